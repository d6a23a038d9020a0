//! The geometry of the discrete flow: Legendre transforms and forms agree with the declaration, the tangent
//! map is the derivative of the step, the inverse leads back, and the paper's laws hold to rounding.

#![allow(clippy::float_cmp)] // exact values are compared exactly

use dsocs_core::geometry::{
    DiscreteFlow, Displacement, Evolution, FlowTheorem, GeometryError, Triple, asymmetry, discrete_form,
    legendre_minus, legendre_plus, momentum_equation, momentum_map, momentum_minus, momentum_plus,
    pair_displacements, rows_at_given_nodes, theta_minus, theta_plus,
};
use dsocs_core::{AnyFlow, AnyLeg, AnyStart, Leg, Real, Regularity, SetupError, Start, Stepper, dsocs};
use dsocs_systems::{
    Curvature, CurvedParticle, GravityTurn, InertiaWheelPendulum, MagneticParticle, PlanarChain2,
    SphericalPendulum, Wavy,
};
use dsocs_tests::declared;
use dsocs_tests::text::{Flow, System, read};

/// The triples of a motion's first steps.
fn triples<S: System<N>, const N: usize>(system: &S, h: f64, start: Start<N>, steps: usize) -> Vec<Triple> {
    let map = DiscreteFlow::new(system.kernel(), h).unwrap();
    let mut flow = Flow::new(system, h, start).unwrap();
    (0..steps)
        .map(|_| {
            let leg = flow.leg();
            flow.advance().unwrap();
            let e: [f64; N] = core::array::from_fn(|i| flow.leg().d[i] - leg.d[i]);
            map.forward_near(leg.any(), &e).unwrap()
        })
        .collect()
}

/// The largest defect of `F*Ω = Ω + dξ`, and the smallest and the largest `dξ`, along a motion.
fn law<S: System<N>, const N: usize>(system: &S, h: f64, start: Start<N>, steps: usize) -> [f64; 3] {
    let map = DiscreteFlow::new(system.kernel(), h).unwrap();
    let mut all = [0.0_f64, f64::INFINITY, 0.0];
    for triple in triples(system, h, start, steps) {
        let law = Evolution::of(&map, &triple).unwrap();
        assert!(law.defect().is_finite() && law.change().is_finite());
        all = [
            all[0].max(law.defect()),
            all[1].min(law.change()),
            all[2].max(law.change()),
        ];
    }
    all
}

#[test]
fn the_law_holds_to_rounding_on_the_papers_examples() {
    for h in [0.1, 0.01, 0.001] {
        let particle = CurvedParticle::default();
        let [defect, least, _] = law(&particle, h, Start::second_order([0.0; 2], [1.0; 2]), 300);
        println!("particle, h = {h}: defect {defect:.1e}, dξ at least {least:.1e}");
        assert!(defect < 1e-15 && least > 0.1 * h, "{defect:e} {least:e}");
        let pendulum = InertiaWheelPendulum::default();
        let [defect, least, most] = law(&pendulum, h, Start::second_order([0.5, 0.0], [0.0, 0.5]), 300);
        println!("pendulum, h = {h}: defect {defect:.1e}, dξ {least:.1e} to {most:.1e}");
        assert!(defect < 1e-14 && most > 1e-3 * h, "{defect:e} {most:e}");
    }
}

#[test]
fn without_constraints_the_flow_is_symplectic() {
    for h in [0.05, 0.005] {
        let start = Start::second_order([2.0, 1.0], [0.0, 1.0]);
        let [defect, _, change] = law(&PlanarChain2::default(), h, start, 200);
        println!("double pendulum, h = {h}: defect {defect:.1e}, dξ {change:.1e}");
        assert!(defect < 1e-14 && change < 1e-14, "{defect:e} {change:e}");
        let start = Start::second_order([1.0, 0.0], [0.3, 0.8]);
        let [defect, _, change] = law(&MagneticParticle::default(), h, start, 200);
        println!("magnetic particle, h = {h}: defect {defect:.1e}, dξ {change:.1e}");
        assert!(defect < 1e-14 && change < 1e-14, "{defect:e} {change:e}");
    }
}

