//! Linear models and equilibria of systems with rotations: by hand, against runs from nearby starts, and
//! against the same systems without rotations.

use dsocs_core::linear::{EquilibriumError, EquilibriumSearch, LinearModel, OperatingPoint, Stability};
use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::{AnyFlow, AnyStart, Kernel, OwnedNode, Run, Tolerance};
use dsocs_tests::scenes::elimination::Decomposed;
use dsocs_tests::text::parsed;
use dsocs_tests::vectors::{Vector, composed, cross, moved, product, quaternion, solved, turned, unit};

use crate::linear::assert_close;

/// A vector of space in the frame of the body.
fn in_body_frame(q: [f64; 4], v: Vector) -> Vector {
    let [w, x, y, z] = q;
    let [_, seen @ ..] = composed(composed([w, -x, -y, -z], [0.0, v[0], v[1], v[2]]), q);
    seen
}

/// The rotation vector from one quaternion to another.
fn turn(from: [f64; 4], to: [f64; 4]) -> Vector {
    let [w, x, y, z] = from;
    let [scalar, vector @ ..] = composed([w, -x, -y, -z], to);
    let size = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    let angle = 2.0 * size.atan2(scalar);
    vector.map(|x| if size > 0.0 { x / size * angle } else { 0.0 })
}

fn names(model: &LinearModel) -> Vec<&str> {
    model.states.iter().map(|state| &*state.name).collect()
}

const INERTIA: [Vector; 3] = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]];
const ARM: Vector = [0.2, 0.1, 1.0];
const MASS: f64 = 0.7;
const DRAG: f64 = 0.1;

const TOP: &str = "parameters { inertia = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]], arm = [0.2, 0.1, 1.0], mass = 0.7, drag = 0.1 }
    coordinates(r: rotation);
    let w = r.angular_velocity();
    let height = (r * arm)[2];
    lagrangian = w.inner(inertia * w) / 2 - mass * height;
    external_forces = -drag * w;
    observe = [height];";

