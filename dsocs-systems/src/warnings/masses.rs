//! Detects a velocity that jumps since an input changes a mass, and tells it from a force that changes too fast.
//!
//! At a change of an input the momentum is kept. So the velocity jumps where the momenta depend on the input; where a row for velocities does, too.

use dsocs_core::geometry::{legendre_with, velocity_after};
use dsocs_core::{AnyNode, Declaration, OwnedNode};

use crate::entry::Row;
use crate::stability::written_time;

/// A velocity that changes by less than this part of the largest is not told.
const LEAST_JUMP: f64 = 1e-9;

/// The inputs of a driven run whose changes make the velocity jump.
pub struct Masses {
    /// The values of the parameters on the leg to the last node; empty before the first.
    values: Vec<f64>,
    /// What depends on each parameter, once it has changed: it is asked for once, as a controller may change its inputs at every node.
    kinds: Vec<Option<Kind>>,
    /// The first jump by a change of the momenta.
    found: Option<Jump>,
}

/// What depends on a parameter.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// No velocity: a force, for example.
    Other,
    /// Rows for velocities.
    Rows,
    /// The momenta.
    Momenta,
}

/// A velocity that jumps.
struct Jump {
    t: f64,
    /// The parameter, and its values before and after.
    parameter: String,
    values: [f64; 2],
    /// The place of the coordinate whose velocity jumps most, and its velocities before and after.
    place: usize,
    velocities: [f64; 2],
}

impl Masses {
    /// The observer of a run, with the values of the parameters on the leg to its current node; they are read off the first node if there are none.
    pub fn of(values: &[f64]) -> Self {
        Self {
            values: values.to_vec(),
            kinds: Vec::new(),
            found: None,
        }
    }

    /// Looks at a node. Where the velocity has jumped at the node before, returns that node with the velocity with which the motion went on.
    #[allow(clippy::float_cmp)] // a value that is given again is the same number
    pub fn look(&mut self, row: &Row<'_>) -> Option<OwnedNode> {
        let now = |place: usize| row.declaration.value(place);
        let is_other = |place: usize| self.kinds.get(place) == Some(&Some(Kind::Other));
        let mut known = self.values.iter().enumerate();
        let parameters = row.declaration.shape().parameters.len();
        if parameters == self.values.len()
            && known.all(|(place, value)| *value == now(place) || is_other(place))
        {
            let values = self.values.iter_mut().enumerate();
            values.for_each(|(place, value)| *value = now(place));
            return None;
        }
        self.look_at_change(row)
    }

    /// Looks at a node where an input has changed whose kind is not known, or on which a velocity depends.
    #[allow(clippy::float_cmp)] // as above
    fn look_at_change(&mut self, row: &Row<'_>) -> Option<OwnedNode> {
        let parameters = row.declaration.shape().parameters.len();
        let values = (0..parameters)
            .map(|place| row.declaration.value(place))
            .collect();
        let before = core::mem::replace(&mut self.values, values);
        let is_changed = |place: &usize| {
            before
                .get(*place)
                .is_some_and(|value| *value != self.values[*place])
        };
        let changed: Vec<usize> = (0..parameters).filter(is_changed).collect();
        let node = row.before.filter(|_| !changed.is_empty())?;
        self.kinds.resize(parameters, None);
        let (values, node) = (&self.values, node.any());
        let kinds = &mut self.kinds;
        let mut kind_of = |place: usize| {
            *kinds[place]
                .get_or_insert_with(|| kind(&row.declaration, &node, (&before, place, values[place])))
        };
        let kinds: Vec<Kind> = changed.iter().map(|&place| kind_of(place)).collect();
        if kinds.iter().all(|kind| *kind == Kind::Other) {
            return None;
        }
        let sides = [&before, values].map(|values| row.declaration.with(values));
        let after = velocity_after(&sides, (node.t, node.q, node.v))?;
        let heaviest = changed
            .iter()
            .zip(&kinds)
            .find(|(_, kind)| **kind == Kind::Momenta);
        if let (Some((&place, _)), None) = (heaviest, &self.found) {
            let parameter = row.declaration.shape().parameters[place].name.to_string();
            let found = Jump::of(
                (node.t, node.v, &after),
                parameter,
                [before[place], values[place]],
            );
            self.found = found;
        }
        let mut departing = OwnedNode::of(&node);
        departing.as_node_mut().write(&AnyNode { v: &after, ..node });
        Some(departing)
    }

    /// The warning, with the names of the coordinates.
    pub fn note(&self, names: &[&str]) -> Option<String> {
        let Jump {
            t,
            parameter,
            values: [from, to],
            place,
            velocities: [before, after],
        } = self.found.as_ref()?;
        let name = names.get(*place).copied().unwrap_or_default();
        Some(format!(
            "warning: the input `{parameter}` changes from {from} to {to} at t = {}, and the momenta depend on it: a change of an input keeps the momentum, so \
             the velocity of `{name}` jumps there from {before:.4} to {after:.4}, and the energy with it. This is right where a body takes up what is at rest or changes \
             its shape; where it loses a part that keeps its velocity, as a load that is dropped or fuel, begin another run at this node with the velocity before",
            written_time(*t)
        ))
    }
}

impl Jump {
    /// The jump between two velocities; `None` if they differ by rounding.
    fn of((t, before, after): (f64, &[f64], &[f64]), parameter: String, values: [f64; 2]) -> Option<Self> {
        let change = |place: &usize| (after[*place] - before[*place]).abs();
        let place = (0..before.len()).max_by(|one, other| change(one).total_cmp(&change(other)))?;
        let largest = before
            .iter()
            .chain(after)
            .fold(0.0_f64, |most, v| most.max(v.abs()));
        (change(&place) > LEAST_JUMP * largest).then(|| Self {
            t,
            parameter,
            values,
            place,
            velocities: [before[place], after[place]],
        })
    }
}

/// What depends on a parameter that changes at a node, by its own change alone and beside the node: at the node itself a velocity or a factor may be zero.
fn kind(
    declaration: &Declaration<'_>,
    node: &AnyNode<'_>,
    (before, place, value): (&[f64], usize, f64),
) -> Kind {
    let beside = |x: &[f64]| -> Vec<f64> {
        let aside = [0.83, -0.37, 0.59];
        x.iter()
            .zip(aside.iter().cycle())
            .map(|(x, aside)| x + aside)
            .collect()
    };
    let (q, v) = (beside(node.q), beside(node.v));
    let mut after = before.to_vec();
    after[place] = value;
    let [old, new] = [before, &after].map(|values| declaration.with(values));
    if legendre_with(&old, (node.t, &q, &v)) != legendre_with(&new, (node.t, &q, &v)) {
        Kind::Momenta
    } else if old.phase(node.t, &q, &v) != new.phase(node.t, &q, &v) {
        Kind::Rows
    } else {
        Kind::Other
    }
}
