//! The discrete motion of the pendulum agrees with the reference, row by row, within double precision; so do
//! single steps, also those where the wrong root is nearest.

use dsocs_core::{Flow, Start, Stepper};
use dsocs_systems::InertiaWheelPendulum;
use dsocs_tests::closed_form::pendulum::START;
use dsocs_tests::data::Table;

/// Up to a time: the largest deviations of `θ` and `ψ`, by the README beside the reference data.
type Tolerance = (f64, [f64; 2]);

fn compare(h: f64, file: &str, tolerances: &[Tolerance]) {
    let table = Table::read(file);
    let pendulum = InertiaWheelPendulum::default();
    let mut flow = Flow::new(&pendulum, h, Start::paper(START.0, START.1)).unwrap();
    let trajectory = flow.until(2000.0).unwrap();
    let mut worst = vec![[0.0_f64; 2]; tolerances.len()];
    let derived = table.numbers("w").into_iter().zip(table.numbers("V"));
    let rows = table
        .indices("k")
        .into_iter()
        .zip(table.pairs(["theta", "psi"]))
        .zip(derived);
    for ((k, q), (w, v)) in rows {
        let node = &trajectory.nodes[usize::try_from(k).unwrap()];
        let band = tolerances
            .iter()
            .position(|(until, _)| node.t <= until + 1e-9)
            .unwrap();
        for i in 0..2 {
            let deviation = (node.q[i] - q[i]).abs();
            worst[band][i] = worst[band][i].max(deviation);
            assert!(
                deviation <= tolerances[band].1[i],
                "h = {h}, t = {}: coordinate {i} is {deviation:e} off",
                node.t
            );
        }
        if k > 0 {
            // w and V are evaluated at the central velocity: in them a deviation of ψ is multiplied by g J/2h
            // and more
            let [_, psi] = tolerances[band].1;
            let (mine, lyapunov) = (pendulum.factor(node.q, node.v), pendulum.lyapunov(node.q, node.v));
            let sensitivity = 1e3 * psi / h;
            assert!(
                (mine - w).abs() <= sensitivity,
                "t = {}: w = {mine}, not {w}",
                node.t
            );
            assert!(
                (lyapunov - v).abs() <= sensitivity * (1.0 + w.abs()),
                "t = {}: V = {lyapunov}, not {v}",
                node.t
            );
        }
    }
    println!("h = {h}: largest deviations {worst:?}");
}

#[test]
fn with_the_step_0_1() {
    let tolerances = [
        (10.0, [1e-13, 5e-10]),
        (100.0, [3e-11, 5e-9]),
        (2000.0, [5e-11, 1e-8]),
    ];
    compare(0.1, "pendulum_discrete_h0.1.csv", &tolerances);
}

#[test]
fn with_the_step_0_05() {
    compare(
        0.05,
        "pendulum_discrete_h0.05.csv",
        &[(100.0, [1e-10, 3e-8]), (2000.0, [2e-10, 4e-8])],
    );
}

#[test]
fn with_the_step_0_0125() {
    compare(
        0.0125,
        "pendulum_discrete_h0.0125.csv",
        &[(100.0, [1e-9, 2e-7]), (2000.0, [1e-9, 2e-7])],
    );
}

/// Checks each step of a file by itself, from its first two nodes.
fn single_steps(file: &str, tolerance: [f64; 2]) {
    let table = Table::read(file);
    let pendulum = InertiaWheelPendulum::default();
    let (q0, q1) = (table.pairs(["theta0", "psi0"]), table.pairs(["theta1", "psi1"]));
    let (q2, spurious) = (
        table.pairs(["theta2", "psi2"]),
        table.pairs(["theta2_spurious", "psi2_spurious"]),
    );
    let mut worst = [0.0_f64; 2];
    for (row, k) in table.indices("k").into_iter().enumerate() {
        let mut flow = Flow::new(&pendulum, 0.1, Start::nodes(q0[row], q1[row])).unwrap();
        flow.advance().unwrap_or_else(|error| panic!("step {k}: {error}"));
        for i in 0..2 {
            let deviation = (flow.position()[i] - q2[row][i]).abs();
            worst[i] = worst[i].max(deviation);
            assert!(
                deviation <= tolerance[i],
                "step {k}: coordinate {i} is {deviation:e} off"
            );
        }
        // the other root is farther away than the tolerance in the hardest of the steps
        assert!(
            (flow.position()[0] - spurious[row][0]).abs() > tolerance[0],
            "step {k} took the spurious root"
        );
    }
    println!("{file}: largest deviations {worst:?}");
}

#[test]
fn the_first_steps_one_by_one() {
    single_steps("pendulum_first_steps_h0.1.csv", [1e-14, 1e-12]);
}

#[test]
fn the_hard_steps_one_by_one() {
    // the tolerance of a solution with the factor divided out exactly; dividing the row numerically loses two digits more
    single_steps(
        "../../dsocs-systems/data/pendulum_hard_steps_h0.1.csv",
        [1e-13, 2e-11],
    );
}
