//! A run by steps says if it leads over a push or a hill that is narrower than its steps, however small the force is at its nodes.

use core::f64::consts::PI;

use dsocs_core::text::Text;
use dsocs_core::{Composition, Flow, Start, Stepper};
use dsocs_tests::text::ComposedFlow;
use proptest::prelude::*;

use super::draws;

/// Functions of `u` that are small but near zero, and their integrals over all `u`.
const SHAPES: [(&str, f64); 20] = [
    ("(-u.powi(2)).exp()", 1.772_453_850_905_516),
    ("(-u.powi(4)).exp()", 1.812_804_954_110_954),
    ("1 / u.min(300.0).max(-300.0).cosh().powi(2)", 2.0),
    ("1 - u.tanh().powi(2)", 2.0),
    ("(1 - u.tanh()) * (1 + u.tanh())", 2.0),
    ("(-u.abs()).exp()", 2.0),
    ("1 / (1 + u.powi(8))", 2.052_344_305_954_062_3),
    ("1 / (1 + u.powi(2)).powi(5)", 35.0 * PI / 128.0),
    ("(1 + u.powi(2)).powf(-2.5)", 4.0 / 3.0),
    ("1 / (1 + u.powi(2))", PI),
    ("(1 - u * u).max(0).powf(2.5)", 0.312_5 * PI),
    ("(-(u.powi(2) + u.powi(4)).sqrt()).exp()", 1.353_525_415),
    ("(1 - u * u).max(0)", 4.0 / 3.0),
    ("(1 - u * u).max(0).powi(2)", 16.0 / 15.0),
    ("(1 - u * u).max(0).powi(3)", 32.0 / 35.0),
    ("(1 - u.abs()).max(0)", 1.0),
    ("if u.abs() < 1 { (1 + (PI * u).cos()) / 2 } else { 0 }", 1.0),
    ("(1 + u).max(0) * (1 - u).max(0)", 4.0 / 3.0),
    ("1 / (1 + u.powi(2)).sqrt().powi(3)", 2.0),
    ("(u + 0.5).atan() - (u - 0.5).atan()", PI),
];

/// What a narrow feature is: a push at a place, one at a time, or a hill that is higher than the mass can go.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Place,
    Time,
    Hill,
}

/// A mass on a soft spring, on whose way lies a feature.
#[derive(Clone, Debug)]
struct Scene {
    shape: usize,
    kind: Kind,
    /// The centre of the feature and its width.
    at: f64,
    width: f64,
    /// The stiffness of the spring.
    k: f64,
    h: f64,
    is_composed: bool,
}

/// The end of a run: the place, the energy that the mass has gained, and whether steps are counted that are not resolved.
struct Ended {
    place: f64,
    gained: f64,
    is_counted: bool,
}

/// A run, or its error.
fn run(scene: &Scene) -> Result<Ended, String> {
    let Scene {
        kind, at, width, k, ..
    } = scene;
    let of = if *kind == Kind::Time { "t" } else { "x" };
    let shape = SHAPES[scene.shape].0;
    let force = if *kind == Kind::Hill {
        format!("lagrangian = dot(x).powi(2) / 2 - {k:?} * x.powi(2) / 2 - 0.75 * ({shape});")
    } else {
        let size = 0.3 / width;
        format!(
            "lagrangian = dot(x).powi(2) / 2 - {k:?} * x.powi(2) / 2; external_forces = ({size:?} * ({shape}));"
        )
    };
    let text = format!("coordinates(x); let u = ({of} - {at:?}) / {width:?}; {force}");
    let text = Text::parse("narrow", &text).map_err(|error| format!("{error:?}"))?;
    let start = Start::second_order([0.0], [1.0]);
    if scene.is_composed {
        let flow = ComposedFlow::read(&text.system, scene.h, Composition::SUZUKI_4, start);
        ended(*k, flow.map_err(|error| error.to_string())?)
    } else {
        let flow = Flow::of(&text.system, scene.h, start);
        ended(*k, flow.map_err(|error| error.to_string())?)
    }
}

fn ended(k: f64, mut flow: impl Stepper<1>) -> Result<Ended, String> {
    flow.to(END).map_err(|error| error.to_string())?;
    let node = flow.node();
    let (q, v) = (node.q[0], node.v[0]);
    Ok(Ended {
        place: q,
        gained: 0.5 * (v * v + k * q * q - 1.0),
        is_counted: flow.unresolved().is_some(),
    })
}

