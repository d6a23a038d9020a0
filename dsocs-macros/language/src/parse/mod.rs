//! Tokens → [`Declaration`]: reads each statement by itself, so that a mistake in one does not hide the others.

use proc_macro2::{Ident, TokenStream};
use quote::ToTokens;
use syn::parse::{ParseStream, Parser};
use syn::{Attribute, Block, Expr, ExprCall, Item, Stmt, Token};

use crate::mistakes::errors::{Errors, Reported};
use crate::syntax::ast::{
    Branch, Constraints, Declaration, Directions, Map, Observe, Scalar, Side, Statement,
};
use crate::syntax::plain_name;
use crate::syntax::shared::{self, StatementTokens};

mod begin;
mod coordinates;
mod depth;
mod each;
mod foreign_statements;
mod lets;
mod operator;
mod values;
mod wrong;

use self::lets::read_let;
use self::values::{read_factor, read_fields, read_map, read_names, read_path, read_rows};
use self::wrong::{
    expected_statement, mark_malformed, report_definition, report_no_statement, report_unknown, set_malformed,
};

pub(crate) use self::depth::{DEEPEST, LONGEST, too_deep};
pub(crate) use self::each::entries;
pub(crate) use self::foreign_statements::foreign_statement_hint;
pub(crate) use self::lets::plain_let;

/// The first words of statements, apart from `let`.
pub(crate) const STATEMENTS: [&str; 16] = [
    "coordinates",
    "lagrangian",
    "holonomic",
    "nonholonomic",
    "kinematic",
    "variational",
    "constraint_forces",
    "external_forces",
    "discrete_lagrangian",
    "discrete_kinematic",
    "phi_lagrangian",
    "phi_kinematic",
    "phi_variational",
    "branch",
    "observe",
    "reduced",
];

/// Reads the body of the attribute.
pub(crate) fn declaration(tokens: TokenStream, errors: &Errors) -> Declaration {
    let mut declaration = Declaration::default();
    for StatementTokens { tokens, shared } in shared::statements_in_order(tokens) {
        if errors.are_many() {
            break;
        }
        let lets = declaration.lets.len();
        if let Some(tree) = too_deep(&tokens, DEEPEST) {
            let reported = errors.at(
                tree,
                format!(
                    "expected an expression that is nested at most {DEEPEST} deep and has at most {LONGEST} words and signs: a `let` gives a part a name"
                ),
            );
            mark_malformed(&mut declaration, tokens, reported);
            continue;
        }
        if let Some(reported) = begin::check(&tokens, errors) {
            mark_malformed(&mut declaration, tokens, reported);
            continue;
        }
        match statement.parse2(tokens.clone()) {
            Ok((attributes, statement)) => {
                only_documentation(&attributes, errors);
                match statement {
                    StatementSyntax::Coordinates(keyword, arguments) => {
                        let lets_before = declaration.lets.len();
                        let coordinates = coordinates::read(&keyword, arguments, lets_before, errors);
                        fill(&mut declaration.coordinates, &keyword, coordinates, errors);
                    }
                    StatementSyntax::Core(keyword, value) => {
                        let keyword = Ident::new("crate", keyword.span);
                        fill(&mut declaration.core, &keyword, read_path(value, errors), errors);
                    }
                    StatementSyntax::Rust(statements) => {
                        for statement in statements {
                            read(&mut declaration, statement, &attributes, errors);
                        }
                    }
                }
            }
            Err(error) => {
                let reported = errors.push(operator::missing(&tokens, error, errors));
                mark_malformed(&mut declaration, tokens, reported);
            }
        }
        for read in &mut declaration.lets[lets..] {
            read.shared = shared;
        }
    }
    declaration
}

/// The expression in some tokens, which follow `before`.
pub(crate) fn expression(
    tokens: &TokenStream,
    before: impl ToTokens,
    errors: &Errors,
) -> Result<Expr, Reported> {
    if tokens.is_empty() {
        return Err(errors.at(before, "expected a value behind this"));
    }
    syn::parse2(tokens.clone()).map_err(|error| errors.push(operator::missing(tokens, error, errors)))
}

