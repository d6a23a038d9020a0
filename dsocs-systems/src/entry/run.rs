//! A run that the command line asks for: how it begins, how exact it is, and the run.

use std::borrow::Cow;
use std::ops::ControlFlow;

use dsocs_core::taylor::GlobalError;
use dsocs_core::{
    AnyFlow, AnyNode, AnyStart, Composition, Declaration, OwnedNode, Quantity, Regularity, Run, RunError,
    SetupError, System, Tolerance,
};
use thiserror::Error;

use super::Row;
use super::erased::AnySystem;
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

impl Beginning {
    /// Checks that every vector has one component for each coordinate.
    ///
    /// # Errors
    ///
    /// [`RunFailure::Length`] for the first vector that has not.
    pub(super) fn fits(&self, coordinates: &[Quantity]) -> Result<(), RunFailure> {
        let (first, others): (_, &[_]) = match self {
            Self::Paper { q0, v0 } | Self::SecondOrder { q0, v0 } => (q0, &[("v0", v0)]),
            Self::ThirdOrder { q0, v0, a0 } => (q0, &[("v0", v0), ("a0", a0)]),
            Self::ThirdOrderByForce { q0, v0, force } => (q0, &[("v0", v0), ("f0", force)]),
            Self::Nodes { q0, q1 } => (q0, &[("q1", q1)]),
            Self::ThreeNodes { q0, q1, q2 } => (q0, &[("q1", q1), ("q2", q2)]),
            Self::Projected(beginning) | Self::At(_, beginning) => return beginning.fits(coordinates),
            Self::Near(a0, beginning) => {
                beginning.fits(coordinates)?;
                return fits("a0", a0, coordinates);
            }
        };
        fits("q0", first, coordinates)?;
        others
            .iter()
            .try_for_each(|(vector, components)| fits(vector, components, coordinates))
    }

    /// The start of a run.
    pub(crate) fn start(&self) -> AnyStart {
        match self {
            Self::Paper { q0, v0 } => AnyStart::paper(q0, v0),
            Self::SecondOrder { q0, v0 } => AnyStart::second_order(q0, v0),
            Self::ThirdOrder { q0, v0, a0 } => AnyStart::third_order(q0, v0, a0),
            Self::ThirdOrderByForce { q0, v0, force } => AnyStart::third_order_by_force(q0, v0, force),
            Self::Nodes { q0, q1 } => AnyStart::nodes(q0, q1),
            Self::ThreeNodes { q0, q1, q2 } => AnyStart::three_nodes(q0, q1, q2),
            Self::Projected(beginning) => beginning.start().projected(),
            Self::Near(a0, beginning) => beginning.start().near_acceleration(a0),
            Self::At(t0, beginning) => beginning.start().at(*t0),
        }
    }

    /// The time of the start.
    fn time(&self) -> f64 {
        match self {
            Self::At(t0, _) => *t0,
            Self::Projected(beginning) | Self::Near(_, beginning) => beginning.time(),
            _ => 0.0,
        }
    }
}

/// Checks that a vector has one component for each coordinate.
///
/// # Errors
///
/// [`RunFailure::Length`] if it has not.
pub(super) fn fits(
    vector: &'static str,
    components: &[f64],
    coordinates: &[Quantity],
) -> Result<(), RunFailure> {
    if components.len() == coordinates.len() {
        return Ok(());
    }
    Err(RunFailure::Length {
        vector,
        found: components.len(),
        coordinates: coordinates
            .iter()
            .map(|coordinate| coordinate.name.clone())
            .collect(),
    })
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

/// How far a motion is from the continuous one; see [`GlobalError`].
pub(super) trait Errors {
    /// The error of each coordinate of a position at a time.
    fn at(&mut self, t: f64, q: &[f64]) -> Result<Vec<f64>, RunError>;

    /// How well the continuous motion is known.
    fn uncertainty(&self) -> f64;
}

impl<const N: usize> Errors for GlobalError<'_, N> {
    fn at(&mut self, t: f64, q: &[f64]) -> Result<Vec<f64>, RunError> {
        let q = q.first_chunk().unwrap_or(&[f64::NAN; N]);
        Ok(Self::at(self, t, q)?.to_vec())
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
pub(super) fn run(
    system: &dyn AnySystem,
    plan: &Plan,
    beginning: &Beginning,
    sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
) -> Result<(), RunFailure> {
    begin(system, plan, beginning, &mut |run, system| {
        let (mut free, mut held);
        let error: Option<&mut dyn Errors> = if !plan.estimate {
            None
        } else if plan.inputs.is_empty() {
            let last = run.clock().until(plan.until)?.time();
            free = system.errors(beginning, last).map_err(RunFailure::Estimate)?;
            Some(&mut *free)
        } else {
            let errors = HeldErrors::new(system, plan.h, beginning, &plan.inputs);
            held = errors.map_err(|error| RunFailure::Estimate(error.into()))?;
            Some(&mut held)
        };
        let shape = system.kernel().shape();
        // what the step says of forces is asked for at every node
        let forced = shape.external_forces && plan.method == Method::Step && !plan.certify;
        let is_closed = !shape.external_forces
            && !shape.depends_on_time
            && shape.kinematic == 0
            && plan.inputs.is_empty()
            && !matches!(plan.method, Method::Tolerance(_));
        hand_on(run, (forced, is_closed), error, plan, sink)
    })
}

/// At every node with such a number the energy's terms are looked at.
const TERMS_EVERY: u64 = 16;

/// The power of a node's constraint force and, at some nodes, the sum of the energy's terms.
fn balance(declaration: &Declaration<'_>, node: &AnyNode<'_>) -> (f64, Option<f64>) {
    let power: f64 = node.force.iter().zip(node.v).map(|(force, v)| force * v).sum();
    // their mean is wanted, which some nodes tell as well
    let terms = node.index.is_multiple_of(TERMS_EVERY).then(|| {
        let lagrangian = declaration.lagrangian(node.t, node.q, node.v);
        node.energy.abs() + 2.0 * lagrangian.abs()
    });
    (power, terms)
}

/// What is done with a run that stands at its start, and the system with the values that inputs begin with.
type Use<'u> = dyn FnMut(&mut (dyn Run + '_), &dyn AnySystem) -> Result<(), RunFailure> + 'u;

