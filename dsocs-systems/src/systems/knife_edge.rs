//! A knife edge, or skate, on an inclined plane.

use dsocs_core::dsocs;

/// The classical start: the edge turns and is otherwise at rest. It does not slide down.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(KnifeEdge::default())
        .named("knife-edge")
        .described("a knife edge on an inclined plane")
        .source("Bloch, Nonholonomic Mechanics and Control, section 1.6")
        .start([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
        .step(0.05)
        .until(50.0)
        .drawn(|&[x, y, phi]: &[f64; 3], _| super::blade([y, -x], phi - std::f64::consts::FRAC_PI_2, 0.2))
        .symmetry("turning the edge", |_: &[f64; 3]| [0.0, 0.0, 1.0])
        .symmetry("translation across the slope", |_: &[f64; 3]| [0.0, 1.0, 0.0])
}

/// A knife edge that moves on an inclined plane, only in its own direction.
///
/// `x` points down the slope, `y` across it, and the edge makes the angle `φ` with `x`: `ẋ sin φ = ẏ cos φ`. It turns at a constant
/// rate, and gravity works along the edge: with the speed `u` along it, `u̇ = g sin α cos φ`. The motion is in closed form
/// ([`KnifeEdge::exact`]): from rest at `φ = 0` it is a cycloid across the slope, and the edge never gets lower than
/// `g sin α / 2ω²`.
#[dsocs {
    coordinates(
        /// The position down the slope [m].
        x,
        /// The position across the slope [m].
        y,
        /// The angle of the edge with `x` [rad].
        phi,
    );
    /// The speed along the edge [m/s].
    let speed = dot(x) * phi.cos() + dot(y) * phi.sin();
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) + inertia / 2 * dot(phi).powi(2)
        + mass * gravity * incline.sin() * x;
    nonholonomic = dot(x) * phi.sin() - dot(y) * phi.cos();
    observe = [speed];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnifeEdge {
    /// The mass \[kg\].
    pub mass: f64,
    /// The moment of inertia about the point of contact [kg m²].
    pub inertia: f64,
    /// The acceleration of gravity [m/s²].
    pub gravity: f64,
    /// The angle `α` of the plane with the horizontal \[rad\].
    pub incline: f64,
}

impl Default for KnifeEdge {
    /// A slope of 0.1 rad.
    fn default() -> Self {
        Self {
            mass: 1.0,
            inertia: 0.1,
            gravity: 9.81,
            incline: 0.1,
        }
    }
}

impl KnifeEdge {
    /// The exact position `(x, y, φ)` a time `t`, in s, after `(q0, v0)`, which obeys the constraint.
    #[must_use]
    pub fn exact(&self, q0: [f64; 3], v0: [f64; 3], t: f64) -> [f64; 3] {
        let ([x, y, phi0], rate) = (q0, v0[2]);
        let (sin0, cos0) = phi0.sin_cos();
        let speed = v0[0] * cos0 + v0[1] * sin0;
        let pull = self.gravity * self.incline.sin();
        if rate == 0.0 {
            let way = speed * t + pull * cos0 * t * t / 2.0;
            return [x + way * cos0, y + way * sin0, phi0];
        }
        // u = c + A sin φ, and (ẋ, ẏ) = u (cos φ, sin φ)
        let amplitude = pull / rate;
        let constant = speed - amplitude * sin0;
        let phi = phi0 + rate * t;
        let (sin, cos) = phi.sin_cos();
        let along = constant * (sin - sin0) + amplitude / 2.0 * (sin * sin - sin0 * sin0);
        let across = -constant * (cos - cos0) + amplitude / 2.0 * (rate * t - (sin * cos - sin0 * cos0));
        [x + along / rate, y + across / rate, phi]
    }
}
