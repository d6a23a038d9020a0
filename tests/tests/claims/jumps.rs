//! A velocity would have to jump at a corner of a constraint or a jump of the Lagrangian: the motion ends
//! there with an error that names the reason. Where only a force or an acceleration jumps it goes on.

use dsocs_core::taylor::TaylorEnsemble;
use dsocs_core::{
    Jump, RunError, Samples, SeriesError, SeriesFailure, Start, Stepper, System, TaylorFlow, Tolerance,
    Unresolved, dsocs,
};
use dsocs_tests::declared;
use dsocs_tests::text::{self, Flow};

/// A bead on a wire that is bent at the origin.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
    holonomic = y - slope * x.abs();
}]
struct Bent {
    slope: f64,
    gravity: f64,
}

/// A wheel on a road given by samples.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
    holonomic = y - road.at(x);
}]
struct Road {
    road: Samples,
    gravity: f64,
}

/// A lift whose height is planned; the plan has corners in time.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.powi(2) / 2;
    holonomic = y - plan.at(t);
}]
struct Lift {
    plan: Samples,
}

/// A blade whose direction jumps at the line x = 0.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    nonholonomic = dot(y) - slope * x.signum() * dot(x);
}]
struct Turned {
    slope: f64,
}

declared! {
    /// A blade whose direction has a corner, which requires no jump of the velocity.
    struct Corner {
        slope: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    nonholonomic = dot(y) - slope * x.abs() * dot(x);
}

/// A mass that jumps in space or in time, and a potential that jumps.
#[dsocs {
    coordinates(x, y);
    let mass = 1 + by_place * x.signum() + by_time * (t - 1).signum();
    let potential = step * x.signum() + field * x * (t - 1).signum();
    lagrangian = mass * dot(x).powi(2) / 2 + dot(y).powi(2) / 2 - potential;
}]
struct Pieces {
    by_place: f64,
    by_time: f64,
    step: f64,
    field: f64,
}

/// A jump of the mass alone: the equation on both sides is `m a = 0` and does not show it.
#[dsocs {
    coordinates(x, y);
    lagrangian = dot(x).powi(2) / 2 * (1 + 0.5 * x.signum()) + dot(y).powi(2) / 2;
}]
struct Heavier {}

/// A step of the potential alone, by a comparison.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - if x < 0 { 0 } else { height };
}]
struct Stair {
    height: f64,
}

/// A constraint on positions that jumps.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    holonomic = y - height * x.signum();
}]
struct Ledge {
    height: f64,
}

/// A belt whose speed jumps: the derivative of its row is `ddot(y)` on both sides.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    nonholonomic = dot(y) - speed * x.signum();
}]
struct Belt {
    speed: f64,
}

declared! {
    /// A spring that begins at the origin: only the derivative of its force jumps.
    struct Buffer {}
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - 3 * x.max(0).powi(2) - y.powi(4) / 4;
}

/// The jump that ends a motion: its time, the velocity before it, and its kind.
fn jump<S: System<2> + Sync>(system: &S, start: [[f64; 2]; 2], tolerance: f64) -> (f64, [f64; 2], Jump) {
    let [q, v] = start;
    let start = Start::second_order(q, v);
    let mut flow = TaylorFlow::new(system, start, Tolerance::relative(tolerance)).unwrap();
    match flow.to(5.0).unwrap_err() {
        RunError::Series(error) => {
            let details = error.details();
            let SeriesFailure::Jumps { by, .. } = details.cause else {
                panic!("{error}")
            };
            let advice = error.to_string();
            let what = if by == Jump::Position {
                "position"
            } else {
                "velocity"
            };
            assert!(advice.contains(&format!("{what} would have to jump")), "{advice}");
            in_lanes(system, start, tolerance, &error);
            (details.time, [details.v[0], details.v[1]], by)
        }
        other => panic!("{other}"),
    }
}

/// A motion in lanes ends with the same error at the same place, and its neighbours with theirs.
fn in_lanes<S: System<2> + Sync>(system: &S, start: Start<2>, tolerance: f64, error: &SeriesError) {
    let tolerance = Tolerance::relative(tolerance);
    let ends = TaylorEnsemble::new(system, tolerance)
        .unwrap()
        .starts([start; 9])
        .to(5.0);
    for end in ends {
        let RunError::Series(own) = end.unwrap_err() else {
            panic!("{error}")
        };
        let (own, single) = (own.details(), error.details());
        let apart = (own.time - single.time).abs();
        assert!(own.cause == single.cause && apart < 1e-12, "{own:?} {single:?}");
    }
}