/// Sets up a run, and does with it what is to be done.
///
/// # Errors
///
/// [`RunFailure`] if the run cannot be set up, and that of what is done.
pub(super) fn begin(
    system: &dyn AnySystem,
    plan: &Plan,
    beginning: &Beginning,
    then: &mut Use<'_>,
) -> Result<(), RunFailure> {
    let Plan { h, until, method, .. } = *plan;
    let shape = system.kernel().shape();
    beginning.fits(&shape.coordinates)?;
    if !until.is_finite() {
        return Err(RunError::Until { until }.into());
    }
    // the values that inputs begin with
    let mut begun = system.copy();
    for input in &plan.inputs {
        let place = shape
            .parameters
            .iter()
            .position(|known| known.name == input.parameter);
        let parameter = place.and_then(|place| begun.parameter(place));
        if let (Some(parameter), Some(value)) = (parameter, input.at(beginning.time(), h)) {
            *parameter = value;
        }
    }
    let system = &*begun;
    // whatever the method: step, parameters and start are to be usable
    let step = AnyFlow::new(system.kernel(), h, &beginning.start())?;
    let mut run = match method {
        Method::Step => step.into_run(),
        Method::Composed(composition) => system.composed(h, composition, beginning)?,
        Method::Tolerance(tolerance) => {
            system.continuous(beginning, Tolerance::relative(tolerance), Some(h))?
        }
    };
    then(&mut *run, system)
}

/// Goes on to the next node, or begins with the first.
pub(super) fn next(run: &mut dyn Run) -> Result<(), RunError> {
    if run.clock().is_handed_out() {
        run.advance()?;
    } else {
        let forever = if run.clock().is_forward() {
            f64::INFINITY
        } else {
            f64::NEG_INFINITY
        };
        let forever = run.clock().until(forever)?;
        run.go_on(&forever)?;
    }
    Ok(())
}

/// Takes a run at a node.
type Take<'t> = dyn FnMut(&dyn Run) -> ControlFlow<()> + 't;

/// Runs with inputs that change, and shows the run at every node.
fn driven(run: &mut dyn Run, plan: &Plan, take: &mut Take<'_>) -> Result<(), RunError> {
    // the step knows one position more than its node
    let ahead = u64::from(plan.method == Method::Step);
    let end = run.clock().until(plan.until)?.time();
    loop {
        let now = run.clock().time_of(run.clock().index() + ahead);
        held::set(run, &plan.inputs, (now, plan.h))?;
        next(run)?;
        if take(run).is_break() || (end - run.clock().time()) * plan.h.signum() < 0.5 * plan.h.abs() {
            break;
        }
    }
    Ok(())
}

/// Hands the nodes of a run on.
fn hand_on(
    run: &mut dyn Run,
    (forced, is_closed): (bool, bool),
    mut error: Option<&mut dyn Errors>,
    plan: &Plan,
    sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
) -> Result<(), RunFailure> {
    let shape = run.kernel().shape();
    let (mut observed, mut node) = (
        vec![0.0; shape.observables.len()],
        OwnedNode::new(shape.dimension()),
    );
    let is_driven = forced || !plan.inputs.is_empty();
    let mut failed = None;
    let mut take = |run: &dyn Run| {
        node.take(run);
        // with the values that inputs have by now
        let (declaration, node) = (run.declaration(), node.any());
        declaration.observe(node.point(), &mut observed);
        let multipliers = declaration.multipliers(&node);
        let regularity = || run.regularity().or(Some(Regularity::UNKNOWN));
        let mut row = Row {
            regularity: (plan.certify && !is_driven).then(regularity).flatten(),
            unresolved: is_driven.then(|| run.unresolved()).flatten(),
            balance: is_closed.then(|| balance(&declaration, &node)),
            ..Row::of(&node, &observed, &multipliers)
        };
        let Some(error) = &mut error else {
            return sink(&row);
        };
        match error.at(node.t, node.q) {
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
    if is_driven {
        driven(run, plan, &mut take)?;
    } else {
        run.walk(plan.until, &mut |run| Ok(take(run)))?;
    }
    match failed {
        Some(error) => Err(RunFailure::Estimate(error)),
        None => Ok(()),
    }
}
