//! The Taylor series of a system that was not compiled, by interpreted recurrences.
//!
//! The recurrences are those that the attribute generates as code, with the same functions in the same order,
//! so the bits are the same. Inner sums run over rows of orders as there; the rest of an order is
//! interpreted.

mod order;
mod start;
mod walk;

use core::cell::Cell;
use std::borrow::Cow;
use std::sync::Arc;

use self::order::Lists;
use self::walk::{Expansion, FACTOR, Numbers, Tables, Way};
use super::Tolerance;
use super::control::Assessment;
use super::flow::AnyTaylorFlow;
use super::recurrences::{Along, SeriesKernel};
use super::state::State;
use crate::error::SetupError;
use crate::kernel::Kernel;
use crate::kernel::series::Series;
use crate::number::dispatch;
use crate::number::dual::Dual;
use crate::series::rows;
use crate::series::switch::Switch;
use crate::start::AnyStart;
use crate::step::TapeKernel;
use crate::tape::declaration::Declaration;
use crate::tape::{CallData, Leaf, Number as _, Part, Segment, Shape, Source, Tape, TapeCall};

/// The interpreted series of a system, with the state of its recurrences.
pub(super) struct Interpreted<'s> {
    kernel: &'s TapeKernel,
    series: Arc<Series>,
    lists: Lists,
    /// The values of the parameters.
    values: Vec<f64>,
    tables: Tables,
    /// Workspace of a step: its increments.
    room: Cell<Vec<f64>>,
}

/// The source of the factors' tape for calls and parameters.
struct Called<'a>(&'a TapeKernel, &'a Series);

impl Source for Called<'_> {
    fn shape(&self) -> &Shape {
        self.0.shape()
    }

    fn tape(&self) -> &Tape {
        &self.1.constants
    }

    fn value(&self, parameter: usize) -> f64 {
        self.0.value(parameter)
    }

    fn call(&self, which: usize, arguments: &[f64]) -> f64 {
        let call = self.data(which);
        call.map_or(f64::NAN, |call| call.value(arguments.first().copied()))
    }

    fn call_dual(&self, which: usize, arguments: &[Dual<f64>]) -> Dual<f64> {
        let plain: Vec<f64> = arguments.iter().map(|argument| argument.re).collect();
        Dual::new(self.call(which, &plain), f64::NAN)
    }

    fn data(&self, which: usize) -> Option<CallData<'_>> {
        self.1.calls.get(which).map(TapeCall::data)
    }
}

impl<'s> Interpreted<'s> {
    /// The series of a system with the current values of its parameters; `None` if it has no recurrences.
    fn new(kernel: &'s TapeKernel) -> Option<Self> {
        let series = kernel.series()?;
        let values = (0..kernel.shape().parameters.len()).map(|place| kernel.value(place));
        let mut interpreted = Self {
            lists: Lists::new(&series)?,
            values: values.collect(),
            tables: Tables::new(&series, &kernel.shape().rotations)?,
            room: Cell::default(),
            kernel,
            series,
        };
        interpreted.decide();
        Some(interpreted)
    }

    /// Computes the factors: numbers, expressions of the parameters, and 1/3.
    fn decide(&mut self) {
        let series = &*self.series;
        let mut numbers = Numbers(&mut self.tables.numbers);
        let factors = numbers.all::<FACTOR>();
        let (numbers, computed) = factors.split_at_mut(series.numbers.len());
        numbers.copy_from_slice(&series.numbers);
        let values = &self.values;
        let leaf = |which| match which {
            Leaf::Parameter(i) => values.get(i).copied().unwrap_or(f64::NAN),
            _ => f64::NAN,
        };
        let program = series.constants.program(Segment::Constants, Part::All);
        let source = Called(self.kernel, series);
        f64::walk(program, &source, &leaf, &mut |place, value| {
            if let Some(factor) = computed.get_mut(place) {
                *factor = value;
            }
        });
        if let Some(third) = computed.get_mut(series.computed) {
            *third = 1.0 / 3.0;
        }
    }

    /// Expands a series, after a step if there is one.
    #[inline(never)]
    fn expand_at(&mut self, next: &mut rows::Series, step: Option<Along<'_>>) -> Assessment {
        let expansion = Expansion {
            series: &self.series,
            lists: &self.lists,
            tables: &mut self.tables,
            room: &self.room,
            next,
            step,
        };
        dispatch::run_as(false, expansion)
    }
}

impl SeriesKernel for Interpreted<'_> {
    fn kernel(&self) -> &dyn Kernel {
        self.kernel
    }

    fn values(&self) -> &[f64] {
        &self.values
    }

    fn set_values(&mut self, values: &[f64]) {
        for (own, value) in self.values.iter_mut().zip(values) {
            *own = *value;
        }
        self.decide();
        self.tables.forget();
    }

    fn expand(&mut self, series: &mut rows::Series) {
        self.expand_at(series, None);
    }

    fn along(&self, series: &rows::Series, h: f64, from: &State, to: &mut State) {
        let room = &self.room;
        dispatch::run_as(
            false,
            Way {
                series,
                h,
                from,
                to,
                rotations: &self.kernel.shape().rotations,
                room,
            },
        );
    }

    fn arrive(&mut self, step: Along<'_>, next: &mut rows::Series) -> Assessment {
        self.expand_at(next, Some(step))
    }

    fn switches(&self) -> usize {
        self.series.names.len()
    }

    fn name(&self, switch: usize) -> Cow<'static, str> {
        let name = self.series.names.get(switch);
        name.map_or(Cow::Borrowed("an expression"), |name| {
            Cow::Owned(name.to_string())
        })
    }

    fn groups(&self) -> usize {
        match self.series.names.len() {
            0 => 0,
            _ => 1 + self.series.functions(),
        }
    }

    fn group(&mut self, group: usize) -> &mut [Switch] {
        match group.checked_sub(1) {
            None => &mut self.tables.switches,
            Some(call) => self
                .tables
                .calls
                .get_mut(call)
                .map_or(&mut [], |call| call.switches()),
        }
    }

    fn enter(&mut self) -> bool {
        let mut any = false;
        for call in &mut self.tables.calls {
            any |= call.enter_pieces();
        }
        any
    }
}

impl<'s> AnyTaylorFlow<'s> {
    /// The motion of a system that was not compiled; see [`crate::TaylorFlow::new`].
    ///
    /// # Errors
    ///
    /// As [`crate::TaylorFlow::new`]; [`SetupError::StartLength`] if the start has another number of coordinates, and [`SetupError::NoSeries`] if the
    /// system is a tape alone.
    #[doc(hidden)]
    pub fn of_tape(
        kernel: &'s TapeKernel,
        start: &AnyStart,
        tolerance: Tolerance,
    ) -> Result<Self, SetupError> {
        let start = start.fitted(kernel.shape())?;
        Self::check_order(&Declaration::of(kernel))?;
        let Some(equations) = Interpreted::new(kernel) else {
            return Err(SetupError::NoSeries);
        };
        Self::new(Box::new(equations), &start, &tolerance)
    }

    /// Hands out nodes on a grid of times; see [`crate::TaylorFlow::every`].
    ///
    /// # Errors
    ///
    /// [`SetupError::Step`] if `h` is zero, infinite or not a number.
    #[doc(hidden)]
    pub fn every(mut self, h: f64) -> Result<Self, SetupError> {
        self.put_on_grid(h)?;
        Ok(self)
    }

    /// The number of steps that were made.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.motion.steps
    }
}
