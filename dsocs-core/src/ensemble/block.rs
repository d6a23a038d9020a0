//! One block: up to eight trajectories, step by step.

use core::array;
use core::num::NonZeroU64;
use core::ops::ControlFlow;

use super::engine::{Common, Engine, LaneKernel, LaneNode, Task};
use super::held::{self, HeldInputs, ParameterChange};
use super::lane_state::LaneState;
use crate::flow::discrete::{Discrete, values_of};
use crate::kernel::Kernel;
use crate::number::instructions::Instructions;
use crate::number::lanes::LANES;
use crate::regularity::sticking::Outlook;
use crate::run::{AnyNode, OwnedNode, Run as _, RunError, inputs};
use crate::start::StartData;
use crate::tape::Shape;
use crate::tape::declaration::Declaration;

/// The data that all blocks share.
pub(super) struct EnsembleRun<'s> {
    /// The system.
    pub kernel: &'s dyn Kernel,
    /// Its steps in lanes.
    pub lanes: &'s dyn LaneKernel,
    /// The parameters that vary, by their places, each with a value for every start.
    pub varied: &'s [(usize, Vec<f64>)],
    /// The parameters that change during the runs.
    pub held: &'s [HeldInputs],
    /// The step.
    pub h: f64,
    /// The time to run to.
    pub t: f64,
    /// The observed nodes: those whose number is a multiple of this.
    pub every: Option<NonZeroU64>,
    /// Largest number of evaluations of a step's rows from one guess.
    pub max_iterations: u32,
    /// The instructions of the steps.
    pub instructions: Instructions,
}

/// Receives the nodes of a block's trajectories, by their places among its starts.
pub(super) trait BlockObserver {
    /// Receives an observed node, and may end the trajectory with it.
    fn node(&mut self, place: usize, node: &AnyNode<'_>) -> ControlFlow<()>;

    /// Receives the last node, or the error with which the trajectory ended early.
    fn end(&mut self, place: usize, last: Result<&AnyNode<'_>, RunError>);
}

/// A trajectory with its lane.
struct Member<'s> {
    /// The trajectory as a flow, for its beginning and for steps that its lane cannot make.
    flow: Discrete<'s>,
    /// The number of its last node.
    last: u64,
    /// Its place among the starts of the block.
    place: usize,
    /// The remaining changes of its parameters, the first one last.
    changes: Vec<ParameterChange>,
}

/// Up to eight trajectories that have begun, and the content of their lanes.
struct Block<'r, 's> {
    /// The data that all blocks share.
    run: &'r EnsembleRun<'s>,
    /// The trajectories, by lane.
    members: Vec<Member<'s>>,
    /// The lanes whose trajectories continue, as bits.
    active: u32,
    /// The state of the lanes between steps.
    lane_state: LaneState,
    /// The last node of the lanes.
    lane_node: LaneNode,
    /// A node for the observers.
    node: OwnedNode,
    /// The steps.
    engine: Box<dyn Engine + 'r>,
    /// The number of the next step's middle node.
    index: u64,
    /// In each lane, the number of the position at which the past begins.
    since: [u64; LANES],
}

/// The numbers of the lanes whose bits are set.
fn lanes(bits: u32) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| bits >> lane & 1 == 1)
}

