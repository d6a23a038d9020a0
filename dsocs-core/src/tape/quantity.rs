//! Names and documentation of a declaration's quantities.

use std::borrow::Cow;

/// Name and documentation of a quantity of a declaration: a coordinate, a parameter or an observed expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// The name in the declaration; `masses_2` for an element of an array.
    pub name: Cow<'static, str>,
    /// The documentation in one line. By convention it ends with the unit in brackets: `The mass of the rod \[kg\].`
    pub doc: Cow<'static, str>,
}

impl Quantity {
    /// A quantity whose name and documentation are known when the program is compiled.
    #[must_use]
    pub const fn new(name: &'static str, doc: &'static str) -> Self {
        Self {
            name: Cow::Borrowed(name),
            doc: Cow::Borrowed(doc),
        }
    }

    /// The unit, if the documentation ends with one in brackets.
    ///
    /// ```
    /// use dsocs_core::Quantity;
    ///
    /// let inertia = Quantity::new("inertia", "The moment of inertia `I` of the wheel [kg m²].");
    /// assert_eq!((inertia.meaning(), inertia.unit()), ("The moment of inertia `I` of the wheel", Some("kg m²")));
    /// // a unit of one word is written `\[kg\]`, since rustdoc takes `[kg]` for a link
    /// let mass = Quantity::new("mass", r"The mass \[kg\]");
    /// assert_eq!((mass.meaning(), mass.unit()), ("The mass", Some("kg")));
    /// assert_eq!(Quantity::new("psi", "The angle.").unit(), None);
    /// ```
    #[must_use]
    pub fn unit(&self) -> Option<&str> {
        self.parts().1
    }

    /// The documentation without the unit and the full stop.
    #[must_use]
    pub fn meaning(&self) -> &str {
        self.parts().0
    }

    /// The documentation and the unit at its end.
    fn parts(&self) -> (&str, Option<&str>) {
        let doc = self.doc.trim_end().trim_end_matches('.');
        match doc.strip_suffix(']').and_then(|doc| doc.rsplit_once('[')) {
            Some((doc, unit)) => (
                doc.trim_end_matches('\\').trim_end(),
                Some(unit.trim_end_matches('\\')),
            ),
            None => (doc, None),
        }
    }
}
