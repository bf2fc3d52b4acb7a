use crate::geometry::Pose;
use crate::sensor::{Depth, Frame};
use glam::DVec3;

/// The camera of a frame, which shows where there is no surface: wherever it looked through.
#[derive(Clone, Debug)]
pub(super) struct FrameCamera {
    frame: Frame,
    from_world: Pose,
}

impl FrameCamera {
    /// Returns the camera in the frame's pose.
    pub fn new(frame: Frame) -> Self {
        Self { from_world: frame.world_from_camera().inverse(), frame }
    }

    /// Returns the camera in another pose.
    pub fn at(&self, pose: Pose) -> Self {
        Self::new(self.frame.clone().with_pose(pose))
    }

    /// Returns the camera's pose.
    pub fn pose(&self) -> Pose {
        self.frame.world_from_camera()
    }

    /// Whether the camera looked through a point (world coordinates, metres): the pixel there shows a surface
    /// deeper by more than `margin` metres, or nothing up to the camera's range. False for points that are
    /// hidden, outside the image, or not measured.
    pub fn looks_through(&self, point: DVec3, margin: f64) -> bool {
        let in_camera = self.from_world.transform_point(point);
        let depth = match self.frame.pixel_at(in_camera) {
            None | Some(Depth::Missing) => return false,
            Some(Depth::Beyond) => self.frame.range(),
            Some(Depth::Surface(depth)) => depth as f64,
        };
        depth - in_camera.z > margin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::synthetic::ball;
    use crate::view::look_at;

    #[test]
    fn looks_through_what_is_in_front_of_the_surface_that_it_measured() {
        let pose = look_at(DVec3::X, DVec3::ZERO).unwrap();
        let camera = FrameCamera::new(ball(pose, 0.1));
        for (x, y, is_through) in [
            (0.2, 0.0, true),    // in front of the ball
            (0.105, 0.0, false), // in front of it, within the margin
            (0.0, 0.0, false),   // in the ball
            (-0.3, 0.0, false),  // hidden
            (0.0, 0.2, true),    // beside it, where nothing came back
            (1.5, 0.0, false),   // behind the camera
            (0.9, 5.0, false),   // outside the image
        ] {
            assert_eq!(camera.looks_through(DVec3::new(x, y, 0.0), 0.01), is_through, "{x} {y}");
        }
        let away = camera.at(look_at(DVec3::X, DVec3::X * 2.0).unwrap());
        assert!(!away.looks_through(DVec3::X * 0.2, 0.01));
    }
}
