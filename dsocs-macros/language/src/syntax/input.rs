//! The item under the attribute: its name, and its fields as parameters.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{ToTokens, quote, quote_spanned};
use syn::ext::IdentExt;
use syn::{Expr, Field as SynField, Generics, Item, ItemStruct, Lit, Type};

use crate::mistakes::errors::{Errors, Reported};
use crate::syntax::{bare, doc};

/// The fields of the struct.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fields {
    all: Vec<Field>,
    /// Whether the declaration is read without a compiler: then Rust functions and constants cannot be used.
    without_compiler: bool,
}

/// The largest number of elements of an array that are listed as parameters. A longer array is a table of
/// data.
const LISTED: usize = 1000;

/// A field of the struct.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    /// Its name.
    pub(crate) ident: Ident,
    /// The kind of its type.
    pub(crate) kind: Kind,
    /// Whether its type is a reference.
    reference: bool,
    /// The number of elements, if it is an array of literal length.
    pub(crate) length: Option<usize>,
    /// The lengths of an array of `f64`, or of an array of such arrays; empty for other types.
    shape: Vec<usize>,
    /// Its type as text.
    ty: String,
    /// Its documentation in one line.
    doc: String,
}

/// The kind of a field's type, as far as the macro can see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `f64`.
    Number,
    /// A number type whose values `f64` holds exactly.
    Exact,
    /// A primitive type that `f64` does not hold exactly, or that is no number.
    NoNumber,
    /// An array.
    Array,
    /// A type parameter of the struct.
    Generic,
    /// A type that the macro does not know; perhaps another name of `f64`.
    Unknown,
}

impl Fields {
    /// Reads the fields; a struct without names for them is reported.
    pub(crate) fn read(item: &ItemStruct, errors: &Errors) -> Result<Self, Reported> {
        match &item.fields {
            syn::Fields::Named(fields) => {
                let fields = fields
                    .named
                    .iter()
                    .filter_map(|field| Field::read(field, &item.generics));
                Ok(Self {
                    all: fields.collect(),
                    without_compiler: false,
                })
            }
            syn::Fields::Unit => Ok(Self::default()),
            syn::Fields::Unnamed(_) => Err(errors.at(
                &item.ident,
                "expected a struct with named fields: the parameters of a system are called by name",
            )),
        }
    }

    /// These fields, of a declaration that no compiler reads.
    pub(crate) fn without_compiler(self) -> Self {
        Self {
            without_compiler: true,
            ..self
        }
    }

    /// Whether a compiler reads the declaration, so that the user's Rust functions and constants can be used.
    pub(crate) fn have_compiler(&self) -> bool {
        !self.without_compiler
    }

    /// The fields, in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Field> {
        self.all.iter()
    }

    /// The field at an index.
    pub(crate) fn get(&self, index: usize) -> Option<&Field> {
        self.all.get(index)
    }

    /// The names of the elements of arrays, with the spans of their fields.
    pub(crate) fn elements(&self) -> Vec<Ident> {
        let parameters = self.parameters().into_iter();
        parameters
            .filter(|parameter| !parameter.element.is_empty())
            .map(|parameter| Ident::new(&parameter.name, parameter.ident.span()))
            .collect()
    }

    /// The fields that are not numbers, each with its type.
    pub(crate) fn others(&self) -> Vec<(String, String)> {
        let others = self
            .all
            .iter()
            .filter(|field| field.reference || field.parameters().is_empty());
        others
            .map(|field| (field.ident.unraw().to_string(), field.ty.clone()))
            .collect()
    }

    /// The numbers in the fields, which can be listed and set by name.
    pub(crate) fn parameters(&self) -> Vec<ParameterField> {
        self.all
            .iter()
            .filter(|field| !field.reference)
            .flat_map(Field::parameters)
            .collect()
    }
}

