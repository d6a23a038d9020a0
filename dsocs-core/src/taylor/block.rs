//! Motions that share eight lanes: each with its own steps, the next one begins where one has ended.

use core::ops::ControlFlow;

use super::control::Tolerance;
use super::ensemble::Varied;
use super::flow::TaylorFlow;
use super::integrator::{Integrator, SHORTER};
use super::jets::Recurrences;
use super::kernel::ROWS;
use super::lanes::{self, Ends, Engine};
use super::switch::Reach;
use crate::compensated::Compensated;
use crate::ensemble::Observed;
use crate::instructions::Instructions;
use crate::lanes::LANES;
use crate::run::roots::Crossing;
use crate::run::{End, Observer, RunError, Stepper as _};
use crate::start::Start;
use crate::system::System;

/// What all motions have in common.
pub(super) struct Run<'s, S: System<N>, const N: usize> {
    /// The system.
    pub system: &'s S,
    /// The parameters that vary.
    pub varied: &'s Varied<S>,
    /// The tolerance.
    pub tolerance: Tolerance,
    /// How many steps are allowed.
    pub max_steps: u64,
    /// The distance of the nodes in time; `None` where they lie at the ends of steps.
    pub every: Option<f64>,
    /// How far to go.
    pub t: f64,
    /// Whether nodes are observed.
    pub observes: bool,
    /// The instructions.
    pub instructions: Instructions,
}

/// A motion.
struct Member<'s, S: System<N>, O, const N: usize> {
    flow: TaylorFlow<'s, S, N>,
    /// Its place among the starts.
    place: usize,
    observer: O,
    /// Where it ends.
    end: End,
    /// The step that is tried.
    step: Trial,
    /// Whether that is a second trial.
    again: bool,
    /// Whether the flow knows all of the series at the current point, as after a step of its own.
    is_complete: bool,
    /// Whether it makes all steps alone.
    stays_alone: bool,
}

/// A step that is tried.
#[derive(Clone, Copy, Default)]
struct Trial {
    /// Where the steps go to, the way that is left, and the step's length.
    until: f64,
    left: f64,
    size: f64,
    /// The shortest that is tried.
    smallest: f64,
}

impl Trial {
    /// Whether it goes all the way.
    fn is_whole(&self) -> bool {
        self.size == self.left.abs()
    }

    fn h(&self) -> f64 {
        if self.is_whole() {
            self.left
        } else {
            self.size.copysign(self.left)
        }
    }
}

/// How a motion goes on.
enum Goes {
    /// With a step of its lane.
    On,
    /// With a step of its own.
    Alone,
    /// Not at all.
    Ended(Result<(), RunError>),
}

impl<'s, S: System<N>, const N: usize> Run<'s, S, N> {
    /// Runs some motions, the first of which has this place among all, and returns them in their order.
    pub fn block<O: Observer<N>>(
        &self,
        first: usize,
        starts: &[Start<N>],
        observer: &dyn Fn(usize) -> O,
    ) -> Vec<Observed<O, N>> {
        let mut ended: Vec<Option<Observed<O, N>>> = starts.iter().map(|_| None).collect();
        let mut queue = (first..).zip(starts);
        let mut members: [Option<Member<'s, S, O, N>>; LANES] = [const { None }; LANES];
        let mut lanes = Lanes {
            engine: lanes::engine(self.instructions, self.system),
            ends: Ends::new(),
            crossings: Vec::with_capacity(ROWS),
        };
        let mut idle = 0_u32;
        loop {
            let (mut h, mut orders, mut active) = ([0.0; LANES], [2; LANES], 0_u32);
            for lane in 0..LANES {
                loop {
                    if members[lane].is_none() {
                        let Some((place, &start)) = queue.next() else {
                            if idle >> lane & 1 == 0 {
                                lanes.engine.clear(lane);
                                idle |= 1 << lane;
                            }
                            break;
                        };
                        match self.begin(place, start, observer(place)) {
                            Ok(member) => {
                                if self.varied.is_some() {
                                    lanes.engine.set_parameters(lane, member.flow.system());
                                }
                                members[lane] = Some(member);
                            }
                            Err(failed) => {
                                ended[place - first] = Some(failed);
                                continue;
                            }
                        }
                    }
                    let Some(member) = &mut members[lane] else {
                        continue;
                    };
                    match member.propose(lane, &mut lanes, self.observes) {
                        Goes::On => {
                            (h[lane], orders[lane]) = (member.step.h(), member.flow.motion.next.order());
                            active |= 1 << lane;
                            break;
                        }
                        Goes::Alone => {
                            if let Err(error) = member.go_alone(lane, &mut lanes) {
                                let member = members[lane].take();
                                put(&mut ended, first, member, Err(error));
                            }
                        }
                        Goes::Ended(result) => {
                            let member = members[lane].take();
                            put(&mut ended, first, member, result);
                        }
                    }
                }
            }
            if active == 0 {
                break;
            }
            lanes.step(&mut members, &h, orders, active);
        }
        // all have ended
        ended.into_iter().flatten().collect()
    }

    /// A motion at its start, whose first step is made.
    fn begin<O: Observer<N>>(
        &self,
        place: usize,
        start: Start<N>,
        observer: O,
    ) -> Result<Member<'s, S, O, N>, Observed<O, N>> {
        let begun = || -> Result<(TaylorFlow<'s, S, N>, End), RunError> {
            if !self.t.is_finite() {
                return Err(RunError::Until { until: self.t });
            }
            let equations = Recurrences::held(self.varied.system(self.system, place)).rounded();
            let mut flow = TaylorFlow::of(equations, start, self.tolerance)?.max_steps(self.max_steps);
            flow.motion.rounded = true;
            match self.every {
                Some(h) => flow = flow.every(h)?,
                None if self.t < flow.time() => flow.reverse()?,
                None => {}
            }
            let end = flow.motion.clock.until(self.t)?;
            Ok((flow, end))
        };
        match begun() {
            Ok((flow, end)) => Ok(Member {
                flow,
                place,
                observer,
                end,
                step: Trial::default(),
                again: false,
                is_complete: true,
                stays_alone: false,
            }),
            Err(error) => Err(Observed {
                observer,
                last: Err(error),
            }),
        }
    }
}

