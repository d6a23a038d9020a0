//! The time `t` as a function, an array, a coordinate or the name of a parameter.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 * dot(t) - x(t) * mass(t) - time * y;
    holonomic = y - t[0];
}]
pub struct Functions {
    pub mass: f64,
}

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
}]
pub struct Named {
    pub t: f64,
}

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - t * x;
    phi_lagrangian = |q0, q1| ((1 - t) * q0 + t * q1, (q1 - q0) / h);
}]
pub struct WithoutTimes;

#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - t * x;
    phi_lagrangian = |q0, t0, q1, t1| (t0, q0, (q1 - q0) / h);
}]
pub struct InTheWrongOrder;

fn main() {}
