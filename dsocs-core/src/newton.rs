//! Newton's iteration: when it has arrived, when it must be slowed down, and when it has failed.

use crate::error::{NewtonFailure, StepFailure};
use crate::unknown::{Linearization, Unknown};

/// An update this small relative to the unknowns is the last: the error after it is its square.
const LAST_UPDATE: f64 = 1e-9;

/// The error that may remain after the last update, relative to the unknowns.
const REMAINDER: f64 = 1e-16;

/// A residual within so many bounds of its rounding error is zero for all that can be told.
const ROUNDINGS: f64 = 4.0;

/// How small a stagnating update must be, in the first iterations, to be suspected of being rounding.
const SUSPECT: f64 = 1e-2;

/// The smallest part of an update that is tried.
const SMALLEST_PART: f64 = 1.0 / (1 << 20) as f64;

/// How often a full update may be taken although no part of it makes the next one smaller.
const PATIENCE: u32 = 3;

/// How Newton's iteration ended with a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stop {
    /// Nothing was solved: the node is the start.
    Start,
    /// The last update was so small that the error after it, of second order, is below rounding.
    Update,
    /// The updates stopped shrinking, and the residual is within the bound of its own rounding error.
    Rounding,
    /// The residual is exactly zero.
    Exact,
}

/// Equations with as many rows as unknowns.
pub(crate) trait Equations {
    /// The unknowns.
    type Z: Unknown<f64>;

    /// The rows and their Jacobian.
    fn linearize(&self, z: &Self::Z) -> Linearization<f64, Self::Z>;

    /// Bounds of the rounding errors in the rows.
    fn rounding(&self, z: &Self::Z) -> Self::Z;
}

/// A root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Root<Z> {
    /// The unknowns.
    pub z: Z,
    /// How often the rows and their Jacobian were evaluated.
    pub evaluations: u32,
    /// How the iteration ended.
    pub stop: Stop,
}

/// The iteration ended without a root here.
pub(crate) struct Failed<Z> {
    /// Why.
    pub reason: StepFailure,
    /// The unknowns.
    pub z: Z,
    /// The rows there.
    pub rows: Z,
}

/// A point of the iteration.
#[derive(Clone, Copy)]
struct Iterate<Z> {
    /// The unknowns.
    z: Z,
    /// The rows.
    rows: Z,
    /// Newton's update from here; zero where the rows are.
    update: Z,
}

/// Newton's iteration for one set of equations.
struct Newton<'a, E: Equations> {
    /// The equations.
    equations: &'a E,
    /// How large each unknown is expected to be, at least.
    size: &'a E::Z,
    /// How often the rows were evaluated.
    evaluations: u32,
}

/// Solves the equations by Newton's iteration from `start`.
///
/// `size` says how large each unknown is expected to be: an update is small or large relative to the unknown, or to
/// `size` where the unknown is smaller. There is no absolute tolerance. `record` is told the relative size of every update.
///
/// With a good start there is one evaluation of the rows: the update is applied, and its size shows that no more is needed.
#[inline]
pub(crate) fn solve<E: Equations>(
    equations: &E,
    start: E::Z,
    size: &E::Z,
    max_iterations: u32,
    record: &mut impl FnMut(f64),
) -> Result<Root<E::Z>, Failed<E::Z>> {
    let mut newton = Newton {
        equations,
        size,
        evaluations: 0,
    };
    let first = newton.evaluate(start)?;
    if newton.is_small(&first, LAST_UPDATE) {
        record(newton.relative(&first.update, &first.z));
        return newton.arrive(&first);
    }
    newton.iterate(first, max_iterations, record)
}

/// Solves equations that failed from `start` once more, to write down the history of the updates.
#[cold]
pub(crate) fn explain<E: Equations>(
    equations: &E,
    start: E::Z,
    size: &E::Z,
    max_iterations: u32,
) -> NewtonFailure {
    let mut updates = Vec::new();
    let result = solve(equations, start, size, max_iterations, &mut |update| {
        updates.push(update)
    });
    let (reason, z, rows) = match result {
        Err(Failed { reason, z, rows }) => (reason, z, rows),
        // the same iteration ends the same way
        Ok(root) => (
            StepFailure::NotConverged,
            root.z,
            equations.linearize(&root.z).rows,
        ),
    };
    NewtonFailure {
        reason,
        unknowns: z.as_ref().to_vec(),
        residual: rows.as_ref().to_vec(),
        updates,
    }
}

