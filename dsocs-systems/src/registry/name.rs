//! Names that do not exist.

use thiserror::Error;

/// A name that does not exist, and those that do.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no {kind} `{name}`{}; known: {}", suggestion(.nearest.as_deref()), .known.join(", "))]
pub struct UnknownName {
    /// What the name should have named.
    pub kind: &'static str,
    /// The name.
    pub name: String,
    /// The name that is nearest, if one is near.
    pub nearest: Option<String>,
    /// All names.
    pub known: Vec<String>,
}

impl UnknownName {
    /// The error for a name that is none of `known`.
    pub fn new<T: Into<String>>(kind: &'static str, name: &str, known: impl IntoIterator<Item = T>) -> Self {
        let known: Vec<String> = known.into_iter().map(Into::into).collect();
        let lower = name.to_lowercase();
        let nearest = known
            .iter()
            .map(|candidate| (strsim::jaro_winkler(&candidate.to_lowercase(), &lower), candidate))
            .filter(|&(similarity, _)| similarity > 0.7)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, candidate)| candidate.clone());
        Self {
            kind,
            name: name.to_owned(),
            nearest,
            known,
        }
    }
}

/// The question after the nearest name.
fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |nearest| format!(" (did you mean `{nearest}`?)"))
}
