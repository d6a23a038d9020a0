//! The steps of a block, which are compiled for each kind of register.

// see [`crate::number::instructions`]
#![allow(clippy::inline_always)]

use core::array;
use core::marker::PhantomData;

use wide::f64x8;

use super::lane_registers::{LaneRegisters, StepResult};
use super::lane_state::LaneState;
use super::newton::{self, Roots};
use crate::kernel::clock::Clock;
use crate::kernel::generated::Report;
use crate::kernel::report::{NodeMut, NodeScalars};
use crate::kernel::run_state::SHORT_PAST;
use crate::number::instructions::{Chosen, InLanes, Instructions, OTHERS};
use crate::number::lanes::{LANES, Lanes, Mask, Register};
use crate::number::point::{Leg, Point};
use crate::number::scalar::Scalar;
use crate::solve::newton::Stop;
use crate::solve::rotation;
use crate::solve::unknown::Unknown;
use crate::step::smooth::NEAR_PREDICTION;
use crate::step::{NEARLY_THE_SAME, SECOND_DIFFERENCE};
use crate::system::System;
use crate::tape::Eight;

/// The steps of a system in lanes, made when an ensemble is set up.
pub(super) trait LaneKernel: Send + Sync {
    /// The steps of a block, with the requested instructions, or the widest available below them. `values` has the
    /// values of the parameters for each lane.
    fn engine<'k>(
        &'k self,
        instructions: Instructions,
        common: &Common,
        values: &[&[f64]; LANES],
    ) -> Box<dyn Engine + 'k>;
}

/// The data that all steps of a block share.
#[derive(Clone, Copy)]
pub(super) struct Common {
    /// The step.
    pub h: f64,
    /// Largest number of evaluations of a step's rows from one guess.
    pub max_iterations: u32,
    /// Whether a body may come to rest where a function jumps.
    pub may_stick: bool,
    /// The clocks of the lanes, if the system depends on time.
    pub clocks: [Clock; LANES],
}

/// The steps that are to be made.
#[derive(Clone, Copy)]
pub(super) struct Task {
    /// The middle node of the first step.
    pub index: u64,
    /// The middle node of the last, whose report is wanted.
    pub last: u64,
    /// The lanes whose trajectories continue, as bits.
    pub active: u32,
    /// The lanes whose first step is made by a flow.
    pub elsewhere: u32,
    /// In each lane, the number of the position at which the past begins.
    pub since: [u64; LANES],
}

/// The last step that was made.
pub(super) struct LastStep {
    /// Its middle node.
    pub index: u64,
    /// The lanes that have to be solved alone, as bits. If there are any, the step is not committed yet.
    pub alone: u32,
    /// Whether the node was the last wanted one: then its data are written.
    pub is_written: bool,
}

impl LastStep {
    /// A step that has to be solved singly in all lanes.
    pub fn alone(task: &Task) -> Self {
        Self {
            index: task.index,
            alone: task.active,
            is_written: task.index == task.last,
        }
    }
}

/// The data of a node, by lanes.
pub(super) struct LaneNode {
    /// Position, velocity, acceleration and constraint force, one after the other.
    pub vectors: Vec<Eight>,
    /// Energy.
    pub energy: Eight,
    /// Number of evaluations of the rows.
    pub evaluations: [u32; LANES],
}

impl LaneNode {
    /// Allocates for a node.
    pub fn new(coordinates: usize) -> Self {
        Self {
            vectors: vec![Eight::ZERO; 4 * coordinates],
            energy: Eight::ZERO,
            evaluations: [0; LANES],
        }
    }

    /// Writes the node of one lane.
    pub fn write(&self, lane: usize, index: u64, t: f64, node: &mut NodeMut<'_>) {
        for (to, from) in node.vectors.iter_mut().zip(&self.vectors) {
            *to = from.0[lane];
        }
        *node.scalars = NodeScalars {
            index,
            t,
            energy: self.energy.0[lane],
            iterations: self.evaluations[lane],
            stop: Stop::Update,
        };
    }
}

/// The steps of eight trajectories, in any kind of register.
pub(super) trait Engine {
    /// Makes steps up to the last one, or to one in which a lane has to be solved alone.
    fn steps(&mut self, lane_state: &mut LaneState, lane_node: &mut LaneNode, task: &Task) -> LastStep;

