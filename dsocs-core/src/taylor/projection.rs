//! Projection of the motion onto holonomic and nonholonomic constraints after each step.
//!
//! Series satisfy these constraints to the tolerance, and the errors would add up. The correction is the
//! shortest one in the metric of the mass matrix at the start: any metric would do, and this one has the
//! units of the coordinates.

use super::recurrences::SeriesKernel;
use super::state::State;
use crate::number::inner_product;
use crate::number::larger;
use crate::start;
use crate::tape::declaration::Declaration;

/// Largest number of corrections of a position or a velocity.
const CORRECTIONS: u32 = 4;

/// A correction below this part of the vector is the last: the remaining error is its square, and below
/// rounding.
const LAST: f64 = 4e-9;

/// Velocities at which derivatives are compared with those at the start: a multiple of its velocity, plus a
/// part of its size.
const OTHERS: [[f64; 2]; 2] = [[-1.7, 0.9], [0.6, -2.3]];

/// A row is dependent if its part that is independent of the others is below this part of it.
const DEPENDENT: f64 = 1e-8;

/// A row is lost if its independent part is below this part of its largest so far: so close to a dependence
/// of constraints, rounding decides the motion.
const LOST: f64 = 1e-7;

/// The constraints of a motion, with workspace.
#[derive(Clone, Debug)]
pub(super) struct Projection {
    /// The number of coordinates.
    n: usize,
    /// The number of rows on positions, and on velocities.
    counts: [usize; 2],
    /// The inverse of the mass matrix at the start.
    inverse: Inverse,
    /// Rows, and their derivatives.
    rows: Vec<f64>,
    /// Whether the rows are affine in the velocity, so that one correction of it is enough.
    is_affine: bool,
    /// The workspace of the shortest correction.
    shortest: Shortest,
    /// The last velocity before its correction, and the size of the correction.
    corrected: (Vec<f64>, f64),
    /// The last position before its correction, and the size of the correction.
    shifted: (Vec<f64>, f64),
    /// The directions of correction at the end of the last step.
    directions: Vec<f64>,
}

/// The range of a vector's nonzero components. Sums leave out the others without a change: with many
/// coordinates a constraint has few of them.
type Span = [usize; 2];

/// The inverse of a mass matrix.
#[derive(Clone, Debug)]
enum Inverse {
    /// Its diagonal: all other entries are zero.
    Diagonal(Vec<f64>),
    /// A full matrix.
    Full {
        /// Row by row.
        rows: Vec<f64>,
        /// The range of nonzero entries of each row.
        spans: Vec<Span>,
        /// The range of nonzero entries of each column.
        columns: Vec<Span>,
    },
}

/// The workspace of the shortest correction.
#[derive(Clone, Debug)]
struct Shortest {
    /// The correction.
    by: Vec<f64>,
    /// The form of a row, its displacement, and workspace for another one.
    form: Vec<f64>,
    direction: Vec<f64>,
    raised: Vec<f64>,
    /// Directions of correction, orthonormal in the mass metric, each followed by itself as a form.
    directions: Vec<f64>,
    /// The ranges of their nonzero components.
    spans: Vec<[Span; 2]>,
    /// The largest square of each row's independent part so far, and whether one has lost nearly all of it.
    largest: Vec<f64>,
    lost: bool,
}

