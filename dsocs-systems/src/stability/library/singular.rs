//! Singular points, at which the equations do not determine the motion: they are refused, and `Regularity`
//! shows them.

use std::error::Error;

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::{
    AnyFlow, AnyStart, Flow, Kernel, Regularity, Run, RunError, SeriesFailure, Start, StepFailure, Stepper,
    Tolerance,
};

use super::roots::{self, Undivided};
use super::{Bar, Measured, Report, larger, read};
use crate::experiment::pendulum::{Q0, V0};
use crate::particle::CurvedParticle;
use crate::pendulum::InertiaWheelPendulum;

/// Constraint and virtual work both contain only the sum of the accelerations: rank 1 of 2, exactly.
const DEPENDENT: &str = "
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = ddot(x) + ddot(y) - 1;
    variational = [(1, 1)];
";

/// The rows of `DEPENDENT` with a nonlinear term: the rank is deficient only where `x = y`.
const DIAGONAL: &str = "
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = ddot(x) + ddot(y) + (ddot(x) - ddot(y)) * (x - y);
    variational = [(1, 1)];
";

/// A constraint on the last two nodes: `q0` does not enter, so no step leads back.
const WITHOUT_FIRST_NODE: &str = "
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + x.sin() * dot(x);
    discrete_kinematic = (x[2] - x[1]) / h - x[1].cos();
    constraint_forces = [(1,)];
";

/// A cart-pole with a constraint that becomes singular on the way: the coefficient of the motor's force
/// passes through zero.
const CART_POLE: &str = "
    parameters { mc = 1, mp = 0.3, l = 0.5, drag = 0.2, ke = 1.5, kv = 2, kx = 1, kd = 1.2 }
    coordinates(s, theta);
    let kinetic = (mc + mp) * dot(s).powi(2) / 2 + mp * l * dot(s) * dot(theta) * theta.cos() + mp * l.powi(2) * dot(theta).powi(2) / 2;
    let potential = mp * 9.81 * l * (theta.cos() - 1);
    lagrangian = kinetic - potential;
    external_forces = (-drag * dot(s), 0);
    let lyapunov = ke / 2 * (kinetic + potential).powi(2) + kv / 2 * dot(s).powi(2) + kx / 2 * s.powi(2);
    kinematic = dot(lyapunov) + kd * dot(s).powi(2);
    constraint_forces = [(1, 0)];
    branch = divide(dot(s));
";

/// A particle that climbs, comes to rest and falls, on a path whose curvature changes at a constant rate.
const CLIMBER: &str = "
    parameters { rate = 0.3 }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
    let curvature = (dot(x) * ddot(y) - dot(y) * ddot(x)) / (dot(x).powi(2) + dot(y).powi(2)).powf(1.5);
    kinematic = dot(curvature) - rate;
    constraint_forces = [(-dot(y), dot(x))];
";

/// A four-bar linkage.
const LINKAGE: &str = "
    parameters { bars: [4] = [1, 2, 1, 2] }
    coordinates(a, b, c);
    lagrangian = (dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2)) / 2 + 0.3 * dot(a) * dot(b) * (a - b).cos();
    holonomic = [
        bars[0] * a.cos() + bars[1] * b.cos() - bars[2] * c.cos() - bars[3],
        bars[0] * a.sin() + bars[1] * b.sin() - bars[2] * c.sin(),
    ];
";

/// The number of steps `h`, of 60 that are tried, with which a run does not stop for one of these reasons
/// before the time `until`.
fn steps_without_stop(text: &str, start: &AnyStart, until: f64, reasons: &[StepFailure]) -> Measured {
    let system = read(text)?;
    let mut passed = 0.0;
    for k in 1..=60 {
        let h = 1.0 / (20.0 * 1.1_f64.powi(k)).round();
        let ended = AnyFlow::new(&system, h, start)?.run_mut().to(until);
        let is_told = ended.is_err_and(|error| {
            error
                .step_failure()
                .is_some_and(|reason| reasons.contains(&reason))
        });
        passed += f64::from(u8::from(!is_told));
    }
    Ok(passed)
}

/// The number of tolerances, of five that are tried, with which the motion of the linkage does not end with
/// the error of dependent constraints at its change point.
fn unchanged() -> Measured {
    let linkage = read(LINKAGE)?;
    let start = AnyStart::second_order(&[1.0, 0.0, 1.0], &[-1.0, 0.0, -1.0]);
    let mut passed = 0.0;
    for tolerance in [1e-6, 1e-8, 1e-10, 1e-12, 1e-13] {
        let mut motion = AnyTaylorFlow::of_tape(&linkage, &start, Tolerance::relative(tolerance))?;
        let ended = (&mut motion as &mut dyn Run).to(2.0);
        let is_told = matches!(
            ended,
            Err(RunError::Series(error)) if matches!(error.details().cause, SeriesFailure::Dependent { .. })
        );
        passed += f64::from(u8::from(!is_told));
    }
    Ok(passed)
}

