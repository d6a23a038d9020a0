//! The values at a node on a jump belong to one side of it: acceleration, constraint force and multipliers
//! obey the equations together, and the velocity of a discrete run is that with which the motion arrives.

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::{TapeKernel, Text};
use dsocs_core::{
    AnyComposedFlow, AnyFlow, AnyStart, Composition, Events, Flow, Occurrence, OwnedNode, Point, Run,
    Samples, Start, Stepper, TaylorFlow, Tolerance, dsocs, on_event,
};

/// The nodes of a run by Taylor series, on a grid or at its own steps.
fn nodes(text: &str, start: &AnyStart, grid: Option<f64>, until: f64) -> Vec<OwnedNode> {
    let system = Text::parse("system", text).unwrap().system;
    let flow = AnyTaylorFlow::of_tape(&system, start, Tolerance::relative(1e-10)).unwrap();
    let mut flow = match grid {
        Some(h) => flow.every(h).unwrap(),
        None => flow,
    };
    let run: &mut dyn Run = &mut flow;
    if until < 0.0 && grid.is_none() {
        run.reverse().unwrap();
    }
    let mut nodes = Vec::new();
    run.walk(until, &mut |run| {
        let mut node = OwnedNode::new(run.kernel().shape().dimension());
        run.write_node(node.as_node_mut());
        nodes.push(node);
        Ok(core::ops::ControlFlow::Continue(()))
    })
    .unwrap();
    nodes
}

#[test]
fn without_constraints_there_is_no_constraint_force_at_any_switch() {
    for force in [
        "if t < 1 { 1 } else { 1000 }",
        "if t > -0.5 { 1 } else { 1000 }",
        "if x < 2 { 3 } else { -40 }",
        "7 * (x - 0.25).signum()",
        "if t < 0.3 { 1 } else { if t < 0.7 { 900 } else { -900 } }",
        "30 * (dot(x) - 0.7).signum() + (if t < 0.5 { 20 } else { 100 })",
        "100 * (x - 0.1).abs() + 50 * (t - 0.6).abs().sqrt()",
    ] {
        let text = format!("coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = {force};");
        for grid in [None, Some(0.01), Some(0.1), Some(0.05)] {
            for back in [1.0, -1.0] {
                // back in time the motion would slide along a jump in the velocity
                if back < 0.0 && force.contains("dot(x)") {
                    continue;
                }
                let grid = grid.map(|h| back * h);
                for node in nodes(&text, &AnyStart::second_order(&[0.0], &[0.1]), grid, back * 2.0) {
                    let node = node.any();
                    assert!(
                        node.force[0].abs() <= 1e-9 * (1.0 + node.a[0].abs()),
                        "{force}, {grid:?}: {node:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_constraint_force_at_a_switch_is_along_its_form() {
    let text = "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
        holonomic = y - 0.5 * x;
        external_forces = ((if t < 1 { 1 } else { 1000 }), (if x < 2 { 0 } else { 50 }));";
    for grid in [None, Some(0.01), Some(0.25)] {
        let all = nodes(text, &AnyStart::second_order(&[0.0, 0.0], &[4.0, 2.0]), grid, 1.5);
        assert!(all.iter().any(|node| (node.any().t - 1.0).abs() < 1e-15) || grid.is_none());
        for node in all {
            let node = node.any();
            let aside = node.force[0] + 0.5 * node.force[1];
            let jump = node.a[1] - 0.5 * node.a[0];
            assert!(
                aside.abs() < 1e-8 && jump.abs() < 1e-8,
                "{grid:?}: {aside:e}, {jump:e}, {node:?}"
            );
        }
    }
}

/// A pendulum whose length is a table of the time.
#[dsocs {
    coordinates(theta);
    let l = length.at(t);
    lagrangian = (l * dot(theta)).powi(2) / 2 + 9.81 * l * theta.cos();
}]
struct Winch {
    length: Samples,
}

/// The pendulum by the velocity of its bob, so that the table is differentiated.
#[dsocs {
    coordinates(theta);
    let l = length.at(t);
    let x = l * theta.sin();
    let y = -l * theta.cos();
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
}]
struct Bob {
    length: Samples,
}

/// A point whose height is a table of the time.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 0.3 * x * dot(y);
    holonomic = y - height.at(t) + 1;
}]
struct Lift {
    height: Samples,
}

