//! Measurements of generated and hand-written code in turn.

use std::hint::black_box;
use std::time::Instant;

use dsocs_core::__private::Compiled as _;
use dsocs_core::{Flow, Leg, Start, Stepper as _, System, dsocs};

use crate::handwritten::lean::{Kernel, Lean};
use crate::handwritten::{chain, particle, pendulum, top};
use crate::systems::{Constant, Curvature, CurvedParticle, InertiaWheelPendulum, PlanarChain8, Wavy};

/// The step of the particle and the pendulum, in s.
pub const H: f64 = 0.1;

/// The step of the chain, in s; its fastest motion has some 30 rad/s.
pub const H_CHAIN: f64 = 0.005;

/// The number of steps after which a run begins again: 2000 s of the pendulum, the paper's duration.
const RUN: u32 = 20_000;

/// The number of steps of the chain: after five seconds rounding has grown so much that two codes differ.
const RUN_CHAIN: u32 = 1000;

/// The particle's start: position and velocity.
pub const PARTICLE: ([f64; 2], [f64; 2]) = ([0.0, 0.0], [1.0, 1.0]);

/// The pendulum's start.
pub const PENDULUM: ([f64; 2], [f64; 2]) = ([0.5, 0.0], [0.0, 0.5]);

/// The chain's start: bent, and rotating.
pub const CHAIN: ([f64; 8], [f64; 8]) = ([1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3], [0.5; 8]);

/// The top's step and start.
pub const H_TOP: f64 = 0.02;
pub const TOP: ([f64; 4], [f64; 4]) = ([1.0, 0.0, 0.0, 0.0], [0.0, 0.6, -0.3, 3.0]);

/// The heavy top of `handwritten/top.rs`, with its numbers.
#[dsocs {
    coordinates(r: rotation);
    let w = r.angular_velocity();
    lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - (r * [0.2, 0.1, 1])[2];
}]
pub struct Top {}

/// A code that makes steps.
pub trait Steps: Clone {
    fn step(&mut self) -> u32;
    fn place(&self) -> &[f64];
}

impl<const N: usize> Steps for Flow<'_, N> {
    #[inline]
    fn step(&mut self) -> u32 {
        self.advance().expect("the step has a solution").iterations
    }

    fn place(&self) -> &[f64] {
        self.position()
    }
}

impl<K: Fn(f64, f64) -> f64 + Copy> Steps for particle::Particle<K> {
    #[inline]
    fn step(&mut self) -> u32 {
        self.advance().expect("the step has a solution")
    }

    fn place(&self) -> &[f64] {
        self.position()
    }
}

impl Steps for pendulum::Pendulum {
    #[inline]
    fn step(&mut self) -> u32 {
        self.advance().expect("the step has a solution")
    }

    fn place(&self) -> &[f64] {
        self.position()
    }
}

impl Steps for top::Top {
    #[inline]
    fn step(&mut self) -> u32 {
        self.advance().expect("the step has a solution")
    }

    fn place(&self) -> &[f64] {
        self.position()
    }
}

impl<const N: usize> Steps for chain::Chain<N> {
    #[inline]
    fn step(&mut self) -> u32 {
        self.advance().expect("the step has a solution")
    }

    fn place(&self) -> &[f64] {
        self.position()
    }
}

pub fn flow<S: System<N>, const N: usize>(system: &S, h: f64, (q0, v0): ([f64; N], [f64; N])) -> Flow<'_, N> {
    Flow::new(system, h, Start::paper(q0, v0)).expect("a start")
}

pub fn particle_by_hand<K: Fn(f64, f64) -> f64>(curvature: K) -> particle::Particle<K> {
    particle::Particle::new(curvature, PARTICLE.0, PARTICLE.1.map(|v| H * v))
}

pub fn pendulum_by_hand() -> pendulum::Pendulum {
    pendulum::Pendulum::new(H, PENDULUM.0, PENDULUM.1.map(|v| H * v))
}

pub fn top_by_hand() -> top::Top {
    let [_, x, y, z] = TOP.1.map(|w| H_TOP * w);
    top::Top::new(H_TOP, TOP.0, [x, y, z])
}

