//! Derivatives of a whole run: against central differences, against dual numbers through every step, forward against backward.

use dsocs_core::__private::{Declaration, Scalar as _, Tangent};
use dsocs_core::prelude::*;
use dsocs_core::{DerivativeError, Leg, Path, System, Variable};
use dsocs_systems::{
    CartPole, CurvedParticle, InertiaWheelPendulum, Kapitza, PlanarChain8, Sleigh, SphericalPendulum, Wavy,
};

/// A mass on a cubic spring, with a friction, pushed.
#[dsocs {
    coordinates(x);
    lagrangian = mass * dot(x).powi(2) / 2 - stiffness * x.powi(4) / 4;
    external_forces = push - friction * dot(x).powi(3);
}]
#[derive(Clone)]
struct Pushed {
    mass: f64,
    stiffness: f64,
    friction: f64,
    push: f64,
}

/// Two masses whose coupling is an input, with a mass matrix that varies: the midpoint.
#[dsocs {
    coordinates(x, y);
    lagrangian = (1 + load * x.powi(2)) * dot(x).powi(2) / 2 + dot(y).powi(2) / 2 - coupling * (x - y).powi(2) / 2;
}]
#[derive(Clone)]
struct Coupled {
    load: f64,
    coupling: f64,
}

/// A bead on a circle, pushed along `x`.
#[dsocs {
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - mass * gravity * y;
    holonomic = x.powi(2) + y.powi(2) - 1;
    external_forces = (push, 0);
}]
#[derive(Clone)]
struct Bead {
    mass: f64,
    gravity: f64,
    push: f64,
}

/// A particle whose curvature is steered.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - steering;
    variational = [(dot(x), dot(y))];
}]
#[derive(Clone)]
struct Steered {
    steering: f64,
}

/// The derivative of a function at 0 by differences of fourth order.
fn difference<const K: usize>(scale: f64, function: &dyn Fn(f64) -> [f64; K]) -> [f64; K] {
    let h = 1e-3 * scale;
    let [a, b, c, d] = [h, -h, 2.0 * h, -2.0 * h].map(function);
    std::array::from_fn(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h))
}

/// The largest difference of two vectors' components, relative to the largest component, which counts as 1e-9
/// at least.
fn relative_distance(x: &[f64], y: &[f64]) -> f64 {
    let size = x.iter().chain(y).fold(1e-9_f64, |size, x| size.max(x.abs()));
    let apart = x
        .iter()
        .zip(y)
        .fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
    apart / size
}

/// Position and velocity of the last node.
fn end<S: System<N>, const N: usize, const K: usize>(
    system: &S,
    h: f64,
    start: Start<N>,
    t: f64,
) -> [f64; K] {
    let node = Flow::new(system, h, start).unwrap().to(t).unwrap();
    std::array::from_fn(|i| if i < N { node.q[i] } else { node.v[i - N] })
}

