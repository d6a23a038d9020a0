//! A system declared by vectors has the bits of the one declared by components, and its motions are those of
//! closed forms.

use dsocs_core::taylor::Tolerance;
use dsocs_core::{Start, Stepper};
use dsocs_tests::declared;
use dsocs_tests::text::{Flow, System, TaylorFlow};

declared! {
    /// A charged spherical pendulum in air with anisotropic drag, by vectors.
    struct Charged {
        mass: f64,
        charge: f64,
        gravity: [f64; 3],
        field: [f64; 3],
        drag: [[f64; 3]; 3],
    }
    coordinates(x: [3]);
    let v = dot(x);
    lagrangian = mass * v.norm_squared() / 2 + mass * gravity.inner(x);
    external_forces = charge * v.cross(field) - drag * v;
    holonomic = x.norm() - 1;
}

declared! {
    /// The charged spherical pendulum by components.
    struct ByComponents {
        mass: f64,
        charge: f64,
        gravity: [f64; 3],
        field: [f64; 3],
        drag: [[f64; 3]; 3],
    }
    coordinates(x: [3]);
    let v = |i| dot(x[i]);
    let dragged = |i| sum(0..3, |j| drag[i][j] * v(j));
    let turned = |i, j| charge * (v(i) * field[j] - v(j) * field[i]);
    lagrangian = mass * (v(0).powi(2) + v(1).powi(2) + v(2).powi(2)) / 2
        + mass * (gravity[0] * x[0] + gravity[1] * x[1] + gravity[2] * x[2]);
    external_forces = [turned(1, 2) - dragged(0), turned(2, 0) - dragged(1), turned(0, 1) - dragged(2)];
    holonomic = (x[0].powi(2) + x[1].powi(2) + x[2].powi(2)).sqrt() - 1;
}

declared! {
    /// A free charge in a constant field along the third axis.
    struct Cyclotron {
        mass: f64,
        charge: f64,
        field: f64,
    }
    coordinates(x: [3]);
    lagrangian = mass * dot(x).norm_squared() / 2;
    external_forces = charge * dot(x).cross([0, 0, field]);
}

declared! {
    /// A servo that follows a moving point with the acceleration of a spring: one row of three components, of
    /// second order.
    struct Servo {
        rate: f64,
    }
    coordinates(x: [3]);
    lagrangian = dot(x).norm_squared() / 2 + x[1];
    let away = x - [t.cos(), t.sin(), 0];
    kinematic = ddot(away) + 2 * rate * dot(away) + rate * rate * away;
    variational = chetaev;
}

const CHARGED: Charged = Charged {
    mass: 0.7,
    charge: 1.3,
    gravity: [0.0, 0.6, -9.81],
    field: [0.2, -0.4, 2.0],
    drag: [[0.05, 0.01, 0.0], [0.01, 0.08, 0.0], [0.0, 0.0, 0.02]],
};

/// The bits of the positions of a discrete and of a continuous motion.
fn motions(system: &impl System<3>, start: Start<3>) -> (Vec<[u64; 3]>, [u64; 3]) {
    let bits = |q: &[f64; 3]| q.map(f64::to_bits);
    let discrete = Flow::new(system, 0.01, start).unwrap().until(3.0).unwrap();
    let mut continuous = TaylorFlow::new(system, start, Tolerance::relative(1e-12)).unwrap();
    (
        discrete.nodes.iter().map(|node| bits(&node.q)).collect(),
        bits(&continuous.to(3.0).unwrap().q),
    )
}

#[test]
fn vectors_and_their_components_are_one_system() {
    let Charged {
        mass,
        charge,
        gravity,
        field,
        drag,
    } = CHARGED;
    let by_components = ByComponents {
        mass,
        charge,
        gravity,
        field,
        drag,
    };
    let start = Start::second_order([1.0, 0.0, 0.0], [0.0, 1.5, -0.5]);
    let (discrete, continuous) = motions(&CHARGED, start);
    assert!(discrete.len() > 300);
    assert!((discrete, continuous) == motions(&by_components, start));
}

#[test]
fn a_charge_turns_about_the_field() {
    let system = Cyclotron {
        mass: 2.0,
        charge: 3.0,
        field: 0.8,
    };
    // m v' = q v × b
    let rate = system.charge * system.field / system.mass;
    let until: f64 = 7.0;
    let (sin, cos) = (rate * until).sin_cos();
    let [v0, v1, v2] = [0.4, -1.1, 0.3];
    let exact = [
        (v0 * sin + v1 * (1.0 - cos)) / rate,
        (v1 * sin - v0 * (1.0 - cos)) / rate,
        v2 * until,
    ];
    let apart = |q: [f64; 3]| {
        let parts = q.iter().zip(exact).map(|(q, exact)| (q - exact).abs());
        parts.fold(0.0, f64::max)
    };
    let start = Start::second_order([0.0; 3], [v0, v1, v2]);
    let mut taylor = TaylorFlow::new(&system, start, Tolerance::relative(1e-15)).unwrap();
    assert!(apart(taylor.to(until).unwrap().q) < 1e-14);
    let errors = [0.02, 0.01].map(|h| apart(Flow::new(&system, h, start).unwrap().to(until).unwrap().q));
    let order = (errors[0] / errors[1]).log2();
    assert!((order - 2.0).abs() < 0.02, "{errors:?}");
}

#[test]
fn a_row_that_is_a_vector_binds_each_of_its_components() {
    let system = Servo { rate: 4.0 };
    // critically damped: within e^-40 of the moving point
    let last = Flow::new(&system, 1e-3, Start::second_order([0.0; 3], [0.0; 3]))
        .unwrap()
        .to(10.0)
        .unwrap();
    let target = [10.0_f64.cos(), 10.0_f64.sin(), 0.0];
    for (q, target) in last.q.iter().zip(target) {
        assert!((q - target).abs() < 1e-5, "{last:?}");
    }
    // the forces at the last node: the point's acceleration less gravity
    for (force, expected) in last.force.iter().zip([-target[0], -target[1] - 1.0, 0.0]) {
        assert!((force - expected).abs() < 1e-4, "{last:?}");
    }
}
