//! Inputs, that is parameters that change at nodes and are held between, against the continuous motion.

use dsocs_core::prelude::*;
use dsocs_core::{Composition, InputError};
use dsocs_systems::InertiaWheelPendulum;
use dsocs_tests::declared;
use dsocs_tests::fit::slope;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::{ComposedFlow, Flow, System, TaylorFlow};

use dsocs_tests::dop853;

declared! {
    /// An oscillator with a cubic friction, pushed.
    #[derive(Clone)]
    struct Pushed {
        u: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    external_forces = u - 0.2 * dot(x).powi(3);
}

declared! {
    /// The pushed mass with the midpoint.
    #[derive(Clone)]
    struct PushedMidpoint {
        u: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
    external_forces = u - 0.2 * dot(x).powi(3);
    phi_lagrangian = midpoint;
}

declared! {
    /// The pushed mass with the push as a potential.
    #[derive(Clone)]
    struct PushedByPotential {
        u: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2 + u * x;
    external_forces = -0.2 * dot(x).powi(3);
}

declared! {
    /// A variable mass: its momentum is continuous, its velocity jumps.
    #[derive(Clone)]
    struct Loaded {
        u: f64,
    }
    coordinates(x);
    lagrangian = (1 + 0.3 * u) * dot(x).powi(2) / 2 - x.powi(4) / 4;
}

declared! {
    /// A particle whose curvature is steered.
    #[derive(Clone)]
    struct Steered {
        u: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - u;
    variational = [(dot(x), dot(y))];
}

declared! {
    /// A mass with friction on the ground.
    #[derive(Clone)]
    struct Rubbed {
        u: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 + (x / 3).cos();
    external_forces = u - 0.6 * dot(x).signum();
}

declared! {
    /// A law in which the input multiplies the acceleration.
    #[derive(Clone)]
    struct Geared {
        u: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
    kinematic = (1 + u) * ddot(x) - y + 0.3 * dot(x);
    variational = [(0, 1)];
}

declared! {
    /// A row that is not affine in the acceleration.
    #[derive(Clone)]
    struct Bent {
        u: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y * x;
    kinematic = ddot(x) + 0.1 * ddot(x).powi(3) - (2 + u) * y.cos();
    constraint_forces = [(1, 0.2)];
}

declared! {
    /// A knife edge with a motor about its axis, and a kinematic row beside the nonholonomic one.
    #[derive(Clone)]
    struct Edge {
        u: f64,
    }
    coordinates(x, y, theta, z);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(theta).powi(2) + dot(z).powi(2)) / 2 - z.powi(2);
    nonholonomic = dot(x) * theta.sin() - dot(y) * theta.cos();
    kinematic = ddot(z) + 0.1 * ddot(z).powi(3) + dot(z) - u;
    constraint_forces = [(0, 0, 0, 1)];
    external_forces = (0.3 * theta.cos(), 0.3 * theta.sin(), u, 0);
}

declared! {
    /// A car with a wheel at each end, whose front wheel is steered at once: the velocity jumps.
    #[derive(Clone)]
    struct Car {
        u: f64,
    }
    coordinates(x, y, theta);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 0.2 * dot(theta).powi(2) - 0.5 * y;
    nonholonomic = [
        dot(x) * theta.sin() - dot(y) * theta.cos(),
        dot(x) * (theta + u).sin() - dot(y) * (theta + u).cos() - 0.7 * dot(theta) * u.cos(),
    ];
}

/// The value of the input from the time `0.1 k` on.
fn u(k: u64) -> f64 {
    (0.7 * k as f64).sin()
}

/// The time for which a value is held.
const HELD: f64 = 0.1;

/// The number of held values.
const CHANGES: u64 = 20;

/// The orders of position and (arriving) velocity at a change, against the continuous motion with the same
/// inputs.
fn order<S: System<N>, const N: usize>(
    of: impl Fn(f64) -> S,
    q0: [f64; N],
    v0: [f64; N],
) -> [(f64, Vec<f64>); 2] {
    let start = Start::second_order(q0, v0);
    let system = of(0.0);
    let mut exact = TaylorFlow::new(&system, start, Tolerance::relative(1e-15))
        .unwrap()
        .every(HELD)
        .unwrap();
    for k in 0..CHANGES {
        exact.set_input("u", u(k)).unwrap();
        exact.advance().unwrap();
    }
    let exact = exact.node();
    assert!((exact.t - HELD * CHANGES as f64).abs() < 1e-12);
    let parts = [8, 16, 32, 64];
    let errors: Vec<[f64; 2]> = parts
        .iter()
        .map(|&parts| {
            let system = of(u(0));
            let mut flow = Flow::new(&system, HELD / parts as f64, start).unwrap();
            while flow.index() <= CHANGES * parts {
                let now = flow.index() / parts;
                flow.set_input("u", u(now)).unwrap();
                assert_eq!(flow.input("u"), Some(u(now)));
                flow.advance().unwrap();
            }
            let node = flow.node();
            assert!((node.t - exact.t).abs() < 1e-12);
            [(&node.q, &exact.q), (&node.v, &exact.v)].map(|(own, exact)| {
                let apart = own.iter().zip(exact);
                apart.map(|(x, exact)| (x - exact).powi(2)).sum::<f64>().sqrt()
            })
        })
        .collect();
    let steps = parts.map(|parts| HELD / parts as f64);
    [0, 1].map(|k| {
        let errors: Vec<f64> = errors.iter().map(|errors| errors[k]).collect();
        (slope(&steps, &errors), errors)
    })
}

#[test]
fn a_change_keeps_the_order() {
    let found = [
        ("pushed", order(|u| Pushed { u }, [1.0], [0.3])),
        ("by the midpoint", order(|u| PushedMidpoint { u }, [1.0], [0.3])),
        ("by a potential", order(|u| PushedByPotential { u }, [1.0], [0.3])),
        ("loaded", order(|u| Loaded { u }, [1.0], [0.3])),
        ("rubbed", order(|u| Rubbed { u }, [0.0], [4.0])),
        ("steered", order(|u| Steered { u }, [0.0; 2], [1.0, 0.2])),
        ("geared", order(|u| Geared { u }, [0.0, 1.0], [1.0, 0.2])),
        ("bent", order(|u| Bent { u }, [0.0, 0.1], [1.0, 0.2])),
        (
            "edge",
            order(
                |u| Edge { u },
                [0.0, 0.0, 0.3, 0.2],
                [0.3_f64.cos(), 0.3_f64.sin(), 0.4, 0.1],
            ),
        ),
        ("car", order(|u| Car { u }, [0.0; 3], [1.0, 0.0, 0.0])),
    ];
    for (name, orders) in found {
        for (order, errors) in orders {
            println!("{name}: order {order:.3}, errors {errors:?}");
            assert!((order - 2.0).abs() < 0.05, "{name}: {order}, {errors:?}");
        }
    }
}

#[test]
fn the_energy_at_a_change_is_that_with_which_the_motion_arrives() {
    let start = Start::second_order([1.0], [0.3]);
    let system = Loaded { u: 0.0 };
    let mut flow = Flow::new(&system, 0.01, start).unwrap();
    let mut exact = TaylorFlow::new(&system, start, Tolerance::relative(1e-13))
        .unwrap()
        .every(0.01)
        .unwrap();
    for k in 0..50 {
        // a value that is set on a flow holds from its next node on
        let value = u(k / 5);
        flow.set_input("u", value).unwrap();
        for run in [&mut flow as &mut dyn Stepper<1>, &mut exact] {
            run.advance().unwrap();
        }
        assert!((flow.node().energy - exact.node().energy).abs() < 1e-4, "{k}");
        exact.set_input("u", value).unwrap();
    }
}

declared! {
    /// A mass drawn along a blade; the mass, and the slope and the speed of the blade, are inputs.
    #[derive(Clone)]
    struct Blade {
        m: f64,
        slope: f64,
        speed: f64,
        pull: f64,
    }
    coordinates(x, y);
    lagrangian = m * dot(x).powi(2) / 2 + dot(y).powi(2) / 2;
    external_forces = (pull, 0);
    nonholonomic = dot(y) - slope * dot(x) - speed;
}

/// Momentum changes along the constraint's force only, from the values before all changes at a node, in
/// whatever order these are set.
#[test]
fn several_inputs_at_a_node_are_one_change() {
    let mut random = Random::new(31);
    for draw in 0..20 {
        let mut drawn = || {
            [
                random.between(0.5, 2.0),
                random.between(-1.0, 1.0),
                random.between(-1.0, 1.0),
            ]
        };
        let [before, after] = [drawn(), drawn()];
        let [m, slope, speed] = before;
        let blade = Blade {
            m,
            slope,
            speed,
            pull: 0.0,
        };
        let v = [0.7, slope * 0.7 + speed];
        let [new, slope, speed] = after;
        // (new vx, vy) = (m vx, vy) + λ (-slope, 1), on the new constraint
        let impulse = (speed - v[1] + slope * m * v[0] / new) / (1.0 + slope * slope / new);
        let expected = [(m * v[0] - slope * impulse) / new, v[1] + impulse];
        let start = Start::second_order([0.0, 0.0], v);
        for places in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
            let run = |inputs: &mut dyn Inputs<2>| {
                for _ in 0..3 {
                    inputs.advance().unwrap();
                }
                for place in places {
                    inputs
                        .set_input(["m", "slope", "speed"][place], after[place])
                        .unwrap();
                }
                for _ in 0..3 {
                    inputs.advance().unwrap();
                }
                inputs.node().v
            };
            let ends = [
                run(&mut Flow::new(&blade, 0.1, start).unwrap()),
                run(&mut TaylorFlow::new(&blade, start, Tolerance::relative(1e-12))
                    .unwrap()
                    .every(0.1)
                    .unwrap()),
            ];
            for found in ends {
                let apart = (found[0] - expected[0]).abs().max((found[1] - expected[1]).abs());
                assert!(apart < 1e-11, "{draw} {places:?}: {found:?} {expected:?}");
            }
        }
    }
}

/// A reversed run counts its nodes from zero, so the index of an earlier change must not be used.
#[test]
fn an_input_after_turning_round_leaves_the_position() {
    let system = PushedByPotentialAlone { u: 0.0 };
    let start = Start::second_order([1.0], [0.3]);
    let mut composed = ComposedFlow::new(&system, 0.1, Composition::SUZUKI_4, start).unwrap();
    let mut series = TaylorFlow::new(&system, start, Tolerance::relative(1e-12))
        .unwrap()
        .every(0.1)
        .unwrap();
    for run in [&mut composed as &mut dyn Inputs<1>, &mut series] {
        run.set_input("u", 0.7).unwrap();
        for _ in 0..5 {
            run.advance().unwrap();
        }
        let before = run.node();
        run.reverse().unwrap();
        run.set_input("u", -0.4).unwrap();
        let after = run.node();
        assert!(
            (before.q[0] - after.q[0]).abs() < 1e-14 && (before.v[0] - after.v[0]).abs() < 1e-14,
            "{before:?} {after:?}"
        );
    }
}

declared! {
    /// A law between two free masses; its coefficient and one mass are inputs.
    #[derive(Clone)]
    struct Law {
        m: f64,
        a: f64,
    }
    coordinates(x, y);
    lagrangian = m * dot(x).powi(2) / 2 + dot(y).powi(2) / 2;
    kinematic = ddot(x) + a * ddot(y);
    constraint_forces = [(1, 0.5)];
}

/// Mass and law change at one node. The velocity jumps by `Δv` with `∂c/∂a Δv = 0`, `∂c/∂a` the mean of the
/// old and the new row: the limit of a steep, steady change.
#[test]
fn a_mass_and_the_law_may_change_at_once() {
    let mut random = Random::new(5);
    for draw in 0..12 {
        let [m, new] = [0, 1].map(|_| random.between(0.5, 2.5));
        let [a, other] = [0, 1].map(|_| random.between(-0.8, 1.5));
        let law = Law { m, a };
        let (v, mean) = ([1.0, 0.4], 0.5 * (a + other));
        // new vx - m 1 = J, vy - 0.4 = J / 2, (vx - 1) + mean (vy - 0.4) = 0
        let impulse = (new - m) / (1.0 + 0.5 * mean * new);
        let expected = [(m + impulse) / new, 0.4 + 0.5 * impulse];
        let start = Start::second_order([0.0, 0.0], v);
        for places in [[0, 1], [1, 0]] {
            let run = |inputs: &mut dyn Inputs<2>| {
                for _ in 0..3 {
                    inputs.advance().unwrap();
                }
                for place in places {
                    inputs.set_input(["m", "a"][place], [new, other][place]).unwrap();
                }
                for _ in 0..3 {
                    inputs.advance().unwrap();
                }
                inputs.node().v
            };
            let ends = [
                run(&mut Flow::new(&law, 0.1, start).unwrap()),
                run(&mut ComposedFlow::new(&law, 0.1, Composition::SUZUKI_4, start).unwrap()),
                run(&mut TaylorFlow::new(&law, start, Tolerance::relative(1e-12))
                    .unwrap()
                    .every(0.1)
                    .unwrap()),
            ];
            for found in ends {
                let apart = (found[0] - expected[0]).abs().max((found[1] - expected[1]).abs());
                assert!(apart < 1e-10, "{draw} {places:?}: {ends:?} {expected:?}");
            }
        }
    }
}

/// At the node where the blade turns the force is that of the old slope: `m ẍ = pull − λ slope`, `ÿ = λ = slope ẍ`.
#[test]
fn forces_and_multipliers_at_a_change_are_those_with_which_the_motion_arrives() {
    let blade = Blade {
        m: 2.0,
        slope: 0.4,
        speed: 0.1,
        pull: 1.3,
    };
    let slopes = [0.4, -1.7, 0.9, 0.2];
    let mut flow = Flow::new(&blade, 0.05, Start::second_order([0.0, 0.0], [1.0, 0.5])).unwrap();
    for (before, after) in slopes.iter().zip(&slopes[1..]) {
        // holds from the next node on
        flow.set_input("slope", *after).unwrap();
        flow.advance().unwrap();
        let node = flow.node();
        let expected = before * 1.3 / (2.0 + before * before);
        let found = flow.multipliers(&node)[0];
        assert!((found - expected).abs() < 1e-10, "{before}: {found} {expected}");
        assert!(
            (node.force[0] + before * expected).abs() < 1e-10 && (node.force[1] - expected).abs() < 1e-10
        );
        for _ in 0..3 {
            flow.advance().unwrap();
        }
    }
}

declared! {
    /// A car that keeps its speed by a law; its curvature is an input.
    #[derive(Clone)]
    struct Driven {
        k: f64,
    }
    coordinates(x, y, heading);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 0.2 * dot(heading).powi(2) / 2;
    let speed = dot(x) * heading.cos() + dot(y) * heading.sin();
    nonholonomic = [dot(x) * heading.sin() - dot(y) * heading.cos(), dot(heading) - k * speed];
    kinematic = dot(speed);
    constraint_forces = [(heading.cos(), heading.sin(), 0)];
}

/// On a straight line no force is needed: multipliers are rounding, and may decide nothing.
#[test]
fn a_wheel_may_be_set_straight() {
    for k in [0.0, 1e-12, 1e-6] {
        for h in [0.1, 0.05, 0.01] {
            let car = Driven { k: 0.2 };
            let mut flow = Flow::new(&car, h, Start::second_order([0.0; 3], [1.0, 0.0, 0.2])).unwrap();
            flow.to(1.0 - 0.9 * h).unwrap();
            flow.set_input("k", k).unwrap();
            let end = flow.to(2.0).unwrap();
            // an arc, and what is nearly a line
            let expected = [
                5.0 * 0.2_f64.sin() + 0.2_f64.cos(),
                5.0 * (1.0 - 0.2_f64.cos()) + 0.2_f64.sin(),
                0.2,
            ];
            for (found, expected) in end.q.iter().zip(expected) {
                assert!((found - expected).abs() < 0.02 * h * h + 2e-6, "{k} {h}: {end:?}");
            }
        }
    }
}

declared! {
    /// A mass on a belt whose speed is held.
    #[derive(Clone)]
    struct Conveyed {
        belt: f64,
        dry: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -dry * (dot(x) - belt).signum();
}

/// A mass at rest on the belt slips at once where the belt's velocity jumps; a slipping one may then slip to
/// the other side.
#[test]
fn a_belt_that_an_input_moves_keeps_the_order() {
    let belts = [0.0, 0.5, -0.3, 0.4, 0.45];
    let dry = 0.8;
    // the velocity goes to the belt's at a constant rate, in parts of one second and of half of one
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    let lengths = [1.0, 1.0, 0.5, 0.5, 1.0];
    for (belt, length) in belts.iter().zip(lengths) {
        let slips = (belt - v).abs() / dry;
        let slips = slips.min(length);
        let end = v + dry * slips * (belt - v).signum();
        x += 0.5 * (v + end) * slips + end * (length - slips);
        v = end;
    }
    for parts in [10, 14, 20, 50] {
        let h = 1.0 / f64::from(parts);
        let mass = Conveyed { belt: 0.0, dry };
        let mut flow = Flow::new(&mass, h, Start::second_order([0.0], [0.0])).unwrap();
        let mut t = 0.0;
        for (belt, length) in belts.iter().skip(1).zip(lengths) {
            t += length;
            flow.to(t - 0.9 * h).unwrap();
            flow.set_input("belt", *belt).unwrap();
        }
        let end = flow.to(4.0).unwrap();
        let apart = [(end.q[0] - x).abs(), (end.v[0] - v).abs()];
        assert!(apart.iter().all(|apart| *apart < 0.3 * h * h), "{h}: {apart:?}");
        assert_eq!(flow.unresolved(), None);
    }
}

/// The continuous motion under held inputs agrees with that of a solver to which they are a function of time.
#[test]
fn the_series_go_on_from_the_new_value() {
    let system = Pushed { u: 0.0 };
    let mut flow = TaylorFlow::new(
        &system,
        Start::second_order([1.0], [0.3]),
        Tolerance::relative(1e-15),
    )
    .unwrap()
    .every(HELD)
    .unwrap();
    let mut state = [1.0, 0.3];
    for k in 0..CHANGES {
        flow.set_input("u", u(k)).unwrap();
        flow.advance().unwrap();
        let rate = |_, [x, v]: [f64; 2]| [v, -x + u(k) - 0.2 * v.powi(3)];
        state = dop853::integrate(rate, state, HELD, 1e-14);
    }
    let node = flow.node();
    assert!(
        (node.q[0] - state[0]).abs() < 1e-13 && (node.v[0] - state[1]).abs() < 1e-13,
        "{node:?} {state:?}"
    );
}

/// A composed step keeps its order where inputs change at its nodes.
#[test]
fn a_composition_keeps_its_order() {
    let system = PushedByPotentialAlone { u: 0.0 };
    let start = Start::second_order([1.0], [0.3]);
    let run = |inputs: &mut dyn Inputs<1>, steps: u64| {
        for k in 0..CHANGES {
            inputs.set_input("u", u(k)).unwrap();
            for _ in 0..steps {
                inputs.advance().unwrap();
            }
        }
        inputs.node().q[0]
    };
    let mut exact = TaylorFlow::new(&system, start, Tolerance::relative(1e-16))
        .unwrap()
        .every(HELD)
        .unwrap();
    let exact = run(&mut exact, 1);
    let parts = [1, 2, 4];
    let errors = parts.map(|parts| {
        let h = HELD / parts as f64;
        let mut flow = ComposedFlow::new(&system, h, Composition::SUZUKI_4, start).unwrap();
        (run(&mut flow, parts) - exact).abs()
    });
    let order = slope(&parts.map(|parts| HELD / parts as f64), &errors);
    println!("order {order:.3}, errors {errors:?}");
    assert!((order - 4.0).abs() < 0.15, "{order}, {errors:?}");
}

declared! {
    /// A pendulum with a wheel, and a motor between them whose torque is an input.
    #[derive(Clone)]
    struct Motor {
        i: f64,
        j: f64,
        m: f64,
        torque: f64,
    }
    coordinates(theta, psi);
    lagrangian = i / 2 * dot(theta).powi(2) + j / 2 * (dot(theta) + dot(psi)).powi(2) - m * (1 + theta.cos());
    external_forces = (0, torque);
}

impl Motor {
    fn new(torque: f64) -> Self {
        let InertiaWheelPendulum { i, j, m, .. } = InertiaWheelPendulum::default();
        Self { i, j, m, torque }
    }
}

const Q0: [f64; 2] = [0.5, 0.0];
const V0: [f64; 2] = [0.0, 0.5];

/// The pendulum's own control law, sampled as held torques: the motion converges to the continuous one with the first order in
/// the sampling interval.
#[test]
fn a_sampled_control_law_is_of_first_order() {
    let pendulum = InertiaWheelPendulum::default();
    let law = |t: f64, q: [f64; 2], v: [f64; 2]| {
        let point = dsocs_core::geometry::motion(&pendulum, t, &q, &v).unwrap();
        dsocs_core::geometry::constraint_force(&pendulum, point.any())[1]
    };
    let end = 5.0;
    let start = Start::second_order(Q0, V0);
    let exact = TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-15))
        .unwrap()
        .to(end)
        .unwrap();
    let steps = [0.005, 0.0025, 0.00125, 0.000_625];
    let errors = steps.map(|h| {
        let motor = Motor::new(law(0.0, Q0, V0));
        let mut flow = Flow::new(&motor, h, start).unwrap();
        flow.drive(end, &mut |node, flow| {
            flow.set_input("torque", law(node.t, node.q, node.v))
        })
        .unwrap();
        (flow.node().q[0] - exact.q[0]).abs()
    });
    let order = slope(&steps, &errors);
    println!("order {order:.3}, errors {errors:?}");
    assert!((order - 1.0).abs() < 0.1, "{order}, {errors:?}");
}

/// The discrete motion's own torques, distributed to the legs, give the same nodes.
#[test]
fn the_discrete_torques_make_the_same_nodes() {
    let (pendulum, h) = (InertiaWheelPendulum::default(), 0.01);
    let nodes = Flow::new(&pendulum, h, Start::second_order(Q0, V0))
        .unwrap()
        .until(5.0)
        .unwrap()
        .nodes;
    // half of a leg's torque acts at each of its ends: `(p[k-1] + p[k]) / 2` is the torque at the node `k`
    let mut held = nodes[0].force[1];
    let motor = Motor::new(held);
    let mut flow = Flow::new(&motor, h, Start::nodes(nodes[0].q, nodes[1].q)).unwrap();
    for (k, node) in nodes.iter().enumerate().skip(1) {
        held = 2.0 * node.force[1] - held;
        flow.set_input("torque", held).unwrap();
        flow.advance().unwrap();
        assert_eq!(flow.node().index, k as u64);
        // without the constraint its force is zero
        assert!(
            flow.node().force.iter().all(|force| force.abs() < 1e-8),
            "{:?}",
            flow.node()
        );
    }
    let last = nodes[nodes.len() - 1].q;
    let found = flow.node().q;
    let apart = [found[0] - last[0], found[1] - last[1]];
    println!("{apart:?}");
    assert!(apart[0].abs() < 1e-9 && apart[1].abs() < 1e-7, "{apart:?}");
}

/// An input that is set to the value it has changes nothing, and a run back passes the changes as the run
/// did.
#[test]
fn there_and_back() {
    let system = Pushed { u: 0.5 };
    let start = Start::second_order([1.0], [0.3]);
    let plain = Flow::new(&system, 0.01, start).unwrap().to(1.0).unwrap();
    let mut idle = Flow::new(&system, 0.01, start).unwrap();
    idle.drive(1.0, &mut |_, run| run.set_input("u", 0.5)).unwrap();
    assert_eq!(idle.node(), plain);

    // turned round at the node of a change, and by inputs that are set back at the same nodes
    let frictionless = PushedByPotentialAlone { u: 0.5 };
    let mut flow = Flow::new(&frictionless, 0.01, start).unwrap();
    let first = *flow.position();
    for k in 0..40 {
        if k == 19 || k == 39 {
            let value = -flow.input("u").unwrap();
            flow.set_input("u", value).unwrap();
        }
        flow.advance().unwrap();
    }
    assert_eq!(flow.node().index, 40);
    flow.reverse().unwrap();
    for k in 1..40 {
        if k == 20 {
            flow.set_input("u", 0.5).unwrap();
        }
        flow.advance().unwrap();
    }
    assert!((flow.node().q[0] - first[0]).abs() < 1e-13, "{:?}", flow.node());
}

declared! {
    /// An oscillator with a stiffening spring, pushed by a potential.
    #[derive(Clone)]
    struct PushedByPotentialAlone {
        u: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - x.powi(4) / 4 + u * x;
}

declared! {
    /// A rod whose length is a parameter.
    #[derive(Clone)]
    struct Rod {
        length: f64,
        gravity: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
    holonomic = x.powi(2) + y.powi(2) - length.powi(2);
}

/// A parameter in a constraint on positions, an unknown name and values that are not finite are refused as
/// inputs, each with its own error.
#[test]
fn what_cannot_be_an_input() {
    let rod = Rod {
        length: 1.0,
        gravity: 9.81,
    };
    let mut flow = Flow::new(&rod, 0.01, Start::second_order([1.0, 0.0], [0.0, 0.5])).unwrap();
    let refused = |error| match error {
        Err(RunError::Input(error)) => *error,
        other => panic!("{other:?}"),
    };
    assert_eq!(
        refused(flow.set_input("length", 1.1)),
        InputError::Position {
            parameter: "length".into()
        }
    );
    assert_eq!(
        refused(flow.set_input("lenght", 1.1)),
        InputError::Unknown {
            parameter: "lenght".to_owned(),
            parameters: vec!["length".into(), "gravity".into()],
        }
    );
    assert!(matches!(
        refused(flow.set_input("gravity", f64::NAN)),
        InputError::NotFinite { parameter, .. } if parameter == "gravity"
    ));
    // a change of the weight does not move the rod
    flow.set_input("gravity", 1.62).unwrap();
    for _ in 0..100 {
        flow.advance().unwrap();
        let [x, y] = flow.node().q;
        assert!((x * x + y * y - 1.0).abs() < 1e-14);
    }
}
