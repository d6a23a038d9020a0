//! A system whose Jacobian is mostly zero.

use dsocs_core::dsocs;

/// Points on massless rods in the plane, hanging from a pivot, in Cartesian coordinates: most of the Jacobian is zero.
#[dsocs {
    coordinates(x: [14], y: [14]);
    lagrangian = sum(0..14, |i| masses[i] * ((dot(x[i]).powi(2) + dot(y[i]).powi(2)) / 2 - gravity * y[i]));
    let rod = |i| (x[i] - x[i - 1]).powi(2) + (y[i] - y[i - 1]).powi(2) - length.powi(2);
    holonomic = [x[0].powi(2) + y[0].powi(2) - length.powi(2), each(1..14, |i| rod(i))];
}]
#[derive(Clone, Debug)]
pub struct Rods {
    /// The masses, from the pivot on.
    pub masses: [f64; 14],
    /// The length of each rod.
    pub length: f64,
    /// The gravity.
    pub gravity: f64,
}

impl Default for Rods {
    fn default() -> Self {
        Self {
            masses: core::array::from_fn(|i| 1.0 + 0.1 * i as f64),
            length: 0.5,
            gravity: 9.81,
        }
    }
}
