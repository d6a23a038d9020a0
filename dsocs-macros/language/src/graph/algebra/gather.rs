//! Products of functions of two coordinates, gathered by coordinates.
//!
//! The momentum of link `i` of a chain is `Σ_j m_ij (cᵢ cⱼ vⱼ + sᵢ sⱼ vⱼ)`. With the factors of link `i`
//! taken out it is `cᵢ Σ_j m_ij cⱼ vⱼ + sᵢ Σ_j m_ij sⱼ vⱼ`. The products `cⱼ vⱼ` and their changes then serve
//! every row, and where the `m_ij` share factors, the sums are running sums ([`crate::program`]). So
//! the rows have as many products as links, not as pairs of links. An entry of the Jacobian keeps a product
//! of a factor of its row and a factor of its column, or two: with angles `m_ij (aᵢ bⱼ + cᵢ dⱼ)`.
//!
//! A sum that depends on one coordinate is never multiplied out, nor is one that is affine in coordinates:
//! multiplied out, a difference of positions would lose digits.

use super::horner::{Ties, gather};
use super::polynomial::{Expansion, MOST_TERMS, Monomial};
use super::{group, simplify};
use crate::graph::{Graph, Leaf, Node, NodeId};

/// The least number of coordinates for which anything is gathered.
const FEWEST: usize = 4;
/// The most terms of an entry of a Jacobian that is multiplied out.
const MOST_IN_ENTRY: usize = 16;

/// The derivatives of a Lagrangian by its coordinates, then by its velocities, with few products; `None`
/// where there are few coordinates or little is spared.
pub(crate) fn slopes(graph: &mut Graph, slopes: &[NodeId]) -> Option<Vec<NodeId>> {
    if slopes.len() < 2 * FEWEST {
        return None;
    }
    let mut expansion = expansion(MOST_TERMS);
    let coordinates = slopes.len() / 2;
    let slope = |&slope: &NodeId| group::slope(graph, coordinates, slope);
    let grouped: Vec<NodeId> = slopes.iter().map(slope).collect();
    let gathered: Option<Vec<NodeId>> = grouped
        .iter()
        .map(|&slope| {
            let polynomial = expansion.polynomial(graph, slope)?;
            let terms = polynomial
                .iter()
                .map(|(monomial, &coefficient)| {
                    (monomial.clone(), simplify::factored_sum(graph, coefficient))
                })
                .collect();
            Some(gather(graph, terms, Ties::FewestCoordinates))
        })
        .collect();
    gathered.filter(|gathered| spares_operations(graph, slopes, gathered))
}

/// Gathers the entries of a Jacobian that depend on two coordinates. Entries that depend on more are
/// multiplied out where terms cancel then.
pub(crate) fn entries(graph: &mut Graph, jacobian: &mut [Vec<NodeId>]) {
    if jacobian.len() < FEWEST {
        return;
    }
    let mut expansion = expansion(MOST_IN_ENTRY);
    let before = jacobian.concat();
    let after: Vec<NodeId> = before
        .iter()
        .map(|&entry| gathered_entry(graph, &mut expansion, entry))
        .collect();
    if spares_operations(graph, &before, &after) {
        for (entry, gathered) in jacobian.iter_mut().flatten().zip(after) {
            *entry = gathered;
        }
    }
}

/// Whether more than an eighth of the operations is spared.
fn spares_operations(graph: &Graph, before: &[NodeId], after: &[NodeId]) -> bool {
    operations(graph, after) * 8 < operations(graph, before) * 7
}

/// The number of additions and multiplications in some expressions, common subexpressions counted once.
fn operations(graph: &Graph, outputs: &[NodeId]) -> usize {
    let mut count = 0;
    for id in graph.subexpressions(outputs.iter().copied(), |id| !is_early(graph, id)) {
        count += match graph.node(id) {
            Node::Sum(_, terms) => terms.len(),
            Node::Product(factors) => {
                let late = factors.iter().filter(|&&(factor, _)| !is_early(graph, factor));
                let products = late.map(|&(_, n)| n.unsigned_abs() as usize).sum::<usize>();
                products - usize::from(products == factors.len() && products > 0)
            }
            _ => 1,
        };
    }
    count
}

