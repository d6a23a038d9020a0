//! Constraint forces in two and three dimensions, constant and varying.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta, psi);
    lagrangian = (dot(theta).powi(2) + (dot(theta) + dot(psi)).powi(2)) / 2 - theta.cos();
    kinematic = ddot(theta) + dot(theta) + theta;
    constraint_forces = [(0, 1)];
}]
pub struct Pendulum;

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = ddot(x) * dot(x) + ddot(y) * dot(y);
    constraint_forces = [(dot(x), dot(y))];
}]
pub struct Constant;

#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2;
    kinematic = ddot(z) - y * ddot(x);
    constraint_forces = [(-y, 0, 1)];
}]
pub struct Knife;

#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2;
    kinematic = [ddot(z) - y * ddot(x), ddot(x) + x];
    constraint_forces = [(x, y, z), (y, z, x)];
    branch = [divide(1 + x.powi(2)), _];
}]
pub struct Two;
