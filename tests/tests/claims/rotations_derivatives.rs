//! Derivatives of runs with rotations, against differences of runs with other starts, attitudes turned a
//! little among them, and other parameters.

use dsocs_core::taylor::TaylorTangents;
use dsocs_core::text::Text;
use dsocs_core::{
    AnyPath, AnyPoint, AnyStart, DerivativeError, Dual, Kernel, Path, Real as _, Start, Stepper as _,
    TaylorFlow, Tolerance, Variable, dsocs,
};
use dsocs_tests::vectors::{composed, moved, quaternion, unit};

const STEP: f64 = 0.05;
const UNTIL: f64 = 1.5;

/// A heavy top whose arm is off its axes of inertia, with a drag.
const TOP: &str = "parameters { inertia = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]], arm = [0.2, 0.1, 1.0], mass = 0.7, drag = 0.1 }
    coordinates(r: rotation);
    let w = r.angular_velocity();
    lagrangian = w.inner(inertia * w) / 2 - mass * (r * arm)[2];
    external_forces = -drag * w;";

/// A cart with a body on it, whose mass is off the joint, and a spring between a coordinate and the attitude.
const CART: &str = "parameters { mass = 0.7, arm = [0.2, 0.1, 1.0], stiffness = 3.0, rest = 0.2 }
    coordinates(x, r: rotation, y);
    let w = r.angular_velocity();
    let v = [dot(x), 0, 0] + r * w.cross(arm);
    lagrangian = w.norm_squared() + mass * v.norm_squared() / 2 + dot(x).powi(2) / 2 + dot(y).powi(2) / 2 - mass * (r * arm)[2]
        - stiffness * (y - x - rest + (r * arm)[1]).powi(2) / 2;";

/// Suslov's problem, with a constraint on the velocities of the body.
const SUSLOV: &str = "parameters { gravity = 1.3, slope = 0.4 }
    coordinates(r: rotation);
    let w = r.angular_velocity();
    lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + 0.5 * w[2].powi(2) - gravity * (r * [0.2, 0.1, 1])[2];
    nonholonomic = w[2] - slope * w[0];";

/// A body with a held point.
const HELD: &str = "parameters { arm = [0.2, 0.1, 1.0], mass = 0.7 }
    coordinates(r: rotation, x: [3]);
    let w = r.angular_velocity();
    lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + 0.5 * w[2].powi(2) + mass * dot(x).norm_squared() / 2 - mass * x[2];
    holonomic = x - r * arm;";

/// A derivative of a position, for the rotation as a turn in the frame of its body.
fn turned(rotation: usize, q: &[f64], change: &[f64]) -> Vec<f64> {
    let [w, x, y, z] = quaternion(q, rotation);
    let [_, turn @ ..] = composed([w, -x, -y, -z], quaternion(change, rotation)).map(|x| 2.0 * x);
    let mut turned = change.to_vec();
    turned[rotation] = 0.0;
    turned[rotation + 1..rotation + 4].copy_from_slice(&turn);
    turned
}

/// The derivative by the central difference of order 4, from values at -2, -1, 1 and 2 shifts.
fn quotient(at: &dyn Fn(f64) -> Vec<f64>, shift: f64) -> Vec<f64> {
    let [far, near, back, behind] = [2.0, 1.0, -1.0, -2.0].map(|k| at(k * shift));
    let place = |i: usize| (8.0 * (near[i] - back[i]) - (far[i] - behind[i])) / (12.0 * shift);
    (0..near.len()).map(place).collect()
}

/// The cost of a node: a body vector's height, extended to quaternions of any norm, and terms of the other
/// coordinates, `v` and `a`.
fn cost(rotation: usize, node: AnyPoint<'_, Dual<f64>>) -> Dual<f64> {
    let [w, x, y, z] = core::array::from_fn(|k| node.q[rotation + k]);
    let height = (w * w - x * x - y * y + z * z) * 0.4 + (y * z + w * x) * 1.2 + (x * z - w * y) * 0.3;
    let rest: Dual<f64> = (node.q.iter().enumerate())
        .filter(|(i, _)| !(rotation..rotation + 4).contains(i))
        .fold(Dual::new(0.0, 0.0), |sum, (_, q)| sum + q.sin());
    let spin = node.v[rotation + 1] * node.v[rotation + 3] + node.v[rotation + 2] * 0.3;
    height + rest + spin + node.a[rotation + 2] * 0.01
}

