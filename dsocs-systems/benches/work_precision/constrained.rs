//! Problems with constraints on positions and on velocities.

use dsocs_core::dsocs;

use crate::problem::{Declared, Equations, Problem};

/// A pendulum on a rod, in Cartesian coordinates.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - gravity * z;
    holonomic = x.powi(2) + y.powi(2) + z.powi(2) - 1;
}]
pub struct Rod {
    gravity: f64,
}

/// The nonholonomic particle in a harmonic potential.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - (x.powi(2) + y.powi(2)) / 2;
    nonholonomic = dot(z) - y * dot(x);
    phi_lagrangian = midpoint;
}]
pub struct Skate {}

/// The acceleration of gravity, in m/s².
const GRAVITY: f64 = 9.81;

/// A pendulum on a sphere, by its holonomic constraint.
#[derive(Clone, Copy)]
pub struct Sphere;

impl Problem for Sphere {
    const NAME: &'static str = "sphere";
    const MEASURED: usize = 3;
    const END: u32 = 50;
}

impl Equations<6> for Sphere {
    fn start(&self) -> [f64; 6] {
        [0.6, 0.0, -0.8, 0.0, 1.0, 0.0]
    }

    #[inline]
    fn rate(&self, &[x, y, z, vx, vy, vz]: &[f64; 6]) -> [f64; 6] {
        let multiplier = (GRAVITY * z - (vx * vx + vy * vy + vz * vz)) / (x * x + y * y + z * z);
        [
            vx,
            vy,
            vz,
            multiplier * x,
            multiplier * y,
            multiplier * z - GRAVITY,
        ]
    }
}

impl Declared<3> for Sphere {
    type System = Rod;

    fn system(&self) -> Self::System {
        Rod { gravity: GRAVITY }
    }

    fn begin(&self) -> ([f64; 3], [f64; 3]) {
        ([0.6, 0.0, -0.8], [0.0, 1.0, 0.0])
    }
}

/// The nonholonomic particle.
#[derive(Clone, Copy)]
pub struct Contact;

impl Problem for Contact {
    const NAME: &'static str = "contact";
    const MEASURED: usize = 3;
    const END: u32 = 100;
}

impl Equations<6> for Contact {
    fn start(&self) -> [f64; 6] {
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    }

    #[inline]
    fn rate(&self, &[x, y, _, vx, vy, vz]: &[f64; 6]) -> [f64; 6] {
        let multiplier = (vx * vy - x * y) / (1.0 + y * y);
        [vx, vy, vz, -x - y * multiplier, -y, multiplier]
    }
}

impl Declared<3> for Contact {
    type System = Skate;

    fn system(&self) -> Self::System {
        Skate {}
    }

    fn begin(&self) -> ([f64; 3], [f64; 3]) {
        ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    }
}
