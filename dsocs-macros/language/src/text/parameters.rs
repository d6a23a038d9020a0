//! `parameters { … }`: names, with the values that they have unless a run sets them.

use proc_macro2::{Group, Ident, Literal, TokenStream};
use quote::{ToTokens, quote};
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Attribute, Expr, ExprCall, Lit, LitStr, Token, bracketed};

use crate::errors::{Errors, Reported};
use crate::syntax::{bare, plain_name};

/// How a table of samples is interpolated; `dsocs_core::Samples` says more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Curve {
    /// A cubic spline, twice continuously differentiable.
    Cubic,
    /// Straight lines.
    Linear,
    /// Cubic polynomials that do not overshoot.
    Monotone,
}

/// A table of samples among the parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// The name of the parameter.
    pub name: String,
    /// The file, as the text names it.
    pub file: String,
    /// How it is interpolated.
    pub curve: Curve,
}

/// A parameter.
pub(super) struct Parameter {
    /// Its documentation.
    attributes: Vec<Attribute>,
    /// Its name.
    pub(super) name: Ident,
    /// What it is.
    pub(super) value: Value,
}

/// What a parameter is.
pub(super) enum Value {
    /// A number.
    Number(Box<Expr>),
    /// An array of numbers: each one, or one for all.
    Array(Vec<Expr>),
    /// Samples in a file.
    Table(String, Curve),
    /// Nothing, since it is wrong.
    Broken(Reported),
}

impl Parameter {
    /// The field of the struct.
    pub(super) fn field(&self) -> TokenStream {
        let (attributes, name) = (&self.attributes, &self.name);
        let ty = match &self.value {
            Value::Array(values) => {
                let length = Literal::usize_unsuffixed(values.len());
                quote!([f64; #length])
            }
            Value::Table(..) => quote!(::dsocs_core::Samples),
            Value::Number(_) | Value::Broken(_) => quote!(f64),
        };
        quote!(#(#attributes)* pub #name: #ty)
    }

    /// The table of samples that it is.
    pub(super) fn table(&self) -> Option<Table> {
        match &self.value {
            Value::Table(file, curve) => Some(Table {
                name: self.name.to_string(),
                file: file.clone(),
                curve: *curve,
            }),
            _ => None,
        }
    }
}

/// One parameter as it is written: its documentation, its name, its length, its value.
struct Written(Vec<Attribute>, Ident, Option<Expr>, Expr);

impl Parse for Written {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let attributes = Attribute::parse_outer(input)?;
        let name: Ident = input.parse()?;
        let length = if input.peek(Token![:]) {
            input.parse::<Token![:]>()?;
            let inner;
            bracketed!(inner in input);
            Some(inner.parse()?)
        } else {
            None
        };
        input.parse::<Token![=]>()?;
        Ok(Self(attributes, name, length, input.parse()?))
    }
}

/// Reads the parameters.
pub(super) fn read(group: Option<Group>, errors: &Errors) -> Vec<Parameter> {
    let Some(group) = group else { return Vec::new() };
    if let Some(deep) = crate::parse::too_deep(&group.stream(), crate::parse::DEEPEST) {
        errors.at(deep, "expected values that are nested less deep");
        return Vec::new();
    }
    let parser = Punctuated::<Written, Token![,]>::parse_terminated;
    let written = match syn::parse::Parser::parse2(parser, group.stream()) {
        Ok(written) => written,
        Err(error) => {
            let message = "expected `name = value`, with a comma between parameters";
            let error = syn::Error::new(error.span(), format!("{message} ({error})"));
            errors.push(error);
            return Vec::new();
        }
    };
    let parameters = written.into_iter();
    parameters
        .map(|Written(attributes, name, length, value)| {
            for attribute in &attributes {
                if !attribute.path().is_ident("doc") {
                    errors.at(
                        attribute,
                        "attributes other than documentation have no meaning here",
                    );
                }
            }
            Parameter {
                attributes,
                value: self::value(&name, length.as_ref(), &value, errors).unwrap_or_else(Value::Broken),
                name,
            }
        })
        .collect()
}

/// The most elements of an array.
const MOST: usize = 1000;

/// What a parameter is.
fn value(name: &Ident, length: Option<&Expr>, value: &Expr, errors: &Errors) -> Result<Value, Reported> {
    let declared = length.map(|length| count(length, errors)).transpose()?;
    let found = match bare(value) {
        Expr::Array(array) => Value::Array(array.elems.iter().cloned().collect()),
        Expr::Repeat(repeat) => {
            let count = count(&repeat.len, errors)?;
            Value::Array(vec![(*repeat.expr).clone(); count])
        }
        Expr::Call(call) if plain_name(&call.func).is_some_and(|name| name == "samples") => {
            let (file, curve) = samples(call, errors)?;
            Value::Table(file, curve)
        }
        _ => Value::Number(Box::new(value.clone())),
    };
    match (&found, declared) {
        (Value::Array(values), Some(declared)) if values.len() != declared => Err(errors.at(
            value,
            format!(
                "expected {declared} values of `{name}`, as it is declared, found {}",
                values.len()
            ),
        )),
        (Value::Number(_) | Value::Table(..), Some(declared)) => Err(errors.at(
            value,
            format!("expected an array of {declared} values, such as `[1.0; {declared}]`"),
        )),
        (Value::Array(values), None) if values.len() > MOST => Err(errors.at(
            value,
            format!(
                "an array of parameters has at most {MOST} elements, found {}; a table of data belongs into a file, `samples(\"data.csv\")`",
                values.len()
            ),
        )),
        _ => Ok(found),
    }
}

/// A length.
fn count(expr: &Expr, errors: &Errors) -> Result<usize, Reported> {
    let count = match bare(expr) {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(number) => number.base10_parse().ok(),
            _ => None,
        },
        _ => None,
    };
    match count {
        Some(count) if count <= MOST => Ok(count),
        Some(_) => Err(errors.at(expr, format!("expected at most {MOST} elements"))),
        None => Err(errors.at(expr, "expected a whole number, or a constant, `const n = 3;`")),
    }
}

/// The file and the curve of `samples("file", monotone)`.
fn samples(call: &ExprCall, errors: &Errors) -> Result<(String, Curve), Reported> {
    let expected = || {
        let message = "expected the name of a file and, if you like, how it is interpolated: `samples(\"wind.csv\")`, `samples(\"wind.csv\", linear)` \
                       or `samples(\"wind.csv\", monotone)`";
        errors.at(call.to_token_stream(), message)
    };
    let arguments: Vec<&Expr> = call.args.iter().map(bare).collect();
    let (file, curve) = match arguments.as_slice() {
        [file] => (file, None),
        [file, curve] => (file, Some(plain_name(curve).ok_or_else(expected)?.to_string())),
        _ => return Err(expected()),
    };
    let Expr::Lit(literal) = file else {
        return Err(expected());
    };
    let Lit::Str(file) = &literal.lit else {
        return Err(expected());
    };
    let curve = match curve.as_deref() {
        None | Some("cubic") => Curve::Cubic,
        Some("linear") => Curve::Linear,
        Some("monotone") => Curve::Monotone,
        Some(_) => return Err(expected()),
    };
    Ok((LitStr::value(file), curve))
}