#[test]
fn a_heavy_top_in_motion_has_the_model_by_hand() {
    let top = parsed(TOP);
    let (q, w) = (unit([1.0, 0.3, -0.4, 0.2]), [0.6, -0.3, 2.0]);
    let start = AnyStart::second_order(&q, &w);
    let model = OperatingPoint::new(&top, start)
        .inputs(["mass", "drag"])
        .outputs(["height", "r_w", "r_y", "v_r_x", "a_r_z"])
        .continuous()
        .unwrap();
    assert_eq!(
        names(&model),
        ["turn_r_x", "turn_r_y", "turn_r_z", "v_r_x", "v_r_y", "v_r_z"]
    );
    let unit_of = |name: &str| -> (&str, Option<&str>) {
        let mut all = model.states.iter().chain(&model.outputs);
        let quantity = all.find(|quantity| quantity.name == name).unwrap();
        (quantity.meaning(), quantity.unit())
    };
    let about = "about the first axis of its body";
    for (name, meaning, unit) in [
        ("turn_r_x", format!("The turn of `r` {about}"), "rad"),
        ("v_r_x", format!("The angular velocity of `r` {about}"), "rad/s"),
    ] {
        assert_eq!(unit_of(name), (&*meaning, Some(unit)));
    }
    // I dω' = I dω × ω + I ω × dω - m c × (Γ × ξ) - drag dω, and ξ' = dω + ξ × ω
    let vertical = in_body_frame(q, [0.0, 0.0, 1.0]);
    let acceleration = |turn: Vector, spin: Vector| -> Vector {
        let weight = cross(ARM, cross(vertical, turn)).map(|x| -MASS * x);
        let gyro = [
            cross(product(&INERTIA, spin), w),
            cross(product(&INERTIA, w), spin),
            spin.map(|x| -DRAG * x),
        ];
        solved(
            &INERTIA,
            [0, 1, 2].map(|i| weight[i] + gyro[0][i] + gyro[1][i] + gyro[2][i]),
        )
    };
    let axis = |k: usize| -> Vector { core::array::from_fn(|i| f64::from(u8::from(i == k))) };
    let columns: Vec<[Vector; 2]> = (0..6)
        .map(|k| {
            let (turn, spin) = if k < 3 {
                (axis(k), [0.0; 3])
            } else {
                ([0.0; 3], axis(k - 3))
            };
            let way = cross(turn, w);
            [[0, 1, 2].map(|i| spin[i] + way[i]), acceleration(turn, spin)]
        })
        .collect();
    let a: Vec<Vec<f64>> = (0..6)
        .map(|i| columns.iter().map(|column| column.concat()[i]).collect())
        .collect();
    assert_close(&model.a, &a, 1e-14);
    let by_mass = solved(&INERTIA, cross(ARM, vertical).map(|x| -x));
    let by_drag = solved(&INERTIA, w.map(|x| -x));
    let b: Vec<Vec<f64>> = (0..6)
        .map(|i| {
            if i < 3 {
                vec![0.0; 2]
            } else {
                vec![by_mass[i - 3], by_drag[i - 3]]
            }
        })
        .collect();
    assert_close(&model.b, &b, 1e-14);
    // the height is c·Γ, the quaternion ½ q∘(0, ξ)
    let height: Vec<f64> = (0..3)
        .map(|k| (0..3).map(|i| ARM[i] * cross(vertical, axis(k))[i]).sum())
        .collect();
    let rate = |k: usize| composed(q, [0.0, axis(k)[0], axis(k)[1], axis(k)[2]]).map(|x| 0.5 * x);
    let still = [0.0; 3];
    let c = vec![
        [&height[..], &still].concat(),
        [&[0, 1, 2].map(|k| rate(k)[0])[..], &still].concat(),
        [&[0, 1, 2].map(|k| rate(k)[2])[..], &still].concat(),
        vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        a[5].clone(),
    ];
    assert_close(&model.c, &c, 1e-14);
    let drift: Vec<f64> = w
        .iter()
        .copied()
        .chain(model.point.any().a[1..].iter().copied())
        .collect();
    assert_close(core::slice::from_ref(&model.drift), &[drift], 1e-15);
    // a controller multiplies the turn from the operating point, whatever the sign of the quaternion
    let there = turned(q, [1e-3, -2e-3, 5e-4]).map(|x| -x);
    let state = model.state(&there, &[0.0, 0.7, -0.3, 2.0]);
    let expected = [1e-3, -2e-3, 5e-4, 0.1, 0.0, 0.0];
    for (state, expected) in state.iter().zip(expected) {
        assert!((state - expected).abs() < 1e-15, "{state} {expected}");
    }
}

/// A matrix times a vector.
fn applied(matrix: &[Vec<f64>], v: &[f64]) -> Vec<f64> {
    let row = |row: &Vec<f64>| row.iter().zip(v).map(|(x, y)| x * y).sum();
    matrix.iter().map(row).collect()
}

#[test]
fn a_sleeping_top_goes_as_the_exponential_of_its_model() {
    // seen from the body nothing changes, so the model holds along the whole motion
    const SLEEPING: &str = "coordinates(r: rotation);
        let w = r.angular_velocity();
        lagrangian = w[0].powi(2) + w[1].powi(2) + w[2].powi(2) / 2 - (r * [0, 0, 1])[2];";
    let top = parsed(SLEEPING);
    let (q, v) = ([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 6.0]);
    let model = OperatingPoint::new(&top, AnyStart::second_order(&q, &v))
        .continuous()
        .unwrap();
    let until = 1.7;
    let end = |z: &[f64]| {
        let start = turned(q, [z[0], z[1], z[2]]);
        let velocity: Vec<f64> = v.iter().zip(&z[3..]).map(|(v, z)| v + z).collect();
        let start = AnyStart::second_order(&start, &velocity);
        let mut flow = AnyTaylorFlow::of_tape(&top, &start, Tolerance::relative(1e-16)).unwrap();
        let run: &mut dyn Run = &mut flow;
        run.to(until).unwrap();
        let mut node = OwnedNode::new(4);
        node.take(run);
        node
    };
    for k in 0..6 {
        let z = |size: f64| -> Vec<f64> { (0..6).map(|i| if i == k { size } else { 0.0 }).collect() };
        let (before, after) = (end(&z(-1e-5)), end(&z(1e-5)));
        let (before, after) = (before.any(), after.any());
        let way = turn(quaternion(before.q, 0), quaternion(after.q, 0));
        let spin: Vec<f64> = after.v[1..]
            .iter()
            .zip(&before.v[1..])
            .map(|(x, y)| x - y)
            .collect();
        let found: Vec<f64> = way.iter().chain(&spin).map(|x| x / 2e-5).collect();
        // the series of the exponential
        let (mut expected, mut term) = (z(1.0), z(1.0));
        for order in 1..80 {
            term = applied(&model.a, &term)
                .iter()
                .map(|x| x * until / f64::from(order))
                .collect();
            expected.iter_mut().zip(&term).for_each(|(sum, x)| *sum += x);
        }
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-7, "{k}: {found} {expected}");
        }
    }
}

