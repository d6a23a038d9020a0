//! The ladder of accuracy: what a run is asked for, and the run.

use std::ops::ControlFlow;

use dsocs_core::taylor::{GlobalError, Jets};
use dsocs_core::{
    ComposedFlow, Composition, Flow, Node, Regularity, RunError, Start, Stepper, TaylorFlow, Tolerance,
    multipliers,
};

use crate::registry::{Row, RunFailure};

/// How a motion is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rung {
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
    pub rung: Rung,
    /// Whether the regularity at each node is recorded; of the paper's step alone.
    pub certify: bool,
    /// Whether the error at each node is estimated; see [`GlobalError`].
    pub estimate: bool,
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
    failed: Option<RunError>,
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
/// # Errors
///
/// [`RunFailure`] if the run cannot be set up, a step has no solution, or the error cannot be estimated.
pub fn run<S: Jets<N>, const N: usize>(
    system: &S,
    plan: &Plan,
    start: Start<N>,
    sink: &mut dyn FnMut(&Row<'_>) -> ControlFlow<()>,
) -> Result<(), RunFailure> {
    let Plan { h, until, rung, .. } = *plan;
    if !until.is_finite() {
        return Err(RunError::Until { until }.into());
    }
    // whatever the method: step, parameters and start are to be usable
    let flow = Flow::new(system, h, start)?;
    let (mut step, mut composed, mut series);
    let run: &mut dyn Stepper<N> = match rung {
        Rung::Step => {
            step = if plan.certify { flow.watchful() } else { flow };
            &mut step
        }
        Rung::Composed(method) => {
            composed = ComposedFlow::new(system, h, method, start)?;
            &mut composed
        }
        Rung::Tolerance(tolerance) => {
            series = TaylorFlow::new(system, start, Tolerance::relative(tolerance))?.every(h)?;
            &mut series
        }
    };
    let last = run.clock().until(until)?.time();
    let error = match plan.estimate {
        false => None,
        true => Some(GlobalError::new(system, start, last).map_err(RunFailure::Estimate)?),
    };
    let mut nodes = Nodes {
        system,
        sink,
        observed: vec![0.0; S::OBSERVABLES.len()],
        error,
        failed: None,
    };
    if plan.certify {
        run.certify(until, &mut |node, regularity| {
            nodes.node(node, regularity.or(Some(Regularity::UNKNOWN)))
        })?;
    } else {
        run.stream(until, &mut |node: &Node<N>| nodes.node(node, None))?;
    }
    match nodes.failed {
        Some(error) => Err(RunFailure::Estimate(error)),
        None => Ok(()),
    }
}
