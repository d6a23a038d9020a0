//! Chapter *The paper in code*: the order of the scheme with both starts, on the particle of section 5.1.
//!
//! `cargo run --release --example the_paper`

use dsocs_core::prelude::*;
use dsocs_systems::CurvedParticle;
use dsocs_systems::experiment::particle;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let system = CurvedParticle::default();
    let (q0, v0, end) = ([0.0, 0.0], [1.0, 1.0], 20.0);
    println!("largest error of x up to t = {end}, and the slope from the step before");
    println!("{:>8} {:>24} {:>24}", "h", "q1 = q0 + h v0", "… + h²/2 a0");
    let mut before: Option<[f64; 2]> = None;
    for k in 0..7 {
        let h = 0.1 / f64::from(1 << k);
        let mut errors = [0.0_f64; 2];
        for (error, start) in errors
            .iter_mut()
            .zip([Start::paper(q0, v0), Start::second_order(q0, v0)])
        {
            for node in &Flow::new(&system, h, start)?.until(end)? {
                *error = error.max((node.q[0] - particle::exact(&system, node.t)[0]).abs());
            }
        }
        let slope = |place: usize| {
            before.map_or_else(String::new, |before| {
                format!("{:.2}", (before[place] / errors[place]).log2())
            })
        };
        println!(
            "{h:>8} {:>18.3e} {:>5} {:>18.3e} {:>5}",
            errors[0],
            slope(0),
            errors[1],
            slope(1)
        );
        before = Some(errors);
    }
    Ok(())
}
