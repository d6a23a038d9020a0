//! A run that the command line asks for: how it begins, how exact it is, and the run.

use std::borrow::Cow;
use std::ops::ControlFlow;

use dsocs_core::taylor::GlobalError;
use dsocs_core::{
    ComposedFlow, Composition, Declaration, Flow, Inputs, Node, Regularity, RunError, SetupError, Start,
    System, TaylorFlow, Tolerance, Unresolved,
};
use thiserror::Error;

use super::Row;
use super::held::{self, HeldErrors, HeldInput};

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
    /// From position, velocity and acceleration, where a constraint is of third order.
    ThirdOrder {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
        /// The initial acceleration.
        a0: Vec<f64>,
    },
    /// The same with the constraint force in place of the acceleration.
    ThirdOrderByForce {
        /// The first node.
        q0: Vec<f64>,
        /// The initial velocity.
        v0: Vec<f64>,
        /// The initial constraint force.
        force: Vec<f64>,
    },
    /// Both nodes.
    Nodes {
        /// The first node.
        q0: Vec<f64>,
        /// The second node.
        q1: Vec<f64>,
    },
    /// Three nodes, where a constraint is of third order.
    ThreeNodes {
        /// The first node.
        q0: Vec<f64>,
        /// The second node.
        q1: Vec<f64>,
        /// The third node.
        q2: Vec<f64>,
    },
    /// Another beginning, moved onto the constraints on positions and velocities.
    Projected(Box<Self>),
    /// Another beginning, with the acceleration near this one where the equations allow several.
    Near(Vec<f64>, Box<Self>),
    /// Another beginning, at another time than 0.
    At(f64, Box<Self>),
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
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The step, and the interval of the output.
    pub h: f64,
    /// The time of the end.
    pub until: f64,
    /// How it is computed.
    pub method: Method,
    /// Whether the regularity at each node is recorded; possible with the paper's step only.
    pub certify: bool,
    /// Whether the error at each node is estimated; see [`GlobalError`].
    pub estimate: bool,
    /// Parameters that change during the run.
    pub inputs: Vec<HeldInput>,
}

/// A run did not reach its end.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RunFailure {
    /// It did not begin.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The number of components of a vector is not the number of coordinates.
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
        coordinates: Vec<Cow<'static, str>>,
    },
    /// It ended early.
    #[error(transparent)]
    Run(#[from] RunError),
    /// There is no continuous motion from which errors could be computed.
    #[error("the error cannot be estimated: {0}")]
    Estimate(#[source] RunError),
}

/// How far a motion is from the continuous one, whatever the system's type; see [`GlobalError`].
pub(super) trait Errors<const N: usize> {
    /// The error of each coordinate of a position at a time.
    fn at(&mut self, t: f64, q: &[f64; N]) -> Result<[f64; N], RunError>;

    /// How well the continuous motion is known.
    fn uncertainty(&self) -> f64;
}

impl<S: System<N>, const N: usize> Errors<N> for GlobalError<'_, S, N> {
    fn at(&mut self, t: f64, q: &[f64; N]) -> Result<[f64; N], RunError> {
        Self::at(self, t, q)
    }

    fn uncertainty(&self) -> f64 {
        Self::uncertainty(self)
    }
}

/// Runs from the start up to the last node at or before the end and hands each node to `sink`, which may end the run. A
/// certified run tells the regularity at each node; at the start, where no step is solved, it is NaN.
///
/// # Errors
///
/// [`RunFailure`] if the run cannot be set up, a step has no solution, or the error cannot be estimated.
pub(super) fn run<S: System<N> + Clone, const N: usize>(
    system: &S,
    plan: &Plan,
    start: Start<N>,
    sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
) -> Result<(), RunFailure> {
    begin(system, plan, start, &mut |run, system| {
        let (mut free, mut held);
        let error: Option<&mut dyn Errors<N>> = if !plan.estimate {
            None
        } else if plan.inputs.is_empty() {
            let last = run.clock().until(plan.until)?.time();
            free = GlobalError::new(system, start, last).map_err(RunFailure::Estimate)?;
            Some(&mut free)
        } else {
            let errors = HeldErrors::new(system, plan.h, start, &plan.inputs);
            held = errors.map_err(|error| RunFailure::Estimate(error.into()))?;
            Some(&mut held)
        };
        // what the step says of forces is asked for at every node
        let forced = S::EXTERNAL_FORCES && plan.method == Method::Step && !plan.certify;
        let is_closed = !S::EXTERNAL_FORCES
            && !S::DEPENDS_ON_TIME
            && S::KINEMATIC == 0
            && plan.inputs.is_empty()
            && !matches!(plan.method, Method::Tolerance(_));
        let balance = |node: &Node<N>| {
            let power: f64 = node.force.iter().zip(&node.v).map(|(force, v)| force * v).sum();
            // their mean is wanted, which some nodes tell as well
            let terms = node.index.is_multiple_of(TERMS_EVERY).then(|| {
                let lagrangian = system.lagrangian(node.t, &node.q, &node.v);
                node.energy.abs() + 2.0 * lagrangian.abs()
            });
            (power, terms)
        };
        let balance: Option<&Balance<'_, N>> = if is_closed { Some(&balance) } else { None };
        hand_on(
            run,
            (&Declaration::of(system), forced, balance),
            error,
            plan,
            sink,
        )
    })
}

