//! The systems of the library against exact solutions, invariants and equations of motion derived by hand, with the order that
//! a fit of their errors gives.

use dsocs_core::geometry::constraint_force;
use dsocs_core::taylor::Tolerance;
use dsocs_core::{Node, Point, Real, Start, Stepper};
use dsocs_systems::{
    CartPole, Curvature, CurvedParticle, GravityTurn, MagneticParticle, PlanarChain2, SphericalPendulum,
};
use dsocs_tests::declared;
use dsocs_tests::fit::{local_slopes, slope};
use dsocs_tests::text::{Flow, System, TaylorFlow};

use dsocs_tests::dop853;

/// The end of a motion by a published Runge–Kutta method of order 8.
fn reference_end(equations: impl Fn([f64; 4]) -> [f64; 4], q: [f64; 2], v: [f64; 2], until: f64) -> [f64; 4] {
    dop853::integrate(
        |_, state| equations(state),
        [q[0], q[1], v[0], v[1]],
        until,
        1e-14,
    )
}

/// The node at `until`.
fn end<S: System<2>>(system: &S, q: [f64; 2], v: [f64; 2], h: f64, until: f64) -> [f64; 2] {
    let mut flow = Flow::new(system, h, Start::second_order(q, v)).unwrap();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some thousand steps
    let steps = (until / h).round() as u64;
    while flow.index() < steps {
        flow.advance().unwrap();
    }
    *flow.position()
}

/// The largest difference of two positions.
fn distance(x: [f64; 2], y: [f64; 2]) -> f64 {
    (x[0] - y[0]).abs().max((x[1] - y[1]).abs())
}

/// Fits the order on a motion of which the end is known.
fn order<S: System<2>>(
    name: &str,
    system: &S,
    q: [f64; 2],
    v: [f64; 2],
    steps: &[f64],
    until: f64,
    known: [f64; 2],
) {
    let errors: Vec<f64> = steps
        .iter()
        .map(|&h| distance(end(system, q, v, h, until), known))
        .collect();
    let order = slope(steps, &errors);
    println!(
        "{name}: order {order:.3}, {:.3?}, errors {errors:?}",
        local_slopes(steps, &errors)
    );
    assert!(
        errors.iter().all(|error| *error > 1e-10),
        "above rounding: {errors:?}"
    );
    assert!((order - 2.0).abs() < 0.03, "{name}: {order}");
}

/// The continuous motion by its Taylor series, for systems that come with both.
fn taylor<S: System<2>>(system: &S, q: [f64; 2], v: [f64; 2], until: f64) -> Node<2> {
    let mut flow = TaylorFlow::new(system, Start::second_order(q, v), Tolerance::relative(1e-15)).unwrap();
    flow.to(until).unwrap()
}

/// The accelerations of the double pendulum as textbooks give them, solved for by hand.
fn textbook(chain: &PlanarChain2, [a, b]: [f64; 2], [va, vb]: [f64; 2]) -> [f64; 2] {
    let ([m1, m2], [l1, l2], g) = (chain.masses, chain.lengths, chain.gravity);
    let d = a - b;
    let scale = 2.0 * m1 + m2 - m2 * (2.0 * d).cos();
    let first = -g * (2.0 * m1 + m2) * a.sin()
        - m2 * g * (a - 2.0 * b).sin()
        - 2.0 * d.sin() * m2 * (vb * vb * l2 + va * va * l1 * d.cos());
    let second =
        2.0 * d.sin() * (va * va * l1 * (m1 + m2) + g * (m1 + m2) * a.cos() + vb * vb * l2 * m2 * d.cos());
    [first / (l1 * scale), second / (l2 * scale)]
}

#[test]
fn two_links_are_the_double_pendulum() {
    let chain = PlanarChain2 {
        masses: [1.5, 0.7],
        lengths: [0.8, 1.3],
        gravity: 9.81,
    };
    for (q, v) in [
        ([0.3, -1.2], [0.5, 2.0]),
        ([2.5, 1.0], [-3.0, 0.4]),
        ([-1.0, -1.0], [1.0, -1.0]),
    ] {
        let a = textbook(&chain, q, v);
        let rest = constraint_force(&chain, Point { t: 0.0, q, v, a }.any());
        assert!(rest.iter().all(|rest| rest.abs() < 1e-13), "{rest:?}");
    }
}

#[test]
fn the_double_pendulum_is_the_textbooks() {
    let chain = PlanarChain2 {
        masses: [1.5, 0.7],
        lengths: [0.8, 1.3],
        gravity: 9.81,
    };
    let equations = |[a, b, va, vb]: [f64; 4]| {
        let [first, second] = textbook(&chain, [a, b], [va, vb]);
        [va, vb, first, second]
    };
    let (q, v, until) = ([2.0, 1.0], [0.0, 0.5], 2.0);
    let known = reference_end(equations, q, v, until);
    assert!(distance(taylor(&chain, q, v, until).q, [known[0], known[1]]) < 1e-11);
    let steps = [0.008, 0.004, 0.002, 0.001, 0.0005];
    order(
        "double pendulum",
        &chain,
        q,
        v,
        &steps,
        until,
        [known[0], known[1]],
    );
}

