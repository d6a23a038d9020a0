//! A system in a text file: a declaration, values of its parameters, and runs.
//!
//! ```text
//! //! A pendulum in the wind.
//! const n = 1;
//! parameters {
//!     /// The length of the rod [m]
//!     length = 1.0,
//!     wind = samples("wind.csv"),
//! }
//! coordinates(theta);
//! lagrangian = dot(theta).powi(2) / 2 + 9.81 / length * theta.cos();
//! external_forces = wind.at(t) * theta.cos();
//! run { start = ([pi / 4], [0.0]); step = 0.01; until = 20.0; }
//! ```
//!
//! Everything but `const`, `parameters` and `run` is the body of the attribute, word for word. The text
//! becomes a struct with that attribute and is read like one.

mod characters;
mod constants;
mod items;
mod parameters;
mod repair;
mod split;
mod unused;
mod values;

use proc_macro2::{Ident, Span, TokenStream};
use quote::quote_spanned;
use syn::ItemStruct;

use crate::check::check;
use crate::mistakes::Mistake;
use crate::mistakes::errors::Errors;
use crate::model::Model;
use crate::syntax::input::Fields;
use crate::syntax::layout;
use crate::{lower, parse};

pub use parameters::{Curve, Table};
pub use values::Run;

/// The most bytes that a text may have.
pub const MOST_BYTES: usize = 1 << 20;

/// The largest number of mistakes that are reported one by one.
const MOST_MISTAKES: usize = 100;

/// The deepest nesting of brackets: those of expressions, which have a limit of their own, inside those of
/// statements.
const DEEPEST: usize = parse::DEEPEST + 20;

/// A system that was read from a text.
#[derive(Clone, Debug)]
pub struct Text {
    /// The declared system.
    pub model: Model,
    /// The values of its parameters, in the order of [`Model::parameters`].
    pub values: Vec<f64>,
    /// Its tables of samples.
    pub tables: Vec<Table>,
    /// The runs that the text asks for.
    pub runs: Vec<Run>,
}

/// Reads a system from a text. `name` is the name of the system, such as that of the file without its ending.
/// `constants` are values that replace those in the text (`const n = 3;`).
///
/// ```
/// let text = dsocs_language::read(
///     "swing",
///     "parameters { length = 2.0 }
///      coordinates(theta);
///      lagrangian = dot(theta).powi(2) / 2 + 9.81 / length * theta.cos();
///      run { start = ([pi / 2], [0]); until = 5.0; }",
///     &[],
/// )
/// .map_err(|mistakes| mistakes[0].clone())?;
/// assert_eq!(text.model.parameters(), ["length"]);
/// assert_eq!(text.values, [2.0]);
/// assert_eq!(text.runs[0].start, Some([vec![std::f64::consts::FRAC_PI_2], vec![0.0]]));
/// # Ok::<(), dsocs_language::Mistake>(())
/// ```
///
/// # Errors
///
/// The mistakes, at least one, in the order of the text; beyond a hundred, only their number is given.
pub fn read(name: &str, text: &str, constants: &[(String, f64)]) -> Result<Text, Vec<Mistake>> {
    if text.len() > MOST_BYTES {
        let message = format!(
            "the text has {} bytes; expected at most {MOST_BYTES}: a table of data belongs into a file of samples",
            text.len()
        );
        return Err(vec![Mistake::of(Span::call_site(), message)]);
    }
    // a byte order mark, which some editors write
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (text, mut mistakes) = characters::read(text);
    let tokens: TokenStream = match text.parse() {
        Ok(tokens) => tokens,
        Err(_) if !mistakes.is_empty() => return Err(mistakes),
        Err(error) => {
            let error: proc_macro2::LexError = error;
            let message = "a bracket, a quotation mark or a character is out of place here";
            return Err(vec![Mistake::of(error.span(), message.to_owned())]);
        }
    };
    if let Some(tree) = parse::too_deep(&tokens, DEEPEST) {
        return Err(vec![Mistake::of(tree.span(), too_deep())]);
    }
    characters::check_literals(&tokens)?;
    if tokens.is_empty() && mistakes.is_empty() {
        let message = "the text declares nothing; expected at least `coordinates(x);` and `lagrangian = dot(x).powi(2) / 2;`";
        return Err(vec![Mistake::of_character(1, 1, message.to_owned())]);
    }
    let errors = Errors::of_text();
    let read = of_tokens(name, tokens, constants, &errors);
    match (errors.finish(), read) {
        (Ok(()), Some(text)) if mistakes.is_empty() => Ok(text),
        (result, _) => {
            let found = result.err().unwrap_or_default();
            let last = end(&text);
            mistakes.extend(found.iter().flat_map(|error| Mistake::in_text(error, last)));
            mistakes.sort_by_key(|mistake| [mistake.line, mistake.column]);
            let more = mistakes.len().saturating_sub(MOST_MISTAKES);
            mistakes.truncate(MOST_MISTAKES);
            if more > 0
                && let Some(last) = mistakes.last()
            {
                let message = format!("below this there are {more} more mistakes, which are not told");
                mistakes.push(Mistake {
                    message,
                    ..last.clone()
                });
            }
            Err(mistakes)
        }
    }
}

