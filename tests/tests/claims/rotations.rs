//! Rotations as coordinates: the step against equations by hand, which DOP853 integrates; its errors and
//! orders.
//!
//! The expected errors are those of an independent implementation of the step, in Python with derivatives by
//! JAX.

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::Text;
use dsocs_core::{
    AnyFlow, AnyStart, Flow, OwnedNode, Run, SetupError, Start, Stepper, TaylorFlow, Tolerance, dsocs,
};

use dsocs_tests::dop853;
use dsocs_tests::vectors::{
    Matrix, Vector, cross, dot, matrix, plus, product, rate, solved, times, transposed, unit,
};

/// `K` numbers of a state, from a place on.
pub(crate) fn part<const K: usize, const N: usize>(state: &[f64; N], from: usize) -> [f64; K] {
    core::array::from_fn(|i| state[from + i])
}

/// The parts one after another.
pub(crate) fn joined<const N: usize>(parts: &[&[f64]]) -> [f64; N] {
    let all = parts.concat();
    core::array::from_fn(|i| all[i])
}

/// A start and an end. Positions have the quaternion first, velocities omit its zero.
pub(crate) struct Motion {
    pub(crate) q0: Vec<f64>,
    pub(crate) v0: Vec<f64>,
    pub(crate) until: f64,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
}

impl Motion {
    /// The motion by DOP853, of a state whose first `K` numbers are positions.
    pub(crate) fn by_hand<const N: usize>(
        hand: impl Fn(&[f64; N]) -> [f64; N],
        (q0, v0): (&[f64], &[f64]),
        until: f64,
    ) -> Self {
        let end = dop853::integrate_from(|_, state| hand(&state), (0.0, joined(&[q0, v0])), until, 1e-13);
        let (q, v) = end.split_at(q0.len());
        Self {
            q0: q0.to_vec(),
            v0: v0.to_vec(),
            until,
            q: q.to_vec(),
            v: v.to_vec(),
        }
    }

    /// Checks the errors of position and velocity of a declaration's step, for a step and its halves.
    #[track_caller]
    fn assert_errors(&self, text: &str, h: f64, positions: [f64; 4], velocities: [f64; 4]) {
        let text = Text::parse("body", text).unwrap_or_else(|error| panic!("{error}"));
        let v0 = [&[0.0], self.v0.as_slice()].concat();
        let start = AnyStart::second_order(&self.q0, &v0);
        let largest = |found: &[f64], known: &[f64]| {
            let apart = found
                .iter()
                .zip(known)
                .map(|(found, known)| (found - known).abs());
            apart.fold(0.0, f64::max)
        };
        let mut taylor = AnyTaylorFlow::of_tape(&text.system, &start, Tolerance::relative(1e-15)).unwrap();
        let run: &mut dyn Run = &mut taylor;
        run.to(self.until).unwrap();
        let mut node = OwnedNode::new(self.q0.len());
        node.take(run);
        let node = node.any();
        let apart = largest(node.q, &self.q).max(largest(&node.v[1..], &self.v));
        assert!(apart < 1e-11, "the Taylor series: {apart:e}");
        let errors = [1.0, 0.5, 0.25, 0.125].map(|part| {
            let mut flow = AnyFlow::new(&text.system, part * h, &start).unwrap();
            flow.run_mut().to(self.until).unwrap();
            let mut node = OwnedNode::new(self.q0.len());
            node.take(flow.run());
            let node = node.any();
            [largest(node.q, &self.q), largest(&node.v[1..], &self.v)]
        });
        println!("{errors:?}");
        for (place, expected) in [positions, velocities].into_iter().enumerate() {
            for (errors, expected) in errors.iter().zip(expected) {
                assert!(
                    (errors[place] / expected - 1.0).abs() < 0.05,
                    "{errors:?} for {expected:e}"
                );
            }
            let order = |i: usize, of: &dyn Fn(usize) -> f64| (of(i) / of(i + 1)).log2();
            for i in 0..3 {
                let (found, expected) = (order(i, &|i| errors[i][place]), order(i, &|i| expected[i]));
                assert!((found - expected).abs() < 0.05, "{errors:?}");
            }
        }
    }
}

/// The text of a matrix of parameters.
pub(crate) fn written(m: &Matrix) -> String {
    format!("{m:?}")
}

