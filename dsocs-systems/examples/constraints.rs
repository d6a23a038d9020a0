//! Chapter *Constraints of every order and their forces*: the force that keeps a skate on its course, and its multiplier.
//!
//! `cargo run --release --example constraints`

use dsocs_core::prelude::*;

/// A skate on a slope. It cannot move across its blade.
#[dsocs {
    coordinates(x, y, theta);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) + inertia / 2 * dot(theta).powi(2)
        + mass * gravity * slope.sin() * x;
    nonholonomic = dot(x) * theta.sin() - dot(y) * theta.cos();
}]
struct Skate {
    mass: f64,
    inertia: f64,
    gravity: f64,
    slope: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let skate = Skate {
        mass: 1.0,
        inertia: 0.1,
        gravity: 9.81,
        slope: 0.2,
    };
    // it glides at 0.3 m/s and rotates; a start across the blade would be refused
    let start = Start::second_order([0.0; 3], [0.3, 0.0, 1.0]);
    let mut flow = Flow::new(&skate, 0.01, start)?;
    println!(
        "{:>6} {:>9} {:>9} {:>10} {:>10} {:>10}",
        "t [s]", "x [m]", "y [m]", "Q_x [N]", "Q_y [N]", "λ [N]"
    );
    for node in flow.until(6.0)?.nodes.iter().step_by(50) {
        let lambda = flow.multipliers(node).first().copied().unwrap_or(f64::NAN);
        println!(
            "{:>6.2} {:>9.4} {:>9.4} {:>10.4} {:>10.4} {lambda:>10.4}",
            node.t, node.q[0], node.q[1], node.force[0], node.force[1]
        );
    }
    Ok(())
}
