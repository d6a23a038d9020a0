//! The steps of a smooth motion: the only code of a run that is compiled for every declared type.
//!
//! It predicts, evaluates, solves, tests and commits, and nothing else. If a test fails it changes nothing
//! and halts with a [`HaltReason`]; the step is then solved on slices, by code that is compiled once.

#![allow(clippy::inline_always)] // parts of every step

use core::cell::Cell;

use super::declared::Smooth;
use super::pair;
use super::{Guess, NEARLY_THE_SAME, SECOND_DIFFERENCE, StepReport};
use crate::kernel::halt::{Halt, HaltReason};
use crate::kernel::run_state::{RunState, past_is_short};
use crate::number::compensated::Compensated;
use crate::number::point::Leg;
use crate::solve::newton::{self, Evaluation, Quick, Root};
use crate::solve::predictor::{self, Arrays, Continuation};
use crate::solve::rotation;
use crate::solve::sum::Sum;
use crate::solve::unknown::Unknown;
use crate::system::System;

/// Only steps that differ from their prediction by more than this, relative to the second difference, are
/// examined: a force that changes as predicted has not jumped.
pub(crate) const NEAR_PREDICTION: f64 = 0.1;

/// A row's factor may change by this part of itself from one step to the next; if it changes by more, it is
/// also compared with its value beside the root.
pub(super) const AS_BEFORE: f64 = 0.5;

/// The size of the unknowns, two doubles, up to which an evaluation is inlined in its three places. Elimination of more
/// unknowns is long.
const INLINED: usize = 16;

/// The rows of a step as arrays.
pub(crate) struct Rows<'a, S: Smooth<N>, const N: usize> {
    system: &'a S,
    constants: &'a S::Constants,
    known: S::Known,
    past_is_short: bool,
    /// The factors of the last step's rows; NaN if they are not known.
    last_scales: S::Unknown,
    /// The factors of this step's rows, if they were evaluated.
    scales: Cell<S::Unknown>,
}

impl<S: Smooth<N>, const N: usize> Quick for Rows<'_, S, N> {
    type Z = S::Unknown;

    #[inline(always)]
    fn are_linear(&self) -> bool {
        self.system.has_affine_rows() && !self.system.may_jump()
    }

    #[inline(always)]
    fn are_watched(&self) -> bool {
        !self.system.is_divided() && !self.system.has_affine_rows()
    }

    #[inline(always)]
    fn past_is_short(&self) -> bool {
        self.past_is_short
    }

    #[inline(always)]
    fn evaluate(&self, z: Self::Z) -> Evaluation<Self::Z> {
        if size_of::<Self::Z>() <= INLINED {
            self.system.evaluation(self.constants, &self.known, z)
        } else {
            self.evaluate_apart(z)
        }
    }

    #[inline(always)]
    fn is_declared(&self, z: &Self::Z, nearby: &Self::Z) -> bool {
        if !self.system.is_scaled() {
            return true;
        }
        let here = self.system.row_scales(self.constants, &self.known, z);
        self.scales.set(here);
        // false also for a NaN
        let near = |there: &S::Unknown, part: f64| {
            let mut scales = here.as_ref().iter().zip(there.as_ref());
            scales.all(|(here, there)| (here - there).abs() < part * here.abs())
        };
        // a factor that is nearly that of the step before has not vanished in between
        near(&self.last_scales, AS_BEFORE)
            || near(
                &self.system.row_scales(self.constants, &self.known, nearby),
                NEARLY_THE_SAME,
            )
    }
}

/// A step that was solved.
pub(crate) struct Solved<U, const N: usize> {
    /// The prediction.
    pub guess: U,
    /// The root.
    pub root: Root<U>,
    /// The second difference.
    pub e: [f64; N],
    /// The factors of the rows.
    pub scales: U,
}

impl<U: Unknown<f64>, const N: usize> Solved<U, N> {
    /// Records the step in the past.
    #[inline(always)]
    pub fn push(&self, past: &mut Arrays<'_, U>, watched: bool) {
        past.push(&self.root.z, watched);
        *past.scales = self.scales;
    }
}

