//! The steps of a smooth motion: the only code of a run that is compiled for every declared type.
//!
//! It predicts, evaluates, solves, tests and commits, and nothing else. Where anything is odd it changes nothing and asks a
//! [`Question`]; the step is then solved on slices, by code that is compiled once.

#![allow(clippy::inline_always)] // parts of every step

use core::cell::Cell;

use super::pair;
use super::{Guess, NEARLY_THE_SAME, SECOND_DIFFERENCE, StepReport};
use crate::kernel::course::{Course, past_is_short};
use crate::kernel::question::{Halt, Question};
use crate::number::array::Array;
use crate::number::compensated::Compensated;
use crate::number::point::Leg;
use crate::solve::Numbers;
use crate::solve::elimination::Determinant;
use crate::solve::newton::{self, Evaluation, Quick, Root};
use crate::solve::predictor::{self, Arrays, Continuation};
use crate::solve::sparse::{Product, Update};
use crate::solve::sum::Sum;
use crate::solve::unknown::{Linearization, Unknown};
use crate::system::System;

/// Only steps that differ from their prediction are examined: by more than this, relative to the second difference. A force that
/// changes as predicted has not been switched.
pub(crate) const FORESEEN: f64 = 0.1;

/// What rows are multiplied by may change by this part of itself from one step to the next; where it changes by more, it is looked at
/// beside the root, too.
pub(super) const AS_BEFORE: f64 = 0.5;

/// What smooth steps ask of a system whose numbers of coordinates and unknowns are known where they are compiled.
pub(crate) trait Smooth<const N: usize> {
    /// The unknowns of a step.
    type Unknown: Unknown<f64> + Array<f64>;
    /// What is known when the run begins.
    type Constants: ?Sized;
    /// What is known when the step begins.
    type Known;

    /// Whether the rows are affine in the unknowns, between their jumps if they have any.
    fn has_affine_rows(&self) -> bool;

    /// Whether a row may jump where an unknown changes.
    fn may_jump(&self) -> bool;

    /// Whether the declaration names a factor to be divided out of a row.
    fn is_divided(&self) -> bool;

    /// Whether rows were multiplied by more than a number.
    fn is_scaled(&self) -> bool;

    /// Whether anything is given by pieces or divided by what may be zero.
    fn is_switching(&self) -> bool;

    /// Whether any expression depends on time.
    fn asks_for_time(&self) -> bool;

    /// Whether a constraint is of third order.
    fn is_of_third_order(&self) -> bool;

    /// Whether external forces act.
    fn is_forced(&self) -> bool;

    /// Takes in what a run knows since it began; `None` if that is of another system.
    fn constants_of<'c>(&self, run: &'c mut Numbers) -> Option<&'c mut Self::Constants>;

    /// Sets the second difference that a step of third order goes on from.
    fn set_past(&self, constants: &mut Self::Constants, past: &[f64; N]);

    /// What is known when a step begins.
    fn known_of(&self, constants: &Self::Constants, leg: &Leg<f64, N>) -> Self::Known;

    /// The rows and Newton's update.
    fn evaluation(
        &self,
        constants: &Self::Constants,
        known: &Self::Known,
        z: &Self::Unknown,
    ) -> Evaluation<Self::Unknown>;

    /// What each row is, divided by the declared one.
    fn row_scales(
        &self,
        constants: &Self::Constants,
        known: &Self::Known,
        z: &Self::Unknown,
    ) -> Self::Unknown;

    /// The unknowns that belong to a second difference, without multipliers.
    fn unknown_of(&self, e: &[f64; N]) -> Self::Unknown;

    /// The second difference that belongs to the unknowns.
    fn difference(&self, constants: &Self::Constants, known: &Self::Known, z: &Self::Unknown) -> [f64; N];
}

impl<S: System<N>, const N: usize> Smooth<N> for S {
    type Unknown = S::Unknown<f64>;
    type Constants = S::Constants<f64>;
    type Known = S::Known<f64>;

