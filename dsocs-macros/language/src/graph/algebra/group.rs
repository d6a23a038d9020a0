//! Terms with the same factor and an inner sum, gathered into one inner sum.
//!
//! The momentum of link `i` of a chain is `Σ_{k ≥ i} m_k cᵢ ẋ_k`, where `ẋ_k` is a sum over the links up to
//! `k`: of the order of `n³` terms in all rows. As `cᵢ Σ_j μ_max(i,j) cⱼ vⱼ` it has `n²`, and the `n³` terms
//! are never formed.

use super::gather::{expand_inner_sums, is_never_expanded};
use crate::graph::{Graph, Node, NodeId};
use crate::hash::HashMap;

/// The least number of coordinates for which terms are grouped; the rows of smaller systems are short.
const FEWEST: usize = 8;

/// Factors and their exponents.
type Factors = Vec<(NodeId, i32)>;
/// A term with an inner sum: its fixed factors, the sum, and its coefficient.
type Member = (Factors, NodeId, f64);

/// A derivative of a Lagrangian with its inner sums grouped by their moving factors; unchanged where there
/// are few coordinates.
pub(crate) fn slope(graph: &mut Graph, coordinates: usize, slope: NodeId) -> NodeId {
    if coordinates < FEWEST {
        return slope;
    }
    grouped(graph, slope)
}

/// A sum with its inner sums grouped by the moving factors of their terms.
fn grouped(graph: &mut Graph, sum: NodeId) -> NodeId {
    // terms that are a fixed factor times a sum are multiplied out
    let flat = expand_inner_sums(graph, sum, &Graph::is_fixed, &|graph, _, inner| {
        !is_never_expanded(graph, inner)
    });
    let (terms, constant) = graph.terms(flat);
    let mut places: HashMap<Factors, usize> = HashMap::default();
    let mut groups: Vec<(Factors, Vec<Member>)> = Vec::new();
    let mut others = Vec::new();
    for &(term, c) in &terms {
        let factors = graph.factors(term).into_iter();
        let (fixed, mut moving): (Vec<_>, Vec<_>) = factors.partition(|&(factor, _)| graph.is_fixed(factor));
        let is_sum = |&(factor, n): &(NodeId, i32)| {
            n == 1 && matches!(graph.node(factor), Node::Sum(..)) && !is_never_expanded(graph, factor)
        };
        let place = moving.iter().position(is_sum);
        match place {
            Some(place) if moving.len() > 1 => {
                let (inner, _) = moving.remove(place);
                let next = groups.len();
                let group = *places.entry(moving.clone()).or_insert(next);
                if group == next {
                    groups.push((moving, Vec::new()));
                }
                groups[group].1.push((fixed, inner, c));
            }
            _ => others.push((term, c)),
        }
    }
    if groups.iter().all(|(_, members)| members.len() < 2) {
        return sum;
    }
    for (moving, members) in groups {
        let (common, inner) = sum_of_members(graph, members);
        let factors = [moving, common, vec![(inner, 1)]].concat();
        others.push((graph.product(&factors), 1.0));
    }
    graph.linear(constant, &others)
}

/// The sum of some inner sums, each times its fixed factors, and the factors that all of them share, taken
/// out.
fn sum_of_members(graph: &mut Graph, members: Vec<Member>) -> (Factors, NodeId) {
    let mut common = members.first().map_or_else(Vec::new, |(fixed, ..)| fixed.clone());
    for (fixed, ..) in &members {
        common.retain(|factor| fixed.contains(factor));
    }
    let is_common = members.iter().all(|(fixed, ..)| fixed.len() == common.len());
    if is_common {
        let members: Vec<_> = members.iter().map(|&(_, inner, c)| (inner, c)).collect();
        return (common, graph.linear(0.0, &members));
    }
    // the coefficient of each term collects the numbers and fixed factors of its terms
    let mut places: HashMap<NodeId, usize> = HashMap::default();
    let mut terms: Vec<(NodeId, Vec<(NodeId, f64)>)> = Vec::new();
    let one = graph.constant(1.0);
    for (mut fixed, inner, c) in members {
        fixed.retain(|factor| !common.contains(factor));
        let fixed = graph.product(&fixed);
        let (inner, constant) = graph.terms(inner);
        for (term, d) in inner.into_iter().chain([(one, constant)]) {
            let next = terms.len();
            let place = *places.entry(term).or_insert(next);
            if place == next {
                terms.push((term, Vec::new()));
            }
            terms[place].1.push((fixed, c * d));
        }
    }
    let terms: Vec<_> = terms
        .into_iter()
        .map(|(term, factors)| {
            let factor = graph.linear(0.0, &factors);
            (graph.mul(factor, term), 1.0)
        })
        .collect();
    (common, graph.linear(0.0, &terms))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Leaf, Unary};

    #[test]
    fn sums_times_one_factor_become_one_and_sums_of_one_coordinate_stay() {
        let mut graph = Graph::new();
        let masses = [0, 1, 2].map(|k| graph.param(quote::quote!(m[#k])));
        let speeds = [0, 1, 2].map(|i| {
            let (angle, rate) = (graph.leaf(Leaf::Q(i)), graph.leaf(Leaf::V(i)));
            let cosine = graph.unary(Unary::Cos, angle);
            graph.mul(cosine, rate)
        });
        let angle = graph.leaf(Leaf::Q(0));
        let cosine = graph.unary(Unary::Cos, angle);
        for masses in [masses, [masses[0]; 3]] {
            let terms = [1, 2, 3].map(|end| {
                let speed = graph.sum(&speeds[..end]);
                graph.product(&[(masses[end - 1], 1), (cosine, 1), (speed, 1)])
            });
            let sum = graph.sum(&terms);
            let after = grouped(&mut graph, sum);
            assert_eq!(graph.terms(after).0.len(), 2, "the first speed is no sum");
            let difference = graph.sub(sum, after);
            assert!(graph.vanishes(difference));
        }
        // a difference of positions keeps its digits
        let [x, y, z] = [0, 1, 2].map(|i| graph.leaf(Leaf::Q(i)));
        let stretches = [graph.sub(x, y), graph.sub(y, z)].map(|stretch| graph.mul(stretch, cosine));
        let sum = graph.linear(0.0, &[(stretches[0], 2.0), (stretches[1], 3.0)]);
        assert_eq!(grouped(&mut graph, sum), sum);
    }
}
