//! `impl Kernel`: the hot form on slices, each method of which is one call.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;
use syn::Generics;

use super::pieces::between_threads;

/// Features that decide which optional methods of the trait are written.
#[derive(Clone, Copy, Default)]
pub(crate) struct Kind {
    /// Whether a constraint is of third order.
    pub(crate) third_order: bool,
    /// Whether the Jacobian is eliminated as a sparse matrix.
    pub(crate) sparse: bool,
    /// Whether a row has a factor that is not a number.
    pub(crate) scaled: bool,
}

/// `impl Kernel` of a declared type with `n` coordinates.
pub(crate) fn kernel(name: &Ident, generics: &Generics, n: usize, kind: Kind) -> TokenStream {
    let n = Literal::usize_unsuffixed(n);
    let generics = between_threads(generics);
    let (impl_generics, type_generics, where_clause) = generics.split_for_impl();
    let hot = quote!(::dsocs_core::__private::kernel);
    let of = quote!(::<Self, #n>);
    let leg = quote!(::dsocs_core::__private::AnyLeg<'_, f64>);
    let at = quote!(at: ::dsocs_core::__private::At<'_>);
    let third_order = kind.third_order.then(|| {
        quote! {
            fn remember(&self, constants: &mut [f64], past: &[f64]) {
                #hot::remember #of(constants, past)
            }
            fn past(&self, constants: &[f64], past: &mut [f64]) {
                #hot::past #of(constants, past)
            }
        }
    });
    let sparse = kind.sparse.then(|| {
        quote! {
            fn sparse(&self) -> ::core::option::Option<&::dsocs_core::__private::Sparse> {
                <Self as ::dsocs_core::__private::Compiled<#n>>::sparse(self)
            }
            fn entries(&self, #at, rows: &mut [f64], entries: &mut [f64]) {
                #hot::entries #of(self, at, rows, entries)
            }
        }
    });
    let scales = kind.scaled.then(|| {
        quote! {
            fn scales(&self, #at, scales: &mut [f64]) {
                #hot::scales #of(self, at, scales)
            }
        }
    });
    quote! {
        #[allow(clippy::all, clippy::pedantic, clippy::nursery)]
        #[automatically_derived]
        impl #impl_generics ::dsocs_core::__private::Kernel for #name #type_generics #where_clause {
            fn constants(&self, parameters: &[f64], h: f64, constants: &mut [f64]) {
                #hot::constants #of(self, parameters, h, constants)
            }
            #third_order
            fn known(&self, constants: &[f64], leg: #leg, known: &mut [f64]) {
                #hot::known #of(self, constants, leg, known)
            }
            fn linearize(&self, #at, rows: &mut [f64], jacobian: &mut [f64]) {
                #hot::linearize #of(self, at, rows, jacobian)
            }
            #sparse
            #scales
            fn unknown(&self, e: &[f64], multipliers: &[f64], z: &mut [f64]) {
                #hot::unknown #of(self, e, multipliers, z)
            }
            fn second_difference(&self, #at, e: &mut [f64]) {
                #hot::second_difference #of(self, at, e)
            }
            fn smooth(&self, run_state: &mut ::dsocs_core::__private::RunState, count: u64) -> ::dsocs_core::__private::Halt {
                #hot::smooth #of(self, run_state, count)
            }
            fn report(&self, run_state: &::dsocs_core::__private::RunState, node: ::dsocs_core::__private::NodeMut<'_>) {
                #hot::report #of(self, run_state, node)
            }
        }
    }
}