/// A heavy top up to a time.
pub(crate) fn heavy_top(until: f64) -> Motion {
    let (inertia, arm) = ([2.0, 1.5, 1.0], [0.2, 0.1, 1.0]);
    let hand = |y: &[f64; 7]| {
        let (q, w): ([f64; 4], Vector) = (part(y, 0), part(y, 4));
        let momentum = [0, 1, 2].map(|i| inertia[i] * w[i]);
        let torque = plus(cross(momentum, w), cross(matrix(q)[2], arm));
        joined(&[&rate(q, w), &[0, 1, 2].map(|i| torque[i] / inertia[i])])
    };
    Motion::by_hand(hand, (&unit([1.0, 0.3, -0.4, 0.2]), &[0.6, -0.3, 3.0]), until)
}

/// Its declaration, with the given maps.
pub(crate) fn of_heavy_top(maps: &str) -> String {
    format!(
        "parameters {{ inertia = [[2.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 1.0]], arm = [0.2, 0.1, 1.0] }}
         coordinates(r: rotation);
         let w = r.angular_velocity();
         lagrangian = w.inner(inertia * w) / 2 - (r * arm)[2];
         {maps}"
    )
}

#[test]
fn a_heavy_top() {
    let motion = heavy_top(5.0);
    // the differences of the paper's map from the trapezoid telescope
    for maps in ["", "phi_lagrangian = paper;", "phi_lagrangian = trapezoid;"] {
        motion.assert_errors(
            &of_heavy_top(maps),
            0.1,
            [2.38e-3, 5.90e-4, 1.47e-4, 3.66e-5],
            [7.02e-3, 1.76e-3, 4.39e-4, 1.10e-4],
        );
    }
    motion.assert_errors(
        &of_heavy_top("phi_lagrangian = midpoint;"),
        0.1,
        [2.21e-3, 5.40e-4, 1.34e-4, 3.33e-5],
        [9.19e-3, 2.29e-3, 5.72e-4, 1.43e-4],
    );
}

/// The body of Suslov's problem, in a field.
const SUSLOV: Matrix = [[2.0, 0.1, 0.3], [0.1, 1.5, -0.2], [0.3, -0.2, 1.2]];

#[test]
fn suslovs_problem() {
    let field = [0.7, 0.4, 0.2];
    for (size, positions, velocities) in [
        (
            0.0,
            [1.79e-4, 4.43e-5, 1.10e-5, 2.75e-6],
            [2.97e-4, 7.40e-5, 1.85e-5, 4.61e-6],
        ),
        (
            1.0,
            [6.61e-4, 1.65e-4, 4.12e-5, 1.03e-5],
            [1.23e-3, 3.07e-4, 7.67e-5, 1.92e-5],
        ),
    ] {
        let axis = [0.0, 0.0, 1.0];
        let hand = |y: &[f64; 7]| {
            let (q, w): ([f64; 4], Vector) = (part(y, 0), part(y, 4));
            let torque = plus(
                cross(product(&SUSLOV, w), w),
                times(size, cross(matrix(q)[2], field)),
            );
            let along = solved(&SUSLOV, axis);
            let multiplier = -dot(along, torque) / dot(along, axis);
            let acceleration = solved(&SUSLOV, plus(torque, times(multiplier, axis)));
            joined(&[&rate(q, w), &acceleration])
        };
        let start = (unit([1.0, 0.3, -0.2, 0.4]), [1.2, -0.7, 0.0]);
        let motion = Motion::by_hand(hand, (&start.0, &start.1), 5.0);
        let text = format!(
            "parameters {{ inertia = {}, field = {field:?}, size = {size:?} }}
             coordinates(r: rotation);
             let w = r.angular_velocity();
             lagrangian = w.inner(inertia * w) / 2 - size * (r.inverse() * [0, 0, 1]).inner(field);
             nonholonomic = w[2];
             phi_lagrangian = trapezoid;",
            written(&SUSLOV)
        );
        motion.assert_errors(&text, 0.1, positions, velocities);
    }
}

pub(crate) const SATELLITE: Matrix = [[3.0, 0.2, -0.1], [0.2, 2.5, 0.15], [-0.1, 0.15, 2.0]];
pub(crate) const DAMPING: Vector = [0.8, 0.6, 0.7];
pub(crate) const WHEEL: f64 = 0.1;

