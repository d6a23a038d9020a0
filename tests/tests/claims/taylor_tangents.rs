//! Derivatives of the continuous motion: against differences of whole runs, and as the limit of the discrete
//! motion's derivatives.

#![allow(clippy::float_cmp)] // the same numbers, to the last bit

use dsocs_core::prelude::*;
use dsocs_core::taylor::TaylorTangents;
use dsocs_core::{DerivativeError, NodeTangent, Path, System, Variable};
use dsocs_systems::{CurvedParticle, InertiaWheelPendulum, Wavy};

/// Two rods and a drive: a mass matrix that varies, time, and a function's parameters.
#[dsocs {
    coordinates(a, b);
    lagrangian = dot(a).powi(2) + dot(b).powi(2) / 2 + ratio * dot(a) * dot(b) * (a - b).cos()
        + gravity * (2 * a.cos() + b.cos()) + push * a * (1.7 * t).sin();
    external_forces = (-drag * dot(a) * (1 + dot(b).powi(2)).sqrt(), -drag * dot(b).tanh());
}]
#[derive(Clone)]
struct Rods {
    ratio: f64,
    gravity: f64,
    push: f64,
    drag: f64,
}

const RODS: Rods = Rods {
    ratio: 0.6,
    gravity: 9.81,
    push: 0.7,
    drag: 0.2,
};

/// Three masses whose accelerations are solved for numerically: the equations are not affine in them.
#[dsocs {
    coordinates(x, y, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - k * (x * y).sin() - z.powi(2);
    kinematic = ddot(x) + ddot(x).powi(3) / 10 + k * x + ddot(z) * y / 4;
    variational = [(0, 1, 0), (0, 0, 1)];
}]
#[derive(Clone)]
struct Stiffening {
    k: f64,
}

/// Dry friction.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    external_forces = -friction * dot(x).signum();
}]
#[derive(Clone)]
struct Dry {
    friction: f64,
}

const TOLERANCE: Tolerance = Tolerance::relative(1e-14);

/// The end of a motion.
fn end<S: System<N>, const N: usize>(system: &S, q: [f64; N], v: [f64; N], t: f64) -> [[f64; N]; 3] {
    let mut flow = TaylorFlow::new(system, Start::second_order(q, v), TOLERANCE).unwrap();
    let Node { q, v, a, .. } = flow.to(t).unwrap();
    [q, v, a]
}

/// Compares with central differences.
fn compare_with_differences<S: System<N> + Clone, const N: usize>(
    system: &S,
    q: [f64; N],
    v: [f64; N],
    t: f64,
    names: &[&str],
) {
    let mut variables: Vec<Variable<'_>> = (0..N)
        .flat_map(|i| [Variable::Position(i), Variable::Velocity(i)])
        .collect();
    variables.extend(names.iter().map(|name| Variable::Parameter(name)));
    let mut motion = TaylorTangents::new(system, Start::second_order(q, v), TOLERANCE, &variables).unwrap();
    let tangents = motion.to(t).unwrap();
    assert_eq!(tangents.len(), variables.len());
    assert_eq!(
        [*motion.flow().position(), *motion.flow().velocity()],
        end(system, q, v, t)[..2]
    );
    for (variable, tangent) in variables.iter().zip(&tangents) {
        let moved = |by: f64| {
            let (mut system, mut q, mut v) = (system.clone(), q, v);
            match *variable {
                Variable::Position(i) => q[i] += by,
                Variable::Velocity(i) => v[i] += by,
                Variable::Parameter(name) => {
                    let place = S::PARAMETERS.iter().position(|known| known.name == name).unwrap();
                    *system.parameter_mut(place).unwrap() += by;
                }
                _ => unreachable!(),
            }
            end(&system, q, v, t)
        };
        // differences of fourth order
        let h = 2e-4;
        let [one, two] = [1.0, 2.0].map(|k| (moved(k * h), moved(-k * h)));
        let NodeTangent { q, v, a } = *tangent;
        for (place, exact) in [q, v, a].into_iter().enumerate() {
            for i in 0..N {
                let quotient = |(up, down): &([[f64; N]; 3], [[f64; N]; 3]), k: f64| {
                    (up[place][i] - down[place][i]) / (2.0 * k * h)
                };
                let difference = (4.0 * quotient(&one, 1.0) - quotient(&two, 2.0)) / 3.0;
                let size = tangents
                    .iter()
                    .flat_map(|x| [x.q, x.v, x.a][place])
                    .fold(1.0, |size: f64, x| size.max(x.abs()));
                assert!(
                    (difference - exact[i]).abs() < 1e-8 * size,
                    "{variable:?} {place} {i}: {difference} {}",
                    exact[i]
                );
            }
        }
    }
}

