//! Dry friction whose slip depends on the attitude of a body: where the slip changes its sign, and where it
//! is held at zero.

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::Text;
use dsocs_core::{AnyFlow, AnyStart, OwnedNode, Run, RunError, SeriesFailure, Tolerance, Unresolved};

use crate::rotations::{joined, part};
use dsocs_tests::dop853;
use dsocs_tests::vectors::{Vector, cross, dot, matrix, plus, rate, times, unit};

const INERTIA: Vector = [2.0, 1.5, 1.0];
const ARM: Vector = [0.2, 0.5, 1.0];

/// A heavy top with friction: its slip, and the torque of a unit friction, in the frame of the body.
struct Top {
    slip: fn([f64; 4], Vector) -> f64,
    lever: fn([f64; 4]) -> Vector,
    friction: f64,
}

impl Top {
    /// The rate of attitude and angular velocity, under a friction.
    fn rate(&self, y: &[f64; 7], friction: f64) -> [f64; 7] {
        let (q, w) = (part(y, 0), part(y, 4));
        let a = self.acceleration(q, w, friction);
        joined(&[&rate(q, w), &a])
    }

    fn acceleration(&self, q: [f64; 4], w: Vector, friction: f64) -> Vector {
        let momentum = [0, 1, 2].map(|i| INERTIA[i] * w[i]);
        let weight = cross(matrix(q)[2], ARM);
        let torque = plus(plus(cross(momentum, w), weight), times(friction, (self.lever)(q)));
        [0, 1, 2].map(|i| torque[i] / INERTIA[i])
    }

    fn slip(&self, y: &[f64; 7]) -> f64 {
        (self.slip)(part(y, 0), part(y, 4))
    }

    /// The friction that keeps the slip constant; the slip is affine in it.
    fn holding(&self, y: &[f64; 7]) -> f64 {
        let by = |friction: f64| {
            // the rate of the slip along the motion
            let beside = |s: f64| {
                let r = self.rate(y, friction);
                let moved: [f64; 7] = core::array::from_fn(|i| y[i] + s * r[i]);
                (self.slip)(unit(part(&moved, 0)), part(&moved, 4))
            };
            (beside(1e-5) - beside(-1e-5)) / 2e-5
        };
        let (none, one) = (by(0.0), by(1.0));
        none / (none - one)
    }

    /// The end of the motion and its events, in pieces: with friction against the slip, and with the friction
    /// that holds it at zero.
    fn motion(&self, mut y: [f64; 7], until: f64) -> ([f64; 7], Vec<f64>) {
        let (mut t, mut events) = (0.0, Vec::new());
        // `None` while the slip is held
        let mut side = Some(self.slip(&y).signum());
        let go = |y: [f64; 7], dt: f64, side: Option<f64>| {
            let friction = |y: &[f64; 7]| side.map_or_else(|| self.holding(y), |side| -side * self.friction);
            dop853::integrate_from(|_, y| self.rate(&y, friction(&y)), (0.0, y), dt, 1e-12)
        };
        while t < until - 1e-12 {
            let step = f64::min(0.01, until - t);
            // the distance to the end of this piece: the slip, or the unused friction
            let left = |y: &[f64; 7]| match side {
                Some(side) => side * self.slip(y),
                None => self.friction - self.holding(y).abs(),
            };
            let next = go(y, step, side);
            if left(&next) >= 0.0 {
                (y, t) = (next, t + step);
                continue;
            }
            let (mut before, mut beyond) = (0.0, step);
            for _ in 0..45 {
                let middle = 0.5 * (before + beyond);
                if left(&go(y, middle, side)) < 0.0 {
                    beyond = middle;
                } else {
                    before = middle;
                }
            }
            y = go(y, beyond, side);
            t += beyond;
            events.push(t);
            side = match side {
                Some(_) if self.holding(&y).abs() < self.friction => None,
                Some(side) => Some(-side),
                None => Some(-self.holding(&y).signum()),
            };
        }
        (y, events)
    }

