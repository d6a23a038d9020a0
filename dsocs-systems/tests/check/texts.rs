//! The checks do not fail on correct declarations that are read at run time: bodies that are damped, unstable
//! or fast, and bodies that hover.

use dsocs_core::text::Text;
use dsocs_systems::check::{Expected, Finding, Settings, check_tape};
use dsocs_systems::entry::Kind;
use dsocs_systems::stability::Bar;
use dsocs_systems::{Entry, systems};

use crate::{found, missed, settings};

/// The entry of a text, with its first run.
fn read(text: &str) -> Entry {
    let text = Text::parse("text", text).unwrap();
    Entry::of_text("text", &text, text.runs.first())
}

/// The findings along its motion, with this initial velocity and end if they are given.
fn findings(entry: &Entry, v0: Option<&[f64]>, until: Option<f64>) -> Vec<Finding> {
    let own = settings(entry);
    let settings = Settings {
        v0: v0.unwrap_or(own.v0),
        until: until.or(Some(entry.checked_end())),
        ..own
    };
    entry.check(&settings).unwrap()
}

/// A wing nut in free flight.
const NUT: &str = "parameters { inertia = [[3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]] }
    coordinates(r: rotation);
    let w = r.angular_velocity();
    lagrangian = w.inner(inertia * w) / 2;
    run { start = ([1, 0, 0, 0], [0.001, 5.0, 0.002]); step = 0.02; until = 40.0; }";

#[test]
fn a_damped_body_steps_back_as_it_stepped() {
    // a motion that is damped by e²⁰ forward grows by as much backward
    let damped = read(
        "coordinates(r: rotation, x);
        let w = r.angular_velocity();
        lagrangian = w.norm_squared() / 2 + dot(x).powi(2) / 2 - x.powi(2) / 2 + r.matrix()[2][2];
        external_forces = (-2.0 * w, -dot(x));
        run { start = ([0.8, 0.6, 0, 0, 1], [0.3, 0.2, -0.5, 0]); step = 0.02; until = 20.0; }",
    );
    for findings in [
        findings(&damped, None, None),
        // an unstable motion grows both ways
        findings(&read(NUT), None, None),
    ] {
        assert_eq!(missed(&findings), []);
        let back = found(&findings, "distance of the step with −h");
        assert!(matches!(back.bar, Bar::AtMost(bar) if bar <= 1e-12), "{back:?}");
    }
}

#[test]
fn a_built_in_system_has_the_bars_of_its_text() {
    for shipped in systems::texts::TEXTS
        .iter()
        .filter(|shipped| shipped.name == "quadrotor")
    {
        let (own, text) = (shipped.entry(&[]).unwrap(), read(shipped.text));
        let until = Some(200.0 * own.default_step());
        let [own, text] = [&own, &text].map(|entry| findings(entry, None, until));
        assert_eq!(missed(&text), []);
        assert_eq!(own, text);
    }
}

/// Bodies whose thrust balances their weight, so that their motion is rounding: no check fails, and the
/// certificate is as large as in motion.
#[test]
fn what_hovers_is_as_regular_as_what_flies() {
    // the thrust differs from the weight by rounding, which alone causes the motion
    let texts = [
        "parameters { mass = 0.8, gravity = 9.81, thrust = 7.848 }
        coordinates(r: rotation, x: [3]);
        let w = r.angular_velocity();
        lagrangian = 0.006 * w.norm_squared() / 2 + mass * dot(x).norm_squared() / 2 - mass * gravity * x[2];
        external_forces = ([0, 0, 0], r * [0, 0, thrust]);
        run { start = ([1, 0, 0, 0, 0, 0, 0], [0; 6]); step = 0.005; until = 2.0; }",
        "parameters { mass = 0.8, gravity = 9.81, thrust = 7.848 }
        coordinates(a, x, z);
        lagrangian = 0.006 * dot(a).powi(2) / 2 + mass * (dot(x).powi(2) + dot(z).powi(2)) / 2 - mass * gravity * z;
        external_forces = (0, -thrust * a.sin(), thrust * a.cos());
        run { start = ([0, 0, 0], [0, 0, 0]); step = 0.005; until = 6.0; }",
        "coordinates(r: rotation, x: [3]);
        let w = r.angular_velocity();
        lagrangian = w.norm_squared() / 2 + dot(x).norm_squared() / 2 - x[2] * 9.81;
        external_forces = (0, [1e-17, 0, 9.81]);
        run { start = ([0.8, 0.6, 0, 0, 0, 0, 0], [0; 6]); step = 0.01; until = 2.0; }",
    ];
    for text in texts {
        let findings = findings(&read(text), None, None);
        assert_eq!(missed(&findings), [], "{text}");
        let smallest = found(&findings, "smallest singular value of D₃");
        assert!(smallest.figure > 1e-4, "{smallest:?}");
    }
    // a mass that vanishes on the way is not excused by that
    let vanishing = read(
        "coordinates(x);
        lagrangian = x * dot(x).powi(2) / 2 - x;
        run { start = ([0], [1e-12]); step = 0.01; until = 0.02; }",
    );
    let own = settings(&vanishing);
    let is_refused = vanishing.check(&own).map_or(true, |findings| {
        findings
            .iter()
            .any(|finding| finding.check == "regularity" && !finding.ok())
    });
    assert!(is_refused);
}

