//! The declaration's expressions → nodes of one graph: names resolved, the order of each expression known.

mod builtin;
mod call;
mod closed;
mod constraints;
mod differentiated;
mod discrete;
mod expr;
mod function;
mod index;
mod map;
mod multiples;
mod shape;
mod unused;
mod wrong;

use proc_macro2::{Ident, TokenStream};
use quote::ToTokens;
use syn::{Expr, ItemStruct};

use crate::ast::{
    Branch, Constraints, Coordinates, Declaration, Directions, Group, Map, Observe, Part, Scalar,
};
use crate::errors::{Errors, Reported};
use crate::graph::{Graph, NodeId};
use crate::input::Fields;
use crate::mechanics;
use crate::model::{Docs, Kind, Model, ParameterField, Row};
use crate::names::{Binding, Scope};
use crate::nearest::did_you_mean;
use crate::syntax::{bare, first_paragraph, plain_name};

pub(crate) use builtin::Builtin;

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
    /// What a discrete expression is made of; `Some` while one is lowered.
    discrete: Option<discrete::Nodes>,
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
    let mut lowering = Lowering::new(declaration, groups, coordinates, fields, errors);
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
    let mut rows = |part, kind| {
        scopes.part(&mut lowering, part, |lowering, constraints| {
            lowering.constraints(constraints, kind)
        })
    };
    let holonomic = rows(&declaration.holonomic, Kind::Holonomic);
    let nonholonomic = rows(&declaration.nonholonomic, Kind::Nonholonomic);
    let kinematic = rows(&declaration.kinematic, Kind::Kinematic);
    let directions = scopes.part(&mut lowering, &declaration.directions, Lowering::fields);
    let branch = scopes.part(&mut lowering, &declaration.branch, Lowering::branch);
    let observe = scopes.part(&mut lowering, &declaration.observe, Lowering::observe);
    let maps = scopes.maps(&mut lowering, declaration, lagrangian);
    let phi_variational = scopes.part(&mut lowering, &declaration.phi_variational, Lowering::triple);
    let external_forces = scopes.part(
        &mut lowering,
        &declaration.external_forces,
        Lowering::external_forces,
    );
    let discrete_lagrangian = scopes.part(
        &mut lowering,
        &declaration.discrete_lagrangian,
        |lowering, value| lowering.discrete_lagrangian(&value.value, &maps),
    );
    let discrete_kinematic = scopes.part(
        &mut lowering,
        &declaration.discrete_kinematic,
        |lowering, rows| lowering.discrete_kinematic(rows, &maps),
    );

    let lagrangian = lagrangian?.ok_or_else(|| errors.missing("lagrangian = …;"));
    checked?;
    let lagrangian = lagrangian?;
    let (holonomic, nonholonomic) = (holonomic?.unwrap_or_default(), nonholonomic?.unwrap_or_default());
    let mut kinematic = kinematic?.unwrap_or_default();
    for (row, factor) in kinematic.iter_mut().zip(branch?.unwrap_or_default()) {
        row.divide = factor;
    }
    for (row, discrete) in kinematic.iter_mut().zip(discrete_kinematic?.unwrap_or_default()) {
        row.discrete = Some(discrete);
    }
    third_order(declaration, &kinematic, errors)?;
    let constraints = [holonomic, nonholonomic, kinematic].concat();
    multiples::check(&constraints, &lowering.graph, errors)?;
    let (phi_lagrangian, phi_kinematic) = (maps.0?, maps.1?);
    // the paper sets φ_{D_V} := φ_{D_K}
    let phi_variational = match phi_variational? {
        Some(own) => own,
        None => phi_kinematic.clone(),
    };
    let elsewhere = phi_variational.is_some();
    let (forms, displacements) = lowering.displacements(declaration, &constraints, directions?, elsewhere)?;
    let parameters = fields.parameters();
    let mut graph = lowering.graph;
    graph.set_numbers(parameters.iter().map(ParameterField::read));
    let observe = observe?.unwrap_or_default();
    let mut model = Model {
        warnings: Vec::new(),
        docs: docs(declaration, item, &observe),
        core: declaration.core.given().cloned(),
        item: item.clone(),
        coordinates: coordinates.clone(),
        parameters,
        lagrangian,
        constraints,
        forms,
        displacements,
        external_forces: external_forces?.unwrap_or_default(),
        discrete_lagrangian: discrete_lagrangian?,
        phi_lagrangian,
        phi_variational,
        phi_kinematic,
        observe,
        graph,
    };
    check_factors(declaration, &model, errors)?;
    model.warnings = unused::warnings(declaration, &model);
    model.warnings.extend(differentiated::warnings(&model));
    Ok(model)
}

