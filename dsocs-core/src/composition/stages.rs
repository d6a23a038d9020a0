//! The stages of a composed step where all of them are smooth: compiled for every declared type that is composed, and for no other.

use crate::any::OwnedLeg;
use crate::array::Array;
use crate::compensated::{Compensated, Sum};
use crate::run::Clock;
use crate::solve::Vector;
use crate::step::course::past_is_short;
use crate::step::newton::Stop;
use crate::step::predictor::Predictor;
use crate::step::question::Question;
use crate::step::smooth::{Rows, Solved, copy, read, write};
use crate::step::{Guess, PAST, StepReport};
use crate::system::{Leg, System};

/// The current node.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// Position.
    pub q: Sum,
    /// Velocity.
    pub v: Sum,
    /// Acceleration.
    pub a: Vector,
}

/// A stage: a leg of the discrete flow with its own length.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    /// The length of its leg.
    pub h: f64,
    /// Whether it goes against the direction of the run.
    pub backward: bool,
    /// Whether it is the longest of these, and the first of its length.
    pub longest: bool,
    /// `1/h²`.
    pub per_square: f64,
    /// What is known since the run began.
    pub constants: Vec<f64>,
    /// The solutions of this stage in the last steps, which lie as far apart as the steps do.
    pub predictor: Predictor,
    /// Their legs, the last first.
    pub past: [OwnedLeg<f64>; PAST],
    /// The solution of the step that is being made.
    pub found: Vector,
    /// Its leg.
    pub leg: OwnedLeg<f64>,
}

/// What a composed step carries to the next one.
#[derive(Clone, Debug)]
pub(super) struct Course {
    /// Its stages, in order.
    pub stages: Vec<Stage>,
    /// Which node is the current one.
    pub clock: Clock,
    /// The number of the node at which the past begins: the start, or a change of inputs.
    pub since: u64,
    /// The current node.
    pub now: State,
    /// The orientation of the longest stage that goes back, as the motion has it.
    pub orientation: f64,
    /// How the step that led to it was solved.
    pub report: StepReport,
    /// How often the rows may be evaluated from one guess.
    pub max_iterations: u32,
}

impl Course {
    /// Takes in the solutions of all stages, and goes on to the node that they lead to.
    pub(super) fn commit(&mut self, now: State, report: StepReport) {
        for stage in &mut self.stages {
            stage.predictor.push(&stage.found);
            stage.remember_leg();
        }
        (self.now, self.report) = (now, report);
        self.clock.tick();
    }
}

impl Stage {
    /// Puts the leg of the step among those of the past.
    fn remember_leg(&mut self) {
        self.past.rotate_right(1);
        let [last, ..] = &mut self.past;
        last.t = self.leg.t;
        last.q.copy_from_slice(&self.leg.q);
        last.d.copy_from_slice(&self.leg.d);
    }
}

/// Makes composed steps as long as all of their stages are smooth.
pub(super) trait Stages: Send + Sync {
    /// Makes the next step, or changes nothing that matters and asks.
    fn step(&self, course: &mut Course) -> Result<(), Question>;
}

/// The stages of a declared type.
pub(super) struct Of<'s, S, const N: usize>(pub &'s S);

impl<S: System<N>, const N: usize> Stages for Of<'_, S, N> {
    fn step(&self, course: &mut Course) -> Result<(), Question> {
        step(self.0, course)
    }
}

fn step<S: System<N>, const N: usize>(system: &S, course: &mut Course) -> Result<(), Question> {
    let (Some(mut q), Some(mut v), Some(mut a)) = (
        read::<N>(&course.now.q),
        read::<N>(&course.now.v),
        course.now.a.first_chunk::<N>().copied(),
    ) else {
        return Err(Question::Start);
    };
    let index = course.clock.index();
    if index == course.since {
        // the acceleration with which the motion begins is said
        return Err(Question::Start);
    }
    // without a past nothing else tells two roots apart
    let past_is_short = past_is_short(index, course.since);
    let now = course.clock.time();
    let mut iterations = 0;
    let mut done = 0.0;
    // between two stages the velocity takes the halves of both at once: a sum that is waited for costs as much as a part of a stage
    let mut left = 0.0;
    for stage in &mut course.stages {
        let half = 0.5 * stage.h;
        v.add(&scaled(left + half, &a));
        let d = Compensated {
            hi: scaled(stage.h, &v.hi),
            lo: scaled(stage.h, &v.lo),
        };
        q = q.plus(&d);
        // as the whole step, the stages begin at an exact time
        done += stage.h;
        let leg = Leg {
            t: now + done,
            q: q.hi,
            d: d.hi,
        };
        stage.leg.t = leg.t;
        copy(&mut stage.leg.q, &leg.q);
        copy(&mut stage.leg.d, &leg.d);
        let constants = Array::read(&stage.constants).ok_or(Question::Start)?;
        let (past, determinants, natural) = stage
            .predictor
            .arrays::<S::Unknown<f64>>()
            .ok_or(Question::Start)?;
        let rows = Rows::<S, N>::new(system, constants, &leg, past_is_short);
        let Solved { root, e, .. } = rows.solve(&leg, &past, determinants, natural, course.max_iterations)?;
        a = scaled(stage.per_square, &e);
        left = half;
        if !kicked(&v.hi, half, &a).iter().all(|v| v.is_finite()) {
            return Err(Question::NotFinite);
        }
        if stage.longest && rows.orientation(&root.z) != course.orientation {
            return Err(Question::Departs);
        }
        for (found, z) in stage.found.iter_mut().zip(root.z.as_ref()) {
            *found = *z;
        }
        iterations += root.evaluations;
    }
    v.add(&scaled(left, &a));
    for stage in &mut course.stages {
        if let (Some(z), Some((mut past, determinants, _))) = (
            Array::read(&stage.found).copied(),
            stage.predictor.arrays::<S::Unknown<f64>>(),
        ) {
            past.push(&z);
            determinants.push();
        }
        stage.remember_leg();
    }
    write(&mut course.now.q, &q);
    write(&mut course.now.v, &v);
    copy(&mut course.now.a, &a);
    course.report = StepReport {
        iterations,
        stop: Stop::Update,
        guess: Guess::Predicted,
    };
    course.clock.tick();
    Ok(())
}

#[inline]
fn scaled<const N: usize>(factor: f64, x: &[f64; N]) -> [f64; N] {
    let mut product = *x;
    for x in &mut product {
        *x *= factor;
    }
    product
}

/// `v + h a`.
#[inline]
fn kicked<const N: usize>(v: &[f64; N], h: f64, a: &[f64; N]) -> [f64; N] {
    let mut after = *v;
    for (v, a) in after.iter_mut().zip(a) {
        *v += h * a;
    }
    after
}
