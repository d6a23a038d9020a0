//! The nodes of a run as rows of a table.

use dsocs_core::{AnyNode, Declaration, NearlySingular, Regularity, RunError, Shape, Unresolved};

use super::Plan;
use super::description::Description;

/// One node of a run. Observed expressions and multipliers are computed only when the row is written: few
/// nodes of a long run are.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    /// The node.
    pub node: AnyNode<'a>,
    /// The declaration, with the values that its parameters have at the node.
    pub declaration: Declaration<'a>,
    /// The power of the constraint force and, at some nodes, the sum of the absolute values of the energy's
    /// terms; only where the energy can change by forces of constraints on positions and velocities alone,
    /// in steps of a fixed length.
    pub balance: Option<(f64, Option<f64>)>,
    /// Whether the energy can change by forces of constraints on positions and velocities alone.
    pub is_closed: bool,
    /// Whether the energy may also change by external forces, by terms that depend on time, or by inputs, in
    /// steps of a fixed length.
    pub is_open: bool,
    /// The smallest singular values of `D₃` and `D₁` at the node, in a certified run.
    pub regularity: Option<Regularity>,
    /// The steps so far that did not resolve a jump.
    pub unresolved: Option<Unresolved>,
    /// The steps so far in which the equations were nearly singular.
    pub nearly_singular: Option<NearlySingular>,
    /// The estimated error of each coordinate, if it is asked for.
    pub errors: &'a [f64],
    /// The uncertainty of the reference motion from which the errors are computed.
    pub uncertainty: f64,
    /// The reason why the errors are NaN from here on: the continuous motion cannot be computed so far.
    pub unknown: Option<&'a RunError>,
}

impl<'a> Row<'a> {
    /// The row of a node of another run, made by steps of a fixed length. `is_closed` means that the energy
    /// can change by forces of constraints on positions and velocities only ([`is_closed`]).
    #[must_use]
    pub fn of_step(node: AnyNode<'a>, declaration: Declaration<'a>, is_closed: bool) -> Self {
        Self {
            balance: is_closed.then(|| balance(&declaration, &node)),
            is_closed,
            is_open: !is_closed,
            ..Self::of(node, declaration)
        }
    }

    /// The row of a node, without regularity and errors.
    pub(super) fn of(node: AnyNode<'a>, declaration: Declaration<'a>) -> Self {
        Self {
            node,
            declaration,
            balance: None,
            is_closed: false,
            is_open: false,
            regularity: None,
            unresolved: None,
            nearly_singular: None,
            errors: &[],
            uncertainty: 0.0,
            unknown: None,
        }
    }

    /// Replaces the content of `values` by the value of each column, in the order of [`columns`].
    pub fn write(&self, values: &mut Vec<f64>) {
        let Self {
            node, declaration, ..
        } = self;
        values.clear();
        values.push(node.t);
        let shape = declaration.shape();
        values.extend(node.q);
        values.extend(shape.moving(node.v));
        values.extend(shape.moving(node.force));
        values.push(node.energy);
        let begin = values.len();
        values.resize(begin + declaration.shape().observables.len(), 0.0);
        declaration.observe(node.point(), &mut values[begin..]);
        values.extend(declaration.multipliers(node));
        if let Some(at) = self.regularity {
            values.extend([at.forward, at.backward]);
        }
        values.extend(self.errors);
    }
}

/// Whether the energy of a system with constant inputs can change by forces of constraints on positions and
/// velocities only.
#[must_use]
pub fn is_closed(shape: &Shape) -> bool {
    !shape.external_forces && !shape.depends_on_time && shape.kinematic == 0
}

/// The energy's terms are summed at nodes whose number is a multiple of this.
const TERMS_EVERY: u64 = 16;

/// The power of a node's constraint force and, at some nodes, the sum of the energy's terms.
#[inline]
pub(super) fn balance(declaration: &Declaration<'_>, node: &AnyNode<'_>) -> (f64, Option<f64>) {
    // some nodes are enough for their mean
    let is_examined = node.index.is_multiple_of(TERMS_EVERY);
    (
        constraint_power(node),
        is_examined.then(|| energy_terms(declaration, node)),
    )
}

/// The power of a node's constraint force.
#[inline]
pub(crate) fn constraint_power(node: &AnyNode<'_>) -> f64 {
    node.force.iter().zip(node.v).map(|(force, v)| force * v).sum()
}

/// The sum of the sizes of the energy's terms at a node.
#[inline(never)]
pub(crate) fn energy_terms(declaration: &Declaration<'_>, node: &AnyNode<'_>) -> f64 {
    node.energy.abs() + 2.0 * declaration.lagrangian(node.t, node.q, node.v).abs()
}

/// A column of a run's table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// The name.
    pub name: String,
    /// The unit, if the declaration gives it.
    pub unit: Option<String>,
}

impl Column {
    /// A column with a unit, if there is one.
    fn new(name: impl Into<String>, unit: Option<impl Into<String>>) -> Self {
        Self {
            name: name.into(),
            unit: unit.map(Into::into),
        }
    }
}

/// The columns of a run: time, position, velocity, force, energy, observed expressions, multipliers; of a rotation the four numbers of its quaternion, and three of
/// velocity and force in the frame of its body. In a certified run follow the smallest singular values of `D₃` and `D₁`; where errors are estimated, one for each coordinate.
#[must_use]
pub fn columns(description: &Description, plan: &Plan) -> Vec<Column> {
    let coordinates = || description.coordinates.iter();
    let mut columns = vec![Column::new("t", Some("s"))];
    columns.extend(coordinates().map(|q| Column::new(&*q.name, q.unit())));
    let moving = || {
        let all = coordinates().enumerate();
        all.filter(|(place, _)| !description.rotations.contains(place))
            .map(|(_, q)| q)
    };
    columns.extend(moving().map(|q| Column::new(format!("v_{}", q.name), q.unit().map(rate))));
    columns.extend(moving().map(|q| Column::new(format!("force_{}", q.name), q.unit().map(force))));
    // a coordinate without a unit has none in J either
    let turns = |place: usize| {
        description
            .rotations
            .iter()
            .any(|&first| (first..first + 4).contains(&place))
    };
    let mut own = coordinates().enumerate().filter(|(place, _)| !turns(*place));
    let has_units = coordinates().any(|q| q.unit().is_some()) && own.all(|(_, q)| q.unit().is_some());
    columns.push(Column::new("energy", has_units.then_some("J")));
    columns.extend(
        description
            .observables
            .iter()
            .map(|x| Column::new(&*x.name, x.unit())),
    );
    columns.extend((0..description.forms).map(|form| Column::new(format!("lambda_{form}"), None::<&str>)));
    if plan.certify {
        let names = ["regularity_forward", "regularity_backward"];
        columns.extend(names.map(|name| Column::new(name, None::<&str>)));
    }
    if plan.estimate {
        columns.extend(coordinates().map(|q| Column::new(format!("error_{}", q.name), q.unit())));
    }
    columns
}

/// The unit of the rate of a coordinate.
fn rate(unit: &str) -> String {
    format!("{unit}/s")
}

/// The unit of the generalized force along a coordinate, whose work is in J.
fn force(unit: &str) -> String {
    match unit {
        "rad" => "N m".to_owned(),
        "m" => "N".to_owned(),
        "1" => "J".to_owned(),
        unit => format!("J/{unit}"),
    }
}