/// Refuses beside constraints of third order what is for those of second order.
fn third_order(declaration: &Declaration, kinematic: &[Row], errors: &Errors) -> Result<(), Reported> {
    if kinematic.iter().all(|row| row.order < 3) {
        return Ok(());
    }
    if let Some(discrete) = declaration.discrete_kinematic.given() {
        return Err(errors.at(
            &discrete.keyword,
            "a constraint here is of third order, and is imposed on four nodes by the map of `dddot`; expected no \
             `discrete_kinematic`, which knows three",
        ));
    }
    if let Some(map) = declaration.phi_kinematic.given()
        && kinematic.iter().all(|row| row.order == 3)
    {
        return Err(errors.at(
            &map.keyword,
            "all constraints here are of third order, which a map of four nodes discretizes; expected no `phi_kinematic`, which is for \
             those of second order (`phi_variational` is where fields and forms are taken)",
        ));
    }
    let mut factors = declaration
        .branch
        .given()
        .into_iter()
        .flat_map(|branch| &branch.factors);
    let mut wrong = Ok(());
    for row in kinematic {
        if let Some(Ok(Some(factor))) = factors.next()
            && row.order == 3
        {
            wrong = Err(errors.at(
                &factor.value,
                "expected `_`: the constraint is of third order, and factors are divided out of those of second order",
            ));
        }
    }
    wrong
}

/// Refuses factors that do not divide their constraints.
fn check_factors(declaration: &Declaration, model: &Model, errors: &Errors) -> Result<(), Reported> {
    let Some(branch) = declaration.branch.given() else {
        return Ok(());
    };
    let first = model.constraints.len() - model.count(Kind::Kinematic);
    let mut wrong = Ok(());
    for (place, factor) in branch.factors.iter().enumerate() {
        if let Ok(Some(factor)) = factor
            && mechanics::is_no_factor(model, first + place)
        {
            let mut message = "expected a factor of the kinematic constraint: where this is zero and the other equations hold, the \
                               constraint is not zero"
                .to_owned();
            if lacks_power(model, first + place) {
                message += "; external forces do work there: their power belongs into the constraint";
            }
            wrong = Err(errors.at(&factor.value, message));
        }
    }
    wrong
}

/// Whether a factor is none for the work of external forces alone: without them it divides its constraint.
fn lacks_power(model: &Model, place: usize) -> bool {
    if model.external_forces.is_empty() {
        return false;
    }
    let mut free = model.clone();
    free.external_forces.clear();
    !mechanics::is_no_factor(&free, place)
}

