//! Expressions, functions and sums.

/// Wrong numbers of arguments.
mod arguments {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        let a = theta.sin(2) + theta.powi(mass) + theta.atan2() + dot(theta, theta);
        lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// Comparisons and choices that have no value.
mod comparison {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        let a = theta < 1;
        let b = if theta < 1 { 2 };
        let c = if theta == 1 { 2 } else { 3 };
        lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// Functions of the declaration that are used as numbers, before they are known, or with other arguments.
mod declared_function {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta: [8]);
        let angle = |i| if i == 0 { 0 } else { theta[i] + angle(i - 1) };
        let height = |i| lengths[i] * theta[i].cos() + offset;
        lagrangian = angle(3) + height(0) + height(1, 2) + height + speed(3) + height(1);
        let speed = |i| dot(theta[i]);
        phi_lagrangian = |q0, q1| (q0 * speed(1), (q1 - q0) / h);
    }]
    pub struct Chain {
        pub lengths: [f64; 8],
    }
}

/// Functions that are methods, and methods without derivative.
mod function_call {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        let a = sin(theta) + theta.floor() + f64::sine(theta) + theta(2);
        lagrangian = mass * length.powi(2) / 2 * dot(theta).powi(2) + mass * theta.cos();
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// Values that are no numbers.
mod numbers {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = mass * "1" + 1f32 * dot(theta) ^ 2 + (theta, mass) + teeth * dot(theta);
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub teeth: usize,
    }
}

/// Derivatives, powers and equations in the notation of other languages.
mod other_ways_of_writing {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = (x_dot**2 + ydot.powi(2)) / 2 + lenght * dot(x);
        holonomic = x - y = 0;
        forces = [(1, -1)];
    }]
    pub struct Particle {
        pub n: f64,
        pub length: f64,
    }
}

/// Sums without a range or a closure, over a range that varies, and with names that are taken.
mod sum {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, theta: [8]);
        let a = sum(8, |i| theta[i]);
        let b = sum(0..count, |i| theta[i]);
        let c = sum(0..8, theta);
        let d = sum(0..8, |x| theta[x]);
        let e = sum(0..8, |i| thta[i]);
        lagrangian = a + b + c + d + e;
    }]
    pub struct Chain {
        pub count: usize,
    }
}

/// The step in the continuous system.
mod step_outside_of_maps {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        lagrangian = mass * dot(theta).powi(2) / h;
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

/// Derivatives beyond the third.
mod fourth_order {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        let acceleration = ddot(x);
        kinematic = dot(dddot(x)) + ddot(acceleration * y);
        variational = [(1, 0)];
    }]
    pub struct Particle {
        pub mass: f64,
    }
}

/// Accelerations in the Lagrangian.
mod lagrangian_with_acceleration {
    use dsocs_core::dsocs;

    #[dsocs {
        coordinates(theta);
        let jerky = 2 * ddot(theta);
        lagrangian = dot(theta).powi(2) + jerky;
    }]
    pub struct Pendulum {
        pub mass: f64,
        pub length: f64,
    }
}

fn main() {}
