//! The clothoid: the curve between a straight and a bend of a road or a railway.

use dsocs_core::dsocs;

/// A vehicle enters a bend: the curvature grows in proportion to the distance travelled.
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
/// The constraint force is orthogonal to the path, like that of rails, so the speed is constant. The path is Euler's spiral with the curvature
/// `κ(s) = κ0 + c s`. The position is a Fresnel integral ([`Clothoid::exact`]). The curvature at the start is free; the acceleration at the start
/// gives it.
///
/// The legs of the discrete path have the same length `l`. The angles `a`, `b` by which it turns at two consecutive nodes obey
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
    /// A mass of one kilogram. The curvature grows by 0.1 1/m per metre.
    fn default() -> Self {
        Self { mass: 1.0, rate: 0.1 }
    }
}

/// Points and weights of Gauss's quadrature with eight points on the interval from −1 to 1: the four positive points.
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_26],
];

/// The least number of pieces of the integral for each radian by which the path turns.
const PIECES: f64 = 4.0;

impl Clothoid {
    /// The exact position, in m, after the distance `s`, in m. The path begins at the origin along the first axis, with the curvature
    /// `curvature`, in 1/m.
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

    /// The angle by which the discrete path turns at a node, in rad: the closed form of a step. `before` is the angle at the previous node, in
    /// rad, and `leg` the length of a leg, in m. Both angles have to be small.
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

/// The number of Newton's iterations for a turn.
const ITERATIONS: u32 = 8;
