//! Arrays of coordinates.

/// Fields whose components have another shape than the coordinates.
mod array_components {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, theta: [3]);
        lagrangian = dot(x).powi(2) + sum(0..3, |i| dot(theta[i]).powi(2));
        kinematic = ddot(x) + dot(theta[0]);
        variational = [(1, [0; 2]), (0, theta[1]), (0, 1, 2)];
        phi_lagrangian = |q0, q1| ((q0.x, q0.theta[3]), (q1 - q0.theta) / h);
    }]
    pub struct Chain;
}

/// Indices out of range, that vary with the motion, that are missing, or that are one too many.
mod array_index {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, theta: [8]);
        let kinetic = sum(0..8, |i| masses[i] / 2 * dot(theta[i]).powi(2)) + dot(theta).powi(2);
        let springs = sum(0..8, |i| (theta[i + 1] - theta[i]).powi(2));
        lagrangian = kinetic - springs - theta[x] - x[0];
    }]
    pub struct Chain {
        pub masses: [f64; 7],
    }
}

/// Arrays of coordinates whose length is no literal, or in another place.
mod array_length {
    use dsocs_core::dsocs;

    const LINKS: usize = 8;

    #[dsocs {
        coordinates(theta: [LINKS], phi: [f64; 3], psi[2]);
        lagrangian = sum(0..8, |i| dot(theta[i]).powi(2));
    }]
    pub struct Chain;
}

/// The coordinates of an array have names.
mod array_name {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta: [3]);
        let theta_2 = dot(theta[2]);
        lagrangian = sum(0..3, |i| masses[i] * dot(theta[i]).powi(2)) + theta_2;
    }]
    pub struct Chain {
        pub masses: [f64; 3],
        pub masses_0: f64,
    }
}

/// Products and sums of vectors that have no meaning, and vectors in the place of numbers.
mod vectors {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x: [3], y: [2]);
        let speed = (dot(x) * dot(x)).sqrt();
        let apart = x - y;
        let shifted = x + 1;
        let length = x.abs() + x.dot(x);
        let turned = y.cross(field) + field * inertia;
        lagrangian = inertia * dot(x);
        external_forces = (x.norm(), y);
        holonomic = [x - field, y];
        observe = [speed, apart, shifted, length, turned];
    }]
    pub struct Body {
        pub field: [f64; 3],
        pub inertia: [[f64; 3]; 3],
    }
}

fn main() {}
