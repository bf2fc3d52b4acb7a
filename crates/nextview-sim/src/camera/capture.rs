use super::look::Look;
use super::simulated_camera::SimulatedCamera;
use crate::noise::{Readings, SensorNoise, Use, Waves};
use nextview::Error;
use nextview::geometry::Pose;
use nextview::sensor::{DepthImage, Frame};

/// A frame and its object pixels.
#[derive(Clone, Debug)]
pub struct Capture {
    /// The measured frame: everything a planner may know.
    pub frame: Frame,
    /// The frame with only the object pixels; all others have no return.
    pub of_object: Frame,
    /// The exact depth of all measured object pixels, and the pose they were measured from.
    pub truth: Frame,
}

impl SimulatedCamera {
    /// Takes a depth image from a pose. The same pose always gives the same bits.
    ///
    /// Fails if there is a room and the camera stands outside.
    pub fn capture(&self, world_from_camera: &Pose) -> Result<Frame, Error> {
        capture(self, world_from_camera)
    }

    /// Captures a frame, with its object pixels and the true measurement.
    pub fn capture_with_truth(&self, world_from_camera: &Pose) -> Result<Capture, Error> {
        Capture::new(self, world_from_camera)
    }

    /// Returns the true measurement of the object that a [`capture`](Self::capture) from this pose gives, in
    /// less time than a capture.
    ///
    /// Fails if there is a room and the camera stands outside.
    pub fn look(&self, world_from_camera: &Pose) -> Result<Look<'_>, Error> {
        Ok(Look::new(self, world_from_camera, truly_measured(self, world_from_camera)?))
    }
}

impl Capture {
    fn new(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Self, Error> {
        let exact = camera.render(world_from_camera)?;
        let (told, readings) = reported(camera, exact.all, world_from_camera);
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
fn capture(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Frame, Error> {
    let exact = camera.render_depth(world_from_camera)?;
    let (told, _) = reported(camera, exact, world_from_camera);
    frame(camera, told, &claimed(camera, world_from_camera)?)
}

/// The image of [`Capture::truth`] as plain numbers.
fn truly_measured(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Vec<f32>, Error> {
    let Some(noise) = &camera.noise().depth else { return camera.render_object(world_from_camera) };
    let exact = camera.render(world_from_camera)?;
    Ok(readings(camera, noise, &exact.all, world_from_camera).truly_measured(&exact.object))
}

/// The measurement of an exact image, and the readings if there is noise.
fn reported(
    camera: &SimulatedCamera,
    exact: Vec<f32>,
    world_from_camera: &Pose,
) -> (Vec<f32>, Option<Readings>) {
    let Some(noise) = &camera.noise().depth else { return (exact, None) };
    let readings = readings(camera, noise, &exact, world_from_camera);
    let random = |purpose| camera.noise().random(world_from_camera, purpose);
    let waves = Waves::new(noise, camera.intrinsics(), &mut random(Use::Waves));
    (readings.reported(noise, &exact, waves.as_ref(), &mut random(Use::Axial)), Some(readings))
}

/// The pose that the camera claims.
fn claimed(camera: &SimulatedCamera, world_from_camera: &Pose) -> Result<Pose, Error> {
    let mut random = camera.noise().random(world_from_camera, Use::Pose);
    camera.noise().pose.claimed(world_from_camera, &mut random)
}

fn readings(
    camera: &SimulatedCamera,
    noise: &SensorNoise,
    exact: &[f32],
    world_from_camera: &Pose,
) -> Readings {
    let random = |purpose| camera.noise().random(world_from_camera, purpose);
    let intrinsics = camera.intrinsics();
    Readings::new(noise, exact, intrinsics, &mut random(Use::Readings)).with_flying(
        noise,
        exact,
        intrinsics.width(),
        &mut random(Use::Flying),
    )
}

fn frame(camera: &SimulatedCamera, depth: Vec<f32>, world_from_camera: &Pose) -> Result<Frame, Error> {
    let intrinsics = *camera.intrinsics();
    let image = DepthImage::from_metres(intrinsics.width(), intrinsics.height(), depth)?;
    Frame::new(image, intrinsics, *world_from_camera, camera.range())
}
