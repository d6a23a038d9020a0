//! Functions and constants by the names that they have in mathematics, in Python or in C.

use proc_macro2::Ident;
use quote::ToTokens;

use crate::lower::functions::builtin::Builtin;
use crate::lower::lowering::Lowering;
use crate::mistakes::errors::{Errors, Reported};

/// Functions of numbers under names of other languages, and the method to use here.
const METHODS: [(&str, &str); 24] = [
    ("pow", "powi(2)` or `.powf(a)"),
    ("power", "powi(2)` or `.powf(a)"),
    ("square", "powi(2)"),
    ("squared", "powi(2)"),
    ("cubed", "powi(3)"),
    ("sign", "signum()"),
    ("sgn", "signum()"),
    ("fabs", "abs()"),
    ("arcsin", "asin()"),
    ("arccos", "acos()"),
    ("arctan", "atan()"),
    ("arctan2", "atan2(x)"),
    ("arcsinh", "asinh()"),
    ("arccosh", "acosh()"),
    ("arctanh", "atanh()"),
    ("arsinh", "asinh()"),
    ("arcosh", "acosh()"),
    ("artanh", "atanh()"),
    ("log_e", "ln()"),
    ("loge", "ln()"),
    ("log1p", "ln_1p()"),
    ("expm1", "exp_m1()"),
    ("maximum", "max(…)"),
    ("minimum", "min(…)"),
];

/// Names of functions as words, and the method to use here. Not used in Rust, where they may well be the
/// user's own.
const WORDS: [(&str, &str); 18] = [
    ("sine", "sin()"),
    ("cosine", "cos()"),
    ("tangent", "tan()"),
    ("tg", "tan()"),
    ("arcsine", "asin()"),
    ("arccosine", "acos()"),
    ("arctangent", "atan()"),
    ("arctg", "atan()"),
    ("sh", "sinh()"),
    ("ch", "cosh()"),
    ("th", "tanh()"),
    ("squareroot", "sqrt()"),
    ("square_root", "sqrt()"),
    ("root", "sqrt()"),
    ("exponential", "exp()"),
    ("logarithm", "ln()"),
    ("absolute", "abs()"),
    ("magnitude", "abs()"),
];

/// The names of [`METHODS`] that may well be the user's own functions.
const OFTEN_OWN: [&str; 3] = ["square", "squared", "cubed"];

/// Methods of vectors under names of other languages, and the method to use here.
const VECTOR_METHODS: [(&str, &str); 15] = [
    ("abs", "norm()"),
    ("length", "norm()"),
    ("len", "norm()"),
    ("mag", "norm()"),
    ("magnitude", "norm()"),
    ("norm2", "norm_squared()"),
    ("squared_norm", "norm_squared()"),
    ("norm_sqr", "norm_squared()"),
    ("length_squared", "norm_squared()"),
    ("powi", "norm_squared()"),
    ("square", "norm_squared()"),
    ("dot", "inner(b)"),
    ("dotproduct", "inner(b)"),
    ("wedge", "cross(b)"),
    ("transposed", "transpose()"),
];

/// The method of vectors for a name of another language.
pub(crate) fn vector_method(name: &str) -> Option<&'static str> {
    let known = VECTOR_METHODS.iter().find(|(known, _)| *known == name);
    known.map(|(_, meant)| *meant)
}

/// Names of the time derivative in other languages.
const DERIVATIVES: [&str; 6] = ["diff", "Diff", "der", "deriv", "derivative", "Derivative"];

/// Modules of functions in other languages.
const MODULES: [&str; 9] = [
    "np", "numpy", "math", "Math", "cmath", "jnp", "sp", "sympy", "torch",
];

/// The method for a function's name, with its parentheses: `sin()`, `max(…)`.
fn method(name: &str, errors: &Errors) -> Option<String> {
    match name {
        // `log` of one number is usually the natural one
        "log" => return Some("ln()` or `.log10()".to_owned()),
        "powi" => return Some("powi(2)".to_owned()),
        _ => {}
    }
    let own =
        Builtin::find(name).map(|builtin| format!("{name}({})", if builtin.is_of_one() { "" } else { "…" }));
    own.or_else(|| method_of_numbers(name, errors).map(ToOwned::to_owned))
}

/// The method of numbers for a name of another language.
fn method_of_numbers(name: &str, errors: &Errors) -> Option<&'static str> {
    let words = WORDS.iter().filter(|_| errors.are_of_text());
    let known = METHODS.iter().chain(words).find(|(known, _)| *known == name);
    known.map(|(_, meant)| *meant)
}

/// The constant for a name of another language.
pub(crate) fn constant(name: &str) -> Option<&'static str> {
    match name {
        "pi" | "Pi" | "π" => Some("pi"),
        "tau" | "Tau" | "τ" => Some("tau"),
        _ => None,
    }
}

