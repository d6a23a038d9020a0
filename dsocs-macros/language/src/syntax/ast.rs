//! The syntax tree of a declaration: its statements, typed, with the tokens they came from.
//!
//! Expressions stay `syn` expressions; [`crate::lower`] finds their meaning.

use proc_macro2::Ident;
use syn::{Expr, ExprClosure, Path};

use crate::mistakes::errors::Reported;

/// A statement that a declaration has at most once.
#[derive(Clone, Debug, Default)]
pub(crate) enum Statement<T> {
    /// The user did not write it.
    #[default]
    Absent,
    /// The user wrote it with a mistake, which was reported: errors that follow from its absence are not.
    Malformed(Reported),
    /// The user wrote it.
    Given(T),
}

impl<T> Statement<T> {
    /// The statement, if it was given and could be read.
    pub(crate) fn given(&self) -> Option<&T> {
        match self {
            Self::Given(statement) => Some(statement),
            Self::Absent | Self::Malformed(_) => None,
        }
    }

    /// Whether the user did not write the statement.
    pub(crate) fn is_absent(&self) -> bool {
        matches!(self, Self::Absent)
    }
}

/// The body of the attribute: its statements.
#[derive(Clone, Default)]
pub(crate) struct Declaration {
    /// `crate = PATH;`
    pub(crate) core: Statement<Path>,
    /// `coordinates(x, y);`
    pub(crate) coordinates: Statement<Coordinates>,
    /// `let NAME = EXPR;`, in order.
    pub(crate) lets: Vec<Let>,
    /// `lagrangian = EXPR;`
    pub(crate) lagrangian: Statement<Scalar>,
    /// `holonomic = …;`
    pub(crate) holonomic: Statement<Constraints>,
    /// `nonholonomic = …;`
    pub(crate) nonholonomic: Statement<Constraints>,
    /// `kinematic = …;`
    pub(crate) kinematic: Statement<Constraints>,
    /// `variational = …;` or `constraint_forces = […];`
    pub(crate) directions: Statement<Directions>,
    /// `external_forces = (f1, f2);`
    pub(crate) external_forces: Statement<Scalar>,
    /// `discrete_lagrangian = EXPR;`
    pub(crate) discrete_lagrangian: Statement<Scalar>,
    /// `discrete_kinematic = …;`
    pub(crate) discrete_kinematic: Statement<Constraints>,
    /// `phi_lagrangian = |q0, q1| …;`
    pub(crate) phi_lagrangian: Statement<Map>,
    /// `phi_kinematic = |q0, q1, q2| …;`
    pub(crate) phi_kinematic: Statement<Map>,
    /// `phi_variational = |q0, q1, q2| …;`
    pub(crate) phi_variational: Statement<Map>,
    /// `branch = …;`
    pub(crate) branch: Statement<Branch>,
    /// `observe = […];`
    pub(crate) observe: Statement<Observe>,
    /// `reduced(r);`
    pub(crate) reduced: Statement<Vec<Ident>>,
}

/// `coordinates(x, y, theta: [3]);`
#[derive(Clone, Debug)]
pub(crate) struct Coordinates {
    /// The coordinates as written, in order.
    pub(crate) groups: Vec<Group>,
    /// The names of all coordinates, in order: `x`, `y`, `theta_0`, `theta_1`, `theta_2`.
    pub(crate) names: Vec<Ident>,
    /// The number of `let`s before it: of two equal names, the later one is the mistake.
    pub(crate) lets_before: usize,
}

/// `x`, `theta: [3]` or `r: rotation` among the coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// The name.
    pub(crate) name: Ident,
    /// The index of its first coordinate.
    pub(crate) first: usize,
    /// The number of coordinates, if it is an array.
    pub(crate) length: Option<usize>,
    /// Whether it is a rotation, which takes four places.
    pub(crate) is_rotation: bool,
    /// Its documentation in one line.
    pub(crate) doc: String,
}

impl Group {
    /// The number of its coordinates; a rotation has four.
    pub(crate) fn places(&self) -> usize {
        if self.is_rotation {
            4
        } else {
            self.length.unwrap_or(1)
        }
    }
}

