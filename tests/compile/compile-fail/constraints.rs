//! Constraints, their orders and their counts, displacements, forces and factors.

/// Factors that cannot be divided out.
mod branch {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y, z);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        kinematic = [ddot(x) * dot(x), ddot(y) * dot(y), ddot(x)];
        variational = [];
        branch = [divide(ddot(x)), divde(dot(y)), dot(x)];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// A factor for one of two rows.
mod branch_count {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        kinematic = [ddot(x) * dot(x), ddot(y) * dot(y)];
        variational = [];
        branch = divide(dot(x));
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// A `branch` that is no factor of its constraint.
mod branch_of_another {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
        kinematic = dot(x) * ddot(y) - x;
        constraint_forces = [(0, 1)];
        branch = divide(dot(x));
    }]
    pub struct Particle;
}

/// Chetaev's rule without a kinematic constraint.
mod chetaev_alone {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        holonomic = x - y;
        variational = chetaev;
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Fields with another number of components than coordinates.
mod components {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        kinematic = ddot(x);
        variational = [(0, 1, 0)];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Two constraints with the same force.
mod dependent_constraints {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        holonomic = [x - y, 2 * y - 2 * x];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Two forces in the same direction.
mod dependent_forces {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y, z);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        kinematic = [ddot(x) + x, ddot(y) + y];
        constraint_forces = [(1, 0, -1), (-2, 0, 2)];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// A field whose components are a list of fields.
mod field_without_tuple {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        kinematic = ddot(x);
        variational = (dot(x), dot(y));
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// One force for two constraints.
mod forces_of_some {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y, z);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        holonomic = x.powi(2) + y.powi(2) - 1;
        nonholonomic = dot(z) - y * dot(x);
        constraint_forces = [(1, 0, 0)];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// A velocity in a constraint of positions.
mod holonomic_of_velocities {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        holonomic = x.powi(2) + dot(y).powi(2) - 1;
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Kinematic constraints without variational ones.
mod kinematic_alone {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        kinematic = dot(x) * ddot(y) - ddot(x) * dot(y);
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Constraints of positions and of velocities among those of accelerations.
mod kinematic_of_lower_order {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y, z);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        kinematic = [x.powi(2) + y.powi(2) - 1, dot(x) + x, ddot(z) - ddot(z) + dot(z)];
        variational = [];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// An acceleration in a constraint of velocities, and one of positions.
mod nonholonomic_of_accelerations {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        nonholonomic = [ddot(x) - y, x - y];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// More constraints than coordinates.
mod too_many_constraints {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        holonomic = x - y;
        nonholonomic = [dot(x) - y, dot(y) - x];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Virtual displacements and constraint forces in one declaration.
mod variational_and_forces {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        kinematic = ddot(x);
        variational = [(0, 1)];
        constraint_forces = [(1, 0)];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// More equations than coordinates.
mod wrong_count {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        kinematic = dot(x) * ddot(y) - ddot(x) * dot(y);
        variational = [(1, 0), (0, 1)];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Fewer forces than kinematic constraints.
mod wrong_count_of_forces {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        kinematic = [ddot(x), ddot(y)];
        constraint_forces = [(1, 0)];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

fn main() {}
