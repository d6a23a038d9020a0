//! A start whose second node lies on the continuous motion.

use super::{TaylorFlow, Tolerance};
use crate::number::compensated::Compensated;
use crate::number::point::sized;
use crate::run::{RunError, Stepper as _};
use crate::solve::rotation;
use crate::start::{Phase, Start};
use crate::system::System;
use crate::tape::declaration::Declaration;

/// The tolerance of [`Start::exact`], at which only rounding is left.
const EXACT: f64 = 1e-17;

impl<const N: usize> Start<N> {
    /// `q1 = q(t0 + h)`, where `q` is the continuous motion from the position and the velocity of this start. It is computed by its Taylor
    /// series, so the start adds no error to the discrete motion. The step of the run has to be `h`. If the system depends on time, call
    /// [`Start::at`] before this function.
    ///
    /// ```
    /// # use dsocs_core::prelude::*;
    /// # #[dsocs { coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2; }]
    /// # struct Oscillator {}
    /// let start = Start::second_order([1.0], [0.0]).exact(&Oscillator {}, 0.1)?;
    /// assert!((Flow::new(&Oscillator {}, 0.1, start)?.position()[0] - 0.1_f64.cos()).abs() < 1e-15);
    /// # Ok::<(), RunError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`RunError`] if the start gives no velocity, or if the motion does not get as far as `h`.
    pub fn exact<S: System<N>>(self, system: &S, h: f64) -> Result<Self, RunError> {
        let Phase { t0, q0, v0, .. } = self.given().phase(&Declaration::of(system.kernel()))?;
        let (q0, v0): ([f64; N], [f64; N]) = (sized(&q0), sized(&v0));
        // without a dependence on time, the end of the step has more digits when counted from 0
        let begin = if S::DEPENDS_ON_TIME { t0 } else { 0.0 };
        let mut flow = TaylorFlow::new(system, self.at(begin), Tolerance::relative(EXACT))?;
        let a0 = *flow.acceleration();
        if h < 0.0 {
            flow.reverse()?;
        }
        flow.to(begin + h)?;
        let mut d = flow.exact_position().plus(&Compensated::exact(q0).negated());
        let rotations = &system.kernel().shape().rotations;
        rotation::from_changes(rotations, &q0, [&mut d.hi, &mut d.lo]);
        Ok(self.along(q0, [v0, a0], d, [t0, h]))
    }
}
