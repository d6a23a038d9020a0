//! Observers, which receive the nodes of a run.

use core::ops::ControlFlow;

use super::{AnyOccurrence, Node, Occurrence, Run, Trajectory};

/// Receives the nodes of a run one by one, in bounded memory, and the events if some are watched.
///
/// Every closure `FnMut(&Node<N>)` is an observer, which returns nothing or whether to go on. So are a
/// [`Trajectory`], which collects the nodes, [`on_event`] and pairs of observers.
///
/// ```
/// use std::ops::ControlFlow;
/// use dsocs_core::{Node, Observer, Trajectory};
///
/// let mut count = 0;
/// let mut counting = |_: &Node<1>| count += 1;
/// let mut falling = |node: &Node<1>| {
///     if node.q[0] < 0.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
/// };
/// let observers: [&mut dyn Observer<1>; 3] = [&mut counting, &mut falling, &mut Trajectory::default()];
/// ```
pub trait Observer<const N: usize> {
    /// Takes a node; [`ControlFlow::Break`] ends the run after it.
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()>;

    /// Takes an event, between the node before and the node after it; [`ControlFlow::Break`] ends the run there, as a
    /// terminal event does. By default events are ignored.
    fn event(&mut self, occurrence: &Occurrence<N>) -> ControlFlow<()> {
        let _ = occurrence;
        ControlFlow::Continue(())
    }
}

/// Receives the nodes and the events of a run with any number of coordinates. It reads nodes from the run
/// itself ([`Run::write_node`]), so that unused ones are not computed.
pub trait AnyObserver {
    /// Called at a node; [`ControlFlow::Break`] ends the run there.
    fn node(&mut self, run: &dyn Run) -> ControlFlow<()>;

    /// Takes an event, between the node before and the node after it; [`ControlFlow::Break`] ends the run there, as a
    /// terminal event does.
    fn event(&mut self, occurrence: &AnyOccurrence) -> ControlFlow<()>;
}

/// The return value of a closure that observes: nothing, or whether to continue.
pub trait ObserverResult {
    /// Whether to continue.
    fn into_control_flow(self) -> ControlFlow<()>;
}

impl ObserverResult for () {
    #[inline]
    fn into_control_flow(self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl ObserverResult for ControlFlow<()> {
    #[inline]
    fn into_control_flow(self) -> ControlFlow<()> {
        self
    }
}

impl<F: FnMut(&Node<N>) -> R, R: ObserverResult, const N: usize> Observer<N> for F {
    #[inline]
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()> {
        self(node).into_control_flow()
    }
}

impl<const N: usize> Observer<N> for Trajectory<N> {
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()> {
        self.nodes.push(*node);
        ControlFlow::Continue(())
    }
}

/// Both observers receive everything, and either of them can end the run.
impl<A: Observer<N>, B: Observer<N>, const N: usize> Observer<N> for (A, B) {
    fn node(&mut self, node: &Node<N>) -> ControlFlow<()> {
        either(self.0.node(node), self.1.node(node))
    }

    fn event(&mut self, occurrence: &Occurrence<N>) -> ControlFlow<()> {
        either(self.0.event(occurrence), self.1.event(occurrence))
    }
}

/// Breaks if either does.
fn either(left: ControlFlow<()>, right: ControlFlow<()>) -> ControlFlow<()> {
    if left.is_break() { left } else { right }
}

/// An observer of events alone, from a closure that returns nothing or says whether to go on.
///
/// ```
/// use dsocs_core::{Occurrence, on_event};
///
/// let mut times = Vec::new();
/// let mut observer = on_event(|event: &Occurrence<2>| times.push(event.t));
/// # let _: &mut dyn dsocs_core::Observer<2> = &mut observer;
/// ```
pub fn on_event<const N: usize, R: ObserverResult, F: FnMut(&Occurrence<N>) -> R>(closure: F) -> OnEvent<F> {
    OnEvent(closure)
}

/// The observer that [`on_event`] makes.
#[derive(Clone, Copy, Debug)]
pub struct OnEvent<F>(F);

impl<F: FnMut(&Occurrence<N>) -> R, R: ObserverResult, const N: usize> Observer<N> for OnEvent<F> {
    fn node(&mut self, _: &Node<N>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn event(&mut self, occurrence: &Occurrence<N>) -> ControlFlow<()> {
        (self.0)(occurrence).into_control_flow()
    }
}
