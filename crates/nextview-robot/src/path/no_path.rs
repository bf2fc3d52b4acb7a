use crate::collision::Contact;
use nextview::Cancelled;

/// Reasons why there is no path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoPath {
    /// Start or goals are not joint values of the arm; all faults at once.
    #[error("{}", .0.join("; "))]
    Invalid(Vec<String>),
    /// The arm is in collision at the start.
    #[error("at the start, {0}")]
    StartTouches(Contact),
    /// The arm would be in collision at every goal.
    #[error("at the end, {}", list(.0))]
    EndTouches(Vec<Contact>),
    /// No path was found; there may be one.
    #[error("no path was found with {n_samples} samples")]
    NotFound {
        /// Number of joint values tried.
        n_samples: usize,
    },
    /// The search was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

fn list(contacts: &[Contact]) -> String {
    let mut each: Vec<String> = contacts.iter().map(Contact::to_string).collect();
    each.dedup();
    each.join(", or ")
}
