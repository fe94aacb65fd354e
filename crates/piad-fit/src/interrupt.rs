//! Ends an abandoned computation.
//!
//! Setting up a fit can take seconds, deep inside loops that do not know about requests. Such loops [`check`] now and
//! then whether the thread's computation is still wanted. If it is not, the stack is unwound to where the computation
//! began, without a message, as this is not an error.

use std::cell::RefCell;
use std::panic::resume_unwind;
use std::sync::Arc;

/// Returns true if the computation is abandoned.
pub(crate) type IsOver = Arc<dyn Fn() -> bool + Send + Sync>;

thread_local! {
    static CURRENT: RefCell<Option<IsOver>> = const { RefCell::new(None) };
}

/// The panic payload that unwinds the stack.
#[derive(Debug)]
pub struct Interrupted;

/// Removes the rule, also if the stack is unwound.
struct Scope(Option<IsOver>);

impl Drop for Scope {
    fn drop(&mut self) {
        CURRENT.set(self.0.take());
    }
}

/// Runs a computation on this thread that is stopped as soon as `is_over`. Then the stack is unwound with
/// [`Interrupted`].
pub fn until<T>(is_over: IsOver, compute: impl FnOnce() -> T) -> T {
    let _scope = Scope(CURRENT.replace(Some(is_over)));
    compute()
}

/// The rule of this thread, for threads that work for it: they stop, and this thread [`check`]s.
pub(super) fn rule() -> Option<IsOver> {
    CURRENT.with_borrow(Clone::clone)
}

/// Unwinds the stack if the computation is abandoned. It takes nanoseconds, but is not for the innermost loops.
pub fn check() {
    // Not borrowed during the call: the rule may run another computation on this thread.
    if rule().is_some_and(|is_over| is_over()) {
        resume_unwind(Box::new(Interrupted));
    }
}

/// [`check`]s after about this many multiplications.
const BETWEEN_CHECKS: usize = 1 << 18;

/// Counts the multiplications of a loop and checks now and then, for loops of cheap passes.
#[derive(Debug, Default)]
pub struct Meter {
    multiplications: usize,
}

impl Meter {
    /// Counts the multiplications of a pass.
    pub(crate) fn add(&mut self, multiplications: usize) {
        self.multiplications += multiplications;
        if self.multiplications >= BETWEEN_CHECKS {
            self.multiplications = 0;
            check();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn abandoned_work_is_interrupted() {
        let checks = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&checks);
        let third: IsOver = Arc::new(move || counter.fetch_add(1, Ordering::Relaxed) == 2);
        let given_up = catch_unwind(AssertUnwindSafe(|| {
            until(third, || (0..10).for_each(|_| check()));
        }));
        assert!(given_up.unwrap_err().is::<Interrupted>());
        assert_eq!(checks.load(Ordering::Relaxed), 3);
        // Whatever comes after it is wanted.
        check();
        assert_eq!(until(Arc::new(|| false), || 7), 7);
    }
}