/// The law holds for any tangent map, since it stands on both sides. So the map is compared with differences
/// of the step.
fn tangent_is_the_derivative<S: System<N>, const N: usize>(
    system: &S,
    h: f64,
    leg: Leg<f64, N>,
    shift: f64,
    bar: f64,
) {
    let map = DiscreteFlow::new(system.kernel(), h).unwrap();
    let triple = map.forward(leg.any()).unwrap();
    let tangent = map.tangent(&triple).unwrap();
    for k in 0..2 * N {
        let unit = Displacement::unit(N, k);
        let exact = tangent.apply(&unit);
        assert_eq!(exact.first, unit.second);
        let mut quotient = [0.0; N];
        for (times, weight) in [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)] {
            for sign in [1.0, -1.0] {
                let by = sign * times * shift;
                let moved: Leg<f64, N> = Leg {
                    t: 0.0,
                    q: core::array::from_fn(|i| leg.q[i] + by * unit.second[i]),
                    d: core::array::from_fn(|i| leg.d[i] + by * (unit.second[i] - unit.first[i])),
                };
                let found = map.forward_near(moved.any(), &triple.e).unwrap().last(h).q;
                for i in 0..N {
                    quotient[i] += sign * weight * (found[i] - triple.last(h).q[i]) / shift;
                }
            }
        }
        for i in 0..N {
            let apart = (quotient[i] - exact.second[i]).abs();
            assert!(
                apart < bar * (1.0 + exact.second[i].abs()),
                "{k} {i}: {quotient:?} {exact:?}"
            );
        }
    }
}

#[test]
fn the_tangent_map_is_the_derivative_of_the_step() {
    let leg = Leg {
        t: 0.0,
        q: [0.3, -0.2],
        d: [0.08, 0.05],
    };
    tangent_is_the_derivative(&CurvedParticle::default(), 0.1, leg, 1e-3, 1e-11);
    tangent_is_the_derivative(&GravityTurn::default(), 0.1, leg, 1e-3, 1e-11);
    tangent_is_the_derivative(&PlanarChain2::default(), 0.05, leg, 1e-3, 1e-10);
    tangent_is_the_derivative(&MagneticParticle::default(), 0.1, leg, 1e-3, 1e-11);
    // a function of the user's, which is differentiated by differences
    let wavy = CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    };
    tangent_is_the_derivative(&wavy, 0.1, leg, 1e-3, 1e-11);
    let turning = Leg {
        t: 0.0,
        q: [0.49, 0.02],
        d: [-0.002, 0.01],
    };
    tangent_is_the_derivative(&InertiaWheelPendulum::default(), 0.1, turning, 1e-6, 1e-8);
}

declared! {
    /// A curvature as `Wavy`, spelled out in the declaration.
    struct Plain;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - (1 + x.sin() * y.cos() / 2);
    variational = [(dot(x), dot(y))];
}

/// Functions of users' are differentiated by differences of eighth order; those leave a few digits less than rounding.
#[test]
fn functions_of_the_users_cost_two_digits_at_most() {
    let wavy = CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    };
    let leg = Leg {
        t: 0.0,
        q: [0.3, -0.2],
        d: [0.08, 0.05],
    };
    let at = |tangent: Result<_, GeometryError>| -> dsocs_core::geometry::TangentMap { tangent.unwrap() };
    let (opaque, plain) = (
        DiscreteFlow::new(&wavy, 0.1).unwrap(),
        DiscreteFlow::new(read(&Plain), 0.1).unwrap(),
    );
    let opaque = at(opaque.tangent(&opaque.forward(leg.any()).unwrap()));
    let plain = at(plain.tangent(&plain.forward(leg.any()).unwrap()));
    let both = opaque
        .by_second
        .iter()
        .flatten()
        .zip(plain.by_second.iter().flatten());
    let apart = both.fold(0.0_f64, |apart, (x, y)| apart.max((x - y).abs()));
    println!("a curvature as a function, and spelled out: {apart:.1e}");
    assert!(apart < 1e-14, "{apart:e}");
    let value: f64 = wavy.curvature.at(0.3, -0.2);
    assert!((value - (1.0 + 0.3_f64.sin() * 0.2_f64.cos() / 2.0)).abs() < 1e-15);
}

