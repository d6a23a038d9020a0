//! Points where the equations do not determine the motion: they are refused, and told by `Regularity`.

use std::error::Error;

use dsocs_core::{
    Flow, Regularity, RunError, SeriesFailure, Start, StepFailure, Stepper, System, TaylorFlow, Tolerance,
    dsocs,
};

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

/// A pole on a cart, whose law is singular on its way: the coefficient of the motor's force passes through zero.
#[dsocs {
    coordinates(s, theta);
    let kinetic = (mc + mp) * dot(s).powi(2) / 2 + mp * l * dot(s) * dot(theta) * theta.cos() + mp * l.powi(2) * dot(theta).powi(2) / 2;
    let potential = mp * 9.81 * l * (theta.cos() - 1);
    lagrangian = kinetic - potential;
    external_forces = (-drag * dot(s), 0);
    let lyapunov = ke / 2 * (kinetic + potential).powi(2) + kv / 2 * dot(s).powi(2) + kx / 2 * s.powi(2);
    kinematic = dot(lyapunov) + kd * dot(s).powi(2);
    constraint_forces = [(1, 0)];
    branch = divide(dot(s));
}]
struct Poled {
    mc: f64,
    mp: f64,
    l: f64,
    drag: f64,
    ke: f64,
    kv: f64,
    kx: f64,
    kd: f64,
}

/// A particle that climbs, comes to rest and falls, on a path whose curvature changes at a constant rate.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
    let curvature = (dot(x) * ddot(y) - dot(y) * ddot(x)) / (dot(x).powi(2) + dot(y).powi(2)).powf(1.5);
    kinematic = dot(curvature) - rate;
    constraint_forces = [(-dot(y), dot(x))];
}]
struct Climber {
    rate: f64,
}

/// A four-bar linkage.
#[dsocs {
    coordinates(a, b, c);
    lagrangian = (dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2)) / 2 + 0.3 * dot(a) * dot(b) * (a - b).cos();
    holonomic = [
        bars[0] * a.cos() + bars[1] * b.cos() - bars[2] * c.cos() - bars[3],
        bars[0] * a.sin() + bars[1] * b.sin() - bars[2] * c.sin(),
    ];
}]
struct Linkage {
    bars: [f64; 4],
}

/// How many of some steps lead a run past a place where it ought to end, or ask, for this reason.
fn passed<S: System<N>, const N: usize>(
    system: &S,
    start: Start<N>,
    until: f64,
    reasons: &[StepFailure],
) -> Measured {
    let mut passed = 0.0;
    for k in 1..=60 {
        let h = 1.0 / (20.0 * 1.1_f64.powi(k)).round();
        let ended = Flow::new(system, h, start)?.to(until);
        let is_told = ended.is_err_and(|error| {
            error
                .step_failure()
                .is_some_and(|reason| reasons.contains(&reason))
        });
        passed += f64::from(u8::from(!is_told));
    }
    Ok(passed)
}

/// How many tolerances lead a motion past a change point, or to another word for it.
fn unchanged() -> Measured {
    let linkage = Linkage {
        bars: [1.0, 2.0, 1.0, 2.0],
    };
    let start = Start::second_order([1.0, 0.0, 1.0], [-1.0, 0.0, -1.0]);
    let mut passed = 0.0;
    for tolerance in [1e-6, 1e-8, 1e-10, 1e-12, 1e-13] {
        let ended = TaylorFlow::new(&linkage, start, Tolerance::relative(tolerance))?.to(2.0);
        let is_told = matches!(
            ended,
            Err(RunError::Series(error)) if matches!(error.details().cause, SeriesFailure::Dependent { .. })
        );
        passed += f64::from(u8::from(!is_told));
    }
    Ok(passed)
}

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
    not_passed(report);
}

/// Places that no run is to pass without a word.
fn not_passed(report: &mut Report<'_>) {
    report.measure(
        "a cart-pole whose law becomes singular, 60 steps: runs that go on behind it",
        Bar::AtMost(0.0),
        || {
            let pole = Poled {
                mc: 1.0,
                mp: 0.3,
                l: 0.5,
                drag: 0.2,
                ke: 1.5,
                kv: 2.0,
                kx: 1.0,
                kd: 1.2,
            };
            let reasons = [
                StepFailure::PassesSingularity,
                StepFailure::NoSolution,
                StepFailure::NotConverged,
            ];
            passed(&pole, Start::second_order([0.2, 2.5], [0.0, 0.3]), 4.0, &reasons)
        },
    );
    report.measure(
        "a row of third order through rest, 60 steps: runs that go on without a word",
        Bar::AtMost(0.0),
        || {
            let start = Start::third_order([0.0; 2], [0.6, 0.8], [-1.36, 0.02]);
            // a leg that ends at rest to rounding has no next one at all
            let reasons = [StepFailure::PassesRest, StepFailure::NotConverged];
            passed(&Climber { rate: 0.3 }, start, 2.0, &reasons)
        },
    );
    report.measure(
        "a linkage at its change point, 5 tolerances: motions not told that the rank is lost",
        Bar::AtMost(0.0),
        unchanged,
    );
}
