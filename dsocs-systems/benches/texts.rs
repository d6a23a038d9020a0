//! A step of a system that is read from text, by the interpreter and as machine code (feature `jit`), beside
//! the compiled one; a run by Taylor series to 1e-12 by the interpreter beside the compiled one; and the time
//! from a text to its first step.
//!
//! All are measured in turn in one process. A result is the median of the ratios of all rounds: noise of the
//! machine affects both times of a ratio alike. All three make the same nodes, bit for bit.

#![allow(missing_docs)] // a bench is no library

use std::hint::black_box;
use std::time::Instant;

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::{TapeKernel, Text};
use dsocs_core::{AnyFlow, AnyStart, Kernel, Run, Start, Stepper, System, TaylorFlow, Tolerance, dsocs};
use dsocs_systems::{Entry, InertiaWheelPendulum, PlanarChain8};

/// A particle that turns with a curvature.
#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
    variational = [(dot(x), dot(y))];
}]
#[derive(Clone, Copy)]
struct Particle {
    mass: f64,
    curvature: f64,
}

/// A particle whose curvature varies over the plane.
#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    let curvature = mean + amplitude * x.sin() * y.cos();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
    variational = [(dot(x), dot(y))];
}]
#[derive(Clone, Copy)]
struct Field {
    mass: f64,
    mean: f64,
    amplitude: f64,
}

/// The number of steps in a batch.
const BATCH: u32 = 1000;

/// The median.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Runs of several kernels of one system, in turn.
struct Turns<'k> {
    kernels: Vec<&'k dyn Kernel>,
    h: f64,
    start: AnyStart,
    /// The number of batches in a run.
    run: u32,
}