/// A Lagrangian with a function of the user's, and the same spelled out.
fn hill<R: Real>(x: R, y: R) -> R {
    (x * y).sin() + x * x
}

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - hill(x, y);
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
}]
struct Opaque;

declared! {
    struct Spelled;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - ((x * y).sin() + x * x);
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
}

/// `D₁D₂L_d = −1/h² − H/4` with the potential's second derivatives `H` at the midpoint. Differences of differences of a user's
/// function, over parts of a leg, leave eleven digits of it.
#[test]
fn the_form_is_the_mixed_derivative() {
    let (h, leg) = (
        0.5,
        Leg {
            t: 0.0,
            q: [0.7, 0.4],
            d: [0.2, -0.1],
        },
    );
    let (x, y) = (0.6_f64, 0.45_f64);
    let (sin, cos) = (x * y).sin_cos();
    let hessian = [
        [-y * y * sin + 2.0, cos - x * y * sin],
        [cos - x * y * sin, -x * x * sin],
    ];
    for (form, bar) in [
        (discrete_form(read(&Spelled), h, leg.any()), 1e-15),
        (discrete_form(&Opaque, h, leg.any()), 1e-11),
    ] {
        for (i, row) in hessian.iter().enumerate() {
            for (j, second) in row.iter().enumerate() {
                let wanted = f64::from(u8::from(i == j)) / (h * h) + second / 4.0;
                let found = form.blocks[0][1][i][j];
                assert!((found - wanted).abs() < bar * 8.0, "{i} {j}: {found} {wanted}");
                assert_eq!(form.blocks[1][0][j][i], -found);
                assert_eq!([form.blocks[0][0][i][j], form.blocks[1][1][i][j]], [0.0; 2]);
            }
        }
        let (u, w) = (Displacement::unit(2, 0), Displacement::unit(2, 3));
        assert_eq!(form.of(&u, &w), form.blocks[0][1][0][1]);
        assert_eq!(form.of(&w, &u), -form.of(&u, &w));
    }
}

#[test]
fn legendre_transforms_are_momenta() {
    let particle = MagneticParticle::default();
    let (h, leg) = (
        0.1,
        Leg {
            t: 0.0,
            q: [1.0, 0.2],
            d: [0.03, 0.08],
        },
    );
    let triple = DiscreteFlow::new(&particle, h)
        .unwrap()
        .forward(leg.any())
        .unwrap();
    // without a constraint the momentum is the same on both sides of a node: F⁺L_d(q0, q1) = F⁻L_d(q1, q2)
    let (plus, minus) = (
        momentum_plus(&particle, h, leg.any()),
        momentum_minus(&particle, h, triple.last(h).any()),
    );
    for i in 0..2 {
        assert!((plus[i] - minus[i]).abs() < 1e-14, "{plus:?} {minus:?}");
    }
    // by the forms, and in units of L
    let unit = Displacement::unit(2, 3);
    assert_eq!(
        theta_plus(&particle, h, leg.any(), &unit),
        legendre_plus(&particle, h, leg.any())[1]
    );
    assert_eq!(
        theta_minus(&particle, h, leg.any(), &Displacement::unit(2, 0)),
        legendre_minus(&particle, h, leg.any())[0]
    );
    assert_eq!(theta_minus(&particle, h, leg.any(), &unit), 0.0);
    // h F⁺L_d is m v + c A at the midpoint plus half a step of the force: with the midpoint map p = ∂L/∂v + h/2 ∂L/∂q
    let (q, v) = ([1.0 - 0.015, 0.2 - 0.04], leg.d.map(|d| d / h));
    let at = |[x, y]: [f64; 2]| 0.5 * (1.0 + 0.125 * (x * x + y * y));
    let turning = q[0] * v[1] - q[1] * v[0];
    let slope = 0.5 * 0.25;
    let by_x = slope * q[0] * turning + at(q) * v[1];
    let wanted = v[0] - at(q) * q[1] + h / 2.0 * by_x;
    assert!((plus[0] - wanted).abs() < 1e-14, "{} {wanted}", plus[0]);
}

