//! Newton's iteration: when it has converged, when its updates must be shortened, and when it has failed.

// vectors stand in the results themselves, so that nothing is allocated
#![allow(clippy::result_large_err)]

use core::cmp::Ordering;

use super::convergence::{
    LAST_UPDATE, NaturalSizes, Progress, ROUNDINGS, StagnationCause, Update, converges, is_last,
};
use super::elimination::Determinant;
use crate::solve::dense::Matrix;
use crate::solve::dense::null_directions;
use crate::solve::failure::{NewtonFailure, StepFailure};
use crate::solve::{Square, Vector, is_finite};

/// The unit round-off, `2⁻⁵³`.
const UNIT: f64 = f64::EPSILON / 2.0;

/// The smallest part of an update that is tried in the line search.
const SMALLEST_PART: f64 = 1.0 / (1 << 20) as f64;

/// Another root is close if its distance is less than the size of the unknown divided by this.
pub(crate) const CLOSE: f64 = 0.5;

/// If the rows bend less than this on the way to a root (see [`Root::bend`]), no other root is possible
/// nearby.
pub(crate) const BENT: f64 = 1e-4;

/// Relative change of the unknowns by which it is tested whether the rows depend on them.
const NEARBY: f64 = 1e-3;

/// A row does not depend on a null direction of the Jacobian if, along it, it stays below this many bounds of
/// its rounding error.
const LEFT: f64 = 64.0;

/// Largest number of evaluations in a step whose updates each shrink fast: longer iterations are left to
/// [`solve`].
const QUICK: u32 = 7;

/// Largest number of full updates in an iteration that are taken although no part of them makes the next
/// update smaller.
const PATIENCE: u32 = 3;

/// The stop rule that ended Newton's iteration at a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stop {
    /// No iteration: the node is the start.
    Start,
    /// The last update was so small that the error after it, which is quadratic in the update, is below rounding. Or the rows are
    /// affine, and one update solves them.
    Update,
    /// The updates stopped shrinking, and the residual is within the bound of its own rounding error.
    Rounding,
    /// The residual is exactly zero, although the updates did not decrease as fast as expected.
    Exact,
    /// The rows have no root: they change sign in a jump, as with dry friction where the next velocity would
    /// have the other sign on either side. The node is that of the jump; or a body comes to rest with the
    /// next leg, and then a value of the function between those of its two sides, such as `0.3` for `signum`,
    /// solves the rows. If several of the user's functions jump in one step, each has the value on a path
    /// that goes straight on. [`Unresolved`](crate::Unresolved) counts these steps.
    Jump,
    /// A body rests where a function jumps, such as a mass that dry friction holds, and has rested on the leg
    /// before. The value of the function between those of its two sides solves the rows.
    /// [`Unresolved`](crate::Unresolved) does not count these steps.
    Sticks,
}

/// Equations with as many rows as unknowns, on slices: for code that is compiled once for all systems.
pub(crate) trait Equations {
    /// Whether the rows are affine in the unknowns, between their jumps if they have any.
    fn are_affine(&self) -> bool {
        false
    }

    /// Whether the rows may jump where an unknown changes.
    fn may_jump(&self) -> bool {
        false
    }

    /// Whether the iteration to a root is watched for a second root nearby.
    fn are_watched(&self) -> bool {
        false
    }

    /// Whether it is watched also for roots that would not be close.
    fn past_is_short(&self) -> bool {
        false
    }

    /// The rows and their Jacobian.
    fn linearize(&self, z: &[f64]) -> Linearized;

    /// The rows and Newton's update by sparse elimination; `None` if the Jacobian is dense or the update
    /// inaccurate.
    fn sparse_update(&self, z: &Vector) -> Option<Evaluation<Vector>> {
        let _ = z;
        None
    }

    /// Whether the factor by which a declared row was multiplied is nonzero at `z`, compared with its value
    /// at a point `nearby`. If it is zero, `z` is no root of the declared rows.
    fn is_declared(&self, z: &[f64], nearby: &[f64]) -> bool {
        let _ = (z, nearby);
        true
    }

    /// Bounds of the rounding errors of the rows.
    fn rounding(&self, z: &[f64]) -> Vector;
}

