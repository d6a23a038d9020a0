//! The orders of the parts: systems whose orders are known by hand, random systems, and the table of the
//! book.

mod book;
mod chance;
#[path = "../program/mod.rs"]
mod program;
mod rotations;

use dsocs_core::dsocs;
use dsocs_core::geometry::{Expansion, PartErrors};
use dsocs_core::text::Text;
use dsocs_systems::check::orders::{Order, Orders, Part, orders};
use dsocs_systems::check::{Begin, Settings};
use dsocs_systems::entry::CheckFailure;
use dsocs_systems::{CurvedParticle, Entry, systems};

/// A motion with a step, over its own time.
fn settings(h: f64) -> Settings<'static> {
    Settings {
        h,
        until: None,
        t0: 0.0,
        q0: &[],
        v0: &[],
        a0: None,
        begin: Begin::default(),
    }
}

/// The orders of a text with further statements.
fn of_text(text: &str, statements: &str, (q0, v0): (&[f64], &[f64]), h: f64) -> Orders {
    let text = Text::parse("system", &format!("{text}\n{statements}")).unwrap();
    let entry = Entry::of_text("system", &text, None);
    let settings = Settings {
        q0,
        v0,
        ..settings(h)
    };
    entry.orders(&settings).unwrap()
}

/// Asserts a fitted order.
fn assert_order(orders: &Orders, part: Part, expected: f64) {
    match orders.of(part) {
        Some(Order::Power { power, .. }) => {
            assert!(
                (power - expected).abs() < 0.05,
                "{part:?}: {power}, not {expected}"
            );
        }
        other => panic!("{part:?}: {other:?}, not {expected}"),
    }
}

/// Asserts the order that follows for the flow, and that it is measured.
fn assert_flow(orders: &Orders, expected: f64) {
    assert_eq!(orders.follows.number(), Some(expected), "{orders:?}");
    assert_eq!(orders.seen.number(), Some(expected), "{orders:?}");
    assert!(orders.holds());
}

/// A bead on a wire: its inertia depends on its position.
const BEAD: &str = "coordinates(x);
lagrangian = (1 + x.powi(2)) / 2 * dot(x).powi(2) - x.powi(4) / 4;";

#[test]
fn the_papers_map_touches_at_order_1_where_the_mass_varies() {
    for (map, order) in [("paper", 1.0), ("midpoint", 2.0), ("trapezoid", 2.0)] {
        let found = of_text(BEAD, &format!("phi_lagrangian = {map};"), (&[1.0], &[0.3]), 0.05);
        for part in [Part::Lagrangian, Part::Momenta, Part::Forces, Part::Equations] {
            assert_order(&found, part, order);
        }
        assert_flow(&found, order);
        let lowering: &[Part] = if map == "paper" { &[Part::Forces] } else { &[] };
        assert_eq!(found.lowering, lowering);
    }
}

/// On a straight wire the paper's `L_d` is of order 1, but its error telescopes: the forces at nodes and the
/// flow are of order 2.
#[test]
fn what_telescopes_lowers_nothing() {
    // a straight wire: L = T(v) − V(q)
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(4) / 4;";
    let found = of_text(text, "phi_lagrangian = paper;", (&[1.0], &[0.3]), 0.05);
    assert_order(&found, Part::Lagrangian, 1.0);
    assert_order(&found, Part::Momenta, 1.0);
    assert_order(&found, Part::Forces, 2.0);
    assert_flow(&found, 2.0);
    assert!(found.lowering.is_empty());
    assert!(
        found.remarks.iter().any(|remark| remark.contains("telescopes")),
        "{found:?}"
    );
}

