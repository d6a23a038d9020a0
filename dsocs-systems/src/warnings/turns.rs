//! Detects bodies that rotate too far in a step.

use dsocs_core::AnyNode;

use crate::entry::Method;

/// A step that rotates a body, or turns an angle, by more than this, in rad, is too coarse for the asymptotic order of the error.
pub const LARGE_TURN: f64 = 1.5;

/// The largest rotation in a step, in rad.
const LARGEST_TURN: f64 = 3.0;

/// A rotation in a step that is well resolved, in rad.
pub const RESOLVED_TURN: f64 = 0.5;

/// The fastest rotation of a run.
pub struct Turns {
    /// The index of the first number of each rotation.
    rotations: Box<[usize]>,
    /// The angular speed, in rad/s.
    rate: f64,
    /// The time.
    time: f64,
    /// The index of the first number of the rotation.
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

    /// Looks at a node.
    pub fn look(&mut self, node: &AnyNode<'_>) {
        for &first in &self.rotations {
            let of_body = node.v.get(first + 1..first + 4).unwrap_or(&[]);
            let rate = of_body.iter().map(|w| w * w).sum::<f64>().sqrt();
            if rate > self.rate {
                (self.rate, self.time, self.rotation) = (rate, node.t, first);
            }
        }
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
        let name = name.strip_suffix("_w").unwrap_or(name);
        let (time, shorter) = (self.time, rounded(RESOLVED_TURN / self.rate));
        let reason = if turn < LARGEST_TURN {
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

/// A number rounded down to one digit.
pub fn rounded(x: f64) -> f64 {
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
