//! The attribute `#[dsocs]`.
mod annihilator;
mod ast;
mod check;
mod emit;
mod errors;
mod expand;
mod graph;
mod input;
mod lower;
mod model;
mod names;
mod parse;
mod stub;

use proc_macro::TokenStream;

/// x
#[proc_macro_attribute]
pub fn dsocs(declaration: TokenStream, item: TokenStream) -> TokenStream {
    expand::expand(declaration.into(), item.into()).into()
}
