//! Linear equations of which most coefficients are zero: elimination in an order that is chosen in advance.
//!
//! A row of a chain depends on its neighbours alone. Then few of the `M²` entries of the Jacobian are
//! nonzero, and elimination in a good order adds few more. The attribute knows the entries and chooses the
//! order (`passes/sparse.rs` of `dsocs-macros`). From both, [`Plan`] derives once per process which entry
//! changes which. Time and memory of an update are then proportional to the number of entries.
//!
//! The order does not depend on numbers, so a pivot may turn out small, or zero. Every solution is therefore
//! put into the equations. If a residual is larger than rounding, measured by the terms of its row, the
//! solution is discarded, and the dense matrix is solved with pivoting. (Li and Demmel, "Making sparse
//! Gaussian elimination scalable by static pivoting", 1998. The criterion is Oettli and Prager's
//! componentwise backward error, Higham, *Accuracy and Stability of Numerical Algorithms*, theorem 7.3.)

use core::cell::Cell;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::OnceLock;

use super::elimination::Determinant;
use super::unknown::Unknown;
use crate::number::instructions::Chosen;
use crate::number::lanes::Lanes;
use crate::number::scalar::Scalar;

/// Largest residual of a row, in units of the sum of its terms: some hundred roundings.
const LEFT: f64 = 256.0 * f64::EPSILON;

/// The entries of a sparse matrix, and the order in which they are eliminated.
#[derive(Clone, Debug)]
pub struct Sparse {
    /// The number of rows and columns.
    size: usize,
    /// Row and column of each entry.
    entries: Cow<'static, [[u16; 2]]>,
    /// Row and column of each pivot, in order.
    pivots: Cow<'static, [[u16; 2]]>,
    plan: OnceLock<Plan>,
}

/// The operations of an elimination, in order.
///
/// Entries, including the fill-in, stand in *slots*, pivot by pivot: the pivot, the entries right of it in
/// its row, the entries below it in its column.
#[derive(Clone, Debug, Default)]
struct Plan {
    /// The slot of each entry.
    slots: Vec<u32>,
    /// The number of slots.
    count: usize,
    pivots: Vec<Pivot>,
    /// For each pivot the columns of the entries right of it; then, for each entry below it, the row and the slots that are
    /// changed there, counted from the pivot's last slot.
    indices: Vec<u32>,
    /// Whether the order of the pivots is an odd permutation.
    odd: bool,
}

/// A pivot.
#[derive(Clone, Copy, Debug)]
struct Pivot {
    row: u32,
    column: u32,
    /// Number of entries right of it.
    right: u32,
    /// Number of entries below it.
    below: u32,
}

/// The rows and an update.
pub(crate) struct Update<U> {
    /// The rows.
    pub rows: U,
    /// Newton's update; NaN in lanes where it is inaccurate.
    pub update: U,
}

impl Sparse {
    /// A matrix of `size` rows with entries at some rows and columns, and the pivots in their order.
    #[must_use]
    pub const fn new(size: usize, entries: &'static [[u16; 2]], pivots: &'static [[u16; 2]]) -> Self {
        Self {
            size,
            entries: Cow::Borrowed(entries),
            pivots: Cow::Borrowed(pivots),
            plan: OnceLock::new(),
        }
    }

    /// A matrix with entries and pivots that are known at run time. `None` unless all entries lie in the
    /// matrix, each once, and there is one pivot in each row and each column.
    #[must_use]
    pub fn owned(size: usize, entries: Vec<[u16; 2]>, pivots: Vec<[u16; 2]>) -> Option<Self> {
        let is_inside = |place: &[u16; 2]| place.iter().all(|&side| usize::from(side) < size);
        let different: BTreeSet<_> = entries.iter().copied().collect();
        let covers = |side: usize| {
            let lines: BTreeSet<u16> = pivots.iter().map(|pivot| pivot[side]).collect();
            lines.len() == size
        };
        let good = entries.iter().chain(&pivots).all(is_inside)
            && different.len() == entries.len()
            && pivots.len() == size
            && covers(0)
            && covers(1);
        good.then(|| Self {
            size,
            entries: Cow::Owned(entries),
            pivots: Cow::Owned(pivots),
            plan: OnceLock::new(),
        })
    }

    /// The number of rows and columns.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    /// Row and column of each entry.
    pub(crate) fn places(&self) -> &[[u16; 2]] {
        &self.entries
    }

    /// The dense matrix with the given values of the entries.
    #[must_use]
    pub fn dense<T: Scalar, U: Unknown<T>>(&self, entries: &[T]) -> U::Square {
        let mut matrix = U::zeros();
        for (&[row, column], &entry) in self.entries.iter().zip(entries) {
            matrix.as_mut()[usize::from(row)].as_mut()[usize::from(column)] = entry;
        }
        matrix
    }

