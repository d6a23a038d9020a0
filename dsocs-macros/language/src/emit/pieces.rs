//! Small pieces of code that many functions are written with.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Generics, parse_quote};

/// The generics of a declared type, where what is generic can go from thread to thread: a kernel does.
pub(crate) fn between_threads(generics: &Generics) -> Generics {
    let mut generics = generics.clone();
    if generics.type_params().next().is_some() {
        let bound = parse_quote!(Self: ::core::marker::Send + ::core::marker::Sync);
        generics.make_where_clause().predicates.push(bound);
    }
    generics
}

/// `[[a, b], [c, d]]` of rows.
pub(super) fn matrix(rows: &[TokenStream], width: usize) -> TokenStream {
    let rows = rows.chunks(width.max(1)).map(|row| quote!([#(#row),*]));
    quote!([#(#rows),*])
}