impl<'s> EnsembleRun<'s> {
    /// The shape of the system.
    fn shape(&self) -> &'s Shape {
        self.kernel.shape()
    }

    /// Runs one block; `first` is the place of its first start among all.
    pub fn block(&self, first: usize, starts: &[StartData], observer: &mut dyn BlockObserver) {
        let mut members = Vec::with_capacity(starts.len());
        let mut node = OwnedNode::new(self.shape().dimension());
        for (place, start) in starts.iter().enumerate() {
            match self.begin((first, place), start, &mut node, observer) {
                Ok(Some(member)) => members.push(member),
                Ok(None) => observer.end(place, Ok(&node.any())),
                Err(error) => observer.end(place, Err(error)),
            }
        }
        if !members.is_empty() {
            Block::new(self, members, node).run(observer);
        }
    }

    /// Makes the nodes 0 and 1, which need a guess without a past. `None` if the trajectory ends with `node`.
    fn begin(
        &self,
        (first, place): (usize, usize),
        start: &StartData,
        node: &mut OwnedNode,
        observer: &mut dyn BlockObserver,
    ) -> Result<Option<Member<'s>>, RunError> {
        start.fits(self.shape())?;
        let values = self.values_of(first + place, start.t0);
        let mut flow = Discrete::new(self.kernel, values, self.h, start)?;
        flow.run_state.max_iterations = self.max_iterations;
        let end = flow.clock().until(self.t)?;
        if self.t.is_infinite() && self.every.is_none() {
            return Err(RunError::Until { until: self.t });
        }
        let last = end.index().unwrap_or(u64::MAX);
        let mut changes = held::changes(self.held, first + place, (flow.clock(), self.h), |parameter| {
            let values = self.values_of(first + place, f64::NEG_INFINITY);
            values.get(parameter).copied().unwrap_or(f64::NAN)
        });
        for index in 0..2 {
            self.change(&mut flow, index, &mut changes)?;
            flow.go_on(&end)?;
            node.take(&flow);
            if self.observes(index) && observer.node(place, &node.any()).is_break() || index == last {
                return Ok(None);
            }
        }
        Ok(Some(Member {
            flow,
            last,
            place,
            changes,
        }))
    }

    /// Sets the parameters of a flow that hold from a position on.
    fn change(
        &self,
        flow: &mut Discrete<'s>,
        index: u64,
        changes: &mut Vec<ParameterChange>,
    ) -> Result<(), RunError> {
        while let Some(ParameterChange { place, value, .. }) = changes.pop_if(|change| change.index == index)
        {
            if let Some(parameter) = self.shape().parameters.get(place) {
                inputs::place(self.shape(), &parameter.name, value)?;
            }
            flow.set_value(place, value)?;
        }
        Ok(())
    }

    /// The values of one trajectory's parameters at a time.
    fn values_of(&self, place: usize, t: f64) -> Vec<f64> {
        let mut values = values_of(self.kernel);
        let varied = self
            .varied
            .iter()
            .map(|(parameter, values)| (*parameter, values.get(place).copied()));
        let held = self
            .held
            .iter()
            .map(|held| (held.place, held.at(place, t, self.h)));
        for (parameter, value) in varied.chain(held) {
            if let (Some(parameter), Some(value)) = (values.get_mut(parameter), value) {
                *parameter = value;
            }
        }
        values
    }

    /// Whether node `index` is observed.
    #[inline]
    fn observes(&self, index: u64) -> bool {
        self.every.is_some_and(|every| index.is_multiple_of(every.get()))
    }
}

impl<'r, 's> Block<'r, 's> {
    /// Puts trajectories into lanes; unused lanes repeat them.
    fn new(run: &'r EnsembleRun<'s>, members: Vec<Member<'s>>, node: OwnedNode) -> Self {
        let shape = run.shape();
        let of_lane = |lane: usize| &members[lane % members.len()].flow;
        let common = Common {
            h: run.h,
            max_iterations: run.max_iterations,
            may_stick: shape.jumps && Declaration::of(run.kernel).sides() > 0,
            clocks: array::from_fn(|lane| *of_lane(lane).clock()),
        };
        let values: [&[f64]; LANES] = array::from_fn(|lane| of_lane(lane).values());
        let engine = run.lanes.engine(run.instructions, &common, &values);
        let mut lane_state = LaneState::new(shape);
        for lane in 0..LANES {
            lane_state.set_lane(lane, &of_lane(lane).run_state);
        }
        Self {
            run,
            active: (1 << members.len()) - 1,
            lane_state,
            lane_node: LaneNode::new(shape.dimension()),
            node,
            engine,
            index: 2,
            since: array::from_fn(|lane| of_lane(lane).run_state.since),
            members,
        }
    }

    /// Runs all trajectories to their ends.
    fn run(mut self, observer: &mut dyn BlockObserver) {
        let mut wanted = self.next_node_wanted();
        while self.active != 0 {
            // a lane that looks at this step says when it looks next
            let elsewhere = self.elsewhere();
            let task = Task {
                index: self.index,
                last: self.before_changes(wanted),
                active: self.active,
                elsewhere,
                since: self.since,
            };
            let made = self
                .engine
                .steps(&mut self.lane_state, &mut self.lane_node, &task);
            self.index = made.index;
            if made.alone != 0 {
                self.solve_alone(made.alone, observer);
                self.lane_state.take();
                self.take_back(made.alone);
            }
            if made.is_written && self.index == wanted {
                self.hand_out(made.alone, observer);
            }
            self.index += 1;
            // after a failure in a lane, the wanted node may lie behind
            if self.index > wanted {
                wanted = self.next_node_wanted();
            }
        }
    }

