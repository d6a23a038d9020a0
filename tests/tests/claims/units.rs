//! Certificates of declarations with multipliers do not depend on the units of the coordinates, the
//! constraints, mass and time. A motion has a Taylor series in every unit of time.

use core::array;

use dsocs_core::geometry::FlowTheorem;
use dsocs_core::{Leg, Regularity, Start, Stepper as _, Tolerance, dsocs};
use dsocs_systems::Sleigh;
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::text::{Flow, System, TaylorFlow};

/// Units, expressed in natural ones: powers of two, which do not round.
#[derive(Clone, Copy, Debug)]
struct Units {
    /// Of each coordinate.
    x: [f64; 3],
    /// Of each constraint, and so of the inverse of its multiplier.
    l: [f64; 2],
    /// Of mass.
    m: f64,
    /// Of time.
    t: f64,
}

/// The natural units.
const NATURAL: Units = Units {
    x: [1.0; 3],
    l: [1.0; 2],
    m: 1.0,
    t: 1.0,
};

/// The largest exponent of two.
const EXPONENT: f64 = 40.0;

impl Units {
    /// Units at random.
    fn new(random: &mut Random) -> Self {
        let mut unit = || random.between(-EXPONENT, EXPONENT).round().exp2();
        Self {
            x: array::from_fn(|_| unit()),
            l: array::from_fn(|_| unit()),
            m: unit(),
            t: unit(),
        }
    }

    /// All units for which one of them has an exponent at the end of its range.
    fn extremes() -> Vec<Self> {
        let set: [fn(&mut Self, f64); 7] = [
            |units, to| units.x[0] = to,
            |units, to| units.x[1] = to,
            |units, to| units.x[2] = to,
            |units, to| units.l[0] = to,
            |units, to| units.l[1] = to,
            |units, to| units.m = to,
            |units, to| units.t = to,
        ];
        let ends = [-EXPONENT, EXPONENT].map(f64::exp2);
        let pairs = set.iter().flat_map(|set| ends.map(|to| (set, to)));
        pairs
            .map(|(set, to)| {
                let mut units = NATURAL;
                set(&mut units, to);
                units
            })
            .collect()
    }
}

