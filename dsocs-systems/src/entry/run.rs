//! A run that the command line asks for: how it begins, how exact it is, and the run.

use std::ops::ControlFlow;

use dsocs_core::taylor::{GlobalError, Jets, Motion, State, TaylorError, Tolerance};
use dsocs_core::{
    ComposedFlow, Composition, Flow, Node, Regularity, RunError, SetupError, Start, Stop, multipliers,
    until_break,
};
use thiserror::Error;

use super::Row;

/// How the first two nodes are found.
#[derive(Clone, Debug, PartialEq)]
pub enum Beginning {
    /// From position and velocity, `q1 = q0 + h v0`.
    Paper {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
    },
    /// From position and velocity, `q1 = q0 + h v0 + h²/2 a0`.
    SecondOrder {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
    },
    /// Both nodes.
    Nodes {
        /// The first node.
        q0: Vec<f64>,
        /// The second node.
        q1: Vec<f64>,
    },
    /// Another beginning, moved onto the constraints of positions and velocities.
    Projected(Box<Self>),
}

/// How a motion is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// By the paper's step, of order 2.
    Step,
    /// By a composition of it.
    Composed(Composition),
    /// The continuous motion, to a tolerance relative to the size of the velocities.
    Tolerance(f64),
}

/// A run that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The step, and the interval of the output.
    pub h: f64,
    /// The time of the end.
    pub until: f64,
    /// How it is computed.
    pub method: Method,
    /// Whether the regularity at each node is recorded; of the paper's step alone.
    pub certify: bool,
    /// Whether the error at each node is estimated; see [`GlobalError`].
    pub estimate: bool,
}

/// A run did not reach its end.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RunFailure {
    /// It did not begin.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A vector has not as many components as the system has coordinates.
    #[error(
        "{vector} has {found} component{}, but there are {} coordinates: {}",
        if *.found == 1 { "" } else { "s" }, .coordinates.len(), .coordinates.join(", ")
    )]
    Length {
        /// Which vector.
        vector: &'static str,
        /// How many components it has.
        found: usize,
        /// The coordinates.
        coordinates: Vec<&'static str>,
    },
    /// It ended early.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The continuous motion ended early.
    #[error(transparent)]
    Taylor(#[from] TaylorError),
    /// There is no continuous motion to measure errors against.
    #[error("the error cannot be estimated: {0}")]
    Estimate(#[source] TaylorError),
    /// It begins with two nodes where a velocity is needed.
    #[error("a run of this kind begins with a position and a velocity, not with two nodes")]
    Velocity,
}

/// What hands the nodes of a run on.
struct Nodes<'a, S: Jets<N>, const N: usize> {
    /// The system.
    system: &'a S,
    /// What takes them.
    sink: &'a mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
    /// The observed expressions of the last one.
    observed: Vec<f64>,
    /// What estimates errors.
    error: Option<GlobalError<'a, S, N>>,
    /// Why errors cannot be estimated any more.
    failed: Option<TaylorError>,
}

impl<S: Jets<N>, const N: usize> Nodes<'_, S, N> {
    /// Takes a node.
    fn node(&mut self, node: &Node<N>, regularity: Option<Regularity>) -> ControlFlow<()> {
        self.system.observe(&node.point(), &mut self.observed);
        let mut row = Row {
            index: node.index,
            t: node.t,
            q: &node.q,
            v: &node.v,
            force: &node.force,
            energy: node.energy,
            observed: &self.observed,
            multipliers: &multipliers(self.system, node),
            regularity,
            errors: &[],
            doubt: 0.0,
        };
        let Some(error) = &mut self.error else {
            return (self.sink)(&row);
        };
        match error.at(node.t, &node.q) {
            Ok(errors) => {
                (row.errors, row.doubt) = (&errors, error.doubt());
                (self.sink)(&row)
            }
            Err(error) => {
                self.failed = Some(error);
                ControlFlow::Break(())
            }
        }
    }
}

