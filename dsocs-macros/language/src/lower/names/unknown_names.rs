//! Error messages for names and expressions without a meaning.

use proc_macro2::{Ident, Span};
use quote::{ToTokens, quote};
use syn::{Expr, Lit, UnOp};

use crate::lower::lowering::Lowering;
use crate::lower::names::Binding;
use crate::lower::names::foreign_names::constant;
use crate::lower::names::look_alike;
use crate::mistakes::errors::{Errors, Reported};
use crate::mistakes::nearest::nearest;
use crate::syntax::input::Field;
use crate::syntax::{bare, plain_name};

/// Endings of names of derivatives in other languages, and their meaning; longer ones first, since `x_ddot`
/// also ends in `dot`.
const SUFFIXES: [(&str, &str); 8] = [
    ("_dddot", "dddot"),
    ("dddot", "dddot"),
    ("_ddot", "ddot"),
    ("ddot", "ddot"),
    ("_dot", "dot"),
    ("dot", "dot"),
    ("dt", "dot"),
    ("_prime", "dot"),
];

/// Beginnings of such names.
const PREFIXES: [(&str, &str); 9] = [
    ("dddot_", "dddot"),
    ("dddot", "dddot"),
    ("ddot_", "ddot"),
    ("ddot", "ddot"),
    ("dd", "ddot"),
    ("dot_", "dot"),
    ("dot", "dot"),
    ("v_", "dot"),
    ("d", "dot"),
];