macro_rules! in_units {
    ($(#[$meta:meta])* $name:ident($x:ident, $y:ident, $z:ident) { $($body:tt)* }) => {
        declared! {
            $(#[$meta])*
            struct $name {
                sx: [f64; 3],
                sl: [f64; 2],
                sm: f64,
                st: f64,
            }
            coordinates($x, $y, $z);
            let first = $x / sx[0];
            let second = $y / sx[1];
            let third = $z / sx[2];
            $($body)*
        }

        impl From<Units> for $name {
            fn from(Units { x: sx, l: sl, m: sm, t: st }: Units) -> Self {
                Self { sx, sl, sm, st }
            }
        }
    };
}

in_units! {
    /// The Chaplygin sleigh: a nonholonomic constraint, one coordinate an angle.
    Blade(x, y, theta) {
        let first_rate = st * dot(first);
        let second_rate = st * dot(second);
        let third_rate = st * dot(third);
        let speed = first_rate * third.cos() + second_rate * third.sin();
        let across = second_rate * third.cos() - first_rate * third.sin();
        lagrangian = sm * (0.65 * (speed.powi(2) + (across + 0.6 * third_rate).powi(2)) + 0.2 * third_rate.powi(2));
        nonholonomic = sl[0] * across;
    }
}

in_units! {
    /// A point on a rod, which slides on a rail that turns: two holonomic constraints.
    Rods(x, y, z) {
        let first_rate = st * dot(first);
        let second_rate = st * dot(second);
        let third_rate = st * dot(third);
        lagrangian = sm * (0.35 * (first_rate.powi(2) + second_rate.powi(2) + third_rate.powi(2)) - 9.81 * second);
        holonomic = [
            sl[0] * (first.powi(2) + second.powi(2) - 1),
            sl[1] * (third - first / 2),
        ];
    }
}

in_units! {
    /// A rod and a wheel in Cartesian coordinates: a holonomic constraint beside one of second order.
    Driven(x, y, psi) {
        let first_rate = st * dot(first);
        let second_rate = st * dot(second);
        let third_rate = st * dot(third);
        let angle = first.atan2(second);
        let rate = (second * first_rate - first * second_rate) / (first.powi(2) + second.powi(2));
        lagrangian = sm * (2 * (first_rate.powi(2) + second_rate.powi(2)) + 0.1 * (rate + third_rate).powi(2) / 2 - 3 * second);
        holonomic = sl[0] * (first.powi(2) + second.powi(2) - 1);
        kinematic = sl[1] * (st * dot(third_rate) + 0.8 * third_rate + 3 * (third - angle));
        constraint_forces = [(0, 0, 1 / sx[2])];
        phi_lagrangian = trapezoid;
    }
}

in_units! {
    /// The nonholonomic particle with a discrete row that does not contain the first node: the inverse does
    /// not exist.
    OneSided(x, y, z) {
        let first_rate = st * dot(first);
        let second_rate = st * dot(second);
        let third_rate = st * dot(third);
        lagrangian = sm * (first_rate.powi(2) + second_rate.powi(2) + third_rate.powi(2)) / 2;
        nonholonomic = sl[0] * (third_rate - second * first_rate);
        kinematic = sl[1] * (st * dot(second_rate) + first.sin() * first_rate);
        discrete_kinematic = sl[1] * (st * (y[2] - y[1]) / (h * sx[1]) - (x[1] / sx[0]).cos());
        constraint_forces = [(0, 1 / sx[1], 0)];
    }
}

in_units! {
    /// The nonholonomic particle.
    Particle(x, y, z) {
        let first_rate = st * dot(first);
        let second_rate = st * dot(second);
        let third_rate = st * dot(third);
        lagrangian = sm * (first_rate.powi(2) + second_rate.powi(2) + third_rate.powi(2)) / 2;
        nonholonomic = sl[0] * (third_rate - second * first_rate);
    }
}

in_units! {
    /// A rod whose end has no mass of its own, but hangs on a spring.
    Massless(x, y, z) {
        lagrangian = sm * ((st * dot(first)).powi(2) / 2 - 2 * (third - first).powi(2) - (second - 0.3).powi(2) - 9.81 * second);
        holonomic = sl[0] * (second.powi(2) + third.powi(2) - 4);
    }
}

in_units! {
    /// A wheel that rolls without slipping: two constraints of velocities and a rod.
    Wheel(x, y, roll) {
        let first_rate = st * dot(first);
        let second_rate = st * dot(second);
        let third_rate = st * dot(third);
        lagrangian = sm * (1.5 * (first_rate.powi(2) + second_rate.powi(2)) + 0.02 * third_rate.powi(2) - 9.81 * second);
        nonholonomic = sl[0] * (first_rate - 0.1 * third_rate);
        holonomic = sl[1] * (second - first.powi(2) / 4);
    }
}

/// A triple of nodes and a step, in natural units.
#[derive(Clone, Copy, Debug)]
struct Place {
    h: f64,
    q: [f64; 3],
    d: [f64; 3],
    e: [f64; 3],
}

impl Place {
    /// The certificate of the step in some units.
    fn certificate<S: System<3> + From<Units>>(&self, units: Units) -> (Regularity, FlowTheorem) {
        let Self { h, q, d, e } = *self;
        let of = |x: [f64; 3]| -> [f64; 3] { array::from_fn(|i| x[i] * units.x[i]) };
        let system = S::from(units);
        let leg = Leg {
            t: 0.0,
            q: of(q),
            d: of(d),
        };
        let (h, e) = (h * units.t, of(e));
        (
            Regularity::of(system.kernel(), h, leg.any(), &e),
            FlowTheorem::at(system.kernel(), h, leg.any(), &e),
        )
    }
}

/// Whether two singular values are equal to 1e-9; values below 1e-14 of `largest` count as zero.
fn same(x: f64, y: f64, largest: f64) -> bool {
    let zero = 1e-14 * largest;
    (x - y).abs() <= 1e-9 * x.abs().max(y.abs()) || (x <= zero && y <= zero) || (x.is_nan() && y.is_nan())
}

/// Triples along a motion, near it, with coordinates at rest, and at rest.
fn places<S: System<3> + From<Units>>(h: f64, q0: [f64; 3], v0: [f64; 3]) -> Vec<Place> {
    let system = S::from(NATURAL);
    let mut places = Vec::new();
    if let Ok(mut flow) = Flow::new(&system, h, Start::second_order(q0, v0)) {
        for _ in 0..20 {
            let before = flow.leg();
            if flow.advance().is_err() {
                break;
            }
            let after = flow.leg();
            places.push(Place {
                h,
                q: before.q,
                d: before.d,
                e: array::from_fn(|i| after.d[i] - before.d[i]),
            });
        }
    }
    let mut random = Random::new(5);
    for k in 0..12 {
        let q: [f64; 3] = array::from_fn(|i| q0[i] + random.between(-0.5, 0.5));
        let mut d: [f64; 3] = array::from_fn(|_| h * random.between(-1.0, 1.0));
        let mut e: [f64; 3] = array::from_fn(|_| h * h * random.between(-1.0, 1.0));
        // some coordinates stand still, or nearly so
        for i in 0..3 {
            if (k >> i) & 1 == 1 {
                let part = if k < 8 { 0.0 } else { 1e-9 };
                (d[i], e[i]) = (part * d[i], part * e[i]);
            }
        }
        places.push(Place { h, q, d, e });
    }
    places
}

/// Compares the certificates of a declaration in many units with that in natural ones.
fn compare<S: System<3> + From<Units>>(name: &str, h: f64, q0: [f64; 3], v0: [f64; 3]) -> Vec<Regularity> {
    let mut random = Random::new(77);
    let mut all = Units::extremes();
    all.extend((0..20).map(|_| Units::new(&mut random)));
    let mut granted = Vec::new();
    let mut wrong = Vec::new();
    for place in places::<S>(h, q0, v0) {
        let (natural, theorem) = place.certificate::<S>(NATURAL);
        for &units in &all {
            let (at, its) = place.certificate::<S>(units);
            let holds = same(natural.forward, at.forward, natural.largest_forward)
                && same(natural.backward, at.backward, natural.largest_backward)
                && same(natural.largest_forward, at.largest_forward, 0.0)
                && same(natural.largest_backward, at.largest_backward, 0.0)
                && natural.grants_forward() == at.grants_forward()
                && natural.grants_backward() == at.grants_backward()
                && theorem.rank == its.rank
                && theorem.full == its.full
                && same(theorem.margin, its.margin, 1.0);
            if !holds {
                wrong.push(format!(
                    "{natural:?}\n  {at:?}\n  {theorem:?}\n  {its:?}\n  {place:?}, {units:?}"
                ));
            }
        }
        granted.push(natural);
    }
    assert!(
        wrong.is_empty(),
        "{name}: {} certificates depend on units, such as\n  {}",
        wrong.len(),
        wrong[0]
    );
    granted
}

#[test]
fn certificates_do_not_depend_on_units() {
    let both = |granted: &[Regularity]| granted.iter().all(Regularity::grants_flow);
    let blade = compare::<Blade>("blade", 0.05, [0.0; 3], [-1.0, 0.0, 0.3]);
    assert!(both(&blade[..20]), "{blade:?}");
    let rods = compare::<Rods>("rods", 0.01, [0.6, -0.8, 0.3], [0.0; 3]);
    assert!(both(&rods[..20]), "{rods:?}");
    let driven = compare::<Driven>("driven", 0.01, [0.6, 0.8, 0.0], [0.0, 0.0, 0.5]);
    assert!(both(&driven[..20]), "{driven:?}");
    let particle = compare::<Particle>("particle", 0.02, [0.1, 0.3, 0.0], [1.0, 0.4, 0.3]);
    assert!(both(&particle[..20]), "{particle:?}");
    let wheel = compare::<Wheel>("wheel", 0.01, [0.4, 0.04, 0.0], [1.0, 0.2, 10.0]);
    assert!(both(&wheel[..20]), "{wheel:?}");
    compare::<Massless>("massless", 0.01, [0.5, 1.2, 1.6], [0.3, 0.0, 0.0]);
    let one_sided = compare::<OneSided>("one-sided", 0.02, [0.1, 0.3, 0.0], [1.0, 0.4, 0.3]);
    assert!(one_sided.iter().all(Regularity::grants_forward), "{one_sided:?}");
    assert!(
        !one_sided.iter().any(Regularity::grants_backward),
        "{one_sided:?}"
    );
}

/// The sleigh's default run, and one in which one coordinate comes to rest.
#[test]
fn a_sleigh_is_regular_throughout() {
    let sleigh = Sleigh::default();
    for (v0, until) in [([-1.0, 0.0, 0.3], 40.0), ([1.0, 0.0, 0.3], 200.0)] {
        let mut flow = Flow::new(&sleigh, 0.05, Start::second_order([0.0; 3], v0)).unwrap();
        let mut lost = 0;
        flow.certify(until, &mut |_, regularity| {
            lost += usize::from(regularity.is_some_and(|at: Regularity| !at.grants_flow()));
            core::ops::ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(lost, 0, "regularity is said to be lost from {v0:?}");
    }
}

/// A relativistic charge in a magnetic field; `unit` is the number of its units of time in a natural one.
#[dsocs {
    coordinates(x, y);
    let slow = (1 - (dot(x).powi(2) + dot(y).powi(2)) * unit.powi(2)).sqrt();
    lagrangian = -slow / unit.powi(2) + (x * dot(y) - y * dot(x)) / (2 * unit) * (1 + x.powi(2) / 10) + x * field / unit.powi(2);
}]
struct Charge {
    unit: f64,
    field: f64,
}

/// Electrons circulate 1e11 times in a second, and galaxies once in 1e16 seconds: high-order coefficients
/// leave the range of doubles. The series then uses lower orders and more steps.
#[test]
fn any_unit_of_time_will_do() {
    for (tolerance, near) in [(1e-6, 1e-5), (1e-12, 1e-11)] {
        let run = |exponent: f64| {
            let unit = exponent.exp2();
            let start = Start::second_order([0.0; 2], [0.6 / unit, 0.0]);
            let charge = Charge { unit, field: 0.1 };
            let mut flow = TaylorFlow::new(&charge, start, Tolerance::relative(tolerance)).unwrap();
            let end = flow.to(20.0 * unit).unwrap();
            (end.q, flow.steps(), flow.rejected().unwrap())
        };
        let (expected, steps, _) = run(0.0);
        for exponent in [-110.0, -80.0, -60.0, -36.0, -20.0, 20.0, 36.0, 60.0, 80.0, 110.0] {
            let (q, needed, rejected) = run(exponent);
            let apart = (q[0] - expected[0]).hypot(q[1] - expected[1]);
            assert!(apart < near, "2^{exponent}: {apart}");
            println!("{tolerance:e}, 2^{exponent}: {needed} + {rejected} steps, {steps} in the natural unit");
            assert!(exponent.abs() > 40.0 || needed + rejected < 2 * steps);
        }
    }
}

/// Frequencies of 1e60 to 1e150 end a Taylor flow with an error.
#[test]
fn what_leaves_the_range_of_doubles_ends_a_run() {
    // faster than any clock
    for exponent in [60, 78, 90, 120, 150] {
        let text = format!(
            "coordinates(x); lagrangian = 1e-{exponent} * dot(x).powi(2) / 2 - 1e{exponent} * x.powi(2) / 2;"
        );
        let text = dsocs_core::text::Text::parse("fast", &text).unwrap();
        let start = Start::second_order([1.0], [0.0]);
        let flow = TaylorFlow::read(&text.system, start, Tolerance::relative(1e-9));
        assert!(flow.unwrap().to(10.0).is_err(), "{exponent}");
    }
}
