//! Order and step: À. Jorba and M. Zou, A software package for the numerical integration of ODEs by means of high-order
//! Taylor methods, Experimental Mathematics 14 (2005), section 3.

use crate::error::SetupError;
use crate::number::larger;
use crate::series::orders::{MAX_ORDER, RECIPROCALS, ROWS};
use crate::series::rows::{self, Series};
use crate::series::switch::Limits;

/// The sizes in a step's series that the step control needs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sizes {
    /// The size of the velocity.
    pub velocity: f64,
    /// The size of the acceleration.
    pub acceleration: f64,
    /// The sizes of the last two coefficients of the velocity.
    pub last: [f64; 2],
    /// Whether the highest known coefficients are in the range of doubles.
    pub is_in_range: bool,
}

impl Sizes {
    /// The sizes in a series, for steps of the order `p`, with components multiplied by weights.
    pub(super) fn of(series: &Series, weights: &[f64], p: usize) -> Self {
        let size = |k: usize| size(series.velocity_of(k), weights);
        Self {
            velocity: size(0),
            acceleration: size(1),
            last: [size(p - 1), size(p)],
            is_in_range: series.is_in_range(),
        }
    }
}

/// The assessment of a step by the series at its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Assessment {
    /// The sizes for the control of the next step.
    pub sizes: Sizes,
    /// The size of the acceleration at the beginning of the new series, and of its difference from that at
    /// the end of the old one.
    pub end: [f64; 2],
}

impl Assessment {
    /// Without a series.
    pub(super) const NONE: Self = Self {
        sizes: Sizes {
            velocity: f64::NAN,
            acceleration: f64::NAN,
            last: [f64::NAN; 2],
            is_in_range: false,
        },
        end: [f64::NAN; 2],
    };

    /// The assessment from the velocity by order, up to an order.
    #[inline(always)]
    pub(super) fn of<const N: usize>(
        v: &[[f64; N]; ROWS],
        order: usize,
        a: &[f64; N],
        (weights, p): (&[f64; N], usize),
    ) -> Self {
        let (order, p) = (order.clamp(2, MAX_ORDER), p.clamp(2, MAX_ORDER));
        let acceleration = size(&v[1], weights);
        Self {
            sizes: Sizes {
                velocity: size(&v[0], weights),
                acceleration,
                last: [size(&v[p - 1], weights), size(&v[p], weights)],
                is_in_range: rows::is_in_range(&v[order - 1], &v[order]),
            },
            end: [acceleration, distance(&v[1], a, weights)],
        }
    }
}

/// The accuracy of a step.
///
/// At the end of a step the error of the velocity is at most `relative` times its size plus `absolute`. The size is the largest component of
/// the velocity at the beginning of the step, or of the change of the velocity during the step if that is larger (the acceleration at the
/// beginning times the step). So the motion may turn round or begin at rest. The error of the position, relative to the distance that it moves
/// during the step, is the same. By default the absolute part is 0, so there is no hidden scale.
///
/// The tolerance applies to each step, and the errors of the steps add up: with 1e-3 the energy of a motion
/// may be some per cent off after a few hundred turns, and with 0.1 the motion is lost. 1e-9 costs little
/// more.
///
/// Components are compared as numbers, but one whose velocity is below a thousandth of the largest counts as a thousandth: its own error is at most a
/// thousand times the tolerance. If coordinates have very different units, [`super::TaylorFlow::scales`] sets how they compare. A
/// [`super::TaylorEnsemble`] compares them as numbers. A relative part below the unit round-off, 1.1e-16, cannot be reached because of rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Tolerance {
    /// The part relative to the velocity's size.
    pub(crate) relative: f64,
    /// The absolute part, in units of the velocities.
    pub(crate) absolute: f64,
    /// The order, if it does not follow from the tolerance.
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

    /// Adds an absolute tolerance, in the units of the velocities.
    pub const fn absolute(mut self, absolute: f64) -> Self {
        self.absolute = absolute;
        self
    }

    /// Sets the order, which otherwise follows from the tolerance and the motion; it is limited to the range from 2 to [`MAX_ORDER`].
    pub const fn order(mut self, order: usize) -> Self {
        self.order = Some(order);
        self
    }

    /// Checks that it is usable.
    pub(super) fn check(&self) -> Result<(), SetupError> {
        let Self {
            relative, absolute, ..
        } = *self;
        if relative > 0.0 && relative < 1.0 && absolute >= 0.0 && absolute.is_finite() {
            Ok(())
        } else {
            Err(SetupError::Tolerance { relative, absolute })
        }
    }

    /// The order to begin with: Jorba and Zou's `-ln(ε)/2 + 1`, and two more.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small positive number
    pub(super) fn first_order(&self) -> usize {
        let of_tolerance = || (3.0 - 0.5 * self.relative.max(1e-300).ln()).ceil() as usize;
        self.order.unwrap_or_else(of_tolerance).clamp(2, MAX_ORDER)
    }
}

