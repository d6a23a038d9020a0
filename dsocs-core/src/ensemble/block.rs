//! One block: up to eight trajectories, step by step.

use core::array;
use core::num::NonZeroU64;

use super::Observed;
use super::determinants::Determinants;
use super::newton::{self, Roots};
use crate::compensated::Compensated;
use crate::compiled::Report;
use crate::flow::{Flow, SHORT_PAST, State};
use crate::held::Held;
use crate::lanes::{LANES, Lanes};
use crate::run::{self, Node, Observer, RunError, Stepper as _};
use crate::scalar::Scalar;
use crate::start::Start;
use crate::step::newton::Stop;
use crate::step::predictor::Predictor;
use crate::step::unknown::{Linearization, Unknown};
use crate::step::{NEARLY_THE_SAME, SECOND_DIFFERENCE};
use crate::system::{Leg, System};

/// What all blocks have in common.
#[derive(Debug)]
pub(super) struct Run<'s, S> {
    /// The system.
    pub system: &'s S,
    /// The parameters that vary, by their places, each with a value for every start.
    pub varied: &'s [(usize, Vec<f64>)],
    /// Makes a copy of the system, where they do.
    pub copy: Option<fn(&S) -> S>,
    /// The step.
    pub h: f64,
    /// How far to go.
    pub t: f64,
    /// Which nodes are observed: those whose number is a multiple of this.
    pub every: Option<NonZeroU64>,
    /// How often the rows of a step may be evaluated from one guess.
    pub max_iterations: u32,
}

/// The rows of a step, in lanes.
struct Rows<'a, S: System<N>, const N: usize> {
    /// The system.
    system: &'a S,
    /// What is known since the run began.
    constants: &'a S::Constants<Lanes>,
    /// What is known since the step began.
    known: &'a S::Known<Lanes>,
    /// In which units determinants are wanted.
    scales: &'a [Lanes; 2],
    /// Whether the past is too short to tell two roots apart by it.
    past_is_short: bool,
}

impl<S: System<N>, const N: usize> newton::Equations for Rows<'_, S, N> {
    type Z = S::Unknown<Lanes>;

    const LINEAR: bool = S::LINEAR;

    const WATCHED: bool = !S::LINEAR && !S::DIVIDED;

    #[inline]
    fn past_is_short(&self) -> bool {
        self.past_is_short
    }

    #[inline]
    fn scales(&self) -> &[Lanes; 2] {
        self.scales
    }

    #[inline]
    fn linearize(&self, z: &Self::Z) -> Linearization<Lanes, Self::Z> {
        self.system.linearize(self.constants, self.known, z)
    }

    #[inline]
    fn sparse_update(&self, z: &Self::Z) -> Option<(Self::Z, Lanes)> {
        if const { !S::SPARSE } {
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

    #[inline]
    fn declared(&self, z: &Self::Z, nearby: &Self::Z) -> u32 {
        if !S::SCALED {
            return u32::MAX;
        }
        let here = self.system.scales(self.constants, self.known, z);
        let there = self.system.scales(self.constants, self.known, nearby);
        let scales = here.as_ref().iter().zip(there.as_ref());
        scales.fold(u32::MAX, |declared, (&here, &there)| {
            let change = (here - there).abs();
            declared & change.below(Lanes::splat(NEARLY_THE_SAME) * here.abs()).bits()
        })
    }
}

/// A trajectory with its lane.
struct Member<'s, S: System<N>, O, const N: usize> {
    /// The trajectory for itself, where it begins and where its lane cannot go on.
    flow: Flow<'s, S, N>,
    /// The number of its last node.
    last: u64,
    /// Its place among the starts of the block.
    place: usize,
    /// Its observer.
    observer: O,
}

/// Up to eight trajectories that have begun, and what their lanes hold.
struct Block<'r, 's, S: System<N>, O, const N: usize> {
    /// What all blocks have in common.
    run: &'r Run<'s, S>,
    /// The trajectories, by lane.
    members: Vec<Member<'s, S, O, N>>,
    /// How they ended.
    ended: Vec<Option<Result<Node<N>, RunError>>>,
    /// The lanes whose trajectories go on, as bits.
    active: u32,
    /// What is known since the run began.
    constants: S::Constants<Lanes>,
    /// The last nodes.
    q: Compensated<N, Lanes>,
    /// The increments that led to them.
    d: Compensated<N, Lanes>,
    /// The past solutions.
    predictor: Predictor<S::Unknown<Lanes>, Lanes>,
    /// The determinants there.
    determinants: Determinants,
    /// The number of the next step's middle node.
    index: u64,
}

/// A step of all lanes.
struct Solved<S: System<N>, const N: usize> {
    /// Its first two nodes.
    leg: Leg<Lanes, N>,
    /// What was known since it began.
    known: S::Known<Lanes>,
    /// The second difference.
    e: [Lanes; N],
    /// The solution.
    roots: Roots<S::Unknown<Lanes>>,
    /// The lanes that were solved for themselves.
    alone: u32,
}

/// The numbers of the lanes whose bits are set.
fn lanes(bits: u32) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| bits >> lane & 1 == 1)
}