/// Whether an expression depends on the parameters and the step alone, so that it is known when the run
/// begins.
fn is_early(graph: &Graph, id: NodeId) -> bool {
    graph.leaves(id).all(|leaf| leaf == Leaf::H)
}

/// The number of coordinates that an expression depends on; 3 stands for three or more.
fn coordinates(graph: &Graph, id: NodeId) -> usize {
    let (mut found, mut count) = ([0; 3], 0);
    for place in graph.leaves(id).filter_map(Leaf::place) {
        if !found[..count].contains(&place) {
            found[count] = place;
            count += 1;
            if count == found.len() {
                break;
            }
        }
    }
    count
}

/// Whether a sum is never multiplied out.
pub(super) fn is_never_expanded(graph: &Graph, sum: NodeId) -> bool {
    coordinates(graph, sum) < 2 || is_affine(graph, sum)
}

/// Whether a sum is affine in the leaves, with fixed coefficients.
fn is_affine(graph: &Graph, sum: NodeId) -> bool {
    let is_leaf = |factor: NodeId| graph.is_fixed(factor) || matches!(graph.node(factor), Node::Leaf(_));
    let is_affine = |term: NodeId| match graph.node(term) {
        Node::Product(factors) => {
            let mut moving = factors.iter().filter(|&&(factor, _)| !graph.is_fixed(factor));
            let first = moving.next();
            moving.next().is_none() && first.is_none_or(|&(factor, n)| n == 1 && is_leaf(factor))
        }
        _ => is_leaf(term),
    };
    match graph.node(sum) {
        Node::Sum(_, terms) => terms.iter().all(|&(term, _)| is_affine(term)),
        _ => is_affine(sum),
    }
}

/// An expansion of sums of several coordinates that are not affine.
fn expansion(most_terms: usize) -> Expansion {
    Expansion::new(most_terms, 1, |graph, sum| {
        // without its common fixed factor, the sum is the same node in every row
        is_never_expanded(graph, sum).then(|| without_common(graph, sum))
    })
}

/// An entry of a Jacobian, gathered.
fn gathered_entry(graph: &mut Graph, expansion: &mut Expansion, entry: NodeId) -> NodeId {
    match coordinates(graph, entry) {
        0 | 1 => return entry,
        2 => {}
        _ => return without_brackets(graph, entry),
    }
    let Some(polynomial) = expansion.polynomial(graph, entry) else {
        return entry;
    };
    let one = graph.constant(1.0);
    let terms: Vec<_> = polynomial
        .iter()
        .map(|(monomial, &coefficient)| {
            // fixed coefficients are factors like the others
            let (c, rest) = graph.split(coefficient);
            let mut factors: Monomial = if rest == one {
                Vec::new()
            } else {
                graph.factors(rest)
            };
            factors.extend_from_slice(monomial);
            (factors, graph.constant(c))
        })
        .collect();
    gather(graph, terms, Ties::FewestCoordinates)
}

/// The fixed factor that all terms of a sum share, and the sum divided by it.
fn without_common(graph: &mut Graph, sum: NodeId) -> [NodeId; 2] {
    let (terms, constant) = graph.terms(sum);
    if constant != 0.0 {
        return [graph.constant(1.0), sum];
    }
    let mut common = graph.common_factors(&terms);
    common.retain(|&(factor, _)| graph.is_fixed(factor));
    let inverse: Vec<_> = common.iter().map(|&(factor, n)| (factor, -n)).collect();
    let inverse = graph.product(&inverse);
    let size = terms[0].1;
    let rest: Vec<_> = terms
        .iter()
        .map(|&(term, c)| (graph.mul(term, inverse), c / size))
        .collect();
    let rest = graph.linear(0.0, &rest);
    let common = graph.product(&common);
    [graph.scale(size, common), rest]
}

