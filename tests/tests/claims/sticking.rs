//! Rest at a jump of a function: dry friction holds a mass while the other forces are below its limit, and
//! releases it in the right direction.

#![allow(clippy::float_cmp)] // the same numbers, to the last bit

use dsocs_core::{AnyPath, Ensemble, Inputs, Start, Stepper, Stop, dsocs};
use dsocs_tests::declared;
use dsocs_tests::fit::slope;
use dsocs_tests::motion::distance;
use dsocs_tests::scenes::elimination::Decomposed;
use dsocs_tests::short_or_long;
use dsocs_tests::text::{Flow, System, read};
use proptest::prelude::*;

declared! {
    /// A block on a slope.
    struct Block {
        mass: f64,
        slope: f64,
        friction: f64,
    }
    coordinates(x);
    lagrangian = mass * (dot(x).powi(2) / 2 - 9.81 * x * slope.sin());
    external_forces = -friction * mass * 9.81 * slope.cos() * dot(x).signum();
}

#[test]
fn a_block_on_a_slope_rests_below_the_limit_and_slides_above() {
    for slope in [-0.6_f64, -0.1, 0.0, 0.1, 0.6] {
        for part in [0.01, 0.5, 0.99, 0.999_999, 1.000_001, 1.01, 3.0] {
            for h in [0.1, 0.003] {
                let friction = if slope == 0.0 {
                    0.2
                } else {
                    slope.abs().tan() / part
                };
                let block = Block {
                    mass: 0.7,
                    slope,
                    friction,
                };
                let holds = slope == 0.0 || part < 1.0;
                // at rest, by both starts
                for start in [Start::second_order([0.3], [0.0]), Start::paper([0.3], [0.0])] {
                    let mut flow = Flow::new(&block, h, start).unwrap();
                    for _ in 0..300 {
                        let report = flow.advance().unwrap();
                        let node = flow.node();
                        if holds {
                            assert_eq!((node.q[0], report.stop), (0.3, Stop::Sticks), "{slope} {part}");
                            assert!(node.v[0].abs() < 1e-30 && node.a[0].abs() < 1e-30, "{node:?}");
                            assert!(node.force[0].abs() < 1e-14);
                        } else {
                            let a = -9.81 * (slope.sin() - slope.signum() * friction * slope.cos());
                            assert!((node.a[0] - a).abs() < 1e-9, "{node:?} {a}");
                            assert!(node.force[0].abs() < 1e-9, "{node:?}");
                        }
                    }
                    assert_eq!(flow.unresolved(), None);
                }
                // thrown up or down
                for v in [1.0, -1.0] {
                    let mut flow = Flow::new(&block, h, Start::second_order([0.0], [v])).unwrap();
                    let slowed = |v: f64| 9.81 * (slope.sin() * v.signum() + friction * slope.cos());
                    let stops = slowed(v) > 0.0;
                    let (time, place) = (1.0 / slowed(v), v / (2.0 * slowed(v)));
                    if !(holds && stops && time < 30.0) {
                        continue;
                    }
                    while flow.time() < time + 3.0 * h {
                        flow.advance().unwrap();
                    }
                    let rests = flow.position()[0];
                    assert!((rests - place).abs() <= slowed(v) * h * h, "{slope} {part} {h}");
                    for _ in 0..100 {
                        let report = flow.advance().unwrap();
                        assert_eq!((flow.position()[0], report.stop), (rests, Stop::Sticks));
                    }
                    // a stop costs no order
                    assert_eq!(flow.unresolved(), None);
                }
            }
        }
    }
}

