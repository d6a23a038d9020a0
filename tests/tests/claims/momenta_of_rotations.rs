//! Momenta of a body with a rotor: those of the legs are kept to rounding; those of the nodes are off by
//! order `h²` and do not drift.

use dsocs_core::text::Text;
use dsocs_core::{AnyFlow, AnyStart, Declaration, OwnedNode};

use dsocs_tests::vectors::{Matrix, Vector, cross, dot, matrix, plus, product, times};

/// A body with a rotor about its third axis.
const TEXT: &str = "parameters { inertia = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]], rotor = 0.3 }
    coordinates(r: rotation, psi);
    let w = r.angular_velocity();
    lagrangian = w.inner(inertia * w) / 2 + rotor * (w[2] + dot(psi)).powi(2) / 2;
    let momentum = r * (inertia * w + [0, 0, rotor * (w[2] + dot(psi))]);
    observe = [momentum];";

const INERTIA: Matrix = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]];
const ROTOR: f64 = 0.3;

/// The momenta of a leg: the total one in space from its second node, `R T(x)ᵀ p` with the tangent `T` of the
/// Padé map, and the rotor's.
fn of_leg(q: &[f64], d: &[f64], h: f64) -> [f64; 4] {
    let x: Vector = [d[1], d[2], d[3]];
    let w = times(1.0 / h, x);
    let own = ROTOR * (w[2] + d[4] / h);
    let p = plus(product(&INERTIA, w), [0.0, 0.0, own]);
    let s = dot(x, x);
    let (a, b) = (1.0 - s / 48.0, s / 16.0);
    let (c, e) = ((a * a - b) / a, (0.125 - a * a / 24.0) / (a * (1.0 + s / 48.0)));
    let turned = plus(
        times(c, p),
        plus(times(0.5, cross(p, x)), times(e * dot(x, p), x)),
    );
    let [l, m, n] = product(&matrix([q[0], q[1], q[2], q[3]]), turned);
    [l, m, n, own]
}

/// The largest changes of the legs' momenta, and of the nodes' momenta from the exact ones in the first and
/// the second half of the run.
fn momentum_changes(h: f64) -> [f64; 3] {
    const UNTIL: f64 = 200.0;
    let text = Text::parse("body", TEXT).unwrap();
    let start = AnyStart::second_order(&[1.0, 0.0, 0.0, 0.0, 0.0], &[0.6, -0.3, 1.2, 4.0]);
    let mut flow = AnyFlow::new(&text.system, h, &start).unwrap();
    let leg = flow.leg();
    let first = of_leg(leg.q, leg.d, h);
    let known = [1.2 - 0.03, 0.06 - 0.45 + 0.24, -0.06 + 1.2 + ROTOR * 5.2];
    let mut most = [0.0_f64; 3];
    let mut node = OwnedNode::new(5);
    let declaration = Declaration::of(&text.system);
    while flow.run().clock().time() < UNTIL {
        flow.run_mut().advance().unwrap();
        let leg = flow.leg();
        for (now, first) in of_leg(leg.q, leg.d, h).iter().zip(first) {
            most[0] = most[0].max((now - first).abs());
        }
        node.take(flow.run());
        let mut observed = [0.0; 3];
        declaration.observe(node.any().point(), &mut observed);
        let half = if node.any().t < 0.5 * UNTIL { 1 } else { 2 };
        for (now, known) in observed.iter().zip(known) {
            most[half] = most[half].max((now - known).abs());
        }
    }
    most
}

#[test]
fn those_of_legs_are_kept_to_rounding_and_those_of_nodes_do_not_drift() {
    let [coarse, fine] = [0.04, 0.02].map(momentum_changes);
    println!("{coarse:?} {fine:?}");
    for [leg, early, late] in [coarse, fine] {
        assert!(leg < 1e-12, "{leg:e}");
        assert!(late < 1.05 * early, "{early:e} {late:e}");
    }
    assert!((coarse[1] / fine[1]).log2() > 1.95, "{coarse:?} {fine:?}");
}
