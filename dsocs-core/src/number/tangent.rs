//! A scalar of the generated code that carries derivatives along.
//!
//! The generated code is generic over its scalar. Evaluated with these numbers it differentiates itself.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::number::dual::{Dual, Part};
use crate::number::real::Real as _;
use crate::number::scalar::Scalar;

/// The weights of the central difference quotient of order 8, for the differences over one to four times the
/// shift.
const WEIGHTS: [f64; 4] = [0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0];

/// Number of lanes for one direction: the unshifted argument, and four on either side.
pub(crate) const PLACES: usize = 1 + 2 * WEIGHTS.len();

/// A number and its derivative in one direction (`Tangent`), or its first derivatives in two directions and
/// the mixed second one (`Tangent<Dual<f64>>`, see [`Tangent::second`]).
///
/// Derivatives are exact, except those of the user's functions ([`Scalar::from_lanes`]), which are called
/// with plain numbers: they are difference quotients of order 8. If no argument of such a function varies,
/// all values agree, and the derivative is exactly zero.
///
/// ```
/// use dsocs_core::__private::{Scalar, Tangent};
///
/// let x = Tangent::new(0.5, 1.0);
/// assert_eq!((x * x).derivative(), 1.0);
/// // ∂²(x² y)/∂x∂y at (0.5, 3)
/// let (x, y) = (Tangent::second(0.5, [1.0, 0.0]), Tangent::second(3.0, [0.0, 1.0]));
/// assert_eq!((x * x * y).mixed(), 1.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Tangent<D: Nested = f64>(Dual<D>);

/// A number with its derivatives in two directions and the mixed one.
pub type Tangent2 = Tangent<Dual<f64>>;

impl Tangent {
    /// A number with its derivative.
    #[must_use]
    pub fn new(value: f64, derivative: f64) -> Self {
        Self(Dual::new(value, derivative))
    }

    /// The derivative.
    #[must_use]
    pub fn derivative(self) -> f64 {
        self.0.eps
    }
}

impl Tangent2 {
    /// A number with its derivatives in two directions, and mixed derivative zero.
    #[must_use]
    pub fn second(value: f64, [first, other]: [f64; 2]) -> Self {
        Self(Dual::new(Dual::new(value, first), Dual::new(other, 0.0)))
    }

    /// The derivatives in the two directions.
    #[must_use]
    pub fn derivatives(self) -> [f64; 2] {
        [self.0.re.eps, self.0.eps.re]
    }

    /// The mixed second derivative.
    #[must_use]
    pub fn mixed(self) -> f64 {
        self.0.eps.eps
    }
}

impl<D: Nested> Tangent<D> {
    /// The number itself.
    #[must_use]
    pub fn value(self) -> f64 {
        self.0.re.re()
    }
}

/// The value's type in a dual number: a number, or a dual number once more.
pub trait Nested: Part + Send + Sync {
    /// The shift of the difference quotients of the user's functions, relative to the derivatives of their
    /// arguments. Derivatives are best taken by coordinates in units of a leg. The rounding error of a
    /// quotient is inversely proportional to the shift, that of a second derivative to its square, which is
    /// why its shift is larger.
    #[doc(hidden)]
    const SHIFT: f64;

    /// The number, shifted for a lane.
    #[doc(hidden)]
    fn moved(number: &Dual<Self>, lane: usize) -> f64;

    /// A function's values and derivatives, from its values at all shifts.
    #[doc(hidden)]
    fn gathered<const P: usize>(function: impl FnMut(usize) -> [f64; P]) -> [Dual<Self>; P];
}

/// The shift of the argument in a lane, in units of the derivative.
fn shift<D: Nested>(place: usize) -> f64 {
    let far = place.div_ceil(2) as f64 * D::SHIFT;
    if place % 2 == 1 { far } else { -far }
}

/// `number + by · derivative`; `number` itself if either factor is zero, also where the other is infinite.
fn along(number: f64, derivative: f64, by: f64) -> f64 {
    if derivative == 0.0 || by == 0.0 {
        number
    } else {
        number + by * derivative
    }
}

/// The difference quotient from the values at all shifts.
fn quotient<D: Nested>(values: impl Fn(usize) -> f64) -> f64 {
    let differences = WEIGHTS.iter().enumerate();
    differences
        .map(|(k, weight)| weight * ((values(2 * k + 1) - values(2 * k + 2)) / D::SHIFT))
        .sum()
}

