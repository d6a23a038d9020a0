//! The value of an expression: a number, a vector, a matrix or a rotation.

use crate::graph::NodeId;
use crate::graph::calculus::rotation::Quaternion;
use crate::mistakes::errors::Reported;

/// A value, unless a mistake was reported.
pub(crate) type Valued = Result<Value, Reported>;

/// The value of an expression.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    /// A number.
    Number(NodeId),
    /// The components of a vector, at least one.
    Vector(Vec<NodeId>),
    /// The rows of a matrix, at least one, of the same length.
    Matrix(Vec<Vec<NodeId>>),
    /// A unit quaternion, the scalar first.
    Rotation(Quaternion),
}

impl Value {
    /// All numbers in it, a matrix row by row.
    pub(crate) fn numbers(&self) -> Vec<NodeId> {
        match self {
            Self::Number(number) => vec![*number],
            Self::Vector(components) => components.clone(),
            Self::Matrix(rows) => rows.concat(),
            Self::Rotation(quaternion) => quaternion.to_vec(),
        }
    }

    /// The number; `None` for other values.
    pub(crate) fn number(&self) -> Option<NodeId> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Vector(_) | Self::Matrix(_) | Self::Rotation(_) => None,
        }
    }

    /// The number of indices that can follow it.
    pub(crate) fn rank(&self) -> usize {
        match self {
            Self::Number(_) | Self::Rotation(_) => 0,
            Self::Vector(_) => 1,
            Self::Matrix(_) => 2,
        }
    }

    /// In words: `a number`, `a vector of 3 components`, `a matrix of 3 by 3`.
    pub(crate) fn kind(&self) -> String {
        match self {
            Self::Number(_) => "a number".to_owned(),
            Self::Rotation(_) => "a rotation".to_owned(),
            Self::Vector(components) => match components.len() {
                1 => "a vector of 1 component".to_owned(),
                more => format!("a vector of {more} components"),
            },
            Self::Matrix(rows) => format!(
                "a matrix of {} by {}",
                rows.len(),
                rows.first().map_or(0, Vec::len)
            ),
        }
    }

    /// A value of the same shape, with a function applied to each number.
    pub(crate) fn map<E>(&self, mut of: impl FnMut(NodeId) -> Result<NodeId, E>) -> Result<Self, E> {
        let mut all = |numbers: &[NodeId]| numbers.iter().map(|&number| of(number)).collect();
        Ok(match self {
            Self::Number(number) => Self::Number(of(*number)?),
            Self::Vector(components) => Self::Vector(all(components)?),
            Self::Rotation(quaternion) => {
                let components: Vec<NodeId> = all(quaternion)?;
                Self::Rotation(components.try_into().unwrap_or(*quaternion))
            }
            Self::Matrix(rows) => Self::Matrix(rows.iter().map(|row| all(row)).collect::<Result<_, _>>()?),
        })
    }
}
