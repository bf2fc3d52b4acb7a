//! Where frames come from.

mod own_camera;
mod recorded;
mod session_config;
#[cfg(feature = "simulated")]
mod simulated;

pub use own_camera::OwnCamera;
pub use recorded::RecordedScan;
#[cfg(feature = "simulated")]
pub use simulated::{Baselines, SimulatedObject, Simulation, Truth, TruthCache};

use crate::{Evaluator, Fault, Faults, ScanConfig, ScanRecord};
use glam::DVec3;
use nextview::geometry::Aabb;
use nextview::sensor::{ColorImage, Frame};
use nextview::session::{NextView, Session};
use nextview::surface::SurfaceMesh;

/// A camera that a run can drive by itself: a simulated one, or the frames of a recording.
///
/// Users' cameras need none of this: see [`LiveScan`](crate::LiveScan) and
/// [`ScanRun::next`](crate::ScanRun::next).
pub trait FrameSource: Send + Sync {
    /// The session that the configuration describes.
    fn session(&self, config: &ScanConfig) -> Result<Session, Faults>;

    /// Takes the frame of a view; `is_first` if it is the first of the scan.
    fn capture(&self, next: &NextView, is_first: bool) -> Result<Frame, Fault>;

    /// The evaluator of a run, for a configuration; none where there is nothing to add to its records.
    fn evaluator(&self, config: &ScanConfig) -> Option<Box<dyn Evaluator + '_>>;

    /// The colour image that belongs to a view's frame; none without one.
    fn color(&self, view: Option<usize>) -> Result<Option<ColorImage>, Fault>;

    /// The box that the object is in, metres, where a session has found none; none if it is not known.
    fn bounds(&self) -> Option<Aabb>;

    /// Fills in what is known of the object and of other planners on it.
    fn describe(&self, record: &mut ScanRecord);

    /// Fills in the quality of the final model: that of the points of its cloud, metres, and of its mesh if
    /// there is one. Nothing where the truth is not known.
    fn measure_model(&self, cloud: &[DVec3], mesh: Option<&SurfaceMesh>, record: &mut ScanRecord);
}