impl Lowering<'_> {
    /// The error for an equation in place of an expression that vanishes: `x - y = 0`.
    pub(crate) fn equation(&self, equals: impl ToTokens, right: &Expr) -> Reported {
        let message = if is_zero(right) {
            "expected the expression that is zero, alone: leave this out"
        } else {
            "expected the expression that is zero, alone: `a = b` is written `a - b`"
        };
        self.errors.at(quote!(#equals #right), message)
    }

    /// The error for `x ** 2`, which Rust reads as `x * (*2)`.
    pub(crate) fn power(&self, star: impl ToTokens, right: &Expr) -> Option<Reported> {
        let Expr::Unary(unary) = right else {
            return None;
        };
        let UnOp::Deref(second) = unary.op else {
            return None;
        };
        let reference = match plain_name(&unary.expr).map(|name| self.scope.get(name)) {
            Some(Some(Binding::Field(index))) => self.fields.get(*index).is_none_or(Field::may_be_reference),
            Some(_) => false,
            None => !matches!(&*unary.expr, Expr::Lit(_)) && self.is_closed(&unary.expr),
        };
        if reference {
            return None;
        }
        let exponent = unary.expr.to_token_stream();
        let power = match self.integer(&unary.expr) {
            Some(_) => "powi",
            None => "powf",
        };
        let message = format!(
            "`**` is no power {}; expected `.{power}({exponent})`",
            self.where_it_is_so()
        );
        Some(self.errors.at(quote!(#star #second), message))
    }

    /// Reports a name that the declaration does not know and that does not look like a constant.
    pub(crate) fn check_free_name(&self, name: &Ident) -> Result<(), Reported> {
        let text = name.to_string();
        let message = match text.as_str() {
            "h" => "the step `h` is known in the maps and in discrete expressions only: a system is continuous until they discretize it"
                .to_owned(),
            "dot" | "ddot" | "dddot" => format!("expected an argument, `{text}(…)`"),
            "sum" | "product" => {
                let what = self.errors.words("a closure", "what stands for each index");
                format!("expected a range and {what}, `{text}(0..8, |i| …)`")
            }
            "nan" | "NaN" | "NAN" | "inf" | "Inf" | "INF" | "infinity" | "Infinity" | "oo" if self.errors.are_of_text() => {
                format!("`{text}` is no number that can be calculated with; expected a finite number")
            }
            "time" if self.component.is_none() => "no name `time` is known here; time is called `t`".to_owned(),
            _ if constant(&text).is_some() => {
                format!("no name `{text}` is known here; did you mean `{}`?", constant(&text).unwrap_or_default())
            }
            "self" => "expected the parameter by its name alone, without `self`".to_owned(),
            _ if self.fields.have_compiler() && text.starts_with(|first: char| first.is_uppercase()) => return Ok(()),
            _ if self.let_names.contains(&text) => {
                format!("`{text}` is defined further down; expected its `let` before this use")
            }
            _ => {
                if let Some(message) = self.column_of_rotation(&text) {
                    return Err(self.errors.at(name, message));
                }
                if let Some(meant) = self.derivative_meant(&text) {
                    let message = format!("no name `{text}` is known here; did you mean `{meant}`?");
                    return Err(self.errors.at(name, message));
                }
                let known = || {
                    let is_meant = |binding: &Binding| self.component.is_none() || !is_of_motion(binding);
                    self.scope.names(is_meant)
                };
                let same = known().find(|known| look_alike::folded(known) == look_alike::folded(&text));
                if let Some(same) = same {
                    let message = look_alike::message(&text, same);
                    return Err(self.errors.at(name, message));
                }
                match nearest(&text, known()) {
                    Some(near) => format!("no name `{text}` is known here; did you mean `{near}`?"),
                    None => format!(
                        "no name `{text}` is known here; expected {}",
                        self.kinds_of_names()
                    ),
                }
            }
        };
        Err(self.errors.at(name, message))
    }

    /// The error for an expression that needs a compiler, in a text.
    pub(crate) fn needs_compiler(&self, tokens: impl ToTokens) -> Reported {
        let message = "this is beyond the language of such texts; expected numbers, parameters, `let`s and the functions of the language: a function \
                       of your own is written `let f = |x| …;`, and data are given as samples";
        self.errors.at(tokens, message)
    }

    /// The derivative that a name like `x_dot`, `xdot`, `dx` or `x_ddot` means in other languages.
    fn derivative_meant(&self, text: &str) -> Option<String> {
        if self.component.is_some() || self.discrete.is_some() {
            return None;
        }
        if let Some((base, word)) = look_alike::dotted(text)
            && is_name(&base)
        {
            let name = Ident::new(&base, Span::call_site());
            if self.scope.get(&name).is_some() {
                return Some(format!("{word}({base})"));
            }
        }
        let of = |base: &str, word: &str| {
            let name = Ident::new(base, Span::call_site());
            match self.scope.get(&name)? {
                Binding::Coordinate(_) | Binding::Array(_) | Binding::Let(Ok(_)) => {
                    Some(format!("{word}({base})"))
                }
                _ => None,
            }
        };
        let base = |base: &str, word: &str| {
            // the forms `dx_dt` and `dxdt`
            let base = base.strip_suffix('_').unwrap_or(base);
            let inner = base.strip_prefix('d').filter(|_| text.ends_with("dt"));
            let inner = inner
                .filter(|inner| is_name(inner))
                .and_then(|inner| of(inner, word));
            inner.or_else(|| {
                Some(base)
                    .filter(|base| is_name(base))
                    .and_then(|base| of(base, word))
            })
        };
        let ends = SUFFIXES
            .iter()
            .filter_map(|&(end, word)| Some((text.strip_suffix(end)?, word)));
        let begins = PREFIXES
            .iter()
            .filter_map(|&(begin, word)| Some((text.strip_prefix(begin)?, word)));
        ends.chain(begins).find_map(|(rest, word)| base(rest, word))
    }

    fn kinds_of_names(&self) -> &'static str {
        match (self.component.is_some(), self.fields.have_compiler()) {
            (true, true) => "a node, a field of the struct or `h`",
            (true, false) => "a node, a parameter or `h`",
            (false, true) => "a coordinate, a field of the struct or an earlier `let`",
            (false, false) => "a coordinate, a parameter or an earlier `let`",
        }
    }

    /// `in Rust` or, in a text, `here`, for messages.
    pub(crate) fn where_it_is_so(&self) -> &'static str {
        if self.fields.have_compiler() {
            "in Rust"
        } else {
            "here"
        }
    }
}

/// Whether an expression is the literal 0.
pub(crate) fn is_zero(expr: &Expr) -> bool {
    let digits = match bare(expr) {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(number) => number.base10_parse().ok(),
            Lit::Float(number) => number.base10_parse().ok(),
            _ => None,
        },
        _ => None,
    };
    digits == Some(0.0)
}

/// Whether a string is a valid name.
fn is_name(text: &str) -> bool {
    syn::parse_str::<Ident>(text).is_ok()
}

/// Whether a map may not use a name.
fn is_of_motion(binding: &Binding) -> bool {
    match binding {
        Binding::Coordinate(_) | Binding::Array(_) | Binding::Let(_) => true,
        Binding::Function(function) => !function.of_nodes,
        _ => false,
    }
}

/// The error for an expression that is never a number.
pub(crate) fn not_a_number(expr: &Expr, errors: &Errors) -> &'static str {
    match expr {
        Expr::Tuple(_) if errors.are_of_text() => {
            "expected a number, found several; a decimal has a point, as in `0.5`"
        }
        Expr::Macro(_) | Expr::Reference(_) if errors.are_of_text() => {
            "this has no meaning here; expected a number"
        }
        Expr::Closure(_) if errors.are_of_text() => {
            "expected a number; a function is written `let f = |i| …;`, to be used as `f(2)`"
        }
        Expr::Tuple(_) => "expected a number, found a tuple",
        Expr::Array(_) | Expr::Repeat(_) => "expected a number, found a list",
        Expr::Closure(_) => {
            "expected a number, found a closure; a function of the declaration is `let f = |i| …;`, to be used as `f(2)`"
        }
        Expr::Range(_) => "expected a number, found a range, which stands in `sum(0..8, |i| …)`",
        Expr::Macro(_) => "a macro cannot be seen into: expected the expression itself, or a function",
        Expr::Match(_) => "expected a number; a choice is written `if … { … } else { … }`",
        Expr::Reference(_) => "expected a number, without `&`",
        _ => "expected a number",
    }
}
