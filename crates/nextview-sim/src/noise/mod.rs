//! Imperfections of a real depth camera added to the exact image: errors and losses of the depth, and an
//! inaccurate pose.
//!
//! Start with [`Noise`]. The same pose and seed give the same bits, whatever was captured before and with any
//! number of threads. Two images from one place do not average the noise out. Formulas, sources and constants
//! are in `docs/noise.md`. Not modelled: texture and gloss, light reflected by other surfaces, and
//! calibration errors.

mod depth_noise;
mod flying;
mod lateral;
mod loss;
mod normal;
mod pose_error;
mod readings;
#[cfg(test)]
mod tests;
mod waves;

pub use depth_noise::SensorNoise;
pub use pose_error::PoseError;
pub(crate) use readings::Readings;
pub(crate) use waves::Waves;

use nextview::Error;
use nextview::geometry::Pose;
use nextview::geometry::random::Random;

/// All errors of a simulated camera; none by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Seed of all errors.
    pub seed: u64,
    /// Errors of the depth; `None` for exact depths.
    pub depth: Option<SensorNoise>,
    /// Errors of the pose that a frame claims.
    pub pose: PoseError,
    /// Whether the first frame of a [scan](crate::evaluator::capture) claims the right pose regardless.
    /// The first frame then defines the world, and the errors of all others are relative to it.
    pub first_pose_is_right: bool,
}

/// A use of random numbers in a frame. Each has its own stream, so one does not shift another.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Use {
    /// The pixels read and the pixels lost.
    Readings,
    /// The axial error.
    Axial,
    /// The error of the pose.
    Pose,
    /// The flying pixels.
    Flying,
    /// The axial error that pixels share.
    Waves,
}

impl Noise {
    /// Fails on the first parameter out of range.
    pub fn check(&self) -> Result<(), Error> {
        self.pose.check()?;
        self.depth.map_or(Ok(()), |depth| depth.check())
    }

    /// Returns whether there are no errors.
    pub fn is_none(&self) -> bool {
        self.depth.is_none() && self.pose == PoseError::default()
    }

    /// The random numbers of the frame from this pose.
    pub(crate) fn random(&self, world_from_camera: &Pose, purpose: Use) -> Random {
        let (t, q) = (world_from_camera.translation(), world_from_camera.rotation());
        let numbers = t.to_array().into_iter().chain(q.to_array());
        Random::new(self.seed, numbers.fold(purpose as u64, |hash, number| mixed(hash ^ number.to_bits())))
    }
}

/// Mixes a number so that every bit of the result depends on every bit of the number: the finaliser of
/// SplitMix64 (Steele et al. 2014).
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}
