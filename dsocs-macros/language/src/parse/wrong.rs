//! Statements that are wrong, and words that begin none.

use proc_macro2::{Ident, TokenStream, TokenTree};
use syn::ExprCall;

use super::{STATEMENTS, begin, foreign_statement_hint};
use crate::check::names::SETTINGS_OF_RUN;
use crate::mistakes::errors::{Errors, Reported};
use crate::mistakes::nearest::nearest;
use crate::syntax::ast::{Declaration, Let, Statement};
use crate::syntax::plain_name;

/// Marks every statement that seems to begin in these tokens as malformed, so that it is not reported as missing.
pub(super) fn mark_malformed(declaration: &mut Declaration, tokens: TokenStream, reported: Reported) {
    let mut last: Option<Ident> = None;
    if let Some(TokenTree::Ident(first)) = begin::words(&tokens).next() {
        set_malformed(declaration, &first.to_string(), reported);
    }
    for tree in tokens {
        match tree {
            TokenTree::Ident(ident) => {
                if last.as_ref().is_some_and(|last| last == "let") {
                    declaration.lets.push(Let {
                        name: ident.clone(),
                        value: Err(reported),
                        doc: String::new(),
                        shared: false,
                    });
                }
                last = Some(ident);
            }
            TokenTree::Punct(punct) if punct.as_char() != '=' => last = None,
            _ => {
                if let Some(keyword) = last.take() {
                    set_malformed(declaration, &keyword.to_string(), reported);
                }
            }
        }
    }
}

/// Marks the named statement as malformed, unless it was read before.
pub(super) fn set_malformed(declaration: &mut Declaration, keyword: &str, reported: Reported) {
    fn set<T>(statement: &mut Statement<T>, reported: Reported) {
        if statement.is_absent() {
            *statement = Statement::Malformed(reported);
        }
    }
    match keyword {
        "crate" => set(&mut declaration.core, reported),
        "coordinates" => set(&mut declaration.coordinates, reported),
        "lagrangian" => set(&mut declaration.lagrangian, reported),
        "holonomic" => set(&mut declaration.holonomic, reported),
        "nonholonomic" => set(&mut declaration.nonholonomic, reported),
        "kinematic" => set(&mut declaration.kinematic, reported),
        "external_forces" => set(&mut declaration.external_forces, reported),
        "discrete_lagrangian" => set(&mut declaration.discrete_lagrangian, reported),
        "discrete_kinematic" => set(&mut declaration.discrete_kinematic, reported),
        "variational" | "constraint_forces" => set(&mut declaration.directions, reported),
        "phi_lagrangian" => set(&mut declaration.phi_lagrangian, reported),
        "phi_kinematic" => set(&mut declaration.phi_kinematic, reported),
        "phi_variational" => set(&mut declaration.phi_variational, reported),
        "branch" => set(&mut declaration.branch, reported),
        "observe" => set(&mut declaration.observe, reported),
        "reduced" => set(&mut declaration.reduced, reported),
        _ => {}
    }
}

/// Reports an assignment to a name that is no statement.
pub(super) fn report_no_statement(
    declaration: &mut Declaration,
    keyword: &Ident,
    name: &str,
    errors: &Errors,
) {
    let is_other = GIVEN_FORCES.contains(&name) || name == "forces" || nearest(name, STATEMENTS).is_some();
    if errors.are_of_text() && SETTINGS_OF_RUN.contains(&name) {
        let message = format!("`{name}` stands in a block of its own, `run {{ {name} = …; }}`");
        errors.at(keyword, message);
    } else if errors.are_of_text() && !is_other {
        let message = format!(
            "no statement is called `{name}`; `let {name} = …;` gives an expression a name, `parameters {{ {name} = … }}` a parameter its value"
        );
        let reported = errors.at(keyword, message);
        // defined, so that its uses are not reported as well
        declaration.lets.push(Let {
            name: keyword.clone(),
            value: Err(reported),
            doc: String::new(),
            shared: false,
        });
    } else {
        report_unknown(declaration, keyword, name, errors);
    }
}

/// Reports a definition in the form `f(x) = …`.
pub(super) fn report_definition(declaration: &mut Declaration, call: &ExprCall, errors: &Errors) {
    let Some(name) = plain_name(&call.func) else {
        return;
    };
    let text = name.to_string();
    if STATEMENTS.contains(&text.as_str()) {
        let reported = errors.at(call, format!("expected `{text} = …;`, without arguments"));
        set_malformed(declaration, &text, reported);
    } else if GIVEN_FORCES.contains(&text.as_str()) {
        report_unknown(declaration, name, &text, errors);
    } else {
        errors.at(call, format!("a function is written `let {text} = |x| …;`"));
    }
}

/// Names of external forces in other languages.
const GIVEN_FORCES: [&str; 15] = [
    "force",
    "external",
    "damping",
    "dampers",
    "friction",
    "drag",
    "dissipation",
    "rayleigh",
    "load",
    "loads",
    "torque",
    "torques",
    "actuation",
    "generalized_forces",
    "nonconservative_forces",
];

/// Reports a word with which no statement begins; the nearest statement is taken to be meant.
pub(super) fn report_unknown(declaration: &mut Declaration, keyword: &Ident, word: &str, errors: &Errors) {
    if word == "forces" {
        let message = "`forces` is called `constraint_forces`: the directions in which the forces of the constraints act; \
                       a force that is given, such as friction, is written `external_forces = (…);`";
        set_malformed(declaration, "constraint_forces", errors.at(keyword, message));
        return;
    }
    if GIVEN_FORCES.contains(&word) {
        let message = format!(
            "no statement is called `{word}`; forces that are given, such as friction and drives, are written \
             `external_forces = (f1, f2);`, with a component for each coordinate"
        );
        set_malformed(declaration, "external_forces", errors.at(keyword, message));
        return;
    }
    if let Some(near) = nearest(&word.to_lowercase(), STATEMENTS) {
        let message = format!("no statement is called `{word}`; did you mean `{near}`?");
        set_malformed(declaration, near, errors.at(keyword, message));
    } else {
        let hint = foreign_statement_hint(word).filter(|_| errors.are_of_text());
        let hint = hint.map_or_else(expected_statement, ToOwned::to_owned);
        errors.at(keyword, format!("no statement begins with `{word}`: {hint}"));
    }
}

pub(super) fn expected_statement() -> String {
    let list: Vec<_> = STATEMENTS
        .iter()
        .map(|statement| format!("`{statement}`"))
        .collect();
    format!("expected a statement: `let`, {}", list.join(", "))
}