/// Checks the derivatives of the end by a start of position and velocity and by all parameters, forward against differences, and
/// backward against forward. `K` is `2 N`; `scale` is a change of position or velocity, and a relative change of a parameter, at
/// which the end changes noticeably; the differences are taken with 1e-3 of it. The tolerance is relative to the largest
/// derivative.
fn check<S: System<N> + Clone, const N: usize, const K: usize>(
    system: &S,
    (q0, v0): ([f64; N], [f64; N]),
    [h, t]: [f64; 2],
    (scale, tolerance): (f64, f64),
) {
    let path = Path::new(system, h, Start::second_order(q0, v0), t).unwrap();
    let mut found = Vec::new();
    for i in 0..N {
        let moved = |x: &[f64; N], by: f64| std::array::from_fn(|j| if i == j { x[j] + by } else { x[j] });
        let position = difference(scale, &|by| {
            end::<S, N, K>(system, h, Start::second_order(moved(&q0, by), v0), t)
        });
        let velocity = difference(scale, &|by| {
            end::<S, N, K>(system, h, Start::second_order(q0, moved(&v0, by)), t)
        });
        found.push((Variable::Position(i), position));
        found.push((Variable::Velocity(i), velocity));
    }
    for (place, quantity) in S::PARAMETERS.iter().enumerate() {
        let value = system.parameter(place).unwrap();
        let by_parameter = difference(scale * value.abs().max(0.1), &|by| {
            let mut moved = system.clone();
            *moved.parameter_mut(place).unwrap() = value + by;
            end::<S, N, K>(&moved, h, Start::second_order(q0, v0), t)
        });
        found.push((Variable::Parameter(&quantity.name), by_parameter));
    }
    let variables: Vec<Variable> = found.iter().map(|(variable, _)| *variable).collect();
    let tangents = path.tangents(&variables).unwrap();
    // relative to the largest of all: an entry that does not depend on a variable is zero to its scale
    let forward: Vec<f64> = tangents
        .iter()
        .flat_map(|tangent| [tangent.q, tangent.v].concat())
        .collect();
    for ((variable, difference), tangent) in found.iter().zip(&tangents) {
        let own = [tangent.q, tangent.v].concat();
        let missed = relative_distance(&own, difference);
        assert!(
            missed < tolerance,
            "{} {variable:?}: {own:?} {difference:?} {missed:e}",
            S::NAME
        );
    }
    for k in 0..K {
        let gradient = path
            .gradient_at_end(&mut |end| if k < N { end.q[k] } else { end.v[k - N] })
            .unwrap();
        let mut backward = Vec::new();
        for i in 0..N {
            backward.extend([gradient.q0[i], gradient.v0[i]]);
        }
        backward.extend(&gradient.parameters);
        let forward: Vec<f64> = forward.chunks(K).map(|tangent| tangent[k]).collect();
        let missed = relative_distance(&forward, &backward);
        assert!(missed < 1e-12, "{} backward {k}: {missed:e}", S::NAME);
    }
}

#[test]
fn by_start_and_parameters_as_differences_are() {
    check::<_, 2, 4>(
        &InertiaWheelPendulum::default(),
        ([0.5, 0.0], [0.0, 0.5]),
        [0.02, 2.0],
        (0.03, 1e-8),
    );
    let pushed = Pushed {
        mass: 1.3,
        stiffness: 2.0,
        friction: 0.2,
        push: 0.4,
    };
    check::<_, 1, 2>(&pushed, ([0.5], [0.3]), [0.05, 3.0], (1.0, 1e-8));
    check::<_, 2, 4>(
        &Coupled {
            load: 0.4,
            coupling: 2.0,
        },
        ([0.5, 0.1], [0.3, -0.2]),
        [0.05, 3.0],
        (1.0, 1e-8),
    );
    // a function of the user's, and time
    let particle = CurvedParticle {
        mass: 1.5,
        curvature: Wavy::default(),
    };
    check::<_, 2, 4>(&particle, ([0.1, 0.0], [1.0, 0.5]), [0.05, 3.0], (1.0, 1e-8));
    check::<_, 1, 2>(&Kapitza::default(), ([0.2], [0.1]), [0.002, 0.5], (0.02, 1e-8));
    check::<_, 2, 4>(
        &CartPole::default(),
        ([0.0, 0.2], [0.1, 0.0]),
        [0.01, 1.0],
        (1.0, 1e-7),
    );
    check::<_, 2, 4>(
        &SphericalPendulum::default(),
        ([0.8, 0.1], [0.2, 1.0]),
        [0.01, 1.0],
        (1.0, 1e-8),
    );
}

#[test]
fn of_a_chain() {
    let mut q0 = [0.0; 8];
    q0[0] = 0.3;
    check::<_, 8, 16>(
        &PlanarChain8::default(),
        (q0, [0.1; 8]),
        [0.005, 0.1],
        (2.0, 1e-7),
    );
}

#[test]
fn also_back_in_time() {
    let pushed = Pushed {
        mass: 1.3,
        stiffness: 2.0,
        friction: 0.05,
        push: 0.4,
    };
    check::<_, 1, 2>(&pushed, ([0.5], [0.3]), [-0.05, -2.0], (1.0, 1e-8));
}

