//! The equations of the constraint force: no work along the virtual displacements.

use crate::graph::{Graph, Leaf, NodeId};

use super::equation::{Equation, Pivots};

/// The constraint force, component by component.
pub(super) struct Force {
    pub(super) value: Vec<NodeId>,
    /// The force with the difference of the momenta formed by subtraction.
    pub(super) by_subtraction: Vec<NodeId>,
}

/// The works `⟨u, Q⟩` of the constraint force along the fields or, without fields, the force less those of
/// the multipliers: the components of `Q - Σ λ_j α_j`.
pub(super) fn works(
    graph: &mut Graph,
    fields: Option<&[Vec<NodeId>]>,
    forms: &[Vec<NodeId>],
    force: &Force,
) -> Vec<Equation> {
    let mut equation = |part: &dyn Fn(&mut Graph, &[NodeId]) -> NodeId| Equation {
        value: part(graph, &force.value),
        by_subtraction: part(graph, &force.by_subtraction),
        divide: None,
        pivots: Pivots::Any,
    };
    match fields {
        Some(fields) => fields
            .iter()
            .map(|field| {
                equation(&|graph, force| {
                    let terms: Vec<_> = field
                        .iter()
                        .zip(force)
                        .map(|(&u, &force)| graph.mul(u, force))
                        .collect();
                    graph.sum(&terms)
                })
            })
            .collect(),
        None => (0..force.value.len())
            .map(|i| {
                equation(&|graph, force| {
                    let mut terms = vec![(force[i], 1.0)];
                    for (j, form) in forms.iter().enumerate() {
                        let multiplier = graph.leaf(Leaf::Lambda(j));
                        terms.push((graph.mul(multiplier, form[i]), -1.0));
                    }
                    graph.linear(0.0, &terms)
                })
            })
            .collect(),
    }
}
