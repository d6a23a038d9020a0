//! The smooth steps of a system that was not compiled: [`smooth`](super::smooth) on slices.
//!
//! It uses the same tests and the same operations in the same order as on arrays, so it gives the same bits.
//! A step allocates nothing.

use core::cell::Cell;
use std::mem;

use super::pair;
use super::smooth::{AS_BEFORE, NEAR_PREDICTION};
use super::{Guess, NEARLY_THE_SAME, SECOND_DIFFERENCE, StepReport};
use crate::kernel::halt::{Halt, HaltReason};
use crate::kernel::run_state::{RunState, past_is_short};
use crate::number::compensated::{add_all, plus_all};
use crate::number::point::AnyLeg;
use crate::solve::elimination::slices;
use crate::solve::is_finite;
use crate::solve::newton::{self, Components, Evaluation, Iterate, Quick, Root};
use crate::solve::predictor::{Continuation, Predictor, continues, is_near_prediction};
use crate::solve::rotation;
use crate::solve::sparse::{Product, Sparse, Update};
use crate::tape::{ProgramMemory, Shape};

/// A system as steps on slices use it. It computes in numbers that the caller keeps.
pub(crate) trait SliceSystem {
    /// The shape of the system.
    fn shape(&self) -> &Shape;

    /// The entries of a sparse Jacobian.
    fn sparse(&self) -> Option<&Sparse>;

    /// Copies in the known values of the run.
    fn take_constants(&self, numbers: &mut [f64], constants: &[f64]);

    /// Copies in the last second difference of a step of third order, to the numbers and to the constants.
    fn take_past(&self, numbers: &mut [f64], constants: &mut [f64], past: &[f64]);

    /// Copies in a leg, and computes the known values of its step.
    fn take_leg(&self, numbers: &mut [f64], leg: AnyLeg<'_, f64>);

    /// Copies in the unknowns, at which the following methods evaluate.
    fn take_unknowns(&self, numbers: &mut [f64], z: &[f64]);

    /// The rows, then their Jacobian row by row.
    fn rows(&self, numbers: &mut [f64], rows: &mut [f64], jacobian: &mut [f64]);

    /// The rows, then the entries of a sparse Jacobian.
    fn sparse_rows(&self, numbers: &mut [f64], rows: &mut [f64], entries: &mut [f64]);

    /// The factor of each row: the row over the declared one.
    fn row_scales(&self, numbers: &mut [f64], scales: &mut [f64]);

    /// The second difference.
    fn difference(&self, numbers: &mut [f64], e: &mut [f64]);

    /// The unknowns that belong to a second difference, without multipliers.
    fn unknowns_of(&self, numbers: &mut [f64], e: &[f64], z: &mut [f64]);
}

/// A vector of unknowns that is made of a slice.
pub(crate) trait Unknowns: Components {
    /// A copy of numbers.
    fn of(numbers: &[f64]) -> Self;
}

/// Few unknowns, as an array of compile-time length.
impl<const M: usize> Unknowns for [f64; M] {
    #[inline]
    fn of(numbers: &[f64]) -> Self {
        numbers.first_chunk().copied().unwrap_or([f64::NAN; M])
    }
}

thread_local! {
    /// Vectors that are not in use.
    static FREE: Cell<Vec<Vec<f64>>> = const { Cell::new(Vec::new()) };
}

/// Any number of unknowns, in a vector that the thread reuses.
pub(crate) struct PooledVector(Vec<f64>);

impl Unknowns for PooledVector {
    fn of(numbers: &[f64]) -> Self {
        let taken = FREE.try_with(|free| {
            let mut vectors = free.take();
            let taken = vectors.pop();
            free.set(vectors);
            taken
        });
        let mut vector = taken.ok().flatten().unwrap_or_default();
        vector.clear();
        vector.extend_from_slice(numbers);
        Self(vector)
    }
}

impl Clone for PooledVector {
    fn clone(&self) -> Self {
        Self::of(&self.0)
    }
}

impl Drop for PooledVector {
    fn drop(&mut self) {
        let vector = mem::take(&mut self.0);
        // at the end of the thread there is no place to keep it
        let _ = FREE.try_with(|free| {
            let mut vectors = free.take();
            vectors.push(vector);
            free.set(vectors);
        });
    }
}

impl AsRef<[f64]> for PooledVector {
    fn as_ref(&self) -> &[f64] {
        &self.0
    }
}

impl AsMut<[f64]> for PooledVector {
    fn as_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

/// The workspace of steps with the numbers of the system.
pub(crate) struct Workspace {
    /// The numbers of the system.
    pub numbers: ProgramMemory,
    /// The rest of it.
    pub workspace: StepWorkspace,
}

/// The workspace of steps without the numbers of the system.
pub(crate) struct StepWorkspace {
    /// The Jacobian, and room for its elimination.
    matrix: Vec<f64>,
    /// The second difference of a step, and the compensated sums of the next leg.
    next: Vec<f64>,
}

impl Workspace {
    /// An empty workspace.
    pub const EMPTY: Self = Self {
        numbers: ProgramMemory::EMPTY,
        workspace: StepWorkspace {
            matrix: Vec::new(),
            next: Vec::new(),
        },
    };
}

impl Default for Workspace {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// The rows of a step.
struct Rows<'a, K, Z> {
    system: &'a K,
    shape: &'a Shape,
    numbers: Cell<&'a mut [f64]>,
    matrix: Cell<&'a mut [f64]>,
    past_is_short: bool,
    /// The factors of the last step's rows; NaN if they are not known.
    last_scales: &'a [f64],
    /// The factors of this step's rows, if they were evaluated.
    scales: Cell<Option<Z>>,
}

impl<K: SliceSystem, Z: Unknowns> Rows<'_, K, Z> {
    /// The factors of the rows at the given unknowns.
    fn scales_at(&self, z: &Z) -> Z {
        let mut scales = z.clone();
        let numbers = self.numbers.take();
        self.system.take_unknowns(numbers, z.as_ref());
        self.system.row_scales(numbers, scales.as_mut());
        self.numbers.set(numbers);
        scales
    }

