//! Corners and jumps that no sign, comparison or absolute value declares: of roots of expressions that touch
//! zero, and of angles at the ends of their ranges. A Taylor flow ends a step there and begins a new series
//! beyond. The references are motions piece by piece. Steps of order 2 and their compositions report the jumps.

use dsocs_core::text::Text;
use dsocs_core::{AnyComposedFlow, Composition, Flow, Run, Start, Stepper, Tolerance, Unresolved};
use dsocs_tests::text::TaylorFlow;
use proptest::prelude::*;

use super::draws;
use dsocs_tests::dop853::integrate_from;

/// A motion with corners where an angle `w = a x + b` is a multiple of a period, or the middle between two.
struct Corners {
    /// The declaration, in terms of `w`.
    declaration: &'static str,
    /// The period, and the part of it between zero and the first corner.
    period: f64,
    shift: f64,
    /// The force by `w`, `a` and the number of the piece.
    force: fn(f64, f64, f64) -> f64,
    /// Whether the force jumps; else it has a corner.
    jumps: bool,
}

/// 1, -1, 1, …
fn sign(piece: f64) -> f64 {
    if piece.rem_euclid(2.0) < 0.5 { 1.0 } else { -1.0 }
}

/// The force of the potential `|sin w|`.
fn of_sine(w: f64, a: f64, piece: f64) -> f64 {
    -sign(piece) * a * w.cos()
}

/// The force of a potential of constant slope.
fn of_slope(_: f64, a: f64, piece: f64) -> f64 {
    -sign(piece) * a
}

use core::f64::consts::PI;

const CORNERS: [Corners; 11] = [
    Corners {
        declaration: "lagrangian = kinetic - (w.sin().powi(2)).sqrt();",
        period: PI,
        shift: 0.0,
        force: of_sine,
        jumps: true,
    },
    Corners {
        declaration: "lagrangian = kinetic - (1 - w.cos().powi(2)).sqrt();",
        period: PI,
        shift: 0.0,
        force: of_sine,
        jumps: true,
    },
    Corners {
        declaration: "lagrangian = kinetic - ((1 - (2 * w).cos()) / 2).powf(0.5);",
        period: PI,
        shift: 0.0,
        force: of_sine,
        jumps: true,
    },
    Corners {
        declaration: "lagrangian = kinetic - (w.sin().powi(4)).powf(0.25);",
        period: PI,
        shift: 0.0,
        force: of_sine,
        jumps: true,
    },
    Corners {
        declaration: "lagrangian = kinetic - w.sin().asin();",
        period: PI,
        shift: 0.5,
        force: of_slope,
        jumps: true,
    },
    Corners {
        declaration: "lagrangian = kinetic - w.cos().acos();",
        period: PI,
        shift: 0.0,
        force: of_slope,
        jumps: true,
    },
    Corners {
        declaration: "lagrangian = kinetic; external_forces = (-w.sin().asin());",
        period: PI,
        shift: 0.5,
        force: |w, _, piece| -sign(piece) * (w - PI * piece),
        jumps: false,
    },
    Corners {
        declaration: "lagrangian = kinetic; external_forces = (-w.tan().atan());",
        period: PI,
        shift: 0.5,
        force: |w, _, piece| -(w - PI * piece),
        jumps: true,
    },
    Corners {
        declaration: "lagrangian = kinetic; external_forces = (-(w.sin() / w.cos()).atan());",
        period: PI,
        shift: 0.5,
        force: |w, _, piece| -(w - PI * piece),
        jumps: true,
    },
    Corners {
        declaration: "lagrangian = kinetic; external_forces = (-w.sin().atan2(w.cos()));",
        period: 2.0 * PI,
        shift: 0.5,
        force: |w, _, piece| -(w - 2.0 * PI * piece),
        jumps: true,
    },
    Corners {
        declaration: "lagrangian = kinetic - w.sin().atan2(w.cos()).powi(2) / 2;",
        period: 2.0 * PI,
        shift: 0.5,
        force: |w, a, piece| -a * (w - 2.0 * PI * piece),
        jumps: true,
    },
];

