//! Parameters, for people.

/// A parameter and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterValue {
    /// The name.
    pub name: &'static str,
    /// The value.
    pub value: f64,
    /// The unit, 1 for a number without.
    pub unit: &'static str,
    /// What it is.
    pub description: &'static str,
}

impl ParameterValue {
    /// Takes the unit off the end of a parameter's documentation.
    pub(super) fn new(name: &'static str, doc: &'static str, value: f64) -> Self {
        let doc = doc.trim_end().trim_end_matches('.');
        // a unit of one word is written `\[kg\]`, since `[kg]` would be a link
        let parts = doc.strip_suffix(']').and_then(|doc| doc.rsplit_once('['));
        let (description, unit) = parts.unwrap_or((doc, "1"));
        let (description, unit) = (
            description.trim_end_matches('\\').trim_end(),
            unit.trim_end_matches('\\'),
        );
        Self {
            name,
            value,
            unit,
            description,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_come_from_the_documentation() {
        let parameter = ParameterValue::new("m", "The mass of the particle [kg].", 1.0);
        assert_eq!(
            (parameter.description, parameter.unit),
            ("The mass of the particle", "kg")
        );
    }
}
