//! The scene of the live page: the content of the 3D view, and the texts around it.

use super::input::ScanPage;
use super::new_points::NewPoints;
use super::page::{subtitle, summary_table};
use super::picture::ViewPicture;
use super::scan_copy::ScanCopy;
use super::scene_source::SceneSource;
use super::shown::{FusedFrames, ShownModel};
use super::summary::summary;
use super::{chart, headline, placement, steps, thumbnail, viewer};
use nextview::geometry::{Aabb, Pose};
use nextview::sensor::Frame;
use serde_json::json;

/// Maximum number of vertices of the surface, 26 bytes each: an update must stay below 300 kB.
const MAX_VERTICES: usize = 7000;

/// Maximum number of points in an update, 8 bytes each, and of all points.
const MAX_POINTS: [usize; 2] = [6000, 60_000];

/// The scene of a scan, with data kept between updates: fused frames are not fused again unless registration
/// has moved one of them, or the box around the object has grown.
#[derive(Default)]
pub struct LiveScene {
    place: Option<(Aabb, f64)>,
    /// Poses of the model's frames.
    poses: Vec<Pose>,
    fused: FusedFrames,
    points: NewPoints,
    /// Number of views when frames last moved: pages with fewer views are outdated.
    right_since: usize,
}

impl LiveScene {
    /// Returns the content of the page as JSON: the current surface, measured and expected, the candidates
    /// with their expected gains, the next view, the curves and tables, the cameras, and the points and
    /// pictures of the views after number `after`. 0 sends everything, as does a move of frames since then.
    ///
    /// An update by one view of 640 x 480 pixels takes less than 300 kB.
    pub fn json(&mut self, source: &SceneSource, after: usize) -> String {
        let SceneSource { copy, record, config, next } = source;
        let n_views = record.steps.len();
        self.update(copy, n_views);
        let after = if after < self.right_since { 0 } else { after.min(n_views) };
        let candidates: Vec<_> = copy.candidates.poses().iter().map(Pose::translation).collect();
        let page = &ScanPage {
            record,
            config,
            views: &ViewPicture::of_copy(copy, &self.points),
            candidates: &candidates,
            model: &ShownModel::of_copy(copy, &mut self.fused, MAX_VERTICES),
            next: next.as_ref(),
            command: "",
            config_text: "",
        };
        let members = viewer::scene(page, after, MAX_POINTS[usize::from(after == 0)]);
        format!(r#"{{{members},"panels":{}}}"#, panels(page, after))
    }

    fn update(&mut self, copy: &ScanCopy, n_views: usize) {
        let poses: Vec<Pose> = copy.model_frames.iter().map(Frame::world_from_camera).collect();
        if self.place != copy.place || !poses.starts_with(&self.poses) {
            let right_since = if self.poses.is_empty() { 0 } else { n_views };
            *self = Self { place: copy.place, right_since, ..Self::default() };
        }
        self.poses = poses;
        self.points.update(copy);
    }
}

/// The parts of the page around the 3D view, as HTML, with pictures only of the views after number `after`.
fn panels(page: &ScanPage<'_>, after: usize) -> serde_json::Value {
    // Based on the first view alone, so the colours of pictures already sent stay right.
    let range = thumbnail::Range::of(page.views.first().map(|picture| &picture.depth));
    let pictures: Vec<String> =
        (after..page.steps().len()).map(|i| steps::pictures(page, range, i)).collect();
    json!({
        "title": page.record.object,
        "subtitle": subtitle(page),
        "headline": headline::draw(page),
        "chart": chart::draw(page),
        "placement": placement::section(page),
        "measures": summary_table(&summary(page.record, page.config)),
        "views": steps::table_with(page, range, |_| String::new()),
        "pictures": pictures,
    })
}
