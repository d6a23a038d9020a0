//! The nodes of a run as rows of a table.

use dsocs_core::{AnyNode, Declaration, NearlySingular, OwnedNode, Regularity, Run, RunError, Unresolved};

use super::Plan;
use super::description::Description;

/// One node of a run. Observed expressions and multipliers are computed only when the row is written: few
/// nodes of a long run are.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    /// The node.
    pub node: AnyNode<'a>,
    /// The node before, if there is one: with steps the other end of the step.
    pub before: Option<&'a OwnedNode>,
    /// The declaration, with the values that its parameters have at the node.
    pub declaration: Declaration<'a>,
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
    /// The row of a node, without the one before, regularity and errors.
    #[must_use]
    pub fn of(node: AnyNode<'a>, declaration: Declaration<'a>) -> Self {
        Self {
            node,
            declaration,
            before: None,
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

/// The last two nodes that were taken of a run, in two places that change their roles: neither is copied.
pub struct LastNodes {
    /// Each at its number modulo two.
    nodes: [OwnedNode; 2],
    /// The number of nodes taken.
    taken: usize,
}

impl LastNodes {
    /// No nodes yet, for a number of coordinates.
    #[must_use]
    pub fn new(coordinates: usize) -> Self {
        Self {
            nodes: [OwnedNode::new(coordinates), OwnedNode::new(coordinates)],
            taken: 0,
        }
    }

    /// Takes the current node of a run; returns the one taken before, if there is one, and it.
    #[inline]
    pub fn take(&mut self, run: &dyn Run) -> (Option<&OwnedNode>, AnyNode<'_>) {
        let [even, odd] = &mut self.nodes;
        let (before, node) = if self.taken.is_multiple_of(2) {
            (odd, even)
        } else {
            (even, odd)
        };
        run.write_node(node.as_node_mut());
        self.taken += 1;
        ((self.taken > 1).then_some(&*before), node.any())
    }

    /// The number of nodes taken.
    #[must_use]
    pub fn taken(&self) -> usize {
        self.taken
    }
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
