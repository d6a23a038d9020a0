//! External forces move the system, keep the order 2 with every map of order 2, and are not counted as
//! constraint forces.

use dsocs_core::geometry::{external_forces, power};
use dsocs_core::taylor::Tolerance;
use dsocs_core::{Composition, Point, Real, Start, Stepper, Symmetry, dsocs};
use dsocs_tests::declared;
use dsocs_tests::fit::{order, slope};
use dsocs_tests::motion::{STEPS, assert_position, continuous, discrete, distance};
use dsocs_tests::plan::Plan;
use dsocs_tests::text::{ComposedFlow, Flow, System, TaylorFlow};

use dsocs_tests::dop853;

/// Declares a damped oscillator with a map.
macro_rules! damped {
    ($(#[$doc:meta])* $name:ident, $($statement:tt)*) => {
        declared! {
            $(#[$doc])*
            struct $name {
                zeta: f64,
            }
            coordinates(x);
            lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
            external_forces = (-2 * zeta * dot(x),);
            $($statement)*
        }
    };
}

damped! {
    /// With the map that is taken where none is declared, the paper's.
    Damped,
}
damped! {
    /// With the midpoint.
    DampedMidpoint, phi_lagrangian = midpoint;
}
damped! {
    /// With the trapezoid.
    DampedTrapezoid, phi_lagrangian = trapezoid;
}
damped! {
    /// With a formula of one's own, a third of the way along the leg: of order 1 in the force, as in a mass matrix that varies.
    DampedAside, phi_lagrangian = |q0, q1| ((2 * q0 + q1) / 3, (q1 - q0) / h);
}

/// A motion by the method of Dormand and Prince.
fn by_hand<const N: usize>(
    rate: impl Fn(f64, [f64; N]) -> [f64; N],
    state: [f64; N],
    until: f64,
) -> [f64; N] {
    dop853::integrate_from(rate, (0.0, state), until, 1e-14)
}

#[test]
fn a_damped_oscillator_is_its_closed_form_with_every_map() {
    let (zeta, [x0, v0]) = (0.15, [1.0, 0.3]);
    let ring = (1.0_f64 - zeta * zeta).sqrt();
    let known = |t: f64| {
        let (sin, cos) = (ring * t).sin_cos();
        (-zeta * t).exp() * (x0 * cos + (v0 + zeta * x0) / ring * sin)
    };
    let start = Start::second_order([x0], [v0]);
    assert_position("default", &Damped { zeta }, start, 10.0, &[known(10.0)], 3e-15);
    assert_position(
        "midpoint",
        &DampedMidpoint { zeta },
        start,
        10.0,
        &[known(10.0)],
        3e-15,
    );
    assert_position(
        "trapezoid",
        &DampedTrapezoid { zeta },
        start,
        10.0,
        &[known(10.0)],
        3e-15,
    );
    // an evaluation point that is not symmetric lowers the order
    let found = order("aside", &STEPS, |h| {
        (discrete(&DampedAside { zeta }, h, start, 10.0).q[0] - known(10.0)).abs()
    });
    assert!((found - 1.0).abs() < 0.1, "{found}");
    // no constraint acts, so no constraint force is reported
    let node = discrete(&Damped { zeta }, 0.01, start, 3.0);
    assert!(node.force[0].abs() < 1e-15, "{node:?}");
    assert!((Damped { zeta }.external_forces(0.0, &[1.0], &[2.0])[0] + 0.6).abs() < 1e-15);
}

/// A body in wind that changes, with quadratic drag: a function of the user's, of velocities and of the time.
#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - 9.81 * mass * y;
    let u = dot(x) - gusts.wind(t);
    let v = dot(y);
    external_forces = (-gusts.drag(u, v) * u, -gusts.drag(u, v) * v);
}]
struct Kite {
    mass: f64,
    gusts: Gusts,
}

/// Wind with gusts, and the drag in it.
struct Gusts {
    coefficient: f64,
    mean: f64,
}

impl Gusts {
    /// The wind at a time.
    fn wind<R: Real>(&self, t: R) -> R {
        (t * 0.9).sin() * 4.0 + self.mean
    }

