//! The arm of two links against inverse kinematics and inverse dynamics in closed form.

use dsocs_core::{DependentRow, Flow, RunError, Start, StepFailure, Stepper};
use dsocs_systems::Arm;

use super::is_second;
use dsocs_tests::motion::{continuous, discrete, distance};

fn start(arm: &Arm, t: f64) -> Start<2> {
    let (q, v) = arm.at(t);
    Start::second_order(q, v).at(t)
}

/// The torques of the motors at a time, by the equations of motion of a robot with two uniform links, `τ = M(q) q̈ + C(q, q̇)
/// q̇ + g(q)`.
fn torques(arm: &Arm, t: f64) -> [f64; 2] {
    let ([alpha, beta], [u, v]) = arm.at(t);
    let (l1, l2, m1, m2) = (arm.length_1, arm.length_2, arm.mass_1, arm.mass_2);
    // J q̈ = ẍ − J̇ q̇
    let (sum, sum_rate) = (alpha + beta, u + v);
    let (near, far) = (alpha.sin_cos(), sum.sin_cos());
    let w = arm.rate;
    let wanted = [
        -arm.radius * w * w * (w * t).cos() + l1 * near.1 * u * u + l2 * far.1 * sum_rate * sum_rate,
        -arm.radius * w * w * (w * t).sin() + l1 * near.0 * u * u + l2 * far.0 * sum_rate * sum_rate,
    ];
    let jacobian = [
        [-l1 * near.0 - l2 * far.0, -l2 * far.0],
        [l1 * near.1 + l2 * far.1, l2 * far.1],
    ];
    let determinant = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
    let a = (wanted[0] * jacobian[1][1] - jacobian[0][1] * wanted[1]) / determinant;
    let b = (jacobian[0][0] * wanted[1] - wanted[0] * jacobian[1][0]) / determinant;
    let (sin, cos) = beta.sin_cos();
    let m11 = m1 * l1 * l1 / 3.0 + m2 * (l1 * l1 + l2 * l2 / 3.0 + l1 * l2 * cos);
    let m12 = m2 * (l2 * l2 / 3.0 + l1 * l2 * cos / 2.0);
    let m22 = m2 * l2 * l2 / 3.0;
    let c = -m2 * l1 * l2 * sin / 2.0;
    let outer = m2 * l2 / 2.0 * far.1 * arm.gravity;
    let inner = (m1 / 2.0 + m2) * l1 * near.1 * arm.gravity;
    [
        m11 * a + m12 * b + c * (2.0 * u * v + v * v) + inner + outer,
        m12 * a + m22 * b - c * u * u + outer,
    ]
}

#[test]
fn the_tip_is_on_the_curve_and_the_torques_are_those_of_inverse_dynamics() {
    let arm = Arm::default();
    let mut flow = Flow::new(&arm, 0.01, start(&arm, 0.0)).unwrap();
    for node in &flow.until(5.0).unwrap() {
        let (q, _) = arm.at(node.t);
        assert!(distance(&node.q, &q) < 2e-14, "{node:?}");
    }
    for t in [0.7, 2.0, 4.3] {
        let found = continuous(&arm, start(&arm, 0.0), t).force;
        let apart = distance(&found, &torques(&arm, t));
        println!("t = {t}: torques {found:?}, apart by {apart:.1e}");
        assert!(apart < 1e-11, "{apart:e}");
    }
    let wanted = torques(&arm, 2.0);
    is_second("torques", [0.02, 0.01, 0.005, 0.0025], |h| {
        distance(&discrete(&arm, h, start(&arm, 0.0), 2.0).force, &wanted)
    });
}

/// The curve leaves the reach of the arm: the run ends where the arm is stretched, with the error that the constraints cannot
/// be met.
#[test]
fn out_of_reach_is_told() {
    let arm = Arm {
        center_x: 0.8,
        ..Arm::default()
    };
    // from the near side of the circle outwards; stretched at x² + y² = (l1 + l2)²
    let t0 = 1.2;
    let mut flow = Flow::new(&arm, -0.005, start(&arm, t0)).unwrap();
    let Err(failed) = flow.until(0.0) else {
        panic!("beyond its reach");
    };
    let last = failed.trajectory.nodes.last().unwrap();
    assert!(last.q[1] > 0.0 && last.q[1] < 0.2, "{last:?}");
    let RunError::Step(error) = &failed.error else {
        panic!("{}", failed.error);
    };
    let (details, text) = (error.details(), error.to_string());
    println!("{text}");
    assert_eq!(details.cause.reason, StepFailure::NoSolution, "{text}");
    let rows: Vec<_> = details.unmet.iter().map(|(row, _)| row.clone()).collect();
    assert!(rows.contains(&DependentRow::Holonomic(0)), "{rows:?}");
    assert!(
        text.contains("cannot be met") && text.contains("holonomic constraint"),
        "{text}"
    );
}
