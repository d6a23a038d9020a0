//! Time in every part of a declaration: the Lagrangian, rows of every order, fields and forms, maps and
//! discrete statements, each against a closed form or equations by hand. Starts, events and runs back are in
//! [`runs`].

use dsocs_core::taylor::Tolerance;
use dsocs_core::{Node, Real, Start, Stepper, dsocs};
use dsocs_tests::declared;
use dsocs_tests::fit::slope;
use dsocs_tests::motion::{STEPS, assert_position, assert_second_order, continuous, discrete};
use dsocs_tests::text::{Flow, System, TaylorFlow};

use dsocs_tests::dop853;

mod runs;

/// The driven oscillator `x″ + x = 0.6 cos 1.7 t` at t = 10, from 1 with the velocity 0.3; with 40 digits, rounded.
const DRIVEN: f64 = -1.181_296_335_684_487;

/// Declares the driven oscillator with a map, or another discrete statement.
macro_rules! driven {
    ($(#[$doc:meta])* $name:ident, $($statement:tt)*) => {
        declared! {
            $(#[$doc])*
            struct $name;
            coordinates(x);
            let drive = 0.6 * (1.7 * t).cos();
            lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 + drive * x;
            $($statement)*
        }
    };
}

/// With the default map, the paper's; compiled, since ensembles need it.
#[dsocs {
    coordinates(x);
    let drive = 0.6 * (1.7 * t).cos();
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 + drive * x;
    observe = [drive];
}]
struct Driven;

driven! {
    /// With the midpoint.
    DrivenMidpoint, phi_lagrangian = midpoint;
}
driven! {
    /// With the trapezoid.
    DrivenTrapezoid, phi_lagrangian = trapezoid;
}
driven! {
    /// With the midpoint, written out with the times of the nodes.
    DrivenWritten, phi_lagrangian = |t0, q0, t1, q1| ((t0 + t1) / 2, (q0 + q1) / 2, (q1 - q0) / h);
}
driven! {
    /// With the midpoint, written out without them: the time is that of the position.
    DrivenUntimed, phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
}
driven! {
    /// With the drive at the end of the leg alone.
    DrivenLate, phi_lagrangian = |t0, q0, t1, q1| { let late = t1 + 0 * t0; (late, q1, (q1 - q0) / h) };
}
driven! {
    /// The paper's discrete Lagrangian, written in nodes.
    DrivenNodes,
    discrete_lagrangian = ((x[1] - x[0]) / h).powi(2) / 2 - x[0].powi(2) / 2 + 0.6 * (1.7 * t[0]).cos() * x[0];
}

/// A motion by the method of Dormand and Prince from the time `t0`.
fn by_hand<const N: usize>(
    rate: impl Fn(f64, [f64; N]) -> [f64; N],
    t0: f64,
    state: [f64; N],
    until: f64,
) -> [f64; N] {
    dop853::integrate_from(rate, (t0, state), until, 1e-14)
}

#[test]
fn a_driven_oscillator_is_its_closed_form_with_every_map() {
    let start = Start::second_order([1.0], [0.3]);
    assert_position("default", &Driven, start, 10.0, &[DRIVEN], 3e-15);
    assert_position("midpoint", &DrivenMidpoint, start, 10.0, &[DRIVEN], 3e-15);
    assert_position("trapezoid", &DrivenTrapezoid, start, 10.0, &[DRIVEN], 3e-15);
    assert_position("nodes", &DrivenNodes, start, 10.0, &[DRIVEN], 3e-15);
    assert_position("late", &DrivenLate, start, 10.0, &[DRIVEN], 3e-15);
    // no constraint force is left, and the energy is that at the time
    let node = discrete(&Driven, 0.01, start, 3.0);
    assert!(node.force[0].abs() < 1e-15, "{node:?}");
    let drive = 0.6 * f64::cos(1.7 * 3.0);
    let energy = f64::midpoint(node.v[0].powi(2), node.q[0].powi(2)) - drive * node.q[0];
    assert!((node.energy - energy).abs() < 1e-15, "{node:?}");
    assert!((Driven.energy(3.0, &node.q, &node.v) - energy).abs() < 1e-15);
    assert!((Driven.lagrangian(3.0, &[1.0], &[0.0]) - (drive - 0.5)).abs() < 1e-15);
}