/// Runs from the start up to the last node at or before the end and hands each node to `sink`, which may end the run. A
/// certified run tells the regularity at each node; at the start, where no step is solved, it is NaN.
///
/// `state` is position and velocity at the start, which every method but the paper's step begins with, and errors are measured
/// from.
///
/// # Errors
///
/// [`RunFailure`] if the run cannot be set up, a step has no solution, or the error cannot be estimated.
pub fn run<S: Jets<N>, const N: usize>(
    system: &S,
    plan: &Plan,
    start: Start<N>,
    state: Option<State<N>>,
    sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
) -> Result<(), RunFailure> {
    let Plan { h, until, method, .. } = *plan;
    // whatever the method: step, parameters and start are to be usable
    let mut flow = Flow::new(system, h, start)?;
    // what was given may have been projected
    let state = match (state, flow.clone().next()) {
        (Some(_), Some(Ok(Node { q, v, .. }))) => Some(State::new(q, v)),
        (state, _) => state,
    };
    let last = last_node(h, until)?;
    let error = match (plan.estimate, state) {
        (false, _) => None,
        (true, None) => return Err(RunFailure::Velocity),
        (true, Some(state)) => {
            Some(GlobalError::new(system, state, last as f64 * h).map_err(RunFailure::Estimate)?)
        }
    };
    let mut nodes = Nodes {
        system,
        sink,
        observed: vec![0.0; S::OBSERVABLES.len()],
        error,
        failed: None,
    };
    match (method, state) {
        (Method::Step, _) if plan.certify => flow.watchful().certify(until, |node, regularity| {
            nodes.node(node, regularity.or(Some(Regularity::UNKNOWN)))
        })?,
        (Method::Step, _) => flow.stream(until, &mut until_break(|node: &Node<N>| nodes.node(node, None)))?,
        (Method::Composed(composition), Some(State { q, v, .. })) => {
            let mut flow = ComposedFlow::new(system, h, composition, q, v)?;
            flow.stream(until, &mut until_break(|node: &Node<N>| nodes.node(node, None)))?;
        }
        (Method::Tolerance(tolerance), Some(state)) => continuous(&mut nodes, tolerance, state, h, last)?,
        (_, None) => return Err(RunFailure::Velocity),
    }
    match nodes.failed {
        Some(error) => Err(RunFailure::Estimate(error)),
        None => Ok(()),
    }
}

/// The continuous motion at the times of the nodes.
fn continuous<S: Jets<N>, const N: usize>(
    nodes: &mut Nodes<'_, S, N>,
    tolerance: f64,
    state: State<N>,
    h: f64,
    last: u64,
) -> Result<(), TaylorError> {
    let system = nodes.system;
    let mut motion = Motion::new(system, state, last as f64 * h, Tolerance::relative(tolerance))?;
    for index in 0..=last {
        let t = index as f64 * h;
        let point = motion.at(t)?;
        let node = Node {
            index,
            t,
            q: point.q,
            v: point.v,
            a: point.a,
            force: system.continuous_force(&point),
            energy: system.energy(&point.q, &point.v),
            iterations: 0,
            stop: Stop::Start,
        };
        if nodes.node(&node, None).is_break() {
            break;
        }
    }
    Ok(())
}

/// The number of the last node at or before `until`, to within rounding.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a cast saturates, which is what is wanted
fn last_node(h: f64, until: f64) -> Result<u64, RunError> {
    if !until.is_finite() {
        return Err(RunError::Until { until });
    }
    let steps = until / h;
    let nearest = steps.round();
    let whole = if (steps - nearest).abs() <= 4.0 * f64::EPSILON * steps.abs() {
        nearest
    } else {
        steps.floor()
    };
    if whole >= 0.0 {
        Ok(whole as u64)
    } else {
        Err(RunError::Behind { until, time: 0.0, h })
    }
}