declared! {
    /// A block on a belt, held by a spring; friction falls with the relative velocity.
    struct Belt {
        stiff: f64,
        speed: f64,
        dry: f64,
        fall: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - stiff * x.powi(2) / 2;
    let slip = dot(x) - speed;
    external_forces = -(dry - fall * slip.abs()) * slip.signum();
}

impl Belt {
    /// Position and velocity on the slip that begins at the time 0.
    fn slip(&self, t: f64) -> [f64; 2] {
        let (rate, centre) = (self.fall / 2.0, (self.dry - self.fall * self.speed) / self.stiff);
        let ring = (self.stiff - rate * rate).sqrt();
        let y = self.fall * self.speed / self.stiff;
        let (sin, cos) = (ring * t).sin_cos();
        let b = (self.speed - rate * y) / ring;
        let (grown, place, turn) = ((rate * t).exp(), y * cos + b * sin, ring * (b * cos - y * sin));
        [centre + grown * place, grown * (rate * place + turn)]
    }

    /// The duration of the slip, and the period.
    fn period(&self) -> [f64; 2] {
        // at first slower than the belt; after a full turn the growth has made it faster
        let turn = std::f64::consts::TAU / (self.stiff - self.fall * self.fall / 4.0).sqrt();
        let (mut low, mut high) = (0.5 * turn, turn);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if self.slip(middle)[1] < self.speed {
                low = middle;
            } else {
                high = middle;
            }
        }
        [
            low,
            low + (self.dry / self.stiff - self.slip(low)[0]) / self.speed,
        ]
    }

    /// The position at a time after a slip has begun.
    fn at(&self, t: f64) -> f64 {
        let [slip, period] = self.period();
        let t = t.rem_euclid(period);
        if t < slip {
            self.slip(t)[0]
        } else {
            self.slip(slip)[0] + self.speed * (t - slip)
        }
    }
}

#[test]
fn stick_and_slip_on_a_belt_has_its_period_to_second_order() {
    let belt = Belt {
        stiff: 4.0,
        speed: 0.3,
        dry: 1.5,
        fall: 1.0,
    };
    let [slip, period] = belt.period();
    assert!(slip < period - 1.0 && belt.slip(slip)[0].abs() < belt.dry / belt.stiff);
    // on the belt, half a second before it is torn off
    let start = Start::second_order([belt.at(-0.5)], [belt.speed]);
    let steps = [0.02, 0.01, 0.005, 0.0025, 0.001_25];
    let errors = steps.map(|h| {
        let mut flow = Flow::new(&belt, h, start).unwrap();
        let (mut error, mut slips, mut first, mut last) = (0.0_f64, 0, 0.0, 0.0);
        let mut stuck = true;
        while flow.time() < 0.5 + 6.2 * period {
            let report = flow.advance().unwrap();
            let node = flow.node();
            error = error.max((node.q[0] - belt.at(node.t - 0.5)).abs());
            let sticks = report.stop == Stop::Sticks;
            if sticks {
                assert!((flow.leg().d[0] / h - belt.speed).abs() < 1e-12, "{node:?}");
                // the friction balances the spring, and no constraint acts
                assert!(
                    node.force[0].abs() < 1e-12 && node.a[0].abs() < 1e-9 / h,
                    "{node:?}"
                );
            }
            if stuck && !sticks && report.stop != Stop::Jump {
                (first, last) = (if slips == 0 { node.t } else { first }, node.t);
                slips += 1;
            }
            stuck = sticks;
        }
        assert_eq!(slips, 7);
        assert!(((last - first) / 6.0 - period).abs() < 0.5 * h, "{h}");
        // neither a stop nor a release costs an order
        assert_eq!(flow.unresolved(), None);
        error
    });
    let order = slope(&steps, &errors);
    println!("period {period}, order {order:.2}, errors {errors:?}");
    assert!(order > 1.8, "{order} {errors:?}");
}