impl<'s, S> Run<'s, S> {
    /// Runs one block, whose first start has this place among all.
    pub fn block<O: Observer<N>, const N: usize>(
        &self,
        first: usize,
        starts: &[Start<N>],
        observers: Vec<O>,
    ) -> Vec<Observed<O, N>>
    where
        S: System<N>,
    {
        let mut members = Vec::with_capacity(starts.len());
        let mut ended: Vec<(usize, Observed<O, N>)> = Vec::with_capacity(starts.len());
        for (place, (&start, mut observer)) in starts.iter().zip(observers).enumerate() {
            match self.begin(first + place, start, &mut observer) {
                Ok(Begun::Going { flow, last }) => members.push(Member {
                    flow,
                    last,
                    place,
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
    fn begin<O: Observer<N>, const N: usize>(
        &self,
        place: usize,
        start: Start<N>,
        observer: &mut O,
    ) -> Result<Begun<'s, S, N>, RunError>
    where
        S: System<N>,
    {
        let mut flow =
            Flow::holding(self.system_of(place), self.h, start)?.max_iterations(self.max_iterations);
        let end = flow.clock().until(self.t)?;
        if self.t.is_infinite() && self.every.is_none() {
            return Err(RunError::Until { until: self.t });
        }
        let last = end.index().unwrap_or(u64::MAX);
        for index in 0..2 {
            let node = run::hand_out(&mut run::Of(&mut flow), end.time())?;
            if self.observes(index) && observer.node(&node).is_break() || index == last {
                return Ok(Begun::Ended(node));
            }
        }
        Ok(Begun::Going { flow, last })
    }

    /// The system of one trajectory.
    fn system_of<const N: usize>(&self, place: usize) -> Held<'s, S>
    where
        S: System<N>,
    {
        let Some(copy) = self.copy else {
            return Held::new(self.system);
        };
        let mut own = copy(self.system);
        for (parameter, values) in self.varied {
            if let (Some(parameter), Some(value)) = (own.parameter_mut(*parameter), values.get(place)) {
                *parameter = *value;
            }
        }
        Held::owning(self.system, own)
    }

    /// Whether node `index` is observed.
    #[inline]
    fn observes(&self, index: u64) -> bool {
        self.every.is_some_and(|every| index.is_multiple_of(every.get()))
    }
}

/// A trajectory at node 1.
enum Begun<'s, S: System<N>, const N: usize> {
    /// It goes on, to node `last`.
    Going {
        /// The trajectory.
        flow: Flow<'s, S, N>,
        /// The number of its last node.
        last: u64,
    },
    /// It ends with this node.
    Ended(Node<N>),
}

impl<'r, 's, S: System<N>, O: Observer<N>, const N: usize> Block<'r, 's, S, O, N> {
    /// Puts trajectories into lanes. Lanes that are left over repeat them.
    fn new(run: &'r Run<'s, S>, members: Vec<Member<'s, S, O, N>>) -> Self {
        let zero = [Lanes::splat(0.0); N];
        let mut parameters = run.system.parameters::<Lanes>();
        if run.copy.is_some() {
            for (place, parameter) in parameters.as_mut().iter_mut().enumerate() {
                for lane in 0..LANES {
                    let own = members[lane % members.len()].flow.system();
                    parameter.set_lane(lane, own.parameter(place).unwrap_or(f64::NAN));
                }
            }
        }
        let mut block = Self {
            run,
            ended: members.iter().map(|_| None).collect(),
            active: (1 << members.len()) - 1,
            constants: run.system.constants(&parameters, Lanes::splat(run.h)),
            q: Compensated::exact(zero),
            d: Compensated::exact(zero),
            predictor: Predictor::new(),
            determinants: Determinants::new(),
            index: 2,
            members,
        };
        for lane in 0..LANES {
            let state = block.members[lane % block.members.len()].flow.state();
            block.set_state(lane, &state);
        }
        block
    }

    /// Runs all trajectories to their ends; each comes with its place among the starts.
    #[inline(never)]
    fn run(mut self) -> impl Iterator<Item = (usize, Observed<O, N>)> {
        let mut wanted = self.next_node_wanted();
        while self.active != 0 {
            let solved = self.step();
            if self.index == wanted {
                self.hand_out(&solved);
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

    /// Solves one step in all lanes and moves on.
    #[inline]
    fn step(&mut self) -> Solved<S, N> {
        let (system, constants) = (self.run.system, &self.constants);
        let leg = Leg {
            t: self.time(),
            q: self.q.hi,
            d: self.d.hi,
        };
        let known = system.known(constants, &leg);
        let increment = system.unknown(&leg.d, &[]);
        let expected = self.predictor.size().zip(&increment, |past, d| {
            past.larger(Lanes::splat(SECOND_DIFFERENCE) * d.abs())
        });
        let rows = Rows {
            system,
            constants,
            known: &known,
            scales: &self.determinants.scales,
            past_is_short: self.index <= SHORT_PAST,
        };
        let roots = newton::solve(
            &rows,
            self.predictor.extrapolate(),
            &expected,
            self.run.max_iterations,
            self.active,
        );
        let e = system.second_difference(constants, &known, &roots.z);
        let mut d = self.d;
        d.add(&e);
        let q = self.q.plus(&d);
        let finite = q.hi.iter().fold(u32::MAX, |finite, q| finite & q.finite().bits());
        let mut alone = self.active & (roots.left | !finite);
        if <Rows<'_, S, N> as newton::Equations>::WATCHED {
            alone |= self.determinants.take(roots.determinants, self.active & !alone);
        }
        if alone != 0 {
            self.solve_alone(alone);
        }
        (self.q, self.d) = (q, d);
        self.predictor.push(&roots.z);
        if <Rows<'_, S, N> as newton::Equations>::WATCHED {
            self.determinants.push();
        }
        if alone != 0 {
            self.take_back(alone);
        }
        Solved {
            leg,
            known,
            e,
            roots,
            alone,
        }
    }

    /// The times of the next step's middle nodes, where the system asks for them.
    #[inline]
    fn time(&self) -> Lanes {
        let mut t = Lanes::splat(0.0);
        if S::DEPENDS_ON_TIME {
            for lane in 0..LANES {
                let member = &self.members[lane % self.members.len()];
                t.set_lane(lane, member.flow.clock().time_of(self.index));
            }
        }
        t
    }

    /// Solves the step in single lanes, from every guess and with damping.
    #[cold]
    #[inline(never)]
    fn solve_alone(&mut self, alone: u32) {
        for lane in lanes(alone) {
            let state = self.state(lane);
            let flow = &mut self.members[lane].flow;
            flow.resume(self.index, state);
            if let Err(error) = flow.advance() {
                self.end(lane, Err(error));
            }
        }
    }

    /// Puts the solutions of single lanes back.
    #[cold]
    #[inline(never)]
    fn take_back(&mut self, alone: u32) {
        for lane in lanes(alone & self.active) {
            let state = self.members[lane].flow.state();
            self.set_state(lane, &state);
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
            let state = self.state(living);
            for lane in lanes(!self.active) {
                self.set_state(lane, &state);
            }
        }
    }

    /// Hands the middle nodes of a step out, to observers and to the trajectories that end there.
    fn hand_out(&mut self, solved: &Solved<S, N>) {
        let (system, constants) = (self.run.system, &self.constants);
        let Solved {
            leg,
            known,
            e,
            roots,
            alone,
        } = solved;
        let Report { point, force, energy } = system.report(constants, known, leg, e);
        let observed = self.run.observes(self.index);
        let going = self.active;
        for lane in lanes(going) {
            let member = &mut self.members[lane];
            let by_itself = if alone >> lane & 1 == 1 {
                Some(member.flow.node())
            } else {
                None
            };
            let node = by_itself.unwrap_or_else(|| Node {
                index: self.index,
                t: member.flow.clock().time_of(self.index),
                q: one_lane(&point.q, lane),
                v: one_lane(&point.v, lane),
                a: one_lane(&point.a, lane),
                force: one_lane(&force, lane),
                energy: energy.lane(lane),
                iterations: roots.evaluations[lane],
                stop: Stop::Update,
            });
            if observed && member.observer.node(&node).is_break() || self.index == member.last {
                self.end(lane, Ok(node));
            }
        }
        if self.active != going {
            self.cover();
        }
    }

    /// What one lane holds.
    fn state(&self, lane: usize) -> State<S::Unknown<f64>, N> {
        let mut predictor = Predictor::<S::Unknown<f64>>::new();
        self.predictor
            .convert(&mut predictor, |to: &mut S::Unknown<f64>, from| {
                for (to, from) in to.as_mut().iter_mut().zip(from.as_ref()) {
                    *to = from.lane(lane);
                }
            });
        State {
            q: one_sum(&self.q, lane),
            d: one_sum(&self.d, lane),
            predictor: predictor.with_determinants(self.determinants.lane(lane)),
        }
    }

    /// Fills one lane.
    fn set_state(&mut self, lane: usize, state: &State<S::Unknown<f64>, N>) {
        let unknowns = state.predictor.size().as_ref().len();
        self.determinants
            .set_lane(lane, state.predictor.determinants(), unknowns);
        for (sums, one) in [(&mut self.q, &state.q), (&mut self.d, &state.d)] {
            for i in 0..N {
                sums.hi[i].set_lane(lane, one.hi[i]);
                sums.lo[i].set_lane(lane, one.lo[i]);
            }
        }
        state.predictor.convert(&mut self.predictor, |to, from| {
            for (to, from) in to.as_mut().iter_mut().zip(from.as_ref()) {
                to.set_lane(lane, *from);
            }
        });
    }
}

/// One lane of a vector.
fn one_lane<const N: usize>(x: &[Lanes; N], lane: usize) -> [f64; N] {
    array::from_fn(|i| x[i].lane(lane))
}

/// One lane of compensated sums.
fn one_sum<const N: usize>(sums: &Compensated<N, Lanes>, lane: usize) -> Compensated<N> {
    Compensated {
        hi: one_lane(&sums.hi, lane),
        lo: one_lane(&sums.lo, lane),
    }
}
