//! The clothoid: the curve along which a road or a railway goes from straight to bent.

use dsocs_core::dsocs;

/// A vehicle enters a bend: its curvature grows in proportion to the way.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    crate::Entry::new(Clothoid::default())
        .named("clothoid")
        .described("the clothoid of roads and rails: the curvature of the path grows in proportion to its length")
        .source("Euler 1744, Additamentum I (De curvis elasticis), art. 51; Borda, Fernández and Grillo, remark on constraints of order k")
        .start_with_acceleration([0.0, 0.0], [1.0, 0.0], [0.0, 0.2])
        .step(0.05)
        .until(10.0)
}

/// A particle in the plane, steered so that the curvature `κ` of its path changes by `c` per unit of length, `dκ/dt = c |v|`: a constraint of
/// third order.
///
/// The force of the constraint is across the path, as that of rails, so that the speed stays. Then the path is Euler's spiral,
/// `κ(s) = κ0 + c s`, and the position an integral of Fresnel's kind ([`Clothoid::exact`]). The curvature at the start is free: an
/// acceleration across the path says it.
///
/// The discrete path has legs of equal length `l`, and from one to the next it turns by angles with
/// `sin b − sin a − ¾ (sin b + sin a)(cos b − cos a) = c l²` ([`Clothoid::turn_after`]).
#[dsocs {
    coordinates(
        /// The first position [m].
        x,
        /// The second position [m].
        y,
    );
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    /// The speed [m/s].
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    /// The curvature of the path, positive to the left [1/m].
    let curvature = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3);
    kinematic = dot(curvature) - rate * speed;
    constraint_forces = [(-dot(y), dot(x))];
    observe = [curvature, speed];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clothoid {
    /// The mass \[kg\].
    pub mass: f64,
    /// The change `c` of the curvature per unit of length [1/m²].
    pub rate: f64,
}

impl Default for Clothoid {
    /// One kilogram; the curvature grows by 0.1 per metre and metre.
    fn default() -> Self {
        Self { mass: 1.0, rate: 0.1 }
    }
}

/// Points and weights of Gauss's quadrature with eight points on the interval from −1 to 1, for one sign.
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_26],
];

/// The integral is taken in so many pieces for each radian that the path turns by, at least.
const PIECES: f64 = 4.0;

impl Clothoid {
    /// The exact position, in m, after the way `s`, in m, from the origin along the first axis with the curvature `curvature`, in 1/m.
    #[must_use]
    pub fn exact(&self, curvature: f64, s: f64) -> [f64; 2] {
        let heading = |s: f64| s * (curvature + self.rate * s / 2.0);
        let turned = s.abs() * (curvature.abs() + self.rate.abs() * s.abs());
        let pieces = (PIECES * turned).ceil().max(1.0);
        let half = s / pieces / 2.0;
        let mut position = [0.0; 2];
        let mut piece = 0.0;
        while piece < pieces {
            let middle = (2.0 * piece + 1.0) * half;
            for [node, weight] in GAUSS {
                for side in [-1.0, 1.0] {
                    let (sin, cos) = heading(middle + side * node * half).sin_cos();
                    position[0] += weight * half * cos;
                    position[1] += weight * half * sin;
                }
            }
            piece += 1.0;
        }
        position
    }

    /// The angle by which the discrete path turns at a node, after the angle `before` at the node before, both small, with legs of the length
    /// `leg`, in m: the closed form of a step.
    #[must_use]
    pub fn turn_after(&self, before: f64, leg: f64) -> f64 {
        let (sin, cos) = before.sin_cos();
        let mut turn = before;
        for _ in 0..ITERATIONS {
            let (s, c) = turn.sin_cos();
            let missed = s - sin - 0.75 * (s + sin) * (c - cos) - self.rate * leg * leg;
            let slope = c - 0.75 * (c * (c - cos) - (s + sin) * s);
            turn -= missed / slope;
        }
        turn
    }
}

/// So often Newton's iteration for a turn is repeated.
const ITERATIONS: u32 = 8;
