//! The rounding of large times and positions, relative to a step and to a leg: it limits the digits of
//! figures that are relative to these.

use dsocs_core::geometry::{FlowTheorem, Triple, depends_on_time};
use dsocs_core::{Kernel, OwnedLeg};

use crate::check::motion::motions::less;
use crate::check::{Finding, larger};
use crate::stability::{Bar, number};

/// The error of a figure, in units of the rounding of a time or position.
const ROUNDINGS: f64 = 4.0;

/// A relative rounding below this is covered by the bars of all checks.
const COVERED_ROUNDING: f64 = 1e-14;

/// A time is large if it exceeds this many durations of the motion, or this many steps.
const LARGE_TIME: [f64; 2] = [8.0, 1e6];

/// Positions are large if they exceed this many times the extent of the motion.
const LARGE_POSITION: f64 = 1e3;

/// A leg below this part of the position is rounding: the motion rests there.
const RESTING_LEG: f64 = 1e4 * f64::EPSILON;

/// The rounding of times and positions along a motion.
pub struct RoundingOfLargeNumbers {
    /// The largest time, and half a unit in its last place.
    time: [f64; 2],
    /// The largest coordinate, and half a unit in its last place.
    place: [f64; 2],
    /// The rounding of the time relative to a step, and of positions relative to the shortest leg; zero
    /// unless they are large.
    relative: [f64; 2],
    /// The smallest over the largest singular value of `D₁`, at the triple where it is least.
    reciprocal_condition: f64,
}

impl RoundingOfLargeNumbers {
    /// The rounding along a motion with these legs; `triples` are sampled from it.
    pub fn along(kernel: &dyn Kernel, h: f64, legs: &[OwnedLeg<f64>], triples: &[Triple]) -> Self {
        let size = |x: &[f64]| x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        let half = |x: f64| x * f64::EPSILON / 2.0;
        let with_rounding = |x: f64| [x, half(x)];
        let time = with_rounding(legs.iter().fold(0.0, |most, leg| larger(most, leg.t.abs())));
        let place = with_rounding(legs.iter().fold(0.0, |most, leg| larger(most, size(&leg.q))));
        let lengths = legs.iter().map(|leg| size(&leg.d));
        let moving = lengths.filter(|length| *length > RESTING_LEG * place[0]);
        let leg = moving.fold(f64::INFINITY, f64::min);
        let [duration, extent] = legs.first().map_or([0.0; 2], |first| {
            let apart = |leg: &OwnedLeg<f64>| size(&less(&leg.q, &first.q));
            [
                legs.iter()
                    .fold(0.0, |most, leg| larger(most, (leg.t - first.t).abs())),
                legs.iter().fold(0.0, |most, leg| larger(most, apart(leg))),
            ]
        });
        let is_late = time[0] > LARGE_TIME[0] * duration || time[0] > LARGE_TIME[1] * h.abs();
        let is_timed = is_late && triples.iter().any(|triple| depends_on_time(kernel, h, triple));
        let is_far = place[0] > LARGE_POSITION * extent;
        let reciprocal_condition = triples.iter().map(|triple| {
            let at = FlowTheorem::at(kernel, h, triple.leg.any(), &triple.e).regularity;
            at.backward / at.largest_backward
        });
        Self {
            time,
            place,
            relative: [
                if is_timed { time[1] / h.abs() } else { 0.0 },
                if is_far { place[1] / leg } else { 0.0 },
            ],
            reciprocal_condition: reciprocal_condition.fold(1.0, f64::min),
        }
    }

    /// The relative error of the motion, in steps and legs, if it is larger than that of other checks.
    pub fn relative_error(&self) -> Option<f64> {
        let error = ROUNDINGS * (self.relative[0] + self.relative[1]);
        (error > COVERED_ROUNDING).then_some(error)
    }

    /// The reason why a figure need not meet its bar, if it misses it by no more than this rounding.
    pub fn excuse(&self, finding: &Finding) -> Option<String> {
        let error = self.relative_error()?;
        let is_rounding = match finding.bar {
            // no step back was found, and its equations are singular to rounding
            _ if finding.failure.is_some() => {
                finding.check == "reversibility" && self.reciprocal_condition <= error
            }
            Bar::AtMost(bar) => bar > 0.0 && finding.figure <= error,
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
                self.relative[0],
                "a step",
                "count the time from near the start",
            ),
            (
                "positions",
                self.place,
                self.relative[1],
                "a leg",
                "measure positions from near the motion",
            ),
        ];
        let large = parts
            .iter()
            .filter(|part| ROUNDINGS * part.2 > COVERED_ROUNDING / 2.0);
        let large: Vec<(String, &str)> = large
            .map(|(what, [size, half], part, of, cure)| {
                let size = number(*size);
                (
                    format!("the rounding of the {what} at {size} is {half:.0e}, {part:.0e} of {of}"),
                    *cure,
                )
            })
            .collect();
        let (what, cures): (Vec<String>, Vec<&str>) = large.into_iter().unzip();
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
        let late = |t: f64, time: f64| RoundingOfLargeNumbers {
            time: [t, t * f64::EPSILON / 2.0],
            place: [1.0, f64::EPSILON / 2.0],
            relative: [time, 0.0],
            reciprocal_condition: 1.0,
        };
        // at t = 1e6 with steps of 0.01
        let large = late(1e6, 1e6 * f64::EPSILON / 2.0 / 0.01);
        assert!(large.excuse(&finding(Bar::AtMost(1e-12), 1e-9)).is_some());
        assert_eq!(large.excuse(&finding(Bar::AtMost(1e-12), 1e-7)), None);
        assert_eq!(large.excuse(&finding(Bar::AtMost(1e-12), f64::NAN)), None);
        // a lower order, a count and a step without solution are not excused
        assert_eq!(large.excuse(&finding(Bar::AtLeast(1.9), 1.8)), None);
        assert_eq!(large.excuse(&finding(Bar::AtMost(0.0), 1e-9)), None);
        let without = Finding {
            check: "reversibility",
            failure: Some("no node before".to_owned()),
            ..finding(Bar::AtMost(1e-12), f64::NAN)
        };
        assert_eq!(large.excuse(&without), None);
        // nothing is excused where the time is not large
        assert_eq!(late(1.0, 0.0).excuse(&finding(Bar::AtMost(1e-12), 2e-12)), None);
    }
}
