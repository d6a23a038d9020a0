//! Constraints of positions and of velocities, alone, together and beside one of second order.

use dsocs_core::dsocs;
use dsocs_tests::declared;

/// A pendulum of unit mass and length in the plane; its rod is a constraint.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
    holonomic = x.powi(2) + y.powi(2) - 1;
}]
pub struct Rod {
    pub gravity: f64,
}

declared! {
    /// The rod with a declared basis of the displacements, of another length than the one that is found.
    pub struct RodWithField {
        pub gravity: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
    holonomic = x.powi(2) + y.powi(2) - 1;
    variational = [((2 + x) * y, -(2 + x) * x)];
}

/// A point on an ellipsoid: there is no basis of the displacements without a zero, so that multipliers are unknown.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - gravity * z;
    holonomic = x.powi(2) + 2 * y.powi(2) + 3 * z.powi(2) - 1;
}]
pub struct Ellipsoid {
    pub gravity: f64,
}

declared! {
    /// The ellipsoid with fields that span the displacements away from `x = 0`.
    pub struct EllipsoidWithFields {
        pub gravity: f64,
    }
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - gravity * z;
    holonomic = x.powi(2) + 2 * y.powi(2) + 3 * z.powi(2) - 1;
    variational = [(2 * y, -x, 0), (3 * z + 2 * y, -x, -x)];
}

declared! {
    /// The ellipsoid with the forms of the forces, in other units.
    pub struct EllipsoidWithForce {
        pub gravity: f64,
    }
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - gravity * z;
    holonomic = x.powi(2) + 2 * y.powi(2) + 3 * z.powi(2) - 1;
    constraint_forces = [(10 * x, 20 * y, 30 * z)];
}

/// A mass matrix that depends on the position, and a constraint without a constant in its form.
#[dsocs {
    coordinates(x, y: [2]);
    lagrangian = (dot(x).powi(2) + dot(y[0]).powi(2) + (1 + x.powi(2)) * dot(y[1]).powi(2)) / 2 - y[0];
    holonomic = x.powi(2) + y[0].powi(2) + (y[1] - x).powi(2) - 1;
}]
pub struct VariableMass;

/// The nonholonomic particle in a harmonic potential.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - (x.powi(2) + y.powi(2)) / 2;
    nonholonomic = dot(z) - y * dot(x);
}]
pub struct Nonholonomic;

declared! {
    /// The nonholonomic particle with a declared basis of the displacements.
    pub struct NonholonomicWithFields;
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - (x.powi(2) + y.powi(2)) / 2;
    nonholonomic = dot(z) - y * dot(x);
    variational = [(1, dot(x), y), (0, 1 + x.powi(2), 0)];
}

/// Affine and nonlinear in the velocities: a particle in a stream that keeps its speed (the first by d'Alembert's rule, the second
/// by Chetaev's).
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - x * z;
    nonholonomic = [dot(z) - y * dot(x) - x, dot(x).powi(2) + dot(y).powi(2) - 1];
}]
pub struct Nonlinear;

/// A constraint of every order.
#[dsocs {
    coordinates(x, y, z, u);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) + dot(u).powi(2)) / 2 - y;
    holonomic = x.powi(2) + y.powi(2) - 1;
    nonholonomic = dot(z) - x * dot(u);
    kinematic = ddot(u) + dot(u) + u.powi(3) - x;
    variational = chetaev;
}]
pub struct Mixed;

declared! {
    /// The mixed system with the force of Chetaev's rule written out.
    pub struct MixedWithForce;
    coordinates(x, y, z, u);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) + dot(u).powi(2)) / 2 - y;
    holonomic = x.powi(2) + y.powi(2) - 1;
    nonholonomic = dot(z) - x * dot(u);
    kinematic = ddot(u) + dot(u) + u.powi(3) - x;
    constraint_forces = [(0, 0, 0, 1)];
}