/// The rows of equations at a point, and their Jacobian.
#[derive(Clone, Debug)]
pub(crate) struct Linearized {
    /// The rows.
    pub rows: Vector,
    /// `∂row/∂z`.
    pub jacobian: Square,
}

impl Linearized {
    /// Newton's update; `None` if it is not finite.
    pub fn update(&self) -> Option<Vector> {
        self.jacobian.solve(&self.rows.map(|row| -row))
    }

    /// The rows and the update, unchecked; for linear equations, where one update is the solution, an
    /// accurate one.
    fn evaluation(self, z: Vector, are_linear: bool) -> Evaluation<Vector> {
        let Self { rows, mut jacobian } = self;
        if are_linear {
            let update = jacobian.solve(&rows.map(|row| -row));
            let safe = update.is_some();
            let update = update.unwrap_or_else(|| rows.clone());
            return Evaluation {
                at: Iterate { z, rows, update },
                safe,
                determinant: Determinant::UNKNOWN,
            };
        }
        // the sign changes last, where it becomes part of the sum with the unknowns
        let mut update = rows.clone();
        let (safe, determinant) = jacobian.solve_quick(&mut update);
        let update = update.map(|x| -x);
        Evaluation {
            at: Iterate { z, rows, update },
            safe,
            determinant,
        }
    }
}

/// Vectors of unknowns: arrays in smooth steps, [`Vector`] elsewhere.
pub(crate) trait Components<T: Copy = f64>: Clone + AsRef<[T]> + AsMut<[T]> {
    /// A function of the components of two vectors, one by one.
    #[inline(always)]
    #[allow(clippy::inline_always)] // part of every step
    fn with(&self, other: &Self, function: impl Fn(T, T) -> T) -> Self {
        let mut result = self.clone();
        for (x, y) in result.as_mut().iter_mut().zip(other.as_ref()) {
            *x = function(*x, *y);
        }
        result
    }
}

impl<T: Copy, Z: Clone + AsRef<[T]> + AsMut<[T]>> Components<T> for Z {}

/// The equations in the first three iterations, which are part of every step.
pub(crate) trait Quick {
    /// The unknowns.
    type Z: Components;

    /// Whether the rows are affine in the unknowns everywhere: one update solves them.
    fn are_linear(&self) -> bool;

    /// See [`Equations::are_watched`].
    fn are_watched(&self) -> bool;

    /// See [`Equations::past_is_short`].
    fn past_is_short(&self) -> bool;

    /// The rows and Newton's update.
    fn evaluate(&self, z: Self::Z) -> Evaluation<Self::Z>;

    /// See [`Equations::is_declared`].
    fn is_declared(&self, z: &Self::Z, nearby: &Self::Z) -> bool;
}

impl Quick for dyn Equations + '_ {
    type Z = Vector;

    fn are_linear(&self) -> bool {
        self.are_affine() && !self.may_jump()
    }

    fn are_watched(&self) -> bool {
        Equations::are_watched(self)
    }

    fn past_is_short(&self) -> bool {
        Equations::past_is_short(self)
    }

    fn evaluate(&self, z: Vector) -> Evaluation<Vector> {
        match self.sparse_update(&z) {
            Some(evaluation) => evaluation,
            None => self.linearize(&z).evaluation(z, self.are_linear()),
        }
    }

    fn is_declared(&self, z: &Vector, nearby: &Vector) -> bool {
        Equations::is_declared(self, z, nearby)
    }
}

/// Records of an iteration: the sizes of its updates and the natural sizes of the unknowns.
pub(crate) trait IterationRecord {
    /// Records the size of an update relative to the unknowns; not called if one of the first three updates
    /// is the last.
    fn update(&mut self, size: f64) {
        let _ = size;
    }

    /// Records the natural sizes of the unknowns, if they were needed.
    fn natural_sizes(&mut self, sizes: &NaturalSizes) {
        let _ = sizes;
    }
}

/// Records nothing.
impl IterationRecord for () {}

/// Records the sizes of the updates.
impl IterationRecord for Vec<f64> {
    fn update(&mut self, size: f64) {
        self.push(size);
    }
}