/// A satellite whose wheels follow a law: their torque is a function of the attitude error `e`, the angular
/// velocity `w` and the total momentum `momentum`.
pub(crate) fn satellite(torque: impl Fn(Vector, Vector, Vector) -> Vector, until: f64) -> Motion {
    let hand = |y: &[f64; 13]| {
        let (q, w, wheels): ([f64; 4], Vector, Vector) = (part(y, 0), part(y, 7), part(y, 10));
        let r = matrix(q);
        let error = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]];
        let momentum = plus(product(&SATELLITE, w), times(WHEEL, plus(w, wheels)));
        let torque = torque(error, w, momentum);
        let acceleration = solved(&SATELLITE, times(-1.0, plus(torque, cross(w, momentum))));
        let of_wheels = plus(times(1.0 / WHEEL, torque), times(-1.0, acceleration));
        joined(&[&rate(q, w), &wheels, &acceleration, &of_wheels])
    };
    let q0: [f64; 7] = joined(&[&unit([1.0, 0.8, -0.5, 0.4]), &[0.0; 3]]);
    Motion::by_hand(hand, (&q0, &[0.3, -0.5, 0.4, 2.0, -1.0, 0.5]), until)
}

/// The declaration of the satellite without the law of its wheels.
pub(crate) fn of_satellite(law: &str) -> String {
    format!(
        "parameters {{ inertia = {}, wheel = {WHEEL:?}, damping = [[0.8, 0.0, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 0.7]] }}
         coordinates(r: rotation, psi: [3]);
         let w = r.angular_velocity();
         lagrangian = w.inner(inertia * w) / 2 + wheel * (w + dot(psi)).norm_squared() / 2;
         let m = r.matrix();
         let e = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]];
         {law}",
        written(&SATELLITE)
    )
}

/// The satellite under one Lyapunov row, and its text.
pub(crate) fn lyapunov(until: f64) -> (Motion, String) {
    const SHARE: f64 = 0.15;
    let motion = satellite(
        |error, w, momentum| {
            let along = plus(w, times(SHARE, error));
            let damped = [0, 1, 2].map(|i| DAMPING[i] * along[i]);
            let wanted = plus(plus(error, damped), times(-1.0, cross(w, momentum)));
            times(dot(along, wanted) / dot(along, along), along)
        },
        until,
    );
    let text = of_satellite(
        "let s = w + 0.15 * e;
         let lyapunov = w.inner(inertia * w) / 2 + 3 - m[0][0] - m[1][1] - m[2][2] + 0.15 * e.inner(inertia * w);
         kinematic = dot(lyapunov) + s.inner(damping * s) + 0.15 * e.norm_squared() - 0.15 * dot(e).inner(inertia * w);
         constraint_forces = [(0, s)];",
    );
    (motion, text)
}

#[test]
fn a_satellite_under_a_lyapunov_row() {
    let (motion, text) = lyapunov(0.75);
    motion.assert_errors(
        &text,
        0.025,
        [8.33e-4, 2.08e-4, 5.21e-5, 1.30e-5],
        [4.18e-4, 1.05e-4, 2.62e-5, 6.55e-6],
    );
}

#[test]
fn a_satellite_under_three_rows() {
    let motion = satellite(
        |error, w, momentum| {
            let damped = [0, 1, 2].map(|i| DAMPING[i] * w[i]);
            plus(plus(error, damped), times(-1.0, cross(w, momentum)))
        },
        4.0,
    );
    let text = of_satellite(
        "kinematic = inertia * dot(w) + e + damping * w;
         constraint_forces = each(0..3, |i| (0, |j| if i == j { 1 } else { 0 }));",
    );
    motion.assert_errors(
        &text,
        0.1,
        [3.20e-2, 8.05e-3, 2.02e-3, 5.06e-4],
        [2.69e-2, 6.70e-3, 1.67e-3, 4.18e-4],
    );
}

