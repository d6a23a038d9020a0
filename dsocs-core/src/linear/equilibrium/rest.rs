//! The equations of rest, and Newton's iteration for them.

use super::error::EquilibriumError;
use super::rows::Rows;
use crate::linear::chart::Basis;
use crate::linear::slopes::{At, Slopes};
use crate::number::point::AnyPoint;
use crate::number::{inner_product, largest};
use crate::regularity::{multipliers, sticking, undefined};
use crate::solve::dense::{Matrix, length};
use crate::solve::rotation::{self, SLOTS};
use crate::tape::declaration::Declaration;
use crate::tape::{Leaf, Part, Segment};

/// Largest number of iterations.
const MAX_ITERATIONS: u32 = 200;

/// Largest number of times that an update is halved.
const HALVINGS: u32 = 30;

/// An update below this, relative to the unknowns or absolute where they are below 1, is the last if the next
/// is not smaller.
pub(super) const SMALL: f64 = 1e-10;

/// Singular values below this part of the largest are zero.
const ZERO: f64 = 1e-9;

/// Distance along a direction at which another equilibrium is searched.
const FAR: f64 = 1e-3;

/// A derivative by time below this part of a row's own derivatives is zero.
const CONSTANT: f64 = 1e-11;

/// The unknowns: coordinates and parameters, by their places, and multipliers.
#[derive(Clone, Debug)]
pub(super) struct Unknowns {
    /// The first places of rotations.
    pub(super) rotations: Vec<usize>,
    pub(super) coordinates: Vec<usize>,
    pub(super) parameters: Vec<usize>,
    pub(super) multipliers: usize,
}

impl Unknowns {
    /// The number of unknown coordinates and parameters.
    fn of_place(&self) -> usize {
        self.coordinates.len() + self.parameters.len()
    }

    /// The leaves of the unknowns.
    fn leaves(&self) -> Vec<Leaf> {
        let coordinates = self.coordinates.iter().map(|&i| Leaf::Q(i));
        let parameters = self.parameters.iter().map(|&i| Leaf::Parameter(i));
        let multipliers = (0..self.multipliers).map(Leaf::Lambda);
        coordinates.chain(parameters).chain(multipliers).collect()
    }

    /// The multipliers among the unknowns.
    pub(super) fn multipliers_of<'x>(&self, x: &'x [f64]) -> &'x [f64] {
        x.get(self.of_place()..).unwrap_or_default()
    }
}

/// The equations of rest from a guess.
pub(super) struct RestEquations<'r> {
    pub(super) declaration: Declaration<'r>,
    pub(super) t: f64,
    pub(super) guess: &'r [f64],
    pub(super) values: &'r [f64],
    pub(super) unknowns: &'r Unknowns,
}

/// A solution.
pub(super) struct RestSolution {
    pub(super) x: Vec<f64>,
    rows: Rows,
}

