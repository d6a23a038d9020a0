//! The contact oscillator against equations by hand; the drift of its energy in a long run.

use dsocs_core::{Flow, Start, Stepper, System};
use dsocs_systems::ContactOscillator;

use super::{continuous, integrate, is_second, order, start};
use dsocs_tests::motion::distance;

/// The right-hand side for the state `(x, y, z, ẋ, ẏ, ż)`, with the multiplier of `(−y, 0, 1)` from the constraint's derivative.
fn by_hand(oscillator: &ContactOscillator, [x, y, z, vx, vy, vz]: [f64; 6]) -> [f64; 6] {
    let b = oscillator.field;
    let force = [
        -x + b * (vy - vz),
        -oscillator.stiffness_y * y + b * (vz - vx),
        -oscillator.stiffness_z * z + b * (vx - vy),
    ];
    let multiplier = (y * force[0] + vx * vy - force[2]) / (1.0 + y * y);
    [
        vx,
        vy,
        vz,
        force[0] - y * multiplier,
        force[1],
        force[2] + multiplier,
    ]
}

#[test]
fn it_moves_as_the_equations_by_hand_say() {
    let oscillator = ContactOscillator::default();
    let (q, v) = start::<3>("contact-oscillator");
    let end = integrate([q[0], q[1], q[2], v[0], v[1], v[2]], 10.0, |state| {
        by_hand(&oscillator, state)
    });
    let exact = [end[0], end[1], end[2]];
    let apart = distance(&continuous(&oscillator, (q, v), 10.0).0, &exact);
    println!("Taylor flow {apart:.1e}");
    assert!(apart < 1e-11, "{apart:e}");
    let steps = [0.1, 0.05, 0.025, 0.0125, 0.00625];
    is_second(order(&oscillator, (q, v), 10.0, &steps, |q| distance(q, &exact)));
}

/// The mean change of the energy over stretches of 10 000, relative to the start's.
fn stretches(oscillator: &ContactOscillator, count: u32) -> Vec<f64> {
    let (q, v) = start::<3>("contact-oscillator");
    let h = 0.1;
    let mut flow = Flow::new(oscillator, h, Start::second_order(q, v)).unwrap();
    let first = oscillator.energy(0.0, &q, &v);
    (0..count)
        .map(|_| {
            let mut sum = 0.0;
            for _ in 0..100_000 {
                flow.advance().unwrap();
                let leg = flow.leg();
                let middle = core::array::from_fn(|i| leg.q[i] - leg.d[i] / 2.0);
                sum += oscillator.energy(0.0, &middle, &leg.d.map(|d| d / h)) / first - 1.0;
            }
            sum / 1e5
        })
        .collect()
}

/// The largest minus the least mean change.
fn spread(means: &[f64]) -> f64 {
    let largest = means.iter().fold(f64::NEG_INFINITY, |largest, x| largest.max(*x));
    largest - means.iter().fold(f64::INFINITY, |least, x| least.min(*x))
}

#[test]
fn the_energy_drifts_unless_the_system_is_reversible() {
    let reversible = ContactOscillator {
        field: 0.0,
        ..ContactOscillator::default()
    };
    let kept = stretches(&reversible, 2);
    println!("without the field {kept:?}");
    assert!(spread(&kept) < 1e-6, "{kept:?}");
    // the motion is chaotic and its drift has no constant direction, so only the size is checked
    let drifting = stretches(&ContactOscillator::default(), 4);
    println!("with the field {drifting:?}");
    assert!(spread(&drifting) > 1e-2, "{drifting:?}");
}
