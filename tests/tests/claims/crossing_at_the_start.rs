//! A mass whose slip on a belt changes its sign, or ends, before the middle of the first leg: no order is lost, and series go on, however short the
//! slip is beside the speed. A composition near rest begins anew
//! with such a leg at every node, so it tells nothing and loses nothing where it only touches the belt's speed. References are closed forms.

use core::fmt::Debug;

use dsocs_core::text::Text;
use dsocs_core::{Composition, Flow, Start, Stepper, Tolerance};
use dsocs_tests::text::{ComposedFlow, TaylorFlow};

use super::draws;

const UNTIL: f64 = 1.0;

/// A mass of 1 kg on a belt with the speed `speed + faster t`, under a force and a friction that are constant.
#[derive(Clone, Copy, Debug)]
struct Belt {
    speed: f64,
    faster: f64,
    force: f64,
    friction: f64,
}

impl Belt {
    /// A belt whose speed is below a size, from numbers between 0 and 1.
    fn drawn(size: f64, [speed, faster, force, friction]: [f64; 4]) -> Self {
        Self {
            speed: size * (2.0 * speed - 1.0),
            faster: if speed < 0.5 { 0.0 } else { 2.0 * faster - 1.0 },
            force: 4.0 * force - 2.0,
            friction: 0.1 + friction,
        }
    }

    /// The rate of a slip with a sign, if the slip goes to zero, and goes on or rests there by more than the bound of friction.
    fn ends(&self, sign: f64) -> Option<f64> {
        let rate = self.rate(sign);
        let is_clear = sign * rate <= -0.05 && self.rate(-sign).abs() >= 0.01;
        is_clear.then_some(rate)
    }

    /// The start with a slip as near to the given one as the speed's rounding allows, and its slip; `None` without one.
    fn start(&self, slip: f64) -> Option<(Start<1>, f64)> {
        let start = Start::second_order([0.0], [self.speed + slip]);
        let slip = self.speed + slip - self.speed;
        (slip != 0.0).then_some((start, slip))
    }

    fn text(&self) -> Text {
        let Self {
            speed,
            faster,
            force,
            friction,
        } = self;
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
             external_forces = {force:?} - {friction:?} * (dot(x) - {speed:?} - {faster:?} * t).signum();"
        );
        Text::parse("belt", &text).unwrap()
    }

    /// The rate of the slip while it has a sign.
    fn rate(&self, sign: f64) -> f64 {
        self.force - self.faster - self.friction * sign
    }

    /// Position and velocity at a time, for a slip at the beginning that goes to zero.
    fn exact(&self, slip: f64, t: f64) -> [f64; 2] {
        let sign = slip.signum();
        let (before, beyond) = (self.rate(sign), self.rate(-sign));
        let meets = -slip / before;
        // beyond zero it goes on, or rests
        let after = if -sign * beyond > 0.0 { beyond } else { 0.0 };
        let since = t - meets;
        let (way, slip) = (
            slip * meets + before * meets * meets / 2.0 + after * since * since / 2.0,
            after * since,
        );
        [
            self.speed * t + self.faster * t * t / 2.0 + way,
            self.speed + self.faster * t + slip,
        ]
    }
}

/// Asserts that position and velocity are near the exact ones.
#[track_caller]
fn assert_near(found: [f64; 2], exact: [f64; 2], bound: f64, scene: &dyn Debug) {
    for (found, exact) in found.iter().zip(exact) {
        assert!((found - exact).abs() < bound, "{scene:?}: {found} {exact}");
    }
}

