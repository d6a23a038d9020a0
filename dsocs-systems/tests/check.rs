//! Every system of the library passes its checks, and what is not so fails them.

use dsocs_core::dsocs;
use dsocs_systems::check::{Expected, Finding, Settings, check};
use dsocs_systems::entry::{Kind, Symmetry};
use dsocs_systems::{CurvedParticle, Entry, GravityTurn, PlanarChain2, systems};

/// The default settings of a system.
fn settings(entry: &Entry) -> Settings<'_> {
    let [q0, v0] = entry.default_start().unwrap();
    Settings {
        h: entry.default_step(),
        until: None,
        q0,
        v0,
    }
}

#[test]
fn every_system_passes() {
    for entry in systems::all() {
        let findings = entry.check(&settings(&entry)).unwrap();
        for finding in &findings {
            assert!(finding.ok(), "{}: {finding:?}", entry.name());
        }
        for check in [
            "regularity",
            "symplectic law",
            "momentum law",
            "reversibility",
            "order",
        ] {
            assert!(
                findings.iter().any(|finding| finding.check == check),
                "{}: {check}",
                entry.name()
            );
        }
    }
}

/// The findings that miss their bar.
fn missed(findings: &[Finding]) -> Vec<(&'static str, &str)> {
    let missed = findings.iter().filter(|finding| !finding.ok());
    missed
        .map(|finding| (finding.check, finding.what.as_str()))
        .collect()
}

#[test]
fn a_constrained_system_is_not_symplectic() {
    let particle = CurvedParticle::default();
    let expected = Expected {
        kind: Kind::Unconstrained,
        order: 2.0,
        reversible: true,
    };
    let entry = systems::particle::entry();
    let start = ([0.0, 0.0], [1.0, 1.0]);
    let findings = check(&particle, &[], expected, &settings(&entry), start).unwrap();
    let missed = missed(&findings);
    assert_eq!(missed.len(), 2, "{missed:?}");
    assert!(
        missed[0].1.starts_with("dξ") && missed[1].1.contains("dν"),
        "{missed:?}"
    );
}

#[test]
fn gravity_has_no_symmetry_of_translation() {
    let symmetries = [Symmetry::new("translation along y", |_: &[f64; 2]| [0.0, 1.0])];
    let expected = Expected {
        kind: Kind::SecondOrder,
        order: 2.0,
        reversible: true,
    };
    let entry = systems::gravity_turn::entry();
    let start = ([0.0, 0.0], [1.0, 3.0]);
    let findings = check(
        &GravityTurn::default(),
        &symmetries,
        expected,
        &settings(&entry),
        start,
    )
    .unwrap();
    let missed = missed(&findings);
    assert_eq!(missed.len(), 2, "{missed:?}");
    assert!(
        missed.iter().all(|(check, _)| *check == "momentum law"),
        "{missed:?}"
    );
}

#[test]
fn another_order_is_not_found() {
    let expected = Expected {
        kind: Kind::Unconstrained,
        order: 3.0,
        reversible: true,
    };
    let entry = systems::double_pendulum::entry();
    let start = ([2.0, 1.0], [0.0, 0.0]);
    let findings = check(&PlanarChain2::default(), &[], expected, &settings(&entry), start).unwrap();
    let missed = missed(&findings);
    assert!(missed.len() == 1 && missed[0].0 == "order", "{missed:?}");
}

/// A pendulum whose inertia depends on its angle, with the paper's map.
#[dsocs {
    coordinates(theta);
    lagrangian = (1 + theta.sin() / 2) * dot(theta).powi(2) / 2 + theta.cos();
}]
struct Uneven;

/// `φ = (q0, ·)` where the mass matrix depends on the angle: of order 1, and another map with `−h`; the inverse is found all the same.
#[test]
fn what_is_not_symmetric_in_time_is_told() {
    let expected = |order, reversible| Expected {
        kind: Kind::Unconstrained,
        order,
        reversible,
    };
    let settings = Settings {
        h: 0.02,
        until: None,
        q0: &[1.0],
        v0: &[0.5],
    };
    let find = |expected| check(&Uneven, &[], expected, &settings, ([1.0], [0.5])).unwrap();
    assert_eq!(missed(&find(expected(1.0, false))), []);
    let wrong = find(expected(2.0, true));
    let wrong: Vec<&str> = missed(&wrong).iter().map(|(check, _)| *check).collect();
    assert_eq!(wrong, ["reversibility", "order"]);
}

/// A pendulum on a rod, in Cartesian coordinates.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
    holonomic = (x.powi(2) + y.powi(2) - 1) / 2;
}]
struct Rod;

/// A particle with `ż = y ẋ`, which is imposed at the midpoint.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - y.powi(2) / 2;
    nonholonomic = dot(z) - y * dot(x);
}]
struct Nonholonomic;

/// The same with the paper's map, which imposes it at the first node of a leg.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - y.powi(2) / 2;
    nonholonomic = dot(z) - y * dot(x);
    phi_lagrangian = paper;
}]
struct OneSided;

#[test]
fn constraints_of_lower_order_are_checked_on_what_they_allow() {
    let expected = |kind| Expected {
        kind,
        order: 2.0,
        reversible: true,
    };
    let (q0, v0) = ([0.6, -0.8], [0.8, 0.6]);
    let settings = |h| Settings {
        h,
        until: None,
        q0: &[],
        v0: &[],
    };
    let rod = check(&Rod, &[], expected(Kind::Holonomic), &settings(0.02), (q0, v0)).unwrap();
    assert_eq!(missed(&rod), [], "{rod:?}");
    let start = ([0.0, 1.0, 0.0], [1.0, 0.5, 1.0]);
    let symmetries = [Symmetry::new("translation along x", |_: &[f64; 3]| {
        [1.0, 0.0, 0.0]
    })];
    let settings = settings(0.05);
    let particle = |kind| check(&Nonholonomic, &symmetries, expected(kind), &settings, start).unwrap();
    let found = particle(Kind::Nonholonomic);
    assert_eq!(missed(&found), [], "{found:?}");
    // it is no holonomic one
    let found = particle(Kind::Holonomic);
    assert_eq!(missed(&found).len(), 2, "{found:?}");
    // at one end of the legs it is of order 1, and another map with −h
    let found = check(&OneSided, &[], expected(Kind::Nonholonomic), &settings, start).unwrap();
    let checks: Vec<&str> = missed(&found).iter().map(|(check, _)| *check).collect();
    assert_eq!(checks, ["reversibility", "order"], "{found:?}");
}
