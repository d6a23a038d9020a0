//! Functions that jump with the velocity, such as dry friction, with their sides as leaves.
//!
//! Where such a function jumps it may have any value between its two sides (Filippov; for friction Moreau). So a declaration that has some is
//! written once more, with a number `s` in `[-1, 1]` in the place of each sign: [`Leaf::Side`]. Functions with the same argument have the same
//! side. On a step's first leg the sides may be others, those of the motion so far: [`Leaf::FirstSide`].

use std::collections::HashMap;

use crate::graph::{Graph, Leaf, Memory, Node, NodeId, Pass, Unary};
use crate::model::{Displacements, Kind, Model, Row};

/// A declaration with sides in the place of signs.
pub(crate) struct Sides {
    /// The declaration.
    pub(crate) model: Model,
    /// The argument of each side, in `Q`, `V` and `T`.
    pub(crate) arguments: Vec<NodeId>,
}

/// The declaration with sides, if its external forces, its kinematic constraints, or the directions of its constraint forces jump with the velocity.
///
/// Not where constraints are of third order or have factors to be divided out: sticking is not looked for there.
pub(crate) fn sides(model: &Model) -> Option<Sides> {
    let divided = |row: &Row| row.divided || row.divide.is_some();
    if model.order() > 2 || model.constraints.iter().any(divided) {
        return None;
    }
    let jumps = |&value: &NodeId| model.graph.deciding(value).any(|leaf| matches!(leaf, Leaf::V(_)));
    let kinematic = |row: &&Row| row.kind == Kind::Kinematic && row.discrete.is_none();
    let rows = model.constraints.iter().filter(kinematic).map(|row| &row.value);
    let forms = model.forms.iter().flat_map(|form| &form.components);
    let fields = match &model.displacements {
        Displacements::Fields(fields) => fields.as_slice(),
        Displacements::Annihilated => &[],
    };
    let directions = forms.chain(fields.iter().flatten());
    if !rows.chain(&model.external_forces).chain(directions).any(jumps) {
        return None;
    }
    let mut model = model.clone();
    let mut signs = Signs::default();
    for force in &mut model.external_forces {
        *force = model.graph.rewrite(*force, &mut signs);
    }
    for row in &mut model.constraints {
        if kinematic(&&*row) {
            row.value = model.graph.rewrite(row.value, &mut signs);
        }
    }
    for form in &mut model.forms {
        model.graph.rewrite_all(&mut form.components, &mut signs);
    }
    if let Displacements::Fields(fields) = &mut model.displacements {
        model.graph.rewrite_all(fields.iter_mut().flatten(), &mut signs);
    }
    let arguments = signs.arguments;
    (!arguments.is_empty()).then_some(Sides { model, arguments })
}

/// What stands in the place of the sides on the first leg of a step.
pub(super) fn of_first_leg(graph: &mut Graph) -> HashMap<Leaf, NodeId> {
    let mut places = HashMap::new();
    while graph.has_leaf(Leaf::Side(places.len())) {
        let side = places.len();
        places.insert(Leaf::Side(side), graph.leaf(Leaf::FirstSide(side)));
    }
    places
}

/// Puts sides in the place of signs.
#[derive(Default)]
struct Signs {
    arguments: Vec<NodeId>,
    memory: Memory,
}

impl Signs {
    /// The side of an argument; `None` if it is not one of velocities alone, positions and the time.
    fn of(&mut self, graph: &mut Graph, argument: NodeId) -> Option<NodeId> {
        let is_motion = graph
            .leaves(argument)
            .all(|leaf| matches!(leaf, Leaf::Q(_) | Leaf::V(_) | Leaf::T));
        let moves = graph.leaves(argument).any(|leaf| matches!(leaf, Leaf::V(_)));
        if !is_motion || !moves {
            return None;
        }
        // multiples change their sign together
        let (factor, argument) = graph.split(argument);
        let known = self.arguments.iter().position(|known| *known == argument);
        let place = known.unwrap_or_else(|| {
            self.arguments.push(argument);
            self.arguments.len() - 1
        });
        let side = graph.leaf(Leaf::Side(place));
        Some(graph.scale(factor.signum(), side))
    }
}

/// Whether an expression is zero where an argument is, as the difference of the two pieces of a corner.
fn vanishes_with(graph: &mut Graph, value: NodeId, argument: NodeId) -> bool {
    let (terms, constant) = graph.terms(argument);
    let is_velocity = |node: NodeId| matches!(graph.node(node), Node::Leaf(Leaf::V(_)));
    let Some(&(solved, slope)) = terms.iter().find(|(node, _)| is_velocity(*node)) else {
        return false;
    };
    let &Node::Leaf(leaf) = graph.node(solved) else {
        return false;
    };
    let others: Vec<_> = terms.iter().filter(|(node, _)| *node != solved).collect();
    if others.iter().any(|(node, _)| graph.depends_on(*node, leaf)) {
        return false;
    }
    let others: Vec<_> = others.iter().map(|&&(node, c)| (node, -c / slope)).collect();
    let zero = graph.linear(-constant / slope, &others);
    let there = graph.substitute(value, &HashMap::from([(leaf, zero)]));
    graph.vanishes(there)
}

impl Pass for Signs {
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn after(&mut self, graph: &mut Graph, id: NodeId) -> NodeId {
        match graph.node(id).clone() {
            Node::Unary(Unary::Signum, argument) => self.of(graph, argument).unwrap_or(id),
            Node::Select(_, [left, right, then, otherwise]) => {
                let (argument, jump) = (graph.sub(right, left), graph.sub(then, otherwise));
                // a corner is no jump
                if vanishes_with(graph, jump, argument) {
                    return id;
                }
                let Some(side) = self.of(graph, argument) else {
                    return id;
                };
                let [one, other] = [1.0, -1.0].map(|sign| graph.linear(0.5, &[(side, 0.5 * sign)]));
                let (then, otherwise) = (graph.mul(one, then), graph.mul(other, otherwise));
                graph.add(then, otherwise)
            }
            _ => id,
        }
    }
}
