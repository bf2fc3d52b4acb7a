//! The scene of the 3D view as JSON. It holds only numbers and base64: nothing in it can end the script
//! element.

use super::cloud;
use super::pack::{PackedPositions, base64, indices};
use crate::scan::color;
use crate::scan::input::ScanPage;
use crate::scan::shown::{ShownModel, ShownVertex};
use glam::{DVec2, DVec3, Vec3};
use nextview::geometry::Pose;
use nextview::planner::Outlook;
use nextview::sensor::Intrinsics;
use nextview::session::NextView;
use nextview_scan::StepRecord;

/// The members of the scene, world frame, metres: all views, whose poses registration may have moved, and at
/// most `max_points` points of those after number `after`.
pub(in crate::scan) fn members(page: &ScanPage<'_>, after: usize, max_points: usize) -> String {
    let n_views = page.steps().len();
    let after = after.min(n_views);
    let cloud = cloud::pack(page, after..n_views, max_points);
    let vertices: Vec<Vec3> = page.model.vertices.iter().map(|vertex| vertex.position.as_vec3()).collect();
    let core = match page.model.bounds {
        // Before anything was seen, only the box is known.
        Some(bounds) if n_views == 0 => [bounds.min, bounds.max].map(|corner| corner.as_vec3()),
        _ if vertices.is_empty() => cloud.core,
        _ => cloud::core(&vertices),
    };
    format!(
        r#""after":{after},"n_views":{n_views},"ramp":{},"core":{},"surface":{},"expected":{},"candidates":{},"next":{},"lens":{},"up":{},"views":{},"ends":{},"points":{}"#,
        list(color::VIEWS.map(|color| list(color.map(|c| c.to_string())))),
        positions(core.map(|p| p.as_dvec3())),
        surface(page.model, &vertices),
        shell(page.model),
        candidates(page),
        page.next.map_or("null".to_owned(), |next| next_view(next, &page.config.camera)),
        positions(corners(&page.config.camera)),
        numbers(page.model.up.unwrap_or(DVec3::Z).to_array()),
        list((0..n_views).map(|i| view(page, i, i >= after))),
        list(cloud.ends.iter().map(usize::to_string)),
        cloud.points.json(),
    )
}

/// The measured surface; null without one. For each vertex: the number of looks, the cosine of the best one
/// in 255ths, and the index of the first step that shows it, 255 if there is none or the index is larger.
fn surface(model: &ShownModel, vertices: &[Vec3]) -> String {
    if model.triangles.is_empty() {
        return "null".to_owned();
    }
    let byte = |n: usize| n.min(255) as u8;
    let looks = |vertex: &ShownVertex| {
        let cosine = (255.0 * vertex.best_cosine).round() as u8;
        [byte(vertex.n_looks), cosine, byte(vertex.first_step.unwrap_or(255))]
    };
    let colors = match model.vertices.iter().any(|vertex| vertex.color.is_some()) {
        true => base64(model.vertices.iter().flat_map(|vertex| vertex.color.unwrap_or([150; 3]))),
        false => String::new(),
    };
    format!(
        r#"{{"positions":{},"triangles":"{}","looks":"{}","colors":"{colors}"}}"#,
        PackedPositions::of(vertices).json(),
        indices(&model.triangles),
        base64(model.vertices.iter().flat_map(looks)),
    )
}