/// Refuses attributes that are no documentation.
fn only_documentation(attributes: &[Attribute], errors: &Errors) {
    for attribute in attributes {
        if !attribute.path().is_ident("doc") {
            errors.at(
                attribute,
                "attributes other than documentation have no meaning in a declaration",
            );
        }
    }
}

/// A statement, and its kind as far as the syntax determines it.
enum StatementSyntax {
    /// `coordinates(…);`, which is no Rust statement because of its arrays.
    Coordinates(Ident, Vec<coordinates::Argument>),
    /// `crate = …;`, which is no Rust statement either.
    Core(Token![crate], Expr),
    /// Any other statement, or several where a `;` is missing.
    Rust(Vec<Stmt>),
}

fn statement(input: ParseStream) -> syn::Result<(Vec<Attribute>, StatementSyntax)> {
    let attributes = Attribute::parse_outer(input)?;
    let statement = if let Some((keyword, arguments)) = coordinates::parse(input)? {
        StatementSyntax::Coordinates(keyword, arguments)
    } else if input.peek(Token![crate]) && input.peek2(Token![=]) {
        let keyword = input.parse()?;
        input.parse::<Token![=]>()?;
        let value = input.parse()?;
        input.parse::<Token![;]>()?;
        StatementSyntax::Core(keyword, value)
    } else {
        StatementSyntax::Rust(Block::parse_within(input)?)
    };
    Ok((attributes, statement))
}

fn read(declaration: &mut Declaration, statement: Stmt, attributes: &[Attribute], errors: &Errors) {
    match statement {
        Stmt::Local(local) => read_let(declaration, local, attributes, errors),
        Stmt::Expr(Expr::Assign(assign), _) => match plain_name(&assign.left) {
            Some(keyword) => read_assignment(declaration, keyword.clone(), *assign.right, errors),
            None => match &*assign.left {
                Expr::Call(call) if plain_name(&call.func).is_some() => {
                    report_definition(declaration, call, errors);
                }
                other => {
                    errors.at(other, expected_statement());
                }
            },
        },
        Stmt::Expr(Expr::Call(call), _) => match plain_name(&call.func) {
            Some(keyword) if keyword == "reduced" => {
                let names = read_coordinates(keyword, &call, errors);
                fill(&mut declaration.reduced, keyword, names, errors);
            }
            Some(keyword) if STATEMENTS.iter().any(|statement| keyword == statement) => {
                let reported = errors.at(keyword, format!("expected `{keyword} = …;`"));
                set_malformed(declaration, &keyword.to_string(), reported);
            }
            Some(keyword) => report_unknown(declaration, keyword, &keyword.to_string(), errors),
            None => {
                errors.at(&call, expected_statement());
            }
        },
        Stmt::Expr(Expr::Path(path), _) if path.path.get_ident().is_some() => {
            if let Some(word) = path.path.get_ident() {
                report_unknown(declaration, word, &word.to_string(), errors);
            }
        }
        // the empty statement of `;;`
        Stmt::Expr(Expr::Verbatim(tokens), _) if tokens.is_empty() => {}
        Stmt::Item(Item::Use(other)) => {
            errors.at(
                other,
                errors.words(
                    "shared statements are macros, which the compiler alone can find: write them out here",
                    "no statement begins with `use`: write out here what is meant",
                ),
            );
        }
        other => {
            errors.at(other, expected_statement());
        }
    }
}

/// Reads the names in `reduced(…)`.
fn read_coordinates(keyword: &Ident, call: &ExprCall, errors: &Errors) -> Result<Vec<Ident>, Reported> {
    if call.args.is_empty() {
        return Err(errors.at(keyword, "expected the names of coordinates, `reduced(r);`"));
    }
    let name = |argument: &Expr| {
        plain_name(argument)
            .cloned()
            .ok_or_else(|| errors.at(argument, "expected the name of a coordinate"))
    };
    call.args.iter().map(name).collect()
}

