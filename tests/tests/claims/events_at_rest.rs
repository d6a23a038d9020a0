//! The slip of a mass on a surface has no events while friction holds the mass, whatever the surface's motion and the method: there the slip of
//! the nodes is an error of the method, of either sign. The times of captures and releases are in closed form.

use dsocs_core::text::Text;
use dsocs_core::{Composition, Event, Events, Flow, Occurrence, Start, Stepper, Tolerance, on_event};
use dsocs_tests::scenes::random::Random;
use dsocs_tests::short_or_long;
use dsocs_tests::text::{ComposedFlow, TaylorFlow};

/// The events of the first observed expression up to a time.
fn events(run: &mut impl Stepper<1>, until: f64) -> Vec<Occurrence<1>> {
    let mut found = Vec::new();
    let mut events = Events::new(vec![Event::observable(0)]);
    run.watch(
        until,
        &mut events,
        &mut on_event(|event: &Occurrence<_>| found.push(*event)),
    )
    .unwrap();
    found
}

/// The events by each method, with its name and its step: the order 2, a composition, and a tolerance.
fn by_each_method(text: &Text, start: Start<1>, h: f64, until: f64) -> Vec<(String, Vec<Occurrence<1>>)> {
    let system = &text.system;
    vec![
        (
            format!("order 2, {h}"),
            events(&mut Flow::of(system, h, start).unwrap(), until),
        ),
        (
            format!("order 4, {h}"),
            events(
                &mut ComposedFlow::read(system, h, Composition::SUZUKI_4, start).unwrap(),
                until,
            ),
        ),
        (
            "tolerance".to_owned(),
            events(
                &mut TaylorFlow::read(system, start, Tolerance::relative(1e-10)).unwrap(),
                until,
            ),
        ),
    ]
}

#[test]
fn a_slip_that_ends_in_a_rest_has_no_event() {
    let mut random = Random::new(31);
    for _ in 0..short_or_long(6, 200) {
        let [reach, rate] = [random.between(0.2, 1.0), random.between(0.5, 3.0)];
        // the surface's acceleration is at most reach · rate²
        let friction = random.between(1.1, 2.0) * reach * rate * rate;
        let text = format!(
            "coordinates(x); let slip = dot(x) - {:?} * ({rate:?} * t).cos(); lagrangian = dot(x).powi(2) / 2; \
             external_forces = -{friction:?} * slip.signum(); observe = [slip];",
            reach * rate
        );
        let text = Text::parse("shaken surface", &text).unwrap();
        for slip in [0.0, 0.3, -0.3] {
            let start = Start::second_order([0.0], [reach * rate + slip]);
            for h in [0.0137, 0.03] {
                for (method, found) in by_each_method(&text, start, h, 2.5) {
                    assert!(found.is_empty(), "{method}, {slip}: {found:?} of {text:?}");
                }
            }
        }
    }
}

/// A mass on a spring is carried by a belt until the spring exceeds the friction. From then on it slips back, and again, always to the same
/// side: the slip changes its sign once, if it was on the other side before. By a tolerance that is the one event. By steps the slip is smaller
/// than their error for a step or two after the release, and may change its sign more than once there.
#[test]
fn a_release_to_the_other_side_is_one_event() {
    let mut random = Random::new(32);
    for _ in 0..short_or_long(6, 200) {
        let [friction, belt, slip] = [
            random.between(0.5, 1.5),
            random.between(0.1, 0.5),
            random.between(0.02, 0.1),
        ];
        let text = format!(
            "coordinates(x); let slip = dot(x) - {belt:?}; lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; \
             external_forces = -{friction:?} * slip.signum(); observe = [slip];"
        );
        let text = Text::parse("belt", &text).unwrap();
        // x + f = f cos t + v sin t on the side of the start, up to v - f t = belt: the first zero of the slip
        let v = belt + slip;
        let captured = {
            // x'' = -(x + f): x' = v cos t - f sin t
            let (size, phase) = (v.hypot(friction), friction.atan2(v));
            (belt / size).acos() - phase
        };
        let x = friction * (captured.cos() - 1.0) + v * captured.sin();
        let released = captured + (friction - x) / belt;
        let until = released + 3.0;
        for (start, count) in [(v, 1), (belt, 0)] {
            let start = Start::second_order([0.0], [start]);
            for h in [0.0137, 0.01] {
                for (method, found) in by_each_method(&text, start, h, until) {
                    let said = || format!("{method}, {released}: {found:?} of {text:?}");
                    let near = |event: &Occurrence<1>| (event.t - released).abs() < 3.0 * h;
                    assert!(found.iter().all(near), "{}", said());
                    assert!(method != "tolerance" || found.len() == count, "{}", said());
                    // the sides before and after decide on the sum
                    assert!(found.len() % 2 == count % 2, "{}", said());
                    assert!(found.last().is_none_or(|event| !event.rising), "{}", said());
                }
            }
        }
    }
}