/// The cost of a node, and its derivative along rates of position, velocity and acceleration.
fn cost_with(rotation: usize, node: AnyPoint<'_, f64>, rates: [&[f64]; 3]) -> Dual<f64> {
    let dual = |numbers: &[f64], rates: &[f64]| -> Vec<Dual<f64>> {
        let pairs = numbers.iter().zip(rates);
        pairs.map(|(number, rate)| Dual::new(*number, *rate)).collect()
    };
    let [q, v, a] = [(node.q, rates[0]), (node.v, rates[1]), (node.a, rates[2])]
        .map(|(numbers, rates)| dual(numbers, rates));
    let point = AnyPoint {
        t: Dual::new(node.t, 0.0),
        q: &q,
        v: &v,
        a: &a,
    };
    cost(rotation, point)
}

/// The cost of a node.
fn cost_at(rotation: usize, node: AnyPoint<'_, f64>) -> f64 {
    let still = vec![0.0; node.q.len()];
    cost_with(rotation, node, [&still; 3]).re
}

/// The derivative of a node's cost along a tangent `[turn, v, a]` of position (for a rotation a turn in the
/// body frame), velocity and acceleration.
fn cost_along(rotation: usize, node: AnyPoint<'_, f64>, [turn, v, a]: [&[f64]; 3]) -> f64 {
    let mut q = turn.to_vec();
    let rate = composed(quaternion(node.q, rotation), quaternion(turn, rotation)).map(|x| 0.5 * x);
    q[rotation..rotation + 4].copy_from_slice(&rate);
    cost_with(rotation, node, [&q, v, a]).eps
}

/// A start from position and velocity, or from two nodes.
type Rule<'r> = &'r dyn Fn(&[f64], &[f64]) -> AnyStart;

/// A system with a state: its text, the index of its quaternion, position and velocity.
struct Case<'c> {
    text: &'c str,
    rotation: usize,
    q: &'c [f64],
    v: &'c [f64],
}

