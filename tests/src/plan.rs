//! A function of time that a declaration calls: a table of samples, linear in between.

use dsocs_core::Real;

/// Samples at multiples of a step.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The step.
    pub h: f64,
    /// The values, the first at the time 0.
    pub samples: Vec<f64>,
}

impl Plan {
    /// The value at a time; beyond the last but one sample the last line goes on.
    pub fn at<R: Real>(&self, t: R) -> R {
        let place = t / self.h;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some hundreds
        let first = (place.re().floor().max(0.0) as usize).min(self.samples.len() - 2);
        let [from, to] = [self.samples[first], self.samples[first + 1]];
        (place - first as f64) * (to - from) + from
    }
}
