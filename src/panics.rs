//! Panics in code that is not ours, on data that is not ours: they become a value, and nothing is said about them.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    static CAUGHT_HERE: Cell<bool> = const { Cell::new(false) };
}

/// What `f` returns, or None if it panics. What `f` was changing may be half changed then: drop it.
pub fn catch<T>(f: impl FnOnce() -> T) -> Option<T> {
    let before = CAUGHT_HERE.replace(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(f));
    CAUGHT_HERE.set(before);
    outcome.ok()
}

/// Whether a panic on this thread is going to be caught by [`catch`], so that a panic hook has nothing to say.
pub fn caught_here() -> bool {
    CAUGHT_HERE.get()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_none_and_is_known_to_be_caught_meanwhile() {
        assert!(!caught_here());
        assert_eq!(catch(|| if caught_here() { 1 } else { 2 }), Some(1));
        assert_eq!(catch(|| -> i32 { std::panic::resume_unwind(Box::new(())) }), None);
        assert!(!caught_here());
    }
}
