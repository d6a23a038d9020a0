//! The step of a declaration, assembled for writing as Rust or as data.

use super::data::Data;
use super::facts::Facts;
use super::tape::{self, Declared, Expressions};
use crate::graph::Graph;
use crate::mechanics::{self, Symmetry};
use crate::model::Model;
use crate::passes;
use crate::program::stages::{Energy, Stages};

/// The step of a declaration with its facts and stages.
pub(super) struct Assembled<'a> {
    pub(super) model: &'a Model,
    pub(super) facts: Facts,
    pub(super) stages: Stages<'a>,
    pub(super) graph: &'a Graph,
    pub(super) declared: Declared,
    pub(super) expressions: &'a Expressions,
}

/// Assembles the step of a declaration, and calls `make` with it.
pub(super) fn assembled<R>(model: &Model, make: impl FnOnce(Assembled<'_>) -> R) -> R {
    let mut graph = model.graph.clone();
    let step = mechanics::step(model, &mut graph);
    let symmetry = Symmetry::decide(model, &graph, &step);
    let unknowns = passes::step(&mut graph, &step.rows, model.coordinates.len(), step.multipliers);
    let declared = Declared::new(model, &mut graph, &step);
    let expressions = Expressions::new(model);
    let energy = Energy::new(expressions.graph(), expressions.energy);
    let stages = Stages::new(&graph, &step, &unknowns, energy);
    make(Assembled {
        model,
        facts: Facts::new(
            model,
            &graph,
            &stages,
            &unknowns,
            (symmetry, expressions.have_switches()),
        ),
        stages,
        graph: &graph,
        declared,
        expressions: &expressions,
    })
}

/// The declaration as data, for an engine that runs it without a compiler.
pub(crate) fn data(model: &Model) -> Data {
    let replaced = passes::with_continuous_quotients(model);
    let model = replaced.as_ref().unwrap_or(model);
    assembled(model, |all| {
        let tape = tape::tape(model, &all.stages, (all.graph, &all.declared), all.expressions);
        Data::new(model, all.facts, tape, all.stages.sparse)
    })
}
