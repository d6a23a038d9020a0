//! The fixed properties of a declared system: names, counts and kinds.

use std::borrow::Cow;

use super::symmetry::Symmetry;
use crate::solve::rotation::SLOTS;
use crate::tape::quantity::Quantity;

/// The fixed properties of a declared system: names, counts and kinds.
#[expect(
    clippy::struct_excessive_bools,
    reason = "facts that do not depend on each other"
)]
#[derive(Clone, Debug)]
pub struct Shape {
    /// The name of the declared type.
    pub name: Cow<'static, str>,
    /// The first paragraph of its documentation, in one line.
    pub doc: Cow<'static, str>,
    /// The declaration as text, without comments: the body of the attribute, which is also the content of a
    /// text file.
    pub declaration: Cow<'static, str>,
    /// The coordinates, in order.
    pub coordinates: Cow<'static, [Quantity]>,
    /// The parameters that are numbers, in order.
    pub parameters: Cow<'static, [Quantity]>,
    /// The fields that are no parameters, each with its type in place of the documentation.
    pub others: Cow<'static, [Quantity]>,
    /// The observed expressions, in order.
    pub observables: Cow<'static, [Quantity]>,
    /// The number of components of an increment: as many as a position has, unless a coordinate is no number.
    pub increments: usize,
    /// The number of unknowns of a step.
    pub unknowns: usize,
    /// The number of unknowns of the continuous system: accelerations, then multipliers.
    pub motion: usize,
    /// The number of constants of a run.
    pub constants: usize,
    /// The number of known values of a step.
    pub known: usize,
    /// The highest order of a derivative in a constraint, and at least 2: a step finds the last of `order + 1` nodes.
    pub order: usize,
    /// The number of holonomic constraints.
    pub holonomic: usize,
    /// The number of nonholonomic constraints.
    pub nonholonomic: usize,
    /// The number of kinematic constraints.
    pub kinematic: usize,
    /// The number of declared constraint forms.
    pub forms: usize,
    /// The places of the constraints of third order among all constraints.
    pub third_order: Cow<'static, [usize]>,
    /// The first of the four places of each coordinate that is a rotation. A position has a unit quaternion there, the scalar first; velocities, accelerations
    /// and forces have a zero and three numbers in the frame of the body.
    pub rotations: Cow<'static, [usize]>,
    /// The places of the parameters that holonomic constraints depend on.
    pub of_positions: Cow<'static, [usize]>,
    /// The places of the parameters inside a `dot(…)`: the derivative takes their own rates to be zero.
    pub of_rates: Cow<'static, [usize]>,
    /// Whether any expression depends on time.
    pub depends_on_time: bool,
    /// Whether external forces act.
    pub external_forces: bool,
    /// Whether the rows of a step are affine in the unknowns, between their jumps if they have any.
    pub linear: bool,
    /// Whether a row may jump where an unknown changes.
    pub jumps: bool,
    /// Whether a row has a `signum` or a comparison that depends on positions or velocities.
    pub piecewise: bool,
    /// Whether an expression is piecewise or has a divisor that may vanish, depending on the motion or on
    /// time.
    pub switches: bool,
    /// Whether rows were multiplied by a factor that is not a number.
    pub scaled: bool,
    /// Whether the declaration names a factor to be divided out of a row.
    pub divided: bool,
    /// Whether steps of different lengths can be composed, or why not.
    pub symmetry: Symmetry,
}

impl Shape {
    /// The type of a field that is no parameter, by its name.
    #[must_use]
    pub fn type_of_other(&self, name: &str) -> Option<&str> {
        let field = self.others.iter().find(|field| field.name == name);
        field.map(|field| &*field.doc)
    }

    /// The number of coordinates.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.coordinates.len()
    }

    /// Whether a coordinate has a velocity, an acceleration and a force: of the four places of a rotation,
    /// the first has a position alone.
    #[must_use]
    pub fn moves(&self, coordinate: usize) -> bool {
        !self.rotations.contains(&coordinate)
    }

    /// The first place of the rotation that contains a place, if one does.
    #[must_use]
    pub fn rotation_of(&self, coordinate: usize) -> Option<usize> {
        let mut rotations = self.rotations.iter().copied();
        rotations.find(|first| (*first..first + SLOTS).contains(&coordinate))
    }

    /// The name of the rotation and of the axis of its body about which a component of a velocity turns;
    /// `None` if it is no rotation.
    pub(crate) fn axis_of(&self, coordinate: usize) -> Option<(&str, &'static str)> {
        let place = coordinate.checked_sub(self.rotation_of(coordinate)? + 1)?;
        let axis = ["first", "second", "third"].get(place)?;
        let (body, _) = self.coordinates.get(coordinate)?.name.rsplit_once('_')?;
        Some((body, axis))
    }

    /// The components of a velocity, an acceleration or a force, without the zeros of rotations.
    pub fn moving<'v>(&'v self, vector: &'v [f64]) -> impl Iterator<Item = &'v f64> {
        let components = vector.iter().enumerate();
        components
            .filter(|(coordinate, _)| self.moves(*coordinate))
            .map(|(_, component)| component)
    }

    /// Whether a constraint is of third order: a step then finds the last of four nodes.
    #[must_use]
    pub fn is_of_third_order(&self) -> bool {
        self.order > 2
    }

    /// Whether a factor could be declared to be divided out of a constraint, and is not.
    #[must_use]
    pub fn may_divide(&self) -> bool {
        self.kinematic > 0 && !self.divided
    }

    /// Whether every step is solved by one update.
    #[must_use]
    pub fn is_solved_at_once(&self) -> bool {
        self.linear && !self.jumps
    }

    /// Whether steps are watched for a second root nearby.
    #[must_use]
    pub fn is_watched(&self) -> bool {
        !self.divided && !self.linear
    }

    /// The number of multipliers among the unknowns of the continuous system.
    #[must_use]
    pub fn multipliers(&self) -> usize {
        self.motion.saturating_sub(self.increments)
    }
}
