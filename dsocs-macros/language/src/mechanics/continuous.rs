//! The continuous system (paper, section 2): rows, constraint force and energy.

use super::equation::{Equation, Pivots};
use super::works::{Force, works};
use crate::graph::algebra::grouped_slope;
use crate::graph::{Graph, Leaf, NodeId};
use crate::model::{Displacements, Model};

/// The continuous system in terms of `Q`, `V`, `A`, `T` and, with constraints of third order, `J`.
pub(crate) struct ContinuousEquations {
    /// The constraints, differentiated until they contain accelerations, then `⟨u, Q⟩` for every field, or
    /// the components of `Q - Σ λ_j α_j`.
    pub(crate) rows: Vec<Equation>,
    /// The constraints on velocities: `c(q, v)` of nonholonomic ones, `dg/dt` of holonomic ones.
    pub(crate) velocities: Vec<NodeId>,
    /// The constraint force `Q = -D_{EL}L - f = d/dt ∂L/∂v - ∂L/∂q - f`, with the external forces `f`.
    pub(crate) force: Vec<NodeId>,
}

/// The continuous system of the declaration.
pub(crate) fn continuous(model: &Model, graph: &mut Graph) -> ContinuousEquations {
    let n = model.coordinates.len();
    let mut force = Vec::new();
    for i in 0..n {
        let momentum = graph.derivative(model.lagrangian, Leaf::V(i));
        let momentum = grouped_slope(graph, n, momentum);
        let rate = graph.total_derivative(momentum);
        let slope = graph.derivative(model.lagrangian, Leaf::Q(i));
        let slope = grouped_slope(graph, n, slope);
        let external = model.external_forces.get(i).map(|&external| (external, -1.0));
        let terms: Vec<_> = [(rate, 1.0), (slope, -1.0)].into_iter().chain(external).collect();
        force.push(graph.linear(0.0, &terms));
    }
    // the momentum of a rotation is in the frame of its body, which turns: `ω × p`
    for first in graph.rotations().to_vec() {
        let slots = [1, 2, 3].map(|k| first + k);
        let momentum = slots.map(|i| graph.derivative(model.lagrangian, Leaf::V(i)));
        let rate = slots.map(|i| graph.leaf(Leaf::V(i)));
        let turning = graph.cross(rate, momentum);
        for (i, turning) in slots.into_iter().zip(turning) {
            force[i] = graph.add(force[i], turning);
        }
    }
    let (mut rows, mut velocities) = (Vec::new(), Vec::new());
    for row in &model.constraints {
        // differentiated until it contains accelerations
        let mut value = row.value;
        for order in row.order..2 {
            if order == 1 {
                velocities.push(value);
            }
            value = graph.total_derivative(value);
        }
        rows.push(Equation {
            value,
            by_subtraction: value,
            divide: row.divide,
            pivots: Pivots::Any,
        });
    }
    let forms: Vec<_> = model.forms.iter().map(|form| form.components.clone()).collect();
    let force = Force {
        by_subtraction: force.clone(),
        value: force,
    };
    let fields = match &model.displacements {
        Displacements::Fields(fields) => Some(fields.as_slice()),
        Displacements::Annihilated => None,
    };
    rows.extend(works(graph, fields, &forms, &force));
    let force = force.value;
    ContinuousEquations {
        rows,
        velocities,
        force,
    }
}

/// The energy `⟨∂L/∂v, v⟩ - L`.
pub(crate) fn energy(model: &Model, graph: &mut Graph) -> NodeId {
    let mut terms = Vec::new();
    for i in 0..model.coordinates.len() {
        let (momentum, v) = (
            graph.derivative(model.lagrangian, Leaf::V(i)),
            graph.leaf(Leaf::V(i)),
        );
        terms.push((graph.mul(momentum, v), 1.0));
    }
    terms.push((model.lagrangian, -1.0));
    graph.linear(0.0, &terms)
}
