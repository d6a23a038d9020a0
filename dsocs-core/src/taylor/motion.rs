//! The continuous motion at given times, and the distance of another motion from it.

use super::Tolerance;
use super::flow::{AnyTaylorFlow, TaylorFlow};
use crate::error::SetupError;
use crate::number::point::{AnyPoint, OwnedPoint, Point, copy};
use crate::run::{AnyPolynomial, Polynomial, Run as _, RunError, TimeBehind};
use crate::start::{AnyStart, Start};
use crate::step::TapeKernel;
use crate::system::System;

/// The continuous motion as a function of time. It can be evaluated at any times, in the order of the motion.
///
/// The flow chooses its own steps. Within a step the motion is evaluated from the polynomial of the step.
#[derive(Debug)]
pub struct Motion<'s, const N: usize>(AnyMotion<'s>);

impl<'s, const N: usize> Motion<'s, N> {
    /// The motion from a start to the time `until`, which may lie before the start.
    ///
    /// # Errors
    ///
    /// As [`TaylorFlow::new`]; [`RunError::Until`] if `until` is not finite.
    pub fn new<S: System<N>>(
        system: &'s S,
        start: Start<N>,
        until: f64,
        tolerance: Tolerance,
    ) -> Result<Self, RunError> {
        let flow = TaylorFlow::new(system, start, tolerance);
        AnyMotion::of(flow.map(|flow| flow.any), until).map(Self)
    }

    /// Position, velocity and acceleration at a time between that of the last call and the end.
    ///
    /// # Errors
    ///
    /// [`RunError`] if the motion cannot be computed up to `t`, or if `t` lies outside of the allowed range.
    pub fn at(&mut self, t: f64) -> Result<Point<f64, N>, RunError> {
        let motion = &mut self.0;
        let polynomial = reach(&mut motion.flow, motion.start.any().t, motion.until, t)?;
        Ok(polynomial.map_or_else(|| motion.start.sized(), |step| Polynomial::of(step).at(t)))
    }
}

/// [`Motion`] of a system without its type.
#[derive(Debug)]
struct AnyMotion<'s> {
    /// The flow.
    flow: AnyTaylorFlow<'s>,
    /// The start.
    start: OwnedPoint<f64>,
    /// The last time that will be requested.
    until: f64,
}

impl<'s> AnyMotion<'s> {
    /// The motion of a flow at its start, or the error.
    fn of(flow: Result<AnyTaylorFlow<'s>, SetupError>, until: f64) -> Result<Self, RunError> {
        if !until.is_finite() {
            return Err(RunError::Until { until });
        }
        let mut flow = flow?;
        let AnyPoint { t, q, v, a } = flow.motion.point();
        let start = OwnedPoint::new(q.len(), [q, v, a, &[t]].concat());
        if until < t {
            flow.reverse()?;
        }
        Ok(Self { flow, start, until })
    }

    /// The position at a time between that of the last call and the end.
    fn position(&mut self, t: f64, q: &mut [f64]) -> Result<(), RunError> {
        let mut point = self.start.clone();
        if let Some(step) = reach(&mut self.flow, point.any().t, self.until, t)? {
            step.at(t, &mut point);
        }
        copy(q, point.any().q);
        Ok(())
    }
}

/// The step that contains a time on the way from a start to the time `until`; `None` for the start.
fn reach<'f>(
    flow: &'f mut AnyTaylorFlow<'_>,
    start: f64,
    until: f64,
    t: f64,
) -> Result<Option<AnyPolynomial<'f>>, RunError> {
    let forward = until >= start;
    let behind = |t: f64, other: f64| if forward { t < other } else { t > other };
    loop {
        let (from, to) = match flow.motion.polynomial() {
            Some(step) => (step.start(), flow.motion.time()),
            None => (start, start),
        };
        if !(behind(to, t)) {
            if behind(t, from) {
                return Err(RunError::time_behind(TimeBehind {
                    until: t,
                    time: from,
                    h: None,
                }));
            }
            return Ok(flow.motion.polynomial());
        }
        if !behind(flow.motion.time(), until) {
            return Err(RunError::Until { until: t });
        }
        flow.step(until)?;
    }
}

/// The global error of a motion: its distance from the continuous motion with the same start. The continuous motion is computed by Taylor
/// series to nearly all digits.
///
/// On both systems of the paper, this is correct at more output times than Richardson extrapolation of whole runs
/// (`tests/tests/claims/global_error.rs`). It costs less, and no run with half the step is needed.
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
/// assert!(error.uncertainty() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct GlobalError<'s, const N: usize>(AnyGlobalError<'s>);

impl<'s, const N: usize> GlobalError<'s, N> {
    /// The error of motions from a start up to the time `until`.
    ///
    /// # Errors
    ///
    /// As [`Motion::new`].
    pub fn new<S: System<N>>(system: &'s S, start: Start<N>, until: f64) -> Result<Self, RunError> {
        let begin = move |tolerance| TaylorFlow::new(system, start, tolerance).map(|flow| flow.any);
        AnyGlobalError::of(Box::new(begin), until).map(Self)
    }

    /// The absolute difference of each coordinate between the position `q` and the continuous motion at the time `t`. The times have
    /// to be in the order of the motion.
    ///
    /// # Errors
    ///
    /// [`RunError`] if the continuous motion cannot be computed up to `t`.
    pub fn at(&mut self, t: f64, q: &[f64; N]) -> Result<[f64; N], RunError> {
        let mut distances = *q;
        self.0.replace(t, &mut distances)?;
        Ok(distances)
    }

