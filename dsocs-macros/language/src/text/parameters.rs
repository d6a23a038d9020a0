//! `parameters { … }`: the parameters with their values, which a run may override.

use proc_macro2::{Group, Ident, Literal, TokenStream};
use quote::{ToTokens, quote};
use syn::{Attribute, Expr, ExprCall, Lit, LitStr};

use super::items::{self, Item};
use crate::mistakes::Place;
use crate::mistakes::errors::{Errors, Reported};
use crate::syntax::{bare, doc, plain_name};

/// The interpolation of a table of samples, as explained at `dsocs_core::Samples`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Curve {
    /// A cubic spline, twice continuously differentiable. The default.
    #[default]
    Cubic,
    /// Straight lines.
    Linear,
    /// Cubic polynomials that do not overshoot.
    Monotone,
}

impl Curve {
    /// Its name in a text.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cubic => "cubic",
            Self::Linear => "linear",
            Self::Monotone => "monotone",
        }
    }
}

/// A table of samples among the parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// The name of the parameter.
    pub name: String,
    /// The file, as the text names it.
    pub file: String,
    /// The interpolation.
    pub curve: Curve,
    /// Its documentation in one line.
    pub doc: String,
    /// The place of the file's name in the text.
    pub place: Place,
}

/// A parameter.
pub(super) struct Parameter {
    /// Its documentation.
    attributes: Vec<Attribute>,
    /// Its name.
    pub(super) name: Ident,
    /// The value.
    pub(super) value: Value,
}

/// The value of a parameter, as written.
pub(super) enum Value {
    /// A number.
    Number(Box<Expr>),
    /// An array of numbers.
    Array(Vec<Expr>),
    /// A matrix of numbers: its rows, of the same length.
    Matrix(Vec<Vec<Expr>>),
    /// Samples in a file.
    Table(String, Curve, Place),
    /// A value with a mistake, which was reported.
    Malformed(Reported),
}

impl Parameter {
    /// The field of the struct for this parameter.
    pub(super) fn field(&self) -> TokenStream {
        let (attributes, name) = (&self.attributes, &self.name);
        let ty = match &self.value {
            Value::Array(values) => {
                let length = Literal::usize_unsuffixed(values.len());
                quote!([f64; #length])
            }
            Value::Matrix(rows) => {
                let columns = Literal::usize_unsuffixed(rows.first().map_or(0, Vec::len));
                let rows = Literal::usize_unsuffixed(rows.len());
                quote!([[f64; #columns]; #rows])
            }
            Value::Table(..) => quote!(::dsocs_core::Samples),
            Value::Number(_) | Value::Malformed(_) => quote!(f64),
        };
        quote!(#(#attributes)* pub #name: #ty)
    }

    /// The table of samples, if the parameter is one.
    pub(super) fn table(&self) -> Option<Table> {
        match &self.value {
            Value::Table(file, curve, place) => Some(Table {
                name: self.name.to_string(),
                file: file.clone(),
                curve: *curve,
                doc: doc(&self.attributes),
                place: *place,
            }),
            _ => None,
        }
    }
}

/// Reads the parameters.
pub(super) fn read(group: Option<Group>, errors: &Errors) -> Vec<Parameter> {
    let items = group.map(|group| items::read(&group, [',', ';'], errors));
    let items = items.unwrap_or_default().into_iter();
    items
        .map(|item| {
            for attribute in &item.attributes {
                if !attribute.path().is_ident("doc") {
                    errors.at(
                        attribute,
                        "attributes other than documentation have no meaning here",
                    );
                }
            }
            Parameter {
                value: value(&item, errors).unwrap_or_else(Value::Malformed),
                attributes: item.attributes,
                name: item.name,
            }
        })
        .collect()
}

/// The most elements of an array.
const MOST: usize = 1000;

/// The value of an entry.
fn value(item: &Item, errors: &Errors) -> Result<Value, Reported> {
    let (name, length) = (&item.name, item.length.as_ref());
    let value = item.value.as_ref().map_err(|reported| *reported)?;
    let length = length.map(|length| length.as_ref().map_err(|reported| *reported));
    let declared = length.map(|length| count(length?, errors)).transpose()?;
    let found = match bare(value) {
        Expr::Array(_) | Expr::Repeat(_) => array(value, errors)?,
        Expr::Call(call) if plain_name(&call.func).is_some_and(|name| name == "samples") => {
            let (file, curve, place) = samples(call, errors)?;
            Value::Table(file, curve, place)
        }
        _ => Value::Number(Box::new(value.clone())),
    };
    match (&found, declared) {
        (Value::Matrix(_), Some(_)) => Err(errors.at(
            value,
            format!("this is a matrix, whose rows tell its size: expected `{name} = [[…], […]]`, without `: […]`"),
        )),
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

/// The numbers of an array, `[1.0, 2.0]` or `[1.0; 3]`, or of a matrix, an array of its rows.
fn array(value: &Expr, errors: &Errors) -> Result<Value, Reported> {
    let rows = elements(value, errors)?;
    if !rows.iter().any(is_array) {
        return Ok(Value::Array(rows));
    }
    let rows: Vec<_> = rows.iter().map(|row| elements(row, errors)).collect();
    let rows: Vec<Vec<Expr>> = rows.into_iter().collect::<Result<_, _>>()?;
    let columns = rows.first().map_or(0, Vec::len);
    if columns == 0 || rows.iter().any(|row| row.len() != columns) || rows.iter().flatten().any(is_array) {
        let message =
            "expected the rows of a matrix, `[[1.0, 0.0], [0.0, 2.0]]`, with as many numbers in each";
        return Err(errors.at(value, message));
    }
    if rows.len() * columns > MOST {
        let message = format!("a matrix of parameters has at most {MOST} elements");
        return Err(errors.at(value, message));
    }
    Ok(Value::Matrix(rows))
}

fn is_array(expr: &Expr) -> bool {
    matches!(bare(expr), Expr::Array(_) | Expr::Repeat(_))
}

/// The elements of an array.
fn elements(value: &Expr, errors: &Errors) -> Result<Vec<Expr>, Reported> {
    match bare(value) {
        Expr::Array(array) => Ok(array.elems.iter().cloned().collect()),
        Expr::Repeat(repeat) => {
            let count = count(&repeat.len, errors)?;
            Ok(vec![(*repeat.expr).clone(); count])
        }
        other => Err(errors.at(other, "expected a row of the matrix in brackets, `[1.0, 0.0]`")),
    }
}

/// A number of elements.
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
fn samples(call: &ExprCall, errors: &Errors) -> Result<(String, Curve, Place), Reported> {
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
        None => Curve::default(),
        Some(name) => {
            let all = [Curve::Cubic, Curve::Linear, Curve::Monotone];
            let named = all.into_iter().find(|curve| curve.name() == name);
            named.ok_or_else(expected)?
        }
    };
    Ok((LitStr::value(file), curve, Place::of(file.span())))
}
