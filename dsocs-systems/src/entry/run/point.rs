//! A run that keeps no table: one point of a sweep.

use std::ops::ControlFlow;

use dsocs_core::taylor::Jet;
use dsocs_core::{
    AnyEvent, AnyEvents, AnyNode, AnyObserver, AnyOccurrence, Declaration, OwnedNode, Run, RunError, Stop,
};

use super::{Beginning, Method, Plan, RunFailure, held_inputs, next, with_run};
use crate::entry::{Entry, Row};

impl Entry {
    /// Runs as planned, to the end or to the first event that ends the run, and returns the index of this
    /// event among those `watched`. `sink` gets the events, each node if `nodes` is set, and the point where
    /// the run ended. For a run that fails, this is its last node.
    ///
    /// # Errors
    ///
    /// [`RunFailure`] if the run cannot be set up or does not reach its end.
    pub fn run_point(
        &self,
        plan: &Plan,
        beginning: &Beginning,
        watched: &[WatchedEvent],
        nodes: bool,
        sink: &mut dyn FnMut(RunItem<'_>),
    ) -> Result<Option<usize>, RunFailure> {
        let plan = &*plan.with_own_values(&*self.system);
        let request = ObservedRun { plan, watched, nodes };
        let mut ended = None;
        with_run(&*self.system, plan, beginning, &mut |run, system| {
            let system = Declaration::of(system.kernel());
            ended = run_point(run, &system, &request, sink)?;
            Ok(())
        })?;
        Ok(ended)
    }
}

/// An event to be watched: a quantity passes a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WatchedEvent {
    /// The quantity.
    pub quantity: EventQuantity,
    /// The value that it passes.
    pub value: f64,
    /// `Some(true)` if only upwards, `Some(false)` if only downwards.
    pub rising: Option<bool>,
    /// Whether the run ends there.
    pub ends: bool,
}

/// A quantity that can be watched, by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventQuantity {
    /// Time.
    Time,
    /// A coordinate.
    Position(usize),
    /// The rate of a coordinate.
    Velocity(usize),
    /// An observed expression.
    Observed(usize),
}

/// An item that a run passes to its observer.
#[derive(Clone, Copy)]
pub enum RunItem<'a> {
    /// A node.
    Node(&'a Row<'a>),
    /// An event that happened: its index among those watched, and the time.
    Event(usize, f64),
    /// The point where the run ended: the last node, or the event that ended it. For an event between nodes there are no forces and no
    /// multipliers.
    End(&'a Row<'a>),
}

/// A run, and the parts of it that are observed.
struct ObservedRun<'a> {
    /// The run.
    pub plan: &'a Plan,
    /// The events that are watched.
    pub watched: &'a [WatchedEvent],
    /// Whether each node is shown.
    pub nodes: bool,
}

/// Runs to the end, or to the first event that ends the run, and returns the index of this event. Where the
/// run fails, its last node is passed on as the end. `system` has the initial values of the inputs.
///
/// # Errors
///
/// [`RunFailure`] if a step has no solution.
fn run_point(
    run: &mut dyn Run,
    system: &Declaration<'_>,
    request: &ObservedRun<'_>,
    sink: &mut dyn FnMut(RunItem<'_>),
) -> Result<Option<usize>, RunFailure> {
    let (ended, result) = match advance(run, system, request, sink) {
        Ok(ended) => (ended, Ok(())),
        Err(error) => (None, Err(error)),
    };
    let declaration = run.declaration();
    if let Some(event) = &ended {
        let point = event.point();
        let nowhere = vec![f64::NAN; system.dimension()];
        let node = AnyNode {
            index: run.clock().index(),
            t: point.t,
            q: point.q,
            v: point.v,
            a: point.a,
            force: &nowhere,
            energy: declaration.energy(point.t, point.q, point.v),
            iterations: 0,
            stop: Stop::Start,
        };
        sink(RunItem::End(&Row::of(node, declaration)));
    } else {
        let mut node = OwnedNode::new(system.dimension());
        node.take(run);
        sink(RunItem::End(&Row::of(node.any(), declaration)));
    }
    result.map(|()| ended.map(|event| event.event))
}

/// Makes the steps.
fn advance(
    run: &mut dyn Run,
    system: &Declaration<'_>,
    request: &ObservedRun<'_>,
    sink: &mut dyn FnMut(RunItem<'_>),
) -> Result<Option<AnyOccurrence>, RunFailure> {
    let ObservedRun { plan, watched, nodes } = *request;
    let driven = !plan.inputs.is_empty();
    if watched.is_empty() && !nodes && !driven {
        // only the end is wanted: nodes on the way are not computed
        run.to(plan.until)?;
        return Ok(None);
    }
    let mut observer = RunObserver {
        nodes: nodes && !driven,
        node: OwnedNode::new(system.dimension()),
        sink,
    };
    if !driven {
        if watched.is_empty() {
            run.walk(plan.until, &mut |run| Ok(observer.node(run)))?;
            return Ok(None);
        }
        return Ok(run.watch(plan.until, &mut events(watched, system), &mut observer)?);
    }
    // inputs change at nodes, so the run goes leg by leg
    let end = run.clock().until(plan.until)?.time();
    let mut events = events(watched, system);
    let ahead = u64::from(plan.method == Method::Step);
    loop {
        let now = run.clock().time_of(run.clock().index() + ahead);
        held_inputs::set(run, &plan.inputs, (now, plan.h))?;
        let mut ended = None;
        if watched.is_empty() || !run.clock().is_handed_out() {
            next(run, plan.h)?;
        } else {
            let next = run.clock().time_of(run.clock().index() + 1);
            ended = run.watch(next, &mut events, &mut observer)?;
        }
        if ended.is_some() {
            return Ok(ended);
        }
        observer.node.take(run);
        if nodes {
            // the parameters have their current values
            observer.show(run.declaration());
        }
        if (end - observer.node.any().t) * plan.h.signum() < 0.5 * plan.h.abs() {
            return Ok(None);
        }
    }
}

/// Passes the nodes and events of a run to the observer.
struct RunObserver<'l> {
    /// Whether nodes are shown.
    nodes: bool,
    /// Room for a node.
    node: OwnedNode,
    /// The observer.
    sink: &'l mut dyn FnMut(RunItem<'_>),
}