#[test]
fn maps_that_name_the_times_are_those_that_have_names() {
    let start = Start::second_order([1.0], [0.3]).at(0.4);
    let nodes = |system: &dyn Fn() -> Node<1>| system().q[0];
    let midpoint = nodes(&|| discrete(&DrivenMidpoint, 0.1, start, 10.4));
    for other in [
        nodes(&|| discrete(&DrivenWritten, 0.1, start, 10.4)),
        nodes(&|| discrete(&DrivenUntimed, 0.1, start, 10.4)),
    ] {
        assert!((midpoint - other).abs() < 1e-14, "{midpoint} {other}");
    }
    let paper = nodes(&|| discrete(&Driven, 0.1, start, 10.4));
    let written = nodes(&|| discrete(&DrivenNodes, 0.1, start, 10.4));
    assert!((paper - written).abs() < 1e-14, "{paper} {written}");
    // they are not all the same map
    assert!((paper - midpoint).abs() > 1e-5);
}

declared! {
    /// A mass on a quartic spring whose mass varies in time.
    struct Leaking;
    coordinates(x);
    let mass = 2 + (1.3 * t).sin();
    lagrangian = mass / 2 * dot(x).powi(2) - x.powi(4) / 4;
}

declared! {
    /// An oscillator with a gauge term `a(t) v`: a potential `a′ x`, by `d/dt (a(t) x) = a′ x + a v`.
    struct Gauge;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 + (2 * t).sin() * dot(x) - x.powi(2) / 2;
}

/// Where the momentum depends on time the default map is of order 2, as where it depends on the position.
#[test]
fn the_default_map_is_of_order_2_where_the_momentum_depends_on_time() {
    let rate = |t: f64, [x, v]: [f64; 2]| {
        let (mass, growth) = (2.0 + (1.3 * t).sin(), 1.3 * (1.3 * t).cos());
        [v, -(x.powi(3) + growth * v) / mass]
    };
    let start = Start::second_order([1.0], [0.3]).at(0.5);
    let [x, _] = by_hand(rate, 0.5, [1.0, 0.3], 6.5);
    assert_position("mass", &Leaking, start, 6.5, &[x], 2e-13);
    let rate = |t: f64, [x, v]: [f64; 2]| [v, -x - 2.0 * (2.0 * t).cos()];
    let [x, _] = by_hand(rate, 0.5, [1.0, 0.3], 6.5);
    assert_position("gauge", &Gauge, start, 6.5, &[x], 2e-13);
}

/// A bead on a wire that turns in a vertical plane.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
    holonomic = y * (rate * t).cos() - x * (rate * t).sin();
    phi_lagrangian = midpoint;
}]
struct Bead {
    rate: f64,
}

declared! {
    /// The bead with the time as a coordinate.
    struct BeadWithClock {
        rate: f64,
    }
    coordinates(x, y, s);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(s).powi(2)) / 2 - 9.81 * y;
    holonomic = y * (rate * s).cos() - x * (rate * s).sin();
    nonholonomic = dot(s) - 1;
    phi_lagrangian = midpoint;
}

const BEAD: Bead = Bead { rate: 0.7 };

/// At the distance 0.5 with the rate 0.2, along a wire that is horizontal at t = 0.
const ON_THE_WIRE: ([f64; 2], [f64; 2]) = ([0.5, 0.0], [0.2, 0.5 * 0.7]);

/// The distance along the wire and its rate: `r″ = ω² r − g sin ωt`.
fn along_the_wire(t: f64) -> [f64; 2] {
    let (w, g) = (0.7, 9.81);
    let (a, forced) = (0.5, g / (2.0 * w * w));
    let b = (0.2 - forced * w) / w;
    let (sin, cos) = (w * t).sin_cos();
    let (sinh, cosh) = ((w * t).sinh(), (w * t).cosh());
    [
        a * cosh + b * sinh + forced * sin,
        w * (a * sinh + b * cosh + forced * cos),
    ]
}