/// The errors of the last velocity of runs with three steps, against a tight run by Taylor series.
macro_rules! last_velocities {
    ($system:expr, $start:expr) => {{
        let system = $system;
        let tight = Tolerance::relative(1e-13);
        // just before the corner, at which the last one would have to jump
        let (mut exact, mut truth) = (TaylorFlow::new(&system, $start, tight).unwrap(), None);
        let mut keep = |_: f64, point: &Point<f64, _>| truth = Some(*point);
        exact.sample(&[10.0 - 1e-10], &mut keep).unwrap();
        let truth = truth.unwrap();
        [0.02, 0.01, 0.005].map(|h| {
            let node = Flow::new(&system, h, $start).unwrap().to(10.0).unwrap();
            let parts = node.v.iter().zip(&truth.v);
            parts.fold(0.0_f64, |most, (v, truth)| most.max((v - truth).abs()))
        })
    }};
}

#[test]
fn at_the_end_of_a_table_the_velocity_is_of_second_order() {
    // a spline that ends with a slope: beyond, it is constant
    let table = || {
        let places = (0..=40).map(|k| 0.25 * f64::from(k));
        Samples::cubic(places.map(|t| (t, 1.0 + 0.3 * t.sin()))).unwrap()
    };
    let swing = Start::second_order([1.0], [0.0]);
    let lift = Start::second_order([0.0, 0.0], [0.0, 0.3]);
    for errors in [
        last_velocities!(Winch { length: table() }, swing),
        last_velocities!(Bob { length: table() }, swing),
        last_velocities!(Lift { height: table() }, lift.projected()),
    ] {
        assert!(errors[0] < 0.03, "{errors:?}");
        for pair in errors.windows(2) {
            assert!(pair[0] > 3.4 * pair[1], "{errors:?}");
        }
    }
}

#[test]
fn at_a_corner_inside_a_table_the_velocity_is_of_second_order_and_no_force_appears() {
    let table = Samples::linear([(0.0, 10.0), (0.5, 11.0), (1.0, 7.0), (3.0, 9.0)]).unwrap();
    let system = Winch { length: table };
    let start = Start::second_order([1.0], [0.0]);
    for t in [0.5, 1.0] {
        let tight = Tolerance::relative(1e-13);
        let truth = TaylorFlow::new(&system, start, tight)
            .unwrap()
            .every(t)
            .unwrap()
            .to(t)
            .unwrap();
        assert!(truth.force[0].abs() < 1e-9, "{truth:?}");
        let errors = [0.05, 0.025, 0.0125].map(|h| {
            let node = Flow::new(&system, h, start).unwrap().to(t).unwrap();
            assert!(node.force[0].abs() < 1e-9, "{node:?}");
            (node.v[0] - truth.v[0]).abs()
        });
        for pair in errors.windows(2) {
            assert!(pair[0] > 3.4 * pair[1], "{t}: {errors:?}");
        }
    }
}

#[test]
fn a_velocity_at_rest_changes_no_sign() {
    // the block sticks and slips; its velocity changes sign three times until t = 6
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = 1.5 * (2 * t).sin() - dot(x).signum();";
    let system = Text::parse("system", text).unwrap().system;
    let start = Start::second_order([0.0], [1.0]);
    let event = || Events::new(vec![dsocs_core::Event::function(|point| point.v[0])]);
    for h in [0.01, 0.05, 0.013, 0.1] {
        let mut flow = Flow::<1>::of(&system, h, start).unwrap();
        let mut found = Vec::new();
        let mut keep = on_event(|event: &Occurrence<1>| found.push((event.t, event.rising)));
        flow.watch(6.0, &mut event(), &mut keep).unwrap();
        assert_eq!(found.len(), 3, "{h}: {found:?}");
        assert!(found.windows(2).all(|pair| pair[0].1 != pair[1].1), "{found:?}");
    }
}

/// A block on a hoop with dry friction and a torque, in Cartesian coordinates, and by its angle.
fn hoop([friction, torque, rate, angle]: [f64; 4]) -> [(String, AnyStart); 2] {
    let drive = format!("{torque:?} * ({rate:?} * t).sin()");
    let cartesian = format!(
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
         holonomic = x.powi(2) + y.powi(2) - 1;
         let s = {drive} - {friction:?} * (-y * dot(x) + x * dot(y)).signum();
         external_forces = (-y * s, x * s);"
    );
    let by_angle = format!(
        "coordinates(p); lagrangian = dot(p).powi(2) / 2 + 9.81 * p.cos();
         external_forces = {drive} - {friction:?} * dot(p).signum();"
    );
    let place = [angle.sin(), -angle.cos()];
    [
        (cartesian, AnyStart::second_order(&place, &[0.0, 0.0])),
        (by_angle, AnyStart::second_order(&[angle], &[0.0])),
    ]
}

