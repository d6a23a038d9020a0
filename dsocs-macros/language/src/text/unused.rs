//! Warnings about parameters and constants that nothing uses, or whose names mean something else.

use std::collections::HashSet;

use proc_macro2::{Ident, TokenStream, TokenTree};

use super::parameters::Parameter;
use super::split::Parts;
use crate::model::Warning;
use crate::parse::STATEMENTS;

/// The names in a text.
pub(super) struct Names {
    /// The names of its constants.
    constants: Vec<Ident>,
    /// The names that occur in expressions.
    mentioned: HashSet<String>,
    /// The mentioned names that occur outside the values of parameters.
    beyond_values: HashSet<String>,
}

impl Names {
    /// The names of a text whose constants have not been replaced yet.
    pub(super) fn of(parts: &Parts) -> Self {
        let mut names = Self {
            constants: parts.constants.iter().map(|(name, _)| name.clone()).collect(),
            mentioned: HashSet::new(),
            beyond_values: HashSet::new(),
        };
        names.add(parts.declaration.clone(), false);
        for (_, value) in &parts.constants {
            names.add(value.clone(), false);
        }
        for (.., group) in &parts.runs {
            names.add(group.stream(), true);
        }
        names.beyond_values = names.mentioned.clone();
        if let Some(group) = &parts.parameters {
            names.add(group.stream(), true);
        }
        names
    }

    /// Adds the names in some tokens. In a block, the names of its entries do not count.
    fn add(&mut self, tokens: TokenStream, is_block: bool) {
        let mut trees = tokens.into_iter().peekable();
        while let Some(tree) = trees.next() {
            match tree {
                TokenTree::Group(group) => self.add(group.stream(), false),
                TokenTree::Ident(name) => {
                    let next = trees.peek();
                    let is_part =
                        matches!(next, Some(TokenTree::Punct(sign)) if matches!(sign.as_char(), '=' | ':'));
                    if !(is_block && is_part) {
                        self.mentioned.insert(name.to_string());
                    }
                }
                _ => {}
            }
        }
    }

    /// The warnings about names that nothing uses, and about names that mean something else.
    pub(super) fn warnings(&self, parameters: &[Parameter]) -> Vec<Warning> {
        let constants = self.constants.iter().map(|name| (name, "constant"));
        let parameters = parameters.iter().map(|parameter| (&parameter.name, "parameter"));
        let mut warnings = Vec::new();
        for (name, kind) in constants.chain(parameters) {
            let text = name.to_string();
            if !self.mentioned.contains(&text) && !text.starts_with('_') {
                let message = format!("nothing uses this {kind}; `_{text}` says that it is meant so");
                warnings.push(Warning {
                    place: name.clone(),
                    message,
                    unused: true,
                });
            }
            if kind == "parameter" && self.mentioned.contains(&text) && !self.beyond_values.contains(&text) {
                let message = format!(
                    "only the values of other parameters use `{text}`, and they are worked out once: a run that sets `{text}` changes nothing; what follows it is \
                     written `let … = …;` in their place"
                );
                warnings.push(Warning {
                    place: name.clone(),
                    message,
                    unused: false,
                });
            }
            let meaning = match text.as_str() {
                "pi" | "PI" => "the number 3.14159…",
                "tau" | "TAU" => "the number 6.28318…",
                word if STATEMENTS.contains(&word) => "the beginning of a statement",
                _ => continue,
            };
            warnings.push(Warning {
                place: name.clone(),
                message: format!("`{text}` is also {meaning}; here it means this {kind}"),
                unused: false,
            });
        }
        warnings
    }
}
