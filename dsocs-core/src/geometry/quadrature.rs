//! Integrals along a motion.

/// Nodes and weights of Gauss's quadrature with eight points on the interval from −1 to 1, for one sign.
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_26],
];

/// The mean of a function over an interval by Gauss's quadrature with eight points, which is exact up to degree 15. The interval may go back.
#[must_use]
pub fn mean_over([from, to]: [f64; 2], function: &mut dyn FnMut(f64) -> f64) -> f64 {
    let (middle, half) = (f64::midpoint(from, to), (to - from) / 2.0);
    let mut sum = 0.0;
    for [node, weight] in GAUSS {
        for side in [-1.0, 1.0] {
            sum += weight / 2.0 * function(middle + side * node * half);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degree_15_is_exact_and_16_is_not() {
        for (degree, is_exact) in [(0, true), (1, true), (8, true), (15, true), (16, false)] {
            let mean = mean_over([-1.0, 2.0], &mut |x| x.powi(degree));
            let power = degree + 1;
            let exact = (2.0_f64.powi(power) - (-1.0_f64).powi(power)) / (3.0 * f64::from(power));
            let apart = (mean / exact - 1.0).abs();
            assert_eq!(apart < 1e-14, is_exact, "degree {degree}: {mean}, not {exact}");
        }
    }
}
