//! Constraints of every order, alone and mixed: the generated step gives the motion of an independent
//! formulation.

use crate::systems::orders::{
    Ellipsoid, EllipsoidWithFields, EllipsoidWithForce, Mixed, MixedWithForce, Nonholonomic,
    NonholonomicWithFields, Nonlinear, Rod, RodWithField, VariableMass,
};
use dsocs_core::__private::{Declaration, Tangent};
use dsocs_core::taylor::Tolerance;
use dsocs_core::{Node, SetupError, Start, Stepper};
use dsocs_systems::{InertiaWheelPendulum, RodAndWheel};
use dsocs_tests::fit::{self, slope};
use dsocs_tests::motion::{continuous, discrete, distance};
use dsocs_tests::text::{Flow, System, TaylorFlow};

/// The order with which the discrete motion from a start converges to the continuous one.
fn order<S: System<N>, const N: usize>(system: &S, q: [f64; N], v: [f64; N], t: f64, steps: &[f64]) -> f64 {
    let start = Start::second_order(q, v);
    let exact = continuous(system, start, t).q;
    fit::order(system.name(), steps, |h| {
        distance(&discrete(system, h, start, t).q, &exact)
    })
}

const STEPS: [f64; 4] = [0.02, 0.01, 0.005, 0.0025];

const ROD: Rod = Rod { gravity: 9.81 };

#[test]
fn orders_of_all_kinds() {
    let within = |order: f64| assert!((order - 2.0).abs() < 0.05, "{order}");
    within(order(&ROD, [0.6, -0.8], [0.8, 0.6], 5.0, &STEPS));
    let ellipsoid = Ellipsoid { gravity: 1.0 };
    within(order(&ellipsoid, [1.0, 0.0, 0.0], [0.0, 0.7, 0.4], 5.0, &STEPS));
    within(order(
        &VariableMass,
        [0.6, 0.8, 0.6],
        [0.8, -0.6, 0.5],
        3.0,
        &STEPS,
    ));
    within(order(
        &Nonholonomic,
        [0.6, 0.3, -0.8],
        [1.0, 1.0, 0.3],
        5.0,
        &STEPS,
    ));
    within(order(&Nonlinear, [0.6, 0.3, -0.8], [0.6, 0.8, 0.78], 3.0, &STEPS));
    within(order(
        &Mixed,
        [0.6, -0.8, 0.0, 1.0],
        [0.8, 0.6, 0.3, 0.5],
        3.0,
        &STEPS,
    ));
}

/// Asserts that two declarations of one system have the same position at t = 10, to 1e-12.
fn same<A: System<N>, B: System<N>, const N: usize>(a: &A, b: &B, start: Start<N>) {
    let (first, second) = (discrete(a, 0.01, start, 10.0).q, discrete(b, 0.01, start, 10.0).q);
    let apart = distance(&first, &second);
    println!("apart by {apart:.1e}");
    assert!(apart < 1e-12, "{first:?} {second:?}");
}

#[test]
fn the_basis_of_the_displacements_does_not_matter() {
    let start = Start::second_order([0.6, -0.8], [0.8, 0.6]);
    same(&ROD, &RodWithField { gravity: 9.81 }, start);
    let ellipsoid = Ellipsoid { gravity: 1.0 };
    assert_eq!(<Ellipsoid as dsocs_core::System<3>>::FORMS, 1);
    let start = Start::second_order([0.8, 0.1, 0.4], [0.3, 0.7, 0.4]).projected();
    same(&ellipsoid, &EllipsoidWithForce { gravity: 1.0 }, start);
    // away from x = 0, where these fields are dependent
    let start = Start::second_order([0.98, 0.1, 0.0], [0.0, 0.1, 0.1]).projected();
    let (fields, until) = (EllipsoidWithFields { gravity: 0.01 }, 3.0);
    let (a, b) = (
        discrete(&Ellipsoid { gravity: 0.01 }, 0.01, start, until).q,
        discrete(&fields, 0.01, start, until).q,
    );
    assert!(distance(&a, &b) < 1e-13, "{a:?} {b:?}");
    let start = Start::second_order([0.6, 0.3, -0.8], [1.0, 1.0, 0.3]);
    same(&Nonholonomic, &NonholonomicWithFields, start);
    let start = Start::second_order([0.6, -0.8, 0.0, 1.0], [0.8, 0.6, 0.3, 0.5]);
    same(&Mixed, &MixedWithForce, start);
}