declared! {
    /// The kinematic map of one side alone: the step with `−h` is another map.
    struct OneSided;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x * y;
    let squared = dot(x).powi(2) + dot(y).powi(2) + 0.5;
    kinematic = dot(x) * ddot(y) - ddot(x) * dot(y) - squared.powf(1.5) * x.cos();
    variational = [(dot(x) + y, dot(y))];
    phi_kinematic = |q0, q1, q2| (q2, (q2 - q1) / h, (q2 - 2 * q1 + q0) / h.powi(2));
}

/// The largest difference of `F⁻¹∘F` and `F∘F⁻¹` from the identity, relative to the leg.
fn inverted<S: System<N>, const N: usize>(system: &S, h: f64, leg: Leg<f64, N>, e: [f64; N]) -> f64 {
    let map = DiscreteFlow::new(system.kernel(), h).unwrap();
    let triple = map.forward_near(leg.any(), &e).unwrap();
    let back = map.backward(triple.last(h).any()).unwrap();
    let again = map.forward_near(back.leg.any(), &back.e).unwrap();
    let largest = |x: &[f64]| x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let apart = |x: &Triple| -> f64 { largest(&core::array::from_fn::<_, N, _>(|i| x.e[i] - triple.e[i])) };
    apart(&back).max(apart(&again)) / largest(&leg.d)
}

#[test]
fn the_inverse_leads_back() {
    let leg = Leg {
        t: 0.0,
        q: [0.3, -0.2],
        d: [0.08, 0.05],
    };
    // there are two solutions; this is the one nearer to a straight line
    let one_sided = [-0.012, 0.01];
    for (name, figure) in [
        (
            "particle",
            inverted(&CurvedParticle::default(), 0.1, leg, [0.0; 2]),
        ),
        (
            "gravity turn",
            inverted(&GravityTurn::default(), 0.1, leg, [0.0; 2]),
        ),
        (
            "double pendulum",
            inverted(&PlanarChain2::default(), 0.05, leg, [0.0; 2]),
        ),
        (
            "pendulum",
            inverted(&InertiaWheelPendulum::default(), 0.1, leg, [0.0; 2]),
        ),
        ("one-sided map", inverted(&OneSided, 0.1, leg, one_sided)),
    ] {
        println!("{name}: {figure:.1e}");
        assert!(figure < 1e-14, "{name}: {figure:e}");
    }
    let map = DiscreteFlow::new(read(&OneSided), 0.1).unwrap();
    let triple = map.forward_near(leg.any(), &one_sided).unwrap();
    // the step with −h is not its inverse
    assert!(map.irreversibility(&triple).unwrap() > 1e-3);
    let map = DiscreteFlow::new(read(&Spelled), 0.1).unwrap();
    assert!(map.irreversibility(&map.forward(leg.any()).unwrap()).unwrap() < 1e-15);
}

/// A triple that does not solve the step has no tangent map, and a leg at rest has neither a step forward nor
/// one back: each gives its own error.
#[test]
fn what_is_no_trajectory_is_refused() {
    let particle = CurvedParticle::default();
    let map = DiscreteFlow::new(&particle, 0.1).unwrap();
    let leg = Leg {
        t: 0.0,
        q: [0.3, -0.2],
        d: [0.08, 0.05],
    };
    let triple = map.forward(leg.any()).unwrap();
    let e: Vec<f64> = triple.e.iter().map(|e| 1.1 * e).collect();
    let error = map.tangent(&Triple::new(leg.any(), &e)).unwrap_err();
    assert!(matches!(error, GeometryError::NoTrajectory { .. }), "{error}");
    let rest = Leg {
        t: 0.0,
        q: [0.0; 2],
        d: [0.0; 2],
    };
    assert!(matches!(map.forward(rest.any()), Err(GeometryError::Step { .. })));
    assert!(matches!(
        map.backward(rest.any()),
        Err(GeometryError::Inverse { .. })
    ));
    assert!(matches!(
        DiscreteFlow::new(&particle, 0.0),
        Err(GeometryError::Setup(_))
    ));
}

