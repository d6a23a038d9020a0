//! A run with its number of coordinates at compile time.

use core::ops::ControlFlow;

use super::{
    AnyObserver, AnyOccurrence, AnyPolynomial, Clock, Events, Failure, Node, Observer, Occurrence,
    Polynomial, Run, RunError, StepEnd, Trajectory, Workspace,
};
use crate::kernel::report::StepReport;
use crate::number::point::Point;
use crate::regularity::Regularity;
use crate::run::{NearlySingular, Unresolved};
use crate::tape::declaration::Declaration;

/// Receives the motion of a step, polynomial by polynomial. It may return a time at which the method is to stop, counted from the
/// point of expansion of the polynomial.
pub type Visitor<'v, const N: usize> = dyn FnMut(&Polynomial<'_, N>) -> Result<Option<f64>, RunError> + 'v;

/// A run in progress, by any method: [`crate::Flow`], [`crate::ComposedFlow`], [`crate::TaylorFlow`].
///
/// A run has a current node; at first it is the start, which has the number 0. Every function of this trait continues from the
/// current node. Each node is handed out once: to the iterator (a run is an endless iterator of nodes, which ends after an error), to a
/// trajectory ([`Stepper::until`]), or to an observer ([`Stepper::stream`], [`Stepper::watch`]). [`Stepper::advance`] and [`Stepper::to`] pass nodes
/// without computing their velocities, forces and energies.
///
/// The trait is object safe: a function that takes a `&mut dyn Stepper<N>` works with every method.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::{Composition, RunError};
///
/// /// A pendulum.
/// #[dsocs {
///     coordinates(theta);
///     lagrangian = dot(theta).powi(2) / 2 + gravity / length * theta.cos();
/// }]
/// struct Pendulum {
///     length: f64,
///     gravity: f64,
/// }
///
/// /// When it first hangs straight down.
/// fn quarter(run: &mut dyn Stepper<1>) -> Result<f64, RunError> {
///     let mut events = Events::new(vec![Event::function(|point| point.q[0]).terminal()]);
///     let event = run.watch(10.0, &mut events, &mut |_: &Node<1>| {})?;
///     Ok(event.map_or(f64::NAN, |event| event.t))
/// }
///
/// let pendulum = Pendulum { length: 1.0, gravity: 9.81 };
/// let start = Start::second_order([1.0], [0.0]);
/// let step = quarter(&mut Flow::new(&pendulum, 0.01, start)?)?;
/// let composed = quarter(&mut ComposedFlow::new(&pendulum, 0.01, Composition::KAHAN_LI_6, start)?)?;
/// let series = quarter(&mut TaylorFlow::new(&pendulum, start, Tolerance::relative(1e-14))?)?;
/// let exact = 0.534_784_400_139_672;
/// assert!((step - exact).abs() < 1e-4 && (composed - exact).abs() < 1e-11 && (series - exact).abs() < 1e-12);
/// # Ok::<(), RunError>(())
/// ```
///
/// # A new method
///
/// A new method implements [`Run`] and shows itself by [`Stepper::run`] and [`Stepper::run_mut`], and [`Iterator`] by [`Stepper::next_node`].
/// The other functions are provided.
pub trait Stepper<const N: usize>: Iterator<Item = Result<Node<N>, RunError>> {
    /// The run without its number of coordinates.
    fn run(&self) -> &dyn Run;

    /// The run without its number of coordinates, mutable.
    fn run_mut(&mut self) -> &mut dyn Run;

    /// Makes one step and advances the clock. No node is computed, and nothing is allocated. `end` is the time towards which the
    /// run goes: a method that chooses its steps does not go beyond it, other methods ignore it.
    ///
    /// # Errors
    ///
    /// [`RunError`] if there is no such step. The run stays where it was.
    #[inline]
    fn step(&mut self, end: f64) -> Result<StepReport, RunError> {
        self.run_mut().step(end)
    }

    /// The current node.
    #[inline]
    fn node(&self) -> Node<N> {
        Node::of(self.run())
    }

    /// The clock.
    #[inline]
    fn clock(&self) -> &Clock {
        self.run().clock()
    }

    /// The clock, mutable.
    #[inline]
    fn clock_mut(&mut self) -> &mut Clock {
        self.run_mut().clock_mut()
    }

