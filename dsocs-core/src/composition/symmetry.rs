//! How steps of different lengths are composed.

use core::fmt;

/// How the step is composed of legs of different lengths, symmetrically in time, or why it cannot be.
///
/// Where the equations at a node depend on the nodes through the parabola through three of them alone, through its
/// value, slope and curvature at the middle node, this parabola joins legs of any lengths, and the code of the step serves for all of
/// them. With the paper's maps that is so if `∂L/∂v` is a constant matrix times `v`. Elsewhere the momenta at the nodes join the
/// legs: half a kick by the constraint force, the discrete flow of `L_d` with the external forces, and the other half.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Symmetry {
    /// By the parabola through three nodes, in the code of the step.
    AnyLegs,
    /// By the momenta at the nodes, evaluated on the tape: slower.
    Momenta,
    /// Not at all: a constraint is of order 0 or 1, one of positions or of velocities.
    LowerOrder,
    /// Not at all: a constraint is of third order.
    ThirdOrder,
    /// Not at all: `L_d` of a leg is another one when the leg is run back.
    LagrangianMap,
    /// Not at all: the map of the kinematic constraints leads to another point than value, slope and curvature.
    KinematicMap,
    /// Not at all: the map of the variational constraints does.
    VariationalMap,
    /// Nobody has looked: the system was written by hand.
    Unknown,
}

impl fmt::Display for Symmetry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AnyLegs => "the step is symmetric with legs of any lengths",
            Self::Momenta => "legs of any lengths are joined by the momenta at the nodes",
            Self::LowerOrder => {
                "compositions do not support constraints of positions or velocities: these bind nodes and legs, and so more than value, \
                 slope and curvature at a node"
            }
            Self::ThirdOrder => {
                "a constraint is of third order, so that a step knows three nodes that lie one step apart"
            }
            Self::LagrangianMap => {
                "with its `phi_lagrangian` or `discrete_lagrangian` the step is not symmetric in time: `midpoint` and `trapezoid` are"
            }
            Self::KinematicMap => {
                "the declared `phi_kinematic` or `discrete_kinematic` is not at value, slope and curvature at the middle node"
            }
            Self::VariationalMap => {
                "the declared `phi_variational` is not value, slope and curvature at the middle node"
            }
            Self::Unknown => "the system was written by hand and does not say whether its step is symmetric",
        })
    }
}
