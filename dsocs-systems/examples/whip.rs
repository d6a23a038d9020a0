//! Chapter *Performance*, "Chains": a chain of rods in Cartesian coordinates hangs folded from both ends, and
//! one end is released.
//!
//! Its tip falls faster than a stone. In the limit of short links and no width of the fold, a tip that has fallen by `x` has the
//! speed `√(g x (2L − x)/(L − x))`, which is unbounded as `x` tends to `L`: the energy of the whole chain goes into the part that
//! still moves (Calkin and March, "The dynamics of a falling chain", Am. J. Phys. 57 (1989), 154).
//!
//! `cargo run --release --example whip`

use dsocs_core::prelude::*;

/// The number of rods: as many down as up, and one across.
const RODS: usize = 17;

/// Points on massless rods, the first of which hangs from the origin.
#[dsocs {
    coordinates(
        /// The points, from the first on [m].
        x: [17],
        /// Upward [m].
        y: [17],
    );
    lagrangian = sum(0..17, |i| mass * ((dot(x[i]).powi(2) + dot(y[i]).powi(2)) / 2 - gravity * y[i]));
    let rod = |i| (x[i] - x[i - 1]).powi(2) + (y[i] - y[i - 1]).powi(2) - length.powi(2);
    holonomic = [x[0].powi(2) + y[0].powi(2) - length.powi(2), each(1..17, |i| rod(i))];
}]
struct Chain {
    /// The mass of each point \[kg\].
    mass: f64,
    /// The length of each rod \[m\].
    length: f64,
    /// The acceleration of gravity [m/s²].
    gravity: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let parts = RODS as f64;
    let chain = Chain {
        mass: 1.0 / parts,
        length: 1.0 / parts,
        gravity: 9.81,
    };
    // down, across, and up again to the height of the origin
    let mut folded = [0.0; 2 * RODS];
    for i in 0..RODS {
        let down = (i + 1).min(RODS - 1 - i);
        if i >= RODS / 2 {
            folded[i] = chain.length;
        }
        folded[RODS + i] = -chain.length * down as f64;
    }
    let mut flow = Flow::new(&chain, 1e-4, Start::second_order(folded, [0.0; 2 * RODS]))?;
    println!("fallen [m]   tip [m/s]   without width   a stone");
    let (mut line, mut fastest, mut first) = (1, 0.0_f64, None);
    while flow.time() < 0.5 {
        flow.advance()?;
        let node = flow.node();
        let fallen = -node.q[2 * RODS - 1];
        let speed = node.v[RODS - 1].hypot(node.v[2 * RODS - 1]);
        fastest = fastest.max(speed);
        let energy = node.energy;
        let drift = (energy - *first.get_or_insert(energy)).abs();
        if line < 10 && fallen > 0.1 * f64::from(line) {
            let limit = (chain.gravity * fallen * (2.0 - fallen) / (1.0 - fallen)).sqrt();
            let stone = (2.0 * chain.gravity * fallen).sqrt();
            println!("{fallen:>10.2} {speed:>11.3} {limit:>15.3} {stone:>9.3}    energy to {drift:.0e} J");
            line += 1;
        }
    }
    println!("fastest {fastest:.2} m/s");
    Ok(())
}
