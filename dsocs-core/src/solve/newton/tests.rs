//! The iteration on scalar equations: easy, stiff, degenerate, impossible and noisy ones.

use super::*;

/// One unknown.
fn one(x: f64) -> Vector {
    Vector::of(&[x])
}

/// One equation for one unknown: value, slope and rounding bound.
struct Scalar<F: Fn(f64) -> (f64, f64, f64)>(F);

impl<F: Fn(f64) -> (f64, f64, f64)> Equations for Scalar<F> {
    fn linearize(&self, z: &[f64]) -> Linearized {
        let (row, slope, _) = (self.0)(z[0]);
        Linearized {
            rows: one(row),
            jacobian: Square::from_fn(1, |_, _| slope),
        }
    }

    fn rounding(&self, z: &[f64]) -> Vector {
        one((self.0)(z[0]).2)
    }
}

fn run(
    function: impl Fn(f64) -> (f64, f64, f64),
    start: f64,
    size: f64,
) -> Result<Root<Vector>, StepFailure> {
    solve(&Scalar(function), &one(start), &one(size), 60, &mut ()).map_err(|failed| failed.reason)
}

#[test]
fn a_good_start_costs_one_evaluation() {
    let root = run(
        |x| (x * x - 2.0, 2.0 * x, 1e-15),
        std::f64::consts::SQRT_2 + 1e-10,
        0.0,
    )
    .unwrap();
    assert_eq!((root.evaluations, root.stop), (1, Stop::Update));
    assert!((root.z[0] - std::f64::consts::SQRT_2).abs() < 5e-16);
}

#[test]
fn quadratic_convergence_ends_without_an_evaluation_to_confirm_it() {
    let root = run(|x| (x * x - 2.0, 2.0 * x, 1e-15), 1.5, 0.0).unwrap();
    assert!(root.evaluations <= 4, "{}", root.evaluations);
    assert!((root.z[0] - std::f64::consts::SQRT_2).abs() < 5e-16);
}

#[test]
fn a_wall_is_met_from_any_start() {
    let mut most = 0;
    for stiffness in [1.0, 10.0, 1e3, 1e6] {
        for ratio in [-2.0, -0.999_999, -0.5, 0.0, 1e-9, 0.3, 0.99, 1.0, 1.5] {
            let right = ratio * stiffness;
            for start in [0.0, 1e-8, 0.3, -1.0, 5.0, -20.0, 325.0, -1e3, 1e5, -1e6] {
                let function = |w: f64| {
                    let tanh = w.tanh();
                    let slope = 1.0 + stiffness * (1.0 - tanh) * (1.0 + tanh);
                    let bound = f64::EPSILON * (w.abs() + stiffness * tanh.abs() + f64::abs(right));
                    (w + stiffness * tanh - right, slope, bound)
                };
                let root = run(function, start, 0.0)
                    .unwrap_or_else(|failure| panic!("{failure}: {stiffness} {ratio} {start}"));
                let (row, slope, bound) = function(root.z[0]);
                let error = (row / slope).abs();
                assert!(
                    row.abs() <= 4.0 * bound || error <= 1e-14 * root.z[0].abs(),
                    "{stiffness} {ratio} {start}: {root:?} {row:e}"
                );
                most = most.max(root.evaluations);
            }
        }
    }
    println!("at most {most} evaluations");
    assert!(most < 200, "{most}");
}

#[test]
fn a_double_root_is_found_to_half_the_digits_and_said_to_be_rounding() {
    // expanded, so that its rounding is that of terms of order 1
    let root = run(
        |x| (x * x - 2.0 * x + 1.0, 2.0 * x - 2.0, 4.0 * f64::EPSILON),
        3.0,
        0.0,
    )
    .unwrap();
    assert!((root.z[0] - 1.0).abs() < 1e-7, "{root:?}");
    // the rows are exact near the root: linear convergence must go on to the end
    let root = run(
        |x| {
            (
                (x - 1.0).powi(2),
                2.0 * (x - 1.0),
                f64::EPSILON * (x - 1.0).powi(2),
            )
        },
        3.0,
        0.0,
    );
    assert!((root.unwrap().z[0] - 1.0).abs() < 1e-12);
}

#[test]
fn an_exact_root_is_a_root_although_the_jacobian_is_singular() {
    let root = run(|x| (x * x, 2.0 * x, 0.0), 0.0, 0.0).unwrap();
    assert_eq!((root.z, root.stop), (one(0.0), Stop::Exact));
}

#[test]
fn failures_say_why() {
    assert_eq!(
        run(|x| (x * x + 1.0, 2.0 * x, 1e-16), 0.5, 0.0).unwrap_err(),
        StepFailure::NotConverged
    );
    assert_eq!(
        run(|x| (x * x + 1.0, 2.0 * x, 1e-16), 0.0, 0.0).unwrap_err(),
        StepFailure::Singular
    );
    assert_eq!(
        run(|x| (x.sqrt(), 0.5 / x.sqrt(), 1e-16), -1.0, 0.0).unwrap_err(),
        StepFailure::NotFinite
    );
    let failure = explain(
        &Scalar(|x: f64| (x.exp(), x.exp(), 0.0)),
        &one(1.0),
        &one(0.0),
        20,
    );
    assert_eq!(failure.reason, StepFailure::NotConverged);
    assert!(failure.updates.len() > 3 && failure.residual[0] > 0.0 && failure.unknowns[0] < 0.0);
}