pub fn chain_by_hand() -> chain::Chain<8> {
    let PlanarChain8 {
        masses,
        lengths,
        gravity,
    } = PlanarChain8::default();
    let constants = chain::Constants::new(masses, lengths, gravity, H_CHAIN);
    chain::Chain::new(constants, CHAIN.0, CHAIN.1.map(|v| H_CHAIN * v))
}

/// The curvature 1.
pub fn one(_: f64, _: f64) -> f64 {
    1.0
}

/// The curvature of the bench, `1 + sin(x) cos(y) / 2`, with its coefficients as literals.
pub fn field(x: f64, y: f64) -> f64 {
    1.0 + 0.5 * x.sin() * y.cos()
}

/// The particle on a circle.
pub const CIRCLE: CurvedParticle<Constant> = CurvedParticle {
    mass: 1.0,
    curvature: Constant(1.0),
};

/// The particle in the field.
pub fn wavy() -> CurvedParticle<Wavy> {
    CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    }
}

/// Asserts that both codes solve the same problem: the same nodes to `tolerance`, in the same number of
/// iterations.
fn must_agree(name: &str, mut generated: impl Steps, mut rival: impl Steps, steps: u32, tolerance: &[f64]) {
    let mut iterations = [0; 2];
    for k in 0..steps {
        iterations[0] += generated.step();
        iterations[1] += rival.step();
        let places = generated.place().iter().zip(rival.place()).zip(tolerance);
        for (i, ((left, right), tolerance)) in places.enumerate() {
            let distance = (left - right).abs();
            assert!(
                distance <= *tolerance,
                "{name}, step {k}: coordinate {i} is {distance:e} apart"
            );
        }
    }
    let mean = iterations.map(|count| f64::from(count) / f64::from(steps));
    eprintln!(
        "{name}: the same motion, {:.3} iterations a step generated, {:.3} by hand",
        mean[0], mean[1]
    );
    assert!(
        (mean[0] - mean[1]).abs() < 0.1,
        "{name}: one of the two has an easier time"
    );
}

/// One line of the table.
pub struct Line {
    pub system: String,
    /// `step`, or `eval`: an evaluation of the rows and their Jacobian.
    pub what: String,
    pub generated: f64,
    pub by_hand: f64,
    pub ratio: f64,
}

