//! Factors that divide the continuous constraint but not the discrete one.
//!
//! A factor `w` that divides a constraint only together with the equations of motion need not divide its
//! discrete row: where the mass matrix varies, the discrete equations differ from these by `O(h²)`. The
//! quotient of the discrete row then has a pole near `w = 0`, where the step has no solution. So the
//! equations of motion are used before the discretization: the constraint becomes its continuous quotient,
//! which is zero for the same motions (except those with `w = 0`), and the order stays.

use crate::graph::{Graph, Leaf, NodeId};
use crate::mechanics;
use crate::model::{Kind, Model};
use crate::passes::{eliminated, motion, of_step, quotient};

/// The declaration with such constraints replaced by their quotients; `None` if there are none.
pub(crate) fn with_continuous_quotients(model: &Model) -> Option<Model> {
    let rows = model.constraints.iter().enumerate();
    let candidates: Vec<usize> = rows
        .filter(|(_, row)| row.kind == Kind::Kinematic && row.divide.is_some() && row.discrete.is_none())
        .map(|(place, _)| place)
        .collect();
    if candidates.is_empty() {
        return None;
    }
    let (n, multipliers) = (model.coordinates.len(), model.multipliers());
    let mut graph = model.graph.clone();
    let step = mechanics::step(model, &mut graph);
    let step = eliminated(&mut graph, &step.rows, n, multipliers);
    // rows with factors are never solved, so they keep their order
    let divided = (0..step.rows.len()).filter(|&place| step.rows[place].divide.is_some());
    let with_factors = model
        .constraints
        .iter()
        .enumerate()
        .filter(|(_, row)| row.divide.is_some());
    let mut poles = Vec::new();
    for (place, (constraint, _)) in divided.zip(with_factors) {
        if candidates.contains(&constraint)
            && quotient::exact(&mut graph, &step.rows, place, of_step(&step.leaves, multipliers)).is_none()
        {
            poles.push(constraint);
        }
    }
    if poles.is_empty() {
        return None;
    }

    let mut replaced = model.clone();
    let equations = mechanics::continuous(model, &mut replaced.graph);
    let unknown: Vec<Leaf> = (0..n)
        .map(Leaf::A)
        .chain((0..multipliers).map(Leaf::Lambda))
        .collect();
    let mut any = None;
    for place in poles {
        let graph = &mut replaced.graph;
        let Some(quotient) = motion::exact(
            graph,
            &equations.rows,
            place,
            &equations.velocities,
            (n, multipliers),
            &unknown,
        ) else {
            continue;
        };
        let works = equations.rows.iter().skip(model.constraints.len());
        let works: Vec<NodeId> = works.map(|row| row.value).collect();
        let value = without_multipliers(graph, quotient.value, &works, multipliers);
        if let Some(value) = value.filter(|&value| graph.order(value) == Some(2)) {
            let value = motion::without_cancellation(graph, value);
            let row = &mut replaced.constraints[place];
            (row.value, row.divide, row.divided) = (value, None, true);
            any = Some(());
        }
    }
    any.map(|()| replaced)
}

/// A row with its multipliers replaced by the least-squares solution of `Q = Σ λ_j α_j`, which depends on the
/// position alone as long as the forms are independent.
fn without_multipliers(
    graph: &mut Graph,
    value: NodeId,
    works: &[NodeId],
    multipliers: usize,
) -> Option<NodeId> {
    let leaves: Vec<Leaf> = (0..multipliers).map(Leaf::Lambda).collect();
    if !leaves.iter().any(|&leaf| graph.depends_on(value, leaf)) {
        return Some(value);
    }
    let mut slopes_by = |leaf| works.iter().map(|&work| graph.derivative(work, leaf)).collect();
    let forms: Vec<Vec<NodeId>> = leaves.iter().map(|&leaf| slopes_by(leaf)).collect();
    let slopes: Vec<NodeId> = leaves.iter().map(|&leaf| graph.derivative(value, leaf)).collect();
    let linear = |&slope: &NodeId| leaves.iter().all(|&leaf| !graph.depends_on(slope, leaf));
    let jumps = leaves.iter().any(|&leaf| graph.jumps_with(value, leaf));
    if jumps || !slopes.iter().all(linear) {
        return None;
    }
    let multiples = quotient::multiples(graph, &forms, slopes)?;
    let mut terms = vec![(value, 1.0)];
    for (form, &multiple) in forms.iter().zip(&multiples) {
        for (&component, &work) in form.iter().zip(works) {
            terms.push((graph.product(&[(multiple, 1), (component, 1), (work, 1)]), -1.0));
        }
    }
    let rest = graph.linear(0.0, &terms);
    // the terms with multipliers cancel
    let zero = graph.constant(0.0);
    let none = leaves.into_iter().map(|leaf| (leaf, zero)).collect();
    Some(graph.substitute(rest, &none))
}
