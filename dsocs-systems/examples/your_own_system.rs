//! Chapter *Your own system in ten minutes*: your own system with the whole command line.
//!
//! `cargo run --release --example your_own_system -- run --report bead.html`

use std::process::ExitCode;

use dsocs_core::dsocs;
use dsocs_systems::entry::Drawing;
use dsocs_systems::{Entry, cli};

/// A bead on a wire in the shape of a parabola.
#[dsocs {
    coordinates(
        /// The distance from the lowest point, measured along the ground [m].
        x,
    );
    let height = steepness * x.powi(2);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(height).powi(2)) - mass * gravity * height;

    /// The speed along the wire [m/s].
    let speed = (dot(x).powi(2) + dot(height).powi(2)).sqrt();
    observe = [speed];
}]
#[derive(Clone)]
struct Bead {
    /// The mass \[kg\].
    mass: f64,
    /// The steepness of the wire, its height over x² [1/m].
    steepness: f64,
    /// The acceleration of gravity [m/s²].
    gravity: f64,
}

fn main() -> ExitCode {
    let bead = Bead {
        mass: 0.1,
        steepness: 0.5,
        gravity: 9.81,
    };
    cli::main(
        [Entry::new(bead)
            .start([1.0], [0.0])
            .step(0.01)
            .until(10.0)
            .drawn(|&[x]: &[f64; 1], parameters| {
                let wire = |x: f64| [x, parameters.get("steepness") * x * x];
                (-10..10)
                    .map(|k| 0.12 * f64::from(k))
                    .fold(Drawing::new(), |drawing, x| drawing.rod(wire(x), wire(x + 0.12)))
                    .point(wire(x))
            })],
    )
}
