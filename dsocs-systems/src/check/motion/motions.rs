//! Discrete and continuous motions of a system, for the checks.

use std::ops::ControlFlow;

use dsocs_core::geometry::{Expansion, Triple};
use dsocs_core::{
    AnyFlow, AnyLeg, AnyNode, AnyPoint, AnyStart, Kernel, NearlySingular, OwnedLeg, OwnedNode, OwnedPoint,
    Regularity, Run, RunError, SetupError, Stop, Tolerance, Unresolved, Workspace,
};

use crate::check::{Measured, Settings};
use crate::entry::{Beginning, CheckFailure, Motions};

/// A state of the continuous motion.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// The time.
    pub t: f64,
    /// The position.
    pub q: Vec<f64>,
    /// The velocity.
    pub v: Vec<f64>,
    /// The acceleration near which a solution is looked for, where there may be several.
    pub near: Option<Vec<f64>>,
    /// The expansion of the motion about it, where runs begin with two nodes of the motion.
    pub expansion: Option<Expansion>,
}

/// The rule for the second node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SecondNode {
    /// `q1 = q0 + h v0 + h²/2 a0`.
    SecondOrder,
    /// `q1 = q0 + h v0`.
    Paper,
    /// `q1 = q(t0 + h)` by the expansion of the motion about the state, as far as it reaches; beyond, as of second order.
    Exact,
}

/// A visitor of the nodes: gets the number, the time and the leg, and whether a function jumps or holds
/// something in the step there; returns whether the motion goes on.
type LegVisitor<'w> = &'w mut dyn FnMut(u64, f64, AnyLeg<'_, f64>, bool) -> bool;

/// The nodes of a motion of third order, the regularity of its steps, and those in which something jumps.
pub type CertifiedNodes = (Vec<MotionNode>, Vec<Regularity>, DoubtfulSteps);

/// A node of a motion of third order.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionNode {
    /// The time.
    pub t: f64,
    /// The position.
    pub q: Vec<f64>,
    /// The velocity.
    pub v: Vec<f64>,
}

impl State {
    /// The start of the motion to check.
    pub fn of(settings: &Settings<'_>) -> Self {
        Self {
            t: settings.t0,
            q: settings.q0.to_vec(),
            v: settings.v0.to_vec(),
            near: settings.a0.map(<[f64]>::to_vec),
            expansion: None,
        }
    }

    /// The start of a run with a step.
    fn start(&self, second_node: SecondNode, h: f64) -> AnyStart {
        match &self.expansion {
            Some(motion) if second_node == SecondNode::Exact && h.abs() <= motion.reach => {
                let point = motion.point(0.0);
                let AnyPoint { q, v, a, .. } = point.any();
                AnyStart::exact(q, [v, a], &motion.increment(h), [self.t, h])
            }
            _ => self.beginning(second_node).start(),
        }
    }

    /// The beginning of a run, with another rule for the second node if that is the first.
    pub fn beginning(&self, second_node: SecondNode) -> Beginning {
        let (q0, v0) = (self.q.clone(), self.v.clone());
        let start = match second_node {
            SecondNode::SecondOrder | SecondNode::Exact => Beginning::SecondOrder { q0, v0 },
            SecondNode::Paper => Beginning::Paper { q0, v0 },
        };
        let start = Beginning::At(self.t, Box::new(start));
        match &self.near {
            Some(near) => Beginning::Near(near.clone(), Box::new(start)),
            None => start,
        }
    }

    /// The beginning, projected onto the constraints of positions and velocities.
    fn projected_beginning(&self) -> Beginning {
        Beginning::Projected(Box::new(self.beginning(SecondNode::SecondOrder)))
    }

    /// The start of a run of third order, with the given acceleration.
    pub fn third_order(&self) -> Result<AnyStart, SetupError> {
        let a0 = self.near.as_ref().ok_or(SetupError::FreeAcceleration)?;
        Ok(AnyStart::third_order(&self.q, &self.v, a0).at(self.t))
    }
}

/// The steps of a motion in which assumptions of the theorems do not hold.
#[derive(Clone, Copy, Default)]
pub struct DoubtfulSteps {
    /// Steps that did not resolve a jump.
    pub unresolved: Option<Unresolved>,
    /// Steps near a singularity.
    pub nearly_singular: Option<NearlySingular>,
}

