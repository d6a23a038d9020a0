//! The order of the scheme, by a fit of its errors against the Taylor flow.

use super::{Measured, Report, Subject, larger, probe};
use crate::stability::Bar;

/// Each of so many steps is half of the one before.
const HALVINGS: u32 = 6;

/// An error below this part of the motion's extent may be rounding, and is left out of the fit.
const PLATEAU: f64 = 1e-11;

/// How far the fitted order may be from the declared one.
const APART: f64 = 0.1;

/// The tolerance of the continuous motion.
const TOLERANCE: f64 = 1e-15;

/// The order on the system's own motion.
pub fn order<const N: usize>(subject: &Subject<'_, N>, report: &mut Report) {
    let fitted = errors(subject).and_then(|errors| fit(&errors));
    let declared = subject.expected.order;
    let (slope, count) = match &fitted {
        Ok((slope, count)) => (Ok(*slope), *count),
        Err(error) => (Err(error.to_string().into()), 0),
    };
    let distance = fitted.map(|(slope, _)| (slope - declared).abs());
    report.push(
        format!(
            "slope of the errors at {count} steps, from h = {} down",
            subject.h
        ),
        Bar::Reported,
        slope,
    );
    report.push(
        format!("its distance from {declared}"),
        Bar::AtMost(APART),
        distance,
    );
}

/// Steps, and the largest error at the nodes of the first, relative to the coordinates' extent.
fn errors<const N: usize>(subject: &Subject<'_, N>) -> Measured<Vec<[f64; 2]>> {
    let (h, [q0, _]) = (subject.h, subject.start);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates
    let coarse = (subject.until / h).round().max(2.0) as u32;
    let times: Vec<f64> = (1..=coarse).map(|k| f64::from(k) * h).collect();
    let exact = probe::exact(subject.system, h, &subject.start, &times, TOLERANCE)?;
    let extent: [f64; N] = core::array::from_fn(|i| {
        let moved = exact.iter().map(|q| (q[i] - q0[i]).abs());
        moved.fold(0.0, larger)
    });
    // a coordinate that stands still is told relative to the one that moves most
    let most = extent.iter().fold(0.0, |most, &x| larger(most, x));
    let mut errors = Vec::new();
    for halving in 0..HALVINGS {
        let parts = 1_u32 << halving;
        let positions = probe::positions(
            subject.system,
            h / f64::from(parts),
            &subject.start,
            (parts, exact.len()),
        )?;
        let mut error = 0.0;
        for (found, exact) in positions.iter().zip(&exact) {
            for ((found, exact), &extent) in found.iter().zip(exact).zip(&extent) {
                let scale = if extent > 1e-3 * most { extent } else { most };
                error = larger(error, (found - exact).abs() / scale);
            }
        }
        errors.push([(h / f64::from(parts)).abs(), error]);
    }
    Ok(errors)
}

/// The slope of the errors above the plateau, and how many there are.
fn fit(errors: &[[f64; 2]]) -> Measured<(f64, usize)> {
    let kept: Vec<[f64; 2]> = errors
        .iter()
        .filter(|[_, error]| *error > PLATEAU || error.is_nan())
        .map(|[h, error]| [h.ln(), error.ln()])
        .collect();
    if kept.len() < 3 {
        return Err("fewer than three errors are above rounding: give a larger step".into());
    }
    let count = kept.len() as f64;
    let mean = |k: usize| kept.iter().map(|point| point[k]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let above: f64 = kept.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    let below: f64 = kept.iter().map(|point| (point[0] - x).powi(2)).sum();
    Ok((above / below, kept.len()))
}