#[test]
fn a_step_out_of_the_domain_is_shortened() {
    // the full update from 3 goes to a negative number, whose logarithm does not exist
    let root = run(|x| (x.ln(), 1.0 / x, 1e-16 * x.ln().abs()), 3.0, 0.0).unwrap();
    assert!((root.z[0] - 1.0).abs() < 1e-15);
}

#[test]
fn noise_is_told_from_failure() {
    // noise of 1e-10, far above the unit round-off, that the bound includes
    let noisy = |x: f64| (x - 1.0 + 1e-10 * (x * 1e13).sin(), 1.0, 1e-10);
    let root = run(noisy, 0.3, 0.0).unwrap();
    assert!((root.z[0] - 1.0).abs() < 1e-9, "{root:?}");
    // the same noise in a user's function, which the bound does not include
    let noisy = |x: f64| (x - 1.0 + 1e-10 * (x * 1e13).sin(), 1.0, 1e-16);
    let root = run(noisy, 0.3, 0.0).unwrap();
    assert!((root.z[0] - 1.0).abs() < 1e-9, "{root:?}");
}

/// An update is the last only after a valid Newton update.
#[test]
fn nothing_settles_after_an_update_that_is_none() {
    let trial = |update: f64, safe: bool| Evaluation {
        at: Iterate {
            z: [1.0],
            rows: [update],
            update: [update],
        },
        safe,
        determinant: Determinant::UNKNOWN,
    };
    let now = trial(1e-12, true);
    assert!(now.settles(&trial(1e-6, true), &[0.0]));
    assert!(!now.settles(&trial(1e-6, false), &[0.0]));
    assert!(!trial(1e-12, false).settles(&trial(1e-6, true), &[0.0]));
}

/// The path to a root from a guess: the root, the fold where it ends, or neither.
fn path(function: impl Fn(f64) -> (f64, f64, f64), start: f64) -> Result<Root<Vector>, Option<Fold>> {
    follow(&Scalar(function), one(start), &one(1.0), 60, &mut 0)
}

#[test]
fn a_path_that_turns_back_ends_in_a_fold() {
    // a parabola that does not reach zero, from far and near, from either side, in small and large units
    for start in [0.1, 0.5, 3.0, -2.0, 100.0] {
        for least in [1e-6, 1.0, 1e6] {
            let fold = path(|x| (x * x + least, 2.0 * x, 1e-16 * least), start);
            let Err(Some(fold)) = fold else {
                panic!("{start} {least}: {fold:?}");
            };
            // points of the path are known to 1e-4 of the unknown's size
            assert!(
                (fold.rows[0] / least - 1.0).abs() < 1e-2,
                "{start} {least}: {fold:?}"
            );
            assert!(fold.left > 1e9, "{fold:?}");
        }
    }
    // a double root to rounding is no fold: there the rows are zero to rounding
    assert!(!matches!(
        path(|x| ((x - 1.0).powi(2) + 1e-16, 2.0 * (x - 1.0), 1e-15), 3.0),
        Err(Some(_))
    ));
}

#[test]
fn paths_that_end_otherwise_have_no_fold() {
    // paths to a root, to infinity where the rows fall for ever or to a limit, and to the edge of the domain
    assert!((path(|x| (x * x - 2.0, 2.0 * x, 1e-16), 5.0).unwrap().z[0] - 2.0_f64.sqrt()).abs() < 1e-15);
    let falling = path(|x| (x.exp(), x.exp(), 1e-16 * x.exp()), 1.0);
    assert!(matches!(falling, Err(None)), "{falling:?}");
    let tending = path(|x| (1.0 + 1.0 / x, -1.0 / (x * x), 1e-16), 1.0);
    assert!(matches!(tending, Err(None)), "{tending:?}");
    let edge = path(|x| (1.0 + x.sqrt() + x, 0.5 / x.sqrt() + 1.0, 1e-16), 4.0);
    assert!(matches!(edge, Err(None)), "{edge:?}");
}

/// Rows that tend to a nonzero limit have no fold, although rounding makes the last of them rise and fall.
#[test]
fn rounding_far_away_is_no_fold() {
    let tending = |x: f64| (1.0 + 1.0 / x + 1e-14 * (x * 1e3).sin(), -1.0 / (x * x), 1e-18);
    for start in [1.0, 3.0, 100.0] {
        let ended = path(tending, start);
        assert!(matches!(ended, Err(None)), "{start}: {ended:?}");
    }
}

