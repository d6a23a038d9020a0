//! The discrete flow: step after step, as an iterator, up to a time, or back.

use core::iter::FusedIterator;

use crate::compensated::Compensated;
use crate::error::{FailedStep, NewtonFailure, RunError, SetupError, StepError};
use crate::newton::Stop;
use crate::predictor::Predictor;
use crate::start::{self, Beginning, Start};
use crate::step::{Step, StepReport};
use crate::system::{Leg, Point, System};
use crate::trajectory::{Failure, Node, Observer, Trajectory};

/// How often the rows of a step are evaluated from one guess unless [`Flow::max_iterations`] says otherwise, parts of
/// updates apart.
const MAX_ITERATIONS: u32 = 50;

/// A discrete motion in progress.
///
/// The flow is an endless iterator of nodes. Node `k` is handed out once the step with the middle node `k` is solved,
/// since its velocity, acceleration and constraint force need the node after it, too. After a step without a solution the
/// iterator ends.
#[derive(Clone, Debug)]
pub struct Flow<'s, S: System<N>, const N: usize> {
    /// The system.
    system: &'s S,
    /// What is known since the run began.
    constants: S::Constants<f64>,
    /// The step.
    h: f64,
    /// The start.
    beginning: Beginning<N>,
    /// The clock.
    clock: Clock,
    /// The last node.
    q: Compensated<N>,
    /// The increment that led to it.
    d: Compensated<N>,
    /// The number of the last node, which is the next step's middle node.
    middle: u64,
    /// The last step that was solved.
    solved: Option<Solved<N>>,
    /// The number of the next node that the iterator hands out.
    next: u64,
    /// The past solutions.
    predictor: Predictor<S::Unknown<f64>>,
    /// How often the rows may be evaluated from one guess.
    max_iterations: u32,
    /// Whether the iterator has ended.
    ended: bool,
}

/// A step that was solved.
#[derive(Clone, Copy, Debug)]
struct Solved<const N: usize> {
    /// The number of its middle node.
    index: u64,
    /// Its first two nodes.
    leg: Leg<f64, N>,
    /// The second difference.
    e: [f64; N],
    /// How it was solved.
    report: StepReport,
}

impl<'s, S: System<N>, const N: usize> Flow<'s, S, N> {
    /// Sets up a run with the step `h`, which is negative to run back in time.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the step, the start or a parameter is not usable, or if the start needs the initial
    /// acceleration and the continuous system has none.
    pub fn new(system: &'s S, h: f64, start: Start<N>) -> Result<Self, SetupError> {
        if !h.is_finite() || h == 0.0 {
            return Err(SetupError::Step { h });
        }
        if !(h * h).is_normal() {
            return Err(SetupError::StepRange { h });
        }
        let values = (0..).map_while(|index| system.parameter(index));
        for (parameter, value) in S::PARAMETERS.iter().zip(values) {
            if !value.is_finite() {
                return Err(SetupError::Parameter {
                    name: parameter.name,
                    value,
                });
            }
        }
        let beginning = start.begin(system, h)?;
        Ok(Self {
            system,
            constants: system.constants(h),
            h,
            clock: Clock {
                t0: beginning.t0,
                h,
                origin: 0,
                direction: 1,
            },
            q: beginning.q,
            d: beginning.d,
            beginning,
            middle: 1,
            solved: None,
            next: 0,
            predictor: Predictor::new(),
            max_iterations: MAX_ITERATIONS,
            ended: false,
        })
    }

    /// Sets how often the rows of a step are evaluated from one guess before it is given up (50 unless set; at least
    /// 1 is taken).
    #[must_use]
    pub fn max_iterations(mut self, limit: u32) -> Self {
        self.max_iterations = limit.max(1);
        self
    }

