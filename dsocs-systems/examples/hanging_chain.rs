//! Chapter *Performance*, "Chains": a hanging chain of rods in Cartesian coordinates swings a little, and its
//! period is compared with theory.
//!
//! A point with `k` points below it moves by `L_k(z)` times the amplitude of the lowest one, and `ω² = z
//! g/l`. `L_k` is Laguerre's polynomial, and `z` the smallest zero of `L_n`: the points obey `(k+1) x_{k+1} =
//! (2k+1−z) x_k − k x_{k−1}`, which is its recurrence, and the point of suspension is fixed. With more and
//! shorter rods `ω` tends to that of a rope, `j₀/2 √(g/L)` with the first zero of Bessel's function `J₀`
//! (Daniel Bernoulli, 1732).
//!
//! `cargo run --release --example hanging_chain`

use std::f64::consts::TAU;

use dsocs_core::prelude::*;

/// The number of rods.
const RODS: usize = 16;

/// Points on massless rods, the first of which hangs from the origin.
#[dsocs {
    coordinates(
        /// The points, from above [m].
        x: [16],
        /// Upward [m].
        y: [16],
    );
    lagrangian = sum(0..16, |i| mass * ((dot(x[i]).powi(2) + dot(y[i]).powi(2)) / 2 - gravity * y[i]));
    let rod = |i| (x[i] - x[i - 1]).powi(2) + (y[i] - y[i - 1]).powi(2) - length.powi(2);
    holonomic = [x[0].powi(2) + y[0].powi(2) - length.powi(2), each(1..16, |i| rod(i))];
}]
struct Chain {
    /// The mass of each point \[kg\].
    mass: f64,
    /// The length of each rod \[m\].
    length: f64,
    /// The acceleration of gravity [m/s²].
    gravity: f64,
}

/// `L_0(z)` to `L_n(z)`.
fn laguerre(z: f64) -> [f64; RODS + 1] {
    let mut values = [1.0; RODS + 1];
    values[1] = 1.0 - z;
    for k in 1..RODS {
        let n = k as f64;
        values[k + 1] = ((2.0 * n + 1.0 - z) * values[k] - n * values[k - 1]) / (n + 1.0);
    }
    values
}

/// The smallest zero of `L_n`, by bisection.
fn smallest_zero() -> f64 {
    let (mut positive, mut negative) = (0.0, 2.0 / RODS as f64);
    for _ in 0..60 {
        let middle = 0.5 * (positive + negative);
        *if laguerre(middle)[RODS] > 0.0 {
            &mut positive
        } else {
            &mut negative
        } = middle;
    }
    positive
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    const PERIODS: u32 = 10;
    let chain = Chain {
        mass: 1.0 / RODS as f64,
        length: 1.0 / RODS as f64,
        gravity: 9.81,
    };
    // at rest, the lowest point a millimetre aside
    let z = smallest_zero();
    let shape = laguerre(z);
    let mut q = [0.0; 2 * RODS];
    let mut above = [0.0; 2];
    for i in 0..RODS {
        let x = 1e-3 * shape[RODS - 1 - i];
        let y = above[1] - (chain.length.powi(2) - (x - above[0]).powi(2)).sqrt();
        (q[i], q[RODS + i]) = (x, y);
        above = [x, y];
    }
    let mut flow = Flow::new(&chain, 1e-3, Start::second_order(q, [0.0; 2 * RODS]))?;
    // the lowest point first passes the middle after a quarter of a period, and then after each half of one
    let (mut passed, mut last, mut before) = (0, 0.0, (0.0, q[RODS - 1]));
    while passed < 2 * PERIODS {
        flow.advance()?;
        let now = (flow.time(), flow.position()[RODS - 1]);
        if now.1 * before.1 < 0.0 {
            last = before.0 - before.1 * (now.0 - before.0) / (now.1 - before.1);
            passed += 1;
        }
        before = now;
    }
    let period = last / (f64::from(PERIODS) - 0.25);
    let of_chain = TAU / (z * chain.gravity / chain.length).sqrt();
    let of_rope = TAU / (0.5 * 2.404_825_557_695_773 * chain.gravity.sqrt());
    println!("period of {RODS} rods: {period:.6} s");
    println!("by Laguerre's polynomial: {of_chain:.6} s");
    println!("of a rope: {of_rope:.6} s");
    assert!(
        (period / of_chain - 1.0).abs() < 1e-5,
        "the chain swings as it should"
    );
    Ok(())
}
