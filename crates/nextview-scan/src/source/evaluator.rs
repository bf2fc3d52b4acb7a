use super::Captured;
use crate::{Fault, ScanRecord, StepRecord};
use glam::DVec3;
use nextview::session::{NextView, Session};
use nextview_model::SurfaceMesh;

/// Fills in the parts of a run's records that neither session nor run knows: above all, the measures against
/// ground truth.
pub trait Evaluator: Send + Sync {
    /// Fills in the record of a step, after its frame was observed.
    ///
    /// The frame has its mapped pose, or the given one if it was set aside. Its truth is `None` if it was not
    /// captured just now, as in a replay. `taken` is the requested view; `None` if there was no request.
    fn measure(
        &mut self,
        session: &Session,
        taken: Option<&NextView>,
        captured: Captured,
        record: &mut StepRecord,
    ) -> Result<(), Fault>;

    /// Fills in facts about the object and about other planners on it.
    fn describe(&self, record: &mut ScanRecord);

    /// Fills in the quality of the final model: of the points of its cloud in metres, and of its mesh if
    /// there is one. Does nothing if the truth is unknown.
    fn measure_model(&self, cloud: &[DVec3], mesh: Option<&SurfaceMesh>, record: &mut ScanRecord);
}
