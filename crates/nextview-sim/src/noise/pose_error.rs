use super::normal::normal;
use glam::{DQuat, DVec3};
use nextview::Error;
use nextview::geometry::Pose;
use nextview::geometry::random::Random;

/// Error of a frame's claimed pose: normally distributed, independent between frames and axes.
///
/// The image is taken where the planner sent the camera, and the claim is wrong: the robot does not know that
/// it arrived. (A wrong arrival believed to be right differs only in the view, not in the map.)
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseError {
    /// Standard deviation of the position along each axis, metres, 0..=1.
    pub translation_sigma: f64,
    /// Standard deviation of the rotation about each axis of the camera, radians, 0..=1.
    pub rotation_sigma: f64,
}

impl PoseError {
    /// Fails on the first field out of range.
    pub fn check(&self) -> Result<(), Error> {
        let check = |name, value: f64, expected| match (0.0..=1.0).contains(&value) {
            true => Ok(()),
            false => Err(Error::InvalidParameter { name, value: value.to_string(), expected }),
        };
        check("pose error (translation)", self.translation_sigma, "0 to 1 m")?;
        check("pose error (rotation)", self.rotation_sigma, "0 to 1 radian (57.3 degrees)")
    }

    /// The claimed pose of an image from this pose.
    pub(crate) fn claimed(&self, world_from_camera: &Pose, random: &mut Random) -> Result<Pose, Error> {
        if *self == Self::default() {
            return Ok(*world_from_camera); // to the bit, unlike after a rotation by zero
        }
        let mut vector = |sigma: f64| DVec3::from_array(std::array::from_fn(|_| sigma * normal(random)));
        let translation = world_from_camera.translation() + vector(self.translation_sigma);
        let turn = DQuat::from_scaled_axis(vector(self.rotation_sigma));
        Pose::new(world_from_camera.rotation() * turn, translation)
    }
}
