//! Derivatives of runs across jumps of the acceleration: refused where the place of the jump moves with the variables, since those of the discrete
//! run do not converge there, and right where it does not. References are closed forms, differentiated by central differences.

use dsocs_core::text::Text;
use dsocs_core::{AnyPath, AnyStart, DerivativeError, Variable};

/// Numbers between 0 and 1.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.next()
    }
}

const END: f64 = 2.0;

/// A system with its parameters.
fn system(parameters: &[(&str, f64)], motion: &str) -> Text {
    let known: Vec<String> = parameters
        .iter()
        .map(|(name, value)| format!("{name} = {value:?}"))
        .collect();
    let text = format!("parameters {{ {} }} coordinates(x); {motion}", known.join(", "));
    Text::parse("jumps", &text).unwrap()
}

fn path(text: &Text, h: f64, start: [f64; 2]) -> Result<AnyPath<'_>, DerivativeError> {
    AnyPath::new(
        &text.system,
        h,
        &AnyStart::second_order(&[start[0]], &[start[1]]),
        END,
    )
}

/// The central difference of a function by one of its arguments.
fn difference<const P: usize>(f: impl Fn([f64; P]) -> f64, at: [f64; P], place: usize) -> f64 {
    let shifted = |by: f64| {
        let mut at = at;
        at[place] += by;
        f(at)
    };
    (shifted(1e-5) - shifted(-1e-5)) / 2e-5
}

/// The time after which a parabola `x + v t + a t²/2` first leaves the side of zero on which it is, if it does.
fn leaves([x, v, a]: [f64; 3], side: f64) -> Option<f64> {
    let root = v * v - 2.0 * a * x;
    let times = [-1.0, 1.0].map(|sign| (-v + sign * root.sqrt()) / a);
    let away = times
        .into_iter()
        .filter(|t| root > 0.0 && *t > 0.0 && side * (v + a * t) < 0.0);
    away.reduce(f64::min)
}

/// The position at the end under the force `push - k sign(x - c)`, and the number of crossings.
fn bounced([k, c, push, x0, v0]: [f64; 5]) -> (f64, u32) {
    let (mut t, mut x, mut v, mut side, mut crossings) = (0.0, x0 - c, v0, (x0 - c).signum(), 0);
    loop {
        let a = push - k * side;
        match leaves([x, v, a], side) {
            Some(after) if t + after < END => {
                (t, x, v) = (t + after, 0.0, v + a * after);
                side = -side;
                crossings += 1;
            }
            _ => {
                let rest = END - t;
                return (c + x + rest * (v + 0.5 * a * rest), crossings);
            }
        }
    }
}

