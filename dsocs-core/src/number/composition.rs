//! The composition methods: the fractions of a step, and their sources.

#![allow(clippy::excessive_precision)] // fractions as they are printed

use core::fmt;

/// A symmetric composition of steps: a step `h` consists of stages of the lengths `γ₁ h, γ₂ h, … γ₂ h, γ₁ h`.
///
/// If a step is symmetric in time and of order 2, the composition is of order 4, 6 or 8 under these conditions: the sum of the fractions is 1, and
/// the sum of their third powers vanishes (for higher orders also those of the fifth and seventh powers, and some more sums). This requires negative
/// fractions, that is, stages that go back in time.
///
/// ```
/// use dsocs_core::Composition;
///
/// let method = Composition::of_order(6).unwrap_or(Composition::SINGLE);
/// assert_eq!((method.order(), method.stages()), (6, 9));
/// assert!((method.fractions().sum::<f64>() - 1.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, PartialEq)]
pub struct Composition {
    /// The name of the method, by its authors.
    name: &'static str,
    /// The order.
    order: u32,
    /// The fractions up to the middle one.
    half: &'static [f64],
}

/// `1/(4 - 4^(1/3))`.
const SUZUKI: f64 = 0.414_490_771_794_375_737_142_354_062_86;

impl Composition {
    /// The step itself, of order 2.
    pub const SINGLE: Self = Self {
        name: "the paper's step",
        order: 2,
        half: &[1.0],
    };

    /// Order 4 in five stages, of which only the middle one goes back in time. M. Suzuki, *Fractal decomposition of exponential operators with
    /// applications to many-body theories and Monte Carlo simulations*, Phys. Lett. A 146 (1990) 319.
    pub const SUZUKI_4: Self = Self {
        name: "Suzuki's composition",
        order: 4,
        half: &[SUZUKI, SUZUKI, 1.0 - 4.0 * SUZUKI],
    };

    /// Order 6 in nine stages. W. Kahan, R.-C. Li, *Composition constants for raising the orders of unconventional schemes for
    /// ordinary differential equations*, Math. Comp. 66 (1997) 1089.
    pub const KAHAN_LI_6: Self = Self {
        name: "Kahan and Li's composition",
        order: 6,
        half: &[
            0.392_161_444_007_314_139_279_250_56,
            0.332_599_136_789_359_438_599_748_64,
            -0.706_246_172_557_639_359_809_964_82,
            0.082_213_596_293_550_800_231_490_45,
            0.798_543_990_934_829_963_398_950_35,
        ],
    };

    /// Order 8 in seventeen stages, from the same paper as [`Composition::KAHAN_LI_6`].
    pub const KAHAN_LI_8: Self = Self {
        name: "Kahan and Li's composition",
        order: 8,
        half: &[
            0.130_202_483_088_890_080_878_817_63,
            0.561_162_981_775_108_384_564_419_68,
            -0.389_474_962_644_847_286_408_078_60,
            0.158_841_906_555_155_600_896_210_75,
            -0.395_903_894_133_237_577_336_231_54,
            0.184_539_640_978_315_707_091_832_54,
            0.258_374_387_686_322_047_293_979_11,
            0.295_011_723_609_310_298_870_966_24,
            -0.605_508_533_830_034_511_698_921_08,
        ],
    };

    /// The method of an order: 2, 4, 6 or 8.
    #[must_use]
    pub fn of_order(order: u32) -> Option<Self> {
        [Self::SINGLE, Self::SUZUKI_4, Self::KAHAN_LI_6, Self::KAHAN_LI_8]
            .into_iter()
            .find(|method| method.order == order)
    }

    /// The order.
    #[must_use]
    pub fn order(self) -> u32 {
        self.order
    }

    /// The number of stages of a step.
    #[must_use]
    pub fn stages(self) -> usize {
        2 * self.half.len() - 1
    }

    /// The fractions of the step, in order; a stage with a negative fraction goes back in time.
    pub fn fractions(self) -> impl Iterator<Item = f64> {
        let back = self.half.iter().rev().skip(1);
        self.half.iter().chain(back).copied()
    }
}

impl fmt::Display for Composition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of order {}", self.name, self.order)
    }
}

impl fmt::Debug for Composition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Composition")
            .field("order", &self.order)
            .field("stages", &self.stages())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of the powers of the fractions.
    fn power_sum(method: Composition, exponent: i32) -> f64 {
        method.fractions().map(|fraction| fraction.powi(exponent)).sum()
    }

    #[test]
    fn the_fractions_fulfil_the_order_conditions() {
        for (order, stages) in [(2, 1), (4, 5), (6, 9), (8, 17)] {
            let method = Composition::of_order(order).unwrap();
            assert_eq!((method.order(), method.stages()), (order, stages));
            assert!((power_sum(method, 1) - 1.0).abs() < 3e-16);
            for exponent in (3..i32::try_from(order).unwrap()).step_by(2) {
                let sum = power_sum(method, exponent);
                assert!(sum.abs() < 3e-16, "order {order}, exponent {exponent}: {sum:e}");
            }
            // and no further one, so that the order is not higher
            let next = power_sum(method, i32::try_from(order + 1).unwrap());
            assert!(next.abs() > 1e-4, "order {order}: {next:e}");
            let fractions: Vec<f64> = method.fractions().collect();
            let mut back = fractions.clone();
            back.reverse();
            assert_eq!(fractions, back);
            assert!(fractions.iter().all(|fraction| fraction.abs() <= 1.0));
        }
        assert!(Composition::of_order(3).is_none());
    }

    #[test]
    fn suzukis_fraction_is_his() {
        assert!((SUZUKI - 1.0 / (4.0 - 4.0_f64.cbrt())).abs() < 1e-16);
    }
}
