//! The train against its steady motion in closed form.

use dsocs_core::{Flow, Start, Stepper};
use dsocs_systems::Train;

use super::is_second;
use dsocs_tests::motion::{continuous, discrete, distance};

/// The closed form against the equations of motion with complex amplitudes, mass by mass.
#[test]
fn the_amplitudes_solve_the_equations_of_motion() {
    for frequency in [0.3, 1.0, 2.4, 3.9, 7.0] {
        let train = Train {
            frequency,
            ..Train::default()
        };
        let inner = train.amplitudes();
        let [k, c] = [train.stiffness, train.damping * frequency];
        let at = |j: usize| match j {
            0 => [train.amplitude, 0.0],
            6 => [0.0; 2],
            j => inner[j - 1],
        };
        for j in 1..6 {
            let bend = [0, 1].map(|part| at(j + 1)[part] - 2.0 * at(j)[part] + at(j - 1)[part]);
            let force = [k * bend[0] - c * bend[1], k * bend[1] + c * bend[0]];
            let inertia = at(j).map(|x| train.mass * frequency * frequency * x);
            let left = (force[0] + inertia[0]).hypot(force[1] + inertia[1]);
            assert!(
                left < 1e-14 * (1.0 + frequency * frequency),
                "{frequency}, {j}: {left:e}"
            );
        }
    }
}

#[test]
fn a_train_that_is_in_step_stays_so() {
    let train = Train::default();
    let (q, v) = train.steady(0.3);
    let start = Start::second_order(q, v).at(0.3);
    let (known, velocity) = train.steady(20.3);
    let node = continuous(&train, start, 20.3);
    assert!(distance(&node.q, &known) < 2e-14 && distance(&node.v, &velocity) < 5e-14);
    is_second("steady", [0.04, 0.02, 0.01, 0.005], |h| {
        distance(&discrete(&train, h, start, 20.3).q, &known)
    });
}

/// From rest the first mode decays with exp(−0.04 t): after 600 s what is left of the start is 1e-11, and the discrete motion
/// has the amplitude to second order.
#[test]
fn every_motion_tends_to_the_steady_one() {
    let train = Train::default();
    let t = 600.0;
    let (known, _) = train.steady(t);
    let apart = distance(
        &continuous(&train, Start::second_order([0.0; 5], [0.0; 5]), t).q,
        &known,
    );
    println!("from rest: {apart:.1e}");
    assert!(apart < 1e-10, "{apart:e}");
    let largest = |h: f64| {
        let mut flow = Flow::new(&train, h, Start::second_order([0.0; 5], [0.0; 5])).unwrap();
        let nodes = flow.until(t).unwrap().nodes;
        let last = nodes.iter().filter(|node| node.t > t - 20.0);
        last.fold([0.0_f64; 5], |most, node| {
            core::array::from_fn(|j| most[j].max(node.q[j].abs()))
        })
    };
    let amplitudes = train.amplitudes().map(|[re, im]| re.hypot(im));
    let found = largest(0.02);
    for (found, amplitude) in found.iter().zip(amplitudes) {
        assert!((found / amplitude - 1.0).abs() < 2e-3, "{found} {amplitude}");
    }
}
