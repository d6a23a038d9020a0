//! Third derivatives in the wrong statements, and statements that cannot stand beside them.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + dddot(x);
    nonholonomic = dot(y) - dddot(x);
}]
pub struct InTheWrongStatement;

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddddot(x) - 1;
    constraint_forces = [1];
}]
pub struct Fourth;

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = dddot(x) - x_dddot;
    constraint_forces = [(1, 0)];
    phi_kinematic = midpoint;
}]
pub struct Unknown;

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let jerk = dddot(y);
    kinematic = dddot(x) - 1;
    constraint_forces = [(1, 0)];
    discrete_kinematic = x[2] - 2 * x[1] + x[0];
    observe = [jerk];
}]
pub struct Observed;

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = dddot(x) - dot(y);
}]
pub struct WithoutForces;

fn main() {}
