//! Unknown names.

use thiserror::Error;

/// A name that does not exist, and those that do.
#[derive(Clone, PartialEq, Eq, Error)]
#[error(
    "there is no {kind} `{name}`{}{}{}",
    suggestion(.nearest.as_deref()), .reason.as_deref().unwrap_or_default(), listed(.known)
)]
pub struct UnknownName {
    /// The kind of thing that was named.
    pub kind: &'static str,
    /// The name.
    pub name: String,
    /// The name that is nearest, if one is near.
    pub nearest: Option<Box<str>>,
    /// A remark on something else of that name.
    pub reason: Option<Box<str>>,
    /// All names.
    pub known: Box<[String]>,
}

dsocs_core::debug_is_message!(UnknownName);

impl UnknownName {
    /// The error for a name that is none of `known`.
    pub fn new<T: Into<String>>(kind: &'static str, name: &str, known: impl IntoIterator<Item = T>) -> Self {
        let known: Vec<String> = known.into_iter().map(Into::into).collect();
        let nearest = nearest(name, &known).map(Into::into);
        Self {
            kind,
            name: name.to_owned(),
            nearest,
            reason: None,
            known: known.into(),
        }
    }

    /// The error for a name that belongs to something else; `reason` follows the name in the message.
    #[must_use]
    pub fn of_other_kind(self, reason: String) -> Self {
        Self {
            reason: Some(reason.into()),
            ..self
        }
    }
}

/// The names that exist.
fn listed(known: &[String]) -> String {
    if known.is_empty() {
        "; none is declared".to_owned()
    } else {
        format!("; known: {}", known.join(", "))
    }
}

/// The nearest name, if it is near: at most one mistake in three letters, or its beginning.
fn nearest(name: &str, known: &[String]) -> Option<String> {
    let name = name.to_lowercase();
    let letters = name.chars().count();
    let mistakes = known.iter().map(|candidate| {
        let candidate_low = candidate.to_lowercase();
        let begins = letters >= 3 && candidate_low.starts_with(&name);
        let mistakes = strsim::damerau_levenshtein(&candidate_low, &name);
        (if begins { 0 } else { mistakes }, candidate)
    });
    mistakes
        // a name of one letter is one mistake away from every other one
        .filter(|&(mistakes, candidate)| {
            mistakes <= letters.max(3) / 3 && mistakes < candidate.chars().count()
        })
        .min_by_key(|&(mistakes, _)| mistakes)
        .map(|(_, candidate)| candidate.clone())
}

/// The name of a type in the form `my-system`.
pub(super) fn kebab(name: &str) -> String {
    let mut kebab = String::new();
    let mut before: Option<char> = None;
    let mut letters = name.chars().peekable();
    while let Some(letter) = letters.next() {
        let next = letters.peek();
        let begins_word = letter.is_uppercase()
            && before
                .is_some_and(|before| !before.is_uppercase() || next.is_some_and(|next| next.is_lowercase()));
        if letter == '_' || begins_word {
            kebab.push('-');
        }
        if letter != '_' {
            kebab.extend(letter.to_lowercase());
        }
        before = (letter != '_').then_some(letter);
    }
    kebab
}

/// The question after the nearest name.
fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |nearest| format!(" (did you mean `{nearest}`?)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_have_names_for_the_command_line() {
        for (name, expected) in [
            ("Pendulum", "pendulum"),
            ("BeadOnHoop", "bead-on-hoop"),
            ("RLCircuit", "rl-circuit"),
            ("PlanarChain8", "planar-chain8"),
            ("Chain8Links", "chain8-links"),
            ("Two_Masses", "two-masses"),
        ] {
            assert_eq!(kebab(name), expected);
        }
    }

    #[test]
    fn the_nearest_name_is_suggested() {
        let known = ["pendulum", "particle", "length"];
        let nearest = |name| UnknownName::new("system", name, known).nearest;
        assert_eq!(nearest("pendulm").as_deref(), Some("pendulum"));
        assert_eq!(nearest("Particel").as_deref(), Some("particle"));
        assert_eq!(nearest("lenght").as_deref(), Some("length"));
        assert_eq!(nearest("pend").as_deref(), Some("pendulum"));
        assert_eq!(nearest("xyz"), None);
        // a letter that a long name contains is not near it
        let nearest = |name| UnknownName::new("parameter", name, ["n", "m", "mass"]).nearest;
        assert_eq!(nearest("lenght"), None);
        assert_eq!(nearest("x"), None);
        assert_eq!(nearest("Masss").as_deref(), Some("mass"));
    }
}
