//! Rotations under constraints of positions: projected starts, and the Taylor series of the motion.

use dsocs_core::taylor::AnyTaylorFlow;
use dsocs_core::text::Text;
use dsocs_core::{
    AnyFlow, AnyPath, AnyStart, Flow, OwnedNode, Run, Start, Stepper, TaylorFlow, Tolerance, Variable, dsocs,
};

use crate::rotations::{Motion, joined, part};
use dsocs_tests::vectors::{Vector, cross, dot, matrix, plus, product, rate, solved, times, unit};

/// A body with a held point: its centre is bound to its attitude.
const HELD: &str = "parameters { inertia = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]], arm = [0.2, 0.1, 1.0], mass = 0.7 }
    coordinates(r: rotation, x: [3]);
    let w = r.angular_velocity();
    lagrangian = w.inner(inertia * w) / 2 + mass * dot(x).norm_squared() / 2 - mass * x[2];
    holonomic = x - r * arm;";

const INERTIA: [Vector; 3] = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]];
const ARM: Vector = [0.2, 0.1, 1.0];
const MASS: f64 = 0.7;

/// Its motion by Euler's equations about the point.
fn motion_about_point(until: f64) -> Motion {
    let square = dot(ARM, ARM);
    let about: [Vector; 3] = [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let one = if i == j { square } else { 0.0 };
            INERTIA[i][j] + MASS * (one - ARM[i] * ARM[j])
        })
    });
    let hand = |y: &[f64; 7]| {
        let (q, w): ([f64; 4], Vector) = (part(y, 0), part(y, 4));
        let weight = times(MASS, cross(matrix(q)[2], ARM));
        let torque = plus(cross(product(&about, w), w), weight);
        joined(&[&rate(q, w), &solved(&about, torque)])
    };
    let (q0, w0) = (unit([1.0, 0.3, -0.4, 0.2]), [0.6, -0.3, 2.0]);
    let mut motion = Motion::by_hand(hand, (&q0, &w0), until);
    for (q, v) in [(&mut motion.q0, &mut motion.v0), (&mut motion.q, &mut motion.v)] {
        let attitude = matrix(core::array::from_fn(|i| q[i]));
        q.extend(product(&attitude, ARM));
        let spin = core::array::from_fn(|i| v[i]);
        v.extend(product(&attitude, cross(spin, ARM)));
    }
    motion
}

fn with_zero(v: &[f64]) -> Vec<f64> {
    [&[0.0], v].concat()
}

#[test]
fn a_body_on_a_point_is_followed_by_its_series() {
    let text = Text::parse("held", HELD).unwrap_or_else(|error| panic!("{error}"));
    let motion = motion_about_point(20.0);
    let start = AnyStart::second_order(&motion.q0, &with_zero(&motion.v0));
    for tolerance in [1e-8, 1e-12, 1e-15] {
        let mut flow = AnyTaylorFlow::of_tape(&text.system, &start, Tolerance::relative(tolerance)).unwrap();
        let run: &mut dyn Run = &mut flow;
        run.to(motion.until).unwrap();
        let mut node = OwnedNode::new(7);
        node.take(run);
        let node = node.any();
        let known = motion
            .q
            .iter()
            .zip(node.q)
            .chain(motion.v.iter().zip(&node.v[1..]));
        let apart = known
            .map(|(known, found)| (known - found).abs())
            .fold(0.0, f64::max);
        println!("{tolerance:e}: {apart:e}");
        assert!(apart < 100.0 * tolerance.max(1e-13), "{tolerance:e}: {apart:e}");
        // on the constraint and of norm one, whatever the tolerance
        let q: [f64; 4] = core::array::from_fn(|i| node.q[i]);
        let place = product(&matrix(q), ARM);
        for (x, place) in node.q[4..].iter().zip(place) {
            assert!((x - place).abs() < 4e-15, "{tolerance:e}: {:?}", node.q);
        }
        let norm = q.iter().map(|q| q * q).sum::<f64>().sqrt();
        assert!((norm - 1.0).abs() <= 2.0 * f64::EPSILON, "{norm}");
    }
}

/// A body with a held point, as a compiled system.
#[dsocs {
    coordinates(r: rotation, x: [3]);
    let w = r.angular_velocity();
    lagrangian = w.inner(inertia * w) / 2 + mass * dot(x).norm_squared() / 2 - mass * x[2];
    holonomic = x - r * arm;
}]
struct Held {
    inertia: [[f64; 3]; 3],
    arm: [f64; 3],
    mass: f64,
}