#[test]
fn the_spherical_pendulum_is_the_textbooks() {
    let pendulum = SphericalPendulum {
        mass: 0.7,
        length: 1.3,
        gravity: 9.81,
    };
    let textbook = |[theta, _, v, w]: [f64; 4]| {
        let (sin, cos) = theta.sin_cos();
        [
            v,
            w,
            sin * cos * w * w - 9.81 / 1.3 * sin,
            -2.0 * v * w * cos / sin,
        ]
    };
    let (q, v, until) = ([1.0, 0.0], [0.5, 2.0], 4.0);
    let known = reference_end(textbook, q, v, until);
    assert!(distance(taylor(&pendulum, q, v, until).q, [known[0], known[1]]) < 1e-11);
    let steps = [0.04, 0.02, 0.01, 0.005, 0.0025];
    order(
        "spherical pendulum",
        &pendulum,
        q,
        v,
        &steps,
        until,
        [known[0], known[1]],
    );
}

/// On a cone it turns at `φ̇² = g/(l cos θ)`; the midpoint of two nodes on a cone is on the same cone, and so the discrete
/// motion is this one exactly.
#[test]
fn the_conical_pendulum_stays_on_its_cone() {
    let pendulum = SphericalPendulum::default();
    let rate = (pendulum.gravity / (pendulum.length * 0.8_f64.cos())).sqrt();
    let mut flow = Flow::new(&pendulum, 0.05, Start::second_order([0.8, 0.0], [0.0, rate])).unwrap();
    while flow.index() < 2000 {
        flow.advance().unwrap();
        let [theta, phi] = *flow.position();
        // rounding grows with the square of the number of steps at most
        assert!(
            (theta - 0.8).abs() < 1e-12 && (phi - rate * flow.time()).abs() < 1e-10,
            "{theta} {phi}"
        );
    }
}

#[test]
fn in_a_uniform_field_the_charge_goes_round_in_a_circle() {
    let particle = MagneticParticle {
        mass: 0.5,
        charge: 2.0,
        field: 0.3,
        gradient: 0.0,
    };
    let (q, v, until) = ([1.0, -0.5], [0.4, 0.9], 6.0);
    let known = particle.exact(q, v, until);
    assert!(distance(taylor(&particle, q, v, until).q, known) < 1e-13);
    let steps = [0.1, 0.05, 0.025, 0.0125];
    order("charge in a uniform field", &particle, q, v, &steps, until, known);
}

#[test]
fn in_a_field_that_grows_outwards_the_force_is_lorentzs() {
    let particle = MagneticParticle::default();
    let lorentz = |[x, y, u, v]: [f64; 4]| {
        let field = 1.0 + 0.25 * (x * x + y * y);
        [u, v, field * v, -field * u]
    };
    let (q, v, until) = ([1.0, 0.0], [0.3, 0.8], 8.0);
    let known = reference_end(lorentz, q, v, until);
    assert!(distance(taylor(&particle, q, v, until).q, [known[0], known[1]]) < 1e-11);
    let steps = [0.1, 0.05, 0.025, 0.0125];
    order(
        "charge in a growing field",
        &particle,
        q,
        v,
        &steps,
        until,
        [known[0], known[1]],
    );
}

/// The curvature of a charge's path.
struct Field {
    particle: MagneticParticle,
    speed: f64,
}

impl Curvature for Field {
    fn at<D: Real>(&self, x: D, y: D) -> D {
        let strength = (x * x + y * y) * self.particle.gradient + 1.0;
        strength * self.particle.curvature(self.speed, 0.0)
    }
}

#[test]
fn the_charge_and_the_particle_of_its_curvature_are_twins() {
    let charge = MagneticParticle::default();
    let (q, v, until) = ([1.0, 0.0], [0.3, 0.8], 20.0);
    let twin = CurvedParticle {
        mass: charge.mass,
        curvature: Field {
            particle: charge,
            speed: f64::hypot(0.3, 0.8),
        },
    };
    let (free, constrained) = (taylor(&charge, q, v, until), taylor(&twin, q, v, until));
    assert!(distance(free.q, constrained.q) < 1e-12 && distance(free.v, constrained.v) < 1e-12);
    let at = twin.curvature.at(1.5, 2.0);
    assert!((at - charge.curvature(f64::hypot(0.3, 0.8), 2.5)).abs() < 1e-14);
}