impl<'k> Turns<'k> {
    fn flow(&self, kernel: &'k dyn Kernel) -> AnyFlow<'k> {
        let mut flow = AnyFlow::new(kernel, self.h, &self.start).expect("a start");
        flow.run_mut().advance().expect("a step");
        flow
    }

    /// The time of a step of each kernel, in ns, and its ratio to that of the first.
    fn measured(&self, rounds: usize) -> (Vec<f64>, Vec<f64>) {
        let count = self.kernels.len();
        let (mut times, mut ratios) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        for _ in 0..rounds.div_ceil(self.run as usize) {
            let mut flows: Vec<_> = self.kernels.iter().map(|kernel| self.flow(*kernel)).collect();
            for batch in 1..=self.run {
                let t = self.h * f64::from(1 + batch * BATCH);
                let own = flows.iter_mut().map(|flow| {
                    let begin = Instant::now();
                    black_box(flow.run_mut().to(t)).expect("steps");
                    begin.elapsed().as_secs_f64() * 1e9 / f64::from(BATCH)
                });
                let own: Vec<f64> = own.collect();
                for (place, time) in own.iter().enumerate() {
                    times[place].push(*time);
                    ratios[place].push(time / own[0]);
                }
            }
            let nodes: Vec<_> = flows.iter().map(|flow| place(flow.run())).collect();
            assert!(nodes.iter().all(|node| *node == nodes[0]), "the bits differ");
        }
        (
            times.into_iter().map(median).collect(),
            ratios.into_iter().map(median).collect(),
        )
    }
}

/// The bits of the current position.
fn place(run: &dyn Run) -> Vec<u64> {
    let mut node = dsocs_core::OwnedNode::new(0);
    node.take(run);
    node.any().q.iter().map(|x| x.to_bits()).collect()
}

/// The time of a run by Taylor series to 1e-12 of the interpreted system, divided by that of the compiled one.
fn series<S: System<N>, const N: usize>(
    (system, walked): (&S, &TapeKernel),
    start: Start<N>,
    until: f64,
    rounds: usize,
) -> f64 {
    let tolerance = Tolerance::relative(1e-12);
    let ratios = (0..rounds.div_ceil(10)).map(|_| {
        let mut compiled = TaylorFlow::new(system, start, tolerance).expect("a series");
        let mut interpreted =
            AnyTaylorFlow::of_tape(walked, &AnyStart::from(start), tolerance).expect("a series");
        let begin = Instant::now();
        let node = black_box(compiled.to(until)).expect("steps");
        let first = begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        let run: &mut dyn Run = &mut interpreted;
        black_box(run.to(until)).expect("steps");
        let second = begin.elapsed().as_secs_f64();
        let same = node.q.map(f64::to_bits);
        assert!(place(&interpreted) == same, "the bits differ");
        second / first
    });
    median(ratios.collect())
}

/// The system of a text without machine code.
fn interpreted(kernel: TapeKernel) -> TapeKernel {
    #[cfg(feature = "jit")]
    return kernel.interpreted();
    #[cfg(not(feature = "jit"))]
    kernel
}

/// Compiles the system of a text to machine code; `false` if that is not possible.
fn is_compiled(kernel: &TapeKernel) -> bool {
    #[cfg(feature = "jit")]
    return kernel.compile().is_ok();
    #[cfg(not(feature = "jit"))]
    {
        let _ = kernel;
        false
    }
}

/// Prints the lines of a system.
fn lines<S: System<N> + Clone + Send + 'static, const N: usize>(
    name: &str,
    system: &S,
    (h, q0, v0, run): (f64, [f64; N], [f64; N], u32),
    rounds: usize,
) {
    let text = Entry::new(system.clone()).text().expect("a text");
    let read = || Text::parse(name, &text).expect("a system").system;
    let (walked, made) = (interpreted(read()), read());
    let mut kernels: Vec<&dyn Kernel> = vec![system.kernel(), &walked];
    if is_compiled(&made) {
        kernels.push(&made);
    }
    let start = Start::second_order(q0, v0);
    let of_series = series((system, &walked), start, 1000.0 * h, rounds);
    let start = AnyStart::from(start);
    let turns = Turns {
        kernels,
        h,
        start,
        run,
    };
    let (times, ratios) = turns.measured(rounds);
    let ready = |compile: bool| {
        let times = (0..15).map(|_| {
            let begin = Instant::now();
            let kernel = read();
            if compile {
                is_compiled(&kernel);
            }
            black_box(turns_first(&kernel, &turns));
            begin.elapsed().as_secs_f64() * 1e3
        });
        median(times.collect())
    };
    let first = [ready(false), ready(true)];
    let column = |of: &[f64], place: usize| of.get(place).copied().unwrap_or(f64::NAN);
    println!(
        "{name:<16} {:>11.1} {:>14.1} {:>6.2} {:>9.1} {:>6.2} {:>8.2} {:>12.2} {:>6.2}",
        column(&times, 0),
        column(&times, 1),
        column(&ratios, 1),
        column(&times, 2),
        column(&ratios, 2),
        of_series,
        first[0],
        first[1],
    );
}

/// Makes the first step of a run.
fn turns_first(kernel: &TapeKernel, turns: &Turns<'_>) -> u64 {
    let mut flow = AnyFlow::new(kernel, turns.h, &turns.start).expect("a start");
    flow.run_mut().advance().expect("a step");
    place(flow.run()).first().copied().unwrap_or_default()
}

fn main() {
    let given = |argument: &str| std::env::args().any(|given| given == argument);
    let rounds = match (given("--test"), given("--quick")) {
        (true, _) => 2,
        (false, true) => 200,
        (false, false) => 4000,
    };
    println!(
        "                        a step [ns], and its ratio to the compiled one   Taylor   text to first step [ms]"
    );
    println!(
        "system              compiled    interpreted  ratio       JIT  ratio    ratio  interpreted    JIT"
    );
    println!("bar                                            4.00            1.30     1.50");
    let particle = Particle {
        mass: 1.0,
        curvature: 1.0,
    };
    lines("particle", &particle, (0.1, [0.0, 0.0], [1.0, 1.0], 20), rounds);
    let field = Field {
        mass: 1.0,
        mean: 1.0,
        amplitude: 0.5,
    };
    lines(
        "particle_field",
        &field,
        (0.1, [0.0, 0.0], [1.0, 1.0], 20),
        rounds,
    );
    let pendulum = InertiaWheelPendulum::default();
    lines("pendulum", &pendulum, (0.1, [0.5, 0.0], [0.0, 0.5], 19), rounds);
    let bent = [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3];
    lines(
        "chain8",
        &PlanarChain8::default(),
        (0.005, bent, [0.5; 8], 2),
        rounds,
    );
}