/// A body in a fluid, and its text.
pub(crate) fn fluid() -> (Motion, String) {
    let inertia = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]];
    let masses = [1.0, 2.0, 3.0];
    let hand = |y: &[f64; 13]| {
        let (q, w, v): ([f64; 4], Vector, Vector) = (part(y, 0), part(y, 7), part(y, 10));
        let r = matrix(q);
        let u = product(&transposed(&r), v);
        let momentum = [0, 1, 2].map(|i| masses[i] * u[i]);
        let turning = solved(&inertia, plus(cross(product(&inertia, w), w), cross(momentum, u)));
        let pushed = cross(momentum, w);
        let pushed = [0, 1, 2].map(|i| pushed[i] / masses[i]);
        joined(&[&rate(q, w), &v, &turning, &product(&r, plus(pushed, cross(w, u)))])
    };
    let q0: [f64; 7] = joined(&[&unit([1.0, 0.2, -0.3, 0.4]), &[0.1, 0.2, 0.3]]);
    let motion = Motion::by_hand(hand, (&q0, &[0.6, -0.3, 1.5, 0.5, -0.7, 0.4]), 4.0);
    let text = format!(
        "parameters {{ inertia = {}, mass = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]] }}
         coordinates(r: rotation, x: [3]);
         let w = r.angular_velocity();
         let u = r.inverse() * dot(x);
         lagrangian = w.inner(inertia * w) / 2 + u.inner(mass * u) / 2;",
        written(&inertia)
    );
    (motion, text)
}

#[test]
fn a_body_in_a_fluid() {
    let (motion, body) = fluid();
    let text = |maps: &str| format!("{body} {maps}");
    // the mass varies with the rotation: the default is the midpoint, and the paper's map is of order 1
    motion.assert_errors(
        &text(""),
        0.1,
        [1.43e-2, 3.65e-3, 9.20e-4, 2.31e-4],
        [3.61e-2, 9.14e-3, 2.30e-3, 5.77e-4],
    );
    motion.assert_errors(
        &text("phi_lagrangian = trapezoid;"),
        0.1,
        [1.22e-2, 3.17e-3, 8.09e-4, 2.04e-4],
        [3.56e-2, 9.08e-3, 2.30e-3, 5.77e-4],
    );
    motion.assert_errors(
        &text("phi_lagrangian = paper;"),
        0.1,
        [1.03e-1, 4.76e-2, 2.29e-2, 1.12e-2],
        [3.03e-1, 1.40e-1, 6.74e-2, 3.30e-2],
    );
}

#[test]
fn a_ball_on_a_turntable() {
    let (mass, radius, turn, spin): (f64, f64, f64, f64) = (1.3, 0.5, 2.0, 0.7);
    let inertia = 0.4 * mass * radius * radius;
    let k = inertia / (inertia + mass * radius * radius) * turn;
    let (x0, v0) = ([0.3, -0.2], [0.5, 0.4]);
    // the contact point moves on a circle
    let x = |t: f64| {
        let (sin, cos) = (k * t).sin_cos();
        [
            x0[0] + (sin * v0[0] + (cos - 1.0) * v0[1]) / k,
            x0[1] + ((1.0 - cos) * v0[0] + sin * v0[1]) / k,
        ]
    };
    let v = |t: f64| {
        let (sin, cos) = (k * t).sin_cos();
        [cos * v0[0] - sin * v0[1], sin * v0[0] + cos * v0[1]]
    };
    let in_space = |t: f64| {
        let (x, v) = (x(t), v(t));
        [(turn * x[0] - v[1]) / radius, (v[0] + turn * x[1]) / radius, spin]
    };
    let start = unit([1.0, 0.2, -0.3, 0.4]);
    let until = 5.0;
    let end = dop853::integrate_from(
        |t, q| {
            let w = product(&transposed(&matrix(q)), in_space(t));
            rate(q, w)
        },
        (0.0, start),
        until,
        1e-13,
    );
    let of_body = |q: [f64; 4], t: f64| product(&transposed(&matrix(q)), in_space(t));
    let motion = Motion {
        q0: [start.as_slice(), &x0].concat(),
        v0: [of_body(start, 0.0).as_slice(), &v0].concat(),
        until,
        q: [end.as_slice(), &x(until)].concat(),
        v: [of_body(end, until).as_slice(), &v(until)].concat(),
    };
    let text = format!(
        "parameters {{ mass = {mass:?}, radius = {radius:?}, turn = {turn:?}, inertia = {inertia:?} }}
         coordinates(r: rotation, x: [2]);
         let o = r * r.angular_velocity();
         lagrangian = inertia * o.norm_squared() / 2 + mass * dot(x).norm_squared() / 2;
         nonholonomic = dot(x) + radius * [-o[1], o[0]] + turn * [x[1], -x[0]];"
    );
    motion.assert_errors(
        &text,
        0.1,
        [3.57e-3, 8.58e-4, 2.12e-4, 5.29e-5],
        [1.25e-2, 3.10e-3, 7.74e-4, 1.93e-4],
    );
}

