//! Jets of functions that the macro does not see into.
//!
//! A function of the user's is generic over its number type, so it can be called with a [`Jet`], which computes its value
//! and writes down on a [`Tape`] what was done. From order 1 on the tape is read, order by order, with the recurrences
//! that the generated code has for its own expressions, and with inner sums in lanes as there. Reading takes some
//! nanoseconds for every operation and order.

mod arithmetic;
mod functions;
mod plan;
mod scalar;
mod tape;

pub use tape::Tape;

use tape::Op;

/// A number with all its derivatives with respect to time, as your functions see it.
///
/// Only its value (order 0) is known at once; comparisons, and so branches, use this value. The operations for the higher orders are
/// recorded on the tape of this thread.
#[derive(Clone, Copy, Debug)]
pub struct Jet {
    value: f64,
    node: Option<u32>,
}

impl Jet {
    /// The coefficient of order 0.
    #[must_use]
    pub fn value(self) -> f64 {
        self.value
    }

    /// An argument of what is being recorded, by its place.
    pub(crate) fn input(place: usize, value: f64) -> Self {
        Self::of(Op::Input(place), value)
    }

    /// A number of whose higher orders nothing is known.
    fn unseen(value: f64) -> Self {
        Self::of(Op::Unseen, value)
    }

    fn of(op: Op, value: f64) -> Self {
        Self {
            value,
            node: tape::push(op, value),
        }
    }

    /// `scale · self + shift`.
    fn affine(self, scale: f64, shift: f64) -> Self {
        let value = scale * self.value + shift;
        match self.node {
            Some(_) if scale == 1.0 && shift == 0.0 => self,
            Some(node) if scale != 0.0 => Self::of(Op::Affine { u: node, scale }, value),
            _ => Self::from(value),
        }
    }

    /// The sign that decides for a piece of a function: that of the value, or the one that is continued.
    fn decides(self, own: f64) -> f64 {
        self.node.map_or(own, |node| tape::note(node, self.value, own))
    }

    /// A function of one argument.
    fn unary(self, op: impl FnOnce(u32) -> Op, value: f64) -> Self {
        match self.node {
            Some(node) => Self::of(op(node), value),
            None => Self::from(value),
        }
    }
}

impl From<f64> for Jet {
    fn from(value: f64) -> Self {
        Self { value, node: None }
    }
}
