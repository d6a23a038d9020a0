//! The one namespace of a declaration: coordinates, fields, `let`s and the words of the language.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use proc_macro2::Ident;

use crate::mistakes::errors::{Errors, Reported};
use crate::syntax::ast::{Declaration, Group, Let};
use crate::syntax::input::{Fields, ParameterField};

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

/// The names of the settings of a run in a text.
pub(crate) const SETTINGS_OF_RUN: [&str; 6] = [
    "start",
    "acceleration",
    "near_acceleration",
    "project",
    "step",
    "until",
];

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
    let of_fields = fields.iter().map(|field| &field.ident).chain(&elements);
    let of_fields = of_fields.map(|name| (name, "a parameter"));
    for (name, kind) in lets(before)
        .chain(coordinates)
        .chain(lets(after))
        .chain(of_fields)
    {
        add(name, kind);
    }
    let Some(coordinates) = declaration.coordinates.given() else {
        return;
    };
    // the mistakes are reported; the declaration can be read all the same
    for name in &coordinates.names {
        let _ = check_column(name, name, &coordinates.names, errors);
    }
    let mut refused = None;
    for ParameterField { name, ident, .. } in fields.parameters() {
        // of an array that is refused, its elements are not named, too
        if refused.as_ref() == Some(&ident) {
            continue;
        }
        let checked = check_column(&ident, &ident, &coordinates.names, errors)
            .and_then(|()| check_column(&name, &ident, &coordinates.names, errors));
        if checked.is_err() {
            refused = Some(ident);
        }
    }
}

/// Refuses the name of a coordinate, a parameter or an observable that another column of a run's results has. It is reported at
/// `tokens`.
pub(crate) fn check_column(
    name: &impl ToString,
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
            ("a_", "the acceleration"),
            ("force_", "the force"),
            ("error_", "the error"),
        ]
        .into_iter()
        .find_map(of_coordinate),
    };
    match what {
        Some(what) => Err(errors.at(
            tokens,
            format!("in the results of a run `{text}` is the column of {what}; expected another name"),
        )),
        None => Ok(()),
    }
}

pub(crate) fn check_reserved(name: &Ident, errors: &Errors) -> Result<(), Reported> {
    match RESERVED.iter().find(|(word, _)| name == word) {
        Some((word, meaning)) => Err(errors.at(
            name,
            format!("`{word}` means {meaning} in a declaration; expected another name"),
        )),
        None => Ok(()),
    }
}

pub(crate) fn report_clash(name: &Ident, kind: &str, errors: &Errors) -> Reported {
    errors.at(
        name,
        format!("`{name}` is the name of {kind} already; expected another name"),
    )
}