    /// The system.
    #[must_use]
    pub fn system(&self) -> &'s S {
        self.system
    }

    /// The step, negative when running back in time.
    #[must_use]
    pub fn h(&self) -> f64 {
        self.h
    }

    /// The number of the last node that is known, the middle node of the next step.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.middle
    }

    /// The time of the last node that is known.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.time(self.middle)
    }

    /// The last node that is known: the second node of the start, then the one that [`Flow::advance`] found.
    #[must_use]
    pub fn position(&self) -> &[f64; N] {
        &self.q.hi
    }

    /// The leg that the next step begins with: the last node and the increment that led to it.
    #[must_use]
    pub fn leg(&self) -> Leg<f64, N> {
        Leg {
            q: self.q.hi,
            d: self.d.hi,
        }
    }

    /// Solves one step and no more: neither velocity, force nor energy is computed. Nothing is allocated.
    ///
    /// # Errors
    ///
    /// [`StepError`] if the step has no solution that is found. The flow stays where it was.
    #[inline]
    pub fn advance(&mut self) -> Result<StepReport, StepError> {
        self.solve().map(|solved| solved.report)
    }

    /// The node in the middle of the last step that was solved, with velocity, acceleration, force and energy; `None`
    /// before the first step.
    #[must_use]
    pub fn node(&self) -> Option<Node<N>> {
        self.solved.map(|solved| self.node_of(solved))
    }

    /// The observed expressions of the declaration at a node, in the order of [`System::OBSERVABLES`].
    ///
    /// Expressions beyond the end of `out` are left out.
    pub fn observe(&self, node: &Node<N>, out: &mut [f64]) {
        let count = S::OBSERVABLES.len();
        if out.len() >= count {
            self.system.observe(&node.point(), &mut out[..count]);
        } else {
            let mut all = vec![0.0; count];
            self.system.observe(&node.point(), &mut all);
            out.copy_from_slice(&all[..out.len()]);
        }
    }

    /// Turns round: the step becomes `-h`, the two last nodes change places with the sums carried along, and time runs
    /// back from where it was.
    ///
    /// The last node that is known becomes number 0. It is not handed out again; the first node that is, is number 1, the
    /// one that was handed out last.
    pub fn reverse(&mut self) {
        let turn = self.clock.tick(self.middle);
        self.clock = Clock {
            origin: turn,
            direction: -self.clock.direction,
            ..self.clock
        };
        self.h = -self.h;
        self.constants = self.system.constants(self.h);
        self.d = self.d.negated();
        self.q = self.q.plus(&self.d);
        self.predictor.turn();
        (self.middle, self.next, self.solved, self.ended) = (1, 1, None, false);
    }

    /// Runs up to the last node at or before `t` (at or after, for a negative step) and collects the nodes, from the
    /// one after the last handed out.
    ///
    /// A node whose time is `t` to within rounding counts as at `t`: 500 with the step 0.1 gives node 5000.
    ///
    /// # Errors
    ///
    /// [`Failure`] with the nodes so far if a step fails, or if `t` lies behind, is infinite or is not a number.
    pub fn until(&mut self, t: f64) -> Result<Trajectory<N>, Failure<N>> {
        let mut trajectory = Trajectory::default();
        let result = match self.last_index(t) {
            Ok(_) if t.is_infinite() => Err(RunError::Until { until: t }),
            Ok(last) => self.run(last, &mut trajectory),
            Err(error) => Err(error),
        };
        match result {
            Ok(()) => Ok(trajectory),
            Err(error) => Err(Failure { error, trajectory }),
        }
    }

    /// Runs like [`Flow::until`], but hands each node to an observer and keeps none. An infinite `t` is allowed: the
    /// observer ends the run.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a step fails, or if `t` lies behind or is not a number.
    pub fn stream<O: Observer<N> + ?Sized>(&mut self, t: f64, observer: &mut O) -> Result<(), RunError> {
        let last = self.last_index(t)?;
        self.run(last, observer)
    }

    /// Solves the next step and moves on.
    #[inline]
    fn solve(&mut self) -> Result<Solved<N>, StepError> {
        let leg = self.leg();
        let step = Step::new(self.system, &self.constants, leg, self.h);
        let (z, report) = match step.solve(&self.predictor, self.max_iterations) {
            Ok(solution) => solution,
            Err(cause) => return Err(self.failed(cause)),
        };
        let e = step.second_difference(&z);
        let mut d = self.d;
        d.add(&e);
        let q = self.q.plus(&d);
        if !q.hi.iter().all(|q| q.is_finite()) {
            return Err(self.failed(step.not_finite(&z)));
        }
        self.predictor.push(&z);
        let solved = Solved {
            index: self.middle,
            leg,
            e,
            report,
        };
        (self.q, self.d, self.solved) = (q, d, Some(solved));
        self.middle += 1;
        Ok(solved)
    }

    /// The middle node of a step.
    fn node_of(
        &self,
        Solved {
            index,
            leg,
            e,
            report,
        }: Solved<N>,
    ) -> Node<N> {
        let known = self.system.known(&self.constants, &leg);
        let Point { q, v, a } = self.system.point(&self.constants, &known, &leg, &e);
        Node {
            index,
            t: self.clock.time(index),
            q: leg.q,
            v,
            a,
            force: self.system.force(&self.constants, &known, &leg, &e),
            energy: self.system.energy(&q, &v),
            iterations: report.iterations,
            stop: report.stop,
        }
    }

    /// Hands the nodes up to number `last` to an observer.
    fn run<O: Observer<N> + ?Sized>(&mut self, last: u64, observer: &mut O) -> Result<(), RunError> {
        while self.next <= last {
            let node = self.step()?;
            if observer.node(&node).is_break() {
                break;
            }
        }
        Ok(())
    }

    /// The number of the last node at or before `t`.
    fn last_index(&self, t: f64) -> Result<u64, RunError> {
        if t.is_nan() {
            return Err(RunError::Until { until: t });
        }
        // what has been handed out cannot be taken back
        let current = self.next.saturating_sub(1);
        match self.clock.last_index(t) {
            Some(last) if last >= current => Ok(last),
            _ => Err(RunError::Behind {
                until: t,
                time: self.clock.time(current),
                h: self.h,
            }),
        }
    }

    /// The next node of the iterator.
    fn step(&mut self) -> Result<Node<N>, StepError> {
        if self.next == 0 && self.middle == 1 {
            self.next = 1;
            return Ok(self.first_node());
        }
        let solved = self.solve()?;
        self.next = self.middle;
        Ok(self.node_of(solved))
    }

    /// The node of the start.
    fn first_node(&self) -> Node<N> {
        let Beginning { q0, v0, a0, t0, .. } = self.beginning;
        let a = a0
            .or_else(|| start::acceleration(self.system, &q0, &v0).ok())
            .unwrap_or([f64::NAN; N]);
        Node {
            index: 0,
            t: t0,
            q: q0,
            v: v0,
            a,
            force: self.system.continuous_force(&Point { q: q0, v: v0, a }),
            energy: self.system.energy(&q0, &v0),
            iterations: 0,
            stop: Stop::Start,
        }
    }

    /// The error of the step that begins with the current leg.
    #[cold]
    fn failed(&self, cause: NewtonFailure) -> StepError {
        let leg = self.leg();
        let step = Step::new(self.system, &self.constants, leg, self.h);
        let mut z = self
            .predictor
            .last()
            .unwrap_or_else(|| self.system.unknown(&[0.0; N]));
        for (z, &last) in z.as_mut().iter_mut().zip(&cause.unknowns) {
            *z = last;
        }
        let e = step.second_difference(&z);
        StepError::new(FailedStep {
            index: self.middle,
            time: self.time(),
            h: self.h,
            q0: self.q.plus(&self.d.negated()).hi.to_vec(),
            q1: leg.q.to_vec(),
            q2: (0..N).map(|i| leg.q[i] + (leg.d[i] + e[i])).collect(),
            coordinates: S::COORDINATES.to_vec(),
            cause,
        })
    }
}

