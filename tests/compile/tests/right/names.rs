//! Names that generated code could collide with.

use dsocs_core::dsocs;

#[allow(dead_code)]
trait System {}
#[allow(dead_code)]
struct Point;
#[allow(dead_code, non_camel_case_types)]
struct f32;

/// A system whose names are those of the trait.
#[dsocs {
    /// The coordinates.
    coordinates(q, z);
    /// The Lagrangian.
    lagrangian = (dot(q).powi(2) + dot(z).powi(2)) / 2 * constants * leg - e;
    let rows = dot(q);
    let v = ddot(z) + T;
    kinematic = v + rows;
    constraint_forces = [(0, 1)];
}]
#[allow(missing_docs)]
pub struct Names<U: Copy> {
    pub constants: f64,
    pub leg: f64,
    pub e: f64,
    pub known: U,
}

#[allow(dead_code)]
const T: f64 = 1.0;
