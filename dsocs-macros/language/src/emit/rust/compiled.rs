//! `impl Compiled`: straight-line code of the functions that a run evaluates often.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::kernel::send_and_sync;
use super::place::Place;
use super::straight_line::matrix;
use crate::emit::facts::Facts;
use crate::graph::Leaf;
use crate::hash::HashMap;
use crate::model::Model;
use crate::passes::sparse::Order;
use crate::program::Value;
use crate::program::stages::Stages;
use crate::syntax::input::ParameterField;

/// The place of a leaf in the arguments of the generated methods.
fn argument(leaf: Leaf) -> Place {
    match leaf {
        Leaf::H => Place::number("h"),
        Leaf::T => Place::number("t"),
        Leaf::Clock => Place::value(quote!(leg.t)),
        Leaf::N(i) => Place::own(quote!(leg.q), i),
        Leaf::D(i) => Place::own(quote!(leg.d), i),
        Leaf::P(i) => Place::own(quote!(past), i),
        Leaf::E(i) => Place::element("e", i),
        Leaf::Z(j) => Place::element("z", j),
        Leaf::Q(i) => Place::own(quote!(q), i),
        Leaf::V(i) => Place::own(quote!(v), i),
        Leaf::A(i) => Place::own(quote!(a), i),
        Leaf::Lambda(j) => Place::element("multipliers", j),
        // the nodes of a map are replaced before code is written, and no step has a jerk; sides occur on the
        // tape only
        Leaf::X0(_)
        | Leaf::X1(_)
        | Leaf::X2(_)
        | Leaf::Chord(_)
        | Leaf::T0
        | Leaf::T1
        | Leaf::T2
        | Leaf::J(_)
        | Leaf::Side(_) => Place::nowhere(),
    }
}

/// The code of a method of a step, which is given `constants` and `known`.
fn code_in_step(stages: &Stages, outputs: &[Value]) -> (TokenStream, Vec<TokenStream>) {
    stages.program.code(outputs, &stages.in_step(), "n", &argument)
}

/// `impl Compiled` of the declaration.
pub(super) fn compiled(model: &Model, facts: &Facts, stages: &Stages) -> TokenStream {
    let name = &model.item.ident;
    let generics = send_and_sync(&model.item.generics);
    let (impl_generics, type_generics, where_clause) = generics.split_for_impl();
    let n = model.coordinates.len();
    let types = types(facts);
    let early = early_methods(model, stages);
    let iteration = iteration_methods(stages, n);
    let report = report_method(model, stages);
    let third_order = third_order(model, stages);
    let rotations = rotations(model);
    let n = Literal::usize_unsuffixed(n);
    quote! {
        // generated straight-line code needs no lints. The methods of a step have to be inlined: lanes
        // compile their steps for the machine's own instructions, and functions outside are not compiled for
        // these
        #[allow(unused_variables, clippy::all, clippy::pedantic, clippy::nursery)]
        #[automatically_derived]
        impl #impl_generics ::dsocs_core::__private::Compiled<#n> for #name #type_generics #where_clause {
            #types
            #third_order
            #rotations
            #early
            #iteration
            #report
        }
    }
}

