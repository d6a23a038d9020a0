//! Linear models of random declarations against differences of their motions.

use core::fmt::Write as _;

use dsocs_core::geometry::motion;
use dsocs_core::linear::{EquilibriumSearch, OperatingPoint};
use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::TapeKernel;
use dsocs_core::{AnyStart, OwnedNode, Tolerance};
use dsocs_tests::scenes::random::Random;

use super::at;
use super::step::exponential;
use dsocs_tests::text::parsed;

/// Weights of the difference quotient of eighth order.
const WEIGHTS: [(f64, f64); 4] = [(1.0, 0.8), (2.0, -0.2), (3.0, 4.0 / 105.0), (4.0, -1.0 / 280.0)];

/// The derivative of a function along a direction.
pub fn slope(function: &dyn Fn(f64) -> Vec<f64>, shift: f64) -> Vec<f64> {
    let mut slope: Vec<f64> = Vec::new();
    for (times, weight) in WEIGHTS {
        for sign in [1.0, -1.0] {
            let there = function(sign * times * shift);
            slope.resize(there.len(), 0.0);
            slope
                .iter_mut()
                .zip(there)
                .for_each(|(sum, x)| *sum += sign * weight * x / shift);
        }
    }
    slope
}

/// The kind of constraint of a declaration.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Bound {
    Free,
    Holonomic,
    Nonholonomic,
    Law,
}

/// A random system of three coordinates whose origin is an equilibrium, with two inputs.
fn declared(random: &mut Random, bound: Bound) -> String {
    let mut number = || format!("{:.3}", random.between(-1.0, 1.0));
    let mut text = String::from("parameters { left = 0.0, right = 0.0 }\ncoordinates(x, y, z);\n");
    let _ = writeln!(
        text,
        "lagrangian = (2 + {} * y.sin()) / 2 * dot(x).powi(2) + (1.5 + {} * (x * z).cos()) / 2 * dot(y).powi(2) + dot(z).powi(2)
            + {} * (x + {} * y).cos() * dot(x) * dot(y) + {} * y * dot(z) + {} * z.cos() * dot(x) * dot(z) / 2
            - {} * x.powi(2) - {} * (y - {} * z).powi(2) - {} * (x * {} + z).cos() + {} * z.powi(3) - z.powi(2);",
        number(), number(), number(), number(), number(), number(), number(), number(), number(), number(), number(), number()
    );
    let _ = writeln!(
        text,
        "external_forces = (left - {} * dot(x) + {} * dot(y) * z, {} * left * (1 + x) - dot(y), right * y.cos() + {} * dot(x).sin());",
        number(),
        number(),
        number(),
        number()
    );
    match bound {
        Bound::Free => {}
        Bound::Holonomic => {
            let _ = writeln!(
                text,
                "holonomic = x - {} * y + {} * z + y * z + {} * x.sin().powi(2);",
                number(),
                number(),
                number()
            );
        }
        Bound::Nonholonomic => {
            let _ = writeln!(
                text,
                "nonholonomic = dot(x) - ({} + z.sin()) * dot(y) - {} * x * dot(z);",
                number(),
                number()
            );
        }
        Bound::Law => {
            let _ = writeln!(
                text,
                "kinematic = ddot(x) + {} * ddot(y) * z.cos() + 1.3 * dot(x) + 2 * x + {} * y + dot(x) * dot(z);\nconstraint_forces = [(1, 0, {})];",
                number(),
                number(),
                number()
            );
        }
    }
    text
}

/// The state after a time, from a projected start.
fn after(system: &TapeKernel, [q, v]: [&[f64]; 2], time: f64) -> Vec<f64> {
    let start = AnyStart::second_order(q, v).projected();
    let mut flow = AnyTaylorFlow::of_tape(system, &start, Tolerance::relative(1e-15)).unwrap();
    let run: &mut dyn dsocs_core::Run = &mut flow;
    run.to(time).unwrap();
    let mut node = OwnedNode::new(3);
    node.take(run);
    [node.any().q, node.any().v].concat()
}

