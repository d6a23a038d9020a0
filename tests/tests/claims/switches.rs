//! Jumps and corners of a force: a Taylor series ends at each and starts anew beyond. The references are
//! closed forms.

use std::f64::consts::PI;

use dsocs_core::taylor::GlobalError;
use dsocs_core::{
    Event, Events, Inputs, Node, Occurrence, Real, RunError, Samples, SeriesFailure, Start, Stepper, Stop,
    Tolerance, dsocs, on_event,
};
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::{Flow, System, TaylorFlow};

/// A mass on a spring with dry friction.
#[dsocs {
    coordinates(x);
    lagrangian = mass / 2 * dot(x).powi(2) - stiffness / 2 * x.powi(2);
    external_forces = -dry * dot(x).signum();
}]
struct Friction {
    mass: f64,
    stiffness: f64,
    dry: f64,
}

impl Friction {
    /// The half period.
    fn half(&self) -> f64 {
        PI / (self.stiffness / self.mass).sqrt()
    }

    /// The position at a time and where a half-swing begins; `None` where the mass has come to rest. In each half-swing the amplitude
    /// drops by twice the friction over the stiffness.
    fn at(&self, start: f64, t: f64) -> Option<f64> {
        let (rate, rest) = (PI / self.half(), self.dry / self.stiffness);
        let (mut x, mut left) = (start, t);
        while x.abs() > rest {
            let middle = rest * x.signum();
            if left <= self.half() {
                return Some(middle + (x - middle) * (rate * left).cos());
            }
            (x, left) = (2.0 * middle - x, left - self.half());
        }
        None
    }

    /// The time at which the mass comes to rest, and its position there.
    fn rest(&self, start: f64) -> (f64, f64) {
        let rest = self.dry / self.stiffness;
        let (mut x, mut t) = (start, 0.0);
        while x.abs() > rest {
            x = 2.0 * rest * x.signum() - x;
            t += self.half();
        }
        (t, x)
    }

    /// The least distance of a turning point from the bound between sticking and going on, relative to that
    /// bound.
    fn doubt(&self, start: f64) -> f64 {
        let rest = self.dry / self.stiffness;
        let (mut x, mut least) = (start.abs(), f64::INFINITY);
        while x > -rest {
            least = least.min((x.abs() / rest - 1.0).abs());
            x -= 2.0 * rest;
        }
        least
    }
}

fn flow<S: System<1>>(system: &S, start: [f64; 2], tolerance: f64) -> TaylorFlow<'_, 1> {
    let [q, v] = start;
    TaylorFlow::new(
        system,
        Start::second_order([q], [v]),
        Tolerance::relative(tolerance),
    )
    .unwrap()
}

/// The time at which a motion comes to rest before `until`, and its position there; it must stay.
fn comes_to_rest(run: &mut TaylorFlow<'_, 1>, until: f64) -> (f64, f64) {
    let rest = loop {
        let node = run.node();
        let before = (node.t, node.q[0]);
        let report = run.advance().unwrap();
        if report.stop == Stop::Sticks {
            break before;
        }
        assert!(run.node().t < until, "{run:?}");
    };
    let node = run.to(f64::max(until, 2.0 * run.node().t)).unwrap();
    assert_eq!(node.stop, Stop::Sticks);
    // up to the rounding of a compensated sum
    assert!(
        (node.q[0] - rest.1).abs() <= f64::EPSILON * rest.1.abs(),
        "{node:?} {rest:?}"
    );
    assert!(node.v[0].abs() < 1e-30, "{node:?}");
    rest
}