impl<E: Equations> Newton<'_, E> {
    /// The rows at `z` and the update from there.
    #[inline]
    fn evaluate(&mut self, z: E::Z) -> Result<Iterate<E::Z>, Failed<E::Z>> {
        self.evaluations += 1;
        let linearization = self.equations.linearize(&z);
        let rows = linearization.rows;
        match linearization.update() {
            Some(update) => Ok(Iterate { z, rows, update }),
            None => Self::without_update(z, &linearization),
        }
    }

    /// What it means that there is no update: a root all the same, a singularity, or no values at all.
    #[cold]
    fn without_update(z: E::Z, at: &Linearization<f64, E::Z>) -> Result<Iterate<E::Z>, Failed<E::Z>> {
        let rows = at.rows;
        let finite = |values: &E::Z| values.as_ref().iter().all(|x| x.is_finite());
        if !finite(&rows) || !at.jacobian.as_ref().iter().all(finite) {
            return Err(Failed {
                reason: StepFailure::NotFinite,
                z,
                rows,
            });
        }
        if rows.as_ref().iter().all(|&row| row == 0.0) {
            return Ok(Iterate {
                z,
                rows,
                update: E::Z::zero(),
            });
        }
        Err(Failed {
            reason: StepFailure::Singular,
            z,
            rows,
        })
    }

    /// Whether an update is at most `tolerance` relative to the unknowns (no division: this is the usual path).
    #[inline]
    fn is_small(&self, at: &Iterate<E::Z>, tolerance: f64) -> bool {
        let sizes = at.z.as_ref().iter().zip(self.size.as_ref());
        at.update
            .as_ref()
            .iter()
            .zip(sizes)
            .all(|(update, (z, size))| update.abs() <= tolerance * z.abs().max(*size))
    }

    /// The size of an update relative to unknowns `z`, or to their expected sizes where these are larger.
    fn relative(&self, update: &E::Z, z: &E::Z) -> f64 {
        let sizes = z.as_ref().iter().zip(self.size.as_ref());
        update
            .as_ref()
            .iter()
            .zip(sizes)
            .fold(0.0, |largest: f64, (update, (z, size))| {
                // no update is a small one, also of an unknown that is zero
                let ratio = if *update == 0.0 {
                    0.0
                } else {
                    update.abs() / z.abs().max(*size)
                };
                largest.max(ratio)
            })
    }

    /// The root after the last update.
    #[inline]
    fn arrive(&self, last: &Iterate<E::Z>) -> Result<Root<E::Z>, Failed<E::Z>> {
        let stop = if last.rows.as_ref().iter().all(|&row| row == 0.0) {
            Stop::Exact
        } else {
            Stop::Update
        };
        let z = last.z.zip(&last.update, |z, update| z + update);
        Ok(Root {
            z,
            evaluations: self.evaluations,
            stop,
        })
    }

    /// The iteration from a point whose update is not small enough to be the last.
    fn iterate(
        mut self,
        first: Iterate<E::Z>,
        max_iterations: u32,
        record: &mut impl FnMut(f64),
    ) -> Result<Root<E::Z>, Failed<E::Z>> {
        let mut now = first;
        let mut size = self.relative(&now.update, &now.z);
        record(size);
        let (mut part, mut patience) = (1.0_f64, PATIENCE);
        let (mut smallest, mut stagnant) = (size, 0);
        for iteration in 1..max_iterations {
            let (next, taken) = self.descend(&now, (8.0 * part).min(1.0), &mut patience)?;
            let (before, last_size) = (now, size);
            (now, part) = (next, taken);
            size = self.relative(&now.update, &now.z);
            record(size);

            if size == 0.0 {
                return self.arrive(&now);
            }
            if size < 0.5 * smallest {
                (smallest, stagnant) = (size, 0);
            } else {
                stagnant += 1;
            }
            if part < 1.0 {
                continue;
            }
            // With quadratic convergence the updates obey ρ' = C ρ², and C ρ'² is what remains after the last.
            let contraction = size / last_size;
            if size <= LAST_UPDATE && size * contraction * contraction <= REMAINDER {
                return self.arrive(&now);
            }
            if contraction >= 0.5 && (size <= SUSPECT || iteration > 2) {
                // a function of the user's may be noisier than the bound knows: give up on noise this small
                let noise = stagnant >= 4 && size <= LAST_UPDATE;
                let at_now = self.roundings(&now);
                if at_now <= ROUNDINGS || noise {
                    let best = if self.roundings(&before) < at_now {
                        before
                    } else {
                        now
                    };
                    return Ok(Root {
                        z: best.z,
                        evaluations: self.evaluations,
                        stop: Stop::Rounding,
                    });
                }
            }
        }
        Err(Failed {
            reason: StepFailure::NotConverged,
            z: now.z,
            rows: now.rows,
        })
    }

    /// Takes the update, or as large a part of it (from `part` down) as makes the next update smaller.
    ///
    /// This is Deuflhard's natural monotonicity test with the new Jacobian. It does not depend on how rows are
    /// scaled, which a test of the residual would.
    fn descend(
        &mut self,
        from: &Iterate<E::Z>,
        mut part: f64,
        patience: &mut u32,
    ) -> Result<(Iterate<E::Z>, f64), Failed<E::Z>> {
        let mut full = None;
        while part >= SMALLEST_PART {
            let trial = self.evaluate(from.z.zip(&from.update, |z, update| z + part * update));
            if let Ok(next) = trial {
                if self.shrinks(from, &next)
                    || self.is_small(&next, LAST_UPDATE)
                    || self.roundings(&next) <= ROUNDINGS
                {
                    return Ok((next, part));
                }
                if full.is_none() {
                    full = Some((next, part));
                }
            } else if part * 0.5 < SMALLEST_PART && full.is_none() {
                return trial.map(|next| (next, part));
            }
            part *= 0.5;
        }
        match full {
            Some(next) if *patience > 0 => {
                *patience -= 1;
                Ok(next)
            }
            _ => Err(Failed {
                reason: StepFailure::NotConverged,
                z: from.z,
                rows: from.rows,
            }),
        }
    }

    /// Whether the update at `to` is smaller than the one at `from`, both relative to the same sizes.
    fn shrinks(&self, from: &Iterate<E::Z>, to: &Iterate<E::Z>) -> bool {
        let (mut before, mut after) = (0.0_f64, 0.0_f64);
        let expected = from
            .z
            .zip(self.size, |z, size| z.abs().max(size))
            .zip(&from.update, |size, x| size.max(x.abs()));
        for (i, &size) in expected.as_ref().iter().enumerate() {
            // an unknown that has no size yet cannot have too large an update
            if size > 0.0 {
                before = before.max(from.update.as_ref()[i].abs() / size);
                after = after.max(to.update.as_ref()[i].abs() / size);
            }
        }
        after < before || after == 0.0
    }

    /// The largest row relative to the bound of its rounding error.
    #[cold]
    fn roundings(&self, at: &Iterate<E::Z>) -> f64 {
        let bounds = self.equations.rounding(&at.z);
        at.rows
            .as_ref()
            .iter()
            .zip(bounds.as_ref())
            .fold(0.0, |largest, (row, bound)| {
                let ratio = if *row == 0.0 { 0.0 } else { row.abs() / bound };
                // a NaN must not pass for zero, nor be forgotten
                if ratio > largest || ratio.is_nan() {
                    ratio
                } else {
                    largest
                }
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One equation for one unknown: value, slope and rounding bound.
    struct Scalar<F: Fn(f64) -> (f64, f64, f64)>(F);

    impl<F: Fn(f64) -> (f64, f64, f64)> Equations for Scalar<F> {
        type Z = [f64; 1];

        fn linearize(&self, z: &[f64; 1]) -> Linearization<f64, [f64; 1]> {
            let (row, slope, _) = (self.0)(z[0]);
            Linearization {
                rows: [row],
                jacobian: [[slope]],
            }
        }

        fn rounding(&self, z: &[f64; 1]) -> [f64; 1] {
            [(self.0)(z[0]).2]
        }
    }

    fn run(
        function: impl Fn(f64) -> (f64, f64, f64),
        start: f64,
        size: f64,
    ) -> Result<Root<[f64; 1]>, StepFailure> {
        solve(&Scalar(function), [start], &[size], 50, &mut |_| {}).map_err(|failed| failed.reason)
    }

    #[test]
    fn a_good_start_costs_one_evaluation() {
        let root = run(
            |x| (x * x - 2.0, 2.0 * x, 1e-15),
            std::f64::consts::SQRT_2 + 1e-10,
            0.0,
        )
        .unwrap();
        assert_eq!((root.evaluations, root.stop), (1, Stop::Update));
        assert!((root.z[0] - std::f64::consts::SQRT_2).abs() < 5e-16);
    }

    #[test]
    fn quadratic_convergence_ends_without_an_evaluation_to_confirm_it() {
        let root = run(|x| (x * x - 2.0, 2.0 * x, 1e-15), 1.5, 0.0).unwrap();
        assert!(root.evaluations <= 4, "{}", root.evaluations);
        assert!((root.z[0] - std::f64::consts::SQRT_2).abs() < 5e-16);
    }

    #[test]
    fn a_wall_is_met_from_any_start() {
        let mut most = 0;
        for stiffness in [1.0, 10.0, 1e3, 1e6] {
            for ratio in [-2.0, -0.999_999, -0.5, 0.0, 1e-9, 0.3, 0.99, 1.0, 1.5] {
                let right = ratio * stiffness;
                for start in [0.0, 1e-8, 0.3, -1.0, 5.0, -20.0, 325.0, -1e3, 1e5, -1e6] {
                    let function = |w: f64| {
                        let tanh = w.tanh();
                        let slope = 1.0 + stiffness * (1.0 - tanh) * (1.0 + tanh);
                        let bound = f64::EPSILON * (w.abs() + stiffness * tanh.abs() + f64::abs(right));
                        (w + stiffness * tanh - right, slope, bound)
                    };
                    let root = run(function, start, 0.0)
                        .unwrap_or_else(|failure| panic!("{failure}: {stiffness} {ratio} {start}"));
                    let (row, slope, bound) = function(root.z[0]);
                    let error = (row / slope).abs();
                    assert!(
                        row.abs() <= 4.0 * bound || error <= 1e-14 * root.z[0].abs(),
                        "{stiffness} {ratio} {start}: {root:?} {row:e}"
                    );
                    most = most.max(root.evaluations);
                }
            }
        }
        println!("at most {most} evaluations");
        assert!(most < 200, "{most}");
    }

    #[test]
    fn a_double_root_is_found_to_half_the_digits_and_said_to_be_rounding() {
        // expanded, so that its rounding is that of terms of order 1
        let root = run(
            |x| (x * x - 2.0 * x + 1.0, 2.0 * x - 2.0, 4.0 * f64::EPSILON),
            3.0,
            0.0,
        )
        .unwrap();
        assert!((root.z[0] - 1.0).abs() < 1e-7, "{root:?}");
        // the rows are exact near the root: linear convergence must go on to the end
        let root = run(
            |x| {
                (
                    (x - 1.0).powi(2),
                    2.0 * (x - 1.0),
                    f64::EPSILON * (x - 1.0).powi(2),
                )
            },
            3.0,
            0.0,
        );
        assert!((root.unwrap().z[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn an_exact_root_is_a_root_although_the_jacobian_is_singular() {
        let root = run(|x| (x * x, 2.0 * x, 0.0), 0.0, 0.0).unwrap();
        assert_eq!((root.z, root.stop), ([0.0], Stop::Exact));
    }

    #[test]
    fn failures_say_why() {
        assert_eq!(
            run(|x| (x * x + 1.0, 2.0 * x, 1e-16), 0.5, 0.0).unwrap_err(),
            StepFailure::NotConverged
        );
        assert_eq!(
            run(|x| (x * x + 1.0, 2.0 * x, 1e-16), 0.0, 0.0).unwrap_err(),
            StepFailure::Singular
        );
        assert_eq!(
            run(|x| (x.sqrt(), 0.5 / x.sqrt(), 1e-16), -1.0, 0.0).unwrap_err(),
            StepFailure::NotFinite
        );
        let failure = explain(&Scalar(|x: f64| (x.exp(), x.exp(), 0.0)), [1.0], &[0.0], 20);
        assert_eq!(
            (failure.reason, failure.updates.len()),
            (StepFailure::NotConverged, 20)
        );
        assert!(failure.residual[0] > 0.0 && failure.unknowns[0] < -10.0);
    }

    #[test]
    fn a_step_out_of_the_domain_is_shortened() {
        // the full update from 3 goes to a negative number, whose logarithm does not exist
        let root = run(|x| (x.ln(), 1.0 / x, 1e-16 * x.ln().abs()), 3.0, 0.0).unwrap();
        assert!((root.z[0] - 1.0).abs() < 1e-15);
    }

    #[test]
    fn noise_is_told_from_failure() {
        // the row's noise of 1e-10 is far above its unit round-off, and the bound knows of it
        let noisy = |x: f64| (x - 1.0 + 1e-10 * (x * 1e13).sin(), 1.0, 1e-10);
        let root = run(noisy, 0.3, 0.0).unwrap();
        assert!((root.z[0] - 1.0).abs() < 1e-9, "{root:?}");
        // the same where the bound does not know of it, as of a function of the user's
        let noisy = |x: f64| (x - 1.0 + 1e-10 * (x * 1e13).sin(), 1.0, 1e-16);
        let root = run(noisy, 0.3, 0.0).unwrap();
        assert!((root.z[0] - 1.0).abs() < 1e-9, "{root:?}");
    }
}
