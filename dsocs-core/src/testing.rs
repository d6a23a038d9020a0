//! Systems written by hand, for unit tests.

use crate::scalar::Scalar;
use crate::step::unknown::Linearization;
use crate::system::{Leg, Point, Quantity, System};

/// The particle in the plane that turns with a constant curvature; its chords form a regular polygon's arc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Particle {
    pub mass: f64,
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
    /// Node `k` of the discrete motion from the origin, exactly: `(x, y)` from the first increment.
    pub fn polygon(&self, d0: [f64; 2], k: u64) -> [f64; 2] {
        let length = d0[0].hypot(d0[1]);
        let turn = self.curvature * length;
        let half = (turn / (1.0 + turn.hypot(1.0))).asin();
        let direction = d0[1].atan2(d0[0]) + (k as f64 - 1.0) * half;
        let chord = length * (k as f64 * half).sin() / half.sin();
        [chord * direction.cos(), chord * direction.sin()]
    }

    fn rows<T: Scalar>(&self, v: [T; 2], a: [T; 2]) -> ([T; 2], [[T; 2]; 2], [[T; 2]; 2]) {
        let (mass, curvature) = (T::splat(self.mass), T::splat(self.curvature));
        let squared = v[0] * v[0] + v[1] * v[1];
        let cubed = (squared * squared.sqrt()).recip();
        let turn = (v[0] * a[1] - a[0] * v[1]) * cubed;
        let radial = T::splat(-3.0) * turn / squared;
        let rows = [turn - curvature, mass * (v[0] * a[0] + v[1] * a[1])];
        let by_v = [
            [a[1] * cubed + radial * v[0], radial * v[1] - a[0] * cubed],
            [mass * a[0], mass * a[1]],
        ];
        let by_a = [[-(v[1] * cubed), v[0] * cubed], [mass * v[0], mass * v[1]]];
        (rows, by_v, by_a)
    }
}

impl System<2> for Particle {
    type Unknown<T: Scalar> = [T; 2];
    type Constants<T: Scalar> = [T; 3];
    type Known<T: Scalar> = [T; 2];
    type Motion<T: Scalar> = [T; 2];

    const NAME: &'static str = "Particle";
    const COORDINATES: [Quantity; 2] = [
        Quantity {
            name: "x",
            doc: "position along x [m]",
        },
        Quantity {
            name: "y",
            doc: "position along y [m]",
        },
    ];
    const PARAMETERS: &'static [Quantity] = &[
        Quantity {
            name: "mass",
            doc: "mass [kg]",
        },
        Quantity {
            name: "curvature",
            doc: "curvature [1/m]",
        },
    ];
    const OBSERVABLES: &'static [Quantity] = &[Quantity {
        name: "speed",
        doc: "speed [m/s]",
    }];

    fn parameter(&self, index: usize) -> Option<f64> {
        [self.mass, self.curvature].get(index).copied()
    }

    fn parameter_mut(&mut self, index: usize) -> Option<&mut f64> {
        [&mut self.mass, &mut self.curvature].into_iter().nth(index)
    }

    fn constants<T: Scalar>(&self, h: T) -> [T; 3] {
        [h.recip(), T::splat(0.5) / h, (h * h).recip()]
    }

    fn known<T: Scalar>(&self, constants: &[T; 3], leg: &Leg<T, 2>) -> [T; 2] {
        leg.d.map(|d| d * constants[0])
    }

    fn residual<T: Scalar>(&self, c: &[T; 3], known: &[T; 2], z: &[T; 2]) -> Linearization<T, [T; 2]> {
        let v = core::array::from_fn(|i| known[i] + z[i] * c[1]);
        let (rows, by_v, by_a) = self.rows(v, z.map(|z| z * c[2]));
        let jacobian =
            core::array::from_fn(|i| core::array::from_fn(|j| by_v[i][j] * c[1] + by_a[i][j] * c[2]));
        Linearization { rows, jacobian }
    }

    fn unknown<T: Scalar>(&self, e: &[T; 2], _: &[T]) -> [T; 2] {
        *e
    }

    fn second_difference<T: Scalar>(&self, _: &[T; 3], _: &[T; 2], z: &[T; 2]) -> [T; 2] {
        *z
    }

    fn point<T: Scalar>(&self, c: &[T; 3], known: &[T; 2], leg: &Leg<T, 2>, e: &[T; 2]) -> Point<T, 2> {
        let v = core::array::from_fn(|i| known[i] + e[i] * c[1]);
        Point {
            q: leg.q,
            v,
            a: e.map(|e| e * c[2]),
        }
    }

    fn force<T: Scalar>(&self, c: &[T; 3], _: &[T; 2], _: &Leg<T, 2>, e: &[T; 2]) -> [T; 2] {
        e.map(|e| T::splat(self.mass) * e * c[2])
    }

    fn lagrangian<T: Scalar>(&self, _: &[T; 2], v: &[T; 2]) -> T {
        T::splat(self.mass / 2.0) * (v[0] * v[0] + v[1] * v[1])
    }

    fn discrete_lagrangian<T: Scalar>(&self, h: T, leg: &Leg<T, 2>) -> T {
        self.lagrangian(&leg.q, &leg.d.map(|d| d / h))
    }

    fn energy<T: Scalar>(&self, q: &[T; 2], v: &[T; 2]) -> T {
        self.lagrangian(q, v)
    }

    fn observe<T: Scalar>(&self, point: &Point<T, 2>, out: &mut [T]) {
        out[0] = (point.v[0] * point.v[0] + point.v[1] * point.v[1]).sqrt();
    }

    fn continuous<T: Scalar>(&self, point: &Point<T, 2>, _: &[T]) -> Linearization<T, [T; 2]> {
        let (rows, _, jacobian) = self.rows(point.v, point.a);
        Linearization { rows, jacobian }
    }

    fn continuous_force<T: Scalar>(&self, point: &Point<T, 2>) -> [T; 2] {
        point.a.map(|a| T::splat(self.mass) * a)
    }
}

