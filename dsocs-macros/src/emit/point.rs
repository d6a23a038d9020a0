//! The methods at a point: Lagrangian, energy, observed expressions, the continuous system.

use std::collections::HashMap;

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::equations;
use super::matrix;
use super::program::{Program, Value};
use super::step::argument;
use crate::graph::{Graph, Leaf, NodeId};
use crate::model::Model;

/// Code for some expressions, all at one stage.
fn code(
    graph: &Graph,
    nodes: &[NodeId],
    leaf: &dyn Fn(Leaf) -> TokenStream,
) -> (TokenStream, Vec<TokenStream>) {
    let mut program = Program::new(graph, |_| 0);
    program.plan(nodes);
    let values: Vec<Value> = nodes.iter().map(|&node| program.lower(node)).collect();
    program.code(&values, &HashMap::new(), leaf)
}

/// A leaf of the continuous system where the argument is a whole point.
fn of_point(leaf: Leaf) -> TokenStream {
    let component = argument(leaf);
    quote!(point.#component)
}

/// `lagrangian`, `discrete_lagrangian`, `energy`, `observe`, `continuous`, `continuous_force`.
pub(super) fn methods(model: &Model) -> TokenStream {
    let n = model.coordinates.len();
    let mut graph: Graph = model.graph.clone();
    let discrete_lagrangian = equations::discrete_lagrangian(model, &mut graph);
    let energy = equations::energy(model, &mut graph);
    let continuous = equations::continuous(model, &mut graph);
    let rows: Vec<NodeId> = continuous
        .rows
        .iter()
        .map(|row| match row.divide {
            Some(factor) => graph.div(row.value, factor),
            None => row.value,
        })
        .collect();
    let jacobian: Vec<NodeId> = rows
        .iter()
        .flat_map(|&row| (0..n).map(move |i| (row, i)))
        .map(|(row, i)| graph.derivative(row, Leaf::A(i)))
        .collect();
    let observed: Vec<NodeId> = model.observe.iter().map(|&(_, node)| node).collect();

    let (lagrangian_code, lagrangian) = code(&graph, &[model.lagrangian], &argument);
    let (discrete_code, discrete) = code(&graph, &[discrete_lagrangian], &argument);
    let (energy_code, energy) = code(&graph, &[energy], &argument);
    let (observe_code, observed) = code(&graph, &observed, &of_point);
    let places = (0..observed.len()).map(Literal::usize_unsuffixed);
    let equations = [rows, jacobian].concat();
    let (continuous_code, results) = code(&graph, &equations, &of_point);
    let (rows, jacobian) = results.split_at(n);
    let jacobian = matrix(jacobian, n);
    let (force_code, force) = code(&graph, &continuous.force, &of_point);
    let n = Literal::usize_unsuffixed(n);
    quote! {
        #[inline]
        fn lagrangian<__T: ::dsocs_core::Scalar>(&self, q: &[__T; #n], v: &[__T; #n]) -> __T {
            #lagrangian_code
            #(#lagrangian)*
        }

        #[inline]
        fn discrete_lagrangian<__T: ::dsocs_core::Scalar>(
            &self,
            h: __T,
            leg: &::dsocs_core::Leg<__T, #n>,
        ) -> __T {
            #discrete_code
            #(#discrete)*
        }

        #[inline]
        fn energy<__T: ::dsocs_core::Scalar>(&self, q: &[__T; #n], v: &[__T; #n]) -> __T {
            #energy_code
            #(#energy)*
        }

        #[inline]
        fn observe<__T: ::dsocs_core::Scalar>(&self, point: &::dsocs_core::Point<__T, #n>, out: &mut [__T]) {
            #observe_code
            #(
                if let ::core::option::Option::Some(place) = out.get_mut(#places) {
                    *place = #observed;
                }
            )*
        }

        #[inline]
        fn continuous<__T: ::dsocs_core::Scalar>(
            &self,
            point: &::dsocs_core::Point<__T, #n>,
        ) -> ::dsocs_core::Linearization<__T, [__T; #n]> {
            #continuous_code
            ::dsocs_core::Linearization { rows: [#(#rows),*], jacobian: #jacobian }
        }

        #[inline]
        fn continuous_force<__T: ::dsocs_core::Scalar>(
            &self,
            point: &::dsocs_core::Point<__T, #n>,
        ) -> [__T; #n] {
            #force_code
            [#(#force),*]
        }
    }
}