/// A mass with dry friction that a Taylor flow once followed wrongly without an error: position at t = 2,
/// time and place of rest are the closed form to the tolerance, from 1e-3 to 1e-14, in less than 30 steps.
#[test]
fn the_scene_that_went_wrong_in_silence() {
    let friction = Friction {
        mass: 1.0,
        stiffness: 40.0,
        dry: 0.5,
    };
    let exact = friction.at(0.2, 2.0).unwrap();
    assert!((exact - 0.099_701).abs() < 1e-6);
    for k in 3..=14 {
        let tolerance = 0.1_f64.powi(k);
        let mut flow = flow(&friction, [0.2, 0.0], tolerance);
        let end = flow.to(2.0).unwrap().q[0];
        assert!((end - exact).abs() < tolerance.max(1e-14), "{tolerance:e}: {end}");
        // one or two steps for each half-swing, none of them rejected
        assert!(flow.steps() < 30 && flow.rejected() == Some(0), "{flow:?}");
        let (t, x) = comes_to_rest(&mut flow, 5.0);
        assert!((t - 8.0 * friction.half()).abs() < tolerance.max(1e-14), "{t}");
        assert!((x - friction.rest(0.2).1).abs() < tolerance.max(1e-14), "{x}");
    }
}

/// 400 random masses with dry friction from random amplitudes at random tolerances: positions on the way, and
/// the time and place of rest, are the closed form to 20 tolerances a half-swing.
#[test]
fn random_scenes_of_dry_friction_lose_what_they_have_to() {
    let mut random = Random::new(15);
    let mut number = |from: f64, to: f64| random.decades(from, to);
    let (mut swings, mut tried) = (0.0, 0);
    while tried < 400 {
        let friction = Friction {
            mass: number(0.1, 10.0),
            stiffness: number(0.1, 1000.0),
            dry: number(1e-3, 10.0),
        };
        let rest = friction.dry / friction.stiffness;
        let start = rest * number(1.1, 40.0) * if tried % 2 == 0 { 1.0 } else { -1.0 };
        let tolerance = number(1e-14, 1e-3);
        let (end, place) = friction.rest(start);
        // the last turning point is so near the bound that the tolerance decides
        if friction.doubt(start) < (1e3 * tolerance).max(1e-9) * (start / rest).abs() {
            continue;
        }
        tried += 1;
        let count = end / friction.half();
        swings += count;
        let allowed = (20.0 * tolerance).max(1e-14) * count.max(1.0) * start.abs();
        let mut run = flow(&friction, [start, 0.0], tolerance);
        for part in [0.3, 0.5, 0.97] {
            let t = part * end;
            let x = run.to(t).unwrap().q[0];
            let exact = friction.at(start, t).unwrap();
            assert!(
                (x - exact).abs() <= allowed,
                "{start} {tolerance:e} {t}: {x} {exact}"
            );
        }
        let (t, x) = comes_to_rest(&mut run, 2.0 * end);
        assert!((x - place).abs() <= allowed, "{start} {tolerance:e}: {x} {place}");
        assert!(
            (t - end).abs() <= 30.0 * allowed.max(1e-12 * start.abs()) / start.abs() * end,
            "{t} {end}"
        );
        assert!((run.steps() as f64) < 60.0 + 12.0 * count, "{run:?} {count}");
    }
    println!("{swings} half-swings");
    assert!(swings > 1000.0);
}

#[test]
fn back_in_time_it_gains_what_it_has_lost() {
    let friction = Friction {
        mass: 1.0,
        stiffness: 40.0,
        dry: 0.5,
    };
    for tolerance in [1e-4, 1e-9, 1e-14] {
        let mut flow = flow(&friction, [0.2, 0.0], tolerance);
        // also from a switching point itself
        for t in [3.7, 3.0 * friction.half()] {
            flow.to(t).unwrap();
            flow.reverse().unwrap();
            let node = flow.to(0.0).unwrap();
            // at a turning point the error of the velocity is the root of that of the energy
            assert!(
                (node.q[0] - 0.2).abs() < 1e3 * tolerance.max(1e-15),
                "{tolerance:e}: {node:?}"
            );
            flow.reverse().unwrap();
        }
    }
}

