//! Many trajectories of one system, in SIMD lanes and on several threads.

use core::fmt;
use core::num::NonZeroU64;
use core::ops::ControlFlow;

use crate::error::SetupError;
use crate::number::instructions::Instructions;
use crate::run::{AnyNode, Failure, InputError, Node, Observer, RunError, Trajectory, inputs};
use crate::start::Start;
use crate::system::System;
use crate::tape::Shape;

mod any;
mod block;
mod determinants;
mod engine;
mod held;
mod interpreted;
#[cfg(test)]
mod interpreted_tests;
mod lane_registers;
mod lane_state;
mod newton;
#[cfg(test)]
mod tests;

pub use any::{AnyEnsemble, AnyObservedRun};
use block::BlockObserver;
use engine::CompiledLanes;

/// Many trajectories of one system with one step `h`, each from its own start.
///
/// The trajectories are divided into blocks of eight. The steps of a block are computed together, one trajectory in each SIMD lane. The
/// generated code is the same as for a [`Flow`](crate::Flow), and so are Newton's iteration, the predictor and the stop rules, which are applied to each
/// lane. A step is solved as in a single [`Flow`](crate::Flow), with all guesses and with damping, if its iteration does not contract at once (for
/// example at a switch), or if its root may not be the one that continues the motion. A trajectory without a solution ends with its own
/// error, and the others go on. The blocks are distributed over the threads.
///
/// - Results come in the order of the starts.
/// - A result does not depend on the number of threads or on the other trajectories: it is the same bit for bit.
/// - A result agrees bit for bit with that of a [`Flow`](crate::Flow) if the system uses no functions but roots and powers. Otherwise
///   it agrees to rounding, because the vector code of some functions rounds differently.
///
/// ```
/// use dsocs_core::{Ensemble, Start, dsocs};
///
/// /// A particle in the plane whose path has a prescribed signed curvature.
/// #[dsocs {
///     coordinates(x, y);
///     lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
///     let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
///     kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
///     variational = [(dot(x), dot(y))];
/// }]
/// struct Particle {
///     mass: f64,
///     curvature: f64,
/// }
///
/// let particle = Particle { mass: 1.0, curvature: 0.5 };
/// let starts = (1..=100).map(|k| Start::second_order([0.0, 0.0], [0.01 * f64::from(k), 0.0]));
/// let finals = Ensemble::new(&particle, 0.01)?.starts(starts).to(10.0);
/// let node = finals[99].as_ref().expect("a particle that moves");
/// assert!((node.q[1] - (2.0 - 2.0 * 5.0_f64.cos())).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Speed
///
/// The steps are compiled for several instruction sets: AVX-512 (eight numbers in a register), AVX2 (four), and that for which the program
/// was compiled (by default on x86-64 SSE2, two). The program chooses the widest that the machine has when it runs. The results are the same
/// bit for bit with each of them, because no product is fused with a sum. The book's chapter on performance has the measured gains.
///
/// Parameters that vary ([`Ensemble::varied`]) lie in lanes like the nodes, and have no additional cost.
#[must_use]
pub struct Ensemble<'a, const N: usize>(AnyEnsemble<'a>);

// prints the fields of `AnyEnsemble` under this name
impl<const N: usize> fmt::Debug for Ensemble<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.write(f, "Ensemble")
    }
}

/// The index of a parameter and its values, one for each start.
pub(crate) fn one_each(
    shape: &Shape,
    parameter: &str,
    values: Vec<f64>,
    starts: usize,
) -> Result<(usize, Vec<f64>), RunError> {
    let refused = |error| RunError::Input(Box::new(error));
    let place = inputs::known(shape, parameter).map_err(refused)?;
    check_count(shape, place, values.len(), starts)?;
    Ok((place, values))
}

/// Checks that the number of values or plans equals the number of starts.
fn check_count(shape: &Shape, place: usize, values: usize, starts: usize) -> Result<(), RunError> {
    if values == starts {
        return Ok(());
    }
    Err(RunError::Input(Box::new(InputError::Count {
        parameter: shape.parameters[place].name.clone(),
        values,
        starts,
    })))
}

/// One observed trajectory of an ensemble.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedRun<O, const N: usize> {
    /// The observer after the run, also if the trajectory failed.
    pub observer: O,
    /// The last node, or the error that ended the trajectory.
    pub last: Result<Node<N>, RunError>,
}

