//! A run whose steps are kept, so that it can be differentiated.

use std::borrow::Cow;
use std::fmt;

use super::block::{Equations, Fixed, Recorded, Rooms, Steps};
use super::changed::{Change, Changed};
use super::error::DerivativeError;
use super::kept::{Checkpoints, Kept};
use super::start::Begun;
use crate::any::AnySystem;
use crate::declaration::Declaration;
use crate::error::SetupError;
use crate::flow::Flow;
use crate::held::Held;
use crate::kernel::Shape;
use crate::run::{Clock, Inputs as _, Node, RunError, Stepper as _, inputs};
use crate::start::{Beginning, Start, StartOrder};
use crate::step::newton::Stop;
use crate::system::System;
use crate::tape::Eight;

/// A run of a [`Flow`] whose steps were kept, so that it can be differentiated: forward by [`Path::tangents`], backward by
/// [`Path::gradient`].
///
/// It takes `8 (3 n + m + 1)` bytes per step, with `n` coordinates and `m` unknowns, up to [`Path::MEMORY`] bytes. A longer run keeps only some of its
/// states, as checkpoints, and about as many steps; derivatives then make the steps between two checkpoints again, which takes about as long as one
/// more run. The nodes are those of [`Flow`], and the derivatives are the same either way, bit for bit.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::{Path, Variable};
///
/// /// A mass on a spring.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = dot(x).powi(2) / 2 - stiffness * x.powi(2) / 2;
/// }]
/// struct Oscillator {
///     stiffness: f64,
/// }
///
/// let oscillator = Oscillator { stiffness: 4.0 };
/// let path = Path::new(&oscillator, 0.001, Start::second_order([1.0], [0.0]), 1.0)?;
/// // x = cos(ω t) with ω² = k: ∂x/∂k = −t sin(ω t) / 2ω
/// let tangents = path.tangents(&[Variable::Parameter("stiffness")])?;
/// assert!((tangents[0].q[0] + 2.0_f64.sin() / 4.0).abs() < 1e-6);
/// // the same from the end, with all other derivatives
/// let gradient = path.gradient_at_end(&mut |end| end.q[0])?;
/// assert!((gradient.parameters[0] - tangents[0].q[0]).abs() < 1e-12);
/// assert!((gradient.q0[0] - 2.0_f64.cos()).abs() < 1e-6);
/// # Ok::<(), dsocs_core::DerivativeError>(())
/// ```
pub struct Path<'s, S: System<N>, const N: usize> {
    /// The step.
    h: f64,
    /// The rule that gives the second node.
    order: StartOrder,
    /// The start, after its rule was applied.
    beginning: Beginning<N>,
    /// The stretches of constant inputs: each system, with the number of the node from which on it holds.
    stretches: Vec<(usize, Held<'s, S>)>,
    /// The inputs, as indices of parameters.
    inputs: Vec<usize>,
    /// How many steps there are.
    length: usize,
    /// All of them, or those from the last checkpoint on.
    kept: Kept<N>,
    /// The states from which the others are made again.
    checkpoints: Checkpoints<'s, S, N>,
    /// The last node.
    end: Node<N>,
}

// by hand, because a derived one would require `Debug` of the system
impl<S: System<N>, const N: usize> fmt::Debug for Path<'_, S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Path")
            .field("h", &self.h)
            .field("steps", &self.length)
            .field("end", &self.end)
            .finish_non_exhaustive()
    }
}

impl<'s, S: System<N>, const N: usize> Path<'s, S, N> {
    /// How many bytes the steps of a path take at most, where nothing else is asked for ([`Path::within`]): 256 MiB.
    pub const MEMORY: usize = 1 << 28;

    /// Runs from a start with the step `h`, up to the last node at or before `t`.
    ///
    /// # Errors
    ///
    /// [`DerivativeError::Run`] as [`Flow::new`] and [`crate::Stepper::to`]; [`DerivativeError::NoSteps`] if `t` is less than a step
    /// away; [`DerivativeError::Jump`] if a step has no root but a jump.
    pub fn new(system: &'s S, h: f64, start: Start<N>, t: f64) -> Result<Self, DerivativeError> {
        Self::within(system, h, start, t, Self::MEMORY)
    }

