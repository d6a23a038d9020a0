//! The motion brought back onto holonomic and nonholonomic constraints after each step.
//!
//! Series keep these constraints to the tolerance, and what is missing would add up. The correction is the shortest one by a mass
//! matrix, that of the start: any metric serves, and this one has the units of the coordinates.

use super::jets::Equations;
use crate::array;
use crate::compensated::Compensated;
use crate::declaration::Declaration;
use crate::start;

/// So often a position or a velocity is corrected at most.
const CORRECTIONS: u32 = 4;

/// A correction of this part of what is corrected is the last: what is left is its square, and below rounding.
const LAST: f64 = 4e-9;

/// Velocities at which slopes are compared with those at the start: a multiple of its velocity, and a part of its size.
const OTHERS: [[f64; 2]; 2] = [[-1.7, 0.9], [0.6, -2.3]];

/// A row whose part that is independent of the others is below this part of itself follows from them.
const DEPENDENT: f64 = 1e-8;

/// The constraints of a motion, with room for what is computed of them.
#[derive(Clone, Debug)]
pub(super) struct Projection<const N: usize> {
    /// How many rows there are of positions and of velocities.
    counts: [usize; 2],
    /// The inverse of the mass matrix at the start, row by row.
    inverse: [[f64; N]; N],
    /// Rows, and their slopes.
    rows: Vec<f64>,
    /// Whether the rows are affine in the velocity, so that one correction of it is all.
    is_affine: bool,
    /// Directions of correction, orthonormal by the mass matrix, and the same as forms.
    directions: Vec<[[f64; N]; 2]>,
    /// The last velocity before it was corrected, and by how much that was.
    corrected: ([f64; N], f64),
    /// The same of the last position.
    shifted: ([f64; N], f64),
}

impl<const N: usize> Projection<N> {
    /// The constraints of a declaration; `None` if it has none of lower order.
    pub fn new(declaration: &Declaration<'_>, (t, q, v): (f64, &[f64; N], &[f64; N])) -> Option<Self> {
        let (holonomic, lower) = (declaration.holonomic(), declaration.lower());
        if lower == 0 {
            return None;
        }
        let inverse = start::inverse_mass(declaration, (t, q, v));
        let mut rows = vec![0.0; lower * (1 + N)];
        let mut slopes = |v: &[f64; N]| {
            declaration.phase_slopes(true, t, q, v, &mut rows);
            rows[lower..].to_vec()
        };
        let here = slopes(v);
        // of rows that are affine in the velocity they have the same bits at any velocity
        let is_affine = OTHERS.iter().all(|[scale, shift]| {
            let size = v.iter().fold(1.0_f64, |size, v| size.max(v.abs()));
            let other = array::from_fn(|i| scale * v[i] + shift * size / (i as f64 + 1.3));
            slopes(&other) == here
        });
        Some(Self {
            counts: [holonomic, lower],
            inverse: core::array::from_fn(|i| core::array::from_fn(|j| inverse[(i, j)])),
            is_affine,
            rows,
            directions: Vec::with_capacity(lower),
            corrected: (*v, 0.0),
            shifted: (*q, 0.0),
        })
    }

    /// Other values of parameters make rows that may be less simple.
    pub fn forget(&mut self) {
        self.is_affine = false;
    }

    /// Brings a position and a velocity at a time back. Nothing is allocated.
    pub fn apply(
        &mut self,
        equations: &dyn Equations<N>,
        t: f64,
        q: &mut Compensated<N>,
        v: &mut Compensated<N>,
    ) {
        if self.counts[0] > 0 {
            let before = q.hi;
            for _ in 0..CORRECTIONS {
                let count = self.counts[0];
                equations.phase_slopes(false, (t, &q.hi, &v.hi), &mut self.rows[..count * (1 + N)]);
                let correction = self.correction(count, &q.hi);
                q.add(&correction.by);
                if correction.is_last {
                    break;
                }
            }
            let by: [f64; N] = array::from_fn(|i| q.hi[i] - before[i]);
            self.shifted = (before, size(&by));
        }
        let before = v.hi;
        for _ in 0..CORRECTIONS {
            equations.phase_slopes(true, (t, &q.hi, &v.hi), &mut self.rows);
            let correction = self.correction(self.counts[1], &v.hi);
            v.add(&correction.by);
            if correction.is_last || self.is_affine {
                break;
            }
        }
        let by: [f64; N] = array::from_fn(|i| v.hi[i] - before[i]);
        self.corrected = (before, size(&by));
    }

    /// The last velocity as it was before its correction, if that was by more than a part of its size or of another one: a motion may turn
    /// round where it is corrected.
    pub fn moved(&self, part: f64, other: f64) -> Option<[f64; N]> {
        let (before, by) = self.corrected;
        (by > part * size(&before).max(other)).then_some(before)
    }

    /// The last position as it was before its correction, if that was by more than a part of its size or of another one: the way to it may lead
    /// to zero.
    pub fn shifted(&self, part: f64, other: f64) -> Option<[f64; N]> {
        let (before, by) = self.shifted;
        (by > part * size(&before).max(other)).then_some(before)
    }

    /// The shortest correction that makes the rows vanish to first order: their slopes are made orthonormal one by one.
    fn correction(&mut self, count: usize, x: &[f64; N]) -> Correction<N> {
        let (values, slopes) = self.rows.split_at(count);
        let mut by = [0.0; N];
        self.directions.clear();
        for (value, slope) in values.iter().zip(slopes.as_chunks::<N>().0) {
            let mut form = *slope;
            if let [value] = values {
                // one row alone has nothing to be made orthogonal to
                let direction = self.raised(&form);
                let square = product(&form, &direction);
                if square > 0.0 {
                    let left = value / square;
                    by = array::map(&direction, |x| -left * x);
                }
                break;
            }
            let mut left = *value + product(&form, &by);
            let whole = product(&form, &self.raised(&form));
            for [direction, other] in &self.directions {
                let along = product(&form, direction);
                for (form, other) in form.iter_mut().zip(other) {
                    *form -= along * other;
                }
            }
            let direction = self.raised(&form);
            let square = product(&form, &direction);
            if square.is_nan() || square <= DEPENDENT * DEPENDENT * whole {
                continue;
            }
            left /= square;
            let length = square.sqrt();
            for (by, direction) in by.iter_mut().zip(&direction) {
                *by -= left * direction;
            }
            self.directions.push([
                array::map(&direction, |x| x / length),
                array::map(&form, |x| x / length),
            ]);
        }
        // what is no number is left to the step's own error
        if by.iter().any(|x| !x.is_finite()) {
            return Correction {
                by: [0.0; N],
                is_last: true,
            };
        }
        Correction {
            is_last: size(&by) <= LAST * size(x),
            by,
        }
    }

    /// The displacement that belongs to a form.
    fn raised(&self, form: &[f64; N]) -> [f64; N] {
        array::from_fn(|i| product(&self.inverse[i], form))
    }
}

/// A correction.
struct Correction<const N: usize> {
    /// What is added.
    by: [f64; N],
    /// Whether what is left after it is rounding.
    is_last: bool,
}

/// The largest component.
pub(super) fn size<const N: usize>(x: &[f64; N]) -> f64 {
    x.iter().fold(0.0_f64, |size, x| size.max(x.abs()))
}

/// The sum of products.
fn product<const N: usize>(x: &[f64; N], y: &[f64; N]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}
