/// An error in the input to the library.
///
/// An absent result is never an error: it is an `Option` or an enum. A broken internal invariant panics.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is outside its range.
    #[error("{name} is {value}, expected {expected}")]
    InvalidParameter {
        /// Name of the parameter, as in the code and the configuration.
        name: &'static str,
        /// The value given.
        value: String,
        /// The accepted values.
        expected: &'static str,
    },
    /// A depth image's buffer does not fit its width and height.
    #[error("depth image has {actual} pixels, expected {width} x {height}")]
    ImageSize {
        /// Number of values given.
        actual: usize,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The work would need more memory than allowed.
    #[error("{what} would need {needed_mb} MB, more than the limit of {limit_mb} MB")]
    TooLarge {
        /// The data that would be stored.
        what: String,
        /// Estimated memory; a lower bound if counting stopped early.
        needed_mb: u64,
        /// The configured limit.
        limit_mb: u64,
    },
    /// The camera cannot reach the required accuracy.
    #[error(
        "goal_mm is {goal_mm}, expected at least {best_mm}: three looks of this camera from {distance} m"
    )]
    UnreachableGoal {
        /// The goal as a standard deviation, millimetres.
        goal_mm: f64,
        /// The smallest error that can be reached.
        best_mm: f64,
        /// The measuring distance, metres.
        distance: f64,
    },
    /// A file is malformed.
    #[error("{place}: {problem}")]
    Format {
        /// The line, byte offset or field.
        place: String,
        /// The fault, and the expected content.
        problem: String,
    },
    /// A planner or a gain from outside the library failed.
    #[error("the planner failed: {0}")]
    Planner(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// The computation was cancelled and has no result.
    #[error(transparent)]
    Cancelled(#[from] crate::Cancelled),
    /// Reading or writing failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl Error {
    /// Returns an [`InvalidParameter`](Self::InvalidParameter): a name, its value and what is accepted.
    pub fn invalid(name: &'static str, value: impl ToString, expected: &'static str) -> Self {
        Self::InvalidParameter { name, value: value.to_string(), expected }
    }
}
