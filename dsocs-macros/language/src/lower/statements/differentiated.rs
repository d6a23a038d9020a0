//! Warnings about holonomic constraints that the user differentiated twice.
//!
//! As rows of second order they fix the acceleration alone, so the original constraint drifts. The statement
//! `holonomic` takes the constraint itself, and finds the same forces.

use proc_macro2::Ident;
use syn::spanned::Spanned as _;

use crate::graph::{Graph, Leaf, NodeId};
use crate::model::{Kind, Model, Warning};

/// The warnings about kinematic rows that should be holonomic.
pub(crate) fn warnings(model: &Model) -> Vec<Warning> {
    let mut graph = model.graph.clone();
    let rows = model.constraints.iter().enumerate();
    let kinematic = rows.filter(|(_, row)| row.kind == Kind::Kinematic && row.discrete.is_none());
    kinematic
        .filter(|&(place, row)| {
            let form = model.forms.get(place).map(|form| form.components.as_slice());
            form.is_some_and(|form| is_differentiated(&mut graph, row.value, form))
        })
        .map(|(_, row)| Warning {
            place: Ident::new("kinematic", row.tokens.span()),
            message: "this row is the second derivative of a function of the coordinates alone, and acts like a constraint on it: it holds \
                      the acceleration, and the function itself drifts away; write the function under `holonomic`, which keeps it"
                .into(),
            unused: false,
        })
        .collect()
}

/// Whether a row is `d²g/dt²` of a nonlinear function `g(q)`, with a force along `dg`.
fn is_differentiated(graph: &mut Graph, row: NodeId, form: &[NodeId]) -> bool {
    let n = form.len();
    let slopes: Vec<NodeId> = (0..n).map(|i| graph.derivative(row, Leaf::A(i))).collect();
    let depends = |graph: &Graph, leaf: fn(usize) -> Leaf| {
        let mut places = (0..n).map(leaf);
        places.any(|leaf| slopes.iter().any(|&slope| graph.depends_on(slope, leaf)))
    };
    // a linear one may be meant: a joint that goes on turning
    let is_of_positions = depends(graph, Leaf::Q) && !depends(graph, Leaf::V) && !depends(graph, Leaf::A);
    if !is_of_positions || slopes.iter().any(|&slope| graph.depends_on(slope, Leaf::T)) {
        return false;
    }
    let products: Vec<NodeId> = slopes
        .iter()
        .enumerate()
        .map(|(i, &slope)| {
            let v = graph.leaf(Leaf::V(i));
            graph.mul(slope, v)
        })
        .collect();
    let rate = graph.sum(&products);
    let differentiated = graph.total_derivative(rate);
    vanishes(graph, row, differentiated)
        && (0..n).all(|i| {
            (0..i).all(|j| {
                let [one, other] = [(i, j), (j, i)].map(|(i, j)| graph.derivative(slopes[i], Leaf::Q(j)));
                let [across, along] = [(i, j), (j, i)].map(|(i, j)| graph.mul(slopes[i], form[j]));
                vanishes(graph, one, other) && vanishes(graph, across, along)
            })
        })
}

/// Whether two expressions are equal.
fn vanishes(graph: &mut Graph, one: NodeId, other: NodeId) -> bool {
    let difference = graph.sub(one, other);
    graph.vanishes(difference)
}