impl<'a, S: Smooth<N>, const N: usize> Rows<'a, S, N> {
    /// An evaluation that the compiler inlines if it is short.
    #[inline]
    fn evaluate_apart(&self, z: S::Unknown) -> Evaluation<S::Unknown> {
        self.system.evaluation(self.constants, &self.known, z)
    }

    /// The rows of the step after a leg.
    #[inline(always)]
    pub fn new(
        system: &'a S,
        constants: &'a S::Constants,
        leg: &Leg<f64, N>,
        past: &Arrays<'_, S::Unknown>,
        past_is_short: bool,
    ) -> Self {
        Self {
            system,
            constants,
            known: system.known_of(constants, leg),
            past_is_short,
            last_scales: *past.scales,
            scales: Cell::new(*past.scales),
        }
    }

    /// Solves the step. Nothing of the past changes but the record of the step's own determinant.
    #[inline(always)]
    pub fn solve(
        &self,
        leg: &Leg<f64, N>,
        past: &mut Arrays<'_, S::Unknown>,
        max_iterations: u32,
    ) -> Result<Solved<S::Unknown, N>, HaltReason> {
        let Some(guess) = past.predict() else {
            return Err(HaltReason::Start);
        };
        let increment = self.system.unknown_of(&leg.d);
        let mut size = past
            .size
            .zip(&increment, |size, d| size.max(SECOND_DIFFERENCE * d.abs()));
        if let Some(natural) = past.natural {
            natural.raise(size.as_mut(), past.size.as_ref());
        }
        let Ok(root) = newton::quick(self, guess, &size, max_iterations) else {
            return Err(HaltReason::NotConverged);
        };
        if !guess.as_ref().is_empty() && past.determinants.is_to_be_examined(root.determinant) {
            return Err(HaltReason::DeterminantChanges);
        }
        if self.are_watched() {
            let fits = !root.determinant.value.is_nan()
                && past.determinants.take(root.determinant) == Continuation::Fits;
            if !fits {
                return Err(HaltReason::Departs);
            }
            if pair::is_ambiguous(&root, self.past_is_short) {
                return Err(HaltReason::Nonlinear);
            }
        }
        let e = self.system.difference(self.constants, &self.known, &root.z);
        Ok(Solved {
            guess,
            root,
            e,
            scales: self.scales.get(),
        })
    }
}

impl<S: System<N>, const N: usize> Rows<'_, S, N> {
    /// The sign of the determinant of the declared rows' Jacobian.
    #[inline]
    pub fn orientation(&self, z: &S::Unknown<f64>) -> f64 {
        let jacobian = self.system.linearize(self.constants, &self.known, z).jacobian;
        let sign = S::Unknown::<f64>::determinant(&jacobian).value.signum();
        if !S::SCALED {
            return sign;
        }
        let scales = self.system.scales(self.constants, &self.known, z);
        let scales = scales.as_ref().iter();
        scales.fold(sign, |sign, scale| sign * scale.signum())
    }
}

/// A compensated sum, read as arrays.
#[inline(always)]
pub(crate) fn read<const N: usize>([hi, lo]: &[&mut [f64; N]; 2]) -> Compensated<N> {
    Compensated { hi: **hi, lo: **lo }
}

/// The high and the low part of a compensated sum as arrays.
#[inline(always)]
pub(crate) fn parts<const N: usize>(sum: &mut Sum) -> Option<[&mut [f64; N]; 2]> {
    Some([sum.hi.first_chunk_mut()?, sum.lo.first_chunk_mut()?])
}

/// Writes the arrays of a compensated sum back.
#[inline(always)]
pub(crate) fn write<const N: usize>(place: [&mut [f64; N]; 2], sum: &Compensated<N>) {
    let [hi, lo] = place;
    (*hi, *lo) = (sum.hi, sum.lo);
}

/// Makes up to `count` steps of a run.
pub fn smooth<S: System<N>, const N: usize>(system: &S, run_state: &mut RunState, count: u64) -> Halt {
    steps::<S, N>(system, run_state, count)
}

