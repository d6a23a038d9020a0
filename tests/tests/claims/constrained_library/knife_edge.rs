//! The knife edge against its closed form, the cycloid.

use dsocs_core::{Node, Start, Stepper};
use dsocs_systems::KnifeEdge;
use dsocs_tests::declared;
use dsocs_tests::text::Flow;

use super::{continuous, fitted, is_second, order, start};
use dsocs_tests::motion::distance;

const STEPS: [f64; 5] = [0.1, 0.05, 0.025, 0.0125, 0.00625];

#[test]
fn a_cycloid_from_rest() {
    let edge = KnifeEdge::default();
    let (start, t) = (start("knife-edge"), 7.0_f64);
    // the textbook's formulas, for the rate 1
    let half = 9.81 * 0.1_f64.sin() / 2.0;
    let exact = [half * t.sin().powi(2), half * (t - (2.0 * t).sin() / 2.0), t];
    let apart = distance(&edge.exact(start.0, start.1, t), &exact);
    assert!(apart < 1e-14, "{apart:e}");
    let apart = distance(&continuous(&edge, start, t).0, &exact);
    println!("Taylor flow {apart:.1e}");
    assert!(apart < 1e-13, "{apart:e}");
    is_second(order(&edge, start, t, &STEPS, |q| distance(q, &exact)));
}

declared! {
    /// The knife edge with the paper's map: the constraint is imposed at the first node of each leg.
    struct OneSided {
        inertia: f64,
        slope: f64,
    }
    coordinates(x, y, phi);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + inertia * dot(phi).powi(2)) / 2 + slope * x;
    nonholonomic = dot(x) * phi.sin() - dot(y) * phi.cos();
    phi_lagrangian = paper;
}

/// Without a declared map the step is of order 2 and much nearer than with the paper's.
#[test]
fn a_declaration_without_a_map() {
    let edge = KnifeEdge::default();
    let one_sided = OneSided {
        inertia: edge.inertia,
        slope: 9.81 * 0.1_f64.sin(),
    };
    let ((q, v), t, h) = (start("knife-edge"), 4.0, 0.02);
    let exact = edge.exact(q, v, t);
    let apart = |nodes: Vec<Node<3>>| distance(&nodes.last().unwrap().q, &exact);
    let begin = Start::second_order(q, v);
    let default = apart(Flow::new(&edge, h, begin).unwrap().until(t).unwrap().nodes);
    let paper = apart(Flow::new(&one_sided, h, begin).unwrap().until(t).unwrap().nodes);
    println!("t = {t}, h = {h}: {default:.2e} without a map, {paper:.2e} with the paper's");
    assert!(default < 1.5e-4 && paper > 0.04, "{default:e} {paper:e}");
    let order = fitted(&STEPS, |h| {
        let nodes = Flow::new(&one_sided, h, begin).unwrap().until(t).unwrap().nodes;
        distance(&nodes.last().unwrap().q, &exact)
    });
    assert!((order - 1.0).abs() < 0.1, "{order}");
}

#[test]
fn any_start() {
    let edge = KnifeEdge {
        mass: 2.0,
        inertia: 0.3,
        gravity: 9.81,
        incline: 0.4,
    };
    let heading =
        |speed: f64, phi: f64, rate| ([0.5, -0.2, phi], [speed * phi.cos(), speed * phi.sin(), rate]);
    // small steps from the exact second node: with the start of second order, its third-order error in the
    // rate would dominate at these speeds
    let steps = STEPS.map(|h| h / 16.0);
    for start in [heading(0.8, 2.0, -0.9), heading(-1.2, -0.7, 0.3)] {
        let exact = edge.exact(start.0, start.1, 5.0);
        let apart = distance(&continuous(&edge, start, 5.0).0, &exact);
        println!("Taylor flow {apart:.1e}");
        assert!(apart < 1e-12, "{apart:e}");
        is_second(fitted(&steps, |h| {
            let begin = Start::second_order(start.0, start.1).exact(&edge, h).unwrap();
            let nodes = Flow::new(&edge, h, begin).unwrap().until(5.0).unwrap().nodes;
            distance(&nodes.last().unwrap().q, &exact)
        }));
    }
    // without rotation it slides down along a line
    let start = heading(0.8, 1.0, 0.0);
    let exact = edge.exact(start.0, start.1, 5.0);
    assert!(distance(&continuous(&edge, start, 5.0).0, &exact) < 1e-13);
}

#[test]
fn it_does_not_slide_down() {
    let edge = KnifeEdge::default();
    let (q, v) = start("knife-edge");
    let lowest = 9.81 * 0.1_f64.sin() / 2.0;
    let mut flow = Flow::new(&edge, 0.05, Start::second_order(q, v)).unwrap();
    let (mut least, mut most) = (0.0_f64, 0.0_f64);
    while flow.time() < 1000.0 {
        flow.advance().unwrap();
        (least, most) = (least.min(flow.position()[0]), most.max(flow.position()[0]));
    }
    println!("x between {least:e} and {most} over 159 turns; exactly {lowest}");
    assert!(
        least > -1e-3 * lowest && (most / lowest - 1.0).abs() < 2e-3,
        "{least} {most}"
    );
}