#[test]
fn a_compiled_system_has_the_bits_of_its_text_under_constraints_too() {
    let text = Text::parse("held", HELD).unwrap();
    let system = Held {
        inertia: INERTIA,
        arm: ARM,
        mass: MASS,
    };
    let motion = motion_about_point(2.0);
    let (q0, v0): ([f64; 7], [f64; 7]) = (joined(&[&motion.q0]), joined(&[&[0.0], &motion.v0]));
    // off the constraint, in attitude and in position
    let mut off = q0;
    (off[1], off[5]) = (off[1] + 1e-7, off[5] - 0.01);
    let tolerance = Tolerance::relative(1e-12);
    let mut compiled = TaylorFlow::new(&system, Start::second_order(off, v0).projected(), tolerance).unwrap();
    let last = compiled.to(2.0).unwrap();
    let start = AnyStart::second_order(&off, &v0).projected();
    let mut flow = AnyTaylorFlow::of_tape(&text.system, &start, tolerance).unwrap();
    let run: &mut dyn Run = &mut flow;
    run.to(2.0).unwrap();
    let mut node = OwnedNode::new(7);
    node.take(run);
    let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&last.q), bits(node.any().q));
    assert_eq!(bits(&last.v), bits(node.any().v));

    // an exact start has the nodes of the motion
    let exact = |h: f64| {
        let start = Start::second_order(q0, v0).exact(&system, h).unwrap();
        let flow = Flow::new(&system, h, start).unwrap();
        let mut taylor =
            TaylorFlow::new(&system, Start::second_order(q0, v0), Tolerance::relative(1e-16)).unwrap();
        let known = taylor.to(h).unwrap();
        flow.position()
            .iter()
            .zip(known.q)
            .map(|(one, other)| (one - other).abs())
            .fold(0.0, f64::max)
    };
    for h in [0.2, 0.01, 1e-4] {
        // the second node is projected onto the row of the pair
        assert!(exact(h) < 2e-16 + 1e-15, "{h}: {:e}", exact(h));
    }
}

#[test]
fn an_increment_of_an_exact_start_has_the_digits_of_the_leg() {
    // a free body that spins about an axis turns by h ω
    let q0 = unit([1.0, 0.3, -0.4, 0.2]);
    for h in [0.3, 1e-3, 1e-6] {
        let w = [0.6, -0.3, 2.0];
        let start = Start::second_order(q0, joined(&[&[0.0], &w]))
            .exact(&Free {}, h)
            .unwrap();
        let flow = Flow::new(&Free {}, h, start).unwrap();
        let angle = h * dot(w, w).sqrt();
        // the Padé map of the increment turns by this angle
        let d = flow.leg().d;
        let size = d.iter().map(|d| d * d).sum::<f64>().sqrt();
        let turned = 4.0 * (0.25 * size / (1.0 - size * size / 48.0)).atan();
        assert!((turned / angle - 1.0).abs() < 1e-15, "{h}: {turned:e} {angle:e}");
        let spin = dot(w, w).sqrt();
        for (d, w) in d[1..].iter().zip(w) {
            assert!((d / size - w / spin).abs() < 5e-16, "{h}: {d:e}");
        }
    }
}

#[dsocs {
    coordinates(r: rotation);
    lagrangian = r.angular_velocity().norm_squared();
}]
struct Free {}

#[test]
fn a_start_off_a_constraint_is_moved_onto_it_as_that_of_an_angle_is() {
    // a wheel with a mass that slides on a rod of it, at the end of a thread
    let texts = [
        "coordinates(phi, x: [2]);
         lagrangian = dot(phi).powi(2) / 2 + dot(x).norm_squared() / 2 - x[1];
         holonomic = x - [phi.cos(), phi.sin()];",
        "coordinates(r: rotation, x: [2]);
         let e = r * [1, 0, 0];
         lagrangian = r.angular_velocity().norm_squared() / 2 + dot(x).norm_squared() / 2 - x[1];
         holonomic = x - [e[0], e[1]];",
    ];
    let texts = texts.map(|text| Text::parse("wheel", text).unwrap_or_else(|error| panic!("{error}")));
    let (angle, spin) = (0.8_f64, 0.5);
    let (sine, cosine) = (0.5 * angle).sin_cos();
    // a tenth off, in position and velocity
    let x = [angle.cos() + 0.1, angle.sin() - 0.05];
    let v = [0.1, 0.4];
    let starts = [
        AnyStart::second_order(&[angle, x[0], x[1]], &[spin, v[0], v[1]]),
        AnyStart::second_order(
            &[cosine, 0.0, 0.0, sine, x[0], x[1]],
            &[0.0, 0.0, 0.0, spin, v[0], v[1]],
        ),
    ];
    for (text, start) in texts.iter().zip(&starts) {
        assert!(AnyFlow::new(&text.system, 0.01, start).is_err());
    }
    let node = |place: usize| {
        let flow = AnyFlow::new(&texts[place].system, 0.01, &starts[place].clone().projected()).unwrap();
        let mut node = OwnedNode::new(1);
        node.take(flow.run());
        [node.any().q, node.any().v].map(<[f64]>::to_vec)
    };
    let ([q, v], [r, w]) = (node(0), node(1));
    let norm = r[..4].iter().map(|r| r * r).sum::<f64>().sqrt();
    assert!((norm - 1.0).abs() <= f64::EPSILON, "{r:?}");
    // the wheel turns about its axis alone
    assert!(r[1].abs().max(r[2].abs()) < f64::MIN_POSITIVE, "{r:?}");
    let first = [
        [q[0], q[1], q[2], v[0], v[1], v[2]],
        [2.0 * r[3].atan2(r[0]), r[4], r[5], w[3], w[4], w[5]],
    ];
    // both projections make the least change in the same metric: the increment of the rotation is its angle
    // up to θ⁵/11520
    for (number, rotation) in first[0].iter().zip(first[1]) {
        assert!((number - rotation).abs() < 1e-8, "{first:?}");
    }
    let [phi, x, y, ..] = first[1];
    assert!(
        (x - phi.cos()).abs() < 1e-15 && (y - phi.sin()).abs() < 1e-15,
        "{first:?}"
    );
    assert!((phi - angle).abs() > 1e-3);
}