/// A root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Root<Z> {
    /// The unknowns.
    pub z: Z,
    /// Number of evaluations of the rows and their Jacobian.
    pub evaluations: u32,
    /// The stop rule that ended the iteration.
    pub stop: Stop,
    /// The second update over the first, both relative to the unknowns: a measure of the rows' curvature, and
    /// so about the ratio of the distance of the guess to that of another root. Zero if one or two
    /// evaluations were enough.
    pub bend: f64,
    /// Whether such a root would be no farther away than a few times the size of the unknowns.
    pub close: bool,
    /// The determinant of the Jacobian from which the last update came, if it is known.
    pub determinant: Determinant,
}

/// An iteration that ended without a root.
pub(crate) struct FailedIteration {
    /// The reason.
    pub reason: StepFailure,
    /// The last unknowns.
    pub z: Vector,
    /// The rows there.
    pub rows: Vector,
    /// Number of evaluations of the rows and their Jacobian.
    pub evaluations: u32,
}

/// A point of the iteration.
#[derive(Clone)]
pub(crate) struct Iterate<Z> {
    /// The unknowns.
    pub z: Z,
    /// The rows.
    pub rows: Z,
    /// Newton's update from here; zero where the rows are.
    pub update: Z,
}

impl<Z> Iterate<Z> {
    /// The update, to be compared with the expected sizes of the unknowns.
    #[inline]
    fn update<'a>(&'a self, sizes: &'a Z) -> Update<'a, Z> {
        Update {
            components: &self.update,
            unknowns: &self.z,
            sizes,
        }
    }
}

/// A point of the iteration, or the reason why there is none.
type Evaluated = Result<Iterate<Vector>, FailedIteration>;

/// The next point of the iteration, and the part of the update that led there.
type Descent = (Iterate<Vector>, f64);

/// Newton's iteration for one set of equations.
struct Newton<'a> {
    /// The equations.
    equations: &'a dyn Equations,
    /// The expected size of each unknown, at least.
    size: Vector,
    /// The natural sizes, where they are known.
    natural: Option<Vector>,
    /// Number of evaluations of the rows.
    evaluations: u32,
    /// Evaluations that were made before and are reused.
    made: &'a [Evaluation<Vector>],
}

/// An evaluation of the rows whose update has not been checked yet.
#[derive(Clone)]
pub(crate) struct Evaluation<Z> {
    /// The point, with its update where the iteration may use it.
    pub at: Iterate<Z>,
    /// Whether the update, if finite, is Newton's, unharmed by overflow or underflow.
    pub safe: bool,
    /// The determinant of the Jacobian.
    pub determinant: Determinant,
}

impl<Z: Components> Evaluation<Z> {
    /// Whether the update is at most `tolerance` relative to the unknowns; an infinite or undefined one is not.
    #[inline]
    fn is_small(&self, size: &Z, tolerance: f64) -> bool {
        self.safe && self.at.update(size).is_small(tolerance)
    }

    /// Whether the update is the last, after that of `before`. Inlined: a call would write both evaluations
    /// to memory in every step that takes two.
    #[inline(always)]
    #[allow(clippy::inline_always)] // saves a write to memory per step
    fn settles(&self, before: &Self, size: &Z) -> bool {
        before.safe && self.safe && self.at.update(size).settles(&before.at.update(size))
    }

    /// Whether the update solves affine rows: whether it is safe and finite.
    #[inline]
    fn is_solution(&self) -> bool {
        self.safe && self.at.update.as_ref().iter().all(|update| update.is_finite())
    }

    /// The point that the update leads to.
    #[inline]
    fn next(&self) -> Z {
        self.at.z.with(&self.at.update, |z, update| z + update)
    }
}

