//! Random chains of rigid bodies in space, against the equations of Newton and Euler for each body with the
//! forces of its joints.
//!
//! A ball joint joins each body to the one above, the first to a fixed point; a torque against the relative
//! angular velocity brakes each joint. A declaration has the attitudes alone, or also the centres of mass,
//! with the joints as constraints.

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::{TapeKernel, Text};
use dsocs_core::{AnyFlow, AnyStart, OwnedNode, Run, Tolerance};
use proptest::prelude::*;

use crate::draws;
use dsocs_tests::dop853;
use dsocs_tests::scenes::elimination::Decomposed;
use dsocs_tests::vectors::{Matrix, Vector, cross, matrix, plus, product, rate, times, transposed, unit};

/// A body.
#[derive(Clone, Debug)]
struct Body {
    mass: f64,
    /// The moments of inertia about the centre of mass, in its frame.
    inertia: Matrix,
    /// From the centre of mass to the joint above and to the one below, in its frame.
    joints: [Vector; 2],
    /// The attitude and the angular velocity at the start.
    start: ([f64; 4], Vector),
}

/// A chain.
#[derive(Clone, Debug)]
struct Chain {
    bodies: Vec<Body>,
    gravity: Vector,
    brake: f64,
}

/// Numbers per body in a state: four of the quaternion and three of the angular velocity.
const NUMBERS: usize = 7;

impl Chain {
    /// Attitude and angular velocity of each body of a state.
    fn states(state: &[f64]) -> Vec<([f64; 4], Vector)> {
        let (states, _) = state.as_chunks::<NUMBERS>();
        states
            .iter()
            .map(|&[w, x, y, z, a, b, c]| ([w, x, y, z], [a, b, c]))
            .collect()
    }

    /// The rate of a state: for each body `m c'' = m g + F_i - F_{i+1}` and `I w' + w × I w = a × F_i - b × F_{i+1} + torques`, and at each joint the same
    /// acceleration of both bodies, solved for all accelerations and forces at once.
    fn rate<const S: usize>(&self, state: &[f64; S]) -> [f64; S] {
        let states = Self::states(state);
        let count = self.bodies.len();
        let attitudes: Vec<Matrix> = states.iter().map(|(q, _)| matrix(*q)).collect();
        let (mut equations, mut right) = (vec![vec![0.0; 9 * count]; 9 * count], vec![0.0; 9 * count]);
        // of each body: the acceleration of its centre, its angular acceleration, the force of the joint above
        let place = |body: usize, kind: usize| 9 * body + 3 * kind;
        // the acceleration of a body's point is `c'' + R (w' × p)` and known terms
        let swing = |body: usize, p: Vector| {
            let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            transposed(&columns.map(|axis| product(&attitudes[body], cross(axis, p))))
        };
        let known = |body: usize, p: Vector| {
            let w = states[body].1;
            product(&attitudes[body], cross(w, cross(w, p)))
        };
        for (i, body) in self.bodies.iter().enumerate() {
            let (w, r) = (states[i].1, &attitudes[i]);
            let [above, below] = body.joints;
            let mut torque = cross(product(&body.inertia, w), w);
            // the brake of the joint above, and the reaction of the joint below
            let in_space = |i: usize| product(&attitudes[i], states[i].1);
            let over = if i == 0 { [0.0; 3] } else { in_space(i - 1) };
            let mut brake = times(-self.brake, plus(in_space(i), times(-1.0, over)));
            if i + 1 < count {
                brake = plus(
                    brake,
                    times(self.brake, plus(in_space(i + 1), times(-1.0, in_space(i)))),
                );
            }
            torque = plus(torque, product(&transposed(r), brake));
            let (swings, knowns) = (swing(i, above), known(i, above));
            let upper = i.checked_sub(1).map(|upper| {
                let joint = self.bodies[upper].joints[1];
                (swing(upper, joint), known(upper, joint))
            });
            for row in 0..3 {
                let newton = &mut equations[place(i, 0) + row];
                newton[place(i, 0) + row] = body.mass;
                newton[place(i, 2) + row] = -1.0;
                if i + 1 < count {
                    newton[place(i + 1, 2) + row] = 1.0;
                }
                right[place(i, 0) + row] = body.mass * self.gravity[row];
                let euler = &mut equations[place(i, 1) + row];
                for column in 0..3 {
                    euler[place(i, 1) + column] = body.inertia[row][column];
                    let force = transposed(r).map(|line| line[column]);
                    euler[place(i, 2) + column] -= cross(above, force)[row];
                    if i + 1 < count {
                        euler[place(i + 1, 2) + column] += cross(below, force)[row];
                    }
                }
                right[place(i, 1) + row] = torque[row];
                let joint = &mut equations[place(i, 2) + row];
                joint[place(i, 0) + row] = 1.0;
                for column in 0..3 {
                    joint[place(i, 1) + column] = swings[row][column];
                }
                right[place(i, 2) + row] = -knowns[row];
                if let Some((swings, knowns)) = &upper {
                    joint[place(i - 1, 0) + row] = -1.0;
                    for column in 0..3 {
                        joint[place(i - 1, 1) + column] = -swings[row][column];
                    }
                    right[place(i, 2) + row] += knowns[row];
                }
            }
        }
        let solution = Decomposed::new(equations).unwrap().solve(&right);
        let mut rates = [0.0; S];
        for (i, (q, w)) in states.into_iter().enumerate() {
            rates[NUMBERS * i..NUMBERS * i + 4].copy_from_slice(&rate(q, w));
            rates[NUMBERS * i + 4..NUMBERS * (i + 1)]
                .copy_from_slice(&solution[place(i, 1)..place(i, 1) + 3]);
        }
        rates
    }

