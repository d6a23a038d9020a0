//! Whether what is left of the error at the end of a step is rounding: of the time, the position and the velocity at which forces are taken. What comes to rest moves in the end by less
//! than a rounding of its position, and a force that depends on it jumps from one rounding to the next. No step is short enough to resolve that.

use super::integrator::Integrator;
use super::recurrences::SeriesKernel;
use crate::start::place::Place;

/// The difference of accelerations may be so many times what roundings make of them.
const ROUNDINGS: f64 = 8.0;

/// It is not asked where, in the time of the step, it moves the position by more than so many roundings.
const MOST: f64 = 1e6;

/// By how many roundings time, position and velocity are moved.
const BESIDE: [[f64; 3]; 3] = [[1.0, 1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0]];

impl Integrator {
    /// Whether the acceleration at the end of the step that has been tried, of the length `size`, differs from that which led there by rounding alone.
    #[cold]
    pub(super) fn is_rounding(&self, equations: &dyn SeriesKernel, defect: f64, size: f64) -> bool {
        let control = &self.control;
        let moved = defect * size * size;
        if moved.is_nan() || moved > MOST * f64::EPSILON * control.size(self.tried.q()) {
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
            Place::of_phase(
                moved(self.next.time(), roundings[0]),
                of(self.tried.q(), 1),
                of(self.tried.v(), 2),
            )
            .solve(&declaration, own)
        };
        let Some(here) = at([0.0; 3]) else {
            return false;
        };
        let n = own.len();
        let mut noise = 0.0_f64;
        for roundings in BESIDE {
            let Some(beside) = at(roundings) else {
                return false;
            };
            noise = noise.max(control.distance(&beside.motion[..n], &here.motion[..n]));
        }
        defect <= ROUNDINGS * noise
    }
}
