//! Detects constraints that nearly depend on each other, which limit the accuracy that a tolerance can ask
//! for.

use dsocs_core::{DependentRow, least_independent};

use crate::entry::Row;

/// The least independent constraint of a run.
#[derive(Default)]
pub struct Dependence {
    /// The number of the next node that is tested: each is twice that of the one before.
    next: u64,
    /// The constraint, its independent part relative to the whole, and the time.
    least: Option<(DependentRow, f64, f64)>,
}

impl Dependence {
    /// Looks at a node.
    #[inline]
    pub fn look<'r>(&mut self, index: u64, row: &impl Fn() -> Row<'r>) {
        if index >= self.next {
            self.look_at_constraints(&row());
        }
    }

    #[cold]
    fn look_at_constraints(&mut self, row: &Row<'_>) {
        self.next = 2 * row.node.index + 1;
        let (t, q, v) = (row.node.t, row.node.q, row.node.v);
        if let Some((constraint, part)) = least_independent(&row.declaration, t, q, v)
            && self.least.as_ref().is_none_or(|(_, least, _)| part < *least)
        {
            self.least = Some((constraint, part, t));
        }
    }

    /// The warning for a run to a tolerance.
    pub fn note(&self, tolerance: f64) -> Option<String> {
        let (constraint, part, t) = self.least.as_ref()?;
        let known = f64::EPSILON / part;
        (known > tolerance).then(|| {
            format!(
                "warning: {constraint} says nothing beside those before it but for a part of {part:.0e}, at t = {t}, as the masses weigh directions: \
                 rounding alone may change the motion and the forces by about {known:.0e}, whatever the tolerance (if the rows say nearly the same, \
                 leave the constraint out, or write what is left of it alone; if they differ in the motion of a light mass only, make it heavier)"
            )
        })
    }
}
