//! Motions that share eight lanes: each has its own steps, and the next one begins where one has ended.

use core::ops::ControlFlow;

use super::control::{Assessment, Sizes, Tolerance};
use super::ensemble::{SeriesKernels, Varied};
use super::flow::{AnyTaylorFlow, TaylorFlow};
use super::grid::Visit;
use super::integrator::Integrator;
use super::lanes::{Ends, LaneSeries};
use super::projection::Projection;
use super::trial::SHORTER;
use crate::ensemble::ObservedRun;
use crate::kernel::clock::End;
use crate::number::compensated::Compensated;
use crate::number::instructions::Instructions;
use crate::number::lanes::LANES;
use crate::run::{Node, Observer, RunError, Stepper as _};
use crate::series::orders::ROWS;
use crate::series::roots::Crossing;
use crate::series::switch::Reach;
use crate::start::Start;

/// The data that all motions share.
pub(super) struct Run<'s> {
    /// The system.
    pub system: &'s dyn SeriesKernels,
    /// The parameters that vary.
    pub varied: &'s Varied,
    /// The tolerance.
    pub tolerance: Tolerance,
    /// The largest number of steps.
    pub max_steps: u64,
    /// The distance of the nodes in time; `None` if they lie at the ends of steps.
    pub every: Option<f64>,
    /// The time to run to.
    pub t: f64,
    /// Whether nodes are observed.
    pub observes: bool,
    /// The instructions.
    pub instructions: Instructions,
}

/// A motion.
struct Member<'s, O, const N: usize> {
    flow: TaylorFlow<'s, N>,
    /// Index of its start.
    place: usize,
    observer: O,
    /// The end of its run.
    end: End,
    /// The current trial step.
    step: Trial,
    /// Whether it is a second trial.
    again: bool,
    /// Whether the flow has the whole series at the current point, as after a step of its own.
    is_complete: bool,
    /// Whether it makes all steps outside of the lanes.
    stays_alone: bool,
}

/// A trial step.
#[derive(Clone, Copy, Default)]
struct Trial {
    /// The time that the steps go to, the distance left, and the step's length.
    until: f64,
    left: f64,
    size: f64,
    /// The shortest length that is tried.
    smallest: f64,
    /// The sizes in the series at its beginning, for the step control.
    sizes: Sizes,
    /// The number of longer steps that were tried before.
    tries: u32,
}

