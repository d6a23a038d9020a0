//! The pendulum near a double root, with the factor divided out and without.

use std::error::Error;

use dsocs_core::{Flow, RunError, Start, StepFailure, Stepper, dsocs};

use super::{Bar, Measured, Report, larger};
use crate::experiment::pendulum::{Q0, V0};
use crate::pendulum::InertiaWheelPendulum;

/// The 80 steps of the reference motion with the nearest roots, in 200-bit arithmetic.
const REFERENCE: &str = include_str!("../../../data/pendulum_hard_steps_h0.1.csv");

/// The step of the reference, in s.
const H: f64 = 0.1;

/// The pendulum of [`InertiaWheelPendulum`] without `branch = divide(w)`.
#[dsocs {
    use crate::pendulum::inertia_wheel_pendulum;
    kinematic = dot(lyapunov) + rho * w * w.tanh();
    constraint_forces = [(0, 1)];
}]
#[derive(Clone)]
pub struct Undivided {
    i: f64,
    j: f64,
    m: f64,
    d: f64,
    e: f64,
    chi: f64,
    n: f64,
    rho: f64,
}

impl Undivided {
    /// The pendulum with the parameters of the divided one.
    pub fn of(pendulum: &InertiaWheelPendulum) -> Self {
        let InertiaWheelPendulum {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            rho,
        } = *pendulum;
        Self {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            rho,
        }
    }
}

/// A step of the reference: its first two nodes, and both solutions.
struct ReferenceStep {
    q0: [f64; 2],
    q1: [f64; 2],
    proper: [f64; 2],
    spurious: [f64; 2],
}

/// The steps of the reference.
fn reference_steps() -> Result<Vec<ReferenceStep>, Box<dyn Error>> {
    let mut steps = Vec::new();
    for line in REFERENCE.lines().skip(1) {
        let numbers: Vec<f64> = line
            .split(',')
            .take(12)
            .map(str::parse)
            .collect::<Result<_, _>>()?;
        let [_, _, t0, p0, t1, p1, _, t2, p2, ts, ps, _] = numbers[..] else {
            return Err(format!("twelve numbers expected in {line}").into());
        };
        steps.push(ReferenceStep {
            q0: [t0, p0],
            q1: [t1, p1],
            proper: [t2, p2],
            spurious: [ts, ps],
        });
    }
    Ok(steps)
}

/// The first two nodes of the hardest step.
pub fn hardest() -> Result<[[f64; 2]; 2], Box<dyn Error>> {
    let step = reference_steps()?.into_iter().next().ok_or("no steps")?;
    Ok([step.q0, step.q1])
}

/// Updates the largest deviations.
fn deviate(worst: &mut [f64; 2], found: &[f64], wanted: [f64; 2]) {
    for (worst, (found, wanted)) in worst.iter_mut().zip(found.iter().zip(wanted)) {
        *worst = larger(*worst, (found - wanted).abs());
    }
}

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    let pendulum = InertiaWheelPendulum::default();
    let undivided = Undivided::of(&pendulum);
    report.measure_all(
        [
            (
                "80 hardest steps one by one, factor divided out: θ [rad]".to_owned(),
                Bar::AtMost(1e-13),
            ),
            ("the same: ψ [rad]".to_owned(), Bar::AtMost(2e-11)),
        ],
        || {
            let mut worst = [0.0; 2];
            for step in reference_steps()? {
                let mut flow = Flow::new(&pendulum, H, Start::nodes(step.q0, step.q1))?;
                flow.advance()?;
                deviate(&mut worst, flow.position(), step.proper);
            }
            Ok(worst)
        },
    );
    // The reference's README finds 1e-11 and 2e-9 fair for a converged solution of the undivided row. The row as it is
    // generated rounds a little more: at the hardest step its bound moves the root by more than the roots are apart (9e-11).
    report.measure_all(
        [
            (
                "the same steps without `branch`: steps that are refused as ambiguous, of 80".to_owned(),
                Bar::Reported,
            ),
            (
                "the same: steps that go to the wrong root in silence".to_owned(),
                Bar::AtMost(0.0),
            ),
            (
                "the same: proper root, found or offered, θ [rad]".to_owned(),
                Bar::AtMost(4e-11),
            ),
            ("the same: ψ [rad]".to_owned(), Bar::AtMost(6e-9)),
            (
                "the same: steps whose other root is not found on request".to_owned(),
                Bar::AtMost(0.0),
            ),
        ],
        || single_steps(&undivided),
    );
    for h in [0.2, 0.1, 0.05, 0.0125] {
        let run =
            format!("pendulum without `branch` to t = 2000, h = {h}, told the larger |w| where ambiguous");
        report.measure_all(
            [
                (format!("{run}: steps refused"), Bar::Reported),
                (
                    "the same: wrong roots taken in silence".to_owned(),
                    Bar::AtMost(0.0),
                ),
            ],
            || whole_run(&undivided, &pendulum, h),
        );
    }
    report.measure(
        "w through 0 in steps of 1e-9 at the hardest step, factor divided out: largest kink of θ [rad]",
        Bar::AtMost(1e-14),
        || through_zero(&pendulum),
    );
}

