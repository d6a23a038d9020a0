//! Whether a coefficient has to be nonzero for the rows to have one solution.
//!
//! Nothing is known of a parameter: a stiffness may be zero, and so may the sum of a mass and a stiffness.
//! Division by such a coefficient is safe only if the rows are singular anyhow where it is zero, as with a
//! mass that multiplies a whole row. That is decided as in [`crate::graph::zeros::identity`]: each way in which the
//! coefficient can become zero is put into the rows' slopes, and their determinant is evaluated modulo the
//! prime. A determinant that is zero at the random points counts as zero. Where one is not, or where not all
//! zeros of the coefficient are found, the answer is no.

use std::collections::{BTreeMap, BTreeSet};

use crate::hash::HashMap;

use crate::graph::zeros::identity::{
    POINTS, Residues, add, invert, multiply, random, signed_power, subtract,
};
use crate::graph::{Graph, Node, NodeId, Unary};

/// Seeds for the values of an atom at which an expression is evaluated.
const SAMPLES: [u64; 3] = [3, 5, 7];
/// The highest power of a parameter that is recognised.
const HIGHEST_POWER: i32 = 8;

/// The derivatives of rows by the unknowns, sparse.
pub(crate) struct Slopes {
    /// For each row its nonzero entries, each with the place of the unknown.
    pub(crate) rows: Vec<Vec<(usize, NodeId)>>,
    /// The number of unknowns.
    pub(crate) columns: usize,
}

/// An atom, that is an expression of the parameters, and a value for it.
type AtomValue = (NodeId, u64);

impl Graph {
    /// Whether the determinant of `slopes` is zero wherever the coefficient, an expression of the parameters and `h`, is zero.
    pub(crate) fn has_to_be_nonzero(&mut self, coefficient: NodeId, slopes: &Slopes) -> bool {
        if let Node::Product(factors) = self.node(coefficient).clone() {
            return factors
                .into_iter()
                .all(|(factor, exponent)| exponent < 0 || self.has_to_be_nonzero(factor, slopes));
        }
        // `h` is never zero, and an expression of `h` alone is the user's choice of the step
        let mut unknown = Vec::new();
        self.atoms(coefficient, &mut unknown);
        (0..POINTS).all(|point| {
            let zeros = self.zeros(coefficient, &unknown, point);
            zeros.is_some_and(|zeros| {
                zeros
                    .into_iter()
                    .all(|zero| self.is_singular_at(slopes, point, zero))
            })
        })
    }

    /// The atoms of an expression: the expressions of the parameters of which it is a sum of products.
    fn atoms(&self, id: NodeId, found: &mut Vec<NodeId>) {
        match self.node(id) {
            Node::Sum(..) | Node::Product(_) => {
                for part in self.parts(id) {
                    self.atoms(part, found);
                }
            }
            _ if self.has_parameters(id) && !found.contains(&id) => found.push(id),
            _ => {}
        }
    }

    /// Whether an expression has a parameter in it.
    pub(crate) fn has_parameters(&self, id: NodeId) -> bool {
        let mut all = self.subexpressions([id], |_| true).into_iter();
        all.any(|id| matches!(self.node(id), Node::Param(_)))
    }

    /// Points at which the coefficient is zero, one on each factor of its numerator, with all atoms but one
    /// at random values; `None` where factors may be missing.
    ///
    /// A factor that is linear in an atom is zero at one value of this atom. A power of an atom is zero with
    /// it. Any other factor contains no atom in which the coefficient is linear. It then divides the slope by
    /// each of these atoms, and there is none with a given atom if one such slope does not depend on that
    /// atom.
    fn zeros(&self, coefficient: NodeId, atoms: &[NodeId], point: usize) -> Option<Vec<AtomValue>> {
        let mut zeros = Vec::new();
        let mut linear = Vec::new();
        let mut others = Vec::new();
        for &atom in atoms {
            if let Node::Unary(Unary::Exp | Unary::Cosh, _) = self.node(atom) {
                continue;
            }
            let fit = self.affine_fit(coefficient, atom, point, None)?;
            if fit.is_affine && fit.slope == 0 {
                continue; // it cancels
            }
            if fit.is_affine {
                linear.push(atom);
                zeros.push((atom, fit.root()));
            } else {
                others.push(atom);
            }
        }
        for atom in others {
            let value = random(SAMPLES[0]);
            let free = linear.iter().any(|&other| {
                let fits = [None, Some((atom, value))]
                    .map(|given| self.affine_fit(coefficient, other, point, given));
                matches!(fits, [Some(one), Some(two)] if one.slope == two.slope)
            });
            if free {
                continue;
            }
            let exponent = self.exponent(coefficient, atom, point)?;
            if exponent > 0 {
                zeros.push((atom, 0));
            }
        }
        Some(zeros)
    }

