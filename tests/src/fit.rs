//! Slopes of errors against steps, on logarithmic axes.

/// The least-squares slope of `ln error` against `ln h`.
#[must_use]
pub fn slope(h: &[f64], error: &[f64]) -> f64 {
    let count = h.len() as f64;
    let (x, y): (Vec<f64>, Vec<f64>) = h.iter().zip(error).map(|(h, error)| (h.ln(), error.ln())).unzip();
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / count, y.iter().sum::<f64>() / count);
    let (mut above, mut below) = (0.0, 0.0);
    for (x, y) in x.iter().zip(&y) {
        above += (x - mean_x) * (y - mean_y);
        below += (x - mean_x).powi(2);
    }
    above / below
}

/// The order of an error: its slope over these steps, which is printed with the errors.
pub fn order(name: &str, steps: &[f64], error: impl Fn(f64) -> f64) -> f64 {
    let errors: Vec<f64> = steps.iter().map(|&h| error(h)).collect();
    let order = slope(steps, &errors);
    println!("{name}: order {order:.4}, errors {errors:?}");
    order
}

/// The slopes between neighbours.
#[must_use]
pub fn local_slopes(h: &[f64], error: &[f64]) -> Vec<f64> {
    let pairs = h.windows(2).zip(error.windows(2));
    pairs
        .map(|(h, error)| (error[1] / error[0]).ln() / (h[1] / h[0]).ln())
        .collect()
}

/// Whether two numbers agree to `digits` significant digits: to half a unit of the last one.
#[must_use]
pub fn agree(left: f64, right: f64, digits: i32) -> bool {
    let unit = 10.0_f64.powf(right.abs().log10().floor() + 1.0) * 10.0_f64.powi(-digits);
    (left - right).abs() <= 0.5 * unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_has_its_exponent_for_slope() {
        let h = [0.1, 0.05, 0.02];
        let error = h.map(|h: f64| 3.0 * h.powf(1.5));
        assert!((slope(&h, &error) - 1.5).abs() < 1e-12);
        assert!(
            local_slopes(&h, &error)
                .iter()
                .all(|slope| (slope - 1.5).abs() < 1e-12)
        );
    }

    #[test]
    fn digits_count_from_the_first() {
        assert!(agree(2.0444, 2.0441, 4) && !agree(2.0448, 2.0441, 4));
        assert!(agree(1.501e-3, 1.5011e-3, 4) && !agree(1.502e-3, 1.5011e-3, 4));
    }
}