impl DoubtfulSteps {
    /// The doubtful steps of a run so far.
    fn of(run: &dyn Run) -> Self {
        Self {
            unresolved: run.unresolved(),
            nearly_singular: run.nearly_singular(),
        }
    }
}

/// Walks along the discrete motion from a state, from the second node on. Returns its doubtful steps.
pub fn follow(
    system: &dyn Kernel,
    h: f64,
    (state, second_node): (&State, SecondNode),
    visitor: LegVisitor<'_>,
) -> (DoubtfulSteps, Result<(), CheckFailure>) {
    let mut flow = match AnyFlow::new(system, h, &state.start(second_node, h)) {
        Ok(flow) => flow,
        Err(error) => return (DoubtfulSteps::default(), Err(error.into())),
    };
    let mut is_held = false;
    while visitor(flow.index(), flow.time(), flow.leg(), is_held) {
        match flow.run_mut().advance() {
            Ok(report) => is_held = matches!(report.stop, Stop::Jump | Stop::Sticks) || flow.meets_jump(),
            Err(error) => return (DoubtfulSteps::of(flow.run()), Err(error.into())),
        }
    }
    (DoubtfulSteps::of(flow.run()), Ok(()))
}

/// The projection of a state onto the constraints of positions and velocities.
pub fn projected(system: &dyn Kernel, h: f64, state: &State) -> Result<State, CheckFailure> {
    let flow = AnyFlow::new(system, h, &state.projected_beginning().start())?;
    let MotionNode { q, v, .. } = node_of(flow.run());
    Ok(State {
        t: state.t,
        q,
        v,
        near: state.near.clone(),
        expansion: None,
    })
}

/// The continuous motion about a state.
pub fn expansion(system: &dyn Motions, start: &State) -> Measured<Expansion> {
    let n = system.kernel().shape().dimension().max(1);
    let mut motion = system.continuous(&start.projected_beginning(), Tolerance::relative(1e-15), None)?;
    let mut found = None;
    motion.trace(f64::INFINITY, &mut Workspace::new(), &mut |_, polynomial| {
        let orders = polynomial.series().positions().chunks(n);
        found = Some(Expansion {
            t: start.t,
            coefficients: orders.map(<[f64]>::to_vec).collect(),
            rotations: system.kernel().shape().rotations.to_vec(),
            reach: polynomial.length().abs(),
        });
        Ok(None)
    })?;
    Ok(found.ok_or("the motion has no series")?)
}

/// The nodes of a motion from a start up to a time, with the regularity of each step,
/// and the steps in which something jumps.
pub fn certified_nodes(
    system: &dyn Kernel,
    h: f64,
    start: &AnyStart,
    until: f64,
) -> Result<CertifiedNodes, CheckFailure> {
    let (mut nodes, mut regularity) = (Vec::new(), Vec::new());
    let mut flow = AnyFlow::new(system, h, start)?;
    flow.run_mut().walk(until, &mut |run| {
        nodes.push(node_of(run));
        regularity.extend(run.regularity());
        Ok(ControlFlow::Continue(()))
    })?;
    Ok((nodes, regularity, DoubtfulSteps::of(flow.run())))
}

/// The nodes of a motion with a step, between two times; or those of the way back from the end.
pub fn nodes_between(
    system: &dyn Kernel,
    h: f64,
    start: &AnyStart,
    (begin, until): (f64, f64),
    back: bool,
) -> Measured<Vec<MotionNode>> {
    let mut flow = AnyFlow::new(system, h, start)?;
    let run = flow.run_mut();
    let until = if back {
        run.walk_to(until, &mut |_| Ok(ControlFlow::Continue(())))?;
        run.reverse()?;
        begin
    } else {
        until
    };
    let mut nodes = Vec::new();
    run.walk_to(until, &mut |run| {
        nodes.push(node_of(run));
        Ok(ControlFlow::Continue(()))
    })?;
    Ok(nodes)
}

/// Time, position and velocity at the node where a run stands.
pub fn node_of(run: &dyn Run) -> MotionNode {
    let mut node = OwnedNode::new(run.kernel().shape().dimension());
    node.take(run);
    let AnyNode { t, q, v, .. } = node.any();
    MotionNode {
        t,
        q: q.to_vec(),
        v: v.to_vec(),
    }
}

