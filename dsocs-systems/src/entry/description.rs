//! The texts, names and counts of a declaration, without the system's type.

use std::fmt;

use dsocs_core::Quantity;
use serde::Serialize;

/// The texts and names in the declaration of a system.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The name and the documentation of the type.
    pub itself: Quantity,
    /// The coordinates.
    pub coordinates: Vec<Quantity>,
    /// The first of the four places of each coordinate that is a rotation: the scalar of its quaternion, which has no velocity and no force.
    pub rotations: Vec<usize>,
    /// The parameters: those of the declaration, then those that an entry adds.
    pub parameters: Vec<Quantity>,
    /// The observed expressions.
    pub observables: Vec<Quantity>,
    /// The number of known one-forms of constraint forces, which is the number of multipliers.
    pub forms: usize,
    /// The numbers of holonomic, nonholonomic and kinematic constraints.
    pub constraints: [usize; 3],
    /// The highest order of a derivative in a constraint, and at least 2.
    pub order: usize,
}

impl Description {
    /// The names of the coordinates.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.coordinates.iter().map(|coordinate| &*coordinate.name)
    }

    /// The kind of the constraints.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self.constraints {
            [0, 0, 0] => Kind::Unconstrained,
            [_, 0, 0] => Kind::Holonomic,
            [0, _, 0] => Kind::Nonholonomic,
            [0, 0, _] if self.order > 2 => Kind::ThirdOrder,
            [0, 0, _] => Kind::SecondOrder,
            _ => Kind::Mixed,
        }
    }
}

/// The kind of a system's constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// None.
    Unconstrained,
    /// On positions.
    Holonomic,
    /// On velocities.
    Nonholonomic,
    /// On accelerations.
    SecondOrder,
    /// On third derivatives, and perhaps on accelerations.
    ThirdOrder,
    /// Of several orders.
    Mixed,
}

impl Kind {
    /// Every kind, in the order of lists.
    pub const ALL: [Self; 6] = [
        Self::Unconstrained,
        Self::Holonomic,
        Self::Nonholonomic,
        Self::SecondOrder,
        Self::ThirdOrder,
        Self::Mixed,
    ];
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unconstrained => "unconstrained",
            Self::Holonomic => "holonomic",
            Self::Nonholonomic => "nonholonomic",
            Self::SecondOrder => "second-order",
            Self::ThirdOrder => "third-order",
            Self::Mixed => "mixed",
        })
    }
}

/// The first sentence of a documentation, without the full stop.
pub(super) fn sentence(doc: &str) -> &str {
    let end = doc.find(". ").unwrap_or(doc.len());
    doc[..end].trim_end().trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_is_the_first_sentence() {
        assert_eq!(sentence("A bead on a hoop. The hoop turns."), "A bead on a hoop");
        assert_eq!(
            sentence("A bead of 0.1 kg on a hoop."),
            "A bead of 0.1 kg on a hoop"
        );
        assert_eq!(sentence(""), "");
    }
}