/// A path ends at its fold: it does not jump to another branch.
#[test]
fn a_path_does_not_jump() {
    // a minimum of 1/3 at 1, and a root beyond the maximum
    let valley = |x: f64| (x.powi(3) / 3.0 - x + 1.0, x * x - 1.0, 1e-16);
    for start in [2.0, 3.0, 10.0, 300.0] {
        let Err(Some(fold)) = path(valley, start) else {
            panic!("{start}: {:?}", path(valley, start));
        };
        assert!((fold.z[0] - 1.0).abs() < 1e-2, "{start}: {fold:?}");
    }
    // waves on a slope, whose next extremum lies before the root
    for ([a, b, c], start) in [
        ([1.163, 2.1695, -4.798], 1.8246),
        ([0.826, 1.639, -4.484], 4.907),
        ([0.4846, 3.4074, 0.2784], -1.5815),
    ] {
        let waves = |x: f64| (x + a * (b * x).sin() - c, 1.0 + a * b * (b * x).cos(), 1e-16);
        let ended = path(waves, start);
        assert!(ended.is_err(), "{start}: {ended:?}");
    }
}

/// Rows that fall to a few of their rounding bounds may have a root there.
#[test]
fn a_fold_that_may_be_a_root_is_none() {
    for (bound, is_fold) in [(1e-8, false), (1e-10, true)] {
        let ended = path(|x| ((x - 1.0).powi(2) + 1e-6, 2.0 * (x - 1.0), bound), 3.0);
        assert_eq!(matches!(ended, Err(Some(_))), is_fold, "{bound:e}: {ended:?}");
    }
}

/// `z (z − 1)`, of which `z = 0` is no root of the declared rows.
struct Declared;

impl Equations for Declared {
    fn linearize(&self, z: &[f64]) -> Linearized {
        Linearized {
            rows: one(z[0] * (z[0] - 1.0)),
            jacobian: Square::from_fn(1, |_, _| 2.0 * z[0] - 1.0),
        }
    }

    fn rounding(&self, z: &[f64]) -> Vector {
        one(f64::EPSILON * (z[0] * z[0]).max(1e-3))
    }

    fn is_declared(&self, z: &[f64], _: &[f64]) -> bool {
        z[0].abs() > 0.1
    }
}

#[test]
fn another_root_is_one_of_the_declared_rows_and_farther_than_rounding() {
    let pair = Scalar(|z: f64| (z * z - 1.0, 2.0 * z, f64::EPSILON * (z * z + 1.0)));
    for guess in [-3.0, -0.5, 0.3, 4.0] {
        let other = other_root(&pair, &one(guess), &one(1.0), &one(1.0)).unwrap();
        assert!((other[0] + 1.0).abs() < 1e-15, "{guess}: {other:?}");
    }
    assert_eq!(other_root(&Declared, &one(0.4), &one(1.0), &one(1.0)), None);
    // two roots that agree to rounding
    let double = Scalar(|z: f64| ((z - 1.0).powi(2), 2.0 * (z - 1.0), 8.0 * f64::EPSILON));
    for guess in [3.0, 0.2] {
        assert_eq!(
            other_root(&double, &one(guess), &one(1.0), &one(1.0)),
            None,
            "{guess}"
        );
    }
    // beyond the fold the rows have the other orientation; without a fold nothing is looked for
    let near = nearby(&pair, &one(0.7), &one(1.0), &one(1.0)).unwrap();
    assert!((near[0] + 1.0).abs() < 1e-15, "{near:?}");
    let straight = Scalar(|z: f64| (z + 0.01 * z.powi(3) - 1.01, 1.0 + 0.03 * z * z, f64::EPSILON));
    assert_eq!(nearby(&straight, &one(0.9), &one(1.0), &one(1.0)), None);
}

#[test]
fn a_root_tells_whether_another_one_may_be_close() {
    /// A parabola that is watched.
    struct Watched<const SHORT: bool>(f64);
    impl<const SHORT: bool> Equations for Watched<SHORT> {
        fn are_watched(&self) -> bool {
            true
        }

        fn past_is_short(&self) -> bool {
            SHORT
        }

        fn linearize(&self, z: &[f64]) -> Linearized {
            // roots at 1 and at 1 + the distance
            let (first, other) = (z[0] - 1.0, z[0] - 1.0 - self.0);
            Linearized {
                rows: one(first * other),
                jacobian: Square::from_fn(1, |_, _| first + other),
            }
        }

        fn rounding(&self, _: &[f64]) -> Vector {
            one(f64::EPSILON)
        }
    }
    let solved = |distance: f64, start: f64| {
        let root = solve(&Watched::<false>(distance), &one(start), &one(1.0), 60, &mut ());
        root.unwrap_or_else(|failed| panic!("{}", failed.reason))
    };
    // the other root is nearer than the size of the unknown, and the rows are nonlinear on the way to this
    // one
    let near = solved(0.1, 0.999);
    assert!(
        near.evaluations == 3 && near.close && near.bend > BENT,
        "{near:?}"
    );
    // far away, with nearly linear rows on the way
    let far = solved(1e3, 0.999);
    assert!(!far.close, "{far:?}");
    let short = solve(&Watched::<true>(20.0), &one(0.7), &one(1.0), 60, &mut ());
    let short = short.unwrap_or_else(|failed| panic!("{}", failed.reason));
    assert!(!short.close && short.bend > BENT, "{short:?}");
}