    /// Force over velocity.
    fn drag<R: Real>(&self, u: R, v: R) -> R {
        (u * u + v * v + 1e-4).sqrt() * self.coefficient
    }
}

/// Friction as a function of the user's.
fn friction<R: Real>(v: R) -> R {
    (v * 5.0).tanh() * 0.2 + v * 0.05
}

/// A pendulum with dry friction in its joint.
#[dsocs {
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + theta.cos();
    external_forces = (-friction(dot(theta)),);
}]
struct Joint;

#[test]
fn a_force_may_be_a_function_of_the_users() {
    let kite = Kite {
        mass: 0.5,
        gusts: Gusts {
            coefficient: 0.1,
            mean: 3.0,
        },
    };
    let rate = |t: f64, [_, _, u, v]: [f64; 4]| {
        let (w, gusts) = (u - kite.gusts.wind(t), &kite.gusts);
        let drag = gusts.drag(w, v) / 0.5;
        [u, v, -drag * w, -drag * v - 9.81]
    };
    let [x, y, ..] = by_hand(rate, [0.0, 2.0, 1.0, 3.0], 4.0);
    let start = Start::second_order([0.0, 2.0], [1.0, 3.0]);
    assert_position("kite", &kite, start, 4.0, &[x, y], 1e-11);
    let rate = |_: f64, [theta, v]: [f64; 2]| [v, -theta.sin() - friction(v)];
    let [theta, _] = by_hand(rate, [1.0, 0.0], 4.0);
    assert_position(
        "joint",
        &Joint,
        Start::second_order([1.0], [0.0]),
        4.0,
        &[theta],
        1e-11,
    );
}

declared! {
    /// A double pendulum with friction in both joints: a mass matrix that depends on the angles.
    struct Links {
        friction: f64,
        push: f64,
    }
    coordinates(alpha, beta);
    let kinetic = dot(alpha).powi(2) + dot(beta).powi(2) / 2 + (alpha - beta).cos() * dot(alpha) * dot(beta);
    lagrangian = kinetic + 2 * alpha.cos() + beta.cos();
    let between = friction * (dot(beta) - dot(alpha));
    external_forces = (-friction * dot(alpha) + between, -between + push * t.sin());
}

#[test]
fn forces_beside_a_mass_matrix_that_varies() {
    let links = Links {
        friction: 0.3,
        push: 0.5,
    };
    let rate = |t: f64, [alpha, beta, u, v]: [f64; 4]| {
        let (sin, cos) = (alpha - beta).sin_cos();
        let between = 0.3 * (v - u);
        let p = -sin * v * v - 2.0 * alpha.sin() - 0.3 * u + between;
        let q = sin * u * u - beta.sin() - between + 0.5 * t.sin();
        let determinant = 2.0 - cos * cos;
        [
            u,
            v,
            (p - cos * q) / determinant,
            (2.0 * q - cos * p) / determinant,
        ]
    };
    let [alpha, beta, ..] = by_hand(rate, [1.5, 0.5, 0.0, -0.4], 5.0);
    let start = Start::second_order([1.5, 0.5], [0.0, -0.4]);
    assert_position("links", &links, start, 5.0, &[alpha, beta], 1e-11);
}

declared! {
    /// A bob on a rod, in air: the multiplier is the rod's force alone.
    struct Bob {
        drag: f64,
        wind: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
    holonomic = (x.powi(2) + y.powi(2) - 1) / 2;
    external_forces = (-drag * dot(x) + wind, -drag * dot(y));
}

declared! {
    /// A skate with friction, pushed along a plane: a nonholonomic constraint, at the midpoint.
    struct Skate {
        drag: f64,
    }
    coordinates(x, y, theta);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(theta).powi(2)) / 2;
    nonholonomic = dot(y) * theta.cos() - dot(x) * theta.sin();
    external_forces = (-drag * dot(x) + 1, -drag * dot(y), -drag * dot(theta) + (2 * t).cos());
}