    /// The same where the steps take at most `memory` bytes, if a run of that length can do with it: checkpoints need room, too.
    ///
    /// # Errors
    ///
    /// As [`Path::new`].
    pub fn within(
        system: &'s S,
        h: f64,
        start: Start<N>,
        t: f64,
        memory: usize,
    ) -> Result<Self, DerivativeError> {
        if !t.is_finite() {
            return Err(RunError::Until { until: t }.into());
        }
        if const { S::ORDER > 2 } {
            let method = "the derivative of a run (Path)";
            return Err(RunError::from(SetupError::ThirdOrder { method }).into());
        }
        let mut flow = Flow::new(system, h, start).map_err(RunError::from)?;
        let end = flow.clock().until(t)?;
        let mut path = Self::begun(&flow, &start);
        let count = end
            .index()
            .map_or(0, |count| usize::try_from(count).unwrap_or(usize::MAX));
        let unknowns = path.unknowns_of_a_step();
        let bytes = size_of::<Recorded<N>>() + size_of::<f64>() * unknowns;
        path.checkpoints = Checkpoints::new(count, bytes, memory);
        let window = count.min(path.checkpoints.every);
        path.kept = Kept::from(1, window, unknowns);
        flow.clock_mut().hand_out(true);
        while !flow.clock().has_reached(&end) {
            if path.checkpoints.keep(&flow, path.length) && path.length > 0 {
                path.kept = Kept::from(path.length + 1, window, unknowns);
            }
            flow.step(end.time())?;
            path.keep(&flow)?;
        }
        path.ended(&flow)
    }

    /// Runs with inputs that are held on each leg: `values[k]` are the values of the parameters `inputs` on the leg from node `k` to node
    /// `k + 1`. The run ends at the node after the last leg. The values of the last leg hold there, too: they give the velocity at the end.
    ///
    /// All other parameters are those of the system. The values that the inputs have in the system are not used.
    ///
    /// # Errors
    ///
    /// [`DerivativeError::Run`] as [`Flow::new`], [`crate::Inputs::set_input`] and [`crate::Stepper::to`]; [`DerivativeError::Jump`] as above;
    /// [`DerivativeError::NoLegs`] without values; [`DerivativeError::Constraints`] for a system with kinematic or nonholonomic
    /// constraints.
    pub fn plan<const U: usize>(
        system: &'s S,
        h: f64,
        start: Start<N>,
        inputs: [&str; U],
        values: &[[f64; U]],
    ) -> Result<Self, DerivativeError>
    where
        S: Clone,
    {
        let Some(first) = values.first() else {
            return Err(DerivativeError::NoLegs);
        };
        for (count, constraints) in [(S::KINEMATIC, "kinematic"), (S::NONHOLONOMIC, "nonholonomic")] {
            if count > 0 {
                return Err(DerivativeError::Constraints { constraints });
            }
        }
        let mut held = Held::new(system);
        let mut places = Vec::with_capacity(U);
        for (name, &value) in inputs.iter().zip(first) {
            let place = inputs::place(const { &Shape::of::<S, N>() }, name, value)?;
            if let Some(parameter) = held.own().parameter_mut(place) {
                *parameter = value;
            }
            places.push(place);
        }
        let mut flow = Flow::holding(held, h, start).map_err(RunError::from)?;
        let mut path = Self::begun(&flow, &start);
        path.inputs = places;
        for leg in 1..=values.len() {
            if let Some(values) = values.get(leg) {
                for (name, &value) in inputs.iter().zip(values) {
                    flow.set_input(name, value)?;
                }
                path.stretches.push((leg, flow.held().clone()));
            }
            flow.step(f64::INFINITY * h)?;
            path.keep(&flow)?;
        }
        path.ended(&flow)
    }

    /// How many unknowns a step has.
    fn unknowns_of_a_step(&self) -> usize {
        Declaration::of(&*self.stretches[0].1).unknowns()
    }

    /// A path without steps.
    fn begun(flow: &Flow<'s, S, N>, start: &Start<N>) -> Self {
        Self {
            h: flow.h(),
            order: start.order(),
            beginning: *flow.beginning(),
            stretches: vec![(0, flow.held().clone())],
            inputs: Vec::new(),
            length: 0,
            kept: Kept::from(1, 0, 0),
            checkpoints: Checkpoints::none(),
            end: flow.node(),
        }
    }

