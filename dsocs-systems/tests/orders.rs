//! The orders of the parts: systems whose answers are known, and the table of the book.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use dsocs_core::dsocs;
use dsocs_core::geometry::{Contact, Expansion};
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

/// The orders of a text with some statements put in.
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

/// Asserts an order that is fitted.
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

/// Asserts what follows for the flow, and that it is seen.
fn assert_flow(orders: &Orders, expected: f64) {
    assert_eq!(orders.follows.number(), Some(expected), "{orders:?}");
    assert_eq!(orders.seen.number(), Some(expected), "{orders:?}");
    assert!(orders.holds());
}

/// A bead on a wire: its inertia depends on where it is.
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

#[test]
fn what_telescopes_lowers_nothing() {
    // the same wire, straight: L = T(v) − V(q)
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
fn gaps_are_those_by_hand() {
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
        reach: 0.5,
    };
    for h in [0.2_f64, 0.1, 0.01] {
        let contact = Contact::of(&CurvedParticle::default(), &motion, h).unwrap();
        // v_d = (0, sin h/h) and a_d = (2 (cos h − 1)/h², 0)
        let curvature = 2.0 * (1.0 - h.cos()) / h.sin().powi(2);
        let [row] = contact.accelerations[..] else {
            panic!("{contact:?}")
        };
        assert!((row.apart - (curvature - 1.0)).abs() < 1e-12, "{row:?}");
        // the chord of the outer nodes is the tangent at the middle one
        let [work] = contact.displacements[..] else {
            panic!("{contact:?}")
        };
        assert!(work.apart.abs() <= work.rounding, "{work:?}");
        // the kinetic energy of the chord, and that of the motion
        let chord = 2.0 * (h / 2.0).sin() / h;
        let [gap] = contact.lagrangian[..] else {
            panic!("{contact:?}")
        };
        assert!((gap.apart - (chord.powi(2) - 1.0) / 2.0).abs() < 1e-13, "{gap:?}");
        // m a_d against m a
        let forces: Vec<f64> = contact.forces.iter().map(|gap| gap.apart).collect();
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

/// The same with the expansion of the exact one to the fourth order.
#[dsocs {
    coordinates(x);
    lagrangian = (dot(x).powi(2) - x.powi(2)) / 2;
    discrete_lagrangian = (x[0].powi(2) + x[1].powi(2)) / 2 * (1 / h.powi(2) - 1 / 3 - h.powi(2) / 45)
        - x[0] * x[1] * (1 / h.powi(2) + 1 / 6 + 7 * h.powi(2) / 360);
}]
struct Fourth;

/// With a potential that is twice too large.
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
    // the paper's start has an error of order 1, and is named
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

/// A pendulum on a cart with a law by the decrease of a Lyapunov function: the cart's motor.
const LYAPUNOV: &str = "coordinates(x, theta);
lagrangian = dot(x).powi(2) + dot(theta).powi(2) / 2 + dot(x) * dot(theta) * theta.cos() + theta.cos();
let energy = dot(theta).powi(2) / 2 - theta.cos() + x.powi(2) / 2 + x * dot(theta);
kinematic = dot(energy) + dot(theta).powi(2) / 5;
constraint_forces = [(1, 0)];";

/// A particle whose curvature depends on its speed, under a force: all three maps enter.
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
        // the motor acts on the cart wherever nodes are
        assert_eq!(found.of(Part::Displacements), Some(&Order::Exact));
        assert_flow(&found, f64::min(forces, rows));
    }
}

#[test]
fn what_the_constraint_force_takes_up_lowers_nothing() {
    // as many constraints as coordinates: the force alone depends on L_d
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

    let body = Text::parse(
        "body",
        "coordinates(r: rotation);
         let w = r.angular_velocity();
         lagrangian = w.norm_squared() / 2 - (r * [0, 0, 1])[2];",
    );
    let body = Entry::of_text("body", &body.unwrap(), None);
    let settings = Settings {
        q0: &[1.0, 0.0, 0.0, 0.0],
        v0: &[0.0, 0.1, 0.2, 0.3],
        ..settings
    };
    let failure = body.orders(&settings).unwrap_err();
    assert!(matches!(failure, CheckFailure::Orders { .. }) && failure.to_string().contains("rotation"));
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
        // the paper's map has the push at the nodes themselves
        match variant.map.name {
            "L: midpoint" => assert_order(&found, Part::ExternalForces, 2.0),
            _ => assert!(found.of(Part::ExternalForces).unwrap().number() >= Some(2.0)),
        }
        assert_flow(&found, if variant.map.name == "L: paper" { 1.0 } else { 2.0 });
    }
}