/// The defect at the end of a step times the step may be this many tolerances. For a series that converges it
/// is a few times its last term.
const DEFECT: f64 = 100.0;
/// A defect below this part of the velocity may be rounding.
const LEAST_DEFECT: f64 = 1e-12;

/// A velocity below this counts as zero: the terms that cause it have lost their digits, as those of a smooth
/// pulse long before its beginning.
pub(super) const NOTHING: f64 = 1e-280;

/// The tolerance in the form that the step control needs.
#[derive(Clone, Debug)]
pub(super) struct Control {
    relative: f64,
    absolute: f64,
    /// The velocity to which the absolute part belongs.
    floor: f64,
    /// The binary logarithm of the relative part.
    log: f64,
    /// The weights of the components, before they are compared.
    weights: Box<[f64]>,
    /// The limits of steps that end at switches.
    pub(super) limits: Limits,
}

impl Control {
    pub(super) fn new(tolerance: &Tolerance, dimension: usize) -> Self {
        Self {
            relative: tolerance.relative,
            absolute: tolerance.absolute.max(NOTHING * tolerance.relative),
            floor: (tolerance.absolute / tolerance.relative).max(NOTHING),
            log: tolerance.relative.log2(),
            weights: vec![1.0; dimension].into_boxed_slice(),
            limits: Limits::new(tolerance.relative),
        }
    }

    /// The tolerance relative to the velocity.
    pub(super) fn relative(&self) -> f64 {
        self.relative
    }

    /// The binary logarithm of the step after which a coefficient of order `k` makes a term as large as the relative tolerance.
    #[inline(always)]
    pub(super) fn log_for(&self, coefficient: f64, k: usize) -> f64 {
        let least = const { 1.0 - f64::MANTISSA_DIGITS as f64 };
        (self.log.max(least) - log2(coefficient)) * RECIPROCALS[k]
    }

    /// Sets the weights of the components.
    pub(super) fn weigh(&mut self, weights: &[f64]) {
        self.weights.copy_from_slice(weights);
    }

    /// The weights of the components, before they are compared.
    #[inline]
    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The error of a step of the length `h` by an error `part` of the acceleration, in units of the allowed
    /// error.
    pub(super) fn excess(&self, v: &[f64], a: &[f64], part: &[f64], h: f64) -> f64 {
        let size = self.size(v).max(self.size(a) * h);
        let allowed = self.relative.max(f64::EPSILON) * size + self.absolute;
        let error = self.size(part) * h;
        if error == 0.0 { 0.0 } else { error / allowed }
    }

    /// The size of a vector; NaN if a component is.
    pub(super) fn size(&self, x: &[f64]) -> f64 {
        size(x, &self.weights)
    }

    /// The size of a difference; NaN if a component is.
    pub(super) fn distance(&self, x: &[f64], y: &[f64]) -> f64 {
        distance(x, y, &self.weights)
    }

    /// The binary logarithm of the velocity's size in a step of the last one's length.
    #[inline(always)]
    pub(super) fn log_size(&self, sizes: &Sizes, last: f64) -> f64 {
        log2(larger(sizes.velocity, sizes.acceleration * last.abs()) + self.floor)
    }

    /// The binary logarithm of the step of order `p`, from two coefficients of the velocity: infinite where they vanish,
    /// NaN where they are not finite.
    #[inline(always)]
    pub(super) fn log_step(&self, [before, last]: [f64; 2], p: usize, log_size: f64) -> f64 {
        let radius = |k: usize, size: f64| (log_size - log2(size)) * RECIPROCALS[k];
        let (before, last) = (radius(p - 1, before), radius(p, last));
        let radius = if before < last { before } else { last };
        radius + self.log * RECIPROCALS[p]
    }

