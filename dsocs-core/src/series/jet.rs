//! Jets: the user's functions, which the macro cannot expand, order by order.
//!
//! A user's function is generic over its number type, so it can be called with [`Jet`]s. It is called once
//! for each order, and each of its operations computes the coefficient of that order with the same recurrence
//! as in generated code. So the compiler knows the operations, and nothing is interpreted. An operation's
//! coefficients of lower orders lie in a [memory] of the thread; the inner sums of all operations are formed
//! in lanes beforehand, as in generated code ([`Call`]).

mod arithmetic;
mod call;
mod functions;
mod memory;
mod pieces;
mod recurrences;
mod scalar;

pub use call::Call;

/// A number with all its derivatives with respect to time, as a user's function receives it.
///
/// Comparisons, and so branches, use the value (order 0). A function is called once for each order; it has to
/// do the same operations each time.
#[derive(Clone, Copy, Debug)]
pub struct Jet {
    /// The coefficient of order 0.
    value: f64,
    /// The coefficient of the order that is being computed, if that is higher.
    now: f64,
    /// Whether there are coefficients beyond order 0.
    moves: bool,
}

impl Jet {
    /// The coefficient of order 0.
    #[must_use]
    #[inline]
    pub fn value(self) -> f64 {
        self.value
    }

    /// A number with the coefficient of the order that is being computed.
    #[inline]
    pub(crate) fn moving(value: f64, now: f64) -> Self {
        Self {
            value,
            now,
            moves: true,
        }
    }

    /// A number whose higher orders are unknown.
    fn unseen(value: f64) -> Self {
        Self::moving(value, f64::NAN)
    }

    /// `scale · self + shift`.
    #[inline]
    fn affine(self, scale: f64, shift: f64) -> Self {
        let value = scale * self.value + shift;
        if self.moves && scale != 0.0 {
            Self::moving(value, scale * self.now)
        } else {
            Self::from(value)
        }
    }
}

impl From<f64> for Jet {
    #[inline]
    fn from(value: f64) -> Self {
        Self {
            value,
            now: 0.0,
            moves: false,
        }
    }
}
