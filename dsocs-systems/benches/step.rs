//! Nanoseconds per step and per residual with Jacobian, generated code beside hand-written code.
//!
//! Criterion measures each alone. At the end both are measured in turn, batch by batch, and the table printed shows the
//! median of each and the median of the batches' ratios: what a noisy machine does to one it does to the other.

#![allow(missing_docs)] // a bench is no library
#![allow(clippy::inline_always)] // the rivals are to be as fast as they can be

mod handwritten;
mod throughput;

use std::hint::black_box;
use std::time::Instant;

use criterion::{BatchSize, Criterion, Throughput};
use dsocs_core::{Flow, Start, System};
use dsocs_systems::{Constant, Curvature, CurvedParticle, InertiaWheelPendulum, Wavy};
use handwritten::particle::{self, Particle};
use handwritten::pendulum::{self, Pendulum};

/// The step.
const H: f64 = 0.1;

/// The steps after which a run begins again: the pendulum's interesting 2000 seconds.
const RUN: u32 = 20_000;

/// The particle's start.
const PARTICLE: ([f64; 2], [f64; 2]) = ([0.0, 0.0], [1.0, 1.0]);

/// The pendulum's.
const PENDULUM: ([f64; 2], [f64; 2]) = ([0.5, 0.0], [0.0, 0.5]);

/// Something that steps.
trait Stepper: Clone {
    fn step(&mut self) -> u32;
    fn place(&self) -> [f64; 2];
}

impl<S: System<2>> Stepper for Flow<'_, S, 2> {
    #[inline]
    fn step(&mut self) -> u32 {
        self.advance().expect("the step has a solution").iterations
    }

    fn place(&self) -> [f64; 2] {
        *self.position()
    }
}

impl<K: Fn(f64, f64) -> f64 + Copy> Stepper for Particle<K> {
    #[inline]
    fn step(&mut self) -> u32 {
        self.advance().expect("the step has a solution")
    }

    fn place(&self) -> [f64; 2] {
        self.position()
    }
}

impl Stepper for Pendulum {
    #[inline]
    fn step(&mut self) -> u32 {
        self.advance().expect("the step has a solution")
    }

    fn place(&self) -> [f64; 2] {
        self.position()
    }
}

fn flow<S: System<2>>(system: &S, (q0, v0): ([f64; 2], [f64; 2])) -> Flow<'_, S, 2> {
    Flow::new(system, H, Start::paper(q0, v0)).expect("a start")
}

fn by_hand<K: Fn(f64, f64) -> f64>(curvature: K) -> Particle<K> {
    Particle::new(curvature, PARTICLE.0, PARTICLE.1.map(|v| H * v))
}

fn pendulum_by_hand() -> Pendulum {
    Pendulum::new(H, PENDULUM.0, PENDULUM.1.map(|v| H * v))
}

/// The field of the bench, `1 + sin(x) cos(y) / 2`, with its coefficients written in.
fn field(x: f64, y: f64) -> f64 {
    1.0 + 0.5 * x.sin() * y.cos()
}

/// Rivals must solve the same problem: the same nodes to rounding, in as many iterations.
fn must_agree(
    name: &str,
    mut generated: impl Stepper,
    mut rival: impl Stepper,
    steps: u32,
    tolerance: [f64; 2],
) {
    let mut iterations = [0; 2];
    for k in 0..steps {
        iterations[0] += generated.step();
        iterations[1] += rival.step();
        let (left, right) = (generated.place(), rival.place());
        for i in 0..2 {
            let distance = (left[i] - right[i]).abs();
            assert!(
                distance <= tolerance[i],
                "{name}, step {k}: coordinate {i} is {distance:e} apart"
            );
        }
    }
    let mean = iterations.map(|count| f64::from(count) / f64::from(steps));
    println!(
        "{name}: the same motion, {:.3} iterations a step generated, {:.3} by hand",
        mean[0], mean[1]
    );
    assert!(
        (mean[0] - mean[1]).abs() < 0.1,
        "{name}: one of the two has an easier time"
    );
}