#[test]
fn constraints_hold_at_every_node_and_on_every_leg() {
    let mut flow = Flow::new(&ROD, 0.01, Start::second_order([0.6, -0.8], [0.8, 0.6])).unwrap();
    let mut worst = 0.0_f64;
    for _ in 0..100_000 {
        flow.advance().unwrap();
        let [x, y] = *flow.position();
        worst = worst.max((x * x + y * y - 1.0).abs());
    }
    println!("rod {worst:.1e}");
    assert!(worst < 1e-14, "{worst:e}");
    let mut flow = Flow::new(
        &Mixed,
        0.01,
        Start::second_order([0.6, -0.8, 0.0, 1.0], [0.8, 0.6, 0.3, 0.5]),
    )
    .unwrap();
    let mut worst = [0.0_f64; 2];
    for _ in 0..10_000 {
        flow.advance().unwrap();
        let leg = flow.leg();
        let [x, y, _, _] = leg.q;
        let middle = x - leg.d[0] / 2.0;
        worst[0] = worst[0].max((x * x + y * y - 1.0).abs());
        worst[1] = worst[1].max((leg.d[2] - middle * leg.d[3]).abs() / leg.d[3].abs().max(1e-3));
    }
    println!("mixed {worst:?}");
    assert!(worst[0] < 1e-14 && worst[1] < 1e-13, "{worst:?}");
}

#[test]
fn a_rod_as_a_constraint_is_the_pendulum_in_its_angle() {
    // θ from the lowest point, so that θ″ = −g sin θ; the fourth-order Runge–Kutta method with a small step
    let (mut theta, mut rate) = (0.6_f64.atan2(0.8), 1.0_f64);
    let step = 1e-4;
    for _ in 0..100_000 {
        let f = |[theta, rate]: [f64; 2]| [rate, -9.81 * theta.sin()];
        let at = |k: [f64; 2], part: f64| [theta + part * step * k[0], rate + part * step * k[1]];
        let k1 = f([theta, rate]);
        let k2 = f(at(k1, 0.5));
        let k3 = f(at(k2, 0.5));
        let k4 = f(at(k3, 1.0));
        theta += step / 6.0 * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0]);
        rate += step / 6.0 * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1]);
    }
    let exact = continuous(&ROD, Start::second_order([0.6, -0.8], [0.8, 0.6]), 10.0).q;
    let apart = distance(&exact, &[theta.sin(), -theta.cos()]);
    println!("Taylor flow with the multiplier against the angle: {apart:.1e}");
    assert!(apart < 1e-11, "{apart:e}");
}

#[test]
fn multipliers_are_the_continuous_ones_to_second_order() {
    // the tension of the rod: λ by the form (2x, 2y), so that Q = 2λ (x, y) and 2λ = −(v² − g y)
    let steps = [0.02, 0.01, 0.005];
    let errors = steps.map(|h| {
        let mut flow = Flow::new(&ROD, h, Start::second_order([0.6, -0.8], [0.8, 0.6])).unwrap();
        let nodes = flow.until(2.0).unwrap().nodes;
        let last = nodes.last().unwrap();
        let Node { q, v, .. } = continuous(&ROD, Start::second_order([0.6, -0.8], [0.8, 0.6]), 2.0);
        let exact = -(v[0] * v[0] + v[1] * v[1] - 9.81 * q[1]) / 2.0;
        (flow.multipliers(last)[0] - exact).abs()
    });
    let tension = slope(&steps, &errors);
    // of every kind at once: by the continuous forms and force at the exact point
    let start = ([0.6, -0.8, 0.0, 1.0], [0.8, 0.6, 0.3, 0.5]);
    let exact = {
        let mut flow = TaylorFlow::new(
            &Mixed,
            Start::second_order(start.0, start.1),
            Tolerance::relative(1e-15),
        )
        .unwrap();
        let Node { q, v, a, .. } = flow.to(2.0).unwrap();
        // x″ = 2 x λ, z″ = μ, u″ = −x μ + ν with the forms (2x, 2y, 0, 0), (0, 0, 1, −x), (0, 0, 0, 1)
        let _ = v;
        [a[0] / (2.0 * q[0]), a[2], a[3] + q[0] * a[2]]
    };
    let errors: Vec<[f64; 3]> = steps
        .iter()
        .map(|&h| {
            let mut flow = Flow::new(&Mixed, h, Start::second_order(start.0, start.1)).unwrap();
            let nodes = flow.until(2.0).unwrap().nodes;
            let found = flow.multipliers(nodes.last().unwrap());
            core::array::from_fn(|j| (found[j] - exact[j]).abs())
        })
        .collect();
    println!("tension {tension:.3}, all kinds {errors:?}");
    assert!((tension - 2.0).abs() < 0.1, "{tension}");
    for j in 0..3 {
        let column: Vec<f64> = errors.iter().map(|error| error[j]).collect();
        let order = slope(&steps, &column);
        assert!((order - 2.0).abs() < 0.15, "multiplier {j}: {order}, {column:?}");
    }
}

