//! The continuous motion at times that come one by one, and how far another motion is from it.

use super::flow::TaylorFlow;
use super::{Jets, Tolerance};
use crate::run::{Behind, RunError, Stepper as _};
use crate::start::Start;
use crate::system::Point;

/// The continuous motion as a function of time: any times, in the order of the motion.
///
/// The flow makes steps of its own length; what lies within a step is read off its polynomial.
#[derive(Debug)]
pub struct Motion<'s, S: Jets<N>, const N: usize> {
    /// The flow.
    flow: TaylorFlow<'s, S, N>,
    /// The start.
    start: (f64, Point<f64, N>),
    /// The last time that will be asked for.
    until: f64,
}

impl<'s, S: Jets<N>, const N: usize> Motion<'s, S, N> {
    /// The motion from a start up to the time `until`, which may lie before.
    ///
    /// # Errors
    ///
    /// As [`TaylorFlow::new`]; [`RunError::Until`] if `until` is not finite.
    pub fn new(system: &'s S, start: Start<N>, until: f64, tolerance: Tolerance) -> Result<Self, RunError> {
        if !until.is_finite() {
            return Err(RunError::Until { until });
        }
        let mut flow = TaylorFlow::new(system, start, tolerance)?;
        let start = (flow.time(), flow.point());
        if until < start.0 {
            flow.reverse()?;
        }
        Ok(Self { flow, start, until })
    }

    /// Position, velocity and acceleration at a time between that of the last call and the end.
    ///
    /// # Errors
    ///
    /// [`RunError`] if the motion does not get there, or if the time lies outside.
    pub fn at(&mut self, t: f64) -> Result<Point<f64, N>, RunError> {
        let (start, point) = self.start;
        let forward = self.until >= start;
        let behind = |t: f64, other: f64| if forward { t < other } else { t > other };
        loop {
            let (from, to) = match self.flow.polynomial() {
                Some(step) => (step.start(), self.flow.time()),
                None => (start, start),
            };
            if !(behind(to, t)) {
                if behind(t, from) {
                    return Err(RunError::behind(Behind {
                        until: t,
                        time: from,
                        h: None,
                    }));
                }
                return Ok(self.flow.polynomial().map_or(point, |step| step.at(t)));
            }
            if !behind(self.flow.time(), self.until) {
                return Err(RunError::Until { until: t });
            }
            self.flow.step(self.until)?;
        }
    }
}

/// Tolerance and order of the two motions that errors are measured against: how far they are apart says how well the motion
/// is known. A low order rounds less.
const REFERENCES: [(f64, usize); 2] = [(1e-16, 18), (1e-17, 22)];

/// The global error of a motion: its distance from the continuous motion with the same start, by Taylor series to nearly all
/// digits.
///
/// Measured on both systems of the paper this is right at more output times than Richardson's extrapolation of whole runs
/// (`tests/tests/claims/global_error.rs`), costs less, and needs no step to be halved.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::taylor::GlobalError;
///
/// /// An oscillator.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
/// }]
/// struct Oscillator {}
///
/// let system = Oscillator {};
/// let start = Start::second_order([1.0], [0.0]);
/// let mut error = GlobalError::new(&system, start, 10.0)?;
/// for node in &Flow::new(&system, 0.01, start)?.until(10.0)? {
///     let [x] = error.at(node.t, &node.q)?;
///     assert!((x - (node.q[0] - node.t.cos()).abs()).abs() < 1e-14);
/// }
/// assert!(error.doubt() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct GlobalError<'s, S: Jets<N>, const N: usize> {
    /// The motions, the one that counts first.
    motions: [Motion<'s, S, N>; 2],
    /// The largest distance of the two so far.
    doubt: f64,
}

impl<'s, S: Jets<N>, const N: usize> GlobalError<'s, S, N> {
    /// The error of motions from a start up to the time `until`.
    ///
    /// # Errors
    ///
    /// As [`Motion::new`].
    pub fn new(system: &'s S, start: Start<N>, until: f64) -> Result<Self, RunError> {
        let motion = |(tolerance, order): (f64, usize)| {
            Motion::new(system, start, until, Tolerance::relative(tolerance).order(order))
        };
        let [first, second] = REFERENCES;
        Ok(Self {
            motions: [motion(first)?, motion(second)?],
            doubt: 0.0,
        })
    }

    /// How far each coordinate of the position `q` is from that of the continuous motion at the time `t`, without a sign. Times
    /// come in the order of the motion.
    ///
    /// # Errors
    ///
    /// [`RunError`] if the continuous motion does not get there.
    pub fn at(&mut self, t: f64, q: &[f64; N]) -> Result<[f64; N], RunError> {
        let [first, second] = &mut self.motions;
        let (truth, other) = (first.at(t)?.q, second.at(t)?.q);
        for (truth, other) in truth.iter().zip(&other) {
            self.doubt = self.doubt.max((truth - other).abs());
        }
        Ok(core::array::from_fn(|i| (q[i] - truth[i]).abs()))
    }

    /// How well the continuous motion itself is known, up to the last time: errors below say nothing.
    #[must_use]
    pub fn doubt(&self) -> f64 {
        self.doubt
    }
}