/// Checks all derivatives of the end by start and parameters, forward and backward, against differences,
/// except along directions that leave constraints.
fn check(case: &Case<'_>, rule: Rule<'_>, nodes: bool, apart: &dyn Fn(usize) -> bool) {
    let Case { text, rotation, q, v } = *case;
    let text = Text::parse("system", text).unwrap_or_else(|error| panic!("{error}"));
    let kernel: &dyn Kernel = &text.system;
    let (n, names) = (q.len(), &kernel.shape().parameters);
    let path_of = |by: usize, change: f64| {
        let (mut system, mut q, mut v) = (text.system.clone(), q.to_vec(), v.to_vec());
        match by {
            by if by < n => q = moved(rotation, &q, by, change),
            // of two nodes, the second one
            by if by < 2 * n && nodes => v = moved(rotation, &v, by - n, change),
            by if by < 2 * n => v[by - n] += change,
            by => *system.parameter_mut(by - 2 * n).unwrap() += change,
        }
        (system, rule(&q, &v))
    };
    let with = |by: usize, change: f64, use_path: &mut dyn FnMut(&AnyPath<'_>)| {
        let (system, start) = path_of(by, change);
        use_path(&AnyPath::new(&system, STEP, &start, UNTIL).unwrap_or_else(|error| panic!("{error}")));
    };
    let end = |by: usize, change: f64| {
        let mut numbers = Vec::new();
        with(by, change, &mut |path| {
            numbers = [path.end().q, path.end().v, path.end().a].concat();
        });
        numbers
    };
    let start = rule(q, v);
    let path = AnyPath::new(&text.system, STEP, &start, UNTIL).unwrap();
    // and with only a few steps in memory at a time
    let short = AnyPath::within(&text.system, STEP, &start, UNTIL, 2000).unwrap();
    let gradient = path.gradient(&mut |_, node| cost(rotation, node)).unwrap();
    assert_eq!(
        short.gradient(&mut |_, node| cost(rotation, node)).unwrap(),
        gradient
    );
    let second = if nodes { &gradient.q1 } else { &gradient.v0 };
    let backward = [&gradient.q0[..], second, &gradient.parameters].concat();
    let cost_of = |by: usize, change: f64| {
        let mut sum = 0.0;
        with(by, change, &mut |path| {
            path.tangents_along(&[], &mut |_, node, _| sum += cost_at(rotation, node))
                .unwrap();
        });
        vec![sum]
    };
    for place in [rotation, n + rotation] {
        assert_eq!(backward[place].to_bits(), 0.0_f64.to_bits());
    }
    for (by, backward) in backward.iter().enumerate() {
        if by % n == rotation && by < 2 * n || apart(by) {
            continue;
        }
        let variable = match by {
            by if by < n => Variable::Position(by),
            by if by < 2 * n && nodes => Variable::SecondNode(by - n),
            by if by < 2 * n => Variable::Velocity(by - n),
            by => Variable::Parameter(&names[by - 2 * n].name),
        };
        let tangents = path.tangents(&[variable]).unwrap();
        let tangent = tangents.get(0).unwrap();
        let found = [tangent.q, tangent.v, tangent.a].concat();
        let difference = quotient(&|change| end(by, change), 2e-4);
        let expected = [
            &turned(rotation, path.end().q, &difference[..n])[..],
            &difference[n..],
        ]
        .concat();
        for (place, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!(
                (found - expected).abs() < 1e-8 * (1.0 + expected.abs()),
                "{variable:?}, {place}: {found} {expected}"
            );
        }
        // the derivative of the cost along the tangents of all nodes equals the gradient, to rounding
        let mut sum = 0.0;
        path.tangents_along(&[variable], &mut |_, node, tangents| {
            let tangent = tangents.next().unwrap();
            sum += cost_along(rotation, node, [tangent.q, tangent.v, tangent.a]);
        })
        .unwrap();
        let expected = quotient(&|change| cost_of(by, change), 2e-4)[0];
        let bar = 1e-11 * (1.0 + sum.abs() + gradient.cost.abs());
        assert!((backward - sum).abs() < bar, "{variable:?}: {backward} {sum}");
        assert!(
            (sum - expected).abs() < 1e-7 * (1.0 + expected.abs()),
            "{variable:?}: {sum} {expected}"
        );
    }
}

const TURNED: [f64; 4] = [1.0, 0.3, -0.4, 0.2];

#[test]
fn a_heavy_top_has_the_derivatives_of_its_differences() {
    let (q, v) = (unit(TURNED), [0.0, 0.6, -0.3, 2.0]);
    for map in ["", "phi_lagrangian = trapezoid;", "phi_lagrangian = midpoint;"] {
        let text = format!("{TOP}\n{map}");
        let case = Case {
            text: &text,
            rotation: 0,
            q: &q,
            v: &v,
        };
        check(&case, &AnyStart::second_order, false, &|_| false);
        check(&case, &AnyStart::paper, false, &|_| false);
    }
    let second = composed(q, unit([1.0, 0.02, -0.01, 0.05]));
    let case = Case {
        text: TOP,
        rotation: 0,
        q: &q,
        v: &second,
    };
    check(&case, &AnyStart::nodes, true, &|_| false);
}

#[test]
fn numbers_beside_a_rotation_have_the_derivatives_of_their_differences() {
    let [w, x, y, z] = unit(TURNED);
    let q = [0.3, w, x, y, z, -0.2];
    let case = Case {
        text: CART,
        rotation: 1,
        q: &q,
        v: &[0.4, 0.0, 0.6, -0.3, 1.2, 0.1],
    };
    check(&case, &AnyStart::second_order, false, &|_| false);
    check(&case, &AnyStart::paper, false, &|_| false);
    let [w, x, y, z] = composed([w, x, y, z], unit([1.0, 0.02, -0.01, 0.03]));
    let second = [0.32, w, x, y, z, -0.19];
    check(&Case { v: &second, ..case }, &AnyStart::nodes, true, &|_| false);
}

