//! Laws whose acceleration is 0/0 at a place, as `p v (v + c) / x` with the solutions `v = -c + C |x|^p`: all arrive at `x = 0` with `v = -c`, and
//! the motion does not tell which one continues it. What is singular in a motion falls below the tolerance before that place. For a whole `p` the
//! solutions are smooth, and go on; so does a quotient with a limit.
//!
//! The reference is the closed form, and DOP853 on the same force, which meets no zero of the divisor.

use dsocs_core::SeriesFailure;
use dsocs_core::prelude::{RunError, Start, Stepper, Tolerance};
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::{System, TaylorFlow};
use dsocs_tests::{declared, dop853, short_or_long};

declared! {
    /// The law as a force.
    #[derive(Debug)]
    struct Force { p: f64, c: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = p * dot(x) * (dot(x) + c) / x;
}

declared! {
    /// The law as a constraint.
    #[derive(Debug)]
    struct Row { p: f64, c: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = x * ddot(x) - p * dot(x) * (dot(x) + c);
    constraint_forces = [(1)];
}

declared! {
    /// The law as a constraint whose factor touches zero.
    #[derive(Debug)]
    struct Touching { p: f64, c: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = x.powi(2) * ddot(x) - p * x * dot(x) * (dot(x) + c);
    constraint_forces = [(1)];
}

declared! {
    /// The law by a mass that vanishes.
    #[derive(Debug)]
    struct Mass { p: f64, c: f64 };
    coordinates(x);
    lagrangian = x * dot(x).powi(2) / 2;
    external_forces = dot(x).powi(2) / 2 + p * dot(x) * (dot(x) + c);
}

declared! {
    /// The law by a leaning constraint force.
    #[derive(Debug)]
    struct Leans { p: f64, c: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    external_forces = (0, -p * dot(x) * (dot(x) + c));
    holonomic = y;
    constraint_forces = [(1, x)];
}

declared! {
    /// The law as a force, beside a motion with other accelerations.
    #[derive(Debug)]
    struct Swings { p: f64, c: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 2 * y.powi(2) - y;
    external_forces = (p * dot(x) * (dot(x) + c) / x, 0);
}

declared! {
    /// The law for the distance from a place that moves.
    #[derive(Debug)]
    struct Moves { p: f64, c: f64, w: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    let v = dot(x) - w;
    external_forces = p * v * (v + c) / (x - w * t);
}

declared! {
    /// The law for a sum of two coordinates, of which one swings.
    #[derive(Debug)]
    struct Coupled { p: f64, c: f64, k: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 2 * y.powi(2);
    let v = dot(x) + k * dot(y);
    external_forces = (p * v * (v + c) / (x + k * y) + 4 * k * y, 0);
}

declared! {
    /// A mass matrix that is singular on a line, together with its right-hand side.
    #[derive(Debug)]
    struct Matrix { p: f64, c: f64 };
    coordinates(x, y);
    lagrangian = x * dot(x).powi(2) / 2 + dot(x) * dot(y) * x / 4 + dot(y).powi(2) / 2;
    external_forces = (
        dot(x).powi(2) / 2 + p * (1 - x / 16) * dot(x) * (dot(x) + c),
        dot(x).powi(2) / 4
    );
}

/// The position and the velocity at the end of a run.
fn run<S: System<N>, const N: usize>(
    system: &S,
    [q0, v0]: [[f64; N]; 2],
    tolerance: f64,
    until: f64,
) -> Result<[[f64; N]; 2], RunError> {
    let start = Start::second_order(q0, v0);
    let mut flow = TaylorFlow::new(system, start, Tolerance::relative(tolerance)).unwrap();
    let node = flow.to(until)?;
    Ok([node.q, node.v])
}

/// The time from `x0` to 0 with `v = -c + C x^p`, by Gauss and Legendre on parts that shorten towards 0.
fn arrival(p: f64, c: f64, [x0, v0]: [f64; 2]) -> f64 {
    let rise = (v0 + c) / x0.powf(p);
    let (mut to, mut sum) = (x0, 0.0);
    for _ in 0..200 {
        let from = 0.8 * to;
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        for (at, weight) in [
            (-0.6_f64.sqrt(), 5.0 / 9.0),
            (0.0, 8.0 / 9.0),
            (0.6_f64.sqrt(), 5.0 / 9.0),
        ] {
            sum += weight * half / (c - rise * (middle + at * half).powf(p));
        }
        to = from;
    }
    sum
}

/// The time at which a failed run says that its motion ends.
fn ended(error: &RunError) -> Option<f64> {
    let RunError::Series(error) = error else {
        return None;
    };
    Some(error.ends_at())
}

#[test]
fn no_tolerance_passes_a_node() {
    let (mut wrong, mut runs, mut named) = (Vec::new(), 0, 0);
    for draw in 0..short_or_long(40, 400) {
        let mut random = Random::new(11_300 + draw);
        let p = loop {
            let p = random.between(0.15, 3.8);
            if f64::abs(p - p.round()) > 0.03 {
                break p;
            }
        };
        let c = random.between(0.6, 1.6);
        let at = random.between(0.5, 1.5);
        let v = -c * (1.0 + random.between(-0.7, 0.7));
        let [w, k, y] = [(); 3].map(|()| random.between(-0.4, 0.4));
        let tolerance = random.decades(1e-12, 1e-5);
        let arrives = arrival(p, c, [at, v]);
        let until = arrives + 1.0;
        let mut count = |law: &dyn core::fmt::Debug, end: Result<(), RunError>| {
            runs += 1;
            let time = end.as_ref().err().and_then(ended);
            named += u32::from(
                matches!(&end, Err(RunError::Series(error)) if matches!(error.details().cause, SeriesFailure::NotUnique { .. })),
            );
            if time.is_none_or(|time| f64::abs(time - arrives) > 0.02) {
                wrong.push(format!(
                    "{draw} {law:?} at {at}, v = {v}, to {tolerance}, ends at {arrives}: {end:?}"
                ));
            }
        };
        let one = [[at], [v]];
        let two = [[at, 0.0], [v, 0.0]];
        let law = Force { p, c };
        count(&law, run(&law, one, tolerance, until).map(|_| ()));
        let law = Row { p, c };
        count(&law, run(&law, one, tolerance, until).map(|_| ()));
        let law = Touching { p, c };
        count(&law, run(&law, one, tolerance, until).map(|_| ()));
        let law = Mass { p, c };
        count(&law, run(&law, one, tolerance, until).map(|_| ()));
        let law = Leans { p, c };
        count(&law, run(&law, two, tolerance, until).map(|_| ()));
        let law = Swings { p, c };
        count(&law, run(&law, two, tolerance, until).map(|_| ()));
        let law = Moves { p, c, w };
        count(&law, run(&law, [[at], [v + w]], tolerance, until).map(|_| ()));
        let law = Coupled { p, c, k };
        count(
            &law,
            run(&law, [[at - k * y, y], [v, 0.0]], tolerance, until).map(|_| ()),
        );
        let law = Matrix { p, c };
        count(&law, run(&law, [[at, y], [v, 0.3]], tolerance, until).map(|_| ()));
    }
    println!("{runs} runs, {named} of them end as not unique");
    assert!(wrong.is_empty(), "{}: {wrong:#?}", wrong.len());
}

declared! {
    /// A rod that slides with one end on a table: with much friction, its normal force is 0/0 where its determinant vanishes.
    #[derive(Debug)]
    struct Rod { mu: f64, j: f64 };
    coordinates(x, y, theta);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2) + j * dot(theta).powi(2)) / 2 - 9.81 * y;
    holonomic = y - theta.sin();
    constraint_forces = [(mu, 1, mu * theta.sin() - theta.cos())];
}

#[test]
fn rods_end_where_their_normal_force_is_undetermined() {
    for draw in 0..short_or_long(12, 120) {
        let mut random = Random::new(12_700 + draw);
        let law = Rod {
            mu: random.between(1.6, 4.0),
            j: random.between(0.2, 0.33),
        };
        let tolerance = random.decades(1e-12, 1e-5);
        let theta: f64 = 1.0;
        let end = run(
            &law,
            [[0.0, theta.sin(), theta], [random.between(1.0, 3.0), 0.0, 0.0]],
            tolerance,
            3.0,
        );
        let Err(RunError::Series(error)) = end else {
            panic!("{law:?} {tolerance} {end:?}")
        };
        let theta = error.details().q[2];
        let determinant = law.j + theta.cos() * (theta.cos() - law.mu * theta.sin());
        assert!(
            determinant.abs() < 0.02,
            "{law:?} {tolerance} {determinant} {error}"
        );
    }
}

declared! {
    /// A force whose divisor passes zero, where it has a limit.
    #[derive(Debug)]
    struct Removable { k: f64, by: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -k * (by * x).sin() / x + k * by - x;
}

declared! {
    /// The same with a divisor of time.
    #[derive(Debug)]
    struct Chases { k: f64, by: f64 };
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    let u = x - by * t.sin();
    external_forces = k * (x.sin() - (by * t.sin()).sin()) / u - x + k * u.sin() / u;
}

declared! {
    /// The same with velocities, and with poles that cancel each other.
    #[derive(Debug)]
    struct Cancels { k: f64, by: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.powi(2) / 2 - by * y.powi(2);
    let u = dot(x) + dot(y);
    external_forces = (k * u.tanh() / u, k * (1 / u - u.cos() / u));
}

declared! {
    /// A constraint with a factor that vanishes.
    #[derive(Debug)]
    struct Factor { k: f64, by: f64 };
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - by * y.powi(2);
    kinematic = (x - k * y) * (ddot(x) + x);
    constraint_forces = [(1, 0)];
}

#[test]
fn quotients_with_a_limit_are_passed() {
    for draw in 0..short_or_long(12, 120) {
        let mut random = Random::new(11_700 + draw);
        let at = random.between(0.5, 1.5);
        let (k, by) = (random.between(0.2, 1.5), random.between(0.3, 2.0));
        let v = random.between(-2.0, -0.5);
        let tolerance = random.decades(1e-12, 1e-5);
        let until = 10.0;
        let good = |law: &dyn core::fmt::Debug, found: Result<f64, RunError>, x: f64| {
            let apart = found.as_ref().map_or(f64::NAN, |found| (found - x).abs());
            assert!(
                apart < 1e4 * tolerance.max(1e-13),
                "{draw} {law:?} {at} {v} {tolerance} {found:?} {x}"
            );
        };
        let exact = |force: &dyn Fn(f64, f64, f64) -> f64| {
            let [x, _] =
                dop853::integrate_from(|t, [x, v]| [v, force(t, x, v)], (0.0, [at, v]), until, 1e-13);
            x
        };
        let law = Removable { k, by };
        let x = exact(&|_, x, _| -k * (by * x).sin() / x + k * by - x);
        good(
            &law,
            run(&law, [[at], [v]], tolerance, until).map(|[q, _]| q[0]),
            x,
        );
        let law = Chases { k, by };
        let x = exact(&|t, x, _| {
            let place = by * t.sin();
            // a difference of sines by a product
            let u = x - place;
            let sinc = |u: f64| if u == 0.0 { 1.0 } else { u.sin() / u };
            k * sinc(0.5 * u) * (0.5 * (x + place)).cos() - x + k * sinc(u)
        });
        good(
            &law,
            run(&law, [[at], [v]], tolerance, until).map(|[q, _]| q[0]),
            x,
        );
        let law = Cancels { k, by };
        let [x, ..] = dop853::integrate(
            |_, [x, y, v, w]| {
                let u: f64 = v + w;
                let part = 0.5 * u;
                let cosine = if u == 0.0 { 0.0 } else { part.sin().powi(2) / part };
                let tangent = if u == 0.0 { 1.0 } else { u.tanh() / u };
                [v, w, -x + k * tangent, -2.0 * by * y + k * cosine]
            },
            [at, 0.3, v, 0.1],
            until,
            1e-13,
        );
        good(
            &law,
            run(&law, [[at, 0.3], [v, 0.1]], tolerance, until).map(|[q, _]| q[0]),
            x,
        );
        let law = Factor { k, by };
        let x = at * until.cos() + v * until.sin();
        good(
            &law,
            run(&law, [[at, 0.3], [v, 0.1]], tolerance, until).map(|[q, _]| q[0]),
            x,
        );
    }
}

#[test]
fn smooth_motions_pass_a_node() {
    let (mut runs, mut refused) = (0, 0);
    for draw in 0..short_or_long(12, 120) {
        let mut random = Random::new(12_400 + draw);
        let c = random.between(0.6, 1.6);
        let at = random.between(0.5, 1.5);
        let rise = c * random.between(-0.4, 0.4);
        let tolerance = random.decades(1e-12, 1e-6);
        for p in [1, 2, 3] {
            let of = |x: f64| -c + rise * (x / at).powi(p);
            let start = [[at], [of(at)]];
            let until = 1.5 * at / c;
            let [x] = dop853::integrate(|_, [x]| [of(x)], [at], until, 1e-13);
            let p = f64::from(p);
            let ends = [
                run(&Force { p, c }, start, tolerance, until),
                run(&Row { p, c }, start, tolerance, until),
                run(&Mass { p, c }, start, tolerance, until),
            ];
            for (law, end) in ends.into_iter().enumerate() {
                runs += 1;
                let Ok([q, _]) = &end else {
                    // a step begins so close to the place that nothing is left of the difference
                    refused += 1;
                    continue;
                };
                let apart = (q[0] - x).abs();
                assert!(
                    apart < 1e5 * tolerance,
                    "{law}: {draw} {p} {c} {at} {rise} {tolerance} {end:?} {x}"
                );
            }
        }
        // no other motion comes through
        let p = -random.between(0.3, 3.0);
        let [[x], _] = run(&Force { p, c }, [[at], [-c]], tolerance, 2.0).unwrap();
        assert!((x - at + 2.0 * c).abs() < 1e-9, "{draw} {p} {c} {at} {x}");
    }
    println!("{refused} of {runs} refused");
    assert!(10 * refused < runs, "{refused} of {runs}");
}

declared! {
    /// The attraction of a point.
    #[derive(Debug)]
    struct Kepler {};
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 1 / (x.powi(2) + y.powi(2)).sqrt();
}

#[test]
fn close_approaches_are_passed() {
    for draw in 0..short_or_long(12, 60) {
        let mut random = Random::new(12_100 + draw);
        let near = random.decades(1e-6, 1e-1);
        let tolerance = random.decades(1e-13, 1e-7);
        // at the apoapsis of an ellipse of the semi-axis 1; the energy stays -1/2
        let start = [[2.0 - near, 0.0], [0.0, (near / (2.0 - near)).sqrt()]];
        let found = run(&Kepler {}, start, tolerance, 2.0 * core::f64::consts::PI);
        assert!(found.is_ok(), "{near} {tolerance} {found:?}");
    }
}

/// The quotients of [`quotient`], with the variable `u`.
const QUOTIENTS: [&str; 4] = [
    "(u).sin() / (u)",
    "(1 - (u).cos()) / (u).powi(2)",
    "(u).exp_m1() / (u)",
    "(u).tanh() / (u)",
];

/// A quotient of [`QUOTIENTS`], with its limit at zero.
fn quotient(number: usize, u: f64) -> f64 {
    let limits = [1.0, 0.5, 1.0, 1.0];
    let half = 0.5 * u;
    match number {
        _ if u == 0.0 => limits[number],
        0 => u.sin() / u,
        1 => 0.5 * (half.sin() / half).powi(2),
        2 => u.exp_m1() / u,
        _ => u.tanh() / u,
    }
}

/// Steps pass a node that lies exactly at the zero of a divisor, where the quotient has a limit: a force, a row, a potential. The
/// node has the limits of the force and of the energy.
#[test]
fn steps_pass_a_node_where_a_quotient_has_a_limit() {
    use dsocs_core::text::Text;
    use dsocs_core::{AnyComposedFlow, Composition, Flow, OwnedNode};
    for (number, quotient_text) in QUOTIENTS.into_iter().enumerate() {
        let by = |u: &str| quotient_text.replace("(u)", u);
        let of = |t: f64| quotient(number, t - 1.0);
        let laws = [
            format!(
                "lagrangian = free - y.powi(2) / 2; external_forces = (0, {});",
                by("x")
            ),
            format!(
                "lagrangian = free; kinematic = ddot(y) + y - {}; constraint_forces = [(0, 1)];",
                by("x")
            ),
            format!("lagrangian = free - y.powi(2) / 2 + y * {};", by("(t - 1)")),
        ];
        for (law, text) in laws.iter().enumerate() {
            let text = format!("coordinates(x, y); let free = (dot(x).powi(2) + dot(y).powi(2)) / 2; {text}");
            let system = Text::parse("quotient", &text).unwrap().system;
            let start = Start::second_order([-1.0, 1.0], [1.0, 0.0]);
            let exact = |until: f64| {
                let right = |t: f64, [y, v]: [f64; 2]| [v, of(t) - y];
                dop853::integrate_from(right, (0.0, [1.0, 0.0]), until, 1e-13)
            };
            let [at_node, _] = exact(1.0);
            let error = |h: f64, method: Option<Composition>| {
                let mut run = match method {
                    Some(method) => AnyComposedFlow::new(&system, h, method, &start.into())
                        .unwrap()
                        .into_run(),
                    None => Flow::<2>::of(&system, h, start).unwrap().into_run(),
                };
                let mut node = OwnedNode::new(2);
                run.to(1.0).unwrap_or_else(|error| panic!("{text} {h}: {error}"));
                node.take(&*run);
                let here = node.any();
                assert!(
                    here.q[0].to_bits() << 1 == 0,
                    "the node does not lie at the zero: {text}"
                );
                assert!(
                    here.force.iter().all(|force| force.is_finite()) && here.energy.is_finite(),
                    "{text}: {here:?}"
                );
                if law == 1 {
                    let expected = of(1.0) - here.q[1];
                    assert!(
                        (here.force[1] - expected).abs() < 1e-6,
                        "{text}: {here:?} {expected}"
                    );
                } else {
                    assert!(here.force[1].abs() < 1e-6, "{text}: {here:?}");
                }
                let first = (here.q[1] - at_node).abs();
                run.to(3.0).unwrap_or_else(|error| panic!("{text} {h}: {error}"));
                assert_eq!(run.unresolved(), None, "{text} {h}");
                node.take(&*run);
                let [y, _] = exact(3.0);
                first.max((node.any().q[1] - y).abs())
            };
            let [coarse, fine] = [0.125, 0.0625].map(|h| error(h, None));
            let slope = (coarse / fine).log2();
            assert!((1.8..2.2).contains(&slope), "{text}: {coarse} {fine}");
            let [coarse, fine] = [0.125, 0.0625].map(|h| error(h, Some(Composition::SUZUKI_4)));
            let slope = (coarse / fine).log2();
            assert!((3.6..4.4).contains(&slope), "{text}: {coarse} {fine}");
        }
    }
}

/// Where the quotient has no limit, at a pole or a jump, the step is refused.
#[test]
fn steps_refuse_a_node_where_a_quotient_has_no_limit() {
    use dsocs_core::Flow;
    use dsocs_core::text::Text;
    for force in ["1 / x", "1 / x.powi(2)", "x.cos() / x", "1 / (x * x.tan())"] {
        let text = format!(
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2; external_forces = (0, {force});"
        );
        let system = Text::parse("pole", &text).unwrap().system;
        let start = Start::second_order([-1.0, 1.0], [1.0, 0.0]);
        let mut flow = Flow::<2>::of(&system, 0.125, start).unwrap();
        let error = flow.to(3.0).unwrap_err().to_string();
        assert!(
            error.contains("the equations have no limit at this node"),
            "{force}: {error}"
        );
    }
}
