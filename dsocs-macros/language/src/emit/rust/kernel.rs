//! `impl Kernel`: the compiled step on slices, each method of which is one call.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;
use syn::{Generics, parse_quote};

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
    let generics = send_and_sync(generics);
    let (impl_generics, type_generics, where_clause) = generics.split_for_impl();
    let kernel = quote!(::dsocs_core::__private::kernel);
    let of = quote!(::<Self, #n>);
    let leg = quote!(::dsocs_core::__private::AnyLeg<'_, f64>);
    let at = quote!(at: ::dsocs_core::__private::At<'_>);
    let third_order = kind.third_order.then(|| {
        quote! {
            fn remember(&self, constants: &mut [f64], past: &[f64]) {
                #kernel::remember #of(constants, past)
            }
            fn past(&self, constants: &[f64], past: &mut [f64]) {
                #kernel::past #of(constants, past)
            }
        }
    });
    let sparse = kind.sparse.then(|| {
        quote! {
            fn sparse(&self) -> ::core::option::Option<&::dsocs_core::__private::Sparse> {
                <Self as ::dsocs_core::__private::Compiled<#n>>::sparse(self)
            }
            fn entries(&self, #at, rows: &mut [f64], entries: &mut [f64]) {
                #kernel::entries #of(self, at, rows, entries)
            }
        }
    });
    let scales = kind.scaled.then(|| {
        quote! {
            fn scales(&self, #at, scales: &mut [f64]) {
                #kernel::scales #of(self, at, scales)
            }
        }
    });
    quote! {
        #[allow(clippy::all, clippy::pedantic, clippy::nursery)]
        #[automatically_derived]
        impl #impl_generics ::dsocs_core::__private::Kernel for #name #type_generics #where_clause {
            fn constants(&self, parameters: &[f64], h: f64, constants: &mut [f64]) {
                #kernel::constants #of(self, parameters, h, constants)
            }
            #third_order
            fn known(&self, constants: &[f64], leg: #leg, known: &mut [f64]) {
                #kernel::known #of(self, constants, leg, known)
            }
            fn linearize(&self, #at, rows: &mut [f64], jacobian: &mut [f64]) {
                #kernel::linearize #of(self, at, rows, jacobian)
            }
            #sparse
            #scales
            fn unknown(&self, e: &[f64], multipliers: &[f64], z: &mut [f64]) {
                #kernel::unknown #of(self, e, multipliers, z)
            }
            fn second_difference(&self, #at, e: &mut [f64]) {
                #kernel::second_difference #of(self, at, e)
            }
            fn smooth(&self, run_state: &mut ::dsocs_core::__private::RunState, count: u64) -> ::dsocs_core::__private::Halt {
                #kernel::smooth #of(self, run_state, count)
            }
            fn report(&self, run_state: &::dsocs_core::__private::RunState, node: ::dsocs_core::__private::NodeMut<'_>) {
                #kernel::report #of(self, run_state, node)
            }
        }
    }
}

/// The generics of a declared type, with a bound that it can be sent between threads, which a kernel
/// requires.
pub(crate) fn send_and_sync(generics: &Generics) -> Generics {
    let mut generics = generics.clone();
    if generics.type_params().next().is_some() {
        let bound = parse_quote!(Self: ::core::marker::Send + ::core::marker::Sync);
        generics.make_where_clause().predicates.push(bound);
    }
    generics
}
