//! Spherical Bessel functions.

use super::Real;

/// Up to this argument spherical Bessel functions are summed as series; beyond it, their closed forms have no
/// cancellation.
const SERIES: f64 = 1.5;

/// Terms of the series: the last is below `1.5³²/32!`.
const TERMS: u32 = 16;

/// The spherical Bessel function of order `order` near 0: `xⁿ Σ (−x²/2)ᵏ / (k! (2n+2k+1)!!)`.
fn series<R: Real>(x: R, order: u32) -> R {
    let square = x * x * -0.5;
    let mut term = R::one();
    for k in 0..order {
        term = term * x / f64::from(2 * k + 3);
    }
    let mut sum = term;
    for k in 1..TERMS {
        term = term * square / f64::from(k * (2 * (order + k) + 1));
        sum += term;
    }
    sum
}

/// `sin x / x`.
pub(super) fn j0<R: Real>(x: R) -> R {
    if x.re().abs() <= SERIES {
        return series(x, 0);
    }
    x.sin() / x
}

/// `(j₀ − cos x)/x`.
pub(super) fn j1<R: Real>(x: R) -> R {
    if x.re().abs() <= SERIES {
        return series(x, 1);
    }
    (j0(x) - x.cos()) / x
}

/// `3 j₁/x − j₀`.
pub(super) fn j2<R: Real>(x: R) -> R {
    if x.re().abs() <= SERIES {
        return series(x, 2);
    }
    j1(x) * 3.0 / x - j0(x)
}