/// The end time of the motions.
const UNTIL: f64 = 1.5;

/// The end of the motion from `(0, v)` with a stiffness, by the pieces, and the times of the corners.
fn by_pieces(corners: &Corners, [a, b, v, stiffness]: [f64; 4]) -> ([f64; 2], Vec<f64>) {
    let place = |x: f64| (a * x + b) / corners.period + corners.shift;
    let (mut t, mut state, mut met) = (0.0, [0.0, v], Vec::new());
    let spans = 600;
    for span in 0..spans {
        let end = UNTIL * f64::from(span + 1) / f64::from(spans);
        loop {
            let piece = if state[1] > 0.0 {
                (place(state[0]) + 1e-12).floor()
            } else {
                (place(state[0]) - 1e-12).floor()
            };
            let rate = |_: f64, [x, v]: [f64; 2]| {
                let force = (corners.force)(a * x + b, a, piece);
                [v, force - stiffness * x]
            };
            let at = |time: f64| integrate_from(rate, (t, state), time, 1e-13);
            let is_beyond = |state: [f64; 2]| {
                let place = place(state[0]);
                place < piece - 1e-13 || place > piece + 1.0 + 1e-13
            };
            let next = at(end);
            if !is_beyond(next) {
                (t, state) = (end, next);
                break;
            }
            let (mut before, mut after) = (t, end);
            while after - before > 1e-15 {
                let middle = 0.5 * (before + after);
                if middle <= before || middle >= after {
                    break;
                }
                if is_beyond(at(middle)) {
                    after = middle;
                } else {
                    before = middle;
                }
            }
            (t, state) = (after, at(after));
            met.push(t);
        }
    }
    (state, met)
}

fn declared(corners: &Corners, [a, b, _, stiffness]: [f64; 4]) -> Text {
    let text = format!(
        "coordinates(x);
         let w = {a:?} * x + {b:?};
         let kinetic = dot(x).powi(2) / 2 - {stiffness:?} * x.powi(2) / 2;
         {}",
        corners.declaration
    );
    Text::parse("corners", &text).unwrap()
}

/// Scenes fast enough to cross every corner, without one at the start.
fn scenes() -> impl Strategy<Value = (usize, [f64; 4])> {
    (
        0..CORNERS.len(),
        [1.0..4.0, 0.2..1.2, 3.0..5.0, 0.0..3.0],
        any::<bool>(),
    )
        .prop_map(|(which, [a, b, v, k], back): (usize, [f64; 4], bool)| {
            (which, [a, b, if back { -v } else { v }, k])
        })
}

#[test]
fn a_series_goes_on_beyond_a_hidden_corner() {
    draws::test(120, 40, scenes(), &|(which, scene)| {
        let corners = &CORNERS[which];
        let (reference, met) = by_pieces(corners, scene);
        let text = declared(corners, scene);
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let start = Start::second_order([0.0], [scene[2]]);
            let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
            let reached = flow.to(UNTIL);
            prop_assert!(
                reached.is_ok(),
                "{} {scene:?} {tolerance}: {reached:?}",
                corners.declaration
            );
            let node = flow.node();
            let error = (node.q[0] - reference[0])
                .abs()
                .max((node.v[0] - reference[1]).abs());
            // near a corner the root itself loses digits
            prop_assert!(
                error < 100.0 * tolerance.max(1e-11),
                "{} {scene:?} {tolerance}: {:?} {:?} {reference:?}, corners at {met:?}",
                corners.declaration,
                node.q,
                node.v
            );
        }
        Ok(())
    });
}

/// The number of unresolved steps of a run.
fn unresolved_steps(run: &mut dyn Run, steps: u64) -> u64 {
    for _ in 0..steps {
        run.advance().unwrap();
    }
    run.unresolved().map_or(0, |Unresolved { steps, .. }| steps)
}

