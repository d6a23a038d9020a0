//! An expression with corners and jumps within a step has its events where it vanishes: both zeros about a corner, and a jump through zero.
//! The motions and the zeros are in closed form.

use dsocs_core::text::Text;
use dsocs_core::{Composition, Event, Events, Flow, Occurrence, Start, Stepper, Tolerance, on_event};
use dsocs_tests::scenes::random::Random;
use dsocs_tests::short_or_long;
use dsocs_tests::text::{ComposedFlow, TaylorFlow};

/// The events of the observed expressions up to a time.
fn events(run: &mut impl Stepper<1>, count: usize, until: f64) -> Vec<Vec<Occurrence<1>>> {
    let mut found = vec![Vec::new(); count];
    let mut events = Events::new((0..count).map(Event::observable).collect());
    let mut keep = on_event(|event: &Occurrence<_>| found[event.event].push(*event));
    run.watch(until, &mut events, &mut keep).unwrap();
    found
}

/// An expression, and the places at which it changes its sign along a motion to positive `x`, upwards or not.
type Watched = (String, Vec<(f64, bool)>);

/// Expressions with corners and jumps at `c`, or near it, and zeros at distances of about `w` from it.
fn expressions(c: f64, w: f64, speed: f64) -> Vec<Watched> {
    let (up, down) = (|place: f64| (place, true), |place: f64| (place, false));
    let rises = vec![up(c + w)];
    let both = vec![down(c - w), up(c + w)];
    let n = std::f64::consts::PI / (3.0 * w);
    vec![
        (format!("(x - {c:?}).abs() - {w:?}"), both.clone()),
        (format!("(x - {c:?}).powi(2).sqrt() - {w:?}"), both.clone()),
        (format!("(x - {c:?}).max({c:?} - x) - {w:?}"), both),
        (format!("(x - {c:?}).max(0.0) - {w:?}"), rises.clone()),
        (format!("-({c:?} - x).min(0.0) - {w:?}"), rises.clone()),
        (
            format!("(t - {:?}).max(0.0) - {:?}", c / speed, w / speed),
            rises.clone(),
        ),
        (
            format!("if x < {c:?} {{ -1.0 }} else {{ x - {:?} }}", c + w),
            rises.clone(),
        ),
        (format!("bend.at(x) - {w:?}"), rises),
        (format!("(x - {c:?}).signum() + 0.5"), vec![up(c)]),
        (format!("x * (x - {c:?}).signum()"), vec![up(c)]),
        (
            format!("if x < {c:?} {{ 2.0 }} else {{ {:?} - x }}", c - 3.0),
            vec![down(c)],
        ),
        (
            format!("((x - {c:?}).abs() - {w:?}).abs() - {:?}", 0.5 * w),
            vec![
                down(c - 1.5 * w),
                up(c - 0.5 * w),
                down(c + 0.5 * w),
                up(c + 1.5 * w),
            ],
        ),
        // a bump that begins and ends within a step
        (
            format!("({w:?} - (x - {c:?}).abs()).max(0.0) - {:?}", 0.25 * w),
            vec![up(c - 0.75 * w), down(c + 0.75 * w)],
        ),
        // zeros at every 60° of a hidden corner's function, between its corners at every 180°
        (
            format!(
                "if (x - {c:?}).abs() < {:?} {{ (({n:?} * (x - {c:?})).cos()).acos() - PI / 2 }} else {{ 1.0 }}",
                2.5 * w
            ),
            vec![down(c - 1.5 * w), up(c + 1.5 * w)],
        ),
    ]
}