#[test]
fn a_bead_on_a_turning_wire_is_its_closed_form() {
    let start = Start::second_order(ON_THE_WIRE.0, ON_THE_WIRE.1);
    let known = [14.336_340_164_937_3, -24.512_941_668_921_09];
    assert_position("bead", &BEAD, start, 3.0, &known, 2e-13);
    // the normal force, of the continuous motion to rounding and of the discrete one to order 2
    let normal = 3.416_149_104_760_147;
    let mut flow = TaylorFlow::new(&BEAD, start, Tolerance::relative(1e-15)).unwrap();
    let node = flow.to(1.0).unwrap();
    let force = node.force[0].hypot(node.force[1]);
    assert!((force - normal).abs() < 1e-13, "{force}");
    assert!((flow.multipliers(&node)[0] - normal).abs() < 1e-13);
    let [_, rate] = along_the_wire(1.0);
    assert!((2.0 * 0.7 * rate + 9.81 * f64::cos(0.7) - normal).abs() < 1e-13);
    assert_second_order("normal force", |h| {
        let mut flow = Flow::new(&BEAD, h, start).unwrap();
        let node = flow.until(1.0).unwrap().nodes.pop().unwrap();
        (flow.multipliers(&node)[0] - normal).abs()
    });
}

#[test]
fn time_is_a_coordinate_with_the_rate_1_but_for_the_coordinate() {
    let clock = BeadWithClock { rate: 0.7 };
    let ([x, y], [u, v]) = ON_THE_WIRE;
    let (mut bead, mut with_clock) = (
        Flow::new(&BEAD, 0.01, Start::second_order([x, y], [u, v])).unwrap(),
        Flow::new(&clock, 0.01, Start::second_order([x, y, 0.0], [u, v, 1.0])).unwrap(),
    );
    let (nodes, others) = (bead.until(3.0).unwrap(), with_clock.until(3.0).unwrap());
    assert_eq!(nodes.len(), 301);
    for (node, other) in nodes.iter().zip(&others) {
        let size = 1.0 + node.q[1].abs();
        assert!((node.t - other.q[2]).abs() < 1e-14 * (1.0 + node.t), "{other:?}");
        for i in 0..2 {
            assert!(
                (node.q[i] - other.q[i]).abs() < 1e-13 * size,
                "{node:?} {other:?}"
            );
            assert!(
                (node.v[i] - other.v[i]).abs() < 1e-11 * size,
                "{node:?} {other:?}"
            );
            assert!(
                (node.force[i] - other.force[i]).abs() < 1e-9 * size,
                "{node:?} {other:?}"
            );
        }
    }
}

declared! {
    /// A skate on a plane that tilts: the direction in which it may move, and a belt, depend on time.
    struct Belt;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.powi(2) / 2 - y.powi(2);
    nonholonomic = dot(y) - (1.1 * t).sin() * dot(x) - 0.3 * (0.9 * t).cos();
}

#[test]
fn a_nonholonomic_row_may_depend_on_time() {
    let rate = |t: f64, [x, y, u, v]: [f64; 4]| {
        let (slope, growth) = ((1.1 * t).sin(), 1.1 * (1.1 * t).cos());
        let belt = -0.27 * (0.9 * t).sin();
        // λ (−slope, 1) is the force
        let multiplier = (2.0 * y - slope * x + growth * u + belt) / (1.0 + slope * slope);
        [u, v, -x - slope * multiplier, -2.0 * y + multiplier]
    };
    let t0: f64 = 0.6;
    let v0 = (1.1 * t0).sin() * 0.5 + 0.3 * (0.9 * t0).cos();
    let [x, y, ..] = by_hand(rate, t0, [1.0, 0.2, 0.5, v0], 5.6);
    let start = Start::second_order([1.0, 0.2], [0.5, v0]).at(t0);
    assert_position("belt", &Belt, start, 5.6, &[x, y], 1e-12);
    // at the time 0 the start's velocity does not obey the row
    let Err(error) = Flow::new(&Belt, 0.01, start.at(0.0)) else {
        panic!("accepted");
    };
    assert!(error.to_string().contains("nonholonomic constraint 1"), "{error}");
}

/// A particle whose curvature changes with time.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature.at(t);
    variational = [(dot(x), dot(y))];
}]
struct Steered {
    curvature: Slalom,
}

/// A curvature in time.
struct Slalom {
    mean: f64,
}

/// The one that is driven here.
const SLALOM: Slalom = Slalom { mean: 0.5 };

impl Slalom {
    fn at<R: Real>(&self, t: R) -> R {
        (t * 1.5).sin() * 0.8 + self.mean
    }
}

#[test]
fn a_kinematic_row_may_depend_on_time() {
    // the heading is the integral of the curvature, at the speed 1
    let heading = |t: f64| 0.5 * t - 0.8 / 1.5 * ((1.5 * t).cos() - 1.0);
    let [x, y] = by_hand(|t, _| [heading(t).cos(), heading(t).sin()], 0.0, [0.0; 2], 7.0);
    let steered = Steered { curvature: SLALOM };
    let start = Start::second_order([0.0; 2], [1.0, 0.0]);
    assert_position("slalom", &steered, start, 7.0, &[x, y], 1e-12);
}

