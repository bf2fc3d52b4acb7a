use crate::{Fault, StepRecord};
use nextview::sensor::Frame;
use nextview::session::{NextView, Session};

/// Evaluates a run against ground truth, frame by frame.
pub trait Evaluator: Send {
    /// Fills in the parts of the record unknown to a session, after this frame was observed.
    ///
    /// `frame` has its mapped pose, or the given one if it was set aside. `taken` is the requested view;
    /// `None` if there was no request.
    fn measure(
        &mut self,
        session: &Session,
        taken: Option<&NextView>,
        frame: &Frame,
        record: &mut StepRecord,
    ) -> Result<(), Fault>;
}