impl Projection {
    /// The constraints of a declaration; `None` if it has none of lower order.
    pub fn new(declaration: &Declaration<'_>, (t, q, v): (f64, &[f64], &[f64])) -> Option<Self> {
        let (holonomic, lower, n) = (declaration.holonomic(), declaration.lower(), q.len());
        if lower == 0 {
            return None;
        }
        let inverse = start::inverse_mass(declaration, t, q, v);
        let mut rows = vec![0.0; lower * (1 + n)];
        let mut slopes = |v: &[f64]| {
            declaration.phase_slopes(true, t, q, v, &mut rows);
            rows[lower..].to_vec()
        };
        let here = slopes(v);
        // the derivatives of rows that are affine in the velocity have the same bits at any velocity
        let is_affine = OTHERS.iter().all(|[scale, shift]| {
            let size = v.iter().fold(1.0_f64, |size, v| size.max(v.abs()));
            let others = v.iter().enumerate();
            let other: Vec<f64> = others
                .map(|(i, v)| scale * v + shift * size / (i as f64 + 1.3))
                .collect();
            slopes(&other) == here
        });
        declaration.phase_slopes(true, t, q, v, &mut rows);
        let zero = vec![0.0; n];
        let mut projection = Self {
            n,
            counts: [holonomic, lower],
            inverse: Inverse::of(
                (0..n * n).map(|place| inverse[(place / n, place % n)]).collect(),
                n,
            ),
            is_affine,
            rows,
            shortest: Shortest {
                by: zero.clone(),
                form: zero.clone(),
                direction: zero.clone(),
                raised: zero,
                directions: Vec::with_capacity(2 * n * lower),
                spans: Vec::with_capacity(lower),
                largest: vec![0.0; lower],
                lost: false,
            },
            corrected: (v.to_vec(), 0.0),
            shifted: (q.to_vec(), 0.0),
            directions: Vec::with_capacity(2 * n * lower),
        };
        projection.correct(lower, v);
        projection.keep_directions();
        Some(projection)
    }

    /// Forgets that the rows are affine, since other values of parameters may change them.
    pub fn forget(&mut self) {
        self.is_affine = false;
    }

    /// Projects a position and a velocity at a time; corrections of rotations are increments in the frames of
    /// their bodies. Nothing is allocated.
    pub fn apply(&mut self, equations: &dyn SeriesKernel, t: f64, state: &mut State) {
        self.shortest.lost = false;
        let rotations = &equations.kernel().shape().rotations;
        if self.counts[0] > 0 {
            self.shifted.0.copy_from_slice(state.q());
            for _ in 0..CORRECTIONS {
                let count = self.counts[0];
                let rows = &mut self.rows[..count * (1 + self.n)];
                equations.phase_slopes(false, (t, state.q(), state.v()), rows);
                let is_last = self.correct(count, state.q());
                if rotations.is_empty() {
                    state.move_position(&self.shortest.by);
                } else {
                    state.turn_position(rotations, &self.shortest.by);
                }
                if is_last {
                    break;
                }
            }
            self.shifted.1 = distance(state.q(), &self.shifted.0);
        }
        self.corrected.0.copy_from_slice(state.v());
        for _ in 0..CORRECTIONS {
            equations.phase_slopes(true, (t, state.q(), state.v()), &mut self.rows);
            let is_last = self.correct(self.counts[1], state.v());
            state.move_velocity(&self.shortest.by);
            if is_last || self.is_affine {
                break;
            }
        }
        self.corrected.1 = distance(state.v(), &self.corrected.0);
    }

    /// Whether the independent part of a row has reversed its direction since the last step. Rows may have
    /// been dependent in between, or the row itself may have turned.
    pub fn has_turned(&self) -> bool {
        let now = &self.shortest.directions;
        let pairs = self.directions.chunks_exact(2 * self.n.max(1));
        let turned = pairs
            .zip(now.chunks_exact(2 * self.n.max(1)))
            .any(|(before, now)| {
                // each direction is followed by its form
                inner_product(&before[..self.n], &now[..self.n]) < 0.0
            });
        turned || !self.directions.is_empty() && self.directions.len() != now.len()
    }

    /// Stores the independent parts of the rows at the end of the last step, with which the next ones are
    /// compared.
    pub fn keep_directions(&mut self) {
        self.directions.clear();
        self.directions.extend_from_slice(&self.shortest.directions);
    }

    /// Whether a row has nearly lost its independent part at the end of the last step.
    pub fn is_lost(&self) -> bool {
        self.shortest.lost
    }