#[test]
fn a_body_that_stops_on_a_constraint_is_no_impact() {
    for hoop in [
        [
            2.872_742_200_746_563_5,
            2.508_281_023_917_63,
            2.421_608_643_886_829,
            -0.187_342_886_645_598,
        ],
        [
            2.190_446_980_314_441,
            1.940_051_642_361_201_3,
            3.816_220_845_260_062_3,
            -0.502_761_457_086_642_3,
        ],
        [
            3.360_630_317_431_190_2,
            1.990_804_077_232_687_4,
            3.245_443_532_677_646_3,
            -1.946_042_728_467_635,
        ],
        [
            2.775_465_772_959_535,
            2.911_835_329_429_257,
            3.809_804_046_234_007_5,
            -1.240_981_302_388_398_4,
        ],
        [
            1.700_206_310_230_553,
            2.445_450_859_827_234,
            0.721_492_839_316_239_6,
            1.053_200_191_648_110_2,
        ],
        [
            2.751_802_747_232_6,
            1.167_720_680_418_822_7,
            3.404_391_922_129_772,
            0.188_572_373_432_622_8,
        ],
    ]
    .map(hoop)
    {
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let [place, angle] = hoop.each_ref().map(|(text, start)| {
                let system = Text::parse("hoop", text).unwrap().system;
                let start = start.clone().projected();
                let mut flow =
                    AnyTaylorFlow::of_tape(&system, &start, Tolerance::relative(tolerance)).unwrap();
                let run: &mut dyn Run = &mut flow;
                let mut last = Vec::new();
                run.sample(&[8.0], &mut |_, point| last = point.q.to_vec())
                    .unwrap();
                last
            });
            let apart = (place[0] - angle[0].sin()).hypot(place[1] + angle[0].cos());
            assert!(apart < 1e3 * tolerance, "{tolerance}: {place:?}, {angle:?}");
        }
    }
}

/// The runs of all methods, with nodes at multiples of 1/8.
fn runs<'s>(system: &'s TapeKernel, start: Start<1>) -> Vec<(&'static str, Box<dyn Run + 's>)> {
    let any: AnyStart = start.into();
    let series = || AnyTaylorFlow::of_tape(system, &any, Tolerance::relative(1e-10)).unwrap();
    let composed = AnyComposedFlow::new(system, 0.125, Composition::SUZUKI_4, &any).unwrap();
    vec![
        ("order 2", Flow::of(system, 0.125, start).unwrap().into_run()),
        ("order 4", composed.into_run()),
        ("series", Box::new(series())),
        ("series on a grid", Box::new(series().every(0.125).unwrap())),
        (
            "series on a fine grid",
            Box::new(series().every(0.03125).unwrap()),
        ),
    ]
}

/// Position, velocity and acceleration at some times.
fn sampled(run: &mut dyn Run, times: &[f64]) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    run.sample(times, &mut |_, point| {
        points.push([point.q[0], point.v[0], point.a[0]]);
    })
    .unwrap();
    points
}

/// Position, velocity and acceleration at the current node.
fn told(run: &dyn Run) -> [f64; 3] {
    let mut node = OwnedNode::new(1);
    node.take(run);
    let node = node.any();
    [node.q[0], node.v[0], node.a[0]]
}

#[test]
fn a_sample_at_a_node_is_the_node_also_where_a_force_jumps() {
    for force in [
        "if t < 1 { 1 } else { 3 }",
        "if t > 1 { 3 } else { 1 }",
        "if x < 1 { 0 } else { 2 }",
        "2 * (x - 1).signum()",
        "(6 * (t - 0.5)).max(0).min(3)",
    ] {
        let text = format!("coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = {force};");
        let system = Text::parse("system", &text).unwrap().system;
        let start = Start::second_order([0.0], [1.0]);
        let times = [0.5, 0.75, 0.875, 1.0, 1.125, 1.5];
        for (place, (method, mut run)) in runs(&system, start).into_iter().enumerate() {
            let points = sampled(&mut *run, &times);
            let (_, mut run) = runs(&system, start).swap_remove(place);
            for (t, point) in times.iter().zip(points) {
                run.to(*t).unwrap();
                for (found, expected) in point.iter().zip(told(&*run)) {
                    assert!(
                        (found - expected).abs() < 1e-9,
                        "{force}, {method}, {t}: {point:?} {:?}",
                        told(&*run)
                    );
                }
            }
        }
    }
}

