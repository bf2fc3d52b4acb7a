use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that lets another thread end a long computation early.
///
/// All clones share one flag. Long computations check it at least every 50 ms.
///
/// ```
/// use nextview::{Cancel, Cancelled};
///
/// let cancel = Cancel::default();
/// let of_another_thread = cancel.clone();
/// assert_eq!(cancel.check(), Ok(()));
/// of_another_thread.cancel();
/// assert_eq!(cancel.check(), Err(Cancelled));
/// cancel.reset();
/// assert!(!of_another_thread.is_cancelled());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

/// A computation was [cancelled](Cancel::cancel) and has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

impl Cancel {
    /// Ends all computations that check the flag, until it is [reset](Self::reset).
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Lets computations run again.
    pub fn reset(&self) {
        self.0.store(false, Ordering::Relaxed);
    }

    /// Whether computations should end.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Fails if computations should end.
    #[inline]
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}
