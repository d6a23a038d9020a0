//! Systems for unit tests.

use dsocs_macros::dsocs;

/// The particle in the plane that turns with a constant curvature; its chords form a regular polygon's arc.
#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
    variational = [(dot(x), dot(y))];
    observe = [speed];
}]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Particle {
    /// mass [kg]
    pub mass: f64,
    /// curvature [1/m]
    pub curvature: f64,
}

impl Default for Particle {
    fn default() -> Self {
        Self {
            mass: 1.0,
            curvature: 1.0,
        }
    }
}

impl Particle {
    /// Node `k` of the exact discrete motion from the origin, `(x, y)`, for the first increment `d0`.
    pub fn polygon(&self, d0: [f64; 2], k: u64) -> [f64; 2] {
        let length = d0[0].hypot(d0[1]);
        let turn = self.curvature * length;
        let half = (turn / (1.0 + turn.hypot(1.0))).asin();
        let direction = d0[1].atan2(d0[0]) + (k as f64 - 1.0) * half;
        let chord = length * (k as f64 * half).sin() / half.sin();
        [chord * direction.cos(), chord * direction.sin()]
    }
}

/// A point on the line whose acceleration is `√(1 - q)`: no step leads on from `q > 1`.
///
/// Its equation is linear in the acceleration and has been solved beforehand: there is nothing left to iterate.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2);
    kinematic = ddot(x) - (1 - x).sqrt();
    variational = [];
}]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cliff;
