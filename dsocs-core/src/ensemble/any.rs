//! Many trajectories of a system without its type.

use core::fmt;
use core::num::NonZeroU64;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicUsize, Ordering};

use super::block::{BlockObserver, EnsembleRun};
use super::engine::{LaneKernel, ScalarSteps};
use super::held::HeldInputs;
use super::interpreted::InterpretedLanes;
use super::{check_count, one_each};
use crate::error::SetupError;
use crate::flow::discrete::check;
use crate::kernel::Kernel;
use crate::kernel::run_state::MAX_ITERATIONS;
use crate::number::instructions::Instructions;
use crate::number::lanes::LANES;
use crate::run::{AnyNode, OwnedNode, RunError, inputs};
use crate::start::{AnyStart, StartData};
use crate::step::TapeKernel;
use crate::tape::declaration::Declaration;
use crate::threads::Threads;

/// An [`Ensemble`](crate::Ensemble) with any number of coordinates, of a system without its type.
///
/// ```
/// # #[cfg(feature = "text")] {
/// use dsocs_core::text::Text;
/// use dsocs_core::{AnyEnsemble, AnyStart};
///
/// let text = Text::parse(
///     "spring",
///     "parameters { stiffness = 1.0 }
///      coordinates(x);
///      lagrangian = dot(x).powi(2) / 2 - stiffness * x.powi(2) / 2;",
/// )?;
/// let values: Vec<f64> = (1..=20).map(f64::from).collect();
/// let ensemble = AnyEnsemble::of_tape(&text.system, 0.001)?
///     .starts(values.iter().map(|_| AnyStart::second_order(&[1.0], &[0.0])))
///     .varied("stiffness", values.iter().copied())?;
/// for (k, end) in values.iter().zip(ensemble.to(1.0)) {
///     assert!((end?.any().q[0] - k.sqrt().cos()).abs() < 1e-5);
/// }
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub struct AnyEnsemble<'a> {
    /// The system.
    kernel: &'a dyn Kernel,
    /// Its steps in lanes.
    lanes: Box<dyn LaneKernel + 'a>,
    /// The step.
    h: f64,
    /// The starts.
    pub(super) starts: Vec<StartData>,
    /// The parameters that vary, by their places, each with a value for every start.
    varied: Vec<(usize, Vec<f64>)>,
    /// The parameters that change during the runs.
    held: Vec<HeldInputs>,
    /// Largest number of evaluations of a step's rows from one guess.
    max_iterations: u32,
    /// The widest instructions that may be used.
    instructions: Instructions,
    /// A function that receives the number of trajectories that have ended.
    progress: Option<&'a (dyn Fn(usize) + Sync)>,
    /// The threads.
    threads: Threads,
}

// by hand, because the derived one would require Debug of the closure
impl fmt::Debug for AnyEnsemble<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, "AnyEnsemble")
    }
}

/// Runs a block for an observer.
pub(super) type RunsBlock<'a> = dyn Fn(&mut dyn BlockObserver) + 'a;

/// One observed trajectory of an [`AnyEnsemble`].
#[derive(Clone, Debug, PartialEq)]
pub struct AnyObservedRun<O> {
    /// The observer after the run, also if the trajectory failed.
    pub observer: O,
    /// The last node, or the error with which the trajectory ended early.
    pub last: Result<OwnedNode, RunError>,
}

impl<'a> AnyEnsemble<'a> {
    /// An ensemble without trajectories, for the step `h` (negative to run back in time). Each trajectory
    /// makes its own steps, so a result agrees bit for bit with that of a flow.
    /// [`Ensemble::new`](crate::Ensemble::new) takes a declared type, and [`AnyEnsemble::of_tape`] a system
    /// that was read from a text; their steps are made in lanes.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the step or a parameter of the system is not usable, or if a constraint is of third order.
    pub fn new(kernel: &'a dyn Kernel, h: f64) -> Result<Self, SetupError> {
        Self::with(kernel, Box::new(ScalarSteps), h)
    }