/// Numbers by a linear congruence.
struct Draws(u64);

impl Draws {
    /// A number between 0 and 1.
    fn number(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of some.
    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        self.number();
        of[usize::try_from(self.0 >> 33).unwrap() % of.len()]
    }

    /// A coefficient, which may be zero.
    fn coefficient(&mut self) -> String {
        let is_zero = self.number() < 0.25;
        let size = 0.3 + 0.6 * self.number();
        format!("{:?}", if is_zero { 0.0 } else { size })
    }
}

/// The Lagrangian, constraints and maps of a system by chance, and whether its `D_K` and its `D_V` are of order 1 by their maps.
fn drawn(draws: &mut Draws) -> (String, [bool; 2]) {
    let [a, b, c, d, f] = core::array::from_fn(|_| draws.coefficient());
    let mut text = format!(
        "coordinates(x, y);
        lagrangian = (2 + {a} * x.sin()) / 2 * dot(x).powi(2) + (1 + {b} * x.powi(2)) / 2 * dot(y).powi(2) + {c} / 2 * dot(x) * dot(y)
            + {d} * y.powi(2) * dot(x) - x.powi(2) / 2 - y.powi(2) - x * y / 3 - x.powi(3) / 5;
        external_forces = (-{f} * dot(x) * (1 + y.powi(2)), {f} * t.sin());\n"
    );
    let place = draws.one(&[
        "q0",
        "q0 / 4 + 3 * q1 / 4",
        "(q0 + q1) / 2",
        "(q0 + q1) / 2",
        "q1",
    ]);
    let _ = writeln!(text, "phi_lagrangian = |q0, q1| ({place}, (q1 - q0) / h);");
    if draws.number() < 0.3 {
        return (text, [false; 2]);
    }
    let mut low = [false; 2];
    for (low, statement) in low.iter_mut().zip(["phi_kinematic", "phi_variational"]) {
        let place = draws.one(&["q1", "q1", "(q0 + 2 * q1 + q2) / 4", "q1 + (q2 - q0) / 8"]);
        let velocity = draws.one(&[
            "(q2 - q0) / (2 * h)",
            "(q2 - q0) / (2 * h)",
            "(q2 - q1) / h",
            "(3 * q2 - 2 * q1 - q0) / (4 * h)",
        ]);
        let _ = writeln!(
            text,
            "{statement} = |q0, q1, q2| ({place}, {velocity}, (q2 - 2 * q1 + q0) / (h * h));"
        );
        *low = place.contains("/ 8") || !velocity.contains("- q0) / (2");
    }
    text +=
        "kinematic = ddot(y) + dot(x) * dot(y) / 3 + y + x.powi(2) / 4 + dot(y).powi(2) / 5 - x * dot(x) / 4;
        variational = [(1 + dot(y) / 3 + x / 5, x / 2 + dot(x) / 4)];\n";
    (text, low)
}

/// Asserts that the order that follows is seen, of so many systems by chance; and the orders of rows and fields that follow from their maps.
fn follow(draws: u64) {
    let mut counts = [0; 3];
    for draw in 0..draws {
        let (text, low) = drawn(&mut Draws(draw));
        let found = of_text(&text, "", (&[0.4, -0.3], &[0.5, 0.8]), 0.02);
        assert!(
            matches!(found.follows, Order::Power { .. }),
            "{draw}: {text}{found:?}"
        );
        assert_eq!(
            found.follows.number(),
            found.seen.number(),
            "{draw}: {text}{found:?}"
        );
        for (part, low) in [Part::Accelerations, Part::Displacements].into_iter().zip(low) {
            if found.of(part).is_some() {
                assert_order(&found, part, if low { 1.0 } else { 2.0 });
            }
        }
        for (count, order) in counts.iter_mut().zip([0.0, 1.0, 2.0]) {
            *count += u64::from(found.seen.number() == Some(order));
        }
    }
    println!("{draws} systems: {counts:?} of order 0, 1, 2");
    let [none, first, second] = counts;
    assert!(none == 0 && first > draws / 10 && second > draws / 10 && first + second == draws);
}