/// The legs of a motion, and the reason why there are no more.
pub struct MotionLegs {
    /// The legs, at least three.
    pub legs: Vec<OwnedLeg<f64>>,
    /// The time that is reached.
    pub until: f64,
    /// The reason why the end was not reached.
    pub ended: Option<String>,
    /// Its doubtful steps.
    pub doubtful: DoubtfulSteps,
    /// Whether a function jumps, or holds something at rest, in the step that begins with a leg.
    pub held: Vec<bool>,
}

/// The legs of the motion from a state up to the time `until`, or as far as it goes.
pub fn legs(
    system: &dyn Kernel,
    h: f64,
    start: (&State, SecondNode),
    until: f64,
) -> Result<MotionLegs, CheckFailure> {
    let (mut legs, mut held, mut reached) = (Vec::new(), Vec::new(), start.0.t);
    let mut holding = false;
    // a time that equals the end to rounding is the end
    let last = until - 1e-6 * h;
    let (doubtful, outcome) = follow(system, h, start, &mut |_, time, leg, is_held| {
        if !legs.is_empty() {
            // a coordinate held on the last leg of a step is held on the first of the next one, which may
            // release it
            held.push(is_held || holding);
            holding = is_held;
        }
        legs.push(leg.to_owned());
        reached = time;
        (time - last) * h.signum() < 0.0 || legs.len() < 3
    });
    let ended = match outcome {
        Ok(()) => None,
        Err(error) if legs.len() < 3 => return Err(error),
        Err(error) => Some(error.to_string()),
    };
    Ok(MotionLegs {
        legs,
        until: reached,
        ended,
        doubtful,
        held,
    })
}

/// The difference of two vectors.
pub fn less(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| x - y).collect()
}

/// The triples about the nodes with the numbers `part`, `2 part`, … of the motion from a state with the step `h`: `count`
/// of them, or fewer if the motion ends before.
pub fn nodes(
    system: &dyn Kernel,
    h: f64,
    start: (&State, SecondNode),
    (part, count): (u32, usize),
) -> Measured<Vec<Triple>> {
    let mut nodes: Vec<Triple> = Vec::with_capacity(count);
    let mut before: Option<OwnedLeg<f64>> = None;
    let (_, outcome) = follow(system, h, start, &mut |index, _, leg, _| {
        if let Some(first) = before.take() {
            let e = less(leg.d, &first.d);
            nodes.push(Triple { leg: first, e });
        }
        if index == u64::from(part) * (nodes.len() as u64 + 1) {
            before = Some(leg.to_owned());
        }
        nodes.len() < count
    });
    match outcome {
        Ok(()) => Ok(nodes),
        // these nodes are another motion's, so their error is not that of the checked motion
        Err(CheckFailure::Setup(error)) => Err(error.into()),
        Err(CheckFailure::Run(error)) => Err(error.into()),
        Err(error) => Err(error.into()),
    }
}

/// The continuous motion from a state at some times, in the direction of `h`, to a tolerance.
pub fn exact(
    system: &dyn Motions,
    h: f64,
    start: &State,
    times: &[f64],
    tolerance: f64,
) -> Measured<Vec<OwnedPoint<f64>>> {
    match continuous_to_its_end(system, h, start, times, tolerance)? {
        (motion, None) => Ok(motion),
        (_, Some(ended)) => Err(ended.into()),
    }
}

/// The continuous motion as far as it exists, and the reason why it ends before the last time, if it does.
pub fn continuous_to_its_end(
    system: &dyn Motions,
    h: f64,
    start: &State,
    times: &[f64],
    tolerance: f64,
) -> Measured<(Vec<OwnedPoint<f64>>, Option<RunError>)> {
    let mut motion = Vec::with_capacity(times.len());
    let beginning = start.beginning(SecondNode::SecondOrder);
    let mut run = system.continuous(&beginning, Tolerance::relative(tolerance), None)?;
    if h < 0.0 {
        run.reverse()?;
    }
    let sampled = run.sample(times, &mut |_, point| motion.push(point.to_owned()));
    Ok((motion, sampled.err()))
}
