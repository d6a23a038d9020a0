//! Systems with two solutions in every step, which approach each other, meet and cross. The figures count
//! refusals, and the runs that change to the other solution without an error.
//!
//! Each is declared as the product of two constraints, and the step of either alone from the same leg is
//! known. The first step decides which of the two motions the run follows. Where a run is refused as
//! ambiguous it is given the next node of that motion.

use std::error::Error;

use dsocs_core::{Flow, Kernel, Leg, RunError, Start, StepFailure, Stepper, dsocs};

use super::garbage::Random;
use super::{Bar, Report, distance, read, with};
use crate::particle::{Curvature, CurvedParticle, Wavy};

/// The steps, in s.
const STEPS: [f64; 4] = [0.2, 0.1, 0.05, 0.0125];

/// The duration of a run, in s.
const UNTIL: f64 = 20.0;

/// Two roots this near to each other, relative to both legs, cannot be distinguished: where they meet, the
/// rounding of the rows moves either by the square root of itself.
const INDISTINCT_ROOTS: f64 = 1e-6;

/// The product of the equations of two oscillators with different springs. Their accelerations cross where
/// the forces agree.
const SPRINGS: &str = "
    parameters { k: [2] = [0; 2], s: [2] = [0; 2], w: [2] = [0; 2], f: [2] = [0; 2] }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (ddot(x) + k[0] * x + s[0] * (w[0] * x).sin() + f[0]) * (ddot(x) + k[1] * x + s[1] * (w[1] * x).sin() + f[1]);
    constraint_forces = [(1,)];
";

/// The values of their parameters.
struct Springs {
    k: [f64; 2],
    s: [f64; 2],
    w: [f64; 2],
    f: [f64; 2],
}

impl Springs {
    /// The acceleration of one of the two oscillators.
    fn acceleration(&self, which: usize, x: f64) -> f64 {
        -(self.k[which] * x + self.s[which] * (self.w[which] * x).sin() + self.f[which])
    }
}

/// The product of a uniform motion and an oscillator.
const EITHER: &str = "
    parameters { drift = 0, stiffness = 0 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (dot(x) - drift) * (ddot(x) + stiffness * x);
    constraint_forces = [(1,)];
";

/// A particle whose path has a prescribed squared curvature. Where the curvature passes through zero both
/// signs are solutions.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let square = dot(x).powi(2) + dot(y).powi(2);
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)).powi(2) / square.powi(3) - curvature.at(x, y).powi(2);
    constraint_forces = [(-dot(y), dot(x))];
}]
struct Unsigned {
    curvature: Wavy,
}

/// The two second differences that solve a step, that of the motion followed first.
type Pair<const N: usize> = [[f64; N]; 2];

/// Computes them for the step that begins with a leg.
type Solve<'a, const N: usize> = &'a dyn Fn(&Leg<f64, N>) -> Result<Pair<N>, Box<dyn Error>>;

/// The number of refusals of a run, and 1 if it changed to the wrong root without an error (which ends it).
fn run<const N: usize>(
    system: &dyn Kernel,
    h: f64,
    first: ([f64; N], [f64; N]),
    pair: Solve<'_, N>,
) -> Result<[f64; 2], Box<dyn Error>> {
    let mut flow = Flow::of(system, h, Start::nodes(first.0, first.1))?;
    let (mut refused, mut swapped, mut begun) = (0.0, false, false);
    while flow.time() < UNTIL {
        let leg = flow.leg();
        let [mut right, mut wrong] = pair(&leg)?;
        if swapped {
            core::mem::swap(&mut right, &mut wrong);
        }
        match flow.advance() {
            Ok(_) => {}
            Err(RunError::Step(error)) if error.details().cause.reason == StepFailure::AmbiguousRoot => {
                refused += 1.0;
                let mut next = leg.q;
                for ((next, d), e) in next.iter_mut().zip(leg.d).zip(right) {
                    *next += d + e;
                }
                flow.advance_to(&next)?;
                begun = true;
                continue;
            }
            Err(error) => return Err(error.into()),
        }
        let mut found = *flow.position();
        for ((found, q), d) in found.iter_mut().zip(leg.q).zip(leg.d) {
            *found = (*found - q) - d;
        }
        let length = distance(&leg.d, &[0.0; N]) + distance(&right, &[0.0; N]);
        if distance(&right, &wrong) > INDISTINCT_ROOTS * length
            && distance(&found, &wrong) < distance(&found, &right)
        {
            if begun {
                return Ok([refused, 1.0]);
            }
            swapped = true;
        }
        begun = true;
    }
    Ok([refused, 0.0])
}

