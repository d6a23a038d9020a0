//! Warnings about declarations without effect: `let`s that nothing uses, coordinates that no equation moves.

use std::collections::HashSet;

use proc_macro2::Ident;
use syn::visit::{self, Visit};
use syn::{Expr, ExprPath};

use crate::graph::{Graph, Leaf};
use crate::model::{Kind, Model, Warning};
use crate::syntax::ast::{Declaration, Entry, Let, MapRule};

/// The warnings about unused `let`s and undetermined coordinates of a model.
pub(crate) fn warnings(declaration: &Declaration, model: &Model) -> Vec<Warning> {
    let mut warnings = unused_lets(declaration);
    let (graph, n) = (&model.graph, model.coordinates.len());
    for (i, name) in model.coordinates.iter().enumerate().take(n) {
        if is_at_rest(model, graph, i) {
            warnings.push(Warning {
                place: name.clone(),
                message: format!(
                    "nothing determines the acceleration of `{name}`: the Lagrangian has no `dot({name})`, and no constraint binds \
                     it"
                ),
                unused: false,
            });
        }
    }
    warnings
}

/// Whether no equation determines the acceleration of a coordinate.
fn is_at_rest(model: &Model, graph: &Graph, i: usize) -> bool {
    let bound = model.constraints.iter().any(|row| {
        let highest = match (row.kind, row.order) {
            (Kind::Holonomic, _) => Leaf::Q(i),
            (Kind::Nonholonomic, _) => Leaf::V(i),
            (Kind::Kinematic, 3) => Leaf::J(i),
            (Kind::Kinematic, _) => Leaf::A(i),
        };
        graph.depends_on(row.value, highest)
    });
    !bound && !graph.depends_on(model.lagrangian, Leaf::V(i)) && model.discrete_lagrangian.is_none()
}

/// The `let`s whose names occur nowhere else.
fn unused_lets(declaration: &Declaration) -> Vec<Warning> {
    let mut used = in_statements(declaration);
    for binding in &declaration.lets {
        used.of(binding);
    }
    let unused = declaration.lets.iter().filter(|binding| {
        let name = binding.name.to_string();
        !binding.shared && !name.starts_with('_') && !used.0.contains(&name)
    });
    let warning = |name: &Ident| Warning {
        place: name.clone(),
        message: format!("nothing uses this `let`; `_{name}` says that it is meant so"),
        unused: true,
    };
    unused.map(|binding| warning(&binding.name)).collect()
}

/// The names that statements use, directly or through `let`s.
pub(crate) fn used_names(declaration: &Declaration) -> HashSet<String> {
    let mut used = in_statements(declaration);
    // a `let` uses only those before it
    for binding in declaration.lets.iter().rev() {
        if used.0.contains(&binding.name.to_string()) {
            used.of(binding);
        }
    }
    used.0
}

/// The names in statements other than `let`s.
fn in_statements(declaration: &Declaration) -> UsedNames {
    let mut used = UsedNames::default();
    for expr in expressions(declaration) {
        used.visit_expr(expr);
    }
    let observed = declaration
        .observe
        .given()
        .into_iter()
        .flat_map(|part| &part.names);
    let observed = observed.flatten().map(ToString::to_string);
    used.0.extend(observed);
    used
}

/// All expressions in statements other than `let`s.
fn expressions(declaration: &Declaration) -> Vec<&Expr> {
    let mut all: Vec<&Expr> = Vec::new();
    for part in [
        &declaration.lagrangian,
        &declaration.discrete_lagrangian,
        &declaration.external_forces,
    ] {
        all.extend(part.given().map(|part| &part.value));
    }
    let rows = [
        &declaration.holonomic,
        &declaration.nonholonomic,
        &declaration.kinematic,
        &declaration.discrete_kinematic,
    ];
    for part in rows {
        all.extend(values(part.given().into_iter().flat_map(|part| &part.rows)));
    }
    let directions = declaration.directions.given().into_iter();
    all.extend(values(directions.flat_map(|part| &part.fields)));
    for part in [
        &declaration.phi_lagrangian,
        &declaration.phi_kinematic,
        &declaration.phi_variational,
    ] {
        if let Some(MapRule::Closure(closure)) = part.given().map(|map| &map.rule) {
            all.push(&closure.body);
        }
    }
    let factors = declaration
        .branch
        .given()
        .into_iter()
        .flat_map(|part| &part.factors);
    all.extend(values(factors.flatten().flatten()));
    all
}

/// The expressions of entries.
fn values<'d>(entries: impl Iterator<Item = &'d Entry>) -> impl Iterator<Item = &'d Expr> {
    entries.map(|entry| &entry.value)
}

/// The names in expressions.
#[derive(Default)]
struct UsedNames(HashSet<String>);

impl UsedNames {
    /// Adds the names in the value of a `let`.
    fn of(&mut self, binding: &Let) {
        if let Ok(value) = &binding.value {
            self.visit_expr(value);
        }
    }
}

impl<'ast> Visit<'ast> for UsedNames {
    fn visit_expr_path(&mut self, path: &'ast ExprPath) {
        self.0.extend(path.path.get_ident().map(ToString::to_string));
        visit::visit_expr_path(self, path);
    }
}