    /// An ensemble of a system that was not compiled. Its steps are made in lanes, with the bits of the
    /// compiled system in lanes.
    ///
    /// # Errors
    ///
    /// The errors of [`AnyEnsemble::new`].
    pub fn of_tape(kernel: &'a TapeKernel, h: f64) -> Result<Self, SetupError> {
        Self::with(kernel, Box::new(InterpretedLanes(kernel)), h)
    }

    /// An ensemble with the given steps in lanes.
    pub(super) fn with(
        kernel: &'a dyn Kernel,
        lanes: Box<dyn LaneKernel + 'a>,
        h: f64,
    ) -> Result<Self, SetupError> {
        if kernel.shape().is_of_third_order() {
            return Err(SetupError::ThirdOrder {
                method: "an ensemble (Ensemble)",
            });
        }
        check(&Declaration::of(kernel), h)?;
        Ok(Self {
            kernel,
            lanes,
            h,
            starts: Vec::new(),
            varied: Vec::new(),
            held: Vec::new(),
            max_iterations: MAX_ITERATIONS,
            instructions: Instructions::best(),
            progress: None,
            threads: Threads::default(),
        })
    }

    /// Adds trajectories, one for each start. A start with another number of coordinates is the error of its
    /// own trajectory.
    pub fn starts(mut self, starts: impl IntoIterator<Item = AnyStart>) -> Self {
        let shape = self.kernel.shape();
        self.starts
            .extend(starts.into_iter().map(|start| start.widened(shape)));
        self
    }

    /// Sets a parameter to a different value on each trajectory; see
    /// [`Ensemble::varied`](crate::Ensemble::varied).
    ///
    /// # Errors
    ///
    /// The errors of [`Ensemble::varied`](crate::Ensemble::varied).
    pub fn varied(
        mut self,
        parameter: &str,
        values: impl IntoIterator<Item = f64>,
    ) -> Result<Self, RunError> {
        let values = values.into_iter().collect();
        let values = one_each(self.kernel.shape(), parameter, values, self.starts.len())?;
        self.varied.push(values);
        Ok(self)
    }

    /// Holds a parameter at values that change during the run; see [`Ensemble::held`](crate::Ensemble::held).
    ///
    /// # Errors
    ///
    /// The errors of [`Ensemble::held`](crate::Ensemble::held).
    pub fn held(
        mut self,
        parameter: &str,
        plans: impl IntoIterator<Item = Vec<[f64; 2]>>,
    ) -> Result<Self, RunError> {
        let shape = self.kernel.shape();
        let place = inputs::place(shape, parameter, 0.0)?;
        let plans: Vec<Vec<[f64; 2]>> = plans.into_iter().collect();
        check_count(shape, place, plans.len(), self.starts.len())?;
        self.held.push(HeldInputs { place, plans });
        Ok(self)
    }

    /// Sets the largest number of evaluations of a step's rows from one guess; see
    /// [`Flow::max_iterations`](crate::Flow::max_iterations).
    pub fn max_iterations(mut self, limit: u32) -> Self {
        self.max_iterations = limit.max(1);
        self
    }

    /// Sets the widest instructions that may be used; see [`Ensemble::instructions`](crate::Ensemble::instructions). A system that was not compiled
    /// uses AVX2 at most.
    pub fn instructions(mut self, widest: Instructions) -> Self {
        self.instructions = widest;
        self
    }

    /// Sets a function that observes the progress; see [`Ensemble::progress`](crate::Ensemble::progress).
    pub fn progress(mut self, progress: &'a (dyn Fn(usize) + Sync)) -> Self {
        self.progress = Some(progress);
        self
    }

    /// Runs all trajectories in the calling thread, one block after the other.
    pub fn here(mut self) -> Self {
        self.threads = Threads::here();
        self
    }

    /// Uses a thread pool of its own; see [`Ensemble::threads`](crate::Ensemble::threads).
    ///
    /// # Errors
    ///
    /// [`rayon::ThreadPoolBuildError`] if the threads cannot be started.
    #[cfg(feature = "rayon")]
    pub fn threads(mut self, threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        self.threads = Threads::new(threads)?;
        Ok(self)
    }

