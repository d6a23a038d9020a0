//! Weights of velocities that are much smaller than others.
//!
//! Velocities are compared as numbers, so a coordinate that is small beside another one, by its unit or in
//! fact, would be computed without a correct digit. If no scales are set, a velocity below a thousandth of
//! the largest is therefore multiplied by a weight that makes it a thousandth: its own error is at most a
//! thousand times the tolerance. A velocity that is only rounding, as that of a coordinate at rest by
//! symmetry, has no weight.

use super::control::{Assessment, Control, Sizes};
use super::integrator::Integrator;
use super::recurrences::SeriesKernel;
use crate::number::larger;
use crate::number::point::AnyPoint;
use crate::solve::Square;
use crate::tape::declaration::Declaration;

/// A velocity counts as at least this part of the largest one.
const LEAST: f64 = 1e-3;

/// The rounding error of a velocity in a step has to be smaller than the error allowed by the tolerance by
/// this factor.
const ABOVE_ROUNDING: f64 = 100.0;

/// Weights are computed again after as many steps as were made, but at least and at most these numbers.
const AGAIN: [u64; 2] = [8, 1024];

/// If the largest velocity falls below this part of its former value, as after a body has passed close to
/// another one or to the pole of its angles, velocities are compared by their current sizes.
const FALLEN: f64 = 1e-2;

/// Number of iterations for the first step, whose length depends on the weights.
const FIRST: u32 = 6;

/// The sizes of velocities, with workspace for their accuracy, so that steps allocate nothing.
#[derive(Debug)]
pub(super) struct Weights {
    /// The largest size of each velocity so far.
    sizes: Vec<f64>,
    /// The number of steps after which weights are computed again.
    pub(super) next: u64,
    /// The weights.
    found: Vec<f64>,
    /// Whether a weight is larger than 1.
    pub(super) are_used: bool,
    /// The largest velocity when the weights were computed.
    pub(super) largest: f64,
    /// Whether velocities have fallen once: they may rise and fall again.
    has_fallen: bool,
    /// Rows, their rounding errors, and their Jacobian.
    rows: Vec<f64>,
    bounds: Vec<f64>,
    jacobian: Vec<f64>,
    transposed: Square,
}

impl Weights {
    /// The weights before the first step.
    pub(super) fn new(dimension: usize) -> Self {
        Self {
            sizes: vec![0.0; dimension],
            next: 0,
            found: vec![1.0; dimension],
            are_used: false,
            largest: 0.0,
            has_fallen: false,
            rows: vec![0.0; dimension],
            bounds: vec![0.0; dimension],
            jacobian: vec![0.0; dimension * dimension],
            transposed: Square::zero(dimension),
        }
    }

    /// Stops computing weights.
    pub(super) fn stop(&mut self) {
        self.next = u64::MAX;
    }

    /// Passes the weights to the step control.
    fn apply(&mut self, control: &mut Control) {
        self.are_used = self.found.iter().any(|&weight| weight > 1.0);
        control.weigh(&self.found);
    }

    /// Computes the rounding errors of the rows, and their Jacobian.
    fn linearize(&mut self, declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) {
        declaration.continuous_bounds(point, &[], &mut self.bounds);
        declaration.linearize_continuous(point, &[], &mut self.rows, &mut self.jacobian);
    }

    /// The rounding error of a component of the acceleration; NaN if it cannot be computed.
    fn rounding(&mut self, component: usize) -> f64 {
        let n = self.rows.len();
        for (place, entry) in self.transposed.entries_mut().iter_mut().enumerate() {
            *entry = self.jacobian[place % n * n + place / n];
        }
        // a row of the inverse
        self.rows.fill(0.0);
        self.rows[component] = 1.0;
        let (is_good, _) = self.transposed.solve_quick(&mut self.rows);
        let terms = self.rows.iter().zip(&self.bounds);
        let rounding = terms.map(|(x, bound)| x.abs() * bound).sum();
        if is_good { rounding } else { f64::NAN }
    }
}

