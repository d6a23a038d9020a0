//! The flow of a composed step of a system without its type.

use super::run::Composed;
use crate::error::SetupError;
use crate::flow::discrete::values_of;
use crate::kernel::Kernel;
use crate::number::composition::Composition;
use crate::run::Run;
use crate::start::AnyStart;

/// A [`ComposedFlow`](crate::ComposedFlow) with any number of coordinates, of a system without its type. All of its stages are solved on slices.
#[derive(Clone)]
pub struct AnyComposedFlow<'s>(Composed<'s>);

impl core::fmt::Debug for AnyComposedFlow<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("AnyComposedFlow")
            .field("method", &self.0.method)
            .field("h", &self.0.h)
            .finish_non_exhaustive()
    }
}

impl<'s> AnyComposedFlow<'s> {
    /// Sets up a run with the step `h`, which is negative to run back in time.
    ///
    /// # Errors
    ///
    /// The errors of [`ComposedFlow::new`](crate::ComposedFlow::new), and [`SetupError::StartLength`] if the start has another number of coordinates.
    pub fn new(
        system: &'s dyn Kernel,
        h: f64,
        method: Composition,
        start: &AnyStart,
    ) -> Result<Self, SetupError> {
        let start = start.fitted(system.shape())?;
        let run = Composed::new((system, values_of(system)), None, h, method, &start);
        Ok(Self(run?))
    }

    /// The run.
    #[must_use]
    pub fn run(&self) -> &(dyn Run + 's) {
        &self.0
    }

    /// The run, to make steps.
    #[must_use]
    pub fn run_mut(&mut self) -> &mut (dyn Run + 's) {
        &mut self.0
    }

    /// The run as a boxed trait object.
    #[must_use]
    pub fn into_run(self) -> Box<dyn Run + 's> {
        Box::new(self.0)
    }
}
