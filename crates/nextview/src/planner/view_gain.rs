use super::Situation;
use crate::Error;
use crate::visibility::{Sight, ViewRays};

/// A gain that evaluates all rays of a view at once, for [`GreedyByView`](super::GreedyByView).
///
/// It suits gains that are computed elsewhere, such as by array operations in another language, where a call
/// for each ray would cost too much. The library's own gains are
/// [`InformationGain`](crate::gain::InformationGain)s, which store no rays.
pub trait ViewGain: Send {
    /// The rays that the gain needs.
    fn sight(&self) -> Sight;

    /// Prepares the gains of a plan; called once before its views. Everything that does not depend on the
    /// view can be computed here.
    fn begin(&mut self, situation: &Situation<'_>) -> Result<(), Error>;

    /// Returns the gain of the view with this number, not negative. Views come in increasing order.
    ///
    /// Long computations check [`Situation::cancel`]; a gain that fails returns [`Error::Planner`].
    fn gain(&mut self, situation: &Situation<'_>, view: usize, rays: &ViewRays) -> Result<f64, Error>;
}
