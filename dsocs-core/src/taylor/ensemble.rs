//! Many continuous motions of one system, in SIMD lanes and on several threads.

use core::fmt;

use super::block::Run;
use super::control::Tolerance;
use super::integrator::MAX_STEPS;
use super::lanes::{self, LaneSeries};
use super::recurrences::{Recurrences, SeriesKernel};
use crate::ensemble::{ObservedRun, one_each};
use crate::error::SetupError;
use crate::kernel::Kernel;
use crate::number::instructions::Instructions;
use crate::number::lanes::LANES;
use crate::run::{Failure, Node, Observer, RunError, Trajectory};
use crate::start::{self, Start};
use crate::system::System;
use crate::tape::declaration::Declaration;
use crate::threads::Threads;

/// Largest number of motions in one block: more would leave threads without work at the end.
const BLOCK: usize = 32 * LANES;

/// Many motions of one system by Taylor series, each from its own start and with the same tolerance: the
/// counterpart of [`Ensemble`](crate::Ensemble) for the continuous motion.
///
/// Eight motions share the SIMD lanes of an expansion. Each has its own order and its own steps, as a [`TaylorFlow`](crate::TaylorFlow)
/// has, and where one motion ends, the next start takes its lane. The first step of a motion is made in a single flow, and so is a step that
/// its lane cannot decide. A system with jumps or corners (`if`, `abs`, `signum`, `min`) makes all its steps in single flows.
///
/// - Results come in the order of the starts.
/// - A motion that fails ends with its own error, and the others go on.
/// - A result does not depend on the number of threads, on the other motions, or on the instructions of the machine: it is the same bit
///   for bit. It agrees with that of a [`TaylorFlow`](crate::TaylorFlow) to within the tolerance: single flows use fused products where
///   the machine has them.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::taylor::TaylorEnsemble;
///
/// /// A pendulum.
/// #[dsocs {
///     coordinates(theta);
///     lagrangian = dot(theta).powi(2) / 2 + 9.81 * theta.cos();
/// }]
/// struct Pendulum {}
///
/// let pendulum = Pendulum {};
/// // let go at angles from 0.1 to 3
/// let starts = (1..=30).map(|k| Start::second_order([0.1 * f64::from(k)], [0.0]));
/// let ends = TaylorEnsemble::new(&pendulum, Tolerance::relative(1e-12))?.starts(starts).to(10.0);
/// for (k, end) in (1..=30).zip(ends) {
///     let end = end?;
///     let lost = end.energy + 9.81 * (0.1 * f64::from(k)).cos();
///     assert!(lost.abs() < 1e-10);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub struct TaylorEnsemble<'a, const N: usize> {
    /// The system.
    system: Box<dyn SeriesKernels + 'a>,
    /// The common tolerance.
    tolerance: Tolerance,
    /// The starts.
    starts: Vec<Start<N>>,
    /// The parameters that vary.
    varied: Varied,
    /// The distance of the nodes in time, if they lie on a grid.
    every: Option<f64>,
    /// The largest number of steps of each motion.
    max_steps: u64,
    /// The widest instructions that may be used.
    instructions: Instructions,
    /// The threads.
    threads: Threads,
}

/// Makes the kernels that an ensemble needs of a system.
pub(super) trait SeriesKernels: Sync {
    /// The system.
    fn kernel(&self) -> &dyn Kernel;

    /// The series of one motion, with instructions that all machines have.
    fn single(&self) -> Box<dyn SeriesKernel + '_>;

    /// The series of eight motions, with the requested instructions, or the widest available below them.
    fn lanes(&self, instructions: Instructions) -> Box<dyn LaneSeries + '_>;
}

/// The kernels of a declared type.
struct Compiled<'a, S, const N: usize>(&'a S);

impl<S: System<N>, const N: usize> SeriesKernels for Compiled<'_, S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.0.kernel()
    }

    fn single(&self) -> Box<dyn SeriesKernel + '_> {
        Box::new(Recurrences::new(self.0, true))
    }

    fn lanes(&self, instructions: Instructions) -> Box<dyn LaneSeries + '_> {
        lanes::engine(instructions, self.0)
    }
}

/// Parameters that vary, by their places, each with a value for every start.
#[derive(Default)]
pub(super) struct Varied(Vec<(usize, Vec<f64>)>);

impl Varied {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Sets the values of one motion.
    pub fn set(&self, place: usize, values: &mut [f64]) {
        for (parameter, of_starts) in &self.0 {
            if let (Some(own), Some(&value)) = (values.get_mut(*parameter), of_starts.get(place)) {
                *own = value;
            }
        }
    }
}

impl<const N: usize> fmt::Debug for TaylorEnsemble<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TaylorEnsemble")
            .field("tolerance", &self.tolerance)
            .field("starts", &self.starts)
            .finish_non_exhaustive()
    }
}