/// The line and column after the last word of a text.
fn end(text: &str) -> (usize, usize) {
    let text = text.trim_end();
    let last = text.rsplit('\n').next().unwrap_or_default();
    (text.matches('\n').count() + 1, last.chars().count() + 1)
}

/// The message about brackets that are nested too deep.
fn too_deep() -> String {
    format!(
        "expected brackets and functions that are nested at most {DEEPEST} deep, and at most {} words and signs between two commas or semicolons",
        parse::LONGEST
    )
}

/// The system that tokens declare; `None` if a mistake was reported.
fn of_tokens(name: &str, tokens: TokenStream, constants: &[(String, f64)], errors: &Errors) -> Option<Text> {
    let parts = split::split(repair::repaired(tokens, errors), errors);
    let names = unused::Names::of(&parts);
    let parts = constants::insert(parts, constants, errors);
    let text = layout::text(&parts.declaration);
    let declaration = parse::declaration(parts.declaration, errors);
    let parameters = parameters::read(parts.parameters, errors);
    let item = item(name, &parts.docs, &parameters)?;
    let fields = Fields::read(&item, errors).ok()?.without_compiler();
    let checked = check(&declaration, &fields, errors);
    let model = lower::model(&declaration, &item, &fields, checked, errors);
    let values = values::parameters(&parameters, &fields, errors);
    let mut model = Model { text, ..model.ok()? };
    model.warnings.extend(names.warnings(&parameters));
    let values = values.ok()?;
    let runs = values::runs(parts.runs, &model, &fields, &values, errors);
    Some(Text {
        tables: parameters
            .iter()
            .filter_map(parameters::Parameter::table)
            .collect(),
        model,
        values,
        runs: runs.ok()?,
    })
}

/// The struct that the text declares.
fn item(name: &str, docs: &[String], parameters: &[parameters::Parameter]) -> Option<ItemStruct> {
    let name = Ident::new(&type_name(name), Span::call_site());
    let fields = parameters.iter().map(parameters::Parameter::field);
    let docs = docs.iter();
    let tokens = quote_spanned!(Span::call_site()=> #(#[doc = #docs])* pub struct #name { #(#fields),* });
    syn::parse2(tokens).ok()
}

/// The name of the struct: `InvertedPendulum` for `inverted-pendulum`.
fn type_name(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let mut camel: String = words
        .flat_map(|word| {
            let (first, rest) = word.split_at(word.len().min(1));
            first
                .to_ascii_uppercase()
                .chars()
                .chain(rest.chars())
                .collect::<Vec<_>>()
        })
        .collect();
    if !camel.starts_with(|first: char| first.is_ascii_alphabetic()) {
        camel.insert_str(0, "System");
    }
    // `Self` is a keyword of Rust
    if camel == "Self" {
        "System".to_owned()
    } else {
        camel
    }
}
