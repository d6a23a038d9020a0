//! The declaration as a tape: all of its operations as bytes, which `dsocs_core` reads.

mod calls;
mod recurrences;
mod segment;

use crate::graph::{Graph, NodeId};
use crate::hash::HashMap;
use crate::mechanics::{self, LowerOrder, Sides, Steep, StepEquations, Switches, Table};
use crate::model::{Kind, Model};
use crate::passes;
use crate::program::stages::{Stages, single};

use segment::{Segment, number};

pub(crate) use calls::Calls;
pub use recurrences::Series;
pub(crate) use recurrences::series;

/// The version of the tape's format, as `dsocs_core` reads it.
const VERSION: u8 = 8;

/// Expressions of a step as it was declared, before the passes.
pub(crate) struct Declared {
    /// The rows of the equations.
    rows: Vec<NodeId>,
    /// The components of the fields that span the virtual displacements, field by field.
    fields: Vec<NodeId>,
    /// The factor to be divided out of each kinematic row, or 1.
    factors: Vec<NodeId>,
}

impl Declared {
    /// The declared expressions of a step.
    pub(crate) fn new(model: &Model, graph: &mut Graph, step: &StepEquations) -> Self {
        let one = graph.constant(1.0);
        let constraints = step.rows.iter().zip(&model.constraints);
        let kinematic = constraints.filter(|(_, row)| row.kind == Kind::Kinematic);
        Self {
            rows: step.rows.iter().map(|row| row.value).collect(),
            fields: step.fields.concat(),
            factors: kinematic.map(|(row, _)| row.divide.unwrap_or(one)).collect(),
        }
    }
}

/// Expressions of the continuous system, of a leg, and of the switches.
pub(crate) struct Expressions {
    graph: Graph,
    discrete_lagrangian: NodeId,
    pub(crate) energy: NodeId,
    /// The rows of the continuous system, then their Jacobian.
    continuous: Vec<NodeId>,
    force: Vec<NodeId>,
    /// The external forces on a leg: on its first node, then on its second.
    external: Vec<NodeId>,
    /// The momentum at the second node of a leg, `D₂L_d + f⁺_d`.
    momentum_at_second_node: Vec<NodeId>,
    switches: Switches,
}

impl Expressions {
    pub(crate) fn new(model: &Model) -> Self {
        let mut graph: Graph = model.graph.clone();
        let discrete_lagrangian = mechanics::discrete_lagrangian(model, &mut graph);
        let external = mechanics::external_on_leg(model, &mut graph);
        let external = mechanics::on_first_leg(model, &mut graph, &external.unwrap_or_default().concat());
        let momentum_at_second_node = mechanics::momentum_at_second_node(model, &mut graph);
        let energy = mechanics::energy(model, &mut graph);
        let (continuous, force) = passes::continuous(model, &mut graph);
        Self {
            graph,
            discrete_lagrangian,
            energy,
            continuous,
            force,
            external,
            momentum_at_second_node,
            switches: mechanics::switches(model),
        }
    }

    pub(crate) fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Whether there are switches, tables of samples or steep functions.
    pub(crate) fn have_switches(&self) -> bool {
        let Switches {
            arguments,
            tables,
            steep,
            ..
        } = &self.switches;
        !(arguments.is_empty() && tables.is_empty() && steep.is_empty())
    }
}

/// The tape of a declaration, and the functions and expressions that it calls.
pub(crate) struct TapeWithCalls {
    pub(crate) bytes: Vec<u8>,
    pub(crate) calls: Calls,
}

/// The tape of the declaration.
pub(crate) fn tape(
    model: &Model,
    stages: &Stages,
    declared: (&Graph, &Declared),
    expressions: &Expressions,
) -> TapeWithCalls {
    let mut calls = Calls::default();
    let segments = segments(model, stages, declared, expressions, &mut calls);
    let mut bytes = vec![VERSION];
    for segment in segments {
        let segment = segment.bytes();
        number(&mut bytes, segment.len());
        bytes.extend(segment);
    }
    TapeWithCalls { bytes, calls }
}

