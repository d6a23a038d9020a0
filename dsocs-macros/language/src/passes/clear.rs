//! Denominators multiplied out of rows.
//!
//! A row vanishes where a multiple of it does. So a denominator that is a square root or a sum of squares is
//! multiplied out where this spares the iteration a division: a curvature `v×a/|v|³ - κ` becomes
//! `v×a - κ|v|³`, which also suits Newton's iteration better, since it does not flatten out far from its
//! root. Factors of the parameters and of `h` that all terms share are dropped. The factor of a row is kept
//! ([`ScaledRow::scale`]): where it vanishes, a root of the product is no root of the declared row.

use std::collections::BTreeMap;

use crate::graph::{Graph, Leaf, Node, NodeId, Unary};

/// The most terms of a row whose denominator is multiplied out, since every term is multiplied.
const MOST_TERMS: usize = 6;

/// A declared row times a factor.
#[derive(Clone, Copy)]
pub(crate) struct ScaledRow {
    /// The product.
    pub(crate) row: NodeId,
    /// The factor times the row formed by subtraction, for derivatives (see [`crate::mechanics::Equation`]).
    pub(crate) by_subtraction: NodeId,
    /// The factor.
    pub(crate) scale: NodeId,
}

impl ScaledRow {
    /// A row as it was declared, with the factor 1.
    pub(crate) fn untouched(graph: &mut Graph, row: NodeId, by_subtraction: NodeId) -> Self {
        let scale = graph.constant(1.0);
        Self {
            row,
            by_subtraction,
            scale,
        }
    }

    /// The expressions, for passes to rewrite.
    pub(crate) fn parts(&mut self) -> impl Iterator<Item = &mut NodeId> {
        [&mut self.row, &mut self.by_subtraction, &mut self.scale].into_iter()
    }

    /// The row with its denominator multiplied out, if it has one that contains unknowns and is not negative.
    pub(crate) fn without_denominator(self, graph: &mut Graph) -> Self {
        let (terms, _) = graph.terms(self.row);
        let Some((base, halves)) = denominator(graph, &terms) else {
            return self;
        };
        let (root, n) = root_power(graph, base, halves);
        let factor = graph.powi(root, n);
        Self {
            row: times_power(graph, self.row, base, halves),
            by_subtraction: times_power(graph, self.by_subtraction, base, halves),
            scale: graph.mul(self.scale, factor),
        }
    }

    /// The row without the factors of the parameters and the step that all its terms share.
    pub(crate) fn without_common_factor(self, graph: &mut Graph) -> Self {
        let (terms, constant) = graph.terms(self.row);
        if constant != 0.0 || graph.as_constant(self.row).is_some() {
            return self;
        }
        let inverse: Vec<_> = graph
            .common_factors(&terms)
            .into_iter()
            .map(|(base, n)| (base, -n))
            .collect();
        let size = terms[0].1.abs();
        #[allow(clippy::float_cmp)] // coefficients that are the same number
        let same = terms.iter().all(|&(_, c)| c.abs() == size);
        let inverse = graph.product(&inverse);
        let inverse = graph.scale(if same { size.recip() } else { 1.0 }, inverse);
        Self {
            row: times(graph, self.row, inverse),
            by_subtraction: times(graph, self.by_subtraction, inverse),
            scale: graph.mul(self.scale, inverse),
        }
    }
}

/// A sum times a factor, term by term.
fn times(graph: &mut Graph, sum: NodeId, factor: NodeId) -> NodeId {
    let (terms, constant) = graph.terms(sum);
    let mut products: Vec<_> = terms
        .iter()
        .map(|&(term, c)| (graph.mul(term, factor), c))
        .collect();
    products.push((factor, constant));
    graph.linear(0.0, &products)
}

/// A sum times `base` to the power `halves/2`, term by term.
fn times_power(graph: &mut Graph, sum: NodeId, base: NodeId, halves: i32) -> NodeId {
    let (mut terms, constant) = graph.terms(sum);
    if constant != 0.0 {
        terms.push((graph.constant(1.0), constant));
    }
    let mut products = Vec::new();
    for (term, c) in terms {
        let (mut factors, mut power) = (Vec::new(), halves);
        for (factor, n) in graph.factors(term) {
            match half_power(graph, factor, n) {
                (inner, present) if inner == base => power += present,
                _ => factors.push((factor, n)),
            }
        }
        factors.push(root_power(graph, base, power));
        products.push((graph.product(&factors), c));
    }
    graph.linear(0.0, &products)
}

/// The base and the exponent of a factor in halves: `√x` to the power `n` is `n` halves of `x`.
fn half_power(graph: &Graph, factor: NodeId, n: i32) -> (NodeId, i32) {
    match graph.node(factor) {
        Node::Unary(Unary::Sqrt, inner) => (*inner, n),
        _ => (factor, 2 * n),
    }
}

/// `base` to the power `halves/2`, as a base and an exponent: the base or, for odd numbers of halves, its
/// root.
fn root_power(graph: &mut Graph, base: NodeId, halves: i32) -> (NodeId, i32) {
    if halves % 2 == 0 {
        (base, halves / 2)
    } else {
        (graph.unary(Unary::Sqrt, base), halves)
    }
}

/// The only denominator that contains unknowns, and its largest power in halves; `None` if it may not be
/// multiplied out.
fn denominator(graph: &Graph, terms: &[(NodeId, f64)]) -> Option<(NodeId, i32)> {
    let mut least: BTreeMap<NodeId, (i32, bool)> = BTreeMap::new();
    for &(term, _) in terms {
        for (factor, n) in graph.factors(term) {
            let unknown = graph
                .leaves(factor)
                .any(|leaf| matches!(leaf, Leaf::E(_) | Leaf::Z(_)));
            let (base, halves) = half_power(graph, factor, n);
            if unknown && n < 0 {
                let entry = least.entry(base).or_insert((0, graph.is_sum_of_squares(base)));
                entry.0 = entry.0.min(halves);
                entry.1 |= base != factor;
            }
        }
    }
    let (base, (halves, positive)) = least.pop_first()?;
    (least.is_empty() && positive && terms.len() <= MOST_TERMS).then_some((base, -halves))
}
