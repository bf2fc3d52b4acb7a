//! Sources of frames.

mod evaluator;
mod own_camera;
mod recorded;
mod session_config;
#[cfg(feature = "simulated")]
mod simulated;

pub use evaluator::Evaluator;
pub use own_camera::OwnCamera;
pub use recorded::RecordedScan;
#[cfg(feature = "simulated")]
pub use simulated::{Baselines, SimulatedObject, Simulation, Truth, TruthCache};

use crate::{Fault, Faults, ScanConfig, ScanRecord};
use glam::DVec3;
use nextview::geometry::Aabb;
use nextview::sensor::{ColorImage, Frame};
use nextview::session::{NextView, Session};
use nextview_model::SurfaceMesh;

/// A camera that a run can drive itself: a simulated one, or the frames of a recording.
///
/// Users' cameras do not need this: see [`LiveScan`](crate::LiveScan) and
/// [`ScanRun::next`](crate::ScanRun::next).
pub trait FrameSource: Send + Sync {
    /// Builds the configured session.
    fn session(&self, config: &ScanConfig) -> Result<Session, Faults>;

    /// Captures the frame of a view; `is_first` for the first of the scan.
    fn capture(&self, next: &NextView, is_first: bool) -> Result<Frame, Fault>;

    /// The evaluator of a run with this configuration; `None` if there is nothing to add to its records.
    fn evaluator(&self, config: &ScanConfig) -> Option<Box<dyn Evaluator + '_>>;

    /// The colour image of a view's frame; `None` if there is none.
    fn color(&self, view: Option<usize>) -> Result<Option<ColorImage>, Fault>;

    /// The object's box in metres, as a session may have found it; `None` if unknown.
    fn bounds(&self) -> Option<Aabb>;

    /// Fills in facts about the object and about other planners on it.
    fn describe(&self, record: &mut ScanRecord);

    /// Fills in the quality of the final model: of the points of its cloud in metres, and of its mesh if
    /// there is one. Does nothing if the truth is unknown.
    fn measure_model(&self, cloud: &[DVec3], mesh: Option<&SurfaceMesh>, record: &mut ScanRecord);
}
