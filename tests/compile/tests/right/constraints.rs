//! Constraints of every order, rules of displacements, and discrete expressions.

use dsocs_core::{Flow, Start, Stepper, System, dsocs};

#[dsocs {
    coordinates(x, y, z, u);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) + dot(u).powi(2)) / 2 - y;
    holonomic = x.powi(2) + y.powi(2) - 1;
    nonholonomic = dot(z) - x * dot(u);
    kinematic = ddot(u) + dot(u) + u.powi(3) - x;
    variational = chetaev;
    phi_lagrangian = trapezoid;
    phi_kinematic = paper;
    phi_variational = midpoint;
}]
struct Mixed;

#[dsocs {
    coordinates(theta: [2]);
    let energy = (dot(theta[0]).powi(2) + dot(theta[1]).powi(2)) / 2;
    lagrangian = energy;
    kinematic = dot(energy) + energy;
    constraint_forces = [[0, 1]];
    discrete_lagrangian = sum(0..2, |i| ((theta[i][1] - theta[i][0]) / h).powi(2) / 2);
    discrete_kinematic = leg(energy, 1) - leg(energy, 0) + h * node(energy);
}]
struct Discrete;

#[test]
fn works() {
    assert_eq!((Mixed::HOLONOMIC, Mixed::NONHOLONOMIC, Mixed::FORMS), (1, 1, 3));
    let start = Start::second_order([0.6, -0.8, 0.0, 1.0], [0.8, 0.6, 0.3, 0.5]);
    let mut flow = Flow::new(&Mixed, 0.01, start).unwrap();
    for _ in 0..10 {
        flow.advance().unwrap();
    }
    let mut flow = Flow::new(&Discrete, 0.01, Start::second_order([0.0; 2], [1.0, 2.0])).unwrap();
    for _ in 0..10 {
        flow.advance().unwrap();
    }
}
