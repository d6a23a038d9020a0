//! What a wrong declaration becomes beside its errors: an implementation that type-checks and is never run.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Generics, Ident};

/// An implementation of `System<n>` without content, so that a mistake in the declaration brings no further errors
/// where the type is used.
#[allow(clippy::too_many_lines)] // one trait, quoted
pub(crate) fn stub(ident: &Ident, generics: &Generics, n: usize) -> TokenStream {
    let (generics, arguments, bounds) = generics.split_for_impl();
    // a name that no parameter of the user's has: an associated type may not shadow one
    let scalar = quote!(__DsocsScalar);
    let known = quote!(constants: &Self::Constants<#scalar>, known: &Self::Known<#scalar>);
    quote! {
        #[automatically_derived]
        #[allow(unused_variables, clippy::all, clippy::pedantic)]
        impl #generics ::dsocs_core::System<#n> for #ident #arguments #bounds {
            type Unknown<#scalar: ::dsocs_core::Scalar> = [#scalar; #n];
            type Constants<#scalar: ::dsocs_core::Scalar> = [#scalar; 0];
            type Known<#scalar: ::dsocs_core::Scalar> = [#scalar; 0];
            type Motion<#scalar: ::dsocs_core::Scalar> = [#scalar; #n];

            const NAME: &'static str = "";
            const COORDINATES: [::dsocs_core::Quantity; #n] = [::dsocs_core::Quantity { name: "", doc: "" }; #n];
            const PARAMETERS: &'static [::dsocs_core::Quantity] = &[];
            const OBSERVABLES: &'static [::dsocs_core::Quantity] = &[];

            fn parameter(&self, index: usize) -> ::core::option::Option<f64> {
                ::core::unreachable!()
            }
            fn parameter_mut(&mut self, index: usize) -> ::core::option::Option<&mut f64> {
                ::core::unreachable!()
            }
            fn constants<#scalar: ::dsocs_core::Scalar>(&self, h: #scalar) -> Self::Constants<#scalar> {
                ::core::unreachable!()
            }
            fn known<#scalar: ::dsocs_core::Scalar>(
                &self,
                constants: &Self::Constants<#scalar>,
                leg: &::dsocs_core::Leg<#scalar, #n>,
            ) -> Self::Known<#scalar> {
                ::core::unreachable!()
            }
            fn residual<#scalar: ::dsocs_core::Scalar>(
                &self,
                #known,
                z: &Self::Unknown<#scalar>,
            ) -> ::dsocs_core::Linearization<#scalar, Self::Unknown<#scalar>> {
                ::core::unreachable!()
            }
            fn unknown<#scalar: ::dsocs_core::Scalar>(
                &self,
                e: &[#scalar; #n],
                multipliers: &[#scalar],
            ) -> Self::Unknown<#scalar> {
                ::core::unreachable!()
            }
            fn second_difference<#scalar: ::dsocs_core::Scalar>(
                &self,
                #known,
                z: &Self::Unknown<#scalar>,
            ) -> [#scalar; #n] {
                ::core::unreachable!()
            }
            fn point<#scalar: ::dsocs_core::Scalar>(
                &self,
                #known,
                leg: &::dsocs_core::Leg<#scalar, #n>,
                e: &[#scalar; #n],
            ) -> ::dsocs_core::Point<#scalar, #n> {
                ::core::unreachable!()
            }
            fn force<#scalar: ::dsocs_core::Scalar>(
                &self,
                #known,
                leg: &::dsocs_core::Leg<#scalar, #n>,
                e: &[#scalar; #n],
            ) -> [#scalar; #n] {
                ::core::unreachable!()
            }
            fn lagrangian<#scalar: ::dsocs_core::Scalar>(&self, q: &[#scalar; #n], v: &[#scalar; #n]) -> #scalar {
                ::core::unreachable!()
            }
            fn discrete_lagrangian<#scalar: ::dsocs_core::Scalar>(
                &self,
                h: #scalar,
                leg: &::dsocs_core::Leg<#scalar, #n>,
            ) -> #scalar {
                ::core::unreachable!()
            }
            fn energy<#scalar: ::dsocs_core::Scalar>(&self, q: &[#scalar; #n], v: &[#scalar; #n]) -> #scalar {
                ::core::unreachable!()
            }
            fn observe<#scalar: ::dsocs_core::Scalar>(
                &self,
                point: &::dsocs_core::Point<#scalar, #n>,
                out: &mut [#scalar],
            ) {
                ::core::unreachable!()
            }
            fn continuous<#scalar: ::dsocs_core::Scalar>(
                &self,
                point: &::dsocs_core::Point<#scalar, #n>,
                multipliers: &[#scalar],
            ) -> ::dsocs_core::Linearization<#scalar, Self::Motion<#scalar>> {
                ::core::unreachable!()
            }
            fn continuous_force<#scalar: ::dsocs_core::Scalar>(
                &self,
                point: &::dsocs_core::Point<#scalar, #n>,
            ) -> [#scalar; #n] {
                ::core::unreachable!()
            }
        }

        #[automatically_derived]
        #[allow(unused_variables, clippy::all, clippy::pedantic)]
        impl #generics ::dsocs_core::taylor::Jets<#n> for #ident #arguments #bounds {
            type Fixed = [f64; 0];
            type Table = ::dsocs_core::taylor::Table<0, 0, 0>;

            fn fixed(&self) -> Self::Fixed {
                ::core::unreachable!()
            }
            fn expand<const __DSOCS_FUSED: bool>(
                &self,
                fixed: &Self::Fixed,
                series: &mut ::dsocs_core::taylor::Series<#n>,
                table: &mut Self::Table,
            ) {
                ::core::unreachable!()
            }
        }
    }
}
