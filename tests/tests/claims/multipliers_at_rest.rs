//! The multiplier of a constraint with friction in its force, where the friction holds a body: it is that of the static friction, whatever value
//! `signum` has at the node.

use dsocs_core::prelude::*;
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::{Flow, System, TaylorFlow};

declared! {
    /// A block on a slope, with Coulomb's friction in its constraint force.
    struct Block { slope: f64, mu: f64, gravity: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
    holonomic = y + slope * x;
    let s = mu * dot(x).signum();
    constraint_forces = [(slope - s, 1 + s * slope)];
}

declared! {
    /// A block on a plank that is turned about the origin, and another on the ground that slides.
    struct Plank { mu: f64, rate: f64 };
    coordinates(x, y, u, w);
    let b = rate * t;
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(u).powi(2) + dot(w).powi(2)) / 2 - 10 * (y + w);
    holonomic = [y * b.cos() - x * b.sin(), w];
    let s = mu * (dot(x) * b.cos() + dot(y) * b.sin()).signum();
    let k = 0.1 * dot(u).signum();
    constraint_forces = [(-b.sin() - s * b.cos(), b.cos() - s * b.sin(), 0, 0), (0, 0, -k, 1)];
}

/// The multipliers at all nodes up to a time, by steps and with a tolerance.
fn all<S: System<N>, const N: usize>(
    system: &S,
    start: Start<N>,
    h: f64,
    until: f64,
) -> [Vec<(f64, Vec<f64>)>; 2] {
    let mut by_steps = Vec::new();
    let mut flow = Flow::new(system, h, start).unwrap();
    by_steps.push((0.0, flow.multipliers(&flow.node())));
    while flow.node().t < until {
        flow.advance().unwrap();
        let node = flow.node();
        by_steps.push((node.t, flow.multipliers(&node)));
    }
    let mut exact = Vec::new();
    let mut flow = TaylorFlow::new(system, start, Tolerance::relative(1e-11)).unwrap();
    let times = (1..).map(|place| 0.1 * f64::from(place));
    for t in times.take_while(|t| *t < until + 0.05) {
        let node = flow.to(t).unwrap();
        exact.push((node.t, flow.multipliers(&node)));
    }
    [by_steps, exact]
}

#[test]
fn the_normal_force_of_a_block_at_rest_is_that_of_static_friction() {
    let mut random = Random::new(31);
    for draw in 0..12 {
        let slope = random.between(-0.9, 0.9);
        let gravity = random.decades(1e-2, 1e2);
        let mu = slope.abs() * random.between(1.02, 3.0);
        let block = Block { slope, mu, gravity };
        let normal = gravity / (1.0 + slope * slope);
        for (t, found) in all(&block, Start::second_order([0.0; 2], [0.0; 2]), 0.01, 0.5).concat() {
            assert!(
                (found[0] / normal - 1.0).abs() < 1e-12,
                "{draw}, t = {t}: {found:?} {normal}"
            );
        }
    }
}

#[test]
fn a_block_that_stops_passes_to_static_friction() {
    // it goes up the slope, stops at t = v / (g (slope + mu) / (1 + slope²)), and stays
    let (slope, mu, gravity) = (-0.3, 0.4, 10.0);
    let block = Block { slope, mu, gravity };
    let start = Start::second_order([0.0; 2], [1.0, 0.3]);
    for (t, found) in all(&block, start, 0.01, 0.5).concat() {
        // the form is as long as that of the constraint, whatever the friction
        let normal = gravity / (1.0 + slope * slope);
        assert!(
            (found[0] / normal - 1.0).abs() < 1e-9,
            "t = {t}: {found:?} {normal}"
        );
    }
}

#[test]
fn a_block_on_a_plank_that_turns_has_its_normal_force() {
    let plank = Plank { mu: 0.4, rate: 0.2 };
    let start = Start::second_order([2.0, 0.0, 0.0, 0.0], [0.0, 0.4, 5.0, 0.0]);
    // it slips once 10 sin(b) - 0.08 = 4 cos(b), at t = 1.94
    let error = |nodes: &[(f64, Vec<f64>)]| {
        nodes.iter().fold(0.0_f64, |most, (t, found)| {
            let normal = 10.0 * (0.2 * t).cos();
            most.max((found[0] - normal).abs()).max((found[1] - 10.0).abs())
        })
    };
    let [coarse, exact] = all(&plank, start, 0.02, 1.9);
    let [fine, _] = all(&plank, start, 0.01, 1.9);
    assert!(error(&exact) < 1e-8, "{}", error(&exact));
    // of second order in the step, with the force
    assert!(
        error(&coarse) < 1e-3 && error(&fine) < 0.3 * error(&coarse),
        "{} {}",
        error(&coarse),
        error(&fine)
    );
}

#[test]
fn one_who_slides_keeps_the_kinetic_friction() {
    let plank = Plank { mu: 0.1, rate: 0.2 };
    // down the plank, which turns under it: N = g cos(b) + 2 v rate
    let start = Start::second_order([2.0, 0.0, 0.0, 0.0], [-1.0, 0.4, 5.0, 0.0]);
    let mut flow = TaylorFlow::new(&plank, start, Tolerance::relative(1e-11)).unwrap();
    for place in 1..20 {
        let node = flow.to(0.05 * f64::from(place)).unwrap();
        let (sin, cos) = (0.2 * node.t).sin_cos();
        let slip = node.v[0] * cos + node.v[1] * sin;
        let found = flow.multipliers(&node);
        if slip.abs() > 1e-3 {
            let normal = 10.0 * cos + 0.4 * slip;
            assert!(
                (found[0] / normal - 1.0).abs() < 1e-9,
                "{node:?} {found:?} {normal}"
            );
        }
    }
}