fn read_assignment(declaration: &mut Declaration, keyword: Ident, value: Expr, errors: &Errors) {
    let lets_before = declaration.lets.len();
    let at = &keyword.clone();
    match keyword.to_string().as_str() {
        "coordinates" => {
            let reported = errors.at(value, "expected `coordinates(x, y);`, without `=`");
            set_malformed(declaration, "coordinates", reported);
        }
        "reduced" => {
            let reported = errors.at(value, "expected `reduced(r);`, without `=`");
            set_malformed(declaration, "reduced", reported);
        }
        name @ ("lagrangian" | "discrete_lagrangian" | "external_forces") => {
            let statement = match name {
                "external_forces" => &mut declaration.external_forces,
                "lagrangian" => &mut declaration.lagrangian,
                _ => &mut declaration.discrete_lagrangian,
            };
            fill(statement, at, Ok(Scalar { value, lets_before }), errors);
        }
        name @ ("holonomic" | "nonholonomic" | "kinematic" | "discrete_kinematic") => {
            let statement = match name {
                "holonomic" => &mut declaration.holonomic,
                "nonholonomic" => &mut declaration.nonholonomic,
                "kinematic" => &mut declaration.kinematic,
                _ => &mut declaration.discrete_kinematic,
            };
            let rows = read_rows(&keyword, value, errors).map(|rows| Constraints {
                keyword,
                rows,
                lets_before,
            });
            fill(statement, at, rows, errors);
        }
        name @ ("variational" | "constraint_forces") => {
            let side = match (name, plain_name(&value)) {
                ("constraint_forces", _) => Side::Forces,
                (_, Some(rule)) if rule == "chetaev" => Side::Chetaev,
                _ => Side::Variational,
            };
            let fields = match side {
                Side::Chetaev => Ok(Vec::new()),
                _ => read_fields(&keyword, value, errors),
            };
            let directions = fields.map(|fields| Directions {
                keyword,
                side,
                fields,
                lets_before,
            });
            fill_directions(&mut declaration.directions, at, directions, errors);
        }
        name @ ("phi_lagrangian" | "phi_kinematic" | "phi_variational") => {
            let statement = match name {
                "phi_lagrangian" => &mut declaration.phi_lagrangian,
                "phi_kinematic" => &mut declaration.phi_kinematic,
                _ => &mut declaration.phi_variational,
            };
            let map = read_map(&keyword, value, errors).map(|rule| Map { keyword, rule });
            fill(statement, at, map, errors);
        }
        "branch" => {
            let entries = match value {
                Expr::Array(array) => entries(array.elems, errors),
                factor => entries([factor], errors),
            };
            let branch = entries.map(|entries| Branch {
                keyword,
                factors: entries
                    .into_iter()
                    .map(|entry| read_factor(entry, errors))
                    .collect(),
                lets_before,
            });
            fill(&mut declaration.branch, at, branch, errors);
        }
        "observe" => {
            let observe = read_names(value, errors).map(|names| Observe { names, lets_before });
            fill(&mut declaration.observe, at, observe, errors);
        }
        other => report_no_statement(declaration, &keyword, other, errors),
    }
}

fn fill<T>(statement: &mut Statement<T>, keyword: &Ident, value: Result<T, Reported>, errors: &Errors) {
    if statement.is_absent() {
        *statement = value.map_or_else(Statement::Malformed, Statement::Given);
    } else {
        errors.at(
            keyword,
            format!("`{keyword}` is declared a second time here; expected it once"),
        );
    }
}

fn fill_directions(
    statement: &mut Statement<Directions>,
    keyword: &Ident,
    value: Result<Directions, Reported>,
    errors: &Errors,
) {
    match statement {
        Statement::Given(first) if first.keyword != *keyword => {
            errors.at(
                keyword,
                format!(
                    "expected either `variational` or `constraint_forces`: they say the same thing from two sides, and `{}` stands above",
                    first.keyword
                ),
            );
        }
        _ => fill(statement, keyword, value, errors),
    }
}
