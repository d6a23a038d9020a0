//! A node that lies where the declaration jumps.
//!
//! There the acceleration has two values. The declaration, evaluated at the numbers of the node, belongs to one of the two sides; rounding
//! decides to which, since a switch is found to rounding only. Constraint force, multipliers and observed expressions are evaluated there. So
//! the acceleration of the node is that of the same side, and the data of a node obey the equations of motion.

use super::integrator::Integrator;
use crate::number::larger;
use crate::number::point::AnyPoint;
use crate::regularity::resting;
use crate::start;
use crate::tape::declaration::Declaration;

/// A time within this many roundings of a switch is that of the switch.
const ROUNDINGS: f64 = 4.0;

/// Acceleration and constraint force.
pub(super) type Sided = (Vec<f64>, Vec<f64>);

impl Integrator {
    /// Records, for later steps, whether a step of the length `h` ends at a switch, and the size of its velocity.
    pub(super) fn keep(&mut self, h: f64, at_switch: bool) {
        if self.projection.is_some() {
            self.lately = larger(self.pace(h), 0.5 * self.lately);
        }
        self.at_switch = [self.at_switch[1], at_switch];
    }

    /// Whether a time is that of a switch, at an end of the last step.
    pub(super) fn is_at_switch_time(&self, t: f64) -> bool {
        let [begins, ends] = self.at_switch;
        ends && self.is_near(t) || begins && self.last.is_some_and(|(start, _)| near(t, start.hi[0]))
    }

    /// Whether a time is that up to which the motion is known, to rounding.
    pub(super) fn is_near(&self, t: f64) -> bool {
        near(t, self.time())
    }

    /// Acceleration and constraint force as the declaration has them at a node that lies on a switch; `None`
    /// elsewhere.
    pub(super) fn at_jump(&self, declaration: &Declaration<'_>, point: AnyPoint<'_, f64>) -> Option<Sided> {
        if !self.is_at_switch_time(point.t) {
            return None;
        }
        let (state, n) = ((point.t, point.q, point.v), point.q.len());
        let shape = declaration.shape();
        let whole = |a: &[f64]| a.len() == n && a.iter().all(|a| a.is_finite());
        if shape.jumps
            && declaration.sides() > 0
            && let Some(found) = resting::of_motion(declaration, state, shape.multipliers(), Some(point.a))
        {
            let a = found.x.get(..n).filter(|a| whole(a))?.to_vec();
            let force = declaration.sided_continuous_force(AnyPoint { a: &a, ..point }, &found.sides);
            return Some((a, force));
        }
        let (a, _) = start::acceleration(declaration, state, Some(point.a)).ok()?;
        let a = Some(a.to_vec()).filter(|a| whole(a))?;
        let force = declaration.continuous_force(AnyPoint { a: &a, ..point });
        Some((a, force))
    }
}

/// Whether two times are the same to rounding.
fn near(t: f64, other: f64) -> bool {
    (t - other).abs() <= ROUNDINGS * f64::EPSILON * t.abs().max(other.abs())
}
