//! The implementation for a wrong declaration: it type-checks and is never run.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Generics, Ident};

use crate::emit::rust::jets;
use crate::emit::rust::kernel::{Kind, kernel, send_and_sync};

/// An empty implementation of `System<n>`, so that a mistake in the declaration causes no errors where the
/// type is used.
#[allow(clippy::too_many_lines)] // one trait, quoted
pub(crate) fn stub(ident: &Ident, generics: &Generics, n: usize) -> TokenStream {
    let jets = jets::none(ident, generics, n);
    let kernel = kernel(ident, generics, n, Kind::default());
    let generics = send_and_sync(generics);
    let (generics, arguments, bounds) = generics.split_for_impl();
    // an unlikely name, because an associated type may not shadow a type parameter of the user's
    let scalar = quote!(__DsocsScalar);
    let bound = quote!(#scalar: ::dsocs_core::__private::Scalar);
    let known = quote!(constants: &Self::Constants<#scalar>, known: &Self::Known<#scalar>);
    quote! {
        #[automatically_derived]
        #[allow(unused_variables, clippy::all, clippy::pedantic)]
        impl #generics ::dsocs_core::System<#n> for #ident #arguments #bounds {
            const NAME: &'static str = "";
            const COORDINATES: [::dsocs_core::Quantity; #n] = [const { ::dsocs_core::Quantity::new("", "") }; #n];
            const PARAMETERS: &'static [::dsocs_core::Quantity] = &[];
            const OBSERVABLES: &'static [::dsocs_core::Quantity] = &[];

            fn kernel(&self) -> &dyn ::dsocs_core::__private::Kernel {
                self
            }
            fn parameter(&self, index: usize) -> ::core::option::Option<f64> {
                ::core::unreachable!()
            }
            fn parameter_mut(&mut self, index: usize) -> ::core::option::Option<&mut f64> {
                ::core::unreachable!()
            }
        }

        #[automatically_derived]
        #[allow(unused_variables, clippy::all, clippy::pedantic)]
        impl #generics ::dsocs_core::__private::Source for #ident #arguments #bounds {
            fn shape(&self) -> &::dsocs_core::__private::Shape {
                ::core::unreachable!()
            }
            fn tape(&self) -> &::dsocs_core::__private::Tape {
                ::core::unreachable!()
            }
            fn value(&self, parameter: usize) -> f64 {
                ::core::unreachable!()
            }
            fn call(&self, which: usize, arguments: &[f64]) -> f64 {
                ::core::unreachable!()
            }
        }

        #[automatically_derived]
        #[allow(unused_variables, clippy::all, clippy::pedantic)]
        impl #generics ::dsocs_core::__private::Compiled<#n> for #ident #arguments #bounds {
            type Parameters<#bound> = [#scalar; 0];
            type Unknown<#bound> = [#scalar; #n];
            type Constants<#bound> = [#scalar; 0];
            type Known<#bound> = [#scalar; 0];
            type Motion = [f64; #n];

            fn parameters<#bound>(&self) -> Self::Parameters<#scalar> {
                ::core::unreachable!()
            }
            fn constants<#bound>(
                &self,
                parameters: &Self::Parameters<#scalar>,
                h: #scalar,
            ) -> Self::Constants<#scalar> {
                ::core::unreachable!()
            }
            fn known<#bound>(
                &self,
                constants: &Self::Constants<#scalar>,
                leg: &::dsocs_core::Leg<#scalar, #n>,
            ) -> Self::Known<#scalar> {
                ::core::unreachable!()
            }
            fn linearize<#bound>(
                &self,
                #known,
                z: &Self::Unknown<#scalar>,
            ) -> ::dsocs_core::__private::Linearization<#scalar, Self::Unknown<#scalar>> {
                ::core::unreachable!()
            }
            fn unknown<#bound>(
                &self,
                e: &[#scalar; #n],
                multipliers: &[#scalar],
            ) -> Self::Unknown<#scalar> {
                ::core::unreachable!()
            }
            fn second_difference<#bound>(
                &self,
                #known,
                z: &Self::Unknown<#scalar>,
            ) -> [#scalar; #n] {
                ::core::unreachable!()
            }
            fn report<#bound>(
                &self,
                #known,
                leg: &::dsocs_core::Leg<#scalar, #n>,
                e: &[#scalar; #n],
            ) -> ::dsocs_core::__private::Report<#scalar, #n> {
                ::core::unreachable!()
            }
        }

        #kernel
        #jets
    }
}
