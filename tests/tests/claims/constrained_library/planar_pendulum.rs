//! The planar pendulum against its angle's equation, its period and the tension.

use dsocs_core::{Flow, Start, Stepper};
use dsocs_systems::PlanarPendulum;

use super::{continuous, fitted, integrate, is_second, order, start};
use dsocs_tests::motion::distance;

/// Small ones: the swing is fast, and terms of higher order show at larger steps.
const STEPS: [f64; 5] = [0.0025, 0.00125, 0.000_625, 0.000_312_5, 0.000_156_25];

/// The position of the pendulum, and the rate of its angle, by `θ̈ = −(g/l) sin θ`.
fn by_angle(t: f64) -> ([f64; 2], f64) {
    let (q, v) = start::<2>("planar-pendulum");
    let [angle, rate] = integrate(
        [q[0].atan2(-q[1]), q[0] * v[1] - q[1] * v[0]],
        t,
        |[angle, rate]| [rate, -9.81 * angle.sin()],
    );
    ([angle.sin(), -angle.cos()], rate)
}

#[test]
fn it_is_the_pendulum_in_its_angle() {
    let pendulum = PlanarPendulum::default();
    let start = start("planar-pendulum");
    let (exact, _) = by_angle(5.0);
    let apart = distance(&continuous(&pendulum, start, 5.0).0, &exact);
    println!("Taylor flow {apart:.1e}");
    assert!(apart < 1e-11, "{apart:e}");
    is_second(order(&pendulum, start, 5.0, &STEPS, |q| distance(q, &exact)));
}

#[test]
fn the_multiplier_is_the_tension_to_second_order() {
    let pendulum = PlanarPendulum::default();
    let (q, v) = start("planar-pendulum");
    let (position, rate) = by_angle(2.0);
    let tension = pendulum.tension(position, [-position[1] * rate, position[0] * rate]);
    is_second(fitted(&STEPS, |h| {
        let mut flow = Flow::new(&pendulum, h, Start::second_order(q, v)).unwrap();
        let nodes = flow.until(2.0).unwrap().nodes;
        (flow.multipliers(nodes.last().unwrap())[0] + tension).abs()
    }));
}

#[test]
fn a_swing_takes_the_period_of_the_elliptic_integral() {
    let pendulum = PlanarPendulum {
        mass: 2.0,
        length: 0.7,
        gravity: 9.81,
    };
    // to 2.5 rad, and back there after whole periods
    let amplitude = 2.5_f64;
    let q = [0.7 * amplitude.sin(), -0.7 * amplitude.cos()];
    let t = 3.0 * pendulum.period(amplitude);
    let apart = distance(&continuous(&pendulum, (q, [0.0; 2]), t).0, &q);
    println!("Taylor flow {apart:.1e}");
    assert!(apart < 1e-10, "{apart:e}");
    // near the turning point the error of the phase is one of second order in it; at a quarter it shows
    let quarter = t / 12.0;
    let steps = [200.0, 400.0, 800.0, 1600.0].map(|parts| quarter / parts);
    is_second(order(&pendulum, (q, [0.0; 2]), quarter, &steps, |q| {
        distance(q, &[0.0, -0.7])
    }));
}

#[test]
fn the_energy_stays_and_the_rod_keeps_its_length() {
    let pendulum = PlanarPendulum::default();
    let (q, v) = start("planar-pendulum");
    let mut worst = [0.0_f64; 2];
    let swing = |h: f64, worst: &mut [f64; 2]| {
        let mut flow = Flow::new(&pendulum, h, Start::second_order(q, v)).unwrap();
        let nodes = flow.until(200.0).unwrap().nodes;
        let first = nodes[0].energy;
        nodes.iter().fold(0.0_f64, |change, node| {
            worst[0] = worst[0].max((node.q[0].hypot(node.q[1]) - 1.0).abs());
            change.max((node.energy - first).abs())
        })
    };
    let coarse = swing(0.02, &mut worst);
    let fine = swing(0.01, &mut worst);
    println!(
        "energy changes by {coarse:.2e}, {fine:.2e}; length by {:.1e}",
        worst[0]
    );
    // bounded over a hundred swings and of second order: a drift would not be
    assert!((coarse / fine / 4.0 - 1.0).abs() < 0.1, "{coarse:e} {fine:e}");
    assert!(worst[0] < 1e-14, "{worst:?}");
}
