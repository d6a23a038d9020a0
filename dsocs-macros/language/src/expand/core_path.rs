//! The path of `dsocs-core` in generated code: `::dsocs_core`, unless the declaration says `crate = path;`.

use proc_macro2::{Group, Ident, Punct, Spacing, TokenStream, TokenTree};
use quote::ToTokens;
use syn::Path;

/// The generated code with every `::dsocs_core` replaced by a path.
pub(crate) fn with_path(code: TokenStream, path: &Path) -> TokenStream {
    let mut trees: Vec<TokenTree> = Vec::new();
    for tree in code {
        match tree {
            TokenTree::Ident(ident) if ident == "dsocs_core" && ends_in_colons(&trees) => {
                trees.truncate(trees.len() - 2);
                trees.extend(path.to_token_stream());
            }
            TokenTree::Group(group) => {
                let mut inner = Group::new(group.delimiter(), with_path(group.stream(), path));
                inner.set_span(group.span());
                trees.push(inner.into());
            }
            other => trees.push(other),
        }
    }
    trees.into_iter().collect()
}

/// Whether the tokens end in a `::` with no name before it, so that a crate's name follows.
fn ends_in_colons(trees: &[TokenTree]) -> bool {
    let colon = |punct: &Punct| punct.as_char() == ':';
    match trees {
        [before @ .., TokenTree::Punct(first), TokenTree::Punct(second)] => {
            // a keyword may stand before it, as in `impl ::dsocs_core::System`
            let after_a_name = before
                .last()
                .is_some_and(|tree| syn::parse2::<Ident>(tree.clone().into()).is_ok());
            colon(first) && colon(second) && first.spacing() == Spacing::Joint && !after_a_name
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crate_alone_is_replaced() {
        let code = "use ::dsocs_core::Scalar as _; impl ::dsocs_core::System<2> for A { \
                    fn f(x: &::dsocs_core::Leg<T, 2>) -> a::dsocs_core::B { <::dsocs_core::C>::d(dsocs_core) } }";
        let wanted = "use prelude::core::Scalar as _; impl prelude::core::System<2> for A { \
                      fn f(x: &prelude::core::Leg<T, 2>) -> a::dsocs_core::B { <prelude::core::C>::d(dsocs_core) } }";
        let path = syn::parse_str("prelude::core").unwrap();
        let found = with_path(code.parse().unwrap(), &path).to_string();
        let packed = |text: &str| text.replace(' ', "");
        assert_eq!(packed(&found), packed(wanted));
    }
}