impl Nested for f64 {
    const SHIFT: f64 = 1.0 / 64.0;

    fn moved(number: &Dual<f64>, lane: usize) -> f64 {
        along(number.re, number.eps, shift::<Self>(lane))
    }

    fn gathered<const P: usize>(function: impl FnMut(usize) -> [f64; P]) -> [Dual<f64>; P] {
        let values: [[f64; P]; PLACES] = core::array::from_fn({
            let mut function = function;
            move |place| function(place)
        });
        core::array::from_fn(|p| Dual::new(values[0][p], quotient::<Self>(|place| values[place][p])))
    }
}

impl Nested for Dual<f64> {
    const SHIFT: f64 = 1.0 / 16.0;

    fn moved(number: &Dual<Self>, lane: usize) -> f64 {
        let (first, other) = (shift::<Self>(lane % PLACES), shift::<Self>(lane / PLACES));
        let moved = along(number.re.re, number.re.eps, first);
        along(along(moved, number.eps.re, other), number.eps.eps, first * other)
    }

    fn gathered<const P: usize>(mut function: impl FnMut(usize) -> [f64; P]) -> [Dual<Self>; P] {
        let values: [[[f64; P]; PLACES]; PLACES] =
            core::array::from_fn(|other| core::array::from_fn(|first| function(other * PLACES + first)));
        core::array::from_fn(|p| {
            let row = |other: usize| {
                let by_first = quotient::<Self>(|first| values[other][first][p]);
                Dual::new(values[other][0][p], by_first)
            };
            let rows: [Dual<f64>; PLACES] = core::array::from_fn(row);
            let by_other = Dual::new(
                quotient::<Self>(|i| rows[i].re),
                quotient::<Self>(|i| rows[i].eps),
            );
            Dual::new(rows[0], by_other)
        })
    }
}

// Not inlined: a generated method is thousands of such operations, each with branches. Compiling them as one
// function would cost more time than these derivatives ever save.

macro_rules! operators {
    ($($name:ident :: $method:ident),* $(,)?) => {
        $(
            impl<D: Nested> $name for Tangent<D> {
                type Output = Self;

                #[inline(never)]
                fn $method(self, other: Self) -> Self {
                    Self($name::$method(self.0, other.0))
                }
            }
        )*
    };
}

operators!(Add::add, Sub::sub, Mul::mul, Div::div);

impl<D: Nested> Neg for Tangent<D> {
    type Output = Self;

    #[inline(never)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! functions {
    ($($name:ident),* $(,)?) => {
        $(
            #[inline(never)]
            fn $name(self) -> Self {
                Self(self.0.$name())
            }
        )*
    };
}

impl<D: Nested> Scalar for Tangent<D> {
    const LANES: usize = 1;

    fn splat(value: f64) -> Self {
        Self(Dual::from(value))
    }

    /// The number itself in lane 0, shifted along its derivatives in the others.
    fn lane(self, lane: usize) -> f64 {
        D::moved(&self.0, lane)
    }

    fn from_lanes<const P: usize>(function: impl FnMut(usize) -> [f64; P]) -> [Self; P] {
        D::gathered(function).map(Self)
    }

    #[inline(never)]
    fn select_lt(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.value() < right.value() {
            then
        } else {
            otherwise
        }
    }

    #[inline(never)]
    fn select_le(left: Self, right: Self, then: Self, otherwise: Self) -> Self {
        if left.value() <= right.value() {
            then
        } else {
            otherwise
        }
    }

    functions!(
        abs, signum, recip, sqrt, cbrt, exp, exp_m1, ln, ln_1p, sin, cos, tan, asin, acos, atan, sinh, cosh,
        tanh, asinh, acosh, atanh,
    );

    #[inline(never)]
    fn powf(self, exponent: Self) -> Self {
        Self(self.0.powd(exponent.0))
    }

    #[inline(never)]
    fn powi(self, exponent: i32) -> Self {
        Self(self.0.powi(exponent))
    }

    #[inline(never)]
    fn atan2(self, x: Self) -> Self {
        Self(self.0.atan2(x.0))
    }
}
