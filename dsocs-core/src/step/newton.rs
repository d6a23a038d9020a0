//! Newton's iteration: when it has arrived, when it must be slowed down, and when it has failed.

use core::cmp::Ordering;

use crate::error::{NewtonFailure, StepFailure};
use crate::step::unknown::{Linearization, Unknown};

/// An update this small relative to the unknowns is the last: the error after it is its square.
pub(crate) const LAST_UPDATE: f64 = 1e-9;

/// The error that may remain after the last update, relative to the unknowns.
const REMAINDER: f64 = 1e-16;

/// A residual within so many bounds of its rounding error is zero for all that can be told.
const ROUNDINGS: f64 = 4.0;

/// An update `ρ'` of at most the first size is the last if the update `ρ` before it was larger than the second size:
/// what remains is `C ρ'² = ρ'³/ρ²`, and that is at most [`REMAINDER`].
pub(crate) const SETTLED: [(f64, f64); 3] = [(1e-10, 1e-7), (4e-12, LAST_UPDATE), (LAST_UPDATE, 3.2e-6)];

/// An update that is this part of the one before shows that the iteration converges fast.
pub(crate) const MUCH_SMALLER: f64 = 0.25;

/// How small a stagnating update must be, in the first iterations, to be suspected of being rounding.
const SUSPECT: f64 = 1e-2;

/// The smallest part of an update that is tried.
const SMALLEST_PART: f64 = 1.0 / (1 << 20) as f64;

/// Another root is close if it is nearer than the unknown is large, over this.
const CLOSE: f64 = 0.5;

/// Where the rows bend less than this on the way to a root (see [`Root::bend`]), no other root is in question.
pub(crate) const BENT: f64 = 1e-4;

/// How far an unknown is moved, relative to itself, to see whether the rows depend on it.
const NEARBY: f64 = 1e-3;

/// How often a full update may be taken although no part of it makes the next one smaller.
const PATIENCE: u32 = 3;

/// How Newton's iteration ended with a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stop {
    /// Nothing was solved: the node is the start.
    Start,
    /// The last update was so small that the error after it, of second order, is below rounding; or the rows are
    /// affine, and one update is all there is to do.
    Update,
    /// The updates stopped shrinking, and the residual is within the bound of its own rounding error.
    Rounding,
    /// The residual is exactly zero where the updates did not become small as fast as they should.
    Exact,
}

/// Equations with as many rows as unknowns.
pub(crate) trait Equations {
    /// The unknowns.
    type Z: Unknown<f64>;

    /// Whether the rows are affine in the unknowns.
    const LINEAR: bool = false;

    /// Whether roots are watched for others nearby.
    const WATCHED: bool = false;

    /// Whether they are watched also where the others would not be close.
    fn watchful(&self) -> bool {
        false
    }

    /// The rows and their Jacobian.
    fn linearize(&self, z: &Self::Z) -> Linearization<f64, Self::Z>;

    /// Whether what the declared rows were multiplied by is anything but zero at `z`, by comparison with a point
    /// `nearby`: a root where it is zero is none of the declared rows.
    fn is_declared(&self, z: &Self::Z, nearby: &Self::Z) -> bool {
        let _ = (z, nearby);
        true
    }

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
    /// The second update over the first, both relative to the unknowns: how much the rows bend on the way to the root, and
    /// so about how far away the root is in units of the distance to another one. Zero where one or two evaluations were
    /// enough.
    pub bend: f64,
    /// Whether another root would then be no farther away than a few times the size of the unknowns.
    pub close: bool,
}

