//! Order and step: À. Jorba and M. Zou, A software package for the numerical integration of ODEs by means of high-order
//! Taylor methods, Experimental Mathematics 14 (2005), section 3.

use super::kernel::MAX_ORDER;
use super::series::Series;

/// The lowest order that the tolerance may choose.
const MIN_ORDER: usize = 8;

/// How exact a step is to be.
///
/// The velocity of every coordinate is known at the end of a step to within `relative` times its own size plus
/// `absolute`; its size is the largest of `|v|` and `|a| h` at the beginning of the step, so that a velocity may pass
/// through zero. The position then is exact to as much of the way that it makes in a step. There is no other scale: the
/// default absolute part is 0, and coordinates may have different units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Tolerance {
    /// The part of a velocity's size.
    pub(crate) relative: f64,
    /// In units of the velocities.
    pub(crate) absolute: f64,
    /// The order, if it is not to follow from the tolerance.
    pub(crate) order: Option<usize>,
}

impl Tolerance {
    /// A tolerance relative to the size of each velocity.
    pub const fn relative(relative: f64) -> Self {
        Self {
            relative,
            absolute: 0.0,
            order: None,
        }
    }

    /// What is exact enough in any velocity, in its units.
    pub const fn absolute(mut self, absolute: f64) -> Self {
        self.absolute = absolute;
        self
    }

    /// Sets the order, which otherwise follows from the tolerance; it is brought into 2 to [`MAX_ORDER`].
    pub const fn order(mut self, order: usize) -> Self {
        self.order = Some(order);
        self
    }

    /// The order of the velocity's series.
    ///
    /// Jorba and Zou's `-ln(ε)/2 + 1` is best where the work grows with the square of the order. Up to some 25 it grows
    /// about linearly here, so higher orders pay.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small positive number
    pub(crate) fn chosen_order(&self) -> usize {
        let of_tolerance = || {
            let wanted = ORDER_SLOPE * -self.relative.max(1e-300).ln() + ORDER_OFFSET;
            (wanted.ceil() as usize).max(MIN_ORDER)
        };
        self.order.unwrap_or_else(of_tolerance).clamp(2, MAX_ORDER)
    }
}

/// The order per natural logarithm of the tolerance.
const ORDER_SLOPE: f64 = 0.6;
/// The order at the tolerance 1.
const ORDER_OFFSET: f64 = 4.0;

/// The defect at the end of a step, times the step, may be so many times the tolerance. Of a series that converges it is
/// a few times its last term.
const DEFECT: f64 = 100.0;
/// A defect of this part of the velocity may be rounding.
const LEAST_DEFECT: f64 = 1e-12;

/// What is computed once of a tolerance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    relative: f64,
    absolute: f64,
    /// The part of the radius of convergence that a step takes.
    part: f64,
}

impl Control {
    pub(crate) fn new(tolerance: &Tolerance, order: usize) -> Self {
        Self {
            relative: tolerance.relative,
            absolute: tolerance.absolute,
            part: tolerance.relative.powf(1.0 / order as f64),
        }
    }

    /// The step, from the two last coefficients of the velocity; infinite where they vanish, not positive or NaN where
    /// they are not finite. `last` is the last step.
    #[inline(always)]
    #[allow(clippy::inline_always)]
    pub(super) fn step<const N: usize>(&self, series: &Series<N>, last: Option<f64>) -> f64 {
        let Some(last) = last else {
            return self.first_step(series);
        };
        let p = series.order();
        let v = series.velocity();
        let mut largest = [0.0_f64; 2];
        for i in 0..N {
            let size = v[0][i].abs().max((v[1][i] * last).abs()) + self.absolute / self.relative;
            let coefficients = [v[p - 1][i].abs(), v[p][i].abs()];
            for (largest, coefficient) in largest.iter_mut().zip(coefficients) {
                let ratio = if coefficient == 0.0 {
                    0.0
                } else {
                    coefficient / size
                };
                // NaN is to be seen
                *largest = if ratio <= *largest { *largest } else { ratio };
            }
        }
        let radius = |ratio: f64, k: usize| -log2(ratio) / k as f64;
        let (before, last) = (radius(largest[0], p - 1), radius(largest[1], p));
        exp2(if before < last { before } else { last }) * self.part
    }

