//! Constraints that nearly depend on each other. The rounding of figures grows as the reciprocal of the part
//! of a constraint that is independent of the others.

use dsocs_core::{Declaration, DependentRow, Kernel, OwnedLeg, least_independent};

use super::Finding;
use crate::stability::{Bar, number};

/// A constraint is reported if a smaller part of it is independent of the others.
const LEFT: f64 = 1e-4;

/// Below this part, its square is rounding: neither a rank nor two distinct roots can be found.
const HARDLY: f64 = 1e-7;

/// The error of a figure, in units of rounding over the independent part.
const ROUNDINGS: f64 = 64.0;

/// The largest number of nodes at which constraints are tested.
const PLACES: usize = 24;

/// The constraint with the smallest part that is independent of those before it.
pub struct Dependent {
    row: DependentRow,
    /// The norm of its independent part, relative to the constraint.
    part: f64,
    /// The time at which it is smallest, in s.
    t: f64,
    /// The shortest leg, relative to the position.
    leg: f64,
}

impl Dependent {
    /// That constraint along a motion, if its independent part is small.
    pub fn along(kernel: &dyn Kernel, h: f64, legs: &[OwnedLeg<f64>]) -> Option<Self> {
        let declaration = Declaration::of(kernel);
        let every = legs.len().div_ceil(PLACES).max(1);
        let size = |x: &[f64]| x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        let mut least: Option<Self> = None;
        for leg in legs.iter().step_by(every) {
            let v: Vec<f64> = leg.d.iter().map(|d| d / h).collect();
            let (row, part) = least_independent(&declaration, leg.t, &leg.q, &v)?;
            if part < least.as_ref().map_or(LEFT, |least| least.part) {
                let (t, leg) = (leg.t, f64::INFINITY);
                least = Some(Self { row, part, t, leg });
            }
        }
        let parts = legs
            .iter()
            .map(|leg| size(&leg.d) / size(&leg.q).max(size(&leg.d)));
        let leg = parts.filter(|part| *part > 0.0).fold(1.0, f64::min);
        least.map(|least| Self { leg, ..least })
    }

    /// The relative error of a position.
    pub fn known(&self) -> f64 {
        ROUNDINGS * f64::EPSILON / self.part
    }

    /// The reason why a figure need not meet its bar, if it misses it by no more than rounding.
    pub fn excuse(&self, finding: &Finding) -> Option<String> {
        let is_rounding = match finding.bar {
            _ if finding.failure.is_some() => self.part < HARDLY,
            // counts
            Bar::AtMost(0.0) => self.part < HARDLY,
            // relative to a leg the error is larger; two roots that coincide are apart by as much
            Bar::AtMost(_) => finding.figure <= self.known() / self.leg,
            Bar::AtLeast(_) if finding.check == "roots" => finding.figure <= self.known() / self.leg,
            Bar::AtLeast(_) | Bar::Reported => false,
        };
        is_rounding.then(|| self.reason())
    }

    /// The constraint, its independent part and the error, in words.
    pub fn reason(&self) -> String {
        let (row, part, t) = (&self.row, self.part, number(self.t));
        format!(
            "not required here: the theorem is about constraints that are independent, and {row} says nothing beside those before it but for a part of {part:.0e}, at t = {t}: what is \
             measured is known to about {:.0e} only, relative to a leg to {:.0e}; leave the constraint out, or write what is left of it alone",
            self.known(),
            self.known() / self.leg
        )
    }
}
