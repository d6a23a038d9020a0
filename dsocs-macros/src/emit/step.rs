//! The methods of one step, split by when their values are known: once a run, once a step, once an iteration.

use std::collections::{BTreeSet, HashMap};

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::equations;
use super::matrix;
use super::program::{Program, Value};
use super::unknowns;
use crate::graph::{Graph, Leaf, NodeId};
use crate::model::Model;

/// Known when the run begins.
const RUN: usize = 0;
/// Known when the step begins.
const STEP: usize = 1;
/// Known in the iteration only.
const ITERATION: usize = 2;

fn stage_of(leaf: Leaf) -> usize {
    match leaf {
        Leaf::H => RUN,
        Leaf::N(_) | Leaf::D(_) => STEP,
        _ => ITERATION,
    }
}

/// Where a leaf stands in the arguments of the generated methods.
pub(super) fn argument(leaf: Leaf) -> TokenStream {
    let at = Literal::usize_unsuffixed;
    match leaf {
        Leaf::H => quote!(h),
        Leaf::N(i) => {
            let i = at(i);
            quote!(leg.q[#i])
        }
        Leaf::D(i) => {
            let i = at(i);
            quote!(leg.d[#i])
        }
        Leaf::E(i) => {
            let i = at(i);
            quote!(e[#i])
        }
        Leaf::Z(j) => {
            let j = at(j);
            quote!(z[#j])
        }
        Leaf::Q(i) => {
            let i = at(i);
            quote!(q[#i])
        }
        Leaf::V(i) => {
            let i = at(i);
            quote!(v[#i])
        }
        Leaf::A(i) => {
            let i = at(i);
            quote!(a[#i])
        }
        // the nodes of a map are replaced before code is written
        Leaf::X0(_) | Leaf::X1(_) | Leaf::X2(_) => quote!(::core::unreachable!()),
    }
}

/// Values that a former method has left in an array.
fn stored(values: &BTreeSet<Value>, array: &TokenStream) -> HashMap<Value, TokenStream> {
    values
        .iter()
        .enumerate()
        .map(|(place, &value)| {
            let place = Literal::usize_unsuffixed(place);
            (value, quote!(#array[#place]))
        })
        .collect()
}

/// `constants`, `known`, `residual`, `unknown`, `second_difference`, `point`, `force`.
pub(super) fn methods(model: &Model) -> TokenStream {
    let n = model.coordinates.len();
    let mut graph: Graph = model.graph.clone();
    let step = equations::step(model, &mut graph);
    let unknowns = unknowns::choose(&mut graph, &step.rows, n);
    let mut program = Program::new(&graph, stage_of);
    let everything = [
        unknowns.rows.clone(),
        unknowns.jacobian.concat(),
        unknowns.second_difference.clone(),
        step.point.q.clone(),
        step.point.v.clone(),
        step.point.a.clone(),
        step.force.clone(),
    ];
    program.plan(&everything.concat());
    let mut lower =
        |nodes: &[NodeId]| -> Vec<Value> { nodes.iter().map(|&node| program.lower(node)).collect() };
    let rows = lower(&unknowns.rows);
    let jacobian = lower(&unknowns.jacobian.concat());
    let second_difference = lower(&unknowns.second_difference);
    let (q, v, a) = (lower(&step.point.q), lower(&step.point.v), lower(&step.point.a));
    let force = lower(&step.force);
    let point = [q, v, a].concat();

    let iterated = [rows.clone(), jacobian.clone(), second_difference.clone()].concat();
    let nothing = BTreeSet::new();
    let known: BTreeSet<Value> = program
        .frontier(&iterated, STEP, &nothing)
        .into_iter()
        .filter(|&v| program.stage(v) == STEP)
        .collect();
    let mut constants: BTreeSet<Value> = program
        .frontier(&iterated, STEP, &nothing)
        .into_iter()
        .filter(|&v| program.stage(v) == RUN)
        .collect();
    let once: Vec<Value> = known.iter().copied().collect();
    constants.extend(program.frontier(&once, RUN, &nothing));
    constants.extend(program.frontier(&[point.clone(), force.clone()].concat(), RUN, &known));

    let from_constants = stored(&constants, &quote!(constants));
    let mut from_both = stored(&known, &quote!(known));
    from_both.extend(from_constants.clone());

    let run: Vec<Value> = constants.iter().copied().collect();
    let (constants_code, constants_results) = program.code(&run, &HashMap::new(), &argument);
    let (known_code, known_results) = program.code(&once, &from_constants, &argument);
    let equations: Vec<Value> = rows.iter().chain(&jacobian).copied().collect();
    let (residual_code, results) = program.code(&equations, &from_both, &argument);
    let (rows, jacobian) = results.split_at(rows.len());
    let jacobian = matrix(jacobian, rows.len());
    let (difference_code, difference) = program.code(&second_difference, &from_both, &argument);
    let (point_code, point) = program.code(&point, &from_both, &argument);
    let (force_code, force) = program.code(&force, &from_both, &argument);

    let (q, rest) = point.split_at(n);
    let (v, a) = rest.split_at(n);
    let kept = unknowns.kept.iter().map(|&i| argument(Leaf::E(i)));
    let m = Literal::usize_unsuffixed(unknowns.kept.len());
    let n = Literal::usize_unsuffixed(n);
    let constants_len = Literal::usize_unsuffixed(run.len());
    let known_len = Literal::usize_unsuffixed(once.len());
    let linear = unknowns
        .jacobian
        .iter()
        .flatten()
        .all(|&entry| graph.leaves(entry).all(|leaf| !matches!(leaf, Leaf::Z(_))));
    quote! {
        const LINEAR: bool = #linear;

        type Unknown<__T: ::dsocs_core::Scalar> = [__T; #m];
        type Constants<__T: ::dsocs_core::Scalar> = [__T; #constants_len];
        type Known<__T: ::dsocs_core::Scalar> = [__T; #known_len];

        #[inline]
        fn constants<__T: ::dsocs_core::Scalar>(&self, h: __T) -> Self::Constants<__T> {
            #constants_code
            [#(#constants_results),*]
        }

        #[inline]
        fn known<__T: ::dsocs_core::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            leg: &::dsocs_core::Leg<__T, #n>,
        ) -> Self::Known<__T> {
            #known_code
            [#(#known_results),*]
        }

        #[inline]
        fn residual<__T: ::dsocs_core::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            known: &Self::Known<__T>,
            z: &Self::Unknown<__T>,
        ) -> ::dsocs_core::Linearization<__T, Self::Unknown<__T>> {
            #residual_code
            ::dsocs_core::Linearization { rows: [#(#rows),*], jacobian: #jacobian }
        }

        #[inline]
        fn unknown<__T: ::dsocs_core::Scalar>(&self, e: &[__T; #n]) -> Self::Unknown<__T> {
            [#(#kept),*]
        }

        #[inline]
        fn second_difference<__T: ::dsocs_core::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            known: &Self::Known<__T>,
            z: &Self::Unknown<__T>,
        ) -> [__T; #n] {
            #difference_code
            [#(#difference),*]
        }

        #[inline]
        fn point<__T: ::dsocs_core::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            known: &Self::Known<__T>,
            leg: &::dsocs_core::Leg<__T, #n>,
            e: &[__T; #n],
        ) -> ::dsocs_core::Point<__T, #n> {
            #point_code
            ::dsocs_core::Point { q: [#(#q),*], v: [#(#v),*], a: [#(#a),*] }
        }

        #[inline]
        fn force<__T: ::dsocs_core::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            known: &Self::Known<__T>,
            leg: &::dsocs_core::Leg<__T, #n>,
            e: &[__T; #n],
        ) -> [__T; #n] {
            #force_code
            [#(#force),*]
        }
    }
}
