//! Discrete Lagrangians, discrete constraints and maps, given directly or by name: the rows that follow from
//! them, and the orders.

use dsocs_core::__private::Declaration;
use dsocs_core::geometry::discrete_lagrangian;
use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{Leg, Start, StepFailure, Stepper, System, dsocs};
use dsocs_systems::InertiaWheelPendulum;
use dsocs_tests::declared;
use dsocs_tests::fit::slope;
use dsocs_tests::text::{self, Flow};

/// A pendulum whose length depends on its angle: a mass matrix that depends on the position.
macro_rules! varying {
    ($name:ident, $($statements:tt)*) => {
        #[dsocs {
            coordinates(theta, x);
            lagrangian = (1 + theta.sin() / 2).powi(2) * dot(theta).powi(2) / 2 + dot(x).powi(2) / 2 + theta.cos()
                - (x - theta).powi(2) / 2 + x * dot(theta);
            $($statements)*
        }]
        struct $name;
    };
}

varying!(Paper, phi_lagrangian = paper;);
varying!(Default,);
varying!(Midpoint, phi_lagrangian = midpoint;);
varying!(Trapezoid, phi_lagrangian = trapezoid;);
varying!(Formula, phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h););
// nonlinear in the nodes: the mean angle by its sine, the chord by the sine of half the angle
varying!(Nonlinear, phi_lagrangian = |q0, q1| (
    q0 + ((q1 - q0) / 2).sin(),
    2 * ((q1 - q0) / 2).sin() / h,
););
varying!(OnLeg, phi_lagrangian = midpoint; discrete_lagrangian = leg((1 + theta.sin() / 2).powi(2) * dot(theta).powi(2) / 2
    + dot(x).powi(2) / 2 + theta.cos() - (x - theta).powi(2) / 2 + x * dot(theta), 0););

/// The error of the position at the time `t`, with the step `h`.
fn error<S: System<N>, const N: usize>(system: &S, h: f64, q: [f64; N], v: [f64; N], t: f64) -> f64 {
    let exact = TaylorFlow::new(system, Start::second_order(q, v), Tolerance::relative(1e-15))
        .unwrap()
        .to(t)
        .unwrap()
        .q;
    let start = Start::second_order(q, v).exact(system, h).unwrap();
    let found = Flow::new(system, h, start).unwrap().until(t).unwrap().nodes;
    let found = found.last().unwrap().q;
    (0..N).fold(0.0, |largest, i| (found[i] - exact[i]).abs().max(largest))
}

fn order<S: System<2>>(system: &S) -> f64 {
    let steps = [0.02, 0.01, 0.005, 0.0025];
    let errors = steps.map(|h| error(system, h, [0.5, 0.3], [1.0, -0.4], 4.0));
    let order = slope(&steps, &errors);
    println!("errors {errors:?}, order {order:.3}");
    order
}

#[test]
fn orders_of_the_maps() {
    let near = |order: f64, wanted: f64| assert!((order - wanted).abs() < 0.07, "{order}, not {wanted}");
    near(order(&Default), 2.0);
    near(order(&Paper), 1.0);
    near(order(&Midpoint), 2.0);
    near(order(&Trapezoid), 2.0);
    near(order(&Formula), 2.0);
    near(order(&Nonlinear), 2.0);
    near(order(&OnLeg), 2.0);
}

/// An oscillator with a prescribed decrease of energy, as a difference on legs, without a map.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.powi(2) * y;
    let energy = dot(y).powi(2) / 2 + y.powi(2) + x.cos() * dot(y);
    let rate = (2 + x.sin()) * dot(y) / 4;
    kinematic = dot(energy) + rate * dot(y);
    discrete_kinematic = leg(energy, 1) - leg(energy, 0) + h * node(rate * dot(y));
    constraint_forces = [(0, 1)];
}]
struct Legs;

#[test]
fn expressions_on_legs_are_of_second_order_without_a_map() {
    let steps = [0.02, 0.01, 0.005, 0.0025];
    let errors = steps.map(|h| error(&Legs, h, [0.5, 0.3], [1.0, 1.4], 1.0));
    let order = slope(&steps, &errors);
    println!("errors {errors:?}, order {order:.3}");
    assert!((order - 2.0).abs() < 0.07, "{order}");
}