/// At every node with such a number the energy's terms are looked at.
const TERMS_EVERY: u64 = 16;

/// The power of a node's constraint force and, at some nodes, the sum of the energy's terms.
type Balance<'b, const N: usize> = dyn Fn(&Node<N>) -> (f64, Option<f64>) + 'b;

/// A motion in progress, by any method.
pub(super) type Run<'r, const N: usize> = dyn Inputs<N> + 'r;

/// What is done with a run that stands at its start, and the system with the values that inputs begin with.
type Use<'u, S, const N: usize> = dyn FnMut(&mut Run<'_, N>, &S) -> Result<(), RunFailure> + 'u;

/// Sets up a run, and does with it what is to be done.
///
/// # Errors
///
/// [`RunFailure`] if the run cannot be set up, and that of what is done.
pub(super) fn begin<S: System<N> + Clone, const N: usize>(
    system: &S,
    plan: &Plan,
    start: Start<N>,
    then: &mut Use<'_, S, N>,
) -> Result<(), RunFailure> {
    let Plan { h, until, method, .. } = *plan;
    if !until.is_finite() {
        return Err(RunError::Until { until }.into());
    }
    // the values that inputs begin with
    let mut begun = system.clone();
    for input in &plan.inputs {
        let place = S::PARAMETERS
            .iter()
            .position(|known| known.name == input.parameter);
        let parameter = place.and_then(|place| begun.parameter_mut(place));
        if let (Some(parameter), Some(value)) = (parameter, input.at(start.time(), h)) {
            *parameter = value;
        }
    }
    let system = &begun;
    // whatever the method: step, parameters and start are to be usable
    let flow = Flow::new(system, h, start)?;
    let (mut step, mut composed, mut series);
    let run: &mut Run<'_, N> = match method {
        Method::Step => {
            step = flow;
            &mut step
        }
        Method::Composed(composition) => {
            composed = ComposedFlow::new(system, h, composition, start)?;
            &mut composed
        }
        Method::Tolerance(tolerance) => {
            series = TaylorFlow::new(system, start, Tolerance::relative(tolerance))?.every(h)?;
            &mut series
        }
    };
    then(run, system)
}

/// Takes a node, with the system as it is there and the steps so far that were too long for the external forces.
type Take<'t, const N: usize> =
    dyn FnMut(&Node<N>, &Declaration<'_>, Option<Unresolved>) -> ControlFlow<()> + 't;

/// Runs with inputs that change, and hands the nodes on, with the steps so far that were too long for the external forces.
fn driven<const N: usize>(
    run: &mut dyn Inputs<N>,
    plan: &Plan,
    take: &mut Take<'_, N>,
) -> Result<(), RunError> {
    // the step knows one position more than its node
    let ahead = u64::from(plan.method == Method::Step);
    let end = run.clock().until(plan.until)?.time();
    loop {
        let now = run.clock().time_of(run.clock().index() + ahead);
        held::set(run, &plan.inputs, (now, plan.h))?;
        let Some(node) = run.next_node() else { break };
        let node = node?;
        if take(&node, &run.run().declaration(), run.unresolved()).is_break()
            || (end - node.t) * plan.h.signum() < 0.5 * plan.h.abs()
        {
            break;
        }
    }
    Ok(())
}

/// Hands the nodes of a run on, whatever the system's type.
fn hand_on<const N: usize>(
    run: &mut dyn Inputs<N>,
    (system, forced, balance): (&Declaration<'_>, bool, Option<&Balance<'_, N>>),
    mut error: Option<&mut dyn Errors<N>>,
    plan: &Plan,
    sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
) -> Result<(), RunFailure> {
    let mut observed = vec![0.0; system.shape().observables.len()];
    let mut failed = None;
    let mut take = |node: &Node<N>,
                    declaration: &Declaration<'_>,
                    regularity: Option<Regularity>,
                    unresolved: Option<Unresolved>| {
        // with the values that inputs have by now
        declaration.observe(node.point().any(), &mut observed);
        let multipliers = declaration.multipliers(&node.any());
        let mut row = Row {
            regularity,
            unresolved,
            balance: balance.map(|of| of(node)),
            ..Row::of(&node.any(), &observed, &multipliers)
        };
        let Some(error) = &mut error else {
            return sink(&row);
        };
        match error.at(node.t, &node.q) {
            Ok(errors) => {
                (row.errors, row.uncertainty) = (&errors, error.uncertainty());
                sink(&row)
            }
            Err(error) => {
                failed = Some(error);
                ControlFlow::Break(())
            }
        }
    };
    if forced || !plan.inputs.is_empty() {
        driven(run, plan, &mut |node, declaration, unresolved| {
            take(node, declaration, None, unresolved)
        })?;
    } else if plan.certify {
        run.certify(plan.until, &mut |node, regularity| {
            take(node, system, regularity.or(Some(Regularity::UNKNOWN)), None)
        })?;
    } else {
        run.stream(plan.until, &mut |node: &Node<N>| take(node, system, None, None))?;
    }
    match failed {
        Some(error) => Err(RunFailure::Estimate(error)),
        None => Ok(()),
    }
}