    /// The lanes, as bits, whose next step a flow makes: those whose parameters change at its middle node, or in which an argument of a
    /// piecewise function may change its sign.
    fn elsewhere(&mut self) -> u32 {
        let mut elsewhere = 0;
        for lane in lanes(self.active) {
            let Member { changes, flow, .. } = &mut self.members[lane];
            let changes = changes.last().is_some_and(|change| change.index == self.index);
            let looks = flow.run_state.next_examination <= self.index;
            // the lane's own flow decides about a possible rest: it knows the state of the contacts
            let asks = changes || looks && self.run.shape().jumps;
            if looks && !asks {
                self.lane_state.put(lane, &mut flow.run_state);
                flow.run_state.resume(self.index);
            }
            if asks || looks && !matches!(flow.outlook(), Outlook::Clear(_)) {
                elsewhere |= 1 << lane;
            }
        }
        elsewhere
    }

    /// The middle node of the last step, `wanted` at most, before one that some lane has to make in its own flow: where its parameters
    /// change, or arguments of piecewise functions are evaluated.
    fn before_changes(&self, wanted: u64) -> u64 {
        let later = |lane: usize| {
            let Member { changes, flow, .. } = &self.members[lane];
            let mut changes = changes.iter().rev();
            let change = changes.find(|change| change.index > self.index);
            let looks = Some(flow.run_state.next_examination).filter(|&looks| looks > self.index);
            change.map(|change| change.index).into_iter().chain(looks)
        };
        lanes(self.active)
            .flat_map(later)
            .fold(wanted, |last, index| last.min(index - 1))
    }

    /// The number of the next node that is the last of a trajectory or is observed.
    fn next_node_wanted(&self) -> u64 {
        let last = lanes(self.active).map(|lane| self.members[lane].last).min();
        let observed = self
            .run
            .every
            .and_then(|every| self.index.checked_next_multiple_of(every.get()));
        let wanted = last.unwrap_or(self.index).max(self.index);
        observed.map_or(wanted, |observed| observed.min(wanted))
    }

    /// Solves the step in single lanes, from every guess and with damping.
    #[cold]
    #[inline(never)]
    fn solve_alone(&mut self, alone: u32, observer: &mut dyn BlockObserver) {
        for lane in lanes(alone) {
            let Member {
                flow, changes, place, ..
            } = &mut self.members[lane];
            self.lane_state.put(lane, &mut flow.run_state);
            flow.run_state.resume(self.index);
            let left = changes.len();
            let solved = self.run.change(flow, self.index, changes);
            let solved = solved.and_then(|()| flow.step(f64::INFINITY).map(drop));
            if changes.len() < left {
                self.engine.set_parameters(lane, flow.values());
                self.since[lane] = flow.run_state.since;
            }
            if let Err(error) = solved {
                observer.end(*place, Err(error));
                self.active &= !(1 << lane);
            }
        }
    }

    /// Copies the solutions of single lanes back.
    #[cold]
    #[inline(never)]
    fn take_back(&mut self, alone: u32) {
        for lane in lanes(alone & self.active) {
            self.lane_state.set_lane(lane, &self.members[lane].flow.run_state);
        }
        self.cover();
    }

    /// Lets the lanes of ended trajectories repeat one that continues: NaN, or states far from a solution,
    /// would cost time.
    fn cover(&mut self) {
        if let Some(living) = lanes(self.active).next() {
            for lane in lanes(!self.active) {
                self.lane_state.repeat(living, lane);
            }
        }
    }

    /// Hands out the middle nodes of a step, to observers and to the trajectories that end there.
    fn hand_out(&mut self, alone: u32, observer: &mut dyn BlockObserver) {
        let observed = self.run.observes(self.index);
        let going = self.active;
        for lane in lanes(going) {
            let Member {
                flow, place, last, ..
            } = &self.members[lane];
            if alone >> lane & 1 == 1 {
                self.node.take(flow);
            } else {
                let t = flow.clock().time_of(self.index);
                self.lane_node
                    .write(lane, self.index, t, &mut self.node.as_node_mut());
            }
            let node = self.node.any();
            if observed && observer.node(*place, &node).is_break() || self.index == *last {
                observer.end(*place, Ok(&node));
                self.active &= !(1 << lane);
            }
        }
        if self.active != going {
            self.cover();
        }
    }
}
