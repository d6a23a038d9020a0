//! Whether the remaining error at the end of a step is rounding of the time, the position and the velocity at
//! which forces are evaluated. A body that comes to rest moves in the end by less than a rounding of its
//! position, and a force that depends on it jumps from one rounding to the next. No step is short enough to
//! resolve that.

use super::integrator::Integrator;
use super::recurrences::SeriesKernel;
use crate::start::place::Place;

/// The difference of accelerations counts as rounding up to this many times the effect of single roundings.
const ROUNDINGS: f64 = 8.0;

/// Rounding is not tested if the difference would move the position, in the time of the step, by more than this many roundings, unless
/// [`TRIES`] shorter steps have been tried.
const MOST: f64 = 1e6;
pub(super) const TRIES: u32 = 2;

/// If the speed at the end of a step exceeds this many times `|v| + h |a|` at its beginning, the motion has
/// changed, and the difference is not rounding.
const GROWS: f64 = 2.0;

/// The shifts of time, position and velocity, in roundings.
const BESIDE: [[f64; 3]; 3] = [[1.0, 1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0]];

impl Integrator {
    /// Whether the acceleration at the end of the trial step of the length `size` differs from that of its
    /// series by rounding alone. `tries` shorter steps have been tried.
    #[cold]
    pub(super) fn is_rounding(
        &self,
        equations: &dyn SeriesKernel,
        (defect, size): (f64, f64),
        tries: u32,
    ) -> bool {
        let control = &self.control;
        let moved = defect * size * size;
        // where a motion begins anew, as from rest, its beginning is no measure
        let from = if self.is_new { &self.tried } else { &self.now };
        let is_small = moved <= MOST * f64::EPSILON * control.size(from.q());
        let pace = control.size(from.v()) + control.size(self.series.velocity_of(1)) * size;
        let leads_on = control.size(self.tried.v()) <= GROWS * pace;
        if defect.is_nan() || !(is_small || tries >= TRIES) || !leads_on {
            return false;
        }
        let declaration = equations.declaration();
        let own = self.next.velocity_of(1);
        let at = |roundings: [f64; 3]| {
            let moved = |x: f64, by: f64| x * (1.0 + by * f64::EPSILON);
            let of = |x: &[f64], first: usize| {
                let components = x.iter().enumerate();
                components
                    .map(|(i, x)| moved(*x, roundings[(first + i) % 3]))
                    .collect()
            };
            let (q, v) = (of(self.tried.q(), 1), of(self.tried.v(), 2));
            let place = Place::of_phase(moved(self.next.time(), roundings[0]), q, v);
            let solved = place.solve(&declaration, own)?;
            Some((place, solved))
        };
        let Some((place, here)) = at([0.0; 3]) else {
            return false;
        };
        let n = own.len();
        let mut noise = place
            .rounding(&declaration, &here.motion)
            .map_or(0.0, |rounding| control.size(&rounding[..n]));
        for roundings in BESIDE {
            let Some((_, beside)) = at(roundings) else {
                return false;
            };
            noise = noise.max(control.distance(&beside.motion[..n], &here.motion[..n]));
        }
        defect <= ROUNDINGS * noise
    }
}