/// The exact position of the gravity turn: its exact velocity, integrated by Gauss–Legendre quadrature of five points on
/// short intervals.
fn integrated(turn: &GravityTurn, q: [f64; 2], v: [f64; 2], until: f64) -> [f64; 2] {
    let (a, b) = (
        1.0 / 3.0 * (5.0 - 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt(),
        1.0 / 3.0 * (5.0 + 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt(),
    );
    let (wa, wb) = (
        (322.0 + 13.0 * 70.0_f64.sqrt()) / 900.0,
        (322.0 - 13.0 * 70.0_f64.sqrt()) / 900.0,
    );
    let points = [(0.0, 128.0 / 225.0), (a, wa), (-a, wa), (b, wb), (-b, wb)];
    let intervals = 200;
    let half = until / f64::from(2 * intervals);
    let mut sum = q;
    for k in 0..intervals {
        let middle = f64::from(2 * k + 1) * half;
        for (x, weight) in points {
            let velocity = turn.exact_velocity(v, middle + half * x);
            sum = [
                sum[0] + half * weight * velocity[0],
                sum[1] + half * weight * velocity[1],
            ];
        }
    }
    sum
}

#[test]
fn the_gravity_turn_is_its_exact_solution() {
    for (acceleration, v) in [(0.5, [1.0, 3.0]), (-0.2, [-2.0, 3.0]), (0.0, [1.5, 2.0])] {
        let turn = GravityTurn {
            acceleration,
            ..GravityTurn::default()
        };
        let (q, until) = ([0.0, 1.0], 4.0);
        let continuous = taylor(&turn, q, v, until);
        assert!(distance(continuous.v, turn.exact_velocity(v, until)) < 1e-13);
        let known = integrated(&turn, q, v, until);
        assert!(distance(continuous.q, known) < 1e-13);
        let steps = [0.2, 0.1, 0.05, 0.025];
        order(
            &format!("gravity turn, τ = {acceleration}"),
            &turn,
            q,
            v,
            &steps,
            until,
            known,
        );
    }
}

declared! {
    /// The gravity turn by the name of Chetaev's rule, solved with multipliers.
    struct ByName {
        mass: f64,
        gravity: f64,
        acceleration: f64,
    }
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - mass * gravity * y;
    kinematic = (dot(x) * ddot(x) + dot(y) * ddot(y)) / (dot(x).powi(2) + dot(y).powi(2)).sqrt() - acceleration;
    variational = chetaev;
}

#[test]
fn chetaevs_rule_by_name_gives_the_same_motion() {
    let named = ByName {
        mass: 1.0,
        gravity: 1.0,
        acceleration: 0.5,
    };
    let (q, v) = ([0.0, 0.0], [1.0, 3.0]);
    let (written, named) = (
        end(&GravityTurn::default(), q, v, 0.05, 20.0),
        end(&named, q, v, 0.05, 20.0),
    );
    assert!(distance(written, named) < 1e-12, "{written:?} {named:?}");
}

#[test]
fn the_cart_pole_follows_the_law() {
    let cart = CartPole::default();
    let (q, v, until) = ([0.0, 2.8], [0.0, 0.3], 3.0);
    let known = reference_end(|state| cart.law(state).0, q, v, until);
    assert!(distance(taylor(&cart, q, v, until).q, [known[0], known[1]]) < 1e-11);
    let steps = [0.008, 0.004, 0.002, 0.001];
    order("cart-pole", &cart, q, v, &steps, until, [known[0], known[1]]);
}

/// The constraint force is the motor's, at every node, to order 2.
#[test]
fn the_constraint_force_drives_the_cart() {
    let cart = CartPole::default();
    let (q, v) = ([0.0, 2.8], [0.0, 0.3]);
    let steps = [0.02, 0.01, 0.005, 0.0025];
    let errors = steps.map(|h| {
        let mut flow = Flow::new(&cart, h, Start::second_order(q, v)).unwrap();
        let trajectory = flow.until(3.0).unwrap();
        let coarse = trajectory.nodes.iter().skip(1).filter(|node| {
            let part = node.t / 0.02;
            (part - part.round()).abs() < 1e-6
        });
        coarse.fold(0.0_f64, |worst, node| {
            let state = taylor(&cart, q, v, node.t);
            let (_, force) = cart.law([state.q[0], state.q[1], state.v[0], state.v[1]]);
            assert!(
                node.force[1].abs() < 1e-9,
                "nothing turns the pole: {:?}",
                node.force
            );
            worst.max((node.force[0] - force).abs())
        })
    });
    let order = slope(&steps, &errors);
    println!("motor force: order {order:.3}, errors {errors:?}");
    assert!((order - 2.0).abs() < 0.03, "{order}");
}

#[test]
fn the_pole_swings_up() {
    let cart = CartPole::default();
    let mut flow = Flow::new(&cart, 0.01, Start::second_order([0.0, 2.8], [0.0, 0.0])).unwrap();
    let trajectory = flow.until(10.0).unwrap();
    let lyapunov = |node: &Node<2>| {
        let mut observed = [0.0; 2];
        cart.observe(&node.point(), &mut observed);
        observed[0]
    };
    let values: Vec<f64> = trajectory.nodes.iter().map(lyapunov).collect();
    let rises = values
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .fold(0.0, f64::max);
    println!(
        "V from {:.3} J² to {:.1e} J², largest rise in a step {rises:.1e} J²",
        values[0],
        values[values.len() - 1]
    );
    assert!(values[values.len() - 1] < 1e-6 * values[0]);
    // V falls to the scheme's order
    assert!(rises < 1e-4 * values[0], "{rises:e}");
    let top = trajectory
        .nodes
        .iter()
        .map(|node| node.q[1].cos())
        .fold(-1.0, f64::max);
    assert!(top > 0.99, "{top}");
}