/// A sum with inner sums multiplied out by their fixed factors, where terms cancel then; else the sum as it
/// is.
fn without_brackets(graph: &mut Graph, sum: NodeId) -> NodeId {
    let flat = expand_inner_sums(graph, sum, &is_early, &|_, count, _| count > 0);
    if graph.terms(flat).0.len() < graph.terms(sum).0.len() {
        flat
    } else {
        sum
    }
}

/// A sum with inner sums multiplied out, where the other factors of the term satisfy `is_factor` and `expands`
/// agrees, given their number and the inner sum.
pub(super) fn expand_inner_sums(
    graph: &mut Graph,
    sum: NodeId,
    is_factor: &dyn Fn(&Graph, NodeId) -> bool,
    expands: &dyn Fn(&Graph, usize, NodeId) -> bool,
) -> NodeId {
    let (terms, constant) = graph.terms(sum);
    let mut flat = Vec::new();
    for (term, c) in terms {
        let factors = graph.factors(term).into_iter();
        let (cofactors, others): (Vec<_>, Vec<_>) =
            factors.partition(|&(factor, _)| is_factor(graph, factor));
        match others[..] {
            [(inner, 1)]
                if matches!(graph.node(inner), Node::Sum(..)) && expands(graph, cofactors.len(), inner) =>
            {
                let cofactor = graph.product(&cofactors);
                let (inner, rest) = graph.terms(inner);
                for (inner, d) in inner {
                    flat.push((graph.mul(cofactor, inner), c * d));
                }
                flat.push((cofactor, c * rest));
            }
            _ => flat.push((term, c)),
        }
    }
    // collects equal terms
    graph.linear(constant, &flat)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Unary;

    /// The kinetic energy of a chain of equal links, and the derivatives by angles and velocities.
    fn chain(graph: &mut Graph, links: usize) -> Vec<NodeId> {
        let function = |graph: &mut Graph, op, i| {
            let angle = graph.leaf(Leaf::Q(i));
            graph.unary(op, angle)
        };
        let mut terms = Vec::new();
        for i in 0..links {
            for j in 0..links {
                let products = [Unary::Sin, Unary::Cos].map(|op| {
                    let (first, second) = (function(graph, op, i), function(graph, op, j));
                    graph.mul(first, second)
                });
                let cosine = graph.sum(&products);
                let speeds = [i, j].map(|i| (graph.leaf(Leaf::V(i)), 1));
                let speeds = graph.product(&speeds);
                terms.push((graph.mul(cosine, speeds), (links - i.max(j)) as f64));
            }
        }
        let energy = graph.linear(0.0, &terms);
        let leaves = (0..links).map(Leaf::Q).chain((0..links).map(Leaf::V));
        leaves.map(|leaf| graph.derivative(energy, leaf)).collect()
    }

    #[test]
    fn gathered_slopes_are_worth_the_same_and_are_fewer_products() {
        let mut graph = Graph::new();
        let before = chain(&mut graph, 6);
        let after = slopes(&mut graph, &before).expect("many products are spared");
        for (&before, &after) in before.iter().zip(&after) {
            let difference = graph.sub(before, after);
            assert!(graph.vanishes(difference));
        }
        assert!(operations(&graph, &after) * 3 < operations(&graph, &before) * 2);
        // three links are left alone
        let few = chain(&mut graph, 3);
        assert!(slopes(&mut graph, &few).is_none());
    }

    #[test]
    fn differences_of_positions_keep_their_digits() {
        let mut graph = Graph::new();
        let [x, y, z] = [0, 1, 2].map(|i| graph.leaf(Leaf::Q(i)));
        // (x - y) sin z: nothing is multiplied out
        let (stretch, sine) = (graph.sub(x, y), graph.unary(Unary::Sin, z));
        let product = graph.mul(stretch, sine);
        let polynomial = expansion(MOST_TERMS).polynomial(&mut graph, product);
        let polynomial = polynomial.unwrap_or_default();
        let monomials: Vec<_> = polynomial.keys().collect();
        assert_eq!(monomials.len(), 1);
        assert!(monomials[0].contains(&(stretch, 1)) || monomials[0].contains(&(graph.sub(y, x), 1)));
    }
}
