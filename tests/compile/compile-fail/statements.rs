//! Statements that are missing, stand twice or cannot be read, and items that are no structs with names.

/// A declaration without coordinates.
mod missing_coordinates {
    use dsocs_core::dsocs;

    #[dsocs {
        lagrangian = mass * dot(theta).powi(2);
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// A declaration without a Lagrangian.
mod missing_lagrangian {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// A statement that is there twice.
mod statement_twice {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
        lagrangian = mass * dot(theta).powi(2);
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// A statement that is misspelt.
mod unknown_statement {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangean = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// Syntax errors in two statements.
mod syntax {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        let kinetic = mass * ;
        let potential = mass theta.cos();
        lagrangian = kinetic - potential;
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// Observed names that are no `let`.
mod observe {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
        let energy = dot(theta).powi(2);
        observe = [enery, theta, 2 * energy];
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// Statements that several declarations share.
mod shared {
    use dsocs_core::{dsocs, statements};

    statements! {
        pendulum {
            coordinates(theta);
            lagrangian = dot(theta).powi(2) * lenght - thta;
        }
    }

    #[dsocs {
        use pendulum;
    }]
    pub struct WithAMistakeInThem {
        pub length: f64,
    }

    #[dsocs {
        use pendulum;
        coordinates(theta);
    }]
    pub struct Twice {
        pub lenght: f64,
        pub thta: f64,
    }

    #[dsocs {
        use pendulum::{all, others};
    }]
    pub struct Tree;

    #[dsocs {
        use pendulum as it;
    }]
    pub struct Renamed;
}

/// Shared statements without a name.
mod not_shared {
    dsocs_core::statements! {
        coordinates(theta);
        lagrangian = dot(theta).powi(2);
    }
}

/// An enumeration.
mod enumeration {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = dot(theta).powi(2);
    }]
    pub enum Pendulum {
        Swinging,
    }
}

/// A function.
mod function {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = dot(theta).powi(2);
    }]
    pub fn pendulum() {}
}

/// A struct without names.
mod tuple_struct {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = dot(theta).powi(2);
    }]
    pub struct Pendulum(pub f64);
}

fn main() {}