/// The median.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Measures two codes in turn. Each closure does a batch of work and returns the number of units in it.
fn alternate(
    system: &str,
    what: &str,
    batches: usize,
    mut generated: impl FnMut() -> u32,
    mut by_hand: impl FnMut() -> u32,
) -> Line {
    fn time(batch: &mut impl FnMut() -> u32) -> f64 {
        let start = Instant::now();
        let units = batch();
        start.elapsed().as_secs_f64() * 1e9 / f64::from(units)
    }
    for _ in 0..batches / 10 {
        black_box((generated(), by_hand()));
    }
    let (mut left, mut right, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for batch in 0..batches {
        // each goes first half of the time
        let (generated, by_hand) = if batch % 2 == 0 {
            let first = time(&mut generated);
            (first, time(&mut by_hand))
        } else {
            let first = time(&mut by_hand);
            (time(&mut generated), first)
        };
        left.push(generated);
        right.push(by_hand);
        ratios.push(generated / by_hand);
    }
    Line {
        system: system.to_owned(),
        what: what.to_owned(),
        generated: median(left),
        by_hand: median(right),
        ratio: median(ratios),
    }
}

/// Batches of steps, one after the other along a run, and the run again from its start.
fn steps<S: Steps>(start: S, run: u32) -> impl FnMut() -> u32 {
    let batch = run.min(1000);
    let (mut stepper, mut done) = (start.clone(), 0);
    move || {
        if done == run {
            (stepper, done) = (start.clone(), 0);
        }
        let mut iterations = 0;
        for _ in 0..batch {
            iterations += stepper.step();
        }
        black_box(iterations);
        done += batch;
        batch
    }
}

/// Batches of evaluations of the rows and their Jacobian, each at an unknown that depends on the last
/// evaluation: as in Newton's iteration, and unlike independent evaluations, several of which a processor
/// does at once.
fn evaluations<const M: usize>(
    z: [f64; M],
    batch: u32,
    evaluate: impl Fn([f64; M]) -> f64,
) -> impl FnMut() -> u32 {
    move || {
        let mut at = black_box(z);
        for _ in 0..batch {
            // too small to change the unknown, but the compiler cannot know this
            let shift = 1e-200 * evaluate(at);
            at = z.map(|z| z + shift);
        }
        black_box(at);
        batch
    }
}

/// A number that depends on every number of an evaluation.
#[inline(always)]
fn all<const M: usize>(rows: [f64; M], jacobian: [[f64; M]; M]) -> f64 {
    let row_sum = |row: [f64; M]| row.into_iter().fold(0.0, |sum, x| sum + x);
    row_sum(rows) + row_sum(jacobian.map(row_sum))
}

/// A leg in the middle of a run and its next second difference, at which rows are evaluated.
fn in_the_middle<const N: usize>(mut flow: Flow<'_, N>) -> (Leg<f64, N>, [f64; N]) {
    for _ in 0..300 {
        flow.advance().expect("the step has a solution");
    }
    let leg = flow.leg();
    flow.advance().expect("the step has a solution");
    let after = flow.leg();
    (leg, std::array::from_fn(|i| after.d[i] - leg.d[i]))
}

fn particle_lines<K: Curvature, F: Fn(f64, f64) -> f64 + Copy>(
    name: &str,
    system: &CurvedParticle<K>,
    curvature: F,
    tolerance: f64,
    batches: usize,
) -> [Line; 2] {
    let start = || flow(system, H, PARTICLE);
    must_agree(name, start(), particle_by_hand(curvature), RUN, &[tolerance; 2]);
    let run = alternate(
        name,
        "step",
        batches,
        steps(start(), RUN),
        steps(particle_by_hand(curvature), RUN),
    );
    let (leg, e) = in_the_middle(start());
    let constants = system.constants(&system.parameters(), H);
    let known = system.known(&constants, &leg);
    let rival = particle::Known::new(leg.d, curvature(leg.q[0], leg.q[1]));
    let rows = alternate(
        name,
        "eval",
        batches,
        evaluations(e, 10_000, |e| {
            let at = system.linearize(&constants, &known, &e);
            all(at.rows, at.jacobian)
        }),
        evaluations(e, 10_000, |e| {
            let (rows, jacobian) = rival.rows(e);
            all(rows, jacobian)
        }),
    );
    [rows, run]
}

fn pendulum_lines(batches: usize) -> [Line; 2] {
    let name = "pendulum";
    let system = InertiaWheelPendulum::default();
    let start = || flow(&system, H, PENDULUM);
    must_agree(name, start(), pendulum_by_hand(), RUN, &[5e-11, 1e-8]);
    let run = alternate(
        name,
        "step",
        batches,
        steps(start(), RUN),
        steps(pendulum_by_hand(), RUN),
    );
    let (leg, e) = in_the_middle(start());
    let constants = system.constants(&system.parameters(), H);
    let known = system.known(&constants, &leg);
    let rival_constants = pendulum::Constants::new(H);
    let rival = rival_constants.known(leg.q, leg.d);
    let rows = alternate(
        name,
        "eval",
        batches,
        evaluations(system.unknown(&e, &[]), 10_000, |z| {
            let at = system.linearize(&constants, &known, &z);
            all(at.rows, at.jacobian)
        }),
        evaluations([e[0]], 10_000, |[z]| {
            let (row, slope) = rival_constants.row(&rival, z);
            all([row], [[slope]])
        }),
    );
    [rows, run]
}

fn chain_lines(batches: usize) -> [Line; 2] {
    let name = "chain8";
    let system = PlanarChain8::default();
    let rival_constants = chain::Constants::new(system.masses, system.lengths, system.gravity, H_CHAIN);
    let start = || flow(&system, H_CHAIN, CHAIN);
    // a chain is chaotic: later, rounding has grown too much
    must_agree(name, start(), chain_by_hand(), RUN_CHAIN / 2, &[1e-9; 8]);
    let run = alternate(
        name,
        "step",
        batches,
        steps(start(), RUN_CHAIN),
        steps(chain_by_hand(), RUN_CHAIN),
    );
    let (leg, e) = in_the_middle(start());
    let constants = system.constants(&system.parameters(), H_CHAIN);
    let known = system.known(&constants, &leg);
    let rival = rival_constants.known(leg.q, leg.d);
    let rows = alternate(
        name,
        "eval",
        batches,
        evaluations(system.unknown(&e, &[]), 2000, |z| {
            let at = system.linearize(&constants, &known, &z);
            all(at.rows, at.jacobian)
        }),
        evaluations(e, 2000, |e| {
            let (rows, jacobian) = rival_constants.rows(&rival, e);
            all(rows, jacobian)
        }),
    );
    [rows, run]
}

fn top_line(batches: usize) -> Line {
    let name = "heavy_top";
    let start = || flow(&Top {}, H_TOP, TOP);
    must_agree(name, start(), top_by_hand(), RUN, &[1e-12; 4]);
    alternate(
        name,
        "step",
        batches,
        steps(start(), RUN),
        steps(top_by_hand(), RUN),
    )
}

/// The step of a smooth motion, against a lean one with the same tests behind an object-safe trait
/// (`handwritten/lean.rs`): all steps in one call, one step a call, and steps with nodes against steps in one
/// call.
fn lean_lines<S: System<2>>(
    name: &str,
    system: &S,
    start: ([f64; 2], [f64; 2]),
    batches: usize,
) -> [Line; 3] {
    /// The step of these lines, for smooth motions.
    const H_SMOOTH: f64 = 0.01;
    const BATCH: u32 = 1000;
    const LONG: u32 = 20;
    /// A run that begins again after `LONG` batches.
    fn again<T>(start: impl Fn() -> T, mut batch: impl FnMut(&mut T)) -> impl FnMut() -> u32 {
        let (mut run, mut done) = (start(), 0);
        move || {
            if done == LONG {
                (run, done) = (start(), 0);
            }
            batch(&mut run);
            done += 1;
            BATCH
        }
    }
    let flow = || Flow::new(system, H_SMOOTH, Start::second_order(start.0, start.1)).expect("a start");
    let lean = || {
        let mut lean: Box<dyn Kernel + '_> = Box::new(Lean::new(system, H_SMOOTH, &flow().leg()));
        assert!(lean.steps(100), "{name}: a smooth start");
        lean
    };
    let (mut ours, mut theirs) = (flow(), lean());
    for _ in 0..100 + LONG * BATCH {
        ours.advance().expect("a step");
    }
    assert!(theirs.steps(u64::from(LONG * BATCH)), "{name}: a smooth motion");
    for (ours, theirs) in ours.position().iter().zip(theirs.place()) {
        assert!((ours - theirs).abs() <= 1e-9, "{name}: {ours} {theirs}");
    }
    let one_call = || again(lean, |lean| assert!(black_box(lean).steps(u64::from(BATCH))));
    let single = || {
        again(lean, |lean| {
            for _ in 0..BATCH {
                assert!(black_box(&mut *lean).steps(1));
            }
        })
    };
    let to = again(flow, |flow| {
        let end = flow.clock().time_of(flow.clock().index() + u64::from(BATCH));
        black_box(flow.to(end)).expect("steps");
    });
    let advance = again(flow, |flow| {
        for _ in 0..BATCH {
            black_box(black_box(&mut *flow).advance()).expect("a step");
        }
    });
    let nodes = again(flow, |flow| {
        for node in flow.take(BATCH as usize) {
            black_box(node).expect("a node");
        }
    });
    [
        alternate(name, "to ÷ lean", batches, to, one_call()),
        alternate(name, "advance ÷ lean", batches, advance, single()),
        alternate(name, "nodes ÷ lean", batches, nodes, single()),
    ]
}

/// All lines of the table.
pub fn lines(batches: usize) -> Vec<Line> {
    let mut lines = Vec::new();
    lines.extend(particle_lines("particle", &CIRCLE, one, 1e-11, batches));
    lines.extend(particle_lines("particle_field", &wavy(), field, 1e-9, batches));
    lines.extend(pendulum_lines(batches));
    lines.extend(chain_lines(batches));
    lines.push(top_line(batches));
    lines.extend(lean_lines("particle", &CIRCLE, PARTICLE, batches));
    lines.extend(lean_lines(
        "pendulum",
        &InertiaWheelPendulum::default(),
        PENDULUM,
        batches,
    ));
    lines
}
