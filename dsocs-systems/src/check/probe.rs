//! What the checks ask of a system beside its geometry: motions, discrete and continuous.
//!
//! This is made anew for every system, and the checks are not.

use std::ops::ControlFlow;

use dsocs_core::geometry::{DiscreteFlow, GeometryError, Triple};
use dsocs_core::{
    AnyLeg, AnyPoint, Flow, Kernel, Node, OwnedLeg, OwnedPoint, Regularity, SetupError, Start, Stepper,
    System, TaylorFlow, Tolerance, Unresolved,
};

use super::{Measured, Settings};
use crate::entry::CheckFailure;

/// A state of the continuous motion.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// The time.
    pub t: f64,
    /// The position.
    pub q: Vec<f64>,
    /// The velocity.
    pub v: Vec<f64>,
    /// Near which the acceleration is, where there may be several.
    pub near: Option<Vec<f64>>,
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
type Walker<'w> = &'w mut dyn FnMut(u64, f64, AnyLeg<'_, f64>) -> bool;

/// A node of a motion of third order.
#[derive(Clone, Debug, PartialEq)]
pub struct Passed {
    /// The time.
    pub t: f64,
    /// The position.
    pub q: Vec<f64>,
    /// The velocity.
    pub v: Vec<f64>,
}

/// A system whose motions can be computed.
pub trait Probe {
    /// The system.
    fn kernel(&self) -> &dyn Kernel;

    /// Its step as a map.
    fn flow(&self, h: f64) -> Result<DiscreteFlow<'_>, GeometryError>;

    /// Walks along the discrete motion from a state, from the second node on. Gives the steps that were too long for the external forces.
    fn walk(
        &self,
        h: f64,
        start: (&State, First),
        walker: Walker<'_>,
    ) -> (Option<Unresolved>, Result<(), CheckFailure>);

    /// A state on the constraints of positions and velocities, near to one that may violate them.
    fn projected(&self, h: f64, state: &State) -> Result<State, CheckFailure>;

    /// Shows the continuous motion from a state at some times, to a tolerance, back in time if asked for.
    fn sample(
        &self,
        start: &State,
        tolerance: Tolerance,
        times: (&[f64], bool),
        observer: &mut dyn FnMut(f64, AnyPoint<'_, f64>),
    ) -> Measured<()>;

    /// The Taylor coefficients of the continuous position at a state, by order, and how far they reach.
    fn series(&self, start: &State) -> Measured<(Vec<Vec<f64>>, f64)>;
}

/// A system of third order whose motions can be computed.
pub trait ThirdOrderProbe {
    /// The system.
    fn kernel(&self) -> &dyn Kernel;

    /// The nodes of the motion from a state, which says the acceleration, up to a time, with the regularity of each step.
    fn certified(
        &self,
        h: f64,
        start: &State,
        until: f64,
    ) -> Result<(Vec<Passed>, Vec<Regularity>), CheckFailure>;

    /// The nodes of the motion with a step.
    fn nodes(&self, h: f64, start: &State, until: f64) -> Measured<Vec<Passed>>;

    /// The nodes of the way back from the end.
    fn back(&self, h: f64, start: &State, until: f64) -> Measured<Vec<Passed>>;
}

/// A system of a type.
pub struct Of<'s, S, const N: usize> {
    system: &'s S,
}

impl<'s, S, const N: usize> Of<'s, S, N> {
    /// The system, without its type.
    pub fn new(system: &'s S) -> Self {
        Self { system }
    }
}

/// A vector with its number of coordinates; NaN where it has another one.
fn sized<const N: usize>(vector: &[f64]) -> [f64; N] {
    vector.try_into().unwrap_or([f64::NAN; N])
}

impl State {
    /// The start of the motion to check.
    pub fn of(settings: &Settings<'_>) -> Self {
        Self {
            t: settings.t0,
            q: settings.q0.to_vec(),
            v: settings.v0.to_vec(),
            near: settings.a0.map(<[f64]>::to_vec),
        }
    }

    /// As the start of a run.
    fn start<const N: usize>(&self) -> Start<N> {
        self.meant(Start::second_order(sized(&self.q), sized(&self.v)))
    }

    /// A start from here, with the time and the acceleration that is meant.
    fn meant<const N: usize>(&self, start: Start<N>) -> Start<N> {
        let start = start.at(self.t);
        match &self.near {
            Some(near) => start.near_acceleration(sized(near)),
            None => start,
        }
    }

    /// The start of a run of third order, with the acceleration that is said.
    fn third_order<const N: usize>(&self) -> Result<Start<N>, SetupError> {
        let a0 = self.near.as_ref().ok_or(SetupError::FreeAcceleration)?;
        Ok(Start::third_order(sized(&self.q), sized(&self.v), sized(a0)).at(self.t))
    }
}

impl<S: System<N>, const N: usize> Probe for Of<'_, S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.system.kernel()
    }

    fn flow(&self, h: f64) -> Result<DiscreteFlow<'_>, GeometryError> {
        DiscreteFlow::new(self.system.kernel(), h)
    }

    fn walk(
        &self,
        h: f64,
        (state, first): (&State, First),
        walker: Walker<'_>,
    ) -> (Option<Unresolved>, Result<(), CheckFailure>) {
        let start = match first {
            First::SecondOrder => state.start(),
            First::Paper => state.meant(Start::paper(sized(&state.q), sized(&state.v))),
        };
        let mut flow = match Flow::new(self.system, h, start) {
            Ok(flow) => flow,
            Err(error) => return (None, Err(error.into())),
        };
        while walker(flow.index(), flow.time(), flow.leg().any()) {
            if let Err(error) = flow.advance() {
                return (flow.unresolved(), Err(error.into()));
            }
        }
        (flow.unresolved(), Ok(()))
    }

    fn projected(&self, h: f64, state: &State) -> Result<State, CheckFailure> {
        let node = Flow::new(self.system, h, state.start().projected())?.node();
        Ok(State {
            t: state.t,
            q: node.q.to_vec(),
            v: node.v.to_vec(),
            near: state.near.clone(),
        })
    }

    fn sample(
        &self,
        start: &State,
        tolerance: Tolerance,
        (times, back): (&[f64], bool),
        observer: &mut dyn FnMut(f64, AnyPoint<'_, f64>),
    ) -> Measured<()> {
        let mut flow = TaylorFlow::new(self.system, start.start(), tolerance)?;
        if back {
            flow.reverse()?;
        }
        Ok(Stepper::sample(&mut flow, times, &mut |t, point| {
            observer(t, point.any());
        })?)
    }

    fn series(&self, start: &State) -> Measured<(Vec<Vec<f64>>, f64)> {
        let start = start.start().projected();
        let mut flow = TaylorFlow::new(self.system, start, Tolerance::relative(1e-15))?;
        flow.advance()?;
        let polynomial = flow.polynomial().ok_or("the motion has no series")?;
        let position = polynomial.series().position::<N>().iter();
        Ok((position.map(|c| c.to_vec()).collect(), polynomial.length().abs()))
    }
}

