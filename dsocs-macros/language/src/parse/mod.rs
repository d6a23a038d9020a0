//! Tokens → [`Declaration`]: reads each statement by itself, so that a mistake in one does not hide the others.

use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::ToTokens;
use syn::parse::{ParseStream, Parser};
use syn::{Attribute, Block, Expr, ExprCall, Item, Stmt, Token};

use crate::ast::{Branch, Constraints, Declaration, Directions, Let, Map, Observe, Scalar, Side, Statement};
use crate::errors::{Errors, Reported};
use crate::nearest::nearest;
use crate::shared::{self, StatementTokens};
use crate::syntax::plain_name;
use crate::text::{RUN, foreign_statement_hint};

mod begin;
mod coordinates;
mod each;
mod lets;
mod operator;
mod values;

use self::lets::read_let;
use self::values::{read_factor, read_fields, read_map, read_names, read_path, read_rows};

pub(crate) use self::each::entries;
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

/// The deepest nesting of an expression. Parsing and lowering recurse as deep, and the compiler's stack has
/// to hold.
pub(crate) const DEEPEST: usize = 100;

/// The most tokens between two commas or semicolons, a bracket counting as one: a sum is nested as deep as it
/// has terms.
pub(crate) const LONGEST: usize = 8000;

/// The first token beyond a depth of brackets, prefixes like `-`, method calls, closures, assignments and
/// alternatives, or beyond [`LONGEST`].
pub(crate) fn too_deep(tokens: &TokenStream, left: usize) -> Option<TokenTree> {
    // the tokens since the last separator, and those of them that add to the depth
    let (mut count, mut prefixes, mut methods, mut inner) = (0, 0, 0, 0);
    let mut before = '\0';
    for tree in tokens.clone() {
        count += 1;
        let mut punctuation = '\0';
        match &tree {
            TokenTree::Group(group) => {
                prefixes = 0;
                match left.checked_sub(1) {
                    Some(left) => {
                        if let Some(deep) = too_deep(&group.stream(), left) {
                            return Some(deep);
                        }
                    }
                    None => return Some(tree),
                }
            }
            TokenTree::Punct(punct) => {
                punctuation = punct.as_char();
                prefixes += 1;
                match punctuation {
                    ',' | ';' => (count, methods, inner) = (0, 0, 0),
                    '.' if before != '.' => methods += 1,
                    // a closure has two of these
                    '|' => inner += 1,
                    '=' if !matches!(before, '=' | '<' | '>' | '!') => inner += 1,
                    _ => methods = 0,
                }
            }
            TokenTree::Ident(word) => {
                prefixes = 0;
                if ["else", "return", "break", "move"]
                    .iter()
                    .any(|keyword| word == keyword)
                {
                    inner += 1;
                }
            }
            TokenTree::Literal(_) => prefixes = 0,
        }
        before = punctuation;
        if count > LONGEST || prefixes.max(methods).max(inner / 2) > left {
            return Some(tree);
        }
    }
    None
}

/// A statement, as far as its syntax tells the kind.
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

/// Marks every statement that seems to begin in these tokens as malformed, so that it is not reported as missing.
fn mark_malformed(declaration: &mut Declaration, tokens: TokenStream, reported: Reported) {
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
fn set_malformed(declaration: &mut Declaration, keyword: &str, reported: Reported) {
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

/// Reports an assignment to a name that is no statement.
fn report_no_statement(declaration: &mut Declaration, keyword: &Ident, name: &str, errors: &Errors) {
    let is_other = GIVEN_FORCES.contains(&name) || name == "forces" || nearest(name, STATEMENTS).is_some();
    if errors.are_of_text() && RUN.contains(&name) {
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

/// Reports a definition in the form `f(x) = …`.
fn report_definition(declaration: &mut Declaration, call: &ExprCall, errors: &Errors) {
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
fn report_unknown(declaration: &mut Declaration, keyword: &Ident, word: &str, errors: &Errors) {
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

fn expected_statement() -> String {
    let list: Vec<_> = STATEMENTS
        .iter()
        .map(|statement| format!("`{statement}`"))
        .collect();
    format!("expected a statement: `let`, {}", list.join(", "))
}