#[test]
fn nodes_on_a_grid_samples_and_events_know_of_it() {
    let friction = Friction {
        mass: 1.0,
        stiffness: 40.0,
        dry: 0.5,
    };
    let exact = |t: f64| friction.at(0.2, t).unwrap();
    let trajectory = flow(&friction, [0.2, 0.0], 1e-12)
        .every(0.01)
        .unwrap()
        .until(3.9)
        .unwrap();
    for node in &trajectory {
        assert!((node.q[0] - exact(node.t)).abs() < 1e-12, "{node:?}");
    }
    let times: Vec<f64> = (0..=1000).map(|k| 3.9e-3 * f64::from(k)).collect();
    flow(&friction, [0.2, 0.0], 1e-12)
        .sample(&times, &mut |t, point| {
            assert!((point.q[0] - exact(t)).abs() < 1e-12);
        })
        .unwrap();
    // the events are the switches themselves
    let mut turns = Vec::new();
    let mut events = Events::new(vec![Event::function(|point| point.v[0])]);
    let mut run = flow(&friction, [0.2, 0.0], 1e-12);
    run.watch(
        3.9,
        &mut events,
        &mut on_event(|event: &Occurrence<1>| turns.push(event.t)),
    )
    .unwrap();
    turns.retain(|t| *t > 0.0);
    assert_eq!(turns.len(), 7, "{turns:?}");
    for (k, t) in turns.iter().enumerate() {
        assert!((t - (k + 1) as f64 * friction.half()).abs() < 1e-12, "{t}");
    }
}

/// A mass that friction holds from the start rests for ever. Where the friction is a user's function, whose
/// sign the series does not know, the run ends with the advice to smooth it, which works.
#[test]
fn what_sticks_from_the_beginning_rests_and_behind_a_function_says_so() {
    let friction = Friction {
        mass: 1.0,
        stiffness: 40.0,
        dry: 0.5,
    };
    let mut held = flow(&friction, [0.01, 0.0], 1e-9);
    assert_eq!(comes_to_rest(&mut held, 1.0), (0.0, 0.01));
    let node = held.to(20.0).unwrap();
    // the friction balances the spring, and no constraint acts
    assert_eq!((node.a[0], node.force[0]), (0.0, 0.0), "{node:?}");
    // the sign in a function of the user's is not known to the series
    let own = OwnFunction { dry: 0.5 };
    let error = flow(&own, [0.01, 0.0], 1e-9).to(1.0).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("sticks") && text.contains("of your own"), "{text}");
    let RunError::Series(error) = error else {
        panic!("{error}")
    };
    let details = error.details();
    assert_eq!((details.time, details.q[0]), (0.0, 0.01));
    assert!(
        matches!(&details.cause, SeriesFailure::Sticks { .. }),
        "{details:?}"
    );
    // as the message advises
    let smooth = Smooth {
        dry: 0.5,
        width: 1e-3,
    };
    let end = flow(&smooth, [0.2, 0.0], 1e-9).to(8.0).unwrap();
    assert!(end.v[0].abs() < 1e-3 && (end.q[0]).abs() <= 0.0125, "{end:?}");
}