declared! {
    /// A mass on a swinging belt, carried along within the limit of friction.
    struct Shaker {
        reach: f64,
        dry: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -dry * (dot(x) - reach * t.sin()).signum();
}

#[test]
fn a_belt_that_swings_takes_along_what_it_can() {
    // the belt's acceleration stays below the friction
    let shaker = Shaker { reach: 0.8, dry: 1.0 };
    let steps = [0.1, 0.05, 0.025];
    let errors = steps.map(|h: f64| {
        let mut flow = Flow::new(&shaker, h, Start::second_order([0.0], [0.0])).unwrap();
        let mut error = 0.0_f64;
        while flow.time() < 20.0 {
            assert_eq!(flow.advance().unwrap().stop, Stop::Sticks);
            let node = flow.node();
            error = error.max((node.q[0] - 0.8 * (1.0 - node.t.cos())).abs());
        }
        error
    });
    let order = slope(&steps, &errors);
    println!("{order:.2} {errors:?}");
    assert!((order - 2.0).abs() < 0.05, "{order} {errors:?}");
    // here it does not: the mass slides at times and is carried at others
    let shaker = Shaker { reach: 1.3, dry: 1.0 };
    let reference = Reference {
        mass: |_: &[f64; 1]| [[1.0]],
        force: |_: f64, _: &[f64; 1], _: &[f64; 1]| [0.0],
        contacts: [([1.0], 1.0)],
        belt: |t: f64| 1.3 * t.sin(),
    };
    let exact = reference.run([0.0], [0.0], 1e-5, 10.0);
    for h in [0.04, 0.02, 0.01, 0.005] {
        let mut flow = Flow::new(&shaker, h, Start::second_order([0.0], [0.0])).unwrap();
        let (mut slid, mut stuck) = (0, 0);
        while flow.time() < 10.0 - 0.5 * h {
            match flow.advance().unwrap().stop {
                Stop::Sticks => stuck += 1,
                _ => slid += 1,
            }
        }
        let error = (flow.position()[0] - exact[0]).abs();
        println!("{h}: {error:e}, {stuck} of {} stuck", stuck + slid);
        assert!(
            error < 0.5 * h && f64::from(stuck.min(slid)) * h > 1.0,
            "{h}: {error:e}"
        );
    }
}

/// Time stepping by Moreau's scheme with projected Gauss–Seidel iterations; shares no code with the project.
/// Friction acts along `contacts`, each a direction in the velocities with its largest force, against the
/// velocity `belt`.
struct Reference<M, F, B, const N: usize, const K: usize> {
    mass: M,
    force: F,
    contacts: [([f64; N], f64); K],
    belt: B,
}

impl<M, F, B, const N: usize, const K: usize> Reference<M, F, B, N, K>
where
    M: Fn(&[f64; N]) -> [[f64; N]; N],
    F: Fn(f64, &[f64; N], &[f64; N]) -> [f64; N],
    B: Fn(f64) -> f64,
{
    /// The position at the end.
    fn run(&self, mut q: [f64; N], mut v: [f64; N], dt: f64, until: f64) -> [f64; N] {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let steps = (until / dt).round() as usize;
        let mut impulses = [0.0; K];
        for k in 0..steps {
            let t = k as f64 * dt;
            // half a step of the positions, the velocities, the other half step
            for (q, v) in q.iter_mut().zip(&v) {
                *q += 0.5 * dt * v;
            }
            let mass = Decomposed::new((self.mass)(&q).map(|row| row.to_vec()).to_vec()).unwrap();
            let force = (self.force)(t + 0.5 * dt, &q, &v);
            let free = mass.solve(&force);
            for (v, a) in v.iter_mut().zip(&free) {
                *v += dt * a;
            }
            let responses = self.contacts.map(|(direction, _)| mass.solve(&direction));
            for (response, impulse) in responses.iter().zip(&impulses) {
                for (v, r) in v.iter_mut().zip(response) {
                    *v -= r * impulse;
                }
            }
            for _ in 0..200 {
                let mut moved = 0.0_f64;
                for ((impulse, response), (direction, largest)) in
                    impulses.iter_mut().zip(&responses).zip(&self.contacts)
                {
                    let along = |x: &[f64]| direction.iter().zip(x).map(|(d, x)| d * x).sum::<f64>();
                    let slip = along(&v) - (self.belt)(t + dt);
                    let wanted = *impulse + slip / along(response);
                    let next = wanted.clamp(-dt * largest, dt * largest);
                    let change = next - *impulse;
                    for (v, r) in v.iter_mut().zip(response) {
                        *v -= r * change;
                    }
                    moved = moved.max(change.abs() / (dt * largest));
                    *impulse = next;
                }
                if moved < 1e-12 {
                    break;
                }
            }
            for (q, v) in q.iter_mut().zip(&v) {
                *q += 0.5 * dt * v;
            }
        }
        q
    }
}

/// Three blocks in a row, coupled by springs and pushed at one end; friction with the floor, and between the second and the third one.
#[dsocs {
    coordinates(x: [3]);
    lagrangian = sum(0..3, |i| mass[i] * dot(x[i]).powi(2) / 2)
        - stiff[0] * x[0].powi(2) / 2 - stiff[1] * (x[1] - x[0]).powi(2) / 2 - stiff[2] * (x[2] - x[1]).powi(2) / 2;
    let between = dry[3] * (dot(x[2]) - dot(x[1])).signum();
    external_forces = (
        push * t.sin() - dry[0] * dot(x[0]).signum(),
        between - dry[1] * dot(x[1]).signum(),
        -between - if dot(x[2]) > 0 { dry[2] } else { -dry[2] },
    );
}]
struct Row {
    mass: [f64; 3],
    stiff: [f64; 3],
    dry: [f64; 4],
    push: f64,
}