#[test]
fn steps_tell_of_hidden_jumps_and_not_of_corners() {
    draws::test(60, 41, scenes(), &|(which, scene)| {
        let corners = &CORNERS[which];
        let text = declared(corners, scene);
        let (h, steps) = (UNTIL / 256.0, 256);
        let start = Start::second_order([0.0], [scene[2]]);
        let (_, met) = by_pieces(corners, scene);
        let mut order_2 = Flow::of(&text.system, h, start).unwrap();
        let order_2 = unresolved_steps(order_2.run_mut(), steps);
        let mut order_4 =
            AnyComposedFlow::new(&text.system, h, Composition::SUZUKI_4, &start.into()).unwrap();
        let order_4 = unresolved_steps(order_4.run_mut(), steps);
        // the last jump may come just before or after the end, and one at a node belongs to two steps
        let jumps = met.len() as u64;
        let expected = if corners.jumps {
            jumps.saturating_sub(1)..=2 * jumps + 1
        } else {
            0..=0
        };
        for counted in [order_2, order_4] {
            prop_assert!(
                expected.contains(&counted),
                "{} {scene:?}: {counted} of {met:?}",
                corners.declaration
            );
        }
        Ok(())
    });
}

#[test]
fn an_angle_goes_over_its_cut_on_a_circle() {
    let text = "coordinates(x, y);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y.atan2(x).powi(2) / 2;
        holonomic = x.powi(2) + y.powi(2) - 1;";
    let text = Text::parse("circle", text).unwrap();
    let (angle, velocity) = (2.0_f64, 4.0);
    // the motion by the angle itself, with the cut at half a turn
    let cut = CORNERS.iter().find(|corners| corners.period > PI).unwrap();
    let ([turned, end], met) = by_pieces(cut, [1.0, angle, velocity, 0.0]);
    assert_eq!(met.len(), 1);
    let start = Start::second_order(
        [angle.cos(), angle.sin()],
        [-velocity * angle.sin(), velocity * angle.cos()],
    );
    let (sine, cosine) = (angle + turned).sin_cos();
    let reference = [cosine, sine, -end * sine, end * cosine];
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
        flow.to(UNTIL).unwrap();
        let node = flow.node();
        for (found, reference) in node.q.iter().chain(&node.v).zip(reference) {
            assert!(
                (found - reference).abs() < 100.0 * tolerance,
                "{tolerance}: {node:?} {reference:?}"
            );
        }
    }
}

#[test]
fn a_corner_is_passed_back_in_time() {
    for corners in &CORNERS {
        let scene = [2.0, 0.7, 4.0, 1.0];
        let ([x, v], _) = by_pieces(corners, scene);
        let text = declared(corners, scene);
        let start = Start::second_order([x], [v]).at(UNTIL);
        let flow = TaylorFlow::read(&text.system, start, Tolerance::relative(1e-9)).unwrap();
        let mut flow = flow.every(-0.1).unwrap();
        flow.to(0.0).unwrap();
        let node = flow.node();
        let error = node.q[0].abs().max((node.v[0] - scene[2]).abs());
        assert!(error < 1e-7, "{}: {node:?}", corners.declaration);
    }
}

#[test]
fn nodes_on_a_grid_lie_on_the_motion_close_to_a_corner() {
    // a grid so dense that nodes lie in the first step beyond a corner, and at its end
    for corners in &CORNERS {
        let scene = [2.0, 0.7, 4.0, 1.0];
        let text = declared(corners, scene);
        let start = Start::second_order([0.0], [scene[2]]);
        let tolerance = Tolerance::relative(1e-10);
        let mut whole = TaylorFlow::read(&text.system, start, tolerance)
            .unwrap()
            .every(1e-3)
            .unwrap();
        let mut ends = TaylorFlow::read(&text.system, start, tolerance).unwrap();
        for node in 1..=1500 {
            whole.advance().unwrap();
            if node % 50 == 0 {
                ends.to(whole.node().t).unwrap();
                let [x, v] = [
                    whole.node().q[0] - ends.node().q[0],
                    whole.node().v[0] - ends.node().v[0],
                ];
                assert!(
                    x.abs().max(v.abs()) < 1e-7,
                    "{} at {}: {x} {v}",
                    corners.declaration,
                    whole.node().t
                );
            }
        }
    }
}

