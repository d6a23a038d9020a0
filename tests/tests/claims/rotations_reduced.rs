//! Systems of which no equation contains the attitude or the position: the step is that of the reduced
//! system, and the momentum equation holds along the group.

use dsocs_core::geometry::{momentum_along, momentum_balance, reduced};
use dsocs_core::text::Text;
use dsocs_core::{AnyFlow, AnyStart, Kernel, OwnedNode};
use dsocs_tests::text::parsed;

use dsocs_tests::vectors::{matrix, unit};

/// A body in free space with a wheel, and a mass on a spring.
const BODY: &str = "coordinates(r: rotation, s, x, y);
    let w = r.angular_velocity();
    lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 + 0.1 * (dot(s) + w[0]).powi(2) + dot(x).powi(2) / 2 + dot(y).powi(2) / 2 - y.powi(2);";

/// Suslov's problem without gravity.
const SUSLOV: &str = "coordinates(r: rotation);
    let w = r.angular_velocity();
    lagrangian = w.inner([[2.0, 0.1, 0.3], [0.1, 1.5, 0.2], [0.3, 0.2, 1.0]] * w) / 2;
    nonholonomic = w[2];";

/// Coordinates that no equation contains are found without the statement `reduced`; with it, a coordinate
/// that an equation does contain is an error that names the equation.
#[test]
fn what_is_reduced_is_seen_and_insisted_on() {
    for (text, expected) in [
        (BODY.to_owned(), &[0, 4, 5][..]),
        (format!("{BODY} reduced(r, s, x);"), &[0, 4, 5]),
        (SUSLOV.to_owned(), &[0]),
        (format!("{SUSLOV} reduced(r);"), &[0]),
        (format!("{SUSLOV} phi_lagrangian = midpoint; reduced(r);"), &[0]),
        (format!("{SUSLOV} phi_lagrangian = trapezoid;"), &[0]),
        (format!("{SUSLOV} external_forces = r.inverse() * [0, 0, 1];"), &[]),
        (
            "coordinates(x, y); lagrangian = dot(x).powi(2) + dot(y).powi(2); holonomic = x - y.sin();".to_owned(),
            &[],
        ),
        // an angle that enters by its rate only, and a map that takes the other angle at the middle
        (
            "coordinates(theta, phi); lagrangian = dot(theta).powi(2) + (theta.sin() * dot(phi)).powi(2); phi_lagrangian = midpoint; reduced(phi);"
                .to_owned(),
            &[1],
        ),
        // a difference of nodes
        (
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; discrete_lagrangian = ((x[1] - x[0]) / h).powi(2) / 2; reduced(x);".to_owned(),
            &[0],
        ),
    ] {
        assert_eq!(reduced(&parsed(&text)), expected, "{text}");
    }
    let error = Text::parse("body", &format!("{BODY} reduced(r, y);"))
        .map(drop)
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("`y` is not reduced: its position is in the Lagrangian"),
        "{error}"
    );
}

/// Positions and velocities of the nodes of a run.
fn nodes(system: &dyn Kernel, start: &AnyStart, steps: u32) -> Vec<[Vec<f64>; 2]> {
    let h = 0.02;
    let mut flow = AnyFlow::new(system, h, start).unwrap();
    let mut node = OwnedNode::new(system.shape().dimension());
    (1..=steps)
        .map(|k| {
            flow.run_mut().to(h * f64::from(k)).unwrap();
            node.take(flow.run());
            [node.any().q, node.any().v].map(<[f64]>::to_vec)
        })
        .collect()
}

