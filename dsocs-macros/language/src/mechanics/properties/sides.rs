//! Functions that jump with the velocity, such as dry friction, with their signs as leaves.
//!
//! Where such a function jumps it may have any value between its two sides (Filippov; for friction Moreau).
//! So a declaration with such functions has a second form, in which each sign is a number `s` in `[-1, 1]`,
//! the leaf [`Leaf::Side`]. Functions with the same argument share their side. So does a corner such as
//! `|u|`, if its argument `u` is that of a jump, as in friction that depends on the speed of slipping: it
//! becomes `s u`. At the ends of a leg that rests on a moving surface `u` is slightly off zero, with opposite
//! signs. There the mean of `|u|` is not zero, while that of `s u` is.

use crate::graph::{Graph, Leaf, Memory, Node, NodeId, Pass, Unary};
use crate::model::{Displacements, Kind, Model, Row};

/// A declaration with sides in place of signs.
pub(crate) struct Sides {
    /// The declaration with sides.
    pub(crate) model: Model,
    /// The argument of each side, in `Q`, `V` and `T`.
    pub(crate) arguments: Vec<NodeId>,
}

/// The declaration with sides, if its external forces, its kinematic constraints, or the directions of its
/// constraint forces jump with the velocity.
///
/// `None` also for constraints of third order or with factors to divide out, where bodies are not made to stick.
pub(crate) fn sides(model: &Model) -> Option<Sides> {
    let divided = |row: &Row| row.divided || row.divide.is_some();
    if model.order() > 2 || model.constraints.iter().any(divided) {
        return None;
    }
    let jumps = |&value: &NodeId| {
        model
            .graph
            .jump_leaves(value)
            .any(|leaf| matches!(leaf, Leaf::V(_)))
    };
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
    // the jumps are found first: their arguments determine which corners have a side, wherever these occur
    let mut jumps = model.clone();
    let arguments = substitute_sides(&mut jumps, Signs::default());
    let mut model = Model {
        graph: jumps.graph,
        ..model.clone()
    };
    let signs = Signs {
        corners: arguments.len(),
        arguments,
        ..Signs::default()
    };
    let arguments = substitute_sides(&mut model, signs);
    (!arguments.is_empty()).then_some(Sides { model, arguments })
}

/// Substitutes sides in all expressions that may have them; returns their arguments.
fn substitute_sides(model: &mut Model, mut signs: Signs) -> Vec<NodeId> {
    for force in &mut model.external_forces {
        *force = model.graph.rewrite(*force, &mut signs);
    }
    for row in &mut model.constraints {
        if row.kind == Kind::Kinematic && row.discrete.is_none() {
            row.value = model.graph.rewrite(row.value, &mut signs);
        }
    }
    for form in &mut model.forms {
        model.graph.rewrite_all(&mut form.components, &mut signs);
    }
    if let Displacements::Fields(fields) = &mut model.displacements {
        model.graph.rewrite_all(fields.iter_mut().flatten(), &mut signs);
    }
    signs.arguments
}

/// The pass that substitutes sides for signs.
#[derive(Default)]
struct Signs {
    arguments: Vec<NodeId>,
    /// The number of arguments, the first ones, that are known to be those of jumps.
    corners: usize,
    memory: Memory,
}

impl Signs {
    /// The side of an argument; `None` unless it depends on velocities, and otherwise on positions and time at most.
    fn of(&mut self, graph: &mut Graph, argument: NodeId) -> Option<NodeId> {
        let is_motion = graph
            .leaves(argument)
            .all(|leaf| matches!(leaf, Leaf::Q(_) | Leaf::V(_) | Leaf::T));
        let moves = graph.leaves(argument).any(|leaf| matches!(leaf, Leaf::V(_)));
        if !is_motion || !moves {
            return None;
        }
        // multiples of one argument share a side
        let (factor, argument) = graph.split(argument);
        let known = self.arguments.iter().position(|known| *known == argument);
        let place = known.unwrap_or_else(|| {
            self.arguments.push(argument);
            self.arguments.len() - 1
        });
        let side = graph.leaf(Leaf::Side(place));
        Some(graph.scale(factor.signum(), side))
    }

    /// The side of a corner, if its argument is that of a jump.
    fn of_corner(&mut self, graph: &mut Graph, argument: NodeId) -> Option<NodeId> {
        let (_, own) = graph.split(argument);
        let is_known = self.arguments[..self.corners].contains(&own);
        is_known.then(|| self.of(graph, argument)).flatten()
    }
}

impl Pass for Signs {
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn after(&mut self, graph: &mut Graph, id: NodeId) -> NodeId {
        match graph.node(id).clone() {
            Node::Unary(Unary::Signum, argument) => self.of(graph, argument).unwrap_or(id),
            Node::Unary(Unary::Abs, argument) => {
                let side = self.of_corner(graph, argument);
                side.map_or(id, |side| graph.mul(side, argument))
            }
            Node::Select(_, [left, right, then, otherwise]) => {
                let (argument, jump) = (graph.sub(right, left), graph.sub(then, otherwise));
                // at a corner the pieces agree
                let side = if graph.vanishes_with(jump, argument) {
                    self.of_corner(graph, argument)
                } else {
                    self.of(graph, argument)
                };
                let Some(side) = side else {
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
