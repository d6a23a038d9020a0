//! What the checks ask of a system beside its geometry: this is made anew for every system, and the checks are not.

use dsocs_core::geometry::{Solvable, Triple};
use dsocs_core::{Flow, Leg, Point, Start, Stepper, System, TaylorFlow, Tolerance, Unresolved};

use super::Measured;
use crate::entry::CheckFailure;

/// A state of the continuous motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize> {
    /// The time.
    pub t: f64,
    /// The position.
    pub q: [f64; N],
    /// The velocity.
    pub v: [f64; N],
    /// Near which the acceleration is, where there may be several.
    pub near: Option<[f64; N]>,
}

impl<const N: usize> State<N> {
    /// As the start of a run.
    fn start(&self) -> Start<N> {
        self.meant(Start::second_order(self.q, self.v))
    }

    /// A start from here, with the time and the acceleration that is meant.
    fn meant(&self, start: Start<N>) -> Start<N> {
        let start = start.at(self.t);
        self.near.map_or(start, |near| start.near_acceleration(near))
    }
}

/// How the second node follows from a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum First {
    /// `q1 = q0 + h v0 + h²/2 a0`.
    SecondOrder,
    /// `q1 = q0 + h v0`.
    Paper,
}

/// Is shown the number, the time and the leg of a position, and says whether the motion goes on.
type Walker<'w, const N: usize> = &'w mut dyn FnMut(u64, f64, Leg<f64, N>) -> bool;

/// A system whose motions can be computed.
pub trait Probe<const N: usize>: Solvable<N> {
    /// Walks along the discrete motion from a state, from the second node on. Gives the steps that were too long for the external forces.
    fn walk(
        &self,
        h: f64,
        start: (&State<N>, First),
        walker: Walker<'_, N>,
    ) -> (Option<Unresolved>, Result<(), CheckFailure>);

    /// A state on the constraints of positions and velocities, near to one that may violate them.
    fn projected(&self, h: f64, state: &State<N>) -> Result<State<N>, CheckFailure>;

    /// Shows the continuous motion from a state at some times, to a tolerance, back in time if asked for.
    fn sample(
        &self,
        start: &State<N>,
        tolerance: Tolerance,
        times: (&[f64], bool),
        observer: &mut dyn FnMut(f64, &Point<f64, N>),
    ) -> Measured<()>;

    /// The Taylor coefficients of the continuous position at a state, by order, and how far they reach.
    fn series(&self, start: &State<N>) -> Measured<(Vec<[f64; N]>, f64)>;

    /// Whether external forces act.
    fn is_forced(&self) -> bool;

    /// How many constraints there are: on positions, on velocities, on accelerations.
    fn constraints(&self) -> [usize; 3];
}

impl<S: System<N>, const N: usize> Probe<N> for S {
    fn walk(
        &self,
        h: f64,
        (state, first): (&State<N>, First),
        walker: Walker<'_, N>,
    ) -> (Option<Unresolved>, Result<(), CheckFailure>) {
        let start = match first {
            First::SecondOrder => state.start(),
            First::Paper => state.meant(Start::paper(state.q, state.v)),
        };
        let mut flow = match Flow::new(self, h, start) {
            Ok(flow) => flow,
            Err(error) => return (None, Err(error.into())),
        };
        while walker(flow.index(), flow.time(), flow.leg()) {
            if let Err(error) = flow.advance() {
                return (flow.unresolved(), Err(error.into()));
            }
        }
        (flow.unresolved(), Ok(()))
    }

    fn projected(&self, h: f64, state: &State<N>) -> Result<State<N>, CheckFailure> {
        let node = Flow::new(self, h, state.start().projected())?.node();
        Ok(State {
            t: state.t,
            q: node.q,
            v: node.v,
            near: state.near,
        })
    }