    /// Newton's update `-J⁻¹ r`. `evaluate` computes the rows `r` and the entries of their Jacobian `J`.
    /// `pivot` receives every pivot, in order; their product is the determinant, up to its sign
    /// ([`Sparse::is_odd`]).
    #[inline]
    pub(crate) fn update<T: ThreadWorkspace, U: Clone + AsRef<[T]> + AsMut<[T]>>(
        &self,
        evaluate: impl FnOnce(&mut [T]) -> U,
        pivot: impl FnMut(T),
    ) -> Update<U> {
        let plan = self.plan();
        T::with_workspace(self.entries.len() + plan.count, |room| {
            let (entries, factors) = room.split_at_mut(self.entries.len());
            let rows = evaluate(entries);
            let solution = plan.solve(entries, factors, &rows, pivot);
            let update = self.trusted(entries, &rows, solution);
            Update { rows, update }
        })
    }

    /// Whether the order of the pivots is an odd permutation of rows and columns.
    pub(crate) fn is_odd(&self) -> bool {
        self.plan().odd
    }

    /// The plan of the elimination, made at the first call.
    #[inline]
    fn plan(&self) -> &Plan {
        self.plan
            .get_or_init(|| Plan::new(self.size, &self.entries, &self.pivots))
    }

    /// `-x` for the solution `x` of `J x = r`; NaN if its residual is larger than rounding.
    #[inline]
    fn trusted<T: Scalar, U: Clone + AsRef<[T]> + AsMut<[T]>>(
        &self,
        entries: &[T],
        rows: &U,
        solution: U,
    ) -> U {
        let (mut left, mut terms) = (rows.clone(), rows.clone());
        for term in terms.as_mut() {
            *term = term.abs();
        }
        let unknowns = solution.as_ref();
        let (remainders, sizes) = (left.as_mut(), terms.as_mut());
        for (&[row, column], &entry) in self.entries.iter().zip(entries) {
            let (row, product) = (usize::from(row), entry * unknowns[usize::from(column)]);
            remainders[row] = remainders[row] - product;
            sizes[row] = sizes[row] + product.abs();
        }
        let one = T::splat(1.0);
        let mut sign = T::splat(-1.0);
        for (&left, &terms) in remainders.iter().zip(sizes.iter()) {
            let good = T::select_le(left.abs(), T::splat(LEFT) * terms, one, T::splat(f64::NAN));
            sign = sign * good;
        }
        let mut solution = solution;
        for x in solution.as_mut() {
            *x = sign * *x;
        }
        solution
    }
}