/// The iteration ended without a root here.
pub(crate) struct Failed<Z> {
    /// Why.
    pub reason: StepFailure,
    /// The unknowns.
    pub z: Z,
    /// The rows there.
    pub rows: Z,
    /// How often the rows and their Jacobian were evaluated.
    pub evaluations: u32,
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

/// A point of the iteration, or why there is none.
type Evaluated<Z> = Result<Iterate<Z>, Failed<Z>>;

/// The next point of the iteration, and the part of the update that led there.
type Descent<Z> = (Iterate<Z>, f64);

/// Newton's iteration for one set of equations.
struct Newton<'a, E: Equations> {
    /// The equations.
    equations: &'a E,
    /// How large each unknown is expected to be, at least.
    size: &'a E::Z,
    /// How often the rows were evaluated.
    evaluations: u32,
    /// Evaluations that need not be made again.
    made: &'a [Trial<E::Z>],
}

/// An evaluation of the rows whose update nobody has looked at yet.
#[derive(Clone, Copy)]
struct Trial<Z> {
    /// The point, with its update where the iteration may use it.
    at: Iterate<Z>,
    /// Whether the update is what Newton's iteration asks for, if it is finite.
    safe: bool,
}

impl<Z: Unknown<f64>> Trial<Z> {
    #[inline]
    fn new<E: Equations<Z = Z>>(equations: &E, z: Z) -> Self {
        let linearization = equations.linearize(&z);
        let rows = linearization.rows;
        let (update, safe) = if E::LINEAR {
            // the only update has to be a good one
            let update = linearization.update();
            (update.unwrap_or(rows), update.is_some())
        } else {
            linearization.quick_update()
        };
        Self {
            at: Iterate { z, rows, update },
            safe,
        }
    }

    /// Whether the update is at most `tolerance` relative to the unknowns; an infinite or undefined one is not.
    #[inline]
    fn is_small(&self, size: &Z, tolerance: f64) -> bool {
        self.safe && is_small(&self.at, size, tolerance)
    }

    /// Whether the update is the last, after that of `before`.
    #[inline]
    fn settles(&self, before: &Self, size: &Z) -> bool {
        before.safe && self.safe && settles(&before.at, &self.at, size)
    }

    /// Whether affine rows are solved by the update.
    #[inline]
    fn is_solution(&self) -> bool {
        self.safe && self.at.update.as_ref().iter().all(|update| update.is_finite())
    }

    /// Where the update leads.
    #[inline]
    fn next(&self) -> Z {
        self.at.z.zip(&self.at.update, |z, update| z + update)
    }
}

/// Solves the equations by Newton's iteration from `start`.
///
/// `size` says how large each unknown is expected to be: an update is small or large relative to the unknown,
/// or to `size` where the unknown is smaller. There is no absolute tolerance. `record` is told the relative
/// size of every update, but for iterations that end with one of the first three.
///
/// With a good start there is one evaluation of the rows: the update is applied, and its size shows that no
/// more is needed. Up to three evaluations are the usual case, and stand here by themselves: whatever is odd fails
/// to be small, and is left to the iteration that looks at everything.
#[inline]
pub(crate) fn solve<E: Equations>(
    equations: &E,
    start: E::Z,
    size: &E::Z,
    max_iterations: u32,
    record: &mut impl FnMut(f64),
) -> Result<Root<E::Z>, Failed<E::Z>> {
    let first = Trial::new(equations, start);
    if E::LINEAR {
        if first.is_solution() && is_declared(equations, &first.next(), size) {
            return Ok(arrived(&first, 1));
        }
    } else if first.is_small(size, LAST_UPDATE) && is_declared(equations, &start, size) {
        return Ok(arrived(&first, 1));
    }
    let second = Trial::new(equations, first.next());
    // the first point is a point nearby for which there is nothing left to compute
    let declared = |z, nearby| equations.is_declared(z, nearby) || is_declared(equations, z, size);
    if second.settles(&first, size) && declared(&second.at.z, &first.at.z) {
        return Ok(arrived(&second, 2));
    }
    let third = Trial::new(equations, second.next());
    if third.settles(&second, size) && declared(&third.at.z, &second.at.z) && max_iterations > 2 {
        return Ok(watched(equations, [&first, &second], size, arrived(&third, 3)));
    }
    go_on(equations, &[first, second, third], size, max_iterations, record)
}

