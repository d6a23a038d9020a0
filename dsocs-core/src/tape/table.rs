//! Calls that are data: numbers, and tables of samples.

use core::any::Any;
use std::sync::Arc;

use super::evaluate::Number;
use crate::number::scalar::Scalar;
use crate::samples::Samples;

/// A call of a tape that is data: a number or a table.
#[derive(Clone, Debug)]
pub enum TapeCall {
    /// A number, without arguments.
    Number(f64),
    /// A derivative of a table of samples, at its one argument.
    Samples {
        /// The table.
        samples: Arc<Samples>,
        /// The order of the derivative; 0 for the value.
        derivative: usize,
    },
}

/// The functions that a tape calls, by their numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct TapeCalls(pub Vec<TapeCall>);

impl TapeCall {
    /// A reference to the data.
    pub(crate) fn data(&self) -> CallData<'_> {
        match self {
            Self::Number(value) => CallData::Number(*value),
            Self::Samples { samples, derivative } => CallData::Samples {
                samples,
                derivative: *derivative,
            },
        }
    }

    /// The value at an argument.
    pub(crate) fn value<T: Number>(&self, argument: Option<T>) -> T {
        self.data().value(argument)
    }
}

/// A call that is data, of a tape or of a field of a struct.
#[derive(Clone, Copy, Debug)]
pub enum CallData<'d> {
    /// A number, without arguments.
    Number(f64),
    /// A derivative of a table of samples, at its one argument.
    Samples {
        /// The table.
        samples: &'d Samples,
        /// The order of the derivative; 0 for the value.
        derivative: usize,
    },
}

/// The derivative of a field that is a table of samples; `None` for another type with the same name.
#[must_use]
pub fn table<T: Any>(field: &T, derivative: usize) -> Option<CallData<'_>> {
    let samples = (field as &dyn Any).downcast_ref()?;
    Some(CallData::Samples { samples, derivative })
}

impl CallData<'_> {
    /// The value at an argument. The operations are those of [`Samples::at`] with dual numbers, in their order.
    pub(crate) fn value<T: Number>(self, argument: Option<T>) -> T {
        let (samples, derivative, x) = match (self, argument) {
            (Self::Number(value), _) => return T::splat(value),
            (Self::Samples { samples, derivative }, Some(x)) => (samples, derivative, x),
            (Self::Samples { .. }, None) => return T::splat(f64::NAN),
        };
        let [from, a, b, c, d] = x.polynomial(samples);
        let x = x - from;
        let rows = (x * d + c) * x + b;
        match derivative {
            0 => rows * x + a,
            1 => (d * x + (x * d + c)) * x + rows,
            2 => {
                let slope = d * x + (x * d + c);
                (d + d) * x + slope + slope
            }
            3 => {
                let twice = d + d;
                twice + twice + twice
            }
            _ => T::splat(0.0) * x,
        }
    }
}

/// The polynomial of samples around a number, lane by lane.
pub(super) fn polynomial<T: Scalar>(x: T, samples: &Samples) -> [T; 5] {
    T::from_lanes(|lane| piece(x.lane(lane), samples))
}

/// The polynomial of samples at a place; its coefficients are constant on a piece.
pub(super) fn piece(x: f64, samples: &Samples) -> [f64; 5] {
    samples.polynomial(samples.places().partition_point(|&place| place <= x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::tangent::Tangent;

    /// Near a sample, finite differences would reach into the next piece.
    #[test]
    fn a_table_is_differentiated_on_its_own_piece() {
        let samples = Samples::linear([(0.0, 0.0), (1.0, 2.0), (2.0, -1.0)]).unwrap();
        let table = TapeCall::Samples {
            samples: Arc::new(samples),
            derivative: 0,
        };
        for (x, slope) in [(0.999, 2.0), (1.0, -3.0), (1.001, -3.0)] {
            let found = table.value(Some(Tangent::new(x, 1.0))).derivative();
            assert!((found - slope).abs() < 1e-14, "{x}: {found}");
        }
    }
}
