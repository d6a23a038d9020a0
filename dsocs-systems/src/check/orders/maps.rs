//! The orders of one system with other discretization maps.

use dsocs_core::text::Text;

use super::Orders;

/// A choice of discretization maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Map {
    /// The name in a table.
    pub name: &'static str,
    /// The statements that replace the declared ones, each with its value. Empty for the maps as declared.
    pub statements: &'static [(&'static str, &'static str)],
    /// Whether it needs constraints on accelerations.
    pub of_accelerations: bool,
}

/// The forward difference of the velocity in place of the central one: a map of first order.
const FORWARD_DIFFERENCE: &str = "|q0, q1, q2| (q1, (q2 - q1) / h, (q2 - 2 * q1 + q0) / (h * h))";

/// The maps of a comparison: those declared, the named ones of `L_d`, and maps of `D_K` and `D_V` of second
/// and of first order.
pub const MAPS: [Map; 7] = [
    Map {
        name: "declared",
        statements: &[],
        of_accelerations: false,
    },
    Map {
        name: "L: paper",
        statements: &[("phi_lagrangian", "paper")],
        of_accelerations: false,
    },
    Map {
        name: "L: midpoint",
        statements: &[("phi_lagrangian", "midpoint")],
        of_accelerations: false,
    },
    Map {
        name: "L: trapezoid",
        statements: &[("phi_lagrangian", "trapezoid")],
        of_accelerations: false,
    },
    Map {
        name: "K: midpoint",
        statements: &[("phi_kinematic", "midpoint"), ("phi_variational", "paper")],
        of_accelerations: true,
    },
    Map {
        name: "K: ahead",
        statements: &[
            ("phi_kinematic", FORWARD_DIFFERENCE),
            ("phi_variational", "paper"),
        ],
        of_accelerations: true,
    },
    Map {
        name: "V: ahead",
        statements: &[
            ("phi_kinematic", "paper"),
            ("phi_variational", FORWARD_DIFFERENCE),
        ],
        of_accelerations: true,
    },
];

/// A system with one choice of maps.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// The maps.
    pub map: Map,
    /// The orders, or the reason why there are none: the declaration may not admit these maps, or the motion
    /// may fail with them.
    pub orders: Result<Orders, String>,
}

impl Variant {
    /// The system with the maps as declared.
    #[must_use]
    pub fn declared(orders: Orders) -> Self {
        let [map, ..] = MAPS;
        Self {
            map,
            orders: Ok(orders),
        }
    }

    /// Whether the order measured is the one that follows, or is excused; also where there is no motion.
    #[must_use]
    pub fn ok(&self) -> bool {
        self.orders.as_ref().map_or(true, Orders::ok)
    }
}

impl Map {
    /// Whether the maps apply to a declaration: they do not to a discrete Lagrangian or constraint that is
    /// given directly.
    pub(crate) fn is_for(&self, declaration: &str, accelerations: usize) -> bool {
        let gives = |statement: &str| statement_of(declaration, statement).is_some();
        let replaced = |(statement, _): &(&str, &str)| match *statement {
            "phi_lagrangian" => gives("discrete_lagrangian"),
            _ => gives("discrete_kinematic"),
        };
        (accelerations > 0 || !self.of_accelerations) && !self.statements.iter().any(replaced)
    }

    /// The text of a system with these maps in place of its own.
    pub(crate) fn written_into(&self, text: &str) -> String {
        let mut text = text.to_owned();
        for (statement, value) in self.statements {
            if let Some([from, to]) = range_of_statement(&text, statement) {
                text.replace_range(from..to, "");
            }
            // statements stand in any order, and every text has coordinates
            let place = range_of_statement(&text, "coordinates").map_or(0, |[from, _]| from);
            text.insert_str(place, &format!("{statement} = {value};\n"));
        }
        text
    }

    /// The system of this text with these maps.
    pub(crate) fn read(
        &self,
        name: &str,
        text: &str,
        samples: &[(String, Vec<(f64, f64)>)],
    ) -> Result<Text, String> {
        Text::parse_with(name, &self.written_into(text), &[], samples).map_err(|error| error.to_string())
    }
}

/// The range of a statement in a declaration, from its name to behind its semicolon.
fn range_of_statement(declaration: &str, statement: &str) -> Option<[usize; 2]> {
    let mut from = 0;
    for line in declaration.split_inclusive('\n') {
        let begins = line.trim_start();
        let is_it = begins
            .strip_prefix(statement)
            .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'));
        if is_it {
            let begin = from + line.len() - begins.len();
            let end = declaration[begin..].find(';')?;
            return Some([begin, begin + end + 1]);
        }
        from += line.len();
    }
    None
}

/// A statement of a declaration, without its name and its semicolon.
pub(crate) fn statement_of<'d>(declaration: &'d str, statement: &str) -> Option<&'d str> {
    let [from, to] = range_of_statement(declaration, statement)?;
    let (_, value) = declaration[from..to].split_once('=')?;
    Some(value.trim_end_matches(';').trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "//! A bead; on a wire.
coordinates(
    /// The place; along the wire [m]
    x
);
lagrangian = (1 + x.powi(2)) / 2 * dot(x).powi(2);
phi_lagrangian = |q0, q1| (
    (q0 + q1) / 2, (q1 - q0) / h
);
run { start = ([1.0], [0.5]); }
";

    #[test]
    fn maps_take_the_place_of_declared_ones() {
        assert_eq!(
            statement_of(TEXT, "phi_lagrangian"),
            Some("|q0, q1| (\n    (q0 + q1) / 2, (q1 - q0) / h\n)")
        );
        assert_eq!(statement_of(TEXT, "phi"), None);
        for map in MAPS.iter().filter(|map| !map.of_accelerations) {
            let text = map.read("bead", TEXT, &[]).unwrap();
            let value = map.statements.first().map(|(_, value)| *value);
            let found = statement_of(&text.text, "phi_lagrangian");
            assert!(value.is_none_or(|value| found == Some(value)), "{found:?}");
        }
    }
}