/// What the user says for people.
fn docs(declaration: &Declaration, item: &ItemStruct, observe: &[(Ident, NodeId)]) -> Docs {
    let groups = declaration.coordinates.given().into_iter();
    let groups = groups.flat_map(|coordinates| &coordinates.groups);
    let of_let = |name: &Ident| {
        let binding = declaration.lets.iter().find(|binding| binding.name == *name);
        binding.map_or_else(String::new, |binding| binding.doc.clone())
    };
    Docs {
        system: first_paragraph(&item.attrs),
        coordinates: groups
            .flat_map(|group| vec![group.doc.clone(); group.length.unwrap_or(1)])
            .collect(),
        observe: observe.iter().map(|(name, _)| of_let(name)).collect(),
    }
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

after_lets!(Scalar, Constraints, Directions, Branch, Observe);

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

impl Scopes {
    /// The maps of `L_d` and of the kinematic constraints.
    fn maps(
        &self,
        lowering: &mut Lowering<'_>,
        declaration: &Declaration,
        lagrangian: Result<Option<NodeId>, Reported>,
    ) -> discrete::Maps {
        let pairs = self.part(lowering, &declaration.phi_lagrangian, Lowering::pairs);
        let triple = self.part(lowering, &declaration.phi_kinematic, Lowering::triple);
        let pairs = pairs.map(|map| match (map, lagrangian) {
            (Some(declared), _) => declared,
            (None, Ok(Some(lagrangian))) => lowering.default_pairs(declaration, lagrangian),
            (None, _) => lowering.paper_pairs(),
        });
        (pairs, triple.map(Option::flatten))
    }
}

impl<'d> Lowering<'d> {
    /// The state before the first `let`.
    fn new(
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
            later: declaration
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
        lowering
    }
}

impl Lowering<'_> {
    fn lagrangian(&mut self, lagrangian: &Scalar) -> Lowered {
        self.below(
            2,
            &lagrangian.value,
            "an acceleration comes in here; expected a Lagrangian of positions and velocities, L(q, v)",
        )
    }

    /// The components of the external forces.
    fn external_forces(&mut self, forces: &Scalar) -> Result<Vec<NodeId>, Reported> {
        if let Expr::Array(list) = bare(&forces.value)
            && self.groups.iter().all(|group| group.length.is_none())
        {
            return Err(self.errors.at(
                list,
                "expected one tuple with a component for each coordinate, `external_forces = (f1, f2);`: forces that act together are \
                 added up",
            ));
        }
        if let Expr::Call(call) = bare(&forces.value)
            && plain_name(&call.func).is_some_and(|name| name == "each")
        {
            return Err(self.errors.at(
                call,
                "expected one component for each coordinate, in the shape of the coordinates; those of an array are written `|i| …`",
            ));
        }
        self.origins.clear();
        let components = self.entries(&forces.value)?;
        for &component in &components {
            if self.graph.order(component).is_some_and(|order| order > 1) {
                let origin = self.origins.iter().find(|origin| origin.order > 1);
                let order = origin.map_or(2, |origin| origin.order);
                let tokens =
                    origin.map_or_else(|| forces.value.to_token_stream(), |origin| origin.tokens.clone());
                return Err(self.errors.at(
                    tokens,
                    of_jerk(
                        "an acceleration comes in here; expected forces of time, positions and velocities, f(t, q, v)",
                        order,
                    ),
                ));
            }
        }
        Ok(components)
    }

    /// An expression of derivatives below an order.
    fn below(&mut self, limit: usize, expr: &Expr, message: &str) -> Lowered {
        self.origins.clear();
        let value = self.expr(expr)?;
        if self.graph.order(value).is_none_or(|order| order < limit) {
            return Ok(value);
        }
        let (value, _) = self.settled(value);
        if self.graph.order(value).is_none_or(|order| order < limit) {
            return Ok(value);
        }
        let origin = self.origins.iter().find(|origin| origin.order >= limit);
        let order = origin.map_or(limit, |origin| origin.order);
        let tokens = origin.map_or_else(|| expr.to_token_stream(), |origin| origin.tokens.clone());
        Err(self.errors.at(tokens, of_jerk(message, order)))
    }

    /// Refuses a jerk, which only kinematic constraints may have.
    fn without_jerk(&self, value: NodeId, tokens: impl ToTokens, expected: &str) -> Lowered {
        if self.graph.order(value) != Some(3) {
            return Ok(value);
        }
        let origin = self.origins.iter().find(|origin| origin.order > 2);
        let tokens = origin.map_or_else(|| tokens.into_token_stream(), |origin| origin.tokens.clone());
        Err(self.errors.at(
            tokens,
            format!("a jerk, a third derivative, comes in here; expected {expected}: jerks stand in `kinematic = …;` alone"),
        ))
    }

    fn branch(&mut self, branch: &Branch) -> Result<Vec<Option<NodeId>>, Reported> {
        let factors = branch.factors.iter().map(|factor| match factor {
            Ok(Some(factor)) => {
                let factors = self.each(std::slice::from_ref(factor), Self::factor)?;
                Ok(factors.into_iter().next())
            }
            Ok(None) => Ok(None),
            Err(reported) => Err(*reported),
        });
        // collected twice, so that the first mistake does not hide the others
        let factors: Vec<_> = factors.collect();
        factors.into_iter().collect()
    }

    fn factor(&mut self, factor: &Expr) -> Lowered {
        let value = self.below(
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
                Some(Binding::Let(value)) => (*value).and_then(|value| {
                    self.origins.clear();
                    let expected =
                        "what a node knows, an expression of time, positions, velocities and accelerations";
                    self.without_jerk(value, name, expected)
                }),
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
}

/// What is said about an acceleration, said about a jerk where it is one.
fn of_jerk(message: &str, order: usize) -> String {
    if order < 3 {
        return message.to_owned();
    }
    message
        .replacen("an acceleration comes", "a jerk, a third derivative, comes", 1)
        .replacen("with accelerations it", "with jerks it", 1)
}