#[test]
fn errors_are_those_by_hand() {
    // a particle on the unit circle, with curvature 1 and speed 1, about the point (1, 0)
    let powers: Vec<f64> = (0..16)
        .scan(1.0, |power, k| {
            let this = *power;
            *power /= f64::from(k + 1);
            Some(this)
        })
        .collect();
    let signs = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    let coefficients = powers.iter().enumerate();
    let coefficients = coefficients.map(|(k, power)| signs[k % 4].map(|sign| sign * power).to_vec());
    let motion = Expansion {
        t: 0.0,
        coefficients: coefficients.collect(),
        rotations: Vec::new(),
        reach: 0.5,
    };
    for h in [0.2_f64, 0.1, 0.01] {
        let part_errors = PartErrors::of(&CurvedParticle::default(), &motion, h).unwrap();
        // v_d = (0, sin h/h) and a_d = (2 (cos h − 1)/h², 0)
        let curvature = 2.0 * (1.0 - h.cos()) / h.sin().powi(2);
        let [row] = part_errors.accelerations[..] else {
            panic!("{part_errors:?}")
        };
        assert!((row.difference - (curvature - 1.0)).abs() < 1e-12, "{row:?}");
        // the chord of the outer nodes is the tangent at the middle one
        let [work] = part_errors.displacements[..] else {
            panic!("{part_errors:?}")
        };
        assert!(work.difference.abs() <= work.rounding, "{work:?}");
        // the kinetic energy of the chord, and that of the motion
        let chord = 2.0 * (h / 2.0).sin() / h;
        let [error] = part_errors.lagrangian[..] else {
            panic!("{part_errors:?}")
        };
        assert!(
            (error.difference - (chord.powi(2) - 1.0) / 2.0).abs() < 1e-13,
            "{error:?}"
        );
        // m a_d against m a
        let forces: Vec<f64> = part_errors.forces.iter().map(|error| error.difference).collect();
        let by_hand = 2.0 * (h.cos() - 1.0) / h.powi(2) + 1.0;
        assert!(
            (forces[0] - by_hand).abs() < 1e-12 && forces[1].abs() < 1e-12,
            "{forces:?}"
        );
    }
}

/// A harmonic oscillator with the exact discrete Lagrangian.
#[dsocs {
    coordinates(x);
    lagrangian = (dot(x).powi(2) - x.powi(2)) / 2;
    discrete_lagrangian = ((x[0].powi(2) + x[1].powi(2)) * h.cos() - 2 * x[0] * x[1]) / (2 * h * h.sin());
}]
struct Exact;

/// A harmonic oscillator with the exact discrete Lagrangian expanded to fourth order.
#[dsocs {
    coordinates(x);
    lagrangian = (dot(x).powi(2) - x.powi(2)) / 2;
    discrete_lagrangian = (x[0].powi(2) + x[1].powi(2)) / 2 * (1 / h.powi(2) - 1 / 3 - h.powi(2) / 45)
        - x[0] * x[1] * (1 / h.powi(2) + 1 / 6 + 7 * h.powi(2) / 360);
}]
struct Fourth;

/// A harmonic oscillator whose discrete potential is twice too large.
#[dsocs {
    coordinates(x);
    lagrangian = (dot(x).powi(2) - x.powi(2)) / 2;
    discrete_lagrangian = ((x[1] - x[0]) / h).powi(2) / 2 - (x[0].powi(2) + x[1].powi(2)) / 2;
}]
struct Inconsistent;

#[test]
fn the_exact_discrete_lagrangian_is_exact() {
    let found = orders(&Exact, &settings(0.2), ([1.0], [0.3])).unwrap();
    for of in &found.parts {
        assert_eq!(of.order, Order::Exact, "{of:?}");
    }
    assert_flow(&found, f64::INFINITY);
}

#[test]
fn a_flow_of_order_4_begins_on_the_motion() {
    let found = orders(&Fourth, &settings(0.2), ([1.0], [0.3])).unwrap();
    assert_order(&found, Part::Lagrangian, 4.0);
    assert_order(&found, Part::Forces, 4.0);
    assert_flow(&found, 4.0);
    // the paper's start has an error of order 1, and is named in the remarks
    let begin = Begin {
        paper: true,
        projected: false,
    };
    let settings = Settings {
        begin,
        ..settings(0.2)
    };
    let found = orders(&Fourth, &settings, ([1.0], [0.3])).unwrap();
    assert_order(&found, Part::Start, 1.0);
    assert_flow(&found, 1.0);
    assert_eq!(found.lowering, [Part::Start]);
}

/// A discrete Lagrangian that does not tend to `L` is of order 0, and so is the flow.
#[test]
fn what_is_not_consistent_is_of_order_0() {
    let found = orders(&Inconsistent, &settings(0.1), ([1.0], [0.3])).unwrap();
    assert_order(&found, Part::Lagrangian, 0.0);
    assert_order(&found, Part::Forces, 0.0);
    assert_eq!(found.follows.number(), Some(0.0));
    assert_eq!(found.seen.number(), Some(0.0));
    assert_eq!(found.lowering, [Part::Forces]);
}

