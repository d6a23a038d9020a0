//! The time of a step against the size of the system: planar chains of 2, 4, 8, 16 and 32 links in angles,
//! where every link is coupled to every other; and chains of 25, 50, 100 and 200 rods in Cartesian
//! coordinates, where each is coupled to its neighbours only.
//!
//! Behind the feature `growth`, since the compiler needs minutes for the largest chain. With `--rods LINKS
//! STEPS` it makes this many steps of one chain and nothing else. Under `valgrind --tool=callgrind`, the
//! difference of two such runs is the number of instructions of the steps (with
//! `GLIBC_TUNABLES=glibc.cpu.x86_rep_movsb_threshold=100000000`: callgrind counts the bytes of `rep movsb`).

#![allow(missing_docs)] // a bench is no library

use std::hint::black_box;
use std::time::Instant;

use dsocs_core::{Flow, Start, Stepper, System};

dsocs_systems::planar_chain! {
    /// Four links.
    #[derive(Clone, Debug)]
    pub struct Chain4; 4
}
dsocs_systems::planar_chain! {
    /// Sixteen links.
    #[derive(Clone, Debug)]
    pub struct Chain16; 16
}
dsocs_systems::planar_chain! {
    /// Thirty-two links.
    #[derive(Clone, Debug)]
    pub struct Chain32; 32
}

/// Declares a chain of points on massless rods, in Cartesian coordinates.
macro_rules! rods {
    ($name:ident, $n:literal) => {
        #[dsocs_core::dsocs {
                    coordinates(x: [$n], y: [$n]);
                    lagrangian = sum(0..$n, |i| {
                        mass * ((dot(x[i]).powi(2) + dot(y[i]).powi(2)) / 2 - gravity * y[i])
                    });
                    let rod = |i| (x[i] - x[i - 1]).powi(2) + (y[i] - y[i - 1]).powi(2) - length.powi(2);
                    holonomic = [x[0].powi(2) + y[0].powi(2) - length.powi(2), each(1..$n, |i| rod(i))];
                }]
        struct $name {
            mass: f64,
            length: f64,
            gravity: f64,
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    mass: 1.0,
                    length: 1.0,
                    gravity: 9.81,
                }
            }
        }
    };
}

rods!(Rods25, 25);
rods!(Rods50, 50);
rods!(Rods100, 100);
rods!(Rods200, 200);

/// The positions of rods of length 1 whose angle varies along the chain.
fn leaning<const N: usize>() -> [f64; N] {
    let (mut q, links) = ([0.0; N], N / 2);
    let (mut x, mut y) = (0.0, 0.0);
    for i in 0..links {
        let angle = 0.3 + 0.2 * (3.0 * i as f64 / links as f64).sin();
        x += angle.sin();
        y -= angle.cos();
        (q[i], q[links + i]) = (x, y);
    }
    q
}

/// The step, in s.
const H: f64 = 1e-3;

/// The median over rounds of the nanoseconds per step, and the mean number of iterations.
fn measure<S: System<N>, const N: usize>(system: &S, rounds: usize) -> (f64, f64) {
    let bent = std::array::from_fn(|i| 1.0 - 0.5 * i as f64 / N as f64);
    measure_from(system, Start::second_order(bent, [0.5; N]), rounds)
}

/// The time and the iterations of a step, from a given start.
fn measure_from<S: System<N>, const N: usize>(system: &S, start: Start<N>, rounds: usize) -> (f64, f64) {
    const STEPS: u32 = 100;
    let mut start = Flow::new(system, H, start).expect("a start");
    for _ in 0..STEPS {
        start.advance().expect("the step has a solution");
    }
    let (mut times, mut iterations) = (Vec::new(), 0);
    for _ in 0..rounds {
        let mut flow = start.clone();
        let begin = Instant::now();
        for _ in 0..STEPS {
            iterations += flow.advance().expect("the step has a solution").iterations;
        }
        times.push(begin.elapsed().as_secs_f64() * 1e9 / f64::from(STEPS));
        black_box(flow.position());
    }
    times.sort_by(f64::total_cmp);
    (
        times[rounds / 2],
        f64::from(iterations) / f64::from(STEPS) / rounds as f64,
    )
}

/// The slope of a straight line through points.
fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let mean = |part: fn(&(f64, f64)) -> f64| points.iter().map(part).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let covariance: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    covariance / points.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>()
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(place) = arguments.iter().position(|argument| argument == "--rods") {
        let number = |place: usize| arguments.get(place).and_then(|text| text.parse().ok());
        match (number(place + 1), number(place + 2)) {
            (Some(25), Some(steps)) => run(&Rods25::default(), steps),
            (Some(50), Some(steps)) => run(&Rods50::default(), steps),
            (Some(100), Some(steps)) => run(&Rods100::default(), steps),
            (Some(200), Some(steps)) => run(&Rods200::default(), steps),
            _ => println!("--rods 25|50|100|200 STEPS"),
        }
        return;
    }
    let rounds = if std::env::args().any(|argument| argument == "--test") {
        1
    } else {
        51
    };
    let rows = [
        (2, measure(&dsocs_systems::PlanarChain2::default(), rounds)),
        (4, measure(&Chain4::default(), rounds)),
        (8, measure(&dsocs_systems::PlanarChain8::default(), rounds)),
        (16, measure(&Chain16::default(), rounds)),
        (32, measure(&Chain32::default(), rounds)),
    ];
    table("by angles", &rows);
    let rods = [
        (25, measure_rods(&Rods25::default(), rounds)),
        (50, measure_rods(&Rods50::default(), rounds)),
        (100, measure_rods(&Rods100::default(), rounds)),
        (200, measure_rods(&Rods200::default(), rounds)),
    ];
    table("rods", &rods);
}

/// The time and the iterations of a step of a chain of rods that starts at rest.
fn measure_rods<S: System<N>, const N: usize>(system: &S, rounds: usize) -> (f64, f64) {
    measure_from(system, Start::second_order(leaning(), [0.0; N]), rounds)
}

/// Prints the times, and the exponent of their growth.
fn table(name: &str, rows: &[(u32, (f64, f64))]) {
    println!("{name}: links  ns/step  iterations/step  ns/evaluation");
    let mut points = Vec::new();
    for &(n, (time, iterations)) in rows {
        println!(
            "{n:>5} {time:>8.0} {iterations:>16.2} {:>14.0}",
            time / iterations
        );
        points.push((f64::from(n).ln(), (time / iterations).ln()));
    }
    println!(
        "the time of an evaluation with its solution grows as n^{:.2}",
        slope(&points)
    );
}

/// Makes this many steps of a chain of rods.
fn run<S: System<N>, const N: usize>(system: &S, steps: u32) {
    let start = Start::second_order(leaning(), [0.0; N]);
    let mut flow = Flow::new(system, H, start).expect("a start");
    for _ in 0..steps {
        flow.advance().expect("the step has a solution");
    }
    black_box(flow.position());
}
