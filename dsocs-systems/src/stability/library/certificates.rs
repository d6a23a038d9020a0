//! Certificates of regularity with multipliers: they do not depend on units, and are granted just where there
//! is a flow.

use std::error::Error;
use std::ops::ControlFlow;

use dsocs_core::{Flow, Kernel, Leg, Regularity, Start, Stepper as _};

use super::garbage::Random;
use super::{Bar, Measured, Report, larger, read, with};
use crate::Sleigh;

/// The largest exponent of two by which a unit changes.
const EXPONENT: f64 = 40.0;

/// The number of systems of units in which a certificate is computed.
const SYSTEMS: usize = 40;

/// The number of steps that are certified.
const STEPS: usize = 20;

/// Units of three coordinates, of two constraints and so of the inverse of their multipliers, of mass and of time.
#[derive(Clone, Copy, Debug)]
struct Units {
    sx: [f64; 3],
    sl: [f64; 2],
    sm: f64,
    st: f64,
}

impl Units {
    /// Units at random: powers of two, which do not round.
    fn new(random: &mut Random) -> Self {
        let mut unit = || (EXPONENT * (2.0 * random.unit() - 1.0)).round().exp2();
        Self {
            sx: [unit(), unit(), unit()],
            sl: [unit(), unit()],
            sm: unit(),
            st: unit(),
        }
    }
}

/// A sleigh that a motor turns: a constraint on velocities and one on accelerations.
const DRIVEN_SLEIGH: &str = "
    parameters { sx: [3] = [1; 3], sl: [2] = [1; 2], sm = 1, st = 1 }
    coordinates(x, y, theta);
    let angle = theta / sx[2];
    let ahead = st * dot(x) / sx[0];
    let aside = st * dot(y) / sx[1];
    let turn = st * dot(theta) / sx[2];
    let across = aside * angle.cos() - ahead * angle.sin();
    lagrangian = sm * ((ahead.powi(2) + aside.powi(2)) / 2 + across * turn / 2 + turn.powi(2) / 4);
    nonholonomic = sl[0] * across;
    kinematic = sl[1] * (st * dot(turn) + turn / 2 + (2 * angle).sin());
    constraint_forces = [(0, 0, 1 / sx[2])];
";

/// The nonholonomic particle with a discrete row that does not contain the first node: no flow leads back.
const WITHOUT_FIRST_NODE: &str = "
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2;
    nonholonomic = dot(z) - y * dot(x);
    kinematic = ddot(y) + x.sin() * dot(x);
    discrete_kinematic = (y[2] - y[1]) / h - x[1].cos();
    constraint_forces = [(0, 1, 0)];
";

/// A triple of nodes, by its first leg and its second difference, and its certificate.
type Certified = (Leg<f64, 3>, [f64; 3], Regularity);

/// The certificates of the first steps of a motion.
fn certified(system: &dyn Kernel, h: f64, start: Start<3>) -> Result<Vec<Certified>, Box<dyn Error>> {
    let mut flow = Flow::of(system, h, start)?;
    let mut all = Vec::with_capacity(STEPS);
    for _ in 0..STEPS {
        let leg = flow.leg();
        flow.advance()?;
        let mut e = flow.leg().d;
        for (e, d) in e.iter_mut().zip(leg.d) {
            *e -= d;
        }
        all.push((leg, e, Regularity::of(system, h, leg.any(), &e)));
    }
    Ok(all)
}

/// The largest relative change of the certificates with the units.
fn changes() -> Measured {
    let led = read(DRIVEN_SLEIGH)?;
    let start = Start::second_order([0.0, 0.0, 0.4], [1.0, 0.4_f64.tan(), 0.3]);
    let h = 0.05;
    let natural = certified(&led, h, start)?;
    let mut random = Random::new(14);
    let mut worst = 0.0;
    for _ in 0..SYSTEMS {
        let units = Units::new(&mut random);
        let scaled = |x: &[f64; 3]| [x[0] * units.sx[0], x[1] * units.sx[1], x[2] * units.sx[2]];
        let Units {
            sx: [x, y, z],
            sl: [one, other],
            sm,
            st,
        } = units;
        let system = with(&led, &[x, y, z, one, other, sm, st]);
        for (leg, e, at) in &natural {
            let leg = Leg {
                t: 0.0,
                q: scaled(&leg.q),
                d: scaled(&leg.d),
            };
            let now = Regularity::of(&system, h * units.st, leg.any(), &scaled(e));
            for (x, y) in [
                (at.forward, now.forward),
                (at.backward, now.backward),
                (at.largest_forward, now.largest_forward),
                (at.largest_backward, now.largest_backward),
            ] {
                worst = larger(worst, ((x - y) / x).abs());
            }
        }
    }
    Ok(worst)
}

/// The number of nodes of a sleigh's run at which a flow is not granted.
fn ungranted_nodes(v0: [f64; 3], until: f64) -> Measured {
    let sleigh = Sleigh::default();
    let mut flow = Flow::new(&sleigh, 0.05, Start::second_order([0.0; 3], v0))?;
    let mut lost = 0.0;
    flow.certify(until, &mut |_, regularity: Option<Regularity>| {
        lost += f64::from(u8::from(regularity.is_some_and(|at| !at.grants_flow())));
        ControlFlow::Continue(())
    })?;
    Ok(lost)
}

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    report.measure(
        format!("a constraint of velocities beside one of accelerations, {SYSTEMS} systems of units up to 2^±40: largest relative change"),
        Bar::AtMost(1e-9),
        changes,
    );
    report.measure(
        format!("z' = y x' beside a row without the first node, {STEPS} steps: backward flows granted"),
        Bar::AtMost(0.0),
        || {
            let all = certified(
                &read(WITHOUT_FIRST_NODE)?,
                0.02,
                Start::second_order([0.0; 3], [0.5, 1.0, 0.0]),
            )?;
            let granted = all
                .iter()
                .filter(|(_, _, at)| at.grants_backward() || !at.grants_forward());
            Ok(granted.count() as f64)
        },
    );
    report.measure(
        "sleigh, its own run: nodes at which a flow is not granted",
        Bar::AtMost(0.0),
        || ungranted_nodes([-1.0, 0.0, 0.3], 40.0),
    );
    report.measure(
        "sleigh that comes to turn no more: nodes at which a flow is not granted",
        Bar::AtMost(0.0),
        || ungranted_nodes([1.0, 0.0, 0.3], 200.0),
    );
}
