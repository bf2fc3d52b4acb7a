//! Synthetic frames for tests: those of the planning library.

use nextview::geometry::Pose;
use nextview::sensor::{DepthImage, Frame, Intrinsics};

#[path = "../../nextview/src/sensor/synthetic.rs"]
mod frames;

pub(crate) use frames::{ball, of_depth};
