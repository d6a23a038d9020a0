//! The declaration's expressions → nodes of one graph: names resolved, the order of each expression known.

mod builtin;
mod call;
mod closed;
mod expr;
mod function;
mod index;
mod map;
mod shape;

use proc_macro2::{Ident, TokenStream};
use syn::{Expr, ItemStruct};

use crate::annihilator::{Defect, annihilator};
use crate::ast::{
    Branch, Coordinates, Declaration, Directions, Group, Kinematic, Map, Observe, Part, Scalar, Side,
};
use crate::errors::{Errors, Reported};
use crate::graph::{Graph, NodeId};
use crate::input::Fields;
use crate::model::{Model, Row};
use crate::names::{Binding, Scope, did_you_mean};
use crate::parse::bare;

/// A node, unless a mistake was reported.
type Lowered = Result<NodeId, Reported>;

/// Where a derivative enters an expression.
#[derive(Clone, Debug)]
struct Origin {
    tokens: TokenStream,
    order: usize,
}

/// The state of the pass.
struct Lowering<'d> {
    graph: Graph,
    fields: &'d Fields,
    /// The coordinates as they were declared.
    groups: &'d [Group],
    /// All coordinates, those of arrays one by one.
    coordinates: &'d [Ident],
    errors: &'d Errors,
    scope: Scope,
    /// The component of the vector being lowered; `Some` in the maps only.
    component: Option<usize>,
    /// The names of all `let`s, to tell an unknown name from one that is defined too late.
    later: Vec<String>,
    /// Those of them that are functions.
    functions: Vec<String>,
    /// How many terms of sums and calls of functions have been written out.
    expanded: usize,
    /// The derivatives in the expression being lowered, inner ones first.
    origins: Vec<Origin>,
}

/// Lowers a declaration whose shape has been checked, with the result `checked`.
pub(crate) fn model(
    declaration: &Declaration,
    item: &ItemStruct,
    fields: &Fields,
    checked: Result<(), Reported>,
    errors: &Errors,
) -> Result<Model, Reported> {
    let Coordinates {
        groups,
        names: coordinates,
        ..
    } = match &declaration.coordinates {
        Part::Given(coordinates) => coordinates,
        Part::Broken(reported) => return Err(*reported),
        Part::Absent => return Err(errors.missing("coordinates(x, y);")),
    };
    let mut lowering = Lowering {
        graph: Graph::new(),
        fields,
        groups,
        coordinates,
        errors,
        scope: Scope::default(),
        component: None,
        later: declaration
            .lets
            .iter()
            .map(|binding| binding.name.to_string())
            .collect(),
        functions: declaration
            .lets
            .iter()
            .filter(|binding| matches!(&binding.value, Ok(value) if matches!(bare(value), Expr::Closure(_))))
            .map(|binding| binding.name.to_string())
            .collect(),
        expanded: 0,
        origins: Vec::new(),
    };
    // fields first: where a field and a coordinate clash, the clash is reported and the coordinate is meant
    for (index, field) in fields.iter().enumerate() {
        lowering.scope.push(&field.ident, Binding::Field(index));
    }
    for (index, name) in coordinates.iter().enumerate() {
        lowering.scope.push(name, Binding::Coordinate(index));
    }
    for (index, group) in groups.iter().enumerate() {
        if group.length.is_some() {
            lowering.scope.push(&group.name, Binding::Array(index));
        }
    }
    let outer = lowering.scope.len();
    for binding in &declaration.lets {
        lowering.origins.clear();
        let value = match &binding.value {
            Ok(value) => lowering.binding(value),
            Err(reported) => Binding::Let(Err(*reported)),
        };
        lowering.scope.push(&binding.name, value);
    }
    let scopes = Scopes {
        all: lowering.scope.clone(),
        outer,
    };

    // every part is lowered before the first mistake ends the pass, so that all are reported
    let lagrangian = scopes.part(&mut lowering, &declaration.lagrangian, Lowering::lagrangian);
    let kinematic = scopes.part(&mut lowering, &declaration.kinematic, Lowering::kinematic);
    let directions = scopes.part(&mut lowering, &declaration.directions, |lowering, directions| {
        lowering.directions(directions, checked)
    });
    let branch = scopes.part(&mut lowering, &declaration.branch, Lowering::branch);
    let observe = scopes.part(&mut lowering, &declaration.observe, Lowering::observe);
    let phi_lagrangian = scopes.part(&mut lowering, &declaration.phi_lagrangian, Lowering::map);
    let phi_kinematic = scopes.part(&mut lowering, &declaration.phi_kinematic, Lowering::map);
    let phi_variational = scopes.part(&mut lowering, &declaration.phi_variational, Lowering::map);

    let lagrangian = lagrangian?.ok_or_else(|| errors.missing("lagrangian = …;"));
    checked?;
    let lagrangian = lagrangian?;
    let (kinematic, branch) = (kinematic?.unwrap_or_default(), branch?.unwrap_or_default());
    let factors = branch.into_iter().chain(std::iter::repeat(None));
    let rows = kinematic.into_iter().zip(factors);
    let kinematic = rows
        .map(|((value, order), divide)| Row { value, order, divide })
        .collect();
    let n = coordinates.len();
    let variational = match directions? {
        Some(fields) => fields,
        None => (0..n).map(|i| lowering.unit_vector(i)).collect(),
    };
    let phi_kinematic = phi_kinematic?;
    Ok(Model {
        item: item.clone(),
        coordinates: coordinates.clone(),
        parameters: fields.parameters(),
        lagrangian,
        kinematic,
        variational,
        phi_lagrangian: phi_lagrangian?,
        // the paper sets φ_{D_V} := φ_{D_K}
        phi_variational: phi_variational?.or_else(|| phi_kinematic.clone()),
        phi_kinematic,
        observe: observe?.unwrap_or_default(),
        graph: lowering.graph,
    })
}

