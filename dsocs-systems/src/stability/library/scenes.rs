//! Random scenes, written out as declarations, against a second formulation of the same step.
//!
//! The second formulation and the generator are those of the tests (`dsocs_tests::scenes`, which draw
//! hundreds of scenes anew). Some of its scenes are declared here, with the last node of the second
//! formulation.

use std::error::Error;

use dsocs_core::__private::{Linearization, Unknown};
use dsocs_core::{At, Declaration, Flow, Kernel, Leg, Start, Stepper as _};

use super::garbage::Random;
use super::{Bar, Report, larger, read};

#[rustfmt::skip]
mod declared;

use declared::{RUN0, RUN1, RUN2, RUN3, RUN4, RUN5, RUN6};

/// The number of steps.
const STEPS: usize = 100;

/// A node this many roundings away belongs to another motion.
const ANOTHER_MOTION: f64 = 1e8;

/// The unit roundoff.
const UNIT: f64 = f64::EPSILON / 2.0;

/// The size of the perturbations that measure the condition of a motion, in roundings.
const PERTURBATION: f64 = 1e5;

/// The number of perturbed motions.
const PERTURBED_MOTIONS: u64 = 3;

/// The largest distance that is explained, relative to the random perturbations: these are random, and only
/// three.
const EXPLAINED_DISTANCE: f64 = 4.0;

/// The number of Newton updates of a perturbed step.
const UPDATES: u32 = 4;

/// A run of a scene with `M` unknowns in each step, and its exact last node.
pub struct Run<const N: usize, const M: usize> {
    /// The name of the scene.
    name: &'static str,
    /// Its declaration.
    text: &'static str,
    /// The step, in s.
    h: f64,
    /// The first node.
    q0: [f64; N],
    /// The second node.
    q1: [f64; N],
    /// The last node of the exact discrete motion.
    last: [f64; N],
    /// The largest change of the last node under perturbations of a unit roundoff, in the second formulation.
    units: [f64; N],
}

/// A perturbed motion: each step has a random error of the size of its rounding, times [`PERTURBATION`].
struct PerturbedMotion<const N: usize> {
    /// Its last leg.
    leg: Leg<f64, N>,
    /// The generator of its errors.
    random: Random,
}

impl<const N: usize> PerturbedMotion<N> {
    /// Makes a step with the second difference near `e`; `None` if it has no solution.
    fn advance<const M: usize>(&mut self, system: &dyn Kernel, h: f64, e: &[f64; N]) -> Option<()> {
        let shape = system.shape();
        let (mut constants, mut known) = (vec![f64::NAN; shape.constants], vec![f64::NAN; shape.known]);
        system.constants(&[], h, &mut constants);
        system.known(&constants, self.leg.any(), &mut known);
        let (constants, known) = (&constants[..], &known[..]);
        let linearize = |z: &[f64; M]| {
            let (mut rows, mut jacobian) = ([f64::NAN; M], [[f64::NAN; M]; M]);
            let at = At { constants, known, z };
            system.linearize(at, &mut rows, jacobian.as_flattened_mut());
            Linearization { rows, jacobian }
        };
        let mut z = [f64::NAN; M];
        system.unknown(e, &[], &mut z);
        for _ in 0..UPDATES {
            let update = linearize(&z).update()?;
            z = z.zip(&update, |z, update| z + update);
        }
        // the rows are perturbed by the bounds of their rounding, the unknowns by their last place
        let mut bounds = z;
        Declaration::of(system).bounds(h, self.leg.any(), &z, &mut bounds);
        let mut noise = || PERTURBATION * (2.0 * self.random.unit() - 1.0);
        let mut moved = z;
        for z in &mut moved {
            *z += noise() * UNIT * z.abs();
        }
        for row in &mut bounds {
            *row *= noise();
        }
        if let Some(update) = Unknown::solve(&linearize(&z).jacobian, &bounds) {
            moved = moved.zip(&update, |z, update| z + update);
        }
        let mut e = [f64::NAN; N];
        let at = At {
            constants,
            known,
            z: &moved,
        };
        system.second_difference(at, &mut e);
        for ((q, d), e) in self.leg.q.iter_mut().zip(&mut self.leg.d).zip(e) {
            *d += e;
            *q += *d;
        }
        self.leg.t += h;
        Some(())
    }
}

/// The distance of the last node from the exact one: in units of its change by rounding in the second
/// formulation; and in units of its change by rounding here, if that is larger: by the bounds of the rows,
/// carried along the motion by the perturbed motions.
fn distance<const N: usize, const M: usize>(run: &Run<N, M>) -> Result<[f64; 2], Box<dyn Error>> {
    let system = &read(run.text)?;
    let mut flow = Flow::of(system, run.h, Start::nodes(run.q0, run.q1))?;
    let mut twins: Vec<PerturbedMotion<N>> = (1..=PERTURBED_MOTIONS)
        .map(|seed| PerturbedMotion {
            leg: flow.leg(),
            random: Random::new(seed),
        })
        .collect();
    for _ in 0..STEPS {
        let before = flow.leg().d;
        flow.advance()?;
        let mut e = flow.leg().d;
        for (e, before) in e.iter_mut().zip(before) {
            *e -= before;
        }
        for twin in &mut twins {
            twin.advance::<M>(system, run.h, &e)
                .ok_or("a step beside the motion has no solution")?;
        }
    }
    let mut figures = [0.0; 2];
    for (i, (q, last)) in flow.position().iter().zip(&run.last).enumerate() {
        let apart = (q - last).abs();
        let moved = twins.iter().map(|twin| (twin.leg.q[i] - q).abs() / PERTURBATION);
        let condition = moved.fold(run.units[i], larger);
        figures[0] = larger(figures[0], apart / run.units[i]);
        figures[1] = larger(figures[1], apart / condition);
    }
    Ok(figures)
}

/// The name of a scene, and a function for its distance.
type Named = (&'static str, fn() -> Result<[f64; 2], Box<dyn Error>>);

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    let runs: [Named; 7] = [
        (RUN0.name, || distance(&RUN0)),
        (RUN1.name, || distance(&RUN1)),
        (RUN2.name, || distance(&RUN2)),
        (RUN3.name, || distance(&RUN3)),
        (RUN4.name, || distance(&RUN4)),
        (RUN5.name, || distance(&RUN5)),
        (RUN6.name, || distance(&RUN6)),
    ];
    report.measure(
        format!("{} scenes drawn at random, {STEPS} steps: refused, or on another motion than a second formulation", runs.len()),
        Bar::AtMost(0.0),
        || {
            let wrong = runs.iter().filter(|(_, run)| !run().is_ok_and(|[distance, _]| distance <= ANOTHER_MOTION));
            Ok(wrong.count() as f64)
        },
    );
    // The second formulation does not know the form of a row: squares of sums with cancelling terms round
    // more than it expects, and a coordinate that a row ties to a faster one has the digits of the faster
    // one. The bounds of the rows take this into account.
    for (name, run) in runs {
        report.measure_all(
            [
                (
                    format!("{name}: distance from the second formulation [its roundings]"),
                    Bar::Reported,
                ),
                (
                    "the same, or what the rows' own rounding bounds come to along the motion if that is more".to_owned(),
                    Bar::AtMost(EXPLAINED_DISTANCE),
                ),
            ],
            run,
        );
    }
}
