use super::ellipsoid::Ellipsoid;
use crate::geometry::Pose;
use crate::sensor::Intrinsics;
use glam::{DMat2, DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// The image of an ellipsoid: the pixels u with (u - center)^T shape^-1 (u - center) at most 1.
struct Ellipse {
    center: DVec2,
    shape: DMat2,
}

/// Cells in which the area of an ellipse that leaves the image is counted.
const CELLS: [u32; 2] = [64, 48];

/// Depth of the ellipsoid's centre, metres.
pub(super) fn depth(ellipsoid: &Ellipsoid, camera_from_world: &Pose) -> f64 {
    camera_from_world.transform_point(ellipsoid.center).z
}

/// Returns the part of the image, in pixels, that an ellipsoid in world coordinates fills; 0 unless all of it
/// is in front of the camera. Lens distortion is ignored.
pub(super) fn area(ellipsoid: &Ellipsoid, camera_from_world: &Pose, intrinsics: &Intrinsics) -> f64 {
    let Some(Ellipse { center, shape }) = Ellipse::of(ellipsoid, camera_from_world, intrinsics) else {
        return 0.0;
    };
    let (low, high) = (DVec2::splat(-0.5), size(intrinsics) - 0.5);
    let reach = DVec2::new(shape.x_axis.x.max(0.0).sqrt(), shape.y_axis.y.max(0.0).sqrt());
    if (center - reach).cmpge(low).all() && (center + reach).cmple(high).all() {
        return PI * shape.determinant().max(0.0).sqrt();
    }
    let (inverse, n_cells) = (shape.inverse(), DVec2::new(CELLS[0] as f64, CELLS[1] as f64));
    let cell = size(intrinsics) / n_cells;
    let is_inside = |(column, row): (u32, u32)| {
        let offset = low + cell * DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - center;
        offset.dot(inverse * offset) <= 1.0
    };
    let cells = (0..CELLS[1]).flat_map(|row| (0..CELLS[0]).map(move |column| (column, row)));
    cells.filter(|&at| is_inside(at)).count() as f64 * cell.x * cell.y
}

fn size(intrinsics: &Intrinsics) -> DVec2 {
    DVec2::new(intrinsics.width() as f64, intrinsics.height() as f64)
}

impl Ellipse {
    /// The paper's Phi = P Q P^T: the dual conic of the image of a dual quadric.
    fn of(ellipsoid: &Ellipsoid, camera_from_world: &Pose, intrinsics: &Intrinsics) -> Option<Self> {
        let center = camera_from_world.transform_point(ellipsoid.center);
        let rotation = camera_from_world.rotation_matrix();
        let shape = rotation * ellipsoid.shape * rotation.transpose();
        let of_center = DMat3::from_cols(center * center.x, center * center.y, center * center.z);
        let (focal, middle) = (intrinsics.focal(), intrinsics.center());
        let pixels_from_camera = DMat3::from_cols(DVec3::X * focal.x, DVec3::Y * focal.y, middle.extend(1.0));
        let conic = pixels_from_camera * (shape - of_center) * pixels_from_camera.transpose();
        // Otherwise it cuts the camera's plane, or lies behind it.
        (center.z > 0.0 && conic.z_axis.z < 0.0).then(|| {
            let conic = conic * (-1.0 / conic.z_axis.z);
            let center = -conic.z_axis.truncate();
            let of_center = DMat2::from_cols(center * center.x, center * center.y);
            Self { center, shape: DMat2::from_mat3(conic) + of_center }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::look_at;
    use proptest::prelude::*;

    fn camera() -> Intrinsics {
        Intrinsics::pinhole(640, 480, DVec2::new(600.0, 580.0), DVec2::new(310.0, 250.0)).unwrap()
    }

    #[test]
    fn a_ball_on_the_axis_is_as_large_as_its_tangent_cone() {
        let camera = Intrinsics::pinhole(640, 480, DVec2::splat(600.0), DVec2::new(320.0, 240.0)).unwrap();
        let ball = |radius: f64, depth: f64| Ellipsoid {
            center: DVec3::Z * depth,
            shape: DMat3::from_diagonal(DVec3::splat(radius * radius)),
        };
        for (s, z) in [(0.1, 0.5), (0.01, 0.3), (0.2, 2.0)] {
            let expected = PI * 600.0 * 600.0 * s * s / (z * z - s * s);
            assert!((area(&ball(s, z), &Pose::IDENTITY, &camera) / expected - 1.0).abs() < 1e-9);
        }
        assert_eq!(area(&ball(0.1, -0.5), &Pose::IDENTITY, &camera), 0.0, "behind the camera");
        assert_eq!(area(&ball(0.6, 0.5), &Pose::IDENTITY, &camera), 0.0, "around the camera");
        assert!(
            (area(&ball(0.49, 0.5), &Pose::IDENTITY, &camera) - 640.0 * 480.0).abs() < 1e-6,
            "everywhere"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// The slow twin: the pixels whose ray meets the ellipsoid.
        #[test]
        fn the_area_is_that_of_the_rays_that_meet_the_ellipsoid(
            axes in prop::array::uniform3(0.01..0.08), turn in prop::array::uniform3(-3.0..3.0),
            center in prop::array::uniform3(-0.15..0.15),
        ) {
            let pose = look_at(DVec3::new(0.3, 0.2, 0.4), DVec3::ZERO).unwrap();
            let turn = DMat3::from_quat(glam::DQuat::from_scaled_axis(DVec3::from_array(turn)));
            let axes = DVec3::from_array(axes);
            let shape = turn * DMat3::from_diagonal(axes * axes) * turn.transpose();
            let ellipsoid = Ellipsoid { center: DVec3::from_array(center), shape };
            let (metric, offset) = (shape.inverse(), pose.translation() - ellipsoid.center);
            let meets = |pixel: DVec2| {
                let direction = pose.rotation() * camera().deproject(pixel).unwrap().extend(1.0);
                let (a, b) = (direction.dot(metric * direction), direction.dot(metric * offset));
                let c = offset.dot(metric * offset) - 1.0;
                b * b >= a * c && b < 0.0
            };
            let pixels = (0..240).flat_map(|v| (0..320).map(move |u| DVec2::new(u as f64, v as f64) * 2.0 + 0.5));
            let expected = 4.0 * pixels.filter(|&pixel| meets(pixel)).count() as f64;
            let found = area(&ellipsoid, &pose.inverse(), &camera());
            prop_assert!((found - expected).abs() < 0.02 * expected + 1500.0, "{} {}", found, expected);
        }
    }
}