#[test]
fn models_of_random_systems_are_derivatives_of_their_flows() {
    let (mut random, mut worst) = (Random::new(30), 0.0_f64);
    for bound in [Bound::Free, Bound::Holonomic, Bound::Nonholonomic, Bound::Law] {
        for _ in 0..6 {
            let text = declared(&mut random, bound);
            let system = parsed(&text);
            let point = OperatingPoint::new(&system, at(&[0.0; 3], &[0.0; 3]));
            let model = point.continuous().unwrap();
            let time = 0.4;
            let n = model.states.len();
            assert_eq!(
                n,
                match bound {
                    Bound::Holonomic => 4,
                    Bound::Nonholonomic => 5,
                    _ => 6,
                }
            );
            let scaled: Vec<Vec<f64>> = model
                .a
                .iter()
                .map(|row| row.iter().map(|x| time * x).collect())
                .collect();
            let expected = exponential(&scaled);
            let mut columns = Vec::new();
            for direction in &model.basis {
                let moved = |by: f64| {
                    let state: Vec<f64> = direction.iter().map(|x| by * x).collect();
                    let (q, v) = state.split_at(3);
                    after(&system, [q, v], time)
                };
                let change = slope(&moved, 2e-3);
                // the change in minimal coordinates: the basis is orthonormal in positions and in velocities
                let parts: Vec<f64> = (0..n)
                    .map(|k| {
                        let own = &model.basis[k];
                        let positions = own[..3].iter().any(|x| *x != 0.0);
                        let range = if positions { 0..3 } else { 3..6 };
                        own[range.clone()]
                            .iter()
                            .zip(&change[range])
                            .map(|(x, y)| x * y)
                            .sum()
                    })
                    .collect();
                columns.push(parts);
            }
            for i in 0..n {
                for j in 0..n {
                    worst = worst.max((columns[j][i] - expected[i][j]).abs());
                    assert!(
                        (columns[j][i] - expected[i][j]).abs() < 1e-9,
                        "{bound:?} ({i}, {j}):\n{text}"
                    );
                }
            }
        }
    }
    println!("differences of Taylor flows and exp(A t) are {worst:.1e} apart at most");
}

#[test]
fn models_in_motion_are_derivatives_of_the_acceleration() {
    let (mut random, mut worst) = (Random::new(31), 0.0_f64);
    for bound in [Bound::Free, Bound::Law] {
        for _ in 0..8 {
            let text = declared(&mut random, bound);
            let system = parsed(&text);
            let mut numbers = || -> Vec<f64> { (0..3).map(|_| random.between(-0.6, 0.6)).collect() };
            let (q, v) = (numbers(), numbers());
            let model = OperatingPoint::new(&system, at(&q, &v))
                .outputs(["a_x", "a_y", "a_z"])
                .continuous()
                .unwrap();
            for j in 0..8 {
                let moved = |by: f64| -> Vec<f64> {
                    let (mut q, mut v, mut system) = (q.clone(), v.clone(), system.clone());
                    match j {
                        0..3 => q[j] += by,
                        3..6 => v[j - 3] += by,
                        _ => *system.parameter_mut(j - 6).unwrap() += by,
                    }
                    motion(&system, 0.0, &q, &v).unwrap().any().a.to_vec()
                };
                let change = slope(&moved, 4e-3);
                for (i, change) in change.iter().enumerate() {
                    let [state, output] = if j < 6 {
                        [model.a[3 + i][j], model.c[i][j]]
                    } else {
                        [model.b[3 + i][j - 6], model.d[i][j - 6]]
                    };
                    assert!((state - output).abs() == 0.0, "{state} {output}");
                    worst = worst.max((change - state).abs());
                    assert!(
                        (change - state).abs() < 1e-9,
                        "{bound:?} ({i}, {j}): {change} {state}\n{text}"
                    );
                }
            }
        }
    }
    println!("differences of accelerations are {worst:.1e} away at most");
}

#[test]
fn random_systems_are_found_at_rest_again() {
    let mut random = Random::new(32);
    for bound in [Bound::Free, Bound::Holonomic] {
        for _ in 0..6 {
            let system = parsed(&declared(&mut random, bound));
            let guess: Vec<f64> = (0..3).map(|_| random.between(-0.05, 0.05)).collect();
            let found = EquilibriumSearch::new(&system).near(&guess).unwrap();
            // whichever equilibrium was found, the motion from there stays
            let there = after(&system, [&found.q, &[0.0; 3]], 0.5);
            for (x, y) in there.iter().zip(found.q.iter().chain(&[0.0; 3])) {
                assert!((x - y).abs() < 1e-10, "{bound:?}: {there:?} {found:?}");
            }
            assert!(found.is_isolated());
        }
    }
}
