//! Jets of functions that the macro does not see into.
//!
//! A function of the user's is generic over its number type, so it can be called with [`Jet`]s. It is called once for each order, and each of its
//! operations computes the coefficient of that order with the recurrence that the generated code has for its own expressions. So the compiler
//! knows the operations, and nothing has to be interpreted. What an operation needs of the orders before lies in a
//! [memory] of the thread; the inner sums of all operations are formed in lanes beforehand, as in generated code ([`Call`]).

mod arithmetic;
mod call;
mod functions;
mod memory;
mod pieces;
mod recurrences;
mod scalar;

pub use call::Call;

/// Jets of order 0.
pub(crate) const FIRST: u8 = 1;

/// Jets of the higher orders.
pub(crate) const HIGHER: u8 = 2;

/// A number with all its derivatives with respect to time, as your functions see it.
///
/// Comparisons, and so branches, use the value (order 0). A function is called once for each order; it has to do the same each time.
///
/// `ORDER` and `SITE` are for generated code, and 0 and `false` for all else: with types of their own for order 0, for the higher orders and for each place where these
/// are computed, the compiler knows more.
#[derive(Clone, Copy, Debug)]
pub struct Jet<const ORDER: u8 = 0, const SITE: bool = false> {
    /// The coefficient of order 0.
    value: f64,
    /// The coefficient of the order that is being computed, if that is higher.
    now: f64,
    /// Whether there are coefficients beyond order 0.
    moves: bool,
}

impl<const ORDER: u8, const SITE: bool> Jet<ORDER, SITE> {
    /// The coefficient of order 0.
    #[must_use]
    #[inline]
    pub fn value(self) -> f64 {
        self.value
    }

    /// Whether order 0 is computed.
    #[inline]
    fn is_first() -> bool {
        match ORDER {
            FIRST => true,
            HIGHER => false,
            _ => memory::order() == 0,
        }
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

    /// A number of whose higher orders nothing is known.
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

impl<const ORDER: u8, const SITE: bool> From<f64> for Jet<ORDER, SITE> {
    #[inline]
    fn from(value: f64) -> Self {
        Self {
            value,
            now: 0.0,
            moves: false,
        }
    }
}