fn shell(model: &ShownModel) -> String {
    if model.expected.triangles.is_empty() {
        return "null".to_owned();
    }
    let vertices: Vec<Vec3> = model.expected.vertices.iter().map(|vertex| vertex.as_vec3()).collect();
    let triangles = indices(&model.expected.triangles);
    format!(r#"{{"positions":{},"triangles":"{triangles}"}}"#, PackedPositions::of(&vertices).json())
}

/// The candidates, with their gains in 255ths of the largest; the list of gains is empty if they are unknown.
fn candidates(page: &ScanPage<'_>) -> String {
    let gains = page.model.gains.iter().copied().map(Some).chain(std::iter::repeat(None));
    let (places, gains): (Vec<Vec3>, Vec<Option<f64>>) = page
        .candidates
        .iter()
        .map(|place| place.as_vec3())
        .zip(gains)
        .filter(|(place, _)| place.is_finite())
        .unzip();
    let gains: Vec<f64> = gains.into_iter().flatten().collect();
    let best = gains.iter().copied().fold(0.0, f64::max);
    let shares = gains.iter().map(|gain| (255.0 * gain / best.max(f64::MIN_POSITIVE)).round() as u8);
    format!(
        r#"{{"best":{best:.1},"positions":{},"gains":"{}"}}"#,
        PackedPositions::of(&places).json(),
        base64(shares)
    )
}

/// A camera: its position, the corners of its image at depth 1 relative to it, and the path to it if that is
/// new.
fn view(page: &ScanPage<'_>, i: usize, is_new: bool) -> String {
    let steps = page.steps();
    let world_from_camera = pose(&steps[i]);
    let position = world_from_camera.translation();
    let before = i.checked_sub(1).map(|before| pose(&steps[before]).translation());
    let straight = before.map_or(vec![], |before| vec![before, position]);
    let path = page.picture(i).map(|picture| &picture.path).filter(|path| !path.is_empty());
    format!(
        r#"{{{},"path":{}}}"#,
        frustum(&world_from_camera, &page.config.camera),
        positions(path.unwrap_or(&straight).iter().filter(|_| is_new).copied()),
    )
}

fn next_view(next: &NextView, camera: &Intrinsics) -> String {
    let expected = next.outlook.as_ref().map(Outlook::n_expected_next).filter(|n| n.is_finite());
    format!(
        r#"{{{},"view":{},"expected":{}}}"#,
        frustum(&next.world_from_camera, camera),
        next.view.map_or("null".to_owned(), |view| view.to_string()),
        expected.map_or("null".to_owned(), |n| format!("{n:.1}"))
    )
}

fn frustum(world_from_camera: &Pose, camera: &Intrinsics) -> String {
    let corners = corners(camera).map(|corner| world_from_camera.rotation() * corner);
    let position = numbers(world_from_camera.translation().to_array());
    format!(r#""position":{position},"corners":{}"#, positions(corners))
}

/// The pose of a step; the identity if the record's rotation is invalid.
fn pose(step: &StepRecord) -> Pose {
    step.world_from_camera().unwrap_or(Pose::IDENTITY)
}

/// The corners of the image at depth 1, camera frame, without lens distortion.
fn corners(camera: &Intrinsics) -> [DVec3; 4] {
    let size = DVec2::new(camera.width() as f64, camera.height() as f64);
    [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| {
        let pixel = size * DVec2::new(u, v) - 0.5;
        ((pixel - camera.center()) / camera.focal()).extend(1.0)
    })
}

/// Positions that are not finite are left out: JSON has no such numbers.
fn positions(points: impl IntoIterator<Item = DVec3>) -> String {
    list(points.into_iter().filter(|p| p.is_finite()).map(|p| numbers(p.to_array())))
}

fn numbers<T: Into<f64>>(values: [T; 3]) -> String {
    list(values.map(|v| format!("{:.5}", v.into())))
}

fn list(items: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", items.into_iter().collect::<Vec<_>>().join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corners_of_a_centred_camera_are_symmetric() {
        let camera = Intrinsics::pinhole(640, 480, DVec2::splat(320.0), DVec2::new(319.5, 239.5)).unwrap();
        let expected = [(-1.0, -0.75), (1.0, -0.75), (1.0, 0.75), (-1.0, 0.75)];
        assert_eq!(corners(&camera), expected.map(|(x, y)| DVec3::new(x, y, 1.0)));
    }

    #[test]
    fn positions_are_numbers_only() {
        assert_eq!(positions([DVec3::NAN, DVec3::new(1.0, -0.5, 0.0)]), "[[1.00000,-0.50000,0.00000]]");
    }
}
