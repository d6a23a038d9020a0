//! Causes of a jump of a position or a velocity at the end of a step.

use std::borrow::Cow;

use super::integrator::Integrator;
use super::projection::size;
use super::recurrences::SeriesKernel;
use super::watch;
use crate::error::series::Jump;
use crate::number::bounded::Bounded;
use crate::number::point::map;
use crate::solve::rotation;
use crate::tape::declaration::Declaration;

/// A velocity jumps at a switch if the constraints move it by more than this many tolerances.
const JUMPS: f64 = 100.0;

/// Lower bound of this threshold, relative to the velocity.
const LEAST_JUMP: f64 = 1e-7;

/// Distance from a switch at which the Lagrangian is compared, as a part of a step; and the least jump,
/// relative to its terms.
const BESIDE: [f64; 2] = [1e-8, 1e-5];

/// If the Lagrangian jumps at the switch, its difference at a distance larger by this factor is at most that here divided by [`JUMPS_NEAR`].
const FARTHER: f64 = 10.0;

const JUMPS_NEAR: f64 = 0.5;

/// A difference of the Lagrangian below this many rounding errors is no jump.
const ROUNDINGS: f64 = 8.0;

impl Integrator {
    /// The velocity at the end of the trial step of the length `h`, if the constraints of lower order move it
    /// by more than the tolerance explains.
    #[inline(always)]
    pub(super) fn moved(&self, h: f64) -> Option<&[f64]> {
        let projection = self.projection.as_ref()?;
        projection.moved(self.least_jump(), self.pace(h).max(self.lately))
    }

    /// The size of the velocity in a step of the length `h`.
    #[inline(always)]
    pub(super) fn pace(&self, h: f64) -> f64 {
        let [v, a] = [0, 1].map(|k| size(self.series.velocity_of(k)));
        v.max(a * h.abs())
    }

    /// The least relative change of a velocity or a position by the constraints that counts as a jump.
    #[inline(always)]
    fn least_jump(&self) -> f64 {
        (JUMPS * self.control.relative()).clamp(LEAST_JUMP, 0.1)
    }

    /// The cause of a jump of the position or the velocity at the end of a step of the length `h` at a
    /// switch, with the switch.
    #[cold]
    #[inline(never)]
    pub(super) fn jump_after(
        &mut self,
        equations: &mut dyn SeriesKernel,
        h: f64,
    ) -> Option<(Option<Cow<'static, str>>, Jump)> {
        let way = self.pace(h) * h.abs();
        let shifted = self
            .projection
            .as_ref()
            .and_then(|projection| projection.shifted(self.least_jump(), way))
            .map(<[f64]>::to_vec);
        let by = if let Some(before) = &shifted {
            // and set back to the place before the constraints moved it
            self.now.set_position(before);
            Jump::Position
        } else if let Some(before) = self.moved(h).map(<[f64]>::to_vec) {
            // the motion ends with the velocity before the jump
            self.now.set_velocity(&before);
            Jump::Constraint
        } else if self.jumps_in_action(&equations.declaration(), h) {
            Jump::Lagrangian
        } else {
            return None;
        };
        let mut switch = None;
        watch::each(equations, |group, place, at| {
            if switch.is_none() && at.touches() {
                switch = Some((group, place));
            }
        });
        Some((switch.map(|(group, place)| equations.switch(group, place)), by))
    }

    /// Whether the Lagrangian jumps with the position or the velocity, or the momentum does, at the end of a
    /// step of the length `h`. A jump in time alone, such as a force that is switched on, does not change the
    /// velocity.
    fn jumps_in_action(&self, declaration: &Declaration<'_>, h: f64) -> bool {
        let [part, least] = BESIDE;
        let beside = part * h;
        let n = self.series.dimension();
        let (mut a, mut rest) = (vec![0.0; n], vec![0.0; 2 * n]);
        let (q, v) = rest.split_at_mut(n);
        self.series.increments(h, [q, v, &mut a]);
        let at = |s: f64| {
            let [q, v] = [self.now.q(), self.now.v()];
            let after: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + s * a).collect();
            let way: Vec<f64> = v.iter().map(|v| s * v).collect();
            (rotation::moved(&declaration.shape().rotations, q, &way), after)
        };
        // the Lagrangian, and the product of momentum and velocity
        let values = |t: f64, (q, v): &(Vec<f64>, Vec<f64>)| {
            let [l, e] = [declaration.lagrangian(t, q, v), declaration.energy(t, q, v)];
            [l, l + e, l.abs().max(e.abs())]
        };
        let jumps = |beside: f64| {
            let [before, beyond] = [-beside, beside].map(|s| (self.time() + s, at(s)));
            let first = values(before.0, &before.1);
            let [moved, last] = [before.0, beyond.0].map(|t| values(t, &beyond.1));
            [
                (moved[0] - first[0]).abs(),
                (last[1] - first[1]).abs(),
                first[2].max(last[2]),
            ]
        };
        let (near, far) = (jumps(beside), jumps(FARTHER * beside));
        // where the momentum is zero, so are its terms but for rounding
        let least = (least * near[2]).max(ROUNDINGS * self.rounding_of_action(declaration));
        // the difference of a smooth function grows with the distance
        (0..2).any(|k| near[k] > least && near[k] > JUMPS_NEAR * far[k])
    }

    /// The rounding error of the Lagrangian, and of the product of momentum and velocity, at the current state.
    fn rounding_of_action(&self, declaration: &Declaration<'_>) -> f64 {
        let rounded = |x: f64| Bounded::known(x, f64::EPSILON * x.abs());
        let [q, v] = [self.now.q(), self.now.v()].map(|x| map(x, rounded));
        let t = rounded(self.time());
        declaration.lagrangian(t, &q, &v).error() + declaration.energy(t, &q, &v).error()
    }
}
