//! The names that can be used at a place, and their meanings.

use std::rc::Rc;

use proc_macro2::Ident;
use syn::ExprClosure;

use crate::check::names::{check_reserved, report_clash};
use crate::graph::NodeId;
use crate::lower::Value;
use crate::mistakes::errors::{Errors, Reported};

/// The meaning of a name.
#[derive(Clone)]
pub(crate) enum Binding {
    /// A coordinate, by its index.
    Coordinate(usize),
    /// An array of coordinates, by its index among [`Coordinates::groups`](crate::syntax::ast::Coordinates::groups).
    Array(usize),
    /// A rotation, by its index among [`Coordinates::groups`](crate::syntax::ast::Coordinates::groups).
    Rotation(usize),
    /// A field of the struct, by its index.
    Field(usize),
    /// A `let`, or an argument of a function.
    Let(Result<Value, Reported>),
    /// A `let` with a closure: a function of the declaration.
    Function(Function),
    /// An integer known while the declaration is read: an index, or an integer argument of a function.
    Index(i64),
    /// A node of a map: 0, 1 or 2.
    Node(usize),
    /// The time of a node of a map.
    NodeTime(usize),
    /// A `let` in a map: one component for each coordinate.
    OfMap(Result<Vec<NodeId>, Reported>),
}

/// A function of the declaration, `|i, j| …`, whose parameters have been checked.
#[derive(Clone)]
pub(crate) struct Function {
    /// The closure.
    pub(crate) closure: Rc<ExprClosure>,
    /// Whether it is defined in a map, so that its values are made of nodes.
    pub(crate) of_nodes: bool,
}

impl Binding {
    /// The kind of the name, for a message.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Coordinate(_) => "a coordinate",
            Self::Array(_) => "an array of coordinates",
            Self::Rotation(_) => "a rotation",
            Self::Function(_) => "a function",
            Self::Index(_) => "an index",
            Self::Field(_) => "a parameter",
            Self::Let(_) | Self::OfMap(_) => "a `let`",
            Self::Node(_) => "a node",
            Self::NodeTime(_) => "the time of a node",
        }
    }
}

/// The names that can be used at a place, the innermost last.
#[derive(Clone, Default)]
pub(crate) struct Scope {
    names: Vec<(String, Binding)>,
}

/// The names that [`Scope::split_off`] removed.
pub(crate) struct RemovedNames(Vec<(String, Binding)>);

impl Scope {
    /// The innermost meaning of a name.
    pub(crate) fn get(&self, name: &Ident) -> Option<&Binding> {
        self.place(name)
            .and_then(|place| self.names.get(place))
            .map(|(_, binding)| binding)
    }

    /// The position of the innermost meaning of a name; the names before it were known when it was defined.
    pub(crate) fn place(&self, name: &Ident) -> Option<usize> {
        let name = name.to_string();
        self.names.iter().rposition(|(known, _)| *known == name)
    }

    /// Removes the names from a position on, until [`Scope::restore`].
    pub(crate) fn split_off(&mut self, place: usize) -> RemovedNames {
        RemovedNames(self.names.split_off(place))
    }

    /// Puts back the names that [`Scope::split_off`] removed, in place of those added since.
    pub(crate) fn restore(&mut self, place: usize, removed: RemovedNames) {
        self.names.truncate(place);
        self.names.extend(removed.0);
    }

    /// Adds a name without a check for clashes.
    pub(crate) fn push(&mut self, name: &Ident, binding: Binding) {
        self.names.push((name.to_string(), binding));
    }

    /// Adds a name, and reports a clash if it is in use.
    pub(crate) fn define(&mut self, name: &Ident, binding: Binding, errors: &Errors) -> Result<(), Reported> {
        let result = match self.get(name) {
            Some(known) => Err(report_clash(name, known.kind(), errors)),
            None => check_reserved(name, errors),
        };
        self.push(name, binding);
        result
    }

    /// The number of names, for [`Scope::truncate`].
    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    /// Removes the names beyond a length.
    pub(crate) fn truncate(&mut self, len: usize) {
        self.names.truncate(len);
    }

    /// All names whose binding satisfies a condition.
    pub(crate) fn names(&self, wanted: impl Fn(&Binding) -> bool) -> impl Iterator<Item = &str> {
        self.names
            .iter()
            .filter(move |(_, binding)| wanted(binding))
            .map(|(name, _)| name.as_str())
    }
}
