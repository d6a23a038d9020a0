//! One block: up to eight trajectories, step by step.

use core::array;
use core::num::NonZeroU64;

use super::Observed;
use super::engine::{Common, Engine, Kept, Task, Told, engine};
use super::held::{self, Change, HeldInputs};
use crate::declaration::Declaration;
use crate::flow::Flow;
use crate::flow::discrete::{Discrete, values_of};
use crate::instructions::Instructions;
use crate::lanes::LANES;
use crate::run::{Inputs as _, Node, Observer, RunError, Stepper as _};
use crate::start::Start;
use crate::system::System;

/// What all blocks have in common.
pub(super) struct Run<'s, S: System<N>, const N: usize> {
    /// The system.
    pub system: &'s S,
    /// The parameters that vary, by their places, each with a value for every start.
    pub varied: &'s [(usize, Vec<f64>)],
    /// The parameters that change.
    pub held: &'s [HeldInputs],
    /// The step.
    pub h: f64,
    /// How far to go.
    pub t: f64,
    /// Which nodes are observed: those whose number is a multiple of this.
    pub every: Option<NonZeroU64>,
    /// How often the rows of a step may be evaluated from one guess.
    pub max_iterations: u32,
    /// The instructions of the steps.
    pub instructions: Instructions,
}

/// A trajectory with its lane.
struct Member<'s, O, const N: usize> {
    /// The trajectory for itself, where it begins and where its lane cannot go on.
    flow: Flow<'s, N>,
    /// The number of its last node.
    last: u64,
    /// Its place among the starts of the block.
    place: usize,
    /// The changes of its parameters that are left, the first one last.
    changes: Vec<Change>,
    /// Its observer.
    observer: O,
}

/// Up to eight trajectories that have begun, and what their lanes hold.
struct Block<'r, 's, S: System<N>, O, const N: usize> {
    /// What all blocks have in common.
    run: &'r Run<'s, S, N>,
    /// The trajectories, by lane.
    members: Vec<Member<'s, O, N>>,
    /// How they ended.
    ended: Vec<Option<Result<Node<N>, RunError>>>,
    /// The lanes whose trajectories go on, as bits.
    active: u32,
    /// What their next steps depend on.
    kept: Kept<S, N>,
    /// The steps.
    engine: Box<dyn Engine<S, N> + 's>,
    /// The number of the next step's middle node.
    index: u64,
    /// In each lane, the position at which the past begins.
    since: [u64; LANES],
}

/// The numbers of the lanes whose bits are set.
fn lanes(bits: u32) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| bits >> lane & 1 == 1)
}

impl<'s, S: System<N>, const N: usize> Run<'s, S, N> {
    /// Runs one block, whose first start has this place among all.
    pub fn block<O: Observer<N>>(
        &self,
        first: usize,
        starts: &[Start<N>],
        observers: Vec<O>,
    ) -> Vec<Observed<O, N>> {
        let mut members = Vec::with_capacity(starts.len());
        let mut ended: Vec<(usize, Observed<O, N>)> = Vec::with_capacity(starts.len());
        for (place, (&start, mut observer)) in starts.iter().zip(observers).enumerate() {
            match self.begin(first + place, start, &mut observer) {
                Ok(Begun::Going { flow, last, changes }) => members.push(Member {
                    flow: *flow,
                    last,
                    place,
                    changes,
                    observer,
                }),
                Ok(Begun::Ended(node)) => ended.push((
                    place,
                    Observed {
                        observer,
                        last: Ok(node),
                    },
                )),
                Err(error) => ended.push((
                    place,
                    Observed {
                        observer,
                        last: Err(error),
                    },
                )),
            }
        }
        if !members.is_empty() {
            ended.extend(Block::new(self, members).run());
        }
        ended.sort_by_key(|(place, _)| *place);
        ended.into_iter().map(|(_, observed)| observed).collect()
    }

    /// The nodes 0 and 1, which need a guess without a past.
    fn begin<O: Observer<N>>(
        &self,
        place: usize,
        start: Start<N>,
        observer: &mut O,
    ) -> Result<Begun<'s, N>, RunError> {
        let values = self.values_of(place, start.time());
        let flow = Discrete::new(self.system.kernel(), values, self.h, &start.given())?;
        let mut flow = Flow::<N>(flow).max_iterations(self.max_iterations);
        let end = flow.clock().until(self.t)?;
        if self.t.is_infinite() && self.every.is_none() {
            return Err(RunError::Until { until: self.t });
        }
        let last = end.index().unwrap_or(u64::MAX);
        let mut changes = held::changes(self.held, place, (flow.clock(), self.h), |parameter| {
            let values = self.values_of(place, f64::NEG_INFINITY);
            values.get(parameter).copied().unwrap_or(f64::NAN)
        });
        for index in 0..2 {
            self.change(&mut flow, index, &mut changes)?;
            flow.run_mut().go_on(&end)?;
            let node = flow.node();
            if self.observes(index) && observer.node(&node).is_break() || index == last {
                return Ok(Begun::Ended(node));
            }
        }
        Ok(Begun::Going {
            flow: Box::new(flow),
            last,
            changes,
        })
    }

    /// Gives a flow the parameters that hold from a position on.
    fn change(&self, flow: &mut Flow<'s, N>, index: u64, changes: &mut Vec<Change>) -> Result<(), RunError> {
        while let Some(change) = changes.pop_if(|change| change.index == index) {
            flow.set_input(&S::PARAMETERS[change.place].name, change.value)?;
        }
        Ok(())
    }

    /// The values of the parameters of one trajectory at a time.
    fn values_of(&self, place: usize, t: f64) -> Vec<f64> {
        let mut values = values_of(self.system.kernel());
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

/// A trajectory at node 1.
enum Begun<'s, const N: usize> {
    /// It goes on, to node `last`.
    Going {
        /// The trajectory.
        flow: Box<Flow<'s, N>>,
        /// The number of its last node.
        last: u64,
        /// The changes that are left.
        changes: Vec<Change>,
    },
    /// It ends with this node.
    Ended(Node<N>),
}