/// The largest second difference of `θ₂` as `ψ₀` varies so that `w` passes through zero, and is exactly zero
/// once.
fn through_zero(pendulum: &InertiaWheelPendulum) -> Measured {
    let [q0, q1] = hardest()?;
    let step = |shift: f64| -> Result<(f64, f64), Box<dyn Error>> {
        let mut flow = Flow::new(pendulum, H, Start::nodes([q0[0], q0[1] + shift], q1))?;
        flow.advance()?;
        let node = flow.node();
        let w = pendulum.factor(node.q, node.v);
        Ok((flow.position()[0], w))
    };
    // w is nearly linear in the shift
    let (_, w) = step(0.0)?;
    let slope = (step(1e-6)?.1 - w) / 1e-6;
    let zero = -w / slope;
    let mut worst = 0.0;
    let mut last: Option<[f64; 2]> = None;
    for k in -200..=200 {
        let (theta, _) = step(zero + f64::from(k) * 1e-9 / slope)?;
        last = Some(match last {
            Some([before, now]) if before.is_finite() => {
                worst = larger(worst, ((theta - now) - (now - before)).abs());
                [now, theta]
            }
            Some([_, now]) => [now, theta],
            None => [f64::NAN, theta],
        });
    }
    Ok(worst)
}

/// The hard steps without division: those refused, those on the wrong root, and the errors.
fn single_steps(undivided: &Undivided) -> Result<[f64; 5], Box<dyn Error>> {
    let (mut refused, mut wrong, mut worst, mut missing) = (0.0, 0.0, [0.0; 2], 0.0);
    let far = |x: &[f64], y: [f64; 2]| (x[0] - y[0]).abs();
    for step in reference_steps()? {
        let mut flow = Flow::new(undivided, H, Start::nodes(step.q0, step.q1))?;
        let roots = flow.roots()?;
        match flow.advance() {
            Ok(_) => {
                let q = flow.position();
                if far(q, step.spurious) < far(q, step.proper) {
                    wrong += 1.0;
                } else {
                    deviate(&mut worst, q, step.proper);
                }
            }
            Err(RunError::Step(error)) if error.details().cause.reason == StepFailure::AmbiguousRoot => {
                refused += 1.0;
                let details = error.details();
                let nearer = if far(&details.q2, step.proper) < far(&details.other, step.proper) {
                    &details.q2
                } else {
                    &details.other
                };
                deviate(&mut worst, nearer, step.proper);
            }
            Err(error) => return Err(error.into()),
        }
        match roots.other {
            Some(other) => {
                let pair = [roots.found, other];
                let near = |wanted: [f64; 2]| {
                    pair.iter()
                        .any(|q| far(q, wanted) < 0.1 * (step.proper[0] - step.spurious[0]).abs())
                };
                if !(near(step.proper) && near(step.spurious)) {
                    missing += 1.0;
                }
            }
            None => missing += 1.0,
        }
    }
    Ok([refused, wrong, worst[0], worst[1], missing])
}

/// The number of steps that are refused, and of those that change to the wrong root without an error, in a
/// run that is given the proper root where it is refused.
fn whole_run(
    undivided: &Undivided,
    pendulum: &InertiaWheelPendulum,
    h: f64,
) -> Result<[f64; 2], Box<dyn Error>> {
    let mut flow = Flow::new(undivided, h, Start::second_order(Q0, V0))?;
    let (mut refused, mut wrong) = (0.0, 0.0);
    while flow.time() < 2000.0 {
        let leg = flow.leg();
        let w = |q2: &[f64]| {
            let v = [0, 1].map(|i| (q2[i] - leg.q[i] + leg.d[i]) / (2.0 * h));
            pendulum.factor(leg.q, v)
        };
        match flow.advance() {
            Ok(_) => {}
            Err(RunError::Step(error)) if error.details().cause.reason == StepFailure::AmbiguousRoot => {
                refused += 1.0;
                let details = error.details();
                let proper = if w(&details.q2).abs() > w(&details.other).abs() {
                    &details.q2
                } else {
                    &details.other
                };
                flow.advance_to(&[proper[0], proper[1]])?;
                continue;
            }
            Err(error) => return Err(error.into()),
        }
        // the next node of the divided pendulum from the same leg
        let mut proper = Flow::new(
            pendulum,
            h,
            Start::nodes([leg.q[0] - leg.d[0], leg.q[1] - leg.d[1]], leg.q),
        )?;
        proper.advance()?;
        let (found, wanted) = (w(flow.position()), w(proper.position()));
        if found.abs() < 0.5 * wanted.abs() && (found - wanted).abs() > 1e-7 {
            wrong += 1.0;
        }
    }
    Ok([refused, wrong])
}