/// Newton's iteration from `start` with full updates, or its first three evaluations if full updates do not
/// shrink fast.
///
/// `size` is the expected size of each unknown: an update is measured relative to the unknown, or to `size`
/// where the unknown is smaller. There is no absolute tolerance.
///
/// With a good start there is one evaluation of the rows: the update is applied, and its size shows that no
/// more is needed. Usually there are at most three, in long steps up to [`QUICK`]. All unusual cases fail to
/// have a small update and are left to [`solve`], which makes every check.
#[inline(always)]
#[allow(clippy::inline_always)] // part of every step
pub(crate) fn quick<E: Quick + ?Sized>(
    equations: &E,
    start: E::Z,
    size: &E::Z,
    max_iterations: u32,
) -> Result<Root<E::Z>, [Evaluation<E::Z>; 3]> {
    let first = equations.evaluate(start);
    if equations.are_linear() {
        if first.is_solution() && is_declared(equations, &first.next(), size) {
            return Ok(arrived(&first, 1));
        }
    } else if first.is_small(size, LAST_UPDATE) && is_declared(equations, &first.at.z, size) {
        return Ok(arrived(&first, 1));
    }
    let second = equations.evaluate(first.next());
    // the first point was evaluated already: as the point nearby it costs nothing
    let declared =
        |z: &E::Z, nearby: &E::Z| equations.is_declared(z, nearby) || is_declared(equations, z, size);
    if second.settles(&first, size) && declared(&second.at.z, &first.at.z) {
        return Ok(arrived(&second, 2));
    }
    let (mut last, mut third) = (second.clone(), None);
    for evaluations in 3..=QUICK {
        let next = equations.evaluate(last.next());
        let before = core::mem::replace(&mut last, next);
        if last.settles(&before, size) && declared(&last.at.z, &before.at.z) && max_iterations >= evaluations
        {
            return Ok(watched(
                equations,
                [&first, &second],
                size,
                arrived(&last, evaluations),
            ));
        }
        if third.is_none() {
            third = Some(last.clone());
        }
        let shrinks = before.safe
            && last.safe
            && shrinks(
                [before.at.update.as_ref(), last.at.update.as_ref()],
                [before.at.z.as_ref(), last.at.z.as_ref()],
                size.as_ref(),
            );
        if !shrinks {
            break;
        }
    }
    let third = third.unwrap_or(last);
    Err([first, second, third])
}

/// Whether the later of two updates is so much smaller that the iteration may go on with full updates.
#[cold]
fn shrinks(updates: [&[f64]; 2], at: [&[f64]; 2], size: &[f64]) -> bool {
    let [before, last] = [0, 1].map(|k| relative(updates[k], at[k], size));
    converges(before, last)
}

/// Solves the equations by Newton's iteration from `start`, with sizes as in [`quick`]. `record` records the
/// updates.
pub(crate) fn solve(
    equations: &dyn Equations,
    start: &Vector,
    size: &Vector,
    max_iterations: u32,
    record: &mut dyn IterationRecord,
) -> Result<Root<Vector>, FailedIteration> {
    match quick(equations, start.clone(), size, max_iterations) {
        Ok(root) => Ok(root),
        Err(made) => go_on(equations, &made, size, max_iterations, record),
    }
}

/// Continues the iteration after three evaluations that did not end it.
#[inline(never)]
fn go_on(
    equations: &dyn Equations,
    made: &[Evaluation<Vector>; 3],
    size: &Vector,
    max_iterations: u32,
    record: &mut dyn IterationRecord,
) -> Result<Root<Vector>, FailedIteration> {
    if let (true, [_, second, third]) = (equations.may_jump(), made) {
        if equations.are_affine() && third.is_solution() {
            return jump::between_pieces(equations, [second, third], size);
        }
        if let Some(root) = jump::between(equations, [&second.at, &third.at], size) {
            return Ok(root);
        }
    }
    let newton = Newton {
        equations,
        size: size.clone(),
        natural: None,
        evaluations: 3,
        made,
    };
    let [first, second, _] = made;
    let root = newton.look(&first.at.z, max_iterations, record)?;
    if is_declared(equations, &root.z, size) {
        let (bend, close) = bend(
            [&first.at.update, &second.at.update],
            [&first.at.z, &second.at.z],
            size,
        );
        return Ok(Root { bend, close, ..root });
    }
    Err(FailedIteration {
        reason: StepFailure::Degenerate,
        rows: equations.linearize(&root.z).rows,
        z: root.z,
        evaluations: root.evaluations,
    })
}

