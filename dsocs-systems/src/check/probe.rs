//! What the checks ask of a system beside its geometry: this is made anew for every system, and the checks are not.

use dsocs_core::geometry::Solvable;
use dsocs_core::{Flow, Leg, Point, Start, Stepper, System, TaylorFlow, Tolerance};

use super::Measured;
use crate::entry::CheckFailure;

/// Is shown the number, the time and the leg of a position, and says whether the motion goes on.
type Walker<'w, const N: usize> = &'w mut dyn FnMut(u64, f64, Leg<f64, N>) -> bool;

/// A system whose motions can be computed.
pub trait Probe<const N: usize>: Solvable<N> {
    /// Walks along the discrete motion from `(q0, v0)`, from the second node on.
    fn walk(&self, h: f64, start: &[[f64; N]; 2], walker: Walker<'_, N>) -> Result<(), CheckFailure>;

    /// Shows the continuous motion from `(q0, v0)` at some times, to a tolerance, back in time if asked for.
    fn sample(
        &self,
        start: &[[f64; N]; 2],
        tolerance: Tolerance,
        times: (&[f64], bool),
        observer: &mut dyn FnMut(f64, &Point<f64, N>),
    ) -> Measured<()>;
}

impl<S: System<N>, const N: usize> Probe<N> for S {
    fn walk(&self, h: f64, &[q0, v0]: &[[f64; N]; 2], walker: Walker<'_, N>) -> Result<(), CheckFailure> {
        let mut flow = Flow::new(self, h, Start::second_order(q0, v0))?;
        while walker(flow.index(), flow.time(), flow.leg()) {
            flow.advance()?;
        }
        Ok(())
    }

    fn sample(
        &self,
        &[q0, v0]: &[[f64; N]; 2],
        tolerance: Tolerance,
        (times, back): (&[f64], bool),
        observer: &mut dyn FnMut(f64, &Point<f64, N>),
    ) -> Measured<()> {
        let mut flow = TaylorFlow::new(self, Start::second_order(q0, v0), tolerance)?;
        if back {
            flow.reverse()?;
        }
        Ok(Stepper::sample(&mut flow, times, observer)?)
    }
}

/// The legs of the motion from `(q0, v0)` up to the time `until`, at least three.
pub fn legs<const N: usize>(
    probe: &dyn Probe<N>,
    h: f64,
    start: &[[f64; N]; 2],
    until: f64,
) -> Result<Vec<Leg<f64, N>>, CheckFailure> {
    let mut legs = Vec::new();
    probe.walk(h, start, &mut |_, time, leg| {
        legs.push(leg);
        (time - until) * h.signum() < 0.0 || legs.len() < 3
    })?;
    Ok(legs)
}

/// The positions of the motion from `(q0, v0)` with the step `h`, at `count` multiples of `part` steps.
pub fn positions<const N: usize>(
    probe: &dyn Probe<N>,
    h: f64,
    start: &[[f64; N]; 2],
    (part, count): (u32, usize),
) -> Measured<Vec<[f64; N]>> {
    let mut positions = Vec::with_capacity(count);
    let walked = probe.walk(h, start, &mut |index, _, leg| {
        if index == u64::from(part) * (positions.len() as u64 + 1) {
            positions.push(leg.q);
        }
        positions.len() < count
    });
    match walked {
        Ok(()) => Ok(positions),
        // not the motion to check
        Err(CheckFailure::Setup(error)) => Err(error.into()),
        Err(CheckFailure::Run(error)) => Err(error.into()),
        Err(error) => Err(error.into()),
    }
}

/// The positions of the continuous motion from `(q0, v0)` at some times, in the direction of `h`, to a tolerance.
pub fn exact<const N: usize>(
    probe: &dyn Probe<N>,
    h: f64,
    start: &[[f64; N]; 2],
    times: &[f64],
    tolerance: f64,
) -> Measured<Vec<[f64; N]>> {
    let mut motion = Vec::with_capacity(times.len());
    let tolerance = Tolerance::relative(tolerance);
    probe.sample(start, tolerance, (times, h < 0.0), &mut |_, point| {
        motion.push(point.q);
    })?;
    Ok(motion)
}
