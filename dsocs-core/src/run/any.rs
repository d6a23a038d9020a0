//! A run of any method and any number of coordinates.

use core::ops::ControlFlow;

use super::{AnyPolynomial, Clock, End, InputError, Node, NotReversible, OwnedNode, RunError};
use super::{NearlySingular, Unresolved};
use crate::kernel::Kernel;
use crate::kernel::report::{NodeMut, StepReport};
use crate::regularity::Regularity;
use crate::series::rows::Series;
use crate::tape::declaration::Declaration;

/// Receives the motion of a step, polynomial by polynomial, with the declaration that holds there. It may
/// return a time at which the method is to stop, counted from the point of expansion of the polynomial.
pub type AnyVisitor<'v> =
    dyn FnMut(&Declaration<'_>, &AnyPolynomial<'_>) -> Result<Option<f64>, RunError> + 'v;

/// Receives the motion at several times together, and for each of them position, velocity and acceleration, one after the other; it may end
/// the run.
pub type SampleObserver<'o> = dyn FnMut(&[f64], &[f64]) -> ControlFlow<()> + 'o;

/// The end of a step that was shown to a visitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepEnd {
    /// The next node; the visitor returned no time at which to stop.
    NextNode,
    /// The next node, beyond the time at which the visitor wanted to stop.
    BeyondStop,
    /// The time at which the visitor wanted to stop.
    AtStop,
}

/// A run in progress, by any method and with any number of coordinates: the basis of [`crate::Stepper`]. All
/// vectors are slices with one entry for each coordinate.
///
/// A method implements this trait: one step, the node there, a [`Clock`]. The functions that drive a run (`advance`, `to`, `stream`, `watch`,
/// …) are those of `dyn Run`. They are compiled once, in this crate.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::{Composition, OwnedNode, Run};
///
/// /// A pendulum.
/// #[dsocs {
///     coordinates(theta);
///     lagrangian = dot(theta).powi(2) / 2 + theta.cos();
/// }]
/// struct Pendulum {}
///
/// /// The largest energy on the way to a time.
/// fn largest(run: &mut dyn Run, t: f64) -> Result<f64, RunError> {
///     let (mut node, mut energy) = (OwnedNode::new(1), f64::NEG_INFINITY);
///     run.walk(t, &mut |run| {
///         node.take(run);
///         energy = energy.max(node.any().energy);
///         Ok(std::ops::ControlFlow::Continue(()))
///     })?;
///     Ok(energy)
/// }
///
/// let start = Start::second_order([1.0], [0.0]);
/// let mut flow = ComposedFlow::new(&Pendulum {}, 0.1, Composition::SUZUKI_4, start)?;
/// assert!((largest(flow.run_mut(), 10.0)? + 1.0_f64.cos()).abs() < 1e-4);
/// # Ok::<(), RunError>(())
/// ```
///
/// # A new method
///
/// A new method owns a [`Clock`] and implements the functions without a body. If it knows the motion between its nodes better than
/// [`AnyPolynomial::between`] does, it implements [`Run::trace`].
pub trait Run {
    /// The system.
    fn kernel(&self) -> &dyn Kernel;

    /// The current values of the parameters, in the order of the declaration.
    fn values(&self) -> &[f64];

    /// The values of the parameters on the leg that ends at the current node. They differ from
    /// [`Run::values`] at a node of a [`crate::Flow`] where inputs change: its next position belongs to the
    /// new values.
    fn arriving_values(&self) -> &[f64] {
        self.values()
    }

    /// Whether each argument of a function that jumps with the velocity, as that of dry friction, stays zero where the motion goes on
    /// from the current node. Empty if none does, or if nodes are at rest exactly.
    fn resting(&self) -> Vec<bool> {
        Vec::new()
    }

    /// Whether velocities and accelerations of nodes are differences of their positions, and so differ from those of the motion through these.
    fn has_differences(&self) -> bool {
        false
    }

    /// Makes one step and advances the clock. No node is computed, and nothing is allocated. `end` is the time towards which the
    /// run goes: a method that chooses its steps does not go beyond it, other methods ignore it.
    ///
    /// # Errors
    ///
    /// [`RunError`] if there is no such step. The run stays where it was.
    fn step(&mut self, end: f64) -> Result<StepReport, RunError>;