impl Row {
    fn reference(&self, start: [f64; 3], until: f64) -> [f64; 3] {
        let Self {
            mass,
            stiff: k,
            dry,
            push,
        } = *self;
        let reference = Reference {
            mass: |_: &[f64; 3]| [[mass[0], 0.0, 0.0], [0.0, mass[1], 0.0], [0.0, 0.0, mass[2]]],
            force: |t: f64, x: &[f64; 3], _: &[f64; 3]| {
                let springs = [k[0] * x[0], k[1] * (x[1] - x[0]), k[2] * (x[2] - x[1])];
                [
                    push * t.sin() - springs[0] + springs[1],
                    springs[2] - springs[1],
                    -springs[2],
                ]
            },
            contacts: [
                ([1.0, 0.0, 0.0], dry[0]),
                ([0.0, 1.0, 0.0], dry[1]),
                ([0.0, 0.0, 1.0], dry[2]),
                ([0.0, -1.0, 1.0], dry[3]),
            ],
            belt: |_: f64| 0.0,
        };
        reference.run(start, [0.0; 3], 1e-4, until)
    }
}

/// The position at a time, the number of steps with sticking, and of those without.
fn end<S: System<N>, const N: usize>(
    system: &S,
    start: Start<N>,
    h: f64,
    until: f64,
) -> ([f64; N], [u32; 2]) {
    let mut flow = Flow::new(system, h, start).unwrap();
    let mut steps = [0; 2];
    while flow.time() < until - 0.5 * h {
        let report = flow.advance().unwrap();
        steps[usize::from(report.stop != Stop::Sticks)] += 1;
    }
    (*flow.position(), steps)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(short_or_long(5, 20)))]

    #[test]
    fn blocks_in_a_row_move_as_moreau_says(
        mass in prop::array::uniform3(0.3_f64..3.0), stiff in prop::array::uniform3(0.5_f64..10.0),
        dry in prop::array::uniform4(0.02_f64..1.5), push in -2.0_f64..2.0, start in prop::array::uniform3(-1.0_f64..1.0),
    ) {
        let row = Row { mass, stiff, dry, push };
        let exact = row.reference(start, 6.0);
        let start = Start::second_order(start, [0.0; 3]);
        let largest = (0..3).map(|i| (dry[i] + dry[3]) / mass[i]).fold(0.0, f64::max);
        for h in [0.02, 0.0025] {
            let (found, _) = end(&row, start, h, 6.0);
            // each of the few turns without a stop changes the velocity by at most half a step of the
            // friction
            let error = distance(&found, &exact);
            prop_assert!(error < 6.0 * h * largest + 1e-3, "{} {:e}: {:?} {:?}", h, error, found, exact);
        }
    }
}

