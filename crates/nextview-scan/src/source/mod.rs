//! Sources of frames.

mod captured;
mod evaluator;
mod own_camera;
mod recorded;
mod session_config;
#[cfg(feature = "simulated")]
mod simulated;

pub use captured::{Captured, FrameTruth};
pub use evaluator::Evaluator;
pub use own_camera::OwnCamera;
pub use recorded::RecordedScan;
#[cfg(feature = "simulated")]
pub use simulated::{Baselines, SimulatedObject, Simulation, Truth, TruthCache};

use crate::{Fault, Faults, ScanConfig};
use nextview::geometry::Aabb;
use nextview::sensor::ColorImage;
use nextview::session::{NextView, Session};

/// A camera that a run can drive itself: a simulated one, or the frames of a recording.
///
/// Users' cameras do not need this: see [`LiveScan`](crate::LiveScan) and
/// [`ScanRun::next`](crate::ScanRun::next).
pub trait FrameSource: Send + Sync {
    /// Builds the configured session.
    fn session(&self, config: &ScanConfig) -> Result<Session, Faults>;

    /// Captures the frame of a view; `is_first` for the first of the scan.
    fn capture(&self, next: &NextView, is_first: bool) -> Result<Captured, Fault>;

    /// The colour image of a candidate's frame; `None` if there is none.
    fn color(&self, next: &NextView) -> Result<Option<ColorImage>, Fault>;

    /// The object's box in metres, as a session may have found it; `None` if unknown.
    fn bounds(&self) -> Option<Aabb>;

    /// The evaluator of one run with this configuration.
    fn evaluator(&self, config: &ScanConfig) -> Box<dyn Evaluator + '_>;
}