/// A statement that may use the `let`s before it.
trait AfterLets {
    /// How many `let`s stand before.
    fn lets_before(&self) -> usize;
}

macro_rules! after_lets {
    ($($part:ty),*) => {
        $(impl AfterLets for $part {
            fn lets_before(&self) -> usize {
                self.lets_before
            }
        })*
    };
}

after_lets!(Scalar, Kinematic, Directions, Branch, Observe);

impl AfterLets for Map {
    fn lets_before(&self) -> usize {
        // a map uses no `let`; it knows them all to say so
        usize::MAX
    }
}

/// The scopes of the statements.
struct Scopes {
    all: Scope,
    outer: usize,
}

impl Scopes {
    fn part<'d, P: AfterLets, T>(
        &self,
        lowering: &mut Lowering<'d>,
        part: &Part<P>,
        lower: impl FnOnce(&mut Lowering<'d>, &P) -> Result<T, Reported>,
    ) -> Result<Option<T>, Reported> {
        match part {
            Part::Absent => Ok(None),
            Part::Broken(reported) => Err(*reported),
            Part::Given(part) => {
                lowering.scope = self.all.clone();
                lowering
                    .scope
                    .truncate(self.outer.saturating_add(part.lets_before()));
                lower(lowering, part).map(Some)
            }
        }
    }
}

