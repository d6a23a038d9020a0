//! Numbers as the program writes them.

/// The shortest decimal form that reads back as the same number: `0.03`, `1e-7`, `-2`.
///
/// Between 1e-4 and 1e16 in size it has no exponent.
pub fn shortest(x: f64) -> String {
    let mut text = format!("{x:?}");
    if text.ends_with(".0") {
        text.truncate(text.len() - 2);
    }
    text
}

/// A number in six digits at most, for people.
pub fn six_digits(x: f64) -> String {
    // adding zero removes the sign of a negative zero
    format!("{x:.5e}")
        .parse()
        .map_or_else(|_| x.to_string(), |rounded: f64| shortest(rounded + 0.0))
}

/// Numbers as options take them, `0.5,-1`.
pub fn comma_separated(numbers: &[f64]) -> String {
    numbers.iter().map(|&x| shortest(x)).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_short_and_reads_back_the_same() {
        for (x, text) in [
            (0.03, "0.03"),
            (1.0, "1"),
            (-0.0, "-0"),
            (0.1 + 0.2, "0.30000000000000004"),
            (1e-7, "1e-7"),
            (1.5e300, "1.5e300"),
            (f64::MIN_POSITIVE, "2.2250738585072014e-308"),
        ] {
            assert_eq!(shortest(x), text);
            assert_eq!(shortest(x).parse::<f64>().unwrap().to_bits(), x.to_bits());
        }
        for (x, text) in [
            (1.0 / 3.0, "0.333333"),
            (-0.0, "0"),
            (1_234_567.8, "1234570"),
            (-2e-9, "-2e-9"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(six_digits(x), text);
        }
        assert_eq!(comma_separated(&[0.5, -1.0]), "0.5,-1");
    }
}