#[test]
fn blocks_in_a_row_stick_alone_and_together() {
    let row = Row {
        mass: [1.0, 0.5, 2.0],
        stiff: [4.0, 2.0, 3.0],
        dry: [0.4, 0.3, 0.6, 0.2],
        push: 1.1,
    };
    let start = [0.9, -0.4, 0.2];
    let exact = row.reference(start, 12.0);
    let start = Start::second_order(start, [0.0; 3]);
    let mut flow = Flow::new(&row, 0.01, start).unwrap();
    let mut seen = [false; 8];
    while flow.time() < 12.0 {
        let report = flow.advance().unwrap();
        let d = flow.leg().d;
        let rest = [d[0], d[1], d[2], d[2] - d[1]].map(|d| d.abs() < 1e-14);
        seen[usize::from(rest[0]) + 2 * usize::from(rest[1]) + 4 * usize::from(rest[2])] = true;
        assert_eq!(
            report.stop == Stop::Sticks || report.stop == Stop::Jump,
            rest.contains(&true)
        );
        // no constraint acts, whatever sticks
        assert!(
            flow.node().force.iter().all(|force| force.abs() < 1e-11),
            "{:?}",
            flow.node()
        );
    }
    println!("{seen:?}");
    assert!(
        seen.iter().filter(|seen| **seen).count() >= 5 && seen[0] && seen[7],
        "{seen:?}"
    );
    for h in [0.02, 0.01, 0.005] {
        let (found, _) = end(&row, start, h, 12.0);
        println!("{h}: {:e}", distance(&found, &exact));
        assert!(distance(&found, &exact) < h, "{found:?} {exact:?}");
    }
}

declared! {
    /// An arm with two links and dry friction in both joints.
    struct Arm {
        weight: f64,
        dry: [f64; 2],
    }
    coordinates(alpha, beta);
    let kinetic = dot(alpha).powi(2) + dot(beta).powi(2) / 2 + (alpha - beta).cos() * dot(alpha) * dot(beta);
    lagrangian = kinetic + weight * (2 * alpha.cos() + beta.cos());
    let elbow = dry[1] * (dot(beta) - dot(alpha)).signum();
    external_forces = (elbow - dry[0] * dot(alpha).signum(), -elbow);
}

#[test]
fn joints_of_an_arm_stick_alone_and_together() {
    let mut found = [0; 4];
    for (weight, dry, start) in [
        (9.0, [1.5, 1.0], [0.8, 0.2]),
        (4.0, [0.4, 1.2], [1.4, -0.6]),
        (6.0, [5.0, 2.5], [0.9, 2.0]),
    ] {
        let arm = Arm { weight, dry };
        let reference = Reference {
            mass: |q: &[f64; 2]| {
                let cos = (q[0] - q[1]).cos();
                [[2.0, cos], [cos, 1.0]]
            },
            force: |_: f64, q: &[f64; 2], v: &[f64; 2]| {
                let sin = (q[0] - q[1]).sin();
                [
                    -sin * v[1] * v[1] - 2.0 * weight * q[0].sin(),
                    sin * v[0] * v[0] - weight * q[1].sin(),
                ]
            },
            contacts: [([1.0, 0.0], dry[0]), ([-1.0, 1.0], dry[1])],
            belt: |_: f64| 0.0,
        };
        let exact = reference.run(start, [0.0; 2], 2e-5, 6.0);
        for h in [0.01, 0.005, 0.0025] {
            let mut flow = Flow::new(&arm, h, Start::second_order(start, [0.0; 2])).unwrap();
            while flow.time() < 6.0 - 0.5 * h {
                flow.advance().unwrap();
                let [shoulder, elbow] =
                    [flow.leg().d[0], flow.leg().d[1] - flow.leg().d[0]].map(|d| d.abs() < 1e-13);
                found[usize::from(shoulder) + 2 * usize::from(elbow)] += 1;
            }
            let error = distance(flow.position(), &exact);
            println!("{h}: {error:e}");
            assert!(error < 2.0 * h, "{h}: {error:e} {:?} {exact:?}", flow.position());
        }
    }
    println!("{found:?}");
    assert!(found.iter().all(|steps| *steps > 20), "{found:?}");
}