#[test]
fn the_order_that_follows_is_seen_of_systems_by_chance() {
    follow(40);
}

/// In a release build, 10 s.
#[test]
#[ignore = "takes a minute; by hand"]
fn the_order_that_follows_is_seen_of_many_systems_by_chance() {
    follow(1000);
}

/// What the command prints and what it tells, and whether it succeeds.
fn dsocs(folder: &Path, arguments: &[&str]) -> (String, String, bool) {
    let run = Command::new(env!("CARGO_BIN_EXE_dsocs"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let [out, told] = [run.stdout, run.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    (out, told, run.status.success())
}

#[test]
fn the_command_writes_values_and_says_what_it_cannot_measure() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text =
        format!("{BEAD} phi_lagrangian = paper; run {{ start = ([1], [0.3]); step = 0.05; until = 5.0; }}");
    std::fs::write(folder.join("bead.dsocs"), text).unwrap();
    let (out, told, good) = dsocs(folder, &["check", "bead.dsocs", "--orders", "--out", "bead.json"]);
    assert!(good, "{told}");
    assert!(
        out.contains("phi_lagrangian = paper lowers the order of the flow"),
        "{out}"
    );
    let values: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("bead.json")).unwrap()).unwrap();
    let map = &values["systems"][0]["maps"][0];
    assert!(
        (map["follows"]["power"].as_f64().unwrap() - 1.0).abs() < 0.05,
        "{map:#}"
    );
    assert_eq!(map["parts"][0]["part"], "L_d");
    assert_eq!(map["lowering"][0], "D₁L_d + D₂L_d");
    assert_eq!(map["holds"], true);
    // a motion that lasts as long as it is told
    let (out, _, good) = dsocs(folder, &["check", "bead.dsocs", "--orders", "--until", "2"]);
    assert!(good && out.contains("errors to t = 1.9"), "{out}");

    let (_, told, good) = dsocs(folder, &["check", "crane", "--orders"]);
    assert!(!good && told.contains("a constraint is of third order"), "{told}");
    let (out, told, good) = dsocs(folder, &["check", "crane", "bead.dsocs", "--orders"]);
    assert!(
        good && out.contains("crane: not measured") && out.contains("bead"),
        "{out}{told}"
    );
    for wrong in [
        ["check", "bead.dsocs", "--every-map"].as_slice(),
        &["check", "bead.dsocs", "--orders", "--out", "bead.txt"],
        &["check", "bead.dsocs", "--out", "bead.md"],
    ] {
        assert!(!dsocs(folder, wrong).2, "{wrong:?}");
    }
}

/// The table of the chapter is what its command writes.
#[test]
fn the_table_of_the_book_is_true() {
    let folder = tempfile::tempdir().unwrap();
    let table = ["check", "--orders", "--every-map", "--out", "orders.md"];
    let (_, told, good) = dsocs(folder.path(), &table);
    assert!(good, "{told}");
    let found = std::fs::read_to_string(folder.path().join("orders.md")).unwrap();
    let book = include_str!("../src/guide/orders.md");
    assert!(book.contains(&found), "the table is now\n{found}");
}

/// The listings of the chapter are systems, and what is said below each of them is what it shows.
#[test]
fn the_listings_of_the_chapter_run() {
    let folder = tempfile::tempdir().unwrap();
    let book = include_str!("../src/guide/orders.md");
    let blocks: Vec<&str> = book
        .split("```text\n")
        .skip(1)
        .filter_map(|block| block.split("```").next())
        .collect();
    let [listing, shown] = blocks[..] else {
        panic!("{blocks:?}")
    };
    std::fs::write(folder.path().join("turn.dsocs"), listing).unwrap();
    let (found, ..) = dsocs(folder.path(), &["check", "turn.dsocs", "--orders"]);
    // distances may differ in their last digits on another machine
    let words = |text: &str| -> Vec<String> {
        let words = text.split_whitespace();
        words
            .filter(|word| !word.contains("e-"))
            .map(str::to_owned)
            .collect()
    };
    assert_eq!(words(&found), words(shown), "{found}");
}