/// Four jumps whose equations are the same on both sides end the motion with the kind of the jump, at t = 0.5
/// to 1e-12 and with the velocity before it, at three tolerances.
#[test]
fn what_jumps_is_told_where_the_equations_show_nothing_of_it() {
    for tolerance in [1e-3, 1e-9, 1e-12] {
        let moving = [[-0.5, 0.0], [1.0, 0.3]];
        let found = [
            jump(&Heavier {}, moving, tolerance),
            jump(&Stair { height: 0.1 }, moving, tolerance),
            jump(&Ledge { height: 0.7 }, [[-0.5, -0.7], [1.0, 0.0]], tolerance),
            jump(&Belt { speed: 0.3 }, [[-0.5, 0.0], [1.0, -0.3]], tolerance),
        ];
        let expected = [
            Jump::Lagrangian,
            Jump::Lagrangian,
            Jump::Position,
            Jump::Constraint,
        ];
        for ((t, v, by), expected) in found.into_iter().zip(expected) {
            assert!(
                (t - 0.5).abs() < 1e-12 && by == expected && (v[0] - 1.0).abs() < 1e-12,
                "{t} {v:?} {by:?}"
            );
        }
    }
}

#[test]
fn a_corner_of_a_constraint_is_an_impact() {
    let bent = Bent {
        slope: 0.5,
        gravity: 9.81,
    };
    // down the slope from x = 1: x = 1 − a t²/2 with a = g s/(1 + s²)
    let rate: f64 = 9.81 * 0.5 / 1.25;
    let exact = (2.0 / rate).sqrt();
    for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
        let (t, v, by) = jump(&bent, [[1.0, 0.5], [0.0, 0.0]], tolerance);
        assert!(
            (t - exact).abs() < tolerance && by == Jump::Constraint,
            "{t} {by:?}"
        );
        // the reported velocity is that before the jump
        assert!(
            (v[0] + rate * exact).abs() < 10.0 * tolerance && (v[1] - 0.5 * v[0]).abs() < 1e-9,
            "{v:?}"
        );
    }
    let turned = Turned { slope: 0.5 };
    let (t, _, by) = jump(&turned, [[0.5, 0.0], [-1.0, -0.5]], 1e-9);
    assert!((t - 0.5).abs() < 1e-12 && by == Jump::Constraint, "{t}");
}

#[test]
fn a_profile_by_samples_has_corners() {
    let road = Samples::linear([(0.0, 0.0), (1.0, 0.0), (2.0, 0.3), (4.0, 0.3)]).unwrap();
    let road = Road { road, gravity: 9.81 };
    let (t, v, by) = jump(&road, [[0.2, 0.0], [4.0, 0.0]], 1e-9);
    assert!((t - 0.2).abs() < 1e-12 && by == Jump::Constraint, "{t}");
    assert!((v[0] - 4.0).abs() < 1e-12 && v[1].abs() < 1e-12, "{v:?}");
    let plan = Samples::linear([(0.0, 0.0), (1.0, 0.5), (9.0, 0.5)]).unwrap();
    let (t, v, by) = jump(&Lift { plan }, [[1.0, 0.0], [0.0, 0.5]], 1e-9);
    assert!((t - 1.0).abs() < 1e-12 && by == Jump::Constraint, "{t}");
    assert!(
        (v[0] + 1.0_f64.sin()).abs() < 1e-8 && (v[1] - 0.5).abs() < 1e-12,
        "{v:?}"
    );
}

#[test]
fn a_lagrangian_that_jumps_is_an_impulse() {
    let plain = Pieces {
        by_place: 0.0,
        by_time: 0.0,
        step: 0.0,
        field: 0.0,
    };
    let moving = [[-0.5, 0.0], [1.0, 0.3]];
    let of_mass = Pieces {
        by_place: 0.3,
        ..plain
    };
    let of_time = Pieces {
        by_time: 0.3,
        ..plain
    };
    let of_potential = Pieces { step: 1e-3, ..plain };
    for (system, place) in [(of_mass, 0.5), (of_time, 1.0), (of_potential, 0.5)] {
        let (t, _, by) = jump(&system, moving, 1e-9);
        assert!((t - place).abs() < 1e-12 && by == Jump::Lagrangian, "{t} {by:?}");
    }
}

