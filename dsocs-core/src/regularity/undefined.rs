//! Expressions of a declaration that have no value at a point.

use core::fmt;

use crate::number::point::AnyPoint;
use crate::tape::Leaf;
use crate::tape::declaration::Declaration;
use crate::tape::origin::Origin;

/// An expression of a declaration, or of its derivatives, without a finite value at a point although its
/// operands are finite, such as the root of a negative number, or an overflow; or a divisor that is zero
/// there.
///
/// Its text is a sentence: ``the divisor `x.powi(2) + y.powi(2)` is zero there (x = 0, y = 0)``.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Undefined {
    /// The expression, written as in a declaration; long ones are shortened.
    pub expression: String,
    /// Its value: infinite, not a number, or zero for a divisor.
    pub value: f64,
    /// The names and values of the quantities in it, such as `x`, `dot(x)`, `mass` and `t`.
    pub quantities: Vec<(String, f64)>,
    /// Whether a position, a velocity, and a parameter are among them.
    contains: [bool; 3],
    /// Whether it has a value, but no derivative.
    without_derivative: bool,
}

/// Functions that overflow for large arguments.
const OVERFLOWS: [&str; 4] = [".exp()", ".exp_m1()", ".cosh()", ".sinh()"];

/// An exponential above this overflows in derivatives of high order, in which its powers are multiplied.
const LARGE: f64 = 1e100;

/// Largest number of quantities that a message names.
const NAMED: usize = 6;

impl Undefined {
    /// Whether a coordinate is in the expression.
    #[must_use]
    pub fn contains_position(&self) -> bool {
        self.contains[0]
    }

    /// Whether a velocity is in the expression.
    #[must_use]
    pub fn contains_velocity(&self) -> bool {
        self.contains[1]
    }

    /// Whether a parameter is in the expression.
    #[must_use]
    pub fn contains_parameter(&self) -> bool {
        self.contains[2]
    }

    /// Whether it is a function that overflows, or is so large that its derivatives do.
    pub(crate) fn overflows(&self) -> bool {
        let grows = OVERFLOWS.iter().any(|name| self.expression.ends_with(name));
        grows && !self.value.is_nan() && self.value.abs() > LARGE
    }

    /// Advice for users.
    pub(crate) fn advice(&self, at_rest: bool) -> &'static str {
        if self.overflows() {
            return "write what is bounded without it: `(1 + (u / 2).tanh()) / 2` in place of `1 / (1 + (-u).exp())`, `1 - u.tanh().powi(2)` in place of \
                    `1 / u.cosh().powi(2)`, and `2 * (-u.abs()).exp() / (1 + (-2 * u.abs()).exp())` in place of `1 / u.cosh()`";
        }
        if self.without_derivative {
            return if at_rest && self.contains_velocity() {
                "the system is at rest there: start with a velocity; or give it a derivative at rest, `(v.norm_squared() + 1e-12).sqrt()` in place of `v.norm()`"
            } else {
                "begin elsewhere; or give it a derivative there, `(x.norm_squared() + 1e-12).sqrt()` in place of `x.norm()`"
            };
        }
        match self.contains {
            [false, false, true] => "its parameters need other values",
            [_, true, _] if at_rest => {
                "the system is at rest there: start with a velocity; or write the constraint so that it has a value at rest (where \
                 `branch` divides by this factor, write the quotient itself)"
            }
            [_, _, true] => "begin elsewhere, or with other parameters",
            _ => "begin elsewhere",
        }
    }
}

/// Numbers that are written without an exponent.
const LONG: core::ops::Range<f64> = 1e-5..1e16;

impl fmt::Display for Undefined {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [before, after] = if self.without_derivative {
            ["", "has no derivative"]
        } else if self.value.is_nan() {
            ["", "has no value"]
        } else if self.value == 0.0 {
            ["the divisor ", "is zero"]
        } else if self.value.is_finite() {
            ["", "is so large that its derivatives overflow"]
        } else {
            ["", "is infinite"]
        };
        write!(f, "{before}`{}` {after} there", self.expression)?;
        let named: Vec<String> = self
            .quantities
            .iter()
            .take(NAMED)
            .map(|(name, value)| format!("{name} = {}", short(*value)))
            .collect();
        let more = if self.quantities.len() > NAMED {
            ", …"
        } else {
            ""
        };
        let says_all = !self.without_derivative
            && self.value == 0.0
            && self.quantities.iter().all(|(name, _)| *name == self.expression);
        if named.is_empty() || says_all {
            Ok(())
        } else {
            write!(f, " ({}{more})", named.join(", "))
        }
    }
}

/// A number in its shortest form.
fn short(value: f64) -> String {
    if value != 0.0 && !LONG.contains(&value.abs()) {
        format!("{value:e}")
    } else {
        format!("{value}")
    }
}

/// The expression without a value in the equations of the continuous system, or in their Jacobian, at a
/// point.
#[cold]
pub(crate) fn of_point(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) -> Option<Undefined> {
    let origin = declaration.origin_of_point(point, &|leaf| named(declaration, leaf))?;
    Some(description(declaration, origin, false))
}

/// The expression in the equations of the continuous system at a point that has a value and no derivative,
/// such as the root of zero.
#[cold]
pub(crate) fn without_derivative(
    declaration: &Declaration<'_>,
    point: AnyPoint<'_, f64>,
) -> Option<Undefined> {
    let origin = declaration.without_derivative(point, &|leaf| named(declaration, leaf))?;
    Some(description(declaration, origin, true))
}

/// The exponential in the equations of the continuous system at a point whose derivatives of high order
/// overflow.
#[cold]
pub(crate) fn overflowing(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) -> Option<Undefined> {
    let origin = declaration.large(point, LARGE, &|leaf| named(declaration, leaf))?;
    Some(description(declaration, origin, false))
}

/// The name of a quantity in a declaration.
pub(crate) fn named(declaration: &Declaration<'_>, leaf: Leaf) -> String {
    let coordinate = |i: usize| {
        let known = declaration.coordinates().get(i);
        known.map_or_else(|| "?".to_owned(), |known| known.name.clone().into_owned())
    };
    match leaf {
        Leaf::Q(i) => coordinate(i),
        Leaf::V(i) => format!("dot({})", coordinate(i)),
        Leaf::A(i) => format!("ddot({})", coordinate(i)),
        Leaf::J(i) => format!("dddot({})", coordinate(i)),
        Leaf::T => "t".to_owned(),
        Leaf::H => "h".to_owned(),
        Leaf::Parameter(i) => {
            let known = declaration.parameters().get(i);
            known.map_or_else(
                || "a parameter".to_owned(),
                |known| known.name.clone().into_owned(),
            )
        }
        _ => "…".to_owned(),
    }
}

/// The description of an expression.
fn description(declaration: &Declaration<'_>, origin: Origin, without_derivative: bool) -> Undefined {
    let contains = |of: fn(&Leaf) -> bool| origin.leaves.iter().any(|(leaf, _)| of(leaf));
    Undefined {
        without_derivative,
        contains: [
            contains(|leaf| matches!(leaf, Leaf::Q(_))),
            contains(|leaf| matches!(leaf, Leaf::V(_))),
            contains(|leaf| matches!(leaf, Leaf::Parameter(_))),
        ],
        quantities: origin
            .leaves
            .iter()
            .map(|&(leaf, value)| (named(declaration, leaf), value))
            .collect(),
        expression: origin.text,
        value: origin.value,
    }
}