    /// The rows, the update and the determinant by dense elimination.
    fn evaluate_dense(&self, numbers: &mut [f64], z: Z) -> Evaluation<Z> {
        let matrix = self.matrix.take();
        let size = self.shape.unknowns;
        let (jacobian, room) = matrix.split_at_mut(size * size);
        let mut rows = z.clone();
        self.system.rows(numbers, rows.as_mut(), jacobian);
        let mut update = rows.clone();
        let (safe, determinant) = if self.are_linear() {
            // a single update solves linear rows: it has to be accurate
            negate(update.as_mut());
            let determinant = slices::solve(jacobian, update.as_mut(), room);
            let good = is_finite(update.as_ref());
            if !good {
                update = rows.clone();
            }
            (good, determinant)
        } else {
            // the sign changes last, where it becomes part of the sum with the unknowns
            let found = slices::solve_quick(jacobian, update.as_mut(), room);
            negate(update.as_mut());
            found
        };
        self.matrix.set(matrix);
        Evaluation {
            at: Iterate { z, rows, update },
            safe,
            determinant,
        }
    }
}

/// The high and the low parts of compensated sums.
#[inline]
fn halves(sums: &mut [f64]) -> [&mut [f64]; 2] {
    let (hi, lo) = sums.split_at_mut(sums.len() / 2);
    [hi, lo]
}

/// Changes all signs.
#[inline]
fn negate(vector: &mut [f64]) {
    for x in vector {
        *x = -*x;
    }
}

impl<K: SliceSystem, Z: Unknowns> Quick for Rows<'_, K, Z> {
    type Z = Z;

    #[inline]
    fn are_linear(&self) -> bool {
        self.shape.linear && !self.shape.jumps
    }

    #[inline]
    fn are_watched(&self) -> bool {
        self.shape.is_watched()
    }

    #[inline]
    fn past_is_short(&self) -> bool {
        self.past_is_short
    }