    #[inline(always)]
    fn has_affine_rows(&self) -> bool {
        S::LINEAR
    }

    #[inline(always)]
    fn may_jump(&self) -> bool {
        S::JUMPS
    }

    #[inline(always)]
    fn is_divided(&self) -> bool {
        S::DIVIDED
    }

    #[inline(always)]
    fn is_scaled(&self) -> bool {
        S::SCALED
    }

    #[inline(always)]
    fn is_switching(&self) -> bool {
        S::SWITCHING
    }

    #[inline(always)]
    fn asks_for_time(&self) -> bool {
        S::DEPENDS_ON_TIME
    }

    #[inline(always)]
    fn is_of_third_order(&self) -> bool {
        S::ORDER > 2
    }

    #[inline(always)]
    fn is_forced(&self) -> bool {
        S::EXTERNAL_FORCES
    }

    #[inline(always)]
    fn constants_of<'c>(&self, run: &'c mut Numbers) -> Option<&'c mut S::Constants<f64>> {
        let (constants, _) = <S::Constants<f64> as Array<f64>>::split(run)?;
        Some(constants)
    }

    #[inline(always)]
    fn set_past(&self, constants: &mut S::Constants<f64>, past: &[f64; N]) {
        S::remember(constants, past);
    }

    #[inline(always)]
    fn known_of(&self, constants: &S::Constants<f64>, leg: &Leg<f64, N>) -> S::Known<f64> {
        self.known(constants, leg)
    }

    #[inline(always)]
    fn evaluation(
        &self,
        constants: &S::Constants<f64>,
        known: &S::Known<f64>,
        z: &S::Unknown<f64>,
    ) -> Evaluation<S::Unknown<f64>> {
        if const { S::SPARSE } {
            return sparse_evaluation(self, constants, known, z);
        }
        // in place: a copy of the matrix of a large system is no small part of the stack
        evaluated(&mut self.linearize(constants, known, z), S::LINEAR && !S::JUMPS)
    }

    #[inline(always)]
    fn row_scales(
        &self,
        constants: &S::Constants<f64>,
        known: &S::Known<f64>,
        z: &S::Unknown<f64>,
    ) -> S::Unknown<f64> {
        self.scales(constants, known, z)
    }

    #[inline(always)]
    fn unknown_of(&self, e: &[f64; N]) -> S::Unknown<f64> {
        self.unknown(e, &[])
    }

    #[inline(always)]
    fn difference(
        &self,
        constants: &S::Constants<f64>,
        known: &S::Known<f64>,
        z: &S::Unknown<f64>,
    ) -> [f64; N] {
        self.second_difference(constants, known, z)
    }
}

/// The rows and Newton's update by all entries. The Jacobian is destroyed.
#[inline(always)]
pub(crate) fn evaluated<U: Unknown<f64>>(
    linearization: &mut Linearization<f64, U>,
    are_linear: bool,
) -> Evaluation<U> {
    let rows = linearization.rows;
    let (update, safe, determinant) = if are_linear {
        // the only update has to be a good one
        let (update, determinant) = linearization.update_and_determinant();
        (update.unwrap_or(rows), update.is_some(), determinant)
    } else {
        linearization.quick_update()
    };
    Evaluation {
        rows,
        update,
        safe,
        determinant,
    }
}

/// By the entries that are not zero everywhere. Where that gives no good update, the step asks.
#[inline(always)]
fn sparse_evaluation<S: System<N>, const N: usize>(
    system: &S,
    constants: &S::Constants<f64>,
    known: &S::Known<f64>,
    z: &S::Unknown<f64>,
) -> Evaluation<S::Unknown<f64>> {
    let Some(sparse) = system.sparse() else {
        return Evaluation {
            rows: *z,
            update: *z,
            safe: false,
            determinant: Determinant::UNKNOWN,
        };
    };
    let mut product = Product::new(sparse.is_odd());
    let Update { rows, update } = sparse.update(
        |entries| system.entries(constants, known, z, entries),
        |pivot| product.take(pivot),
    );
    Evaluation {
        safe: update.as_ref().iter().all(|x| x.is_finite()),
        rows,
        update,
        determinant: product.value(),
    }
}