/// About a state in motion the turn of a rotation is expressed in the moving frame of the body: the model
/// agrees with differences of motions by Taylor series from turned starts, to 1e-4.
#[test]
fn in_motion_a_turn_is_seen_from_the_moving_body() {
    let top = parsed(TOP);
    let (q, w) = (unit([1.0, 0.3, -0.4, 0.2]), [0.6, -0.3, 2.0]);
    let model = OperatingPoint::new(&top, AnyStart::second_order(&q, &w))
        .continuous()
        .unwrap();
    let at = |z: &[f64], t: f64| -> [Vec<f64>; 2] {
        let spin: Vec<f64> = w.iter().zip(&z[3..]).map(|(w, z)| w + z).collect();
        let start = AnyStart::second_order(&turned(q, [z[0], z[1], z[2]]), &spin);
        let mut flow = AnyTaylorFlow::of_tape(&top, &start, Tolerance::relative(1e-16)).unwrap();
        let run: &mut dyn Run = &mut flow;
        run.to(t).unwrap();
        let mut node = OwnedNode::new(4);
        node.take(run);
        [node.any().q.to_vec(), node.any().v.to_vec()]
    };
    // the rate at the beginning, of third order in a time
    let t = 1e-2;
    let rate = |of: &dyn Fn(f64) -> Vec<f64>| -> Vec<f64> {
        let [a, b, c, d] = [0.0, 1.0, 2.0, 3.0].map(|k| of(k * t));
        let sum = |i: usize| (-11.0 * a[i] + 18.0 * b[i] - 9.0 * c[i] + 2.0 * d[i]) / (6.0 * t);
        (0..6).map(sum).collect()
    };
    let part = |state: &[Vec<f64>; 2]| -> Vec<f64> { model.state(&state[0], &state[1]) };
    let still = [0.0; 6];
    for (found, expected) in rate(&|t| part(&at(&still, t))).iter().zip(&model.drift) {
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }
    for k in 0..6 {
        let z = |size: f64| -> Vec<f64> { (0..6).map(|i| if i == k { size } else { 0.0 }).collect() };
        let size = 1e-4;
        let about = |t: f64, z: &[f64]| -> Vec<f64> {
            let ([q, v], [p, u]) = (at(&still, t), at(z, t));
            model.state_about([&q, &v], [&p, &u])
        };
        let both = |of: &dyn Fn(f64, &[f64]) -> Vec<f64>| {
            rate(&|t| {
                let (after, before) = (of(t, &z(size)), of(t, &z(-size)));
                let differences = after.iter().zip(&before);
                differences.map(|(x, y)| (x - y) / (2.0 * size)).collect()
            })
        };
        let moving = both(&about);
        // relative to the fixed attitude, half of the body's turn is added
        let fixed = both(&|t, z| part(&at(z, t)));
        let axis: Vector = core::array::from_fn(|i| f64::from(u8::from(i == k)));
        let half = cross(w, axis).map(|x| x / 2.0);
        for i in 0..6 {
            let expected = model.a[i][k];
            assert!(
                (moving[i] - expected).abs() < 1e-4,
                "{k}, {i}: {} {expected}",
                moving[i]
            );
            let expected = expected + if i < 3 { half[i] } else { 0.0 };
            assert!(
                (fixed[i] - expected).abs() < 1e-4,
                "{k}, {i}: {} {expected}",
                fixed[i]
            );
        }
    }
}

