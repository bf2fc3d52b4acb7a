use super::SimulatedCamera;
use crate::noise::{DepthNoise, Readings, Use};
use nextview::Error;
use nextview::geometry::Pose;
use nextview::sensor::{DepthImage, Frame};

/// A frame, and what in it is the object.
#[derive(Clone, Debug)]
pub struct Capture {
    /// What the camera tells: all that a planner may know.
    pub frame: Frame,
    /// The same with those pixels alone in which the camera looks at the object; nothing comes back from the others.
    pub of_object: Frame,
    /// The exact depth of all pixels of the object that were measured, and the pose from which they were.
    pub truth: Frame,
}

impl Capture {
    pub(super) fn new(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Self, Error> {
        let exact = camera.render(world_from_camera)?;
        let (told, readings) = told(camera, exact.all, world_from_camera);
        let (shown, measured) = match readings {
            None => (exact.object.clone(), exact.object),
            Some(readings) => (readings.shown(&exact.object), readings.truly_measured(&exact.object)),
        };
        let of_object = told.iter().zip(shown);
        let of_object =
            of_object.map(|(&told, shown)| if shown.is_infinite() { shown } else { told }).collect();
        let claimed = claimed(camera, world_from_camera)?;
        Ok(Self {
            frame: frame(camera, told, &claimed)?,
            of_object: frame(camera, of_object, &claimed)?,
            truth: frame(camera, measured, world_from_camera)?,
        })
    }
}

/// [`Capture::frame`] alone.
pub(super) fn capture(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Frame, Error> {
    let exact = camera.render_depth(world_from_camera)?;
    let (told, _) = told(camera, exact, world_from_camera);
    frame(camera, told, &claimed(camera, world_from_camera)?)
}

/// The image of [`Capture::truth`] as plain numbers.
pub(super) fn truly_measured(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Vec<f32>, Error> {
    let Some(noise) = &camera.noise.depth else { return camera.render_object(world_from_camera) };
    let exact = camera.render(world_from_camera)?;
    Ok(readings(camera, noise, &exact.all, world_from_camera).truly_measured(&exact.object))
}

/// What the camera tells of an exact image, and which pixels it reads if it has noise.
fn told(camera: &SimulatedCamera, exact: Vec<f32>, world_from_camera: &Pose) -> (Vec<f32>, Option<Readings>) {
    let Some(noise) = &camera.noise.depth else { return (exact, None) };
    let readings = readings(camera, noise, &exact, world_from_camera);
    let mut random = camera.noise.random(world_from_camera, Use::Axial);
    (readings.told(noise, &exact, &mut random), Some(readings))
}

/// The pose that the camera claims.
fn claimed(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Pose, Error> {
    let mut random = camera.noise.random(world_from_camera, Use::Pose);
    camera.noise.pose.claimed(world_from_camera, &mut random)
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
