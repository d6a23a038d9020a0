//! More coordinates, several rows, forces instead of fields, and a factor on one row of two.

use dsocs_core::{Real, dsocs};
use dsocs_tests::independent::{Declaration, Number};

/// Two rows and one field in space.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) - z;
    kinematic = [ddot(x) + dot(y) * dot(z) - x, ddot(z) * dot(x) - dot(y) * ddot(y)];
    variational = [(dot(x), dot(y) + 1, dot(z))];
}]
pub struct Two {
    pub mass: f64,
}

impl Declaration<3> for Two {
    fn lagrangian<R: Number>(&self, q: [R; 3], v: [R; 3]) -> R {
        (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * (self.mass / 2.0) - q[2]
    }

    fn kinematic<R: Number>(&self, q: [R; 3], v: [R; 3], a: [R; 3]) -> Vec<R> {
        vec![a[0] + v[1] * v[2] - q[0], a[2] * v[0] - v[1] * a[1]]
    }

    fn variational<R: Number>(&self, _: [R; 3], v: [R; 3], _: [R; 3]) -> Vec<[R; 3]> {
        vec![[v[0], v[1] + 1.0, v[2]]]
    }
}

/// One row and one force, and so two fields, which the macro finds. Any two fields that span the annihilator
/// will do; the comparison is with `(0, 1, 0)` and `(−dot(y), 0, 1)`, from elimination with the pivot 1.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) + x * y * z;
    kinematic = ddot(x) + dot(y) * ddot(z) + dot(x).powi(3);
    constraint_forces = [(1, 0, dot(y))];
}]
pub struct Forces {
    pub mass: f64,
}

impl Declaration<3> for Forces {
    fn lagrangian<R: Number>(&self, q: [R; 3], v: [R; 3]) -> R {
        (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * (self.mass / 2.0) + q[0] * q[1] * q[2]
    }

    fn kinematic<R: Number>(&self, _: [R; 3], v: [R; 3], a: [R; 3]) -> Vec<R> {
        vec![a[0] + v[1] * a[2] + v[0] * v[0] * v[0]]
    }

    fn variational<R: Number>(&self, _: [R; 3], v: [R; 3], _: [R; 3]) -> Vec<[R; 3]> {
        let (zero, one) = (R::from(0.0), R::from(1.0));
        vec![[zero, one, zero], [-v[1], zero, one]]
    }
}

/// Two rows, of which the first is divided.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
    let factor = dot(x) + 4;
    kinematic = [(ddot(y) + z) * factor + dot(z) * factor.sinh(), ddot(z) + x];
    variational = [(1, dot(y), dot(x))];
    branch = [divide(factor), _];
}]
pub struct Divided {
    pub mass: f64,
}

impl Declaration<3> for Divided {
    fn lagrangian<R: Number>(&self, _: [R; 3], v: [R; 3]) -> R {
        (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * (self.mass / 2.0)
    }

    fn kinematic<R: Number>(&self, q: [R; 3], v: [R; 3], a: [R; 3]) -> Vec<R> {
        vec![
            (a[1] + q[2]) * (v[0] + 4.0) + v[2] * (v[0] + 4.0).sinh(),
            a[2] + q[0],
        ]
    }

    fn divide<R: Number>(&self, _: [R; 3], v: [R; 3]) -> Vec<Option<R>> {
        vec![Some(v[0] + 4.0), None]
    }

    fn variational<R: Number>(&self, _: [R; 3], v: [R; 3], _: [R; 3]) -> Vec<[R; 3]> {
        vec![[R::from(1.0), v[1], v[0]]]
    }
}