/// A cart with a body on it, and a spring between a number and the attitude.
const CART: &str = "parameters { mass = 0.7, arm = [0.2, 0.1, 1.0], stiffness = 3.0 }
    coordinates(x, r: rotation, y);
    let w = r.angular_velocity();
    let v = [dot(x), 0, 0] + r * w.cross(arm);
    lagrangian = w.norm_squared() + mass * v.norm_squared() / 2 + dot(x).powi(2) / 2 + dot(y).powi(2) / 2 - mass * (r * arm)[2]
        - stiffness * (y - x + (r * arm)[1]).powi(2) / 2;";

/// The positions of a leg's two nodes, of a system with one rotation.
type Nodes = [Vec<f64>; 2];

/// The states (position and velocity) of the middle node and of the next.
fn states(system: &dyn Kernel, h: f64, [q0, q1]: &Nodes) -> [[Vec<f64>; 2]; 2] {
    let mut flow = AnyFlow::new(system, h, &AnyStart::nodes(q0, q1)).unwrap();
    let mut node = OwnedNode::new(q0.len());
    [1.0, 2.0].map(|k| {
        flow.run_mut().to(k * h).unwrap();
        node.take(flow.run());
        [node.any().q.to_vec(), node.any().v.to_vec()]
    })
}

/// The coordinates that vary freely: of a quaternion the last three.
fn moving(rotation: usize, n: usize) -> impl Iterator<Item = usize> {
    (0..n).filter(move |i| *i != rotation)
}

/// The difference of two states in minimal coordinates.
fn state_difference(rotation: usize, [q, v]: &[Vec<f64>; 2], [p, w]: &[Vec<f64>; 2]) -> Vec<f64> {
    let n = q.len();
    let mut way: Vec<f64> = p.iter().zip(q).map(|(p, q)| p - q).collect();
    let own = turn(quaternion(q, rotation), quaternion(p, rotation));
    way[rotation + 1..rotation + 4].copy_from_slice(&own);
    let speed: Vec<f64> = w.iter().zip(v).map(|(w, v)| w - v).collect();
    let pick = |all: &[f64]| moving(rotation, n).map(|i| all[i]).collect::<Vec<f64>>();
    [pick(&way), pick(&speed)].concat()
}

