//! All maps overridden: of vectors, of components, with blocks, parameters and functions.

use dsocs_core::geometry::discrete_lagrangian;
use dsocs_core::{Real, dsocs};

fn weight<R: Real>(x: R) -> R {
    x * x + 1.0
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.cos();
    kinematic = ddot(x) + damping * dot(x) + dot(y) * y;
    variational = [(y, dot(x))];
    phi_lagrangian = |q0, q1| ((1 - alpha) * q0 + alpha * q1, (q1 - q0) / h);
    phi_kinematic = |q0, q1, q2| {
        let d0 = (q1 - q0) / h;
        let d1 = ((q2.x - q1.x) / h, (q2.y - q1.1) / h);
        (q1 + 0 * weight(q0.x), (d0 + d1) / 2, (d1 - d0) / h)
    };
    phi_variational = |a, b, c| ((b.x, b.y), (c - a) / (2 * h), ((c - 2 * b + a) / h.powi(2), 0));
}]
pub struct Particle {
    pub damping: f64,
    pub alpha: f64,
}

#[test]
fn works() {
    let particle = Particle {
        damping: 0.1,
        alpha: 0.5,
    };
    let leg = dsocs_core::Leg {
        t: 0.0,
        q: [1.0, 2.0],
        d: [0.5, 0.25],
    };
    let value = discrete_lagrangian(&particle, 0.5, leg.any());
    let expected = (1.0 + 0.25) / 2.0 - 0.75_f64.cos();
    assert!((value - expected).abs() < 1e-14, "{value} {expected}");
}
