//! The paper's pendulum with its rod as a constraint, against the one in angles: the motion is in `constraints.rs`, here are
//! the forces.

use dsocs_core::{Flow, Start, Stepper, System};
use dsocs_systems::{InertiaWheelPendulum, RodAndWheel};

use super::{continuous, fitted, is_second, order, start};
use dsocs_tests::motion::distance;

/// The state in angles at a time.
fn by_angles(t: f64) -> ([f64; 2], [f64; 2]) {
    continuous(&InertiaWheelPendulum::default(), ([0.5, 0.0], [0.0, 0.5]), t)
}

const STEPS: [f64; 4] = [0.002, 0.001, 0.0005, 0.00025];

#[test]
fn it_is_the_pendulum_in_angles() {
    let pendulum = RodAndWheel::default();
    let start = start("rod-and-wheel");
    let ([theta, psi], _) = by_angles(1.0);
    let exact = [theta.sin(), theta.cos(), psi];
    let apart = distance(&continuous(&pendulum, start, 1.0).0, &exact);
    println!("Taylor flows apart by {apart:.1e}");
    assert!(apart < 1e-10, "{apart:e}");
    let order = order(&pendulum, start, 1.0, &STEPS, |q| distance(q, &exact));
    assert!((order - 2.0).abs() < 0.1, "{order}");
}

#[test]
fn the_multipliers_are_the_rods_force_and_the_motors_torque() {
    let pendulum = RodAndWheel::default();
    assert_eq!(RodAndWheel::FORMS, 2);
    let (q, v) = start("rod-and-wheel");
    let (angles, rates) = by_angles(1.0);
    // θ̈ and the torque from the momenta's equations: p₁' = M sin θ, p₂' = torque
    let own = InertiaWheelPendulum::default();
    let [p1, p2] = own.momentum(rates);
    let torque = own.proper_branch([angles[0], angles[1], p1, p2])[3];
    // along the rod: −I θ̇² = −M cos θ + λ
    let rod = own.m * angles[0].cos() - own.i * rates[0] * rates[0];
    for (form, exact) in [rod, torque].into_iter().enumerate() {
        println!("multiplier {form}: {exact}");
        is_second(fitted(&STEPS, |h| {
            let mut flow = Flow::new(&pendulum, h, Start::second_order(q, v)).unwrap();
            let nodes = flow.until(1.0).unwrap().nodes;
            (flow.multipliers(nodes.last().unwrap())[form] - exact).abs()
        }));
    }
}