    /// An expression as a function of one atom, with a value given for another one.
    fn affine_fit(
        &self,
        id: NodeId,
        atom: NodeId,
        point: usize,
        other: Option<AtomValue>,
    ) -> Option<AffineFit> {
        let samples = SAMPLES.map(random);
        let [first, second, third] = self.values_over(id, atom, point, other, samples)?;
        let run = invert(subtract(samples[1], samples[0]));
        let slope = multiply(subtract(second, first), run);
        let expected = add(first, multiply(slope, subtract(samples[2], samples[0])));
        Some(AffineFit {
            sample: samples[0],
            value: first,
            slope,
            is_affine: expected == third,
        })
    }

    /// The exponent of an atom, if the expression is a power of it times something independent of it.
    fn exponent(&self, id: NodeId, atom: NodeId, point: usize) -> Option<i32> {
        let samples = SAMPLES.map(random);
        let values = self.values_over(id, atom, point, None, samples)?;
        (-HIGHEST_POWER..=HIGHEST_POWER).find(|&exponent| {
            let [one, two, three] = samples.map(|sample| signed_power(sample, exponent));
            multiply(values[0], two) == multiply(values[1], one)
                && multiply(values[0], three) == multiply(values[2], one)
        })
    }

    /// The values of an expression at some values of an atom.
    fn values_over<const N: usize>(
        &self,
        id: NodeId,
        atom: NodeId,
        point: usize,
        other: Option<AtomValue>,
        samples: [u64; N],
    ) -> Option<[u64; N]> {
        let mut values = [0; N];
        for (value, sample) in values.iter_mut().zip(samples) {
            let set = [Some((atom, sample)), other].into_iter().flatten();
            let mut known: Residues = set.map(|(node, value)| (node, Some(value))).collect();
            *value = self.residue_with(id, point, &mut known)?;
        }
        Some(values)
    }

    /// Whether the determinant of `slopes` is zero, or does not exist, where an atom has a value.
    fn is_singular_at(&mut self, slopes: &Slopes, point: usize, (atom, value): AtomValue) -> bool {
        let mut known: Residues = HashMap::from_iter([(atom, Some(value))]);
        if slopes.columns != slopes.rows.len() {
            return false;
        }
        let mut matrix = Vec::with_capacity(slopes.columns);
        for row in &slopes.rows {
            let mut residues = BTreeMap::new();
            for &(place, slope) in row {
                match self.residue_with(slope, point, &mut known) {
                    Some(0) => {}
                    Some(residue) => {
                        residues.insert(place, residue);
                    }
                    // a denominator that is zero at this value alone: the rows do not exist there
                    None => return self.residue(slope, point).is_some(),
                }
            }
            matrix.push(residues);
        }
        determinant_is_zero(matrix)
    }
}

/// An expression as a function of one atom, at random values of the others.
struct AffineFit {
    /// The value of the atom.
    sample: u64,
    /// The value of the expression there.
    value: u64,
    slope: u64,
    /// Whether it is affine in the atom.
    is_affine: bool,
}

impl AffineFit {
    /// The value of the atom at which the expression is zero.
    fn root(&self) -> u64 {
        subtract(self.sample, multiply(self.value, invert(self.slope)))
    }
}

