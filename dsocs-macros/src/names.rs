//! The one namespace of a declaration: coordinates, fields, `let`s and the words of the language.

use proc_macro2::Ident;

use crate::ast::{Declaration, Let};
use crate::errors::{Errors, Reported};
use crate::graph::NodeId;
use crate::input::Fields;

/// Names with a meaning of their own.
pub(crate) const RESERVED: [(&str, &str); 3] = [
    ("h", "the step"),
    ("dot", "the time derivative"),
    ("ddot", "the second time derivative"),
];

/// What a name stands for.
#[derive(Clone, Debug)]
pub(crate) enum Binding {
    /// A coordinate, by its place.
    Coordinate(usize),
    /// A field of the struct, by its place.
    Field(usize),
    /// A `let`.
    Let(Result<NodeId, Reported>),
    /// A node of the discrete path, in a map: 0, 1 or 2.
    Node(usize),
    /// A `let` in a map, with its components.
    Vector(Result<Vec<NodeId>, Reported>),
}

impl Binding {
    /// The kind of name, for a message.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Coordinate(_) => "a coordinate",
            Self::Field(_) => "a parameter",
            Self::Let(_) | Self::Vector(_) => "a `let`",
            Self::Node(_) => "a node",
        }
    }
}

/// The names that can be used at some place.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scope {
    names: Vec<(String, Binding)>,
}

impl Scope {
    /// The innermost meaning of a name.
    pub(crate) fn get(&self, name: &Ident) -> Option<&Binding> {
        self.names
            .iter()
            .rev()
            .find(|(known, _)| name == known)
            .map(|(_, binding)| binding)
    }

    /// Adds a name whose clashes have been checked.
    pub(crate) fn push(&mut self, name: &Ident, binding: Binding) {
        self.names.push((name.to_string(), binding));
    }

    /// Adds a name unless it is in use.
    pub(crate) fn define(&mut self, name: &Ident, binding: Binding, errors: &Errors) -> Result<(), Reported> {
        let result = match self.get(name) {
            Some(known) => Err(clash(name, known.kind(), errors)),
            None => check_reserved(name, errors),
        };
        self.push(name, binding);
        result
    }

    /// How many names there are now, for [`Scope::truncate`].
    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    /// Forgets the names that came after.
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

/// Reports every top-level name that has a meaning already, at the second one.
pub(crate) fn check<'d>(declaration: &'d Declaration, fields: &'d Fields, errors: &Errors) {
    let mut known: Vec<(&Ident, &str)> = Vec::new();
    let mut add = |name: &'d Ident, kind| {
        if let Some((_, first)) = known.iter().find(|(known, _)| *known == name) {
            clash(name, first, errors);
        } else {
            // a reserved word has been reported; what else it clashes with does not matter
            let _ = check_reserved(name, errors);
            known.push((name, kind));
        }
    };
    let coordinates = declaration.coordinates.given();
    let split = coordinates
        .map_or(0, |coordinates| coordinates.lets_before)
        .min(declaration.lets.len());
    let (before, after) = declaration.lets.split_at(split);
    let lets = |lets: &'d [Let]| lets.iter().map(|binding| (&binding.name, "a `let`"));
    let coordinates = coordinates
        .iter()
        .flat_map(|part| &part.names)
        .map(|name| (name, "a coordinate"));
    let fields = fields.iter().map(|field| (&field.ident, "a parameter"));
    for (name, kind) in lets(before).chain(coordinates).chain(lets(after)).chain(fields) {
        add(name, kind);
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

fn clash(name: &Ident, kind: &str, errors: &Errors) -> Reported {
    errors.at(
        name,
        format!("`{name}` is the name of {kind} already; expected another name"),
    )
}

/// `; did you mean …?` with the nearest of the candidates, or nothing if none is near.
pub(crate) fn did_you_mean<'c>(found: &str, candidates: impl IntoIterator<Item = &'c str>) -> String {
    nearest(found, candidates)
        .map(|name| format!("; did you mean `{name}`?"))
        .unwrap_or_default()
}

/// The nearest of the candidates, if one is near.
pub(crate) fn nearest<'c>(found: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    let limit = found.chars().count().max(3) / 3;
    candidates
        .into_iter()
        .map(|name| (strsim::damerau_levenshtein(found, name), name))
        // a name of one letter is one edit away from every other one
        .filter(|&(distance, name)| distance <= limit && distance < name.chars().count())
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, name)| name)
}
