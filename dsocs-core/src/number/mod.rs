//! The numbers with which a declaration is evaluated: doubles, lanes, derivatives, bounds of rounding errors,
//! compensated sums.

pub(crate) mod array;
pub(crate) mod bounded;
pub(crate) mod compensated;
pub(crate) mod composition;
pub(crate) mod dispatch;
pub(crate) mod double;
pub(crate) mod dual;
pub(crate) mod fours;
pub(crate) mod instructions;
pub(crate) mod lanes;
pub(crate) mod message;
pub(crate) mod point;
pub(crate) mod real;
pub(crate) mod scalar;
pub(crate) mod tangent;

/// The larger of two sizes, neither of which is negative; NaN if either is.
// as bits, such numbers have the same order, and NaN is the largest
#[inline]
pub(crate) fn larger(size: f64, other: f64) -> f64 {
    f64::from_bits(size.to_bits().max(other.to_bits()))
}

/// The largest absolute value of a component, 0 of none; NaN is ignored.
#[inline]
pub(crate) fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()))
}

/// The inner product of two vectors.
#[inline]
pub(crate) fn inner_product(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// Removes the part of a vector along a direction, which has the length 1.
pub(crate) fn remove_part(vector: &mut [f64], direction: &[f64]) {
    let part = inner_product(vector, direction);
    for (x, along) in vector.iter_mut().zip(direction) {
        *x -= part * along;
    }
}

#[cfg(test)]
mod tests {
    use super::larger;

    #[test]
    fn no_size_hides_what_is_no_number() {
        assert_eq!(larger(1.0, 2.0), 2.0);
        assert_eq!(larger(f64::INFINITY, 2.0), f64::INFINITY);
        assert!(larger(f64::NAN, 2.0).is_nan() && larger(2.0, f64::NAN).is_nan());
    }
}