declared! {
    /// A slider with a prescribed motion, by a rod whose direction turns: the form of the force depends on
    /// time.
    struct Rod;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y.powi(2) / 2;
    kinematic = ddot(x) + x - (0.7 * t).sin();
    constraint_forces = [(1, t.sin() / 2)];
}

declared! {
    /// The rod by fields.
    struct RodByFields;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y.powi(2) / 2;
    kinematic = ddot(x) + x - (0.7 * t).sin();
    variational = [(-t.sin() / 2, 1)];
}

#[test]
fn forms_and_fields_may_depend_on_time() {
    let rate = |t: f64, [x, y, u, v]: [f64; 4]| {
        let wanted = (0.7 * t).sin() - x;
        [u, v, wanted, -y + t.sin() / 2.0 * wanted]
    };
    let t0 = -1.0;
    let [x, y, ..] = by_hand(rate, t0, [0.4, 1.0, 0.0, -0.5], 5.0);
    let start = Start::second_order([0.4, 1.0], [0.0, -0.5]).at(t0);
    assert_position("forms", &Rod, start, 5.0, &[x, y], 1e-12);
    assert_position("fields", &RodByFields, start, 5.0, &[x, y], 1e-12);
}

declared! {
    /// A declared rate of change with its partial derivative in time: `dot(e)` of an expression with `t`.
    struct Follower;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    let wanted = x - (1.2 * t).sin() * t;
    kinematic = ddot(x) - dot(dot((1.2 * t).sin() * t)) + 2 * dot(wanted) + wanted;
    constraint_forces = [(1,)];
    observe = [wanted];
}

/// The deviation from the curve in time decays, critically damped.
#[test]
fn dot_of_an_expression_has_its_partial_derivative_in_time() {
    let deviation = |t: f64| (1.0 + 1.5 * t) * (-t).exp();
    let known = deviation(4.0) + f64::sin(4.8) * 4.0;
    let start = Start::second_order([1.0], [0.5]);
    assert_position("follower", &Follower, start, 4.0, &[known], 2e-14);
    let mut observed = [0.0];
    Follower.observe(&continuous(&Follower, start, 4.0).point(), &mut observed);
    assert!((observed[0] - deviation(4.0)).abs() < 1e-13);
}

/// The paper's map of three nodes, written with their times, and one with the time at another node.
macro_rules! follower {
    ($name:ident, $($map:tt)*) => {
        declared! {
            /// An oscillator about a moving centre, with the given map.
            struct $name;
            coordinates(x);
            lagrangian = dot(x).powi(2) / 2;
            kinematic = ddot(x) + x - (1.2 * t).sin();
            constraint_forces = [(1,)];
            phi_kinematic = $($map)*;
        }
    };
}

follower!(Paper, paper);
follower!(Timed, |t0, q0, t1, q1, t2, q2| (
    (t0 + t2) / 2 + 0 * t1,
    q1,
    (q2 - q0) / (t2 - t0),
    (q2 - 2 * q1 + q0) / h.powi(2)
));
follower!(Early, |t0, q0, t1, q1, t2, q2| (
    t0 + 0 * (t1 + t2),
    q1,
    (q2 - q0) / (2 * h),
    (q2 - 2 * q1 + q0) / h.powi(2)
));

#[test]
fn maps_of_three_nodes_may_name_the_times() {
    let start = Start::second_order([1.0], [0.5]).at(0.7);
    let node = |h: f64, system: u8| match system {
        0 => discrete(&Paper, h, start, 5.7),
        1 => discrete(&Timed, h, start, 5.7),
        _ => discrete(&Early, h, start, 5.7),
    };
    for h in [0.1, 0.05] {
        assert!((node(h, 0).q[0] - node(h, 1).q[0]).abs() < 1e-13);
    }
    // the time of the first node makes the map of order 1
    let exact = continuous(&Paper, start, 5.7).q[0];
    let errors = STEPS.map(|h| (node(h, 2).q[0] - exact).abs());
    let order = slope(&STEPS, &errors);
    assert!((order - 1.0).abs() < 0.05, "{order}: {errors:?}");
}
