/// Reasons why a transform cannot be kept or found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransformError {
    /// No transform names this frame.
    #[error("no transform names the frame '{frame}', expected one of {known}")]
    UnknownFrame {
        /// The requested frame.
        frame: String,
        /// The known frames.
        known: String,
    },
    /// Both frames are known, but belong to different trees.
    #[error(
        "nothing connects '{source_frame}', a frame of the tree of '{source_root}', to '{destination}', one of the tree of '{destination_root}'"
    )]
    NoPath {
        /// The frame that points are taken to.
        destination: String,
        /// The root of its tree.
        destination_root: String,
        /// The frame that points are taken from.
        source_frame: String,
        /// The root of its tree.
        source_root: String,
    },
    /// The time is before the first known transform.
    #[error("'{frame}' in '{parent}' is known only from {first_s:.3} s, {:.3} s after the requested time", first_s - time_s)]
    Before {
        /// The child frame.
        frame: String,
        /// Its parent.
        parent: String,
        /// The requested time in seconds.
        time_s: f64,
        /// The first known time in seconds.
        first_s: f64,
    },
    /// The time is after the last known transform: a later one may still arrive.
    #[error("'{frame}' in '{parent}' is known only until {last_s:.3} s, {:.3} s before the requested time", time_s - last_s)]
    After {
        /// The child frame.
        frame: String,
        /// Its parent.
        parent: String,
        /// The requested time in seconds.
        time_s: f64,
        /// The last known time in seconds.
        last_s: f64,
    },
    /// The time is in a gap that is too long to interpolate.
    #[error(
        "'{frame}' in '{parent}' moves, and is unknown from {from_s:.3} s to {to_s:.3} s, expected a gap of \
         at most 0.5 s"
    )]
    Gap {
        /// The child frame.
        frame: String,
        /// Its parent.
        parent: String,
        /// Start of the gap in seconds.
        from_s: f64,
        /// End of the gap in seconds.
        to_s: f64,
    },
    /// A transform is much older than another one of the same frame: a simulation was restarted, or a
    /// recording is played again.
    #[error(
        "the clock ran backwards: '{frame}' was at {newest_s:.3} s and is at {time_s:.3} s now, expected at most 10 s less"
    )]
    ClockBackwards {
        /// The child frame.
        frame: String,
        /// Its time in seconds.
        time_s: f64,
        /// The newest earlier time of that frame in seconds.
        newest_s: f64,
    },
    /// A frame changes its parent: two programs publish it.
    #[error(
        "'{frame}' has the parent '{parent}', expected '{before}' as before: do two programs publish it?"
    )]
    OtherParent {
        /// The child frame.
        frame: String,
        /// The parent.
        parent: String,
        /// The previous parent.
        before: String,
    },
    /// A frame is both static and moving: two programs publish it.
    #[error("'{frame}' is published both as static and as moving, expected only one of them")]
    BothKinds {
        /// The child frame.
        frame: String,
    },
    /// A transform would make a frame its own ancestor.
    #[error("'{frame}' in '{parent}' closes a loop, expected a tree")]
    Circle {
        /// The child frame.
        frame: String,
        /// Its parent.
        parent: String,
    },
    /// A transform is invalid.
    #[error("'{frame}' in '{parent}': {problem}")]
    Invalid {
        /// The child frame.
        frame: String,
        /// Its parent.
        parent: String,
        /// The fault and the expected value.
        problem: String,
    },
}