#[test]
fn a_row_that_has_no_gradient_where_it_holds_is_named() {
    let link = Text::parse(
        "link",
        "coordinates(r: rotation);
         lagrangian = r.angular_velocity().norm_squared() - (r * [0, 0.3, 1])[2];
         holonomic = (r * [1, 0, 0])[0] - 1;",
    )
    .unwrap()
    .system;
    let start = AnyStart::second_order(&unit([1.0, 0.0, 0.05, 0.2]), &[1.0, 0.0, 0.0]).projected();
    let message = match AnyFlow::new(&link, 0.01, &start) {
        Ok(mut flow) => flow.run_mut().to(1.0).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    };
    assert!(
        message.contains("holonomic constraint 1 has no gradient at q1, where it holds")
            && message.contains("two rows for an axis"),
        "{message}"
    );
}

/// A link on a hinge about the first axis of space and of the link.
const HINGE: &str = "coordinates(r: rotation);
     let w = r.angular_velocity();
     lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - (r * [0, 0.3, 1])[2];
     holonomic = [(r * [1, 0, 0]).inner([0, 1, 0]), (r * [1, 0, 0]).inner([0, 0, 1])];";

#[test]
fn a_start_far_from_a_hinge_comes_to_the_assembly_that_is_near() {
    let link = Text::parse("link", HINGE).unwrap().system;
    // the rows also hold where the axis is reversed, and their Newton's iteration leads there from 1.17 rad on
    for angle in [0.3_f64, 1.0, 1.2, 1.4, 1.5] {
        let (sine, cosine) = (0.5 * angle).sin_cos();
        let start = AnyStart::second_order(&[cosine, 0.0, 0.6 * sine, 0.8 * sine], &[0.5, 0.0, 0.0]);
        let flow = AnyFlow::new(&link, 0.01, &start.projected()).unwrap();
        let mut node = OwnedNode::new(4);
        node.take(flow.run());
        let [w, x, y, z] = core::array::from_fn(|i| node.any().q[i]);
        assert!(
            w * w + x * x - y * y - z * z > 1.0 - 1e-12,
            "{angle}: {:?}",
            node.any().q
        );
        // by the least rotation, back to the attitude before the turn
        let turn = 2.0 * (w * cosine + 0.6 * y * sine + 0.8 * z * sine).abs().acos();
        assert!(turn < 1.1 * angle, "{angle}: {turn}");
    }
}

#[test]
fn derivatives_by_a_start_far_from_a_hinge_are_those_of_differences() {
    let link = Text::parse("link", HINGE).unwrap().system;
    let q = unit([1.0, 0.1, 0.35, 0.55]);
    let path = |k: usize, by: f64| {
        // turned by an angle about an axis of the body
        let (sine, cosine) = (by / 2.0_f64).sin_cos();
        let [w, x, y, z] = q;
        let about = [[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]][k - 1];
        let turned: [f64; 4] = core::array::from_fn(|i| cosine * q[i] + sine * about[i]);
        let start = AnyStart::second_order(&turned, &[0.5, 0.1, -0.2]).projected();
        AnyPath::new(&link, 0.01, &start, 0.2).unwrap()
    };
    for k in 1..4 {
        let [far, near, back, behind] = [2e-3, 1e-3, -1e-3, -2e-3].map(|by| path(k, by).end().v.to_vec());
        let whole = path(k, 0.0);
        let tangents = whole.tangents(&[Variable::Position(k)]).unwrap();
        let found = tangents.get(0).unwrap();
        for i in 1..4 {
            let difference = (8.0 * (near[i] - back[i]) - (far[i] - behind[i])) / 12e-3;
            assert!(
                (found.v[i] - difference).abs() < 1e-7,
                "{k}, {i}: {} {difference}",
                found.v[i]
            );
        }
    }
}
