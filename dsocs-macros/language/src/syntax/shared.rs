//! Statements that several declarations share: `statements! { name { … } }`, inserted by `use name;`.
//!
//! A macro cannot see into another one. So the shared statements become a macro by example of that name, and
//! an attribute with `use name;` expands to a call of that macro, which gives back the same attribute with
//! `use { … };` in place of `use name;`. The block tells shared statements from the declaration's own: they
//! cause no warnings about unused names.

use proc_macro2::{Delimiter, Group, Ident, Punct, Spacing, Span, TokenStream, TokenTree};
use quote::{quote, quote_spanned};
use syn::parse::{Parse, ParseStream, Parser};
use syn::{Attribute, Path, Token, Visibility, braced};

use crate::mistakes::errors::compile_errors;

/// A statement, as tokens with their `;`.
pub(crate) struct StatementTokens {
    /// The tokens.
    pub(crate) tokens: TokenStream,
    /// Whether it comes from shared statements.
    pub(crate) shared: bool,
}

/// The statements of a declaration in order, with those of `use { … };` blocks.
pub(crate) fn statements_in_order(declaration: TokenStream) -> Vec<StatementTokens> {
    fn push(tokens: TokenStream, shared: bool, all: &mut Vec<StatementTokens>) {
        for tokens in split_statements(tokens) {
            match use_block(&tokens) {
                Some(inner) => push(inner, true, all),
                None => all.push(StatementTokens { tokens, shared }),
            }
        }
    }
    let mut all = Vec::new();
    push(declaration, false, &mut all);
    all
}

/// Splits after every `;` outside parentheses; the last statement gets one if it has none.
fn split_statements(tokens: TokenStream) -> Vec<TokenStream> {
    let mut statements = Vec::new();
    let mut statement = Vec::new();
    for tree in tokens {
        let end = matches!(&tree, TokenTree::Punct(punct) if punct.as_char() == ';');
        statement.push(tree);
        if end {
            statements.push(statement.drain(..).collect());
        }
    }
    if let Some(last) = statement.last() {
        let mut semicolon = Punct::new(';', Spacing::Alone);
        semicolon.set_span(last.span());
        statement.push(semicolon.into());
        statements.push(statement.into_iter().collect());
    }
    statements
}

/// The tokens in `use { … };`.
fn use_block(tokens: &TokenStream) -> Option<TokenStream> {
    let mut trees = tokens.clone().into_iter();
    match (trees.next(), trees.next()) {
        (Some(TokenTree::Ident(word)), Some(TokenTree::Group(group)))
            if word == "use" && group.delimiter() == Delimiter::Brace =>
        {
            Some(group.stream())
        }
        _ => None,
    }
}

/// The path in `use name;`, or the syntax error in it; `None` for other statements.
fn used_path(tokens: &TokenStream) -> Option<syn::Result<Path>> {
    let parser = |input: ParseStream| {
        input.parse::<Token![use]>()?;
        let path = input.call(Path::parse_mod_style)?;
        input.parse::<Token![;]>()?;
        Ok(path)
    };
    let first = tokens.clone().into_iter().next()?;
    let TokenTree::Ident(word) = first else {
        return None;
    };
    let wrong = |error: syn::Error| {
        let message = "expected `use name;`, with the name or the path of a `statements! { name { … } }`";
        syn::Error::new(error.span(), message)
    };
    (word == "use").then(|| parser.parse2(tokens.clone()).map_err(wrong))
}