declared! {
    /// A block with dry friction under a force: its velocity is piecewise linear in time.
    #[derive(Clone)]
    struct Shoved {
        push: f64,
        jump: f64,
        swing: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = push + (if t > 1.3 { jump } else { 0 }) + swing * t.sin() - dot(x).signum();
}

#[test]
fn a_velocity_that_is_linear_in_time_finds_its_stop_in_steps_without_an_end() {
    for v in [0.7, 1.0, 1.3, 2.9, 17.0] {
        let shoved = Shoved {
            push: 0.5,
            jump: 0.0,
            swing: 0.0,
        };
        let mut run = flow(&shoved, [0.0, v], 1e-9);
        assert!((comes_to_rest(&mut run, 1e3).1 - v * v).abs() < 1e-13 * v * v);
        // with an input that changes on the way
        for push in [0.4, 0.2, -0.1, -0.37, 0.3] {
            let mut run = flow(&shoved, [0.0, v], 1e-9).every(0.5).unwrap();
            run.to(0.5).unwrap();
            run.set_input("push", push).unwrap();
            while run.node().t < 60.0 {
                run.advance().unwrap();
            }
            let (before, left) = (0.5 * v - 0.0625, v - 0.25);
            let rest = before + left * left / (2.0 * (1.0 - push));
            let node = run.node();
            assert!(
                (node.q[0] - rest).abs() < 1e-12 * rest && node.stop == Stop::Sticks,
                "{v} {push}: {node:?} {rest}"
            );
        }
    }
}

#[test]
fn a_jump_lets_a_mass_go_when_it_happens() {
    // at 1.3 it is let go, and moves under 1 + 0.3 sin t
    let shoved = Shoved {
        push: 0.5,
        jump: 1.5,
        swing: 0.3,
    };
    for tolerance in [1e-6, 1e-10, 1e-13] {
        let node = flow(&shoved, [0.0, 0.0], tolerance).to(2.5).unwrap();
        let [from, to] = [1.3_f64, 2.5];
        let way = (to - from).powi(2) / 2.0 + 0.3 * (from.cos() * (to - from) + from.sin() - to.sin());
        assert!(
            (node.q[0] - way).abs() < tolerance.max(1e-12),
            "{tolerance:e}: {node:?} {way}"
        );
    }
}

/// The mass with its friction in a function of the user's.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - 20 * x.powi(2);
    external_forces = -dry * coulomb(dot(x));
}]
struct OwnFunction {
    dry: f64,
}

fn coulomb<R: Real>(x: R) -> R {
    x.signum()
}

declared! {
    /// The mass with a smooth, steep friction.
    struct Smooth {
        dry: f64,
        width: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - 20 * x.powi(2);
    external_forces = -dry * (dot(x) / width).tanh();
}

/// This friction in a function of the user's.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - 20 * x.powi(2);
    external_forces = -dry * steep(dot(x) / width);
}]
struct SmoothFunction {
    dry: f64,
    width: f64,
}

fn steep<R: Real>(x: R) -> R {
    x.tanh()
}

#[test]
fn a_steep_smooth_switch_is_not_jumped_over() {
    for width in [1e-2, 1e-4, 1e-6, 1e-8] {
        let (smooth, function) = (Smooth { dry: 0.5, width }, SmoothFunction { dry: 0.5, width });
        let exact = flow(&smooth, [0.2, 0.0], 1e-15).to(3.9).unwrap().q[0];
        for k in 3..=14 {
            let tolerance = 0.1_f64.powi(k);
            let runs = [
                flow(&smooth, [0.2, 0.0], tolerance).to(3.9).unwrap().q[0],
                flow(&function, [0.2, 0.0], tolerance).to(3.9).unwrap().q[0],
            ];
            for x in runs {
                assert!(
                    (x - exact).abs() < (3.0 * tolerance).max(1e-13),
                    "{width} {tolerance:e}: {x} {exact}"
                );
            }
        }
    }
}

declared! {
    /// A corner in the potential, which is a jump of the force.
    struct Corner {
        left: f64,
        right: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - (-left * x).max(right * x);
}

/// The corner by `min` in a function of the user's.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - corner(left * x, right * x);
}]
struct CornerFunction {
    left: f64,
    right: f64,
}

fn corner<R: Real>(left: R, right: R) -> R {
    -left.min(-right)
}

