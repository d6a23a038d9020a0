//! The Taylor series of a motion, and its values.

use crate::number::largest;
use pulp::Simd;

use super::coefficient::Coefficient;
use super::orders::{MAX_ORDER, RECIPROCALS, ROWS};
use crate::number::lanes::{Lanes, Mask, Register};
use crate::number::scalar::Scalar as _;
use crate::series::sums::add_product;
use crate::solve::rotation;

/// Signs as the digits of one number: two numbers differ if a sign does. Beyond the digits of a number, places are
/// used again.
#[inline(always)]
pub(crate) fn number_of_signs<T: Coefficient>(signs: impl Iterator<Item = T>) -> T {
    const DIGITS: usize = 48;
    let mut number = T::splat(0.0);
    for (place, sign) in signs.enumerate() {
        let unit = (1_u64 << (place % DIGITS)) as f64;
        number = number + T::splat(unit) * sign;
    }
    number
}

/// Below this size, products of coefficients may underflow to zero.
const TINY: f64 = 1e-250;

/// The Taylor coefficients of a motion at a point, computed by the generated recurrences, for any number of coordinates.
///
/// The velocity is known to the order of the series, the position to one order more.
#[derive(Clone, Debug, PartialEq)]
pub struct Series<T = f64> {
    /// The order of the velocity, `2..=MAX_ORDER`.
    order: usize,
    /// The number of coordinates, which is the length of a row in the tables.
    dimension: usize,
    /// The time of the point of expansion.
    t: T,
    /// See [`Series::signs`].
    signs: T,
    /// `q^(k)/k!` by order, [`ROWS`] rows.
    q: Box<[T]>,
    /// `v^(k)/k!` by order, [`ROWS`] rows.
    v: Box<[T]>,
}

/// A [`Series`] as arrays, for the recurrences.
#[derive(Debug)]
pub struct Rows<'c, const N: usize, T = f64> {
    /// The order of the velocity.
    order: usize,
    /// The time of the point of expansion.
    t: T,
    /// See [`Series::signs`].
    signs: &'c mut T,
    /// The position by order.
    q: &'c mut [[T; N]; ROWS],
    /// The velocity by order.
    v: &'c mut [[T; N]; ROWS],
}

/// The rows of a table as arrays of `N` numbers.
#[inline(always)]
fn sized<T, const N: usize>(table: &[T], dimension: usize) -> &[[T; N]] {
    if dimension == N { table.as_chunks().0 } else { &[] }
}

impl<T: Coefficient> Series<T> {
    /// A series of `dimension` coordinates whose velocity has the order `order`, between 2 and [`MAX_ORDER`].
    #[must_use]
    pub fn new(dimension: usize, order: usize) -> Self {
        let table = || vec![T::splat(0.0); ROWS * dimension].into_boxed_slice();
        Self {
            order: order.clamp(2, MAX_ORDER),
            dimension,
            t: T::splat(0.0),
            signs: T::splat(0.0),
            q: table(),
            v: table(),
        }
    }

    /// Sets the order of the velocity.
    #[inline]
    pub(crate) fn set_order(&mut self, order: usize) {
        self.order = order.clamp(2, MAX_ORDER);
    }

