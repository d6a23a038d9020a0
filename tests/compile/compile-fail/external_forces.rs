//! External forces under the names of other statements.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    forces = (-drag * dot(x), -drag * dot(y));
}]
pub struct Forces {
    pub drag: f64,
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    damping = (-drag * dot(x), -drag * dot(y));
}]
pub struct Damping {
    pub drag: f64,
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    external_forces = (-drag * dot(x),);
}]
pub struct TooFew {
    pub drag: f64,
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    external_forces = [-drag * dot(x), -drag * dot(y)];
}]
pub struct List {
    pub drag: f64,
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    external_forces = (-added * ddot(x), 0);
}]
pub struct Acceleration {
    pub added: f64,
}

fn main() {}