/// The number of segments of a tape.
const SEGMENTS: usize = 30;

/// A tape with a segment of constants, and all others empty.
pub(crate) fn of_constants(constants: &Segment) -> Vec<u8> {
    let none = Segment::default().bytes();
    let others = (1..SEGMENTS).map(|_| none.clone());
    let mut bytes = vec![VERSION];
    for segment in [constants.bytes()].into_iter().chain(others) {
        number(&mut bytes, segment.len());
        bytes.extend(segment);
    }
    bytes
}

/// The segments of the tape, in their order.
fn segments(
    model: &Model,
    stages: &Stages,
    (declared_graph, declared): (&Graph, &Declared),
    expressions: &Expressions,
    calls: &mut Calls,
) -> Vec<Segment> {
    let nothing = HashMap::default();
    let (program, in_step) = (&stages.program, stages.in_step());
    let constants = constants(stages, calls);
    let known = program.segment(Segment::default(), &stages.known, 0, &stages.in_run(), calls);
    let residual = program.segment(
        Segment::default(),
        &stages.residual(),
        stages.rows.len(),
        &in_step,
        calls,
    );
    let scales = program.segment(Segment::default(), &stages.scales, 0, &in_step, calls);
    let second_difference =
        program.segment(Segment::default(), &stages.second_difference, 0, &in_step, calls);
    let node = program.segment(
        Segment::default(),
        &stages.node(),
        stages.point.len(),
        &in_step,
        calls,
    );
    let forms = program.segment(Segment::default(), &stages.forms, 0, &in_step, calls);
    let energy = &stages.energy;
    let energy = energy
        .program
        .segment(Segment::default(), &energy.value, 0, &stages.in_energy(), calls);

    let mut of = |graph: &Graph, nodes: &[NodeId], head: usize| {
        let (program, values) = single(graph, nodes);
        program.segment(Segment::default(), &values, head, &nothing, calls)
    };
    let mut meanings_graph = Graph::new();
    let meanings: Vec<NodeId> = stages
        .meanings
        .iter()
        .map(|&leaf| meanings_graph.leaf(leaf))
        .collect();
    let unknown = of(&meanings_graph, &meanings, 0);
    let rows = model.coordinates.len() + model.multipliers();
    let continuous = of(&expressions.graph, &expressions.continuous, rows);
    let continuous_force = of(&expressions.graph, &expressions.force, 0);
    let forms_of_point: Vec<NodeId> = model
        .forms
        .iter()
        .flat_map(|form| form.components.iter().copied())
        .collect();
    let continuous_forms = of(&model.graph, &forms_of_point, 0);
    let [phase, pair, phase_slopes] = lower_order(model, &mut of);
    let [sides, sided, sided_continuous] = sided(model, &mut of);
    let switches = of(&expressions.switches.graph, &expressions.switches.arguments, 0);
    let lagrangian = of(&expressions.graph, &[model.lagrangian], 0);
    let discrete_lagrangian = of(&expressions.graph, &[expressions.discrete_lagrangian], 0);
    let observed: Vec<NodeId> = model.observe.iter().map(|&(_, node)| node).collect();
    let observe = of(&expressions.graph, &observed, 0);
    let [declared, fields, factors] =
        [&declared.rows, &declared.fields, &declared.factors].map(|nodes| of(declared_graph, nodes, 0));
    let momentum_at_second_node = of(&expressions.graph, &expressions.momentum_at_second_node, 0);
    let external = of(&expressions.graph, &model.external_forces, 0);
    let external_on_leg = of(
        &expressions.graph,
        &expressions.external,
        model.external_forces.len(),
    );
    let tables = tables(&expressions.switches, calls);
    let steep = steep(&expressions.switches, calls);
    vec![
        constants,
        known,
        residual,
        scales,
        second_difference,
        unknown,
        node,
        forms,
        continuous,
        continuous_force,
        continuous_forms,
        phase,
        pair,
        lagrangian,
        discrete_lagrangian,
        energy,
        observe,
        declared,
        external,
        external_on_leg,
        momentum_at_second_node,
        fields,
        factors,
        phase_slopes,
        sides,
        sided,
        sided_continuous,
        switches,
        tables,
        steep,
    ]
}

