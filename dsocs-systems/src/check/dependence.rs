//! Constraints that nearly depend on each other: what is measured with them is known to the rounding of a number over what is left of one beside the others.

use dsocs_core::{Declaration, DependentRow, Kernel, OwnedLeg, least_independent};

use super::Finding;
use crate::stability::{Bar, number};

/// So much of a constraint has to be left beside the others, or it is said.
const LEFT: f64 = 1e-4;

/// Where less is left, its square is no more than rounding: no rank is known, and no root from another one.
const HARDLY: f64 = 1e-7;

/// What is measured is known to so many roundings over what is left.
const ROUNDINGS: f64 = 64.0;

/// Constraints are looked at in so many places of a motion.
const PLACES: usize = 24;

/// The constraint that says least beside those before it.
pub struct Dependent {
    row: DependentRow,
    /// What is left of it.
    part: f64,
    /// When.
    t: f64,
    /// The shortest part of a position that a leg is.
    leg: f64,
}

impl Dependent {
    /// That along a motion, if little is left of it.
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

    /// To what part of itself a position is known.
    pub fn known(&self) -> f64 {
        ROUNDINGS * f64::EPSILON / self.part
    }

    /// Why a figure need not meet its bar, if it misses it by no more than rounding makes of it.
    pub fn excuse(&self, finding: &Finding) -> Option<String> {
        let is_rounding = match finding.bar {
            _ if finding.failure.is_some() => self.part < HARDLY,
            // of whole numbers
            Bar::AtMost(0.0) => self.part < HARDLY,
            // relative to a leg, what is known is so much less; two roots that are one are as near to each other
            Bar::AtMost(_) => finding.figure <= self.known() / self.leg,
            Bar::AtLeast(_) if finding.check == "roots" => finding.figure <= self.known() / self.leg,
            Bar::AtLeast(_) | Bar::Reported => false,
        };
        is_rounding.then(|| self.reason())
    }

    /// What the constraint leaves unknown.
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