/// [`smooth`] for every system that implements [`Smooth`].
#[inline(always)]
pub(crate) fn steps<S: Smooth<N>, const N: usize>(system: &S, run_state: &mut RunState, count: u64) -> Halt {
    let is_third = system.is_of_third_order();
    let may_switch = !is_third && system.is_forced();
    let arrays = run_state.vectors.arrays::<N>();
    let Some(vectors) = arrays.filter(|_| run_state.given.is_none()) else {
        return Halt::NotSmooth(HaltReason::Start);
    };
    let (e, solved_q, solved_d) = (vectors.e, vectors.solved_q, vectors.solved_d);
    let (mut q, mut d) = (read(&vectors.q), read(&vectors.d));
    let [second, second_low] = vectors.second;
    let Some(constants) = system.constants_of(&mut run_state.constants) else {
        return Halt::NotSmooth(HaltReason::Start);
    };
    let Some(mut past) = run_state.predictor.arrays::<S::Unknown>() else {
        return Halt::NotSmooth(HaltReason::Start);
    };
    let mut made = 0;
    let halt = loop {
        if made == count {
            break Halt::Done;
        }
        let index = run_state.clock.index() + run_state.ahead;
        if system.is_switching() && run_state.next_examination <= index {
            break Halt::NotSmooth(HaltReason::RestOrSignChange);
        }
        let leg = Leg {
            t: if system.asks_for_time() {
                run_state.clock.time_of(index)
            } else {
                0.0
            },
            q: q.hi,
            d: d.hi,
        };
        let short = past_is_short(index, run_state.since);
        let rows = Rows::<S, N>::new(system, constants, &leg, &past, short);
        let solved = rows.solve(&leg, &mut past, run_state.max_iterations);
        let solved = match solved {
            Ok(solved) => solved,
            Err(reason) => break Halt::NotSmooth(reason),
        };
        let (found, z) = (solved.e, &solved.root.z);
        let mut next_second = None;
        let next_d = if is_third {
            let mut sum = read(&[&mut *second, &mut *second_low]);
            sum.add(&found);
            next_second = Some(sum);
            d.plus(&sum)
        } else {
            let mut next = d;
            next.add(&found);
            next
        };
        let mut next_q = q.plus(&next_d);
        let rotations = system.rotations();
        if !rotations.is_empty() {
            // copies: the sums of a step without rotations stay in registers
            let (from, by, mut to) = (q, next_d, next_q);
            let from = [&from.hi[..], &from.lo];
            rotation::turn(rotations, from, [&by.hi, &by.lo], [&mut to.hi, &mut to.lo]);
            if rotation::turns_too_far(rotations, &by.hi).is_some() {
                break Halt::NotSmooth(HaltReason::NotFinite);
            }
            next_q = to;
        }
        if !next_q.hi.iter().all(|q| q.is_finite()) {
            break Halt::NotSmooth(HaltReason::NotFinite);
        }
        if may_switch || system.may_jump() {
            let past = run_state.has_solved.then_some([&vectors.before[..], &e[..]]);
            let foreseen = predictor::continues(z.as_ref().len(), past, &found, NEAR_PREDICTION)
                && predictor::is_near_prediction(solved.guess.as_ref(), z.as_ref(), NEAR_PREDICTION);
            if may_switch && !foreseen {
                break Halt::NotSmooth(HaltReason::Unforeseen);
            }
            run_state.is_examined = false;
            *vectors.before = *e;
        }
        solved.push(&mut past, rows.are_watched());
        (q, d) = (next_q, next_d);
        if let Some(sum) = &next_second {
            *vectors.before = *second;
            write([&mut *second, &mut *second_low], sum);
            system.set_past(constants, second);
        }
        (*e, *solved_q, *solved_d) = (found, leg.q, leg.d);
        run_state.solved_at = leg.t;
        run_state.report = StepReport {
            iterations: solved.root.evaluations,
            stop: solved.root.stop,
            guess: Guess::Predicted,
        };
        run_state.has_solved = true;
        run_state.clock.tick();
        made += 1;
    };
    write(vectors.q, &q);
    write(vectors.d, &d);
    halt
}