    /// The number of coordinates.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// The series as arrays; `None` for another number of coordinates.
    #[doc(hidden)]
    #[inline(always)]
    pub fn rows<const N: usize>(&mut self) -> Option<Rows<'_, N, T>> {
        let (q, v) = (self.q.as_chunks_mut().0, self.v.as_chunks_mut().0);
        Some(Rows {
            order: self.order.min(MAX_ORDER),
            t: self.t,
            signs: &mut self.signs,
            q: q.try_into().ok()?,
            v: v.try_into().ok()?,
        })
    }

    /// Sets the expected acceleration of order 0.
    #[doc(hidden)]
    pub fn expect(&mut self, a: &[T]) {
        self.v[self.dimension..2 * self.dimension].copy_from_slice(a);
    }

    /// The order of the velocity.
    #[inline]
    #[must_use]
    pub fn order(&self) -> usize {
        // it is never larger: this tells the compiler, so that rows of a table need no bounds check
        self.order.min(MAX_ORDER)
    }

    /// Sets the point of expansion.
    #[doc(hidden)]
    #[inline]
    pub fn begin(&mut self, t: T, q: &[T], v: &[T]) {
        self.t = t;
        self.q[..self.dimension].copy_from_slice(q);
        self.v[..self.dimension].copy_from_slice(v);
    }

    /// The time of the point of expansion.
    #[inline]
    #[must_use]
    pub fn time(&self) -> T {
        self.t
    }

    /// The signs, at the point of expansion, of the determinant of the equations for the accelerations and of
    /// the divisors that may vanish, as one number: two numbers differ if a sign does.
    #[inline]
    pub(crate) fn signs(&self) -> T {
        self.signs
    }

    /// Sets the number of these signs.
    #[inline]
    pub(crate) fn set_signs(&mut self, signs: T) {
        self.signs = signs;
    }

    /// Moves the point of expansion to the time `s` later; the polynomials stay the same.
    pub(crate) fn begin_later(&mut self, s: T) {
        let (n, order) = (self.dimension, self.order());
        self.t = self.t + s;
        for (table, degree) in [(&mut self.q, order + 1), (&mut self.v, order)] {
            for first in 0..degree {
                for k in (first..degree).rev() {
                    for i in 0..n {
                        table[k * n + i] = table[k * n + i] + s * table[(k + 1) * n + i];
                    }
                }
            }
        }
    }

    /// Sets the time of the point of expansion.
    #[inline]
    pub(crate) fn set_time(&mut self, t: T) {
        self.t = t;
    }

    /// The velocity by order, with unknown orders; `None` for another number of coordinates.
    #[inline]
    pub(crate) fn velocity_table<const N: usize>(&self) -> Option<&[[T; N]; ROWS]> {
        self.v.as_chunks().0.try_into().ok()
    }

    /// The velocity by order, mutable; `None` for another number of coordinates.
    #[inline]
    pub(crate) fn velocity_table_mut<const N: usize>(&mut self) -> Option<&mut [[T; N]; ROWS]> {
        self.v.as_chunks_mut().0.try_into().ok()
    }

    /// The coefficients of the position, by order, mutable.
    #[inline]
    pub(crate) fn position_table_mut<const N: usize>(&mut self) -> &mut [[T; N]] {
        self.q.as_chunks_mut().0
    }

    /// Position and velocity at the point of expansion.
    #[inline]
    #[must_use]
    pub fn start(&self) -> (&[T], &[T]) {
        (&self.q[..self.dimension], &self.v[..self.dimension])
    }

    /// The coefficients of the velocity of one order.
    #[inline]
    #[must_use]
    pub fn velocity_of(&self, k: usize) -> &[T] {
        &self.v[k * self.dimension..(k + 1) * self.dimension]
    }

    /// The coefficients of the position of one order.
    #[inline]
    #[must_use]
    pub fn position_of(&self, k: usize) -> &[T] {
        &self.q[k * self.dimension..(k + 1) * self.dimension]
    }

    /// The coefficients of position and velocity by order, mutable: one for each coordinate.
    #[inline(always)]
    pub(crate) fn tables_mut(&mut self) -> [&mut [T]; 2] {
        [&mut self.q, &mut self.v]
    }

    /// The coefficients of the velocity of one order, mutable.
    #[inline]
    pub(crate) fn velocity_mut(&mut self, k: usize) -> &mut [T] {
        &mut self.v[k * self.dimension..(k + 1) * self.dimension]
    }

    /// The coefficients of the position of all orders, one order after the other, each with one number for each coordinate.
    #[inline]
    #[must_use]
    pub fn positions(&self) -> &[T] {
        &self.q[..(self.order() + 2) * self.dimension]
    }

    /// The coefficients of the velocity of all orders, one order after the other.
    #[inline]
    pub(crate) fn velocities(&self) -> &[T] {
        &self.v[..(self.order() + 1) * self.dimension]
    }

    /// The coefficients of the position, by order; empty for another number of coordinates.
    #[must_use]
    pub fn position<const N: usize>(&self) -> &[[T; N]] {
        sized(self.positions(), self.dimension)
    }

    /// The coefficients of the velocity, by order; empty for another number of coordinates.
    #[must_use]
    pub fn velocity<const N: usize>(&self) -> &[[T; N]] {
        sized(self.velocities(), self.dimension)
    }

    /// The increments of position and velocity in a time `h`, and the acceleration at its end.
    #[inline(always)]
    pub(crate) fn increments_of<const FUSED: bool, const N: usize>(&self, h: T) -> [[T; N]; 3] {
        let (mut q, mut v, mut a) = ([T::splat(0.0); N], [T::splat(0.0); N], [T::splat(0.0); N]);
        for row in self.position::<N>().get(1..).unwrap_or_default().iter().rev() {
            for i in 0..N {
                q[i] = add_product::<FUSED, T>(row[i], q[i], h);
            }
        }
        for row in self.velocity::<N>().get(1..).unwrap_or_default().iter().rev() {
            for i in 0..N {
                // a is the derivative of h v: v plus h times its own derivative
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

impl<const N: usize, T: Coefficient> Rows<'_, N, T> {
    /// The order of the velocity.
    #[inline(always)]
    #[must_use]
    pub fn order(&self) -> usize {
        self.order.min(MAX_ORDER)
    }

    /// The time of the point of expansion.
    #[inline(always)]
    #[must_use]
    pub fn time(&self) -> T {
        self.t
    }

    /// Sets the point of expansion, and the expected acceleration of order 0.
    #[inline(always)]
    pub(crate) fn begin(&mut self, q: &[T; N], v: &[T; N], a: &[T; N]) {
        (self.q[0], self.v[0], self.v[1]) = (*q, *v, *a);
    }

    /// The velocity by order, with unknown orders.
    #[inline(always)]
    pub(crate) fn velocities(&self) -> &[[T; N]; ROWS] {
        self.v
    }

    /// The point of expansion.
    #[inline(always)]
    #[must_use]
    pub fn start(&self) -> ([T; N], [T; N]) {
        (self.q[0], self.v[0])
    }

    /// The expected acceleration of order 0, for systems that solve for it; 0 in place of NaN.
    #[must_use]
    pub fn guess(&self) -> [T; N] {
        self.v[1].map(|a| {
            T::of_tracks(|track| {
                let a = a.track(track);
                if a.is_finite() { a } else { 0.0 }
            })
        })
    }

    /// Sets the signs of the determinant and of the divisors, as digits of one number.
    #[inline(always)]
    pub fn set_signs<const M: usize>(&mut self, signs: [T; M]) {
        *self.signs = number_of_signs(signs.into_iter());
    }

    /// Stores the acceleration of order `k`, and advances position and velocity from order `k` to the next.
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
}

impl<const N: usize, T: Coefficient> Rows<'_, N, T> {
    /// [`Rows::push`] for systems with rotations.
    #[inline(always)]
    pub fn push_turning<const FUSED: bool>(
        &mut self,
        k: usize,
        rotations: &[usize],
        q: &mut [T; N],
        v: &mut [T; N],
        a: [T; N],
    ) {
        let next = (k + 1).min(MAX_ORDER);
        self.push(k, q, v, a);
        for &first in rotations {
            self.turn::<FUSED>(next, first);
            let slots = first..first + rotation::SLOTS;
            if let (Some(to), Some(from)) = (q.get_mut(slots.clone()), self.q[next].get(slots)) {
                to.copy_from_slice(from);
            }
            if next == self.order {
                self.turn::<FUSED>(next + 1, first);
            }
        }
    }

    /// Computes the coefficients of order `k` of a rotation, from those of lower orders.
    #[inline(always)]
    fn turn<const FUSED: bool>(&mut self, k: usize, first: usize) {
        let k = k.min(ROWS - 1);
        let slots = |row: &[T; N]| {
            let slots = row.get(first..).and_then(|row| row.first_chunk().copied());
            slots.unwrap_or([T::splat(f64::NAN); rotation::SLOTS])
        };
        let ((ahead, last), (back_last, back)) =
            (self.q[..k].as_chunks::<2>(), self.v[..k].as_rchunks::<2>());
        let next = rotation::Coefficient {
            scale: T::splat(RECIPROCALS[k]),
            pairs: ahead
                .iter()
                .zip(back.iter().rev())
                .map(|(q, v)| [[slots(&q[0]), slots(&v[1])], [slots(&q[1]), slots(&v[0])]]),
            last: last
                .first()
                .zip(back_last.first())
                .map(|(q, v)| [slots(q), slots(v)]),
        };
        let turned = T::on_fours::<FUSED, _>(next);
        for (to, x) in self.q[k].iter_mut().skip(first).zip(turned) {
            *to = x;
        }
    }
}

impl<R: Register> Series<Lanes<R>> {
    /// Sets the coefficients of order `k` to zero in all lanes but those of the masks, of the velocity and of
    /// the position.
    #[inline(always)]
    pub(crate) fn cut(&mut self, k: usize, velocity: Mask<R>, position: Mask<R>) {
        let zero = Lanes::splat(0.0);
        let row = k * self.dimension..(k + 1) * self.dimension;
        for (table, within) in [(&mut self.v, velocity), (&mut self.q, position)] {
            for x in &mut table[row.clone()] {
                *x = within.select(*x, zero);
            }
        }
    }

    /// The series of one lane, to its own order; higher coefficients are zero.
    pub(crate) fn lane(&self, lane: usize, series: &mut Series) {
        let count = (series.order() + 2) * self.dimension;
        series.t = self.t.lane(lane);
        for (one, all) in [(&mut series.q, &self.q), (&mut series.v, &self.v)] {
            for (one, all) in one.iter_mut().zip(all).take(count) {
                *one = all.lane(lane);
            }
        }
    }

    /// Copies a series into one lane.
    pub(crate) fn set_lane(&mut self, lane: usize, series: &Series) {
        self.make_room(series.order());
        self.t.set_lane(lane, series.t);
        let n = self.dimension;
        let all = (self.order + 2) * n;
        let known = [(series.order() + 2) * n, (series.order() + 1) * n];
        let tables = [(&mut self.q, &series.q), (&mut self.v, &series.v)];
        for ((table, one), known) in tables.into_iter().zip(known) {
            let numbers = one.iter().take(known).copied();
            for (to, x) in table
                .iter_mut()
                .zip(numbers.chain(core::iter::repeat(0.0)))
                .take(all)
            {
                to.set_lane(lane, x);
            }
        }
    }

    /// Copies one lane of other series.
    pub(crate) fn copy_lane(&mut self, lane: usize, other: &Self) {
        let mut series = Series::new(other.dimension, other.order);
        other.lane(lane, &mut series);
        self.set_lane(lane, &series);
    }

    /// Raises the order to at least `order`.
    fn make_room(&mut self, order: usize) {
        if order > self.order {
            let (zero, n) = (Lanes::splat(0.0), self.dimension);
            self.v[(self.order + 1) * n..(order + 2) * n].fill(zero);
            self.q[(self.order + 2) * n..(order + 2) * n].fill(zero);
            self.order = order;
        }
    }
}

impl Series {
    /// Allocates for a polynomial motion of `dimension` coordinates, unless there is room.
    pub(crate) fn resize(&mut self, dimension: usize) {
        if dimension != self.dimension {
            *self = Self::new(dimension, self.order);
        }
    }

    /// Sets the first coefficients of one component of a polynomial motion; higher ones are zero.
    pub(crate) fn fill(&mut self, component: usize, position: &[f64]) {
        let (n, last) = (self.dimension, self.order() + 2);
        let coefficients = position.iter().copied().chain(core::iter::repeat(0.0));
        let column = self.q.iter_mut().skip(component).step_by(n.max(1));
        for (k, (q, c)) in column.zip(coefficients).enumerate() {
            *q = if k < last { c } else { 0.0 };
        }
        for k in 0..last - 1 {
            self.v[k * n + component] = (k + 1) as f64 * self.q[(k + 1) * n + component];
        }
    }

    /// Sets the first coefficients of one component of the velocity, if it is not the rate of the position.
    pub(crate) fn fill_velocity(&mut self, component: usize, velocity: &[f64]) {
        let (n, last) = (self.dimension, self.order() + 1);
        let coefficients = velocity.iter().copied().chain(core::iter::repeat(0.0));
        let column = self.v.iter_mut().skip(component).step_by(n.max(1));
        for (k, (v, c)) in column.zip(coefficients).enumerate() {
            *v = if k < last { c } else { 0.0 };
        }
    }

    /// Whether the highest coefficients are in the range of doubles.
    #[inline(always)]
    pub(crate) fn is_in_range(&self) -> bool {
        let last = self.order();
        is_in_range(self.velocity_of(last - 1), self.velocity_of(last))
    }

    /// Whether the highest coefficients are finite.
    #[inline(always)]
    pub(crate) fn is_finite(&self) -> bool {
        let (last, n) = (self.order(), self.dimension);
        self.v[(last - 1) * n..(last + 1) * n]
            .iter()
            .all(|x| x.is_finite())
    }

    /// The order up to which the coefficients are in the range of doubles: finite, and not so small that the
    /// following ones may underflow. Some may be zero.
    pub(crate) fn in_range_to(&self) -> usize {
        let is_in_range = |v: &&[f64]| {
            let largest = largest(v);
            (largest == 0.0 || largest >= TINY) && v.iter().all(|x| x.is_finite())
        };
        let rows = (0..=self.order()).map(|k| self.velocity_of(k));
        rows.take_while(is_in_range).count().saturating_sub(1)
    }

    /// Positions, velocities and accelerations of the component `i` of `n` at some times after the point of expansion.
    ///
    /// Times are put into registers explicitly: the compiler would put components there, and spill.
    #[inline(always)]
    pub(crate) fn values<S: Simd, const R: usize>(
        &self,
        simd: S,
        (i, n): (usize, usize),
        s: &[S::f64s; R],
    ) -> [[S::f64s; R]; 3] {
        let zero = [simd.splat_f64s(0.0); R];
        let (positions, velocities) = (self.positions(), self.velocities());
        let (below, highest) = positions.split_at(positions.len().saturating_sub(n));
        let highest = highest.get(i).copied().unwrap_or(0.0);
        let (mut q, mut v, mut a) = ([simd.splat_f64s(highest); R], zero, zero);
        for (position, velocity) in below.chunks_exact(n).zip(velocities.chunks_exact(n)).rev() {
            let (position, velocity) = (simd.splat_f64s(position[i]), simd.splat_f64s(velocity[i]));
            for r in 0..R {
                q[r] = simd.mul_add_e_f64s(q[r], s[r], position);
                // the derivative by Horner's scheme
                a[r] = simd.mul_add_e_f64s(a[r], s[r], v[r]);
                v[r] = simd.mul_add_e_f64s(v[r], s[r], velocity);
            }
        }
        [q, v, a]
    }

    /// Position, velocity and acceleration at some times after the point of expansion, of as many components as a
    /// register holds: the same sums.
    #[inline(always)]
    pub(crate) fn side_by_side<S: Simd, const R: usize>(
        &self,
        simd: S,
        s: &[S::f64s; R],
    ) -> [[S::f64s; 3]; R] {
        let zero = simd.splat_f64s(0.0);
        let (positions, _) = S::as_simd_f64s(self.positions());
        let (velocities, _) = S::as_simd_f64s(self.velocities());
        let Some((highest, below)) = positions.split_last() else {
            return [[zero; 3]; R];
        };
        let mut values = [[*highest, zero, zero]; R];
        for (position, velocity) in below.iter().zip(velocities).rev() {
            for r in 0..R {
                let [q, v, a] = values[r];
                values[r] = [
                    simd.mul_add_e_f64s(q, s[r], *position),
                    simd.mul_add_e_f64s(v, s[r], *velocity),
                    simd.mul_add_e_f64s(a, s[r], v),
                ];
            }
        }
        values
    }

    /// The increments of position and velocity in a time `s`, and the acceleration at its end.
    pub(crate) fn increments(&self, s: f64, moves: [&mut [f64]; 3]) {
        self.increments_as::<false>(s, moves);
    }

    /// [`Series::increments`], with products and sums rounded once if `FUSED`.
    #[inline(always)]
    pub(crate) fn increments_as<const FUSED: bool>(&self, s: f64, moves: [&mut [f64]; 3]) {
        match self.dimension {
            // few components stay in registers
            1 => self.few_increments::<FUSED, 1>(s, moves),
            2 => self.few_increments::<FUSED, 2>(s, moves),
            3 => self.few_increments::<FUSED, 3>(s, moves),
            4 => self.few_increments::<FUSED, 4>(s, moves),
            n => self.many_increments::<FUSED>(n.max(1), s, moves),
        }
    }

    /// [`Series::increments_as`] for `N` components.
    #[inline(always)]
    fn few_increments<const FUSED: bool, const N: usize>(&self, s: f64, moves: [&mut [f64]; 3]) {
        let increments = self.increments_of::<FUSED, N>(s);
        for (to, from) in moves.into_iter().zip(&increments) {
            for (to, from) in to.iter_mut().zip(from) {
                *to = *from;
            }
        }
    }

    /// [`Series::increments_as`] for any number of components.
    #[inline(always)]
    fn many_increments<const FUSED: bool>(&self, n: usize, s: f64, [q, v, a]: [&mut [f64]; 3]) {
        let add = |sum: f64, x: f64| add_product::<FUSED, f64>(sum, x, s);
        let beyond = |table: &'_ [f64]| table.len().min(n);
        let (positions, velocities) = (self.positions(), self.velocities());
        for x in [&mut *q, &mut *v, &mut *a] {
            x.fill(0.0);
        }
        for row in positions[beyond(positions)..].chunks_exact(n).rev() {
            for (q, row) in q.iter_mut().zip(row) {
                *q = add(*row, *q);
            }
        }
        for row in velocities[beyond(velocities)..].chunks_exact(n).rev() {
            for ((a, v), row) in a.iter_mut().zip(&mut *v).zip(row) {
                *a = add(*v, *a);
                *v = add(*row, *v);
            }
        }
        for ((q, v), a) in q.iter_mut().zip(v).zip(a) {
            *a = add(*v, *a);
            (*q, *v) = (*q * s, *v * s);
        }
    }

    /// Position, velocity and acceleration at the time `s` after the point of expansion.
    pub(crate) fn point(&self, s: f64, moves: [&mut [f64]; 3]) {
        match self.dimension {
            1 => self.few_points::<1>(s, moves),
            2 => self.few_points::<2>(s, moves),
            3 => self.few_points::<3>(s, moves),
            4 => self.few_points::<4>(s, moves),
            n => {
                let [q, v, a] = moves;
                self.many_increments::<false>(n.max(1), s, [&mut *q, &mut *v, a]);
                for ((q, v), (start, rate)) in q.iter_mut().zip(v).zip(self.q.iter().zip(&self.v)) {
                    (*q, *v) = (start + *q, rate + *v);
                }
            }
        }
    }

    /// [`Series::point`] for `N` components.
    #[inline(always)]
    fn few_points<const N: usize>(&self, s: f64, moves: [&mut [f64]; 3]) {
        let [mut q, mut v, a] = self.increments_of::<false, N>(s);
        if let (Some(start), Some(rate)) = (self.q.first_chunk::<N>(), self.v.first_chunk::<N>()) {
            for i in 0..N {
                (q[i], v[i]) = (start[i] + q[i], rate[i] + v[i]);
            }
        }
        for (to, from) in moves.into_iter().zip([q, v, a]) {
            if let Some(to) = to.first_chunk_mut() {
                *to = from;
            }
        }
    }
}

/// Whether the last two coefficients are finite, and not so small that their products may underflow.
#[inline(always)]
pub(crate) fn is_in_range(before: &[f64], last: &[f64]) -> bool {
    let mut is_finite = true;
    for (before, last) in before.iter().zip(last) {
        is_finite &= before.is_finite() & last.is_finite();
    }
    largest(last).max(largest(before)) >= TINY && is_finite
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_increments_are_those_of_the_polynomial() {
        // the motion q = exp(t) in one coordinate: every coefficient 1/k!
        let mut series = Series::new(1, 24);
        series.begin(0.0, &[1.0], &[1.0]);
        let mut rows = series.rows::<1>().unwrap();
        let ([mut q], [mut v]) = rows.start();
        for k in 0..24 {
            let (mut whole, mut rate) = ([q], [v]);
            let a = v; // q'' = q'
            rows.push(k, &mut whole, &mut rate, [a]);
            ([q], [v]) = (whole, rate);
        }
        let [mut q, mut v, mut a] = [[0.0]; 3];
        series.point(0.75, [&mut q, &mut v, &mut a]);
        let exact = 0.75_f64.exp();
        for value in [q[0], v[0], a[0]] {
            assert!((value - exact).abs() < 1e-15, "{value}");
        }
        let times = [0.0, 0.25, -0.5, 1.0];
        for value in series.values(pulp::Scalar, (0, 1), &times) {
            for (value, t) in value.iter().zip(&times) {
                assert!((value - t.exp()).abs() < 1e-15, "{value:?}");
            }
        }
    }
}