#[test]
fn a_momentum_is_measured_with_all_axes_of_its_rotation() {
    let nut = read(NUT);
    // one component of the angular velocity is at most 1e-4 of the others
    for (v0, until) in [([0.0, 0.001, 5.0, 0.002], 40.0), ([0.0, 1e-8, 0.0, 3.0], 20.0)] {
        let findings = findings(&nut, Some(&v0), Some(until));
        let momenta: Vec<&Finding> = findings
            .iter()
            .filter(|finding| finding.what.contains("variation of J"))
            .collect();
        assert_eq!(momenta.len(), 3);
        for momentum in momenta {
            assert!(momentum.holds() && momentum.figure < 1e-13, "{momentum:?}");
            assert!(momentum.bar != Bar::Reported, "{momentum:?}");
        }
    }
}

#[test]
fn the_order_of_a_rough_spin_is_fitted_where_errors_fall_as_a_power() {
    let nut = read(NUT);
    for (v0, until) in [([0.0, 30.0, 40.0, 50.0], 2.0), ([0.0, 60.0, 80.0, 10.0], 0.5)] {
        let findings = findings(&nut, Some(&v0), Some(until));
        assert_eq!(missed(&findings), []);
        let order = findings.iter().rfind(|finding| finding.check == "order").unwrap();
        let note = order.note.as_deref().unwrap_or_default();
        assert!(note.contains("fitted from h = 5.0e-3"), "{order:?}");
        assert!(order.figure > 1.9 && order.figure < 2.1, "{order:?}");
    }
}

/// With masses that span twenty decades, the change `dξ` of the symplectic form by a nonholonomic constraint
/// is found: it is above 1e-3 of the terms.
#[test]
fn what_constraints_change_is_seen_in_any_units() {
    // masses that span twenty decades
    let beside = read(
        "coordinates(x, y);
        lagrangian = 0.5e12 * dot(x).powi(2) + 0.5e-8 * dot(y).powi(2) - 0.5e12 * x.powi(2) - 0.5e-6 * (y - 1e-6 * x).powi(2);
        nonholonomic = [dot(y) - 1e-6 * dot(x) * (1 + t)];
        run { start = ([1000.0, 0.001], [0, 0]); step = 0.01; until = 1.0; }",
    );
    let findings = findings(&beside, None, None);
    assert_eq!(missed(&findings), []);
    let change = found(&findings, "dξ along the pairs");
    assert!(change.figure > 1e-3, "{change:?}");
}

/// An excuse for one reason hides no wrong order: a text is checked against other orders than that of the
/// step, and has to fail.
#[test]
fn what_is_open_hides_no_other_order() {
    for (kind, orders, text) in [
        // a mass that nearly vanishes: errors fall as the third power until the step is short enough
        (
            Kind::Unconstrained,
            &[(1.0, true), (2.0, false)][..],
            "coordinates(x);
            lagrangian = dot(x).powi(4) / 4 + 1e-3 * dot(x).powi(2) / 2 - x.powi(2) / 2;
            run { start = ([1], [0]); step = 0.01; until = 1; }",
        ),
        // constraints that nearly depend on each other
        (
            Kind::Holonomic,
            &[(1.0, true), (2.0, false), (3.0, true)],
            "coordinates(x, y, z);
            lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - 9.81 * y;
            holonomic = [z - 0.3 * x, z - 0.3 * x + 1e-8 * (y - x.powi(2))];
            run { start = ([1, 1, 0.3], [0, 0, 0]); step = 0.01; until = 1; }",
        ),
        // a motion that ends by itself
        (
            Kind::Unconstrained,
            &[(1.0, true), (2.0, false), (3.0, true)],
            "coordinates(x);
            lagrangian = dot(x).powi(2) / 2 - 2 * x * x.sqrt() / 3;
            run { start = ([1], [-2.5]); step = 0.01; until = 5; }",
        ),
    ] {
        let (entry, read) = (read(text), Text::parse("text", text).unwrap());
        let until = Some(entry.checked_end());
        for &(order, fails) in orders {
            let expected = Expected {
                kind,
                order,
                reversible: true,
            };
            let settings = Settings {
                until,
                ..settings(&entry)
            };
            let findings = check_tape(&read.system, &[], expected, &settings).unwrap();
            let of_order =
                |finding: &&Finding| !finding.ok() && finding.what.starts_with("distance of that from");
            assert_eq!(
                findings.iter().any(|finding| of_order(&finding)),
                fails,
                "{order}: {text}"
            );
        }
    }
}