impl RunObserver<'_> {
    /// Passes on the current node.
    fn show(&mut self, declaration: Declaration<'_>) {
        (self.sink)(RunItem::Node(&Row::of(self.node.any(), declaration)));
    }
}

impl AnyObserver for RunObserver<'_> {
    fn node(&mut self, run: &dyn Run) -> ControlFlow<()> {
        if self.nodes {
            self.node.take(run);
            self.show(run.declaration());
        }
        ControlFlow::Continue(())
    }

    fn event(&mut self, occurrence: &AnyOccurrence) -> ControlFlow<()> {
        (self.sink)(RunItem::Event(occurrence.event, occurrence.point().t));
        ControlFlow::Continue(())
    }
}

/// The events of a system.
fn events<'e>(watched: &[WatchedEvent], system: &'e Declaration<'e>) -> AnyEvents<'e> {
    let event = |watched: &WatchedEvent| {
        let WatchedEvent { quantity, value, .. } = *watched;
        let event = AnyEvent::function(move |point| {
            let found = match quantity {
                EventQuantity::Time => point.t,
                EventQuantity::Position(place) => point.q[place],
                EventQuantity::Velocity(place) => point.v[place],
                EventQuantity::Observed(place) => {
                    let mut observed = vec![Jet::from(f64::NAN); system.shape().observables.len()];
                    system.observe(point, &mut observed);
                    observed[place]
                }
            };
            found - Jet::from(value)
        });
        let event = match watched.rising {
            Some(true) => event.rising(),
            Some(false) => event.falling(),
            None => event,
        };
        if watched.ends { event.terminal() } else { event }
    };
    AnyEvents::new(watched.iter().map(event).collect())
}

/// A stable word for why a run ended early, for tables.
#[must_use]
pub fn failure_code(failure: &RunFailure) -> &'static str {
    use dsocs_core::{SetupError, StepFailure};
    let step = |failure: Option<StepFailure>, other| match failure {
        Some(StepFailure::NotFinite) => "not-finite",
        Some(StepFailure::Singular) => "singular",
        Some(StepFailure::NotConverged) => "not-converged",
        Some(StepFailure::NoSolution) => "no-solution",
        Some(StepFailure::Degenerate) => "degenerate",
        Some(StepFailure::AmbiguousRoot) => "ambiguous-root",
        Some(StepFailure::PassesSingularity) => "singularity",
        Some(StepFailure::PassesRest) => "rest",
        Some(StepFailure::Forks) => "fork",
        Some(StepFailure::TurnsTooFar) => "turn",
        _ => other,
    };
    let setup = |error: &SetupError| match error {
        SetupError::Inconsistent { .. } | SetupError::Projection { .. } => "inconsistent-start",
        SetupError::Acceleration { .. } => "no-acceleration",
        SetupError::Singular { .. } => "singular",
        SetupError::Parameter { .. } | SetupError::SubnormalParameter { .. } => "parameter",
        _ => "setup",
    };
    match failure {
        RunFailure::Setup(error) => setup(error),
        RunFailure::Run(error) => match error {
            RunError::Setup(error) => setup(error),
            RunError::Step(_) => step(error.step_failure(), "step"),
            RunError::Stage(_) => step(error.step_failure(), "stage"),
            RunError::Series(_) => "series",
            RunError::Event(_) => "event",
            RunError::Input(_) => "input",
            _ => "run",
        },
        _ => "run",
    }
}
