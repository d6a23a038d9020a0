//! Whether steps of different lengths can be composed.

use core::fmt;

/// Whether the map from node to node is symmetric in time for legs of any lengths, or why that cannot be said.
///
/// It is where the equations at a node depend on the nodes through the parabola through three of them alone: through its
/// value, slope and curvature at the middle node, which exist for unequal legs as well. With the paper's maps that is so
/// if `∂L/∂v` is a constant matrix times `v` and every kinematic constraint is of second order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Symmetry {
    /// It is: the step can be composed.
    AnyLegs,
    /// A constraint is of order 0 or 1: one of positions or of velocities.
    LowerOrder,
    /// `∂L/∂v` depends on the position, or is not linear in the velocity.
    Momentum,
    /// An external force depends on the velocity, and is taken on legs.
    ExternalForces,
    /// The map of the Lagrangian gives other equations than those of the continuous system at the parabola's point.
    LagrangianMap,
    /// The map of the kinematic constraints leads to another point.
    KinematicMap,
    /// The map of the variational constraints leads to another point.
    VariationalMap,
    /// Nobody has looked: the system was written by hand.
    Unknown,
}

impl fmt::Display for Symmetry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AnyLegs => "the step is symmetric with legs of any lengths",
            Self::LowerOrder => {
                "compositions do not support constraints of positions or velocities: these bind nodes and legs, and so more than value, \
                 slope and curvature at a node"
            }
            Self::Momentum => {
                "∂L/∂v is not a constant matrix times the velocity, so that the step is not symmetric in time"
            }
            Self::ExternalForces => {
                "an external force depends on the velocity, which legs of different lengths have differently on both sides of a node"
            }
            Self::LagrangianMap => {
                "with its `phi_lagrangian` (`midpoint` by default where the momentum depends on the position) the equations at a node \
                 depend on more than value, slope and curvature there"
            }
            Self::KinematicMap => {
                "the declared `phi_kinematic` is not value, slope and curvature at the middle node"
            }
            Self::VariationalMap => {
                "the declared `phi_variational` is not value, slope and curvature at the middle node"
            }
            Self::Unknown => "the system was written by hand and does not say whether its step is symmetric",
        })
    }
}
