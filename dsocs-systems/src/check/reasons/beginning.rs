//! Motions that begin from rest. Their first legs are short beside the longest one, to whose rounding the
//! solution of a step is known; so figures relative to a short leg may be rounding.

use dsocs_core::OwnedLeg;

use crate::check::theorems::equations::LARGEST_RESIDUAL;
use crate::check::{CheckedMotion, larger};
use crate::stability::written_time;

/// A leg below this part of the longest is short.
const SHORT_LEG: f64 = 1e-2;

/// The legs of a motion, of which some are short.
pub struct BeginningFromRest<'a> {
    legs: &'a [OwnedLeg<f64>],
    /// The length of the longest.
    longest: f64,
}

impl<'a> BeginningFromRest<'a> {
    /// The legs of a motion, if the first one is short.
    pub fn along(motion: &'a CheckedMotion<'_>) -> Option<Self> {
        let legs = &motion.legs[..];
        let longest = legs.iter().fold(0.0, |most, leg| larger(most, size(&leg.d)));
        let beginning = Self { legs, longest };
        beginning.is_short(size(&legs.first()?.d)).then_some(beginning)
    }

    /// Whether a leg of this length is short.
    fn is_short(&self, length: f64) -> bool {
        length < SHORT_LEG * self.longest
    }

    /// The reason why rows at the nodes of short legs need not vanish to their own rounding, if every row
    /// vanishes to its largest rounding along the motion. `rows` has, for each triple, the index of its first
    /// leg and each row with its rounding; `worst` is the index of the leg where a row is largest relative to
    /// its rounding.
    pub fn excuse_rows(&self, rows: &[(usize, Vec<[f64; 2]>)], worst: usize) -> Option<String> {
        let count = rows.iter().map(|(_, rows)| rows.len()).max()?;
        let mut explained = vec![0.0; count];
        for (_, rows) in rows {
            for (explained, [_, own]) in explained.iter_mut().zip(rows) {
                *explained = larger(*explained, *own);
            }
        }
        let holds = |(_, rows): &(usize, Vec<[f64; 2]>)| {
            let mut rows = rows.iter().zip(&explained);
            rows.all(|([row, _], explained)| row.abs() <= LARGEST_RESIDUAL * explained)
        };
        let is_short = self.is_short(size(&self.legs.get(worst)?.d));
        (is_short && rows.iter().all(holds)).then(|| self.reason(worst))
    }

    /// The leg at a place, in words.
    fn reason(&self, place: usize) -> String {
        let length = self.legs.get(place).map_or(0.0, |leg| size(&leg.d));
        format!(
            "not required here: what is measured is relative to a leg, and the motion begins from rest: at t = {} its leg is {:.0e} of the longest, and what is solved there is known to the \
             rounding of that one; to see it required, start a little later (`--t0`, `--q0`, `--v0`)",
            written_time(self.legs.get(place).map_or(0.0, |leg| leg.t)),
            length / self.longest
        )
    }
}

/// The largest component.
pub fn size(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| larger(most, x.abs()))
}
