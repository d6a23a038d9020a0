//! Constraints of lower order: what they ask of a position and of a velocity, and the slopes by which a motion is brought back onto them.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::program::Place;
use super::stages::single;
use crate::graph::{Graph, Leaf, NodeId};
use crate::hash::HashMap;
use crate::mechanics;
use crate::model::{Kind, Model};

/// More operations stay on the tape: straight-line code for them would take longer to compile than it saves in most runs.
const MOST_OPERATIONS: usize = 400;

/// Rows, and their derivatives, row by row.
pub(super) struct Rows {
    pub(super) rows: Vec<NodeId>,
    slopes: Vec<NodeId>,
}

impl Rows {
    fn new(graph: &mut Graph, rows: &[NodeId], by: fn(usize) -> Leaf, n: usize) -> Self {
        let slopes = rows
            .iter()
            .flat_map(|&row| (0..n).map(move |i| (row, by(i))))
            .map(|(row, leaf)| graph.derivative(row, leaf))
            .collect();
        Self {
            rows: rows.to_vec(),
            slopes,
        }
    }

    /// The rows, then their slopes.
    pub(super) fn all(&self) -> Vec<NodeId> {
        [self.rows.as_slice(), &self.slopes].concat()
    }
}

/// Constraints of lower order at a point.
pub(super) struct Phase {
    /// Rows of the position.
    pub(super) positions: Rows,
    /// Rows of the velocity: the derivatives of the former, and those that were declared.
    pub(super) velocities: Rows,
}

impl Phase {
    /// Those of a declaration, if there are any.
    pub(super) fn new(model: &Model, graph: &mut Graph) -> Option<Self> {
        let [holonomic, nonholonomic] = [Kind::Holonomic, Kind::Nonholonomic].map(|kind| model.count(kind));
        if holonomic + nonholonomic == 0 {
            return None;
        }
        let n = model.coordinates.len();
        let phase = mechanics::phase(model, graph);
        let (positions, velocities) = phase.split_at(holonomic);
        Some(Self {
            positions: Rows::new(graph, positions, Leaf::Q, n),
            velocities: Rows::new(graph, velocities, Leaf::V, n),
        })
    }
}

/// `phase_slopes`, where there is something to tell: the rows and slopes of the tape's segment `PhaseSlopes`, as code.
pub(super) fn method(model: &Model) -> Option<TokenStream> {
    let mut graph = model.graph.clone();
    let Phase {
        positions,
        velocities,
    } = Phase::new(model, &mut graph)?;
    let code = |rows: &Rows| {
        let (program, values) = single(&graph, &rows.all());
        (program.operations() <= MOST_OPERATIONS).then(|| {
            let (code, results) = program.code(&values, &HashMap::default(), "n", &argument);
            quote! {
                #code
                out.copy_from_slice(&[#(#results),*]);
            }
        })
    };
    let (positions, velocities) = (code(&positions)?, code(&velocities)?);
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    Some(quote! {
        const PHASE_SLOPES: bool = true;

        fn phase_slopes<__T: ::dsocs_core::__private::Scalar>(
            &self,
            of_velocity: bool,
            parameters: &<Self as ::dsocs_core::__private::Compiled<#n>>::Parameters<__T>,
            (t, q, v): (__T, &[__T; #n], &[__T; #n]),
            out: &mut [__T],
        ) {
            if of_velocity {
                #velocities
            } else {
                #positions
            }
        }
    })
}

/// Where a leaf stands in the arguments.
fn argument(leaf: Leaf) -> Place {
    match leaf {
        Leaf::T => Place::number("t"),
        Leaf::Q(i) => Place::element("q", i),
        Leaf::V(i) => Place::element("v", i),
        _ => Place::nowhere(),
    }
}