    fn evaluate(&self, z: Z) -> Evaluation<Z> {
        let numbers = self.numbers.take();
        self.system.take_unknowns(numbers, z.as_ref());
        let evaluation = if let Some(sparse) = self.system.sparse() {
            let mut product = Product::new(sparse.is_odd());
            let evaluate = |entries: &mut [f64]| {
                let mut rows = z.clone();
                self.system.sparse_rows(numbers, rows.as_mut(), entries);
                rows
            };
            let Update { rows, update } = sparse.update(evaluate, |pivot| product.take(pivot));
            Evaluation {
                safe: is_finite(update.as_ref()),
                at: Iterate { z, rows, update },
                determinant: product.value(),
            }
        } else {
            self.evaluate_dense(numbers, z)
        };
        self.numbers.set(numbers);
        evaluation
    }

    #[inline]
    fn is_declared(&self, z: &Z, nearby: &Z) -> bool {
        if !self.shape.scaled {
            return true;
        }
        let here = self.scales_at(z);
        self.scales.set(Some(here.clone()));
        // false also for a NaN
        let near = |there: &[f64], part: f64| {
            let mut scales = here.as_ref().iter().zip(there);
            scales.all(|(here, there)| (here - there).abs() < part * here.abs())
        };
        // a factor that is nearly that of the step before has not vanished in between
        near(self.last_scales, AS_BEFORE) || near(self.scales_at(nearby).as_ref(), NEARLY_THE_SAME)
    }
}

/// A step that was solved.
struct Solved<Z> {
    /// The prediction.
    guess: Z,
    /// The root.
    root: Root<Z>,
    /// The factors of the rows, if they were evaluated.
    scales: Option<Z>,
}

/// Solves the step after a leg. Nothing of the past changes but the record of the step's own determinant.
fn solve<K: SliceSystem, Z: Unknowns>(
    system: &K,
    (numbers, matrix): (&mut [f64], &mut [f64]),
    leg: AnyLeg<'_, f64>,
    predictor: &mut Predictor,
    (past_is_short, max_iterations): (bool, u32),
) -> Result<Solved<Z>, HaltReason> {
    let Some(guess) = predictor.predict_as(Z::of) else {
        return Err(HaltReason::Start);
    };
    system.take_leg(numbers, leg);
    let mut size = guess.clone();
    system.unknowns_of(numbers, leg.d, size.as_mut());
    for (size, lately) in size.as_mut().iter_mut().zip(predictor.size()) {
        *size = lately.max(SECOND_DIFFERENCE * size.abs());
    }
    if let Some(natural) = predictor.natural() {
        natural.raise(size.as_mut(), predictor.size());
    }
    let rows = Rows {
        system,
        shape: system.shape(),
        numbers: Cell::new(numbers),
        matrix: Cell::new(matrix),
        past_is_short,
        last_scales: predictor.scales(),
        scales: Cell::new(None),
    };
    let Ok(root) = newton::quick(&rows, guess.clone(), &size, max_iterations) else {
        return Err(HaltReason::NotConverged);
    };
    let watched = rows.are_watched();
    let scales = rows.scales.take();
    let determinants = &mut predictor.determinants;
    if !guess.as_ref().is_empty() && determinants.is_to_be_examined(root.determinant) {
        return Err(HaltReason::DeterminantChanges);
    }
    if watched {
        let fits =
            !root.determinant.value.is_nan() && determinants.take(root.determinant) == Continuation::Fits;
        if !fits {
            return Err(HaltReason::Departs);
        }
        if pair::is_ambiguous(&root, past_is_short) {
            return Err(HaltReason::Nonlinear);
        }
    }
    Ok(Solved { guess, root, scales })
}