    fn sample(
        &self,
        start: &State<N>,
        tolerance: Tolerance,
        (times, back): (&[f64], bool),
        observer: &mut dyn FnMut(f64, &Point<f64, N>),
    ) -> Measured<()> {
        let mut flow = TaylorFlow::new(self, start.start(), tolerance)?;
        if back {
            flow.reverse()?;
        }
        Ok(Stepper::sample(&mut flow, times, observer)?)
    }

    fn series(&self, start: &State<N>) -> Measured<(Vec<[f64; N]>, f64)> {
        let start = start.start().projected();
        let mut flow = TaylorFlow::new(self, start, Tolerance::relative(1e-15))?;
        flow.advance()?;
        let polynomial = flow.polynomial().ok_or("the motion has no series")?;
        Ok((polynomial.series().position().to_vec(), polynomial.length().abs()))
    }

    fn is_forced(&self) -> bool {
        S::EXTERNAL_FORCES
    }

    fn constraints(&self) -> [usize; 3] {
        [S::HOLONOMIC, S::NONHOLONOMIC, S::KINEMATIC]
    }
}

/// The legs of a motion, and why there are no more.
pub struct Walked<const N: usize> {
    /// The legs, at least three.
    pub legs: Vec<Leg<f64, N>>,
    /// The time that is reached.
    pub until: f64,
    /// Why the end is not.
    pub ended: Option<String>,
    /// The steps that were too long for the external forces.
    pub unresolved: Option<Unresolved>,
}

/// The legs of the motion from a state up to the time `until`, or as far as it goes.
pub fn legs<const N: usize>(
    probe: &dyn Probe<N>,
    h: f64,
    start: (&State<N>, First),
    until: f64,
) -> Result<Walked<N>, CheckFailure> {
    let (mut legs, mut reached) = (Vec::new(), start.0.t);
    // a time that is the end to within rounding is the end
    let last = until - 1e-6 * h;
    let (unresolved, walked) = probe.walk(h, start, &mut |_, time, leg| {
        legs.push(leg);
        reached = time;
        (time - last) * h.signum() < 0.0 || legs.len() < 3
    });
    let ended = match walked {
        Ok(()) => None,
        Err(error) if legs.len() < 3 => return Err(error),
        Err(error) => Some(error.to_string()),
    };
    Ok(Walked {
        legs,
        until: reached,
        ended,
        unresolved,
    })
}

/// Nodes of the motion from a state with the step `h`, at `count` multiples of `part` steps: each as the triple about it.
pub fn nodes<const N: usize>(
    probe: &dyn Probe<N>,
    h: f64,
    start: (&State<N>, First),
    (part, count): (u32, usize),
) -> Measured<Vec<Triple<N>>> {
    let mut nodes: Vec<Triple<N>> = Vec::with_capacity(count);
    let mut before: Option<Leg<f64, N>> = None;
    let (_, walked) = probe.walk(h, start, &mut |index, _, leg| {
        if let Some(first) = before.take() {
            let e = core::array::from_fn(|i| leg.d[i] - first.d[i]);
            nodes.push(Triple { leg: first, e });
        }
        if index == u64::from(part) * (nodes.len() as u64 + 1) {
            before = Some(leg);
        }
        nodes.len() < count
    });
    match walked {
        Ok(()) => Ok(nodes),
        // not the motion to check
        Err(CheckFailure::Setup(error)) => Err(error.into()),
        Err(CheckFailure::Run(error)) => Err(error.into()),
        Err(error) => Err(error.into()),
    }
}

/// The continuous motion from a state at some times, in the direction of `h`, to a tolerance.
pub fn exact<const N: usize>(
    probe: &dyn Probe<N>,
    h: f64,
    start: &State<N>,
    times: &[f64],
    tolerance: f64,
) -> Measured<Vec<Point<f64, N>>> {
    let mut motion = Vec::with_capacity(times.len());
    let tolerance = Tolerance::relative(tolerance);
    probe.sample(start, tolerance, (times, h < 0.0), &mut |_, point| {
        motion.push(*point);
    })?;
    Ok(motion)
}