#[test]
fn starts_that_are_moved_onto_constraints_have_the_derivatives_of_their_differences() {
    let projected = |q: &[f64], v: &[f64]| AnyStart::second_order(q, v).projected();
    let case = Case {
        text: SUSLOV,
        rotation: 0,
        q: &unit(TURNED),
        v: &[0.0, 0.6, -0.3, 0.1],
    };
    check(&case, &projected, false, &|_| false);
    let [w, x, y, z] = unit(TURNED);
    let case = Case {
        text: HELD,
        rotation: 0,
        q: &[w, x, y, z, 0.1, 0.5, 0.9],
        v: &[0.0, 0.6, -0.3, 1.1, 0.2, 0.1, -0.2],
    };
    check(&case, &projected, false, &|_| false);
}

#[test]
fn held_torques_have_the_derivatives_of_their_differences() {
    const BODY: &str = "parameters { torque = [0.0, 0.0, 0.0], third = 1.0 }
        coordinates(r: rotation);
        let w = r.angular_velocity();
        lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + third / 2 * w[2].powi(2);
        external_forces = torque;";
    let text = Text::parse("body", BODY).unwrap_or_else(|error| panic!("{error}"));
    let kernel: &dyn Kernel = &text.system;
    let parameters = &kernel.shape().parameters;
    let inputs: Vec<&str> = parameters[..3].iter().map(|own| &*own.name).collect();
    let legs = 20;
    let values = |changed: Option<(usize, usize, f64)>| -> Vec<Vec<f64>> {
        let own = |leg: usize, j: usize| 0.8 * (0.7 * (leg / 3) as f64 + j as f64).sin();
        let mut values: Vec<Vec<f64>> = (0..legs)
            .map(|leg| (0..3).map(|j| own(leg, j)).collect())
            .collect();
        if let Some((leg, j, by)) = changed {
            values[leg][j] += by;
        }
        values
    };
    let (q, v) = (unit(TURNED), [0.0, 0.6, -0.3, 2.0]);
    let planned = |q: &[f64], changed, use_path: &mut dyn FnMut(&AnyPath<'_>)| {
        let values = values(changed);
        let values: Vec<&[f64]> = values.iter().map(|values| &values[..]).collect();
        let start = AnyStart::second_order(q, &v);
        use_path(&AnyPath::plan(&text.system, STEP, &start, &inputs, &values).unwrap());
    };
    let end = |q: &[f64], changed| {
        let mut numbers = Vec::new();
        planned(q, changed, &mut |path| {
            numbers = [path.end().q, path.end().v].concat();
        });
        numbers
    };
    planned(&q, None, &mut |path| {
        let gradient = path.gradient(&mut |_, node| cost(0, node)).unwrap();
        let along = |variable: Variable<'_>, difference: &[f64], derivative: f64| {
            let tangents = path.tangents(&[variable]).unwrap();
            let tangent = tangents.get(0).unwrap();
            let expected = [&turned(0, path.end().q, &difference[..4])[..], &difference[4..]].concat();
            for (found, expected) in tangent.q.iter().chain(tangent.v).zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{variable:?}: {found} {expected}"
                );
            }
            let sum = derivative_of_cost(path, variable);
            assert!(
                (derivative - sum).abs() < 1e-11 * (1.0 + sum.abs()),
                "{variable:?}"
            );
        };
        for leg in [0, 1, 7, legs - 1] {
            for (j, name) in inputs.iter().enumerate() {
                let difference = quotient(&|by| end(&q, Some((leg, j, by))), 2e-4);
                along(
                    Variable::Input { name, leg },
                    &difference,
                    gradient.inputs[leg][j],
                );
            }
        }
        for place in 1..4 {
            let difference = quotient(&|by| end(&moved(0, &q, place, by), None), 2e-4);
            along(Variable::Position(place), &difference, gradient.q0[place]);
        }
    });
}

