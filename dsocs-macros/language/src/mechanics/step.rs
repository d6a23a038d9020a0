//! The rows of a step: the constraints at its nodes, and the work of the constraint force (paper, section 3).

use super::equation::{Equation, Pivots};
use super::force::discrete_force;
use super::nodes::{Nodes, PointNodes, map_point, on_pair};
use super::works::works;
use crate::graph::{Change, Graph, Leaf, NodeId, Substitution};
use crate::hash::HashMap;
use crate::model::{Displacements, Kind, Model, Row};

/// The discrete step in terms of the middle node `N`, the known increment `D` and the second difference `E`;
/// with a constraint of third order, in terms of `N`, `D`, the previous second difference `P` and the third
/// difference `E`.
///
/// Of third order, the force is that at the last inner one of four nodes: the rows of the force at the first
/// inner node would not contain the unknown node.
pub(crate) struct StepEquations {
    /// The constraints, then `⟨u, Q⟩` for every field, or the components of `Q - Σ λ_j α_j`.
    pub(crate) rows: Vec<Equation>,
    /// The number of multipliers among the unknowns.
    pub(crate) multipliers: usize,
    /// `φ_{D_K}⁻¹(q0, q1, q2)`.
    pub(crate) point: PointNodes,
    /// The constraint force `Q = -(D₁L_d(q1,q2) + D₂L_d(q0,q1) + f⁻_d(q1,q2) + f⁺_d(q0,q1))`.
    pub(crate) force: Vec<NodeId>,
    /// The fields that span the virtual displacements; empty where multipliers are unknown instead.
    pub(crate) fields: Vec<Vec<NodeId>>,
    /// The forms along which the constraint force acts, if they are known.
    pub(crate) forms: Vec<Vec<NodeId>>,
}

/// The discrete step of the declaration.
pub(crate) fn step(model: &Model, graph: &mut Graph) -> StepEquations {
    let nodes = Nodes::of_step(graph, model);
    let point = map_point(graph, &nodes, model.phi_kinematic.as_ref());
    let displacements = map_point(graph, &nodes, model.phi_variational.as_ref()).substitution();
    let force = discrete_force(model, graph, &nodes);
    let forms = discrete_forms(model, graph, &nodes.middle(), &displacements);
    let kinematic = point.substitution();
    let mut rows = Vec::new();
    for row in &model.constraints {
        let value = match (row.discrete, row.kind) {
            (Some(discrete), _) => graph.substitute(discrete, &nodes.substitution()),
            (None, Kind::Holonomic) => {
                rows.push(holonomic(graph, &nodes, row.value));
                continue;
            }
            (None, Kind::Nonholonomic) => {
                let value = on_pair(model, graph, row.value);
                graph.substitute(value, &nodes.second_leg())
            }
            (None, Kind::Kinematic) if row.order > 2 => {
                let four = nodes.middle_of_four(graph);
                graph.substitute(row.value, &four)
            }
            (None, Kind::Kinematic) => graph.substitute(row.value, &kinematic),
        };
        let divide = row.divide.map(|factor| graph.substitute(factor, &kinematic));
        rows.push(Equation {
            value,
            by_subtraction: value,
            divide,
            pivots: pivots(model, graph, row),
        });
    }
    let fields = match &model.displacements {
        Displacements::Fields(fields) => Some(fields.iter().map(|field| {
            let mut pass = Substitution::new(&displacements);
            field.iter().map(|&u| graph.rewrite(u, &mut pass)).collect()
        })),
        Displacements::Annihilated => None,
    };
    let fields: Option<Vec<Vec<NodeId>>> = fields.map(Iterator::collect);
    rows.extend(works(graph, fields.as_deref(), &forms, &force));
    StepEquations {
        rows,
        multipliers: model.multipliers(),
        point,
        force: force.value,
        fields: fields.unwrap_or_default(),
        forms,
    }
}

/// The fraction of a holonomic constraint's rounding error at `q1` that a step takes away.
const CORRECTED: f64 = 1.0 / 1024.0;

/// `g(q2)`, for a middle node with `g(q1) = 0` up to rounding: the change from there, formed without
/// cancellation, plus a small part of the error at `q1`, so that errors do not add up. The whole error would
/// show in the second difference, which is itself of the size `h²`.
fn holonomic(graph: &mut Graph, nodes: &Nodes, g: NodeId) -> Equation {
    let mut change: HashMap<_, _> = (0..nodes.q1.len())
        .map(|i| {
            let change = Change {
                before: nodes.q1[i],
                after: nodes.q2[i],
                delta: nodes.changes[1][i],
            };
            (Leaf::Q(i), change)
        })
        .collect();
    let [_, (_, time)] = nodes.change_of_time(graph);
    change.insert(Leaf::T, time);
    let late = |leaf: Leaf| matches!(leaf, Leaf::E(_));
    let Change { before, after, delta } = graph.difference(g, &change, &late, false, &mut HashMap::default());
    Equation {
        value: graph.linear(0.0, &[(delta, 1.0), (before, CORRECTED)]),
        by_subtraction: graph.linear(0.0, &[(after, 1.0), (before, CORRECTED - 1.0)]),
        divide: None,
        pivots: Pivots::Any,
    }
}

/// The second differences for which a row may be solved symbolically. A constraint on accelerations may be
/// solved only if it has a single one.
fn pivots(model: &Model, graph: &Graph, row: &Row) -> Pivots {
    if row.kind != Kind::Kinematic || row.order != 2 || row.discrete.is_some() {
        return Pivots::Any;
    }
    let mut accelerated = (0..model.coordinates.len()).filter(|&i| graph.depends_on(row.value, Leaf::A(i)));
    match (accelerated.next(), accelerated.next()) {
        (Some(one), None) => Pivots::One(Leaf::E(one)),
        _ => Pivots::None,
    }
}

/// The forms of the constraint forces: of holonomic constraints at the middle node, of the others at
/// `φ_{D_V}⁻¹`.
fn discrete_forms(
    model: &Model,
    graph: &mut Graph,
    node: &HashMap<Leaf, NodeId>,
    displacements: &HashMap<Leaf, NodeId>,
) -> Vec<Vec<NodeId>> {
    model
        .forms
        .iter()
        .map(|form| {
            let place = if form.at_node { node } else { displacements };
            let components = form.components.iter();
            components
                .map(|&component| graph.substitute(component, place))
                .collect()
        })
        .collect()
}