    /// The states of the bodies at a time, by DOP853.
    fn by_hand<const S: usize>(&self, until: f64) -> Vec<([f64; 4], Vector)> {
        let mut state = [0.0; S];
        for (body, numbers) in self.bodies.iter().zip(state.as_chunks_mut::<NUMBERS>().0) {
            let ([w, x, y, z], [a, b, c]) = body.start;
            *numbers = [w, x, y, z, a, b, c];
        }
        let end = dop853::integrate_from(|_, state| self.rate(&state), (0.0, state), until, 1e-13);
        Self::states(&end)
    }

    /// Position and velocity of a declaration: of each body its attitude and, if it `has_places`, its centre of mass.
    fn start(&self, has_places: bool) -> AnyStart {
        let (mut q0, mut v0) = (Vec::new(), Vec::new());
        let mut joint = ([0.0; 3], [0.0; 3]);
        for body in &self.bodies {
            let (q, w) = body.start;
            let at = |p: Vector| (product(&matrix(q), p), product(&matrix(q), cross(w, p)));
            let (above, below) = (at(body.joints[0]), at(body.joints[1]));
            let place = plus(joint.0, times(-1.0, above.0));
            let velocity = plus(joint.1, times(-1.0, above.1));
            q0.extend(q);
            v0.extend([&[0.0], w.as_slice()].concat());
            if has_places {
                q0.extend(place);
                v0.extend(velocity);
            }
            joint = (plus(place, below.0), plus(velocity, below.1));
        }
        AnyStart::second_order(&q0, &v0)
    }

    /// Sets the parameters of a declaration to the chain.
    fn set(&self, system: &mut TapeKernel) {
        let bodies = self.bodies.iter().flat_map(|body| {
            let [above, below] = body.joints;
            [&[body.mass], body.inertia.as_flattened(), &above, &below].concat()
        });
        let values = self.gravity.into_iter().chain([self.brake]).chain(bodies);
        for (place, value) in values.enumerate() {
            *system.parameter_mut(place).unwrap() = value;
        }
    }
}

/// The declaration of a chain of so many bodies.
fn declared(count: usize, has_places: bool) -> Text {
    let each = |of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<Vec<_>>();
    let parameters = each(&|i| {
        format!(
            "mass{i} = 1.0, inertia{i} = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], above{i} = [0.0, 0.0, 1.0], below{i} = [0.0, 0.0, 1.0]"
        )
    });
    let coordinates = each(&|i| {
        if has_places {
            format!("r{i}: rotation, x{i}: [3]")
        } else {
            format!("r{i}: rotation")
        }
    });
    let joint = |i: usize| match i {
        0 => "[0, 0, 0]".to_owned(),
        _ => format!("(x{} + r{} * below{})", i - 1, i - 1, i - 1),
    };
    let places = each(&|i| {
        if has_places {
            String::new()
        } else {
            format!("let x{i} = {} - r{i} * above{i};", joint(i))
        }
    });
    let rows = each(&|i| format!("x{i} + r{i} * above{i} - {}", joint(i)));
    let energies = each(&|i| {
        format!(
            "r{i}.angular_velocity().inner(inertia{i} * r{i}.angular_velocity()) / 2 + mass{i} * dot(x{i}).norm_squared() / 2 + mass{i} * gravity.inner(x{i})"
        )
    });
    let spin = |i: usize| format!("r{i} * r{i}.angular_velocity()");
    let torques = each(&|i| {
        let over = if i == 0 {
            "[0, 0, 0]".to_owned()
        } else {
            spin(i - 1)
        };
        let below = if i + 1 < count {
            format!(" + {} - {}", spin(i + 1), spin(i))
        } else {
            String::new()
        };
        let torque = format!("brake * (r{i}.inverse() * ({over} - {}{below}))", spin(i));
        if has_places {
            format!("{torque}, [0, 0, 0]")
        } else {
            torque
        }
    });
    let bound = if has_places {
        format!("holonomic = [{}];", rows.join(", "))
    } else {
        String::new()
    };
    let text = format!(
        "parameters {{ gravity = [0.0, 0.0, -9.81], brake = 0.1, {} }}
         coordinates({});
         {}
         lagrangian = {};
         external_forces = ({},);
         {bound}",
        parameters.join(", "),
        coordinates.join(", "),
        places.join("\n"),
        energies.join(" + "),
        torques.join(", "),
    );
    Text::parse("chain", &text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Mass, moments of inertia, a matrix whose squares are added to these, joints, attitude and angular
/// velocity.
type RandomBody = (f64, Vector, Matrix, [Vector; 2], ([f64; 4], Vector));

/// Chains of so many bodies.
fn chains(count: usize) -> BoxedStrategy<Chain> {
    let number = || -1.0..1.0;
    let vector = move || prop::array::uniform3(number());
    let body = (
        0.3..2.0,
        prop::array::uniform3(0.1..1.0),
        prop::array::uniform3(vector()),
        prop::array::uniform2(vector()),
        (prop::array::uniform4(number()), vector()),
    );
    let body = body.prop_map(|(mass, moments, lever, joints, (q, w)): RandomBody| {
        // the inertia of masses at a distance: the squares of a matrix, and a least value
        let inertia = [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| {
                let sum: f64 = (0..3).map(|k| lever[i][k] * lever[j][k]).sum();
                0.2 * sum + if i == j { moments[i] } else { 0.0 }
            })
        });
        let q = if q.iter().all(|q| q.abs() < 0.1) {
            [1.0, 0.0, 0.0, 0.0]
        } else {
            q
        };
        Body {
            mass,
            inertia,
            joints,
            start: (unit(q), times(2.0, w)),
        }
    });
    (prop::collection::vec(body, count), vector(), 0.0..0.3)
        .prop_map(|(bodies, gravity, brake)| Chain {
            bodies,
            gravity: times(9.81, gravity),
            brake,
        })
        .boxed()
}

