//! The methods at a point: Lagrangian, energy, observed expressions, the continuous system.

use std::collections::HashMap;

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::matrix;
use super::program::{Program, Value};
use super::step::argument;
use crate::graph::{Graph, Leaf, NodeId};
use crate::mechanics;
use crate::model::{Kind, Model};

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
    let discrete_lagrangian = mechanics::discrete_lagrangian(model, &mut graph);
    let energy = mechanics::energy(model, &mut graph);
    let continuous = mechanics::continuous(model, &mut graph);
    let rows: Vec<NodeId> = continuous
        .rows
        .iter()
        .map(|row| match row.divide {
            Some(factor) => graph.div(row.value, factor),
            None => row.value,
        })
        .collect();
    let multipliers = model.multipliers();
    let unknown: Vec<Leaf> = (0..n)
        .map(Leaf::A)
        .chain((0..multipliers).map(Leaf::Lambda))
        .collect();
    let mut jacobian: Vec<NodeId> = Vec::new();
    for &row in &rows {
        jacobian.extend(unknown.iter().map(|&leaf| graph.derivative(row, leaf)));
    }
    let observed: Vec<NodeId> = model.observe.iter().map(|&(_, node)| node).collect();

    let (lagrangian_code, lagrangian) = code(&graph, &[model.lagrangian], &argument);
    let (discrete_code, discrete) = code(&graph, &[discrete_lagrangian], &argument);
    let (energy_code, energy) = code(&graph, &[energy], &argument);
    let (observe_code, observed) = code(&graph, &observed, &of_point);
    let places = (0..observed.len()).map(Literal::usize_unsuffixed);
    let equations = [rows, jacobian].concat();
    let of_motion = |leaf| match leaf {
        Leaf::Lambda(_) => argument(leaf),
        other => of_point(other),
    };
    let (continuous_code, results) = code(&graph, &equations, &of_motion);
    let (rows, jacobian) = results.split_at(n + multipliers);
    let jacobian = matrix(jacobian, n + multipliers);
    let size = Literal::usize_unsuffixed(n + multipliers);
    let forms = forms(model);
    let lower = lower(model);
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

        type Motion<__T: ::dsocs_core::Scalar> = [__T; #size];

        #forms
        #lower

        #[inline]
        fn continuous<__T: ::dsocs_core::Scalar>(
            &self,
            point: &::dsocs_core::Point<__T, #n>,
            multipliers: &[__T],
        ) -> ::dsocs_core::Linearization<__T, Self::Motion<__T>> {
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

/// `continuous_forms`, where some are known.
fn forms(model: &Model) -> Option<TokenStream> {
    if model.forms.is_empty() {
        return None;
    }
    let nodes: Vec<NodeId> = model
        .forms
        .iter()
        .flat_map(|form| form.components.iter().copied())
        .collect();
    let (code, values) = code(&model.graph, &nodes, &of_point);
    let n = model.coordinates.len();
    let forms = values.chunks(n).map(|form| quote!([#(#form),*]));
    let n = Literal::usize_unsuffixed(n);
    Some(quote! {
        #[inline]
        fn continuous_forms<__T: ::dsocs_core::Scalar>(
            &self,
            point: &::dsocs_core::Point<__T, #n>,
            out: &mut [[__T; #n]],
        ) {
            #code
            for (place, form) in out.iter_mut().zip([#(#forms),*]) {
                *place = form;
            }
        }
    })
}

/// `phase` and `pair`, where there are constraints of lower order.
fn lower(model: &Model) -> Option<TokenStream> {
    let [holonomic, nonholonomic] = [Kind::Holonomic, Kind::Nonholonomic].map(|kind| model.count(kind));
    if holonomic + nonholonomic == 0 {
        return None;
    }
    let mut graph = model.graph.clone();
    let (phase, pair) = (
        mechanics::phase(model, &mut graph),
        mechanics::pair(model, &mut graph),
    );
    let (phase_code, phase) = code(&graph, &phase, &argument);
    let (pair_code, pair) = code(&graph, &pair, &argument);
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    let counts = [holonomic, nonholonomic].map(Literal::usize_unsuffixed);
    let [holonomic, nonholonomic] = &counts;
    Some(quote! {
        const HOLONOMIC: usize = #holonomic;
        const NONHOLONOMIC: usize = #nonholonomic;

        #[inline]
        fn phase<__T: ::dsocs_core::Scalar>(&self, q: &[__T; #n], v: &[__T; #n], out: &mut [__T]) {
            #phase_code
            for (place, row) in out.iter_mut().zip([#(#phase),*]) {
                *place = row;
            }
        }

        #[inline]
        fn pair<__T: ::dsocs_core::Scalar>(&self, h: __T, leg: &::dsocs_core::Leg<__T, #n>, out: &mut [__T]) {
            #pair_code
            for (place, row) in out.iter_mut().zip([#(#pair),*]) {
                *place = row;
            }
        }
    })
}