/// The associated types, all arrays of literal sizes, and the constants about the rows.
fn types(facts: &Facts) -> TokenStream {
    let Facts {
        linear,
        jumps,
        piecewise,
        switches,
        scaled,
        divided,
        ..
    } = facts;
    let [parameters, m, constants, known, motion] = [
        facts.parameters,
        facts.unknowns,
        facts.constants,
        facts.known,
        facts.motion,
    ]
    .map(Literal::usize_unsuffixed);
    // empty lists have a default in the trait
    let places = |name: TokenStream, places: &[usize]| {
        let literals = places.iter().copied().map(Literal::usize_unsuffixed);
        (!places.is_empty()).then(|| quote!(const #name: &'static [usize] = &[#(#literals),*];))
    };
    let of_positions = places(quote!(OF_POSITIONS), &facts.of_positions);
    let of_rates = places(quote!(OF_RATES), &facts.of_rates);
    let switching = switches.then(|| {
        quote!(
            const SWITCHING: bool = true;
        )
    });
    quote! {
        #of_positions
        #of_rates
        const LINEAR: bool = #linear;
        const JUMPS: bool = #jumps;
        const PIECEWISE: bool = #piecewise;
        #switching
        const SCALED: bool = #scaled;
        const DIVIDED: bool = #divided;

        type Parameters<__T: ::dsocs_core::__private::Scalar> = [__T; #parameters];
        type Unknown<__T: ::dsocs_core::__private::Scalar> = [__T; #m];
        type Constants<__T: ::dsocs_core::__private::Scalar> = [__T; #constants];
        type Known<__T: ::dsocs_core::__private::Scalar> = [__T; #known];
        type Motion = [f64; #motion];
    }
}

/// The number of components of the previous second difference that a step needs.
fn past_count(model: &Model) -> usize {
    if model.order() > 2 {
        model.coordinates.len()
    } else {
        0
    }
}

/// The first slots of the rotations; `None` if there are none.
fn rotations(model: &Model) -> Option<TokenStream> {
    let first: Vec<_> = (model.graph.rotations().iter())
        .map(|&first| Literal::usize_unsuffixed(first))
        .collect();
    (!first.is_empty()).then(|| quote!(const ROTATIONS: &'static [usize] = &[#(#first),*];))
}

/// The methods for a step of third order, which stores the previous second difference behind the constants.
fn third_order(model: &Model, stages: &Stages) -> Option<TokenStream> {
    let rows: Vec<_> = model.third_order().map(Literal::usize_unsuffixed).collect();
    if rows.is_empty() {
        return None;
    }
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    let first = stages.constants_count();
    let places: Vec<_> = (first..first + past_count(model))
        .map(Literal::usize_unsuffixed)
        .collect();
    let components = (0..places.len()).map(Literal::usize_unsuffixed);
    Some(quote! {
        const THIRD_ORDER: &'static [usize] = &[#(#rows),*];

        #[inline]
        fn past<__T: ::dsocs_core::__private::Scalar>(constants: &Self::Constants<__T>) -> [__T; #n] {
            [#(constants[#places]),*]
        }

        #[inline]
        fn remember<__T: ::dsocs_core::__private::Scalar>(constants: &mut Self::Constants<__T>, past: &[__T; #n]) {
            #(constants[#places] = past[#components];)*
        }
    })
}

/// The statement that reads the previous second difference.
fn past(model: &Model) -> Option<TokenStream> {
    (model.order() > 2).then(|| quote!(let past = Self::past(constants);))
}

/// `parameters`, `constants` and `known`: values known before the iteration.
fn early_methods(model: &Model, stages: &Stages) -> TokenStream {
    let read = model.parameters.iter().map(ParameterField::read);
    let nothing = HashMap::default();
    let (constants_code, constants) = stages.program.code(&stages.constants, &nothing, "n", &argument);
    let energy = &stages.energy;
    let (energy_code, of_energy) = energy.program.code(&energy.constants, &nothing, "m", &argument);
    let (known_code, known) = stages
        .program
        .code(&stages.known, &stages.in_run(), "n", &argument);
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    let past = past(model);
    let none = (0..past_count(model)).map(|_| quote!(__T::splat(0.0)));
    quote! {
        #[inline]
        fn parameters<__T: ::dsocs_core::__private::Scalar>(&self) -> Self::Parameters<__T> {
            [#(__T::splat(#read)),*]
        }

        #[inline]
        fn constants<__T: ::dsocs_core::__private::Scalar>(
            &self,
            parameters: &Self::Parameters<__T>,
            h: __T,
        ) -> Self::Constants<__T> {
            #constants_code
            #energy_code
            [#(#constants,)* #(#of_energy,)* #(#none),*]
        }

        #[inline(always)]
        fn known<__T: ::dsocs_core::__private::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            leg: &::dsocs_core::Leg<__T, #n>,
        ) -> Self::Known<__T> {
            #past
            #known_code
            [#(#known),*]
        }
    }
}

/// The arguments of a method that is evaluated at the unknowns of a step.
fn unknown_arguments() -> TokenStream {
    quote! {
        constants: &Self::Constants<__T>,
        known: &Self::Known<__T>,
        z: &Self::Unknown<__T>,
    }
}

/// `linearize`, `scales`, `unknown` and `second_difference`.
fn iteration_methods(stages: &Stages, n: usize) -> TokenStream {
    let linearize = match &stages.sparse {
        Some(order) => sparse_methods(stages, order),
        None => linearize_method(stages),
    };
    let scales = scales_method(stages);
    let unknown_arguments = unknown_arguments();
    let (difference_code, difference) = code_in_step(stages, &stages.second_difference);
    let meanings = stages.meanings.iter().map(|&leaf| match leaf {
        Leaf::Lambda(j) => {
            let j = Literal::usize_unsuffixed(j);
            quote!(multipliers.get(#j).copied().unwrap_or(__T::splat(0.0)))
        }
        other => argument(other).read(),
    });
    let n = Literal::usize_unsuffixed(n);
    quote! {
        #linearize

        #scales

        #[inline(always)]
        fn unknown<__T: ::dsocs_core::__private::Scalar>(
            &self,
            e: &[__T; #n],
            multipliers: &[__T],
        ) -> Self::Unknown<__T> {
            [#(#meanings),*]
        }

        #[inline(always)]
        fn second_difference<__T: ::dsocs_core::__private::Scalar>(
            &self,
            #unknown_arguments
        ) -> [__T; #n] {
            #difference_code
            [#(#difference),*]
        }
    }
}

/// `linearize`: the rows and their Jacobian.
fn linearize_method(stages: &Stages) -> TokenStream {
    let (code, results) = code_in_step(stages, &stages.residual());
    let (rows, jacobian) = results.split_at(stages.rows.len());
    let jacobian = matrix(jacobian, rows.len());
    let unknown_arguments = unknown_arguments();
    quote! {
        #[inline(always)]
        fn linearize<__T: ::dsocs_core::__private::Scalar>(
            &self,
            #unknown_arguments
        ) -> ::dsocs_core::__private::Linearization<__T, Self::Unknown<__T>> {
            #code
            ::dsocs_core::__private::Linearization { rows: [#(#rows),*], jacobian: #jacobian }
        }
    }
}

/// `linearize` with a sparse Jacobian: its entries that are not identically zero, and the order of
/// elimination.
fn sparse_methods(stages: &Stages, order: &Order) -> TokenStream {
    let (code, results) = code_in_step(stages, &stages.entries(order));
    let (rows, entries) = results.split_at(stages.rows.len());
    let [size, count] = [rows.len(), entries.len()].map(Literal::usize_unsuffixed);
    let places = |places: &[[usize; 2]]| {
        let places = places.iter().map(|place| {
            let [row, column] = place.map(Literal::usize_unsuffixed);
            quote!([#row, #column])
        });
        quote!(&[#(#places),*])
    };
    let (where_entries, pivots) = (places(&order.entries), places(&order.pivots));
    let unknown_arguments = unknown_arguments();
    quote! {
        const SPARSE: bool = true;

        fn sparse(&self) -> ::core::option::Option<&'static ::dsocs_core::__private::Sparse> {
            static SPARSE: ::dsocs_core::__private::Sparse =
                ::dsocs_core::__private::Sparse::new(#size, #where_entries, #pivots);
            ::core::option::Option::Some(&SPARSE)
        }

        fn entries<__T: ::dsocs_core::__private::Scalar>(
            &self,
            #unknown_arguments
            entries: &mut [__T],
        ) -> Self::Unknown<__T> {
            #code
            entries.copy_from_slice(&[#(#entries),*]);
            [#(#rows),*]
        }

        fn linearize<__T: ::dsocs_core::__private::Scalar>(
            &self,
            #unknown_arguments
        ) -> ::dsocs_core::__private::Linearization<__T, Self::Unknown<__T>> {
            let mut entries = [__T::splat(0.0); #count];
            let rows = self.entries(constants, known, z, &mut entries);
            let jacobian = ::dsocs_core::__private::Compiled::sparse(self)
                .map(|sparse| sparse.dense::<__T, Self::Unknown<__T>>(&entries))
                .unwrap_or_else(<Self::Unknown<__T> as ::dsocs_core::__private::Unknown<__T>>::zeros);
            ::dsocs_core::__private::Linearization { rows, jacobian }
        }
    }
}

/// `scales`, unless no row has a factor.
fn scales_method(stages: &Stages) -> Option<TokenStream> {
    if stages.unscaled() {
        return None;
    }
    let (code, scales) = code_in_step(stages, &stages.scales);
    let unknown_arguments = unknown_arguments();
    Some(quote! {
        #[inline(always)]
        fn scales<__T: ::dsocs_core::__private::Scalar>(
            &self,
            #unknown_arguments
        ) -> Self::Unknown<__T> {
            #code
            [#(#scales),*]
        }
    })
}

/// `report`: point, force and energy at a node whose step has been solved.
fn report_method(model: &Model, stages: &Stages) -> TokenStream {
    let (n, past) = (model.coordinates.len(), past(model));
    let (code, results) = code_in_step(stages, &stages.node());
    let (point, force) = results.split_at(3 * n + 1);
    let (q, rest) = point.split_at(n);
    let (v, rest) = rest.split_at(n);
    let (a, t) = rest.split_at(n);
    let energy = &stages.energy;
    // the point is an operand of the energy, so that the energy has the same bits wherever the point comes
    // from
    let (energy_code, energy) = energy
        .program
        .code(&energy.value, &stages.in_energy(), "m", &argument);
    let n = Literal::usize_unsuffixed(n);
    quote! {
        #[inline(always)]
        fn report<__T: ::dsocs_core::__private::Scalar>(
            &self,
            constants: &Self::Constants<__T>,
            known: &Self::Known<__T>,
            leg: &::dsocs_core::Leg<__T, #n>,
            e: &[__T; #n],
        ) -> ::dsocs_core::__private::Report<__T, #n> {
            #past
            #code
            let q: [__T; #n] = [#(#q),*];
            let v: [__T; #n] = [#(#v),*];
            let t: __T = #(#t)*;
            #energy_code
            ::dsocs_core::__private::Report {
                point: ::dsocs_core::Point { t, q, v, a: [#(#a),*] },
                force: [#(#force),*],
                energy: #(#energy)*,
            }
        }
    }
}