    /// Runs every trajectory up to the last node at or before `t`, and returns that node for each, in the order of the starts.
    ///
    /// For a trajectory that does not begin or does not reach `t`, the result is its [`RunError`].
    #[must_use]
    pub fn to(&self, t: f64) -> Vec<Result<OwnedNode, RunError>> {
        let runs = self.observed(t, None, |_| (), &|(), _| ControlFlow::Continue(()));
        runs.into_iter().map(|run| run.last).collect()
    }

    /// Runs like [`AnyEnsemble::to`], and hands the nodes whose number is a multiple of `every` to `visit`.
    ///
    /// Each trajectory has a state of its own, which `begin` makes from the index of its start and `visit`
    /// receives with the nodes. If `visit` breaks, this trajectory ends; its last node is the one that
    /// `visit` received last. An infinite `t` is allowed if all break.
    #[must_use]
    pub fn stream<O: Send>(
        &self,
        t: f64,
        every: NonZeroU64,
        begin: impl Fn(usize) -> O + Sync,
        visit: impl Fn(&mut O, &AnyNode<'_>) -> ControlFlow<()> + Sync,
    ) -> Vec<AnyObservedRun<O>> {
        self.observed(t, Some(every), begin, &visit)
    }

    /// Runs all blocks with observers.
    fn observed<O: Send>(
        &self,
        t: f64,
        every: Option<NonZeroU64>,
        begin: impl Fn(usize) -> O + Sync,
        visit: &(dyn Fn(&mut O, &AnyNode<'_>) -> ControlFlow<()> + Sync),
    ) -> Vec<AnyObservedRun<O>> {
        self.runs(t, every, &|first, starts, block| {
            let mut observers = Observers {
                own: (0..starts).map(|lane| begin(first + lane)).collect(),
                ends: (0..starts).map(|_| None).collect(),
                visit,
            };
            block(&mut observers);
            let both = observers.own.into_iter().zip(observers.ends);
            // all trajectories of a block end
            both.filter_map(|(observer, last)| last.map(|last| AnyObservedRun { observer, last }))
                .collect()
        })
    }

    /// Runs all blocks. `results` receives the place of a block's first start, its number of starts, and a
    /// function that runs it.
    pub(super) fn runs<R: Send>(
        &self,
        t: f64,
        every: Option<NonZeroU64>,
        results: &(dyn Fn(usize, usize, &RunsBlock<'_>) -> Vec<R> + Sync),
    ) -> Vec<R> {
        let run = EnsembleRun {
            kernel: self.kernel,
            lanes: &*self.lanes,
            varied: &self.varied,
            held: &self.held,
            h: self.h,
            t,
            every,
            max_iterations: self.max_iterations,
            instructions: self.instructions,
        };
        let finished = AtomicUsize::new(0);
        self.threads.gather(&self.starts, LANES, &|first, starts| {
            let results = results(first, starts.len(), &|observer| {
                run.block(first, starts, observer);
            });
            let total = finished.fetch_add(starts.len(), Ordering::Relaxed) + starts.len();
            if let Some(progress) = self.progress {
                progress(total);
            }
            results
        })
    }

    /// The debug format, under a name.
    pub(super) fn write(&self, f: &mut fmt::Formatter<'_>, name: &str) -> fmt::Result {
        f.debug_struct(name)
            .field("h", &self.h)
            .field("starts", &self.starts)
            .finish_non_exhaustive()
    }
}

/// The observers of a block, and the ends of its trajectories.
struct Observers<'v, O> {
    /// The state of each trajectory.
    own: Vec<O>,
    /// The last nodes, or the errors with which trajectories ended early.
    ends: Vec<Option<Result<OwnedNode, RunError>>>,
    /// Receives the nodes.
    visit: &'v (dyn Fn(&mut O, &AnyNode<'_>) -> ControlFlow<()> + Sync),
}

impl<O> BlockObserver for Observers<'_, O> {
    fn node(&mut self, place: usize, node: &AnyNode<'_>) -> ControlFlow<()> {
        match self.own.get_mut(place) {
            Some(observer) => (self.visit)(observer, node),
            None => ControlFlow::Continue(()),
        }
    }

    fn end(&mut self, place: usize, last: Result<&AnyNode<'_>, RunError>) {
        if let Some(end) = self.ends.get_mut(place) {
            *end = Some(last.map(OwnedNode::of));
        }
    }
}