#[test]
fn a_step_has_the_model_of_its_differences() {
    for (text, rotation) in [(TOP, 0), (CART, 1)] {
        for map in ["", "phi_lagrangian = trapezoid;", "phi_lagrangian = midpoint;"] {
            let system = parsed(&format!("{text}\n{map}"));
            let [w, x, y, z] = unit([1.0, 0.3, -0.4, 0.2]);
            let (q, v) = if rotation == 0 {
                (vec![w, x, y, z], vec![0.0, 0.6, -0.3, 2.0])
            } else {
                (vec![0.3, w, x, y, z, -0.2], vec![0.4, 0.0, 0.6, -0.3, 1.2, 0.1])
            };
            let (h, n) = (0.1, q.len());
            let model = OperatingPoint::new(&system, AnyStart::second_order(&q, &v))
                .step(h)
                .unwrap();
            // a leg through this state: by Newton's iteration on its first node
            let mut first = q.clone();
            for place in moving(rotation, n) {
                first = moved(rotation, &first, place, -h * v[place]);
            }
            let rests = |first: &Vec<f64>| {
                let [here, _] = states(&system, h, &[first.clone(), q.clone()]);
                state_difference(rotation, &[q.clone(), v.clone()], &here)[n - 1..].to_vec()
            };
            for _ in 0..12 {
                let rest = rests(&first);
                let columns: Vec<Vec<f64>> = moving(rotation, n)
                    .map(|place| {
                        let [before, after] =
                            [-1e-4, 1e-4].map(|by| rests(&moved(rotation, &first, place, by)));
                        after.iter().zip(&before).map(|(x, y)| (x - y) / 2e-4).collect()
                    })
                    .collect();
                let row = |i: usize| columns.iter().map(|column| column[i]).collect();
                let rows = (0..rest.len()).map(row).collect();
                let update = Decomposed::new(rows).unwrap().solve(&rest);
                for (place, update) in moving(rotation, n).zip(&update) {
                    first = moved(rotation, &first, place, -update);
                }
            }
            assert!(rests(&first).iter().all(|rest| rest.abs() < 1e-13));
            // the derivatives of both states by the nodes
            let nodes = [first, q.clone()];
            let by_nodes: Vec<[Vec<f64>; 2]> = (0..2)
                .flat_map(|k| moving(rotation, n).map(move |place| (k, place)))
                .map(|(k, place)| {
                    let at = |by: f64| {
                        let mut nodes = nodes.clone();
                        nodes[k] = moved(rotation, &nodes[k], place, by);
                        states(&system, h, &nodes)
                    };
                    let shift = 1e-3;
                    let [far, near, back, behind] = [2.0, 1.0, -1.0, -2.0].map(|k| at(k * shift));
                    [0, 1].map(|node| {
                        let wide = state_difference(rotation, &behind[node], &far[node]);
                        let narrow = state_difference(rotation, &back[node], &near[node]);
                        let both = narrow.iter().zip(&wide);
                        both.map(|(narrow, wide)| (8.0 * narrow - wide) / (12.0 * shift))
                            .collect()
                    })
                })
                .collect();
            // A takes the state here to the state there
            for [here, there] in &by_nodes {
                for (found, expected) in applied(&model.a, here).iter().zip(there) {
                    assert!(
                        (found - expected).abs() < 1e-8 * (1.0 + expected.abs()),
                        "{rotation}, {map}: {found} {expected}"
                    );
                }
            }
            let [here, there] = states(&system, h, &nodes);
            for (found, expected) in model.drift.iter().zip(state_difference(rotation, &here, &there)) {
                // by the map of increments, which is exact up to its fifth power
                assert!((found - expected).abs() < 1e-6, "{found} {expected}");
            }
        }
    }
}

/// A body with a held point: its centre is bound to its attitude.
const HELD: &str = "coordinates(r: rotation, x: [3]);
    let w = r.angular_velocity();
    lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + 0.5 * w[2].powi(2) + 0.35 * dot(x).norm_squared() - 0.7 * x[2];
    external_forces = (-0.1 * w, [0, 0, 0]);
    holonomic = x - r * [0, 0, -1];";

/// The body of `HELD` with its inertia about the held point, without the coordinates of its centre.
const ABOUT: &str = "coordinates(r: rotation);
    let w = r.angular_velocity();
    lagrangian = 1.35 * w[0].powi(2) + 1.1 * w[1].powi(2) + 0.5 * w[2].powi(2) + 0.7 * (r * [0, 0, 1])[2];
    external_forces = -0.1 * w;";

#[track_caller]
fn same(found: &[[f64; 2]], expected: &[[f64; 2]], bar: f64) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        for k in 0..2 {
            assert!((found[k] - expected[k]).abs() < bar, "{found:?} {expected:?}");
        }
    }
}

