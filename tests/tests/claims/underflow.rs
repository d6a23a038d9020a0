//! A common factor of Lagrangian and forces changes no motion. Where it is so small that products in the
//! equations underflow, a run is refused; else it ends where the run without the factor does.

use dsocs_core::text::Text;
use dsocs_core::{Composition, Flow as AnyFlow, RunError, SetupError, Start, Stepper as _, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::text::{ComposedFlow, Flow, System, TaylorFlow};

declared! {
    /// Two masses on springs.
    struct Springs {
        first: f64,
        second: f64,
    }
    coordinates(x, y);
    lagrangian = first * second * (dot(x).powi(2) / 2 + dot(y).powi(2) - x.powi(2) / 2 - (x - y).powi(2) - y.powi(4) / 4);
}

declared! {
    /// A mass on a circle.
    struct Circle {
        first: f64,
        second: f64,
    }
    coordinates(x, y);
    lagrangian = first * second * (dot(x).powi(2) / 2 + dot(y).powi(2) / 2 - y);
    holonomic = x.powi(2) + y.powi(2) - 1;
}

/// The last position of a run, or its error.
type Ended = Result<Vec<f64>, RunError>;

/// The error of a refused start; `None` for other errors.
fn refusal(error: &RunError) -> Option<&SetupError> {
    match error {
        RunError::Setup(error) => Some(error),
        _ => None,
    }
}

/// The last positions of runs by three methods.
fn ends<S: System<2>>(system: &S, [q0, v0]: [[f64; 2]; 2]) -> [Ended; 3] {
    let start = || Start::second_order(q0, v0);
    let (h, until) = (0.01, 4.0);
    let step = || Ok(Flow::new(system, h, start())?.to(until)?.q.to_vec());
    let series = || {
        let mut flow = TaylorFlow::new(system, start(), Tolerance::relative(1e-11))?;
        Ok(flow.to(until)?.q.to_vec())
    };
    let composed = || {
        let mut flow = ComposedFlow::new(system, h, Composition::SUZUKI_4, start())?;
        Ok(flow.to(until)?.q.to_vec())
    };
    [step(), series(), composed()]
}

/// Compares runs with factors to the run without.
fn compare_with_factors<S: System<2>>(name: &str, of: impl Fn(f64, f64) -> S, start: [[f64; 2]; 2]) {
    // with a constraint on positions, compositions are refused
    let natural = ends(&of(1.0, 1.0), start).map(Result::ok);
    assert!(natural[0].is_some() && natural[1].is_some(), "{name}");
    let mut refused = [0; 3];
    for exponent in (900..=1160).step_by(4) {
        let factor = 2.0_f64.powi(-exponent / 2);
        let all = ends(&of(factor, factor), start).into_iter().zip(&natural);
        let known = all
            .enumerate()
            .filter_map(|(place, (end, natural))| Some((place, end, natural.as_ref()?)));
        for (place, end, natural) in known {
            match end {
                Ok(end) => {
                    // the series may divide the factor out
                    assert!(
                        exponent < 1060 || place == 1,
                        "{name}, method {place}: 2^-{exponent} is not refused"
                    );
                    for (x, y) in end.iter().zip(natural) {
                        assert!(
                            (x - y).abs() < 1e-7,
                            "{name}, method {place}: 2^-{exponent}: {x} for {y}"
                        );
                    }
                }
                Err(error) => {
                    assert!(exponent > 970, "{name}, method {place}: 2^-{exponent}: {error}");
                    assert!(
                        matches!(
                            refusal(&error),
                            // also the failure of a step whose rows have lost all digits
                            None | Some(SetupError::Underflow { .. } | SetupError::Acceleration { .. })
                        ),
                        "{name}: {error}"
                    );
                    refused[place] += 1;
                }
            }
        }
    }
    assert!(
        refused[0] > 20 && (refused[2] > 20 || natural[2].is_none()),
        "{refused:?}"
    );
}

#[test]
fn a_factor_that_leaves_no_digits_is_refused() {
    let springs = |first, second| Springs { first, second };
    compare_with_factors("springs", springs, [[1.0, 0.3], [0.0, 0.5]]);
    // where no force acts at first
    compare_with_factors("springs", springs, [[0.0; 2], [1.0, 0.0]]);
    let circle = |first, second| Circle { first, second };
    compare_with_factors("circle", circle, [[1.0, 0.0], [0.0, 0.3]]);
}

#[test]
fn a_force_that_underflows_far_from_where_it_acts_is_no_loss() {
    for from in [-3.0_f64, -7.0] {
        for far in (1000..1200).step_by(3) {
            // exp(-far / 1.6) at the start
            let width = from.abs() / (f64::from(far) / 1.6).sqrt();
            let text = format!(
                "coordinates(x); lagrangian = dot(x).powi(2) / 2;
                 external_forces = (0.3 * (-(x / {width:?}).powi(2)).exp());"
            );
            let text = Text::parse("well", &text).unwrap();
            for v in [0.0, 1.0] {
                let start = || Start::second_order([from], [v]);
                let end = from + 2.0 * v;
                let mut step = AnyFlow::of(&text.system, 0.1, start()).unwrap();
                step.to(2.0).unwrap();
                let mut series = TaylorFlow::read(&text.system, start(), Tolerance::relative(1e-9)).unwrap();
                series.to(2.0).unwrap();
                for q in [step.node().q[0], series.node().q[0]] {
                    assert!((q - end).abs() < 1e-9, "{width} {v}: {q}");
                }
            }
        }
    }
}

#[test]
fn parameters_below_the_normal_numbers_are_refused() {
    for first in [1e-320, 5e-324, 2e-308, -1e-310] {
        let system = Springs { first, second: 1.0 };
        for end in ends(&system, [[1.0, 0.0], [0.0; 2]]) {
            assert!(
                matches!(end.as_ref().err().and_then(refusal), Some(SetupError::SubnormalParameter { name, .. }) if name == "first"),
                "{first}: {end:?}"
            );
        }
    }
}

/// Positions and velocities down to subnormal numbers, and masses of 1e-100, run by all three methods.
#[test]
fn what_is_small_and_has_its_digits_runs() {
    // states that hardly move, one without force, and rest
    for (q0, v0) in [
        ([1e-200, 0.0], [0.0; 2]),
        ([1e-310, 0.0], [0.0; 2]),
        ([0.0; 2], [1e-300, 0.0]),
        ([0.0; 2], [0.0; 2]),
        ([1.0, 1e-250], [0.0, 1e-320]),
    ] {
        for end in ends(
            &Springs {
                first: 1.0,
                second: 1.0,
            },
            [q0, v0],
        ) {
            assert!(end.is_ok(), "{q0:?}, {v0:?}: {end:?}");
        }
        // a mass of 1e-100
        for end in ends(
            &Springs {
                first: 1e-50,
                second: 1e-50,
            },
            [q0.map(|x| x.max(1e-100)), v0],
        ) {
            assert!(end.is_ok(), "{q0:?}, {v0:?}: {end:?}");
        }
    }
}

/// Constants in powers are not collected where their power alone underflows: the force at a place is that of the same expression in Rust.
#[test]
fn constants_in_high_powers_and_large_units_keep_their_digits() {
    type Force = fn(f64) -> f64;
    let forces: [(&str, f64, Force); 12] = [
        ("((1 + x.cos()) / 2).powi(1500)", 0.02, |x| {
            (x / 2.0).cos().powi(2 * 1500)
        }),
        ("((1 + x.cos()) / 2).powf(1100.0)", 0.02, |x| {
            (x / 2.0).cos().powi(2 * 1100)
        }),
        ("((1 + x.cos()) / 2).powi(1050)", 0.02, |x| {
            (x / 2.0).cos().powi(2 * 1050)
        }),
        ("(((1 + x.cos()) / 2).powi(40)).powi(40)", 0.02, |x| {
            (x / 2.0).cos().powi(2 * 1600)
        }),
        ("((2 + x.cos()) / 3).powi(700)", 0.02, |x| {
            ((2.0 + x.cos()) / 3.0).powi(700)
        }),
        ("(1 - 0.5 * x * x).powi(1500)", 0.02, |x| {
            (1.0 - 0.5 * x * x).powi(1500)
        }),
        ("(x / 2).powi(1100)", 1.99, |x| (x / 2.0).powi(1100)),
        ("(x / 1e5).powi(70)", 1e5, |x| (x / 1e5).powi(70)),
        ("(x * x / 1e10).powi(33)", 0.9e5, |x| (x * x / 1e10).powi(33)),
        ("(x * 1e-110).powi(3)", 1e110, |x| (x * 1e-110).powi(3)),
        ("(x * 1e-110) * (x * 1e-110) * (x / 1e110)", 1e110, |x| {
            (x * 1e-110).powi(3)
        }),
        ("1 / (1 + (x * 1e-170).powi(2))", 1e170, |x| {
            (1.0 + (x * 1e-170).powi(2)).recip()
        }),
    ];
    for (force, x, value) in forces {
        let text = format!("coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = ({force});");
        let text = Text::parse("power", &text).unwrap();
        let flow = AnyFlow::of(&text.system, 0.01, Start::second_order([x], [0.0])).unwrap();
        let (found, expected) = (flow.node().a[0], value(x));
        assert!(
            (found / expected - 1.0).abs() < 1e-12,
            "{force} at {x}: {found} for {expected}"
        );
    }
}
