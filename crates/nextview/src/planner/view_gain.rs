use super::Situation;
use crate::Error;
use crate::visibility::{Sight, ViewRays};

/// A gain that values all rays of a view at once, for [`GreedyByView`](super::GreedyByView).
///
/// It suits gains that are computed elsewhere, such as by array operations of another language, where a call
/// for each ray would cost too much. A gain of the library is an
/// [`InformationGain`](crate::gain::InformationGain), which keeps no rays.
pub trait ViewGain: Send {
    /// The rays that the gain needs.
    fn sight(&self) -> Sight;

    /// Called once for each plan, before the views: everything that does not depend on the view can be
    /// computed here.
    fn begin(&mut self, situation: &Situation<'_>) -> Result<(), Error>;

    /// The gain of the view of this number, not negative. Views come one after the other, in increasing
    /// order.
    ///
    /// Long computations check [`Situation::cancel`]; a gain that fails says so with [`Error::Planner`].
    fn gain(&mut self, situation: &Situation<'_>, view: usize, rays: &ViewRays) -> Result<f64, Error>;
}