#[test]
fn a_body_that_is_bound_has_the_eigenvalues_of_the_one_about_its_point() {
    let (held, about) = (parsed(HELD), parsed(ABOUT));
    let q = turned([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.4]);
    let place = [&q[..], &[0.0, 0.0, -1.0]].concat();
    let points = [
        OperatingPoint::new(&held, AnyStart::second_order(&place, &[0.0; 6])),
        OperatingPoint::new(&about, AnyStart::second_order(&q, &[0.0; 3])),
    ];
    let [one, other] = points.each_ref().map(|point| point.continuous().unwrap());
    assert_eq!(one.a.len(), 6);
    same(&one.eigenvalues().unwrap(), &other.eigenvalues().unwrap(), 1e-10);
    // and the step's model is nearly the exponential
    let error = |h: f64| {
        let [one, other] = points.each_ref().map(|point| point.step(h).unwrap());
        assert_eq!(one.a.len(), 6);
        same(
            &one.eigenvalues().unwrap(),
            &other.eigenvalues().unwrap(),
            h.powi(3),
        );
        let sizes = |values: Vec<[f64; 2]>| {
            let mut sizes: Vec<f64> = values.iter().map(|[re, im]| re.hypot(*im)).collect();
            sizes.sort_by(f64::total_cmp);
            sizes
        };
        let exact = points[1].continuous().unwrap().eigenvalues().unwrap();
        let exact = sizes(exact.iter().map(|[re, _]| [(re * h).exp(), 0.0]).collect());
        let found = sizes(one.eigenvalues().unwrap());
        found
            .iter()
            .zip(exact)
            .map(|(x, y)| (x - y).abs())
            .fold(0.0, f64::max)
    };
    assert!(error(0.1) < 1e-3 && error(0.01) < 1e-6);
}

#[test]
fn a_body_in_springs_rests_where_they_are_short() {
    // three springs that pull its axes to those of space
    let body = parsed(
        "parameters { pull = [1.0, 2.0, 4.0], torque = [0.0, 0.0, 0.0] }
         coordinates(x, r: rotation);
         let w = r.angular_velocity();
         lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + 0.5 * w[2].powi(2) + dot(x).powi(2) / 2 - x.powi(2) / 2
             + pull[0] * (r * [1, 0, 0])[0] + pull[1] * (r * [0, 1, 0])[1] + pull[2] * (r * [0, 0, 1])[2];
         external_forces = (0, torque);",
    );
    let search = EquilibriumSearch::new(&body);
    let guess = |turn: Vector| [&[0.3][..], &turned([1.0, 0.0, 0.0, 0.0], turn)].concat();
    let guesses = [
        guess([0.4, -0.5, 0.3]),
        guess([3.0, 0.2, -0.1]),
        guess([0.1, -0.2, 2.9]),
        guess([-0.1, 0.1, 0.0]),
    ];
    let found = search.near_all(&guesses).unwrap();
    let places: Vec<usize> = found
        .of_guess
        .iter()
        .map(|place| *place.as_ref().unwrap())
        .collect();
    assert_eq!(places, [0, 1, 2, 0]);
    let first = &found.equilibria[0];
    assert!(first.is_isolated());
    assert!(
        turn([1.0, 0.0, 0.0, 0.0], quaternion(&first.q, 1))
            .iter()
            .all(|x| x.abs() < 1e-14)
    );
    assert!((first.q[0]).abs() < 1e-14);
    // I ξ'' = -K ξ, where K has the sums of two
    let mut known: Vec<f64> = [(6.0_f64, 2.0), (5.0, 1.5), (3.0, 1.0), (1.0, 1.0)]
        .iter()
        .map(|(stiffness, inertia): &(f64, f64)| (stiffness / inertia).sqrt())
        .collect();
    known.sort_by(f64::total_cmp);
    let mut found_rates: Vec<f64> = first
        .eigenvalues()
        .unwrap()
        .iter()
        .map(|[_, im]| im.abs())
        .collect();
    found_rates.sort_by(f64::total_cmp);
    for (pair, known) in found_rates.chunks(2).zip(known) {
        assert!(
            (pair[0] - known).abs() < 1e-10 && (pair[1] - known).abs() < 1e-10,
            "{pair:?} {known}"
        );
    }
    for other in &found.equilibria[1..] {
        assert_eq!(other.stability().unwrap(), Stability::Unstable);
    }
    // the torques that hold an attitude: the opposites of the springs'
    let kernel: &dyn Kernel = &body;
    let torques: Vec<String> = kernel.shape().parameters[3..6]
        .iter()
        .map(|own| own.name.to_string())
        .collect();
    let q = guess([0.4, -0.5, 0.3]);
    let held = search.clone().held(["r"]).free(torques).near(&q).unwrap();
    let own = quaternion(&q, 1);
    let pulls = [1.0, 2.0, 4.0];
    let mut torque = [0.0; 3];
    for (k, size) in pulls.into_iter().enumerate() {
        let axis: Vector = core::array::from_fn(|i| f64::from(u8::from(i == k)));
        let pull = cross(axis, in_body_frame(own, axis)).map(|x| size * x);
        torque = [0, 1, 2].map(|i| torque[i] - pull[i]);
    }
    for (found, torque) in held.parameters[3..].iter().zip(torque) {
        assert!((found - torque).abs() < 1e-12, "{found} {torque}");
    }
    for (held, own) in held.q[1..].iter().zip(own) {
        assert!((held - own).abs() < 1e-15);
    }
    let error = search.held(["r_x"]).near(&q).unwrap_err();
    assert!(
        matches!(&error, EquilibriumError::Name { known, .. } if known == &["x", "r"]),
        "{error}"
    );
}

