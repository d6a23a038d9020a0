//! Ensembles of systems with rotations: their lanes against single flows.

use dsocs_core::taylor::TaylorEnsemble;
use dsocs_core::text::Text;
use dsocs_core::{
    AnyEnsemble, AnyFlow, AnyStart, Ensemble, Flow, Instructions, OwnedNode, Start, Stepper, TaylorFlow,
    Tolerance, dsocs,
};

use crate::rotations::joined;
use dsocs_tests::vectors::unit;

/// A top and a mass that is bound to it, under a held torque.
#[dsocs {
    coordinates(x, r: rotation);
    let w = r.angular_velocity();
    lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - weight * (r * [0.2, 0.1, 1])[2] + dot(x).powi(2) / 2 - x * (r * [0, 1, 0])[0];
    external_forces = (-0.1 * dot(x), [0, 0, torque] - 0.1 * w);
}]
struct Top {
    weight: f64,
    torque: f64,
}

const TEXT: &str = "parameters { weight = 1.0, torque = 0.3 }
    coordinates(x, r: rotation);
    let w = r.angular_velocity();
    lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - weight * (r * [0.2, 0.1, 1])[2] + dot(x).powi(2) / 2 - x * (r * [0, 1, 0])[0];
    external_forces = (-0.1 * dot(x), [0, 0, torque] - 0.1 * w);";

/// Starts that turn about all axes, for more than one block of lanes.
fn starts() -> Vec<([f64; 5], [f64; 5])> {
    (0..11)
        .map(|i| {
            let s = f64::from(i);
            let q = unit([1.0 - 0.15 * s, 0.3, 0.1 * s, -0.2 * s]);
            let q0 = joined(&[&[0.1 * s], &q]);
            (q0, [0.2, 0.0, 0.6 - 0.1 * s, 0.3 * s, 2.0 - 0.5 * s])
        })
        .collect()
}

/// The largest distance of two positions and velocities.
fn distance(one: [&[f64]; 2], other: [&[f64]; 2]) -> f64 {
    let pairs = one.into_iter().flatten().zip(other.into_iter().flatten());
    pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}

#[test]
fn lanes_go_as_flows_do() {
    let top = Top {
        weight: 1.0,
        torque: 0.3,
    };
    let text = Text::parse("top", TEXT).unwrap();
    let (h, until) = (0.01, 20.0);
    let weights: Vec<f64> = (0..11).map(|i| 0.5 + 0.1 * f64::from(i)).collect();
    let all = starts().into_iter().map(|(q0, v0)| Start::second_order(q0, v0));
    let ensemble = Ensemble::new(&top, h).unwrap().starts(all);
    let ensemble = ensemble.varied("weight", weights.iter().copied()).unwrap();
    let compiled: Vec<_> = ensemble.to(until).into_iter().map(|end| end.unwrap()).collect();
    // velocities with three numbers for the rotation
    let all = starts()
        .into_iter()
        .map(|(q0, v0)| AnyStart::second_order(&q0, &[v0[0], v0[2], v0[3], v0[4]]));
    let ensemble = AnyEnsemble::of_tape(&text.system, h).unwrap().starts(all);
    let ensemble = ensemble.varied("weight", weights.iter().copied()).unwrap();
    let walked: Vec<_> = ensemble.to(until).into_iter().map(|end| end.unwrap()).collect();
    for (place, (q0, v0)) in starts().into_iter().enumerate() {
        let own = Top {
            weight: weights[place],
            torque: 0.3,
        };
        let mut flow = Flow::new(&own, h, Start::second_order(q0, v0)).unwrap();
        let known = flow.to(until).unwrap();
        let found = &compiled[place];
        let distance = distance([&found.q, &found.v], [&known.q, &known.v]);
        assert!(distance < 1e-10, "{place}: {distance:e}");
        let norm = found.q[1..].iter().map(|q| q * q).sum::<f64>().sqrt();
        assert!((norm - 1.0).abs() <= 2.0 * f64::EPSILON, "{norm}");
        assert_eq!(found.v[1].to_bits(), 0);
        // the system from its text has the bits of the compiled one
        let read = walked[place].any();
        let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found.q), bits(read.q), "{place}");
        assert_eq!(bits(&found.v), bits(read.v), "{place}");
    }
}

