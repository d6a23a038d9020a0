//! The dual numbers with which the user's functions are called.
//!
//! A dual number is a value and a derivative, each a number or a dual number in its turn: nested twice they
//! give second derivatives. `num-dual` has such numbers too ([`Real`] takes them). But some of its functions
//! leave the range of doubles long before their results do (`tanh` is NaN from 355 on, `atan` flat from 1e154
//! on), or are NaN where a limit exists (`sqrt` of the constant 0, `powi(3)` at 0 times an infinite slope),
//! or panic (`%`). The functions here are right wherever the function and its derivative are finite, or have
//! limits.

mod functions;
mod numbers;

use crate::number::real::Real;

/// The type of a dual number's parts: real numbers, and dual numbers over them.
pub trait Part: Real {
    /// Whether every part is zero, as in the derivative of a constant.
    fn vanishes(&self) -> bool;
}

impl Part for f64 {
    fn vanishes(&self) -> bool {
        *self == 0.0
    }
}

/// A value and a derivative: the number type in which the cost of a [`Path`](crate::Path) is written.
///
/// It has the functions of [`Real`]. An operand of its operators may be an `f64`, on either side. Comparisons look only at the value.
///
/// ```
/// use dsocs_core::{Dual, Real};
///
/// let x = Dual::new(0.5, 1.0);
/// let y = 3.0 * x * x + x.sin();
/// assert_eq!((y.re, y.eps), (0.75 + 0.5_f64.sin(), 3.0 + 0.5_f64.cos()));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Dual<D> {
    /// The value.
    pub re: D,
    /// The derivative.
    pub eps: D,
}

impl<D> Dual<D> {
    /// A dual number with the given parts.
    pub fn new(re: D, eps: D) -> Self {
        Self { re, eps }
    }
}

impl<D: Part> Part for Dual<D> {
    fn vanishes(&self) -> bool {
        self.re.vanishes() && self.eps.vanishes()
    }
}

impl<D: Part> Dual<D> {
    /// A constant.
    fn constant(re: D) -> Self {
        Self { re, eps: D::zero() }
    }

    /// A function's value, and its derivative by the chain rule. The derivative of a constant stays zero,
    /// also where the slope is infinite.
    fn chain(self, value: D, slope: impl FnOnce() -> D) -> Self {
        Self {
            re: value,
            eps: part(self.eps, slope),
        }
    }
}

/// One term of the chain rule, `derivative · slope`; zero if the derivative is.
fn part<D: Part>(derivative: D, slope: impl FnOnce() -> D) -> D {
    if derivative.vanishes() {
        D::zero()
    } else {
        derivative * slope()
    }
}

#[cfg(test)]
mod tests;