/// The tables of samples, each as a triple: the number of its call, 1 if it is differentiated or else 0, and its argument.
fn tables(switches: &Switches, calls: &mut Calls) -> Segment {
    let mut graph = switches.graph.clone();
    let mut all = Vec::with_capacity(3 * switches.tables.len());
    for &Table { callee, argument } in &switches.tables {
        let number = calls.function(callee, 1, &[]);
        let differentiated = calls.differentiates(callee);
        all.extend([
            graph.constant(number as f64),
            graph.constant(f64::from(u8::from(differentiated))),
            argument,
        ]);
    }
    let (program, values) = single(&graph, &all);
    program.segment(Segment::default(), &values, 0, &HashMap::default(), calls)
}

/// The functions that may be flat but for a narrow feature, each as a pair: its exponent and its argument.
fn steep(switches: &Switches, calls: &mut Calls) -> Segment {
    let mut graph = switches.graph.clone();
    let pairs = switches
        .steep
        .iter()
        .flat_map(|&Steep { exponent, argument }| [graph.constant(exponent), argument]);
    let all: Vec<NodeId> = pairs.collect();
    let (program, values) = single(&graph, &all);
    program.segment(Segment::default(), &values, 0, &HashMap::default(), calls)
}

/// The values known when the run begins: those for the step, then those for the energy.
fn constants(stages: &Stages, calls: &mut Calls) -> Segment {
    let nothing = HashMap::default();
    let none = Segment::default();
    let of_step = stages
        .program
        .segment(none, &stages.constants, 0, &nothing, calls);
    let energy = &stages.energy;
    energy
        .program
        .segment(of_step, &energy.constants, 0, &nothing, calls)
}

/// Three segments with sides in place of signs: the arguments of functions that jump with the velocity; the
/// declared rows of a step and its constraint force; the rows of the continuous system, its force and the forms.
fn sided(model: &Model, of: &mut impl FnMut(&Graph, &[NodeId], usize) -> Segment) -> [Segment; 3] {
    let Some(Sides { model, arguments }) = mechanics::sides(model) else {
        return [Segment::default(), Segment::default(), Segment::default()];
    };
    let mut graph = model.graph.clone();
    let step = mechanics::step(&model, &mut graph);
    let rows: Vec<NodeId> = step.rows.iter().map(|row| row.value).chain(step.force).collect();
    let continuous = mechanics::continuous(&model, &mut graph);
    let of_motion = continuous.rows.iter().map(|row| row.value);
    let forms = model
        .forms
        .iter()
        .flat_map(|form| form.components.iter().copied());
    let of_motion: Vec<NodeId> = of_motion.chain(continuous.force).chain(forms).collect();
    [
        of(&graph, &arguments, 0),
        of(&graph, &rows, step.rows.len()),
        of(&graph, &of_motion, continuous.rows.len()),
    ]
}

/// The constraints of lower order: at a position and a velocity, with their slopes, and on a leg.
fn lower_order(model: &Model, of: &mut impl FnMut(&Graph, &[NodeId], usize) -> Segment) -> [Segment; 3] {
    let mut graph = model.graph.clone();
    let Some(LowerOrder {
        positions,
        velocities,
    }) = LowerOrder::new(model, &mut graph)
    else {
        return [Segment::default(), Segment::default(), Segment::default()];
    };
    let phase = [positions.rows.as_slice(), &velocities.rows].concat();
    let pair = mechanics::pair(model, &mut graph);
    let (head, with_slopes) = (
        positions.rows_then_slopes().len(),
        [positions.rows_then_slopes(), velocities.rows_then_slopes()].concat(),
    );
    [
        of(&graph, &phase, positions.rows.len()),
        of(&graph, &pair, positions.rows.len()),
        of(&graph, &with_slopes, head),
    ]
}