impl<S: System<N>, const N: usize> ThirdOrderProbe for Of<'_, S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.system.kernel()
    }

    fn certified(
        &self,
        h: f64,
        start: &State,
        until: f64,
    ) -> Result<(Vec<Passed>, Vec<Regularity>), CheckFailure> {
        let (mut nodes, mut regularity) = (Vec::new(), Vec::new());
        let mut flow = Flow::new(self.system, h, start.third_order()?)?;
        flow.certify(until, &mut |node, found| {
            nodes.push(passed(node));
            regularity.extend(found);
            ControlFlow::Continue(())
        })?;
        Ok((nodes, regularity))
    }

    fn nodes(&self, h: f64, start: &State, until: f64) -> Measured<Vec<Passed>> {
        let nodes = Flow::new(self.system, h, start.third_order()?)?
            .until(until)?
            .nodes;
        Ok(nodes.iter().map(passed).collect())
    }

    fn back(&self, h: f64, start: &State, until: f64) -> Measured<Vec<Passed>> {
        let mut flow = Flow::new(self.system, h, start.third_order()?)?;
        flow.until(until)?;
        flow.reverse()?;
        Ok(flow.until(start.t)?.nodes.iter().map(passed).collect())
    }
}

/// What the checks look at of a node.
fn passed<const N: usize>(node: &Node<N>) -> Passed {
    Passed {
        t: node.t,
        q: node.q.to_vec(),
        v: node.v.to_vec(),
    }
}

/// The legs of a motion, and why there are no more.
pub struct Walked {
    /// The legs, at least three.
    pub legs: Vec<OwnedLeg<f64>>,
    /// The time that is reached.
    pub until: f64,
    /// Why the end is not.
    pub ended: Option<String>,
    /// The steps that were too long for the external forces.
    pub unresolved: Option<Unresolved>,
}

/// The legs of the motion from a state up to the time `until`, or as far as it goes.
pub fn legs(probe: &dyn Probe, h: f64, start: (&State, First), until: f64) -> Result<Walked, CheckFailure> {
    let (mut legs, mut reached) = (Vec::new(), start.0.t);
    // a time that is the end to within rounding is the end
    let last = until - 1e-6 * h;
    let (unresolved, walked) = probe.walk(h, start, &mut |_, time, leg| {
        legs.push(leg.to_owned());
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

/// By how much a vector is more than another one.
pub fn less(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| x - y).collect()
}

/// Nodes of the motion from a state with the step `h`, at `count` multiples of `part` steps: each as the triple about it.
pub fn nodes(
    probe: &dyn Probe,
    h: f64,
    start: (&State, First),
    (part, count): (u32, usize),
) -> Measured<Vec<Triple>> {
    let mut nodes: Vec<Triple> = Vec::with_capacity(count);
    let mut before: Option<OwnedLeg<f64>> = None;
    let (_, walked) = probe.walk(h, start, &mut |index, _, leg| {
        if let Some(first) = before.take() {
            let e = less(leg.d, &first.d);
            nodes.push(Triple { leg: first, e });
        }
        if index == u64::from(part) * (nodes.len() as u64 + 1) {
            before = Some(leg.to_owned());
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
pub fn exact(
    probe: &dyn Probe,
    h: f64,
    start: &State,
    times: &[f64],
    tolerance: f64,
) -> Measured<Vec<OwnedPoint<f64>>> {
    let mut motion = Vec::with_capacity(times.len());
    let tolerance = Tolerance::relative(tolerance);
    probe.sample(start, tolerance, (times, h < 0.0), &mut |_, point| {
        motion.push(point.to_owned());
    })?;
    Ok(motion)
}
