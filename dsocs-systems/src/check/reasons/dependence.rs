//! Constraints that nearly depend on each other. The rounding of figures grows as the reciprocal of the part
//! of a constraint that is independent of the others.

use dsocs_core::{Declaration, DependentRow, Kernel, OwnedLeg, least_independent};

use crate::check::Finding;
use crate::stability::{Bar, written_time};

/// A constraint is reported if a smaller part of it is independent of the others.
const REPORTED_PART: f64 = 1e-4;

/// Below this part, its square is rounding: neither a rank nor two distinct roots can be found.
const PART_WITH_ROUNDED_SQUARE: f64 = 1e-7;

/// The error of a figure, in units of rounding over the independent part.
const ROUNDINGS: f64 = 64.0;

/// The largest number of nodes at which constraints are tested.
const MOST_NODES: usize = 24;

/// The constraint with the smallest part that is independent of those before it.
pub struct NearlyDependentConstraint {
    row: DependentRow,
    /// The norm of its independent part, relative to the constraint.
    independent_part: f64,
    /// The time at which it is smallest, in s.
    t: f64,
    /// The shortest leg, relative to the position.
    shortest_leg: f64,
}

impl NearlyDependentConstraint {
    /// The constraint with the smallest independent part along a motion, if this part is below
    /// `REPORTED_PART`.
    pub fn along(kernel: &dyn Kernel, h: f64, legs: &[OwnedLeg<f64>]) -> Option<Self> {
        let declaration = Declaration::of(kernel);
        let every = legs.len().div_ceil(MOST_NODES).max(1);
        let size = |x: &[f64]| x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        let mut least: Option<Self> = None;
        for leg in legs.iter().step_by(every) {
            let v: Vec<f64> = leg.d.iter().map(|d| d / h).collect();
            let (row, independent_part) = least_independent(&declaration, leg.t, &leg.q, &v)?;
            if independent_part
                < least
                    .as_ref()
                    .map_or(REPORTED_PART, |least| least.independent_part)
            {
                let (t, shortest_leg) = (leg.t, f64::INFINITY);
                least = Some(Self {
                    row,
                    independent_part,
                    t,
                    shortest_leg,
                });
            }
        }
        let parts = legs
            .iter()
            .map(|leg| size(&leg.d) / size(&leg.q).max(size(&leg.d)));
        let shortest_leg = parts.filter(|part| *part > 0.0).fold(1.0, f64::min);
        least.map(|least| Self {
            shortest_leg,
            ..least
        })
    }

    /// The relative error of a position.
    pub fn relative_error(&self) -> f64 {
        ROUNDINGS * f64::EPSILON / self.independent_part
    }

    /// The reason why a figure need not meet its bar, if it misses it by no more than rounding.
    pub fn excuse(&self, finding: &Finding) -> Option<String> {
        let is_rounding = match finding.bar {
            _ if finding.failure.is_some() => self.independent_part < PART_WITH_ROUNDED_SQUARE,
            // counts
            Bar::AtMost(0.0) => self.independent_part < PART_WITH_ROUNDED_SQUARE,
            // relative to a leg the error is larger; two roots that coincide are apart by as much
            Bar::AtMost(_) => finding.figure <= self.relative_error() / self.shortest_leg,
            Bar::AtLeast(_) if finding.check == "roots" => {
                finding.figure <= self.relative_error() / self.shortest_leg
            }
            Bar::AtLeast(_) | Bar::Reported => false,
        };
        is_rounding.then(|| self.reason())
    }

    /// The constraint, its independent part and the error, in words.
    pub fn reason(&self) -> String {
        let (row, part, t) = (&self.row, self.independent_part, written_time(self.t));
        format!(
            "not required here: the theorem is about constraints that are independent, and {row} says nothing beside those before it but for \
             a part of {part:.0e}, at t = {t}, as the masses weigh directions: what is measured is known to about {:.0e} only, relative to a leg \
             to {:.0e}; if the rows say nearly the same, leave the constraint out, or write what is left of it alone; if they differ in the \
             motion of a light mass only, make it heavier",
            self.relative_error(),
            self.relative_error() / self.shortest_leg
        )
    }
}