#[test]
fn vectors_of_another_number_of_coordinates_are_told() {
    let particle = CurvedParticle::default();
    let map = DiscreteFlow::new(&particle, 0.1).unwrap();
    for count in [0, 1, 3] {
        let (q, d) = (&vec![0.3; count], &vec![0.08; count]);
        let leg = AnyLeg { t: 0.0, q, d };
        let is_length_error = |error: GeometryError| matches!(error, GeometryError::Length { found, coordinates: 2 } if found == count);
        assert!(
            is_length_error(map.forward(leg).unwrap_err()) && is_length_error(map.backward(leg).unwrap_err())
        );
        assert!(is_length_error(map.tangent(&Triple::new(leg, d)).unwrap_err()));
        assert!(!FlowTheorem::at(&particle, 0.1, leg, d).grants_flow());
        assert!(!Regularity::of(&particle, 0.1, leg, d).grants_flow());
        assert!(rows_at_given_nodes(&particle, 0.0, 0.1, [q, q, q]).is_empty());
        let start = AnyStart::second_order(q, d);
        let refused = AnyFlow::new(&particle, 0.1, &start).map(|_| ());
        assert!(matches!(
            refused,
            Err(SetupError::StartLength { coordinates: 2, .. })
        ));
    }
}

#[test]
fn momenta_are_conserved_or_change_by_the_forces_work() {
    // about the vertical
    let spherical = SphericalPendulum::default();
    let map = DiscreteFlow::new(&spherical, 0.02).unwrap();
    let about: &dyn Fn(&[f64]) -> Vec<f64> = &|_| vec![0.0, 1.0];
    let all = triples(&spherical, 0.02, Start::second_order([1.0, 0.0], [0.0, 2.0]), 500);
    let first = momentum_map(&map, all[0].leg.any(), about);
    for triple in &all {
        assert!((momentum_map(&map, triple.leg.any(), about) - first).abs() < 1e-13 * first.abs());
    }
    // the particle: translations, which the constraint's force breaks
    let particle = CurvedParticle::default();
    let map = DiscreteFlow::new(&particle, 0.1).unwrap();
    let along: &dyn Fn(&[f64]) -> Vec<f64> = &|_| vec![1.0, 0.0];
    let all = triples(&particle, 0.1, Start::second_order([0.0; 2], [1.0; 2]), 100);
    let mut changed = 0.0_f64;
    for triple in &all {
        let [missed, terms] = momentum_equation(&map, triple, along);
        assert!(missed.abs() < 1e-15 * terms, "{missed:e} {terms:e}");
        changed = changed.max(
            (momentum_map(&map, triple.last(0.1).any(), along) - momentum_map(&map, triple.leg.any(), along))
                .abs(),
        );
        assert_eq!(asymmetry(&map, triple.leg.any(), along), 0.0);
    }
    assert!(changed > 0.1);
    // gravity is not invariant: L_d changes by −m g a unit of height
    let turn = GravityTurn::default();
    let map = DiscreteFlow::new(&turn, 0.1).unwrap();
    let leg = Leg {
        t: 0.0,
        q: [0.3, -0.2],
        d: [0.08, 0.05],
    };
    let up = asymmetry(&map, leg.any(), &|_| vec![0.0, 1.0]);
    let p = 0.05 / 0.01;
    assert!((up.abs() - 1.0 / (2.0 * p + 1.0)).abs() < 1e-14, "{up}");
}

