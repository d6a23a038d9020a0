//! Names.

/// Names that have a meaning already.
mod name_clash {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta, dot);
        let theta = 2;
        let mass = 3;
        lagrangian = dot(theta).powi(2);
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// A name that is nearly that of a coordinate, and one that is nearly that of a parameter.
mod unknown_name {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = mas * length.powi(2) / 2 * dot(theta).powi(2) + mass * thetta.cos();
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// A `let` below its use.
mod defined_too_late {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = kinetic + mass * theta.cos();
        let kinetic = mass / 2 * dot(theta).powi(2);
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// A `let` that is more than a name.
mod let_pattern {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        let (a, b) = (1, 2);
        let c: f64 = 3;
        lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// A parameter of a generic type as a number.
mod generic_parameter {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = dot(theta).powi(2) - potential;
    }]
    pub struct Pendulum<P> {
        pub potential: P,
    }
}

/// A macro, which cannot be seen into.
mod macro_call {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = mass * square!(dot(theta));
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

fn main() {}
