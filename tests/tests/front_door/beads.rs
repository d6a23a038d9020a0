use std::process::ExitCode;

use dsocs_core::dsocs;
use dsocs_systems::{Entry, cli};

/// Two beads on a hoop that turns about its vertical diameter. A spring along the chord ties them together.
#[dsocs {
    coordinates(
        /// The angle of each bead from the lowest point [rad].
        theta: [2],
    );
    let swing = |i| masses[i] / 2 * length.powi(2) * (dot(theta[i]).powi(2) + (rate * theta[i].sin()).powi(2));
    let height = |i| -length * theta[i].cos();
    let stretch = 2 * length.powi(2) * (1 - (theta[0] - theta[1]).cos());
    lagrangian = sum(0..2, |i| swing(i) - masses[i] * gravity * height(i)) - stiffness / 2 * stretch;

    /// The torque that keeps the hoop turning [N m].
    let torque = sum(0..2, |i| masses[i] * length.powi(2) * rate * dot(theta[i].sin().powi(2)));
    observe = [torque];
}]
#[derive(Clone)]
struct BeadsOnHoop {
    /// The mass of each bead [kg].
    masses: [f64; 2],
    /// The radius of the hoop, a length [m].
    length: f64,
    /// The rate at which the hoop turns [rad/s].
    rate: f64,
    /// The stiffness of the spring [N/m].
    stiffness: f64,
    /// The acceleration of gravity [m/s²].
    gravity: f64,
}

fn main() -> ExitCode {
    cli::main([Entry::new(BeadsOnHoop { masses: [0.1, 0.2], length: 0.5, rate: 5.0, stiffness: 0.3, gravity: 9.81 })])
}