impl<'a, const N: usize> TaylorEnsemble<'a, N> {
    /// An ensemble without motions.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if the tolerance or a parameter of the system cannot be used.
    pub fn new<S: System<N>>(system: &'a S, tolerance: Tolerance) -> Result<Self, SetupError> {
        tolerance.check()?;
        start::check_parameters(&Declaration::of(system))?;
        Ok(Self {
            system: Box::new(Compiled(system)),
            tolerance,
            starts: Vec::new(),
            varied: Varied::default(),
            every: None,
            max_steps: MAX_STEPS,
            instructions: Instructions::best(),
            threads: Threads::default(),
        })
    }

    /// Adds motions, one for each start.
    pub fn starts(mut self, starts: impl IntoIterator<Item = Start<N>>) -> Self {
        self.starts.extend(starts);
        self
    }

    /// Sets a parameter to a different value in each motion, in the order of the starts that were added
    /// before. Several parameters may vary.
    ///
    /// # Errors
    ///
    /// [`RunError::Input`] if there is no such parameter, or if there are not as many values as starts. A
    /// value that a run cannot begin with fails only its own motion.
    pub fn varied(
        mut self,
        parameter: &str,
        values: impl IntoIterator<Item = f64>,
    ) -> Result<Self, RunError> {
        let values = values.into_iter().collect();
        let values = one_each(self.system.kernel().shape(), parameter, values, self.starts.len())?;
        self.varied.0.push(values);
        Ok(self)
    }

    /// Puts the nodes on a grid of times, a distance of `h` apart, as [`TaylorFlow::every`](crate::TaylorFlow::every) does.
    ///
    /// # Errors
    ///
    /// [`SetupError::Step`] if `h` is zero, infinite or not a number.
    pub fn every(mut self, h: f64) -> Result<Self, SetupError> {
        if !h.is_finite() || h == 0.0 {
            return Err(SetupError::Step { h });
        }
        self.every = Some(h);
        Ok(self)
    }

    /// Sets the largest number of steps of each motion (10 million by default).
    pub fn max_steps(mut self, limit: u64) -> Self {
        self.max_steps = limit;
        self
    }

    /// Sets the widest instructions that may be used, to compare them: unless set, the widest that the machine has. The results
    /// do not depend on them.
    pub fn instructions(mut self, widest: Instructions) -> Self {
        self.instructions = widest;
        self
    }

    /// Uses a thread pool of its own with so many threads (0: as many as there are cores). Without this the ensemble uses
    /// rayon's global pool.
    ///
    /// # Errors
    ///
    /// [`rayon::ThreadPoolBuildError`] if the threads cannot be started.
    #[cfg(feature = "rayon")]
    pub fn threads(mut self, threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        self.threads = Threads::new(threads)?;
        Ok(self)
    }

    /// Runs every motion to the time `t`, or to the last node of the grid at or before it, and returns the node there for each, in the order
    /// of the starts. Without a grid, a time before a start is reached back in time. For a motion that does not begin or does not reach `t`,
    /// the result is its [`RunError`].
    #[must_use]
    pub fn to(&self, t: f64) -> Vec<Result<Node<N>, RunError>> {
        let runs = self.runs(t, false, |_| Trajectory::default());
        runs.into_iter().map(|run| run.last).collect()
    }

    /// Runs every motion to the time `t` and collects its nodes. For a motion that fails, the [`Failure`] contains the nodes so far.
    #[must_use]
    pub fn until(&self, t: f64) -> Vec<Result<Trajectory<N>, Failure<N>>> {
        let runs = self.stream(t, |_| Trajectory::default());
        let collected = |ObservedRun { observer, last }| match last {
            Ok(_) => Ok(observer),
            Err(error) => Err(Failure {
                error,
                trajectory: observer,
            }),
        };
        runs.into_iter().map(collected).collect()
    }

    /// Runs every motion to the time `t`, and hands its nodes to an observer of its own, which is made from the number of the start.
    /// An observer may end its motion.
    #[must_use]
    pub fn stream<O: Observer<N> + Send>(
        &self,
        t: f64,
        observer: impl Fn(usize) -> O + Sync,
    ) -> Vec<ObservedRun<O, N>> {
        self.runs(t, true, observer)
    }

    /// Runs all blocks.
    fn runs<O: Observer<N> + Send>(
        &self,
        t: f64,
        observes: bool,
        observer: impl Fn(usize) -> O + Sync,
    ) -> Vec<ObservedRun<O, N>> {
        let run = Run {
            system: &*self.system,
            varied: &self.varied,
            tolerance: self.tolerance,
            max_steps: self.max_steps,
            every: self.every,
            t,
            observes,
            instructions: self.instructions,
        };
        let size = match self.threads.count() {
            1 => BLOCK,
            threads => {
                let each = self.starts.len().div_ceil(4 * threads);
                each.next_multiple_of(LANES).clamp(LANES, BLOCK)
            }
        };
        self.threads.gather(&self.starts, size, &|first, starts| {
            run.block(first, starts, &observer)
        })
    }
}