#[test]
fn a_disk_that_rolls() {
    let (mass, radius, gravity) = (1.2, 0.6, 9.81);
    let (across, along) = (mass * radius * radius / 4.0, mass * radius * radius / 2.0);
    let inertia = [across, across, along];
    let up = |r: &Matrix| {
        let norm = r[2][0].hypot(r[2][1]);
        ([r[2][0] / norm, r[2][1] / norm, 0.0], norm)
    };
    let hand = |y: &[f64; 13]| {
        // the velocity of the centre follows from the rolling
        let (q, w): ([f64; 4], Vector) = (part(y, 0), part(y, 7));
        let r = matrix(q);
        let rates = cross(r[2], w);
        let (u, norm) = up(&r);
        let stretch = (r[2][0] * rates[0] + r[2][1] * rates[1]) / norm;
        let turned = plus(
            times(1.0 / norm, [rates[0], rates[1], 0.0]),
            times(-stretch / norm, u),
        );
        let v = times(radius, cross(w, u));
        let lever = transposed(&[0, 1, 2].map(|i| {
            let axis = [0, 1, 2].map(|j| if i == j { 1.0 } else { 0.0 });
            cross(u, cross(axis, u))
        }));
        let whole: Matrix = [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| if i == j { inertia[i] } else { 0.0 } + mass * radius * radius * lever[i][j])
        });
        let pushed = plus(
            plus(times(radius, cross(w, turned)), cross(w, v)),
            times(gravity, r[2]),
        );
        let momentum = [0, 1, 2].map(|i| inertia[i] * w[i]);
        let torque = plus(
            times(-1.0, cross(w, momentum)),
            times(-radius * mass, cross(u, pushed)),
        );
        let acceleration = solved(&whole, torque);
        let of_centre = times(
            radius,
            plus(
                cross(acceleration, u),
                plus(cross(w, turned), cross(w, cross(w, u))),
            ),
        );
        joined(&[
            &rate(q, w),
            &product(&r, v),
            &acceleration,
            &product(&r, of_centre),
        ])
    };
    let lean = core::f64::consts::FRAC_PI_2 - 0.25;
    let q = [(lean / 2.0).cos(), (lean / 2.0).sin(), 0.0, 0.0];
    let w = [0.3, 0.5, 5.0];
    let (u, norm) = up(&matrix(q));
    let q0: [f64; 7] = joined(&[&q, &[0.0, 0.0, radius * norm]]);
    let v0: [f64; 6] = joined(&[&w, &product(&matrix(q), times(radius, cross(w, u)))]);
    let motion = Motion::by_hand(hand, (&q0, &v0), 2.0);
    let text = |rows: &str| {
        format!(
            "parameters {{ mass = {mass:?}, radius = {radius:?}, g = {gravity:?}, across = {across:?}, along = {along:?} }}
             coordinates(r: rotation, x: [3]);
             let w = r.angular_velocity();
             let up = r.inverse() * [0, 0, 1];
             let n = [up[0], up[1]].norm();
             let slip = dot(x) - radius * (r * w.cross([up[0] / n, up[1] / n, 0]));
             lagrangian = across / 2 * (w[0].powi(2) + w[1].powi(2)) + along / 2 * w[2].powi(2)
                 + mass * dot(x).norm_squared() / 2 - mass * g * x[2];
             {rows}"
        )
    };
    motion.assert_errors(
        &text("nonholonomic = slip;"),
        0.04,
        [2.16e-3, 5.57e-4, 1.42e-4, 3.59e-5],
        [1.75e-2, 4.32e-3, 1.08e-3, 2.69e-4],
    );
    motion.assert_errors(
        &text("nonholonomic = [slip[0], slip[1]]; holonomic = x[2] - radius * n;"),
        0.04,
        [2.84e-3, 7.28e-4, 1.85e-4, 4.65e-5],
        [2.26e-2, 5.61e-3, 1.40e-3, 3.49e-4],
    );
}

