//! Unknowns that are much smaller than others.
//!
//! Velocities are compared as numbers, so a coordinate that is small beside another one, in its unit or in fact, would be computed to no digit of its own. Where
//! no scales are set, one whose velocity is below a thousandth of the largest is therefore multiplied by a weight that makes it a thousandth: its own
//! error is at most a thousand times the tolerance. Not so what is only rounding, as the velocity of a coordinate that stays at rest by symmetry.

use super::control::{Control, Judged, Sizes};
use super::integrator::Integrator;
use super::recurrences::SeriesKernel;
use crate::number::larger;
use crate::number::point::AnyPoint;
use crate::solve::Square;
use crate::tape::declaration::Declaration;

/// A velocity counts as this part of the largest one, at least.
const LEAST: f64 = 1e-3;

/// The rounding of a velocity in a step is so much less than what the tolerance asks of it.
const ABOVE_ROUNDING: f64 = 100.0;

/// Weights are looked at again after as many steps as were made, between these numbers.
const AGAIN: [u64; 2] = [8, 1024];

/// Where the largest velocity has fallen to this part of what it was, as after a body has passed close to another one or to the pole of its angles, velocities
/// are compared by what they are now.
const FALLEN: f64 = 1e-2;

/// So often the first step is looked at.
const FIRST: u32 = 6;

/// How large velocities are, and room to find out how far they are known, so that steps allocate nothing.
#[derive(Debug)]
pub(super) struct Weights {
    /// The largest size of each velocity so far.
    sizes: Vec<f64>,
    /// The number of steps after which they are looked at again.
    pub(super) next: u64,
    /// The weights.
    found: Vec<f64>,
    /// Whether one is larger than 1.
    pub(super) are_used: bool,
    /// The largest velocity when they were found.
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
    /// Before the first step.
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

    /// Does not look any more.
    pub(super) fn stop(&mut self) {
        self.next = u64::MAX;
    }

    /// Gives the weights to the control.
    fn apply(&mut self, control: &mut Control) {
        self.are_used = self.found.iter().any(|&weight| weight > 1.0);
        control.weigh(&self.found);
    }

    /// Takes the rounding errors of rows, and their Jacobian.
    fn linearize(&mut self, declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) {
        declaration.continuous_bounds(point, &[], &mut self.bounds);
        declaration.linearize_continuous(point, &[], &mut self.rows, &mut self.jacobian);
    }

    /// How far a component of the acceleration is known; NaN where that cannot be told.
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
    /// Whether velocities have fallen far below those that the weights belong to.
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

    /// Looks how large velocities are, and sets the weights of those that are much smaller than the largest.
    #[cold]
    #[inline(never)]
    pub(super) fn weigh(&mut self, equations: &dyn SeriesKernel) {
        let [least, most] = AGAIN;
        self.weights.next = self.steps + self.steps.clamp(least, most);
        let shape = equations.kernel().shape();
        // what constraints leave of a velocity may be rounding, of which the equations for accelerations know nothing
        if shape.is_of_third_order() || shape.multipliers() > 0 || self.projection.is_some() {
            self.weights.stop();
            return;
        }
        self.weights.has_fallen |= self.have_fallen();
        if self.weights.has_fallen {
            self.weights.sizes.fill(0.0);
            // beside such a place each step is many times as long as the one before
            self.weights.next = self.steps + 1;
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

    /// Lowers the weights of velocities that grow in the step of the length `h` that has been tried, as that of a body that rests until another one meets it: with a
    /// weight that belongs to rounding it would be all that counts. Gives the sizes at the beginning of the step and what is judged at its end with the new weights.
    #[cold]
    #[inline(never)]
    pub(super) fn weigh_at_end(&mut self, equations: &dyn SeriesKernel, h: f64) -> (Sizes, Judged) {
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
            // not where a size is no number
            if least < *weight {
                *weight = least;
            }
        }
        weights.largest = largest;
        weights.apply(control);
        let (weights, p) = (control.weights(), order.current());
        (
            Sizes::of(series, weights, p),
            equations.judge(next, tried.a(), weights, p),
        )
    }
}