/// The smallest singular values along a run.
fn smallest_singular_values(
    system: &dyn Kernel,
    h: f64,
    start: &AnyStart,
    steps: u32,
) -> Result<[f64; 2], Box<dyn Error>> {
    let mut flow = AnyFlow::new(system, h, start)?;
    let run = flow.run_mut();
    let mut smallest = [f64::INFINITY; 2];
    for _ in 0..steps {
        run.advance()?;
        if let Some(at) = run.regularity() {
            for (smallest, value) in smallest.iter_mut().zip([at.forward, at.backward]) {
                *smallest = -larger(-*smallest, -value);
            }
        }
    }
    Ok(smallest)
}

/// 0 if a first step is refused for this reason, 1 if not.
fn refused(system: &dyn Kernel, start: &AnyStart, reason: StepFailure) -> Measured {
    let failure = AnyFlow::new(system, 0.1, start)?.run_mut().advance();
    Ok(match failure {
        Err(error) if error.step_failure() == Some(reason) => 0.0,
        _ => 1.0,
    })
}

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    let pendulum = InertiaWheelPendulum::default();
    let circle = AnyStart::second_order(&[0.0; 2], &[1.0; 2]);
    report.measure_all(
        [
            (
                "particle, 1000 steps: smallest singular value of D₃".to_owned(),
                Bar::AtLeast(1e-2),
            ),
            ("the same: of D₁".to_owned(), Bar::AtLeast(1e-2)),
        ],
        || smallest_singular_values(&CurvedParticle::default(), 0.1, &circle, 1000),
    );
    report.measure_all(
        [
            (
                "pendulum, 20000 steps: smallest singular value of D₃".to_owned(),
                Bar::AtLeast(1e-6),
            ),
            ("the same: of D₁".to_owned(), Bar::AtLeast(1e-9)),
        ],
        || smallest_singular_values(&pendulum, 0.1, &AnyStart::second_order(&Q0, &V0), 20_000),
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
            let dependent = read(DEPENDENT)?;
            let start = AnyStart::nodes(&[0.0; 2], &[0.1, 0.2]);
            let flow = AnyFlow::new(&dependent, 0.1, &start)?;
            let at = Regularity::of(&dependent, 0.1, flow.leg(), &[0.0; 2]);
            let granted = f64::from(u8::from(at.grants_forward() || at.grants_backward()));
            Ok(granted + refused(&dependent, &start, StepFailure::Singular)?)
        },
    );
    report.measure(
        "rank n−1 exactly, on a line: steps there not refused or granted, steps beside it refused or not granted",
        Bar::AtMost(0.0),
        || {
            let diagonal = read(DIAGONAL)?;
            let mut wrong = 0.0;
            for (start, regular) in [
                (AnyStart::nodes(&[0.0, 0.1], &[0.2, 0.2]), false),
                (AnyStart::nodes(&[0.0, 0.1], &[0.2, 0.3]), true),
            ] {
                let mut flow = AnyFlow::new(&diagonal, 0.1, &start)?;
                let at = Regularity::of(&diagonal, 0.1, flow.leg(), &[0.0; 2]);
                if at.grants_forward() != regular || flow.run_mut().advance().is_ok() != regular {
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
            let onward = read(WITHOUT_FIRST_NODE)?;
            let mut flow = Flow::of(&onward, 0.1, Start::nodes([0.0], [0.1]))?;
            flow.advance()?;
            let at = flow.regularity().unwrap_or(Regularity::UNKNOWN);
            Ok(f64::from(u8::from(at.grants_backward() || !at.grants_forward())))
        },
    );
    not_passed(report);
}

/// Singularities that no run may pass without an error.
fn not_passed(report: &mut Report<'_>) {
    report.measure(
        "a cart-pole whose law becomes singular, 60 steps: runs that go on behind it",
        Bar::AtMost(0.0),
        || {
            let reasons = [
                StepFailure::PassesSingularity,
                StepFailure::NoSolution,
                StepFailure::NotConverged,
            ];
            let start = AnyStart::second_order(&[0.2, 2.5], &[0.0, 0.3]);
            steps_without_stop(CART_POLE, &start, 4.0, &reasons)
        },
    );
    report.measure(
        "a row of third order through rest, 60 steps: runs that go on without a word",
        Bar::AtMost(0.0),
        || {
            let start = AnyStart::third_order(&[0.0; 2], &[0.6, 0.8], &[-1.36, 0.02]);
            // a leg that ends at rest to rounding has no next one
            let reasons = [StepFailure::PassesRest, StepFailure::NotConverged];
            steps_without_stop(CLIMBER, &start, 2.0, &reasons)
        },
    );
    report.measure(
        "a linkage at its change point, 5 tolerances: motions not told that the rank is lost",
        Bar::AtMost(0.0),
        unchanged,
    );
}
