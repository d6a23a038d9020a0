//! Kapitza's pendulum against its equation of motion, the threshold of Mathieu's equation and the effective potential.

use std::f64::consts::TAU;

use dsocs_core::{Event, Events, Flow, Occurrence, Start, Stepper, on_event};
use dsocs_systems::Kapitza;

use super::is_second;
use dsocs_tests::dop853;
use dsocs_tests::motion::{continuous, discrete};

#[test]
fn it_obeys_its_equation_of_motion() {
    let pendulum = Kapitza::default();
    let rate = |t: f64, [theta, v]: [f64; 2]| {
        let lift = 9.81 - 0.05 * 150.0_f64.powi(2) * (150.0 * t).cos();
        [v, lift * theta.sin()]
    };
    let [theta, v] = dop853::integrate_from(rate, (0.01, [0.3, 0.1]), 2.01, 1e-14);
    let start = Start::second_order([0.3], [0.1]).at(0.01);
    let node = continuous(&pendulum, start, 2.01);
    println!("apart by {:.1e}, {:.1e}", node.q[0] - theta, node.v[0] - v);
    assert!((node.q[0] - theta).abs() < 1e-11 && (node.v[0] - v).abs() < 1e-9);
    is_second("angle", [0.0008, 0.0004, 0.0002, 0.0001], |h| {
        (discrete(&pendulum, h, start, 2.01).q[0] - theta).abs()
    });
}

/// The trace of the map over a period near the upright position: upright is stable where it lies between −2 and 2.
fn trace(pendulum: &Kapitza) -> f64 {
    let (period, small) = (TAU / pendulum.frequency, 1e-7);
    let one = continuous(pendulum, Start::second_order([small], [0.0]), period);
    let other = continuous(pendulum, Start::second_order([0.0], [small]), period);
    (one.q[0] + other.v[0]) / small
}

/// The amplitude at which upright becomes stable, by bisection.
fn threshold(pendulum: &Kapitza) -> f64 {
    let (mut below, mut above) = (
        0.9 * pendulum.critical_amplitude(),
        1.2 * pendulum.critical_amplitude(),
    );
    for _ in 0..40 {
        let amplitude = f64::midpoint(below, above);
        if trace(&Kapitza {
            amplitude,
            ..*pendulum
        }) > 2.0
        {
            below = amplitude;
        } else {
            above = amplitude;
        }
    }
    above
}

/// Mathieu's equation has the threshold `4 g/(l ω²) = 2 (a/l)² − 7/8 (a/l)⁴ + …` (Abramowitz and Stegun, 20.2.25); the first
/// term is Kapitza's.
#[test]
fn upright_becomes_stable_at_the_known_amplitude() {
    let mut missed = Vec::new();
    for frequency in [40.0, 80.0, 160.0] {
        let pendulum = Kapitza {
            frequency,
            ..Kapitza::default()
        };
        let (found, kapitza) = (threshold(&pendulum), pendulum.critical_amplitude());
        let square = found * found;
        let next = 2.0 * square - 7.0 / 8.0 * square * square;
        let wanted = 4.0 * 9.81 / (frequency * frequency);
        println!(
            "ω = {frequency}: a = {found}, {:.2e} from Kapitza's",
            found / kapitza - 1.0
        );
        // 7/32 (a/l)², and what is left beyond the fourth power is of the sixth
        assert!(
            (found / kapitza - 1.0 - 7.0 / 32.0 * square).abs() < 0.1 * square,
            "{found}"
        );
        missed.push((next / wanted - 1.0).abs() / square.powi(2));
    }
    // 29/144 · 2⁶/2 …: bounded, as the next coefficient says (−29 q⁶/2304, q = 2a/l)
    for missed in missed {
        assert!((missed - 29.0 * 32.0 / 2304.0).abs() < 0.1, "{missed}");
    }
}

#[test]
fn above_the_amplitude_it_swings_and_below_it_falls() {
    let pendulum = Kapitza {
        frequency: 300.0,
        amplitude: 0.0,
        ..Kapitza::default()
    };
    let critical = pendulum.critical_amplitude();
    let start = Start::second_order([0.01], [0.0]);
    let farthest = |amplitude: f64| {
        let pendulum = Kapitza {
            amplitude,
            ..pendulum
        };
        let mut flow = Flow::new(&pendulum, 0.0005, start).unwrap();
        let nodes = flow.until(30.0).unwrap().nodes;
        nodes.iter().fold(0.0_f64, |most, node| most.max(node.q[0].abs()))
    };
    let (falls, stays) = (farthest(0.95 * critical), farthest(1.05 * critical));
    println!("at 0.95 and 1.05 of the critical amplitude it gets to {falls} and {stays}");
    assert!(falls > 1.0 && stays < 0.012, "{falls} {stays}");
    // well above, the period of slow swings is that of the effective potential, with an error that shrinks with the amplitude
    let apart = |frequency: f64| {
        let pendulum = Kapitza {
            frequency,
            amplitude: 2.0 * 2.0_f64.sqrt() * 9.81_f64.sqrt() / frequency,
            ..pendulum
        };
        let mut flow = Flow::new(&pendulum, 0.05 / frequency, start).unwrap();
        let mut crossings = Vec::new();
        flow.watch(
            6.0,
            &mut Events::new(vec![Event::function(|point| point.q[0])]),
            &mut on_event(|event: &Occurrence<1>| crossings.push(event.t)),
        )
        .unwrap();
        let periods = (crossings.len() - 1) as f64 / 2.0;
        let slow = TAU * periods / (crossings[crossings.len() - 1] - crossings[0]);
        (slow / pendulum.slow_frequency().unwrap() - 1.0).abs()
    };
    let (coarse, fine) = (apart(200.0), apart(800.0));
    println!("slow frequency off by {coarse:.1e}, {fine:.1e}");
    assert!(coarse < 0.02 && fine < coarse / 3.0, "{coarse:e} {fine:e}");
    assert_eq!(
        Kapitza {
            amplitude: 0.9 * critical,
            ..pendulum
        }
        .slow_frequency(),
        None
    );
}