impl Field {
    fn read(field: &SynField, generics: &Generics) -> Option<Self> {
        let (ty, reference) = match ungrouped(&field.ty) {
            Type::Reference(inner) => (ungrouped(&inner.elem), true),
            other => (other, false),
        };
        let name = match ty {
            Type::Path(path) if path.qself.is_none() => path.path.get_ident().map(ToString::to_string),
            _ => None,
        };
        let kind = match name.as_deref() {
            Some("f64") => Kind::Number,
            Some("f32" | "i8" | "i16" | "i32" | "u8" | "u16" | "u32") => Kind::Exact,
            Some(
                "i64" | "i128" | "isize" | "u64" | "u128" | "usize" | "bool" | "char" | "str" | "String",
            ) => Kind::NoNumber,
            Some(name) if generics.type_params().any(|parameter| parameter.ident == name) => Kind::Generic,
            _ if matches!(ty, Type::Array(_)) => Kind::Array,
            _ => Kind::Unknown,
        };
        let length = match ty {
            Type::Array(array) => length(&array.len),
            _ => None,
        };
        let doc = doc(&field.attrs);
        let text = field.ty.to_token_stream().to_string().replace(' ', "");
        field.ident.clone().map(|ident| Self {
            ident,
            kind,
            reference,
            length,
            shape: shape(ty).unwrap_or_default(),
            ty: text,
            doc,
        })
    }

    /// The lengths of an array of numbers, `[3]`, or of a matrix, `[3, 3]`; empty for other types.
    pub(crate) fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Whether it is a table of samples.
    pub(crate) fn is_table(&self) -> bool {
        self.kind == Kind::Unknown && is_of_samples(&self.ty)
    }

    /// Whether its type may be a reference to a number.
    pub(crate) fn may_be_reference(&self) -> bool {
        self.reference || matches!(self.kind, Kind::Unknown | Kind::Generic)
    }

    /// The numbers in the field.
    fn parameters(&self) -> Vec<ParameterField> {
        let name = self.ident.unraw().to_string();
        let parameter = |name: String, element| ParameterField {
            name,
            ident: self.ident.clone(),
            element,
            doc: self.doc.clone(),
        };
        match (self.kind, self.shape.as_slice()) {
            (Kind::Number, _) => vec![parameter(name, Vec::new())],
            (Kind::Array, &[length]) => (0..length.min(LISTED))
                .map(|i| parameter(format!("{name}_{i}"), vec![i]))
                .collect(),
            (Kind::Array, &[rows, columns]) => (0..rows)
                .flat_map(|i| (0..columns).map(move |j| (i, j)))
                .take(LISTED)
                .map(|(i, j)| parameter(format!("{name}_{i}_{j}"), vec![i, j]))
                .collect(),
            _ => Vec::new(),
        }
    }

