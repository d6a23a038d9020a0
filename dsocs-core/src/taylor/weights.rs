//! Unknowns that are much smaller than others.
//!
//! Velocities are compared as numbers, so a coordinate that is small beside another one, in its unit or in fact, would be computed to no digit of its own. Where
//! no scales are set, one whose velocity is below a thousandth of the largest is therefore multiplied by a weight that makes it a thousandth: its own
//! error is at most a thousand times the tolerance. Not so what is only rounding, as the velocity of a coordinate that stays at rest by symmetry.

use super::integrator::Integrator;
use super::recurrences::SeriesKernel;
use crate::number::point::AnyPoint;
use crate::regularity::sides;
use crate::solve::Vector;
use crate::solve::dense::Matrix;
use crate::start;
use crate::tape::declaration::Declaration;

/// A velocity counts as this part of the largest one, at least.
const LEAST: f64 = 1e-3;

/// The rounding of a velocity in a step is so much less than what the tolerance asks of it.
const ABOVE_ROUNDING: f64 = 100.0;

/// Weights are looked at again after as many steps as were made, between these numbers.
const AGAIN: [u64; 2] = [8, 1024];

/// So often the first step is looked at.
const FIRST: u32 = 6;

/// How large velocities are.
#[derive(Debug)]
pub(super) struct Weights {
    /// The largest size of each velocity so far.
    sizes: Vec<f64>,
    /// The number of steps after which they are looked at again.
    pub(super) next: u64,
}

impl Weights {
    /// Before the first step.
    pub(super) fn new(dimension: usize) -> Self {
        Self {
            sizes: vec![0.0; dimension],
            next: 0,
        }
    }

    /// Does not look any more: scales were set.
    pub(super) fn stop(&mut self) {
        self.next = u64::MAX;
    }
}

impl Integrator {
    /// Looks how large velocities are, and sets the weights of those that are much smaller than the largest.
    #[cold]
    #[inline(never)]
    pub(super) fn weigh(&mut self, equations: &dyn SeriesKernel) {
        let [least, most] = AGAIN;
        self.weights.next = self.steps + self.steps.clamp(least, most);
        if equations.kernel().shape().is_of_third_order() {
            return;
        }
        if let Some((_, h)) = self.last {
            self.weigh_by(equations, h.abs());
            return;
        }
        // how long the first step is depends on the weights
        for _ in 0..FIRST {
            let h = self.control.first_step(&self.next, self.order());
            self.weights.sizes.fill(0.0);
            if !self.weigh_by(equations, h) {
                return;
            }
        }
    }

    /// The same by a step of the length `h`. Returns whether a weight is another one.
    fn weigh_by(&mut self, equations: &dyn SeriesKernel, h: f64) -> bool {
        if !h.is_finite() {
            return false;
        }
        let own = self.now.v().iter().zip(self.next.velocity_of(1));
        for (size, (v, a)) in self.weights.sizes.iter_mut().zip(own) {
            *size = size.max(v.abs()).max((h * a).abs());
        }
        let sizes = &self.weights.sizes;
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        let is_small = |size: f64| size > 0.0 && size < LEAST * largest;
        if !sizes.iter().any(|&size| is_small(size)) || !largest.is_finite() {
            return false;
        }
        let point = AnyPoint {
            t: self.time(),
            q: self.now.q(),
            v: self.now.v(),
            a: self.acceleration(),
        };
        let Some(rounding) = rounding(&equations.declaration(), point) else {
            return false;
        };
        let weights: Vec<f64> = sizes
            .iter()
            .zip(&rounding)
            .map(|(&size, rounding)| {
                let known = self.control.relative() * largest / (ABOVE_ROUNDING * h * rounding);
                if is_small(size) {
                    (LEAST * largest / size).min(known).max(1.0)
                } else {
                    1.0
                }
            })
            .collect();
        let differ = weights != self.control.weights();
        if differ {
            self.control.weigh(&weights);
            self.known = None;
        }
        differ
    }
}

/// How far each component of an acceleration is known; `None` where that cannot be told.
fn rounding(declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) -> Option<Vector> {
    let n = point.q.len();
    let (_, multipliers) =
        start::acceleration(declaration, (point.t, point.q, point.v), Some(point.a)).ok()?;
    let count = n + declaration.shape().multipliers();
    let mut bounds = vec![0.0; count];
    declaration.continuous_bounds(point, &multipliers, &mut bounds);
    let jacobian = declaration
        .continuous_with_jacobian::<f64>(point, &multipliers)
        .split_off(count);
    let inverse = sides::inverse(Matrix::from_fn(count, count, |i, j| jacobian[i * count + j]))?;
    let rounding = Vector::from_fn(n, |i| {
        let terms = inverse.row(i).zip(&bounds);
        terms.map(|(x, bound)| x.abs() * bound).sum()
    });
    rounding.is_finite().then_some(rounding)
}
