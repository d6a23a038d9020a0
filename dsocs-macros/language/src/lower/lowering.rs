//! The state of the lowering: the graph so far, and the names in scope.

use proc_macro2::{Ident, TokenStream};
use quote::ToTokens;
use syn::Expr;

use crate::graph::{Graph, NodeId};
use crate::lower::names::{Binding, Scope};
use crate::mistakes::errors::{Errors, Reported};
use crate::model::{PairPoint, TriplePoint};
use crate::syntax::ast::{Declaration, Group};
use crate::syntax::bare;
use crate::syntax::input::Fields;

/// A node, unless a mistake was reported.
pub(crate) type Lowered = Result<NodeId, Reported>;

/// A derivative in an expression, with its order.
#[derive(Clone, Debug)]
pub(crate) struct DerivativeTokens {
    pub(crate) tokens: TokenStream,
    pub(crate) order: usize,
}

/// The state of the lowering.
pub(crate) struct Lowering<'d> {
    pub(crate) graph: Graph,
    pub(crate) fields: &'d Fields,
    /// The groups of coordinates as declared.
    pub(crate) groups: &'d [Group],
    /// All coordinates, those of arrays one by one.
    pub(crate) coordinates: &'d [Ident],
    pub(crate) errors: &'d Errors,
    pub(crate) scope: Scope,
    /// In a map, the component of the vector being lowered.
    pub(crate) component: Option<usize>,
    /// In a discrete expression, its nodes.
    pub(crate) discrete: Option<Nodes>,
    /// The names of all `let`s, to tell an unknown name from one that is used before its definition.
    pub(crate) let_names: Vec<String>,
    /// The names of those `let`s that are functions.
    pub(crate) functions: Vec<String>,
    /// The number of terms of sums and calls of functions expanded so far.
    pub(crate) expanded: usize,
    /// The number of rows of each kind of constraint, where a vector counts as several; `None` where it is
    /// not known.
    pub(crate) rows: [Option<usize>; 3],
    /// The arguments of `dot(…)` so far.
    pub(crate) differentiated: Vec<NodeId>,
    /// The derivatives in the expression being lowered, inner ones first.
    pub(crate) derivatives: Vec<DerivativeTokens>,
}

/// The maps of pairs and of triples.
pub(crate) type Maps = (
    Result<Vec<PairPoint>, Reported>,
    Result<Option<TriplePoint>, Reported>,
);

/// The nodes of a discrete expression.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// The number of nodes.
    pub(crate) count: usize,
    /// The maps to the continuous system.
    pub(crate) maps: Maps,
}

impl<'d> Lowering<'d> {
    /// The state before the first `let`.
    pub(crate) fn new(
        declaration: &Declaration,
        groups: &'d [Group],
        coordinates: &'d [Ident],
        fields: &'d Fields,
        errors: &'d Errors,
    ) -> Self {
        let mut lowering = Lowering {
            graph: Graph::new(),
            fields,
            groups,
            coordinates,
            errors,
            scope: Scope::default(),
            component: None,
            discrete: None,
            let_names: declaration
                .lets
                .iter()
                .map(|binding| binding.name.to_string())
                .collect(),
            functions: declaration
                .lets
                .iter()
                .filter(
                    |binding| matches!(&binding.value, Ok(value) if matches!(bare(value), Expr::Closure(_))),
                )
                .map(|binding| binding.name.to_string())
                .collect(),
            expanded: 0,
            rows: [Some(0); 3],
            differentiated: Vec::new(),
            derivatives: Vec::new(),
        };
        // fields first: if a coordinate has the same name, the clash is reported and the name means the
        // coordinate
        for (index, field) in fields.iter().enumerate() {
            lowering.scope.push(&field.ident, Binding::Field(index));
        }
        let rotations = groups.iter().filter(|group| group.is_rotation);
        lowering
            .graph
            .set_rotations(rotations.map(|group| group.first).collect());
        for (index, name) in coordinates.iter().enumerate() {
            // the components of a quaternion have no names
            if lowering.graph.rotation_at(index).is_none() {
                lowering.scope.push(name, Binding::Coordinate(index));
            }
        }
        for (index, group) in groups.iter().enumerate() {
            if group.is_rotation {
                lowering.scope.push(&group.name, Binding::Rotation(index));
            } else if group.length.is_some() {
                lowering.scope.push(&group.name, Binding::Array(index));
            }
        }
        lowering
    }
}

impl Lowering<'_> {
    /// The value of an expression whose order must be below a limit; `message` is the error.
    pub(crate) fn expr_of_order_below(&mut self, limit: usize, expr: &Expr, message: &str) -> Lowered {
        self.derivatives.clear();
        let value = self.expr(expr)?;
        self.check_order_below(limit, value, expr, message)
    }

    /// Checks that the order of a value, a number or a component of a vector, is below a limit, and returns the value; `message` is the
    /// error.
    pub(crate) fn check_order_below(
        &mut self,
        limit: usize,
        value: NodeId,
        expr: &Expr,
        message: &str,
    ) -> Lowered {
        if self.graph.order(value).is_none_or(|order| order < limit) {
            return Ok(value);
        }
        let (value, _) = self.without_cancelled_derivatives(value);
        if self.graph.order(value).is_none_or(|order| order < limit) {
            return Ok(value);
        }
        let derivative = self
            .derivatives
            .iter()
            .find(|derivative| derivative.order >= limit);
        let order = derivative.map_or(limit, |derivative| derivative.order);
        let tokens =
            derivative.map_or_else(|| expr.to_token_stream(), |derivative| derivative.tokens.clone());
        Err(self.errors.at(tokens, with_jerk_named(message, order)))
    }

    /// Refuses a jerk, which only kinematic constraints may contain.
    pub(crate) fn without_jerk(&self, value: NodeId, tokens: impl ToTokens, expected: &str) -> Lowered {
        if self.graph.order(value) != Some(3) {
            return Ok(value);
        }
        let derivative = self.derivatives.iter().find(|derivative| derivative.order > 2);
        let tokens = derivative.map_or_else(
            || tokens.into_token_stream(),
            |derivative| derivative.tokens.clone(),
        );
        Err(self.errors.at(
            tokens,
            format!("a jerk, a third derivative, comes in here; expected {expected}: jerks stand in `kinematic = …;` alone"),
        ))
    }
}

/// A message about an acceleration, changed to one about a jerk if the order is 3.
pub(crate) fn with_jerk_named(message: &str, order: usize) -> String {
    if order < 3 {
        return message.to_owned();
    }
    message
        .replacen("an acceleration comes", "a jerk, a third derivative, comes", 1)
        .replacen("with accelerations it", "with jerks it", 1)
}