/// Where an input changes at a node, the node and samples up to it have the acceleration with which the
/// motion arrives, and samples beyond it the new one, by every method.
#[test]
fn where_an_input_changes_a_node_and_a_sample_tell_how_the_motion_arrives() {
    let text =
        "parameters { push = 0.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = push;";
    let system = Text::parse("system", text).unwrap().system;
    for (method, mut run) in runs(&system, Start::second_order([0.0], [1.0])) {
        let before = sampled(&mut *run, &[0.5, 0.9375, 1.0]);
        let node = told(&*run);
        run.set_input("push", 2.0).unwrap();
        // a flow of order 2 knows its next position already
        let change = if method == "order 2" { 1.125 } else { 1.0 };
        let exact = |t: f64| {
            let pushed = (t - change).max(0.0);
            [
                t + pushed * pushed,
                1.0 + 2.0 * pushed,
                if t > change { 2.0 } else { 0.0 },
            ]
        };
        let force = |run: &dyn Run| {
            let mut node = OwnedNode::new(1);
            node.take(run);
            node.any().force[0]
        };
        assert!(force(&*run).abs() < 1e-12, "{method}: {}", force(&*run));
        let beyond = [1.0625, 1.125, 1.1875, 1.25, 1.5];
        let after = sampled(&mut *run, &beyond);
        let all = before
            .iter()
            .zip([0.5, 0.9375, 1.0])
            .chain(after.iter().zip(beyond));
        for (found, t) in all.chain([(&node, 1.0)]) {
            for (found, exact) in found.iter().zip(exact(t)) {
                assert!((found - exact).abs() < 1e-9, "{method}, {t}: {found} {exact}");
            }
        }
    }
}

#[test]
fn at_the_end_of_a_table_the_velocity_is_of_second_order_with_friction_rotations_and_inputs() {
    let directory = tempfile::tempdir().unwrap();
    let rows = (0..5)
        .map(|k| 0.125 * f64::from(k))
        .map(|t| format!("{t},{}\n", 1.0 + 0.3 * (2.0 * t).sin()));
    std::fs::write(
        directory.path().join("table.csv"),
        format!("t,value\n{}", rows.collect::<String>()),
    )
    .unwrap();
    let bob = "coordinates(theta); let l = table.at(t); let x = l * theta.sin(); let y = -l * theta.cos();
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;";
    let swings = AnyStart::second_order(&[-1.0], &[3.5]);
    let turns = AnyStart::second_order(&[1.0, 0.0, 0.0, 0.0], &[0.0, 1.0, 2.0, 1.0]);
    let push = "external_forces = push;";
    let scenes = [
        (
            format!("{bob} external_forces = -0.3 * dot(theta).signum();"),
            &swings,
            false,
        ),
        (
            format!("{bob} external_forces = -0.3 * dot(theta).signum() + push;"),
            &swings,
            true,
        ),
        (format!("{bob} {push}"), &swings, true),
        (
            "coordinates(r: rotation); let w = r.angular_velocity();
             lagrangian = (w[0].powi(2) + 2 * table.at(t) * w[1].powi(2) + 3 * w[2].powi(2)) / 2;"
                .to_owned(),
            &turns,
            false,
        ),
    ];
    for (text, start, has_input) in scenes {
        let file = directory.path().join("scene.dsocs");
        let parameters = "parameters { table = samples(\"table.csv\"), push = 0.0 }";
        std::fs::write(
            &file,
            format!("{parameters} {text} let pushed = push; observe = [pushed];"),
        )
        .unwrap();
        let system = Text::read(&file).unwrap().system;
        // an input that changes at 0.1
        let drive = |run: &mut dyn Run, ahead: f64| {
            if has_input {
                run.to(0.1 - ahead).unwrap();
                run.set_input("push", 1.0).unwrap();
            }
        };
        let mut exact = AnyTaylorFlow::of_tape(&system, start, Tolerance::relative(1e-13)).unwrap();
        drive(&mut exact, 0.0);
        let (run, mut truth): (&mut dyn Run, _) = (&mut exact, Vec::new());
        run.sample(&[0.5 - 1e-10], &mut |_, point| truth.extend_from_slice(point.v))
            .unwrap();
        let errors = [0.02, 0.01, 0.005].map(|h| {
            let mut flow = AnyFlow::new(&system, h, start).unwrap();
            // a flow knows its next position already
            drive(flow.run_mut(), h);
            flow.run_mut().to(0.5).unwrap();
            let mut node = OwnedNode::new(truth.len());
            node.take(flow.run());
            let parts = node.any().v.iter().zip(&truth);
            parts.fold(0.0_f64, |most, (v, truth)| most.max((v - truth).abs()))
        });
        assert!(errors[0] < 0.01, "{text} {errors:?}");
        for pair in errors.windows(2) {
            assert!(pair[0] > 3.3 * pair[1] || pair[1] < 1e-5, "{text} {errors:?}");
        }
    }
}
