//! Friction on a swinging surface at late times, which are known to their rounding alone, and the surface's velocity with
//! them.

use core::f64::consts::PI;

use dsocs_core::text::Text;
use dsocs_core::{Start, Stepper as _, Tolerance};
use dsocs_tests::scenes::random::Random;
use dsocs_tests::short_or_long;
use dsocs_tests::text::TaylorFlow;

use super::reference::{Reference, Scene};
use super::{EVENT_CLEARANCE, Ends, MARGIN, REFERENCE_STEP};

/// The scene of a mass from a time on, in the time since then.
struct Since<'s>(&'s Ends, f64);

impl Scene<1> for Since<'_> {
    fn mass(&self, q: &[f64; 1]) -> [[f64; 1]; 1] {
        self.0.mass(q)
    }

    fn force(&self, t: f64, q: &[f64; 1], v: &[f64; 1]) -> [f64; 1] {
        self.0.force(t, q, v)
    }

    fn contacts(&self) -> usize {
        self.0.contacts()
    }

    fn direction(&self, k: usize) -> [f64; 1] {
        self.0.direction(k)
    }

    fn surface(&self, _: usize, t: f64, x: &[f64; 1]) -> (f64, f64, [f64; 1]) {
        // by the addition theorem: the sum of both times would be rounded
        let ((s0, c0), (s, c)) = ((2.0 * self.1).sin_cos(), (2.0 * t).sin_cos());
        let (sin, cos) = (s0 * c + c0 * s, c0 * c - s0 * s);
        let Ends { reach, by_place, .. } = *self.0;
        (reach * sin + by_place * x[0], 2.0 * reach * cos, [by_place])
    }

    fn limit(&self, k: usize, slip: f64) -> f64 {
        self.0.limit(k, slip)
    }
}

#[test]
fn series_stick_and_slip_at_late_times_as_at_early_ones() {
    let mut random = Random::new(7);
    let until = 6.0;
    let (mut done, mut events, mut worst) = (0, 0, 0.0_f64);
    while done < short_or_long(12, 300) {
        let mass = Ends {
            stiff: random.between(0.0, 2.0),
            dry: random.between(0.2, 2.0),
            reach: random.between(0.2, 1.0),
            by_place: random.between(-0.3, 0.3),
        };
        let t0 = random.decades(1e3, 1e9);
        let (x, v) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        let motion = Reference(&Since(&mass, t0)).run(([x], [v]), &[false], [0.0, until], REFERENCE_STEP);
        let Some(motion) = motion.filter(|motion| {
            motion.margin > MARGIN
                && motion.gap(&[], until) > 2.2 * EVENT_CLEARANCE
                && motion.events.len() > 2
        }) else {
            continue;
        };
        done += 1;
        events += motion.events.len();
        // of the accelerations, over the rounding of the time
        let known = f64::EPSILON * t0 * (mass.dry + 2.0 * mass.reach + mass.stiff);
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let start = Start::second_order([x], [v]).at(t0);
            let flow = TaylorFlow::new(&mass, start, Tolerance::relative(tolerance)).unwrap();
            let mut flow = flow.every(0.02).unwrap();
            while flow.node().t < t0 + until - 0.03 {
                if let Err(error) = flow.advance() {
                    panic!("{error} {mass:?} {t0} {tolerance} {:?}", motion.events);
                }
                let node = flow.node();
                let (q, v) = motion.at(node.t - t0);
                let error = (node.q[0] - q[0]).abs().max((node.v[0] - v[0]).abs());
                worst = worst.max(error / (tolerance + known).max(1e-11));
            }
        }
    }
    println!("{events} events; largest error: {worst:.1} tolerances or roundings of the time");
    assert!(worst < 100.0, "{worst}");
}