    /// Checks that the errors of the step at the end of a motion are of order 2, wherever events lie within
    /// steps.
    #[track_caller]
    fn assert_second_order(
        &self,
        force: &str,
        until: f64,
        (least, bound): (usize, f64),
    ) -> Vec<Option<Unresolved>> {
        let y0: [f64; 7] = joined(&[&unit([1.0, 0.3, -0.4, 0.2]), &[0.6, -0.3, 2.0]]);
        let (end, events) = self.motion(y0, until);
        println!("{events:?}");
        assert!(events.len() >= least, "{events:?}");
        let text = format!(
            "parameters {{ arm = {ARM:?}, friction = {:?} }}
             coordinates(r: rotation);
             let w = r.angular_velocity();
             lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - (r * arm)[2];
             {force}",
            self.friction
        );
        let text = Text::parse("top", &text).unwrap_or_else(|error| panic!("{error}"));
        let start = AnyStart::second_order(&y0[..4], &[0.0, y0[4], y0[5], y0[6]]);
        let steps = (0..6).map(|halvings| 0.02 * 0.5_f64.powi(halvings));
        let jumps = steps.map(|h| {
            let mut flow = AnyFlow::new(&text.system, h, &start).unwrap();
            flow.run_mut().to(until).unwrap();
            let mut node = OwnedNode::new(4);
            node.take(flow.run());
            let found = node.any();
            let apart = found
                .q
                .iter()
                .zip(&end)
                .map(|(found, known)| (found - known).abs());
            let apart = apart.fold(0.0, f64::max);
            println!(
                "{h}: {apart:e}, {} h², {:?}",
                apart / (h * h),
                flow.run().unresolved()
            );
            assert!(apart < bound * h * h, "{h}: {apart:e}");
            flow.run().unresolved()
        });
        let jumps = jumps.collect();
        // and the series follows the motion, to the accuracy of the holding friction here
        for tolerance in [1e-7, 1e-10, 1e-14] {
            let mut flow =
                AnyTaylorFlow::of_tape(&text.system, &start, Tolerance::relative(tolerance)).unwrap();
            let run: &mut dyn Run = &mut flow;
            run.to(until).unwrap();
            let mut node = OwnedNode::new(4);
            node.take(run);
            let node = node.any();
            let both = node.q.iter().chain(&node.v[1..]).zip(&end);
            let apart = both
                .map(|(found, known)| (found - known).abs())
                .fold(0.0, f64::max);
            println!("{tolerance:e}: {apart:e}, {} steps", run.clock().index());
            assert!(apart < 100.0 * tolerance + 2e-9, "{tolerance:e}: {apart:e}");
            let norm = node.q.iter().map(|q| q * q).sum::<f64>().sqrt();
            assert!((norm - 1.0).abs() <= 2.0 * f64::EPSILON, "{norm}");
        }
        jumps
    }
}

#[test]
fn a_slip_that_turns_round() {
    for (friction, bound) in [(0.1, 0.04), (0.5, 0.3)] {
        let top = Top {
            slip: |q, w| dot(matrix(q)[0], cross(w, ARM)),
            lever: |q| cross(ARM, matrix(q)[0]),
            friction,
        };
        let jumps = top.assert_second_order(
            "let slip = (r * w.cross(arm))[0];
             external_forces = arm.cross(r.inverse() * [-friction * slip.signum(), 0, 0]);",
            3.0,
            (2, bound),
        );
        // the sides act on their own parts of the step, so no run reports a loss of order
        assert!(jumps.iter().all(Option::is_none), "{jumps:?}");
    }
}

#[test]
fn a_slip_that_only_changes_its_sign_is_told() {
    // along a leg the angular velocity about the vertical is constant, so that the step takes one side of the
    // jump on each leg, as with an angle
    let text = "coordinates(r: rotation);
        let w = r.angular_velocity();
        lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - (r * [0.2, 0.5, 1])[2];
        let turn = r.inverse() * [0, 0, 1];
        external_forces = -0.8 * w.inner(turn).signum() * turn;";
    let text = Text::parse("top", text).unwrap();
    for halvings in 0..6 {
        let h = 0.05 * 0.5_f64.powi(halvings);
        let start = AnyStart::second_order(&[1.0, 0.0, 0.0, 0.0], &[0.6, -0.3, 2.0]);
        let mut flow = AnyFlow::new(&text.system, h, &start).unwrap();
        flow.run_mut().to(2.6).unwrap();
        // the slip passes zero at 2.2009
        let jumps = flow.run().unresolved().expect("a jump");
        assert!(
            jumps.steps == 1 && (jumps.first - 2.2009).abs() < h,
            "{h}: {jumps:?}"
        );
    }
}

