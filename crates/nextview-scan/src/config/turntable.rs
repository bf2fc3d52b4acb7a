use crate::Fault;
use glam::{DQuat, DVec2, DVec3};
use nextview::geometry::Pose;
use nextview::sensor::{Depth, DepthImage, Intrinsics};
use nextview::view::ViewSpace;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A turntable in front of a fixed camera. The world is the plate and turns with the object: its origin is
/// the middle of the plate's surface, and z is the axis, upwards.
///
/// Angles are counter-clockwise seen from above.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TurntableConfig {
    /// Pose of the camera relative to the plate at angle 0.
    pub table_from_camera: Pose,
    /// Radius of the plate. Everything beyond it does not turn, and is ignored.
    pub plate_radius_m: f64,
}

/// Maximum radius of a plate in metres: the camera is nearer to the axis, so a larger plate would hit it.
const LARGEST_RADIUS_M: f64 = 100.0;

impl TurntableConfig {
    /// The pose of the camera relative to the object with the plate at this angle in degrees.
    pub fn pose_at(&self, angle_deg: f64) -> Result<Pose, Fault> {
        if !angle_deg.is_finite() {
            return Err(Fault::of_value("angle_deg", angle_deg, "a finite number of degrees"));
        }
        let back = Pose::new(DQuat::from_rotation_z(-angle_deg.to_radians()), DVec3::ZERO)?;
        Ok(back * self.table_from_camera)
    }

    /// The plate angle in degrees, 0 to 360, that puts the camera at this pose relative to the object.
    pub fn angle_deg(&self, world_from_camera: &Pose) -> f64 {
        let turned = world_from_camera.rotation() * self.table_from_camera.rotation().conjugate();
        let angle = -2.0 * turned.z.atan2(turned.w);
        let degrees = angle.rem_euclid(TAU).to_degrees();
        // Rounding must turn 0 neither into a full turn nor negative.
        if degrees > 360.0 - 1e-9 { 0.0 } else { degrees.abs() }
    }

    /// This number of evenly spaced candidates; candidate i is at i / n of a turn.
    pub(crate) fn views(&self, n: usize) -> Result<ViewSpace, Fault> {
        let pose = |i: usize| self.pose_at(360.0 * i as f64 / n as f64);
        Ok(ViewSpace::new((0..n).map(pose).collect::<Result<_, _>>()?)?)
    }

    /// Removes everything that does not turn from the image. A pixel beyond the space above the plate shows
    /// that this space is free there; a pixel in front of or next to it shows nothing.
    pub(crate) fn turning_part(&self, image: &DepthImage, camera: &Intrinsics) -> Result<DepthImage, Fault> {
        let mut depths = Vec::with_capacity(camera.n_pixels());
        for v in 0..image.height() {
            for u in 0..image.width() {
                depths.push(match image.get(u, v) {
                    Depth::Missing => f32::NAN,
                    Depth::Beyond => f32::INFINITY,
                    Depth::Surface(depth) => {
                        self.turning_depth(depth, camera.deproject(DVec2::new(u.into(), v.into())))
                    }
                });
            }
        }
        Ok(DepthImage::from_metres(image.width(), image.height(), depths)?)
    }

    fn turning_depth(&self, depth: f32, ideal: Option<DVec2>) -> f32 {
        let Some(ideal) = ideal else { return f32::NAN };
        let [from, to] = [DVec3::ZERO, ideal.extend(1.0) * f64::from(depth)]
            .map(|point| self.table_from_camera.transform_point(point).truncate());
        if to.length() <= self.plate_radius_m {
            return depth;
        }
        let along = to - from;
        let nearest = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let passes_plate = (from + along * nearest).length() < self.plate_radius_m;
        if passes_plate { f32::INFINITY } else { f32::NAN }
    }

    pub(crate) fn faults(&self) -> Vec<Fault> {
        let camera = self.table_from_camera.translation();
        let radius = self.plate_radius_m;
        let mut faults = Vec::new();
        if !(radius > 0.0 && radius <= LARGEST_RADIUS_M) {
            let expected = format!("a positive number of metres, at most {LARGEST_RADIUS_M}");
            faults.push(Fault::of_value("turntable.plate_radius_m", radius, expected));
        } else if camera.truncate().length() < radius && camera.z <= 0.0 {
            let fault =
                Fault::of_value("turntable.table_from_camera", camera, "a camera next to or above the plate");
            faults.push(fault.with_remedy("the origin is the middle of the plate, z points up, metres"));
        }
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::view::look_at;

    fn turntable() -> TurntableConfig {
        let camera = look_at(DVec3::new(0.4, 0.1, 0.25), DVec3::new(0.0, 0.0, 0.03)).unwrap();
        TurntableConfig { table_from_camera: camera, plate_radius_m: 0.15 }
    }

    #[test]
    fn an_angle_is_a_pose_and_back() {
        let turntable = turntable();
        for angle in [0.0, 1e-6, 30.0, 90.0, 179.0, 180.0, 181.0, 270.0, 359.0] {
            let pose = turntable.pose_at(angle).unwrap();
            assert!((turntable.angle_deg(&pose) - angle).abs() < 1e-6, "{angle}");
            // Points that turned with the plate appear at their turned positions.
            let on_plate = DVec3::new(0.05, 0.02, 0.04);
            let turned = DQuat::from_rotation_z(angle.to_radians()) * on_plate;
            let seen = pose.inverse().transform_point(on_plate);
            let expected = turntable.table_from_camera.inverse().transform_point(turned);
            assert!(seen.distance(expected) < 1e-12, "{angle}");
        }
        assert!((turntable.angle_deg(&turntable.pose_at(-90.0).unwrap()) - 270.0).abs() < 1e-9);
        assert!(turntable.pose_at(f64::NAN).is_err());
        let views = turntable.views(8).unwrap();
        assert!((turntable.angle_deg(&views.pose(3)) - 135.0).abs() < 1e-9);
    }

    /// The object stays; a wall behind shows free space; a post in front of the plate shows nothing.
    #[test]
    fn what_does_not_turn_is_left_out() {
        let turntable = turntable();
        let camera = Intrinsics::pinhole(65, 49, DVec2::splat(60.0), DVec2::new(32.0, 24.0)).unwrap();
        let n = camera.n_pixels();
        let cut = |depth: f32| {
            let image = DepthImage::from_metres(65, 49, vec![depth; n]).unwrap();
            turntable.turning_part(&image, &camera).unwrap()
        };
        assert_eq!(cut(0.45).get(32, 24), Depth::Surface(0.45), "on the plate");
        assert_eq!(cut(1.5).get(32, 24), Depth::Beyond, "a wall behind it");
        assert_eq!(cut(0.1).get(32, 24), Depth::Missing, "a post before it");
        assert_eq!(cut(1.5).get(0, 24), Depth::Missing, "a wall beside it");
    }

    #[test]
    fn refuses_what_is_no_turntable() {
        assert!(turntable().faults().is_empty());
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(TurntableConfig { plate_radius_m: radius, ..turntable() }.faults().len(), 1);
        }
        let below = look_at(DVec3::new(0.01, 0.0, -0.3), DVec3::ZERO).unwrap();
        assert_eq!(TurntableConfig { table_from_camera: below, ..turntable() }.faults().len(), 1);
    }
}
