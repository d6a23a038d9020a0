//! Chapter *Performance*, "Chains": 16 × 16 points in the plane, each tied to its four neighbours by springs under tension, and to walls around.
//!
//! The points move a little along one axis, in the lowest mode of the lattice. The springs along this axis pull back by their stiffness `k`, the
//! others by their tension over their length, `k (1 − l/a)`. So with `N + 1` springs in each line
//! `m ω² = 4 k (2 − l/a) sin²(π/(2 (N+1)))`.
//!
//! `cargo run --release --features growth --example lattice`

use std::f64::consts::{PI, TAU};

use dsocs_core::prelude::*;

/// The number of points in a line.
const LINE: usize = 16;

/// A lattice of points and springs.
#[dsocs {
    coordinates(
        /// The displacement of each point along the lines [m].
        u: [256],
        /// The displacement of each point across the lines [m].
        v: [256],
    );
    let stretch = |a, b| (a.powi(2) + b.powi(2)).sqrt() - length;
    let along = |i| sum(0..15, |j| {
        stretch(spacing + u[16 * i + j + 1] - u[16 * i + j], v[16 * i + j + 1] - v[16 * i + j]).powi(2)
    });
    let across = |i| sum(0..15, |j| {
        stretch(spacing + v[16 * j + i + 16] - v[16 * j + i], u[16 * j + i + 16] - u[16 * j + i]).powi(2)
    });
    let walls = |i| {
        stretch(spacing + u[16 * i], v[16 * i]).powi(2) + stretch(spacing - u[16 * i + 15], v[16 * i + 15]).powi(2)
            + stretch(spacing + v[i], u[i]).powi(2) + stretch(spacing - v[240 + i], u[240 + i]).powi(2)
    };
    lagrangian = sum(0..256, |i| mass / 2 * (dot(u[i]).powi(2) + dot(v[i]).powi(2)))
        - stiffness / 2 * sum(0..16, |i| along(i) + across(i) + walls(i));
}]
struct Lattice {
    /// The mass of each point \[kg\].
    mass: f64,
    /// The stiffness of each spring \[N/m\].
    stiffness: f64,
    /// The length of a spring without tension \[m\].
    length: f64,
    /// The distance of neighbours at rest \[m\].
    spacing: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    const PERIODS: u32 = 4;
    const POINTS: usize = LINE * LINE;
    let lattice = Lattice {
        mass: 1.0,
        stiffness: 1.0,
        length: 0.5,
        spacing: 1.0,
    };
    let mut q = [0.0; 2 * POINTS];
    let wave = |i: usize| (PI * (i + 1) as f64 / (LINE + 1) as f64).sin();
    for (i, u) in q[..POINTS].iter_mut().enumerate() {
        *u = 1e-3 * wave(i / LINE) * wave(i % LINE);
    }
    let middle = POINTS / 2 + LINE / 2;
    let mut flow = Flow::new(&lattice, 0.02, Start::second_order(q, [0.0; 2 * POINTS]))?;
    // the point first passes its equilibrium after a quarter of a period, and then after each half of one
    let (mut passed, mut last, mut before) = (0, 0.0, (0.0, q[middle]));
    while passed < 2 * PERIODS {
        flow.advance()?;
        let now = (flow.time(), flow.position()[middle]);
        if now.1 * before.1 < 0.0 {
            last = before.0 - before.1 * (now.0 - before.0) / (now.1 - before.1);
            passed += 1;
        }
        before = now;
    }
    let period = last / (f64::from(PERIODS) - 0.25);
    let stiffness = lattice.stiffness * (2.0 - lattice.length / lattice.spacing);
    let frequency = 2.0 * (stiffness / lattice.mass).sqrt() * (PI / (2.0 * (LINE + 1) as f64)).sin();
    println!("period of the lattice: {period:.5} s");
    println!("by its dispersion relation: {:.5} s", TAU / frequency);
    assert!(
        (period * frequency / TAU - 1.0).abs() < 1e-4,
        "the lattice swings as it should"
    );
    Ok(())
}