fn run<S: text::System<N>, const N: usize>(
    system: &S,
    q0: [f64; N],
    q1: [f64; N],
    h: f64,
    t: f64,
) -> Vec<[f64; N]> {
    let nodes = Flow::new(system, h, Start::nodes(q0, q1))
        .unwrap()
        .until(t)
        .unwrap()
        .nodes;
    nodes.iter().map(|node| node.q).collect()
}

#[test]
fn a_name_a_formula_and_a_leg_are_the_same_map() {
    let motion = run(&Midpoint, [0.5, 0.3], [0.51, 0.296], 0.01, 10.0);
    for other in [
        run(&Formula, [0.5, 0.3], [0.51, 0.296], 0.01, 10.0),
        run(&OnLeg, [0.5, 0.3], [0.51, 0.296], 0.01, 10.0),
    ] {
        for (a, b) in motion.iter().zip(&other) {
            assert!((a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-11, "{a:?} {b:?}");
        }
    }
}

declared! {
    /// The harmonic oscillator with its exact discrete Lagrangian, the action along the motion between two nodes, by the step.
    struct Oscillator;
    coordinates(x);
    lagrangian = (dot(x).powi(2) - x.powi(2)) / 2;
    discrete_lagrangian = ((x[0].powi(2) + x[1].powi(2)) * h.cos() - 2 * x[0] * x[1]) / (2 * h * h.sin());
}

declared! {
    /// The oscillator with its discrete Lagrangian by the trapezoid, written out.
    struct WrittenOut;
    coordinates(x);
    lagrangian = (dot(x).powi(2) - x.powi(2)) / 2;
    discrete_lagrangian = ((x[1] - x[0]) / h).powi(2) / 2 - (x[0].powi(2) + x[1].powi(2)) / 4;
}

declared! {
    /// The oscillator with the trapezoid by name.
    struct Named;
    coordinates(x);
    lagrangian = (dot(x).powi(2) - x.powi(2)) / 2;
    phi_lagrangian = trapezoid;
}

#[test]
fn the_exact_discrete_lagrangian_gives_the_motion_itself() {
    for h in [1.0, 0.1, 0.01] {
        let motion = run(&Oscillator, [1.0], [f64::cos(h)], h, 100.0);
        let worst = motion.iter().enumerate().fold(0.0_f64, |worst, (k, q)| {
            worst.max((q[0] - (k as f64 * h).cos()).abs())
        });
        println!("h = {h}: {worst:.1e}");
        assert!(worst < 1e-12 / h, "h = {h}: {worst:e}");
        // the discrete Lagrangian itself, in the units of the Lagrangian
        let leg = Leg {
            t: 0.0,
            q: [f64::cos(h)],
            d: [f64::cos(h) - 1.0],
        };
        let action = -(2.0 * h).sin() / (4.0 * h);
        assert!((discrete_lagrangian(text::read(&Oscillator), h, leg.any()) - action).abs() < 1e-12 / h);
    }
}

#[test]
fn a_discrete_lagrangian_of_the_nodes_is_the_named_one() {
    let (a, b) = (
        run(&WrittenOut, [1.0], [0.99], 0.1, 100.0),
        run(&Named, [1.0], [0.99], 0.1, 100.0),
    );
    for (a, b) in a.iter().zip(&b) {
        assert!((a[0] - b[0]).abs() < 1e-12, "{a:?} {b:?}");
    }
}

/// The paper's pendulum with a constraint that makes `V` decrease by exactly `h F` from leg to leg, in place of `dV/dt = −F` at
/// the nodes.
#[dsocs {
    use dsocs_systems::pendulum::inertia_wheel_pendulum;
    let dissipation = rho * w * w.tanh();

    kinematic = dot(lyapunov) + dissipation;
    discrete_kinematic = leg(lyapunov, 1) - leg(lyapunov, 0) + h * node(dissipation);
    constraint_forces = [(0, 1)];
    phi_lagrangian = trapezoid;
    observe = [lyapunov, dissipation, w];
}]
#[derive(Clone, Copy)]
struct Exact {
    i: f64,
    j: f64,
    m: f64,
    d: f64,
    e: f64,
    chi: f64,
    n: f64,
    rho: f64,
}

