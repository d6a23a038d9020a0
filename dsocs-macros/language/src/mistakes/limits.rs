//! Limits for declarations in texts. Anybody may have written a text, so the time, memory and stack that it
//! takes are bounded.
//!
//! The cost of a declaration is known only while it is expanded and differentiated, deep inside algebra that
//! cannot fail. So passing a limit unwinds from there to [`within_limits`], without the panic handler.
//! Declarations that a compiler reads have no limits.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use proc_macro2::Span;

use crate::mistakes::Mistake;

/// The largest cost of a text: one for each operation in the graph, and one for each of its operands. A chain
/// of 32 links costs a quarter of it.
const MOST: u64 = 60_000_000;

/// The deepest nesting of operations, with functions and `let`s expanded.
const DEEPEST: u32 = 10_000;

thread_local! {
    /// The cost that may still be spent; `None` without limits.
    static LEFT: Cell<Option<u64>> = const { Cell::new(None) };
}

/// A limit that was passed.
#[derive(Clone, Copy)]
enum PassedLimit {
    Cost,
    Depth,
}

/// Runs some work on a text within the limits for time, memory and stack (which has to be of 256 MB).
///
/// # Errors
///
/// [`Mistake`] that says which limit the text passes.
pub fn within_limits<T>(work: impl FnOnce() -> T) -> Result<T, Mistake> {
    within_cost(MOST, work)
}

/// Runs some work on a text within the limits of [`within_limits`], with the given limit for the cost.
fn within_cost<T>(most: u64, work: impl FnOnce() -> T) -> Result<T, Mistake> {
    LEFT.set(Some(most));
    let result = catch_unwind(AssertUnwindSafe(work));
    LEFT.set(None);
    result.map_err(|payload| {
        let message = match payload.downcast_ref::<PassedLimit>() {
            Some(PassedLimit::Cost) => format!(
                "with its derivatives, the declaration is longer than this library reads ({most} operations and operands); expected fewer coordinates, \
                 or expressions with fewer of them in one product"
            ),
            Some(PassedLimit::Depth) => format!(
                "written out, an expression is nested more than {DEEPEST} deep; expected fewer functions of functions, or `let`s of `let`s"
            ),
            // a panic, so a defect of this library
            None => resume_unwind(payload),
        };
        Mistake::of(Span::call_site(), message)
    })
}

/// Counts a cost; unwinds if the limit is passed.
pub(crate) fn spend(cost: usize) {
    if let Some(left) = LEFT.get() {
        match left.checked_sub(cost as u64) {
            Some(left) => LEFT.set(Some(left)),
            None => resume_unwind(Box::new(PassedLimit::Cost)),
        }
    }
}

/// Checks the depth of an operation; unwinds if the limit is passed.
pub(crate) fn check_depth(depth: u32) {
    if depth > DEEPEST && LEFT.get().is_some() {
        resume_unwind(Box::new(PassedLimit::Depth));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The message for a text that is read within a limit of the cost; `None` if it is read without a
    /// mistake.
    fn message(most: u64, text: &str) -> Option<String> {
        let read = within_cost(most, || {
            let read = crate::read("long", text, &[]);
            read.map(|read| drop(read.model.data()))
                .map_err(|mistakes| mistakes[0].clone())
        });
        read.and_then(|read| read).err().map(|mistake| mistake.message)
    }

    #[test]
    fn what_is_too_long_or_too_deep_is_refused_with_its_limit() {
        let product = |n: usize| {
            format!(
                "coordinates(x: [{n}]); lagrangian = sum(0..{n}, |i| dot(x[i]).powi(2)) + product(0..{n}, |i| x[i].sin());"
            )
        };
        assert_eq!(message(MOST, &product(4)), None);
        let long = message(100_000, &product(40)).unwrap();
        assert!(
            long.contains("longer than this library reads (100000 operations"),
            "{long}"
        );
        // each function calls the one before it twice
        let functions = (1..17).map(|i| format!("let f{i} = |u| f{0}(f{0}(u));", i - 1));
        let functions: String = functions.collect();
        let text = format!(
            "let f0 = |u| u * u + u.sin(); {functions} coordinates(x); lagrangian = dot(x).powi(2) / 2 + f16(x);"
        );
        let deep = message(MOST, &text).unwrap();
        assert!(deep.contains("nested more than 10000 deep"), "{deep}");
        // a mistake is reported even if the cost up to it is within a small limit
        assert!(
            message(1_000_000, "coordinates(x); lagrangian = y;")
                .unwrap()
                .contains("no name `y`")
        );
    }
}