#[test]
fn constraint_forces_are_those_of_the_constraints_alone() {
    let bob = Bob { drag: 0.4, wind: 2.0 };
    let rate = |_: f64, [theta, v]: [f64; 2]| [v, -9.81 * theta.sin() - 0.4 * v + 2.0 * theta.cos()];
    let start = Start::second_order([0.6, -0.8], [0.8, 0.6]);
    let [theta, v] = by_hand(rate, [0.6_f64.asin(), 1.0], 2.0);
    let (sin, cos) = theta.sin_cos();
    assert_position("bob", &bob, start, 2.0, &[sin, -cos], 1e-12);
    // outwards: the rod pulls with the centrifugal force, the weight and the wind
    let rod = -(v * v + 9.81 * cos + 2.0 * sin);
    let mut flow = TaylorFlow::new(&bob, start, Tolerance::relative(1e-15)).unwrap();
    let node = flow.to(2.0).unwrap();
    assert!((flow.multipliers(&node)[0] - rod).abs() < 1e-11);
    assert!(
        distance(&node.force, &[rod * sin, -rod * cos]) < 1e-11,
        "{node:?}"
    );
    let found = order("rod", &STEPS, |h| {
        let mut flow = Flow::new(&bob, h, start).unwrap();
        let node = flow.until(2.0).unwrap().nodes.pop().unwrap();
        (flow.multipliers(&node)[0] - rod).abs()
    });
    assert!((found - 2.0).abs() < 0.02, "{found}");
}

#[test]
fn forces_beside_a_nonholonomic_constraint() {
    let skate = Skate { drag: 0.3 };
    // along the blade at the rate u, which turns at the rate w
    let rate = |t: f64, [_, _, theta, u, w]: [f64; 5]| {
        let (sin, cos) = theta.sin_cos();
        [u * cos, u * sin, w, -0.3 * u + cos, -0.3 * w + (2.0 * t).cos()]
    };
    let [x, y, theta, ..] = by_hand(rate, [0.0, 0.0, 0.3, 0.7, 0.5], 3.0);
    let (sin, cos) = 0.3_f64.sin_cos();
    let start = Start::second_order([0.0, 0.0, 0.3], [0.7 * cos, 0.7 * sin, 0.5]);
    assert_position("skate", &skate, start, 3.0, &[x, y, theta], 1e-11);
}

declared! {
    /// A particle with a prescribed curvature, pushed along x and braked: a kinematic constraint beside forces.
    struct Braked {
        push: f64,
        drag: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - 0.5;
    variational = [(dot(x), dot(y))];
    external_forces = (push - drag * dot(x), -drag * dot(y));
}

#[test]
fn forces_beside_a_kinematic_constraint() {
    let braked = Braked { push: 0.8, drag: 0.3 };
    // the path turns by half the way; the steering force takes what the push has across the path
    let rate = |_: f64, [_, _, heading, speed]: [f64; 4]| {
        let (sin, cos) = heading.sin_cos();
        [speed * cos, speed * sin, 0.5 * speed, 0.8 * cos - 0.3 * speed]
    };
    let [x, y, ..] = by_hand(rate, [0.0, 0.0, 0.0, 1.5], 2.0);
    let start = Start::second_order([0.0; 2], [1.5, 0.0]);
    assert_position("braked", &braked, start, 2.0, &[x, y], 1e-12);
    // the force is across the path: it does no work, and the external ones do
    let node = continuous(&braked, start, 1.0);
    let [u, v] = node.v;
    assert!((node.force[0] * u + node.force[1] * v).abs() < 1e-13, "{node:?}");
    let point = Point {
        t: 1.0,
        q: node.q,
        v: node.v,
        a: node.a,
    };
    let given = 0.8 * u - 0.3 * (u * u + v * v);
    assert!((power(System::<2>::kernel(&braked), point.any()) - given).abs() < 1e-13);
}

/// A motor with torques from a table in time, linear between the samples.
#[dsocs {
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + theta.cos();
    external_forces = (plan.at(t),);
}]
struct Planned {
    plan: Plan,
}