#[test]
fn a_rod_and_a_lyapunov_constraint_are_the_papers_pendulum() {
    let rod = RodAndWheel::default();
    // θ = 0.5, θ̇ = 0, ψ̇ = 0.5
    let (q, v) = ([0.5_f64.sin(), 0.5_f64.cos(), 0.0], [0.0, 0.0, 0.5]);
    let exact = continuous(
        &InertiaWheelPendulum::default(),
        Start::second_order([0.5, 0.0], [0.0, 0.5]),
        1.0,
    );
    let cartesian = continuous(&rod, Start::second_order(q, v), 1.0);
    let apart = distance(&[cartesian.q[0].atan2(cartesian.q[1]), cartesian.q[2]], &exact.q);
    println!("Taylor flows apart by {apart:.1e}");
    assert!(apart < 1e-10, "{apart:e}");
    let steps = [0.002, 0.001, 0.0005, 0.00025];
    let errors = steps.map(|h| {
        let [x, y, psi] = discrete(&rod, h, Start::second_order(q, v), 1.0).q;
        distance(&[x.atan2(y), psi], &exact.q)
    });
    let order = slope(&steps, &errors);
    println!("errors {errors:?}, order {order:.3}");
    assert!((order - 2.0).abs() < 0.1, "{order}, {errors:?}");
}

#[test]
fn a_start_that_violates_a_constraint_is_refused_or_projected() {
    let refused = |start: Start<2>| Flow::new(&ROD, 0.01, start).unwrap_err();
    let Err(error) = Flow::new(&ROD, 0.01, Start::second_order([0.6, -0.79], [0.8, 0.6])) else {
        panic!("accepted");
    };
    let message = error.to_string();
    assert!(
        matches!(&error, SetupError::Inconsistent { violations }
            if violations[0].constraint == "holonomic constraint" && (violations[0].value + 0.0159).abs() < 1e-12),
        "{error:?}"
    );
    assert!(
        message.contains("holonomic constraint 1 at q0 by -0.0159,"),
        "{message}"
    );
    let error = refused(Start::second_order([0.6, -0.8], [0.8, 0.7]));
    assert!(
        error
            .to_string()
            .contains("time derivative of holonomic constraint 1"),
        "{error}"
    );
    let error = refused(Start::nodes([0.6, -0.8], [0.6, -0.81]));
    assert!(error.to_string().contains("holonomic constraint 1"), "{error}");
    let Err(error) = Flow::new(
        &Nonholonomic,
        0.01,
        Start::paper([0.0, 1.0, 0.0], [1.0, 0.0, 0.5]),
    ) else {
        panic!("accepted");
    };
    assert!(
        error
            .to_string()
            .contains("nonholonomic constraint 1 at (q0, v0) by -0.5,"),
        "{error}"
    );

    // by the mass matrix, here the identity: the nearest point of the circle, and the part of the velocity along it
    let flow = Flow::new(&ROD, 0.01, Start::paper([0.6, -0.8], [2.0, 1.0]).projected()).unwrap();
    let first = flow.clone().next().unwrap().unwrap();
    assert!(
        distance(&first.v, &[2.2 * 0.8, 2.2 * 0.6]) < 1e-14,
        "{:?}",
        first.v
    );
    let flow = Flow::new(&ROD, 0.01, Start::paper([3.0, -4.0], [0.0, 0.0]).projected()).unwrap();
    let first = flow.clone().next().unwrap().unwrap();
    assert!(distance(&first.q, &[0.6, -0.8]) < 1e-15, "{:?}", first.q);
    let Err(error) = Flow::new(&ROD, 0.01, Start::paper([0.0, 0.0], [0.0, 0.0]).projected()) else {
        panic!("projected from the centre");
    };
    assert!(matches!(error, SetupError::Projection { .. }), "{error}");
}