#[test]
fn of_constrained_systems_by_parameters() {
    let h = 0.02;
    let bead = Bead {
        mass: 1.2,
        gravity: 9.0,
        push: 0.5,
    };
    let flow = Flow::new(&bead, h, Start::second_order([0.6, -0.8], [0.8, 0.6])).unwrap();
    let start = Start::nodes([0.6, -0.8], *flow.position());
    parameters::<_, 2, 4>(&bead, h, start, 1.0);
    // the second node moves with the parameters, and is moved onto the constraints
    for start in [Start::second_order, Start::paper] {
        parameters::<_, 2, 4>(&bead, h, start([0.6, -0.8], [0.8, 0.6]), 1.0);
        parameters::<_, 2, 4>(&bead, h, start([0.7, -0.9], [0.5, 0.6]).projected(), 1.0);
    }
    let sleigh = Sleigh::default();
    let flow = Flow::new(&sleigh, h, Start::second_order([0.0, 0.0, 0.0], [-1.0, 0.0, 0.3])).unwrap();
    let start = Start::nodes([0.0, 0.0, 0.0], *flow.position());
    let path = Path::new(&sleigh, h, start, 1.0).unwrap();
    for (place, quantity) in Sleigh::PARAMETERS.iter().enumerate() {
        // the offset is in the constraint: with another value of it the given nodes would violate the
        // constraint
        if !["mass", "inertia"].contains(&&*quantity.name) {
            continue;
        }
        let expected = by_parameter::<_, 3, 6>(&sleigh, place, h, start, 1.0);
        let tangent = path.tangents(&[Variable::Parameter(&quantity.name)]).unwrap()[0];
        assert!(
            relative_distance(&[tangent.q, tangent.v].concat(), &expected) < 1e-8,
            "{}",
            quantity.name
        );
    }
}

fn by_parameter<S: System<N> + Clone, const N: usize, const K: usize>(
    system: &S,
    place: usize,
    h: f64,
    start: Start<N>,
    t: f64,
) -> [f64; K] {
    let value = system.parameter(place).unwrap();
    difference(value.abs(), &|by| {
        let mut moved = system.clone();
        *moved.parameter_mut(place).unwrap() = value + by;
        end::<S, N, K>(&moved, h, start, t)
    })
}

fn parameters<S: System<N> + Clone, const N: usize, const K: usize>(
    system: &S,
    h: f64,
    start: Start<N>,
    t: f64,
) {
    let path = Path::new(system, h, start, t).unwrap();
    let gradient = path.gradient_at_end(&mut |end| end.q[0]).unwrap();
    for (place, quantity) in S::PARAMETERS.iter().enumerate() {
        let expected = by_parameter::<S, N, K>(system, place, h, start, t);
        let tangent = path.tangents(&[Variable::Parameter(&quantity.name)]).unwrap()[0];
        let missed = relative_distance(&[tangent.q, tangent.v].concat(), &expected);
        assert!(missed < 1e-8, "{} {}: {missed:e}", S::NAME, quantity.name);
        assert!((gradient.parameters[place] - tangent.q[0]).abs() < 1e-12 * tangent.q[0].abs());
    }
}

