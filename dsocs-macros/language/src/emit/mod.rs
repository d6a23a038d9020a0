//! From a checked declaration to its `impl System`; nothing here can fail.
//!
//! [`crate::mechanics`] says what has to vanish, [`crate::passes`] make it fast; here code is written, and nothing else.
//! [`program`] turns expressions into straight-line code, [`step`] and [`point`] wrap that code into the methods of the
//! trait, [`jets`] writes the recurrences of Taylor series.

mod jets;
mod point;
mod program;
mod step;

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use crate::mechanics::Symmetry;
use crate::model::{Model, plain};

/// The struct as the user wrote it, and its `impl System`.
pub(crate) fn expand(model: &Model) -> TokenStream {
    let item = &model.item;
    let system = system(model);
    let jets = jets::jets(model);
    quote! {
        #item
        #system
        #jets
    }
}

/// The `impl System` of the declaration.
fn system(model: &Model) -> TokenStream {
    let name = &model.item.ident;
    let (impl_generics, type_generics, where_clause) = model.item.generics.split_for_impl();
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    let metadata = metadata(model);
    let symmetry = symmetry(model);
    let step = step::methods(model);
    let point = point::methods(model);
    quote! {
        // straight-line code: the lints for people do not apply to it
        #[allow(unused_variables, clippy::all, clippy::pedantic, clippy::nursery)]
        #[automatically_derived]
        impl #impl_generics ::dsocs_core::System<#n> for #name #type_generics #where_clause {
            #metadata
            #symmetry
            #step
            #point
        }
    }
}

/// The associated constant that says whether the step is symmetric.
fn symmetry(model: &Model) -> TokenStream {
    let variant = match Symmetry::decide(model) {
        Symmetry::AnyLegs => quote!(AnyLegs),
        Symmetry::LowerOrder => quote!(LowerOrder),
        Symmetry::Momentum => quote!(Momentum),
        Symmetry::LagrangianMap => quote!(LagrangianMap),
        Symmetry::KinematicMap => quote!(KinematicMap),
        Symmetry::VariationalMap => quote!(VariationalMap),
    };
    quote! {
        const SYMMETRY: ::dsocs_core::Symmetry = ::dsocs_core::Symmetry::#variant;
    }
}

/// Names, and access to the parameters by their place.
fn metadata(model: &Model) -> TokenStream {
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    let coordinates = model.coordinates.iter().map(plain);
    let observables = model.observe.iter().map(|(name, _)| plain(name));
    let parameters = model.parameters.iter().map(|field| {
        let (name, doc) = (&field.name, &field.doc);
        quote!(::dsocs_core::Parameter { name: #name, doc: #doc })
    });
    let index = (0..model.parameters.len()).map(Literal::usize_unsuffixed);
    let fields: Vec<_> = model
        .parameters
        .iter()
        .map(|field| {
            let ident = &field.ident;
            let element = field.element.map(|place| {
                let place = Literal::usize_unsuffixed(place);
                quote!([#place])
            });
            quote!(#ident #element)
        })
        .collect();
    let indices: Vec<_> = index.collect();
    quote! {
        const COORDINATES: [&'static str; #n] = [#(#coordinates),*];
        const PARAMETERS: &'static [::dsocs_core::Parameter] = &[#(#parameters),*];
        const OBSERVABLES: &'static [&'static str] = &[#(#observables),*];

        fn parameter(&self, index: usize) -> ::core::option::Option<f64> {
            match index {
                #(#indices => ::core::option::Option::Some(self.#fields),)*
                _ => ::core::option::Option::None,
            }
        }

        fn parameter_mut(&mut self, index: usize) -> ::core::option::Option<&mut f64> {
            match index {
                #(#indices => ::core::option::Option::Some(&mut self.#fields),)*
                _ => ::core::option::Option::None,
            }
        }
    }
}

/// `[[a, b], [c, d]]` of rows.
fn matrix(rows: &[TokenStream], width: usize) -> TokenStream {
    let rows = rows.chunks(width.max(1)).map(|row| quote!([#(#row),*]));
    quote!([#(#rows),*])
}

#[cfg(test)]
mod tests;