    /// The last velocity before its correction, if the correction exceeds a part of its size and of another
    /// size: a motion may reverse where it is corrected.
    pub fn moved(&self, part: f64, other: f64) -> Option<&[f64]> {
        let (before, by) = &self.corrected;
        (*by > part * size(before).max(other)).then_some(before)
    }

    /// The last position before its correction, if the correction exceeds a part of its size and of another
    /// size: the path may lead to zero.
    pub fn shifted(&self, part: f64, other: f64) -> Option<&[f64]> {
        let (before, by) = &self.shifted;
        (*by > part * size(before).max(other)).then_some(before)
    }

    /// The shortest correction that makes the rows vanish to first order, by orthonormalising their
    /// derivatives one by one. Returns whether the remaining error is rounding.
    fn correct(&mut self, count: usize, x: &[f64]) -> bool {
        let Self {
            n,
            inverse,
            rows,
            shortest,
            ..
        } = self;
        let n = *n;
        let (values, slopes) = rows.split_at(count);
        if let [value] = values {
            return shortest.for_one_row(inverse, *value, slopes, x);
        }
        let Shortest {
            by,
            form,
            direction,
            raised: room,
            directions,
            spans,
            largest,
            lost,
        } = shortest;
        by.fill(0.0);
        directions.clear();
        spans.clear();
        for (k, (value, slope)) in values.iter().zip(slopes.chunks_exact(n.max(1))).enumerate() {
            form.copy_from_slice(slope);
            let mut span = span_of(form);
            let mut left = *value + product_in(span, form, by);
            inverse.raise(form, span, room);
            let whole = product_in(span, form, room);
            for (pair, [own, of_other]) in directions.chunks_exact(2 * n.max(1)).zip(&*spans) {
                let (direction, other) = pair.split_at(n);
                let along = product_in(common(span, *own), form, direction);
                if along == 0.0 {
                    continue;
                }
                let [from, to] = *of_other;
                for (form, other) in form[from..to].iter_mut().zip(&other[from..to]) {
                    *form -= along * other;
                }
                span = [span[0].min(from), span[1].max(to)];
            }
            let reach = inverse.raise(form, span, direction);
            let square = product_in(span, form, direction);
            if square.is_nan() || square <= DEPENDENT * DEPENDENT * whole {
                continue;
            }
            *lost |= loses(&mut largest[k], square);
            left /= square;
            for (by, direction) in in_span(reach, by).iter_mut().zip(in_span(reach, direction)) {
                *by -= left * *direction;
            }
            let factor = 1.0 / square.sqrt();
            let pair = directions.len();
            directions.resize(pair + 2 * n, 0.0);
            for (of_all, x, own) in [(pair, &*direction, reach), (pair + n, &*form, span)] {
                let to = in_span(own.map(|place| of_all + place), directions);
                for (to, x) in to.iter_mut().zip(&x[own[0]..own[1]]) {
                    *to = factor * x;
                }
            }
            spans.push([reach, span]);
        }
        // a NaN is left to the step's own error
        if by.iter().any(|x| !x.is_finite()) {
            by.fill(0.0);
            return true;
        }
        size(by) <= LAST * size(x)
    }
}

/// Whether a row has lost nearly all of its independent part, whose square is held against its largest so far.
fn loses(largest: &mut f64, square: f64) -> bool {
    *largest = largest.max(square);
    square <= LOST * LOST * *largest
}