impl RestEquations<'_> {
    /// The position for given unknowns, with held coordinates at the guess. For a rotation the unknowns are
    /// the increment from the guess.
    pub(super) fn position(&self, x: &[f64]) -> Vec<f64> {
        let (mut q, mut increment) = (self.guess.to_vec(), vec![0.0; self.guess.len()]);
        for (&i, x) in self.unknowns.coordinates.iter().zip(x) {
            if self.is_turn(i) {
                increment[i] = *x;
            } else {
                q[i] = *x;
            }
        }
        rotation::moved(&self.unknowns.rotations, &q, &increment)
    }

    /// Whether a place belongs to a rotation, whose change is a turn.
    fn is_turn(&self, i: usize) -> bool {
        let mut rotations = self.unknowns.rotations.iter();
        rotations.any(|first| (*first..first + SLOTS).contains(&i))
    }

    /// The unknowns after a part of an update.
    fn moved(&self, x: &[f64], update: &[f64], part: f64) -> Vec<f64> {
        let mut moved: Vec<f64> = x
            .iter()
            .zip(update)
            .map(|(x, update)| x + part * update)
            .collect();
        if !self.unknowns.rotations.is_empty() {
            // an update of a rotation is a turn of the body from its current attitude
            let scaled: Vec<f64> = update.iter().map(|update| part * update).collect();
            let by = self.whole(&scaled[..self.unknowns.of_place().min(scaled.len())]);
            let rotations = &self.unknowns.rotations;
            let there = rotation::moved(rotations, &self.position(x), &by[..self.guess.len()]);
            self.put_turns(&self.apart(self.guess, &there), &mut moved);
        }
        moved
    }

    /// The difference of two positions, with turns in the frames of bodies.
    fn apart(&self, from: &[f64], to: &[f64]) -> Vec<f64> {
        let mut apart: Vec<f64> = to.iter().zip(from).map(|(to, from)| to - from).collect();
        rotation::difference(&self.unknowns.rotations, [from, to], &mut apart);
        apart
    }

    /// Replaces the unknowns of rotations by turns.
    fn put_turns(&self, turns: &[f64], x: &mut [f64]) {
        for (&i, x) in self.unknowns.coordinates.iter().zip(x) {
            if self.is_turn(i) {
                *x = turns[i];
            }
        }
    }

    /// The values of all parameters.
    pub(super) fn parameters(&self, x: &[f64]) -> Vec<f64> {
        let mut values = self.values.to_vec();
        let own = x.iter().skip(self.unknowns.coordinates.len());
        for (&i, x) in self.unknowns.parameters.iter().zip(own) {
            values[i] = *x;
        }
        values
    }

    /// The initial values of the unknowns.
    fn first(&self) -> Vec<f64> {
        let still = vec![0.0; self.guess.len()];
        let declaration = self.declaration.with(self.values);
        let point = AnyPoint {
            t: self.t,
            q: self.guess,
            v: &still,
            a: &still,
        };
        let mut multipliers = multipliers::of_point(&declaration, point);
        multipliers.resize(self.unknowns.multipliers, 0.0);
        if multipliers.iter().any(|multiplier| !multiplier.is_finite()) {
            multipliers.fill(0.0);
        }
        let first = |&i: &usize| if self.is_turn(i) { 0.0 } else { self.guess[i] };
        let coordinates = self.unknowns.coordinates.iter().map(first);
        let parameters = self.unknowns.parameters.iter().map(|&i| self.values[i]);
        coordinates.chain(parameters).chain(multipliers).collect()
    }

    /// The equations at some unknowns: those of the continuous system at rest, and the constraints on
    /// positions and velocities.
    fn slopes(&self, x: &[f64]) -> Slopes {
        let (q, values) = (self.position(x), self.parameters(x));
        let declaration = self.declaration.with(&values);
        let still = vec![0.0; q.len()];
        let at = At {
            t: self.t,
            q: &q,
            v: &still,
            a: &still,
            multipliers: self.unknowns.multipliers_of(x),
        };
        let sides = self.sides(&declaration, &q);
        let continuous = if sides.is_empty() {
            Segment::Continuous
        } else {
            Segment::SidedContinuous
        };
        let value = |leaf| match leaf {
            Leaf::Side(g) => sides.get(g).copied().unwrap_or(0.0),
            _ => at.value(&declaration, leaf),
        };
        Slopes::of(
            &declaration,
            &[(continuous, Part::Head), (Segment::Phase, Part::All)],
            &value,
        )
    }

    /// The sides of the functions that jump with the velocity, at rest at a position: the sign of each argument, or zero (between the two
    /// sides) where the argument is zero. A function that jumps at another velocity has the value of the side on which rest lies.
    pub(super) fn sides(&self, declaration: &Declaration<'_>, q: &[f64]) -> Vec<f64> {
        if declaration.sides() == 0 {
            return Vec::new();
        }
        let still = vec![0.0; q.len()];
        let zero = sticking::zero(declaration, self.t, q, &still);
        let arguments = declaration.side_arguments(self.t, q, &still);
        let both = arguments.into_iter().zip(zero);
        both.map(|(argument, zero)| if zero { 0.0 } else { argument.signum() })
            .collect()
    }

    /// Whether functions that jump at rest, such as dry friction, act there: they hold positions around it, too.
    pub(super) fn is_held(&self, found: &RestSolution) -> bool {
        let q = self.position(&found.x);
        let values = self.parameters(&found.x);
        let sides = self.sides(&self.declaration.with(&values), &q);
        let acts = |g: usize| {
            found
                .rows
                .slopes
                .by(Leaf::Side(g))
                .iter()
                .any(|slope| *slope != 0.0)
        };
        sides.iter().enumerate().any(|(g, side)| *side == 0.0 && acts(g))
    }

    /// The rows; `None` if they have no value.
    fn rows(&self, x: &[f64]) -> Option<Rows> {
        let slopes = self.slopes(x);
        let leaves = self.unknowns.leaves();
        let mut columns: Vec<Vec<f64>> = leaves.iter().map(|leaf| slopes.by(*leaf)).collect();
        let finite = |x: &f64| x.is_finite();
        if !slopes.values.iter().all(finite) || !columns.iter().flatten().all(finite) {
            return None;
        }
        let known = |size: f64| if size > 0.0 { size } else { 1.0 };
        let row = |i: usize| -> Vec<f64> { columns.iter().map(|column| column[i]).collect() };
        let lengths: Vec<f64> = (0..slopes.values.len()).map(|i| known(length(&row(i)))).collect();
        let at = |i: usize| -> f64 {
            let own = slopes.moving(i).map(|(leaf, slope)| {
                let value = match leaf {
                    Leaf::Parameter(_) | Leaf::Q(_) | Leaf::Lambda(_) => self.value(x, leaf),
                    _ => 0.0,
                };
                (slope * value).abs()
            });
            own.sum::<f64>() / lengths[i]
        };
        let terms = (0..slopes.values.len()).map(at).collect();
        for column in &mut columns {
            column
                .iter_mut()
                .zip(&lengths)
                .for_each(|(entry, length)| *entry /= length);
        }
        let place = self.unknowns.of_place();
        let scale = |(j, column): (usize, &Vec<f64>)| if j < place { 1.0 } else { known(length(column)) };
        let scales: Vec<f64> = columns.iter().enumerate().map(scale).collect();
        let matrix = Matrix::from_fn(lengths.len(), columns.len(), |i, j| columns[j][i] / scales[j]);
        let values = slopes
            .values
            .iter()
            .zip(&lengths)
            .map(|(value, length)| value / length)
            .collect();
        Some(Rows {
            slopes,
            matrix,
            columns: scales,
            lengths,
            values,
            terms,
        })
    }

    /// The value of a leaf, for the sizes of terms.
    fn value(&self, x: &[f64], leaf: Leaf) -> f64 {
        let place = self.unknowns.leaves().iter().position(|own| *own == leaf);
        match (place, leaf) {
            // the size of a turn is that of the unit vectors that it moves
            (_, Leaf::Q(i)) if self.is_turn(i) => 1.0,
            (Some(place), _) => x[place],
            (None, Leaf::Q(i)) => self.guess[i],
            (None, Leaf::Parameter(i)) => self.values[i],
            _ => 0.0,
        }
    }

    /// The equilibrium from the guess.
    pub(super) fn found(&self) -> Result<RestSolution, EquilibriumError> {
        let found = self.solved(self.first())?;
        let by_time = found.rows.slopes.by(Leaf::T);
        let mut scaled = by_time.iter().zip(&found.rows.lengths);
        if scaled.any(|(slope, length)| slope.abs() > CONSTANT * length) {
            return Err(EquilibriumError::TimeDependent {
                q: self.position(&found.x),
                t: self.t,
            });
        }
        Ok(found)
    }

    /// Newton's iteration.
    fn solved(&self, mut x: Vec<f64>) -> Result<RestSolution, EquilibriumError> {
        let mut rows = self.rows(&x).ok_or_else(|| self.undefined(&x))?;
        for iteration in 0..MAX_ITERATIONS {
            if rows.are_zero() {
                return Ok(RestSolution { x, rows });
            }
            let update = self.update(&rows, &x);
            let small = self.is_small(&update, &x);
            let Some((next, rows_there)) = self.improved(&x, &update, &rows) else {
                if small && rows.are_small(largest(&x)) {
                    return Ok(RestSolution { x, rows });
                }
                return Err(self.not_found(&x, &rows, iteration));
            };
            (x, rows) = (next, rows_there);
        }
        // at a multiple root each update is a fixed part of the one before, and the iteration does not settle.
        let update = self.update(&rows, &x);
        if self.is_small(&update, &x) && rows.are_small(largest(&x)) {
            return Ok(RestSolution { x, rows });
        }
        Err(self.not_found(&x, &rows, MAX_ITERATIONS))
    }

    /// The shortest update, limited so that no coordinate or parameter changes by more than itself and 1.
    fn update(&self, rows: &Rows, x: &[f64]) -> Vec<f64> {
        let singular = rows.matrix.decomposed();
        let [_, largest] = singular.extremes();
        let wanted: Vec<f64> = rows.values.iter().map(|value| -value).collect();
        let mut update = singular.solve(&wanted, ZERO * largest);
        update
            .iter_mut()
            .zip(&rows.columns)
            .for_each(|(update, scale)| *update /= scale);
        let place = self.unknowns.of_place();
        let longest = update.iter().zip(x).take(place);
        let longest = longest.fold(0.0_f64, |most, (update, x)| {
            most.max(update.abs() / x.abs().max(1.0))
        });
        if longest > 1.0 {
            for update in &mut update {
                *update /= longest;
            }
        }
        update
    }

    /// Whether an update changes coordinates and parameters only little.
    fn is_small(&self, update: &[f64], x: &[f64]) -> bool {
        let mut each = update.iter().zip(x).take(self.unknowns.of_place());
        each.all(|(update, x)| update.abs() <= SMALL * x.abs().max(1.0))
    }

    /// The unknowns after the largest part of an update, by halving, that makes the rows smaller.
    fn improved(&self, x: &[f64], update: &[f64], rows: &Rows) -> Option<(Vec<f64>, Rows)> {
        let size = length(&rows.values);
        let mut part = 1.0;
        for _ in 0..HALVINGS {
            let next = self.moved(x, update, part);
            if let Some(there) = self.rows(&next) {
                let compared = there.slopes.values.iter().zip(&rows.lengths);
                let compared: Vec<f64> = compared.map(|(value, length)| value / length).collect();
                if length(&compared) < (1.0 - 1e-4 * part) * size {
                    return Some((next, there));
                }
            }
            part *= 0.5;
        }
        None
    }

    /// The error of rows without a value.
    fn undefined(&self, x: &[f64]) -> EquilibriumError {
        let (q, values) = (self.position(x), self.parameters(x));
        let still = vec![0.0; q.len()];
        let point = AnyPoint {
            t: self.t,
            q: &q,
            v: &still,
            a: &still,
        };
        let undefined = undefined::of_point(&self.declaration.with(&values), point).map(Box::new);
        EquilibriumError::Undefined {
            guess: self.guess.to_vec(),
            q,
            undefined,
        }
    }

    /// The error of an iteration that ends early.
    fn not_found(&self, x: &[f64], rows: &Rows, iterations: u32) -> EquilibriumError {
        let q = self.position(x);
        let [holonomic, nonholonomic, _] = self.declaration.constraints();
        // the rows of velocities come last: c(t, q, 0), then dg/dt
        let first = rows.values.len().saturating_sub(holonomic + nonholonomic);
        for (place, value) in rows.slopes.values.iter().skip(first).enumerate() {
            let moves = rows.matrix.row(first + place).any(|slope| slope != 0.0);
            if *value != 0.0 && !moves {
                let (constraint, index) = match place.checked_sub(nonholonomic) {
                    None => ("nonholonomic constraint", place),
                    Some(index) => ("holonomic constraint", index),
                };
                return EquilibriumError::Moving {
                    constraint,
                    index,
                    value: *value,
                    q,
                };
            }
        }
        EquilibriumError::NotFound {
            guess: self.guess.to_vec(),
            residual: largest(&rows.slopes.values),
            q,
            iterations,
        }
    }

    /// The directions in which other equilibria lie: changes of the position, then of the free parameters, an orthonormal basis.
    pub(super) fn continuum(&self, found: &RestSolution) -> Vec<Vec<f64>> {
        let place = self.unknowns.of_place();
        let singular = found.rows.matrix.decomposed();
        let [_, largest] = singular.extremes();
        let terms = singular.values.iter().zip(&singular.right);
        let bound: Vec<Vec<f64>> = terms
            .filter(|(value, _)| **value > ZERO * largest)
            .map(|(_, right)| right.clone())
            .collect();
        let open = Basis::of(found.x.len(), &bound).vectors;
        let mut directions: Vec<Vec<f64>> = Vec::new();
        for direction in open {
            // multipliers may be undetermined where coordinates are not
            let mut own = direction[..place].to_vec();
            for known in &directions {
                let part = inner_product(&own, known);
                own.iter_mut()
                    .zip(known)
                    .for_each(|(x, known)| *x -= part * known);
            }
            let size = length(&own);
            if size <= ZERO {
                continue;
            }
            for x in &mut own {
                *x /= size;
            }
            if self.goes_on(found, &own) {
                directions.push(own);
            }
        }
        directions.iter().map(|own| self.whole(own)).collect()
    }

    /// Whether there are other equilibria along a direction: from a point there, the iteration does not lead
    /// back.
    fn goes_on(&self, found: &RestSolution, direction: &[f64]) -> bool {
        let size = found
            .x
            .iter()
            .take(direction.len())
            .fold(1.0_f64, |most, x| most.max(x.abs()));
        let mut by = vec![0.0; found.x.len()];
        by.iter_mut().zip(direction).for_each(|(by, own)| *by = *own);
        let beside = self.moved(&found.x, &by, FAR * size);
        let Ok(other) = self.solved(beside) else {
            return false;
        };
        let mut apart: Vec<f64> = other.x.iter().zip(&found.x).map(|(x, y)| x - y).collect();
        let turns = self.apart(&self.position(&found.x), &self.position(&other.x));
        self.put_turns(&turns, &mut apart);
        inner_product(&apart, direction) >= 0.5 * FAR * size
    }

    /// A direction of all coordinates and free parameters, with zeros for the held coordinates.
    fn whole(&self, own: &[f64]) -> Vec<f64> {
        let (coordinates, parameters) = own.split_at(self.unknowns.coordinates.len());
        let mut whole = vec![0.0; self.guess.len()];
        for (&i, x) in self.unknowns.coordinates.iter().zip(coordinates) {
            whole[i] = *x;
        }
        whole.extend(parameters);
        whole
    }
}
