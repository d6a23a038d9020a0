//! The rounding of large times and positions, relative to a step and to a leg: it limits the digits of
//! figures that are relative to these.

use dsocs_core::geometry::{FlowTheorem, Triple, depends_on_time};
use dsocs_core::{Kernel, OwnedLeg};

use super::probe::less;
use super::{Finding, larger};
use crate::stability::{Bar, number};

/// The error of a figure, in units of the rounding of a time or position.
const ROUNDINGS: f64 = 4.0;

/// A relative rounding below this is covered by the bars of all checks.
const FINE: f64 = 1e-14;

/// A time is large if it exceeds this many durations of the motion, or this many steps.
const LATE: [f64; 2] = [8.0, 1e6];

/// Positions are large if they exceed this many times the extent of the motion.
const FAR: f64 = 1e3;

/// A leg below this part of the position is rounding: the motion rests there.
const RESTS: f64 = 1e4 * f64::EPSILON;

/// The rounding of times and positions along a motion.
pub struct Coarse {
    /// The largest time, and half a unit in its last place.
    time: [f64; 2],
    /// The largest coordinate, and half a unit in its last place.
    place: [f64; 2],
    /// The rounding of the time relative to a step, and of positions relative to the shortest leg; zero
    /// unless they are large.
    parts: [f64; 2],
    /// The smallest over the largest singular value of `D₁`, at the triple where it is least.
    left: f64,
}

impl Coarse {
    /// The rounding along a motion with these legs; `triples` are sampled from it.
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

    /// The relative error of the motion, in steps and legs, if it is larger than that of other checks.
    pub fn known(&self) -> Option<f64> {
        let known = ROUNDINGS * (self.parts[0] + self.parts[1]);
        (known > FINE).then_some(known)
    }

    /// The reason why a figure need not meet its bar, if it misses it by no more than this rounding.
    pub fn excuse(&self, finding: &Finding) -> Option<String> {
        let known = self.known()?;
        let is_rounding = match finding.bar {
            // no step back was found, and its equations are singular to rounding
            _ if finding.failure.is_some() => finding.check == "reversibility" && self.left <= known,
            Bar::AtMost(bar) => bar > 0.0 && finding.figure <= known,
            Bar::AtLeast(_) | Bar::Reported => false,
        };
        is_rounding.then(|| self.reason())
    }

    /// The sizes and roundings of the times and positions, in words.
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

    /// A figure with its bar.
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
        // a lower order, a count and a step without solution are not excused
        assert_eq!(coarse.excuse(&finding(Bar::AtLeast(1.9), 1.8)), None);
        assert_eq!(coarse.excuse(&finding(Bar::AtMost(0.0), 1e-9)), None);
        let without = Finding {
            check: "reversibility",
            failure: Some("no node before".to_owned()),
            ..finding(Bar::AtMost(1e-12), f64::NAN)
        };
        assert_eq!(coarse.excuse(&without), None);
        // nothing is excused where the time is not large
        assert_eq!(late(1.0, 0.0).excuse(&finding(Bar::AtMost(1e-12), 2e-12)), None);
    }
}
