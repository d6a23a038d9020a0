//! The generated rows, Jacobians, forces and energies are those of the declaration.
//!
//! Each system below is written twice: declared with `#[dsocs]`, and as functions over dual numbers ([`Declaration`]), from
//! which the rows follow by nested dual numbers as the paper defines them. [`compare`] compares them at random states, and
//! the Jacobian also with difference quotients and with the generated code run with dual numbers.

use dsocs_core::System;
use dsocs_systems::{Constant, CurvedParticle, InertiaWheelPendulum, Wavy};
use dsocs_tests::check::{Kind, Mismatch, State, compare};
use dsocs_tests::independent::Declaration;
use proptest::prelude::*;

use crate::draws::{self, sized, vector};
use crate::systems::{builtin, constrained, maps, mass, opaque, paper};

/// The ranges from which states are drawn.
struct Range {
    q: f64,
    v: f64,
    a: f64,
}

const ORDINARY: Range = Range {
    q: 2.0,
    v: 2.0,
    a: 3.0,
};

/// Compares at random states, the same in every run.
fn compare_jacobians<S, P, const N: usize>(system: &S, declaration: &P, kind: Kind, Range { q, v, a }: Range)
where
    S: System<N>,
    P: Declaration<N>,
{
    let steps = prop_oneof![0.02..0.5, -0.5..-0.02].boxed();
    let states = (steps, vector::<N>(-q..q), vector::<N>(-v..v), vector::<N>(-a..a));
    draws::test(200, 2, states, &|(h, q, v, a)| {
        let [q, v, a] = [q, v, a].map(|x| sized(&x));
        compare(system, declaration, State { h, q, v, a }, kind).map_err(|mismatch| match mismatch {
            Mismatch::Undefined => TestCaseError::reject("undefined here"),
            Mismatch::Differs(words) => TestCaseError::fail(words),
        })
    });
}

/// A system that is written both ways itself.
fn at_random_states<S, const N: usize>(system: &S, kind: Kind, range: Range)
where
    S: System<N> + Declaration<N>,
{
    compare_jacobians(system, system, kind, range);
}

#[test]
fn of_the_particle() {
    let particle = CurvedParticle {
        mass: 1.7,
        curvature: Constant(-0.6),
    };
    compare_jacobians(&particle, &paper::Particle(&particle), Kind::default(), ORDINARY);
    let particle = CurvedParticle {
        mass: 0.4,
        curvature: Wavy::default(),
    };
    compare_jacobians(&particle, &paper::Particle(&particle), Kind::default(), ORDINARY);
}

#[test]
fn of_the_pendulum() {
    // velocities for which w stays within the range of hyperbolic functions; the switch is narrow in the unknown
    let kind = Kind {
        nudge: 1e-6,
        ..Kind::default()
    };
    let pendulum = InertiaWheelPendulum::default();
    compare_jacobians(
        &pendulum,
        &paper::Pendulum(&pendulum),
        kind,
        Range {
            q: 3.0,
            v: 0.5,
            a: 2.0,
        },
    );
    compare_jacobians(
        &pendulum,
        &paper::Pendulum(&pendulum),
        kind,
        Range {
            q: 0.5,
            v: 0.02,
            a: 0.1,
        },
    );
}

#[test]
fn with_a_midpoint_lagrangian() {
    at_random_states(
        &maps::Midpoint {
            mass: 1.3,
            stiffness: 0.7,
        },
        Kind::default(),
        ORDINARY,
    );
}

#[test]
fn with_a_lagrangian_on_both_nodes() {
    at_random_states(&maps::Weighted { weight: 0.3 }, Kind::default(), ORDINARY);
}

#[test]
fn with_other_kinematic_and_variational_maps() {
    at_random_states(&maps::Forward { curvature: 0.8 }, Kind::default(), ORDINARY);
    at_random_states(&maps::Mixed { curvature: 0.8 }, Kind::default(), ORDINARY);
    at_random_states(&maps::Averaged { curvature: 0.8 }, Kind::default(), ORDINARY);
}

#[test]
fn with_a_mass_matrix_that_varies() {
    at_random_states(
        &mass::DoublePendulum {
            ratio: 0.6,
            gravity: 9.81,
        },
        Kind::default(),
        ORDINARY,
    );
    at_random_states(
        &mass::DoublePendulumMidpoint {
            ratio: 0.6,
            gravity: 9.81,
        },
        Kind::default(),
        ORDINARY,
    );
    at_random_states(
        &mass::Constrained {
            ratio: 0.6,
            gravity: 9.81,
        },
        Kind::default(),
        ORDINARY,
    );
}

#[test]
fn with_functions_of_the_users() {
    at_random_states(&opaque::Landscape::default(), Kind::default(), ORDINARY);
    at_random_states(
        &opaque::Metric::default(),
        Kind {
            opaque: true,
            ..Kind::default()
        },
        ORDINARY,
    );
    at_random_states(
        &opaque::Speed { gain: 0.4 },
        Kind {
            opaque: true,
            ..Kind::default()
        },
        ORDINARY,
    );
}

#[test]
fn with_several_rows_and_forces() {
    at_random_states(&constrained::Two { mass: 1.5 }, Kind::default(), ORDINARY);
    at_random_states(&constrained::Forces { mass: 1.5 }, Kind::default(), ORDINARY);
    at_random_states(
        &constrained::Divided { mass: 1.5 },
        Kind {
            nudge: 1e-4,
            ..Kind::default()
        },
        ORDINARY,
    );
}

#[test]
fn with_branches() {
    // a difference quotient across a kink is no derivative: those states are drawn again
    at_random_states(
        &builtin::Branches { edge: 0.3 },
        Kind {
            nudge: 1e-9,
            ..Kind::default()
        },
        ORDINARY,
    );
}

#[test]
fn of_every_function() {
    at_random_states(&builtin::Everywhere { p: 0.9 }, Kind::default(), ORDINARY);
    at_random_states(&builtin::Positive { p: 0.9 }, Kind::default(), ORDINARY);
    at_random_states(&builtin::Bounded { p: 0.9 }, Kind::default(), ORDINARY);
}