/// Puts a motion that has ended where it belongs.
fn put<S: System<N>, O, const N: usize>(
    ended: &mut [Option<Observed<O, N>>],
    first: usize,
    member: Option<Member<'_, S, O, N>>,
    result: Result<(), RunError>,
) {
    if let Some(member) = member {
        ended[member.place - first] = Some(Observed {
            last: result.map(|()| member.flow.node()),
            observer: member.observer,
        });
    }
}

/// The lanes of a block.
struct Lanes<'s, S, const N: usize> {
    engine: Box<dyn Engine<S, N> + 's>,
    ends: Ends<N>,
    /// What the search for switches fills.
    crossings: Vec<Crossing>,
}

impl<S: System<N>, const N: usize> Lanes<'_, S, N> {
    /// Tries a step of every lane that is active.
    fn step<O: Observer<N>>(
        &mut self,
        members: &mut [Option<Member<'_, S, O, N>>; LANES],
        h: &[f64; LANES],
        mut orders: [usize; LANES],
        active: u32,
    ) {
        // idle lanes follow one that goes on: what is no number would cost time
        let Some(living) = members.iter().position(Option::is_some) else {
            return;
        };
        for lane in 0..LANES {
            let from = if active >> lane & 1 == 1 { lane } else { living };
            orders[lane] = orders[from];
            if let Some(member) = &members[from] {
                let Integrator { t, q, v, .. } = &member.flow.motion;
                self.ends.set(lane, t.hi[0], q, v);
            }
        }
        self.engine.arrive(h, &mut self.ends);
        for (lane, member) in members.iter_mut().enumerate() {
            if let Some(member) = member {
                member.arrive(lane, &mut self.ends);
            }
        }
        let asked = members.iter().flatten().map(Member::first_asked).min();
        self.engine.expand(&self.ends, &orders, asked.unwrap_or(2));
        let mut back = 0;
        for (lane, member) in members.iter_mut().enumerate() {
            if let Some(member) = member
                && !member.judge(lane, self)
            {
                back |= 1 << lane;
            }
        }
        self.engine.go_on(back);
        for (lane, member) in members.iter_mut().enumerate() {
            if let Some(member) = member
                && back >> lane & 1 == 0
                && member.flow.motion.on_grid.is_some()
                && member.flow.motion.reaches_node()
            {
                self.engine.last(lane, &mut member.flow.motion.series);
            }
        }
    }
}