#[test]
fn a_top_hangs_in_all_directions() {
    let top = parsed(TOP);
    let start = |turn: Vector| turned([1.0, 0.0, 0.0, 0.0], turn);
    let guesses = [
        start([2.5, 0.4, 0.3]),
        start([2.6, -1.0, 0.9]),
        start([0.2, 0.1, 0.3]),
        start([-0.1, 0.1, 1.3]),
    ];
    let found = EquilibriumSearch::new(&top).near_all(guesses).unwrap();
    let places: Vec<usize> = found
        .of_guess
        .iter()
        .map(|place| *place.as_ref().unwrap())
        .collect();
    assert_eq!(places, [0, 0, 1, 1]);
    let length = ARM.iter().map(|x| x * x).sum::<f64>().sqrt();
    for (found, sign, stability) in [
        (&found.equilibria[0], -1.0, Stability::Undecided),
        (&found.equilibria[1], 1.0, Stability::Unstable),
    ] {
        let vertical = in_body_frame(quaternion(&found.q, 0), [0.0, 0.0, 1.0]);
        for k in 0..3 {
            assert!((vertical[k] - sign * ARM[k] / length).abs() < 1e-12);
        }
        // it may be turned about the vertical
        let [direction] = &found.directions[..] else {
            panic!("{:?}", found.directions)
        };
        let along: f64 = (0..3).map(|k| direction[k + 1] * vertical[k]).sum();
        assert!((along.abs() - 1.0).abs() < 1e-9, "{direction:?}");
        assert_eq!(direction[0].to_bits(), 0.0_f64.to_bits());
        assert_eq!(found.stability().unwrap(), stability);
    }
    let long = EquilibriumSearch::new(&top)
        .near([1.0, 0.1, 0.0, 0.0])
        .unwrap_err();
    println!("{long}");
    assert!(matches!(long, EquilibriumError::Setup(_)));
}

/// Where a drag of the form |v| v has no derivative at rest, the linear model and the series are refused with
/// an error that names the expression.
#[test]
fn what_has_no_derivative_at_rest_is_named() {
    let body = parsed(
        "coordinates(r: rotation, x: [3]);
         lagrangian = r.angular_velocity().norm_squared() + dot(x).norm_squared() / 2 - x[2];
         external_forces = (0, -dot(x).norm() * (r * (r.inverse() * dot(x))));",
    );
    let start = |speed: f64| {
        AnyStart::second_order(
            &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            &[0.0, 0.0, 0.0, speed, 0.0, 0.0],
        )
    };
    let linear = OperatingPoint::new(&body, start(0.0)).continuous().unwrap_err();
    let mut flow = AnyTaylorFlow::of_tape(&body, &start(0.0), Tolerance::relative(1e-9));
    let series = match &mut flow {
        Ok(flow) => (flow as &mut dyn Run).to(0.1).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    };
    for message in [linear.to_string(), series] {
        assert!(
            message.contains("dot(x_0).powi(2)")
                && message.contains(".sqrt()` has no derivative there (dot(x_0) = 0"),
            "{message}"
        );
    }
    assert!(OperatingPoint::new(&body, start(0.1)).continuous().is_ok());
}
