//! Chapter *Control*: a Lyapunov constraint, and the motor's control law that follows from it.
//!
//! `cargo run --release --example control`

use dsocs_core::prelude::*;

/// Two carts on springs, brought to rest by a motor on the second one.
#[dsocs {
    coordinates(x, y);
    let kinetic = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let potential = stiffness / 2 * (x.powi(2) + (y - x).powi(2));
    lagrangian = kinetic - potential;

    let lyapunov = kinetic + potential;
    let dissipation = gain * dot(y).powi(2);
    kinematic = dot(lyapunov) + dissipation;   // dV/dt = −F
    constraint_forces = [(0, 1)];              // the motor acts on the second cart
    branch = divide(dot(y));                   // a cart at rest obeys dV/dt = −F whatever the motor does
}]
struct Carts {
    mass: f64,
    stiffness: f64,
    gain: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let carts = Carts {
        mass: 1.0,
        stiffness: 4.0,
        gain: 0.8,
    };
    let start = Start::second_order([0.3, -0.2], [0.0, 0.5]);
    println!(
        "{:>6} {:>12} {:>14} {:>14}",
        "t [s]", "V [J]", "motor [N]", "−k ẏ [N]"
    );
    for node in Flow::new(&carts, 0.01, start)?
        .until(10.0)?
        .nodes
        .iter()
        .step_by(100)
    {
        // here the Lyapunov function V is the energy
        let law = -carts.gain * node.v[1];
        println!(
            "{:>6} {:>12.6} {:>14.8} {law:>14.8}",
            node.t, node.energy, node.force[1]
        );
    }
    Ok(())
}