#[test]
fn a_slip_that_ends_before_the_middle_of_the_first_leg_costs_no_order() {
    let drawn = draws::vector::<5>(0.0..1.0);
    draws::test(400, 28_401, drawn, &|drawn| {
        let [speed, faster, force, friction, part] = draws::sized(&drawn);
        let belt = Belt::drawn(1.0, [speed, faster, force, friction]);
        let text = belt.text();
        for sign in [1.0, -1.0] {
            let Some(rate) = belt.ends(sign) else {
                continue;
            };
            for steps in [37.0, 100.0, 211.0] {
                let h = UNTIL / steps;
                // at most before the middle; the smallest are rounding
                let slip = -rate * 0.5 * h * if part < 0.2 { 1e-14 } else { part };
                let Some((start, slip)) = belt.start(slip) else {
                    continue;
                };
                let exact = belt.exact(slip, UNTIL);
                let bound = 4.0 * (2.0 * belt.friction + rate.abs() + belt.faster.abs()) * h * h;
                let mut flow = Flow::of(&text.system, h, start).unwrap();
                let node = flow.to(UNTIL).unwrap();
                assert_near([node.q[0], node.v[0]], exact, bound, &(belt, slip, h));
            }
        }
        Ok(())
    });
}

/// The speed `v = b - a (t - T)²` of a mass touches that of a belt.
#[test]
fn a_speed_that_touches_that_of_the_belt_loses_no_order() {
    let drawn = draws::vector::<3>(0.2..1.0);
    draws::test(80, 28_402, drawn, &|drawn| {
        let [a, friction, speed] = draws::sized(&drawn);
        // the belt is touched at a node, and between two
        for at in [0.5, 0.37] {
            let text = format!(
                "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
                 external_forces = {:?} * (t - {at:?}) - {friction:?} - {friction:?} * (dot(x) - {speed:?}).signum();",
                -2.0 * a
            );
            let text = Text::parse("touch", &text).unwrap();
            let start = Start::second_order([0.0], [speed - a * at * at]);
            let since = UNTIL - at;
            let exact = [
                speed * UNTIL - a * (since.powi(3) + at.powi(3)) / 3.0,
                speed - a * since * since,
            ];
            for steps in [20, 50, 100, 200, 400] {
                let h = UNTIL / f64::from(steps);
                let end = Flow::of(&text.system, h, start).unwrap().to(UNTIL).unwrap();
                let mut ends = vec![[end.q[0], end.v[0]]];
                for method in [Composition::SUZUKI_4, Composition::KAHAN_LI_6] {
                    let mut flow = ComposedFlow::read(&text.system, h, method, start).unwrap();
                    let end = flow.to(UNTIL).unwrap();
                    ends.push([end.q[0], end.v[0]]);
                }
                for end in ends {
                    assert_near(end, exact, 4.0 * h * h, &(a, friction, speed, at, h));
                }
            }
        }
        Ok(())
    });
}

#[test]
fn series_go_on_from_a_slip_that_is_short_beside_the_speed() {
    let drawn = draws::vector::<6>(0.0..1.0);
    draws::test(400, 28_403, drawn, &|drawn| {
        let [speed, faster, force, friction, part, size] = draws::sized(&drawn);
        let size = 10.0_f64.powf(8.0 * size - 3.0);
        let belt = Belt::drawn(size, [speed, faster, force, friction]);
        let text = belt.text();
        for sign in [1.0, -1.0] {
            let Some(rate) = belt.ends(sign) else {
                continue;
            };
            // from rounding of the speed to a slip that takes half of the time
            let slip = sign * (0.5 * rate.abs() * 10.0_f64.powf(-16.0 * part));
            let Some((start, slip)) = belt.start(slip) else {
                continue;
            };
            let exact = belt.exact(slip, UNTIL);
            for tolerance in [1e-6, 1e-9, 1e-12] {
                let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
                let node = match flow.to(UNTIL) {
                    Ok(node) => node,
                    Err(error) => panic!("{belt:?} {slip} {tolerance}: {error}"),
                };
                let bound = 1e-13 * (1.0 + belt.speed.abs());
                assert_near([node.q[0], node.v[0]], exact, bound, &(belt, slip, tolerance));
            }
        }
        Ok(())
    });
}