    /// Keeps the last step of the flow.
    #[inline]
    fn keep(&mut self, flow: &Flow<'s, S, N>) -> Result<(), DerivativeError> {
        if const { S::JUMPS } && matches!(flow.node().stop, Stop::Jump | Stop::Sticks) {
            let index = self.length + 1;
            let time = flow.node().t;
            return Err(DerivativeError::Jump { index, time });
        }
        self.kept.keep(flow);
        self.length += 1;
        Ok(())
    }

    fn ended(mut self, flow: &Flow<'s, S, N>) -> Result<Self, DerivativeError> {
        if self.length == 0 {
            return Err(DerivativeError::NoSteps { h: self.h });
        }
        self.end = flow.node();
        Ok(self)
    }

    /// The last node.
    #[must_use]
    pub fn end(&self) -> &Node<N> {
        &self.end
    }

    /// The number of steps. Nodes are numbered from 0 (the start) to this number.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.length
    }

    /// The inputs of a plan, in its order, by their names.
    pub(super) fn input_names(&self) -> Vec<Cow<'static, str>> {
        self.inputs
            .iter()
            .filter_map(|&place| Some(S::PARAMETERS.get(place)?.name.clone()))
            .collect()
    }

    /// The index of a parameter.
    pub(super) fn parameter(name: &str) -> Result<usize, DerivativeError> {
        parameter::<S, N>(name)
    }

    /// The path without the type of its system.
    pub(super) fn motion(&self) -> Result<Motion<'_, N>, DerivativeError> {
        let stretches: Vec<_> = (self.stretches.iter())
            .map(|(from, system)| (*from, Declaration::of(&**system)))
            .collect();
        let system: &S = &self.stretches[0].1;
        Ok(Motion::new(
            self,
            stretches,
            Begun::new(system, self.h, self.order, &self.beginning)?,
            system,
        ))
    }

    /// The rule that gives the second node.
    pub(super) fn order(&self) -> StartOrder {
        self.order
    }

    /// How many legs have inputs of their own.
    pub(super) fn legs(&self) -> usize {
        self.stretches.len()
    }

    /// The inputs, as indices of parameters.
    pub(super) fn input_places(&self) -> &[usize] {
        &self.inputs
    }
}

/// The index of a parameter.
pub(crate) fn parameter<S: System<N>, const N: usize>(name: &str) -> Result<usize, DerivativeError> {
    let place = S::PARAMETERS.iter().position(|known| known.name == name);
    place.ok_or_else(|| DerivativeError::Parameter {
        name: name.to_owned(),
        known: S::PARAMETERS.iter().map(|known| known.name.clone()).collect(),
    })
}

/// A path without the type of its system. Derivatives are computed from it.
pub(super) struct Motion<'p, const N: usize> {
    pub h: f64,
    pub beginning: &'p Beginning<N>,
    pub begun: Begun<N>,
    /// How many steps there are.
    length: usize,
    /// How many of them lie between two checkpoints.
    every: usize,
    /// All of them, or those from the last checkpoint on.
    kept: &'p Kept<N>,
    /// Makes the steps from a checkpoint on again.
    again: Box<Again<'p, N>>,
    stretches: Vec<(usize, Declaration<'p>)>,
    pub equations: Equations,
}

/// Makes the steps from a checkpoint on again.
type Again<'p, const N: usize> = dyn Fn(usize) -> Result<Kept<N>, DerivativeError> + 'p;

/// Consecutive steps of a path, all from one checkpoint on.
pub(super) type Window<'p, const N: usize> = Cow<'p, Kept<N>>;

/// Some consecutive steps, by the numbers of their middle nodes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Piece {
    /// Up to eight steps with the same parameters.
    Plain {
        first: usize,
        count: usize,
        stretch: usize,
    },
    /// The one step at which the parameters change to those of a stretch.
    Changed { at: usize, stretch: usize },
}

impl Piece {
    /// The first of its steps, how many they are, and the stretch that they belong to.
    pub(super) fn steps(&self) -> (usize, usize, usize) {
        match *self {
            Self::Plain {
                first,
                count,
                stretch,
            } => (first, count, stretch),
            Self::Changed { at, stretch } => (at, 1, stretch),
        }
    }
}

