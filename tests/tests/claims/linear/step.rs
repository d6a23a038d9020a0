//! The linear model of the step: against the exponential, an oscillator by hand, and differences of the nodes.

use dsocs_core::Kernel;
use dsocs_core::geometry::DiscreteFlow;
use dsocs_core::linear::{LinearModel, LinearTime, OperatingPoint};
use dsocs_core::{AnyLeg, Declaration, OwnedLeg};

use super::{assert_close, at, model};
use dsocs_tests::text::parsed;

/// The product of two matrices.
pub fn product(x: &[Vec<f64>], y: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let entry = |row: &Vec<f64>, j: usize| row.iter().zip(y).map(|(x, y)| x * y[j]).sum();
    let columns = y.first().map_or(0, Vec::len);
    x.iter()
        .map(|row| (0..columns).map(|j| entry(row, j)).collect())
        .collect()
}

/// The exponential of a matrix, by its series on a small part of it, squared again.
pub fn exponential(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    const SQUARINGS: i32 = 10;
    let n = matrix.len();
    let small: Vec<Vec<f64>> = matrix
        .iter()
        .map(|row| row.iter().map(|x| x / 2.0_f64.powi(SQUARINGS)).collect())
        .collect();
    let unit: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    let (mut sum, mut term) = (unit.clone(), unit);
    for k in 1..20 {
        term = product(&term, &small);
        for (sum, term) in sum.iter_mut().flatten().zip(term.iter_mut().flatten()) {
            *term /= f64::from(k);
            *sum += *term;
        }
    }
    for _ in 0..SQUARINGS {
        sum = product(&sum, &sum);
    }
    sum
}

/// The transition over a time, and the effect of inputs that are held: from `exp([A B; 0 0] t)`.
fn transition(continuous: &LinearModel, t: f64) -> [Vec<Vec<f64>>; 2] {
    let (n, inputs) = (continuous.a.len(), continuous.inputs.len());
    let mut both: Vec<Vec<f64>> = continuous
        .a
        .iter()
        .zip(&continuous.b)
        .map(|(a, b)| [&a[..], b].concat().iter().map(|x| t * x).collect())
        .collect();
    both.resize(n + inputs, vec![0.0; n + inputs]);
    let all = exponential(&both);
    [0..n, n..n + inputs].map(|columns| all[..n].iter().map(|row| row[columns.clone()].to_vec()).collect())
}

/// The largest difference of two matrices' entries.
fn distance(x: &[Vec<f64>], y: &[Vec<f64>]) -> f64 {
    let pairs = x.iter().flatten().zip(y.iter().flatten());
    pairs.fold(0.0, |most, (x, y)| most.max((x - y).abs()))
}

#[test]
fn the_step_is_the_exponential_to_third_order() {
    let cart = parsed(super::CART_POLE);
    let rod = parsed(
        "parameters { length = 0.8, gravity = 9.81, damping = 0.5, push = 0.0 }
         coordinates(x, y);
         lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
         holonomic = x.powi(2) + y.powi(2) - length.powi(2);
         external_forces = (push - damping * dot(x), -damping * dot(y));",
    );
    let law = parsed(
        "parameters { spring = 9.0, brake = 1.2, push = 0.0 }
         coordinates(x, theta);
         lagrangian = dot(x).powi(2) + 0.2 * theta.cos() * dot(x) * dot(theta) + dot(theta).powi(2) / 4 - theta.cos();
         kinematic = ddot(theta) + brake * dot(theta) + spring * theta - push;
         constraint_forces = [(1, 0)];",
    );
    let knife = parsed(
        "parameters { push = 0.0, offset = 0.3 }
         coordinates(x, y, theta);
         let across = dot(y) * theta.cos() - dot(x) * theta.sin();
         let along = dot(x) * theta.cos() + dot(y) * theta.sin();
         lagrangian = (along.powi(2) + (across + offset * dot(theta)).powi(2)) / 2 + dot(theta).powi(2) / 2 - 2 * x.powi(2) - theta.powi(2);
         nonholonomic = across;
         external_forces = (push, 0, push);",
    );
    let hung = parsed(
        "parameters { mass = 0.7, stiffness = 5.0, rest = 0.3, gravity = 9.81 }
         coordinates(x);
         lagrangian = mass / 2 * dot(x).powi(2) - stiffness / 2 * (x - rest).powi(2) + mass * gravity * x;",
    );
    let cases: [(&dyn Kernel, &[f64], &[&str]); 5] = [
        (&cart, &[0.1, 0.0], &["force"]),
        (&rod, &[0.0, -0.8], &["push"]),
        (&law, &[0.0, 0.0], &["push"]),
        (&knife, &[0.0, 0.0, 0.0], &["push"]),
        (
            &hung,
            &[0.3 + 0.7 * 9.81 / 5.0],
            &["mass", "stiffness", "rest", "gravity"],
        ),
    ];
    for (system, q, inputs) in cases {
        let rest = vec![0.0; q.len()];
        let point = || OperatingPoint::new(system, at(q, &rest)).inputs(inputs.to_vec());
        let continuous = point().continuous().unwrap();
        let errors: Vec<[f64; 2]> = [0.02, 0.01, 0.005]
            .iter()
            .map(|&h| {
                let step = point().step(h).unwrap();
                assert_eq!(step.time, LinearTime::Step { h });
                assert_eq!(step.states, continuous.states);
                let [a, b] = transition(&continuous, h);
                [distance(&step.a, &a), distance(&step.b, &b)]
            })
            .collect();
        for k in 0..2 {
            let order = (errors[0][k] / errors[2][k]).log2() / 2.0;
            println!(
                "{q:?}: errors {:.2e} to {:.2e}, order {order:.3}",
                errors[0][k], errors[2][k]
            );
            assert!(
                errors[2][k] < 2e-5 && (order > 2.9 || errors[0][k] < 1e-13),
                "{q:?}: {errors:?} {order}"
            );
        }
    }
}

