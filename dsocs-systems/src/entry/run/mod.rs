//! A run according to a plan.

mod any_system;
pub(super) mod beginning;
mod failure;
mod held_inputs;
#[cfg(feature = "sweep")]
mod lanes;
mod plan;
#[cfg(feature = "sweep")]
mod point;
mod reference;

use std::ops::ControlFlow;

use dsocs_core::{AnyFlow, Regularity, Run, RunError, Tolerance};

use super::Entry;
use super::columns::{LastNodes, Row};
use held_inputs::ErrorsUnderInputs;
use reference::Errors;

pub use any_system::ExtraParameter;
pub(super) use any_system::{AnySystem, EntrySystem};
pub(crate) use any_system::{Motions, TypedSystem};
pub use beginning::Beginning;
pub use failure::RunFailure;
#[cfg(feature = "sweep")]
pub use lanes::{VariedParameter, can_share_lanes};
pub use plan::{HeldInput, Method, Plan};
#[cfg(feature = "sweep")]
pub use point::{EventQuantity, RunItem, WatchedEvent, failure_code};

impl Entry {
    /// Runs as planned and hands each node to `sink`, which may end the run.
    ///
    /// # Errors
    ///
    /// [`RunFailure`] if the run cannot be set up or does not reach its end.
    pub fn run(
        &self,
        plan: &Plan,
        beginning: &Beginning,
        sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
    ) -> Result<(), RunFailure> {
        run(&*self.system, plan, beginning, sink)
    }
}

/// Runs from the start up to the last node at or before the end and passes each node to `sink`, which may end
/// the run. A certified run gives the regularity at each node; at the start, where no step is solved, it is
/// NaN.
///
/// # Errors
///
/// [`RunFailure`] if the run cannot be set up, a step has no solution, or the error cannot be estimated.
fn run(
    system: &dyn AnySystem,
    plan: &Plan,
    beginning: &Beginning,
    sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
) -> Result<(), RunFailure> {
    let plan = &plan.with_own_values(system);
    with_run(system, plan, beginning, &mut |run, system| {
        let (mut free, mut held);
        let error: Option<&mut dyn Errors> = if !plan.estimate {
            None
        } else if plan.inputs.is_empty() {
            let last = run.clock().until(plan.until)?.time();
            free = system.errors(beginning, last).map_err(RunFailure::Estimate)?;
            Some(&mut *free)
        } else {
            let errors = ErrorsUnderInputs::new(system, plan.h, beginning, &plan.inputs);
            held = errors.map_err(|error| RunFailure::Estimate(error.into()))?;
            Some(&mut held)
        };
        pass_on_nodes(run, error, plan, sink)
    })
}

/// A use of a run that stands at its start, and of the system with the initial values of the inputs.
type RunUse<'u> = dyn FnMut(&mut (dyn Run + '_), &dyn AnySystem) -> Result<(), RunFailure> + 'u;

/// Sets up a run, and passes it to `then`.
///
/// # Errors
///
/// [`RunFailure`] if the run cannot be set up, and the errors of `then`.
fn with_run(
    system: &dyn AnySystem,
    plan: &Plan,
    beginning: &Beginning,
    then: &mut RunUse<'_>,
) -> Result<(), RunFailure> {
    let Plan { h, until, method, .. } = *plan;
    let shape = system.kernel().shape();
    beginning.fits(shape)?;
    if !until.is_finite() {
        return Err(RunError::Until { until }.into());
    }
    // a copy of the system, with the initial values of the inputs
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
    // every method refuses the steps, parameters and starts that the paper's step refuses
    let step = || AnyFlow::new(system.kernel(), h, &beginning.start());
    let mut run = match method {
        Method::Step => step()?.into_run(),
        Method::Composed(composition) => {
            step()?;
            system.composed(h, composition, beginning)?
        }
        Method::Tolerance(tolerance) => {
            // between two times of the output a body may rotate by any angle, which a single step may not
            if shape.rotations.is_empty() {
                step()?;
            }
            system.continuous(beginning, Tolerance::relative(tolerance), Some(h))?
        }
    };
    then(&mut *run, system)
}

/// Makes the step to the next node in the direction of `h`, or begins with the first node.
fn next(run: &mut dyn Run, h: f64) -> Result<(), RunError> {
    if run.clock().is_handed_out() {
        run.step(f64::INFINITY.copysign(h))?;
    } else {
        let forever = run.clock().until(f64::INFINITY.copysign(h))?;
        run.go_on(&forever)?;
    }
    Ok(())
}

/// Observes a run at a node.
type NodeObserver<'t> = dyn FnMut(&dyn Run) -> ControlFlow<()> + 't;

/// Runs with inputs that change, and passes on the run at every node.
fn run_with_inputs(run: &mut dyn Run, plan: &Plan, take: &mut NodeObserver<'_>) -> Result<(), RunError> {
    // the step has computed one position beyond its node
    let ahead = u64::from(plan.method == Method::Step);
    let end = run.clock().until(plan.until)?.time();
    loop {
        let now = run.clock().time_of(run.clock().index() + ahead);
        held_inputs::set(run, &plan.inputs, (now, plan.h))?;
        next(run, plan.h)?;
        if take(run).is_break() || (end - run.clock().time()) * plan.h.signum() < 0.5 * plan.h.abs() {
            break;
        }
    }
    Ok(())
}

/// Passes on the nodes of a run.
fn pass_on_nodes(
    run: &mut dyn Run,
    mut error: Option<&mut dyn Errors>,
    plan: &Plan,
    sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
) -> Result<(), RunFailure> {
    let mut nodes = LastNodes::new(run.kernel().shape().dimension());
    let is_driven = !plan.inputs.is_empty();
    let mut unknown = None;
    let mut take = |run: &dyn Run| {
        let (before, node) = nodes.take(run);
        let declaration = if is_driven {
            // the values of the inputs before the node
            run.declaration_at_node()
        } else {
            run.declaration()
        };
        let regularity = || run.regularity().or(Some(Regularity::UNKNOWN));
        let mut row = Row {
            regularity: (plan.certify && !is_driven).then(regularity).flatten(),
            unresolved: run.unresolved(),
            nearly_singular: run.nearly_singular(),
            before,
            ..Row::of(node, declaration)
        };
        let Some(error) = &mut error else {
            return sink(&row);
        };
        let mut errors = vec![f64::NAN; node.q.len()];
        if unknown.is_none() {
            match error.at(node.t, node.q) {
                Ok(found) => errors = found,
                // the run continues without estimates of its errors
                Err(why) => unknown = Some(why),
            }
        }
        (row.errors, row.uncertainty, row.unknown) = (&errors, error.uncertainty(), unknown.as_ref());
        sink(&row)
    };
    if is_driven {
        run_with_inputs(run, plan, &mut take)?;
    } else {
        run.walk(plan.until, &mut |run| Ok(take(run)))?;
    }
    Ok(())
}