    /// An element of an array of numbers, with the span of its use.
    pub(crate) fn element(used: &Ident, indices: &[usize]) -> TokenStream {
        let place = field_of_self(used);
        let indices = indices.iter().map(|&index| {
            let mut index = Literal::usize_unsuffixed(index);
            index.set_span(used.span());
            index
        });
        quote_spanned!(used.span()=> #place #([#indices])*)
    }

    /// The field as an `f64`, with the span of its use.
    pub(crate) fn number(&self, used: &Ident, errors: &Errors) -> Result<TokenStream, Reported> {
        let mut place = field_of_self(used);
        if self.reference {
            place = quote_spanned!(used.span()=> *#place);
        }
        match self.kind {
            Kind::Number | Kind::Unknown => Ok(place),
            Kind::Exact => Ok(quote_spanned!(used.span()=> ::core::primitive::f64::from(#place))),
            Kind::NoNumber => Err(errors.at(
                used,
                format!(
                    "expected a number, but the field `{used}` is of type `{}`; types that count as numbers: \
                     f64, f32, i8, i16, i32, u8, u16, u32",
                    self.ty
                ),
            )),
            Kind::Array => Err(errors.at(
                used,
                format!(
                    "expected a number, but the field `{used}` is an array; expected an element, `{used}[0]`"
                ),
            )),
            Kind::Generic => Err(errors.at(
                used,
                format!(
                    "expected a number, but the field `{used}` is of the generic type `{}`; \
                     expected a call of one of its methods, such as `{used}.at(…)`",
                    self.ty
                ),
            )),
        }
    }
}

/// A field as a place, `self.name`, with the span of its use.
pub(crate) fn field_of_self(used: &Ident) -> TokenStream {
    // hygiene of the method's own `self`, location of the user's name
    let receiver = Ident::new("self", Span::call_site().located_at(used.span()));
    quote_spanned!(used.span()=> #receiver.#used)
}

/// A type without parentheses and without the group that a macro by example puts around a `$t:ty`.
fn ungrouped(mut ty: &Type) -> &Type {
    loop {
        ty = match ty {
            Type::Group(group) => &group.elem,
            Type::Paren(paren) => &paren.elem,
            _ => return ty,
        };
    }
}

/// The lengths of an array of numbers, or of an array of such arrays, if they are literals.
fn shape(ty: &Type) -> Option<Vec<usize>> {
    match ungrouped(ty) {
        Type::Array(array) => {
            let mut lengths = vec![length(&array.len)?];
            match ungrouped(&array.elem) {
                Type::Path(path) if path.path.is_ident("f64") => Some(lengths),
                inner @ Type::Array(_) => {
                    lengths.extend(shape(inner)?);
                    Some(lengths).filter(|lengths| lengths.len() <= 2)
                }
                _ => None,
            }
        }
        _ => None,
    }
}

/// The length of an array, if it is a literal.
fn length(expr: &Expr) -> Option<usize> {
    match bare(expr) {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(digits) => digits.base10_parse().ok(),
            _ => None,
        },
        _ => None,
    }
}

/// Reports that the item is not a struct, at its keyword.
pub(crate) fn not_a_struct(item: &Item, errors: &Errors) -> Reported {
    const EXPECTED: &str = "expected a struct, whose fields are the parameters of the system";
    match item {
        Item::Enum(item) => errors.at(item.enum_token, EXPECTED),
        Item::Union(item) => errors.at(item.union_token, EXPECTED),
        Item::Fn(item) => errors.at(item.sig.fn_token, EXPECTED),
        Item::Impl(item) => errors.at(item.impl_token, EXPECTED),
        Item::Mod(item) => errors.at(item.mod_token, EXPECTED),
        Item::Trait(item) => errors.at(item.trait_token, EXPECTED),
        Item::Type(item) => errors.at(item.type_token, EXPECTED),
        other => errors.at(other, EXPECTED),
    }
}

/// Whether a type, as written, is a table of samples.
pub(crate) fn is_of_samples(ty: &str) -> bool {
    ty.rsplit("::").next().map(str::trim) == Some("Samples")
}

/// A parameter that can be listed and set by name: a field of type `f64`, or an element of an array or matrix
/// of them.
#[derive(Clone, Debug)]
pub(crate) struct ParameterField {
    /// Its name: `mass`, `masses_2`, `inertia_0_1`.
    pub(crate) name: String,
    /// The field.
    pub(crate) ident: Ident,
    /// The indices of the element in the field: one for an array, two for a matrix, none for a number.
    pub(crate) element: Vec<usize>,
    /// Its documentation in one line.
    pub(crate) doc: String,
}

impl ParameterField {
    /// The place in the struct: `mass`, `masses[2]`, `inertia[0][1]`.
    pub(crate) fn place(&self) -> TokenStream {
        let ident = &self.ident;
        let element = self.element.iter().map(|&place| Literal::usize_unsuffixed(place));
        quote!(#ident #([#element])*)
    }

    /// The expression that reads it: `self.mass`, `self.masses[2]`.
    pub(crate) fn read(&self) -> TokenStream {
        let place = self.place();
        quote!(self.#place)
    }
}