/// Makes up to `count` steps of a run.
pub(crate) fn smooth<K: SliceSystem, Z: Unknowns>(
    system: &K,
    (numbers, workspace): (&mut [f64], &mut StepWorkspace),
    run_state: &mut RunState,
    count: u64,
) -> Halt {
    let shape = system.shape();
    let third = shape.is_of_third_order();
    let may_switch = !third && shape.external_forces;
    let (n, m) = (shape.increments, shape.unknowns);
    if run_state.given.is_some() {
        return Halt::NotSmooth(HaltReason::Start);
    }
    let [sums, solved_q, solved_d, e, second, before] = run_state.vectors.slices();
    let StepWorkspace { matrix, next } = workspace;
    matrix.resize(m * (m + 2), 0.0);
    // the compensated sums of the next leg, those of its second difference, and the difference itself
    next.resize(7 * n, 0.0);
    let (next_sums, rest) = next.split_at_mut(4 * n);
    let (next_second, found) = rest.split_at_mut(2 * n);
    system.take_constants(numbers, &run_state.constants);
    let mut made = 0;
    loop {
        if made == count {
            return Halt::Done;
        }
        let index = run_state.clock.index() + run_state.ahead;
        if shape.switches && run_state.next_examination <= index {
            return Halt::NotSmooth(HaltReason::RestOrSignChange);
        }
        let t = if shape.depends_on_time {
            run_state.clock.time_of(index)
        } else {
            0.0
        };
        let (q, d) = (&sums[..n], &sums[2 * n..3 * n]);
        let leg = AnyLeg { t, q, d };
        let limits = (past_is_short(index, run_state.since), run_state.max_iterations);
        let solved = solve::<K, Z>(system, (numbers, matrix), leg, &mut run_state.predictor, limits);
        let Solved { guess, root, scales } = match solved {
            Ok(solved) => solved,
            Err(reason) => return Halt::NotSmooth(reason),
        };
        let z = root.z.as_ref();
        system.take_unknowns(numbers, z);
        system.difference(numbers, found);
        next_sums.copy_from_slice(sums);
        let (next_q, next_d) = next_sums.split_at_mut(2 * n);
        let [next_q, next_q_low] = halves(next_q);
        let [next_d, next_d_low] = halves(next_d);
        if third {
            next_second.copy_from_slice(second);
            let [hi, lo] = halves(next_second);
            add_all(hi, lo, found);
            plus_all([&mut *next_d, &mut *next_d_low], [hi, lo]);
        } else {
            add_all(next_d, next_d_low, found);
        }
        plus_all([&mut *next_q, &mut *next_q_low], [&*next_d, &*next_d_low]);
        if !shape.rotations.is_empty() {
            let (q, q_low) = (q, &sums[n..2 * n]);
            let to = [&mut *next_q, next_q_low];
            rotation::turn(&shape.rotations, [q, q_low], [next_d, next_d_low], to);
            if rotation::turns_too_far(&shape.rotations, next_d).is_some() {
                return Halt::NotSmooth(HaltReason::NotFinite);
            }
        }
        if !is_finite(next_q) {
            return Halt::NotSmooth(HaltReason::NotFinite);
        }
        if may_switch || shape.jumps {
            let past = run_state.has_solved.then_some([&before[..], &e[..]]);
            let foreseen = continues(m, past, found, NEAR_PREDICTION)
                && is_near_prediction(guess.as_ref(), z, NEAR_PREDICTION);
            if may_switch && !foreseen {
                return Halt::NotSmooth(HaltReason::Unforeseen);
            }
            run_state.is_examined = false;
            before.copy_from_slice(e);
        }
        let scales = scales.as_ref().map(AsRef::as_ref);
        run_state
            .predictor
            .push_smooth(z, scales.unwrap_or_default(), shape.is_watched());
        solved_q.copy_from_slice(q);
        solved_d.copy_from_slice(d);
        e.copy_from_slice(found);
        sums.copy_from_slice(next_sums);
        if third {
            before.copy_from_slice(&second[..n]);
            second.copy_from_slice(next_second);
            system.take_past(numbers, &mut run_state.constants, &second[..n]);
        }
        run_state.solved_at = t;
        run_state.report = StepReport {
            iterations: root.evaluations,
            stop: root.stop,
            guess: Guess::Predicted,
        };
        run_state.has_solved = true;
        run_state.clock.tick();
        made += 1;
    }
}
