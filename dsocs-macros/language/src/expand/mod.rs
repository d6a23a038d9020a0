//! The whole front end: the tokens of the attribute and of the item → the item with its implementation, or
//! errors.

pub(crate) mod core_path;
pub(crate) mod source;
mod stub;

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Generics, Ident, Item, Path};

use crate::check::check;
use crate::emit::{Data, Series};
use crate::mistakes::errors::{Errors, compile_errors};
use crate::model::Model;
use crate::syntax::input::{Fields, not_a_struct};
use crate::syntax::{layout, shared};
use crate::{emit, lower, parse};

/// The expansion of `#[dsocs { declaration }] item`: the item with its implementation. For a wrong
/// declaration it is the item with an error at every mistake and an empty implementation, so that no other
/// errors follow.
#[must_use]
pub fn expand(declaration: TokenStream, item: &TokenStream) -> TokenStream {
    let refused = match (
        syn::parse2::<Item>(item.clone()),
        shared::macro_call(&declaration, item),
    ) {
        (Ok(_), Ok(Some(call))) => return call,
        (Ok(parsed), Ok(None)) => match model(shared::resolve_in_scope(declaration.clone(), item), &parsed) {
            Ok(model) => return model.code(),
            // read again without `in_scope`: then a mistake in shared statements also shows where they are
            // used
            Err(refused) => model(declaration, &parsed).err().unwrap_or(refused),
        },
        (Err(error), _) | (_, Err(error)) => WrongDeclaration {
            errors: vec![error],
            stub: TokenStream::new(),
        },
    };
    let (errors, stub) = (compile_errors(&refused.errors), refused.stub);
    quote!(#item #errors #stub)
}

impl Model {
    /// The struct and its trait implementations, as the attribute generates them.
    #[must_use]
    pub fn code(&self) -> TokenStream {
        with_core_path(emit::expand(self), self.core.as_ref())
    }

    /// The declaration as data, for an engine that runs it without a compiler.
    #[must_use]
    pub fn data(&self) -> Data {
        emit::data(self)
    }

    /// The recurrences of its Taylor series as data; `None` for a system of third order, which has none.
    #[must_use]
    pub fn series(&self) -> Option<Series> {
        emit::series(self)
    }
}

/// The result of a wrong declaration.
#[derive(Debug)]
pub(crate) struct WrongDeclaration {
    /// The mistakes, at least one.
    pub(crate) errors: Vec<syn::Error>,
    /// The empty implementation, if the number of coordinates is known.
    pub(crate) stub: TokenStream,
}

/// The model of a declaration, or its mistakes.
pub(crate) fn model(declaration: TokenStream, item: &Item) -> Result<Model, WrongDeclaration> {
    let errors = Errors::new();
    let text = layout::text(&declaration);
    let declaration = parse::declaration(declaration, &errors);
    let coordinates = declaration.coordinates.given();
    let model = match item {
        Item::Struct(item) => Fields::read(item, &errors).and_then(|fields| {
            let checked = check(&declaration, &fields, &errors);
            lower::model(&declaration, item, &fields, checked, &errors)
        }),
        other => Err(not_a_struct(other, &errors)),
    };
    match (errors.finish(), model) {
        (Ok(()), Ok(model)) => Ok(Model { text, ..model }),
        (result, _) => {
            let stub = match (name_and_generics(item), coordinates) {
                (Some((ident, generics)), Some(coordinates)) => {
                    let stub = stub::stub(ident, generics, coordinates.names.len());
                    with_core_path(stub, declaration.core.given())
                }
                _ => TokenStream::new(),
            };
            Err(WrongDeclaration {
                errors: result.err().unwrap_or_default(),
                stub,
            })
        }
    }
}

/// Generated code that uses the declared path of `dsocs-core`.
fn with_core_path(code: TokenStream, path: Option<&Path>) -> TokenStream {
    match path {
        Some(path) => core_path::with_path(code, path),
        None => code,
    }
}

/// The name and the generics of a type.
fn name_and_generics(item: &Item) -> Option<(&Ident, &Generics)> {
    match item {
        Item::Struct(item) => Some((&item.ident, &item.generics)),
        Item::Enum(item) => Some((&item.ident, &item.generics)),
        Item::Union(item) => Some((&item.ident, &item.generics)),
        _ => None,
    }
}