impl Trial {
    /// Whether it goes to the end.
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

/// The continuation of a motion.
enum Goes {
    /// The next step is computed in its lane.
    On,
    /// The next step is computed singly.
    Alone,
    /// The motion has ended.
    Ended(Result<(), RunError>),
}

impl<'s> Run<'s> {
    /// Runs some motions, the first of which has the index `first` among all, and returns them in their
    /// order.
    pub fn block<O: Observer<N>, const N: usize>(
        &self,
        first: usize,
        starts: &[Start<N>],
        observer: &dyn Fn(usize) -> O,
    ) -> Vec<ObservedRun<O, N>> {
        let mut ended: Vec<Option<ObservedRun<O, N>>> = starts.iter().map(|_| None).collect();
        let mut queue = (first..).zip(starts);
        let mut members: [Option<Member<'s, O, N>>; LANES] = [const { None }; LANES];
        let mut lanes = Lanes {
            engine: self.system.lanes(self.instructions),
            ends: Ends::new(N),
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
                                if !self.varied.is_empty() {
                                    lanes
                                        .engine
                                        .set_parameters(lane, member.flow.any.equations.values());
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
                            (h[lane], orders[lane]) = (member.step.h(), member.flow.any.motion.next.order());
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
        // all motions have ended
        ended.into_iter().flatten().collect()
    }

    /// A motion after its first step.
    fn begin<O: Observer<N>, const N: usize>(
        &self,
        place: usize,
        start: Start<N>,
        observer: O,
    ) -> Result<Member<'s, O, N>, ObservedRun<O, N>> {
        let begun = || -> Result<(TaylorFlow<'s, N>, End), RunError> {
            if !self.t.is_finite() {
                return Err(RunError::Until { until: self.t });
            }
            let mut equations = self.system.single();
            if !self.varied.is_empty() {
                let mut values = equations.values().to_vec();
                self.varied.set(place, &mut values);
                equations.set_values(&values);
            }
            let any = AnyTaylorFlow::new(equations, &start.given(), &self.tolerance)?;
            let mut flow = TaylorFlow { any }.max_steps(self.max_steps);
            match self.every {
                Some(h) => flow = flow.every(h)?,
                None if self.t < flow.time() => flow.reverse()?,
                None => {}
            }
            let end = flow.any.motion.clock.until(self.t)?;
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
            Err(error) => Err(ObservedRun {
                observer,
                last: Err(error),
            }),
        }
    }
}

/// Stores a motion that has ended at its index.
fn put<O, const N: usize>(
    ended: &mut [Option<ObservedRun<O, N>>],
    first: usize,
    member: Option<Member<'_, O, N>>,
    result: Result<(), RunError>,
) {
    if let Some(member) = member {
        ended[member.place - first] = Some(ObservedRun {
            last: result.map(|()| member.flow.node()),
            observer: member.observer,
        });
    }
}

/// The lanes of a block.
struct Lanes<'s> {
    engine: Box<dyn LaneSeries + 's>,
    ends: Ends,
    /// Workspace for the search for switches.
    crossings: Vec<Crossing>,
}

impl Lanes<'_> {
    /// Tries a step in every active lane.
    fn step<O: Observer<N>, const N: usize>(
        &mut self,
        members: &mut [Option<Member<'_, O, N>>; LANES],
        h: &[f64; LANES],
        mut orders: [usize; LANES],
        active: u32,
    ) {
        // idle lanes repeat one that continues: NaN would cost time
        let Some(living) = members.iter().position(Option::is_some) else {
            return;
        };
        for lane in 0..LANES {
            let from = if active >> lane & 1 == 1 { lane } else { living };
            orders[lane] = orders[from];
            if let Some(member) = &mut members[from] {
                let Integrator { t, now, .. } = &mut member.flow.any.motion;
                self.ends.set::<N>(lane, t.hi[0], now);
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
                && !member.assess(lane, self)
            {
                back |= 1 << lane;
            }
        }
        self.engine.go_on(back);
        for (lane, member) in members.iter_mut().enumerate() {
            if let Some(member) = member
                && back >> lane & 1 == 0
                && member.flow.any.motion.on_grid.is_some()
                && member.flow.any.motion.reaches_node()
            {
                self.engine.last(lane, &mut member.flow.any.motion.series);
            }
        }
    }
}

impl<O: Observer<N>, const N: usize> Member<'_, O, N> {
    /// The lowest order beyond 1 whose coefficient the step control needs.
    fn first_asked(&self) -> usize {
        let motion = &self.flow.any.motion;
        let current = motion.order.current();
        if motion.next.order() > current {
            motion.order.below() - 1
        } else {
            current - 1
        }
    }

    /// Proposes the next step; nodes on the way are observed if `observes`.
    fn propose(&mut self, lane: usize, lanes: &mut Lanes<'_>, observes: bool) -> Goes {
        let AnyTaylorFlow { motion, equations } = &mut self.flow.any;
        if core::mem::take(&mut self.again) {
            return Goes::On;
        }
        let observer = &mut self.observer;
        let mut node =
            |motion: &Integrator| observer.node(&Node::written_by(|node| motion.tell(&**equations, node)));
        let node: Option<&mut Visit<'_>> = if observes { Some(&mut node) } else { None };
        let until = match motion.hand_nodes_out(&**equations, &self.end, node) {
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
        let sizes = motion.sizes();
        let wanted = motion.wanted(&sizes);
        let wanted = motion.limited(&**equations, wanted);
        motion.next.set_order(motion.order.next());
        let mut size = wanted.min(left.abs());
        let mut alone = wanted.is_nan() || wanted < smallest || !motion.series.is_finite();
        let (order, limits) = (motion.series.order(), motion.control.limits);
        let switches = if self.is_complete {
            equations.group(0)
        } else {
            lanes.engine.switches(lane)
        };
        for switch in switches {
            match switch.reach(order, size.copysign(left), &limits, &mut lanes.crossings) {
                Reach::Whole => {}
                Reach::Shorter(part) => size *= part,
                Reach::Crossing(_) | Reach::Corner(_) => alone = true,
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
            sizes,
            tries: 0,
        };
        Goes::On
    }

    /// Makes a step as a single flow, at the start and if its lane cannot decide.
    #[cold]
    fn go_alone(&mut self, lane: usize, lanes: &mut Lanes<'_>) -> Result<(), RunError> {
        let AnyTaylorFlow { motion, equations } = &mut self.flow.any;
        if !self.is_complete {
            motion.begin(&mut **equations);
        }
        let until = motion.towards(&self.end);
        motion.go(&mut **equations, until)?;
        self.is_complete = true;
        lanes.engine.take(lane, &motion.next);
        Ok(())
    }

    /// Projects the end of a step onto the constraints.
    fn arrive(&mut self, lane: usize, ends: &mut Ends) {
        let AnyTaylorFlow { motion, equations } = &mut self.flow.any;
        let t = if self.step.is_whole() {
            self.step.until
        } else {
            motion.t.hi[0] + self.step.h()
        };
        ends.t[lane] = t;
        if let Some(projection) = &mut motion.projection {
            ends.get::<N>(lane, &mut motion.tried);
            projection.apply(&**equations, t, &mut motion.tried);
            ends.set::<N>(lane, t, &mut motion.tried);
        }
    }

    /// Whether the step was accepted. If so it is committed, else it will be tried again.
    fn assess(&mut self, lane: usize, lanes: &mut Lanes<'_>) -> bool {
        let asked = self.first_asked();
        let AnyTaylorFlow { motion, equations } = &mut self.flow.any;
        let Trial {
            until,
            size,
            smallest,
            ref sizes,
            ..
        } = self.step;
        if lanes.engine.has_compared(lane) {
            // pieces of a function: the step is made by the flow
            core::mem::swap(&mut motion.series, &mut motion.next);
            (self.stays_alone, self.is_complete) = (true, false);
            return false;
        }
        lanes.ends.get::<N>(lane, &mut motion.tried);
        motion
            .next
            .begin(lanes.ends.t[lane], motion.tried.q(), motion.tried.v());
        lanes.engine.tell(lane, asked, &mut motion.next);
        // a jump of the velocity without a known switch, or a place where the equations do not determine the
        // acceleration
        let depends = |projection: &Projection| projection.has_turned() || projection.is_lost();
        let is_hard = motion.moved(self.step.h()).is_some()
            || motion.changes_sign()
            || motion.projection.as_ref().is_some_and(depends);
        let weights = motion.control.weights();
        let order = motion.order.current();
        let Assessment { sizes: known, end } =
            equations.assess(&motion.next, motion.tried.a(), weights, order);
        let is_good = motion.control.good(sizes, end, size, false);
        let is_hard = is_hard || (is_good && motion.may_pass_zero(end));
        let good = !is_hard && is_good;
        let stays_alone =
            is_hard || (!good && motion.is_rounding(&**equations, (end[1], size), self.step.tries));
        if stays_alone || (!good && size <= smallest) {
            // the flow's own step finds the reason
            core::mem::swap(&mut motion.series, &mut motion.next);
            self.stays_alone |= stays_alone;
            self.is_complete = false;
            return false;
        }
        self.again = !good;
        if self.again {
            motion.rejected += 1;
            motion.expansions = motion.expansions.saturating_add(1);
            self.step.size = (SHORTER * size).max(smallest);
            self.step.tries += 1;
            return false;
        }
        if let Some(projection) = &mut motion.projection {
            projection.keep_directions();
        }
        motion.last = Some((motion.t, self.step.h()));
        if self.step.is_whole() {
            motion.t = Compensated::exact([until]);
        } else {
            motion.t.add(&[self.step.h()]);
        }
        core::mem::swap(&mut motion.now, &mut motion.tried);
        motion.known = Some(known);
        motion.steps += 1;
        self.is_complete = false;
        motion.expansions = motion.expansions.saturating_add(1);
        true
    }
}