/// One line of the table.
struct Line {
    system: &'static str,
    what: &'static str,
    generated: f64,
    by_hand: f64,
    ratio: f64,
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Measures two things in turn. Each closure does a batch of work and says of how many units.
fn alternate(
    [system, what]: [&'static str; 2],
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
        // neither always goes first
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
        system,
        what,
        generated: median(left),
        by_hand: median(right),
        ratio: median(ratios),
    }
}

/// Batches of steps, one after the other along a run, and the run again from its start.
fn steps<S: Stepper>(start: S) -> impl FnMut() -> u32 {
    const BATCH: u32 = 1000;
    let (mut stepper, mut done) = (start.clone(), 0);
    move || {
        if done == RUN {
            (stepper, done) = (start.clone(), 0);
        }
        let mut iterations = 0;
        for _ in 0..BATCH {
            iterations += stepper.step();
        }
        black_box(iterations);
        done += BATCH;
        BATCH
    }
}

/// Batches of evaluations of the rows and their Jacobian, each at an unknown that waits for the last: as in Newton's
/// iteration, and unlike independent evaluations, of which a processor does several at a time.
fn evaluations<const M: usize>(z: [f64; M], evaluate: impl Fn([f64; M]) -> f64) -> impl FnMut() -> u32 {
    const BATCH: u32 = 10_000;
    move || {
        let mut at = black_box(z);
        for _ in 0..BATCH {
            // too small to change the unknown, which the compiler does not know
            let shift = 1e-200 * evaluate(at);
            at = z.map(|z| z + shift);
        }
        black_box(at);
        BATCH
    }
}

/// Something that depends on every number of an evaluation.
#[inline(always)]
fn all<const M: usize>(rows: [f64; M], jacobian: [[f64; M]; M]) -> f64 {
    let row_sum = |row: [f64; M]| row.into_iter().fold(0.0, |sum, x| sum + x);
    row_sum(rows) + row_sum(jacobian.map(row_sum))
}

/// The state in which residuals are measured: in the middle of a run, at its next second difference.
fn in_the_middle<S: System<2>>(mut flow: Flow<'_, S, 2>) -> (dsocs_core::Leg<f64, 2>, [f64; 2]) {
    for _ in 0..300 {
        flow.step();
    }
    let leg = flow.leg();
    flow.step();
    let after = flow.leg();
    (leg, [after.d[0] - leg.d[0], after.d[1] - leg.d[1]])
}

fn particle_lines<K: Curvature, F: Fn(f64, f64) -> f64 + Copy>(
    name: &'static str,
    system: &CurvedParticle<K>,
    curvature: F,
    batches: usize,
) -> [Line; 2] {
    let run = alternate(
        [name, "step"],
        batches,
        steps(flow(system, PARTICLE)),
        steps(by_hand(curvature)),
    );
    let (leg, e) = in_the_middle(flow(system, PARTICLE));
    let constants = system.constants(H);
    let known = system.known(&constants, &leg);
    let rival = particle::Known::new(leg.d, curvature(leg.q[0], leg.q[1]));
    let rows = alternate(
        [name, "residual + Jacobian"],
        batches,
        evaluations(e, |e| {
            let at = system.residual(&constants, &known, &e);
            all(at.rows, at.jacobian)
        }),
        evaluations(e, |e| {
            let (rows, jacobian) = rival.rows(e);
            all(rows, jacobian)
        }),
    );
    [run, rows]
}

fn pendulum_lines(batches: usize) -> [Line; 2] {
    let name = "pendulum";
    let system = InertiaWheelPendulum::default();
    let run = alternate(
        [name, "step"],
        batches,
        steps(flow(&system, PENDULUM)),
        steps(pendulum_by_hand()),
    );
    let (leg, e) = in_the_middle(flow(&system, PENDULUM));
    let constants = system.constants(H);
    let known = system.known(&constants, &leg);
    let rival_constants = pendulum::Constants::new(H);
    let rival = rival_constants.known(leg.q, leg.d);
    let rows = alternate(
        [name, "residual + Jacobian"],
        batches,
        evaluations(system.unknown(&e), |z| {
            let at = system.residual(&constants, &known, &z);
            all(at.rows, at.jacobian)
        }),
        evaluations([e[0]], |[z]| {
            let (row, slope) = rival_constants.row(&rival, z);
            all([row], [[slope]])
        }),
    );
    [run, rows]
}

/// A thousand steps from a state in the middle of the run.
fn measure<S: Stepper>(criterion: &mut Criterion, name: &str, variant: &str, mut start: S) {
    const STEPS: u32 = 1000;
    for _ in 0..300 {
        start.step();
    }
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(u64::from(STEPS)));
    group.bench_function(variant, |bencher| {
        bencher.iter_batched_ref(
            || start.clone(),
            |stepper| {
                for _ in 0..STEPS {
                    black_box(stepper.step());
                }
            },
            BatchSize::SmallInput,
        );
    });
    group.finish();
}