    /// Whether a step was as good as its series promised: at its end the acceleration `a` of its series has to be that
    /// of the system, with which the series `next` begins.
    #[inline(always)]
    #[allow(clippy::inline_always)]
    pub(super) fn good<const N: usize>(
        &self,
        series: &Series<N>,
        next: &Series<N>,
        a: &[f64; N],
        size: f64,
    ) -> bool {
        let (v, end) = (series.velocity(), next.velocity());
        let relative = (DEFECT * self.relative).max(LEAST_DEFECT);
        let mut good = true;
        for i in 0..N {
            let way = v[0][i]
                .abs()
                .max(v[1][i].abs() * size)
                .max(end[1][i].abs() * size);
            let defect = (end[1][i] - a[i]).abs() * size;
            good &= defect <= relative * way + DEFECT * self.absolute;
        }
        good
    }

    /// The first step, of which no step is known before: a velocity's size is the largest term of its series that the step
    /// makes, so that a motion may begin at rest.
    #[cold]
    fn first_step<const N: usize>(&self, series: &Series<N>) -> f64 {
        let p = series.order();
        let v = series.velocity();
        let mut step = f64::INFINITY;
        for i in 0..N {
            for last in [p - 1, p] {
                let coefficient = v[last][i].abs();
                if coefficient == 0.0 {
                    continue;
                }
                let mut longest = 0.0_f64;
                for k in 0..=2.min(last - 1) {
                    let floor = if k == 0 {
                        self.absolute / self.relative
                    } else {
                        0.0
                    };
                    let ratio = (v[k][i].abs() + floor) / coefficient;
                    longest = longest.max((self.relative * ratio).powf(1.0 / (last - k) as f64));
                }
                if !(longest >= step) {
                    step = longest;
                }
            }
        }
        step
    }
}

/// The binary logarithm to three digits, of a number that is not negative.
#[inline(always)]
#[allow(clippy::inline_always, clippy::cast_possible_wrap)]
fn log2(x: f64) -> f64 {
    let bits = x.to_bits();
    let exponent = (bits >> 52) as i64 - 1023;
    if !(x > 0.0 && x.is_finite()) {
        return x.log2();
    }
    let m = f64::from_bits(bits & ((1 << 52) - 1) | 1.0_f64.to_bits());
    // a cubic through the ends, within 1e-3 between them
    let fraction = (m - 1.0) * (1.424_0 + (m - 1.0) * (-0.584_0 + (m - 1.0) * 0.160_0));
    exponent as f64 + fraction
}

/// A power of two to three digits.
#[inline(always)]
#[allow(
    clippy::inline_always,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]
fn exp2(x: f64) -> f64 {
    if !(x > -1000.0 && x < 1000.0) {
        return x.exp2();
    }
    let whole = x.floor();
    let f = x - whole;
    let power = f64::from_bits(((whole as i64 + 1023) as u64) << 52);
    power * (1.0 + f * (0.6951 + f * (0.2276 + f * 0.0773)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_and_power_are_good_to_a_percent() {
        for k in -200..200 {
            let x = 1.1_f64.powi(k);
            assert!((log2(x) - x.log2()).abs() < 3e-3, "{x}: {} {}", log2(x), x.log2());
            let y = f64::from(k) / 7.0;
            assert!((exp2(y) / y.exp2() - 1.0).abs() < 3e-3, "{y}");
        }
        assert_eq!(exp2(f64::NEG_INFINITY), 0.0);
        assert_eq!(exp2(-log2(0.0)), f64::INFINITY);
        assert!(exp2(log2(f64::NAN)).is_nan());
    }
}