#[test]
fn an_oscillator_by_hand() {
    // q″ = −k q + u, with L_d at the first node of a leg: e = h² (u − k q1), v = (d + e/2)/h
    let (stiffness, h) = (3.0, 0.1);
    let spring = parsed(
        "parameters { stiffness = 3.0, push = 0.0 }
         coordinates(x);
         lagrangian = dot(x).powi(2) / 2 - stiffness / 2 * x.powi(2) + push * x;",
    );
    let found = OperatingPoint::new(&spring, at(&[0.4], &[0.7]))
        .inputs(["push"])
        .step(h)
        .unwrap();
    // q⁺ = q + h v + h²/2 (u − k q), v⁺ = v + h/2 (u − k q) + h/2 (u − k q⁺)
    let half = 1.0 - h * h / 2.0 * stiffness;
    let a = [[half, h], [-h / 2.0 * stiffness * (1.0 + half), half]];
    assert_close(&found.a, &a.map(Vec::from), 1e-14);
    assert_close(
        &found.b,
        &[vec![h * h / 2.0], vec![h - h * h * h / 4.0 * stiffness]],
        1e-14,
    );
    let next = [half * 0.4 + h * 0.7, a[1][0] * 0.4 + half * 0.7];
    assert_close(&[found.drift], &[vec![next[0] - 0.4, next[1] - 0.7]], 1e-14);
}

/// The state of a node, as a run reports it, `steps` steps after a leg.
fn reported(system: &dyn Kernel, h: f64, leg: AnyLeg<'_, f64>, near: &[f64], steps: usize) -> Vec<f64> {
    let map = DiscreteFlow::new(system, h).unwrap();
    let mut triple = map.forward_near(leg, near).unwrap();
    for _ in 0..steps {
        triple = map.forward_near(triple.last(h).any(), &triple.e).unwrap();
    }
    let point = Declaration::of(system).point(h, triple.leg.any(), &triple.e);
    [&triple.leg.q[..], point.any().v].concat()
}

