//! The warning about coordinates that move otherwise than their velocity says: it comes with compositions where a
//! direction has hardly any inertia for the step.

use super::{attempt, run};

/// The quaternion of a rotation vector.
fn turn([x, y, z]: [f64; 3]) -> [f64; 4] {
    let angle = (x * x + y * y + z * z).sqrt();
    let part = if angle > 0.0 {
        (angle / 2.0).sin() / angle
    } else {
        0.5
    };
    [(angle / 2.0).cos(), part * x, part * y, part * z]
}

/// The product of two quaternions.
fn product([a, b, c, d]: [f64; 4], [w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

/// Angular velocity at the start.
const W: [f64; 3] = [0.6, -0.3, 3.0];

/// The error of the attitude of a free body with the moments of inertia 1, 1 and `i3` at t = 3, and the warnings. The body
/// precesses about its angular momentum and spins about its axis, both at constant rates.
fn error(i3: f64, step: f64, order: &str) -> (f64, String) {
    let text = format!(
        "coordinates(r: rotation); let w = r.angular_velocity(); lagrangian = (w[0].powi(2) + w[1].powi(2) + {i3} * w[2].powi(2)) / 2; \
         run {{ start = ([1, 0, 0, 0], [{}, {}, {}]); step = {step}; until = 3; }}",
        W[0], W[1], W[2]
    );
    let (warnings, last) = run(&text, &["--order", order, "--columns", "r_w,r_x,r_y,r_z"]);
    let t = 3.0;
    let precession = turn([W[0] * t, W[1] * t, i3 * W[2] * t]);
    let exact = product(precession, turn([0.0, 0.0, (1.0 - i3) * W[2] * t]));
    let found: Vec<f64> = last.split(',').map(|number| number.parse().unwrap()).collect();
    // both signs are the same attitude
    let along: f64 = found.iter().zip(exact).map(|(q, exact)| q * exact).sum();
    let apart = found
        .iter()
        .zip(exact)
        .map(|(q, exact)| (q - exact.copysign(exact * along)).powi(2));
    (apart.sum::<f64>().sqrt(), warnings)
}

#[test]
fn a_composition_that_loses_the_spin_of_a_slender_body_is_told() {
    let mut told = 0;
    for i3 in [1.5, 0.1, 1e-3, 1e-5, 1e-6, 1e-9] {
        for step in [0.05, 0.01, 0.002] {
            for order in ["2", "4", "6"] {
                let (error, warnings) = error(i3, step, order);
                let is_told = warnings.contains("the legs of a composition are joined by momenta");
                assert!(is_told || error < 0.05, "{i3} {step} {order}: {error}");
                assert!(!is_told || error > 1e-3, "{i3} {step} {order}: {error}");
                told += u32::from(is_told);
            }
        }
    }
    assert!(told > 10, "{told}");
}

#[test]
fn increments_that_follow_their_velocities_are_not() {
    for text in [
        // twelve steps a period, in coordinates with a mass that varies
        "coordinates(r, p); lagrangian = (dot(r).powi(2) + (r * dot(p)).powi(2)) / 2 + 9.81 * r * p.cos() - 12 * (r - 1).powi(2); \
         run { start = ([1, 1.5], [0, 0]); step = 0.1; until = 20; }",
        // from rest, by a force that grows with the cube of the time
        "coordinates(x); lagrangian = (1 + x.powi(2)) * dot(x).powi(2) / 2; external_forces = t.powi(3); \
         run { start = ([0], [0]); step = 0.01; until = 1; }",
        // friction that stops and releases
        "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = 1.4 * t.sin() - dot(x).signum(); \
         run { start = ([0], [0]); step = 0.01; until = 12; }",
    ] {
        for order in ["4", "6"] {
            let (_, [_, warnings]) = attempt(text, "run", &["--order", order]);
            assert!(
                !warnings.contains("joined by momenta"),
                "{text} {order}: {warnings}"
            );
        }
    }
}

/// A displacement below the rounding of the position, beside a motion that is faster by nine orders of magnitude.
#[test]
fn an_increment_below_the_rounding_of_its_position_is_not() {
    for (y0, w) in [(1.0, 1e9), (-30.0, 1e8), (1e-3, 1e10)] {
        let text = format!(
            "coordinates(x, y); lagrangian = dot(x).powi(2) / 2 - {:e} * x * x / 2 + dot(y).powi(2) / 2 - y * y / 2; \
             run {{ start = ([1, {y0}], [0, 0]); step = {:e}; until = {:e}; }}",
            w * w,
            0.1 / w,
            100.0 / w
        );
        for order in ["4", "6"] {
            let (warnings, _) = run(&text, &["--order", order]);
            assert!(
                !warnings.contains("joined by momenta"),
                "{text} {order}: {warnings}"
            );
        }
    }
}

/// Before a Gaussian hill arrives its force grows by large factors from nothing, and means nothing.
#[test]
fn a_force_that_grows_from_nothing_is_not_told() {
    let text = "coordinates(x, y); \
                lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 0.3 * (-((x - 0.503).powi(2) + (y - 0.004).powi(2)) / 0.004).exp(); \
                run { start = ([0, 0], [1, 0]); step = 0.01; until = 1; }";
    let (warnings, _) = run(text, &["--order", "4"]);
    assert_eq!(warnings, "");
}
