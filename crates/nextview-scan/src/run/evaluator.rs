use crate::{Fault, StepRecord};
use nextview::sensor::Frame;
use nextview::session::{NextView, Session};

/// Measures a run beside the truth, frame by frame.
pub trait Evaluator: Send {
    /// Fills in the parts of the record that a session cannot know, after this frame was observed.
    ///
    /// `frame` has the pose in which it was mapped, or the given one if it was set aside. `taken` is the view
    /// that it answers; none if it was not asked for.
    fn measure(
        &mut self,
        session: &Session,
        taken: Option<&NextView>,
        frame: &Frame,
        record: &mut StepRecord,
    ) -> Result<(), Fault>;
}