/// The call of the macro for the first `use name;` in a declaration; `None` if there is none.
pub(crate) fn macro_call(declaration: &TokenStream, item: &TokenStream) -> syn::Result<Option<TokenStream>> {
    let statements = statements_in_order(declaration.clone());
    let mut first = None;
    for (place, statement) in statements.iter().enumerate() {
        if let Some(path) = used_path(&statement.tokens) {
            first = Some((place, path?));
            break;
        }
    }
    let Some((place, path)) = first else {
        return Ok(None);
    };
    let attribute = attribute(&statements);
    let (before, after) = (joined(&statements[..place]), joined(&statements[place + 1..]));
    Ok(Some(quote!(#path! { [#attribute] { #before } { #after } #item })))
}

/// A declaration whose shared statements are resolved in the scope of the item, so that names in them can
/// mean the fields of its struct.
///
/// Macro hygiene tells a name in shared statements from the same name in the struct. The tokens lose that
/// hygiene here, and with it the place of their use, which a mistake in them would show.
pub(crate) fn resolve_in_scope(declaration: TokenStream, item: &TokenStream) -> TokenStream {
    let first = item.clone().into_iter().next();
    let site = first.map_or_else(Span::call_site, |tree| tree.span());
    let mut statements = statements_in_order(declaration);
    for statement in statements.iter_mut().filter(|statement| statement.shared) {
        statement.tokens = resolved_at(statement.tokens.clone(), site);
    }
    joined(&statements)
}

/// The path of the attribute, by which the call names it.
fn attribute(statements: &[StatementTokens]) -> TokenStream {
    let parser = |input: ParseStream| {
        input.parse::<Token![crate]>()?;
        input.parse::<Token![=]>()?;
        let path = input.call(Path::parse_mod_style)?;
        input.parse::<Token![;]>()?;
        Ok(path)
    };
    let core = statements
        .iter()
        .find_map(|statement| parser.parse2(statement.tokens.clone()).ok());
    core.map_or_else(|| quote!(::dsocs_core::dsocs), |path| quote!(#path::dsocs))
}

/// The tokens of statements, each shared one in a `use { … };` block.
fn joined(statements: &[StatementTokens]) -> TokenStream {
    let tokens = statements
        .iter()
        .map(|StatementTokens { tokens, shared }| match shared {
            true => quote!(use { #tokens };),
            false => tokens.clone(),
        });
    tokens.collect()
}

/// Tokens with their locations, resolved like names at `site`.
fn resolved_at(tokens: TokenStream, site: Span) -> TokenStream {
    let tree = |tree| match tree {
        TokenTree::Group(group) => {
            let mut moved = Group::new(group.delimiter(), resolved_at(group.stream(), site));
            moved.set_span(group.span().resolved_at(site));
            moved.into()
        }
        mut other => {
            other.set_span(other.span().resolved_at(site));
            other
        }
    };
    tokens.into_iter().map(tree).collect()
}

/// One item `name { … }` of `statements!`.
struct Shared {
    /// Its documentation.
    attributes: Vec<Attribute>,
    /// Its visibility.
    visibility: Visibility,
    /// Its name.
    name: Ident,
    /// The statements.
    statements: TokenStream,
}

impl Parse for Shared {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let attributes = input.call(Attribute::parse_outer)?;
        let visibility = input.parse()?;
        let name = input.parse()?;
        let body;
        braced!(body in input);
        Ok(Self {
            attributes,
            visibility,
            name,
            statements: body.parse()?,
        })
    }
}

/// The expansion of `statements! { name { … } }`: a macro by example for each name.
#[must_use]
pub fn statements(tokens: TokenStream) -> TokenStream {
    let parser = |input: ParseStream| {
        let mut all = Vec::new();
        while !input.is_empty() {
            all.push(input.parse::<Shared>()?);
        }
        Ok(all)
    };
    match parser.parse2(tokens) {
        Ok(all) => all.iter().map(macro_by_example).collect(),
        Err(error) => {
            let message = "expected `name { … }` with statements of a declaration between the braces";
            compile_errors(&[syn::Error::new(error.span(), message)])
        }
    }
}

/// The macro by example that an attribute with `use name;` calls.
fn macro_by_example(shared: &Shared) -> TokenStream {
    let Shared {
        attributes,
        visibility,
        name,
        statements,
    } = shared;
    // an exported macro is in the root of its crate, whatever module it is written in
    let (export, alias) = match visibility {
        Visibility::Public(_) => (
            quote!(#[doc(hidden)] #[macro_export]),
            Ident::new(&format!("__dsocs_statements_{name}"), name.span()),
        ),
        _ => (TokenStream::new(), name.clone()),
    };
    let import = quote!(#visibility use #alias as #name;);
    quote_spanned! {name.span()=>
        #export
        #[allow(unused_macros)]
        macro_rules! #alias {
            ([$($attribute:tt)*] { $($before:tt)* } { $($after:tt)* } $($item:tt)*) => {
                #[$($attribute)* { $($before)* use { #statements }; $($after)* }]
                $($item)*
            };
        }
        #(#attributes)*
        #[allow(unused_imports)]
        #import
    }
}