#[test]
fn by_nodes_as_dual_numbers_through_every_step() {
    // Newton's iteration in dual numbers from the solution: two updates bring the derivative to rounding
    let pendulum = InertiaWheelPendulum::default();
    let declaration = Declaration::of(&pendulum);
    let (h, steps) = (0.1, 400);
    let flow = Flow::new(&pendulum, h, Start::second_order([0.5, 0.0], [0.0, 0.5])).unwrap();
    let (q0, q1) = ([0.5, 0.0], *flow.position());
    let t = h * f64::from(steps);
    let path = Path::new(&pendulum, h, Start::nodes(q0, q1), t).unwrap();
    let mut plain = Flow::new(&pendulum, h, Start::nodes(q0, q1)).unwrap();
    let mut position: [Tangent; 2] = std::array::from_fn(|i| Tangent::new(q1[i], [0.0, 1.0][i]));
    let mut increment: [Tangent; 2] = std::array::from_fn(|i| position[i] - Tangent::new(q0[i], 0.0));
    for _ in 0..steps {
        let leg = plain.leg();
        // the values are those of the run, without what rounding would add up to
        let fixed = |x: [f64; 2], rates: [Tangent; 2]| -> [Tangent; 2] {
            std::array::from_fn(|i| Tangent::new(x[i], rates[i].derivative()))
        };
        let leg = Leg {
            t: Tangent::splat(0.0),
            q: fixed(leg.q, position),
            d: fixed(leg.d, increment),
        };
        plain.advance().unwrap();
        let next = plain.leg();
        let mut z = vec![Tangent::splat(next.d[0] - leg.d[0].value())];
        for _ in 0..4 {
            let h = Tangent::splat(h);
            let (rows, jacobian) = (
                declaration.rows(h, leg.any(), &z),
                declaration.jacobian(h, leg.any(), &z),
            );
            z[0] = z[0] - rows[0] / jacobian[0];
        }
        let e = declaration.second_difference(Tangent::splat(h), leg.any(), &z);
        for i in 0..2 {
            increment[i] = leg.d[i] + e[i];
            position[i] = leg.q[i] + increment[i];
        }
    }
    // the position after the last node: e of the last step is in the velocity (q2 − q0) / 2h
    let tangent = path.tangents(&[Variable::SecondNode(1)]).unwrap()[0];
    let velocity: [f64; 2] = std::array::from_fn(|i| tangent.v[i]);
    let before: [f64; 2] = std::array::from_fn(|i| position[i].derivative() - 2.0 * h * velocity[i]);
    // q0 of the last step, from the position and the increment there
    let expected: [f64; 2] = std::array::from_fn(|i| {
        let next = position[i].derivative();
        let own = next - increment[i].derivative();
        own - (own - before[i])
    });
    assert!(relative_distance(&before, &expected) < 1e-12);
    let node: [f64; 2] = std::array::from_fn(|i| position[i].derivative() - increment[i].derivative());
    assert!(
        relative_distance(&tangent.q, &node) < 1e-11,
        "{:?} {node:?}",
        tangent.q
    );
    assert!(node[1].abs() > 1e-3);
}

#[test]
fn a_sum_over_nodes_is_the_sum_of_their_tangents() {
    let particle = CurvedParticle {
        mass: 1.0,
        curvature: Wavy::default(),
    };
    let path = Path::new(&particle, 0.1, Start::second_order([0.1, 0.0], [1.0, 0.5]), 7.3).unwrap();
    let gradient = path
        .gradient(&mut |k, node| node.q[0] * node.v[1] * (k as f64) + node.a[0] * node.t.re)
        .unwrap();
    let (mut cost, mut sum, mut count) = (0.0, 0.0, 0);
    path.tangents_along(&[Variable::Velocity(0)], &mut |k, node, tangents| {
        assert_eq!(k, count);
        count += 1;
        let (k, tangent) = (k as f64, tangents[0]);
        cost += node.q[0] * node.v[1] * k + node.a[0] * node.t;
        sum += (tangent.q[0] * node.v[1] + node.q[0] * tangent.v[1]) * k + tangent.a[0] * node.t;
    })
    .unwrap();
    assert_eq!(count, path.steps() + 1);
    assert_eq!(path.steps(), 73);
    assert!((gradient.cost - cost).abs() < 1e-11 * cost.abs());
    assert!(
        (gradient.v0[0] - sum).abs() < 1e-11 * sum.abs(),
        "{} {sum}",
        gradient.v0[0]
    );
}

#[test]
fn the_nodes_are_those_of_the_flow() {
    let pendulum = InertiaWheelPendulum::default();
    let start = Start::second_order([0.5, 0.0], [0.0, 0.5]);
    let nodes = Flow::new(&pendulum, 0.1, start)
        .unwrap()
        .until(40.0)
        .unwrap()
        .nodes;
    let path = Path::new(&pendulum, 0.1, start, 40.0).unwrap();
    assert_eq!(path.end(), nodes.last().unwrap());
    path.tangents_along(&[], &mut |k, node, _| {
        assert_eq!(node.q.map(f64::to_bits), nodes[k].q.map(f64::to_bits));
        for (x, y) in [(node.v, nodes[k].v), (node.a, nodes[k].a)] {
            assert!(relative_distance(&x, &y) < 1e-14, "{k}: {x:?} {y:?}");
        }
        assert!((node.t - nodes[k].t).abs() < 1e-12);
    })
    .unwrap();
}