    /// Sets the parameters of one lane.
    fn set_parameters(&mut self, lane: usize, values: &[f64]);
}

/// No steps in lanes: each trajectory is computed singly.
pub(super) struct ScalarSteps;

impl LaneKernel for ScalarSteps {
    fn engine<'k>(&'k self, _: Instructions, _: &Common, _: &[&[f64]; LANES]) -> Box<dyn Engine + 'k> {
        Box::new(Self)
    }
}

impl Engine for ScalarSteps {
    fn steps(&mut self, _: &mut LaneState, _: &mut LaneNode, task: &Task) -> LastStep {
        LastStep::alone(task)
    }

    fn set_parameters(&mut self, _: usize, _: &[f64]) {}
}

/// The steps of a declared system in lanes.
pub(super) struct CompiledLanes<'s, S, const N: usize>(pub &'s S);

impl<S: System<N>, const N: usize> LaneKernel for CompiledLanes<'_, S, N> {
    fn engine<'k>(
        &'k self,
        instructions: Instructions,
        common: &Common,
        values: &[&[f64]; LANES],
    ) -> Box<dyn Engine + 'k> {
        // sparse elimination is not inlined, so it is compiled only for the program's own instructions
        #[cfg(target_arch = "x86_64")]
        if const { !S::SPARSE && OTHERS } {
            use crate::number::lanes::x86::{Avx2, Avx512};
            if instructions >= Instructions::Avx512
                && let Some(token) = Avx512::token()
            {
                return Box::new(Steps::<Avx512, S, N>::new(token, self.0, common, values));
            }
            if instructions >= Instructions::Avx2
                && let Some(token) = Avx2::token()
            {
                return Box::new(Steps::<Avx2, S, N>::new(token, self.0, common, values));
            }
        }
        let _ = instructions;
        Box::new(Steps::<f64x8, S, N>::new((), self.0, common, values))
    }
}

/// The steps in registers of one kind.
struct Steps<'s, R: Chosen, S: System<N>, const N: usize> {
    /// Proof that the machine has them.
    token: R::Token,
    /// The system, for everything but the parameters.
    system: &'s S,
    /// The data that do not change.
    common: Common,
    /// The parameters.
    parameters: S::Parameters<Lanes<R>>,
    /// The known values of the run.
    constants: S::Constants<Lanes<R>>,
    /// The number of coordinates.
    coordinates: PhantomData<[(); N]>,
}

/// The rows of a step, in lanes.
struct Rows<'a, R: Register, S: System<N>, const N: usize> {
    /// The system.
    system: &'a S,
    /// The known values of the run.
    constants: &'a S::Constants<Lanes<R>>,
    /// The known values of the step.
    known: &'a S::Known<Lanes<R>>,
    /// The units of the determinants.
    scales: &'a [Lanes<R>; 2],
    /// The lanes whose past is too short to tell two roots apart.
    past_is_short: u32,
}

impl<R: Chosen, S: System<N>, const N: usize> newton::Equations<R> for Rows<'_, R, S, N> {
    type Z = S::Unknown<Lanes<R>>;

    const MAY_BE_LINEAR: bool = S::LINEAR && !S::JUMPS;

    const MAY_BE_WATCHED: bool = !S::LINEAR && !S::DIVIDED;

    const MAY_BE_SCALED: bool = S::SCALED;

    #[inline(always)]
    fn past_is_short(&self) -> Mask<R> {
        Mask::from_bits(self.past_is_short)
    }

    #[inline(always)]
    fn update(&mut self, z: &Self::Z) -> (Self::Z, Lanes<R>) {
        if let Some(found) = self.sparse_update(z) {
            return found;
        }
        let at = self.system.linearize(self.constants, self.known, z);
        let (solution, determinants) = if Self::MAY_BE_LINEAR {
            Self::Z::solve_scaled(&at.jacobian, &at.rows, self.scales)
        } else {
            Self::Z::solve_lanes(&at.jacobian, &at.rows, self.scales)
        };
        (solution.zip(&solution, |x, _| -x), determinants)
    }

    #[inline(always)]
    fn declared(&mut self, z: &Self::Z, nearby: &Self::Z) -> Mask<R> {
        let here = self.system.scales(self.constants, self.known, z);
        let there = self.system.scales(self.constants, self.known, nearby);
        let mut declared = Mask::splat(true);
        for (&here, &there) in here.as_ref().iter().zip(there.as_ref()) {
            let change = (here - there).abs();
            declared = declared & change.below(Lanes::splat(NEARLY_THE_SAME) * here.abs());
        }
        declared
    }
}

