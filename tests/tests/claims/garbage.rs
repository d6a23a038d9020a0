//! Arbitrary numbers as states, parameters and steps, on all systems: no panic, no hang, and every accepted
//! step leads to a finite node.

use crate::systems::{builtin, constrained, maps, mass, opaque};
use dsocs_core::{Flow, Real, Regularity, Start, Stepper, System};
use dsocs_systems::{Constant, Curvature, CurvedParticle, InertiaWheelPendulum, PlanarChain2, Wavy};
use proptest::prelude::*;

use crate::draws::{self, sized, vector};

/// A number of any kind, or an ordinary one.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => -2.0..2.0,
        1 => prop::num::f64::ANY,
        1 => (-300.0..300.0_f64).prop_map(|exponent| 10.0_f64.powf(exponent)),
        1 => prop::sample::select(vec![0.0, -0.0, f64::NAN, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE, 5e-324, 1e-320]),
    ]
}

/// Runs a system from 300 random starts by three rules, ten steps each: no panic, and every accepted position
/// is finite.
fn shoot<S: System<N>, const N: usize>(system: &S) {
    let steps = prop_oneof![2 => Just(0.1), 1 => number()].boxed();
    let states = (0..3, steps, vector::<N>(number()), vector::<N>(number()));
    draws::test(300, 4, states, &|(rule, h, q, v)| {
        let (q, v): ([f64; N], _) = (sized(&q), sized(&v));
        let start = match rule {
            0 => Start::paper(q, v),
            1 => Start::second_order(q, v),
            _ => Start::nodes(q, v),
        };
        let Ok(mut flow) = Flow::new(system, h, start) else {
            return Ok(());
        };
        for _ in 0..10 {
            let leg = flow.leg();
            match flow.advance() {
                Ok(_) => prop_assert!(flow.position().iter().all(|q| q.is_finite())),
                Err(error) => {
                    prop_assert!(!error.to_string().is_empty());
                    // regularity and roots can be computed for any state
                    let _ = Regularity::of(system.kernel(), h, leg.any(), &[0.0; N]).grants_flow();
                    let _ = flow.roots();
                    break;
                }
            }
            let _ = (flow.node(), flow.regularity());
        }
        Ok(())
    });
}

/// A curvature whose functions have delicate dual numbers: at kinks, at zero, and for large arguments.
struct Delicate;

impl Curvature for Delicate {
    fn at<D: Real>(&self, x: D, y: D) -> D {
        (x * 400.0).tanh() + (x * x).sqrt() - (y.abs() + 1.0).ln() + x.powi(3).cbrt() * y.atan2(x)
    }
}

#[test]
fn on_the_systems_of_the_paper() {
    shoot(&CurvedParticle::default());
    shoot(&CurvedParticle {
        mass: 1e-300,
        curvature: Constant(1e300),
    });
    shoot(&CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    });
    shoot(&CurvedParticle {
        mass: 1.0,
        curvature: Delicate,
    });
    shoot(&InertiaWheelPendulum::default());
    shoot(&InertiaWheelPendulum {
        rho: 1e200,
        ..InertiaWheelPendulum::default()
    });
    shoot(&PlanarChain2::default());
}

#[test]
fn on_systems_with_many_functions() {
    shoot(&builtin::Everywhere { p: 0.9 });
    shoot(&builtin::Positive { p: 0.9 });
    shoot(&builtin::Bounded { p: 0.9 });
    shoot(&builtin::Branches { edge: 0.3 });
    shoot(&opaque::Landscape::default());
    shoot(&opaque::Metric::default());
    shoot(&opaque::Speed { gain: 0.4 });
}

#[test]
fn on_systems_with_other_maps_and_constraints() {
    shoot(&maps::Midpoint {
        mass: 1.3,
        stiffness: 0.7,
    });
    shoot(&maps::Forward { curvature: 0.8 });
    shoot(&maps::Averaged { curvature: 0.8 });
    shoot(&constrained::Two { mass: 1.5 });
    shoot(&constrained::Forces { mass: 1.5 });
    shoot(&constrained::Divided { mass: 1.5 });
    shoot(&mass::Constrained {
        ratio: 0.6,
        gravity: 9.81,
    });
}