/// A sleigh whose blade is behind its centre of mass.
const SLEIGH: &str = "coordinates(x, y, theta);
let along = dot(x) * theta.cos() + dot(y) * theta.sin();
let across = dot(y) * theta.cos() - dot(x) * theta.sin();
lagrangian = (along.powi(2) + (across + dot(theta) / 2).powi(2) + dot(theta).powi(2) / 4) / 2;
nonholonomic = across;";

#[test]
fn a_row_of_velocities_at_one_end_of_a_leg_is_of_order_1() {
    for (map, order) in [("paper", 1.0), ("midpoint", 2.0)] {
        let map = format!("phi_lagrangian = {map};");
        let found = of_text(SLEIGH, &map, (&[0.0; 3], &[-1.0, 0.0, 0.3]), 0.05);
        assert_order(&found, Part::Velocities, order);
        assert_eq!(found.of(Part::Displacements), Some(&Order::Exact));
        assert_flow(&found, order);
    }
}

/// A pendulum on a cart with a Lyapunov constraint that the cart's motor enforces.
const LYAPUNOV: &str = "coordinates(x, theta);
lagrangian = dot(x).powi(2) + dot(theta).powi(2) / 2 + dot(x) * dot(theta) * theta.cos() + theta.cos();
let energy = dot(theta).powi(2) / 2 - theta.cos() + x.powi(2) / 2 + x * dot(theta);
kinematic = dot(energy) + dot(theta).powi(2) / 5;
constraint_forces = [(1, 0)];";

/// A particle with a force, whose curvature depends on its speed: all three maps enter.
const CURVED: &str = "coordinates(x, y);
lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y - x * y / 2;
let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - 1 - x / 2 - dot(y) / 4;
variational = [(dot(x), dot(y))];";

#[test]
fn the_map_that_lowers_the_order_is_named() {
    let central = "|q0, q1, q2| (q1, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / (h * h))";
    let ahead = "|q0, q1, q2| (q1, (q2 - q1) / h, (q2 - 2 * q1 + q0) / (h * h))";
    let behind = "|q0, q1, q2| (q0, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / (h * h))";
    let start: (&[f64], &[f64]) = (&[0.1, 0.2], &[1.0, 0.5]);
    for (kinematic, variational, lowering) in [
        (central, central, &[][..]),
        ("midpoint", central, &[]),
        ("midpoint", "midpoint", &[]),
        (ahead, central, &[Part::Accelerations]),
        (central, ahead, &[Part::Displacements]),
        (behind, "midpoint", &[Part::Accelerations]),
        (ahead, ahead, &[Part::Accelerations, Part::Displacements]),
    ] {
        let maps = format!("phi_kinematic = {kinematic}; phi_variational = {variational};");
        let found = of_text(CURVED, &maps, start, 0.02);
        assert_eq!(found.lowering, lowering, "{maps}: {found:?}");
        let order = |part| if lowering.contains(&part) { 1.0 } else { 2.0 };
        assert_order(&found, Part::Accelerations, order(Part::Accelerations));
        assert_order(&found, Part::Displacements, order(Part::Displacements));
        assert_flow(&found, if lowering.is_empty() { 2.0 } else { 1.0 });
    }
}

#[test]
fn a_law_by_a_lyapunov_function_has_an_exact_c_v() {
    let ahead = "|q0, q1, q2| (q1, (q2 - q1) / h, (q2 - 2 * q1 + q0) / (h * h))";
    let start: (&[f64], &[f64]) = (&[0.2, 0.3], &[0.1, 1.0]);
    for (maps, forces, rows) in [
        (String::new(), 2.0, 2.0),
        (format!("phi_kinematic = {ahead};"), 2.0, 1.0),
        ("phi_lagrangian = paper;".to_owned(), 1.0, 2.0),
    ] {
        let found = of_text(LYAPUNOV, &maps, start, 0.01);
        assert_order(&found, Part::Forces, forces);
        assert_order(&found, Part::Accelerations, rows);
        // the motor's force does not depend on the nodes
        assert_eq!(found.of(Part::Displacements), Some(&Order::Exact));
        assert_flow(&found, f64::min(forces, rows));
    }
}