    /// [`Control::log_step`] from a series.
    pub(super) fn log_step_by(&self, series: &Series, p: usize, log_size: f64) -> f64 {
        let last = [p - 1, p].map(|k| self.size(series.velocity_of(k)));
        self.log_step(last, p, log_size)
    }

    /// Whether a step of the length `h` is accepted: the acceleration at the end of its series has to be that
    /// of the system, with which the next series begins. `end` has the sizes of the system's acceleration and
    /// of the difference. In a rough step the difference is the whole estimate of the error.
    #[inline(always)]
    pub(super) fn good(&self, sizes: &Sizes, [end, defect]: [f64; 2], h: f64, is_rough: bool) -> bool {
        let way = larger(sizes.acceleration, end) * h;
        let size = larger(sizes.velocity, way);
        let times = if is_rough { 1.0 } else { DEFECT };
        let allowed = larger(times * self.relative, LEAST_DEFECT) * size + times * self.absolute;
        // an overflowing size is no measure
        defect * h <= allowed && allowed < f64::INFINITY
    }

    /// The first step, without a step before it. The size of the velocity is the largest term of its series
    /// in the step, so that a motion may begin at rest, and with any power of time.
    #[cold]
    pub(super) fn first_step(&self, series: &Series, p: usize) -> f64 {
        let size = |k: usize| self.size(series.velocity_of(k));
        let mut step = f64::INFINITY;
        // if motion and force begin together, the first terms vanish
        let leading = (0..p - 1).find(|&k| size(k) > 0.0).unwrap_or(0).max(2);
        for last in [p - 1, p] {
            let coefficient = size(last);
            if coefficient == 0.0 {
                continue;
            }
            let mut longest = 0.0_f64;
            for k in 0..=leading.min(last - 1) {
                let floor = if k == 0 { self.floor } else { 0.0 };
                let ratio = (size(k) + floor) / coefficient;
                longest = longest.max((self.relative * ratio).powf(1.0 / (last - k) as f64));
            }
            if longest.is_nan() || coefficient.is_nan() {
                return f64::NAN;
            }
            step = step.min(longest);
        }
        step
    }
}

/// The size of a vector, with components multiplied by weights; NaN if a component is.
#[inline(always)]
pub(super) fn size(x: &[f64], weights: &[f64]) -> f64 {
    let mut size = 0.0_f64;
    for (x, weight) in x.iter().zip(weights) {
        size = larger(size, (x * weight).abs());
    }
    size
}

/// The size of a difference; NaN if a component is.
#[inline(always)]
pub(super) fn distance(x: &[f64], y: &[f64], weights: &[f64]) -> f64 {
    let mut size = 0.0_f64;
    for ((x, y), weight) in x.iter().zip(y).zip(weights) {
        size = larger(size, ((x - y) * weight).abs());
    }
    size
}

/// The bits of the smallest normal number, and of infinity.
const NORMAL: [u64; 2] = [f64::MIN_POSITIVE.to_bits(), f64::INFINITY.to_bits()];

/// The binary logarithm to three digits, of a nonnegative number.
#[inline(always)]
#[allow(clippy::cast_possible_wrap)]
pub(super) fn log2(x: f64) -> f64 {
    let bits = x.to_bits();
    // positive, normal and finite, in one comparison
    if bits.wrapping_sub(NORMAL[0]) >= NORMAL[1] - NORMAL[0] {
        return unusual_log2(x);
    }
    let exponent = (bits >> 52) as i64 - 1023;
    let m = f64::from_bits(bits & ((1 << 52) - 1) | 1.0_f64.to_bits());
    // a cubic through the ends, within 1e-3 between them
    let fraction = (m - 1.0) * (1.424_0 + (m - 1.0) * (-0.584_0 + (m - 1.0) * 0.160_0));
    exponent as f64 + fraction
}

#[cold]
fn unusual_log2(x: f64) -> f64 {
    x.log2()
}

/// Added to a number of moderate size, it rounds it to an integer, which then stands in the lowest bits.
const WHOLE: f64 = 1.5 / f64::EPSILON;

/// A power of two to three digits.
#[inline(always)]
pub(super) fn exp2(x: f64) -> f64 {
    if !(x > -1000.0 && x < 1000.0) {
        return x.exp2();
    }
    let shifted = x - 0.5 + WHOLE;
    let f = x - (shifted - WHOLE);
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
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