/// A body under a torque given in its own frame, and the torque in space.
#[test]
fn a_torque_from_outside_acts_at_both_ends_of_a_leg() {
    let inertia = [2.0, 1.5, 1.0];
    let hand = |y: &[f64; 7]| {
        let (q, w): ([f64; 4], Vector) = (part(y, 0), part(y, 4));
        let momentum = [0, 1, 2].map(|i| inertia[i] * w[i]);
        let drag = times(-0.3, w);
        let driven = times(0.5, matrix(q)[2]);
        let torque = plus(cross(momentum, w), plus(drag, driven));
        joined(&[&rate(q, w), &[0, 1, 2].map(|i| torque[i] / inertia[i])])
    };
    let motion = Motion::by_hand(hand, (&unit([1.0, 0.3, -0.4, 0.2]), &[0.6, -0.3, 2.0]), 4.0);
    let mut last = None;
    for maps in ["", "phi_lagrangian = trapezoid;", "phi_lagrangian = midpoint;"] {
        let text = format!(
            "coordinates(r: rotation);
             let w = r.angular_velocity();
             lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2;
             external_forces = -0.3 * w + r.inverse() * [0, 0, 0.5];
             {maps}"
        );
        let text = Text::parse("driven", &text).unwrap();
        let v0 = [&[0.0], motion.v0.as_slice()].concat();
        let error = |h: f64| {
            let mut flow = AnyFlow::new(&text.system, h, &AnyStart::second_order(&motion.q0, &v0)).unwrap();
            flow.run_mut().to(motion.until).unwrap();
            let mut node = OwnedNode::new(4);
            node.take(flow.run());
            let q = node.any().q.to_vec();
            let apart = q.iter().zip(&motion.q).map(|(q, known)| (q - known).abs());
            apart.fold(0.0, f64::max)
        };
        let errors = [0.04, 0.02, 0.01].map(error);
        for pair in errors.windows(2) {
            assert!(
                ((pair[0] / pair[1]).log2() - 2.0).abs() < 0.05,
                "{maps}: {errors:?}"
            );
        }
        // the paper's map takes the forces of the trapezoid
        if maps.contains("trapezoid") {
            assert_eq!(last, Some(errors));
        }
        last = Some(errors);
    }
}

#[test]
fn the_norm_stays_one_and_a_step_back_leads_back() {
    let text = Text::parse(
        "free",
        "coordinates(r: rotation);
         let w = r.angular_velocity();
         lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2;",
    )
    .unwrap();
    // the norm deviates from one by 1e-8, and is corrected
    let start = AnyStart::second_order(&[1.0 + 1e-8, 0.0, 0.0, 0.0], &[0.0, 0.5, 2.0, -0.3]);
    let mut flow = AnyFlow::new(&text.system, 1e-3, &start).unwrap();
    let norm = |flow: &AnyFlow<'_>| flow.leg().q.iter().map(|q| q * q).sum::<f64>().sqrt();
    flow.run_mut().to(200.0).unwrap();
    assert!((norm(&flow) - 1.0).abs() <= 2.0 * f64::EPSILON, "{}", norm(&flow));
    let mut node = OwnedNode::new(4);
    node.take(flow.run());
    let energy = node.any().energy;
    assert!((energy - (0.25 + 0.75 * 4.0 + 0.045)).abs() < 1e-5, "{energy}");
    flow.run_mut().reverse().unwrap();
    flow.run_mut().to(0.0).unwrap();
    node.take(flow.run());
    for (q, first) in node.any().q.iter().zip([1.0, 0.0, 0.0, 0.0]) {
        assert!((q - first).abs() < 1e-9, "{:?}", node.any().q);
    }
}

/// A top of two bodies joined by a rotation, and a mass on a spring in the second.
#[dsocs {
    coordinates(s, r: rotation, q: rotation);
    let w = r.angular_velocity();
    let u = (r * q).angular_velocity();
    let place = r * (q * [s, 0, 1]);
    lagrangian = w.inner(inertia * w) / 2 + u.inner(inertia * u) / 2 + mass * dot(place).norm_squared() / 2 - mass * place[2] - s.powi(2);
    external_forces = (-0.1 * dot(s), -0.1 * w, 0);
    observe = [place];
}]
struct Gimbal {
    mass: f64,
    inertia: [[f64; 3]; 3],
}