/// The place and the velocity at a time of a motion from rest at `r > 0` on a line, whose acceleration is `-k` times the sign of the place;
/// and the number of times that it has passed zero.
fn to_and_fro(k: f64, r: f64, t: f64) -> ([f64; 2], u64) {
    let quarter = (2.0 * r / k).sqrt();
    let (half, since) = ((t / quarter).div_euclid(2.0), t.rem_euclid(2.0 * quarter));
    // from one turning point to the next, by the time from the middle
    let (from_middle, side) = (since - quarter, sign(half));
    let speed = k * quarter;
    let place = -side * from_middle.signum() * (speed * from_middle.abs() - k * from_middle.powi(2) / 2.0);
    let velocity = -side * (speed - k * from_middle.abs());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few")]
    let passed = half as u64 + u64::from(from_middle > 0.0);
    ([place, velocity], passed)
}

/// Motions from rest through the point where a norm of several components, or the angle of a rotation, vanishes: a declaration, the
/// number of numbers of a position, and the place along the ray at the distance `r`.
const NORMS: [(&str, usize); 5] = [
    (
        "coordinates(x: [2]); lagrangian = dot(x).norm_squared() / 2 - k * x.norm();",
        2,
    ),
    (
        "coordinates(x, y); let r = (x.powi(2) + y.powi(2)).sqrt(); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - k * r;",
        2,
    ),
    (
        "coordinates(x: [3]); lagrangian = dot(x).norm_squared() / 2; external_forces = -k * x / x.norm();",
        3,
    ),
    (
        "coordinates(x: [3]); lagrangian = dot(x).norm_squared() / 2 - k * x.norm_squared().powf(0.5);",
        3,
    ),
    (
        "coordinates(r: rotation); let w = r.angular_velocity(); let m = r.matrix(); \
         lagrangian = w.norm_squared() / 2 - k * ((m[0][0] + m[1][1] + m[2][2] - 1) / 2).acos();",
        4,
    ),
];

/// The position at the place `r` on a ray, and the same of a velocity.
fn on_ray<const N: usize>(direction: [f64; 3], [r, v]: [f64; 2]) -> [[f64; N]; 2] {
    let mut at = [[0.0; N]; 2];
    if N == 4 {
        let (sine, cosine) = (r / 2.0).sin_cos();
        (at[0][0], at[1][0]) = (cosine, 0.0);
        for i in 0..3 {
            (at[0][i + 1], at[1][i + 1]) = (direction[i] * sine, direction[i] * v);
        }
    } else {
        let length = direction[..N].iter().map(|x| x * x).sum::<f64>().sqrt();
        for i in 0..N {
            (at[0][i], at[1][i]) = (r * direction[i] / length, v * direction[i] / length);
        }
    }
    at
}