#[test]
fn inputs_that_are_held_change_in_lanes() {
    let text = Text::parse("top", TEXT).unwrap();
    let h = 0.02;
    let plans = (0..11).map(|i| vec![[0.0, 0.3], [1.0, -0.2 * f64::from(i)], [2.0, 0.5]]);
    let all = starts()
        .into_iter()
        .map(|(q0, v0)| AnyStart::second_order(&q0, &v0));
    let ensemble = AnyEnsemble::of_tape(&text.system, h).unwrap().starts(all);
    let ends = ensemble.held("torque", plans).unwrap().to(3.0);
    for (place, (q0, v0)) in starts().into_iter().enumerate() {
        let mut flow = AnyFlow::new(&text.system, h, &AnyStart::second_order(&q0, &v0)).unwrap();
        for (t, value) in [(1.0, -0.2 * place as f64), (2.0, 0.5)] {
            // the step knows one position beyond its node
            flow.run_mut().to(t - h).unwrap();
            flow.run_mut().set_value(1, value).unwrap();
        }
        flow.run_mut().to(3.0).unwrap();
        let mut node = OwnedNode::new(5);
        node.take(flow.run());
        let (known, found) = (node.any(), ends[place].as_ref().unwrap().any());
        let distance = distance([found.q, found.v], [known.q, known.v]);
        assert!(distance < 1e-11, "{place}: {distance:e}");
    }
}

#[test]
fn a_lane_that_turns_too_far_ends_alone() {
    let text = Text::parse(
        "driven",
        "coordinates(r: rotation); lagrangian = r.angular_velocity().norm_squared() / 2; external_forces = [0, 0, 1];",
    )
    .unwrap();
    let spins = [0.0, 5.0, 20.0, -15.0, 10.0];
    let starts = spins.map(|spin| AnyStart::second_order(&[1.0, 0.0, 0.0, 0.0], &[0.0, 0.0, spin]));
    let ends = AnyEnsemble::of_tape(&text.system, 0.1)
        .unwrap()
        .starts(starts.clone())
        .to(15.0);
    for ((spin, start), end) in spins.into_iter().zip(&starts).zip(ends) {
        match end {
            // 3 rad per step are reached at 30 rad/s
            Err(error) => assert!(
                spin > 15.0 && error.to_string().contains("half a turn"),
                "{spin}: {error}"
            ),
            Ok(node) => {
                assert!(spin < 15.0);
                let mut flow = AnyFlow::new(&text.system, 0.1, start).unwrap();
                flow.run_mut().to(15.0).unwrap();
                let mut known = OwnedNode::new(4);
                known.take(flow.run());
                let distance = distance([node.any().q, node.any().v], [known.any().q, known.any().v]);
                assert!(distance < 1e-9, "{spin}: {distance:e}");
            }
        }
    }
}

#[test]
fn series_in_lanes_go_as_those_of_flows_do() {
    let top = Top {
        weight: 1.0,
        torque: 0.3,
    };
    let all = || starts().into_iter().map(|(q0, v0)| Start::second_order(q0, v0));
    for bar in [1e-6, 1e-12] {
        let tolerance = Tolerance::relative(bar);
        let lanes = TaylorEnsemble::new(&top, tolerance).unwrap().starts(all());
        let found: Vec<_> = lanes.to(10.0).into_iter().map(|end| end.unwrap()).collect();
        let bits = |end: &dsocs_core::Node<5>| [end.q, end.v].map(|x| x.map(f64::to_bits));
        // the instructions of the compiled target alone give the same bits
        let plain = TaylorEnsemble::new(&top, tolerance)
            .unwrap()
            .starts(all())
            .instructions(Instructions::Compiled)
            .to(10.0);
        for (found, plain) in found.iter().zip(plain) {
            assert_eq!(bits(found), bits(&plain.unwrap()));
        }
        for (start, found) in all().zip(&found) {
            let mut flow = TaylorFlow::new(&top, start, tolerance).unwrap();
            let known = flow.to(10.0).unwrap();
            let apart = distance([&known.q, &known.v], [&found.q, &found.v]);
            assert!(apart < 2e3 * bar, "{apart:e}");
            let norm = found.q[1..].iter().map(|q| q * q).sum::<f64>().sqrt();
            assert!((norm - 1.0).abs() <= 2.0 * f64::EPSILON, "{norm}");
        }
    }
}

/// A body without torques.
#[dsocs {
    coordinates(r: rotation);
    lagrangian = r.angular_velocity().norm_squared() / 2;
}]
struct Free {}

#[test]
fn a_body_that_spins_evenly_has_steps_in_lanes_by_its_attitude() {
    // its constant angular velocity alone would allow steps of any length
    let starts = (1..20).map(|k| Start::second_order([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, f64::from(k)]));
    let ends = TaylorEnsemble::new(&Free {}, Tolerance::relative(1e-13))
        .unwrap()
        .starts(starts)
        .to(7.0);
    for (k, end) in (1..20).zip(ends) {
        let [w, .., z] = end.unwrap().q;
        let angle = 3.5 * f64::from(k);
        let apart = (w - angle.cos()).abs().max((z - angle.sin()).abs());
        assert!(apart < 1e-11, "{k}: {apart:e}");
    }
}
