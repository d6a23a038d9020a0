//! The front end without a compiler: a struct with its attribute → its model, or its mistakes.

use proc_macro2::{LexError, Span, TokenStream};
use syn::{Attribute, Item, Meta};

use crate::expand;
use crate::mistakes::Mistake;
use crate::model::Model;

/// The input of [`analyze`]: a struct with the attribute `#[dsocs { … }]`.
#[derive(Clone, Debug)]
pub enum Source<'s> {
    /// As text.
    Text(&'s str),
    /// As tokens.
    Tokens(TokenStream),
}

impl<'s> From<&'s str> for Source<'s> {
    fn from(text: &'s str) -> Self {
        Self::Text(text)
    }
}

impl From<TokenStream> for Source<'_> {
    fn from(tokens: TokenStream) -> Self {
        Self::Tokens(tokens)
    }
}

/// The model of a struct with the attribute `#[dsocs { … }]`, or all mistakes in its declaration, in the order of the
/// source.
///
/// The attribute may be written with a path, `#[dsocs_core::dsocs { … }]`; other attributes, and the documentation, belong to
/// the struct.
///
/// ```
/// let model = dsocs_language::analyze(
///     "#[dsocs {
///         coordinates(x);
///         lagrangian = mass / 2 * dot(x).powi(2) - stiffness / 2 * x.powi(2);
///     }]
///     struct Spring { mass: f64, stiffness: f64 }",
/// )
/// .map_err(|mistakes| mistakes[0].clone())?;
/// assert_eq!(model.name(), "Spring");
/// assert_eq!(model.coordinates(), ["x"]);
/// assert_eq!(model.parameters(), ["mass", "stiffness"]);
/// assert!(model.code().to_string().contains("impl"));
/// # Ok::<(), dsocs_language::Mistake>(())
/// ```
///
/// For a wrong declaration every mistake is reported at its place:
///
/// ```
/// let Err(mistakes) = dsocs_language::analyze(
///     "#[dsocs {
///     coordinates(x, y);
///     lagrangian = mass / 2 * (dot(x).powi(2) + dot(z).powi(2));
///     holonomic = x * dot(y);
/// }]
/// struct Particle { mass: f64 }",
/// ) else {
///     panic!("there is no z");
/// };
/// assert_eq!((mistakes[0].line, mistakes[0].column), (3, 51));
/// assert!(mistakes[0].message.contains("`z`"));
/// assert!(mistakes[1].to_string().starts_with("4:21: a velocity or an acceleration comes in here"));
/// ```
///
/// # Errors
///
/// The mistakes, at least one: in the syntax of Rust, in the item, in the declaration.
pub fn analyze<'s>(source: impl Into<Source<'s>>) -> Result<Model, Vec<Mistake>> {
    let nowhere = Span::call_site();
    let tokens = match source.into() {
        Source::Tokens(tokens) => tokens,
        Source::Text(text) => text.parse().map_err(|error: LexError| {
            let message = "expected Rust: a bracket, a quotation mark or a character is out of place here";
            vec![Mistake::at(error.span(), nowhere, message.to_owned())]
        })?,
    };
    let mistakes = |error: &syn::Error, attribute| Mistake::all(error, attribute).collect::<Vec<_>>();
    let mut item: Item = syn::parse2(tokens).map_err(|error| mistakes(&error, nowhere))?;
    let attribute = attributes(&mut item)
        .and_then(|attributes| {
            let place = attributes.iter().position(is_dsocs)?;
            Some(attributes.remove(place))
        })
        .ok_or_else(|| {
            let message = "expected a struct with the attribute `#[dsocs { … }]`";
            mistakes(&syn::Error::new_spanned(&item, message), nowhere)
        })?;
    let place = attribute
        .path()
        .segments
        .last()
        .map_or(nowhere, |last| last.ident.span());
    let declaration = match attribute.meta {
        Meta::List(list) => list.tokens,
        _ => TokenStream::new(),
    };
    expand::model(declaration, &item).map_err(|refused| {
        let errors = refused.errors.iter();
        errors.flat_map(|error| Mistake::all(error, place)).collect()
    })
}

/// The attributes of a type.
fn attributes(item: &mut Item) -> Option<&mut Vec<Attribute>> {
    match item {
        Item::Struct(item) => Some(&mut item.attrs),
        Item::Enum(item) => Some(&mut item.attrs),
        Item::Union(item) => Some(&mut item.attrs),
        _ => None,
    }
}

/// Whether an attribute is `dsocs`, under any path.
fn is_dsocs(attribute: &Attribute) -> bool {
    let name = attribute.path().segments.last();
    name.is_some_and(|name| name.ident == "dsocs")
}