#[test]
fn a_body_that_spins_evenly_is_followed_for_as_long_as_it_spins() {
    // a constant angular velocity does not limit the step; alone, and beside a spring
    let spins = "coordinates(r: rotation, x); let w = r.angular_velocity(); \
        lagrangian = w.inner([[3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]] * w) / 2 + dot(x).powi(2) / 2 - x.powi(2) / 2;";
    let text = Text::parse("spins", spins).unwrap();
    for (axis, x) in [(1, 0.0), (2, 0.0), (3, 0.3)] {
        let mut v0 = [0.0; 5];
        v0[axis] = 1.0;
        let start = AnyStart::second_order(&[1.0, 0.0, 0.0, 0.0, x], &v0);
        for tolerance in [1e-4, 1e-8, 1e-12] {
            let tolerance_of = Tolerance::relative(tolerance);
            let mut taylor = AnyTaylorFlow::of_tape(&text.system, &start, tolerance_of).unwrap();
            let run: &mut dyn Run = &mut taylor;
            for until in [7.0, 100.0, 240.0_f64] {
                run.to(until).unwrap();
                let mut node = OwnedNode::new(5);
                node.take(run);
                let (sine, cosine) = (0.5 * until).sin_cos();
                let q = node.any().q;
                let apart = (q[0] - cosine).abs().max((q[axis] - sine).abs());
                assert!(
                    apart < 100.0 * tolerance.max(1e-13),
                    "{axis} {tolerance:e} {until}: {q:?}"
                );
            }
        }
    }
}

#[test]
fn a_compiled_system_has_the_bits_of_its_text() {
    let system = Gimbal {
        mass: 0.5,
        inertia: [[2.0, 0.1, 0.0], [0.1, 1.5, 0.0], [0.0, 0.0, 1.0]],
    };
    let declaration = dsocs_core::System::kernel(&system).shape().declaration.clone();
    let text = Text::parse(
        "gimbal",
        &format!("parameters {{ mass = 0.5, inertia = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.0], [0.0, 0.0, 1.0]] }} {declaration}"),
    )
    .unwrap();
    let q0 = [0.1, 0.6, 0.8, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    let v0 = [0.2, 0.0, 0.3, -0.2, 1.5, 0.0, 0.1, 0.4, -0.6];
    let mut compiled = Flow::new(&system, 0.01, Start::second_order(q0, v0)).unwrap();
    let last = compiled.to(5.0).unwrap();
    let mut read = AnyFlow::new(&text.system, 0.01, &AnyStart::second_order(&q0, &v0)).unwrap();
    read.run_mut().to(5.0).unwrap();
    let mut node = OwnedNode::new(9);
    node.take(read.run());
    let node = node.any();
    let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&last.q), bits(node.q));
    assert_eq!(bits(&last.force), bits(node.force));
    assert_eq!(last.energy.to_bits(), node.energy.to_bits());
    // the series too, and its end
    let tolerance = Tolerance::relative(1e-13);
    let mut taylor = TaylorFlow::new(&system, Start::second_order(q0, v0), tolerance).unwrap();
    let exact = taylor.to(5.0).unwrap();
    let mut read =
        AnyTaylorFlow::of_tape(&text.system, &AnyStart::second_order(&q0, &v0), tolerance).unwrap();
    let run: &mut dyn Run = &mut read;
    run.to(5.0).unwrap();
    let mut node = OwnedNode::new(9);
    node.take(run);
    assert_eq!(bits(&exact.q), bits(node.any().q));
    assert_eq!(bits(&exact.v), bits(node.any().v));
    for (q, exact) in last.q.iter().zip(exact.q) {
        assert!((q - exact).abs() < 1e-3, "{:?}\n{exact:?}", last.q);
    }
    // between nodes as at nodes: the motion with half the step
    let every = |h: f64| {
        let mut flow = Flow::new(&system, h, Start::second_order(q0, v0)).unwrap();
        flow.until(1.0).unwrap()
    };
    let (coarse, fine) = (every(0.01), every(0.005));
    for node in fine.nodes.iter().skip(1).step_by(2) {
        let between = coarse.at(node.t).unwrap();
        let apart = |one: &[f64], other: &[f64]| {
            let apart = one.iter().zip(other).map(|(one, other)| (one - other).abs());
            apart.fold(0.0, f64::max)
        };
        // both are of order 2; a quaternion whose rate were taken to be the angular velocity would be off by 1e-3
        assert!(apart(&between.q, &node.q) < 5e-5, "{between:?}\n{node:?}");
        assert!(apart(&between.v, &node.v) < 2e-4, "{between:?}\n{node:?}");
    }
    // and both rotations are of norm one
    for quaternion in [&last.q[1..5], &last.q[5..]] {
        let norm = quaternion.iter().map(|q| q * q).sum::<f64>().sqrt();
        assert!((norm - 1.0).abs() <= 2.0 * f64::EPSILON, "{norm}");
    }
}