#[test]
fn a_reduced_system_goes_as_one_whose_equations_have_the_position() {
    // a weight of zero brings attitude and position into all equations
    let q = unit([1.0, 0.3, -0.4, 0.2]);
    let place = [&q[..], &[0.3, -0.1, 0.4]].concat();
    let spin = [0.6, -0.3, 2.0];
    for (text, start) in [
        (
            BODY,
            AnyStart::second_order(&place, &[0.6, -0.3, 2.0, 5.0, 0.2, -0.3]),
        ),
        (SUSLOV, AnyStart::second_order(&q, &[spin[0], spin[1], 0.0])),
    ] {
        let lagrangian = text.find("lagrangian = ").unwrap() + "lagrangian = ".len();
        let weight = "- weight * (r * [0.2, 0.1, 1])[2] + ";
        let whole = format!(
            "parameters {{ weight = 0.0 }} {}{weight}{}",
            &text[..lagrangian],
            &text[lagrangian..]
        );
        let (small, large) = (parsed(text), parsed(&whole));
        assert!(!reduced(&large).contains(&0));
        let both = [nodes(&small, &start, 500), nodes(&large, &start, 500)];
        for (one, other) in both[0].iter().zip(&both[1]) {
            for (x, y) in one.iter().flatten().zip(other.iter().flatten()) {
                assert!((x - y).abs() < 1e-12, "{x} {y}");
            }
        }
        // turning the start turns the whole motion, to rounding
        let turn = unit([0.2, 0.5, 0.7, -0.4]);
        let [a, b, c, d] = turn;
        let [w, x, y, z] = q;
        let turned = [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y + c * w + d * x - b * z,
            a * z + d * w + b * y - c * x,
        ];
        let start = match text {
            BODY => AnyStart::second_order(
                &[&turned[..], &[7.3, 11.0, 0.4]].concat(),
                &[0.6, -0.3, 2.0, 5.0, 0.2, -0.3],
            ),
            _ => AnyStart::second_order(&turned, &[spin[0], spin[1], 0.0]),
        };
        for (one, other) in both[0].iter().zip(nodes(&small, &start, 500)) {
            let bits = |v: &[f64]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            // no force depends on it: the velocities have the same bits
            assert_eq!(bits(&one[1]), bits(&other[1]));
        }
    }
}

/// The axes of space, seen from the body.
fn axis(k: usize) -> impl Fn(&[f64]) -> Vec<f64> {
    move |q: &[f64]| {
        let mut out = vec![0.0; q.len()];
        let seen = matrix(core::array::from_fn(|i| q[i]))[k];
        out[1..4].copy_from_slice(&seen);
        out
    }
}

#[test]
fn momenta_are_those_of_the_declared_map() {
    // a body in a fluid: its mass varies with the attitude, so that the maps differ in the momentum
    let q = [&unit([1.0, 0.3, -0.4, 0.2])[..], &[0.3, -0.1, 0.4]].concat();
    for map in ["paper", "midpoint", "trapezoid"] {
        let body = parsed(&format!(
            "coordinates(r: rotation, x: [3]);
             let w = r.angular_velocity();
             let u = r.inverse() * dot(x);
             lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 + 1.5 * u[0].powi(2) + 2.5 * u[1].powi(2) + 4 * u[2].powi(2);
             phi_lagrangian = {map};"
        ));
        let legs = legs(
            &body,
            &AnyStart::second_order(&q, &[0.6, -0.3, 2.0, 0.5, 0.3, -0.2]),
        );
        for k in 0..3 {
            let along = move |_: &[f64]| {
                (0..7)
                    .map(|i| f64::from(u8::from(i == 4 + k)))
                    .collect::<Vec<f64>>()
            };
            let (missed, work, drift) = law(&body, &legs, &along);
            assert!(
                missed < 1e-13 && work < 1e-14 && drift < 1e-12,
                "{map}, {k}: {missed:e} {work:e} {drift:e}"
            );
        }
    }
}

