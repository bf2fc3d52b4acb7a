use super::SimulatedCamera;
use crate::noise::{DepthNoise, Readings, Use};
use nextview::Error;
use nextview::geometry::Pose;
use nextview::sensor::{DepthImage, Frame};

/// A frame, and what was truly measured for it.
#[derive(Clone, Debug)]
pub struct Capture {
    /// What the camera tells: all that a planner may know.
    pub frame: Frame,
    /// None if the frame is the truth.
    truth: Option<Frame>,
}

impl Capture {
    pub(super) fn new(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Self, Error> {
        let exact = camera.render_depth(world_from_camera)?;
        if camera.noise.is_none() {
            return Ok(Self { frame: frame(camera, exact, world_from_camera)?, truth: None });
        }
        let (measured, told) = match &camera.noise.depth {
            None => (exact.clone(), exact),
            Some(noise) => {
                let readings = readings(camera, noise, &exact, world_from_camera);
                let mut random = camera.noise.random(world_from_camera, Use::Axial);
                (readings.truly_measured(&exact), readings.told(noise, &exact, &mut random))
            }
        };
        let mut random = camera.noise.random(world_from_camera, Use::Pose);
        let claimed = camera.noise.pose.claimed(world_from_camera, &mut random)?;
        let truth = Some(frame(camera, measured, world_from_camera)?);
        Ok(Self { frame: frame(camera, told, &claimed)?, truth })
    }

    /// The exact depth of all pixels that were measured, and the pose from which they were. Without noise, the frame.
    pub fn truth(&self) -> &Frame {
        self.truth.as_ref().unwrap_or(&self.frame)
    }
}

/// The image of [`Capture::truth`] as plain numbers.
pub(super) fn truly_measured(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Vec<f32>, Error> {
    let exact = camera.render_depth(world_from_camera)?;
    Ok(match &camera.noise.depth {
        None => exact,
        Some(noise) => readings(camera, noise, &exact, world_from_camera).truly_measured(&exact),
    })
}

fn readings(
    camera: &SimulatedCamera,
    noise: &DepthNoise,
    exact: &[f32],
    world_from_camera: &Pose,
) -> Readings {
    let mut random = camera.noise.random(world_from_camera, Use::Readings);
    Readings::new(noise, exact, &camera.intrinsics, &mut random)
}

fn frame(camera: &SimulatedCamera, depth: Vec<f32>, world_from_camera: &Pose) -> Result<Frame, Error> {
    let intrinsics = camera.intrinsics;
    let image = DepthImage::from_metres(intrinsics.width(), intrinsics.height(), depth)?;
    Frame::new(image, intrinsics, *world_from_camera, camera.range)
}
