//! The nonholonomic particle `ż = s y ẋ`.

use dsocs_core::dsocs;

/// A particle that crosses the plane `y = 0`.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(NonholonomicParticle::default())
        .named("nonholonomic-particle")
        .described("a free particle with the constraint z' = s y x'")
        .source("Rosenberg, Analytical Dynamics of Discrete Systems (1977); Bates and Śniatycki, Nonholonomic reduction (1993)")
        .start([0.0, -1.0, 0.0], [1.0, 0.5, -1.0])
        .step(0.05)
        .until(20.0)
        .symmetry("translation along x", |_: &[f64; 3]| [1.0, 0.0, 0.0])
        .symmetry("translation along y", |_: &[f64; 3]| [0.0, 1.0, 0.0])
}

/// A free particle whose height changes with its way along `x` by `ż = s y ẋ`: the simplest nonholonomic constraint.
///
/// By d'Alembert's principle `ẋ √(1 + s² y²)` and `ẏ` are invariant, which gives the motion in closed form
/// ([`NonholonomicParticle::exact`]). The translation along `y` is a virtual displacement, so its momentum is conserved. The
/// translation along `x` is not a virtual displacement, and its momentum obeys the momentum equation. The discrete Lagrangian is taken at the
/// midpoint, where the constraint is imposed on a leg.
#[dsocs {
    coordinates(
        /// The first horizontal position [m].
        x,
        /// The second horizontal position [m].
        y,
        /// The height [m].
        z,
    );
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
    nonholonomic = dot(z) - slope * y * dot(x);
    /// `ẋ √(1 + s² y²)`, which does not change [m/s].
    let invariant = dot(x) * (1 + (slope * y).powi(2)).sqrt();
    observe = [invariant];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonholonomicParticle {
    /// The mass of the particle \[kg\].
    pub mass: f64,
    /// How the slope `dz/dx` grows with `y` [1/m].
    pub slope: f64,
}

impl Default for NonholonomicParticle {
    /// A slope of one, a metre aside.
    fn default() -> Self {
        Self {
            mass: 1.0,
            slope: 1.0,
        }
    }
}

impl NonholonomicParticle {
    /// The exact position, in m, a time `t`, in s, after `(q0, v0)`, for a slope that is not zero.
    #[must_use]
    pub fn exact(&self, q0: [f64; 3], v0: [f64; 3], t: f64) -> [f64; 3] {
        let [x, y, z] = q0;
        let root = |y: f64| 1.0_f64.hypot(self.slope * y);
        let invariant = v0[0] * root(y);
        let after = y + v0[1] * t;
        if v0[1] == 0.0 {
            return [x + v0[0] * t, y, z + self.slope * y * v0[0] * t];
        }
        let scale = invariant / (self.slope * v0[1]);
        [
            x + scale * ((self.slope * after).asinh() - (self.slope * y).asinh()),
            after,
            z + scale * (root(after) - root(y)),
        ]
    }
}