/// Position and velocity at the end of a plan.
fn planned<S: System<N> + Clone, const N: usize, const K: usize>(
    system: &S,
    h: f64,
    start: Start<N>,
    name: &str,
    values: &[[f64; 1]],
) -> [f64; K] {
    let path = Path::plan(system, h, start, [name], values).unwrap();
    let end = path.end();
    std::array::from_fn(|i| if i < N { end.q[i] } else { end.v[i - N] })
}

/// Checks the derivatives of a plan, leg by leg.
fn check_plan<S: System<N> + Clone, const N: usize, const K: usize>(
    system: &S,
    h: f64,
    start: Start<N>,
    name: &'static str,
    values: &[[f64; 1]],
) {
    let path = Path::plan(system, h, start, [name], values).unwrap();
    let gradient = path
        .gradient_at_end(&mut |end| end.q[0] + end.v[N - 1] * 0.3)
        .unwrap();
    assert_eq!(gradient.inputs.len(), values.len());
    let mut sum = 0.0;
    for leg in 0..values.len() {
        let expected: [f64; K] = difference(1.0, &|by| {
            let mut moved = values.to_vec();
            moved[leg][0] += by;
            planned(system, h, start, name, &moved)
        });
        let tangent = path.tangents(&[Variable::Input { name, leg }]).unwrap()[0];
        let own = [tangent.q, tangent.v].concat();
        let missed = own
            .iter()
            .zip(&expected)
            .fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
        assert!(missed < 1e-9, "{} leg {leg}: {own:?} {expected:?}", S::NAME);
        let forward = tangent.q[0] + 0.3 * tangent.v[N - 1];
        assert!(
            (gradient.inputs[leg][0] - forward).abs() < 1e-12,
            "{} leg {leg}",
            S::NAME
        );
        sum += forward;
    }
    let place = S::PARAMETERS.iter().position(|known| known.name == name).unwrap();
    assert!((gradient.parameters[place] - sum).abs() < 1e-11);
    let whole = path.tangents(&[Variable::Parameter(name)]).unwrap()[0];
    assert!((whole.q[0] + 0.3 * whole.v[N - 1] - sum).abs() < 1e-11);
}

#[test]
fn by_inputs_leg_by_leg() {
    let plans = [
        (0..12).map(|k| [0.3 - 0.1 * f64::from(k)]).collect::<Vec<_>>(),
        vec![[0.0]; 12],
        [[[0.5]; 6], [[-0.5]; 6]].concat(),
    ];
    for values in &plans {
        let pushed = Pushed {
            mass: 1.3,
            stiffness: 2.0,
            friction: 0.2,
            push: 7.0,
        };
        check_plan::<_, 1, 2>(&pushed, 0.1, Start::second_order([0.5], [0.3]), "push", values);
        let coupled = Coupled {
            load: 0.4,
            coupling: 7.0,
        };
        let start = Start::second_order([0.5, 0.1], [0.3, -0.2]);
        check_plan::<_, 2, 4>(&coupled, 0.1, start, "coupling", values);
        check_plan::<_, 2, 4>(&coupled, 0.1, start, "load", values);
        let bead = Bead {
            mass: 1.2,
            gravity: 9.0,
            push: 0.0,
        };
        let flow = Flow::new(&bead, 0.1, Start::second_order([0.6, -0.8], [0.8, 0.6])).unwrap();
        let start = Start::nodes([0.6, -0.8], *flow.position());
        check_plan::<_, 2, 4>(&bead, 0.1, start, "push", values);
    }
}