fn main() {
    let constant = CurvedParticle {
        mass: 1.0,
        curvature: Constant(1.0),
    };
    let wavy = CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    };
    let pendulum = InertiaWheelPendulum::default();
    let one = |_: f64, _: f64| 1.0;

    must_agree(
        "particle, κ = 1",
        flow(&constant, PARTICLE),
        by_hand(one),
        RUN,
        [1e-11; 2],
    );
    must_agree(
        "particle, κ(x, y)",
        flow(&wavy, PARTICLE),
        by_hand(field),
        RUN,
        [1e-9; 2],
    );
    must_agree(
        "pendulum",
        flow(&pendulum, PENDULUM),
        pendulum_by_hand(),
        RUN,
        [5e-11, 1e-8],
    );

    let mut criterion = Criterion::default().configure_from_args();
    measure(
        &mut criterion,
        "particle, constant curvature",
        "generated",
        flow(&constant, PARTICLE),
    );
    measure(
        &mut criterion,
        "particle, constant curvature",
        "by hand",
        by_hand(one),
    );
    measure(
        &mut criterion,
        "particle, curvature field",
        "generated",
        flow(&wavy, PARTICLE),
    );
    measure(
        &mut criterion,
        "particle, curvature field",
        "by hand",
        by_hand(field),
    );
    measure(&mut criterion, "pendulum", "generated", flow(&pendulum, PENDULUM));
    measure(&mut criterion, "pendulum", "by hand", pendulum_by_hand());
    criterion.final_summary();

    let given = |argument: &str| std::env::args().any(|given| given == argument);
    let batches = if given("--test") {
        2
    } else if given("--quick") {
        400
    } else {
        4000
    };
    println!("\nsystem               what                 generated ns  by hand ns  ratio");
    let lines = particle_lines("particle, κ = 1", &constant, one, batches)
        .into_iter()
        .chain(particle_lines("particle, κ(x, y)", &wavy, field, batches))
        .chain(pendulum_lines(batches));
    for Line {
        system,
        what,
        generated,
        by_hand,
        ratio,
    } in lines
    {
        println!("{system:<20} {what:<20} {generated:>12.1} {by_hand:>11.1} {ratio:>6.2}");
    }
    let rounds = (batches / 20).max(2);
    println!("\nmany trajectories    a flow each ns  ensemble ns  gain  all threads ns  gain");
    let near = |(q, v): ([f64; 2], [f64; 2])| {
        move |part: f64| Start::paper(q, [v[0] + 0.1 * part, v[1] - 0.1 * part])
    };
    let tables = [
        throughput::measure(&constant, "particle, κ = 1", H, near(PARTICLE), rounds),
        throughput::measure(&wavy, "particle, κ(x, y)", H, near(PARTICLE), rounds),
        throughput::measure(&pendulum, "pendulum", H, near(PENDULUM), rounds),
    ];
    for table in tables {
        println!(
            "{:<20} {:>14.1} {:>12.1} {:>5.2} {:>15.1} {:>5.2}",
            table.system, table.flows, table.ensemble, table.lanes, table.all_threads, table.threads
        );
    }
}
