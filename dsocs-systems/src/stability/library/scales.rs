//! Invariance under scaling: speeds, lengths and curvature from 1e-90 to 1e90, and masses, give the same
//! motion up to its scale.

use std::error::Error;

use dsocs_core::{Flow, RunError, SetupError, Start, Stepper};

use super::{Bar, Report, larger};
use crate::particle::{CurvedParticle, Wavy};

/// The nodes of a run, with the last force.
type Motion = (Vec<[f64; 2]>, [f64; 2]);

/// Runs the particle with lengths in units of `length` and masses in units of `mass`; the result is in these
/// units.
fn motion(length: f64, mass: f64) -> Result<Motion, Box<dyn Error>> {
    let particle = CurvedParticle {
        mass,
        curvature: Wavy {
            mean: 1.0 / length,
            amplitude: 0.5 / length,
            wave_number: 1.0 / length,
        },
    };
    let mut flow = Flow::new(&particle, 0.1, Start::second_order([0.0; 2], [length, length]))?;
    let mut nodes = Vec::new();
    let mut force = [0.0; 2];
    for _ in 0..1000 {
        flow.advance()?;
        nodes.push(flow.position().map(|q| q / length));
        force = flow.node().force.map(|force| force / length / mass);
    }
    Ok((nodes, force))
}

/// The largest difference of two motions.
fn difference(one: &Motion, other: &Motion) -> f64 {
    let nodes = one.0.iter().zip(&other.0).chain([(&one.1, &other.1)]);
    nodes
        .flat_map(|(x, y)| x.iter().zip(y))
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, larger)
}

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    for (name, base, exponents, bar) in [
        (
            "lengths in units of 2^±100, masses in 2^±100: change of the motion, bit by bit",
            2.0,
            [-100, -60, -20, 20, 60, 100],
            0.0,
        ),
        (
            "lengths in units of 1e±90, masses in 1e±90: change of the motion (1000 steps)",
            10.0,
            [-90, -60, -30, 30, 60, 90],
            1e-12,
        ),
    ] {
        report.measure(name, Bar::AtMost(bar), || {
            let unit = motion(1.0, 1.0)?;
            let mut worst = 0.0;
            for exponent in exponents {
                let scale = f64::powi(base, exponent);
                for (length, mass) in [(scale, 1.0), (1.0, scale), (scale, scale.recip())] {
                    worst = larger(worst, difference(&unit, &motion(length, mass)?));
                }
            }
            Ok(worst)
        });
    }
    report.measure(
        "where |v|³ leaves the range of doubles (1e±110, 1e±150, 1e±300): runs without a typed error",
        Bar::AtMost(0.0),
        || {
            let mut silent = 0.0;
            for exponent in [-300, -150, -110, 110, 150, 300] {
                match motion(10.0_f64.powi(exponent), 1.0) {
                    Err(error) if error.is::<SetupError>() || error.is::<RunError>() => {}
                    _ => silent += 1.0,
                }
            }
            Ok(silent)
        },
    );
}
