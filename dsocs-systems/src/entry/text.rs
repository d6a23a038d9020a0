//! A system written as a text file, and as Rust.

use std::fmt::Write as _;

#[cfg(feature = "sweep")]
use dsocs_core::Samples;
use dsocs_core::text::{Curve, Table};
use dsocs_core::{Kernel, Quantity};
use thiserror::Error;

use super::Entry;

/// A system that cannot be written as a text.
#[derive(Clone, PartialEq, Eq, Error)]
#[error(
    "`{name}` is more than a text can say: {}; text files know numbers, arrays of them and tables of samples",
    .fields.join(", ")
)]
pub struct NoText {
    /// The system.
    pub name: String,
    /// Its parameters that are neither numbers nor tables of samples, with their types.
    pub fields: Vec<String>,
}

dsocs_core::debug_is_message!(NoText);

/// A parameter of the declaration.
struct Parameter<'a> {
    name: &'a str,
    doc: &'a str,
    /// The number of elements of an array, or of rows and columns of a matrix; empty for a number.
    lengths: Vec<usize>,
    /// Its value, in the notation that texts and Rust share.
    value: String,
}

impl Entry {
    /// The system as the text of a file, with the present values of its parameters, its start, step and end.
    ///
    /// # Errors
    ///
    /// [`NoText`] if it has parameters of other types than numbers and tables of samples, or calls functions of Rust.
    pub fn text(&self) -> Result<String, NoText> {
        let shape = self.system.kernel().shape();
        let mut text = String::new();
        for line in shape.doc.lines() {
            let _ = writeln!(text, "//! {}", unescaped(line));
        }
        let parameters = self.as_declared()?;
        if !parameters.is_empty() || !self.tables.is_empty() {
            text.push_str("parameters {\n");
            for of in &parameters {
                documentation(&mut text, &unescaped(of.doc));
                let length = match of.lengths[..] {
                    [length] => format!(": [{length}]"),
                    _ => String::new(),
                };
                let _ = writeln!(text, "    {}{length} = {},", of.name, of.value);
            }
            for table in self.tables() {
                documentation(&mut text, &unescaped(&table.doc));
                let curve = match table.curve {
                    Curve::Cubic => String::new(),
                    other => format!(", {}", other.name()),
                };
                let _ = writeln!(text, "    {} = samples({:?}{curve}),", table.name, table.file);
            }
            text.push_str("}\n");
        }
        for line in shape.declaration.lines() {
            let line = match line.split_once("///") {
                Some((indent, doc)) if indent.trim().is_empty() => format!("{indent}///{}", unescaped(doc)),
                _ => line.to_owned(),
            };
            let _ = writeln!(text, "{line}");
        }
        text.push_str("run {\n");
        if let Some([q0, v0]) = &self.start {
            let _ = writeln!(text, "    start = ({q0:?}, {v0:?});");
        }
        for (name, vector) in [
            ("acceleration", &self.acceleration),
            ("near_acceleration", &self.near),
        ] {
            if let Some(vector) = vector {
                let _ = writeln!(text, "    {name} = {vector:?};");
            }
        }
        if self.project {
            text.push_str("    project = true;\n");
        }
        let _ = writeln!(
            text,
            "    step = {:?};\n    until = {:?};\n}}",
            self.step, self.until
        );
        Ok(text)
    }

    /// The system as the `main.rs` of a crate whose command line runs it.
    ///
    /// # Errors
    ///
    /// As [`Entry::text`].
    pub fn rust(&self) -> Result<String, NoText> {
        let shape = self.system.kernel().shape();
        let parameters = self.as_declared()?;
        let has_tables = !self.tables.is_empty();
        let summary = self.summary.lines().collect::<Vec<_>>().join(" ");
        let mut rust = format!("//! {summary}\n\nuse std::process::ExitCode;\n\n");
        rust.push_str(if has_tables {
            "use dsocs_core::{Samples, SamplesError, dsocs};\n"
        } else {
            "use dsocs_core::dsocs;\n"
        });
        rust.push_str("use dsocs_systems::{Entry, cli};\n\n");
        for line in shape.doc.lines() {
            let _ = writeln!(rust, "/// {line}");
        }
        rust.push_str("#[dsocs {\n");
        for line in shape.declaration.lines() {
            let _ = writeln!(rust, "    {line}");
        }
        let _ = write!(rust, "}}]\n#[derive(Clone)]\nstruct {} {{\n", shape.name);
        for of in &parameters {
            documentation(&mut rust, of.doc);
            let lengths = of.lengths.iter().rev();
            let ty = lengths.fold("f64".to_owned(), |ty, length| format!("[{ty}; {length}]"));
            let _ = writeln!(rust, "    {}: {ty},", of.name);
        }
        for table in self.tables() {
            documentation(&mut rust, &table.doc);
            let _ = writeln!(rust, "    {}: Samples,", table.name);
        }
        let result = if has_tables {
            "Result<ExitCode, SamplesError>"
        } else {
            "ExitCode"
        };
        let _ = write!(
            rust,
            "}}\n\nfn main() -> {result} {{\n    let system = {} {{\n",
            shape.name
        );
        for of in &parameters {
            let _ = writeln!(rust, "        {}: {},", of.name, of.value);
        }
        for Table {
            name, file, curve, ..
        } in self.tables()
        {
            let _ = writeln!(
                rust,
                "        {name}: Samples::{}(Samples::read({file:?})?)?,",
                curve.name()
            );
        }
        let _ = write!(
            rust,
            "    }};\n    let entry = Entry::new(system)\n        .named({:?})\n",
            self.name
        );
        match (&self.start, &self.acceleration) {
            (Some([q0, v0]), Some(a0)) => {
                let _ = writeln!(rust, "        .start_with_acceleration({q0:?}, {v0:?}, {a0:?})");
            }
            (Some([q0, v0]), None) => {
                let _ = writeln!(rust, "        .start({q0:?}, {v0:?})");
            }
            _ => {}
        }
        if let Some(near) = &self.near {
            let _ = writeln!(rust, "        .near_acceleration({near:?})");
        }
        if self.project {
            rust.push_str("        .projected()\n");
        }
        let _ = writeln!(
            rust,
            "        .step({:?})\n        .until({:?});",
            self.step, self.until
        );
        let run = "cli::main([entry])";
        let _ = if has_tables {
            writeln!(rust, "    Ok({run})\n}}")
        } else {
            writeln!(rust, "    {run}\n}}")
        };
        Ok(rust)
    }

