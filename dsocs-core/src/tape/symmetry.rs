//! Ways to compose steps of different lengths.

use core::fmt;

/// The way in which steps of different lengths are composed symmetrically in time, or the reason why they
/// cannot be.
///
/// Consider the parabola through three nodes. If the equations depend only on its value, slope and curvature at the middle node, the
/// parabola joins legs of any lengths, and the code of the step can be used for all of them. With the paper's maps this is so if
/// `∂L/∂v` is a constant matrix times `v`. Otherwise the momenta at the nodes join the legs: half a kick by the constraint force, the
/// discrete flow of `L_d` with the external forces, and another half kick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Symmetry {
    /// The parabola through three nodes joins the legs, with the generated code of the step.
    AnyLegs,
    /// The momenta at the nodes join the legs. They are evaluated on the tape, which is slower.
    Momenta,
    /// None: there is a constraint on positions or velocities (of order 0 or 1).
    LowerOrder,
    /// None: a constraint is of third order.
    ThirdOrder,
    /// None: `L_d` has different values for a leg and for the same leg run back in time.
    LagrangianMap,
    /// None: the map of the kinematic constraints gives another point than the parabola's value, slope and
    /// curvature.
    KinematicMap,
    /// None: the map of the variational constraints gives another point than the parabola's value, slope and
    /// curvature.
    VariationalMap,
    /// Unknown: the system was written by hand.
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
