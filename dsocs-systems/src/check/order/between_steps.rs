//! Orders that are seen from a step to its half, without a Taylor series.

use dsocs_core::geometry::{Triple, discrete_power};
use dsocs_core::{AnyPoint, Declaration, Kernel, OwnedLeg};

use super::slope::{above_plateau, fitted_slope};
use crate::check::{Measured, Report, larger};
use crate::stability::Bar;

/// A change below this part of the motion's extent may be rounding.
const PLATEAU: f64 = 1e-10;

/// The largest deficit of the fitted order against the declared one.
pub const ORDER_DEFICIT: f64 = 0.1;

/// A leg, with the second difference behind it.
pub type Step = (OwnedLeg<f64>, Vec<f64>);

/// The order of the energy balance: the energy at the nodes of some steps, each half of the one before, against
/// the sum of the power of the forces.
pub fn balance(
    kernel: &dyn Kernel,
    (lengths, order): (impl IntoIterator<Item = f64>, f64),
    steps: impl Fn(f64) -> Measured<Vec<Step>>,
    report: &mut Report,
) {
    let lengths = lengths.into_iter();
    let measured = lengths.map(|h| Ok([h.abs(), missed_power(kernel, h, steps(h)?)]));
    push_slope(
        "slope of E − Σh(⟨Q + f, v⟩ − ∂L/∂t) between nodes",
        measured.collect(),
        Bar::AtLeast(order - ORDER_DEFICIT),
        report,
    );
}

/// The largest defect of the energy balance since the first node, relative to the energy's terms.
fn missed_power(kernel: &dyn Kernel, h: f64, steps: Vec<Step>) -> f64 {
    let declaration = Declaration::of(kernel);
    let (mut change, mut missed, mut terms) = (0.0, 0.0, 0.0);
    let mut last: Option<(f64, f64)> = None;
    for (leg, e) in steps {
        let point = declaration.point(h, leg.any(), &e);
        let AnyPoint { t, q, v, .. } = point.any();
        let energy = declaration.energy(t, q, v);
        terms = larger(terms, energy.abs() + 2.0 * declaration.lagrangian(t, q, v).abs());
        let power = discrete_power(kernel, h, &Triple { leg, e });
        last = Some(match last {
            Some((first, before)) => {
                change += h * (before + power) / 2.0;
                missed = larger(missed, (energy - first - change).abs());
                (first, power)
            }
            None => (energy, power),
        });
    }
    if missed == 0.0 { 0.0 } else { missed / terms }
}

/// Fits a slope to the values above rounding.
pub fn push_slope(what: &str, measured: Measured<Vec<[f64; 2]>>, bar: Bar, report: &mut Report) {
    let points = match measured {
        Ok(points) => points,
        Err(error) => {
            report.push(what, Bar::Reported, Err(error));
            return;
        }
    };
    let fit = above_plateau(PLATEAU, points);
    let Some(points @ [[first, _], .., [least, _]]) = fit.as_deref() else {
        report.push(what, Bar::Reported, Ok(0.0));
        report.note("what is measured is rounding: no order is fitted");
        return;
    };
    report.push(
        format!("{what}, h = {first:.1e} to {least:.1e}"),
        bar,
        Ok(fitted_slope(points)),
    );
}
