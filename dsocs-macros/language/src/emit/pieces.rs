//! Small helpers for generated code.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Generics, parse_quote};

/// The generics of a declared type, with a bound that it can be sent between threads, which a kernel
/// requires.
pub(crate) fn between_threads(generics: &Generics) -> Generics {
    let mut generics = generics.clone();
    if generics.type_params().next().is_some() {
        let bound = parse_quote!(Self: ::core::marker::Send + ::core::marker::Sync);
        generics.make_where_clause().predicates.push(bound);
    }
    generics
}

/// The array `[[a, b], [c, d]]` of some entries, row by row.
pub(super) fn matrix(rows: &[TokenStream], width: usize) -> TokenStream {
    let rows = rows.chunks(width.max(1)).map(|row| quote!([#(#row),*]));
    quote!([#(#rows),*])
}