impl<S: System<N>, O: Observer<N>, const N: usize> Member<'_, S, O, N> {
    /// The lowest order whose coefficient the control of the step asks for, beyond order 1.
    fn first_asked(&self) -> usize {
        let motion = &self.flow.motion;
        let current = motion.order.current();
        if motion.next.order() > current {
            motion.order.below() - 1
        } else {
            current - 1
        }
    }

    /// The next step; nodes on the way are observed if asked for.
    fn propose(&mut self, lane: usize, lanes: &mut Lanes<'_, S, N>, observes: bool) -> Goes {
        let TaylorFlow { motion, equations } = &mut self.flow;
        if core::mem::take(&mut self.again) {
            return Goes::On;
        }
        let observer: Option<&mut dyn Observer<N>> = if observes { Some(&mut self.observer) } else { None };
        let until = match motion.hand_nodes_out(equations, &self.end, observer) {
            ControlFlow::Continue(until) => until,
            ControlFlow::Break(()) => return Goes::Ended(Ok(())),
        };
        self.stays_alone |= self.is_complete && equations.has_pieces_here();
        if self.stays_alone || motion.is_new || motion.steps >= motion.looks_at() {
            return Goes::Alone;
        }
        let left = (until - motion.t.hi[0]) - motion.t.lo[0];
        let smallest = motion.smallest_step(until);
        core::mem::swap(&mut motion.series, &mut motion.next);
        let wanted = motion.wanted();
        motion.next.set_order(motion.order.next());
        let mut size = wanted.min(left.abs());
        let mut alone = wanted.is_nan() || wanted < smallest || !motion.series.is_finite();
        let (order, limits) = (motion.series.order(), motion.control.limits);
        let switches = if self.is_complete {
            equations.steep()
        } else {
            lanes.engine.switches(lane)
        };
        for switch in switches {
            match switch.reach(order, size.copysign(left), &limits, &mut lanes.crossings) {
                Reach::Whole => {}
                Reach::Shorter(part) => size *= part,
                Reach::Crossing(_) => alone = true,
            }
        }
        if alone {
            core::mem::swap(&mut motion.series, &mut motion.next);
            return Goes::Alone;
        }
        self.step = Trial {
            until,
            left,
            size,
            smallest,
        };
        Goes::On
    }

    /// Makes a step in a single flow, as at the start and where its lane does not know enough.
    #[cold]
    fn go_alone(&mut self, lane: usize, lanes: &mut Lanes<'_, S, N>) -> Result<(), RunError> {
        let TaylorFlow { motion, equations } = &mut self.flow;
        if !self.is_complete {
            motion.begin(equations);
        }
        let until = motion.towards(&self.end);
        motion.go(equations, until)?;
        self.is_complete = true;
        lanes.engine.take(lane, &motion.next);
        Ok(())
    }

    /// Brings the end of a step back onto the constraints.
    fn arrive(&mut self, lane: usize, ends: &mut Ends<N>) {
        let TaylorFlow { motion, equations } = &mut self.flow;
        let t = if self.step.is_whole() {
            self.step.until
        } else {
            motion.t.hi[0] + self.step.h()
        };
        ends.t[lane] = t;
        if let Some(projection) = &mut motion.projection {
            let (mut q, mut v, _) = ends.get(lane);
            projection.apply(equations, t, &mut q, &mut v);
            ends.set(lane, t, &q, &v);
        }
    }

    /// Whether the step was good. If so it is taken, else it will be tried again.
    fn judge(&mut self, lane: usize, lanes: &mut Lanes<'_, S, N>) -> bool {
        let asked = self.first_asked();
        let TaylorFlow { motion, .. } = &mut self.flow;
        let Trial {
            until,
            size,
            smallest,
            ..
        } = self.step;
        if lanes.engine.has_compared(lane) {
            // pieces of a function: the step is made alone
            core::mem::swap(&mut motion.series, &mut motion.next);
            (self.stays_alone, self.is_complete) = (true, false);
            return false;
        }
        let (q, v, a) = lanes.ends.get(lane);
        motion.next.begin(lanes.ends.t[lane], &q.hi, &v.hi);
        lanes.engine.tell(lane, asked, &mut motion.next);
        // a velocity that jumps where no expansion shows a switch
        let jumps = motion.moved(self.step.h()).is_some();
        let good = !jumps && motion.control.good(&motion.series, &motion.next, &a, size);
        if jumps || (!good && size <= smallest) {
            // what this is, the step says that is made alone
            core::mem::swap(&mut motion.series, &mut motion.next);
            self.stays_alone |= jumps;
            self.is_complete = false;
            return false;
        }
        self.again = !good;
        if self.again {
            motion.rejected += 1;
            motion.expansions = motion.expansions.saturating_add(1);
            self.step.size = (SHORTER * size).max(smallest);
            return false;
        }
        motion.last = Some((motion.t, self.step.h()));
        if self.step.is_whole() {
            motion.t = Compensated::exact([until]);
        } else {
            motion.t.add(&[self.step.h()]);
        }
        (motion.q, motion.v) = (q, v);
        motion.steps += 1;
        self.is_complete = false;
        motion.expansions = motion.expansions.saturating_add(1);
        true
    }
}