/// Finds how much the rows bend on the way to a root, if the equations are watched or another root may be
/// close.
#[inline]
fn watched<E: Quick + ?Sized>(
    equations: &E,
    [first, second]: [&Evaluation<E::Z>; 2],
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
    if equations.are_watched() && !straight && (equations.past_is_short() || close) {
        // without `map`, of which every declared type would have copies
        let (bend, close) = bend(
            [first.at.update.as_ref(), second.at.update.as_ref()],
            [first.at.z.as_ref(), second.at.z.as_ref()],
            size.as_ref(),
        );
        Root { bend, close, ..root }
    } else {
        root
    }
}

/// The bend of the rows (see [`Root::bend`]) from the first two updates, and whether another root would be
/// close.
#[cold]
fn bend(updates: [&[f64]; 2], at: [&[f64]; 2], size: &[f64]) -> (f64, bool) {
    let [before, after] = [0, 1].map(|k| relative(updates[k], at[k], size));
    // close also where an update is NaN
    let far = matches!(
        after.partial_cmp(&(CLOSE * before * before)),
        Some(Ordering::Less)
    );
    (after / before, !far)
}

/// Whether a root at `z` is one of the declared rows, compared with a point at the distance of a last update.
#[inline(always)]
#[allow(clippy::inline_always)] // part of every step
fn is_declared<E: Quick + ?Sized>(equations: &E, z: &E::Z, size: &E::Z) -> bool {
    let nearby = z.with(size, |z, size| z + LAST_UPDATE * z.abs().max(size));
    equations.is_declared(z, &nearby)
}

/// The root that an update leads to.
#[inline]
fn arrived<Z: Components>(last: &Evaluation<Z>, evaluations: u32) -> Root<Z> {
    Root {
        z: last.next(),
        evaluations,
        stop: Stop::Update,
        bend: 0.0,
        close: false,
        determinant: last.determinant,
    }
}

/// The size of an update relative to unknowns `z`, or to their expected sizes where these are larger.
#[inline]
pub(crate) fn relative(update: &[f64], z: &[f64], size: &[f64]) -> f64 {
    Update {
        components: &update,
        unknowns: &z,
        sizes: &size,
    }
    .relative()
}

/// Repeats a failed iteration from `start`, to record the history of its updates.
#[cold]
pub(crate) fn explain(
    equations: &dyn Equations,
    start: &Vector,
    size: &Vector,
    max_iterations: u32,
) -> NewtonFailure {
    let mut updates = Vec::new();
    let result = solve(equations, start, size, max_iterations, &mut updates);
    let (reason, z, rows) = match result {
        Err(FailedIteration { reason, z, rows, .. }) => (reason, z, rows),
        // not reached: the same iteration fails again
        Ok(root) => (
            StepFailure::NotConverged,
            root.z.clone(),
            equations.linearize(&root.z).rows,
        ),
    };
    NewtonFailure {
        reason,
        unknowns: z.to_vec(),
        residual: rows.to_vec(),
        updates,
        other: Vec::new(),
    }
}

