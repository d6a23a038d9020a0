//! The Chaplygin sleigh: its closed form, its energy, and its attractor.

use dsocs_core::{Flow, Start, Stepper, System};
use dsocs_systems::Sleigh;

use super::{continuous, fitted, integrate, is_second, order, start};
use dsocs_tests::motion::distance;

const STEPS: [f64; 5] = [0.1, 0.05, 0.025, 0.0125, 0.00625];

/// Direction, speed along the blade and rate.
fn reduced([_, _, theta]: [f64; 3], [x, y, rate]: [f64; 3]) -> [f64; 3] {
    [theta, x * theta.cos() + y * theta.sin(), rate]
}

#[test]
fn closed_form() {
    let sleigh = Sleigh {
        mass: 2.0,
        inertia: 0.7,
        offset: 0.4,
    };
    for rate in [0.3, -0.8] {
        let (q, mut v) = start("sleigh");
        v[2] = rate;
        let exact = sleigh.exact(reduced(q, v), 12.0);
        let (end, velocity) = continuous(&sleigh, (q, v), 12.0);
        let apart = distance(&reduced(end, velocity), &exact);
        println!("Taylor flow {apart:.1e}");
        assert!(apart < 1e-12, "{apart:e}");
        is_second(order(&sleigh, (q, v), 12.0, &STEPS, |q| (q[2] - exact[0]).abs()));
    }
}

#[test]
fn the_path_is_the_closed_forms_quadrature() {
    let sleigh = Sleigh::default();
    let (q, v) = start("sleigh");
    let begin = reduced(q, v);
    // time is the third component
    let [x, y, _] = integrate([0.0; 3], 12.0, |[_, _, t]| {
        let [theta, speed, _] = sleigh.exact(begin, t);
        [speed * theta.cos(), speed * theta.sin(), 1.0]
    });
    let exact = [x, y, sleigh.exact(begin, 12.0)[0]];
    let apart = distance(&continuous(&sleigh, (q, v), 12.0).0, &exact);
    println!("Taylor flow {apart:.1e}");
    assert!(apart < 1e-12, "{apart:e}");
    is_second(order(&sleigh, (q, v), 12.0, &STEPS, |q| distance(q, &exact)));
}

/// The node's direction and the motion of the next leg: the speed along the blade and the rate.
fn leg_state(flow: &Flow<'_, 3>) -> [f64; 2] {
    let leg = flow.leg();
    let middle = leg.q[2] - leg.d[2] / 2.0;
    let (sin, cos) = middle.sin_cos();
    [(leg.d[0] * cos + leg.d[1] * sin) / flow.h(), leg.d[2] / flow.h()]
}

#[test]
fn the_energy_is_kept_and_yet_there_is_an_attractor() {
    let sleigh = Sleigh::default();
    let (q, v) = start("sleigh");
    let energy = sleigh.energy(0.0, &q, &v);
    let k2 = 0.25 + 0.25;
    let end = (2.0 * energy).sqrt();
    // the largest change of the energy on legs, and the change at the end
    let run = |h: f64| {
        let mut flow = Flow::new(&sleigh, h, Start::second_order(q, v)).unwrap();
        let mut largest = 0.0_f64;
        loop {
            let [speed, rate] = leg_state(&flow);
            let change = f64::midpoint(speed * speed, k2 * rate * rate) / energy - 1.0;
            largest = largest.max(change.abs());
            if flow.time() >= 60.0 {
                return (largest, change, [speed, rate]);
            }
            flow.advance().unwrap();
        }
    };
    let steps = [0.1, 0.05, 0.025];
    let runs = steps.map(run);
    println!("largest and last change of the energy, and the last leg: {runs:?}");
    is_second(fitted(&steps, |h| run(h).0));
    for (h, (largest, _, [speed, rate])) in steps.into_iter().zip(runs) {
        // the sleigh turns from backwards to straight ahead: the rate decays, and the speed returns with the other
        // sign
        assert!(rate.abs() < 1e-12, "{rate:e}");
        assert!((speed / end - 1.0).abs() < largest, "h = {h}: {speed} {end}");
    }
}

#[test]
fn the_way_into_the_attractor_is_exponential_at_the_exact_rate() {
    let sleigh = Sleigh::default();
    // nearly straight ahead: ω falls by exp(−a V t / k²)
    let (q, v) = ([0.0; 3], [1.0, 0.0, 1e-3]);
    let rate = 0.5 / 0.5;
    is_second(fitted(&[0.2, 0.1, 0.05, 0.025], |h| {
        let mut flow = Flow::new(&sleigh, h, Start::second_order(q, v)).unwrap();
        let first = leg_state(&flow)[1];
        while flow.time() < 5.0 {
            flow.advance().unwrap();
        }
        let time = flow.time() - h;
        ((leg_state(&flow)[1] / first).ln() / time + rate).abs()
    }));
}
