//! The Taylor series of a motion, and its values.

use pulp::Simd;

use super::coefficient::Coefficient;
use super::kernel::{MAX_ORDER, RECIPROCALS, ROWS, add_product};
use crate::lanes::{Lanes, Mask, Register};
use crate::scalar::Scalar as _;

/// Products of smaller coefficients with others may be zero although none of them is.
const TINY: f64 = 1e-250;

/// The Taylor coefficients of a motion at a point, computed by the generated recurrences.
///
/// The velocity is known to the order of the series, the position to one order more.
#[derive(Clone, Debug, PartialEq)]
pub struct Series<const N: usize, T = f64> {
    /// The order of the velocity, `2..=MAX_ORDER`.
    order: usize,
    /// The time of the point of expansion.
    t: T,
    /// `q^(k)/k!` by order.
    q: [[T; N]; ROWS],
    /// `v^(k)/k!` by order.
    v: [[T; N]; ROWS],
}

impl<const N: usize, T: Coefficient> Series<N, T> {
    /// A series whose velocity will be known to `order`, between 2 and [`MAX_ORDER`].
    #[must_use]
    pub fn new(order: usize) -> Self {
        Self {
            order: order.clamp(2, MAX_ORDER),
            t: T::splat(0.0),
            q: [[T::splat(0.0); N]; ROWS],
            v: [[T::splat(0.0); N]; ROWS],
        }
    }

    /// Sets the order of the velocity.
    #[inline]
    pub(super) fn set_order(&mut self, order: usize) {
        self.order = order.clamp(2, MAX_ORDER);
    }

    /// Sets what the acceleration of order 0 is expected to be.
    #[doc(hidden)]
    pub fn expect(&mut self, a: &[T; N]) {
        self.v[1] = *a;
    }

    /// What the acceleration of order 0 is expected to be, for systems that look for it.
    #[doc(hidden)]
    #[must_use]
    pub fn guess(&self) -> [T; N] {
        self.v[1].map(|a| {
            T::of_tracks(|track| {
                let a = a.track(track);
                if a.is_finite() { a } else { 0.0 }
            })
        })
    }

    /// The order of the velocity.
    #[inline]
    #[must_use]
    pub fn order(&self) -> usize {
        // as it is already: so the compiler knows, too, and rows of a table need no check
        self.order.min(MAX_ORDER)
    }

    /// Sets the point of expansion.
    #[doc(hidden)]
    pub fn begin(&mut self, t: T, q: &[T; N], v: &[T; N]) {
        (self.t, self.q[0], self.v[0]) = (t, *q, *v);
    }

    /// The time of the point of expansion.
    #[inline]
    #[must_use]
    pub fn time(&self) -> T {
        self.t
    }

    /// The point of expansion.
    #[inline]
    #[must_use]
    pub fn start(&self) -> ([T; N], [T; N]) {
        (self.q[0], self.v[0])
    }

    /// The coefficients of the position, by order.
    #[must_use]
    pub fn position(&self) -> &[[T; N]] {
        &self.q[..self.order.min(MAX_ORDER) + 2]
    }

    /// The coefficients of the velocity, by order.
    #[must_use]
    pub fn velocity(&self) -> &[[T; N]] {
        &self.v[..=self.order.min(MAX_ORDER)]
    }

    /// Takes the acceleration of order `k`, and moves the position and the velocity from order `k` to the next.
    #[doc(hidden)]
    #[inline(always)]
    pub fn push(&mut self, k: usize, q: &mut [T; N], v: &mut [T; N], a: [T; N]) {
        let next = (k + 1).min(MAX_ORDER);
        let scale = T::splat(RECIPROCALS[next]);
        for i in 0..N {
            q[i] = v[i] * scale;
            v[i] = a[i] * scale;
        }
        self.q[next] = *q;
        self.v[next] = *v;
        if next == self.order {
            let mut beyond = [T::splat(0.0); N];
            for i in 0..N {
                beyond[i] = v[i] * T::splat(RECIPROCALS[next + 1]);
            }
            self.q[next + 1] = beyond;
        }
    }