#[test]
fn the_theorem_is_granted_along_the_papers_motions_and_not_at_rest() {
    let particle = CurvedParticle::default();
    let pendulum = InertiaWheelPendulum::default();
    for triple in triples(&particle, 0.1, Start::second_order([0.0; 2], [1.0; 2]), 100) {
        let theorem = FlowTheorem::at(&particle, 0.1, triple.leg.any(), &triple.e);
        assert!(theorem.grants_flow() && theorem.margin > 1e-6, "{theorem:?}");
    }
    for triple in triples(&pendulum, 0.1, Start::second_order([0.5, 0.0], [0.0, 0.5]), 100) {
        let theorem = FlowTheorem::at(&pendulum, 0.1, triple.leg.any(), &triple.e);
        assert!(theorem.grants_flow(), "{theorem:?}");
    }
    let rest = Leg {
        t: 0.0,
        q: [0.0; 2],
        d: [0.0; 2],
    };
    let theorem = FlowTheorem::at(&particle, 0.1, rest.any(), &[0.0; 2]);
    assert!(
        !theorem.has_constant_rank() && !theorem.grants_flow(),
        "{theorem:?}"
    );
    // a leg turned back: the velocity is zero, and the virtual displacement with it
    let leg = Leg {
        t: 0.0,
        q: [0.0; 2],
        d: [0.1, 0.0],
    };
    let theorem = FlowTheorem::at(&particle, 0.1, leg.any(), &[-0.2, 0.0]);
    assert!(!theorem.grants_flow(), "{theorem:?}");
}

declared! {
    /// A pendulum on a rod, in Cartesian coordinates.
    struct Rod;
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
    holonomic = (x.powi(2) + y.powi(2) - 1) / 2;
}

declared! {
    /// The particle of Bates, Śniatycki and others, `ż = y ẋ`.
    struct Nonholonomic;
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - y.powi(2) / 2;
    nonholonomic = dot(z) - y * dot(x);
}

/// The largest `dξ` along the pairs that are allowed, the largest defect of the law, and how many directions are allowed.
fn allowed<S: System<N>, const N: usize>(system: &S, h: f64, start: Start<N>) -> ([f64; 2], usize) {
    let map = DiscreteFlow::new(system.kernel(), h).unwrap();
    let (mut figures, mut count) = ([0.0_f64; 2], 0);
    for triple in triples(system, h, start, 60) {
        let directions = pair_displacements(system.kernel(), h, triple.leg.any());
        let law = Evolution::of(&map, &triple).unwrap();
        figures = [
            figures[0].max(law.change_on(&directions)),
            figures[1].max(law.defect()),
        ];
        count = directions.len();
        let back = map.backward(triple.last(h).any()).unwrap();
        for i in 0..N {
            assert!(
                (back.leg.d[i] - triple.leg.d[i]).abs() < 1e-14,
                "{back:?} {triple:?}"
            );
        }
        // F maps C_d into itself
        let after = pair_displacements(system.kernel(), h, triple.last(h).any());
        for displacement in &directions {
            let image = law.tangent.apply(displacement);
            let product = |x: &Displacement, y: &Displacement| -> f64 {
                let first = x.first.iter().zip(&y.first).map(|(x, y)| x * y).sum::<f64>();
                first + x.second.iter().zip(&y.second).map(|(x, y)| x * y).sum::<f64>()
            };
            let inside: f64 = after.iter().map(|basis| product(basis, &image).powi(2)).sum();
            let whole = product(&image, &image);
            assert!((inside - whole).abs() < 1e-10 * whole, "{inside} {whole}");
        }
    }
    (figures, count)
}

#[test]
fn holonomic_flows_are_symplectic_on_their_submanifold_and_nonholonomic_ones_are_not() {
    for h in [0.05, 0.01] {
        let start = Start::second_order([0.6, -0.8], [0.8, 0.6]);
        let ([change, defect], count) = allowed(&Rod, h, start);
        println!("rod, h = {h}: dξ {change:.1e}, defect {defect:.1e}, {count} directions");
        assert_eq!(count, 2, "pairs on the circle");
        assert!(change < 1e-12 && defect < 1e-13, "{change:e} {defect:e}");
        let start = Start::second_order([0.0, 1.0, 0.0], [1.0, 0.5, 1.0]);
        let ([change, defect], count) = allowed(&Nonholonomic, h, start);
        println!("ż = y ẋ, h = {h}: dξ {change:.1e}, defect {defect:.1e}, {count} directions");
        assert_eq!(count, 5, "pairs that satisfy the constraint");
        assert!(change > 1e-3 * h && defect < 1e-13, "{change:e} {defect:e}");
    }
}
