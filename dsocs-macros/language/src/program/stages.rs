//! The values that the methods of a step compute, and their stages: once a run, once a step, once an
//! iteration.

use std::collections::BTreeSet;

use super::{Given, Program, Stored, Value};
use crate::graph::{Graph, Leaf, NodeId};
use crate::hash::HashMap;
use crate::mechanics::{PointNodes, StepEquations};
use crate::passes::Unknowns;
use crate::passes::sparse::{self, Order};

/// The stage of values known when the run begins.
const RUN: usize = 0;
/// The stage of values known when the step begins.
const STEP: usize = 1;
/// The stage of values known only in the iteration.
const ITERATION: usize = 2;

fn stage_of(leaf: Leaf) -> usize {
    match leaf {
        Leaf::H => RUN,
        Leaf::N(_) | Leaf::D(_) | Leaf::P(_) | Leaf::Clock => STEP,
        _ => ITERATION,
    }
}

/// The operations that compute some nodes.
pub(crate) fn lower(program: &mut Program, nodes: &[NodeId]) -> Vec<Value> {
    nodes.iter().map(|&node| program.lower(node)).collect()
}

/// The operations that compute some nodes, as a program of one stage.
pub(crate) fn single<'g>(graph: &'g Graph, nodes: &[NodeId]) -> (Program<'g>, Vec<Value>) {
    let mut program = Program::new(graph, |_| 0);
    program.plan(nodes);
    let values = lower(&mut program, nodes);
    program.look_for_cells();
    (program, values)
}

/// The values of a step and their stages. Straight-line code and the tape are written from this.
pub(crate) struct Stages<'g> {
    pub(crate) program: Program<'g>,
    pub(crate) rows: Vec<Value>,
    pub(crate) scales: Vec<Value>,
    pub(crate) jacobian: Vec<Value>,
    /// The order of elimination, if the Jacobian is sparse.
    pub(crate) sparse: Option<Order>,
    pub(crate) second_difference: Vec<Value>,
    /// Position, velocity, acceleration and time of the node.
    pub(crate) point: Vec<Value>,
    pub(crate) force: Vec<Value>,
    pub(crate) forms: Vec<Value>,
    /// The meaning of each unknown: a second difference `E`, or a multiplier `Lambda`.
    pub(crate) meanings: Vec<Leaf>,
    /// The array `constants`, computed once a run, without the constants of the energy at its end.
    pub(crate) constants: Vec<Value>,
    /// The array `known`, computed once a step.
    pub(crate) known: Vec<Value>,
    /// The energy at a point.
    pub(crate) energy: Energy<'g>,
}

/// The energy, and its values that depend on the parameters alone.
pub(crate) struct Energy<'g> {
    pub(crate) program: Program<'g>,
    pub(crate) value: Vec<Value>,
    pub(crate) constants: Vec<Value>,
}

impl<'g> Energy<'g> {
    /// The energy as an expression of a graph of its own.
    pub(crate) fn new(graph: &'g Graph, energy: NodeId) -> Self {
        let (program, value) = single(graph, &[energy]);
        let (fixed, nothing) = (program.fixed(), BTreeSet::new());
        let constants = program.frontier(&value, |value| fixed[value.index()], &nothing);
        let constants = program.in_order(constants);
        Self {
            program,
            value,
            constants,
        }
    }
}

impl<'g> Stages<'g> {
    pub(crate) fn new(
        graph: &'g Graph,
        step: &StepEquations,
        unknowns: &Unknowns,
        energy: Energy<'g>,
    ) -> Self {
        let jacobian = unknowns.jacobian.concat();
        let PointNodes { t, q, v, a } = &step.point;
        let point = [q.as_slice(), v, a, &[*t]].concat();
        let forms = step.forms.concat();
        let mut program = Program::new(graph, stage_of);
        let all = [
            &unknowns.rows,
            &unknowns.scales,
            &jacobian,
            &unknowns.second_difference,
            &point,
            &step.force,
            &forms,
        ];
        program.plan(&all.map(Vec::as_slice).concat());
        let [rows, scales, jacobian, second_difference, point, force, forms] =
            all.map(|nodes| lower(&mut program, nodes));
        program.look_for_cells();

        let iterated = [
            rows.clone(),
            scales.clone(),
            jacobian.clone(),
            second_difference.clone(),
        ]
        .concat();
        let nothing = BTreeSet::new();
        let (known, mut constants): (BTreeSet<Value>, BTreeSet<Value>) = program
            .frontier(&iterated, |value| program.stage(value) <= STEP, &nothing)
            .into_iter()
            .partition(|&value| program.stage(value) == STEP);
        let once = program.in_order(known.iter().copied());
        constants.extend(program.frontier(&once, |value| program.stage(value) == RUN, &nothing));
        // other values of the node are computed when it is reported, from the leg
        constants.extend(program.frontier(
            &[point.clone(), force.clone(), forms.clone()].concat(),
            |value| program.stage(value) == RUN,
            &known,
        ));
        let constants = program.in_order(constants);
        Self {
            program,
            rows,
            scales,
            jacobian,
            sparse: sparse::order(graph, unknowns),
            second_difference,
            point,
            force,
            forms,
            meanings: unknowns.meanings.clone(),
            constants,
            known: once,
            energy,
        }
    }

    /// The rows, then their Jacobian.
    pub(crate) fn residual(&self) -> Vec<Value> {
        [self.rows.as_slice(), &self.jacobian].concat()
    }

    /// The rows, then the entries of their Jacobian that are not identically zero.
    pub(crate) fn entries(&self, order: &Order) -> Vec<Value> {
        let entries = order.entries.iter();
        let entries = entries.map(|&[row, column]| self.jacobian[row * self.rows.len() + column]);
        self.rows.iter().copied().chain(entries).collect()
    }

    /// The point of a node, then the force.
    pub(crate) fn node(&self) -> Vec<Value> {
        [self.point.as_slice(), &self.force].concat()
    }

    /// Whether every row has the factor 1.
    pub(crate) fn unscaled(&self) -> bool {
        self.scales.iter().all(|&scale| self.program.is_one(scale))
    }

    /// The length of the array `constants`.
    pub(crate) fn constants_count(&self) -> usize {
        self.constants.len() + self.energy.constants.len()
    }

    /// The values given once the run has begun.
    pub(crate) fn in_run(&self) -> Given {
        stored(&self.constants, 0, Stored::Constants)
    }

    /// The values given once the step has begun.
    pub(crate) fn in_step(&self) -> Given {
        let mut given = stored(&self.known, 0, Stored::Known);
        given.extend(self.in_run());
        given
    }

    /// The values given for the energy.
    pub(crate) fn in_energy(&self) -> Given {
        stored(&self.energy.constants, self.constants.len(), Stored::Constants)
    }
}

/// Values that another method has stored in an array, from the index `first` on.
fn stored(values: &[Value], first: usize, array: fn(usize) -> Stored) -> Given {
    let values = values.iter().enumerate();
    values
        .map(|(place, &value)| (value, array(first + place)))
        .collect::<HashMap<_, _>>()
}
