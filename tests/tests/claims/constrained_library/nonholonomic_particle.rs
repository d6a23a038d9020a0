//! The nonholonomic particle against its closed form.

use dsocs_systems::NonholonomicParticle;

use super::{continuous, is_second, order, start};
use dsocs_tests::motion::distance;

#[test]
fn closed_form() {
    for slope in [1.0, -0.6] {
        let particle = NonholonomicParticle { mass: 2.0, slope };
        let (q, mut v) = start("nonholonomic-particle");
        v[2] = slope * q[1] * v[0];
        let exact = particle.exact(q, v, 10.0);
        let apart = distance(&continuous(&particle, (q, v), 10.0).0, &exact);
        println!("Taylor flow {apart:.1e}");
        assert!(apart < 1e-13, "{apart:e}");
        let steps = [0.1, 0.05, 0.025, 0.0125, 0.00625];
        is_second(order(&particle, (q, v), 10.0, &steps, |q| distance(q, &exact)));
    }
}

#[test]
fn straight_on_without_a_velocity_aside() {
    let particle = NonholonomicParticle::default();
    let (q, v) = ([0.0, 0.5, 0.0], [1.0, 0.0, 0.5]);
    let exact = particle.exact(q, v, 4.0);
    assert!(distance(&exact, &[4.0, 0.5, 2.0]) < 1e-15);
    assert!(distance(&continuous(&particle, (q, v), 4.0).0, &exact) < 1e-14);
}
