//! Arbitrary text as a declaration: the attribute answers with code or with errors, and both are Rust.

#![no_main]

use libfuzzer_sys::fuzz_target;
use proc_macro2::TokenStream;

/// What stands between a declaration and its item; without it the item is [`ITEM`].
const SEPARATOR: &str = "\n---\n";

/// A struct with parameters of many kinds.
const ITEM: &str = "struct Body<K: Curvature> {
    mass: f64, curvature: K, count: u32, flag: bool, masses: [f64; 3], a: f64, b: f64, rho: f64,
}";

fuzz_target!(|text: &str| {
    let (declaration, item) = text.split_once(SEPARATOR).unwrap_or((text, ITEM));
    let (Ok(declaration), Ok(item)) = (declaration.parse::<TokenStream>(), item.parse::<TokenStream>()) else {
        return; // rustc's lexer refuses it before the attribute is asked
    };
    let readable = syn::parse2::<syn::Item>(item.clone()).is_ok();
    let code = dsocs_language::expand(declaration, &item);
    if readable && let Err(error) = syn::parse2::<syn::File>(code.clone()) {
        panic!("no Rust: {error}\n{code}");
    }
});