    /// The files of its tables, as the text names them.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        self.tables.iter().map(|(table, _)| table.file.as_str())
    }

    /// The names of its tables of samples, with their contents.
    #[cfg(feature = "sweep")]
    pub(crate) fn samples(&self) -> impl Iterator<Item = (&str, &Samples)> {
        self.tables
            .iter()
            .map(|(table, samples)| (table.name.as_str(), &**samples))
    }

    /// The numeric parameters, arrays as arrays.
    fn as_declared(&self) -> Result<Vec<Parameter<'_>>, NoText> {
        let kernel = self.system.kernel();
        let shape = kernel.shape();
        let is_table = |name: &str| self.tables.iter().any(|(table, _)| table.name == name);
        let others = shape.others.iter().filter(|other| !is_table(&other.name));
        let others = others.map(|other| format!("`{}` is of type `{}`", other.name, other.doc));
        let extra = self.description.parameters.get(shape.parameters.len()..);
        let extra = extra.unwrap_or_default().iter();
        let extra = extra.map(|extra| format!("`{}` is not declared", extra.name));
        let calls = (kernel.tape().calls_functions() && shape.others.is_empty())
            .then(|| "it calls functions of Rust".to_owned());
        let fields: Vec<String> = others.chain(extra).chain(calls).collect();
        if fields.is_empty() {
            Ok(parameters(kernel))
        } else {
            Err(NoText {
                name: self.name.clone(),
                fields,
            })
        }
    }
}

/// Documentation without the backslashes that keep Rust from reading units as links: `\[J\]`.
fn unescaped(doc: &str) -> String {
    doc.replace("\\[", "[").replace("\\]", "]")
}

/// Writes a line of documentation, if there is one.
fn documentation(text: &mut String, doc: &str) {
    for line in doc.lines() {
        let _ = writeln!(text, "    /// {line}");
    }
}

/// The parameters of a system.
fn parameters(kernel: &dyn Kernel) -> Vec<Parameter<'_>> {
    let shape = kernel.shape();
    let all = &shape.parameters[..];
    let mut parameters = Vec::new();
    let mut place = 0;
    while let Some(first) = all.get(place) {
        let (name, lengths) = lengths(&all[place..], &shape.declaration);
        let count: usize = lengths.iter().product();
        let values: Vec<f64> = (place..place + count).map(|place| kernel.value(place)).collect();
        parameters.push(Parameter {
            name,
            doc: &first.doc,
            value: match lengths[..] {
                [] => format!("{:?}", kernel.value(place)),
                [_] => format!("{values:?}"),
                [_, columns, ..] => format!("{:?}", values.chunks(columns).collect::<Vec<_>>()),
            },
            lengths,
        });
        place += count;
    }
    parameters
}

/// The name of the parameter that begins with the first of these elements, and its lengths: none for a
/// number, one for an array, two for a matrix.
fn lengths<'q>(parameters: &'q [Quantity], declaration: &str) -> (&'q str, Vec<usize>) {
    let Some(first) = parameters.first() else {
        return ("", Vec::new());
    };
    let is_read = |name: &str| {
        declaration.match_indices(name).any(|(at, _)| {
            let is_end = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric() && c != '_');
            is_end(declaration[..at].chars().next_back())
                && is_end(declaration[at + name.len()..].chars().next())
        })
    };
    let run = |names: &mut dyn Iterator<Item = String>| {
        let same = parameters.iter().zip(names);
        same.take_while(|(of, name)| of.name == *name && of.doc == first.doc)
            .count()
    };
    // the declaration contains an array's own name, not the names of its elements
    let of = |end: &str| {
        first
            .name
            .strip_suffix(end)
            .filter(|name| is_read(name) && !is_read(&first.name))
    };
    if let Some(name) = of("_0") {
        return (name, vec![run(&mut (0..).map(|i| format!("{name}_{i}")))]);
    }
    if let Some(name) = of("_0_0") {
        let columns = run(&mut (0..).map(|j| format!("{name}_0_{j}")));
        let all = run(&mut (0..).map(|k| format!("{name}_{}_{}", k / columns, k % columns)));
        return (name, vec![all / columns, columns]);
    }
    (&first.name, Vec::new())
}