impl Lowering<'_> {
    fn lagrangian(&mut self, lagrangian: &Scalar) -> Lowered {
        self.below_acceleration(
            &lagrangian.value,
            "an acceleration comes in here; expected a Lagrangian of positions and velocities, L(q, v)",
        )
    }

    /// An expression of positions and velocities.
    fn below_acceleration(&mut self, expr: &Expr, message: &str) -> Lowered {
        self.origins.clear();
        let value = self.expr(expr)?;
        if self.graph.order(value).is_none_or(|order| order < 2) {
            return Ok(value);
        }
        let origin = self
            .origins
            .iter()
            .find(|origin| origin.order == 2)
            .map(|origin| origin.tokens.clone());
        Err(match origin {
            Some(origin) => self.errors.at(origin, message),
            None => self.errors.at(expr, message),
        })
    }

    fn kinematic(&mut self, kinematic: &Kinematic) -> Result<Vec<(NodeId, usize)>, Reported> {
        let rows: Vec<_> = kinematic.rows.iter().map(|row| self.row(row)).collect();
        rows.into_iter().collect()
    }

    fn row(&mut self, row: &Expr) -> Result<(NodeId, usize), Reported> {
        let value = self.expr(row)?;
        match self.graph.order(value) {
            Some(0) => Err(self.errors.at(
                row,
                "expected a velocity or an acceleration in a kinematic constraint; \
                 constraints of positions alone (holonomic ones) are not supported yet",
            )),
            Some(order) => Ok((value, order)),
            None => Err(self.errors.at(
                row,
                "expected a velocity or an acceleration in a kinematic constraint; this does not depend on the motion",
            )),
        }
    }

    fn directions(
        &mut self,
        directions: &Directions,
        checked: Result<(), Reported>,
    ) -> Result<Vec<Vec<NodeId>>, Reported> {
        let fields = directions.fields.iter().map(|field| self.entries(field));
        let fields: Vec<_> = fields.collect();
        let fields: Vec<_> = fields.into_iter().collect::<Result<_, _>>()?;
        checked?;
        // the annihilator also finds out whether they are independent
        let annihilated = annihilator(&mut self.graph, &fields, self.coordinates.len());
        let at = |row: usize| directions.fields.get(row);
        match (directions.side, annihilated) {
            (side, Err(Defect::Dependent(row))) => {
                let noun = if side == Side::Forces { "forces" } else { "fields" };
                let message = format!("expected independent {noun}; this one is zero or a combination of the others");
                Err(self.errors.at(at(row), message))
            }
            (Side::Variational, _) => Ok(fields),
            (Side::Forces, Ok(fields)) => Ok(fields),
            (Side::Forces, Err(Defect::NoPivot(row))) => Err(self.errors.at(
                at(row),
                "expected a component that is a nonzero constant, so that the virtual displacements on which this force \
                 does no work can be found; without one, give these displacements: `variational = [(…), …];`",
            )),
        }
    }

    fn branch(&mut self, branch: &Branch) -> Result<Vec<Option<NodeId>>, Reported> {
        let factors = branch.factors.iter().map(|factor| match factor {
            Ok(Some(factor)) => self.factor(factor).map(Some),
            Ok(None) => Ok(None),
            Err(reported) => Err(*reported),
        });
        // collected twice, so that the first mistake does not hide the others
        let factors: Vec<_> = factors.collect();
        factors.into_iter().collect()
    }

    fn factor(&mut self, factor: &Expr) -> Lowered {
        let value = self.below_acceleration(
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

    fn observe(&mut self, observe: &Observe) -> Result<Vec<(Ident, NodeId)>, Reported> {
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
                Some(Binding::Let(value)) => *value,
                Some(other) => {
                    let message = format!("expected the name of a `let`, but `{name}` is {}", other.kind());
                    Err(self.errors.at(name, message))
                }
                None => {
                    let text = name.to_string();
                    let message = if self.later.contains(&text) {
                        format!("`{text}` is defined further down; expected its `let` before this use")
                    } else {
                        let lets = self.scope.names(|binding| matches!(binding, Binding::Let(_)));
                        format!("no `let` is called `{text}`{}", did_you_mean(&text, lets))
                    };
                    Err(self.errors.at(name, message))
                }
            };
            seen.push(name);
            observed.push(value.map(|value| (name.clone(), value)));
        }
        observed.into_iter().collect()
    }

    fn unit_vector(&mut self, index: usize) -> Vec<NodeId> {
        let (zero, one) = (self.graph.constant(0.0), self.graph.constant(1.0));
        (0..self.coordinates.len())
            .map(|i| if i == index { one } else { zero })
            .collect()
    }
}
