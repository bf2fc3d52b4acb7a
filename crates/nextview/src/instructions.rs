use pulp::Arch;

/// Returns the vector instructions of this CPU, used for all computations. Results are bit-identical with any
/// others; `session/instructions.rs` compares whole scans.
pub(crate) fn instructions() -> Arch {
    #[cfg(test)]
    if let Some(arch) = tests::forced() {
        return arch;
    }
    Arch::new()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
    use std::sync::{Mutex, PoisonError};

    /// One more than the index in [`archs`] of the instructions that all threads use; 0 for those of the CPU.
    static FORCED: AtomicUsize = AtomicUsize::new(0);

    /// The instructions that this CPU has, and those that every CPU has.
    pub fn archs() -> Vec<Arch> {
        let mut archs = vec![Arch::Scalar, Arch::new()];
        #[cfg(target_arch = "x86_64")]
        archs.extend(pulp::x86::V3::try_new().map(Arch::V3));
        archs
    }

    pub fn forced() -> Option<Arch> {
        FORCED.load(SeqCst).checked_sub(1).map(|number| archs()[number])
    }

    /// Returns the results of a computation with each of [`archs`]. Tests running in parallel use them, too;
    /// that only changes their speed.
    pub fn with_each<T>(compute: impl Fn() -> T) -> Vec<T> {
        static TURN: Mutex<()> = Mutex::new(());
        let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let computed = (1..=archs().len()).map(|number| {
            FORCED.store(number, SeqCst);
            compute()
        });
        let computed = computed.collect();
        FORCED.store(0, SeqCst);
        computed
    }
}
