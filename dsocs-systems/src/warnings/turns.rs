//! Detects bodies and angles that turn too far in a step.
//!
//! A coordinate is an angle if a whole turn changes neither the Lagrangian nor the external forces, and a part of a turn does.

use core::f64::consts::TAU;

use dsocs_core::AnyNode;

use crate::entry::{Method, Row};

use super::is_tested;

/// A step that rotates a body by more than this, in rad, is too coarse for the asymptotic order of the error.
const LARGE_TURN: f64 = 1.5;

/// The largest rotation in a step, in rad.
const LARGEST_TURN: f64 = 3.0;

/// A rotation in a step that is well resolved, in rad.
const RESOLVED_TURN: f64 = 0.5;

/// A part of a turn, in rad: of no other period that an angle may have.
const PART: f64 = 1.0;

/// Relative difference of two values that are equal but for rounding.
const EQUAL: f64 = 1e-9;

/// The fastest rotation of a run.
pub struct Turns {
    /// The index of the first number of each rotation.
    rotations: Box<[usize]>,
    /// The angular speed, in rad/s.
    rate: f64,
    /// The time.
    time: f64,
    /// The index of the first number of the rotation, or that of the angle.
    rotation: usize,
}

impl Turns {
    /// No rotation yet, of bodies whose rotations begin at these indices.
    pub fn of(rotations: &[usize]) -> Self {
        Self {
            rotations: rotations.into(),
            rate: 0.0,
            time: 0.0,
            rotation: rotations.first().copied().unwrap_or(0),
        }
    }

    /// Looks at a node; at angles only at all of the first ones, and then at a window of consecutive ones now and again.
    #[inline]
    pub fn look<'r>(&mut self, node: &AnyNode<'_>, row: &impl Fn() -> Row<'r>) {
        for &first in &self.rotations {
            let of_body = node.v.get(first + 1..first + 4).unwrap_or(&[]);
            let rate = of_body.iter().map(|w| w * w).sum::<f64>().sqrt();
            if rate > self.rate {
                (self.rate, self.time, self.rotation) = (rate, node.t, first);
            }
        }
        if is_tested(node.index) {
            self.look_at_angles(&row());
        }
    }

    #[inline(never)]
    fn look_at_angles(&mut self, row: &Row<'_>) {
        let (node, Some(before)) = (&row.node, row.before) else {
            return;
        };
        let h = (node.t - before.any().t).abs();
        for (i, v) in node.v.iter().enumerate() {
            let rate = v.abs();
            let is_fast = rate > self.rate && rate * h > LARGE_TURN;
            if is_fast && !self.is_of_rotation(i) && is_angle(row, i) {
                (self.rate, self.time, self.rotation) = (rate, node.t, i);
            }
        }
    }

    /// Whether a number is one of a rotation.
    fn is_of_rotation(&self, i: usize) -> bool {
        self.rotations
            .iter()
            .any(|first| (*first..first + 4).contains(&i))
    }

    /// The warning for steps of the length `h`, with the names of the coordinates.
    pub fn note<'n>(
        &self,
        mut names: impl Iterator<Item = &'n str>,
        method: Method,
        h: f64,
    ) -> Option<String> {
        let turn = self.rate * h.abs();
        if matches!(method, Method::Tolerance(_)) || turn < LARGE_TURN {
            return None;
        }
        let name = names.nth(self.rotation).unwrap_or_default();
        let (time, shorter) = (self.time, rounded(RESOLVED_TURN / self.rate));
        let is_angle = !self.is_of_rotation(self.rotation);
        let name = if is_angle {
            name
        } else {
            name.strip_suffix("_w").unwrap_or(name)
        };
        let reason = if is_angle {
            format!(
                "the angle `{name}` turns by {turn:.1} rad in a step at t = {time}: the nodes do not see what depends on it in between"
            )
        } else if turn < LARGEST_TURN {
            format!(
                "`{name}` turns by {turn:.1} rad in a step at t = {time}: such a step is rough, and one of 3 rad is refused"
            )
        } else {
            // the angular velocity is that of the node; the increment of the step was shorter
            format!(
                "`{name}` has the angular velocity {:.3} rad/s at t = {time}, {turn:.1} rad in a step, which is more than the 3 rad that a step can turn by",
                self.rate
            )
        };
        Some(format!(
            "warning: {reason}; take `--step {shorter}` or less, {RESOLVED_TURN} rad a step"
        ))
    }
}

/// Whether a coordinate is an angle that the motion depends on.
fn is_angle(row: &Row<'_>, coordinate: usize) -> bool {
    let (node, declaration) = (&row.node, &row.declaration);
    // at rest nothing shows that a mass depends on the angle
    let v: Vec<f64> = node.v.iter().map(|v| v + 1.0).collect();
    let values = |by: f64| {
        let mut q = node.q.to_vec();
        q[coordinate] += by;
        let mut values = vec![0.0; q.len()];
        declaration.external_forces(node.t, &q, &v, &mut values);
        values.push(declaration.lagrangian(node.t, &q, &v));
        values
    };
    let (here, turned, beside) = (values(0.0), values(TAU), values(PART));
    // a large angle has few digits behind the point
    let equal = EQUAL.max(f64::EPSILON * node.q[coordinate].abs() * 8.0);
    let differs = |(x, y): (&f64, &f64)| (x - y).abs() > equal * x.abs().max(y.abs());
    !here.iter().zip(&turned).any(differs) && here.iter().zip(&beside).any(differs)
}

/// A number rounded down to one digit.
fn rounded(x: f64) -> f64 {
    let unit = 10_f64.powf(x.log10().floor());
    // the nearest number to this decimal
    format!("{:e}", (x / unit).floor() * unit).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_turn_far_are_told_with_a_shorter_one() {
        let turns = Turns {
            rate: 20.0,
            time: 0.5,
            ..Turns::of(&[1])
        };
        let note = |method, h| turns.note(["x", "r_w", "r_x", "r_y", "r_z"].into_iter(), method, h);
        let warning = note(Method::Step, -0.1).unwrap();
        assert!(
            warning.contains("`r` turns by 2.0 rad in a step at t = 0.5")
                && warning.contains("`--step 0.02`"),
            "{warning}"
        );
        let beyond = note(Method::Step, 0.2).unwrap();
        assert!(
            beyond.contains("20.000 rad/s at t = 0.5, 4.0 rad in a step, which is more than the 3 rad")
                && !beyond.contains("refused"),
            "{beyond}"
        );
        assert_eq!(note(Method::Step, 0.07), None);
        assert_eq!(note(Method::Tolerance(1e-9), 0.1), None);
    }

    #[test]
    fn a_step_is_rounded_to_one_digit() {
        assert!(
            [(0.025, 0.02), (0.099, 0.09), (3.4, 3.0), (1e-7, 1e-7)]
                .into_iter()
                .all(|(x, rounded)| (super::rounded(x) / rounded - 1.0).abs() < 1e-15)
        );
    }
}