impl<'p, const N: usize> Motion<'p, N> {
    fn new<S: System<N>>(
        path: &'p Path<'_, S, N>,
        stretches: Vec<(usize, Declaration<'p>)>,
        begun: Begun<N>,
        system: &'p dyn AnySystem<N>,
    ) -> Self {
        let parameters = system.parameters().len();
        Self {
            h: path.h,
            beginning: &path.beginning,
            begun,
            length: path.length,
            every: path.checkpoints.every,
            kept: &path.kept,
            again: Box::new(|window| path.checkpoints.again(window, path.length)),
            equations: Equations::new::<N>(stretches[0].1.source().tape(), parameters),
            stretches,
        }
    }

    /// How many stretches there are.
    pub fn stretches(&self) -> usize {
        self.stretches.len()
    }

    /// The declaration on a stretch.
    pub fn declaration(&self, stretch: usize) -> &Declaration<'p> {
        &self.stretches[stretch].1
    }

    /// How many windows the steps are in.
    pub fn windows(&self) -> usize {
        self.length.div_ceil(self.every)
    }

    /// The steps of a window.
    ///
    /// # Errors
    ///
    /// None, as long as steps that were solved once can be solved again.
    pub fn window(&self, window: usize) -> Result<Window<'p, N>, DerivativeError> {
        if window + 1 == self.windows() {
            return Ok(Cow::Borrowed(self.kept));
        }
        Ok(Cow::Owned((self.again)(window)?))
    }

    /// The pieces of a window, in order.
    pub fn pieces(&self, window: &Kept<N>) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for (stretch, (from, _)) in self.stretches.iter().enumerate() {
            let next = self
                .stretches
                .get(stretch + 1)
                .map_or(self.length + 1, |next| next.0);
            if stretch > 0 && (window.first..window.end()).contains(from) {
                pieces.push(Piece::Changed { at: *from, stretch });
            }
            let mut first = (from + 1).max(window.first);
            let next = next.min(window.end());
            while first < next {
                let count = (next - first).min(Eight::COUNT);
                pieces.push(Piece::Plain {
                    first,
                    count,
                    stretch,
                });
                first += count;
            }
        }
        pieces
    }

    /// Whether a piece is the last of the path.
    pub fn is_last(&self, piece: &Piece) -> bool {
        let (first, count, _) = piece.steps();
        first + count > self.length
    }

    /// Prepares the steps of a stretch; returns the values of its constants and parameters.
    pub fn enter(&self, stretch: usize, rooms: &mut Rooms) -> Fixed {
        let source = self.declaration(stretch).source();
        let fixed = self.equations.fixed(source, self.h, rooms);
        self.equations.enter(&fixed, self.h, rooms);
        fixed
    }

    /// The steps of a window with the middle nodes `first`, …, `first + count - 1`.
    pub fn some<'w>(&'w self, window: &'w Kept<N>, piece: &Piece) -> Steps<'w, N> {
        let (first, count, stretch) = piece.steps();
        let range = first - window.first..first - window.first + count;
        let rows = self.equations.rows;
        Steps {
            source: self.declaration(stretch).source(),
            unknowns: &window.unknowns[range.start * rows..range.end * rows],
            recorded: &window.steps[range],
        }
    }

    /// The derivatives of the step at which the parameters change.
    pub fn changed(
        &self,
        window: &Kept<N>,
        at: usize,
        stretch: usize,
    ) -> Result<Changed<N>, DerivativeError> {
        let change = Change {
            sides: [*self.declaration(stretch - 1), *self.declaration(stretch)],
            h: self.h,
            step: window.steps[at - window.first],
        };
        change
            .slopes(self.equations.parameters)
            .ok_or_else(|| self.singular(at))
    }

    /// The time of a node.
    pub fn time(&self, index: usize) -> f64 {
        Clock::even(self.beginning.t0, self.h).time_of(index as u64)
    }

    /// The error of a step that cannot be differentiated.
    pub fn singular(&self, index: usize) -> DerivativeError {
        DerivativeError::Singular {
            index,
            time: self.time(index),
        }
    }
}