#[test]
fn a_slip_about_a_vertical_axis_is_held_and_let_go() {
    let top = Top {
        slip: |q, w| dot(matrix(q)[2], w),
        lever: |q| matrix(q)[2],
        friction: 0.8,
    };
    top.assert_second_order(
        "let turn = r.inverse() * [0, 0, 1];
         external_forces = -friction * w.inner(turn).signum() * turn;",
        6.0,
        (1, 1.0),
    );
}

/// A body that turns, and slides on a rod where friction stops it and releases it.
#[test]
fn what_is_held_beside_a_rotation_leaves_it_as_it_is() {
    // the mass on the rod stops at 1/0.6; from there on the body moves as one without it
    let free = "coordinates(r: rotation);
        let w = r.angular_velocity();
        lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - (r * [0.2, 0.5, 1])[2];";
    let rubs = "coordinates(r: rotation, x);
        let w = r.angular_velocity();
        lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - (r * [0.2, 0.5, 1])[2] + dot(x).powi(2) / 2;
        external_forces = ([0, 0, 0], -0.3 * dot(x).signum());";
    let q = unit([1.0, 0.3, -0.4, 0.2]);
    let starts = [
        (free, 4, AnyStart::second_order(&q, &[0.6, -0.3, 2.0])),
        (
            rubs,
            5,
            AnyStart::second_order(&[&q[..], &[0.0]].concat(), &[0.6, -0.3, 2.0, 1.0]),
        ),
    ];
    let [known, found] = starts.map(|(text, n, start)| {
        let text = Text::parse("body", text).unwrap();
        let mut flow = AnyTaylorFlow::of_tape(&text.system, &start, Tolerance::relative(1e-14)).unwrap();
        let run: &mut dyn Run = &mut flow;
        run.to(6.0).unwrap();
        let mut node = OwnedNode::new(n);
        node.take(run);
        [node.any().q, node.any().v].map(<[f64]>::to_vec)
    });
    for k in 0..4 {
        assert!((known[0][k] - found[0][k]).abs() < 2e-13, "{known:?} {found:?}");
        assert!((known[1][k] - found[1][k]).abs() < 5e-13, "{known:?} {found:?}");
    }
    assert!(
        (found[0][4] - 1.0 / 0.6).abs() < 1e-14 && found[1][4].abs() < 1e-15,
        "{found:?}"
    );
}

/// A ball that slides until it rolls, with friction along the slip. The force has no value where the slip
/// ends, and the motion beyond belongs to no side.
#[test]
fn a_friction_along_a_slip_ends_the_motion_where_the_slip_ends() {
    let text = Text::parse(
        "ball",
        "parameters { mass = 1.0, radius = 0.1, inertia = 0.004, mu = 0.2, gravity = 9.81 }
        coordinates(r: rotation, x: [2]);
        let o = r * r.angular_velocity();
        lagrangian = inertia * o.norm_squared() / 2 + mass * dot(x).norm_squared() / 2;
        let slip = dot(x) + radius * [-o[1], o[0]];
        let f = -mu * mass * gravity * slip / slip.norm();
        external_forces = (r.inverse() * [radius * f[1], -radius * f[0], 0], f);",
    )
    .unwrap();
    let (q0, v0) = ([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 5.0, 0.0, 2.0, 1.0]);
    // the slip (1.5, 1) falls by μ g (1 + m ρ²/J) in a second
    let ends = 1.5_f64.hypot(1.0) / (0.2 * 9.81 * 3.5);
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-14] {
        let start = AnyStart::second_order(&q0, &v0);
        let mut flow = AnyTaylorFlow::of_tape(&text.system, &start, Tolerance::relative(tolerance)).unwrap();
        let run: &mut dyn Run = &mut flow;
        let mut steps = 0;
        let error = loop {
            match run.advance() {
                Ok(_) => steps += 1,
                Err(error) => break error,
            }
            assert!(steps < 200, "{tolerance:e}");
        };
        let RunError::Series(error) = error else {
            panic!("{tolerance:e}: {error}");
        };
        let failed = error.details();
        assert!(
            matches!(failed.cause, SeriesFailure::BackAndForth { .. }),
            "{tolerance:e}: {error}"
        );
        assert!(
            (failed.time - ends).abs() < 2e3 * tolerance.max(1e-13),
            "{tolerance:e}: {} {ends}",
            failed.time
        );
        // the reported state is that where the slip ends
        let norm: f64 = failed.q[..4].iter().map(|x| x * x).sum();
        assert!(
            (norm - 1.0).abs() < 1e-9 && failed.v[2] < 17.0,
            "{tolerance:e}: {error}"
        );
    }
}
