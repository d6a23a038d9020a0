//! The one namespace of a declaration: coordinates, fields, `let`s and the words of the language.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::rc::Rc;

use proc_macro2::Ident;
use syn::ExprClosure;

use crate::ast::{Declaration, Group, Let};
use crate::errors::{Errors, Reported};
use crate::graph::NodeId;
use crate::input::Fields;
use crate::lower::Value;

/// Words of the language, which cannot be defined anew, and their meanings.
pub(crate) const RESERVED: [(&str, &str); 8] = [
    ("h", "the step"),
    ("t", "time"),
    ("dot", "the time derivative"),
    ("ddot", "the second time derivative"),
    ("dddot", "the third time derivative"),
    ("sum", "a sum over a range"),
    ("product", "a product over a range"),
    ("each", "an entry of a list for every index"),
];

/// The meaning of a name.
#[derive(Clone)]
pub(crate) enum Binding {
    /// A coordinate, by its index.
    Coordinate(usize),
    /// An array of coordinates, by its index among [`Coordinates::groups`](crate::ast::Coordinates::groups).
    Array(usize),
    /// A rotation, by its index among [`Coordinates::groups`](crate::ast::Coordinates::groups).
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

/// Reports every top-level name that has a meaning already, at its second definition.
pub(crate) fn check<'d>(declaration: &'d Declaration, fields: &'d Fields, errors: &Errors) {
    let mut known: HashMap<String, &str> = HashMap::new();
    let mut add = |name: &Ident, kind| match known.entry(name.to_string()) {
        Entry::Occupied(first) => {
            report_clash(name, first.get(), errors);
        }
        Entry::Vacant(place) => {
            // a reserved word is reported here, and its other clashes need not be
            let _ = check_reserved(name, errors);
            place.insert(kind);
        }
    };
    let coordinates = declaration.coordinates.given();
    let split = coordinates
        .map_or(0, |coordinates| coordinates.lets_before)
        .min(declaration.lets.len());
    let (before, after) = declaration.lets.split_at(split);
    let lets = |lets: &'d [Let]| lets.iter().map(|binding| (&binding.name, "a `let`"));
    let array = |group: &'d Group| match group.length {
        Some(_) => Some((&group.name, "an array of coordinates")),
        None => group.is_rotation.then_some((&group.name, "a rotation")),
    };
    let arrays = coordinates.iter().flat_map(|part| &part.groups).filter_map(array);
    let coordinates = coordinates
        .iter()
        .flat_map(|part| &part.names)
        .map(|name| (name, "a coordinate"));
    let coordinates = arrays.chain(coordinates);
    let elements = fields.elements();
    let fields = fields.iter().map(|field| &field.ident).chain(&elements);
    let fields = fields.map(|name| (name, "a parameter"));
    for (name, kind) in lets(before).chain(coordinates).chain(lets(after)).chain(fields) {
        add(name, kind);
    }
    if let Some(coordinates) = declaration.coordinates.given() {
        for name in &coordinates.names {
            // the mistake is reported; the declaration can be read all the same
            let _ = check_column(name, name, &coordinates.names, errors);
        }
    }
}

/// Refuses the name of a coordinate or observable that another column of a run's table has. It is reported at
/// `tokens`.
pub(crate) fn check_column(
    name: &Ident,
    tokens: &Ident,
    coordinates: &[Ident],
    errors: &Errors,
) -> Result<(), Reported> {
    let text = name.to_string();
    let of_coordinate = |(prefix, what): (&str, &str)| {
        let coordinate = text.strip_prefix(prefix)?;
        let is_known = coordinates.iter().any(|known| known == coordinate);
        is_known.then(|| format!("{what} of `{coordinate}`"))
    };
    let is_multiplier = |text: &str| {
        let number = text.strip_prefix("lambda_");
        number.is_some_and(|number| !number.is_empty() && number.chars().all(|digit| digit.is_ascii_digit()))
    };
    let what = match text.as_str() {
        "energy" => Some("the energy".to_owned()),
        "regularity_forward" | "regularity_backward" => Some("the regularity".to_owned()),
        text if is_multiplier(text) => Some("a multiplier".to_owned()),
        _ => [
            ("v_", "the velocity"),
            ("force_", "the force"),
            ("error_", "the error"),
        ]
        .into_iter()
        .find_map(of_coordinate),
    };
    match what {
        Some(what) => Err(errors.at(
            tokens,
            format!("in the table of a run `{text}` is the column of {what}; expected another name"),
        )),
        None => Ok(()),
    }
}

fn check_reserved(name: &Ident, errors: &Errors) -> Result<(), Reported> {
    match RESERVED.iter().find(|(word, _)| name == word) {
        Some((word, meaning)) => Err(errors.at(
            name,
            format!("`{word}` means {meaning} in a declaration; expected another name"),
        )),
        None => Ok(()),
    }
}

fn report_clash(name: &Ident, kind: &str, errors: &Errors) -> Reported {
    errors.at(
        name,
        format!("`{name}` is the name of {kind} already; expected another name"),
    )
}