impl<R: Register, S: System<N>, const N: usize> Rows<'_, R, S, N> {
    /// Newton's update by sparse elimination, NaN in lanes where it is inaccurate, and the determinants (see
    /// [`crate::solve::newton::Equations::sparse_update`]).
    #[inline]
    #[allow(clippy::type_complexity)] // as the trait has it
    fn sparse_update(&self, z: &S::Unknown<Lanes<R>>) -> Option<(S::Unknown<Lanes<R>>, Lanes<R>)>
    where
        R: Chosen,
    {
        if const { !S::SPARSE && OTHERS } {
            return None;
        }
        let sparse = self.system.sparse()?;
        let mut determinants = Lanes::splat(if sparse.is_odd() { -1.0 } else { 1.0 });
        let mut scale = &self.scales[0];
        let found = sparse.update(
            |entries| self.system.entries(self.constants, self.known, z, entries),
            |pivot| {
                determinants = determinants * (pivot * *scale);
                scale = &self.scales[1];
            },
        );
        Some((found.update, determinants))
    }
}

impl<'s, R: Chosen, S: System<N>, const N: usize> Steps<'s, R, S, N> {
    /// Whether steps are watched for a second root nearby.
    const WATCHED: bool = !S::LINEAR && !S::DIVIDED;

    /// Steps with the given parameters.
    fn new(token: R::Token, system: &'s S, common: &Common, values: &[&[f64]; LANES]) -> Self {
        let mut parameters = system.parameters::<Lanes<R>>();
        for (lane, values) in values.iter().enumerate() {
            set_lane(parameters.as_mut(), lane, values);
        }
        Self {
            token,
            system,
            constants: system.constants(&parameters, Lanes::splat(common.h)),
            parameters,
            common: *common,
            coordinates: PhantomData,
        }
    }
}

/// Several steps, as a function that is compiled for each kind of register.
struct StepWork<'a, 's, R: Chosen, S: System<N>, const N: usize> {
    /// The steps.
    steps: &'a Steps<'s, R, S, N>,
    /// Their state.
    lane_state: &'a mut LaneState,
    /// Receives the data of the last node.
    lane_node: &'a mut LaneNode,
    /// The steps that are to be made.
    task: &'a Task,
}

impl<R: Chosen, S: System<N>, const N: usize> InLanes for StepWork<'_, '_, R, S, N> {
    type Output = LastStep;

    #[inline(always)]
    fn run(self) -> LastStep {
        let Self {
            steps,
            lane_state,
            lane_node,
            task,
        } = self;
        let (system, constants) = (steps.system, &steps.constants);
        let mut now: LaneRegisters<S::Unknown<Lanes<R>>, R, N> = LaneRegisters::load(lane_state);
        let (mut index, mut elsewhere) = (task.index, task.elsewhere);
        let mut lately = u32::MAX;
        loop {
            if lately != 0 {
                lately = short(task, index);
            }
            let leg = Leg {
                t: if S::DEPENDS_ON_TIME {
                    times(&steps.common.clocks, index).into()
                } else {
                    Lanes::splat(0.0)
                },
                q: now.q.hi,
                d: now.d.hi,
            };
            let known = system.known(constants, &leg);
            let increment = system.unknown(&leg.d, &[]);
            let least = increment.zip(&increment, |d, _| Lanes::splat(SECOND_DIFFERENCE) * d.abs());
            let expected = now.expected(&least);
            let mut rows = Rows {
                system,
                constants,
                known: &known,
                scales: &now.determinants.scales,
                past_is_short: lately,
            };
            let guess = now.predictor.extrapolate_here();
            let roots: Roots<_, R> = newton::solve(
                &mut rows,
                guess,
                &expected,
                steps.common.max_iterations,
                task.active,
            );
            let e = system.second_difference(constants, &known, &roots.z);
            let mut d = now.d;
            d.add(&e);
            let mut q = now.q.plus(&d);
            let mut finite = Mask::<R>::splat(true);
            if !S::ROTATIONS.is_empty() {
                let (from, by) = ([&now.q.hi[..], &now.q.lo], [&d.hi[..], &d.lo]);
                rotation::turn_in(S::ROTATIONS, from, by, [&mut q.hi, &mut q.lo]);
                let longest = rotation::longest_square(S::ROTATIONS, &d.hi);
                finite = longest.below(Lanes::splat(rotation::TOO_FAR));
            }
            for q in &q.hi {
                finite = finite & q.finite();
            }
            let mut alone = task.active & (roots.left | elsewhere | !finite.bits());
            if S::JUMPS && steps.common.may_stick {
                // the lane's own flow decides about a possible rest
                alone |= task.active & !is_near_prediction(guess.as_ref(), roots.z.as_ref()).bits();
            }
            if !guess.as_ref().is_empty() {
                alone |= task.active & now.determinants.ask(roots.determinants);
            }
            if Steps::<R, S, N>::WATCHED {
                alone |= now.determinants.take(roots.determinants, task.active & !alone);
            }
            let is_written = index == task.last;
            if is_written {
                let Report { point, force, energy } = system.report(constants, &known, &leg, &e);
                write_node(&leg.q, &point, &force, (energy, roots.evaluations), lane_node);
            }
            let found = StepResult { q, d, z: roots.z };
            if alone == 0 {
                now.take(&found);
            }
            if alone != 0 || is_written {
                now.store(lane_state);
                if alone != 0 {
                    found.store(lane_state);
                }
                return LastStep {
                    index,
                    alone,
                    is_written,
                };
            }
            index += 1;
            elsewhere = 0;
        }
    }
}

