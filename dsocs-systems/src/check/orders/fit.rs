//! The order of a figure: the power of the step with which it falls.

use crate::check::order::fitted_slope;

/// A figure is used if it is above this many times its rounding.
const LEAST_ROUNDINGS: f64 = 10.0;

/// A figure that no longer falls is rounding if it is below this part of the terms: the exact motion is known
/// no better, as where masses differ much.
const PLATEAU: f64 = 1e-6;

/// It no longer falls if half the step leaves more than this part of it.
const STOPPED_FALLING: f64 = core::f64::consts::FRAC_1_SQRT_2;

/// A figure that never falls is rounding if it is below this part of the terms.
const EXACT_FIGURE: f64 = 1e-9;

/// A figure that is below this part of the terms at every step is exactly zero.
const ZERO_FIGURE: f64 = 1e-13;

/// The number of steps in a fit.
const FITTED_STEPS: usize = 4;

/// The smallest number of steps that show a power.
const LEAST_STEPS: usize = 3;

/// The largest change of the power between steps of a fit: the first where possible, else the second.
const STEADY_POWER: [f64; 2] = [0.02, 0.1];

/// A fitted power this near to a whole number is that number.
const WHOLE_POWER: f64 = 0.2;

/// There is no power if it changes by more than this in all fits.
const NO_POWER: f64 = 0.5;

/// A figure that was measured with a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The step, in s.
    pub h: f64,
    /// The figure, relative to its terms.
    pub value: f64,
    /// The part of it that rounding explains.
    pub rounding: f64,
}

/// The order of contact of a part of the discrete system with the exact one, as the step goes to zero.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// The part is exact, to rounding, at every step.
    Exact,
    /// The distance falls with this power of the step.
    Power {
        /// The power, as fitted.
        power: f64,
        /// The largest and the smallest step of the fit, in s.
        steps: [f64; 2],
    },
    /// There is no order, for a reason.
    Unknown(String),
}

impl Order {
    /// The order as a number: infinite where the part is exact, `None` where it is not known. A fitted power
    /// near a whole number is that number.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Exact => Some(f64::INFINITY),
            Self::Power { power, .. } if (power - power.round()).abs() < WHOLE_POWER => Some(power.round()),
            Self::Power { power, .. } => Some(*power),
            Self::Unknown(_) => None,
        }
    }

    /// The lower of two orders; not known if either is not.
    pub(super) fn least(self, other: &Self) -> Self {
        match (self.value(), other.value()) {
            (None, _) => self,
            (_, None) => other.clone(),
            (Some(x), Some(y)) if y < x => other.clone(),
            _ => self,
        }
    }

    /// The order as fitted.
    fn value(&self) -> Option<f64> {
        match self {
            Self::Exact => Some(f64::INFINITY),
            Self::Power { power, .. } => Some(*power),
            Self::Unknown(_) => None,
        }
    }
}

/// The order of a figure, from samples with decreasing steps.
pub fn order(samples: &[Sample]) -> Order {
    order_and_unsteadiness(samples).0
}