/// The iteration after three evaluations that did not end it.
#[inline(never)]
fn go_on<E: Equations>(
    equations: &E,
    made: &[Trial<E::Z>],
    size: &E::Z,
    max_iterations: u32,
    record: &mut impl FnMut(f64),
) -> Result<Root<E::Z>, Failed<E::Z>> {
    let newton = Newton {
        equations,
        size,
        evaluations: 3,
        made,
    };
    let root = newton.look(made[0].at.z, max_iterations, record)?;
    if is_declared(equations, &root.z, size) {
        return Ok(bent([&made[0], &made[1]], size, root));
    }
    Err(Failed {
        reason: StepFailure::Degenerate,
        z: root.z,
        rows: equations.linearize(&root.z).rows,
        evaluations: root.evaluations,
    })
}

/// Tells how the rows bend on the way to a root, if anybody wants to know, or another root may be close.
#[inline]
fn watched<E: Equations>(
    equations: &E,
    [first, second]: [&Trial<E::Z>; 2],
    size: &E::Z,
    root: Root<E::Z>,
) -> Root<E::Z> {
    // without divisions, and for the worst pair of components: this is a usual path
    let (mut before, mut after, mut smallest, mut largest) = (0.0_f64, 0.0_f64, f64::INFINITY, 0.0_f64);
    let updates = first.at.update.as_ref().iter().zip(second.at.update.as_ref());
    let sizes = second.at.z.as_ref().iter().zip(size.as_ref());
    for ((first, second), (z, size)) in updates.zip(sizes) {
        let size = z.abs().max(*size);
        (before, after) = (before.max(first.abs()), after.max(second.abs()));
        (smallest, largest) = (smallest.min(size), largest.max(size));
    }
    let close = after * (largest * largest) >= CLOSE * (before * before) * smallest;
    let straight = after * largest < BENT * before * smallest;
    if E::WATCHED && !straight && (equations.watchful() || close) {
        bent([first, second], size, root)
    } else {
        root
    }
}

/// The root with what the first two updates tell of it.
#[cold]
fn bent<Z: Unknown<f64>>([first, second]: [&Trial<Z>; 2], size: &Z, root: Root<Z>) -> Root<Z> {
    let [before, after] = [first, second].map(|trial| relative(&trial.at.update, &trial.at.z, size));
    // close also where nothing is known
    let far = matches!(
        after.partial_cmp(&(CLOSE * before * before)),
        Some(Ordering::Less)
    );
    Root {
        bend: after / before,
        close: !far,
        ..root
    }
}

/// Whether a root at `z` is one of the declared rows, by comparison with a point as near as the last update leads.
#[inline]
fn is_declared<E: Equations>(equations: &E, z: &E::Z, size: &E::Z) -> bool {
    let nearby = z.zip(size, |z, size| z + LAST_UPDATE * z.abs().max(size));
    equations.is_declared(z, &nearby)
}

/// The root that an update leads to.
#[inline]
fn arrived<Z: Unknown<f64>>(last: &Trial<Z>, evaluations: u32) -> Root<Z> {
    Root {
        z: last.next(),
        evaluations,
        stop: Stop::Update,
        bend: 0.0,
        close: false,
    }
}

/// Whether the update at `now` is the last, after the full one at `before` (see [`SETTLED`]).
#[inline]
fn settles<Z: Unknown<f64>>(before: &Iterate<Z>, now: &Iterate<Z>, size: &Z) -> bool {
    let settled = |(largest, smallest)| is_small(now, size, largest) && !is_small(before, size, smallest);
    SETTLED.into_iter().any(settled)
}