/// Whether the determinant of some sparse rows is zero modulo the prime.
fn determinant_is_zero(mut rows: Vec<BTreeMap<usize, u64>>) -> bool {
    let mut columns: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); rows.len()];
    for (place, row) in rows.iter().enumerate() {
        for &column in row.keys() {
            columns[column].insert(place);
        }
    }
    for column in 0..rows.len() {
        // the row with the fewest entries, since it fills in least
        let Some(&pivot) = columns[column].iter().min_by_key(|&&row| rows[row].len()) else {
            return true;
        };
        let top = std::mem::take(&mut rows[pivot]);
        for &place in top.keys() {
            columns[place].remove(&pivot);
        }
        let inverse = invert(top[&column]);
        for row in columns[column].clone() {
            let factor = multiply(rows[row][&column], inverse);
            for (&place, &above) in &top {
                let entry = rows[row].get(&place).copied().unwrap_or_default();
                match subtract(entry, multiply(factor, above)) {
                    0 => {
                        rows[row].remove(&place);
                        columns[place].remove(&row);
                    }
                    entry => {
                        rows[row].insert(place, entry);
                        columns[place].insert(row);
                    }
                }
            }
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use quote::quote;

    fn slopes(rows: &[Vec<NodeId>]) -> Slopes {
        Slopes {
            rows: rows
                .iter()
                .map(|row| row.iter().copied().enumerate().collect())
                .collect(),
            columns: rows.first().map_or(0, Vec::len),
        }
    }

    fn parameters(graph: &mut Graph) -> [NodeId; 3] {
        [quote!(a), quote!(b), quote!(k)].map(|name| graph.param(name))
    }

    #[test]
    fn what_the_rows_can_do_without_may_be_zero() {
        let mut graph = Graph::new();
        let [a, b, k] = parameters(&mut graph);
        let (off, sum) = (graph.neg(k), graph.add(b, k));
        let slopes = slopes(&[vec![a, off], vec![off, sum]]);
        for coefficient in [a, b, k, sum, off] {
            assert!(!graph.has_to_be_nonzero(coefficient, &slopes));
        }
        let two = graph.constant(2.0);
        assert!(graph.has_to_be_nonzero(two, &slopes));
        // b + k - k²/a: the second row after elimination of the first
        let quotient = graph.product(&[(k, 2), (a, -1)]);
        let left = graph.sub(sum, quotient);
        assert!(graph.has_to_be_nonzero(left, &slopes));
    }

    #[test]
    fn what_makes_the_rows_singular_has_to_be_nonzero() {
        let mut graph = Graph::new();
        let [a, b, k] = parameters(&mut graph);
        let zero = graph.constant(0.0);
        let slopes = slopes(&[vec![a, zero], vec![zero, b]]);
        let (power, ratio) = (graph.product(&[(a, 2), (b, 1)]), graph.div(a, k));
        for coefficient in [a, b, power, ratio] {
            assert!(graph.has_to_be_nonzero(coefficient, &slopes));
        }
        let (product, sum) = (graph.mul(a, k), graph.add(a, b));
        for coefficient in [k, product, sum] {
            assert!(!graph.has_to_be_nonzero(coefficient, &slopes));
        }
    }

    #[test]
    fn every_factor_of_a_sum_is_looked_at() {
        let mut graph = Graph::new();
        let [a, b, k] = parameters(&mut graph);
        let squares = [graph.powi(k, 2), graph.powi(b, 2)];
        // a k² + a k⁴ is zero with `k` too, and a k² + a b² where k² + b² is
        let high = [graph.mul(a, squares[0]), graph.product(&[(a, 1), (k, 4)])];
        let pair = squares.map(|square| graph.mul(a, square));
        for terms in [high, pair] {
            let sum = graph.sum(&terms);
            assert!(!graph.has_to_be_nonzero(sum, &slopes(&[vec![a]])));
        }
        // a k² + a² k² is zero where `a` is 0 or -1, and where `k` is 0
        let terms = [graph.mul(a, squares[0]), graph.product(&[(a, 2), (k, 2)])];
        let sum = graph.sum(&terms);
        assert!(!graph.has_to_be_nonzero(sum, &slopes(&[vec![a]])));
        // a + k² is irreducible
        let sum = graph.sum(&[a, squares[0]]);
        assert!(graph.has_to_be_nonzero(sum, &slopes(&[vec![sum]])));
        assert!(!graph.has_to_be_nonzero(sum, &slopes(&[vec![a]])));
    }
}
