//! Functions of dual numbers on the whole range of doubles, against 420-digit arithmetic.

use std::error::Error;

use dsocs_core::__private::Dual;
use dsocs_core::Real;
use num_dual::Dual as Foreign;

use super::{Bar, Measured, Report, larger};

/// Functions, arguments, values and two derivatives.
const TABLE: &str = include_str!("../../../data/functions.csv");

/// Errors of numbers below this size are relative to it: near the smallest doubles fewer digits are left.
const SMALLEST: f64 = 1e-292;

/// A function of the table.
fn apply<R: Real>(name: &str, x: R) -> Option<R> {
    Some(match name {
        "recip" => x.recip(),
        "powi0" => x.powi(0),
        "powi1" => x.powi(1),
        "powi2" => x.powi(2),
        "powi3" => x.powi(3),
        "powi7" => x.powi(7),
        "powi-3" => x.powi(-3),
        "powf0.5" => x.powf(0.5),
        "powf2.5" => x.powf(2.5),
        "powf-1.5" => x.powf(-1.5),
        "powf3" => x.powf(3.0),
        "sqrt" => x.sqrt(),
        "cbrt" => x.cbrt(),
        "exp" => x.exp(),
        "exp2" => x.exp2(),
        "exp_m1" => x.exp_m1(),
        "ln" => x.ln(),
        "log2" => x.log2(),
        "log10" => x.log10(),
        "ln_1p" => x.ln_1p(),
        "sin" => x.sin(),
        "cos" => x.cos(),
        "tan" => x.tan(),
        "asin" => x.asin(),
        "acos" => x.acos(),
        "atan" => x.atan(),
        "sinh" => x.sinh(),
        "cosh" => x.cosh(),
        "tanh" => x.tanh(),
        "asinh" => x.asinh(),
        "acosh" => x.acosh(),
        "atanh" => x.atanh(),
        "sph_j0" => x.sph_j0(),
        "sph_j1" => x.sph_j1(),
        "sph_j2" => x.sph_j2(),
        _ => return None,
    })
}

/// The error of a number in units of `ε`, relative to itself or to `scale`.
fn units(found: f64, wanted: f64, scale: f64) -> f64 {
    let same = found.total_cmp(&wanted).is_eq() || (found == 0.0 && wanted == 0.0);
    if same {
        return 0.0;
    }
    if wanted.is_infinite() && found.abs() > 1e308 && found.signum() == wanted.signum() {
        return 0.0; // next to the largest double, where rounding decides
    }
    (found - wanted).abs() / (wanted.abs().max(scale).max(SMALLEST) * f64::EPSILON)
}

/// The largest errors of first and second derivatives, in `ε`; the number of derivatives that differ by more
/// than `1e-6`; and the number of values that differ from those of `f64`. `evaluate` returns the value with
/// both derivatives.
fn errors(evaluate: impl Fn(&str, f64) -> Option<[f64; 3]>) -> Result<[f64; 4], Box<dyn Error>> {
    let mut worst = [0.0; 4];
    for line in TABLE.lines().skip(1) {
        let mut fields = line.split(',');
        let name = fields.next().unwrap_or_default();
        let numbers: Vec<f64> = fields.map(str::parse).collect::<Result<_, _>>()?;
        let ([x, _, first, second], Some(found)) = (&numbers[..], evaluate(name, numbers[0])) else {
            return Err(format!("what is {line}?").into());
        };
        // spherical Bessel functions are relatively inaccurate at their zeros
        let scale = if name.starts_with("sph") {
            x.abs().max(1.0).recip()
        } else {
            0.0
        };
        let plain = apply(name, *x).unwrap_or(f64::NAN);
        if !name.starts_with("sph") && found[0].to_bits() != plain.to_bits() {
            worst[3] += 1.0;
        }
        for (place, wanted) in [*first, *second].into_iter().enumerate() {
            let error = units(found[place + 1], wanted, scale);
            worst[place] = larger(worst[place], error);
            if error.is_nan() || error > 1e-6 / f64::EPSILON {
                worst[2] += 1.0;
            }
        }
    }
    Ok(worst)
}

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    let names = [
        (
            "35 functions at 88 arguments from 5e-324 to 1.7e308: first derivatives, error in ε".to_owned(),
            Bar::AtMost(16.0),
        ),
        (
            "the same: second derivatives, error in ε".to_owned(),
            Bar::AtMost(64.0),
        ),
        (
            "the same: derivatives that are wrong or NaN".to_owned(),
            Bar::AtMost(0.0),
        ),
        (
            "the same: values that are not those of f64".to_owned(),
            Bar::AtMost(0.0),
        ),
    ];
    report.measure_all(names, || {
        errors(|name, x| {
            let y = apply(name, Dual::new(Dual::new(x, 1.0), Dual::new(1.0, 0.0)))?;
            Some([y.re.re, y.re.eps, y.eps.eps])
        })
    });
    report.measure(
        "num-dual 0.15 by itself: derivatives that are wrong or NaN",
        Bar::Reported,
        || {
            let figures = errors(|name, x| {
                let y = apply(name, Foreign::new(Foreign::new(x, 1.0), Foreign::new(1.0, 0.0)))?;
                Some([y.re.re, y.re.eps, y.eps.eps])
            })?;
            Ok(figures[2])
        },
    );
    report.measure(
        "constants at points of infinite slope (sqrt, cbrt, ln, asin … at the edge): NaN or not constant",
        Bar::AtMost(0.0),
        constants,
    );
}

/// Constants at the edges of domains whose derivative is not zero.
fn constants() -> Measured {
    let (mut wrong, zero) = (0.0, Dual::new(0.0, 0.0));
    for (name, x) in [
        ("sqrt", 0.0),
        ("cbrt", 0.0),
        ("powf0.5", 0.0),
        ("powf2.5", 0.0),
        ("powi0", 0.0),
        ("powi3", 0.0),
        ("recip", 0.0),
        ("ln", 0.0),
        ("ln_1p", -1.0),
        ("asin", 1.0),
        ("acos", -1.0),
        ("acosh", 1.0),
        ("atanh", 1.0),
        ("tanh", 1e308),
        ("exp", 1e308),
        ("sinh", -1e308),
    ] {
        let Some(y) = apply(name, Dual::new(Dual::new(x, 0.0), zero)) else {
            return Err(format!("what is {name}?").into());
        };
        if y.re.eps != 0.0 || y.eps.re != 0.0 || y.eps.eps != 0.0 {
            wrong += 1.0;
        }
    }
    Ok(wrong)
}
