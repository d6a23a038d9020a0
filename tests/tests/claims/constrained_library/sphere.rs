//! The pendulum on the sphere against the one in angles, and its invariants.

use dsocs_core::geometry::{DiscreteFlow, momentum_map};
use dsocs_core::{Flow, Start, Stepper, System};
use dsocs_systems::{Sphere, SphericalPendulum};

use super::{continuous, is_second, order, start};
use dsocs_tests::motion::distance;

#[test]
fn it_is_the_spherical_pendulum_in_angles() {
    let (sphere, angles) = (Sphere::default(), SphericalPendulum::default());
    let (q, v) = ([1.0, 0.3], [0.5, 2.0]);
    let (end, rate) = continuous(&angles, (q, v), 5.0);
    let (exact, _) = sphere.of_angles(end, rate);
    let start = sphere.of_angles(q, v);
    let apart = distance(&continuous(&sphere, start, 5.0).0, &exact);
    println!("Taylor flows apart by {apart:.1e}");
    assert!(apart < 1e-11, "{apart:e}");
    let steps = [0.02, 0.01, 0.005, 0.0025, 0.00125];
    is_second(order(&sphere, start, 5.0, &steps, |q| distance(q, &exact)));
}

#[test]
fn energy_and_angular_momentum_stay() {
    let sphere = Sphere::default();
    assert_eq!((Sphere::FORMS, Sphere::HOLONOMIC), (1, 1));
    let (q, v) = start("sphere");
    let run = |h: f64| {
        let map = DiscreteFlow::new(&sphere, h).unwrap();
        let mut flow = Flow::new(&sphere, h, Start::second_order(q, v)).unwrap();
        let momentum = |flow: &Flow<'_, 3>| momentum_map(&map, flow.leg().any(), &|q| vec![-q[1], q[0], 0.0]);
        let (first, energy) = (momentum(&flow), sphere.energy(0.0, &q, &v));
        let mut worst = [0.0_f64; 3];
        while flow.time() < 200.0 {
            flow.advance().unwrap();
            let node = flow.node();
            worst[0] = worst[0].max((momentum(&flow) / first - 1.0).abs());
            worst[1] = worst[1].max((node.energy - energy).abs());
            let [x, y, z] = node.q;
            worst[2] = worst[2].max((x.hypot(y).hypot(z) - 1.0).abs());
        }
        println!("h = {h}: momentum, energy, length {worst:?}");
        worst
    };
    let (coarse, fine) = (run(0.02), run(0.01));
    for worst in [coarse, fine] {
        assert!(worst[0] < 1e-12 && worst[2] < 1e-14, "{worst:?}");
    }
    assert!(
        (coarse[1] / fine[1] / 4.0 - 1.0).abs() < 0.1,
        "{coarse:?} {fine:?}"
    );
}