    /// Reverses the direction of time. The run goes back from the current node, which becomes number 0 and is not handed out again.
    ///
    /// The run back is the same method with the step `-h`. It retraces the nodes to rounding only if the step is symmetric in
    /// time: the step of a [`crate::Flow`] with the default maps and a constant mass matrix, and compositions of it. Otherwise
    /// (`phi_lagrangian` of first order, a mass matrix that depends on the position) the run back is another motion, which differs by the
    /// discretization error. A [`crate::TaylorFlow`] retraces its motion to its tolerance. A damped motion grows on the way back, and
    /// rounding errors grow with it.
    ///
    /// # Errors
    ///
    /// [`RunError::NotReversible`] if the method cannot go back; other errors if the step back has no solution here. The run stays as it was.
    fn reverse(&mut self) -> Result<(), RunError> {
        self.run_mut().reverse()
    }

    /// The certificate of the last step's equations, if the method solves equations. For a [`crate::Flow`]
    /// these are the equations of the triple about the current node. `None` before the first step.
    fn regularity(&self) -> Option<Regularity> {
        self.run().regularity()
    }

    /// The steps of a [`crate::Flow`] or a [`crate::ComposedFlow`] so far that were too long for a jump in
    /// them. `None` if there were none, and for all other methods.
    fn unresolved(&self) -> Option<Unresolved> {
        self.run().unresolved()
    }

    /// The steps of a [`crate::Flow`] so far in which the equations were nearly singular, or the stages of a composed one. `None` if there were
    /// none, and for all other methods.
    fn nearly_singular(&self) -> Option<NearlySingular> {
        self.run().nearly_singular()
    }

    /// Makes one step like [`Stepper::step`] and hands the motion during the step to a visitor.
    ///
    /// Unless a method knows it better, the motion shown is the polynomial between its nodes ([`Polynomial::between`]).
    ///
    /// # Errors
    ///
    /// The errors of [`Stepper::step`] and of the visitor.
    fn trace(&mut self, end: f64, visit: &mut Visitor<'_, N>) -> Result<StepEnd, RunError> {
        let mut visit =
            |_: &Declaration<'_>, polynomial: &AnyPolynomial<'_>| visit(&Polynomial::of(*polynomial));
        self.run_mut().trace(end, &mut Workspace::new(), &mut visit)
    }

    /// Makes exactly one step. [`Stepper::node`] then gives the node at its end, which counts as handed out.
    ///
    /// # Errors
    ///
    /// [`RunError`] if there is no step. The run stays where it was.
    #[inline]
    fn advance(&mut self) -> Result<StepReport, RunError> {
        self.run_mut().step(f64::INFINITY)
    }

    /// The next node of the iterator; `None` after an error.
    fn next_node(&mut self) -> Option<Result<Node<N>, RunError>> {
        let run = self.run_mut();
        if run.clock().has_ended() {
            return None;
        }
        if !run.clock().is_handed_out() {
            run.clock_mut().hand_out(true);
        } else if let Err(error) = run.step(f64::INFINITY) {
            run.clock_mut().end();
            return Some(Err(error));
        }
        Some(Ok(Node::of(run)))
    }

    /// Runs up to the last node at or before `t` (back in time: at or after `t`), and collects all nodes that were not handed out
    /// before.
    ///
    /// A node whose time is `t` to within rounding counts as at `t`: 500 with the step 0.1 gives node 5000. A method that chooses
    /// its steps has its last node at `t`.
    ///
    /// # Errors
    ///
    /// [`Failure`] with the nodes so far if a step fails, or if `t` lies behind, is infinite or is not a number.
    fn until(&mut self, t: f64) -> Result<Trajectory<N>, Failure<N>> {
        let mut trajectory = Trajectory {
            nodes: Vec::new(),
            rotations: self.run().kernel().shape().rotations.to_vec(),
            differences: self.run().has_differences(),
        };
        let ended = self.run_mut().walk_to(t, &mut |run| {
            trajectory.nodes.push(Node::of(run));
            Ok(ControlFlow::Continue(()))
        });
        match ended {
            Ok(()) => Ok(trajectory),
            Err(error) => Err(Failure { error, trajectory }),
        }
    }

    /// Runs like [`Stepper::until`] and returns only the last node; no [`Node`] is made for the steps before it.
    ///
    /// # Errors
    ///
    /// The errors of [`Stepper::until`], as a [`RunError`] without nodes. The current node is then the last one that was reached.
    fn to(&mut self, t: f64) -> Result<Node<N>, RunError> {
        self.run_mut().to(t)?;
        Ok(self.node())
    }