/// The order, and the change of the power within the steps of the fit; infinite where a fit was needed and
/// none was found.
pub fn order_and_unsteadiness(samples: &[Sample]) -> (Order, f64) {
    let unknown = |reason: String| (Order::Unknown(reason), f64::INFINITY);
    let known = samples
        .iter()
        .take_while(|of| of.value > LEAST_ROUNDINGS * of.rounding && of.value.is_finite());
    let mut points: Vec<[f64; 2]> = known.map(|of| [of.h, of.value]).collect();
    if let Some(bad) = samples.get(points.len()).filter(|of| !of.value.is_finite()) {
        return unknown(format!("it has no value with the step {:.1e} s", bad.h));
    }
    let stops = |pair: &[[f64; 2]]| pair[1][1] > STOPPED_FALLING * pair[0][1];
    if let Some(stop) = points
        .windows(2)
        .position(|pair| pair[0][1] < PLATEAU && stops(pair))
    {
        points.truncate(stop);
    }
    let largest = samples.iter().fold(0.0_f64, |most, of| most.max(of.value));
    let falls = points.len() >= LEAST_STEPS;
    if points.is_empty() || largest < ZERO_FIGURE || (!falls && largest < EXACT_FIGURE) {
        return (Order::Exact, 0.0);
    }
    if !falls {
        return unknown(format!(
            "with {} of {} steps alone it is above rounding, too few for a power",
            points.len(),
            samples.len()
        ));
    }
    // beginning with the smallest steps: larger ones may be too large for a power law
    let windows = points.windows(FITTED_STEPS.min(points.len())).rev();
    let windows: Vec<(&[[f64; 2]], f64)> = windows.map(|window| (window, unsteadiness(window))).collect();
    let steady = |most: f64| windows.iter().find(|(_, unsteadiness)| *unsteadiness < most);
    let steadiest = || windows.iter().min_by(|x, y| x.1.total_cmp(&y.1));
    let best = STEADY_POWER.into_iter().find_map(steady).or_else(steadiest);
    match best {
        Some((window @ [[first, _], .., [last, _]], unsteadiness)) if *unsteadiness < NO_POWER => {
            let (power, steps) = (fitted_slope(window), [*first, *last]);
            (Order::Power { power, steps }, *unsteadiness)
        }
        _ => unknown("it does not fall as a power of the step".to_owned()),
    }
}

/// The change of the power from step to step: the largest minus the smallest.
fn unsteadiness(points: &[[f64; 2]]) -> f64 {
    let powers = points
        .windows(2)
        .map(|pair| (pair[0][1] / pair[1][1]).ln() / (pair[0][0] / pair[1][0]).ln());
    let (least, most) = powers.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), power| {
        (least.min(power), most.max(power))
    });
    most - least
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures with the steps 1, ½, ¼ and so on.
    fn samples(value: impl Fn(f64) -> f64, rounding: impl Fn(f64) -> f64) -> Vec<Sample> {
        let steps = (0..14).map(|k| 0.5_f64.powi(k));
        steps
            .map(|h| Sample {
                h,
                value: value(h),
                rounding: rounding(h),
            })
            .collect()
    }

    #[test]
    fn powers_are_found() {
        for power in 1..5 {
            // with a term of higher order, a plateau, and noise
            let of = |h: f64| h.powi(power) * (1.0 + 8.0 * h * h) + 1e-13;
            let noise = |h: f64| 1e-16 / h;
            let found = order(&samples(of, noise));
            let Order::Power { power: fit, .. } = found else {
                panic!("{found:?}");
            };
            assert!((fit - f64::from(power)).abs() < 0.02, "{fit}, not {power}");
            assert_eq!(found.number(), Some(f64::from(power)));
        }
    }

    #[test]
    fn what_does_not_fall_is_of_order_0_unless_it_is_rounding() {
        let flat = |size: f64| order(&samples(|_| size, |_| 1e-16)).number();
        assert_eq!(flat(1e-3), Some(0.0));
        assert_eq!(flat(1e-12), Some(f64::INFINITY));
        assert_eq!(order(&samples(|_| 1e-15, |_| 1e-15)), Order::Exact);
    }

    #[test]
    fn no_power_is_told() {
        // the power alternates from step to step
        let found = order(&samples(|h| h * (2.0 + (1.0 / h).log2().sin() * 1.5), |_| 1e-16));
        assert!(matches!(found, Order::Unknown(_)), "{found:?}");
        let found = order(&samples(|h| if h < 0.1 { f64::NAN } else { h }, |_| 1e-16));
        assert!(matches!(found, Order::Unknown(_)), "{found:?}");
        // above rounding with two steps only
        let found = order(&samples(|h| h * h, |_| 0.02));
        assert!(matches!(found, Order::Unknown(_)), "{found:?}");
    }
}
