//! Maps, and discrete statements.

/// A component of a node that is no coordinate.
mod map_component {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        phi_lagrangian = |q0, q1| (q0, ((q1.x - q0.x) / h, (q1.z - q0.2) / h));
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Maps of no known name.
mod map_name {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        phi_lagrangian = midpiont;
        phi_kinematic = trapezoid;
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Coordinates and derivatives in a map.
mod map_of_the_motion {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        let speed = dot(x);
        phi_lagrangian = |q0, q1| (q0, (x, y));
        phi_kinematic = |q0, q1, q2| (q1, dot(q1), (speed, 0));
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Maps with a wrong number of nodes, vectors and components.
mod map_shape {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        phi_lagrangian = |q0, q1, q2| (q1, (q2 - q0) / h);
        phi_kinematic = |q0, q1, q2| (q1, (q2 - q0) / h);
        phi_variational = |q0, q1, q2| (q1, (q2 - q0) / h, (0, 0, 0));
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// A discrete constraint too many, and one that binds no last node.
mod discrete_count {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        kinematic = ddot(x);
        constraint_forces = [(1, 0)];
        discrete_kinematic = [x[1] - x[0], x[2]];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Expressions of the motion among nodes.
mod discrete_motion {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        let v = dot(x);
        discrete_lagrangian = v * (x[1] - x[0]) / h + y - leg(ddot(x), 0) + x[2] + dot(y);
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

fn main() {}
