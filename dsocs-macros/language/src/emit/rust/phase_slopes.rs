//! Constraints on positions and velocities, with the slopes by which a motion is projected onto them.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::place::Place;
use crate::graph::{Leaf, NodeId};
use crate::hash::HashMap;
use crate::mechanics::LowerOrder;
use crate::model::Model;
use crate::program::stages::single;

/// The most operations that are written as code; more stay on the tape, since compiling them would take
/// longer than most runs would gain.
const MOST_OPERATIONS: usize = 400;

/// `phase_slopes`, if there are such constraints: the rows and slopes of the tape's segment `PhaseSlopes`, as
/// code.
pub(super) fn method(model: &Model) -> Option<TokenStream> {
    let mut graph = model.graph.clone();
    let LowerOrder {
        positions,
        velocities,
    } = LowerOrder::new(model, &mut graph)?;
    let code = |rows: &[NodeId]| {
        let (program, values) = single(&graph, rows);
        (program.operations() <= MOST_OPERATIONS).then(|| {
            let (code, results) = program.code(&values, &HashMap::default(), "n", &argument);
            quote! {
                #code
                out.copy_from_slice(&[#(#results),*]);
            }
        })
    };
    let (positions, velocities) = (
        code(&positions.rows_then_slopes())?,
        code(&velocities.rows_then_slopes())?,
    );
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