#[test]
fn tangents_are_those_of_central_differences() {
    compare_with_differences(
        &RODS,
        [0.4, -0.3],
        [0.5, 1.0],
        2.0,
        &["ratio", "gravity", "push", "drag"],
    );
    compare_with_differences(&CurvedParticle::default(), [0.1, 0.2], [1.0, 0.7], 3.0, &["mass"]);
    compare_with_differences(
        &InertiaWheelPendulum::default(),
        [0.5, 0.0],
        [0.0, 0.5],
        1.5,
        &["i", "m", "rho", "chi"],
    );
    compare_with_differences(
        &Stiffening { k: 1.3 },
        [0.5, 0.8, -0.2],
        [0.1, -0.4, 0.3],
        1.5,
        &["k"],
    );
}

/// The derivatives of the discrete motion converge to them with the square of the step.
#[test]
fn tangents_are_the_limit_of_discrete_ones() {
    let (q, v, t) = ([0.4, -0.3], [0.5, 1.0], 1.0);
    let variables = [
        Variable::Position(1),
        Variable::Velocity(0),
        Variable::Parameter("gravity"),
        Variable::Parameter("drag"),
        Variable::Parameter("push"),
    ];
    let start = Start::second_order(q, v);
    let mut motion = TaylorTangents::new(&RODS, start, TOLERANCE, &variables).unwrap();
    let limit = motion.to(t).unwrap();
    let far = |h: f64| {
        let path = Path::new(&RODS, h, start, t).unwrap();
        let tangents = path.tangents(&variables).unwrap();
        let each = tangents.iter().zip(&limit);
        each.flat_map(|(x, y)| [x.q[0] - y.q[0], x.q[1] - y.q[1]])
            .fold(0.0, |far: f64, x| far.max(x.abs()))
    };
    let distances = [0.02, 0.01, 0.005].map(far);
    for pair in distances.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((3.8..4.2).contains(&ratio), "{distances:?}");
    }
    assert!(distances[2] < 1e-3, "{distances:?}");
}

#[test]
fn along_the_motion_and_on_from_there() {
    let start = Start::second_order([0.4, -0.3], [0.5, 1.0]);
    let variables = [Variable::Parameter("gravity")];
    let mut motion = TaylorTangents::new(&RODS, start, TOLERANCE, &variables).unwrap();
    assert_eq!(motion.tangents()[0].q, [0.0; 2]);
    assert!(motion.tangents()[0].a != [0.0; 2]);
    let mut times = Vec::new();
    motion
        .along(1.0, &mut |point, tangents| {
            times.push((point.t, tangents[0].q[0]));
        })
        .unwrap();
    assert!(times.len() > 2 && times.last().unwrap().0 == 1.0);
    let on = motion.to(2.0).unwrap();
    let mut whole = TaylorTangents::new(&RODS, start, TOLERANCE, &variables).unwrap();
    let whole = whole.to(2.0).unwrap();
    assert!((on[0].q[0] - whole[0].q[0]).abs() < 1e-11);
    assert!(motion.to(1.0).is_err());
}

/// A motion that meets a jump, a start by nodes, unknown variables and a user's function have no tangents:
/// each error gives its reason.
#[test]
fn what_has_no_derivative_says_why() {
    let start = Start::second_order([1.0], [0.0]);
    let dry = Dry { friction: 0.1 };
    let refused = |error: DerivativeError, expected: &str| {
        assert!(error.to_string().contains(expected), "{error}");
    };
    let variables = [Variable::Parameter("friction")];
    let mut motion =
        TaylorTangents::new(&dry, Start::second_order([1.0], [0.5]), TOLERANCE, &variables).unwrap();
    refused(motion.to(3.0).unwrap_err(), "a jump or a corner");
    let new = |start, variable| TaylorTangents::new(&dry, start, TOLERANCE, &[variable]).unwrap_err();
    refused(
        new(Start::nodes([1.0], [1.1]), Variable::Position(0)),
        "position and velocity",
    );
    refused(new(start, Variable::Position(1)), "no coordinate 1");
    refused(
        new(start, Variable::Parameter("frictoin")),
        "expected one of friction",
    );
    refused(new(start, Variable::SecondNode(0)), "no second node");
    let field = CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    };
    let start = Start::second_order([0.0, 0.0], [1.0, 1.0]);
    let error = TaylorTangents::new(&field, start, TOLERANCE, &[Variable::Position(0)]).unwrap_err();
    refused(error, "a function of yours");
}