impl Plan {
    /// Derives the operations symbolically. Entries without a pivot in their row or column are left out, and
    /// pivots that do not cover the matrix give an empty plan: in both cases the solution fails the test of
    /// its residual.
    fn new(size: usize, entries: &[[u16; 2]], pivots: &[[u16; 2]]) -> Self {
        let mut rows: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); size];
        let mut columns = rows.clone();
        for &[row, column] in entries {
            rows[usize::from(row)].insert(u32::from(column));
            columns[usize::from(column)].insert(u32::from(row));
        }
        let mut plan = Self::default();
        let mut slots = std::collections::HashMap::new();
        // the entries right of and below each pivot; the slots are numbered at the end
        let mut order = Vec::new();
        for &[row, column] in pivots {
            let [row, column] = [row, column].map(u32::from);
            let right: Vec<u32> = rows[row as usize]
                .iter()
                .copied()
                .filter(|&j| j != column)
                .collect();
            let below: Vec<u32> = columns[column as usize]
                .iter()
                .copied()
                .filter(|&i| i != row)
                .collect();
            let mut place = |row: u32, column: u32| {
                slots.insert((row, column), plan.count);
                plan.count += 1;
            };
            place(row, column);
            for &j in &right {
                place(row, j);
            }
            for &i in &below {
                place(i, column);
            }
            for &j in &right {
                columns[j as usize].remove(&row);
                columns[j as usize].extend(&below);
            }
            for &i in &below {
                rows[i as usize].remove(&column);
                rows[i as usize].extend(&right);
            }
            order.push((row, column, plan.count, right, below));
        }
        for (row, column, end, right, below) in &order {
            plan.pivots.push(Pivot {
                row: *row,
                column: *column,
                right: saturated(right.len()),
                below: saturated(below.len()),
            });
            plan.indices.extend(right);
            for &i in below {
                plan.indices.push(i);
                let changed = right
                    .iter()
                    .map(|&j| slots.get(&(i, j)).map_or(0, |slot| slot - end));
                plan.indices.extend(changed.map(saturated));
            }
        }
        let slot = |&[row, column]: &[u16; 2]| slots.get(&(row.into(), column.into())).copied();
        plan.slots = entries
            .iter()
            .map(|entry| slot(entry).map_or(u32::MAX, saturated))
            .collect();
        let [rows, columns] = [0, 1].map(|side| pivots.iter().map(|pivot| pivot[side]).collect());
        plan.odd = is_odd(rows) != is_odd(columns);
        plan
    }

    /// Solves `J x = r` in slots for factors.
    #[inline]
    fn solve<T: Scalar, U: Clone + AsRef<[T]> + AsMut<[T]>>(
        &self,
        entries: &[T],
        factors: &mut [T],
        rows: &U,
        mut pivot: impl FnMut(T),
    ) -> U {
        factors.fill(T::splat(0.0));
        for (&slot, &entry) in self.slots.iter().zip(entries) {
            if let Some(place) = factors.get_mut(slot as usize) {
                *place = entry;
            }
        }
        let mut right_side = rows.clone();
        let mut inverses = rows.clone();
        let x = right_side.as_mut();
        let (mut open, mut indices) = (&mut *factors, self.indices.as_slice());
        for (step, inverse) in self.pivots.iter().zip(inverses.as_mut()) {
            let (right, below) = (step.right as usize, step.below as usize);
            let (own, rest) = open.split_at_mut(1 + right + below);
            open = rest;
            pivot(own[0]);
            *inverse = own[0].recip();
            let (of_row, of_column) = own[1..].split_at(right);
            let value = x[step.row as usize];
            let (of_pivot, later) = indices.split_at(right + below * (1 + right));
            indices = later;
            for (changed, &entry) in of_pivot[right..].chunks_exact(1 + right).zip(of_column) {
                let factor = entry * *inverse;
                let lower = &mut x[changed[0] as usize];
                *lower = *lower - factor * value;
                for (&slot, &upper) in changed[1..].iter().zip(of_row) {
                    let slot = &mut open[slot as usize];
                    *slot = *slot - factor * upper;
                }
            }
        }
        self.back(factors, x, &inverses)
    }

    /// Back substitution: the unknowns, from the last pivot to the first.
    #[inline]
    fn back<T: Scalar, U: Clone + AsRef<[T]> + AsMut<[T]>>(
        &self,
        factors: &[T],
        right_side: &[T],
        inverses: &U,
    ) -> U {
        let mut solution = inverses.clone();
        solution.as_mut().fill(T::splat(0.0));
        let unknowns = solution.as_mut();
        let (mut slots, mut indices) = (factors, self.indices.as_slice());
        for (step, &inverse) in self.pivots.iter().zip(inverses.as_ref()).rev() {
            let (right, below) = (step.right as usize, step.below as usize);
            let (earlier, own) = slots.split_at(slots.len() - (1 + right + below));
            let (before, columns) = indices.split_at(indices.len() - (right + below * (1 + right)));
            (slots, indices) = (earlier, before);
            let mut value = right_side[step.row as usize];
            for (&column, &entry) in columns[..right].iter().zip(&own[1..]) {
                value = value - entry * unknowns[column as usize];
            }
            unknowns[step.column as usize] = value * inverse;
        }
        solution
    }
}

/// Whether a permutation is odd; undefined for other sequences.
fn is_odd(mut permutation: Vec<u16>) -> bool {
    let mut odd = false;
    for place in 0..permutation.len() {
        while let Some(&other) = permutation.get(usize::from(permutation[place])) {
            if other == permutation[place] {
                break;
            }
            let to = usize::from(permutation[place]);
            permutation.swap(place, to);
            odd = !odd;
        }
    }
    odd
}

/// A count as `u32`, which no system exceeds.
fn saturated(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// The determinant as a running product of pivots.
pub(crate) struct Product(Determinant);

impl Product {
    /// The product before the first pivot.
    pub(crate) fn new(odd: bool) -> Self {
        Self(Determinant::of(if odd { -1.0 } else { 1.0 }))
    }

    /// Multiplies by a pivot.
    #[inline]
    pub(crate) fn take(&mut self, pivot: f64) {
        self.0 = self.0.times(pivot);
    }

    /// The product.
    pub(crate) fn value(self) -> Determinant {
        self.0
    }
}

/// Numbers for which every thread keeps the workspace of an elimination.
pub(crate) trait ThreadWorkspace: Scalar {
    /// Calls `work` with a workspace of `length` numbers.
    fn with_workspace<R>(length: usize, work: impl FnOnce(&mut [Self]) -> R) -> R;
}

impl ThreadWorkspace for f64 {
    #[inline]
    fn with_workspace<R>(length: usize, work: impl FnOnce(&mut [Self]) -> R) -> R {
        thread_local! {
            static ROOM: Cell<Vec<f64>> = const { Cell::new(Vec::new()) };
        }
        // rows may call a user's function that runs another system: that elimination finds an empty workspace
        let mut room = ROOM.take();
        if room.len() < length {
            room.resize(length, 0.0);
        }
        let result = work(&mut room[..length]);
        ROOM.set(room);
        result
    }
}

impl<R: Chosen> ThreadWorkspace for Lanes<R> {
    #[inline]
    fn with_workspace<T>(length: usize, work: impl FnOnce(&mut [Self]) -> T) -> T {
        R::with_workspace(length, work)
    }
}

#[cfg(test)]
mod tests;
