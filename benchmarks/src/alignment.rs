//! An image to align to the surface in the others.

use glam::{DQuat, DVec3};
use nextview::Cancel;
use nextview::geometry::{Aabb, Pose};
use nextview::registration::{KnownSurface, RegistrationConfig, SearchReach, SurfacePoint, align};
use nextview::sensor::Frame;

/// Distance between neighbouring points, metres.
const SPACING: f64 = 0.002;

/// Search distances for correspondences: a few millimetres more than the offset of the points, and two cells.
const REACH: SearchReach = SearchReach { first: 0.01, last: 2.0 * SPACING };

/// Points slightly off their surface.
#[derive(Clone, Debug)]
pub struct OffsetPoints {
    known: KnownSurface,
    /// Right positions of the points, metres.
    points: Vec<SurfacePoint>,
}

impl OffsetPoints {
    /// Aligns the last of the frames to the surface that the others show in the box (world coordinates).
    pub fn of(frames: &[Frame], bounds: Aabb) -> Self {
        let surface = |frames: &[Frame]| {
            let config = RegistrationConfig { spacing: Some(SPACING), ..RegistrationConfig::enabled() };
            let mut surface = KnownSurface::new(config).expect("a spacing written in the source");
            for frame in frames {
                let added = surface.add(frame, &frame.world_from_camera(), bounds, &Cancel::default());
                added.expect("nobody cancels");
            }
            surface
        };
        let (others, last) = frames.split_at(frames.len() - 1);
        Self { known: surface(others), points: surface(last).points() }
    }

    /// Returns the motion that displaces the points: 4 mm and a degree.
    pub fn motion() -> Pose {
        let rotation = DQuat::from_axis_angle(DVec3::new(2.0, -1.0, 2.0) / 3.0, 1f64.to_radians());
        Pose::new(rotation, DVec3::new(0.003, -0.002, 0.002)).expect("a rotation of unit length")
    }

    /// Returns the remaining motion after the alignment, which should be none, and the number of steps.
    pub fn align(&self) -> (Pose, usize) {
        let pairs = |pose: &Pose, reach| self.known.pairs(&self.points, pose, reach, &Cancel::default());
        align(Self::motion(), REACH, pairs).expect("nobody cancels")
    }

    /// Returns the known points, and the points to align.
    pub fn points(&self) -> [Vec<SurfacePoint>; 2] {
        [self.known.points(), self.points.clone()]
    }
}

#[cfg(test)]
mod tests {
    use crate::workload::Workload;

    #[test]
    fn what_is_off_is_aligned() {
        let (pose, n_steps) = Workload::around("teapot").unwrap().alignment().align();
        assert!(pose.translation().length() < 3e-4 && (2..30).contains(&n_steps), "{pose:?} {n_steps}");
    }
}