declared! {
    /// The corner by `abs` and by a square root.
    struct Vee {
        force: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - force * x.abs() / 2 - force * (x * x).sqrt() / 2;
}

/// Pieces of parabolas: position and velocity.
fn parabolas([left, right]: [f64; 2], speed: f64, t: f64) -> [f64; 2] {
    let (there, back) = (2.0 * speed / right, 2.0 * speed / left);
    let t = t % (there + back);
    if t <= there {
        [t * (speed - right * t / 2.0), speed - right * t]
    } else {
        let t = t - there;
        [t * (left * t / 2.0 - speed), left * t - speed]
    }
}

#[test]
fn a_corner_of_the_potential_makes_parabolas() {
    let mut random = Random::new(3);
    for k in 0..60 {
        let [left, right, speed] = [0; 3].map(|_| random.decades(0.1, 10.0));
        let tolerance = random.decades(1e-14, 1e-3);
        let period = 2.0 * speed * (1.0 / left + 1.0 / right);
        let end = random.between(5.0, 25.0) * period;
        let check = |sides: [f64; 2], run: Result<Node<1>, RunError>| {
            let node = run.unwrap();
            let [x, v] = parabolas(sides, speed, end);
            let size = speed * period;
            assert!((node.q[0] - x).abs() < 1e-12 * size, "{k}: {node:?} {x}");
            assert!(
                (node.v[0] - v).abs() < 1e-12 * (speed + (left + right) * period),
                "{k}: {node:?} {v}"
            );
        };
        check(
            [left, right],
            flow(&Corner { left, right }, [0.0, speed], tolerance).to(end),
        );
        check(
            [left, right],
            flow(&CornerFunction { left, right }, [0.0, speed], tolerance).to(end),
        );
        let end = end.min(20.0 * speed / right);
        let node = flow(&Vee { force: right }, [0.0, speed], tolerance)
            .to(end)
            .unwrap();
        let [x, _] = parabolas([right; 2], speed, end);
        assert!(
            (node.q[0] - x).abs() < 1e-12 * speed * speed / right,
            "{node:?} {x}"
        );
    }
}

declared! {
    /// Springs that differ on both sides: the force has a corner.
    struct Springs {
        left: f64,
        right: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - if x < 0 { left * x.powi(2) / 2 } else { right * x.powi(2) / 2 };
}

#[test]
fn a_corner_of_the_force_costs_no_order() {
    let springs = Springs {
        left: 3.0,
        right: 70.0,
    };
    let period = PI / 3_f64.sqrt() + PI / 70_f64.sqrt();
    for k in 3..=14 {
        let tolerance = 0.1_f64.powi(k);
        for direction in [1.0, -1.0] {
            let mut run = flow(&springs, [0.0, 1.0], tolerance);
            if direction < 0.0 {
                run.reverse().unwrap();
            }
            let node = run.to(direction * 20.0 * period).unwrap();
            assert!(
                node.q[0].abs() < (100.0 * tolerance).max(1e-12),
                "{tolerance:e}: {node:?}"
            );
            assert!(
                (node.v[0] - 1.0).abs() < (100.0 * tolerance).max(1e-12),
                "{tolerance:e}: {node:?}"
            );
        }
    }
}

declared! {
    /// Two masses that turn at the same times, in opposite directions.
    struct Two {
        dry: f64,
    }
    coordinates(x: [2]);
    lagrangian = sum(0..2, |i| dot(x[i]).powi(2) / 2 - 20 * x[i].powi(2));
    external_forces = (-dry * dot(x[0]).signum(), dry * (-dot(x[1])).signum());
}

#[test]
fn switches_at_the_same_time_do_not_disturb_each_other() {
    let friction = Friction {
        mass: 1.0,
        stiffness: 40.0,
        dry: 0.5,
    };
    for other in [-0.2, 0.2, 0.2 + 1e-13, 0.31] {
        for tolerance in [1e-5, 1e-9, 1e-14] {
            let two = Two { dry: 0.5 };
            let start = Start::second_order([0.2, other], [0.0; 2]);
            let mut run = TaylorFlow::new(&two, start, Tolerance::relative(tolerance)).unwrap();
            let node = run.to(3.9).unwrap();
            for (x, start) in node.q.iter().zip([0.2, other]) {
                let exact = friction.at(start, 3.9).unwrap();
                assert!(
                    (x - exact).abs() < (10.0 * tolerance).max(1e-13),
                    "{other} {tolerance:e}: {x} {exact}"
                );
            }
        }
    }
}

declared! {
    /// A switching control law: full force towards the line `x' = -x`.
    struct Sliding {
        force: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + force * (dot(x) + x).signum();
    variational = [];
}

#[test]
fn a_sliding_motion_goes_along_its_line() {
    // x = 1 - 2 t², x' = -4 t: on the line where 2 t² + 4 t = 1, and then along it
    let t = 1.5_f64.sqrt() - 1.0;
    for tolerance in [1e-3, 1e-8, 1e-14] {
        let sliding = Sliding { force: 4.0 };
        let mut run = flow(&sliding, [1.0, 0.0], tolerance);
        let node = run.to(3.0).unwrap();
        let x = (1.0 - 2.0 * t * t) * (t - 3.0).exp();
        assert!(
            (node.q[0] - x).abs() < tolerance.max(1e-14) && node.stop == Stop::Sticks,
            "{node:?} {x}"
        );
        assert!(
            (node.v[0] + node.q[0]).abs() < 1e-15 && (node.a[0] - x).abs() < tolerance.max(1e-14),
            "{node:?}"
        );
    }
    // a weaker force crosses the line at first, and stays on it later
    let root = 5_f64.sqrt();
    let weak = Sliding { force: 0.5 };
    let node = flow(&weak, [1.0, 0.0], 1e-12).to(10.0).unwrap();
    let x = (3.0 - root) / 2.0 * (3.0 * root - 5.0 - 10.0).exp();
    assert!((node.q[0] - x).abs() < 1e-13, "{node:?} {x}");
}

declared! {
    /// A Lyapunov function whose decrease switches.
    struct Law {
        slow: f64,
        fast: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    let energy = dot(x).powi(2) / 2 + dot(y).powi(2) / 2;
    kinematic = dot(energy) + if x < 1 { slow } else { fast } * (dot(x).powi(2) + dot(y).powi(2));
    constraint_forces = [(1, 0)];
}

#[test]
fn a_jump_in_a_control_law_is_met() {
    let law = Law {
        slow: 0.25,
        fast: 1.5,
    };
    // v' = -rate v
    let cross = -(1.0_f64 - 0.25 / 2.0).ln() / 0.25;
    let speed = 2.0 * (1.0_f64 - 0.25 / 2.0);
    for tolerance in [1e-4, 1e-9, 1e-14] {
        let start = Start::second_order([0.0; 2], [2.0, 0.0]);
        let mut run = TaylorFlow::new(&law, start, Tolerance::relative(tolerance)).unwrap();
        let node = run.to(cross + 1.0).unwrap();
        let exact = 1.0 + speed * (1.0 - (-1.5_f64).exp()) / 1.5;
        assert!(
            (node.q[0] - exact).abs() < (10.0 * tolerance).max(1e-14),
            "{tolerance:e}: {node:?} {exact}"
        );
    }
}

/// A mass under forces sampled in space and in time, and under a sawtooth.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    external_forces = (place.at(x), push.at(t) + saw(t));
}]
struct Pushed {
    place: Samples,
    push: Samples,
}

fn saw<R: Real>(t: R) -> R {
    t % 0.75
}

#[test]
fn pieces_of_samples_end_where_they_end() {
    // a spring with limits in space, and a triangle in time
    let pushed = Pushed {
        place: Samples::linear([(-0.5, 2.0), (0.5, -2.0)]).unwrap(),
        push: Samples::linear([(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)]).unwrap(),
    };
    // from 1.5: a parabola to 0.5, a cosine to -0.5, a parabola to -1.5
    let there = 1.0;
    let middle = (0.25_f64 + 1.0).sqrt();
    let quarter = (0.5 / middle).asin() / 2.0;
    let half = 2.0 * (there + quarter);
    for k in 4..=14 {
        let tolerance = 0.1_f64.powi(k);
        let start = Start::second_order([1.5, 0.0], [0.0; 2]);
        let mut run = TaylorFlow::new(&pushed, start, Tolerance::relative(tolerance)).unwrap();
        let node = run.to(2.0 * half).unwrap();
        assert!(
            (node.q[0] - 1.5).abs() < (50.0 * tolerance).max(1e-13),
            "{tolerance:e}: {node:?}"
        );
        // the push gives 1, the saw 9/32 a tooth
        let teeth = (node.t / 0.75).floor();
        let speed = 1.0 + teeth * 9.0 / 32.0 + (node.t - 0.75 * teeth).powi(2) / 2.0;
        assert!(
            (node.v[1] - speed).abs() < 1e-13,
            "{tolerance:e}: {node:?} {speed}"
        );
        assert!(run.steps() < 400, "{run:?}");
    }
}

declared! {
    /// A force that changes its sign often; in between the motion is a parabola.
    struct Hills {
        height: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = height * (50 * x).sin().signum();
}

#[test]
fn switches_that_the_motion_does_not_foresee_are_found() {
    // up a ramp of the length π/50 and down the next one
    let (hills, length): (_, f64) = (Hills { height: 3.0 }, PI / 50.0);
    let top = (1.0 + 6.0 * length).sqrt();
    let both = 2.0 * (top - 1.0) / 3.0;
    for tolerance in [1e-3, 1e-8, 1e-14] {
        let node = flow(&hills, [0.0, 1.0], tolerance).to(40.0 * both).unwrap();
        assert!(
            (node.q[0] - 80.0 * length).abs() < 1e-12,
            "{tolerance:e}: {node:?}"
        );
    }
}

#[test]
fn the_error_of_another_method_is_measured_across_switches() {
    let friction = Friction {
        mass: 1.0,
        stiffness: 40.0,
        dry: 0.5,
    };
    let mut error = GlobalError::new(&friction, Start::second_order([0.2], [0.0]), 3.95).unwrap();
    for k in 0..=39 {
        let t = 0.1 * f64::from(k);
        let [distance] = error.at(t, &[friction.at(0.2, t).unwrap()]).unwrap();
        assert!(distance < 1e-14, "{distance}");
    }
    assert!(error.uncertainty() < 1e-14);
}

/// A function that hides its branch from the series.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -hidden(dot(x));
}]
struct Hidden {}

fn hidden<R: Real>(v: R) -> R {
    R::from(if v.re() > 0.0 { 1.0 } else { -1.0 })
}

#[test]
fn a_jump_that_is_hidden_and_leads_back_ends_the_motion() {
    let start = Start::second_order([0.0], [1.0]);
    let mut run = dsocs_core::TaylorFlow::new(&Hidden {}, start, Tolerance::relative(1e-9)).unwrap();
    let error = run.to(3.0).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("goes back and forth at t = 1.0000000") && text.contains("a function of your own"),
        "{text}"
    );
}