/// Whether a name is that of a module of functions in other languages.
pub(crate) fn is_module(name: &Ident) -> bool {
    MODULES.iter().any(|module| name == module)
}

impl Lowering<'_> {
    /// The error for a function in the notation of other languages: `sin(x)`, `sign(x)`, `diff(x, t)`.
    pub(crate) fn foreign_function(
        &self,
        name: &Ident,
        argument: Option<&impl ToTokens>,
    ) -> Option<Reported> {
        let text = name.to_string();
        if DERIVATIVES.contains(&text.as_str()) {
            let argument = argument.map_or_else(|| "x".to_owned(), source_text);
            let message = format!(
                "the time derivative is called `dot`: expected `dot({argument})`, and `ddot({argument})` for the second one{}",
                if self.errors.are_of_text() {
                    String::new()
                } else {
                    hint_for_own_function(&text)
                }
            );
            return Some(self.errors.at(name, message));
        }
        if OFTEN_OWN.contains(&text.as_str()) && !self.errors.are_of_text() {
            return None;
        }
        let meant = method(&text, self.errors)?;
        let place = self.where_it_is_so();
        let message = match Builtin::find(&text) {
            _ if self.errors.are_of_text() => hint_for_method_notation(argument, &meant),
            Some(_) if text != "log" => {
                format!(
                    "functions of numbers are methods {place}: expected `(…).{meant}` or `f64::{text}(…)`"
                )
            }
            _ => format!(
                "functions of numbers are methods {place}: expected `(…).{meant}`{}",
                hint_for_own_function(&text)
            ),
        };
        Some(self.errors.at(name, message))
    }

    /// The error for a function of a module: `np.sin(x)`.
    pub(crate) fn function_of_module(
        &self,
        module: &Ident,
        name: &Ident,
        argument: Option<&impl ToTokens>,
    ) -> Reported {
        let meant = method(&name.to_string(), self.errors).unwrap_or_else(|| format!("{name}()"));
        let message = if self.errors.are_of_text() {
            format!(
                "{}, without `{module}`",
                hint_for_method_notation(argument, &meant)
            )
        } else {
            let place = self.where_it_is_so();
            format!("functions of numbers are methods {place}: expected `(…).{meant}`, without `{module}`")
        };
        self.errors.at(module, message)
    }

    /// The error for a constant of a module: `np.pi`.
    pub(crate) fn constant_of_module(&self, module: &Ident, name: &Ident) -> Reported {
        let text = name.to_string();
        let meant = constant(&text).map_or_else(
            || format!("no name `{module}` is known here; expected the number itself"),
            |meant| format!("expected `{meant}`, without `{module}`"),
        );
        self.errors.at(module, meant)
    }

    /// The error for a method without its parentheses: `x.abs`.
    pub(crate) fn method_without_call(&self, name: &Ident) -> Option<Reported> {
        let meant = method(&name.to_string(), self.errors)?;
        let what = self.errors.words("method is called", "function is written");
        let message = format!("a {what} with parentheses: expected `.{meant}`");
        Some(self.errors.at(name, message))
    }

    /// The error for a method of numbers that has another name here: `x.squared()`.
    pub(crate) fn foreign_method(&self, name: &Ident) -> Option<Reported> {
        let meant = method_of_numbers(&name.to_string(), self.errors)?;
        if self.errors.are_of_text() {
            let message = format!("no function is called `{name}`: expected `.{meant}`");
            return Some(self.errors.at(name, message));
        }
        let message = format!(
            "numbers have no method `{name}`: expected `.{meant}` (a method of your own of this name is called by the path of its trait, \
             `Trait::{name}(…)`)"
        );
        Some(self.errors.at(name, message))
    }
}

/// The hint how to call a user's function whose name means something else.
fn hint_for_own_function(name: &str) -> String {
    format!(" (a function of your own of this name is called by its path, `self::{name}(…)`)")
}

/// The hint to write a function behind its argument, for authors of a text.
fn hint_for_method_notation(argument: Option<&impl ToTokens>, meant: &str) -> String {
    let written = argument.map(source_text).unwrap_or_default();
    let is_short = (1..30).contains(&written.chars().count());
    let is_whole = written
        .chars()
        .all(|c| c.is_alphanumeric() || "_.[]()".contains(c));
    let of = match (is_short, is_whole) {
        (true, true) => written,
        (true, false) => format!("({written})"),
        _ => "(…)".to_owned(),
    };
    format!("a function stands behind what it is of: expected `{of}.{meant}`")
}

/// An expression as the user wrote it, without spaces.
fn source_text(expr: &impl ToTokens) -> String {
    expr.to_token_stream().to_string().replace(' ', "")
}