#[test]
fn zeros_about_corners_are_found_at_their_times() {
    let mut random = Random::new(41);
    for _ in 0..short_or_long(12, 400) {
        let h = random.between(0.01, 0.1);
        let (c, speed) = (random.between(0.3, 0.7), random.between(0.5, 2.0));
        let w = h * speed * random.between(0.02, 0.8);
        let watched = expressions(c, w, speed);
        let (lets, names): (Vec<String>, Vec<String>) = watched
            .iter()
            .enumerate()
            .map(|(i, (expression, _))| (format!("let g{i} = {expression};"), format!("g{i}")))
            .unzip();
        let text = format!(
            "parameters {{ bend = samples(\"bend.csv\", linear) }} coordinates(x); lagrangian = dot(x).powi(2) / 2; {} observe = [{}];",
            lets.join(" "),
            names.join(", ")
        );
        let table = vec![(-1.0, 0.0), (c, 0.0), (3.0, 3.0 - c)];
        let text = Text::parse_with("particle", &text, &[], &[("bend.csv".to_owned(), table)]).unwrap();
        let system = &text.system;
        let count = watched.len();
        let until = 1.0 / speed;
        let start = Start::second_order([0.0], [speed]);
        let series = || TaylorFlow::read(system, start, Tolerance::relative(1e-11)).unwrap();
        let runs = [
            (
                "order 2",
                events(&mut Flow::of(system, h, start).unwrap(), count, until + h),
            ),
            (
                "order 4",
                events(
                    &mut ComposedFlow::read(system, h, Composition::SUZUKI_4, start).unwrap(),
                    count,
                    until + h,
                ),
            ),
            ("tolerance", events(&mut series(), count, until)),
            (
                "a grid",
                events(&mut series().every(h).unwrap(), count, until + h),
            ),
        ];
        for (method, found) in runs {
            for ((expression, exact), found) in watched.iter().zip(&found) {
                let said = || format!("{method}, {h}: {expression}: {exact:?} {found:?}");
                assert_eq!(found.len(), exact.len(), "{}", said());
                for (event, (place, rising)) in found.iter().zip(exact) {
                    assert!((event.t * speed - place).abs() < 1e-9, "{}", said());
                    assert_eq!(event.rising, *rising, "{}", said());
                }
            }
        }
    }
}

/// Where an event ends the run, the run ends at the zero beyond the corner.
#[test]
fn a_run_ends_at_the_zero_beyond_a_corner() {
    let text = "coordinates(x); lagrangian = dot(x).powi(2) / 2; let over = (x - 0.3456).max(0.0) - 0.001; observe = [over];";
    let text = Text::parse("particle", text).unwrap();
    let start = Start::second_order([0.0], [1.0]);
    let mut run = TaylorFlow::read(&text.system, start, Tolerance::relative(1e-10)).unwrap();
    let mut events = Events::new(vec![Event::observable(0).terminal()]);
    let ended = run.watch(1.0, &mut events, &mut on_event(|_: &Occurrence<1>| {}));
    let ended = ended.unwrap().unwrap();
    assert!((ended.t - 0.3466).abs() < 1e-12, "{ended:?}");
    assert!((run.node().t - ended.t).abs() < 1e-15, "{ended:?}");
}

/// An oscillator and functions of it whose corners it passes many times, forward and back in time.
#[test]
fn an_oscillator_passes_corners_many_times() {
    let mut random = Random::new(42);
    for _ in 0..short_or_long(12, 400) {
        let [c, w, rate] = [
            random.between(-0.6, 0.6),
            random.between(0.01, 0.3),
            random.between(1.0, 8.0),
        ];
        // cos(rate t) = level
        let until = 5.0;
        let zeros = |levels: &[f64]| {
            let mut times: Vec<f64> = levels
                .iter()
                .flat_map(|level| {
                    let angle = level.acos();
                    (0..20).flat_map(move |turn| {
                        let turn = f64::from(turn) * std::f64::consts::TAU;
                        [turn + angle, turn - angle]
                    })
                })
                .map(|angle| angle / rate)
                .filter(|t| *t > 0.0 && *t < until)
                .collect();
            times.sort_by(f64::total_cmp);
            times
        };
        let exact = [
            zeros(&[c - w, c + w]),
            zeros(&[c + w]),
            zeros(&[c - w, c + w]),
            zeros(&[c]),
        ];
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - {:?} * x.powi(2) / 2; let near = (x - {c:?}).abs() - {w:?}; \
             let over = (x - {c:?}).max(0.0) - {w:?}; let root = (x - {c:?}).powi(2).sqrt() - {w:?}; let side = (x - {c:?}).signum() + 0.25; \
             observe = [near, over, root, side];",
            rate * rate
        );
        let text = Text::parse("oscillator", &text).unwrap();
        for back in [false, true] {
            let start = Start::second_order([1.0], [0.0]);
            let mut run = TaylorFlow::read(&text.system, start, Tolerance::relative(1e-13)).unwrap();
            if back {
                run.reverse().unwrap();
            }
            let found = events(&mut run, exact.len(), if back { -until } else { until });
            for (place, (found, exact)) in found.iter().zip(&exact).enumerate() {
                let said = || format!("{place}, {back}: {exact:?} {found:?} of {text:?}");
                assert_eq!(found.len(), exact.len(), "{}", said());
                for (event, t) in found.iter().zip(exact) {
                    assert!((event.t.abs() - t).abs() < 1e-9, "{}", said());
                }
            }
        }
    }
}