/// The force of a constraint, as a table for the free system, gives the same nodes: at a node a force of the
/// time alone is the table's value, half from each leg.
#[test]
fn a_table_may_be_what_a_constraint_has_done() {
    declared! {
        struct Servo;
        coordinates(theta);
        lagrangian = dot(theta).powi(2) / 2 + theta.cos();
        kinematic = ddot(theta) + theta - (1.3 * t).sin();
        constraint_forces = [(1,)];
    }
    let (h, start) = (0.05, Start::second_order([0.4], [0.2]));
    let nodes = Flow::new(&Servo, h, start).unwrap().until(10.1).unwrap().nodes;
    let samples = nodes.iter().map(|node| node.force[0]).collect();
    let planned = Planned {
        plan: Plan { h, samples },
    };
    // from the same two nodes
    let same = Start::nodes(nodes[0].q, nodes[1].q);
    let replayed = Flow::new(&planned, h, same).unwrap().until(10.0).unwrap().nodes;
    let apart = nodes
        .iter()
        .zip(&replayed)
        .map(|(one, other)| (one.q[0] - other.q[0]).abs());
    let apart = apart.fold(0.0, f64::max);
    println!("apart by {apart:.1e}");
    assert!(apart < 1e-11, "{apart:e}");
    assert!(replayed.iter().skip(1).all(|node| node.force[0].abs() < 1e-12));
}

/// The map distributes the discrete force at a node: half comes from each leg.
#[test]
fn forces_come_in_halves_from_both_legs() {
    let damped = Damped { zeta: 0.25 };
    let triple = dsocs_core::geometry::Triple {
        leg: dsocs_core::OwnedLeg {
            t: 0.0,
            q: vec![0.5],
            d: vec![0.1],
        },
        e: vec![0.02],
    };
    // the paper's halves: at the node, with the velocity of either leg
    let force = external_forces(System::<1>::kernel(&damped), 0.1, &triple)[0];
    assert!((force + 0.5 * (1.0 + 1.2) / 2.0).abs() < 1e-15, "{force}");
    let midpoint = external_forces(System::<1>::kernel(&DampedMidpoint { zeta: 0.25 }), 0.1, &triple)[0];
    assert!((midpoint - force).abs() < 1e-15);
}

declared! {
    /// A pendulum with viscous friction, pushed.
    struct Viscous {
        friction: f64,
    }
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + theta.cos();
    external_forces = (-friction * dot(theta) + (1.3 * t).cos() / 2,);
}

/// Forces that are linear in the velocity have the same value at a node whatever the legs: the mean of both
/// legs' velocities is the slope of the parabola. Other forces do not.
#[test]
fn what_can_be_composed_beside_forces() {
    assert_eq!(<Planned as dsocs_core::System<1>>::SYMMETRY, Symmetry::AnyLegs);
    assert_eq!(System::<1>::symmetry(&Damped { zeta: 0.1 }), Symmetry::AnyLegs);
    assert_eq!(<Joint as dsocs_core::System<1>>::SYMMETRY, Symmetry::Momenta);
    assert_eq!(
        System::<2>::symmetry(&Links {
            friction: 0.1,
            push: 0.0
        }),
        Symmetry::Momenta
    );
    let start = Start::second_order([1.0], [0.0]);
    let viscous = Viscous { friction: 0.2 };
    let rate = |t: f64, [theta, v]: [f64; 2]| [v, -theta.sin() - 0.2 * v + 0.5 * (1.3 * t).cos()];
    let [truth, _] = by_hand(rate, [1.0, 0.0], 8.0);
    for (method, parts) in [
        (Composition::SUZUKI_4, [8, 12, 16, 24]),
        (Composition::KAHAN_LI_6, [5, 6, 8, 10]),
        (Composition::KAHAN_LI_8, [4, 5, 6, 8]),
    ] {
        let steps = parts.map(|parts| f64::from(parts).recip());
        let errors = steps.map(|h| {
            let mut flow = ComposedFlow::new(&viscous, h, method, start).unwrap();
            (flow.to(8.0).unwrap().q[0] - truth).abs()
        });
        let found = slope(&steps, &errors);
        println!("{method}: {found:.3}, {errors:?}");
        let order = f64::from(method.order());
        assert!(
            (found - order).abs() < 0.05 * order,
            "{method}: {found}, {errors:?}"
        );
    }
}