impl<S: System<N>, const N: usize> Iterator for Flow<'_, S, N> {
    type Item = Result<Node<N>, StepError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let node = self.step();
        self.ended = node.is_err();
        Some(node)
    }
}

impl<S: System<N>, const N: usize> FusedIterator for Flow<'_, S, N> {}

/// Times of nodes, by multiplication: adding up steps would add up rounding errors.
#[derive(Clone, Copy, Debug)]
struct Clock {
    /// The time of the start.
    t0: f64,
    /// The step that the run was set up with.
    h: f64,
    /// How many steps after the start node 0 lies.
    origin: i64,
    /// 1, or -1 while the run goes back.
    direction: i64,
}

impl Clock {
    /// How many steps after the start node `index` lies.
    fn tick(&self, index: u64) -> i64 {
        self.origin.saturating_add(
            self.direction
                .saturating_mul(i64::try_from(index).unwrap_or(i64::MAX)),
        )
    }

    /// The time of node `index`.
    fn time(&self, index: u64) -> f64 {
        self.t0 + self.tick(index) as f64 * self.h
    }

    /// The number of the last node at or before `t` in the direction of the run, to within rounding; `None` if it
    /// would lie before node 0.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a cast saturates, which is what is wanted
    fn last_index(&self, t: f64) -> Option<u64> {
        let steps = ((t - self.t0) / self.h - self.origin as f64) * self.direction as f64;
        let rounding = 4.0 * f64::EPSILON * ((t.abs() + self.t0.abs()) / self.h.abs() + self.origin as f64);
        let nearest = steps.round();
        let whole = if (steps - nearest).abs() <= rounding.abs().max(f64::EPSILON) {
            nearest
        } else {
            steps.floor()
        };
        (whole >= 0.0).then_some(whole as u64)
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::error::StepFailure;
    use crate::testing::{Cliff, Particle};
    use crate::trajectory::until_break;

    const ORIGIN: [f64; 2] = [0.0, 0.0];
    const DIAGONAL: [f64; 2] = [1.0, 1.0];

    fn distance(left: [f64; 2], right: [f64; 2]) -> f64 {
        (left[0] - right[0]).hypot(left[1] - right[1])
    }

    /// The largest distance from the exact discrete motion, at some hundred nodes.
    fn distance_from_polygon(h: f64, steps: u64) -> f64 {
        let particle = Particle::default();
        let mut flow = Flow::new(&particle, h, Start::paper(ORIGIN, DIAGONAL)).unwrap();
        let d0 = flow.leg().d;
        let mut worst: f64 = 0.0;
        for k in 1..=steps {
            if k % (steps / 100) == 0 {
                worst = worst.max(distance(*flow.position(), particle.polygon(d0, k)));
            }
            flow.advance().unwrap();
        }
        worst
    }

    #[test]
    fn the_particle_walks_its_polygon() {
        for (h, steps, tolerance) in [
            (0.1, 5000, 1e-11),
            (0.01, 50_000, 1e-12),
            (1e-3, 100_000, 1e-12),
            (1e-5, 1_000_000, 1e-13),
        ] {
            let worst = distance_from_polygon(h, steps);
            println!("h = {h:e}: {worst:e}");
            assert!(worst < tolerance, "h = {h:e}: {worst:e}");
        }
    }

    #[test]
    #[ignore = "long: 5e7 steps, for measurements in release"]
    fn the_particle_walks_its_polygon_for_long() {
        for (h, steps) in [
            (0.1, 5000),
            (0.01, 50_000),
            (1e-3, 500_000),
            (1e-4, 5_000_000),
            (1e-5, 50_000_000),
        ] {
            let clock = std::time::Instant::now();
            let worst = distance_from_polygon(h, steps);
            let time = clock.elapsed().as_nanos() as f64 / steps as f64;
            println!("h = {h:e}: {worst:.2e} from the polygon, {time:.1} ns per step");
            assert!(worst < 1e-11);
        }
    }

    #[test]
    #[ignore = "a measurement, for release"]
    fn the_time_of_a_step() {
        let particle = Particle::default();
        for h in [0.1, 0.01, 0.001] {
            let mut flow = Flow::new(&particle, h, Start::second_order(ORIGIN, DIAGONAL)).unwrap();
            let (mut evaluations, steps) = (0_u64, 10_000_000_u32);
            let clock = std::time::Instant::now();
            for _ in 0..steps {
                evaluations += u64::from(flow.advance().unwrap().iterations);
            }
            let time = clock.elapsed().as_nanos() as f64 / f64::from(steps);
            println!(
                "h = {h}: {time:.1} ns per step, {} evaluations",
                evaluations as f64 / f64::from(steps)
            );
        }
    }

    #[test]
    fn forward_and_back_returns() {
        let particle = Particle::default();
        for h in [0.1, -0.01] {
            let mut flow = Flow::new(&particle, h, Start::second_order(ORIGIN, DIAGONAL)).unwrap();
            let q1 = *flow.position();
            for _ in 0..100_000 {
                flow.advance().unwrap();
            }
            flow.reverse();
            for _ in 0..99_999 {
                flow.advance().unwrap();
            }
            println!("h = {h}: {:e}", distance(*flow.position(), q1));
            assert!(distance(*flow.position(), q1) < 1e-11);
            flow.advance().unwrap();
            assert!(distance(*flow.position(), ORIGIN) < 1e-11);
            assert!(flow.time().abs() < 1e-12 && flow.h() == -h);
        }
    }

    #[test]
    fn one_evaluation_a_step_is_the_rule() {
        let particle = Particle::default();
        let mut flow = Flow::new(&particle, 0.01, Start::second_order(ORIGIN, DIAGONAL)).unwrap();
        let evaluations: u32 = (0..10_000).map(|_| flow.advance().unwrap().iterations).sum();
        assert!(evaluations < 10_100, "{evaluations}");
        let mut flow = Flow::new(&particle, 0.1, Start::second_order(ORIGIN, DIAGONAL)).unwrap();
        let evaluations: u32 = (0..10_000).map(|_| flow.advance().unwrap().iterations).sum();
        assert!(evaluations < 20_100, "{evaluations}");
    }

    #[test]
    fn nodes_carry_velocity_force_and_energy() {
        let particle = Particle {
            mass: 3.0,
            curvature: 0.5,
        };
        let mut flow = Flow::new(&particle, 0.01, Start::second_order(ORIGIN, DIAGONAL).at(1.0)).unwrap();
        let nodes = flow.until(2.0).unwrap().nodes;
        assert_eq!(nodes.len(), 101);
        for (k, node) in nodes.iter().enumerate() {
            assert_eq!(node.index, k as u64);
            assert!((node.t - (1.0 + k as f64 * 0.01)).abs() < 1e-15);
            // Q = m κ |v|² to the left of the velocity; the first node has the continuous system's
            let speed = node.v[0].hypot(node.v[1]);
            let force = 3.0 * 0.5 * speed * speed;
            let expected = [-node.v[1] / speed * force, node.v[0] / speed * force];
            assert!(distance(node.force, expected) < 1e-9, "{node:?}");
            assert!((node.energy - 1.5 * speed * speed).abs() < 1e-12);
            let mut observed = [0.0];
            flow.observe(node, &mut observed);
            assert!((observed[0] - speed).abs() < 1e-14);
        }
        assert_eq!((nodes[0].stop, nodes[0].iterations), (Stop::Start, 0));
    }

    #[test]
    fn until_counts_times_to_within_rounding() {
        let particle = Particle::default();
        for (h, t, count) in [
            (0.1, 500.0, 5001),
            (0.1, 0.3, 4),
            (0.01, 4.999, 500),
            (-0.1, -0.7, 8),
            (0.1, 0.0, 1),
        ] {
            let mut flow = Flow::new(&particle, h, Start::paper(ORIGIN, DIAGONAL)).unwrap();
            assert_eq!(flow.until(t).unwrap().len(), count, "{h} {t}");
        }
    }

    #[test]
    fn a_run_goes_on_where_it_stopped_and_back() {
        let particle = Particle::default();
        let mut flow = Flow::new(&particle, 0.1, Start::paper(ORIGIN, DIAGONAL).at(-0.5)).unwrap();
        let first = flow.until(1.0).unwrap();
        assert!(flow.until(1.0).unwrap().is_empty());
        let second = flow.until(2.0).unwrap();
        assert_eq!((first.len(), second.len()), (16, 10));
        assert_eq!(second.nodes[0].index, 16);
        assert!(matches!(
            flow.until(1.5).unwrap_err().error,
            RunError::Behind { time: 2.0, .. }
        ));
        assert!(matches!(
            flow.until(f64::NAN).unwrap_err().error,
            RunError::Until { .. }
        ));
        assert!(matches!(
            flow.until(f64::INFINITY).unwrap_err().error,
            RunError::Until { .. }
        ));
        flow.reverse();
        assert!(matches!(
            flow.until(3.0).unwrap_err().error,
            RunError::Behind { .. }
        ));
        let back = flow.until(-0.5).unwrap();
        let forward: Vec<_> = first.iter().chain(&second).collect();
        assert_eq!(back.len(), forward.len());
        for (node, other) in back.iter().zip(forward.into_iter().rev()) {
            assert_eq!(node.t, other.t);
            assert!(distance(node.q, other.q) < 1e-14);
            // the first node carries the initial velocity, not the central difference
            assert!(other.index == 0 || distance(node.v, other.v) < 1e-12);
        }
    }

    #[test]
    fn observers_see_every_node_and_may_end_the_run() {
        let particle = Particle::default();
        let mut flow = Flow::new(&particle, 0.1, Start::paper(ORIGIN, DIAGONAL)).unwrap();
        let mut count = 0;
        flow.stream(10.0, &mut |_: &Node<2>| count += 1).unwrap();
        assert_eq!(count, 101);
        let mut seen = 0;
        let mut observer = until_break(|node: &Node<2>| {
            seen += 1;
            if node.t > 11.95 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        flow.stream(f64::INFINITY, &mut observer).unwrap();
        assert_eq!(seen, 20);
        assert_eq!(flow.next().unwrap().unwrap().index, 121);
    }

    #[test]
    fn a_failed_run_gives_what_it_has() {
        let mut flow = Flow::new(&Cliff, 0.5, Start::nodes([0.0], [0.25])).unwrap();
        let failure = flow.until(100.0).unwrap_err();
        let RunError::Step(error) = &failure.error else {
            panic!("{failure}")
        };
        let step = error.details();
        assert_eq!(step.cause.reason, StepFailure::NotFinite);
        assert!(step.q1[0] > 1.0 && step.q0[0] <= 1.0);
        assert_eq!(failure.trajectory.len() as u64, step.index);
        assert_eq!(step.coordinates, ["x"]);
        assert!(failure.to_string().contains("no value here"), "{failure}");
        let mut flow = Flow::new(&Cliff, 0.5, Start::nodes([0.0], [0.25])).unwrap();
        assert!((&mut flow).take(1000).last().unwrap().is_err());
        assert!(flow.next().is_none());
    }

    #[test]
    fn rest_is_reported_where_curvature_is_undefined() {
        let particle = Particle::default();
        let error = Flow::new(&particle, 0.1, Start::second_order(ORIGIN, ORIGIN)).unwrap_err();
        assert!(matches!(error, SetupError::Acceleration { .. }));
        assert!(error.to_string().contains("at rest"), "{error}");
        let mut flow = Flow::new(&particle, 0.1, Start::paper(ORIGIN, ORIGIN)).unwrap();
        assert!(flow.next().unwrap().unwrap().a[0].is_nan());
        let error = flow.next().unwrap().unwrap_err();
        assert!(error.to_string().contains("at rest"), "{error}");
    }

    #[test]
    fn bad_input_is_told_before_the_run() {
        let good = Start::paper(ORIGIN, DIAGONAL);
        let particle = Particle::default();
        let error = |h, start| Flow::new(&particle, h, start).unwrap_err();
        for h in [0.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(error(h, good), SetupError::Step { .. }));
        }
        assert!(matches!(error(1e-170, good), SetupError::StepRange { .. }));
        assert!(matches!(
            error(0.1, good.at(f64::NAN)),
            SetupError::StartTime { .. }
        ));
        let start = Start::nodes(ORIGIN, [0.0, f64::NAN]);
        assert!(matches!(
            error(0.1, start),
            SetupError::Start {
                vector: "q1",
                coordinate: "y",
                ..
            }
        ));
        let start = Start::paper([f64::INFINITY, 0.0], DIAGONAL);
        assert!(matches!(
            error(0.1, start),
            SetupError::Start {
                vector: "q0",
                coordinate: "x",
                ..
            }
        ));
        let start = Start::second_order(ORIGIN, [0.0, f64::NAN]);
        assert!(matches!(
            error(0.1, start),
            SetupError::Start {
                vector: "v0",
                coordinate: "y",
                ..
            }
        ));
        let particle = Particle {
            mass: 1.0,
            curvature: f64::NAN,
        };
        let error = Flow::new(&particle, 0.1, good).unwrap_err();
        assert!(matches!(
            error,
            SetupError::Parameter {
                name: "curvature",
                ..
            }
        ));
    }

    #[test]
    fn a_start_by_nodes_keeps_their_difference() {
        let particle = Particle::default();
        let flow = Flow::new(
            &particle,
            0.1,
            Start::nodes([1e8, 1e8], [1e8 + 0.125, 1e8 - 0.25]),
        )
        .unwrap();
        assert_eq!(flow.leg().d, [0.125, -0.25]);
    }
}
