//! Fuzzing: arbitrary text as a declaration. The attribute answers with code or with errors, and both have to
//! parse as Rust.

#![no_main]

use libfuzzer_sys::fuzz_target;
use proc_macro2::TokenStream;

/// The separator between a declaration and its item; without it the item is [`ITEM`].
const SEPARATOR: &str = "\n---\n";

/// A struct with parameters of many kinds.
const ITEM: &str = "struct Body<K: Curvature> {
    mass: f64, curvature: K, count: u32, flag: bool, masses: [f64; 3], a: f64, b: f64, rho: f64,
}";

fuzz_target!(|text: &str| {
    let (declaration, item) = text.split_once(SEPARATOR).unwrap_or((text, ITEM));
    let (Ok(declaration), Ok(item)) = (declaration.parse::<TokenStream>(), item.parse::<TokenStream>())
    else {
        return; // rustc's lexer refuses it before the attribute is asked
    };
    let source = format!("#[dsocs {{\n{declaration}\n}}]\n{item}");
    match dsocs_language::analyze(source.as_str()) {
        Ok(model) => assert_rust(model.code()),
        Err(mistakes) => {
            assert!(!mistakes.is_empty(), "refused without a word");
            let lines = 1..=source.lines().count() + 1;
            let outside = mistakes
                .iter()
                .find(|mistake| !lines.contains(&mistake.line) || mistake.column == 0);
            assert!(outside.is_none(), "no place in {source}: {outside:?}");
            if syn::parse2::<syn::Item>(item.clone()).is_ok() {
                assert_rust(dsocs_language::expand(declaration, &item));
            }
        }
    }
});

/// Asserts that the output of the attribute parses as Rust.
fn assert_rust(code: TokenStream) {
    if let Err(error) = syn::parse2::<syn::File>(code.clone()) {
        panic!("no Rust: {error}\n{code}");
    }
}