/// The derivative of the sum of costs along the tangents of all nodes.
fn derivative_of_cost(path: &AnyPath<'_>, variable: Variable<'_>) -> f64 {
    let mut sum = 0.0;
    path.tangents_along(&[variable], &mut |_, node, tangents| {
        let tangent = tangents.next().unwrap();
        let rate = composed(quaternion(node.q, 0), quaternion(tangent.q, 0)).map(|x| 0.5 * x);
        let dual = |numbers: &[f64], rates: &[f64]| -> Vec<Dual<f64>> {
            let both = numbers.iter().zip(rates);
            both.map(|(number, rate)| Dual::new(*number, *rate)).collect()
        };
        let (q, v, a) = (
            dual(node.q, &rate),
            dual(node.v, tangent.v),
            dual(node.a, tangent.a),
        );
        let point = AnyPoint {
            t: Dual::new(node.t, 0.0),
            q: &q,
            v: &v,
            a: &a,
        };
        sum += cost(0, point).eps;
    })
    .unwrap();
    sum
}

/// The heavy top as a compiled system.
#[dsocs {
    coordinates(r: rotation);
    let w = r.angular_velocity();
    lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + 0.5 * w[2].powi(2) - mass * (r * [0.2, 0.1, 1])[2];
}]
struct Top {
    mass: f64,
}

#[test]
fn the_scalar_of_a_quaternion_is_no_variable() {
    let top = Top { mass: 0.7 };
    let start = Start::second_order(unit(TURNED), [0.0, 0.6, -0.3, 2.0]);
    let path = Path::new(&top, STEP, start, UNTIL).unwrap();
    let error = path.tangents(&[Variable::Position(0)]).unwrap_err();
    assert!(
        matches!(&error, DerivativeError::Scalar { rotation, index: 0 } if rotation == "r"),
        "{error}"
    );
    println!("{error}");
    // a compiled system has the gradient of its text
    let gradient = path.gradient_at_end(&mut |end| end.q[1] * end.q[2]).unwrap();
    let tangent = path.tangents(&[Variable::Position(2)]).unwrap()[0];
    let q = path.end().q;
    let rate = composed(q, tangent.q).map(|x| 0.5 * x);
    let expected = rate[1] * q[2] + q[1] * rate[2];
    assert!((gradient.q0[2] - expected).abs() < 1e-13);
}

#[test]
fn the_series_of_a_top_has_the_derivatives_of_its_differences() {
    let (q, v, tolerance) = (unit(TURNED), [0.0, 0.6, -0.3, 2.0], Tolerance::relative(1e-16));
    let end = |q: &[f64], v: [f64; 4], mass: f64| {
        let top = Top { mass };
        let start = Start::second_order(core::array::from_fn(|i| q[i]), v);
        let mut flow = TaylorFlow::new(&top, start, tolerance).unwrap();
        let end = flow.to(3.0).unwrap();
        [&end.q[..], &end.v, &end.a].concat()
    };
    let variables = [
        Variable::Position(1),
        Variable::Position(2),
        Variable::Position(3),
        Variable::Velocity(2),
        Variable::Parameter("mass"),
    ];
    let start = Start::second_order(q, v);
    let mut tangents =
        TaylorTangents::new(&Top { mass: 0.7 }, start, Tolerance::relative(1e-14), &variables).unwrap();
    let at_start = tangents.tangents();
    for (found, expected) in at_start[1].q.iter().zip([0.0, 0.0, 1.0, 0.0]) {
        assert!((found - expected).abs() < 1e-16);
    }
    let found = tangents.to(3.0).unwrap();
    for (variable, found) in variables.iter().zip(found) {
        let at = |by: f64| match variable {
            Variable::Position(place) => end(&moved(0, &q, *place, by), v, 0.7),
            Variable::Velocity(place) => end(
                &q,
                core::array::from_fn(|i| v[i] + if i == *place { by } else { 0.0 }),
                0.7,
            ),
            _ => end(&q, v, 0.7 + by),
        };
        let difference = quotient(&at, 2e-4);
        let position = end(&q, v, 0.7);
        let expected = [&turned(0, &position[..4], &difference[..4])[..], &difference[4..]].concat();
        for (found, expected) in found.q.iter().chain(&found.v).chain(&found.a).zip(expected) {
            assert!(
                (found - expected).abs() < 1e-8 * (1.0 + expected.abs()),
                "{variable:?}: {found} {expected}"
            );
        }
    }
    let refused = TaylorTangents::new(&Top { mass: 0.7 }, start, tolerance, &[Variable::Position(0)]);
    assert!(matches!(
        refused.map(drop),
        Err(DerivativeError::Scalar { index: 0, .. })
    ));
}
