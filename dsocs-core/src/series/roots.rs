//! The changes of sign of a polynomial on an interval, none missed.
//!
//! In Bernstein's basis on an interval the number of roots inside is at most the number of changes of sign of
//! the coefficients, and differs from it by an even number (Descartes). So without a change there is no root,
//! and with one change there is one; with more, the interval is halved by de Casteljau's scheme. This ends
//! because near a simple root one change is left (Vincent; Collins and Akritas, Polynomial real root
//! isolation using Descarte's rule of signs, 1976).

use crate::series::orders::ROWS;

/// Largest number of halvings: two changes of sign closer than that count as none.
const DEPTH: u32 = 40;

/// Bernstein coefficients of a polynomial of degree below [`ROWS`].
type Bernstein = [f64; ROWS];

/// A change of sign of a polynomial: its place in `(0, 1]`, and whether it is upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) at: f64,
    /// An interval that contains it, for other evaluations of the same function.
    pub(crate) bracket: [f64; 2],
    pub(crate) rising: bool,
}

/// The changes of sign of `Σ c_k s^k` for `s` in `(0, 1)`, in order.
pub(crate) fn crossings(coefficients: &[f64], found: &mut Vec<Crossing>) {
    found.clear();
    let degree = coefficients.len().min(ROWS).saturating_sub(1);
    let bernstein = bernstein(&coefficients[..=degree]);
    isolate(&bernstein, degree, [0.0, 1.0], DEPTH, &mut |bracket| {
        found.push(refine(&|s| value(coefficients, s), bracket));
    });
}

/// `Σ c_k s^k`.
pub(crate) fn value(coefficients: &[f64], s: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * s + c)
}

/// `b_i = Σ_k C(i,k)/C(n,k) c_k`.
fn bernstein(coefficients: &[f64]) -> Bernstein {
    let n = coefficients.len() - 1;
    let mut b = [0.0; ROWS];
    for (i, b) in b.iter_mut().enumerate().take(n + 1) {
        let mut ratio = 1.0;
        for (k, c) in coefficients.iter().enumerate().take(i + 1) {
            *b += ratio * c;
            ratio *= (i - k) as f64 / (n - k).max(1) as f64;
        }
    }
    b
}

/// Passes on intervals with one change of sign each, from left to right.
fn isolate(
    b: &Bernstein,
    degree: usize,
    [left, right]: [f64; 2],
    depth: u32,
    found: &mut impl FnMut([f64; 2]),
) {
    let mut changes = 0;
    let mut sign = 0.0;
    for &b in &b[..=degree] {
        if b != 0.0 {
            if sign * b < 0.0 {
                changes += 1;
            }
            sign = b.signum();
        }
    }
    if changes == 0 {
        return;
    }
    let ends = b[0] * b[degree];
    if (changes == 1 && ends < 0.0) || depth == 0 {
        if ends < 0.0 {
            found([left, right]);
        }
        return;
    }
    let (mut low, mut high) = (*b, *b);
    for level in 1..=degree {
        for i in 0..=degree - level {
            high[i] = 0.5 * (high[i] + high[i + 1]);
        }
        low[level] = high[0];
    }
    // a root at the middle itself is on neither side; the sum of a pair of signs decides on which it counts
    let middle = 0.5 * (left + right);
    if high[0] == 0.0 && low[..degree].iter().any(|b| *b != 0.0) {
        let before = low[..degree]
            .iter()
            .rev()
            .find(|b| **b != 0.0)
            .copied()
            .unwrap_or(0.0);
        let after = high[1..=degree]
            .iter()
            .find(|b| **b != 0.0)
            .copied()
            .unwrap_or(0.0);
        isolate(&low, degree, [left, middle], depth - 1, found);
        if before * after < 0.0 {
            let width = (right - left) * 1e-9;
            found([middle - width, middle + width]);
        }
        isolate(&high, degree, [middle, right], depth - 1, found);
        return;
    }
    isolate(&low, degree, [left, middle], depth - 1, found);
    isolate(&high, degree, [middle, right], depth - 1, found);
}

/// The root in an interval with different signs at its ends, by the Illinois method, which keeps it
/// bracketed.
pub(crate) fn refine(value: &dyn Fn(f64) -> f64, [mut a, mut b]: [f64; 2]) -> Crossing {
    let bracket = [a, b];
    let (mut at_a, mut at_b) = (value(a), value(b));
    let rising = at_b > at_a;
    for _ in 0..200 {
        if at_b == 0.0 || (b - a).abs() <= f64::EPSILON * a.abs().max(b.abs()) {
            break;
        }
        let secant = b - at_b * (b - a) / (at_b - at_a);
        let middle = if secant.is_finite() && (secant - a) * (secant - b) < 0.0 {
            secant
        } else {
            0.5 * (a + b)
        };
        if middle == a || middle == b {
            break;
        }
        let at_middle = value(middle);
        if at_middle * at_b < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        (b, at_b) = (middle, at_middle);
    }
    Crossing {
        at: b,
        bracket,
        rising,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `Π (s - r)`, expanded.
    fn with_roots(roots: &[f64]) -> Vec<f64> {
        let mut coefficients = vec![1.0];
        for root in roots {
            let mut next = vec![0.0; coefficients.len() + 1];
            for (k, c) in coefficients.iter().enumerate() {
                next[k + 1] += c;
                next[k] -= root * c;
            }
            coefficients = next;
        }
        coefficients
    }

    fn found(roots: &[f64]) -> Vec<Crossing> {
        let mut crossings_found = Vec::new();
        crossings(&with_roots(roots), &mut crossings_found);
        crossings_found
    }

    #[test]
    fn every_root_inside_is_found_and_none_outside() {
        let crossings = found(&[-0.5, 0.1, 0.101, 0.5, 0.8, 0.999, 1.2, 3.0]);
        let expected = [0.1, 0.101, 0.5, 0.8, 0.999];
        assert_eq!(crossings.len(), expected.len(), "{crossings:?}");
        for (crossing, root) in crossings.iter().zip(expected) {
            assert!((crossing.at - root).abs() < 1e-11, "{crossing:?} {root}");
        }
        for pair in crossings.windows(2) {
            assert_ne!(pair[0].rising, pair[1].rising);
        }
    }

    #[test]
    fn two_roots_between_ends_of_one_sign_are_found() {
        let crossings = found(&[0.4, 0.400_001]);
        assert_eq!(crossings.len(), 2);
        assert!(!crossings[0].rising && crossings[1].rising);
    }

    #[test]
    fn what_only_touches_zero_is_no_change_of_sign() {
        // (s - 1/2)² in exact arithmetic
        let mut crossings_found = Vec::new();
        crossings(&[0.25, -1.0, 1.0], &mut crossings_found);
        assert_eq!(crossings_found, []);
        crossings(&[0.26, -1.0, 1.0], &mut crossings_found);
        assert_eq!(crossings_found, []);
    }

    #[test]
    fn a_triple_root_is_one_change() {
        let crossings = found(&[0.25, 0.25, 0.25]);
        assert_eq!(crossings.len(), 1);
        assert!((crossings[0].at - 0.25).abs() < 1e-5 && crossings[0].rising);
    }
}