    /// Writes the current node.
    fn write_node(&self, node: NodeMut<'_>);

    /// Writes the current node with the velocity and the acceleration with which the motion goes on. They differ
    /// from those of [`Run::write_node`] at a node of a [`crate::Flow`] where inputs change.
    fn write_departure(&self, node: NodeMut<'_>) {
        self.write_node(node);
    }

    /// The clock.
    fn clock(&self) -> &Clock;

    /// The clock, mutable.
    fn clock_mut(&mut self) -> &mut Clock;

    /// Makes all steps up to an end. The current node counts as handed out. No node is computed.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a step fails. The current node is then the last one that was reached.
    fn reach(&mut self, end: &End) -> Result<(), RunError> {
        self.clock_mut().hand_out(true);
        while !self.clock().has_reached(end) {
            self.step(end.time())?;
        }
        Ok(())
    }

    /// Moves to the next node that has not been handed out, and hands it out. `false` if the end has been
    /// reached.
    ///
    /// # Errors
    ///
    /// [`RunError`] if the step there fails.
    #[inline]
    fn go_on(&mut self, end: &End) -> Result<bool, RunError> {
        if self.clock().has_reached(end) {
            return Ok(false);
        }
        if self.clock().is_handed_out() {
            self.step(end.time())?;
        } else {
            self.clock_mut().hand_out(true);
        }
        Ok(true)
    }

    /// Reverses the direction of time; see [`crate::Stepper::reverse`].
    ///
    /// # Errors
    ///
    /// [`RunError::NotReversible`] if the method cannot go back; other errors if the step back has no solution here. The run stays as it was.
    fn reverse(&mut self) -> Result<(), RunError> {
        Err(RunError::NotReversible(Box::new(NotReversible {
            method: "this method",
            reason: "it has no step back",
        })))
    }

    /// The certificate of the last step's equations; see [`crate::Stepper::regularity`].
    fn regularity(&self) -> Option<Regularity> {
        None
    }

    /// The steps so far that were too long for a jump in them; see [`crate::Stepper::unresolved`].
    fn unresolved(&self) -> Option<Unresolved> {
        None
    }

    /// The steps so far in which the equations were nearly singular; see [`crate::Stepper::nearly_singular`].
    fn nearly_singular(&self) -> Option<NearlySingular> {
        None
    }

    /// Sets the parameter at a place of the declaration; see [`crate::Inputs::set_input`]. The place and the
    /// value have been checked: it exists, no holonomic constraint depends on it, and the value is finite.
    ///
    /// # Errors
    ///
    /// [`RunError::Input`] if the method takes no inputs, [`RunError::Setup`] if the motion cannot go on with the value. The run stays as it was.
    fn set_value(&mut self, place: usize, value: f64) -> Result<(), RunError> {
        let parameter = self.kernel().shape().parameters.get(place);
        let parameter = parameter.map_or_else(Default::default, |parameter| parameter.name.clone());
        let _ = value;
        Err(RunError::Input(Box::new(InputError::Fixed { parameter })))
    }

    /// Makes one step like [`Run::step`] and hands the motion during the step to a visitor.
    ///
    /// Unless a method implements it otherwise, the motion shown is the polynomial between its nodes ([`AnyPolynomial::between`]), which is made
    /// in `room`.
    ///
    /// # Errors
    ///
    /// The errors of [`Run::step`] and of the visitor.
    fn trace(
        &mut self,
        end: f64,
        room: &mut Workspace,
        visit: &mut AnyVisitor<'_>,
    ) -> Result<StepEnd, RunError> {
        let [before, after] = &mut room.nodes;
        before.fit(self);
        self.write_departure(before.as_node_mut());
        let rested = self.resting();
        self.step(end)?;
        after.take(self);
        let rests = self.resting();
        let declaration = Declaration::of(self.kernel()).with(self.values());
        let rotations = &self.kernel().shape().rotations;
        let differences = self.has_differences();
        let mut polynomial = AnyPolynomial::through(
            rotations,
            differences,
            [&before.any(), &after.any()],
            &mut room.series,
        );
        polynomial.resting = [&rested, &rests];
        Ok(match visit(&declaration, &polynomial)? {
            Some(_) => StepEnd::BeyondStop,
            None => StepEnd::NextNode,
        })
    }

    /// Hands out the motion at some times, which are in the order of the run, none of them before the current
    /// node, if the method has a faster way than [`Run::trace`]. `false` if it has none; then nothing has
    /// happened. If the observer breaks, the run ends at a node soon after.
    ///
    /// # Errors
    ///
    /// The errors of [`Run::step`].
    fn sample_at_once(&mut self, times: &[f64], observer: &mut SampleObserver<'_>) -> Result<bool, RunError> {
        let _ = (times, observer);
        Ok(false)
    }
}

/// The workspace of [`Run::trace`] for polynomials, made once for many steps.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// The nodes before and after a step.
    nodes: [OwnedNode; 2],
    /// The polynomial between them.
    series: Series,
}

impl Workspace {
    /// An empty workspace, which is allocated when it is first needed.
    #[must_use]
    pub fn new() -> Self {
        Self {
            nodes: [OwnedNode::new(0), OwnedNode::new(0)],
            series: Series::new(0, AnyPolynomial::ORDER),
        }
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Node<N> {
    /// The current node of a run.
    #[inline]
    pub(crate) fn of<R: Run + ?Sized>(run: &R) -> Self {
        Self::written_by(|node| run.write_node(node))
    }
}

impl OwnedNode {
    /// Takes the current node of a run. Nothing is allocated if the number of coordinates agrees.
    pub fn take<R: Run + ?Sized>(&mut self, run: &R) {
        self.fit(run);
        run.write_node(self.as_node_mut());
    }

    /// Allocates for the nodes of a run.
    fn fit<R: Run + ?Sized>(&mut self, run: &R) {
        let coordinates = run.kernel().shape().dimension();
        if coordinates != self.coordinates {
            *self = Self::new(coordinates);
        }
    }
}
