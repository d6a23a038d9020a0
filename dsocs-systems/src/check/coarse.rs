//! Times that are large beside a step, and positions that are large beside a leg: their last digits show in what is measured relative to these.

use dsocs_core::geometry::{FlowTheorem, Triple, depends_on_time};
use dsocs_core::{Kernel, OwnedLeg};

use super::probe::less;
use super::{Finding, larger};
use crate::stability::{Bar, number};

/// What is measured is known to so many roundings.
const ROUNDINGS: f64 = 4.0;

/// Below this part of a step or of a leg, a rounding is as small as those of the numbers that all bars know.
const FINE: f64 = 1e-14;

/// A time is large that is so many times as long as the motion, or as many steps as the second.
const LATE: [f64; 2] = [8.0, 1e6];

/// Positions are large that are so many times as far as the motion goes.
const FAR: f64 = 1e3;

/// A leg that is a smaller part of the position is rounding: there something rests.
const RESTS: f64 = 1e4 * f64::EPSILON;

/// What the rounding of times and of positions makes of a motion.
pub struct Coarse {
    /// The last time, and half of its last digit.
    time: [f64; 2],
    /// The largest coordinate, and half of its last digit.
    place: [f64; 2],
    /// What these are of a step, if the time is large and anything depends on it, and of the shortest leg, if positions are large.
    parts: [f64; 2],
    /// What is left of the least singular value of `D₁` beside the largest.
    left: f64,
}

impl Coarse {
    /// That along a motion, with triples of it.
    pub fn along(kernel: &dyn Kernel, h: f64, legs: &[OwnedLeg<f64>], triples: &[Triple]) -> Self {
        let size = |x: &[f64]| x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        let half = |x: f64| x * f64::EPSILON / 2.0;
        let known = |x: f64| [x, half(x)];
        let time = known(legs.iter().fold(0.0, |most, leg| larger(most, leg.t.abs())));
        let place = known(legs.iter().fold(0.0, |most, leg| larger(most, size(&leg.q))));
        let lengths = legs.iter().map(|leg| size(&leg.d));
        let moving = lengths.filter(|length| *length > RESTS * place[0]);
        let leg = moving.fold(f64::INFINITY, f64::min);
        let [lasts, goes] = legs.first().map_or([0.0; 2], |first| {
            let apart = |leg: &OwnedLeg<f64>| size(&less(&leg.q, &first.q));
            [
                legs.iter()
                    .fold(0.0, |most, leg| larger(most, (leg.t - first.t).abs())),
                legs.iter().fold(0.0, |most, leg| larger(most, apart(leg))),
            ]
        });
        let is_late = time[0] > LATE[0] * lasts || time[0] > LATE[1] * h.abs();
        let is_timed = is_late && triples.iter().any(|triple| depends_on_time(kernel, h, triple));
        let is_far = place[0] > FAR * goes;
        let left = triples.iter().map(|triple| {
            let at = FlowTheorem::at(kernel, h, triple.leg.any(), &triple.e).regularity;
            at.backward / at.largest_backward
        });
        Self {
            time,
            place,
            parts: [
                if is_timed { time[1] / h.abs() } else { 0.0 },
                if is_far { place[1] / leg } else { 0.0 },
            ],
            left: left.fold(1.0, f64::min),
        }
    }

    /// To what part of a step or of a leg the motion is known, where that is less than to the digits of a number.
    pub fn known(&self) -> Option<f64> {
        let known = ROUNDINGS * (self.parts[0] + self.parts[1]);
        (known > FINE).then_some(known)
    }

    /// Why a figure need not meet its bar, if it misses it by no more than these roundings make of it.
    pub fn excuse(&self, finding: &Finding) -> Option<String> {
        let known = self.known()?;
        let is_rounding = match finding.bar {
            // a step back whose equations are singular to rounding
            _ if finding.failure.is_some() => finding.check == "reversibility" && self.left <= known,
            Bar::AtMost(bar) => bar > 0.0 && finding.figure <= known,
            Bar::AtLeast(_) | Bar::Reported => false,
        };
        is_rounding.then(|| self.reason())
    }

    /// Which numbers are rounded to what.
    pub fn reason(&self) -> String {
        let parts = [
            (
                "time",
                self.time,
                self.parts[0],
                "a step",
                "count the time from near the start",
            ),
            (
                "positions",
                self.place,
                self.parts[1],
                "a leg",
                "measure positions from near the motion",
            ),
        ];
        let told = parts.iter().filter(|part| ROUNDINGS * part.2 > FINE / 2.0);
        let told: Vec<(String, &str)> = told
            .map(|(what, [size, half], part, of, cure)| {
                let size = number(*size);
                (
                    format!("the rounding of the {what} at {size} is {half:.0e}, {part:.0e} of {of}"),
                    *cure,
                )
            })
            .collect();
        let (what, cures): (Vec<String>, Vec<&str>) = told.into_iter().unzip();
        format!(
            "not required here: {}, and what is measured relative to that is known to no more; to see it required, {}",
            what.join(", and "),
            cures.join(", and ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is measured against a bar.
    fn finding(bar: Bar, figure: f64) -> Finding {
        Finding {
            check: "equations",
            what: String::new(),
            figure,
            bar,
            failure: None,
            note: None,
            excuse: None,
        }
    }

    #[test]
    fn only_what_rounding_makes_is_open() {
        let late = |t: f64, time: f64| Coarse {
            time: [t, t * f64::EPSILON / 2.0],
            place: [1.0, f64::EPSILON / 2.0],
            parts: [time, 0.0],
            left: 1.0,
        };
        // at t = 1e6 with steps of 0.01
        let coarse = late(1e6, 1e6 * f64::EPSILON / 2.0 / 0.01);
        assert!(coarse.excuse(&finding(Bar::AtMost(1e-12), 1e-9)).is_some());
        assert_eq!(coarse.excuse(&finding(Bar::AtMost(1e-12), 1e-7)), None);
        assert_eq!(coarse.excuse(&finding(Bar::AtMost(1e-12), f64::NAN)), None);
        // no order, no count and no step that is not found
        assert_eq!(coarse.excuse(&finding(Bar::AtLeast(1.9), 1.8)), None);
        assert_eq!(coarse.excuse(&finding(Bar::AtMost(0.0), 1e-9)), None);
        let without = Finding {
            check: "reversibility",
            failure: Some("no node before".to_owned()),
            ..finding(Bar::AtMost(1e-12), f64::NAN)
        };
        assert_eq!(coarse.excuse(&without), None);
        // and nothing where the time is not large
        assert_eq!(late(1.0, 0.0).excuse(&finding(Bar::AtMost(1e-12), 2e-12)), None);
    }
}