/// A point on the line whose acceleration is `√(1 - q)`: no step leads on from `q > 1`.
///
/// Its equation is linear in the acceleration and has been solved beforehand: there is nothing left to iterate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cliff;

impl System<1> for Cliff {
    type Unknown<T: Scalar> = [T; 0];
    type Constants<T: Scalar> = [T; 1];
    type Known<T: Scalar> = [T; 1];
    type Motion<T: Scalar> = [T; 1];

    const NAME: &'static str = "Cliff";
    const COORDINATES: [Quantity; 1] = [Quantity { name: "x", doc: "" }];
    const PARAMETERS: &'static [Quantity] = &[];
    const OBSERVABLES: &'static [Quantity] = &[];

    fn parameter(&self, _: usize) -> Option<f64> {
        None
    }

    fn parameter_mut(&mut self, _: usize) -> Option<&mut f64> {
        None
    }

    fn constants<T: Scalar>(&self, h: T) -> [T; 1] {
        [h]
    }

    fn known<T: Scalar>(&self, constants: &[T; 1], leg: &Leg<T, 1>) -> [T; 1] {
        [(T::splat(1.0) - leg.q[0]).sqrt() * constants[0] * constants[0]]
    }

    fn residual<T: Scalar>(&self, _: &[T; 1], _: &[T; 1], _: &[T; 0]) -> Linearization<T, [T; 0]> {
        Linearization {
            rows: [],
            jacobian: [],
        }
    }

    fn unknown<T: Scalar>(&self, _: &[T; 1], _: &[T]) -> [T; 0] {
        []
    }

    fn second_difference<T: Scalar>(&self, _: &[T; 1], known: &[T; 1], _: &[T; 0]) -> [T; 1] {
        *known
    }

    fn point<T: Scalar>(&self, h: &[T; 1], _: &[T; 1], leg: &Leg<T, 1>, e: &[T; 1]) -> Point<T, 1> {
        let v = (leg.d[0] + T::splat(0.5) * e[0]) / h[0];
        Point {
            q: leg.q,
            v: [v],
            a: [e[0] / (h[0] * h[0])],
        }
    }

    fn force<T: Scalar>(&self, _: &[T; 1], _: &[T; 1], _: &Leg<T, 1>, _: &[T; 1]) -> [T; 1] {
        [T::splat(0.0)]
    }

    fn lagrangian<T: Scalar>(&self, _: &[T; 1], v: &[T; 1]) -> T {
        v[0] * v[0]
    }

    fn discrete_lagrangian<T: Scalar>(&self, h: T, leg: &Leg<T, 1>) -> T {
        leg.d[0] * leg.d[0] / (h * h)
    }

    fn energy<T: Scalar>(&self, _: &[T; 1], v: &[T; 1]) -> T {
        v[0] * v[0]
    }

    fn observe<T: Scalar>(&self, _: &Point<T, 1>, _: &mut [T]) {}

    fn continuous<T: Scalar>(&self, point: &Point<T, 1>, _: &[T]) -> Linearization<T, [T; 1]> {
        let row = point.a[0] - (T::splat(1.0) - point.q[0]).sqrt();
        Linearization {
            rows: [row],
            jacobian: [[T::splat(1.0)]],
        }
    }

    fn continuous_force<T: Scalar>(&self, _: &Point<T, 1>) -> [T; 1] {
        [T::splat(0.0)]
    }
}