impl<'a, const N: usize> Ensemble<'a, N> {
    /// An ensemble without trajectories, for the step `h` (negative to run back in time).
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the step or a parameter of the system is not usable.
    pub fn new<S: System<N>>(system: &'a S, h: f64) -> Result<Self, SetupError> {
        AnyEnsemble::with(system.kernel(), Box::new(CompiledLanes(system)), h).map(Self)
    }

    /// The ensemble without its number of coordinates.
    pub fn into_any(self) -> AnyEnsemble<'a> {
        self.0
    }

    /// Adds trajectories, one for each start.
    pub fn starts(mut self, starts: impl IntoIterator<Item = Start<N>>) -> Self {
        self.0
            .starts
            .extend(starts.into_iter().map(|start| start.given()));
        self
    }

    /// Varies a parameter from trajectory to trajectory: one value for each start added before, in their
    /// order. Several parameters may vary.
    ///
    /// ```
    /// use dsocs_core::prelude::*;
    ///
    /// /// A mass on a spring.
    /// #[dsocs {
    ///     coordinates(x);
    ///     lagrangian = dot(x).powi(2) / 2 - stiffness * x.powi(2) / 2;
    /// }]
    /// #[derive(Clone)]
    /// struct Oscillator {
    ///     stiffness: f64,
    /// }
    ///
    /// let oscillator = Oscillator { stiffness: 1.0 };
    /// let values: Vec<f64> = (1..=20).map(f64::from).collect();
    /// let ensemble = Ensemble::new(&oscillator, 0.001)?
    ///     .starts(values.iter().map(|_| Start::second_order([1.0], [0.0])))
    ///     .varied("stiffness", values.iter().copied())?;
    /// for (k, end) in values.iter().zip(ensemble.to(1.0)) {
    ///     assert!((end?.q[0] - k.sqrt().cos()).abs() < 1e-5);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`RunError::Input`] if there is no such parameter, or if there are not as many values as starts. A
    /// value that a run cannot begin with fails only its own trajectory.
    pub fn varied(self, parameter: &str, values: impl IntoIterator<Item = f64>) -> Result<Self, RunError> {
        self.0.varied(parameter, values).map(Self)
    }

    /// Changes the values of a parameter during the run. Each trajectory has its own plan, in the order of
    /// the starts added before. A plan lists times that increase, each with the value that holds from then
    /// on. Before the first time, the parameter has its value in the system. Several parameters may be held.
    ///
    /// Values change at nodes, with the effect that [`Inputs`](crate::Inputs) describes: a value holds from
    /// the first position at or after its time. The step around a change is solved in a single flow, and the
    /// others in lanes, so that rare changes cost little.
    ///
    /// ```
    /// use dsocs_core::prelude::*;
    ///
    /// /// A mass that a force pushes.
    /// #[dsocs {
    ///     coordinates(x);
    ///     lagrangian = dot(x).powi(2) / 2;
    ///     external_forces = push;
    /// }]
    /// #[derive(Clone)]
    /// struct Mass {
    ///     push: f64,
    /// }
    ///
    /// let mass = Mass { push: 0.0 };
    /// // pushed for a second, and braked for another
    /// let plans = (1..=20).map(|k| vec![[0.0, f64::from(k)], [1.0, -f64::from(k)]]);
    /// let ends = Ensemble::new(&mass, 0.01)?
    ///     .starts((1..=20).map(|_| Start::second_order([0.0], [0.0])))
    ///     .held("push", plans)?
    ///     .to(2.0);
    /// for (k, end) in (1..=20).map(f64::from).zip(ends) {
    ///     let end = end?;
    ///     assert!((end.q[0] - k).abs() < 1e-9 && end.v[0].abs() < 0.01 * k);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`RunError::Input`] if there is no such parameter, if it stands in a holonomic constraint or inside a
    /// `dot(…)`, or if there are not as many plans as starts. A value that is not finite, or with which the
    /// motion cannot continue, fails only its own trajectory.
    pub fn held(
        self,
        parameter: &str,
        plans: impl IntoIterator<Item = Vec<[f64; 2]>>,
    ) -> Result<Self, RunError> {
        self.0.held(parameter, plans).map(Self)
    }

    /// Sets the maximum number of Newton iterations from one guess; see
    /// [`Flow::max_iterations`](crate::Flow::max_iterations).
    pub fn max_iterations(self, limit: u32) -> Self {
        Self(self.0.max_iterations(limit))
    }

    /// Sets the widest instructions that may be used, for example to compare them. By default these are the widest that the machine has.
    /// The results do not depend on them.
    pub fn instructions(self, widest: Instructions) -> Self {
        Self(self.0.instructions(widest))
    }

    /// Sets a function that observes the progress. After each block, it is called with the number of
    /// trajectories that have ended so far, failed ones included. Several threads may call it at the same
    /// time, so the numbers may arrive out of order.
    pub fn progress(self, progress: &'a (dyn Fn(usize) + Sync)) -> Self {
        Self(self.0.progress(progress))
    }

    /// Runs all trajectories in the calling thread, one block after the other.
    pub fn here(self) -> Self {
        Self(self.0.here())
    }

    /// Uses a thread pool of its own with this number of threads (0: as many as there are cores). By default the ensemble uses
    /// rayon's global pool.
    ///
    /// # Errors
    ///
    /// [`rayon::ThreadPoolBuildError`] if the threads cannot be started.
    #[cfg(feature = "rayon")]
    pub fn threads(self, threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        self.0.threads(threads).map(Self)
    }

    /// Runs every trajectory up to the last node at or before `t`, as [`crate::Stepper::to`] does, and returns that node for
    /// each, in the order of the starts.
    ///
    /// For a trajectory that does not begin or does not reach `t`, the result is its [`RunError`]; a step error contains the last nodes.
    #[must_use]
    pub fn to(&self, t: f64) -> Vec<Result<Node<N>, RunError>> {
        let runs = self.runs(t, None, |_| Trajectory::default());
        runs.into_iter().map(|run| run.last).collect()
    }

    /// Runs every trajectory up to the last node at or before `t` and collects all nodes, as [`crate::Stepper::until`] does. For a
    /// trajectory that fails, the [`Failure`] contains the nodes so far.
    #[must_use]
    pub fn until(&self, t: f64) -> Vec<Result<Trajectory<N>, Failure<N>>> {
        let every = if t.is_infinite() {
            None
        } else {
            Some(NonZeroU64::MIN)
        };
        let runs = self.runs(t, every, |_| Trajectory::default());
        let collected = |ObservedRun { observer, last }| match last {
            Ok(_) => Ok(observer),
            Err(error) => Err(Failure {
                error,
                trajectory: observer,
            }),
        };
        runs.into_iter().map(collected).collect()
    }

    /// Runs like [`Ensemble::to`], and passes the nodes whose index is a multiple of `every` to observers, as
    /// [`crate::Stepper::stream`] does.
    ///
    /// The function `observer` makes an observer for each trajectory, from the index of its start. An
    /// observer that breaks off ends its own trajectory; the last node is then the last that it received. An
    /// infinite `t` is allowed if all observers break off.
    #[must_use]
    pub fn stream<O: Observer<N> + Send>(
        &self,
        t: f64,
        every: NonZeroU64,
        observer: impl Fn(usize) -> O + Sync,
    ) -> Vec<ObservedRun<O, N>> {
        self.runs(t, Some(every), observer)
    }

    /// Runs all blocks.
    fn runs<O: Observer<N> + Send>(
        &self,
        t: f64,
        every: Option<NonZeroU64>,
        observer: impl Fn(usize) -> O + Sync,
    ) -> Vec<ObservedRun<O, N>> {
        self.0.runs(t, every, &|first, starts, block| {
            let mut observers = Observers {
                observers: (0..starts).map(|lane| observer(first + lane)).collect(),
                ends: (0..starts).map(|_| None).collect(),
            };
            block(&mut observers);
            observers.observed()
        })
    }
}

/// Observers and final results of the trajectories of a block.
struct Observers<O, const N: usize> {
    /// The observers, one for each trajectory.
    observers: Vec<O>,
    /// The last node of each trajectory, or the error that ended it; `None` before its end.
    ends: Vec<Option<Result<Node<N>, RunError>>>,
}

impl<O, const N: usize> Observers<O, N> {
    /// The observed trajectories. Every trajectory of a block ends.
    fn observed(self) -> Vec<ObservedRun<O, N>> {
        let both = self.observers.into_iter().zip(self.ends);
        both.filter_map(|(observer, last)| last.map(|last| ObservedRun { observer, last }))
            .collect()
    }
}

impl<O: Observer<N>, const N: usize> BlockObserver for Observers<O, N> {
    fn node(&mut self, place: usize, node: &AnyNode<'_>) -> ControlFlow<()> {
        match self.observers.get_mut(place) {
            Some(observer) => observer.node(&node.sized()),
            None => ControlFlow::Continue(()),
        }
    }

    fn end(&mut self, place: usize, last: Result<&AnyNode<'_>, RunError>) {
        if let Some(end) = self.ends.get_mut(place) {
            *end = Some(last.map(AnyNode::sized));
        }
    }
}