const PENDULUM: Exact = Exact {
    i: 312.5,
    j: 2.0772,
    m: 37.98,
    d: 1.0,
    e: 1000.0,
    chi: 100.0,
    n: -154.0,
    rho: 2.0,
};

/// `V` on a leg, as in the constraint.
fn lyapunov(h: f64, leg: &Leg<f64, 2>) -> f64 {
    let q0 = [leg.q[0] - leg.d[0], leg.q[1] - leg.d[1]];
    let v = leg.d.map(|d| d / h);
    let pendulum = InertiaWheelPendulum::default();
    f64::midpoint(pendulum.lyapunov(q0, v), pendulum.lyapunov(leg.q, v))
}

const Q0: [f64; 2] = [0.5, 0.0];
const V0: [f64; 2] = [0.0, 0.5];

#[test]
fn the_lyapunov_function_decreases_exactly() {
    for h in [0.1, 0.05, 0.02, 0.01, 0.001] {
        let mut flow = Flow::new(&PENDULUM, h, Start::second_order(Q0, V0)).unwrap();
        let mut before = lyapunov(h, &flow.leg());
        let mut worst = 0.0_f64;
        while flow.time() < 15.0 - h {
            flow.advance().unwrap();
            let node = flow.node();
            let after = lyapunov(h, &flow.leg());
            let dissipation = InertiaWheelPendulum::default().dissipation(node.q, node.v);
            assert!(
                after <= before && dissipation >= 0.0,
                "V rises at {}",
                flow.time()
            );
            worst = worst.max((after - before + h * dissipation).abs() / before);
            before = after;
        }
        println!("h = {h}: V = {before}, V(q1,q2) − V(q0,q1) + h F at most {worst:.1e} of V");
        assert!(worst < 1e-12, "h = {h}: {worst:e}");
    }
}

#[test]
fn exact_decrease_is_of_second_order_too() {
    let steps = [0.02, 0.01, 0.005, 0.0025];
    let exact = steps.map(|h| error(&PENDULUM, h, Q0, V0, 10.0));
    let paper = steps.map(|h| error(&InertiaWheelPendulum::default(), h, Q0, V0, 10.0));
    println!("exact decrease {exact:?}, at the nodes {paper:?}");
    let order = slope(&steps, &exact);
    assert!((order - 2.0).abs() < 0.05, "{order}");
}

/// The pendulum with an exact decrease ends with `NoSolution` at t = 28.5 to 29, where `w` passes through
/// zero, with three steps; no unknown on a line of 40 001 solves the row there.
#[test]
fn where_the_motor_has_no_power_there_need_be_no_exact_decrease() {
    // dV/dt is w times the effect of the motor. Where w passes through zero, at t = 28.8 for the first time, the discrete row is
    // a parabola that does not reach zero, unless a step skips this place
    for h in [0.02, 0.01, 0.005] {
        let mut flow = Flow::new(&PENDULUM, h, Start::second_order(Q0, V0)).unwrap();
        let error = loop {
            if let Err(error) = flow.advance() {
                break error;
            }
        };
        assert!((28.5..29.0).contains(&flow.time()), "{error}");
        assert_eq!(error.step_failure(), Some(StepFailure::NoSolution));
        let leg = flow.leg();
        let declaration = Declaration::of(&PENDULUM);
        let row = |e: f64| declaration.rows(h, leg.any(), &declaration.unknown(&[e, e], &[]))[0];
        let sign = row(0.0).signum();
        let last = leg.d[0].abs().max(leg.d[1].abs());
        for k in -20_000..=20_000 {
            let e = f64::from(k) / 2000.0 * last;
            assert!(row(e) * sign > 0.0, "a solution at e = {e}");
        }
    }
}