/// The largest deviation of attitudes (up to the quaternion's sign) and angular velocities from known ones;
/// `apart` is the number of coordinates per body.
fn distance(node: &OwnedNode, known: &[([f64; 4], Vector)], apart: usize) -> f64 {
    let node = node.any();
    let of_body = |(i, (q, w)): (usize, &([f64; 4], Vector))| {
        let (found, spin) = (&node.q[apart * i..], &node.v[apart * i + 1..]);
        let sign = found
            .iter()
            .zip(q)
            .map(|(found, q)| found * q)
            .sum::<f64>()
            .signum();
        let of_q = found.iter().zip(q).map(|(found, q)| (sign * found - q).abs());
        let of_w = spin.iter().zip(w).map(|(found, w)| (found - w).abs());
        of_q.chain(of_w).fold(0.0, f64::max)
    };
    known.iter().enumerate().map(of_body).fold(0.0, f64::max)
}

/// Checks random chains of this length against their equations.
fn assert_agreement<const S: usize>(cases: u32, has_places: bool) {
    const UNTIL: f64 = 0.5;
    let count = S / NUMBERS;
    let text = declared(count, has_places);
    let apart = if has_places { 7 } else { 4 };
    draws::test(
        cases,
        S as u64 + u64::from(has_places),
        chains(count),
        &move |chain| {
            let mut system = text.system.clone();
            chain.set(&mut system);
            let known = chain.by_hand::<S>(UNTIL);
            let start = chain.start(has_places);
            let mut node = OwnedNode::new(apart * count);
            let mut series = AnyTaylorFlow::of_tape(&system, &start, Tolerance::relative(1e-14)).unwrap();
            let run: &mut dyn Run = &mut series;
            run.to(UNTIL).unwrap();
            node.take(run);
            let of_series = distance(&node, &known, apart);
            prop_assert!(of_series < 1e-10, "the Taylor series: {of_series:e}");
            let mut errors = [0.0; 2];
            for (error, steps) in errors.iter_mut().zip([400.0, 800.0]) {
                let mut flow = AnyFlow::new(&system, UNTIL / steps, &start).unwrap();
                flow.run_mut().to(UNTIL).unwrap();
                node.take(flow.run());
                *error = distance(&node, &known, apart);
            }
            let order = (errors[0] / errors[1]).log2();
            prop_assert!((order - 2.0).abs() < 0.05, "order {order}: {errors:?}");
            Ok(())
        },
    );
}

#[test]
fn chains_of_attitudes_move_as_newton_and_euler_say() {
    assert_agreement::<7>(10, false);
    assert_agreement::<14>(10, false);
    assert_agreement::<21>(5, false);
}

#[test]
fn chains_with_joints_as_constraints_move_as_newton_and_euler_say() {
    assert_agreement::<7>(5, true);
    assert_agreement::<14>(8, true);
    assert_agreement::<21>(8, true);
    assert_agreement::<28>(4, true);
}