    /// How far the position and the velocity move in a time `h`, and the acceleration then.
    #[inline(always)]
    pub(super) fn increments<const FUSED: bool>(&self, h: T) -> [[T; N]; 3] {
        let (mut q, mut v, mut a) = ([T::splat(0.0); N], [T::splat(0.0); N], [T::splat(0.0); N]);
        for row in self.position()[1..].iter().rev() {
            for i in 0..N {
                q[i] = add_product::<FUSED, T>(row[i], q[i], h);
            }
        }
        for row in self.velocity()[1..].iter().rev() {
            for i in 0..N {
                // a is the derivative of h v: what v was, and h times its own derivative
                a[i] = add_product::<FUSED, T>(v[i], a[i], h);
                v[i] = add_product::<FUSED, T>(row[i], v[i], h);
            }
        }
        let mut end = a;
        for i in 0..N {
            end[i] = add_product::<FUSED, T>(v[i], a[i], h);
        }
        for i in 0..N {
            (q[i], v[i]) = (q[i] * h, v[i] * h);
        }
        [q, v, end]
    }
}

impl<const N: usize, R: Register> Series<N, Lanes<R>> {
    /// Keeps the coefficients of order `k` only in some lanes: of the velocity, and of the position.
    #[inline(always)]
    pub(super) fn cut(&mut self, k: usize, velocity: Mask<R>, position: Mask<R>) {
        let zero = Lanes::splat(0.0);
        for (rows, within) in [(&mut self.v, velocity), (&mut self.q, position)] {
            for x in &mut rows[k] {
                *x = within.select(*x, zero);
            }
        }
    }

    /// The series of one lane, to the order that is set; those of higher orders are zero.
    pub(super) fn lane(&self, lane: usize, series: &mut Series<N>) {
        let last = series.order();
        series.t = self.t.lane(lane);
        for k in 0..=last + 1 {
            series.q[k] = self.q[k].map(|q| q.lane(lane));
            series.v[k] = self.v[k].map(|v| v.lane(lane));
        }
    }

    /// Takes a series into one lane.
    pub(super) fn set_lane(&mut self, lane: usize, series: &Series<N>) {
        self.make_room(series.order());
        self.t.set_lane(lane, series.t);
        for k in 0..=self.order + 1 {
            for i in 0..N {
                let [q, v] = [
                    if k <= series.order + 1 {
                        series.q[k][i]
                    } else {
                        0.0
                    },
                    if k <= series.order { series.v[k][i] } else { 0.0 },
                ];
                self.q[k][i].set_lane(lane, q);
                self.v[k][i].set_lane(lane, v);
            }
        }
    }

    /// Takes one lane of other series.
    pub(super) fn copy_lane(&mut self, lane: usize, other: &Self) {
        let mut series = Series::new(other.order);
        other.lane(lane, &mut series);
        self.set_lane(lane, &series);
    }

    /// Raises the order, if it is lower.
    fn make_room(&mut self, order: usize) {
        if order > self.order {
            let zero = [Lanes::splat(0.0); N];
            self.v[self.order + 1..=order + 1].fill(zero);
            self.q[self.order + 2..=order + 1].fill(zero);
            self.order = order;
        }
    }
}

impl<const N: usize> Series<N> {
    /// Sets the coefficient of order `k` of the velocity.
    pub(super) fn set_velocity(&mut self, k: usize, v: [f64; N]) {
        self.v[k] = v;
    }

    /// Takes the coefficients of a polynomial motion; those of higher orders are zero.
    pub(crate) fn fill(&mut self, position: &[[f64; N]]) {
        let last = position.len().min(self.order + 2);
        self.q[..last].copy_from_slice(&position[..last]);
        self.q[last..].fill([0.0; N]);
        for k in 0..=self.order {
            self.v[k] = self.q[k + 1].map(|q| (k + 1) as f64 * q);
        }
    }

