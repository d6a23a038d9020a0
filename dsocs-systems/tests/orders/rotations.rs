//! The orders of systems with rotations, against values by hand. Increments of legs and forces at nodes are
//! vectors in the frame of the body.

use dsocs_core::dsocs;
use dsocs_core::geometry::{Expansion, PartErrors};
use dsocs_systems::check::orders::{Order, Orders, Part};
use dsocs_systems::check::{Begin, Settings};
use dsocs_systems::systems;

use super::{assert_flow, assert_order, of_text, settings};

/// A ball that rotates at a constant rate.
#[dsocs {
    coordinates(r: rotation);
    lagrangian = r.angular_velocity().norm_squared() / 2;
}]
struct Ball;

/// The quaternion of a rotation about an axis with the rate `w`, by its Taylor coefficients.
fn even_turn([x, y, z]: [f64; 3], w: f64) -> Vec<Vec<f64>> {
    let mut power = 1.0;
    let mut coefficients = Vec::new();
    for k in 0_u32..24 {
        let (cos, sin) = match k % 4 {
            0 => (power, 0.0),
            1 => (0.0, power),
            2 => (-power, 0.0),
            _ => (0.0, -power),
        };
        coefficients.push(vec![cos, sin * x, sin * y, sin * z]);
        power *= w / 2.0 / f64::from(k + 1);
    }
    coefficients
}

#[test]
fn errors_of_an_even_turn_are_those_of_the_map_by_hand() {
    let axis = [0.6, 0.0, 0.8];
    let w = 1.5;
    let motion = Expansion {
        t: 0.0,
        coefficients: even_turn(axis, w),
        rotations: vec![0],
        reach: 1.0,
    };
    for h in [0.5_f64, 0.2, 0.1] {
        let part_errors = PartErrors::of(&Ball, &motion, h).unwrap();
        // the increment of a rotation by θ has the length x, tan(θ/4) = (x/4)/(1 − x²/48)
        let tangent = (w * h / 4.0).tan();
        let x = 8.0 * tangent / (1.0 + (1.0 + 4.0 / 3.0 * tangent.powi(2)).sqrt());
        let [error] = part_errors.lagrangian[..] else {
            panic!("{part_errors:?}")
        };
        let by_hand = ((x / h).powi(2) - w.powi(2)) / 2.0;
        assert!(
            (error.difference - by_hand).abs() < 4e-15,
            "{h}: {error:?} {by_hand}"
        );
        // the momenta of the legs at the node: along the axis, with the slope dx/dθ
        let slope = {
            let a = 1.0 - x * x / 48.0;
            let b = x * x / 16.0;
            // dx/dθ from cos θ/2 = (a² − b)/(a² + b)
            (a * a + b) / (1.0 + x * x / 48.0)
        };
        assert_eq!(part_errors.momenta.len(), 6);
        for (i, error) in part_errors.momenta.iter().enumerate() {
            let by_hand = axis[i % 3] * (x / h * slope - w);
            assert!(
                (error.difference - by_hand).abs() < 1e-13,
                "{h}: {error:?} {by_hand}"
            );
        }
        // the momenta of both legs are equal
        assert_eq!(part_errors.forces.len(), 3);
        for error in &part_errors.forces {
            assert!(error.difference.abs() <= error.rounding, "{error:?}");
        }
    }
}

#[test]
fn the_map_of_rotations_touches_at_order_4() {
    let ball = "coordinates(r: rotation); lagrangian = r.angular_velocity().norm_squared() / 2;";
    let found = of_text(ball, "", (&[1.0, 0.0, 0.0, 0.0], &[0.0, 0.3, -0.7, 1.1]), 0.2);
    assert_order(&found, Part::Lagrangian, 4.0);
    assert_order(&found, Part::Momenta, 4.0);
    assert_eq!(found.of(Part::Forces), Some(&Order::Exact));
    assert!(found.holds());
}

/// A heavy top with three different moments of inertia.
const TOP: &str = "coordinates(r: rotation);
let w = r.angular_velocity();
lagrangian = (2 * w[0].powi(2) + 1.5 * w[1].powi(2) + w[2].powi(2)) / 2 - (r * [0.2, 0.1, 1])[2];";

/// An initial attitude away from the axes.
const TURNED: [f64; 4] = [0.5, 0.5, -0.5, 0.5];

/// A top with the paper's map, the midpoint and the trapezoid: the paper's `L_d` alone is of order 1, and all
/// three flows are of order 2.
#[test]
fn with_a_constant_inertia_what_the_papers_map_lacks_telescopes() {
    for (map, alone) in [("paper", 1.0), ("midpoint", 2.0), ("trapezoid", 2.0)] {
        let map = format!("phi_lagrangian = {map};");
        let found = of_text(TOP, &map, (&TURNED, &[0.0, 0.6, -0.3, 2.0]), 0.05);
        assert_order(&found, Part::Lagrangian, alone);
        for part in [Part::Forces, Part::Equations] {
            assert_order(&found, part, 2.0);
        }
        assert_flow(&found, 2.0);
        assert!(found.lowering.is_empty());
    }
}

/// A body in a fluid, whose inertia depends on its attitude.
const KIRCHHOFF: &str = "coordinates(r: rotation, x: [3]);
let w = r.angular_velocity();
let u = r.inverse() * dot(x);
lagrangian = (2 * w[0].powi(2) + 1.5 * w[1].powi(2) + w[2].powi(2)) / 2
    + (1.2 * u[0].powi(2) + 2 * u[1].powi(2) + 3 * u[2].powi(2)) / 2 + x[2] / 5;";

/// A body whose inertia depends on its attitude: the paper's map is of order 1, midpoint and trapezoid are of
/// order 2.
#[test]
fn where_the_attitude_makes_the_mass_vary_the_papers_map_is_of_order_1() {
    let mut q = TURNED.to_vec();
    q.extend([0.0; 3]);
    let v = [0.0, 0.6, -0.3, 1.0, 0.5, 0.2, -0.4];
    for (map, order) in [("paper", 1.0), ("midpoint", 2.0), ("trapezoid", 2.0)] {
        let map = format!("phi_lagrangian = {map};");
        let found = of_text(KIRCHHOFF, &map, (&q, &v), 0.05);
        assert_order(&found, Part::Forces, order);
        assert_flow(&found, order);
        let lowering: &[Part] = if order < 2.0 { &[Part::Forces] } else { &[] };
        assert_eq!(found.lowering, lowering);
    }
}

/// The orders of one of the library's texts.
fn of_system(name: &str) -> Orders {
    let shipped = systems::texts::TEXTS.iter().find(|text| text.name == name);
    let entry = shipped.unwrap().entry(&[]).unwrap();
    let [q0, v0] = entry.default_start().unwrap();
    let settings = Settings {
        q0,
        v0,
        begin: Begin {
            paper: false,
            projected: true,
        },
        ..settings(entry.default_step())
    };
    entry.orders(&settings).unwrap()
}

#[test]
fn constraints_of_bodies_that_turn_touch_at_order_2() {
    for (name, rows) in [
        ("suslov", Part::Velocities),
        ("turntable", Part::Velocities),
        ("coin", Part::Velocities),
        ("satellite", Part::Accelerations),
    ] {
        let found = of_system(name);
        assert_order(&found, rows, 2.0);
        assert_flow(&found, 2.0);
        assert!(found.lowering.is_empty(), "{name}: {found:?}");
    }
}