/// The rows of a step as arrays.
pub(crate) struct Rows<'a, S: Smooth<N>, const N: usize> {
    system: &'a S,
    constants: &'a S::Constants,
    known: S::Known,
    past_is_short: bool,
    /// What the rows of the last step were multiplied by; NaN where it is not known.
    last_scales: S::Unknown,
    /// What those of this step are multiplied by, where it was looked at.
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
    fn evaluate(&self, z: &Self::Z) -> Evaluation<Self::Z> {
        self.system.evaluation(self.constants, &self.known, z)
    }

    #[inline(always)]
    fn is_declared(&self, z: &Self::Z, nearby: &Self::Z) -> bool {
        if !self.system.is_scaled() {
            return true;
        }
        let here = self.system.row_scales(self.constants, &self.known, z);
        self.scales.set(here);
        // false also where one of them is no number
        let near = |there: &S::Unknown, part: f64| {
            let mut scales = here.as_ref().iter().zip(there.as_ref());
            scales.all(|(here, there)| (here - there).abs() < part * here.abs())
        };
        // what is nearly as it was at the step before has not vanished in between
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
    /// What the rows are multiplied by.
    pub scales: U,
}

impl<U: Unknown<f64>, const N: usize> Solved<U, N> {
    /// Puts the step among those of the past.
    #[inline(always)]
    pub fn push(&self, past: &mut Arrays<'_, U>, watched: bool) {
        past.push(&self.root.z, watched);
        *past.scales = self.scales;
    }
}

impl<'a, S: Smooth<N>, const N: usize> Rows<'a, S, N> {
    /// The rows of the step that begins with a leg.
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