/// With as many constraints as coordinates, an `L_d` of order 1 changes the force alone: the positions are
/// exact.
#[test]
fn what_the_constraint_force_takes_up_lowers_nothing() {
    // as many constraints as coordinates: only the force depends on L_d
    let text = "coordinates(x, y);
    lagrangian = (1 + x.powi(2)) / 2 * (dot(x).powi(2) + dot(y).powi(2)) - y;
    holonomic = [x - 2 - t.cos(), y - t.sin()];
    phi_lagrangian = paper;";
    let found = of_text(text, "", (&[3.0, 0.0], &[0.0, 1.0]), 0.05);
    assert_order(&found, Part::Forces, 1.0);
    assert_eq!(found.of(Part::Positions), Some(&Order::Exact));
    assert_flow(&found, f64::INFINITY);
    assert!(found.lowering.is_empty());
}

#[test]
fn external_forces_have_an_order_of_their_own() {
    let text = format!("{BEAD} external_forces = (-dot(x) * (1 + x.powi(2)) / 5 + t.cos());");
    for (map, order) in [("paper", 1.0), ("midpoint", 2.0), ("trapezoid", 2.0)] {
        let found = of_text(&text, &format!("phi_lagrangian = {map};"), (&[1.0], &[0.3]), 0.05);
        assert_order(&found, Part::ExternalForces, 2.0);
        assert_order(&found, Part::Forces, order);
        assert_flow(&found, order);
    }
}

/// The orders of a system of third order are refused, with the reason.
#[test]
fn what_cannot_be_had_says_so() {
    let crane = systems::crane::entry();
    let [q0, v0] = crane.default_start().unwrap();
    let settings = Settings {
        q0,
        v0,
        ..settings(0.01)
    };
    let failure = crane.orders(&settings).unwrap_err();
    assert!(matches!(failure, CheckFailure::Orders { .. }) && failure.to_string().contains("third order"));
}

#[test]
fn a_motion_that_jumps_or_ends_is_open_or_shorter() {
    // dry friction holds the block
    let text = "coordinates(x);
    lagrangian = (dot(x).powi(2) - x.powi(2)) / 2;
    external_forces = (-3 * dot(x).signum() / 10);";
    let found = of_text(text, "", (&[2.0], &[0.1]), 0.05);
    assert_order(&found, Part::Equations, 2.0);
    assert!(!found.holds() && found.ok(), "{found:?}");
    assert!(found.excuse.unwrap().contains("smooth"));
    // a fall into a centre
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2 + 1 / x;";
    let found = of_text(text, "", (&[1.0], &[0.0]), 0.01);
    assert!(found.until < 1.12, "{found:?}");
    assert!(found.states > 1, "{found:?}");
    assert!(
        found.remarks.iter().any(|remark| remark.contains("ends")),
        "{found:?}"
    );
    assert_flow(&found, 2.0);
}

#[test]
fn corners_and_tables_are_looked_at_within_their_pieces() {
    // a soft stop
    let text = "coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 - 50 * (x - 0.5).max(0).powi(2);";
    let found = of_text(text, "", (&[0.0], &[1.0]), 0.02);
    assert_order(&found, Part::Equations, 2.0);
    assert!(
        found.ok() && found.excuse.as_ref().unwrap().contains("corner"),
        "{found:?}"
    );

    // before the first sample its value is held: a corner, at which the motion begins
    let text = "parameters { push = samples(\"push.csv\") }
    coordinates(x);
    lagrangian = (1 + x.powi(2) / 3) / 2 * dot(x).powi(2) - x.powi(2) / 2;
    external_forces = (push.at(t));
    run { start = ([1.0], [0.3]); step = 0.02; until = 4.0; }";
    let samples = (0..101)
        .map(|k| f64::from(k) / 10.0)
        .map(|t| (t, (0.7 * t).sin()));
    let samples = [("push.csv".to_owned(), samples.collect())];
    let text = Text::parse_with("push", text, &[], &samples).unwrap();
    let entry = Entry::of_text("push", &text, text.runs.first());
    let settings = Settings {
        q0: &[1.0],
        v0: &[0.3],
        ..settings(0.02)
    };
    let by_map = entry.orders_by_map(&settings).unwrap();
    assert_eq!(by_map.len(), 4);
    for variant in by_map {
        let found = variant.orders.unwrap();
        // the paper's map evaluates the push at the nodes
        match variant.map.name {
            "L: midpoint" => assert_order(&found, Part::ExternalForces, 2.0),
            _ => assert!(found.of(Part::ExternalForces).unwrap().number() >= Some(2.0)),
        }
        assert_flow(&found, if variant.map.name == "L: paper" { 1.0 } else { 2.0 });
    }
}