/// The end of a run, which has then passed the feature or turned back.
const END: f64 = 1.1;

/// A run is right if it gains the energy that it should to this accuracy.
const RIGHT: f64 = 0.03;

/// Scenes with a width between two powers of ten of a step; that of a hill, in which the force changes its sign, times another one.
fn scenes(narrowest: f64, widest: f64, hill: f64) -> impl Strategy<Value = Scene> + 'static {
    let kind = prop_oneof![Just(Kind::Place), Just(Kind::Time), Just(Kind::Hill)];
    let numbers = (0.4..0.6, narrowest..widest, 0.0..0.2, 0.002..0.02_f64);
    (0..SHAPES.len(), kind, numbers, any::<bool>()).prop_map(
        move |(shape, kind, (at, log, k, h), is_composed)| {
            let log: f64 = if kind == Kind::Hill { log + hill } else { log };
            let width = h * f64::powf(10.0, log);
            Scene {
                shape,
                kind,
                at,
                width,
                k,
                h,
                is_composed,
            }
        },
    )
}

#[test]
fn a_feature_that_the_steps_miss_is_counted() {
    draws::test(2000, 61, scenes(-4.0, -0.3, -0.4), &|scene: Scene| {
        let found = run(&scene);
        let push = 0.3 * SHAPES[scene.shape].1;
        let expected = match scene.kind {
            Kind::Place => push,
            Kind::Time => {
                let w = scene.k.sqrt();
                push * (w * scene.at).cos() + 0.5 * push * push
            }
            Kind::Hill => 0.0,
        };
        match found {
            // a step that finds no solution says so
            Err(_) => {}
            Ok(Ended {
                place,
                gained,
                is_counted,
            }) => {
                // the hill is higher than the mass can go
                let turns_back = scene.kind != Kind::Hill || place < scene.at;
                prop_assert!(
                    is_counted || turns_back && (gained - expected).abs() < RIGHT,
                    "{scene:?} {}: {place}, {gained} for {expected}",
                    SHAPES[scene.shape].0
                );
            }
        }
        Ok(())
    });
}

#[test]
fn a_feature_that_the_steps_resolve_is_not() {
    draws::test(400, 62, scenes(0.8, 1.3, 0.0), &|scene: Scene| {
        // the force of a hill with a corner jumps
        let has_corner = SHAPES[scene.shape].0.ends_with(".max(0)");
        if scene.kind == Kind::Hill && has_corner {
            return Ok(());
        }
        let found = run(&scene);
        let counted = found.map(|ended| ended.is_counted);
        prop_assert!(
            counted == Ok(false),
            "{scene:?} {}: {counted:?}",
            SHAPES[scene.shape].0
        );
        Ok(())
    });
}

/// A force whose period is the step, or a part of it, is the same at all nodes.
#[test]
fn a_period_of_the_step_is_counted() {
    for h in [0.01, 0.0137] {
        for periods in [0.5, 1.0, 2.0, 3.0, 0.99, 1.995] {
            for phase in [0.0, 0.4, 1.1] {
                let text = format!(
                    "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 2 * x.powi(2); \
                     external_forces = 30 * ({:?} * t + {phase:?}).cos();",
                    2.0 * PI * periods / h
                );
                let text = Text::parse("shaken", &text).unwrap();
                let start = || Start::second_order([0.0], [0.0]);
                let mut flow = Flow::of(&text.system, h, start()).unwrap();
                flow.to(1.0).unwrap();
                assert!(flow.unresolved().is_some(), "{h} {periods} {phase}");
                let mut flow = ComposedFlow::read(&text.system, h, Composition::SUZUKI_4, start()).unwrap();
                flow.to(1.0).unwrap();
                assert!(flow.unresolved().is_some(), "{h} {periods} {phase}, order 4");
            }
        }
    }
    // eight steps and more see it
    for periods in [0.1, 0.02] {
        let h = 0.01;
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 2 * x.powi(2); external_forces = 30 * ({:?} * t).cos();",
            2.0 * PI * periods / h
        );
        let text = Text::parse("shaken", &text).unwrap();
        let mut flow = Flow::of(&text.system, h, Start::second_order([0.0], [0.0])).unwrap();
        flow.to(1.0).unwrap();
        assert_eq!(flow.unresolved(), None, "{periods}");
    }
}