#[test]
fn momenta_change_by_what_works_along_the_group() {
    let q = unit([1.0, 0.3, -0.4, 0.2]);
    for (text, conserved, works) in [
        ("", [true; 3], [false; 3]),
        // gravity leaves the momentum about the vertical
        ("- (r * [0.2, 0.1, 1])[2]", [false, false, true], [false; 3]),
    ] {
        let top = parsed(&format!(
            "coordinates(r: rotation); let w = r.angular_velocity();
             lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 {text};"
        ));
        let legs = legs(&top, &AnyStart::second_order(&q, &[0.6, -0.3, 2.0]));
        for k in 0..3 {
            let (missed, work, drift) = law(&top, &legs, &axis(k));
            if conserved[k] {
                assert!(
                    missed < 1e-14 && drift < 1e-12,
                    "{text}, {k}: {missed:e} {drift:e}"
                );
                assert_eq!(work > 1e-13, works[k], "{work:e}");
            } else {
                assert!(missed > 1e-4 && drift > 1e-2, "{text}, {k}: {missed:e} {drift:e}");
            }
        }
    }
    // the constraint force of Suslov's problem does work along the axes of space; the momentum equation gives its
    // amount
    let suslov = parsed(SUSLOV);
    let all = legs(&suslov, &AnyStart::second_order(&q, &[0.6, -0.3, 0.0]));
    for k in 0..3 {
        let (missed, work, drift) = law(&suslov, &all, &axis(k));
        assert!(missed < 1e-14, "{k}: {missed:e}");
        assert!(work > 1e-4 && drift > 1e-2, "{work:e} {drift:e}");
    }
    // along fields that the constraint allows, axes of the body, it does no work, and the momentum changes
    // with the field: by ⟨μ, Ad ξ - ξ⟩
    let body = |k: usize| move |_: &[f64]| (0..4).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
    for (pair, k) in all.windows(2).flat_map(|pair| [(pair, 1), (pair, 2)]) {
        let both = [pair[0].any(), pair[1].any()];
        let e = second_difference(pair);
        let [apart, work, terms] = momentum_balance(&suslov, STEP, both, &e, &body(k));
        assert!(work.abs() < 1e-14 * terms);
        // the field at the last node, seen from the body at the middle one, where the next leg begins with what the force leaves
        let [one, other] = both.map(|leg| matrix(core::array::from_fn(|i| leg.q[i])));
        let carried = (0..3).map(|i| {
            let seen: f64 = (0..3).map(|j| one[j][i] * other[j][k - 1]).sum();
            let field = body(i + 1);
            let leaving = momentum_along(&suslov, STEP, both[0], &field)
                + momentum_balance(&suslov, STEP, both, &e, &field)[1];
            seen * leaving
        });
        let change = carried.sum::<f64>() - momentum_along(&suslov, STEP, both[0], &body(k));
        // the momenta themselves are of the size one
        assert!((apart - change).abs() < 4e-15, "{apart} {change}");
    }
}

const STEP: f64 = 0.02;

fn second_difference(pair: &[dsocs_core::OwnedLeg<f64>]) -> Vec<f64> {
    pair[1].d.iter().zip(&pair[0].d).map(|(x, y)| x - y).collect()
}

/// The legs of a run.
fn legs(system: &dyn Kernel, start: &AnyStart) -> Vec<dsocs_core::OwnedLeg<f64>> {
    let mut flow = AnyFlow::new(system, STEP, start).unwrap();
    (1..=1000)
        .map(|k| {
            flow.run_mut().to(STEP * f64::from(k)).unwrap();
            flow.leg().to_owned()
        })
        .collect()
}

/// The defect of the momentum equation, the largest work along a field, and the variation of the momentum,
/// relative to its terms.
fn law(
    system: &dyn Kernel,
    legs: &[dsocs_core::OwnedLeg<f64>],
    field: &dyn Fn(&[f64]) -> Vec<f64>,
) -> (f64, f64, f64) {
    let (mut missed, mut works) = (0.0_f64, 0.0_f64);
    for pair in legs.windows(2) {
        let both = [pair[0].any(), pair[1].any()];
        let [apart, work, terms] = momentum_balance(system, STEP, both, &second_difference(pair), field);
        (missed, works) = (missed.max(apart.abs() / terms), works.max(work.abs() / terms));
    }
    let momenta: Vec<f64> = legs
        .iter()
        .map(|leg| momentum_along(system, STEP, leg.any(), field))
        .collect();
    let (least, most) = momenta
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| {
            (least.min(*x), most.max(*x))
        });
    (missed, works, (most - least) / least.abs().max(most.abs()))
}
