//! Ten rigid bodies in a chain, with ball joints between them.

use dsocs_core::dsocs;

use crate::problem::{Declared, Problem};

/// The chain: each joint is a constraint on positions, of three rows. The body that is measured comes first.
#[dsocs {
    coordinates(x9: [3], r9: rotation, x0: [3], r0: rotation, x1: [3], r1: rotation, x2: [3], r2: rotation, x3: [3], r3: rotation, x4: [3], r4: rotation, x5: [3], r5: rotation, x6: [3], r6: rotation, x7: [3], r7: rotation, x8: [3], r8: rotation);
    let body = |x, r| {
        let w = r.angular_velocity();
        let turning = sum(0..3, |i| moments[i] * w[i].powi(2)) / 2;
        turning + dot(x).norm_squared() / 2 - 9.81 * x[2]
    };
    let joint = |x, r, y, s| (x + r * half) - (y - s * half);
    lagrangian = body(x0, r0) + body(x1, r1) + body(x2, r2) + body(x3, r3) + body(x4, r4) + body(x5, r5) + body(x6, r6) + body(x7, r7) + body(x8, r8) + body(x9, r9);
    holonomic = [
        x0 - r0 * half,
        joint(x0, r0, x1, r1),
        joint(x1, r1, x2, r2),
        joint(x2, r2, x3, r3),
        joint(x3, r3, x4, r4),
        joint(x4, r4, x5, r5),
        joint(x5, r5, x6, r6),
        joint(x6, r6, x7, r7),
        joint(x7, r7, x8, r8),
        joint(x8, r8, x9, r9),
    ];
}]
pub struct Chain10 {
    moments: [f64; 3],
    half: [f64; 3],
}

/// The number of bodies.
pub const BODIES: usize = 10;

/// The moments of inertia of each body about its centre of mass, in kg m²; its mass is 1 kg.
pub const MOMENTS: [f64; 3] = [0.018, 0.018, 0.003];

/// The distance of the centre of mass from either joint, in m.
pub const HALF: f64 = 0.225;

/// The chain, released bent and twisted. The position of the last body is measured.
#[derive(Clone, Copy)]
pub struct Bodies;

impl Bodies {
    /// The attitudes at the start, from the fixed point on.
    pub fn attitudes() -> [[f64; 4]; BODIES] {
        core::array::from_fn(|i| {
            let (along, angle) = (0.6 * i as f64, 0.45 + 0.05 * i as f64);
            let (sin, cos) = (angle / 2.0).sin_cos();
            [cos, sin * along.cos(), sin * along.sin(), 0.0]
        })
    }
}

/// The position of the joint below, relative to the centre of mass, of a body with this attitude.
fn below([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let axis = [
        2.0 * (x * z + w * y),
        2.0 * (y * z - w * x),
        1.0 - 2.0 * (x * x + y * y),
    ];
    axis.map(|part| -HALF * part)
}

impl Problem for Bodies {
    const NAME: &'static str = "bodies";
    const MEASURED: usize = 3;
    const END: u32 = 2;
}

impl Declared<70> for Bodies {
    type System = Chain10;

    fn system(&self) -> Self::System {
        Chain10 {
            moments: MOMENTS,
            half: [0.0, 0.0, -HALF],
        }
    }

    fn begin(&self) -> ([f64; 70], [f64; 70]) {
        let mut q = [0.0; 70];
        let mut joint = [0.0; 3];
        for (i, attitude) in Self::attitudes().into_iter().enumerate() {
            let half = below(attitude);
            let centre = [0, 1, 2].map(|k| joint[k] + half[k]);
            joint = [0, 1, 2].map(|k| centre[k] + half[k]);
            // the last body comes first
            let place = 7 * ((i + 1) % BODIES);
            q[place..place + 3].copy_from_slice(&centre);
            q[place + 3..place + 7].copy_from_slice(&attitude);
        }
        (q, [0.0; 70])
    }
}
