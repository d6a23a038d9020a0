//! The whole declaration: its statements, each in its scope, then the checks between them.

use proc_macro2::Ident;
use syn::ItemStruct;

use crate::check;
use crate::graph::NodeId;
use crate::lower::lowering::{Lowering, Maps};
use crate::lower::names::unused;
use crate::lower::names::{Binding, Scope};
use crate::lower::statements::Observed;
use crate::lower::statements::differentiated;
use crate::lower::statements::multiples;
use crate::lower::statements::reduction;
use crate::lower::values::rotations;
use crate::mechanics;
use crate::mistakes::errors::{Errors, Reported};
use crate::model::{Docs, Kind, Model, Row};
use crate::syntax::ast::{
    Branch, Constraints, Coordinates, Declaration, Directions, Map, Observe, Scalar, Statement,
};
use crate::syntax::first_paragraph;
use crate::syntax::input::{Fields, ParameterField};

/// The model of a declaration whose syntax has been checked, with the result `checked`.
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
        Statement::Given(coordinates) => coordinates,
        Statement::Malformed(reported) => return Err(*reported),
        Statement::Absent => return Err(errors.missing("coordinates(x, y);")),
    };
    let mut lowering = Lowering::new(declaration, groups, coordinates, fields, errors);
    let outer = lowering.scope.len();
    lets(&mut lowering, declaration);
    let scopes = Scopes {
        all: lowering.scope.clone(),
        outer,
    };

    // every part is lowered before the first error is returned, so that all mistakes are reported
    let lagrangian = scopes.lower(&mut lowering, &declaration.lagrangian, Lowering::lagrangian);
    let mut rows = |part, kind| {
        scopes.lower(&mut lowering, part, |lowering, constraints| {
            lowering.constraints(constraints, kind)
        })
    };
    let holonomic = rows(&declaration.holonomic, Kind::Holonomic);
    let nonholonomic = rows(&declaration.nonholonomic, Kind::Nonholonomic);
    let kinematic = rows(&declaration.kinematic, Kind::Kinematic);
    let directions = scopes.lower(&mut lowering, &declaration.directions, Lowering::fields);
    let branch = scopes.lower(&mut lowering, &declaration.branch, Lowering::branch);
    let observe = scopes.lower(&mut lowering, &declaration.observe, Lowering::observe);
    let maps = scopes.maps(&mut lowering, declaration, lagrangian);
    let phi_variational = scopes.lower(&mut lowering, &declaration.phi_variational, Lowering::triple);
    let external_forces = scopes.lower(
        &mut lowering,
        &declaration.external_forces,
        Lowering::external_forces,
    );
    let discrete_lagrangian = scopes.lower(
        &mut lowering,
        &declaration.discrete_lagrangian,
        |lowering, value| lowering.discrete_lagrangian(&value.value, &maps),
    );
    let discrete_kinematic = scopes.lower(
        &mut lowering,
        &declaration.discrete_kinematic,
        |lowering, rows| lowering.discrete_kinematic(rows, &maps),
    );

    let counted = check::check_counts(declaration, lowering.rows, errors);
    let lagrangian = lagrangian?.ok_or_else(|| errors.missing("lagrangian = …;"));
    checked.and(counted)?;
    let lagrangian = lowering.with_particles_at_rest(lagrangian?);
    let (holonomic, nonholonomic) = (holonomic?.unwrap_or_default(), nonholonomic?.unwrap_or_default());
    let mut kinematic = kinematic?.unwrap_or_default();
    set_factors(&mut kinematic, &branch?.unwrap_or_default());
    set_discrete_rows(&mut kinematic, discrete_kinematic?.unwrap_or_default(), errors)?;
    check_third_order(declaration, &kinematic, errors)?;
    let written: Vec<usize> = kinematic.iter().map(Vec::len).collect();
    rotations::check(declaration, &kinematic.concat(), errors)?;
    let constraints = [holonomic, nonholonomic, kinematic].concat().concat();
    multiples::check(&constraints, &lowering.graph, errors)?;
    let (phi_lagrangian, phi_kinematic) = (maps.0?, maps.1?);
    // the paper sets φ_{D_V} := φ_{D_K}
    let phi_variational = match phi_variational? {
        Some(own) => own,
        None => phi_kinematic.clone(),
    };
    let off_node = phi_variational.is_some();
    let (forms, displacements) = lowering.displacements(declaration, &constraints, directions?, off_node)?;
    let parameters = fields.parameters();
    let mut graph = lowering.graph;
    graph.set_numbers(parameters.iter().map(ParameterField::read));
    let observe = observe?.unwrap_or_default();
    let docs = docs(declaration, item, &observe);
    let mut model = Model {
        warnings: Vec::new(),
        docs,
        core: declaration.core.given().cloned(),
        text: String::new(),
        item: item.clone(),
        coordinates: coordinates.clone(),
        parameters,
        others: fields.others(),
        lagrangian,
        constraints,
        forms,
        displacements,
        external_forces: external_forces?.unwrap_or_default(),
        discrete_lagrangian: discrete_lagrangian?,
        phi_lagrangian,
        phi_variational,
        phi_kinematic,
        observe: observe
            .into_iter()
            .map(|observed| (observed.name, observed.value))
            .collect(),
        differentiated: lowering.differentiated,
        graph,
    };
    check_factors(declaration, &model, &written, errors)?;
    reduction::check(declaration, groups, &model, errors)?;
    model.warnings = unused::warnings(declaration, &model);
    model.warnings.extend(differentiated::warnings(&model));
    Ok(model)
}

