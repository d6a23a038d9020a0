//! A system as the text of a file that says the same.

use std::fmt::Write as _;

use dsocs_core::{Kernel, Quantity};
use thiserror::Error;

use super::Entry;

/// A system that no text can say.
#[derive(Clone, PartialEq, Eq, Error)]
#[error(
    "`{name}` is more than a text can say: {}; text files know numbers, arrays of them and tables of samples",
    .fields.join(", ")
)]
pub struct NoText {
    /// The system.
    pub name: String,
    /// Its parameters that are no numbers, with their types.
    pub fields: Vec<String>,
}

dsocs_core::debug_is_message!(NoText);

impl Entry {
    /// The system as the text of a file, with the present values of its parameters, its start, step and end. A system that was read from a file with
    /// tables of samples has none of its own.
    ///
    /// # Errors
    ///
    /// [`NoText`] if it has parameters of other types than numbers.
    pub fn text(&self) -> Result<String, NoText> {
        let kernel = self.system.kernel();
        let shape = kernel.shape();
        let others = shape
            .others
            .iter()
            .map(|other| format!("`{}` is of type `{}`", other.name, other.doc));
        let extra = self
            .description
            .parameters
            .get(shape.parameters.len()..)
            .unwrap_or_default();
        let extra = extra
            .iter()
            .map(|extra| format!("`{}` is not declared", extra.name));
        let calls = (kernel.tape().calls_functions() && shape.others.is_empty())
            .then(|| "it calls functions of Rust".to_owned());
        let fields: Vec<String> = others.chain(extra).chain(calls).collect();
        if !fields.is_empty() {
            return Err(NoText {
                name: self.name.clone(),
                fields,
            });
        }
        let mut text = String::new();
        for line in shape.doc.lines() {
            let _ = writeln!(text, "//! {line}");
        }
        text.push_str(&parameters(kernel));
        text.push_str(&shape.declaration);
        text.push_str(&self.run_as_text());
        Ok(text)
    }

    /// `run { … }`.
    fn run_as_text(&self) -> String {
        let mut run = String::from("run {\n");
        if let Some([q0, v0]) = &self.start {
            let _ = writeln!(run, "    start = ({q0:?}, {v0:?});");
        }
        if let Some(a0) = &self.acceleration {
            let _ = writeln!(run, "    acceleration = {a0:?};");
        }
        if let Some(near) = &self.near {
            let _ = writeln!(run, "    near_acceleration = {near:?};");
        }
        let _ = writeln!(
            run,
            "    step = {:?};\n    until = {:?};\n}}",
            self.step, self.until
        );
        run
    }
}

/// `parameters { … }`; nothing if there are none.
fn parameters(kernel: &dyn Kernel) -> String {
    let shape = kernel.shape();
    let all = &shape.parameters[..];
    if all.is_empty() {
        return String::new();
    }
    let mut text = String::from("parameters {\n");
    let mut place = 0;
    while let Some(first) = all.get(place) {
        let length = elements(&all[place..], &shape.declaration);
        if !first.doc.is_empty() {
            let _ = writeln!(text, "    /// {}", first.doc);
        }
        let _ = match length {
            None => writeln!(text, "    {} = {:?},", first.name, kernel.value(place)),
            Some(length) => {
                let name = first.name.trim_end_matches("_0");
                let values: Vec<f64> = (place..place + length).map(|place| kernel.value(place)).collect();
                writeln!(text, "    {name}: [{length}] = {values:?},")
            }
        };
        place += length.unwrap_or(1);
    }
    text.push_str("}\n");
    text
}

/// How many elements the array has with whose first element some parameters begin; `None` if they begin with a number.
fn elements(parameters: &[Quantity], declaration: &str) -> Option<usize> {
    let first = parameters.first()?;
    let name = first.name.strip_suffix("_0")?;
    // an array is read by its elements
    let read = declaration.match_indices(name).any(|(at, _)| {
        let before = declaration[..at].chars().next_back();
        let is_whole = before.is_none_or(|c| !c.is_alphanumeric() && c != '_');
        is_whole && declaration[at + name.len()..].trim_start().starts_with('[')
    });
    let same = parameters.iter().enumerate();
    let same = same.take_while(|(i, of)| of.name == format!("{name}_{i}") && of.doc == first.doc);
    read.then(|| same.count())
}