impl Newton<'_> {
    /// The rows at `z` and the update from there.
    fn evaluate(&mut self, z: Vector) -> Evaluated {
        let here = |trial: &&Evaluation<Vector>| trial.at.z == z && trial.is_solution();
        if let Some(trial) = self.made.iter().find(here) {
            return Ok(trial.at.clone());
        }
        self.evaluations += 1;
        if let Some(evaluation) = self.equations.sparse_update(&z) {
            return Ok(evaluation.at);
        }
        let at = self.equations.linearize(&z);
        match at.update() {
            Some(update) => Ok(Iterate {
                z,
                rows: at.rows,
                update,
            }),
            None => self.without_update(z, &at),
        }
    }

    /// The result at `z` without an update: an exact root, a singular Jacobian, or rows that are not finite.
    #[cold]
    fn without_update(&self, z: Vector, at: &Linearized) -> Evaluated {
        let rows = at.rows.clone();
        if !rows.is_finite() || !is_finite(at.jacobian.entries()) {
            return Err(FailedIteration {
                reason: StepFailure::NotFinite,
                z,
                rows,
                evaluations: self.evaluations,
            });
        }
        let is_zero = rows.iter().all(|&row| row == 0.0);
        // a double root is a root; rows that stay zero along a null direction of the Jacobian do not
        // determine the unknowns
        let determined = |direction: Vec<f64>| {
            let lengths = z.iter().zip(self.size.iter());
            let lengths = lengths.map(|(z, size)| z.abs().max(*size));
            // size of a change by the direction, relative to the unknowns
            let far = direction
                .iter()
                .zip(lengths)
                .fold(0.0_f64, |far, (part, length)| {
                    let far_here = if length > 0.0 { part.abs() / length } else { 0.0 };
                    far.max(far_here)
                });
            let part = if far > 0.0 { NEARBY / far } else { NEARBY };
            let mut moved = z.clone();
            for (z, along) in moved.iter_mut().zip(&direction) {
                *z += part * along;
            }
            // the direction is rounded: rows within their rounding errors count as zero
            let rows = self.equations.linearize(&moved).rows;
            let bounds = self.equations.rounding(&moved);
            let mut rows = rows.iter().zip(bounds.iter());
            rows.any(|(row, bound)| {
                let is_rounding = row.abs() <= LEFT * bound;
                *row != 0.0 && !is_rounding
            })
        };
        let count = rows.len();
        let jacobian = || Matrix::from_fn(count, count, |i, j| at.jacobian.entries()[i * count + j]);
        if is_zero && null_directions(jacobian(), count).into_iter().all(determined) {
            return Ok(Iterate {
                z,
                rows,
                update: Vector::zero(count),
            });
        }
        Err(FailedIteration {
            reason: StepFailure::Singular,
            z,
            rows,
            evaluations: self.evaluations,
        })
    }

    /// The root after the last update.
    #[inline]
    fn arrive(&self, last: &Iterate<Vector>) -> Root<Vector> {
        let stop = if last.rows.iter().all(|&row| row == 0.0) {
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
            determinant: Determinant::UNKNOWN,
        }
    }

    /// The point that the full update leads to.
    #[inline]
    fn full_step(&mut self, from: &Iterate<Vector>) -> Evaluated {
        self.evaluate(from.z.zip(&from.update, |z, update| z + update))
    }

    /// Full updates from `start`, as long as each is much smaller than the one before. No other check is
    /// needed then.
    fn look(
        mut self,
        start: &Vector,
        max_iterations: u32,
        record: &mut dyn IterationRecord,
    ) -> Result<Root<Vector>, FailedIteration> {
        let mut now = self.evaluate(start.clone())?;
        let mut size = now.update(&self.size).relative();
        record.update(size);
        if now.update(&self.size).is_small(LAST_UPDATE) || Quick::are_linear(self.equations) {
            return Ok(self.arrive(&now));
        }
        let mut next = self.full_step(&now);
        loop {
            let Ok(at) = &next else {
                return self.iterate(now, size, next, max_iterations, record);
            };
            let next_size = at.update(&self.size).relative();
            if at.update(&self.size).settles(&now.update(&self.size)) {
                record.update(next_size);
                let stop = Stop::Update;
                return Ok(Root {
                    stop,
                    ..self.arrive(at)
                });
            }
            if !converges(size, next_size) || self.evaluations >= max_iterations {
                // perhaps the expected size of an unknown is below the accuracy that rounding allows
                if self.natural.is_none() && self.learn(&at.z, record) {
                    size = now.update(&self.size).relative();
                    continue;
                }
                return self.iterate(now, size, next, max_iterations, record);
            }
            record.update(next_size);
            (now, size) = (at.clone(), next_size);
            next = self.full_step(&now);
        }
    }

    /// Computes the natural sizes of the unknowns near `z`; `false` if there are none.
    #[cold]
    fn learn(&mut self, z: &Vector, record: &mut dyn IterationRecord) -> bool {
        if z.len() < 2 {
            return false; // a single unknown has no coupling
        }
        let terms = self.equations.rounding(z);
        let terms = terms.map(|bound| bound / UNIT);
        let Some(natural) = NaturalSizes::new(&self.equations.linearize(z).jacobian, &terms, z) else {
            return false;
        };
        self.evaluations += 1;
        if !natural.are_usual() {
            return false;
        }
        self.size = natural.raise(&self.size);
        record.natural_sizes(&natural);
        self.natural = Some(natural.sizes);
        true
    }

    /// Continues the iteration from a point whose update is not small enough to be the last; the next point
    /// has been evaluated.
    #[inline(never)]
    fn iterate(
        mut self,
        mut now: Iterate<Vector>,
        mut size: f64,
        next: Evaluated,
        max_iterations: u32,
        record: &mut dyn IterationRecord,
    ) -> Result<Root<Vector>, FailedIteration> {
        let (mut part, mut patience) = (1.0_f64, PATIENCE);
        let mut progress = Progress::new(size);
        let mut evaluated = Some(next);
        for iteration in self.evaluations.saturating_sub(1)..max_iterations {
            let (next, taken) = self.descend(&now, evaluated.take(), (8.0 * part).min(1.0), &mut patience)?;
            let (before, last_size) = (now, progress.last());
            (now, part) = (next, taken);
            size = now.update(&self.size).relative();
            record.update(size);
            if size == 0.0 {
                return Ok(self.arrive(&now));
            }
            progress.take(size);
            if part < 1.0 {
                continue;
            }
            if is_last(last_size, size) {
                return Ok(self.arrive(&now));
            }
            let stagnation_cause = progress.stagnation_cause(last_size, iteration);
            if stagnation_cause != StagnationCause::None {
                let noise = stagnation_cause == StagnationCause::Noise;
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
                        determinant: Determinant::UNKNOWN,
                    });
                }
            }
        }
        Err(FailedIteration {
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
        from: &Iterate<Vector>,
        mut evaluated: Option<Evaluated>,
        mut part: f64,
        patience: &mut u32,
    ) -> Result<Descent, FailedIteration> {
        let mut full = None;
        while part >= SMALLEST_PART {
            let trial = match evaluated.take() {
                Some(trial) => trial,
                None => self.evaluate(from.z.zip(&from.update, |z, update| z + part * update)),
            };
            if let Ok(next) = trial {
                if self.shrinks(from, &next)
                    || next.update(&self.size).is_small(LAST_UPDATE)
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
            _ => Err(FailedIteration {
                reason: StepFailure::NotConverged,
                z: from.z.clone(),
                rows: from.rows.clone(),
                evaluations: self.evaluations,
            }),
        }
    }

    /// Whether the update at `to` is smaller than the one at `from`, both relative to the same sizes.
    fn shrinks(&self, from: &Iterate<Vector>, to: &Iterate<Vector>) -> bool {
        let (mut before, mut after) = (0.0_f64, 0.0_f64);
        // unknowns far below their natural sizes do not count
        let natural = self.natural.as_ref().unwrap_or(&self.size);
        let size = natural.zip(&self.size, f64::max);
        let expected = from
            .z
            .zip(&size, |z, size| z.abs().max(size))
            .zip(&from.update, |size, x| size.max(x.abs()));
        for (i, &size) in expected.iter().enumerate() {
            // an unknown without a size yet cannot have too large an update
            if size > 0.0 {
                before = before.max(from.update[i].abs() / size);
                after = after.max(to.update[i].abs() / size);
            }
        }
        after < before || after == 0.0
    }

    /// The largest row relative to the bound of its rounding error.
    #[cold]
    fn roundings(&self, at: &Iterate<Vector>) -> f64 {
        let bounds = self.equations.rounding(&at.z);
        at.rows
            .iter()
            .zip(bounds.iter())
            .fold(0.0, |largest, (row, bound)| {
                let ratio = if *row == 0.0 { 0.0 } else { row.abs() / bound };
                // a NaN must not count as zero, and must be kept
                if ratio > largest || ratio.is_nan() {
                    ratio
                } else {
                    largest
                }
            })
    }
}

mod homotopy;
mod jump;
mod pair;
pub(crate) use homotopy::{Fold, follow};
pub(crate) use pair::{nearby, orientation, other_root, scalar_product};
#[cfg(test)]
mod tests;