declared! {
    /// A mass that a relay brings to rest in the shortest time, along a curve at whose end both sides lead back.
    struct Relay {}
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -(x + dot(x) * dot(x).abs() / 2).signum();
}

#[test]
fn a_relay_that_leads_to_rest_is_told_at_every_tolerance() {
    for [x, v] in [[1.0, 0.0], [2.0, 0.5], [0.5, -1.0], [-1.0, 1.0], [-3.0, -0.2]] {
        // against the side of the curve first
        let side: f64 = if x + v * f64::abs(v) / 2.0 < 0.0 {
            -1.0
        } else {
            1.0
        };
        let rests = side * v + 2.0 * f64::sqrt(side * x + v * v / 2.0);
        for tolerance in [1e-4, 1e-6, 1e-9, 1e-12] {
            let mut run = flow(&Relay {}, [x, v], tolerance);
            let error = run.to(rests + 1.0).unwrap_err();
            let RunError::Series(error) = error else {
                panic!("{error}");
            };
            let details = error.details();
            assert!(
                matches!(&details.cause, SeriesFailure::Sticks { switch, .. } if switch.contains("dot(x).abs()")),
                "{x} {v} {tolerance}: {error}"
            );
            assert!((details.time - rests).abs() < 1e-6, "{} {rests}", details.time);
            assert!(details.q[0].abs() < 1e-9 && details.v[0].abs() < 1e-6);
        }
        // the advice: steps of a fixed length pass such a place
        let start = Start::second_order([x], [v]);
        let mut steps = Flow::new(&Relay {}, 1e-3, start).unwrap();
        let node = steps.to(rests + 1.0).unwrap();
        assert!(node.q[0].abs() < 1e-3 && node.v[0].abs() < 2e-3, "{node:?}");
    }
}