/// The velocities of all nodes of a plan, and their derivatives by the value of a leg.
fn velocities(system: &Pushed, values: &[[f64; 1]], leg: usize) -> (Vec<f64>, Vec<f64>) {
    let start = Start::second_order([0.5], [0.3]);
    let path = Path::plan(system, 0.1, start, ["push"], values).unwrap();
    let (mut all, mut slopes) = (Vec::new(), Vec::new());
    let variable = Variable::Input { name: "push", leg };
    path.tangents_along(&[variable], &mut |_, point, tangents| {
        all.push(point.v[0]);
        slopes.push(tangents[0].v[0]);
    })
    .unwrap();
    (all, slopes)
}

/// The velocity of a node at which an input changes is that with which the motion arrives: the new value does not move it.
#[test]
fn velocities_at_changes_do_not_see_the_new_value() {
    let system = Pushed {
        mass: 1.3,
        stiffness: 2.0,
        friction: 0.2,
        push: 7.0,
    };
    let values: Vec<[f64; 1]> = (0..6).map(|k| [0.3 - 0.1 * f64::from(k)]).collect();
    let start = Start::second_order([0.5], [0.3]);
    let path = Path::plan(&system, 0.1, start, ["push"], &values).unwrap();
    for leg in 0..values.len() {
        let (all, slopes) = velocities(&system, &values, leg);
        let moved = |by: f64| {
            let mut moved = values.clone();
            moved[leg][0] += by;
            velocities(&system, &moved, leg).0
        };
        let [less, more] = [moved(-1e-4), moved(1e-4)];
        for node in 0..all.len() {
            let expected = (more[node] - less[node]) / 2e-4;
            assert!(
                (slopes[node] - expected).abs() < 1e-8,
                "leg {leg}, node {node}: {} {expected}",
                slopes[node]
            );
            // legs from this node on come later
            assert!(node > leg || slopes[node] == 0.0, "leg {leg}, node {node}");
            let gradient = path
                .gradient(&mut |index, point| {
                    if index == node {
                        point.v[0]
                    } else {
                        point.v[0] * 0.0
                    }
                })
                .unwrap();
            assert!((gradient.inputs[leg][0] - slopes[node]).abs() < 1e-12);
        }
    }
}

#[test]
fn a_plan_is_the_run_with_the_same_inputs() {
    let pushed = Pushed {
        mass: 1.3,
        stiffness: 2.0,
        friction: 0.2,
        push: 0.3,
    };
    let values: Vec<[f64; 1]> = (0..10).map(|k| [0.3 - 0.1 * f64::from(k)]).collect();
    let start = Start::second_order([0.5], [0.3]);
    let path = Path::plan(&pushed, 0.1, start, ["push"], &values).unwrap();
    let mut run = Flow::new(&pushed, 0.1, start).unwrap();
    run.drive(0.8, &mut |node, run| {
        // an input that is set at a node holds from the next position on
        run.set_input("push", values[usize::try_from(node.index).unwrap() + 1][0])
    })
    .unwrap();
    for _ in 0..2 {
        run.advance().unwrap();
    }
    assert_eq!(&run.node(), path.end());
    assert!((path.end().t - 1.0).abs() < 1e-15);
}

/// All results of a path in bits: tangents along it, tangents at its end, and gradients.
fn bits<const N: usize>(path: &Path<'_, N>, parameter: &str) -> Vec<u64> {
    let mut all = Vec::new();
    let variables = [Variable::Position(0), Variable::Parameter(parameter)];
    path.tangents_along(&variables, &mut |index, point, tangents| {
        all.push(index as u64);
        all.extend(point.q.iter().chain(&point.v).map(|x| x.to_bits()));
        for tangent in tangents {
            all.extend(tangent.q.iter().chain(&tangent.v).map(|x| x.to_bits()));
        }
    })
    .unwrap();
    for tangent in path.tangents(&variables).unwrap() {
        all.extend(tangent.q.iter().chain(&tangent.v).map(|x| x.to_bits()));
    }
    let sum = path.gradient(&mut |_, node| node.q[0] * node.q[0] + node.v[N - 1] * 2.0);
    let end = path.gradient_at_end(&mut |node| node.q[0] * node.v[0]);
    for gradient in [sum.unwrap(), end.unwrap()] {
        all.push(gradient.cost.to_bits());
        let numbers = gradient.q0.iter().chain(&gradient.v0).chain(&gradient.parameters);
        all.extend(numbers.map(|x| x.to_bits()));
    }
    all.extend(path.end().q.map(f64::to_bits));
    all
}

