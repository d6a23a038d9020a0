//! The beginning of a run.

use dsocs_core::{AnyStart, Shape};

use super::failure::RunFailure;

/// The rule that gives the first nodes of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Beginning {
    /// From position and velocity, `q1 = q0 + h v0`.
    Paper {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
    },
    /// From position and velocity, `q1 = q0 + h v0 + h²/2 a0`.
    SecondOrder {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
    },
    /// From position, velocity and acceleration, where a constraint is of third order.
    ThirdOrder {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
        /// The initial acceleration.
        a0: Vec<f64>,
    },
    /// From position, velocity and constraint force, where a constraint is of third order.
    ThirdOrderByForce {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
        /// The initial constraint force.
        force: Vec<f64>,
    },
    /// Both nodes.
    Nodes {
        /// The first node.
        q0: Vec<f64>,
        /// The second node.
        q1: Vec<f64>,
    },
    /// Three nodes, where a constraint is of third order.
    ThreeNodes {
        /// The first node.
        q0: Vec<f64>,
        /// The second node.
        q1: Vec<f64>,
        /// The third node.
        q2: Vec<f64>,
    },
    /// Another beginning, projected onto the constraints on positions and velocities.
    Projected(Box<Self>),
    /// Another beginning, with the acceleration near this one where the equations allow several.
    Near(Vec<f64>, Box<Self>),
    /// Another beginning, at another time than 0.
    At(f64, Box<Self>),
}

impl Beginning {
    /// Checks that every vector has one component for each coordinate.
    ///
    /// # Errors
    ///
    /// [`RunFailure::Length`] for the first vector that has not.
    pub(crate) fn fits(&self, shape: &Shape) -> Result<(), RunFailure> {
        let (first, others): (_, &[_]) = match self {
            Self::Paper { q0, v0 } | Self::SecondOrder { q0, v0 } => (q0, &[("v0", v0)]),
            Self::ThirdOrder { q0, v0, a0 } => (q0, &[("v0", v0), ("a0", a0)]),
            Self::ThirdOrderByForce { q0, v0, force } => (q0, &[("v0", v0), ("f0", force)]),
            Self::Nodes { q0, q1 } => (q0, &[("q1", q1)]),
            Self::ThreeNodes { q0, q1, q2 } => (q0, &[("q1", q1), ("q2", q2)]),
            Self::Projected(beginning) | Self::At(_, beginning) => return beginning.fits(shape),
            Self::Near(a0, beginning) => {
                beginning.fits(shape)?;
                return fits("a0", a0, shape);
            }
        };
        fits("q0", first, shape)?;
        others
            .iter()
            .try_for_each(|(vector, components)| fits(vector, components, shape))
    }

    /// The start of a run.
    pub fn start(&self) -> AnyStart {
        match self {
            Self::Paper { q0, v0 } => AnyStart::paper(q0, v0),
            Self::SecondOrder { q0, v0 } => AnyStart::second_order(q0, v0),
            Self::ThirdOrder { q0, v0, a0 } => AnyStart::third_order(q0, v0, a0),
            Self::ThirdOrderByForce { q0, v0, force } => AnyStart::third_order_by_force(q0, v0, force),
            Self::Nodes { q0, q1 } => AnyStart::nodes(q0, q1),
            Self::ThreeNodes { q0, q1, q2 } => AnyStart::three_nodes(q0, q1, q2),
            Self::Projected(beginning) => beginning.start().projected(),
            Self::Near(a0, beginning) => beginning.start().near_acceleration(a0),
            Self::At(t0, beginning) => beginning.start().at(*t0),
        }
    }

    /// The given position, where it is projected onto constraints.
    pub(crate) fn projected_from(&self) -> Option<&[f64]> {
        match self {
            Self::Projected(beginning) => beginning.position(),
            Self::At(_, beginning) | Self::Near(_, beginning) => beginning.projected_from(),
            _ => None,
        }
    }

    /// The given position of the first node.
    fn position(&self) -> Option<&[f64]> {
        match self {
            Self::Paper { q0, .. }
            | Self::SecondOrder { q0, .. }
            | Self::ThirdOrder { q0, .. }
            | Self::ThirdOrderByForce { q0, .. } => Some(q0),
            Self::Projected(beginning) | Self::At(_, beginning) | Self::Near(_, beginning) => {
                beginning.position()
            }
            // given nodes are not projected
            Self::Nodes { .. } | Self::ThreeNodes { .. } => None,
        }
    }

    /// The time of the start.
    pub(super) fn time(&self) -> f64 {
        match self {
            Self::At(t0, _) => *t0,
            Self::Projected(beginning) | Self::Near(_, beginning) => beginning.time(),
            _ => 0.0,
        }
    }
}

/// Checks that a vector has one component for each coordinate.
///
/// # Errors
///
/// [`RunFailure::Length`] if it has not.
pub(crate) fn fits(vector: &'static str, components: &[f64], shape: &Shape) -> Result<(), RunFailure> {
    if components.len() == shape.dimension() {
        return Ok(());
    }
    let is_position = vector.starts_with('q');
    let named = shape.coordinates.iter().enumerate();
    let named = named.filter(|(place, _)| is_position || shape.moves(*place));
    Err(RunFailure::Length {
        vector,
        found: components.len(),
        coordinates: named.map(|(_, coordinate)| coordinate.name.clone()).collect(),
        of_rotations: match (shape.rotations.is_empty(), is_position) {
            (true, _) => "",
            (false, true) => "; a rotation has the four of a unit quaternion, the scalar w first",
            (false, false) => "; a rotation has three, in the frame of its body",
        },
    })
}