    /// Runs like [`Stepper::until`], but hands each node to an observer and keeps none. An infinite `t` is allowed; then the
    /// observer has to end the run.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a step fails, or if `t` lies behind or is not a number.
    fn stream(&mut self, t: f64, observer: &mut dyn Observer<N>) -> Result<(), RunError> {
        self.run_mut()
            .walk(t, &mut |run| Ok(observer.node(&Node::of(run))))
    }

    /// Runs like [`Stepper::stream`] and hands each node on with the regularity of its step ([`Stepper::regularity`]); the
    /// node of the start has none.
    ///
    /// # Errors
    ///
    /// The errors of [`Stepper::stream`].
    fn certify(
        &mut self,
        t: f64,
        observer: &mut dyn FnMut(&Node<N>, Option<Regularity>) -> ControlFlow<()>,
    ) -> Result<(), RunError> {
        self.run_mut()
            .walk(t, &mut |run| Ok(observer(&Node::of(run), run.regularity())))
    }

    /// Runs like [`Stepper::stream`], and hands nodes and events to the observer, in order. The run ends early at the first terminal
    /// event, which is then returned.
    ///
    /// An event is a change of sign of a function. A zero without a change of sign is not an event, and neither is a zero at
    /// the start. Every change within a step is found, even if a function changes its sign several times. The search uses the
    /// [`Polynomial`] of the step, whose documentation says how exact it is. On this polynomial the zero is exact to rounding.
    ///
    /// A function that is zero as long as a body rests, as the slip of a friction is, has no events there, and keeps the sign that it had before.
    /// By steps of a fixed length the slip is smaller than their error for a step or two after a release, and may change its sign more than
    /// once there.
    ///
    /// After a terminal event, the current node of a run by Taylor series is at the event. For the discrete methods it is the node after
    /// the event. When the run goes on, this node is handed out, and so are the events between the terminal one and this node.
    /// Events at the same time as the terminal one are reported before it.
    ///
    /// A run may be watched in parts, with the same [`Events`] or with new ones that continue them
    /// ([`Events::after`]): an event at the node between two parts is then found once.
    ///
    /// # Errors
    ///
    /// The errors of [`Stepper::stream`], and [`RunError::Event`] if a function has no Taylor series.
    fn watch(
        &mut self,
        t: f64,
        events: &mut Events<'_, N>,
        observer: &mut dyn Observer<N>,
    ) -> Result<Option<Occurrence<N>>, RunError> {
        let found = self
            .run_mut()
            .watch(t, &mut events.any, &mut SizedObserver(observer))?;
        Ok(found.map(|found| Occurrence::of(&found)))
    }

    /// Runs to the last of the given times and hands out the motion at each of them. The times have to be in the order of the run,
    /// none of them before the current node. Between nodes the motion is the [`Polynomial`] of the step; at a node it is the node. So where an
    /// input changes it is the motion that arrives, and where a declared function jumps the acceleration is that of the declaration at the
    /// point. The forces at a point are those of [`crate::System::constraint_force`] and [`crate::System::external_forces`].
    ///
    /// # Errors
    ///
    /// The errors of [`Stepper::stream`].
    fn sample(
        &mut self,
        times: &[f64],
        observer: &mut dyn FnMut(f64, &Point<f64, N>),
    ) -> Result<(), RunError> {
        self.run_mut().sample_together(times, &mut |times, numbers| {
            let points = numbers.as_chunks().0.as_chunks().0;
            for (&t, &[q, v, a]) in times.iter().zip(points) {
                observer(t, &Point { t, q, v, a });
            }
            ControlFlow::Continue(())
        })
    }

    /// Writes the observed expressions of the declaration at a node to `out`, in the order of [`crate::System::OBSERVABLES`], as many as
    /// `out` has room for.
    fn observe(&self, node: &Node<N>, out: &mut [f64]) {
        self.run().observe(node.point().any(), out);
    }

    /// The multipliers of a node's constraint force, by the forms of its constraints.
    fn multipliers(&self, node: &Node<N>) -> Vec<f64> {
        self.run().multipliers(&node.any())
    }
}

/// An observer that receives nodes and events with their number of coordinates.
struct SizedObserver<'o, const N: usize>(&'o mut dyn Observer<N>);

impl<const N: usize> AnyObserver for SizedObserver<'_, N> {
    fn node(&mut self, run: &dyn Run) -> ControlFlow<()> {
        self.0.node(&Node::of(run))
    }

    fn event(&mut self, occurrence: &AnyOccurrence) -> ControlFlow<()> {
        self.0.event(&Occurrence::of(occurrence))
    }
}