#[test]
fn a_jump_with_the_position_is_refused_if_it_is_crossed() {
    let mut draws = Draws(5);
    let mut counts = [0; 2];
    for _ in 0..40 {
        let [k, c, push] = [
            draws.between(0.5, 2.0),
            draws.between(-0.5, 0.5),
            draws.between(-0.3, 0.3),
        ];
        let start = [c + draws.between(0.3, 2.0), draws.between(-0.5, 1.5)];
        let all = [k, c, push, start[0], start[1]];
        let (end, crossings) = bounced(all);
        let parameters = [("k", k), ("c", c), ("push", push)];
        let text = system(
            &parameters,
            "lagrangian = dot(x).powi(2) / 2 + push * x - k * (x - c).abs();",
        );
        let forced = system(
            &parameters,
            "lagrangian = dot(x).powi(2) / 2; external_forces = push - k * (x - c).signum();",
        );
        for (text, h) in [(&text, 0.01), (&text, 0.001), (&forced, 0.01), (&forced, 0.001)] {
            let found = path(text, h, start);
            counts[usize::from(crossings > 0)] += 1;
            if crossings > 0 {
                let error = found.unwrap_err();
                let DerivativeError::MovingJump { argument, .. } = &error else {
                    panic!("{error}");
                };
                assert_eq!(argument, "x - c");
                assert!(error.to_string().contains("does not converge"), "{error}");
                continue;
            }
            let found = found.unwrap();
            assert!((found.end().q[0] - end).abs() < 1e-9, "{:?} {end}", found.end().q);
            let gradient = found.gradient_at_end(&mut |end| end.q[0]).unwrap();
            for (place, by) in gradient
                .parameters
                .iter()
                .chain(&gradient.q0)
                .chain(&gradient.v0)
                .enumerate()
            {
                let exact = difference(|all| bounced(all).0, all, place);
                assert!((by - exact).abs() < 1e-6, "{place}: {by} {exact}");
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 10), "{counts:?}");
}

/// The position at the end on a spring `k` with the dry friction `dry`, and the number of reversals; it does not come to rest.
fn rubbed([k, dry, x0, v0]: [f64; 4]) -> (f64, u32) {
    let w = k.sqrt();
    let (mut t, mut x, mut v, mut reversals) = (0.0, x0, v0, 0);
    loop {
        let side = if v == 0.0 { -x.signum() } else { v.signum() };
        // about the place where spring and friction balance
        let from = x + side * dry / k;
        let [phase, size] = [f64::atan2(-v / w, from), from.hypot(v / w)];
        let turn = if side < 0.0 { core::f64::consts::PI } else { 0.0 };
        let mut after = (turn - phase) / w;
        while after <= 1e-12 {
            after += core::f64::consts::TAU / w;
        }
        let by = after.min(END - t);
        x = size * (phase + w * by).cos() - side * dry / k;
        if by < after {
            return (x, reversals);
        }
        (t, v) = (t + after, 0.0);
        reversals += 1;
    }
}

/// The force is as large before a reversal as after it only without friction: the place of the reversal moves the velocity after it.
#[test]
fn friction_that_changes_its_direction_is_refused() {
    let mut draws = Draws(13);
    let mut counts = [0; 2];
    for _ in 0..40 {
        let all = [
            draws.between(0.2, 4.0),
            draws.between(0.05, 0.1),
            draws.between(1.5, 3.0),
            draws.between(-3.0, -0.5),
        ];
        let [k, dry, x0, v0] = all;
        let text = system(
            &[("k", k), ("dry", dry)],
            "lagrangian = dot(x).powi(2) / 2 - k / 2 * x.powi(2); external_forces = -dry * dot(x).signum();",
        );
        let (end, reversals) = rubbed(all);
        counts[usize::from(reversals > 0)] += 1;
        let found = path(&text, 0.001, [x0, v0]);
        if reversals > 0 {
            let error = found.unwrap_err();
            let is_refused = matches!(
                error,
                DerivativeError::MovingJump { .. } | DerivativeError::Jump { .. }
            );
            assert!(is_refused, "{error}");
            continue;
        }
        let found = found.unwrap();
        assert!((found.end().q[0] - end).abs() < 1e-5);
        let gradient = found.gradient_at_end(&mut |end| end.q[0]).unwrap();
        for (place, by) in gradient
            .parameters
            .iter()
            .chain(&gradient.q0)
            .chain(&gradient.v0)
            .enumerate()
        {
            let exact = difference(|all| rubbed(all).0, all, place);
            assert!((by - exact).abs() < 1e-5, "{place}: {by} {exact}");
        }
    }
    assert!(counts.iter().all(|count| *count > 5), "{counts:?}");
}

/// The position at the end under a force that changes its value at the time `s`.
fn switched([s, before, after, x0, v0]: [f64; 5]) -> f64 {
    let (x, v, rest) = (x0 + s * (v0 + 0.5 * before * s), v0 + before * s, END - s);
    x + rest * (v + 0.5 * after * rest)
}

/// Only the time of the jump has no derivative: it alone moves the place.
#[test]
fn a_jump_in_time_has_derivatives_by_what_does_not_move_it() {
    let mut draws = Draws(7);
    for _ in 0..20 {
        let all: [f64; 5] = core::array::from_fn(|i| {
            if i == 0 {
                draws.between(0.4, 1.6)
            } else {
                draws.between(-1.0, 1.0)
            }
        });
        let [s, before, after, x0, v0] = all;
        let text = system(
            &[("s", s), ("before", before), ("after", after)],
            "lagrangian = dot(x).powi(2) / 2; external_forces = if t < s { before } else { after };",
        );
        let path = path(&text, 0.001, [x0, v0]).unwrap();
        let variables = [
            Variable::Parameter("before"),
            Variable::Parameter("after"),
            Variable::Position(0),
            Variable::Velocity(0),
        ];
        let tangents = path.tangents(&variables).unwrap();
        for (number, tangent) in tangents.iter().enumerate() {
            let exact = difference(switched, all, number + 1);
            assert!(
                (tangent.q[0] - exact).abs() < 2e-3,
                "{number}: {} {exact}",
                tangent.q[0]
            );
        }
        let jump = |error: DerivativeError| match error {
            DerivativeError::MovingJump { time, others, .. } => {
                assert!(
                    (time - s).abs() < 2e-3 && others.contains("tangents"),
                    "{time} {s}"
                );
            }
            other => panic!("{other}"),
        };
        jump(path.tangents(&[Variable::Parameter("s")]).unwrap_err());
        jump(path.gradient_at_end(&mut |end| end.q[0]).unwrap_err());
        // the same jump at a time that is no parameter
        let fixed = system(
            &[("before", before), ("after", after)],
            &format!(
                "lagrangian = dot(x).powi(2) / 2; external_forces = if t < {s:?} {{ before }} else {{ after }};"
            ),
        );
        let fixed = self::path(&fixed, 0.001, [x0, v0])
            .unwrap()
            .gradient_at_end(&mut |end| end.q[0])
            .unwrap();
        for (by, tangent) in fixed.parameters.iter().zip(tangents.iter()) {
            assert!((by - tangent.q[0]).abs() < 1e-12);
        }
    }
}

/// The position at the end on a spring that only pushes, `k max(c - x, 0)`, and the number of pieces of the motion.
fn pushed([k, c, x0, v0]: [f64; 4]) -> (f64, u32) {
    let (mut t, mut x, mut v, mut is_free, mut pieces) = (0.0, x0 - c, v0, x0 > c, 0);
    loop {
        pieces += 1;
        let w = k.sqrt();
        // the time until it touches, or is free
        let way = if !is_free {
            core::f64::consts::PI / w
        } else if v < 0.0 {
            -x / v
        } else {
            f64::INFINITY
        };
        let by = way.min(END - t);
        if way >= END - t {
            return (
                c + if is_free {
                    x + by * v
                } else {
                    v / w * (w * by).sin()
                },
                pieces,
            );
        }
        (t, x, v) = (t + by, 0.0, if is_free { v } else { -v });
        is_free = !is_free;
    }
}

#[test]
fn a_corner_of_the_force_has_derivatives() {
    let mut draws = Draws(11);
    let mut most = 0;
    for _ in 0..20 {
        let all = [
            draws.between(4.0, 30.0),
            draws.between(-0.2, 0.2),
            draws.between(0.3, 0.8),
            draws.between(-3.0, -1.0),
        ];
        let [k, c, x0, v0] = all;
        most = most.max(pushed(all).1);
        for motion in [
            "lagrangian = dot(x).powi(2) / 2; external_forces = k * (c - x).max(0.0);",
            "lagrangian = dot(x).powi(2) / 2 - k / 2 * (c - x).max(0.0).powi(2);",
        ] {
            let text = system(&[("k", k), ("c", c)], motion);
            let path = path(&text, 5e-4, [x0, v0]).unwrap();
            let gradient = path.gradient_at_end(&mut |end| end.q[0]).unwrap();
            for (place, by) in gradient
                .parameters
                .iter()
                .chain(&gradient.q0)
                .chain(&gradient.v0)
                .enumerate()
            {
                let exact = difference(|all| pushed(all).0, all, place);
                assert!(
                    (by - exact).abs() < 0.02 * (1.0 + exact.abs()),
                    "{all:?} {place}: {by} {exact}"
                );
            }
        }
    }
    assert!(most >= 3, "{most}");
}

/// The errors of a path of few steps in memory, and of a plan, are those of the whole path.
#[test]
fn checkpoints_and_plans_refuse_the_same() {
    let text = system(
        &[("k", 1.0), ("push", 0.0)],
        "lagrangian = dot(x).powi(2) / 2 - k * x.abs(); external_forces = push;",
    );
    let start = AnyStart::second_order(&[0.5], &[0.1]);
    let whole = AnyPath::new(&text.system, 0.01, &start, END).unwrap_err();
    let few = AnyPath::within(&text.system, 0.01, &start, END, 2000).unwrap_err();
    assert_eq!(whole, few);
    let values = vec![&[0.0][..]; 200];
    let plan = AnyPath::plan(&text.system, 0.01, &start, &["push"], &values).unwrap_err();
    assert_eq!(whole, plan);
}