impl Shortest {
    /// The correction for a single row, which need not be made orthogonal, as in [`Projection::correct`].
    fn for_one_row(&mut self, inverse: &Inverse, value: f64, slope: &[f64], x: &[f64]) -> bool {
        let Self {
            by,
            direction,
            directions,
            largest,
            lost,
            ..
        } = self;
        let n = x.len();
        let slope = &slope[..n];
        inverse.raise(slope, [0, n], direction);
        let square = inner_product(slope, direction);
        if square.is_nan() || square <= 0.0 {
            by.fill(0.0);
            directions.clear();
            return true;
        }
        *lost |= loses(&mut largest[0], square);
        let (left, factor) = (value / square, 1.0 / square.sqrt());
        directions.resize(2 * n, 0.0);
        let (to_direction, to_form) = directions.split_at_mut(n);
        let (mut of_by, mut of_x) = (0.0_f64, 0.0_f64);
        for (i, by) in by.iter_mut().enumerate() {
            *by = -left * direction[i];
            (to_direction[i], to_form[i]) = (factor * direction[i], factor * slope[i]);
            (of_by, of_x) = (larger(of_by, by.abs()), larger(of_x, x[i].abs()));
        }
        // a NaN is left to the step's own error
        if !of_by.is_finite() {
            by.fill(0.0);
            return true;
        }
        of_by <= LAST * of_x
    }
}

impl Inverse {
    /// The matrix of rows, one after the other.
    fn of(rows: Vec<f64>, n: usize) -> Self {
        let places = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        if places().all(|(i, j)| i == j || rows[i * n + j] == 0.0) {
            return Self::Diagonal((0..n).map(|i| rows[i * n + i]).collect());
        }
        let spans = rows.chunks_exact(n.max(1)).map(span_of).collect();
        let column = |j| span_of(&(0..n).map(|i| rows[i * n + j]).collect::<Vec<_>>());
        Self::Full {
            spans,
            columns: (0..n).map(column).collect(),
            rows,
        }
    }

    /// The displacement of a form that is zero outside a span, and the range of its nonzero components.
    fn raise(&self, form: &[f64], span: Span, displacement: &mut [f64]) -> Span {
        match self {
            Self::Diagonal(entries) => {
                for (x, (entry, form)) in displacement.iter_mut().zip(entries.iter().zip(form)) {
                    *x = entry * form;
                }
                span
            }
            Self::Full { rows, spans, columns } => {
                displacement.fill(0.0);
                let mut reach = [form.len(), 0];
                for column in columns.get(span[0]..span[1]).unwrap_or_default() {
                    reach = [reach[0].min(column[0]), reach[1].max(column[1])];
                }
                let reach = [reach[0].min(reach[1]), reach[1]];
                let rows = rows.chunks_exact(form.len().max(1)).zip(spans);
                let all = displacement.iter_mut().zip(rows);
                for (x, (row, own)) in all.take(reach[1]).skip(reach[0]) {
                    *x = product_in(common(*own, span), row, form);
                }
                reach
            }
        }
    }
}

/// The components of a vector in a span.
fn in_span([from, to]: Span, x: &mut [f64]) -> &mut [f64] {
    x.get_mut(from..to).unwrap_or_default()
}

/// The range of a vector's nonzero components.
fn span_of(x: &[f64]) -> Span {
    let is_something = |x: &f64| *x != 0.0;
    let from = x.iter().position(is_something).unwrap_or(0);
    let to = x.iter().rposition(is_something).map_or(from, |last| last + 1);
    [from, to]
}

/// The common range of two.
fn common([from, to]: Span, [other_from, other_to]: Span) -> Span {
    let from = from.max(other_from);
    [from, to.min(other_to).max(from)]
}

/// The inner product in a range.
fn product_in([from, to]: Span, x: &[f64], y: &[f64]) -> f64 {
    match (x.get(from..to), y.get(from..to)) {
        (Some(x), Some(y)) => inner_product(x, y),
        _ => f64::NAN,
    }
}

/// The largest absolute component; NaN if one is.
#[inline]
pub(super) fn size(x: &[f64]) -> f64 {
    x.iter().fold(0.0_f64, |size, x| larger(size, x.abs()))
}

/// The largest absolute component of a difference; NaN if one is.
fn distance(x: &[f64], y: &[f64]) -> f64 {
    let differences = x.iter().zip(y);
    differences.fold(0.0_f64, |size, (x, y)| larger(size, (x - y).abs()))
}
