//! Whether a declared factor divides its constraint.
//!
//! It does if the constraint is zero wherever the factor and the other equations of the continuous system are. This is tested at random
//! points of this kind, found by Newton's method. A factor that cannot be tested is accepted: one without a zero, or with a user's function.

use crate::graph::{Graph, Leaf, NodeId};
use crate::model::{Kind, Model};

/// The number of random starting points.
const TRIES: u64 = 12;
/// The least number of points found for a verdict.
const ENOUGH: usize = 3;
/// The number of Newton steps from each starting point.
const STEPS: usize = 60;
/// A residual below this fraction of its terms counts as zero.
const ZERO: f64 = 1e-11;
/// A constraint above this fraction of its terms counts as nonzero.
const NOT_ZERO: f64 = 1e-6;

/// Whether an expression declared as a factor of a constraint certainly does not divide it: at every point found where it and all other
/// equations are zero, the constraint is not.
pub(crate) fn is_no_factor(model: &Model, place: usize) -> bool {
    let Some(factor) = model.constraints.get(place).and_then(|row| row.divide) else {
        return false;
    };
    let mut graph = model.graph.clone();
    let equations = crate::mechanics::continuous(model, &mut graph);
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
        zeros.extend(crate::mechanics::phase(model, &mut graph));
    }
    let constraint = equations.rows[place].value;
    let trial = Trial::new(&mut graph, &zeros, constraint);
    let mut found = 0;
    for rest in (1..=TRIES).filter_map(|seed| trial.at(&graph, seed)) {
        // one point where the constraint is zero suffices: the factor is accepted
        if rest.is_nan() || rest <= NOT_ZERO {
            return false;
        }
        found += 1;
    }
    found >= ENOUGH
}

/// The equations of the trial, with their derivatives.
struct Trial {
    leaves: Vec<Leaf>,
    /// Each expression that has to be zero, followed by its derivatives by the leaves; last the constraint,
    /// likewise.
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

    /// The constraint as a fraction of its terms, at a point found near a random one where all else is zero.
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
            // the residual as a fraction of the row's terms
            let part = |row: &[f64]| {
                let terms = row[1..].iter().zip(&point).map(|(slope, x)| (slope * x).abs());
                row[0].abs() / (row[0].abs() + terms.sum::<f64>()).max(f64::MIN_POSITIVE)
            };
            let (constraint, zeros) = rows.split_last()?;
            if zeros.iter().all(|row| row[0] == 0.0 || part(row) < ZERO) {
                return Some(part(constraint));
            }
            for (x, step) in point.iter_mut().zip(least_norm_solution(zeros)?) {
                *x -= step;
            }
        }
        None
    }
}

/// The shortest solution `x` of `J x = r`, where each row is `r` followed by its row of `J`; `None` where the
/// rows are dependent.
fn least_norm_solution(rows: &[&[f64]]) -> Option<Vec<f64>> {
    let m = rows.len();
    let dot = |a: &[f64], b: &[f64]| a[1..].iter().zip(&b[1..]).map(|(a, b)| a * b).sum::<f64>();
    // the normal equations J Jᵀ y = r
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

/// Pseudo-random numbers between 0 and 1, the same at every compilation.
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