#[test]
fn a_start_far_from_the_norm_one_is_refused_and_so_is_what_cannot_be_had_yet() {
    let text = Text::parse(
        "free",
        "coordinates(x, r: rotation); lagrangian = dot(x).powi(2) + r.angular_velocity().norm_squared();",
    )
    .unwrap();
    let refused = |start: &AnyStart| AnyFlow::new(&text.system, 0.1, start).map(drop).unwrap_err();
    let v0 = [0.0; 5];
    let error = refused(&AnyStart::second_order(&[0.0, 1.0, 0.1, 0.0, 0.0], &v0));
    assert!(
        matches!(&error, SetupError::Quaternion { rotation, norm } if rotation == "r" && (norm - 1.005).abs() < 1e-3),
        "{error}"
    );
    let one = [0.0, 1.0, 0.0, 0.0, 0.0];
    // a start by two nodes depends on the rotation between them, and not on the signs of the quaternions
    let turned = [0.0, -(0.05_f64.cos()), 0.0, 0.0, -(0.05_f64.sin())];
    let flow = AnyFlow::new(&text.system, 0.1, &AnyStart::nodes(&one, &turned)).unwrap();
    let d = flow.leg().d.to_vec();
    assert!(
        (d[4] - 0.1).abs() < 1e-7 && d[..4].iter().all(|d| d.abs() < 1e-16),
        "{d:?}"
    );
    assert!(flow.leg().q[1] > 0.9);
    // the first component of a quaternion's velocity must be zero
    let mut wrong = v0;
    wrong[1] = 0.5;
    let error = refused(&AnyStart::second_order(&one, &wrong));
    assert!(
        matches!(error, SetupError::AngularVelocity { value: 0.5, .. }),
        "{error}"
    );
}

#[test]
fn a_step_that_turns_by_half_a_turn_is_refused() {
    let text = Text::parse(
        "driven",
        "coordinates(r: rotation);
         lagrangian = r.angular_velocity().norm_squared() / 2;
         external_forces = [0, 0, 1];",
    )
    .unwrap();
    let one = [1.0, 0.0, 0.0, 0.0];
    let start = |spin: f64| AnyStart::second_order(&one, &[0.0, 0.0, 0.0, spin]);
    let error = AnyFlow::new(&text.system, 0.1, &start(40.0))
        .map(drop)
        .unwrap_err();
    assert!(
        matches!(&error, SetupError::Turn { rotation, turn, .. } if rotation == "r" && (turn - 4.005).abs() < 1e-12),
        "{error}"
    );
    // the angle of a step, 0.1 (20 + t), reaches 3 at t = 10; the increment, which is a little shorter,
    // reaches it later
    let mut flow = AnyFlow::new(&text.system, 0.1, &start(20.0)).unwrap();
    let error = flow.run_mut().to(20.0).unwrap_err();
    assert!((flow.run().clock().time() - 10.0).abs() < 1.0, "{error}");
    assert!(
        error.to_string().contains("half a turn or more in this step"),
        "{error}"
    );
    // with shorter steps it is as it should be: the angle is 20 t + t²/2
    let mut flow = AnyFlow::new(&text.system, 0.01, &start(20.0)).unwrap();
    flow.run_mut().to(10.0).unwrap();
    let mut node = OwnedNode::new(4);
    node.take(flow.run());
    let q = node.any().q.to_vec();
    let half: f64 = 0.5 * (200.0 + 50.0);
    for (q, exact) in [(q[0], half.cos()), (q[3], half.sin())] {
        assert!((q - exact).abs() < 5e-3, "{q} {exact}");
    }
}