/// A mass that friction holds until a force exceeds it, as at early times; the speed after half a period is in closed form.
#[test]
fn series_are_released_at_late_times_as_at_early_ones() {
    let mut random = Random::new(8);
    let mut done = 0;
    while done < short_or_long(40, 1000) {
        let t0 = random.decades(1e2, 1e8).round();
        let [amplitude, friction, rate] = [
            random.between(0.5, 3.0),
            random.between(1.05, 1.4),
            random.between(0.5, 5.0),
        ];
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
             external_forces = 1 + {amplitude:?} * ({rate:?} * (t - {t0:?})).sin() - {friction:?} * dot(x).signum();"
        );
        let text = Text::parse("late release", &text).unwrap();
        let released = ((friction - 1.0) / amplitude).asin() / rate;
        let speed = |since: f64| {
            (1.0 - friction) * (since - released)
                - amplitude / rate * ((rate * since).cos() - (rate * released).cos())
        };
        let until = t0 + PI / rate;
        let exact = speed(until - t0);
        // the mass has come to rest before, and the closed form is of another motion
        if exact <= 0.0 {
            continue;
        }
        done += 1;
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let start = Start::second_order([0.0], [0.0]).at(t0);
            let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
            let node = match flow.to(until) {
                Ok(node) => node,
                Err(error) => panic!("{t0} {amplitude} {friction} {rate} {tolerance}: {error}"),
            };
            // force changes by less than 15 a second
            let bound = tolerance.max(1e-12) * 100.0 + 60.0 * f64::EPSILON * t0;
            assert!(
                (node.v[0] - exact).abs() < bound,
                "{t0} {amplitude} {friction} {rate} {tolerance}: {} for {exact}",
                node.v[0]
            );
        }
    }
}

/// A mass on a spring rides on a surface that swings with the spring's frequency, so that the friction that holds it is constant: the difference of
/// two forces, which late times, or a spring far from the origin, leave few digits.
#[test]
fn series_rest_where_the_holding_force_has_few_digits() {
    for (clock, far) in [(0.0, 0.0), (1e8, 0.0), (1e9, 0.0), (0.0, 1e8), (0.0, 3e7)] {
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - (x - {far:?}).powi(2) / 2; \
             external_forces = -0.1 * (dot(x) - 0.1 * (t - {clock:?}).cos()).signum();"
        );
        let text = Text::parse("resonant belt", &text).unwrap();
        for tolerance in [1e-7, 1e-9, 1e-12] {
            let start = Start::second_order([far], [0.1]).at(clock);
            let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
            let node = match flow.to(clock + 6.0) {
                Ok(node) => node,
                Err(error) => panic!("{clock} {far} {tolerance}: {error}"),
            };
            let exact = [far + 0.1 * 6.0_f64.sin(), 0.1 * 6.0_f64.cos()];
            let bound = tolerance.max(1e-12) * 100.0 + 16.0 * f64::EPSILON * (clock + far);
            for (found, exact) in [node.q[0], node.v[0]].iter().zip(exact) {
                assert!(
                    (found - exact).abs() < bound,
                    "{clock} {far} {tolerance}: {found} for {exact}"
                );
            }
            assert!(
                flow.steps() < 2000,
                "{clock} {far} {tolerance}: {} steps",
                flow.steps()
            );
        }
    }
}

/// A mass that friction holds on a shaker table, on a stiff spring whose anchor is far from the origin: the holding force has a few digits more
/// than the tolerance asks for, which is no reason for ever shorter steps.
#[test]
fn series_rest_where_a_stiff_spring_rounds() {
    let mut random = Random::new(9);
    for _ in 0..short_or_long(20, 500) {
        let [stiff, far] = [random.decades(1e3, 1e6), random.decades(1e1, 1e4)];
        let [speed, rate] = [random.decades(1e-5, 1e-3), random.between(5.0, 40.0)];
        // the table moves by twice the reach of its swing, and friction exceeds the forces of spring and inertia
        let friction = 2.0 * (2.0 * stiff * speed / rate + speed * rate);
        let text = format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2 - {stiff:?} * (x - {far:?}).powi(2) / 2; \
             external_forces = -{friction:?} * (dot(x) - {speed:?} * ({rate:?} * t).sin()).signum();"
        );
        let text = Text::parse("shaker table", &text).unwrap();
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let start = Start::second_order([far], [0.0]);
            let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
            let node = match flow.to(1.0) {
                Ok(node) => node,
                Err(error) => panic!("{stiff} {far} {speed} {rate} {tolerance}: {error}"),
            };
            let exact = [far + speed / rate * (1.0 - rate.cos()), speed * rate.sin()];
            let bound = tolerance.max(1e-12) * 100.0 * speed + 16.0 * f64::EPSILON * far;
            assert!(
                (node.q[0] - exact[0]).abs() < bound,
                "{stiff} {far} {speed} {rate} {tolerance}: {node:?} for {exact:?}"
            );
            assert!(
                (node.v[0] - exact[1]).abs() < bound,
                "{stiff} {far} {speed} {rate} {tolerance}: {node:?} for {exact:?}"
            );
            assert!(
                flow.steps() < 2000,
                "{stiff} {far} {speed} {rate} {tolerance}: {} steps",
                flow.steps()
            );
        }
    }
}