impl Coordinates {
    /// For each rotation, the index of its first coordinate.
    pub(crate) fn rotations(&self) -> impl Iterator<Item = usize> {
        let rotations = self.groups.iter().filter(|group| group.is_rotation);
        rotations.map(|group| group.first)
    }
}

/// `let NAME = EXPR;`
#[derive(Clone)]
pub(crate) struct Let {
    /// The name.
    pub(crate) name: Ident,
    /// The expression.
    pub(crate) value: Result<Expr, Reported>,
    /// Its documentation in one line.
    pub(crate) doc: String,
    /// Whether it comes from statements that several declarations share.
    pub(crate) shared: bool,
}

/// `lagrangian = EXPR;`, or the tuple of `external_forces = (…);`
#[derive(Clone)]
pub(crate) struct Scalar {
    /// The expression.
    pub(crate) value: Expr,
    /// The number of `let`s before it, which it may use.
    pub(crate) lets_before: usize,
}

/// An entry of a list.
#[derive(Clone)]
pub(crate) struct Entry {
    /// The expression.
    pub(crate) value: Expr,
    /// The values of the `each(…)` indices around it, the outermost first.
    pub(crate) indices: Vec<Index>,
    /// The index of the list's element as written: all entries of one `each` have the same.
    pub(crate) group: usize,
}

/// An index and its value.
#[derive(Clone, Debug)]
pub(crate) struct Index {
    /// The name.
    pub(crate) name: Ident,
    /// The value.
    pub(crate) value: i64,
}

/// `kinematic = EXPR;` or `kinematic = [EXPR, …];`, and so for the other kinds of constraints.
#[derive(Clone)]
pub(crate) struct Constraints {
    /// The word `holonomic`, `nonholonomic`, `kinematic` or `discrete_kinematic`.
    pub(crate) keyword: Ident,
    /// The rows.
    pub(crate) rows: Vec<Entry>,
    /// The number of `let`s before it, which it may use.
    pub(crate) lets_before: usize,
}

/// `variational = […];`, `variational = chetaev;` or `constraint_forces = […];`
#[derive(Clone)]
pub(crate) struct Directions {
    /// The word `variational` or `constraint_forces`.
    pub(crate) keyword: Ident,
    /// Whether fields or forms are given.
    pub(crate) side: Side,
    /// Each field or form: its components, in the shape of the coordinates.
    pub(crate) fields: Vec<Entry>,
    /// The number of `let`s before it, which it may use.
    pub(crate) lets_before: usize,
}

/// The way in which the variational constraints are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// By fields that span `C_V`.
    Variational,
    /// By forms that span `F_V`, the annihilator of `C_V`.
    Forces,
    /// By Chetaev's rule for `F_V`.
    Chetaev,
}

/// `phi_… = |q0, q1| …;`
#[derive(Clone)]
pub(crate) struct Map {
    /// The word `phi_lagrangian`, `phi_kinematic` or `phi_variational`.
    pub(crate) keyword: Ident,
    /// The map.
    pub(crate) rule: MapRule,
}

/// A discretization map, as written.
#[derive(Clone)]
pub(crate) enum MapRule {
    /// A formula.
    Closure(Box<ExprClosure>),
    /// `paper`.
    Paper,
    /// `midpoint`.
    Midpoint,
    /// `trapezoid`: the mean of the values at both nodes.
    Trapezoid,
}

/// `branch = divide(w);` or `branch = [divide(w), _];`
#[derive(Clone)]
pub(crate) struct Branch {
    /// The word `branch`.
    pub(crate) keyword: Ident,
    /// For each kinematic row the factor to divide out, if any.
    pub(crate) factors: Vec<Result<Option<Entry>, Reported>>,
    /// The number of `let`s before it, which it may use.
    pub(crate) lets_before: usize,
}

/// `observe = [NAME, …];`
#[derive(Clone, Debug)]
pub(crate) struct Observe {
    /// The names of `let`s.
    pub(crate) names: Vec<Result<Ident, Reported>>,
    /// The number of `let`s before it, which it may use.
    pub(crate) lets_before: usize,
}
