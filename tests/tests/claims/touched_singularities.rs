//! No run passes a place where the determinant of its law touches zero without a change of sign.

use dsocs_core::prelude::*;
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::{ComposedFlow, Flow, System};

declared! {
    /// A law whose determinant is a square that vanishes on a line, where its right-hand side does not.
    #[derive(Debug)]
    struct Touches { place: f64, slope: f64, push: f64, spring: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - spring / 2 * y.powi(2);
    kinematic = (place + slope * y - x).powi(2) * ddot(x) - push;
    constraint_forces = [(1, 0)];
}

declared! {
    /// A law whose right-hand side vanishes on the line too.
    #[derive(Debug)]
    struct Divides { place: f64, slope: f64, push: f64, spring: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - spring / 2 * y.powi(2);
    kinematic = (place + slope * y - x).powi(2) * (ddot(x) - push);
    constraint_forces = [(1, 0)];
}

/// Numbers of runs: `passed` and `ended` under `Touches`, `regular` and `refused` under `Divides`.
#[derive(Debug, Default)]
struct Counts {
    passed: u32,
    ended: u32,
    regular: u32,
    refused: u32,
}

/// Whether a node lies beyond the line, and whether the run ended with an error.
fn run<S: System<2>>(
    system: &S,
    h: f64,
    method: Option<Composition>,
    line: [f64; 2],
    v: [f64; 2],
) -> [bool; 2] {
    let start = Start::second_order([0.0, 0.0], v);
    let mut beyond = false;
    let mut look = |q: [f64; 2]| beyond |= q[0] > line[0] + line[1] * q[1];
    let ended = if let Some(method) = method {
        let mut flow = ComposedFlow::new(system, h, method, start).unwrap();
        flow.stream(4.0, &mut |node: &Node<2>| look(node.q)).is_err()
    } else {
        let mut flow = Flow::new(system, h, start).unwrap();
        flow.stream(4.0, &mut |node: &Node<2>| look(node.q)).is_err()
    };
    [beyond, ended]
}

#[test]
fn random_laws_end_where_their_determinant_touches_zero() {
    let mut counts = Counts::default();
    for draw in 0..60 {
        let mut random = Random::new(700 + draw);
        let place = random.between(0.3, 1.2);
        let slope = random.between(-0.5, 0.5);
        let push = random.decades(1e-2, 0.3);
        let spring = random.between(0.5, 4.0);
        let v = [random.between(0.4, 1.5), random.between(-0.5, 0.5)];
        let h = random.decades(1e-3, 4e-2);
        let methods = [
            None,
            Some(Composition::SUZUKI_4),
            Some(Composition::KAHAN_LI_6),
            Some(Composition::KAHAN_LI_8),
        ];
        for method in methods {
            let law = Touches {
                place,
                slope,
                push,
                spring,
            };
            let [beyond, ended] = run(&law, h, method, [place, slope], v);
            counts.passed += u32::from(beyond && !ended);
            counts.ended += u32::from(ended);
            if beyond && !ended {
                println!("{draw} {h} {law:?} {v:?} {method:?}");
            }
            let law = Divides {
                place,
                slope,
                push,
                spring,
            };
            let [beyond, ended] = run(&law, h, method, [place, slope], v);
            counts.regular += u32::from(beyond);
            counts.refused += u32::from(ended);
            if ended {
                println!("refused {draw} {h} {law:?} {v:?} {method:?}");
            }
        }
    }
    println!("{counts:?}");
    assert!(counts.passed == 0 && counts.refused == 0, "{counts:?}");
    assert!(counts.ended > 200 && counts.regular > 200, "{counts:?}");
}

declared! {
    /// A free particle in polar coordinates, whose mass vanishes at the origin.
    #[derive(Debug)]
    struct Polar {};
    coordinates(r, phi);
    lagrangian = (dot(r).powi(2) + (r * dot(phi)).powi(2)) / 2;
}

#[test]
fn compositions_tell_of_a_mass_that_nearly_vanishes() {
    let mut random = Random::new(6);
    for _ in 0..24 {
        // on the line x = 1 - t, y = b
        let b = 10.0_f64.powf(random.between(-5.0, -3.0));
        let h = random.between(0.01, 0.03);
        let r = b.hypot(1.0);
        for method in [
            Composition::SUZUKI_4,
            Composition::KAHAN_LI_6,
            Composition::KAHAN_LI_8,
        ] {
            let near = Start::second_order([r, b.atan()], [-1.0 / r, b / r.powi(2)]);
            let mut flow = ComposedFlow::new(&Polar {}, h, method, near).unwrap();
            let ended = flow.to(100.0 * h).is_err();
            assert!(ended || flow.nearly_singular().is_some(), "{b} {h} {method:?}");
            // far from it there is no warning
            let far = Start::second_order([1.5_f64.sqrt(), 0.0], [-0.5, 1.0]);
            let mut flow = ComposedFlow::new(&Polar {}, h, method, far).unwrap();
            flow.to(100.0 * h).unwrap();
            assert!(flow.nearly_singular().is_none(), "{h} {method:?}");
        }
    }
}
