//! `coordinates(x, y, theta: [3], r: rotation);`

use proc_macro2::Ident;
use quote::{ToTokens, format_ident};
use syn::ext::IdentExt;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Attribute, Expr, Lit, Token, parenthesized, token};

use super::only_documentation;
use crate::mistakes::errors::{Errors, Reported};
use crate::syntax::ast::{Coordinates, Group};
use crate::syntax::{bare, doc, plain_name};

/// The most coordinates of a system: its code grows at least with the square of their number.
const MOST: usize = 1000;

/// `x`, `theta: [3]` or `r: rotation`, with its documentation.
pub(super) struct Argument {
    attributes: Vec<Attribute>,
    name: Expr,
    length: Option<Expr>,
}

impl Parse for Argument {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let attributes = Attribute::parse_outer(input)?;
        let name = input.parse()?;
        let colon: Option<Token![:]> = input.parse()?;
        let length = colon.map(|_| input.parse()).transpose()?;
        Ok(Self {
            attributes,
            name,
            length,
        })
    }
}

/// The statement, if it is one of this kind.
pub(super) fn parse(input: ParseStream) -> syn::Result<Option<(Ident, Vec<Argument>)>> {
    let ahead = input.fork();
    if !matches!(ahead.call(Ident::parse_any), Ok(word) if word == "coordinates") || !ahead.peek(token::Paren)
    {
        return Ok(None);
    }
    let keyword = input.call(Ident::parse_any)?;
    let list;
    parenthesized!(list in input);
    let arguments = Punctuated::<Argument, Token![,]>::parse_terminated(&list)?;
    input.parse::<Token![;]>()?;
    Ok(Some((keyword, arguments.into_iter().collect())))
}

/// Checks the arguments and counts the coordinates.
pub(super) fn read(
    keyword: &Ident,
    arguments: Vec<Argument>,
    lets_before: usize,
    errors: &Errors,
) -> Result<Coordinates, Reported> {
    let mut coordinates = Coordinates {
        groups: Vec::new(),
        names: Vec::new(),
        lets_before,
    };
    let mut wrong = None;
    for argument in arguments {
        only_documentation(&argument.attributes, errors);
        let name = name(&argument.name, errors);
        let is_rotation = argument.length.as_ref().and_then(plain_name);
        let is_rotation = is_rotation.is_some_and(|word| word == "rotation");
        let brackets = argument.length.filter(|_| !is_rotation);
        let length = brackets.map(|brackets| match (&name, like_a_rotation(&brackets)) {
            (Ok(name), Some(LikeRotation::One)) => {
                Err(errors.at(&brackets, format!("expected `{name}: rotation`, for a body that turns in space")))
            }
            (Ok(name), Some(LikeRotation::Several)) => {
                let message = format!(
                    "rotations have no arrays, so far; expected each by its own name, `{name}0: rotation, {name}1: rotation`"
                );
                Err(errors.at(&brackets, message))
            }
            _ => length(&brackets, errors),
        });
        let length = length.transpose();
        match (name, length) {
            (Ok(name), Ok(length)) => {
                coordinates.add(name, (length, is_rotation), doc(&argument.attributes));
            }
            (Err(reported), _) | (_, Err(reported)) => wrong = Some(reported),
        }
        if coordinates.names.len() > MOST {
            wrong = Some(errors.at(keyword, format!("expected at most {MOST} coordinates")));
            break;
        }
    }
    match wrong {
        Some(reported) => Err(reported),
        None if coordinates.names.is_empty() => {
            Err(errors.at(keyword, "expected at least one coordinate, `coordinates(x, y);`"))
        }
        None => Ok(coordinates),
    }
}

impl Coordinates {
    fn add(&mut self, name: Ident, (length, is_rotation): (Option<usize>, bool), doc: String) {
        let first = self.names.len();
        match length {
            None if is_rotation => {
                let names =
                    ["w", "x", "y", "z"].map(|end| format_ident!("{}_{}", name, end, span = name.span()));
                self.names.extend(names);
            }
            None => self.names.push(name.clone()),
            Some(length) => {
                let names = (0..length).map(|i| format_ident!("{}_{}", name, i, span = name.span()));
                self.names.extend(names);
            }
        }
        self.groups.push(Group {
            name,
            first,
            length,
            is_rotation,
            doc,
        });
    }
}

fn name(expr: &Expr, errors: &Errors) -> Result<Ident, Reported> {
    if let Some(name) = plain_name(expr) {
        return Ok(name.clone());
    }
    if let Expr::Index(index) = expr
        && let Some(name) = plain_name(&index.expr)
    {
        let length = index.index.to_token_stream();
        return Err(errors.at(
            expr,
            format!("expected an array of coordinates as `{name}: [{length}]`"),
        ));
    }
    Err(errors.at(expr, "expected the name of a coordinate"))
}

/// An expression that resembles `rotation`: one, or an array of them.
enum LikeRotation {
    One,
    Several,
}

/// The rotations that an expression resembles: `Rotation`, `quaternion`, `[rotation; 2]`.
fn like_a_rotation(expr: &Expr) -> Option<LikeRotation> {
    let is_one = |expr: &Expr| {
        plain_name(bare(expr)).is_some_and(|word| {
            let word = word.to_string().to_lowercase();
            word.contains("rotation")
                || ["quaternion", "attitude", "orientation", "so3"].contains(&word.as_str())
        })
    };
    match bare(expr) {
        Expr::Repeat(repeat) if is_one(&repeat.expr) => Some(LikeRotation::Several),
        Expr::Array(array) if array.elems.first().is_some_and(is_one) => Some(LikeRotation::Several),
        expr if is_one(expr) => Some(LikeRotation::One),
        _ => None,
    }
}

/// The length in brackets, `[3]`.
fn length(brackets: &Expr, errors: &Errors) -> Result<usize, Reported> {
    const EXPECTED: &str = "expected the number of coordinates in brackets, as in `theta: [8]`";
    let number = match bare(brackets) {
        Expr::Array(array) if array.elems.len() == 1 => &array.elems[0],
        Expr::Repeat(repeat) => {
            let length = repeat.len.to_token_stream();
            return Err(errors.at(
                brackets,
                format!(
                    "expected the number of coordinates alone, `[{length}]`: each is a number{}",
                    errors.words(" of type `f64`", "")
                ),
            ));
        }
        _ => return Err(errors.at(brackets, EXPECTED)),
    };
    match bare(number) {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(digits) if matches!(digits.suffix(), "" | "usize") => {
                match digits.base10_parse::<usize>() {
                    Ok(0) => Err(errors.at(number, "expected at least one coordinate in an array")),
                    Ok(length) if length <= MOST => Ok(length),
                    _ => Err(errors.at(number, format!("expected at most {MOST} coordinates"))),
                }
            }
            _ => Err(errors.at(number, EXPECTED)),
        },
        _ => Err(errors.at(
            number,
            errors.words(
                "expected a literal number, as in `theta: [8]`: the code for the system is written for one number of \
                 coordinates, before the values of constants are known",
                "expected a whole number, as in `theta: [8]`, or a constant, `const n = 8;`",
            ),
        )),
    }
}
