//! The constraint force of the pendulum is the torque of a motor: as the input of a pendulum without
//! constraint, written by hand and integrated by an ODE solver, it gives the same motion.

use dsocs_core::geometry::{constraint_force, motion};
use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{Flow, Start, Stepper};
use dsocs_systems::InertiaWheelPendulum;
use dsocs_tests::fit::slope;
use ode_solvers::{Rk4, SVector};

use dsocs_tests::dop853;

const Q0: [f64; 2] = [0.5, 0.0];
const V0: [f64; 2] = [0.0, 0.5];

/// The inertia wheel pendulum with a motor: `(I + J) θ″ + J ψ″ = M sin θ`, `J (θ″ + ψ″) = τ`.
struct Motor<T> {
    torque: T,
}

impl<T: Fn(f64, [f64; 2], [f64; 2]) -> f64> ode_solvers::System<f64, SVector<f64, 4>> for Motor<T> {
    fn system(&self, t: f64, y: &SVector<f64, 4>, dy: &mut SVector<f64, 4>) {
        *dy = self.rate(t, (*y).into()).into();
    }
}

impl<T: Fn(f64, [f64; 2], [f64; 2]) -> f64> Motor<T> {
    fn rate(&self, t: f64, [theta, psi, theta_rate, psi_rate]: [f64; 4]) -> [f64; 4] {
        let InertiaWheelPendulum { i, j, m, .. } = InertiaWheelPendulum::default();
        let torque = (self.torque)(t, [theta, psi], [theta_rate, psi_rate]);
        let acceleration = (m * theta.sin() - torque) / i;
        [theta_rate, psi_rate, acceleration, torque / j - acceleration]
    }
}

/// The state at the start.
const STATE: [f64; 4] = [Q0[0], Q0[1], V0[0], V0[1]];

/// The angles after a time, under a smooth torque.
fn angles_under_torque(torque: impl Fn(f64, [f64; 2], [f64; 2]) -> f64, end: f64) -> [f64; 2] {
    let motor = Motor { torque };
    let last = dop853::integrate(|t, state| motor.rate(t, state), STATE, end, 1e-13);
    [last[0], last[1]]
}

/// The constraint force as a function of the state, applied by the motor: after 10 and 40 s the angles of
/// DOP853 are those of the Taylor flow, `θ` to 1e-9 and `ψ`, which is 150 times as large, to 2e-7.
#[test]
fn as_a_feedback_law() {
    let pendulum = InertiaWheelPendulum::default();
    let law = |_: f64, q: [f64; 2], v: [f64; 2]| {
        constraint_force(&pendulum, motion(&pendulum, 0.0, &q, &v).unwrap().any())[1]
    };
    for end in [10.0, 40.0] {
        let found = angles_under_torque(law, end);
        let exact = TaylorFlow::new(&pendulum, Start::second_order(Q0, V0), Tolerance::relative(1e-15))
            .unwrap()
            .to(end)
            .unwrap()
            .q;
        let apart = [found[0] - exact[0], found[1] - exact[1]];
        println!("t = {end}: {apart:?}");
        // ψ is about 150 times as far as θ is
        assert!(apart[0].abs() < 1e-9 && apart[1].abs() < 2e-7, "{apart:?}");
    }
}

#[test]
fn as_a_plan_of_the_torque() {
    // node by node from the discrete motion, with a cubic polynomial through four nodes in between; they join with kinks,
    // so that a solver with a fixed step goes from node to node
    let pendulum = InertiaWheelPendulum::default();
    let end = 10.0;
    let steps = [0.1, 0.05, 0.025, 0.0125];
    let deviations = steps.map(|h| {
        let mut flow = Flow::new(&pendulum, h, Start::second_order(Q0, V0)).unwrap();
        let nodes = flow.until(end + 3.0 * h).unwrap().nodes;
        let torques: Vec<f64> = nodes
            .iter()
            .map(|node| {
                let lambda = flow.multipliers(node)[0];
                assert!((lambda - node.force[1]).abs() <= 1e-14 * lambda.abs(), "{lambda}");
                assert!(node.force[0].abs() < 1e-9, "the force acts on the wheel alone");
                node.force[1]
            })
            .collect();
        let plan = |t: f64, _: [f64; 2], _: [f64; 2]| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some hundreds
            let first = ((t / h).floor() as usize)
                .saturating_sub(1)
                .min(torques.len() - 4);
            let x = t / h - first as f64;
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| torques[first + k]);
            a * (x - 1.0) * (x - 2.0) * (x - 3.0) / -6.0
                + b * x * (x - 2.0) * (x - 3.0) / 2.0
                + c * x * (x - 1.0) * (x - 3.0) / -2.0
                + d * x * (x - 1.0) * (x - 2.0) / 6.0
        };
        let mut solver = Rk4::new(Motor { torque: plan }, 0.0, STATE.into(), end, h / 8.0);
        solver.integrate().unwrap();
        let found = solver.y_out().last().unwrap();
        assert!((solver.x_out().last().unwrap() - end).abs() < 1e-9);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let last = nodes[(end / h).round() as usize].q;
        (found[0] - last[0]).abs()
    });
    let order = slope(&steps, &deviations);
    println!("θ apart by {deviations:?}, order {order:.3}");
    assert!((order - 2.0).abs() < 0.1, "{order}, {deviations:?}");
}
