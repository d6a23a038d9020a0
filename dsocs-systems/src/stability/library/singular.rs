//! Points where the equations do not determine the motion: they are refused, and told by `Regularity`.

use std::error::Error;

use dsocs_core::{Flow, Regularity, Start, StepFailure, Stepper, System, dsocs};

use super::roots::{self, Undivided};
use super::{Bar, Measured, Report, larger};
use crate::experiment::pendulum::{Q0, V0};
use crate::particle::CurvedParticle;
use crate::pendulum::InertiaWheelPendulum;

/// Constraint and work both bind the sum of the accelerations: rank 1 of 2, exactly.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = ddot(x) + ddot(y) - 1;
    variational = [(1, 1)];
}]
struct Dependent;

/// The same with rows that are not linear, whose rank falls where `x = y` alone.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = ddot(x) + ddot(y) + (ddot(x) - ddot(y)) * (x - y);
    variational = [(1, 1)];
}]
struct Diagonal;

/// A constraint on the last two nodes: `q0` does not enter, no step leads back.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + x.sin() * dot(x);
    discrete_kinematic = (x[2] - x[1]) / h - x[1].cos();
    constraint_forces = [(1,)];
}]
struct Onward;

/// The smallest singular values along a run.
fn along<S: System<2>>(system: &S, h: f64, start: Start<2>, steps: u32) -> Result<[f64; 2], Box<dyn Error>> {
    let mut flow = Flow::new(system, h, start)?;
    let mut smallest = [f64::INFINITY; 2];
    for _ in 0..steps {
        flow.advance()?;
        if let Some(at) = flow.regularity() {
            for (smallest, value) in smallest.iter_mut().zip([at.forward, at.backward]) {
                *smallest = -larger(-*smallest, -value);
            }
        }
    }
    Ok(smallest)
}

/// Whether a first step is refused for a reason, 1 if not.
fn refused<S: System<N>, const N: usize>(system: &S, start: Start<N>, reason: StepFailure) -> Measured {
    let failure = Flow::new(system, 0.1, start)?.advance();
    Ok(match failure {
        Err(error) if error.step_failure() == Some(reason) => 0.0,
        _ => 1.0,
    })
}

/// The figures.
pub fn run(report: &mut Report<'_>) {
    let pendulum = InertiaWheelPendulum::default();
    let circle = Start::second_order([0.0; 2], [1.0; 2]);
    report.measure_all(
        [
            (
                "particle, 1000 steps: smallest singular value of D₃".to_owned(),
                Bar::AtLeast(1e-2),
            ),
            ("the same: of D₁".to_owned(), Bar::AtLeast(1e-2)),
        ],
        || along(&CurvedParticle::default(), 0.1, circle, 1000),
    );
    report.measure_all(
        [
            (
                "pendulum, 20000 steps: smallest singular value of D₃".to_owned(),
                Bar::AtLeast(1e-6),
            ),
            ("the same: of D₁".to_owned(), Bar::AtLeast(1e-9)),
        ],
        || along(&pendulum, 0.1, Start::second_order(Q0, V0), 20_000),
    );
    report.measure(
        "pendulum without `branch` at the hardest step: D₃'s smallest singular value, in that with `branch`",
        Bar::AtMost(1e-6),
        || {
            let [q0, q1] = roots::hardest()?;
            let mut flow = Flow::new(&pendulum, 0.1, Start::nodes(q0, q1))?;
            let leg = flow.leg();
            flow.advance()?;
            let divided = flow.regularity().unwrap_or(Regularity::UNKNOWN);
            let e: [f64; 2] = std::array::from_fn(|i| flow.leg().d[i] - leg.d[i]);
            let undivided = Regularity::of(&Undivided::of(&pendulum), 0.1, leg.any(), &e);
            Ok(undivided.forward / divided.forward)
        },
    );
    report.measure(
        "particle at rest: not refused with a typed error",
        Bar::AtMost(0.0),
        || {
            let rest = Start::nodes([0.0; 2], [0.0; 2]);
            let particle = CurvedParticle::default();
            let mut flow = Flow::new(&particle, 0.1, rest)?;
            let at = Regularity::of(&particle, 0.1, flow.leg().any(), &[0.0; 2]);
            Ok(f64::from(u8::from(flow.advance().is_ok() || at.grants_flow())))
        },
    );
    report.measure(
        "rank n−1 exactly, everywhere: steps not refused as singular, or granted a flow",
        Bar::AtMost(0.0),
        || {
            let start = Start::nodes([0.0; 2], [0.1, 0.2]);
            let leg = Flow::new(&Dependent, 0.1, start)?.leg();
            let at = Regularity::of(&Dependent, 0.1, leg.any(), &[0.0; 2]);
            let granted = f64::from(u8::from(at.grants_forward() || at.grants_backward()));
            Ok(granted + refused(&Dependent, start, StepFailure::Singular)?)
        },
    );
    report.measure(
        "rank n−1 exactly, on a line: steps there not refused or granted, steps beside it refused or not granted",
        Bar::AtMost(0.0),
        || {
            let mut wrong = 0.0;
            for (start, regular) in [
                (Start::nodes([0.0, 0.1], [0.2, 0.2]), false),
                (Start::nodes([0.0, 0.1], [0.2, 0.3]), true),
            ] {
                let mut flow = Flow::new(&Diagonal, 0.1, start)?;
                let leg = flow.leg();
                let at = Regularity::of(&Diagonal, 0.1, leg.any(), &[0.0; 2]);
                if at.grants_forward() != regular || flow.advance().is_ok() != regular {
                    wrong += 1.0;
                }
            }
            Ok(wrong)
        },
    );
    report.measure(
        "a constraint on q1 and q2 alone: a backward flow granted, or a forward flow not",
        Bar::AtMost(0.0),
        || {
            let mut flow = Flow::new(&Onward, 0.1, Start::nodes([0.0], [0.1]))?;
            flow.advance()?;
            let at = flow.regularity().unwrap_or(Regularity::UNKNOWN);
            Ok(f64::from(u8::from(at.grants_backward() || !at.grants_forward())))
        },
    );
}
