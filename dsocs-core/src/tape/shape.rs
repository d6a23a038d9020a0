//! What is known of a declared system at all times: names, counts and kinds.

use std::borrow::Cow;

use super::symmetry::Symmetry;
use crate::solve::rotation::SLOTS;
use crate::tape::quantity::Quantity;

/// What is known of a declared system at all times.
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
    /// The declaration as text, without comments: the body of the attribute, which a text file says word for word.
    pub declaration: Cow<'static, str>,
    /// The coordinates, in order.
    pub coordinates: Cow<'static, [Quantity]>,
    /// The parameters that are numbers, in order.
    pub parameters: Cow<'static, [Quantity]>,
    /// The fields that are no parameters, each with its type in the place of the documentation.
    pub others: Cow<'static, [Quantity]>,
    /// The observed expressions, in order.
    pub observables: Cow<'static, [Quantity]>,
    /// How many numbers an increment has: as many as a position, unless a coordinate is no number.
    pub increments: usize,
    /// How many unknowns a step has.
    pub unknowns: usize,
    /// How many the continuous system has: accelerations, then multipliers.
    pub motion: usize,
    /// How many values are known when a run begins.
    pub constants: usize,
    /// How many are known when a step begins.
    pub known: usize,
    /// The highest order of a derivative in a constraint, and at least 2: a step finds the last of `order + 1` nodes.
    pub order: usize,
    /// How many holonomic constraints there are.
    pub holonomic: usize,
    /// How many nonholonomic constraints.
    pub nonholonomic: usize,
    /// How many kinematic constraints.
    pub kinematic: usize,
    /// How many one-forms of constraint forces are known.
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
    /// Whether a row has a `signum` or a comparison that positions or velocities decide.
    pub piecewise: bool,
    /// Whether anything is given by pieces or divided by what may be zero, as the motion or the time decides.
    pub switches: bool,
    /// Whether rows were multiplied by more than a number.
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

    /// How many coordinates there are.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.coordinates.len()
    }

    /// Whether a coordinate has a velocity, an acceleration and a force: the first of the four places of a rotation has a position alone.
    #[must_use]
    pub fn moves(&self, coordinate: usize) -> bool {
        !self.rotations.contains(&coordinate)
    }

    /// The first place of the rotation to which a place belongs, if it does to one.
    #[must_use]
    pub fn rotation_of(&self, coordinate: usize) -> Option<usize> {
        let mut rotations = self.rotations.iter().copied();
        rotations.find(|first| (*first..first + SLOTS).contains(&coordinate))
    }

    /// The rotation and the axis of its body, in words, about which a place of a velocity turns; `None` of a number.
    pub(crate) fn axis_of(&self, coordinate: usize) -> Option<(&str, &'static str)> {
        let place = coordinate.checked_sub(self.rotation_of(coordinate)? + 1)?;
        let axis = ["first", "second", "third"].get(place)?;
        let (body, _) = self.coordinates.get(coordinate)?.name.rsplit_once('_')?;
        Some((body, axis))
    }

    /// The components of a velocity, an acceleration or a force that coordinates have.
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

    /// Whether roots are watched for others nearby.
    #[must_use]
    pub fn is_watched(&self) -> bool {
        !self.divided && !self.linear
    }

    /// How many multipliers are unknown in the continuous system.
    #[must_use]
    pub fn multipliers(&self) -> usize {
        self.motion.saturating_sub(self.increments)
    }
}