declared! {
    /// A rod from the floor to a wall, with friction at both ends: one coordinate, two frictions.
    struct Tied {
        push: f64,
        dry: [f64; 2],
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + push * x;
    holonomic = 2 * x - y;
    external_forces = (-dry[0] * dot(x).signum(), -dry[1] * dot(y).signum());
}

#[test]
fn frictions_that_are_tied_to_each_other_hold_together() {
    let limit = 0.4 + 2.0 * 0.3;
    for push in [-0.999, -0.5, 0.0, 0.7, 0.999, 1.001, -1.5] {
        let tied = Tied {
            push: push * limit,
            dry: [0.4, 0.3],
        };
        for v in [0.0, 0.3] {
            let mut flow = Flow::new(&tied, 0.01, Start::second_order([0.1, 0.2], [v, 2.0 * v])).unwrap();
            for _ in 0..2000 {
                flow.advance().unwrap();
            }
            let report = flow.advance().unwrap();
            let node = flow.node();
            if push.abs() < 1.0 {
                // near the limit it takes long to stop
                if v == 0.0 || push < 0.9 {
                    assert_eq!(report.stop, Stop::Sticks, "{push} {v} {node:?}");
                    assert!(node.v.iter().all(|v| v.abs() < 1e-17));
                }
            } else {
                let a = (push - push.signum()) * limit / 5.0;
                assert!(
                    (node.a[0] - a).abs() < 1e-9 && report.stop == Stop::Update,
                    "{node:?} {a}"
                );
            }
        }
    }
}

declared! {
    /// A block on a slope; friction is a part of the constraint force.
    struct Pressed {
        slope: f64,
        friction: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 9.81 * y;
    holonomic = y + slope * x;
    let s = friction * dot(x).signum();
    constraint_forces = [(slope - s, 1 + s * slope)];
}

#[test]
fn friction_by_the_force_of_a_constraint_holds_within_its_cone() {
    for slope in [0.3, -0.5] {
        for part in [0.3_f64, 0.98, 1.02, 2.0] {
            let pressed = Pressed {
                slope,
                friction: slope.abs() / part,
            };
            let h = 0.005;
            for v in [0.0, slope.signum() * 0.4] {
                let start = Start::second_order([0.0, 0.0], [v, -slope * v]);
                let mut flow = Flow::new(&pressed, h, start).unwrap();
                // along the slope, per unit of x
                let length = 1.0 + slope * slope;
                let a = 9.81 * (slope - v.signum() * slope.abs() / part) / length;
                let time = if part < 1.0 && v != 0.0 { -v / a } else { 0.0 };
                while flow.time() < time + 1.0 {
                    flow.advance().unwrap();
                }
                let node = flow.node();
                if part < 1.0 {
                    let place = -v * v / (2.0 * a);
                    let place = if v == 0.0 { 0.0 } else { place };
                    if time > 30.0 {
                        continue;
                    }
                    assert_eq!(node.stop, Stop::Sticks, "{slope} {part} {v}");
                    assert!((node.q[0] - place).abs() < 20.0 * h * h, "{node:?} {place}");
                    // the slope carries the whole weight
                    assert!(
                        node.force[0].abs() < 1e-9 && (node.force[1] - 9.81).abs() < 1e-9,
                        "{node:?}"
                    );
                } else {
                    let sign = slope.signum();
                    let a = 9.81 * (slope - sign * slope.abs() / part) / length;
                    assert!((node.a[0] - a).abs() < 1e-8, "{node:?} {a}");
                }
            }
        }
    }
}

declared! {
    /// A prescribed motion with friction in the constraint.
    struct Prescribed {
        stiff: f64,
        dry: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = ddot(x) + stiff * x + dry * dot(x).signum();
    constraint_forces = [1];
}

#[test]
fn a_constraint_with_friction_comes_to_rest_where_it_should() {
    for start in [0.3, 2.5, 3.1, 4.7, -6.2] {
        let prescribed = Prescribed { stiff: 1.0, dry: 1.0 };
        // half swings about 1 and -1, each shorter by 2, until the friction holds
        let mut rest: f64 = start;
        while rest.abs() > 1.0 {
            rest = 2.0 * rest.signum() - rest;
        }
        for h in [0.05, 0.01, 0.002] {
            let mut flow = Flow::new(&prescribed, h, Start::second_order([start], [0.0])).unwrap();
            while flow.time() < 16.0 {
                flow.advance().unwrap();
            }
            let stays = flow.position()[0];
            assert!((stays - rest).abs() < 3.0 * h, "{start} {h}: {stays} {rest}");
            for _ in 0..100 {
                assert_eq!(flow.advance().unwrap().stop, Stop::Sticks);
                let node = flow.node();
                assert_eq!(node.q[0], stays);
                // at rest there is no constraint force
                assert!(
                    node.v[0].abs() < 1e-16 && node.a[0].abs() < 1e-14 && node.force[0].abs() < 1e-14,
                    "{node:?}"
                );
            }
        }
    }
}

declared! {
    /// Two masses on springs. Without friction the step keeps an energy to rounding: the kinetic energy of a
    /// leg, and the springs' by the product of their elongations at its ends.
    struct Springs {
        dry: [f64; 2],
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 2 * x.powi(2) - (y - x).powi(2) / 2;
    external_forces = (-dry[0] * dot(x).signum(), -dry[1] * dot(y).signum());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(short_or_long(6, 24)))]

    #[test]
    fn friction_gives_no_energy(
        dry in prop::array::uniform2(0.01_f64..1.0), start in prop::array::uniform2(-2.0_f64..2.0), h in 0.001_f64..0.05,
    ) {
        let springs = Springs { dry };
        let mut flow = Flow::new(&springs, h, Start::second_order(start, [0.0; 2])).unwrap();
        let energy = |flow: &dsocs_core::Flow<'_, 2>| {
            let ([d, e], [x, y]) = (flow.leg().d, *flow.position());
            let (before, between) = ([x - d, y - e], y - x);
            let potential = 2.0 * x * before[0] + between * (before[1] - before[0]) / 2.0;
            (d * d + e * e) / (2.0 * h * h) + potential
        };
        let first = energy(&flow);
        let mut last = first;
        // where a mass stops, turns or is released within a step, friction acts with its mean over the step,
        // and the energy may rise by this much
        let allowed = (dry[0] + dry[1]).powi(2) * h * h;
        for _ in 0..2000 {
            let before = flow.leg().d;
            let report = flow.advance().unwrap();
            let now = energy(&flow);
            let mut legs = before.iter().zip(flow.leg().d);
            let switches = report.stop == Stop::Jump || legs.any(|(before, after)| before * after < 0.0);
            let allowed = if switches { allowed } else { 0.0 };
            prop_assert!(now <= last + allowed + 1e-13 * first.abs(), "{:e} {:?}", now - last, report);
            last = now;
        }
    }
}

#[test]
fn a_force_along_the_velocity_holds_nothing() {
    // a friction of the other sign
    for dry in [[-0.3, 0.0], [0.2, -0.3]] {
        let springs = Springs { dry };
        for h in [0.01, 0.003] {
            let mut flow = Flow::new(&springs, h, Start::second_order([0.4, -0.1], [0.0; 2])).unwrap();
            while flow.time() < 5.0 {
                flow.advance().unwrap();
                let pushed = usize::from(dry[0] > 0.0);
                assert!(flow.leg().d[pushed].abs() > 1e-3 * h * h, "{h} {:?}", flow.node());
            }
        }
    }
}

#[test]
fn without_friction_nothing_is_held() {
    let free = Springs { dry: [0.0; 2] };
    for start in [[0.5, -0.2], [0.0, 0.0], [0.0, 1.0]] {
        let mut flow = Flow::new(&free, 0.01, Start::paper(start, [0.0; 2])).unwrap();
        let mut leg = flow.leg();
        for _ in 0..1000 {
            flow.advance().unwrap();
            let [x, y] = leg.q;
            let force = [-4.0 * x + (y - x), x - y];
            for i in 0..2 {
                let e = flow.leg().d[i] - leg.d[i];
                assert!((e - 1e-4 * force[i]).abs() < 1e-17, "{e:e} {force:?}");
            }
            leg = flow.leg();
        }
    }
}

/// A block that has stopped keeps its position to the last bit over 100 000 steps and when the run is
/// reversed; a run with sticking has no derivative.
#[test]
fn what_rests_rests_for_ever_and_no_derivative_is_told() {
    let block = Block {
        mass: 1.0,
        slope: 0.3,
        friction: 0.5,
    };
    let start = Start::second_order([0.25], [0.7]);
    let mut flow = Flow::new(&block, 0.01, start).unwrap();
    for _ in 0..100 {
        flow.advance().unwrap();
    }
    let rests = *flow.position();
    for _ in 0..100_000 {
        assert_eq!(flow.advance().unwrap().stop, Stop::Sticks);
    }
    assert_eq!(*flow.position(), rests);
    // also where it turns round
    flow.reverse().unwrap();
    assert_eq!(*flow.position(), rests);
    flow.advance().unwrap();
    assert_eq!(*flow.position(), rests);
    let start = Start::second_order([0.25], [0.0]).into();
    assert!(AnyPath::new(read(&block), 0.01, &start, 1.0).is_err());
}

declared! {
    /// A block on the floor that is pushed.
    #[derive(Clone)]
    struct Pushed {
        push: f64,
        dry: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = push - dry * dot(x).signum();
}

#[test]
fn an_input_that_changes_holds_or_tears_off_at_its_node() {
    for sign in [1.0, -1.0] {
        for h in [0.125, 0.0625] {
            let pushed = Pushed { push: 0.0, dry: 1.0 };
            let mut flow = Flow::new(&pushed, h, Start::second_order([0.0], [0.0])).unwrap();
            flow.to(1.0).unwrap();
            flow.set_input("push", 0.75 * sign).unwrap();
            flow.to(2.0).unwrap();
            assert_eq!((flow.position()[0], flow.node().stop), (0.0, Stop::Sticks));
            flow.set_input("push", 2.0 * sign).unwrap();
            // from the known position on, one step ahead of the node
            let begins = flow.time();
            while flow.time() < 4.0 {
                flow.advance().unwrap();
                let node = flow.node();
                let t = node.t - begins;
                assert!(
                    (node.q[0] - 0.5 * sign * t.max(0.0).powi(2)).abs() < 1e-12,
                    "{node:?}"
                );
                assert!(node.force[0].abs() < 1e-12, "{node:?}");
            }
        }
    }
}

#[test]
fn lanes_rest_where_flows_do() {
    let row = Row {
        mass: [1.0, 0.5, 2.0],
        stiff: [4.0, 2.0, 3.0],
        dry: [0.4, 0.3, 0.6, 0.2],
        push: 1.1,
    };
    let starts: Vec<_> = (0..21)
        .map(|i| Start::second_order([0.1 * f64::from(i), 0.3, -0.05 * f64::from(i)], [0.0; 3]))
        .collect();
    let ends = Ensemble::new(&row, 0.01)
        .unwrap()
        .starts(starts.iter().copied())
        .to(9.0);
    for (start, end) in starts.iter().zip(ends) {
        let node = Flow::new(&row, 0.01, *start).unwrap().to(9.0).unwrap();
        let end = end.unwrap();
        // lanes choose their pivots together: the last bits may differ
        assert!(distance(&end.q, &node.q) < 1e-14, "{end:?} {node:?}");
        assert_eq!(end.stop, node.stop);
    }
}

/// Three blocks come to rest one upon the other at one time. The slip between two blocks that rest is zero, but for the
/// rounding of their velocities: it can not go another way than they do.
#[test]
fn blocks_that_come_to_rest_together_do_not_fork() {
    let row = Row {
        mass: [0.3, 1.155_722_899_763_146_1, 1.313_938_726_727_473],
        stiff: [
            1.694_871_989_360_917_4,
            5.767_820_962_835_81,
            5.317_997_637_527_738,
        ],
        dry: [
            0.951_052_790_630_369_2,
            0.256_051_242_552_274_5,
            0.673_699_345_269_173_4,
            1.259_566_222_517_928_7,
        ],
        push: 0.0,
    };
    let start = [
        0.046_000_368_771_444_38,
        -0.336_896_591_912_647_1,
        -0.596_855_639_658_985,
    ];
    let exact = row.reference(start, 3.0);
    let start = Start::second_order(start, [0.0; 3]);
    for h in [0.02, 0.005, 0.0025, 0.001] {
        let (found, _) = end(&row, start, h, 3.0);
        assert!(distance(&found, &exact) < h, "{h}: {found:?} {exact:?}");
    }
}