    /// The uncertainty of the continuous motion itself, up to the last time; at least the rounding of
    /// position and time. Estimated errors below it are meaningless.
    #[must_use]
    pub fn uncertainty(&self) -> f64 {
        self.0.uncertainty()
    }
}

/// Begins a continuous motion to a tolerance.
type Begin<'s> = dyn Fn(Tolerance) -> Result<AnyTaylorFlow<'s>, SetupError> + 's;

/// [`GlobalError`] of a system without its type.
pub struct AnyGlobalError<'s> {
    /// Begins the motions.
    begin: Box<Begin<'s>>,
    /// The last time that will be requested.
    until: f64,
    /// Whether the motions are those to the larger tolerances.
    is_coarse: bool,
    /// The motions, the more accurate one first.
    motions: [AnyMotion<'s>; 2],
    /// The largest distance of the two motions so far.
    uncertainty: f64,
    /// The time of the last call, and the position then.
    last: Option<(f64, Vec<f64>)>,
}

// by hand, because of the function
impl core::fmt::Debug for AnyGlobalError<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("GlobalError")
            .field("motions", &self.motions)
            .field("uncertainty", &self.uncertainty)
            .finish_non_exhaustive()
    }
}

impl<'s> AnyGlobalError<'s> {
    /// Tolerances and orders of the two continuous motions against which errors are measured. Their distance is the uncertainty of the
    /// continuous motion. Rounding errors are smaller with a low order.
    pub const REFERENCES: [Tolerance; 2] = [
        Tolerance::relative(1e-16).order(18),
        Tolerance::relative(1e-17).order(22),
    ];

    /// Tolerances for systems of which no motion can be computed to [`Self::REFERENCES`], such as near a
    /// corner of an angle whose place is lost in rounding.
    const COARSE: [Tolerance; 2] = [Tolerance::relative(1e-13), Tolerance::relative(1e-12)];

    /// The error of motions of a system that was read from a text, from a start up to the time `until`.
    ///
    /// # Errors
    ///
    /// As [`Motion::new`].
    pub fn of_tape(system: &'s TapeKernel, start: &AnyStart, until: f64) -> Result<Self, RunError> {
        let start = start.clone();
        let begin = move |tolerance| AnyTaylorFlow::of_tape(system, &start, tolerance);
        Self::of(Box::new(begin), until)
    }

    /// The error of motions up to the time `until`; `begin` begins the reference motions.
    fn of(begin: Box<Begin<'s>>, until: f64) -> Result<Self, RunError> {
        let motions = motions(&*begin, Self::REFERENCES, until)?;
        Ok(Self {
            begin,
            until,
            is_coarse: false,
            motions,
            uncertainty: 0.0,
            last: None,
        })
    }

    /// The positions of both motions at a time.
    fn positions(&mut self, t: f64, dimension: usize) -> Result<[Vec<f64>; 2], RunError> {
        let [first, second] = &mut self.motions;
        let (mut truth, mut other) = (vec![f64::NAN; dimension], vec![f64::NAN; dimension]);
        first.position(t, &mut truth)?;
        second.position(t, &mut other)?;
        Ok([truth, other])
    }

    /// Continues with motions to larger tolerances. Returns whether there are some.
    #[cold]
    fn coarsen(&mut self) -> bool {
        if self.is_coarse {
            return false;
        }
        self.is_coarse = true;
        let found = motions(&*self.begin, Self::COARSE, self.until);
        found.map(|found| self.motions = found).is_ok()
    }

    /// Replaces a position by its absolute differences from the continuous motion at the time `t`. The times
    /// have to be in the order of the motion.
    ///
    /// # Errors
    ///
    /// [`RunError`] if the continuous motion cannot be computed up to `t`.
    pub fn replace(&mut self, t: f64, q: &mut [f64]) -> Result<(), RunError> {
        let [truth, other] = match self.positions(t, q.len()) {
            Err(_) if self.coarsen() => self.positions(t, q.len())?,
            found => found?,
        };
        let last = self.last.take();
        for (i, (q, (truth, other))) in q.iter_mut().zip(truth.iter().zip(&other)).enumerate() {
            let rate = last
                .as_ref()
                .map_or(0.0, |(before, last)| (truth - last[i]) / (t - before));
            self.uncertainty = (self.uncertainty)
                .max((truth - other).abs())
                .max(rounding(t, *truth, rate));
            *q = (*q - truth).abs();
        }
        self.last = Some((t, truth));
        Ok(())
    }

    /// The uncertainty of the continuous motion itself, up to the last time; at least the rounding of
    /// position and time.
    #[must_use]
    pub fn uncertainty(&self) -> f64 {
        self.uncertainty
    }
}

/// Motions to two tolerances up to a time.
fn motions<'s>(
    begin: &Begin<'s>,
    [first, second]: [Tolerance; 2],
    until: f64,
) -> Result<[AnyMotion<'s>; 2], RunError> {
    Ok([
        AnyMotion::of(begin(first), until)?,
        AnyMotion::of(begin(second), until)?,
    ])
}

/// The rounding error of a position at a time, with a velocity: two reference motions may agree in all
/// digits, which are rounded themselves, as is the time.
#[doc(hidden)]
#[must_use]
pub fn rounding(t: f64, q: f64, v: f64) -> f64 {
    let moved = (v * t).abs();
    // a velocity without a value is that of two equal times
    f64::EPSILON * (q.abs() + if moved.is_finite() { moved } else { 0.0 })
}
