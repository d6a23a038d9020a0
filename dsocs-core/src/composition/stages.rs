//! The smooth stages of a composed step: compiled for every declared type that is composed, and for no other.

#![expect(clippy::float_cmp, reason = "orientations are signs")]

use crate::kernel::clock::Clock;
use crate::kernel::halt::HaltReason;
use crate::kernel::report::{Guess, StepReport};
use crate::kernel::run_state::past_is_short;
use crate::number::array::Array;
use crate::number::compensated::Compensated;
use crate::number::point::Leg;
use crate::number::point::{AnyLeg, OwnedLeg};
use crate::solve::newton::Stop;
use crate::solve::predictor::PAST;
use crate::solve::predictor::Predictor;
use crate::solve::sum::Sum;
use crate::solve::{Numbers, Vector};
use crate::step::smooth::{Rows, parts, read, write};
use crate::system::System;

/// The current node.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Position.
    pub q: Sum,
    /// Velocity.
    pub v: Sum,
    /// Acceleration.
    pub a: Vector,
}

/// A stage: a leg of the discrete flow with its own length.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    /// The length of its leg.
    pub h: f64,
    /// Whether the leg goes against the direction of the run.
    pub backward: bool,
    /// Whether it is the longest of the backward legs, and the first of its length.
    pub longest: bool,
    /// `1/h²`.
    pub per_square: f64,
    /// The known values of the run.
    pub constants: Numbers,
    /// The solutions of this stage in the last steps, a step apart.
    pub predictor: Predictor,
    /// The legs of these solutions; the last is at the place `last`, the earlier ones follow cyclically.
    pub past: [OwnedLeg<f64>; PAST],
    /// The place of the last leg.
    pub last: usize,
    /// The solution of the step that is being made.
    pub found: Vector,
    /// Its leg.
    pub leg: OwnedLeg<f64>,
}

/// The state that is carried from step to step.
#[derive(Clone, Debug)]
pub(crate) struct ComposedState {
    /// The stages of the method, in order.
    pub stages: Vec<Stage>,
    /// The number and the time of the current node.
    pub clock: Clock,
    /// The number of the node at which the past begins: the start, or a change of inputs.
    pub since: u64,
    /// The current node.
    pub now: State,
    /// The sign of the longest backward stage's determinant, as the motion has it.
    pub orientation: f64,
    /// Statistics of the step to the current node.
    pub report: StepReport,
    /// Largest number of evaluations of the rows from one guess.
    pub max_iterations: u32,
}

impl ComposedState {
    /// Records the solutions of all stages, and moves to the node that they lead to.
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
    /// Records the leg of the step in the past.
    fn remember_leg(&mut self) {
        // backwards in the ring: it replaces the oldest
        self.last = (self.last + PAST - 1) % PAST;
        core::mem::swap(&mut self.past[self.last], &mut self.leg);
    }

    /// The legs of the last steps, the last first.
    pub fn past(&self) -> [AnyLeg<'_, f64>; PAST] {
        core::array::from_fn(|k| self.past[(self.last + k) % PAST].any())
    }
}

/// Makes composed steps as long as all of their stages are smooth.
pub(crate) trait Stages: Send + Sync {
    /// Makes the next step, or gives the reason why it is not smooth, with the state of the run unchanged.
    fn step(&self, run_state: &mut ComposedState) -> Result<(), HaltReason>;
}

/// The stages of a declared type.
pub(super) struct CompiledStages<'s, S, const N: usize>(pub &'s S);

impl<S: System<N>, const N: usize> Stages for CompiledStages<'_, S, N> {
    fn step(&self, run_state: &mut ComposedState) -> Result<(), HaltReason> {
        step(self.0, run_state)
    }
}

fn step<S: System<N>, const N: usize>(system: &S, run_state: &mut ComposedState) -> Result<(), HaltReason> {
    let State { q, v, a } = &mut run_state.now;
    let (Some(place_of_q), Some(place_of_v), Some(place_of_a)) =
        (parts::<N>(q), parts(v), a.first_chunk_mut::<N>())
    else {
        return Err(HaltReason::Start);
    };
    let (mut q, mut v) = (read(&place_of_q), read(&place_of_v));
    let mut a = *place_of_a;
    let index = run_state.clock.index();
    if index == run_state.since {
        // the acceleration of the beginning is given
        return Err(HaltReason::Start);
    }
    // with few past steps, only the flag `past_is_short` decides between two roots
    let past_is_short = past_is_short(index, run_state.since);
    let now = run_state.clock.time();
    let mut iterations = 0;
    let mut done = 0.0;
    // between two stages the velocity is updated once, by the halves of both: a second dependent sum would
    // cost as much as a part of a stage
    let mut left = 0.0;
    for stage in &mut run_state.stages {
        let half = 0.5 * stage.h;
        v.add(&scaled(left + half, &a));
        let d = Compensated {
            hi: scaled(stage.h, &v.hi),
            lo: scaled(stage.h, &v.lo),
        };
        q = q.plus(&d);
        // stages begin at exact times, as the whole step does
        done += stage.h;
        let leg = Leg {
            t: now + done,
            q: q.hi,
            d: d.hi,
        };
        let Stage {
            leg:
                OwnedLeg {
                    t,
                    q: leg_q,
                    d: leg_d,
                },
            found,
            ..
        } = stage;
        let (Some(leg_q), Some(leg_d), Some((found, _))) = (
            leg_q.first_chunk_mut(),
            leg_d.first_chunk_mut(),
            Array::split(found),
        ) else {
            return Err(HaltReason::Start);
        };
        (*t, *leg_q, *leg_d) = (leg.t, leg.q, leg.d);
        let constants = Array::read(&stage.constants).ok_or(HaltReason::Start)?;
        let mut past = stage.predictor.arrays().ok_or(HaltReason::Start)?;
        let rows = Rows::<S, N>::new(system, constants, &leg, &past, past_is_short);
        let solved = rows.solve(&leg, &mut past, run_state.max_iterations)?;
        a = scaled(stage.per_square, &solved.e);
        left = half;
        if !kicked(&v.hi, half, &a).iter().all(|v| v.is_finite()) {
            return Err(HaltReason::NotFinite);
        }
        if stage.longest && rows.orientation(&solved.root.z) != run_state.orientation {
            return Err(HaltReason::Departs);
        }
        *found = solved.root.z;
        // kept even if a later stage halts: the step that is then solved on slices resets the factors
        *past.scales = solved.scales;
        iterations += solved.root.evaluations;
    }
    v.add(&scaled(left, &a));
    for stage in &mut run_state.stages {
        if let (Some(z), Some(mut past)) = (
            Array::read(&stage.found),
            stage.predictor.arrays::<S::Unknown<f64>>(),
        ) {
            past.push(z, !S::DIVIDED && !S::LINEAR);
        }
        stage.remember_leg();
    }
    write(place_of_q, &q);
    write(place_of_v, &v);
    *place_of_a = a;
    run_state.report = StepReport {
        iterations,
        stop: Stop::Update,
        guess: Guess::Predicted,
    };
    run_state.clock.tick();
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