impl<'r, 's, S: System<N>, O: Observer<N>, const N: usize> Block<'r, 's, S, O, N> {
    /// Puts trajectories into lanes. Lanes that are left over repeat them.
    fn new(run: &'r Run<'s, S, N>, members: Vec<Member<'s, O, N>>) -> Self {
        let of_lane = |lane: usize| &members[lane % members.len()].flow;
        let common = Common {
            system: run.system,
            h: run.h,
            max_iterations: run.max_iterations,
            may_stick: S::JUMPS && Declaration::of(run.system).sides() > 0,
            clocks: array::from_fn(|lane| *of_lane(lane).clock()),
        };
        let mut engine = engine(run.instructions, common);
        let mut kept = Kept::<S, N>::new();
        for lane in 0..LANES {
            engine.set_parameters(lane, &of_lane(lane).0.values);
            kept.set_lane(lane, &of_lane(lane).0.course);
        }
        Self {
            run,
            ended: members.iter().map(|_| None).collect(),
            active: (1 << members.len()) - 1,
            kept,
            engine,
            index: 2,
            since: array::from_fn(|lane| of_lane(lane).0.course.since),
            members,
        }
    }

    /// Runs all trajectories to their ends; each comes with its place among the starts.
    fn run(mut self) -> impl Iterator<Item = (usize, Observed<O, N>)> {
        let mut wanted = self.next_node_wanted();
        while self.active != 0 {
            let task = Task {
                index: self.index,
                last: self.before_changes(wanted),
                active: self.active,
                elsewhere: self.elsewhere(),
                since: self.since,
            };
            let made = self.engine.steps(&mut self.kept, &task);
            self.index = made.index;
            if let Some(held_back) = &made.held_back {
                self.solve_alone(made.alone);
                self.kept.take(held_back);
                self.take_back(made.alone);
            }
            if let Some(told) = made.told.as_ref().filter(|_| self.index == wanted) {
                self.hand_out(told, made.alone);
            }
            self.index += 1;
            // where a lane has failed, what was wanted may lie behind
            if self.index > wanted {
                wanted = self.next_node_wanted();
            }
        }
        self.members
            .into_iter()
            .zip(self.ended)
            .filter_map(|(member, last)| {
                let Member { place, observer, .. } = member;
                last.map(|last| (place, Observed { observer, last }))
            })
    }

    /// The lanes whose parameters change at the middle node of the next step, or in which something rests where a function jumps, as bits.
    fn elsewhere(&self) -> u32 {
        let changes = |lane: usize| {
            let Member { changes, flow, .. } = &self.members[lane];
            let next = changes.last();
            next.is_some_and(|change| change.index == self.index)
                || S::JUMPS && flow.0.is_stuck_at(self.index)
        };
        lanes(self.active)
            .filter(|&lane| changes(lane))
            .fold(0, |bits, lane| bits | 1 << lane)
    }

    /// The last step, up to the one about the node `wanted`, before parameters change after the next step.
    fn before_changes(&self, wanted: u64) -> u64 {
        let later = |lane: usize| {
            let mut changes = self.members[lane].changes.iter().rev();
            changes.find(|change| change.index > self.index)
        };
        lanes(self.active)
            .filter_map(later)
            .fold(wanted, |last, change| last.min(change.index - 1))
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
    fn solve_alone(&mut self, alone: u32) {
        for lane in lanes(alone) {
            let Member { flow, changes, .. } = &mut self.members[lane];
            self.kept.put(lane, &mut flow.0.course);
            flow.0.course.resume(self.index);
            let left = changes.len();
            let solved = self.run.change(flow, self.index, changes);
            let solved = solved.and_then(|()| flow.advance().map(drop));
            if changes.len() < left {
                self.engine.set_parameters(lane, &flow.0.values);
                self.since[lane] = flow.0.course.since;
            }
            if let Err(error) = solved {
                self.end(lane, Err(error));
            }
        }
    }

    /// Puts the solutions of single lanes back.
    #[cold]
    #[inline(never)]
    fn take_back(&mut self, alone: u32) {
        for lane in lanes(alone & self.active) {
            self.kept.set_lane(lane, &self.members[lane].flow.0.course);
        }
        self.cover();
    }

    /// Ends a trajectory.
    fn end(&mut self, lane: usize, last: Result<Node<N>, RunError>) {
        self.active &= !(1 << lane);
        self.ended[lane] = Some(last);
    }

    /// Lets the lanes whose trajectories have ended follow one that goes on: what is no number, or far from where a
    /// system has a solution, would cost time.
    fn cover(&mut self) {
        if let Some(living) = lanes(self.active).next() {
            let course = &mut self.members[living].flow.0.course;
            self.kept.put(living, course);
            for lane in lanes(!self.active) {
                self.kept.set_lane(lane, course);
            }
        }
    }

    /// Hands the middle nodes of a step out, to observers and to the trajectories that end there.
    fn hand_out(&mut self, told: &Told<N>, alone: u32) {
        let observed = self.run.observes(self.index);
        let going = self.active;
        for lane in lanes(going) {
            let member = &mut self.members[lane];
            let node = if alone >> lane & 1 == 1 {
                member.flow.node()
            } else {
                told.node(lane, self.index, member.flow.clock().time_of(self.index))
            };
            if observed && member.observer.node(&node).is_break() || self.index == member.last {
                self.end(lane, Ok(node));
            }
        }
        if self.active != going {
            self.cover();
        }
    }
}