/// A random system of the first family, `SPRINGS`.
fn springs(random: &mut Random, h: f64) -> Result<[f64; 2], Box<dyn Error>> {
    let mut number = |least: f64, most: f64| least + (most - least) * random.unit();
    let springs = Springs {
        k: [number(0.2, 4.0), number(0.2, 4.0)],
        s: [number(-1.0, 1.0), number(-1.0, 1.0)],
        w: [number(0.5, 3.0), number(0.5, 3.0)],
        f: [number(-0.5, 0.5), number(-0.5, 0.5)],
    };
    let (x, v) = (number(-2.0, 2.0), number(-2.0, 2.0));
    let second = x + h * v + h * h / 2.0 * springs.acceleration(0, x);
    let [k, s, w, f] = [springs.k, springs.s, springs.w, springs.f];
    let system = with(&read(SPRINGS)?, &[k, s, w, f].concat());
    run(&system, h, ([x], [second]), &|leg| {
        Ok([0, 1].map(|which| [h * h * springs.acceleration(which, leg.q[0])]))
    })
}

/// A random system of the second family, `EITHER`, on either of its motions.
fn either(random: &mut Random, h: f64) -> Result<[f64; 2], Box<dyn Error>> {
    let mut number = |least: f64, most: f64| least + (most - least) * random.unit();
    let (drift, stiffness) = (number(-1.0, 1.0), number(0.2, 4.0));
    let x = number(-2.0, 2.0);
    let oscillates = number(0.0, 1.0) < 0.75;
    let v = if oscillates { number(-2.0, 2.0) } else { drift };
    let a = if oscillates { -stiffness * x } else { 0.0 };
    let system = with(&read(EITHER)?, &[drift, stiffness]);
    run(&system, h, ([x], [x + h * v + h * h / 2.0 * a]), &|leg| {
        let swing = [-h * h * stiffness * leg.q[0]];
        let drift = [2.0 * (h * drift - leg.d[0])];
        Ok(if oscillates {
            [swing, drift]
        } else {
            [drift, swing]
        })
    })
}

/// A random system of the third family, with a squared curvature.
fn unsigned(random: &mut Random, h: f64) -> Result<[f64; 2], Box<dyn Error>> {
    let mut number = |least: f64, most: f64| least + (most - least) * random.unit();
    let curvature = Wavy {
        mean: number(-0.5, 0.5),
        amplitude: number(0.5, 1.5),
        wave_number: number(0.5, 2.0),
    };
    let (x, y, direction) = (number(-2.0, 2.0), number(-2.0, 2.0), number(0.0, 6.3));
    let (left, right) = (curvature, Opposite(curvature));
    let [d, e] = [[direction.cos(), direction.sin()].map(|v| h * v), [0.0; 2]];
    let first = ([x - d[0], y - d[1]], [x + e[0], y + e[1]]);
    run(&Unsigned { curvature }, h, first, &|leg| {
        Ok([turned(left, h, leg)?, turned(right, h, leg)?])
    })
}

/// A curvature with the opposite sign.
#[derive(Clone, Copy)]
struct Opposite(Wavy);

impl Curvature for Opposite {
    fn at<D: dsocs_core::Real>(&self, x: D, y: D) -> D {
        -self.0.at(x, y)
    }
}

/// The second difference of a step with a signed curvature.
fn turned<K: Curvature>(curvature: K, h: f64, leg: &Leg<f64, 2>) -> Result<[f64; 2], Box<dyn Error>> {
    let particle = CurvedParticle { mass: 1.0, curvature };
    let before = [leg.q[0] - leg.d[0], leg.q[1] - leg.d[1]];
    let mut flow = Flow::new(&particle, h, Start::nodes(before, leg.q))?;
    flow.advance()?;
    let next = flow.position();
    Ok([0, 1].map(|i| (next[i] - leg.q[i]) - leg.d[i]))
}

/// Measures `count` systems of each family with one step.
fn measure(seed: u64, count: u32, h: f64) -> Result<[f64; 2], Box<dyn Error>> {
    let mut random = Random::new(seed);
    let mut sum = [0.0; 2];
    for _ in 0..count {
        for family in [springs, either, unsigned] {
            let [refused, wrong] = family(&mut random, h)?;
            sum = [sum[0] + refused, sum[1] + wrong];
        }
    }
    Ok(sum)
}

/// Measures the figures of the case.
pub fn run_all(report: &mut Report<'_>) {
    let count = if report.quick { 5 } else { 67 };
    for (seed, h) in (1..).zip(STEPS) {
        let systems = format!("{} random systems with two roots to t = 20, h = {h}", 3 * count);
        report.measure_all(
            [
                (format!("{systems}: steps refused as ambiguous"), Bar::Reported),
                (
                    "the same: runs that go over to the wrong root in silence".to_owned(),
                    Bar::AtMost(0.0),
                ),
            ],
            || measure(seed, count, h),
        );
    }
}