/// The generated Jacobian, which comes from simpler rows than the residual, is the derivative of the residual.
fn jacobian<S: dsocs_core::System<N>, const N: usize>(system: &S, start: Start<N>) {
    let h = 0.05;
    let mut flow = Flow::new(system, h, start).unwrap();
    for _ in 0..5 {
        let leg = flow.leg();
        flow.advance().unwrap();
        let e: [f64; N] = core::array::from_fn(|i| (flow.leg().d[i] - leg.d[i]) * 1.1);
        let node = flow.node();
        let multipliers: Vec<f64> = flow.multipliers(&node).iter().map(|x| 1.1 * x).collect();
        dsocs_tests::tape::same_bits(system, h, &leg, &e, &multipliers).unwrap();
        let z = system.unknown(&e, &multipliers);
        let fixed = |x: &[f64; N]| x.map(|x| Tangent::new(x, 0.0));
        let moving_leg = dsocs_core::Leg {
            t: Tangent::new(leg.t, 0.0),
            q: fixed(&leg.q),
            d: fixed(&leg.d),
        };
        let constants = system.constants(&system.parameters(), h);
        let known = system.known(&constants, &leg);
        let generated = system.linearize(&constants, &known, &z);
        let m = z.as_ref().len();
        for j in 0..m {
            let moving = z.as_ref().iter().enumerate();
            let moving: Vec<_> = moving
                .map(|(k, &from)| Tangent::new(from, f64::from(u8::from(k == j))))
                .collect();
            let rows = Declaration::of(system).rows(Tangent::new(h, 0.0), moving_leg.any(), &moving);
            for (i, (row, moved)) in generated.jacobian.as_ref().iter().zip(&rows).enumerate() {
                let row: &[f64] = row.as_ref();
                let (entry, exact) = (row[j], moved.derivative());
                let size = row.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
                assert!(
                    (entry - exact).abs() <= 1e-12 * size,
                    "entry {i}, {j}: {entry} and {exact}"
                );
            }
        }
    }
}

#[test]
fn jacobians_of_all_kinds() {
    jacobian(&ROD, Start::second_order([0.6, -0.8], [0.8, 0.6]));
    jacobian(
        &Ellipsoid { gravity: 1.0 },
        Start::second_order([1.0, 0.0, 0.0], [0.0, 0.7, 0.4]),
    );
    jacobian(
        &VariableMass,
        Start::second_order([0.6, 0.8, 0.6], [0.8, -0.6, 0.5]),
    );
    jacobian(
        &Nonholonomic,
        Start::second_order([0.6, 0.3, -0.8], [1.0, 1.0, 0.3]),
    );
    jacobian(
        &Nonlinear,
        Start::second_order([0.6, 0.3, -0.8], [0.6, 0.8, 0.78]),
    );
    jacobian(
        &Mixed,
        Start::second_order([0.6, -0.8, 0.0, 1.0], [0.8, 0.6, 0.3, 0.5]),
    );
}

#[test]
fn back_and_forth() {
    // holonomic constraints, and nonholonomic ones on the midpoint of a leg, are as symmetric in time as the maps are
    let mut flow = Flow::new(
        &Mixed,
        0.01,
        Start::second_order([0.6, -0.8, 0.0, 1.0], [0.8, 0.6, 0.3, 0.5]),
    )
    .unwrap();
    let start = flow.leg();
    for _ in 0..1000 {
        flow.advance().unwrap();
    }
    // the first step back
    flow.reverse().unwrap();
    for _ in 1..1000 {
        flow.advance().unwrap();
    }
    let q0: [f64; 4] = core::array::from_fn(|i| start.q[i] - start.d[i]);
    // the reversed flow has its last node at q0 after as many steps as the way there
    let apart = distance(flow.position(), &q0);
    println!("back to within {apart:.1e}");
    assert!(apart < 1e-11, "{apart:e}");
}