/// Where only an acceleration jumps the motion goes on: its position at t = 2 is the closed form to 1e-11.
#[test]
fn where_only_the_acceleration_jumps_the_motion_goes_on() {
    let field = Pieces {
        by_place: 0.0,
        by_time: 0.0,
        step: 0.0,
        field: 0.5,
    };
    let start = Start::second_order([-0.5, 0.0], [1.0, 0.3]);
    let end = TaylorFlow::new(&field, start, Tolerance::relative(1e-12))
        .unwrap()
        .to(2.0)
        .unwrap();
    // 0.5 to the right for a second, then 0.5 to the left for another one
    assert!((end.q[0] - (-0.5 + 1.25 + 1.5 - 0.25)).abs() < 1e-11, "{end:?}");
    let corner = Corner { slope: 0.5 };
    let start = Start::second_order([0.5, 0.0], [-1.0, -0.25]);
    let mut flow = text::TaylorFlow::new(&corner, start, Tolerance::relative(1e-12)).unwrap();
    let end = flow.to(1.5).unwrap();
    assert!(end.q[0] < -0.4 && (end.energy - 0.53125).abs() < 1e-11, "{end:?}");
}

/// A discrete flow steps across a jump of the velocity, and counts the step.
#[test]
fn steps_across_a_jump_are_counted() {
    fn unresolved<S: text::System<2>>(system: &S, [q, v]: [[f64; 2]; 2], h: f64) -> Option<Unresolved> {
        let mut flow = Flow::new(system, h, Start::second_order(q, v)).unwrap();
        flow.to(0.9).unwrap();
        flow.unresolved()
    }
    let bent = Bent {
        slope: 0.5,
        gravity: 9.81,
    };
    for h in [0.1, 0.03, 0.01, 0.001] {
        let moving = [[-0.512, 0.0], [1.0, -0.3]];
        let found = [
            unresolved(&bent, [[0.5, 0.25], [-1.0, -0.5]], h),
            unresolved(&Ledge { height: 0.7 }, [[-0.512, -0.7], [1.0, 0.0]], h),
            unresolved(&Belt { speed: 0.3 }, moving, h),
            unresolved(&Heavier {}, moving, h),
        ];
        for (i, found) in found.into_iter().enumerate() {
            let found = found.unwrap_or_else(|| panic!("{i}, {h}"));
            let place = if i == 0 { 0.31 } else { 0.512 };
            assert!((found.first - place).abs() <= 1.01 * h, "{i}, {h}: {found:?}");
        }
        assert_eq!(unresolved(&Buffer {}, moving, h), None, "{h}");
    }
}

/// A charge in a field whose potential follows samples: its momentum `dot(x) + field` is constant.
#[dsocs {
    coordinates(x);
    lagrangian = (dot(x) + field.at(t)).powi(2) / 2;
}]
struct Charge {
    field: Samples,
}

/// At a sample of a smooth curve the velocity does not jump, also where the momentum is zero, so that the Lagrangian is rounding.
#[test]
fn a_momentum_of_zero_does_not_jump() {
    let samples = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (3.0, 1.0), (4.0, 0.5)];
    let monotone = Samples::monotone(samples).unwrap();
    let cubic = Samples::cubic(samples).unwrap();
    for field in [monotone, cubic] {
        // Simpson's rule on the pieces, which are cubic polynomials
        let area = |piece: f64, to: f64| {
            let at = |part: f64| field.at(piece + part * (to - piece));
            (at(0.0) + 4.0 * at(0.5) + at(1.0)) * (to - piece) / 6.0
        };
        let whole = area(0.0, 1.0) + area(1.0, 2.0) + area(2.0, 3.0) + area(3.0, 3.5);
        let last = field.at(3.5);
        let charge = Charge { field };
        for momentum in [0.0, 0.3] {
            for tolerance in [1e-6, 1e-9, 1e-12] {
                let start = Start::second_order([1.0], [momentum]);
                let mut flow = TaylorFlow::new(&charge, start, Tolerance::relative(tolerance)).unwrap();
                let node = flow
                    .to(3.5)
                    .unwrap_or_else(|error| panic!("{momentum}, {tolerance}: {error}"));
                let (x, v) = (1.0 + 3.5 * momentum - whole, momentum - last);
                assert!(
                    (node.q[0] - x).abs() < 100.0 * tolerance && (node.v[0] - v).abs() < 100.0 * tolerance,
                    "{momentum}, {tolerance}: {node:?}, {x}, {v}"
                );
            }
        }
    }
}