    /// Whether the highest coefficients are in the range of doubles.
    #[inline(always)]
    pub(super) fn is_in_range(&self) -> bool {
        let last = self.order.min(MAX_ORDER);
        largest(&self.v[last]).max(largest(&self.v[last - 1])) >= TINY && self.is_finite()
    }

    /// Whether the highest coefficients are numbers.
    #[inline(always)]
    pub(super) fn is_finite(&self) -> bool {
        let last = self.order.min(MAX_ORDER);
        self.v[last]
            .iter()
            .chain(&self.v[last - 1])
            .all(|x| x.is_finite())
    }

    /// Up to which order the coefficients are in the range of doubles: they are numbers, and not so small that what comes after them may be zero
    /// for this reason alone. Some may be zero.
    pub(super) fn in_range_to(&self) -> usize {
        let is_in_range = |v: &&[f64; N]| {
            let largest = largest(v);
            (largest == 0.0 || largest >= TINY) && v.iter().all(|x| x.is_finite())
        };
        let known = self.velocity().iter().take_while(is_in_range).count();
        known.saturating_sub(1)
    }

    /// Positions, velocities and accelerations at some times after the point of expansion, `[component][time]`.
    ///
    /// Times are put into registers by hand: the compiler puts components into them, and spills.
    #[inline(always)]
    pub(super) fn values<S: Simd, const R: usize>(
        &self,
        simd: S,
        s: &[S::f64s; R],
    ) -> [[[S::f64s; R]; N]; 3] {
        let last = self.order.min(MAX_ORDER);
        let zero = [simd.splat_f64s(0.0); R];
        let mut values = [[zero; N]; 3];
        for i in 0..N {
            let (mut q, mut v, mut a) = ([simd.splat_f64s(self.q[last + 1][i]); R], zero, zero);
            for (position, velocity) in self.q[..=last].iter().zip(&self.v[..=last]).rev() {
                let (position, velocity) = (simd.splat_f64s(position[i]), simd.splat_f64s(velocity[i]));
                for r in 0..R {
                    q[r] = simd.mul_add_e_f64s(q[r], s[r], position);
                    // the derivative of a polynomial that is formed from within
                    a[r] = simd.mul_add_e_f64s(a[r], s[r], v[r]);
                    v[r] = simd.mul_add_e_f64s(v[r], s[r], velocity);
                }
            }
            (values[0][i], values[1][i], values[2][i]) = (q, v, a);
        }
        values
    }

    /// Position, velocity and acceleration a time `s` after the point of expansion.
    pub(crate) fn point(&self, s: f64) -> [[f64; N]; 3] {
        let [q, v, a] = self.increments::<false>(s);
        let add = |x: &[f64; N], d: [f64; N]| core::array::from_fn(|i| x[i] + d[i]);
        [add(&self.q[0], q), add(&self.v[0], v), a]
    }
}

/// The largest size of a component.
#[inline(always)]
fn largest<const N: usize>(x: &[f64; N]) -> f64 {
    x.iter().fold(0.0, |largest, x| largest.max(x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_increments_are_those_of_the_polynomial() {
        // the motion q = exp(t) in one coordinate: every coefficient 1/k!
        let mut series = Series::<1>::new(24);
        series.begin(0.0, &[1.0], &[1.0]);
        let ([mut q], [mut v]) = series.start();
        for k in 0..24 {
            let (mut whole, mut rate) = ([q], [v]);
            let a = v; // q'' = q'
            series.push(k, &mut whole, &mut rate, [a]);
            ([q], [v]) = (whole, rate);
        }
        let [q, v, a] = series.point(0.75);
        let exact = 0.75_f64.exp();
        for value in [q[0], v[0], a[0]] {
            assert!((value - exact).abs() < 1e-15, "{value}");
        }
        let times = [0.0, 0.25, -0.5, 1.0];
        for value in series.values(pulp::Scalar, &times) {
            for (value, t) in value[0].iter().zip(&times) {
                assert!((value - t.exp()).abs() < 1e-15, "{value:?}");
            }
        }
    }
}
