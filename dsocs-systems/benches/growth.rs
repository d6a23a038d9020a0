//! How the time of a step grows with the size of the system: planar chains of 2, 4, 8, 16 and 32 links.
//!
//! Behind the feature `growth`, since the compiler needs minutes for the largest chain.

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

/// The step.
const H: f64 = 1e-3;

/// The median over rounds of the nanoseconds per step, and the mean number of iterations.
fn measure<S: System<N>, const N: usize>(system: &S, rounds: usize) -> (f64, f64) {
    const STEPS: u32 = 100;
    let bent = std::array::from_fn(|i| 1.0 - 0.5 * i as f64 / N as f64);
    let mut start = Flow::new(system, H, Start::second_order(bent, [0.5; N])).expect("a start");
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
    println!("links  ns/step  iterations/step  ns/evaluation");
    let mut points = Vec::new();
    for (n, (time, iterations)) in rows {
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
