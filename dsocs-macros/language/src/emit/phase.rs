//! Constraints on positions and velocities, with the slopes by which a motion is projected onto them.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::program::Place;
use super::stages::single;
use crate::graph::{Graph, Leaf, NodeId};
use crate::hash::HashMap;
use crate::mechanics;
use crate::model::{Kind, Model};

/// The most operations that are written as code; more stay on the tape, since compiling them would take
/// longer than most runs would gain.
const MOST_OPERATIONS: usize = 400;

/// Rows, and their derivatives by the coordinates or the velocities, row by row.
pub(super) struct RowsWithSlopes {
    pub(super) rows: Vec<NodeId>,
    slopes: Vec<NodeId>,
}

impl RowsWithSlopes {
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
    pub(super) fn rows_then_slopes(&self) -> Vec<NodeId> {
        [self.rows.as_slice(), &self.slopes].concat()
    }
}

/// The constraints of lower order at a position and a velocity.
pub(super) struct Phase {
    /// The rows for the position: the holonomic constraints.
    pub(super) positions: RowsWithSlopes,
    /// The rows for the velocity: nonholonomic constraints, and derivatives of holonomic ones.
    pub(super) velocities: RowsWithSlopes,
}

impl Phase {
    /// The constraints of a declaration; `None` if there are none.
    pub(super) fn new(model: &Model, graph: &mut Graph) -> Option<Self> {
        let [holonomic, nonholonomic] = [Kind::Holonomic, Kind::Nonholonomic].map(|kind| model.count(kind));
        if holonomic + nonholonomic == 0 {
            return None;
        }
        let n = model.coordinates.len();
        let phase = mechanics::phase(model, graph);
        let (positions, velocities) = phase.split_at(holonomic);
        Some(Self {
            positions: RowsWithSlopes::new(graph, positions, Leaf::Q, n),
            velocities: RowsWithSlopes::new(graph, velocities, Leaf::V, n),
        })
    }
}

/// `phase_slopes`, if there are such constraints: the rows and slopes of the tape's segment `PhaseSlopes`, as
/// code.
pub(super) fn method(model: &Model) -> Option<TokenStream> {
    let mut graph = model.graph.clone();
    let Phase {
        positions,
        velocities,
    } = Phase::new(model, &mut graph)?;
    let code = |rows: &RowsWithSlopes| {
        let (program, values) = single(&graph, &rows.rows_then_slopes());
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

/// The place of a leaf in the arguments.
fn argument(leaf: Leaf) -> Place {
    match leaf {
        Leaf::T => Place::number("t"),
        Leaf::Q(i) => Place::element("q", i),
        Leaf::V(i) => Place::element("v", i),
        _ => Place::nowhere(),
    }
}