/// Checks the motion from rest on a ray with Taylor series, and what steps tell of it.
fn through_zero<const N: usize>(declaration: &str, direction: [f64; 3], [k, r]: [f64; 2]) {
    let text = Text::parse("norm", &format!("parameters {{ k = {k:?} }} {declaration}")).unwrap();
    let [q0, v0] = on_ray::<N>(direction, [r, 0.0]);
    let start = Start::second_order(q0, v0);
    let (end, passed) = to_and_fro(k, r, UNTIL);
    let exact = on_ray::<N>(direction, end);
    let apart = |q: &[f64; N], v: &[f64; N]| {
        let pairs = q.iter().zip(exact[0]).chain(v.iter().zip(exact[1]));
        pairs.fold(0.0_f64, |most, (found, exact)| most.max((found - exact).abs()))
    };
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
        flow.to(UNTIL).unwrap();
        let error = apart(&flow.node().q, &flow.node().v);
        assert!(
            error < 100.0 * tolerance.max(1e-11),
            "{declaration} {k} {r} {tolerance}: {error}"
        );
    }
    let (h, steps) = (UNTIL / 256.0, 256);
    let mut order_2 = Flow::of(&text.system, h, start).unwrap();
    let order_2 = unresolved_steps(order_2.run_mut(), steps);
    let mut order_4 = AnyComposedFlow::new(&text.system, h, Composition::SUZUKI_4, &start.into()).unwrap();
    let order_4 = unresolved_steps(order_4.run_mut(), steps);
    for counted in [order_2, order_4] {
        let expected = passed.saturating_sub(1)..=2 * passed + 1;
        assert!(
            expected.contains(&counted) && (passed == 0 || counted > 0),
            "{declaration} {direction:?} {k} {r}: {counted} of {passed}"
        );
    }
}

#[test]
fn a_motion_through_the_zero_of_a_norm_has_a_corner() {
    let scenes = ([-1.0..1.0, -1.0..1.0, 0.3..1.0], [1.0..9.0, 0.3..1.5]);
    draws::test(40, 42, (0..NORMS.len(), scenes), &|(
        which,
        (direction, scene),
    )| {
        let direction: [f64; 3] = direction;
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let direction = direction.map(|x| x / length);
        let (declaration, numbers) = NORMS[which];
        match numbers {
            2 => through_zero::<2>(declaration, direction, scene),
            3 => through_zero::<3>(declaration, direction, scene),
            _ => through_zero::<4>(declaration, direction, scene),
        }
        Ok(())
    });
}

/// Every pass is counted, wherever the nodes lie: none of 200 lengths of the step passes over one. One near a node may count for both steps.
#[test]
fn every_pass_through_the_zero_of_a_norm_is_counted() {
    let text = Text::parse(
        "norm",
        "coordinates(x: [2]); lagrangian = dot(x).norm_squared() / 2 - x.norm();",
    )
    .unwrap();
    for direction in [[1.0, 0.5], [1.0, 0.0], [-0.3, 0.7]] {
        let start = Start::second_order(direction, [0.0; 2]);
        let distance = direction[0].hypot(direction[1]);
        for k in 0..200 {
            let h = 0.003 * 1.007_f64.powi(k);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "some thousands"
            )]
            let steps = (20.0 / h) as u64;
            let (_, passed) = to_and_fro(1.0, distance, (20.0 / h).floor() * h);
            let mut flow = Flow::of(&text.system, h, start).unwrap();
            let counted = unresolved_steps(flow.run_mut(), steps);
            assert!(
                counted >= passed && counted <= 2 * passed + 1,
                "{direction:?} {h}: {counted} of {passed}"
            );
        }
    }
}

#[test]
fn a_motion_around_the_zero_of_a_norm_is_smooth() {
    for text in [
        "coordinates(x: [2]); lagrangian = dot(x).norm_squared() / 2 - x.norm();",
        "coordinates(x: [2]); lagrangian = dot(x).norm_squared() / 2 - 5 * (x.norm() - 0.7).powi(2);",
        "coordinates(x: [2]); lagrangian = dot(x).norm_squared() / 2 + 1 / x.norm();",
        "coordinates(x: [2]); lagrangian = dot(x).norm_squared() / 2 - x.norm().powi(3);",
    ] {
        let text = Text::parse("norm", text).unwrap();
        let start = Start::second_order([1.0, 0.1], [0.3, 0.5]);
        let mut order_2 = Flow::of(&text.system, 0.005, start).unwrap();
        assert_eq!(unresolved_steps(order_2.run_mut(), 4000), 0);
        let mut order_4 =
            AnyComposedFlow::new(&text.system, 0.005, Composition::SUZUKI_4, &start.into()).unwrap();
        assert_eq!(unresolved_steps(order_4.run_mut(), 4000), 0);
    }
}
