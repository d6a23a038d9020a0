//! Whether a declared factor divides its constraint.
//!
//! It does where the constraint is zero with it, as far as the other equations of the continuous system hold. That is tried at random
//! points of this kind, found by Newton's method. What cannot be tried is believed: a factor without a zero, a function of the user's.

use crate::graph::{Graph, Leaf, NodeId};
use crate::model::{Kind, Model};

/// From how many random points it is tried.
const TRIES: u64 = 12;
/// So many of them have to be found.
const ENOUGH: usize = 3;
/// Newton's steps from each.
const STEPS: usize = 60;
/// A residual below this fraction of its terms is zero.
const ZERO: f64 = 1e-11;
/// A constraint above this fraction of its terms is not.
const NOT_ZERO: f64 = 1e-6;

/// Whether the factor of a constraint, by its place, is certainly none: at every point that was found where it and all other equations
/// are zero, the constraint is not.
pub(crate) fn is_no_factor(model: &Model, place: usize) -> bool {
    let Some(factor) = model.constraints.get(place).and_then(|row| row.divide) else {
        return false;
    };
    let mut graph = model.graph.clone();
    let equations = super::continuous(model, &mut graph);
    let mut zeros = vec![factor];
    for (other, row) in equations.rows.iter().enumerate() {
        if other != place {
            zeros.push(match row.divide {
                Some(factor) => graph.div(row.value, factor),
                None => row.value,
            });
        }
    }
    if model.constraints.iter().any(|row| row.kind != Kind::Kinematic) {
        zeros.extend(super::phase(model, &mut graph));
    }
    let constraint = equations.rows[place].value;
    let trial = Trial::new(&mut graph, &zeros, constraint);
    let mut found = 0;
    for rest in (1..=TRIES).filter_map(|seed| trial.at(&graph, seed)) {
        // one point where the constraint is zero decides
        if rest.is_nan() || rest <= NOT_ZERO {
            return false;
        }
        found += 1;
    }
    found >= ENOUGH
}

/// What has to be zero, and the constraint that is looked at there.
struct Trial {
    leaves: Vec<Leaf>,
    /// The expressions that have to be zero, each followed by its derivatives by the leaves; then the constraint, likewise.
    rows: Vec<NodeId>,
}

impl Trial {
    fn new(graph: &mut Graph, zeros: &[NodeId], constraint: NodeId) -> Self {
        let all: Vec<NodeId> = zeros.iter().copied().chain([constraint]).collect();
        let mut leaves: Vec<Leaf> = all.iter().flat_map(|&row| graph.leaves(row)).collect();
        leaves.sort_unstable();
        leaves.dedup();
        let mut rows = Vec::new();
        for row in all {
            rows.push(row);
            rows.extend(leaves.iter().map(|&leaf| graph.derivative(row, leaf)));
        }
        Self { leaves, rows }
    }

    /// The constraint as a fraction of its terms, at a point near a random one where all else is zero, if one is found.
    fn at(&self, graph: &Graph, seed: u64) -> Option<f64> {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut point: Vec<f64> = self.leaves.iter().map(|_| random.next() * 3.0 - 1.5).collect();
        let param =
            |which: usize| Random(seed ^ (which as u64 + 1).wrapping_mul(0x2545_f491_4f6c_dd1d)).next() + 0.5;
        for _ in 0..STEPS {
            let leaf = |which: Leaf| {
                let place = self.leaves.binary_search(&which);
                place
                    .ok()
                    .and_then(|place| point.get(place).copied())
                    .unwrap_or(f64::NAN)
            };
            let values = graph.values(&self.rows, &leaf, &param)?;
            if values.iter().any(|value| !value.is_finite()) {
                return None;
            }
            let rows: Vec<&[f64]> = values.chunks(self.leaves.len() + 1).collect();
            // each in units of its terms
            let part = |row: &[f64]| {
                let terms = row[1..].iter().zip(&point).map(|(slope, x)| (slope * x).abs());
                row[0].abs() / (row[0].abs() + terms.sum::<f64>()).max(f64::MIN_POSITIVE)
            };
            let (constraint, zeros) = rows.split_last()?;
            if zeros.iter().all(|row| row[0] == 0.0 || part(row) < ZERO) {
                return Some(part(constraint));
            }
            for (x, step) in point.iter_mut().zip(shortest(zeros)?) {
                *x -= step;
            }
        }
        None
    }
}

/// The shortest of the solutions `x` of `J x = r`, where each row is `r` and then its part of `J`; `None` where the rows are dependent.
fn shortest(rows: &[&[f64]]) -> Option<Vec<f64>> {
    let m = rows.len();
    let dot = |a: &[f64], b: &[f64]| a[1..].iter().zip(&b[1..]).map(|(a, b)| a * b).sum::<f64>();
    // J Jᵀ y = r
    let mut system: Vec<Vec<f64>> = rows
        .iter()
        .map(|row| rows.iter().map(|other| dot(row, other)).chain([row[0]]).collect())
        .collect();
    for column in 0..m {
        let pivot =
            (column..m).max_by(|&a, &b| system[a][column].abs().total_cmp(&system[b][column].abs()))?;
        system.swap(column, pivot);
        let (before, rest) = system.split_at_mut(column + 1);
        let pivot = &before[column];
        if pivot[column] == 0.0 {
            return None;
        }
        for row in rest {
            let factor = row[column] / pivot[column];
            for (entry, above) in row.iter_mut().zip(pivot) {
                *entry -= factor * above;
            }
        }
    }
    let mut y = vec![0.0; m];
    for i in (0..m).rev() {
        let known: f64 = (i + 1..m).map(|j| system[i][j] * y[j]).sum();
        y[i] = (system[i][m] - known) / system[i][i];
    }
    let n = rows.first()?.len() - 1;
    let x = (0..n).map(|j| rows.iter().zip(&y).map(|(row, y)| row[j + 1] * y).sum());
    Some(x.collect())
}

/// Numbers between 0 and 1, the same at every compilation.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        // xorshift64*
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