    /// Solves the step, and changes nothing but what is known of its own determinant.
    #[inline(always)]
    pub fn solve(
        &self,
        leg: &Leg<f64, N>,
        past: &mut Arrays<'_, S::Unknown>,
        max_iterations: u32,
    ) -> Result<Solved<S::Unknown, N>, Question> {
        let Some(guess) = past.predict() else {
            return Err(Question::Start);
        };
        let increment = self.system.unknown_of(&leg.d);
        let mut size = past
            .size
            .zip(&increment, |size, d| size.max(SECOND_DIFFERENCE * d.abs()));
        if let Some(natural) = past.natural {
            natural.raise(size.as_mut(), past.size.as_ref());
        }
        let Ok(root) = newton::quick(self, guess, &size, max_iterations) else {
            return Err(Question::Unsettled);
        };
        if !guess.as_ref().is_empty() && past.determinants.asks(root.determinant) {
            return Err(Question::Varies);
        }
        if self.are_watched() {
            let fits = !root.determinant.value.is_nan()
                && past.determinants.take(root.determinant) == Continuation::Fits;
            if !fits {
                return Err(Question::Departs);
            }
            if pair::in_question(&root, self.past_is_short) {
                return Err(Question::Bends);
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
    /// The sign of the determinant of the rows, as they were declared.
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

/// A sum of arrays, which is written back with [`write`].
#[inline(always)]
pub(crate) fn read<const N: usize>([hi, lo]: &[&mut [f64; N]; 2]) -> Compensated<N> {
    Compensated { hi: **hi, lo: **lo }
}

/// The parts of a sum as arrays.
#[inline(always)]
pub(crate) fn parts<const N: usize>(sum: &mut Sum) -> Option<[&mut [f64; N]; 2]> {
    Some([sum.hi.first_chunk_mut()?, sum.lo.first_chunk_mut()?])
}

/// Arrays back into a sum.
#[inline(always)]
pub(crate) fn write<const N: usize>(place: [&mut [f64; N]; 2], sum: &Compensated<N>) {
    let [hi, lo] = place;
    (*hi, *lo) = (sum.hi, sum.lo);
}

/// What a step knows of the run beside the past solutions.
struct State<const N: usize> {
    /// The last position that is known.
    q: Compensated<N>,
    /// The increment that led to it.
    d: Compensated<N>,
    /// Of third order: the second difference that ends with the last node, and the one before.
    third: Option<(Compensated<N>, [f64; N])>,
}

/// Makes up to `count` steps of a run.
pub fn smooth<S: System<N>, const N: usize>(system: &S, course: &mut Course, count: u64) -> Halt {
    steps::<S, N>(system, course, count)
}

/// The same of a system of any kind.
#[inline(always)]
pub(crate) fn steps<S: Smooth<N>, const N: usize>(system: &S, course: &mut Course, count: u64) -> Halt {
    let is_third = system.is_of_third_order();
    let may_switch = !is_third && system.is_forced();
    let Some(vectors) = course.vectors.arrays::<N>().filter(|_| course.given.is_none()) else {
        return Halt::Asks(Question::Start);
    };
    let (e, solved_q, solved_d) = (vectors.e, vectors.solved_q, vectors.solved_d);
    let third = is_third.then(|| (read(&vectors.second), *vectors.before));
    let mut state = State {
        q: read(&vectors.q),
        d: read(&vectors.d),
        third,
    };
    let Some(constants) = system.constants_of(&mut course.constants) else {
        return Halt::Asks(Question::Start);
    };
    let Some(mut past) = course.predictor.arrays::<S::Unknown>() else {
        return Halt::Asks(Question::Start);
    };
    let mut made = 0;
    let halt = loop {
        if made == count {
            break Halt::Done;
        }
        let index = course.clock.index() + course.ahead;
        if system.is_switching() && course.looks_at <= index {
            break Halt::Asks(Question::Sides);
        }
        let leg = Leg {
            t: if system.asks_for_time() {
                course.clock.time_of(index)
            } else {
                0.0
            },
            q: state.q.hi,
            d: state.d.hi,
        };
        let short = past_is_short(index, course.since);
        let rows = Rows::<S, N>::new(system, constants, &leg, &past, short);
        let solved = rows.solve(&leg, &mut past, course.max_iterations);
        let solved = match solved {
            Ok(solved) => solved,
            Err(question) => break Halt::Asks(question),
        };
        let (found, z) = (solved.e, &solved.root.z);
        let mut next = State { ..state };
        if let (true, Some((second, before))) = (is_third, &mut next.third) {
            *before = second.hi;
            second.add(&found);
            next.d = state.d.plus(second);
        } else {
            next.d.add(&found);
        }
        next.q = state.q.plus(&next.d);
        if !next.q.hi.iter().all(|q| q.is_finite()) {
            break Halt::Asks(Question::NotFinite);
        }
        if may_switch || system.may_jump() {
            let last = course.has_solved.then_some(&e[..]);
            let foreseen = predictor::continues(z.as_ref().len(), last, &found, FORESEEN)
                && predictor::foresees(solved.guess.as_ref(), z.as_ref(), FORESEEN);
            if may_switch && !foreseen {
                break Halt::Asks(Question::Unforeseen);
            }
            course.looked = false;
        }
        solved.push(&mut past, rows.are_watched());
        state = next;
        if let (true, Some((second, _))) = (is_third, &state.third) {
            system.set_past(constants, &second.hi);
        }
        (*e, *solved_q, *solved_d) = (found, leg.q, leg.d);
        course.solved_at = leg.t;
        course.report = StepReport {
            iterations: solved.root.evaluations,
            stop: solved.root.stop,
            guess: Guess::Predicted,
        };
        course.has_solved = true;
        course.clock.tick();
        made += 1;
    };
    write(vectors.q, &state.q);
    write(vectors.d, &state.d);
    if let (true, Some((second, before))) = (is_third, &state.third) {
        write(vectors.second, second);
        *vectors.before = *before;
    }
    halt
}
