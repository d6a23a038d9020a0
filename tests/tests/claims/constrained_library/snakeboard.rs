//! The snakeboard against equations that are derived by hand.

use dsocs_core::{Flow, Start, Stepper};
use dsocs_systems::Snakeboard;

use super::{continuous, integrate, is_second, order, start};
use dsocs_tests::motion::distance;

#[test]
fn it_moves_as_the_reduced_equations_say() {
    let board = Snakeboard::default();
    let start = start::<5>("snakeboard");
    let ([x, y, theta, psi, phi], [.., psi_rate, phi_rate]) = start;
    let end = integrate([x, y, theta, psi, phi, 0.0, psi_rate, phi_rate], 10.0, |state| {
        board.reduced(state)
    });
    let exact: [f64; 5] = core::array::from_fn(|i| end[i]);
    let apart = distance(&continuous(&board, start, 10.0).0, &exact);
    println!("Taylor flow {apart:.1e}, {exact:?}");
    assert!(apart < 1e-10, "{apart:e}");
    // it has driven off
    assert!(exact[0].hypot(exact[1]) > 0.1, "{exact:?}");
    let steps = [0.04, 0.02, 0.01, 0.005, 0.0025];
    is_second(order(&board, start, 10.0, &steps, |q| distance(q, &exact)));
}

#[test]
fn a_free_rotor_keeps_its_momentum() {
    // turning the rotor is a virtual displacement and, without its spring, a symmetry: J_r (θ̇ + ψ̇) is kept
    let board = Snakeboard {
        rotor_spring: 0.0,
        ..Snakeboard::default()
    };
    let (q, mut v) = start::<5>("snakeboard");
    v[3] = 2.0;
    let mut flow = Flow::new(&board, 0.02, Start::second_order(q, v)).unwrap();
    let momentum = |d: [f64; 5]| (d[2] + d[3]) / 0.02;
    let first = momentum(flow.leg().d);
    let mut worst = 0.0_f64;
    while flow.time() < 100.0 {
        flow.advance().unwrap();
        worst = worst.max((momentum(flow.leg().d) / first - 1.0).abs());
    }
    println!("momentum of the rotor changes by {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn the_wheels_do_not_slip_on_any_leg() {
    let board = Snakeboard::default();
    let (q, v) = start::<5>("snakeboard");
    let mut flow = Flow::new(&board, 0.02, Start::second_order(q, v)).unwrap();
    let mut worst = 0.0_f64;
    while flow.time() < 40.0 {
        flow.advance().unwrap();
        let leg = flow.leg();
        let [_, _, theta, _, phi]: [f64; 5] = core::array::from_fn(|i| leg.q[i] - leg.d[i] / 2.0);
        for side in [1.0, -1.0] {
            let (sin, cos) = (theta + side * phi).sin_cos();
            let slip = cos * leg.d[1] - sin * leg.d[0] + side * board.length * phi.cos() * leg.d[2];
            worst = worst.max(slip.abs());
        }
    }
    println!("a leg slips by {worst:.1e}");
    assert!(worst < 1e-15, "{worst:e}");
}