#[test]
fn in_motion_the_step_is_the_derivative_of_the_nodes() {
    // nothing is constant here: masses and forces vary, also in time, and the maps are not the paper's
    let system = parsed(
        "parameters { gain = 0.7, bias = 0.2 }
         coordinates(x, y);
         lagrangian = (1.5 + y.sin()) / 2 * dot(x).powi(2) + dot(y).powi(2) / 2 + 0.3 * (x + t).cos() * dot(x) * dot(y) - x.powi(2) * y.cos();
         external_forces = (-gain * dot(x) * y, bias * x * dot(y).powi(2));
         phi_lagrangian = midpoint;",
    );
    let h = 0.1;
    let point = || OperatingPoint::new(&system, at(&[0.3, -0.5], &[0.8, 0.4]).at(0.7));
    let found = point().step(h).unwrap();
    let state = found.point.any();
    assert_eq!((state.q, state.t), (&[0.3, -0.5][..], 0.7));
    assert_close(&[state.v.to_vec()], &[vec![0.8, 0.4]], 1e-13);
    // the model finds the leg again from the state by the same search, in its own basis; here the differences
    // are in the leg
    let near: Vec<f64> = state.a.iter().map(|a| h * h * a).collect();
    let mut d: Vec<f64> = state.v.iter().zip(&near).map(|(v, e)| h * v - e / 2.0).collect();
    for _ in 0..50 {
        let leg = OwnedLeg {
            t: 0.7,
            q: state.q.to_vec(),
            d: d.clone(),
        };
        let there = reported(&system, h, leg.any(), &near, 0);
        d.iter_mut()
            .zip(&there[2..])
            .zip(state.v)
            .for_each(|((d, found), v)| *d += h * (v - found));
    }
    let column = |k: usize, steps: usize| -> Vec<f64> {
        let shift = 1e-2;
        let mut column = vec![0.0; 4];
        for (times, weight) in [(1.0, 0.8), (2.0, -0.2), (3.0, 4.0 / 105.0), (4.0, -1.0 / 280.0)] {
            for sign in [1.0, -1.0] {
                let by = sign * times * shift;
                let mut leg = OwnedLeg {
                    t: 0.7,
                    q: state.q.to_vec(),
                    d: d.clone(),
                };
                if k < 2 {
                    leg.q[k] += by;
                } else {
                    leg.d[k - 2] += h * by;
                }
                let there = reported(&system, h, leg.any(), &near, steps);
                column
                    .iter_mut()
                    .zip(there)
                    .for_each(|(sum, x)| *sum += sign * weight * x / shift);
            }
        }
        column
    };
    // A X = Y, with the columns of X the change of this node and those of Y that of the next
    let rows = |steps: usize| -> Vec<Vec<f64>> {
        let columns: Vec<Vec<f64>> = (0..4).map(|k| column(k, steps)).collect();
        (0..4)
            .map(|i| columns.iter().map(|column| column[i]).collect())
            .collect()
    };
    assert_close(&product(&found.a, &rows(0)), &rows(1), 1e-10);
    // and it differs from the model at zero velocity
    assert!(distance(&found.a, &model_at_rest(&system, h)) > 1e-2);
}

/// The model at the same position with zero velocity.
fn model_at_rest(system: &dyn Kernel, h: f64) -> Vec<Vec<f64>> {
    OperatingPoint::new(system, at(&[0.3, -0.5], &[0.0, 0.0]).at(0.7))
        .step(h)
        .unwrap()
        .a
}

#[test]
fn bound_states_have_bases_that_obey_the_constraints() {
    let plane = parsed(
        "coordinates(x, y, z);
         lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - z;
         holonomic = x.powi(2) + y.powi(2) + z.powi(2) - 1;",
    );
    let (q, v) = ([0.6, 0.0, 0.8], [0.4, 1.0, -0.3]);
    let found = model(&plane, &q, &v);
    assert_eq!((found.states.len(), found.basis.len()), (4, 4));
    for direction in &found.basis {
        let (to, rate) = direction.split_at(3);
        let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
        assert!(dot(to, &q).abs() < 1e-15 && (dot(to, &v) + dot(rate, &q)).abs() < 1e-15);
    }
    // a change along a direction is one of its state alone
    for (k, direction) in found.basis.iter().enumerate() {
        let moved = |from: &[f64], by: &[f64]| -> Vec<f64> {
            from.iter().zip(by).map(|(x, y)| x + 0.1 * y).collect()
        };
        let state = found.state(&moved(&q, &direction[..3]), &moved(&v, &direction[3..]));
        for (i, x) in state.iter().enumerate() {
            assert!((x - if i == k { 0.1 } else { 0.0 }).abs() < 1e-15, "{state:?}");
        }
    }
    // of the step: two nodes on the sphere, and the basis of the next node
    let step = OperatingPoint::new(&plane, at(&q, &v)).step(0.05).unwrap();
    let (found, after) = (&step.basis, &step.basis_after);
    assert!(distance(found, after) > 1e-3 && distance(found, after) < 0.2);
    for (direction, other) in found.iter().zip(&model(&plane, &q, &v).basis) {
        let apart = direction
            .iter()
            .zip(other)
            .fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
        assert!(apart < 1e-2, "{direction:?} {other:?}");
    }
}
