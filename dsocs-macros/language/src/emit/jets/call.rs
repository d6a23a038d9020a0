//! Calls of the user's functions with jets.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote_spanned;

use crate::graph::Callee;

/// A call with jets for its value, with dual numbers of jets nested as deep as the partial derivative asks, seeded one
/// argument a level.
pub(super) fn call(callee: &Callee, args: &[Ident], wrt: &[usize]) -> TokenStream {
    // everything at the user's name, so that rustc's word on a wrong function points there
    let span = callee.span();
    let args: Vec<_> = args
        .iter()
        .enumerate()
        .map(|(place, arg)| seed(span, arg, place, wrt))
        .collect();
    let result = match callee {
        Callee::Function(function) => quote_spanned!(span=> #function(#(#args),*)),
        Callee::Method(method) => {
            let (receiver, rest) = (&args[0], &args[1..]);
            quote_spanned!(span=> (#receiver).#method(#(#rest),*))
        }
    };
    let parts = wrt.iter().map(|_| Ident::new("eps", span));
    quote_spanned!(span=> #result #(.#parts)*)
}

fn seed(span: Span, value: &Ident, place: usize, wrt: &[usize]) -> TokenStream {
    match wrt.split_first() {
        None => quote_spanned!(span=> #value),
        Some((&first, rest)) => {
            let inner = seed(span, value, place, rest);
            let tangent = seed_constant(span, if first == place { 1.0 } else { 0.0 }, rest.len());
            quote_spanned!(span=> ::dsocs_core::__private::Dual::new(#inner, #tangent))
        }
    }
}

fn seed_constant(span: Span, value: f64, depth: usize) -> TokenStream {
    if depth == 0 {
        let value = Literal::f64_suffixed(value);
        return quote_spanned!(span=> ::dsocs_core::taylor::Jet::from(#value));
    }
    let (inner, zero) = (
        seed_constant(span, value, depth - 1),
        seed_constant(span, 0.0, depth - 1),
    );
    quote_spanned!(span=> ::dsocs_core::__private::Dual::new(#inner, #zero))
}
