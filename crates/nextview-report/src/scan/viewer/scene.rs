//! The scene of the 3D view as JSON. It holds numbers and base64 only, so that nothing in it can end the
//! script element.

use super::cloud;
use crate::scan::color;
use crate::scan::input::ScanPage;
use glam::{DVec2, DVec3};
use nextview::geometry::Pose;
use nextview::sensor::Intrinsics;
use nextview_scan::StepRecord;

/// The scene, world frame, metres.
pub(in crate::scan) fn json(page: &ScanPage<'_>) -> String {
    let cloud = cloud::pack(page);
    let views = (0..page.steps().len()).map(|i| view(page, i));
    format!(
        r#"{{"core":{},"min":{},"unit":{},"ends":{},"candidates":{},"views":{},"points":"{}"}}"#,
        positions(cloud.core.map(|p| p.as_dvec3())),
        numbers(cloud.min.to_array()),
        // Enough digits for 65535 units to stay exact to a unit.
        list(cloud.unit.to_array().map(|u| format!("{u:e}"))),
        list(cloud.ends.iter().map(usize::to_string)),
        positions(page.candidates.iter().copied()),
        list(views),
        cloud.data
    )
}

/// A camera: where it stands, where the corners of its image lie at depth 1 from there, the path to it.
fn view(page: &ScanPage<'_>, i: usize) -> String {
    let steps = page.steps();
    let world_from_camera = pose(&steps[i]);
    let position = world_from_camera.translation();
    let before = i.checked_sub(1).map(|before| pose(&steps[before]).translation());
    let straight = before.map_or(vec![], |before| vec![before, position]);
    let path = page.picture(i).map(|picture| &picture.path).filter(|path| !path.is_empty());
    let corners = corners(&page.config.camera).map(|corner| world_from_camera.rotation() * corner);
    format!(
        r#"{{"position":{},"corners":{},"path":{},"color":{}}}"#,
        numbers(position.to_array()),
        positions(corners),
        positions(path.unwrap_or(&straight).iter().copied()),
        list(color::view(i, steps.len()).map(|c| c.to_string()))
    )
}

/// The pose of a step; the identity where the record's rotation is none.
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