impl Integrator {
    /// Whether velocities have fallen far below those for which the weights were computed.
    #[inline]
    pub(super) fn have_fallen(&self) -> bool {
        self.weights.are_used && self.is_far_below()
    }

    fn is_far_below(&self) -> bool {
        let (Some(known), Some((_, h))) = (&self.known, self.last) else {
            return false;
        };
        known.velocity.max(known.acceleration * h.abs()) < FALLEN * self.weights.largest
    }

    /// Computes the sizes of velocities, and the weights of those that are much smaller than the largest.
    #[cold]
    #[inline(never)]
    pub(super) fn weigh(&mut self, equations: &dyn SeriesKernel) {
        let [least, most] = AGAIN;
        self.weights.next = self.steps + self.steps.clamp(least, most);
        let shape = equations.kernel().shape();
        // the rest of a velocity after projection may be rounding, which the equations for accelerations do
        // not contain
        if shape.is_of_third_order() || shape.multipliers() > 0 || self.projection.is_some() {
            self.weights.stop();
            return;
        }
        self.weights.has_fallen |= self.have_fallen();
        if self.weights.has_fallen {
            self.weights.sizes.fill(0.0);
            // near such a place each step is many times as long as the one before
            self.weights.next = self.steps + 1;
        }
        if let Some((_, h)) = self.last {
            self.weigh_by(equations, h.abs());
            return;
        }
        // the length of the first step depends on the weights
        for _ in 0..FIRST {
            let h = self.control.first_step(&self.next, self.order());
            self.weights.sizes.fill(0.0);
            if !self.weigh_by(equations, h) {
                return;
            }
        }
    }

    /// [`Integrator::weigh`] for a step of the length `h`. Returns whether a weight has changed.
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
        if !largest.is_finite() {
            return false;
        }
        if !sizes.iter().any(|&size| is_small(size)) {
            if self.weights.are_used {
                self.weights.found.fill(1.0);
                self.weights.apply(&mut self.control);
                self.known = None;
            }
            return false;
        }
        let Self {
            weights,
            control,
            now,
            next,
            t,
            ..
        } = self;
        let point = AnyPoint {
            t: t.hi[0],
            q: now.q(),
            v: now.v(),
            a: next.velocity_of(1),
        };
        weights.linearize(&equations.declaration(), point);
        for component in 0..weights.sizes.len() {
            let size = weights.sizes[component];
            weights.found[component] = if is_small(size) {
                let rounding = weights.rounding(component);
                let known = control.relative() * largest / (ABOVE_ROUNDING * h * rounding);
                let weight = (LEAST * largest / size).min(known).max(1.0);
                if weight.is_finite() { weight } else { 1.0 }
            } else {
                1.0
            };
        }
        weights.largest = largest;
        let differ = weights.found != control.weights();
        if differ {
            weights.apply(control);
            self.known = None;
        }
        differ
    }

    /// Lowers the weights of velocities that grow in the trial step of the length `h`, as that of a body at
    /// rest that another one hits: its weight for rounding would make it dominate. Returns the sizes at the
    /// beginning of the step and the assessment at its end with the new weights.
    #[cold]
    #[inline(never)]
    pub(super) fn weigh_at_end(&mut self, equations: &dyn SeriesKernel, h: f64) -> (Sizes, Assessment) {
        let Self {
            weights,
            control,
            series,
            next,
            tried,
            order,
            ..
        } = self;
        let own = tried.v().iter().zip(next.velocity_of(1));
        for (size, (v, a)) in weights.sizes.iter_mut().zip(own) {
            *size = larger(*size, larger(v.abs(), (h * a).abs()));
        }
        let largest = weights.sizes.iter().copied().fold(0.0, larger);
        for (weight, size) in weights.found.iter_mut().zip(&weights.sizes) {
            let least = (LEAST * largest / size).max(1.0);
            // not if a size is NaN
            if least < *weight {
                *weight = least;
            }
        }
        weights.largest = largest;
        weights.apply(control);
        let (weights, p) = (control.weights(), order.current());
        (
            Sizes::of(series, weights, p),
            equations.assess(next, tried.a(), weights, p),
        )
    }
}
