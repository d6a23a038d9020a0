//! The motion about a time as a Taylor polynomial.

use super::map::Triple;
use crate::number::point::{AnyPoint, OwnedLeg, OwnedPoint};
use crate::solve::rotation;

/// The Taylor polynomial of the continuous motion about a time.
///
/// The nodes of a triple are computed as sums of terms and not as differences of rounded positions, so their differences have all digits.
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion {
    /// The time of the centre, in s.
    pub t: f64,
    /// The Taylor coefficients of the position by order, from the position itself on: each has one component for each coordinate.
    pub coefficients: Vec<Vec<f64>>,
    /// The first places of rotations among the coordinates, each with the four components of its quaternion
    /// ([`Shape::rotations`](crate::Shape::rotations)).
    pub rotations: Vec<usize>,
    /// The time before and after the centre for which the polynomial is accurate, in s.
    pub reach: f64,
}

impl Expansion {
    /// The number of coordinates.
    fn dimension(&self) -> usize {
        self.coefficients.first().map_or(0, Vec::len)
    }

    /// Position, velocity and acceleration at the time `s` after the centre; for a rotation the angular
    /// velocity and acceleration in the frame of its body, behind a zero.
    #[must_use]
    pub fn point(&self, s: f64) -> OwnedPoint<f64> {
        let zero = || vec![0.0; self.dimension()];
        let [mut q, mut v, mut a] = [zero(), zero(), zero()];
        for (k, coefficient) in self.coefficients.iter().enumerate().rev() {
            let k = k as f64;
            for (i, c) in coefficient.iter().enumerate() {
                q[i] = q[i] * s + c;
                if k > 0.0 {
                    v[i] = v[i] * s + k * c;
                }
                if k > 1.0 {
                    a[i] = a[i] * s + k * (k - 1.0) * c;
                }
            }
        }
        let [v, a] = [v, a].map(|rates| rotation::body(&self.rotations, &q, &rates));
        let (t, q, v, a) = (self.t + s, &q, &v, &a);
        AnyPoint { t, q, v, a }.to_owned()
    }

    /// The sum of the terms from the first order on, each times a factor that depends on its order.
    fn sum(&self, factor: &dyn Fn(usize) -> f64) -> Vec<f64> {
        let mut sum = vec![0.0; self.dimension()];
        // the smallest first
        for (k, coefficient) in self.coefficients.iter().enumerate().skip(1).rev() {
            let factor = factor(k);
            for (sum, c) in sum.iter_mut().zip(coefficient) {
                *sum += c * factor;
            }
        }
        sum
    }

    /// The increment of the position from the centre to a time `s` after it.
    #[must_use]
    pub fn increment(&self, s: f64) -> Vec<f64> {
        let mut d = self.sum(&|k| power(s, k));
        let mut low = vec![0.0; d.len()];
        rotation::from_changes(&self.rotations, &self.centre(), [&mut d, &mut low]);
        d
    }

    /// The position at the centre.
    fn centre(&self) -> Vec<f64> {
        self.coefficients.first().cloned().unwrap_or_default()
    }

    /// The nodes `q(t − h)`, `q(t)` and `q(t + h)` about the centre `t`.
    #[must_use]
    pub fn triple(&self, h: f64) -> Triple {
        let q = self.centre();
        let even = self.sum(&|k| if k % 2 == 0 { power(h, k) } else { 0.0 });
        let odd = self.sum(&|k| if k % 2 == 0 { 0.0 } else { power(h, k) });
        let mut d = self.sum(&|k| if k % 2 == 0 { -power(h, k) } else { power(h, k) });
        let mut e: Vec<f64> = even.iter().map(|even| 2.0 * even).collect();
        rotation::about(&self.rotations, &q, [&even, &odd], [&mut d, &mut e]);
        Triple {
            leg: OwnedLeg { t: self.t, q, d },
            e,
        }
    }
}

/// A power of a time.
fn power(s: f64, k: usize) -> f64 {
    s.powi(i32::try_from(k).unwrap_or(i32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_and_points_are_those_of_the_polynomial() {
        // q = 1 + 2 s − 3 s² + s³/2
        let motion = Expansion {
            t: 5.0,
            coefficients: [1.0, 2.0, -3.0, 0.5].map(|c| vec![c]).to_vec(),
            rotations: Vec::new(),
            reach: 1.0,
        };
        let at = |s: f64| 1.0 + s * (2.0 + s * (-3.0 + s * 0.5));
        let point = motion.point(0.25);
        let AnyPoint { t, q, v, a } = point.any();
        assert_eq!(
            [t, q[0], v[0], a[0]],
            [5.25, at(0.25), 2.0 - 1.5 + 0.09375, -6.0 + 0.75]
        );
        let [q0, q1, q2] = motion.triple(0.25).nodes();
        assert_eq!([q0[0], q1[0], q2[0]], [at(-0.25), 1.0, at(0.25)]);
        assert_eq!(motion.increment(0.25), [at(0.25) - 1.0]);
    }
}