#[test]
fn checkpoints_change_no_bit() {
    // without a limit of memory the number of checkpoints is the optimal one
    let pushed = Pushed {
        mass: 1.3,
        stiffness: 2.0,
        friction: 0.1,
        push: 0.4,
    };
    let coupled = Coupled {
        load: 0.5,
        coupling: 3.0,
    };
    for steps in [1_u16, 7, 8, 9, 40, 63, 64, 65, 257, 1000, 5003] {
        let until = 0.01 * f64::from(steps);
        let start = Start::second_order([0.4], [0.3]);
        let [kept, again] =
            [usize::MAX, 0].map(|memory| Path::within(&pushed, 0.01, start, until, memory).unwrap());
        assert_eq!(again.steps(), usize::from(steps));
        assert_eq!(bits(&kept, "friction"), bits(&again, "friction"), "{steps}");
        let start = Start::second_order([0.4, -0.2], [0.3, 1.0]);
        let [kept, again] =
            [usize::MAX, 0].map(|memory| Path::within(&coupled, -0.01, start, -until, memory).unwrap());
        assert_eq!(bits(&kept, "load"), bits(&again, "load"), "{steps}");
    }
}

/// Unknown parameters and coordinates, and runs without derivatives, give an error that names them and the
/// known names.
#[test]
fn what_has_no_derivative_says_so() {
    let pushed = Pushed {
        mass: 1.3,
        stiffness: 2.0,
        friction: 0.2,
        push: 0.4,
    };
    let start = Start::second_order([0.5], [0.3]);
    let path = Path::new(&pushed, 0.1, start, 1.0).unwrap();
    let of = |variable| path.tangents(&[variable]).unwrap_err();
    assert!(matches!(
        of(Variable::Parameter("pusch")),
        DerivativeError::Parameter { .. }
    ));
    assert!(
        of(Variable::Parameter("pusch"))
            .to_string()
            .contains("mass, stiffness, friction, push")
    );
    assert!(matches!(
        of(Variable::Position(1)),
        DerivativeError::Index { count: 1, .. }
    ));
    assert!(matches!(
        of(Variable::SecondNode(0)),
        DerivativeError::Variable { .. }
    ));
    let input = Variable::Input { name: "push", leg: 0 };
    assert!(matches!(of(input), DerivativeError::Input { .. }));
    let nodes = Path::new(&pushed, 0.1, Start::nodes([0.5], [0.53]), 1.0).unwrap();
    let error = nodes.tangents(&[Variable::Velocity(0)]).unwrap_err();
    assert!(matches!(error, DerivativeError::Variable { .. }));
    let exact = start.exact(&pushed, 0.1).unwrap();
    let error = Path::new(&pushed, 0.1, exact, 1.0)
        .unwrap()
        .tangents(&[])
        .unwrap_err();
    assert!(matches!(error, DerivativeError::Start { .. }));
    let plan = |values: &[[f64; 1]]| Path::plan(&pushed, 0.1, start, ["push"], values).unwrap_err();
    assert_eq!(plan(&[]), DerivativeError::NoLegs);
    assert!(matches!(
        plan(&[[f64::NAN]]),
        DerivativeError::Run(RunError::Input(_))
    ));
    let short = Path::new(&pushed, 0.1, start, 0.01).unwrap_err();
    assert!(matches!(short, DerivativeError::NoSteps { .. }));
    let steered = Steered { steering: 1.0 };
    let start = Start::second_order([0.0, 0.0], [1.0, 0.0]);
    let error = Path::plan(&steered, 0.1, start, ["steering"], &[[1.0]]).unwrap_err();
    assert!(matches!(error, DerivativeError::Constraints { .. }));
}