/// The lanes whose past is short at a node, as bits.
pub(super) fn short(task: &Task, index: u64) -> u32 {
    let is_short = |lane: &usize| index.saturating_sub(task.since[*lane]) <= SHORT_PAST;
    (0..LANES)
        .filter(is_short)
        .fold(0, |short, lane| short | 1 << lane)
}

/// The lanes whose solution is close to its prediction, by a slightly stricter test than that of a flow.
#[inline(always)]
pub(super) fn is_near_prediction<R: Register>(guess: &[Lanes<R>], z: &[Lanes<R>]) -> Mask<R> {
    let mut foreseen = Mask::splat(true);
    for (&guess, &z) in guess.iter().zip(z) {
        let close = Lanes::splat(0.999 * NEAR_PREDICTION) * z.abs() + Lanes::splat(f64::MIN_POSITIVE);
        foreseen = foreseen & (z - guess).abs().below(close);
    }
    foreseen
}

/// The times of a node.
#[inline(never)]
pub(super) fn times(clocks: &[Clock; LANES], index: u64) -> [f64; LANES] {
    array::from_fn(|lane| clocks[lane].time_of(index))
}

/// Writes the data of a node from registers.
#[inline(always)]
fn write_node<R: Register, const N: usize>(
    q: &[Lanes<R>; N],
    point: &Point<Lanes<R>, N>,
    force: &[Lanes<R>; N],
    (energy, evaluations): (Lanes<R>, [u32; LANES]),
    lane_node: &mut LaneNode,
) {
    // the reported position is the middle node `q1`, whatever the declared maps are
    let parts = [q, &point.v, &point.a, force];
    for (to, from) in lane_node.vectors.chunks_exact_mut(N).zip(parts) {
        for (to, &from) in to.iter_mut().zip(from) {
            to.0 = from.into();
        }
    }
    lane_node.energy.0 = energy.into();
    lane_node.evaluations = evaluations;
}

/// Sets one lane of the parameters; those beyond the last value are NaN.
fn set_lane<R: Register>(parameters: &mut [Lanes<R>], lane: usize, values: &[f64]) {
    for (place, parameter) in parameters.iter_mut().enumerate() {
        parameter.set_lane(lane, values.get(place).copied().unwrap_or(f64::NAN));
    }
}

impl<R: Chosen, S: System<N>, const N: usize> Engine for Steps<'_, R, S, N> {
    fn steps(&mut self, lane_state: &mut LaneState, lane_node: &mut LaneNode, task: &Task) -> LastStep {
        let steps = &*self;
        R::run(
            self.token,
            StepWork {
                steps,
                lane_state,
                lane_node,
                task,
            },
        )
    }

    fn set_parameters(&mut self, lane: usize, values: &[f64]) {
        set_lane(self.parameters.as_mut(), lane, values);
        self.constants = self
            .system
            .constants(&self.parameters, Lanes::splat(self.common.h));
    }
}