/// Whether an update is at most `tolerance` relative to the unknowns (no division: this is the usual path).
#[inline]
fn is_small<Z: Unknown<f64>>(at: &Iterate<Z>, size: &Z, tolerance: f64) -> bool {
    let sizes = at.z.as_ref().iter().zip(size.as_ref());
    at.update
        .as_ref()
        .iter()
        .zip(sizes)
        .all(|(update, (z, size))| update.abs() <= tolerance * z.abs().max(*size))
}

/// The size of an update relative to unknowns `z`, or to their expected sizes where these are larger.
#[inline]
pub(crate) fn relative<Z: Unknown<f64>>(update: &Z, z: &Z, size: &Z) -> f64 {
    let sizes = z.as_ref().iter().zip(size.as_ref());
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

/// What remains after the later of two full updates, relative to the unknowns: with quadratic convergence the
/// updates obey `ρ' = C ρ²`, and `C ρ'²` is what is left.
#[inline]
fn remainder(before: f64, after: f64) -> f64 {
    let contraction = after / before;
    after * contraction * contraction
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
        updates.push(update);
    });
    let (reason, z, rows) = match result {
        Err(Failed { reason, z, rows, .. }) => (reason, z, rows),
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
        other: Vec::new(),
    }
}

impl<E: Equations> Newton<'_, E> {
    /// The rows at `z` and the update from there.
    fn evaluate(&mut self, z: E::Z) -> Evaluated<E::Z> {
        let here = |trial: &&Trial<E::Z>| trial.at.z.as_ref() == z.as_ref() && trial.is_solution();
        if let Some(trial) = self.made.iter().find(here) {
            return Ok(trial.at);
        }
        self.evaluations += 1;
        let linearization = self.equations.linearize(&z);
        let rows = linearization.rows;
        match linearization.update() {
            Some(update) => Ok(Iterate { z, rows, update }),
            None => self.without_update(z, &linearization),
        }
    }

    /// What it means that there is no update: a root all the same, a singularity, or no values at all.
    #[cold]
    fn without_update(&self, z: E::Z, at: &Linearization<f64, E::Z>) -> Evaluated<E::Z> {
        let rows = at.rows;
        let finite = |values: &E::Z| values.as_ref().iter().all(|x| x.is_finite());
        if !finite(&rows) || !at.jacobian.as_ref().iter().all(finite) {
            return Err(Failed {
                reason: StepFailure::NotFinite,
                z,
                rows,
                evaluations: self.evaluations,
            });
        }
        let is_zero = |rows: &E::Z| rows.as_ref().iter().all(|&row| row == 0.0);
        // a double root is one; rows that stay zero when an unknown is moved say nothing of that unknown
        let determined = |place: usize| {
            let mut moved = z;
            let (unknown, size) = (moved.as_mut(), self.size.as_ref());
            let length = unknown[place].abs().max(size[place]);
            unknown[place] += if length > 0.0 { NEARBY * length } else { NEARBY };
            !is_zero(&self.equations.linearize(&moved).rows)
        };
        if is_zero(&rows) && (0..z.as_ref().len()).all(determined) {
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
            evaluations: self.evaluations,
        })
    }

    /// The root after the last update.
    #[inline]
    fn arrive(&self, last: &Iterate<E::Z>) -> Root<E::Z> {
        let stop = if last.rows.as_ref().iter().all(|&row| row == 0.0) {
            Stop::Exact
        } else {
            Stop::Update
        };
        let z = last.z.zip(&last.update, |z, update| z + update);
        Root {
            z,
            evaluations: self.evaluations,
            stop,
            bend: 0.0,
            close: false,
        }
    }

    /// The point that the full update leads to.
    #[inline]
    fn full_step(&mut self, from: &Iterate<E::Z>) -> Evaluated<E::Z> {
        self.evaluate(from.z.zip(&from.update, |z, update| z + update))
    }

    /// Full updates from `start`, as long as each is much smaller than the one before: nothing else needs to be looked
    /// at.
    fn look(
        mut self,
        start: E::Z,
        max_iterations: u32,
        record: &mut impl FnMut(f64),
    ) -> Result<Root<E::Z>, Failed<E::Z>> {
        let mut now = self.evaluate(start)?;
        let mut size = relative(&now.update, &now.z, self.size);
        record(size);
        if is_small(&now, self.size, LAST_UPDATE) || E::LINEAR {
            return Ok(self.arrive(&now));
        }
        let mut next = self.full_step(&now);
        loop {
            let Ok(at) = &next else {
                return self.iterate(now, size, next, max_iterations, record);
            };
            let next_size = relative(&at.update, &at.z, self.size);
            if settles(&now, at, self.size) {
                record(next_size);
                let stop = Stop::Update;
                return Ok(Root {
                    stop,
                    ..self.arrive(at)
                });
            }
            let converges = next_size < MUCH_SMALLER * size;
            if !converges || self.evaluations >= max_iterations {
                return self.iterate(now, size, next, max_iterations, record);
            }
            record(next_size);
            (now, size) = (*at, next_size);
            next = self.full_step(&now);
        }
    }

    /// The iteration from a point whose update is not small enough to be the last; the point that it leads to
    /// has been evaluated.
    #[inline(never)]
    fn iterate(
        mut self,
        mut now: Iterate<E::Z>,
        mut size: f64,
        next: Evaluated<E::Z>,
        max_iterations: u32,
        record: &mut impl FnMut(f64),
    ) -> Result<Root<E::Z>, Failed<E::Z>> {
        let (mut part, mut patience) = (1.0_f64, PATIENCE);
        let (mut smallest, mut stagnant) = (size, 0);
        let mut evaluated = Some(next);
        for iteration in self.evaluations.saturating_sub(1)..max_iterations {
            let (next, taken) = self.descend(&now, evaluated.take(), (8.0 * part).min(1.0), &mut patience)?;
            let (before, last_size) = (now, size);
            (now, part) = (next, taken);
            size = relative(&now.update, &now.z, self.size);
            record(size);

            if size == 0.0 {
                return Ok(self.arrive(&now));
            }
            if size < 0.5 * smallest {
                (smallest, stagnant) = (size, 0);
            } else {
                stagnant += 1;
            }
            if part < 1.0 {
                continue;
            }
            if size <= LAST_UPDATE && remainder(last_size, size) <= REMAINDER {
                return Ok(self.arrive(&now));
            }
            if size >= 0.5 * last_size && (size <= SUSPECT || iteration > 2) {
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
                        bend: 0.0,
                        close: false,
                    });
                }
            }
        }
        Err(Failed {
            reason: StepFailure::NotConverged,
            z: now.z,
            rows: now.rows,
            evaluations: self.evaluations,
        })
    }

    /// Takes the update, or as large a part of it (from `part` down) as makes the next update smaller. The
    /// first part may have been evaluated already.
    ///
    /// This is Deuflhard's natural monotonicity test with the new Jacobian. It does not depend on how rows are
    /// scaled, which a test of the residual would.
    fn descend(
        &mut self,
        from: &Iterate<E::Z>,
        mut evaluated: Option<Evaluated<E::Z>>,
        mut part: f64,
        patience: &mut u32,
    ) -> Result<Descent<E::Z>, Failed<E::Z>> {
        let mut full = None;
        while part >= SMALLEST_PART {
            let trial = match evaluated.take() {
                Some(trial) => trial,
                None => self.evaluate(from.z.zip(&from.update, |z, update| z + part * update)),
            };
            if let Ok(next) = trial {
                if self.shrinks(from, &next)
                    || is_small(&next, self.size, LAST_UPDATE)
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
                evaluations: self.evaluations,
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

mod homotopy;
mod pair;
pub(crate) use homotopy::follow;
pub(crate) use pair::{nearby, orientation, other_root};
#[cfg(test)]
mod tests;
