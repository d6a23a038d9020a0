//! One coordinate: fields with and without a tuple, rows of first and of second order.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2);
}]
pub struct Free;

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    variational = [(1,)];
}]
pub struct Tuple;

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    variational = [1 + x.powi(2)];
}]
pub struct Bare;

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + x;
    constraint_forces = [1];
}]
pub struct Driven;

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    nonholonomic = dot(x) - speed;
    variational = [];
}]
pub struct Conveyor {
    pub speed: f64,
}
