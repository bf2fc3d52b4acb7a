use nextview::geometry::{Aabb, Plane};
use nextview::map::Snapshot;
use nextview::motion::Trajectory;
use nextview::object::TableTops;
use nextview::sensor::{ColorImage, DepthRange, Frame};
use nextview::view::ViewSpace;
use nextview_scan::{ModelFrames, ScanState};

/// A copy of everything that a page shows of a scan: the scan continues while the page is made. Images are
/// shared.
pub(crate) struct ScanCopy {
    /// The frames in the map, at their mapped poses.
    pub frames: Vec<Frame>,
    /// The step index of each.
    pub step_idxs: Vec<usize>,
    /// The frames of the model: first those of the scan before the object was turned, then those in the map.
    pub model_frames: Vec<Frame>,
    /// The colours of the frames of the earlier scan; `None` if there are no colours.
    pub earlier_colors: Vec<Option<ColorImage>>,
    /// Each frame that could not be aligned, with the index of its step.
    pub set_aside: Vec<(usize, Frame)>,
    /// For each step; `None` if there are no colours.
    pub colors: Vec<Option<ColorImage>>,
    /// For each step, from the previous view.
    pub trajectories: Vec<Trajectory>,
    pub candidates: ViewSpace,
    /// `None` before an object was found.
    pub snapshot: Option<Snapshot>,
    /// The box of the model, and the edge of the final model's cells, metres; `None` if no object was found.
    pub place: Option<(Aabb, f64)>,
    /// Edge of the finest voxels, metres.
    pub voxel_size: f64,
    pub depth_range: DepthRange,
    pub table: Option<Plane>,
    /// The table in the frames of the model; `None` if they show nothing but the object.
    pub table_tops: Option<TableTops>,
}

impl ScanCopy {
    pub fn of(scan: &ScanState<'_>) -> Self {
        let session = &scan.session;
        // If cancelled, a page without the earlier scan is better than none.
        let of_map = ModelFrames { frames: session.frames().into(), n_earlier: 0 };
        let model = scan.model_frames().unwrap_or(of_map);
        let earlier_color = |i: usize| scan.model_color(i, model.n_earlier).ok().flatten();
        Self {
            frames: session.frames().to_vec(),
            step_idxs: session.frame_numbers().to_vec(),
            earlier_colors: (0..model.n_earlier).map(earlier_color).collect(),
            model_frames: model.frames.into_owned(),
            set_aside: session.set_aside().iter().map(|a| (a.number, a.frame.clone())).collect(),
            // A page without the colours of an unreadable image is better than none.
            colors: (0..scan.steps.len()).map(|step_idx| scan.color(step_idx).ok().flatten()).collect(),
            trajectories: scan.trajectories.clone(),
            candidates: session.views().clone(),
            snapshot: session.snapshot(),
            place: scan.model_bounds().map(|bounds| (bounds, scan.detail(bounds))),
            voxel_size: session.map().lattice().voxel_size(),
            depth_range: session.depth_range(),
            table: session.table(),
            table_tops: scan.table_tops(),
        }
    }

    /// The frames of the model, with the index of their step (`None` for the earlier scan) and their colours,
    /// if any.
    pub fn model_views(&self) -> impl Iterator<Item = (&Frame, Option<usize>, Option<&ColorImage>)> {
        let earlier = self.earlier_colors.iter().map(|color| (None, color.as_ref()));
        let now = self.step_idxs.iter().map(|&step_idx| (Some(step_idx), self.colors[step_idx].as_ref()));
        let views = self.model_frames.iter().zip(earlier.chain(now));
        views.map(|(frame, (step_idx, color))| (frame, step_idx, color))
    }
}
