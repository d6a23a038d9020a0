//! `impl Source`: the tape of a declaration, and the functions that it calls.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::functions::Functions;
use super::kernel::send_and_sync;
use crate::emit::tape::TapeWithCalls;
use crate::model::Model;

/// `impl Source` of the declaration.
pub(crate) fn source(
    model: &Model,
    TapeWithCalls { bytes, calls }: &TapeWithCalls,
    functions: &Functions,
) -> TokenStream {
    let name = &model.item.ident;
    let generics = send_and_sync(&model.item.generics);
    let (impl_generics, type_generics, where_clause) = generics.split_for_impl();
    let tape = Literal::byte_string(bytes);
    let arms = calls.arms(&model.graph, functions);
    let dual_arms = calls.dual_arms(&model.graph, functions);
    let call_dual = (!dual_arms.is_empty()).then(|| {
        quote! {
            fn call_dual(
                &self,
                which: usize,
                arguments: &[::dsocs_core::__private::Dual<f64>],
            ) -> ::dsocs_core::__private::Dual<f64> {
                match (which, arguments) {
                    #(#dual_arms,)*
                    (_, &[]) => ::dsocs_core::__private::Dual::new(self.call(which, &[]), 0.0),
                    _ => ::dsocs_core::__private::Dual::new(f64::NAN, f64::NAN),
                }
            }
        }
    });
    let data_arms = calls.data_arms(model);
    let data = (!data_arms.is_empty()).then(|| {
        quote! {
            fn data(&self, which: usize) -> ::core::option::Option<::dsocs_core::__private::CallData<'_>> {
                match which {
                    #(#data_arms,)*
                    _ => ::core::option::Option::None,
                }
            }
        }
    });
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    quote! {
        #[allow(unused_variables, clippy::all, clippy::pedantic, clippy::nursery)]
        #[automatically_derived]
        impl #impl_generics ::dsocs_core::__private::Source for #name #type_generics #where_clause {
            fn shape(&self) -> &::dsocs_core::__private::Shape {
                const { &::dsocs_core::__private::Shape::of::<Self, #n>() }
            }

            fn tape(&self) -> &::dsocs_core::__private::Tape {
                static TAPE: ::dsocs_core::__private::Tape = ::dsocs_core::__private::Tape::new(#tape);
                &TAPE
            }

            fn value(&self, parameter: usize) -> f64 {
                <Self as ::dsocs_core::System<#n>>::parameter(self, parameter).unwrap_or(f64::NAN)
            }

            fn call(&self, which: usize, arguments: &[f64]) -> f64 {
                match (which, arguments) {
                    #(#arms,)*
                    _ => f64::NAN,
                }
            }

            #call_dual

            #data
        }
    }
}