/// Lowers the `let`s, in order.
fn lets(lowering: &mut Lowering<'_>, declaration: &Declaration) {
    let used = unused::used_names(declaration);
    for binding in &declaration.lets {
        lowering.derivatives.clear();
        let differentiated = lowering.differentiated.len();
        let value = match &binding.value {
            Ok(value) => lowering.binding(value),
            Err(reported) => Binding::Let(Err(*reported)),
        };
        // derivatives in a `let` that nothing uses do not belong to the model
        if !used.contains(&binding.name.to_string()) {
            lowering.differentiated.truncate(differentiated);
        }
        lowering.scope.push(&binding.name, value);
    }
}

/// Gives each kinematic constraint its factor; the rows of a vector share one.
fn set_factors(kinematic: &mut [Vec<Row>], factors: &[Option<NodeId>]) {
    for (rows, factor) in kinematic.iter_mut().zip(factors) {
        for row in rows {
            row.divide = *factor;
        }
    }
}

/// Gives the kinematic constraints their discrete rows.
fn set_discrete_rows(
    kinematic: &mut [Vec<Row>],
    discrete: Vec<Vec<NodeId>>,
    errors: &Errors,
) -> Result<(), Reported> {
    for (rows, discrete) in kinematic.iter_mut().zip(discrete) {
        if let Some(row) = rows.first()
            && rows.len() != discrete.len()
        {
            let message = format!(
                "expected as many components as those of the discrete row in its place, {}, found {}",
                discrete.len(),
                rows.len()
            );
            return Err(errors.at(&row.tokens, message));
        }
        for (row, discrete) in rows.iter_mut().zip(discrete) {
            row.discrete = Some(discrete);
        }
    }
    Ok(())
}

/// Refuses statements that are for second order only, if a constraint is of third order.
fn check_third_order(
    declaration: &Declaration,
    kinematic: &[Vec<Row>],
    errors: &Errors,
) -> Result<(), Reported> {
    if kinematic.iter().flatten().all(|row| row.order < 3) {
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
        && kinematic.iter().flatten().all(|row| row.order == 3)
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
    for rows in kinematic {
        if let Some(Ok(Some(factor))) = factors.next()
            && rows.iter().any(|row| row.order == 3)
        {
            wrong = Err(errors.at(
                &factor.value,
                "expected `_`: the constraint is of third order, and factors are divided out of those of second order",
            ));
        }
    }
    wrong
}

/// Refuses factors that do not divide their constraints. `written` has, for each kinematic constraint, the
/// number of its rows.
fn check_factors(
    declaration: &Declaration,
    model: &Model,
    written: &[usize],
    errors: &Errors,
) -> Result<(), Reported> {
    let Some(branch) = declaration.branch.given() else {
        return Ok(());
    };
    let mut first = model.constraints.len() - model.count(Kind::Kinematic);
    let mut wrong = Ok(());
    for (factor, &count) in branch.factors.iter().zip(written) {
        let mut rows = first..first + count;
        first += count;
        if let Ok(Some(factor)) = factor
            && let Some(place) = rows.find(|&place| mechanics::is_no_factor(model, place))
        {
            let mut message = "expected a factor of the kinematic constraint: where this is zero and the other equations hold, the \
                               constraint is not zero"
                .to_owned();
            if lacks_power(model, place) {
                message += "; external forces do work there: their power belongs into the constraint";
            }
            wrong = Err(errors.at(&factor.value, message));
        }
    }
    wrong
}

/// Whether a factor fails only because of the power of external forces: without them it divides its
/// constraint.
fn lacks_power(model: &Model, place: usize) -> bool {
    if model.external_forces.is_empty() {
        return false;
    }
    let mut free = model.clone();
    free.external_forces.clear();
    !mechanics::is_no_factor(&free, place)
}

/// The documentation in a declaration.
fn docs(declaration: &Declaration, item: &ItemStruct, observe: &[Observed]) -> Docs {
    let groups = declaration.coordinates.given().into_iter();
    let groups = groups.flat_map(|coordinates| &coordinates.groups);
    let of_let = |name: &Ident| {
        let binding = declaration.lets.iter().find(|binding| binding.name == *name);
        binding.map_or_else(String::new, |binding| binding.doc.clone())
    };
    Docs {
        system: first_paragraph(&item.attrs),
        coordinates: groups
            .flat_map(|group| vec![group.doc.clone(); group.places()])
            .collect(),
        observe: observe.iter().map(|observed| of_let(&observed.of)).collect(),
    }
}

/// A statement that may use the `let`s before it.
trait AfterLets {
    /// The number of `let`s before the statement.
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
        // a map may use no `let`, but knows their names for its error messages
        usize::MAX
    }
}

/// The scope after all `let`s, from which that of each statement is taken.
struct Scopes {
    all: Scope,
    outer: usize,
}

impl Scopes {
    fn lower<'d, P: AfterLets, T>(
        &self,
        lowering: &mut Lowering<'d>,
        statement: &Statement<P>,
        lower: impl FnOnce(&mut Lowering<'d>, &P) -> Result<T, Reported>,
    ) -> Result<Option<T>, Reported> {
        match statement {
            Statement::Absent => Ok(None),
            Statement::Malformed(reported) => Err(*reported),
            Statement::Given(statement) => {
                lowering.scope = self.all.clone();
                lowering
                    .scope
                    .truncate(self.outer.saturating_add(statement.lets_before()));
                lower(lowering, statement).map(Some)
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
    ) -> Maps {
        let pairs = self.lower(lowering, &declaration.phi_lagrangian, Lowering::pairs);
        let triple = self.lower(lowering, &declaration.phi_kinematic, Lowering::triple);
        let pairs = pairs.map(|map| match (map, lagrangian) {
            (Some(declared), _) => declared,
            (None, Ok(Some(lagrangian))) => lowering.default_pairs(declaration, lagrangian),
            (None, _) => lowering.paper_pairs(),
        });
        (pairs, triple.map(Option::flatten))
    }
}
