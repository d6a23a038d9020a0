//! Singular values of `D₃` and `D₁` do not depend on units, account for derivatives of the user's functions,
//! and show where the theorem on the discrete flow does not apply.

use std::ops::ControlFlow;

use dsocs_core::{Flow, Leg, Real, Regularity, Start, Stepper, dsocs};
use dsocs_systems::{Constant, CurvedParticle, InertiaWheelPendulum};
use dsocs_tests::declared;
use dsocs_tests::text::read;

#[test]
fn units_are_of_no_account() {
    let at = |length: f64, mass: f64| {
        let particle = CurvedParticle {
            mass,
            curvature: Constant(1.0 / length),
        };
        let leg = Leg {
            t: 0.0,
            q: [0.3 * length, -0.2 * length],
            d: [0.1 * length, 0.05 * length],
        };
        Regularity::of(&particle, 0.1, leg.any(), &[-0.004 * length, 0.008 * length])
    };
    let unit = at(1.0, 1.0);
    assert!(
        unit.grants_flow() && unit.forward > 0.01 && unit.backward > 0.01,
        "{unit:?}"
    );
    for exponent in [-200, -30, 30, 200] {
        let scale = 2.0_f64.powi(exponent);
        assert_eq!(at(scale, 1.0), unit);
        assert_eq!(at(1.0, scale), unit);
    }
}

/// A drag as a user's function.
fn drag<R: Real>(v: R) -> R {
    v * (v * v + 1.0).sqrt()
}

/// A constraint with a function of which the macro knows nothing.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + drag(dot(x));
    constraint_forces = [(1,)];
}]
struct Opaque;

declared! {
    /// The constraint of `Opaque`, with the drag written out.
    struct Plain;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + dot(x) * (dot(x).powi(2) + 1).sqrt();
    constraint_forces = [(1,)];
}

/// With one row and one coordinate `D₃` is `1/h² + c/2h` and `D₁` is `1/h² − c/2h`, with the drag's slope `c` at the central
/// velocity, both in one unit.
#[test]
fn functions_of_the_users_are_seen_through() {
    let (h, d, e) = (0.1, 0.05, 0.01);
    let leg = Leg {
        t: 0.0,
        q: [0.3],
        d: [d],
    };
    let v: f64 = (2.0 * d + e) / (2.0 * h);
    let c = (2.0 * v * v + 1.0) / (v * v + 1.0).sqrt();
    let wanted = (1.0 / h + c / 2.0) / (1.0 / h - c / 2.0);
    let quotient = |at: Regularity| at.forward / at.backward;
    let plain = quotient(Regularity::of(read(&Plain), h, leg.any(), &[e]));
    assert!((plain - wanted).abs() < 1e-14, "{plain} {wanted}");
    let opaque = quotient(Regularity::of(&Opaque, h, leg.any(), &[e]));
    assert!((opaque - wanted).abs() < 1e-11, "{opaque} {wanted}");
}

#[test]
fn a_particle_at_rest_has_no_flow() {
    let leg = Leg {
        t: 0.0,
        q: [0.0; 2],
        d: [0.0; 2],
    };
    let at = Regularity::of(&CurvedParticle::default(), 0.1, leg.any(), &[0.0; 2]);
    assert!(
        !at.grants_forward() && !at.grants_backward() && !at.grants_flow(),
        "{at:?}"
    );
}

#[test]
fn a_certified_run_tells_every_node() {
    let pendulum = InertiaWheelPendulum::default();
    let mut flow = Flow::new(&pendulum, 0.1, Start::second_order([0.5, 0.0], [0.0, 0.5])).unwrap();
    let mut nodes = Vec::new();
    flow.certify(10.0, &mut |node, regularity| {
        nodes.push((*node, regularity));
        ControlFlow::Continue(())
    })
    .unwrap();
    let mut again = Flow::new(&pendulum, 0.1, Start::second_order([0.5, 0.0], [0.0, 0.5])).unwrap();
    let trajectory = again.until(10.0).unwrap();
    assert_eq!(nodes.len(), trajectory.len());
    assert!(nodes[0].1.is_none(), "no step is solved at the start");
    for ((node, regularity), plain) in nodes.iter().zip(&trajectory).skip(1) {
        assert_eq!(node, plain);
        assert!(regularity.unwrap().grants_flow(), "{regularity:?}");
    }
}
