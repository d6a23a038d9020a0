//! The methods of one step, split by when their values are known: once a run, once a step, once an iteration.

use std::collections::{BTreeSet, HashMap};

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::matrix;
use super::program::{Program, Value};
use crate::graph::{Graph, Leaf, NodeId};
use crate::mechanics::{self, StepEquations};
use crate::model::Model;
use crate::passes::{self, Unknowns};

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
        Leaf::Lambda(j) => {
            let j = at(j);
            quote!(multipliers[#j])
        }
        // the nodes of a map are replaced before code is written
        Leaf::X0(_) | Leaf::X1(_) | Leaf::X2(_) => quote!(::core::unreachable!()),
    }
}

/// Values that a former method has left in an array.
fn stored(values: &[Value], array: &TokenStream) -> HashMap<Value, TokenStream> {
    values
        .iter()
        .enumerate()
        .map(|(place, &value)| {
            let place = Literal::usize_unsuffixed(place);
            (value, quote!(#array[#place]))
        })
        .collect()
}

/// The operations that compute some nodes.
fn lower(program: &mut Program, nodes: &[NodeId]) -> Vec<Value> {
    nodes.iter().map(|&node| program.lower(node)).collect()
}

/// The values of one step's methods, and where each is computed.
struct Stages<'g> {
    program: Program<'g>,
    rows: Vec<Value>,
    scales: Vec<Value>,
    jacobian: Vec<Value>,
    second_difference: Vec<Value>,
    point: Vec<Value>,
    force: Vec<Value>,
    forms: Vec<Value>,
    /// Computed once a run, in the order of the array `constants`.
    constants: Vec<Value>,
    /// Computed once a step, in the order of the array `known`.
    known: Vec<Value>,
}

impl<'g> Stages<'g> {
    fn new(graph: &'g Graph, step: &StepEquations, unknowns: &Unknowns) -> Self {
        let jacobian = unknowns.jacobian.concat();
        let point = [step.point.q.clone(), step.point.v.clone(), step.point.a.clone()].concat();
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

        let iterated = [
            rows.clone(),
            scales.clone(),
            jacobian.clone(),
            second_difference.clone(),
        ]
        .concat();
        let nothing = BTreeSet::new();
        let (known, mut constants): (BTreeSet<Value>, BTreeSet<Value>) = program
            .frontier(&iterated, STEP, &nothing)
            .into_iter()
            .partition(|&value| program.stage(value) == STEP);
        let once: Vec<Value> = known.iter().copied().collect();
        constants.extend(program.frontier(&once, RUN, &nothing));
        // what the node needs beyond that is computed there, from the leg
        constants.extend(program.frontier(
            &[point.clone(), force.clone(), forms.clone()].concat(),
            RUN,
            &known,
        ));
        let constants = constants.into_iter().collect();
        Self {
            program,
            rows,
            scales,
            jacobian,
            second_difference,
            point,
            force,
            forms,
            constants,
            known: once,
        }
    }

    /// The code of the method `constants`.
    fn constants(&self) -> (TokenStream, Vec<TokenStream>) {
        self.program.code(&self.constants, &HashMap::new(), &argument)
    }

    /// The code of the method `known`.
    fn known(&self) -> (TokenStream, Vec<TokenStream>) {
        self.program.code(
            &self.known,
            &stored(&self.constants, &quote!(constants)),
            &argument,
        )
    }

    /// The code of a method that is handed what both have computed.
    fn later(&self, outputs: &[Value]) -> (TokenStream, Vec<TokenStream>) {
        let mut given = stored(&self.known, &quote!(known));
        given.extend(stored(&self.constants, &quote!(constants)));
        self.program.code(outputs, &given, &argument)
    }
}

/// The methods of one step.
pub(super) fn methods(model: &Model) -> TokenStream {
    let n = model.coordinates.len();
    let mut graph: Graph = model.graph.clone();
    let step = mechanics::step(model, &mut graph);
    let unknowns = passes::step(&mut graph, &step.rows, n, step.multipliers);
    let stages = Stages::new(&graph, &step, &unknowns);
    let divided = model.constraints.iter().any(|row| row.divide.is_some());
    let types = types(&graph, &stages, &unknowns, divided);
    let early = early_methods(&stages, n);
    let iteration = iteration_methods(&stages, &unknowns, n);
    let node = node_methods(&stages, n);
    quote! {
        #types
        #early
        #iteration
        #node
    }
}

/// The associated types, all arrays of literal sizes, and what kind of rows there are.
fn types(graph: &Graph, stages: &Stages, unknowns: &Unknowns, divided: bool) -> TokenStream {
    let m = Literal::usize_unsuffixed(unknowns.kept.len());
    let constants = Literal::usize_unsuffixed(stages.constants.len());
    let known = Literal::usize_unsuffixed(stages.known.len());
    let affine = |&entry: &NodeId| graph.leaves(entry).all(|leaf| !matches!(leaf, Leaf::Z(_)));
    let linear = unknowns.jacobian.iter().flatten().all(affine);
    let scaled = unknowns
        .scales
        .iter()
        .any(|&scale| graph.as_constant(scale).is_none());
    quote! {
        const LINEAR: bool = #linear;
        const SCALED: bool = #scaled;
        const DIVIDED: bool = #divided;

        type Unknown<__T: ::dsocs_core::Scalar> = [__T; #m];
        type Constants<__T: ::dsocs_core::Scalar> = [__T; #constants];
        type Known<__T: ::dsocs_core::Scalar> = [__T; #known];
    }
}

/// `constants` and `known`: what comes before the iteration.
fn early_methods(stages: &Stages, n: usize) -> TokenStream {
    let n = Literal::usize_unsuffixed(n);
    let (constants_code, constants) = stages.constants();
    let (known_code, known) = stages.known();
    quote! {
        #[inline]
        fn constants<__T: ::dsocs_core::Scalar>(&self, h: __T) -> Self::Constants<__T> {
            #constants_code
            [#(#constants),*]
        }

        #[inline]
        fn known<__T: ::dsocs_core::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            leg: &::dsocs_core::Leg<__T, #n>,
        ) -> Self::Known<__T> {
            #known_code
            [#(#known),*]
        }
    }
}

/// `residual`, `unknown` and `second_difference`.
fn iteration_methods(stages: &Stages, unknowns: &Unknowns, n: usize) -> TokenStream {
    let equations: Vec<Value> = stages.rows.iter().chain(&stages.jacobian).copied().collect();
    let (residual_code, results) = stages.later(&equations);
    let (rows, jacobian) = results.split_at(stages.rows.len());
    let jacobian = matrix(jacobian, rows.len());
    let scales = scales_method(stages);
    let (difference_code, difference) = stages.later(&stages.second_difference);
    let kept = unknowns.kept.iter().map(|&leaf| match leaf {
        Leaf::Lambda(j) => {
            let j = Literal::usize_unsuffixed(j);
            quote!(multipliers.get(#j).copied().unwrap_or(__T::splat(0.0)))
        }
        other => argument(other),
    });
    let n = Literal::usize_unsuffixed(n);
    quote! {
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

        #scales

        #[inline]
        fn unknown<__T: ::dsocs_core::Scalar>(
            &self,
            e: &[__T; #n],
            multipliers: &[__T],
        ) -> Self::Unknown<__T> {
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
    }
}

/// `scales`, where there is something to tell.
fn scales_method(stages: &Stages) -> Option<TokenStream> {
    if stages.scales.iter().all(|&scale| stages.program.is_one(scale)) {
        return None;
    }
    let (code, scales) = stages.later(&stages.scales);
    Some(quote! {
        #[inline]
        fn scales<__T: ::dsocs_core::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            known: &Self::Known<__T>,
            z: &Self::Unknown<__T>,
        ) -> Self::Unknown<__T> {
            #code
            [#(#scales),*]
        }
    })
}

/// `point` and `force`: what is computed at a node once its step is solved.
fn node_methods(stages: &Stages, n: usize) -> TokenStream {
    let (point_code, point) = stages.later(&stages.point);
    let (force_code, force) = stages.later(&stages.force);
    let (q, rest) = point.split_at(n);
    let (v, a) = rest.split_at(n);
    let forms = forms_method(stages, n);
    let n = Literal::usize_unsuffixed(n);
    quote! {
        #forms

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

/// `forms`, where some are known.
fn forms_method(stages: &Stages, n: usize) -> Option<TokenStream> {
    if stages.forms.is_empty() {
        return None;
    }
    let (code, forms) = stages.later(&stages.forms);
    let forms = forms.chunks(n.max(1)).map(|form| quote!([#(#form),*]));
    let count = Literal::usize_unsuffixed(stages.forms.len() / n.max(1));
    let n = Literal::usize_unsuffixed(n);
    Some(quote! {
        const FORMS: usize = #count;

        #[inline]
        fn forms<__T: ::dsocs_core::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            known: &Self::Known<__T>,
            leg: &::dsocs_core::Leg<__T, #n>,
            e: &[__T; #n],
            out: &mut [[__T; #n]],
        ) {
            #code
            for (place, form) in out.iter_mut().zip([#(#forms),*]) {
                *place = form;
            }
        }
    })
}
