//! The Lagrangian, external forces, factors and observables.

mod constraints;
pub(crate) mod differentiated;
mod discrete;
mod map;
pub(crate) mod multiples;
pub(crate) mod reduction;

use proc_macro2::Ident;
use quote::{ToTokens, format_ident};
use syn::Expr;

use crate::check::names::check_column;
use crate::graph::NodeId;
use crate::lower::lowering::{Lowered, Lowering, with_jerk_named};
use crate::lower::names::Binding;
use crate::lower::values::Value;
use crate::mistakes::errors::Reported;
use crate::mistakes::nearest::did_you_mean;
use crate::syntax::ast::{Branch, Observe, Scalar};
use crate::syntax::{bare, plain_name};

impl Lowering<'_> {
    pub(crate) fn lagrangian(&mut self, lagrangian: &Scalar) -> Lowered {
        self.expr_of_order_below(
            2,
            &lagrangian.value,
            "an acceleration comes in here; expected a Lagrangian of positions and velocities, L(q, v)",
        )
    }

    /// The components of the external forces.
    pub(crate) fn external_forces(&mut self, forces: &Scalar) -> Result<Vec<NodeId>, Reported> {
        if let Expr::Array(list) = bare(&forces.value)
            && self
                .groups
                .iter()
                .all(|group| group.length.is_none() && !group.is_rotation)
        {
            let what = self.errors.words("one tuple", "parentheses");
            let message = format!(
                "expected {what} with a component for each coordinate, `external_forces = (f1, f2);`: forces that act together are added up"
            );
            return Err(self.errors.at(list, message));
        }
        if let Expr::Call(call) = bare(&forces.value)
            && plain_name(&call.func).is_some_and(|name| name == "each")
        {
            return Err(self.errors.at(
                call,
                "expected one component for each coordinate, in the shape of the coordinates; those of an array are written `|i| …`",
            ));
        }
        self.derivatives.clear();
        let components = self.entries(&forces.value)?;
        for &component in &components {
            if self.graph.order(component).is_some_and(|order| order > 1) {
                let derivative = self.derivatives.iter().find(|derivative| derivative.order > 1);
                let order = derivative.map_or(2, |derivative| derivative.order);
                let tokens = derivative.map_or_else(
                    || forces.value.to_token_stream(),
                    |derivative| derivative.tokens.clone(),
                );
                return Err(self.errors.at(
                    tokens,
                    with_jerk_named(
                        "an acceleration comes in here; expected forces of time, positions and velocities, f(t, q, v)",
                        order,
                    ),
                ));
            }
        }
        Ok(components)
    }

    pub(crate) fn branch(&mut self, branch: &Branch) -> Result<Vec<Option<NodeId>>, Reported> {
        let factors = branch.factors.iter().map(|factor| match factor {
            Ok(Some(factor)) => {
                let factors = self.each_entry(std::slice::from_ref(factor), Self::factor)?;
                Ok(factors.into_iter().next())
            }
            Ok(None) => Ok(None),
            Err(reported) => Err(*reported),
        });
        // collected in two steps, so that the first mistake does not hide the others
        let factors: Vec<_> = factors.collect();
        factors.into_iter().collect()
    }

    fn factor(&mut self, factor: &Expr) -> Lowered {
        let value = self.expr_of_order_below(
            2,
            factor,
            "an acceleration comes in here; expected a factor of positions and velocities",
        )?;
        if self.graph.order(value).is_none() {
            return Err(self.errors.at(
                factor,
                "expected a factor that depends on positions or velocities; dividing by another one changes no root",
            ));
        }
        Ok(value)
    }

    /// The observables: a number by its name, the components of a vector by numbered names, `force_0`.
    pub(crate) fn observe(&mut self, observe: &Observe) -> Result<Vec<Observed>, Reported> {
        let mut seen: Vec<&Ident> = Vec::new();
        let mut observed = Vec::new();
        for name in &observe.names {
            let name = match name {
                Ok(name) => name,
                Err(reported) => {
                    observed.push(Err(*reported));
                    continue;
                }
            };
            let value = match self.scope.get(name) {
                _ if seen.contains(&name) => {
                    Err(self.errors.at(name, format!("`{name}` is observed already")))
                }
                Some(Binding::Let(value)) => value.clone().and_then(|value| {
                    self.derivatives.clear();
                    let expected =
                        "what a node knows, an expression of time, positions, velocities and accelerations";
                    value.map(|value| self.without_jerk(value, name, expected))
                }),
                Some(other) => {
                    let message = format!("expected the name of a `let`, but `{name}` is {}", other.kind());
                    Err(self.errors.at(name, message))
                }
                None => {
                    let text = name.to_string();
                    let message = if self.let_names.contains(&text) {
                        format!("`{text}` is defined further down; expected its `let` before this use")
                    } else {
                        let lets = self.scope.names(|binding| matches!(binding, Binding::Let(_)));
                        format!("no `let` is called `{text}`{}", did_you_mean(&text, lets))
                    };
                    Err(self.errors.at(name, message))
                }
            };
            seen.push(name);
            observed.push(value.and_then(|value| self.observed(name, &value)));
        }
        let observed: Vec<_> = observed.into_iter().collect::<Result<_, _>>()?;
        Ok(observed.into_iter().flatten().collect())
    }

    /// The observables of one `let`.
    fn observed(&self, name: &Ident, value: &Value) -> Result<Vec<Observed>, Reported> {
        let ends: Vec<String> = match value {
            Value::Rotation(_) => {
                let message = format!(
                    "the components of a quaternion are observed as it is, in columns of their own; expected what is made of it, such as `{name} * c`"
                );
                return Err(self.errors.at(name, message));
            }
            Value::Number(_) => vec![String::new()],
            Value::Vector(components) => (0..components.len()).map(|i| format!("_{i}")).collect(),
            Value::Matrix(rows) => {
                let columns = rows.first().map_or(0, Vec::len);
                let all = (0..rows.len()).flat_map(|i| (0..columns).map(move |j| (i, j)));
                all.map(|(i, j)| format!("_{i}_{j}")).collect()
            }
        };
        let components = ends.iter().zip(value.numbers()).map(|(end, value)| {
            let own = if end.is_empty() { name.clone() } else { format_ident!("{name}{end}") };
            if !end.is_empty() && self.scope.get(&own).is_some() {
                let message = format!("the components of this vector are observed by numbered names, and `{own}` has a meaning already; expected another name");
                return Err(self.errors.at(name, message));
            }
            check_column(&own, name, self.coordinates, self.errors)?;
            Ok(Observed {
                name: own,
                of: name.clone(),
                value,
            })
        });
        components.collect()
    }
}

/// An observable: a number with its name.
pub(crate) struct Observed {
    /// Its name.
    pub(crate) name: Ident,
    /// The `let` that it is, or is a component of.
    pub(crate) of: Ident,
    /// Its value.
    pub(crate) value: NodeId,
}
