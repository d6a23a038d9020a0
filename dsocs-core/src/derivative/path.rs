//! A run whose steps are stored, so that it can be differentiated.

use std::fmt;
use std::ops::ControlFlow;

use super::error::DerivativeError;
use super::memory::{Checkpoints, RecordedSteps, record_last};
use super::motion::{JumpInTime, Recording, Stretch};
use super::start::{AppliedStart, ContinuousSolution};
use crate::error::SetupError;
use crate::flow::discrete::{Discrete, values_of};
use crate::kernel::Kernel;
use crate::run::{AnyNode, Node, OwnedNode, Run, RunError, inputs};
use crate::solve::newton::Stop;
use crate::solve::rotation;
use crate::start::{self, AnyStart, ComputedStart, Start, StartData};
use crate::system::System;
use crate::tape::quantity::Quantity;

/// A run of a [`Flow`](crate::Flow) whose steps are stored, so that it can be differentiated: forward by
/// [`Path::tangents`], backward by [`Path::gradient`].
///
/// It takes `8 (3 n + m + 1)` bytes per step, with `n` coordinates and `m` unknowns, up to [`Path::MEMORY`]
/// bytes. A longer run stores only some of its states, as checkpoints, and about as many steps; derivatives
/// then compute the steps between two checkpoints again, which takes about as long as one more run. The nodes
/// are those of [`Flow`](crate::Flow), and the derivatives are the same either way, bit for bit.
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
pub struct Path<'s, const N: usize> {
    /// The path with any number of coordinates.
    pub(super) any: AnyPath<'s>,
    /// The last node.
    end: Node<N>,
}

// by hand, because the steps are not printed
impl<const N: usize> fmt::Debug for Path<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.any.write(f, "Path")
    }
}

impl<'s, const N: usize> Path<'s, N> {
    /// Largest memory of a path's steps in bytes, unless set by [`Path::within`]: 256 MiB.
    pub const MEMORY: usize = AnyPath::MEMORY;

    /// Runs from a start with the step `h`, up to the last node at or before `t`.
    ///
    /// # Errors
    ///
    /// [`DerivativeError::Run`] with the errors of [`crate::Flow::new`] and [`crate::Stepper::to`]; [`DerivativeError::NoSteps`] if `t` is
    /// less than a step away; [`DerivativeError::Jump`] if a step has no root but a jump; [`DerivativeError::MovingJump`] if the acceleration jumps
    /// at a place of the motion.
    pub fn new<S: System<N>>(
        system: &'s S,
        h: f64,
        start: Start<N>,
        t: f64,
    ) -> Result<Self, DerivativeError> {
        Self::within(system, h, start, t, Self::MEMORY)
    }

    /// [`Path::new`] with at most `memory` bytes for the steps, if a run of that length is possible with it:
    /// checkpoints need memory, too.
    ///
    /// # Errors
    ///
    /// The errors of [`Path::new`].
    pub fn within<S: System<N>>(
        system: &'s S,
        h: f64,
        start: Start<N>,
        t: f64,
        memory: usize,
    ) -> Result<Self, DerivativeError> {
        run(system.kernel(), h, &start.given(), t, memory, &mut go_on).map(Self::of)
    }

    /// Runs with inputs that are held on each leg: `values[k]` are the values of the parameters `inputs` on the leg from node `k` to node
    /// `k + 1`. The run ends at the node after the last leg. The values of the last leg hold there, too: they give the velocity at the end.
    ///
    /// All other parameters are those of the system. The values that the inputs have in the system are not used.
    ///
    /// # Errors
    ///
    /// [`DerivativeError::Run`] with the errors of [`crate::Flow::new`], [`crate::Inputs::set_input`] and [`crate::Stepper::to`];
    /// [`DerivativeError::Jump`] if a step has no root but a jump; [`DerivativeError::MovingJump`] if the acceleration jumps at a place of the
    /// motion; [`DerivativeError::NoLegs`] without values;
    /// [`DerivativeError::Constraints`] for a system with kinematic or nonholonomic constraints.
    pub fn plan<S: System<N>, const U: usize>(
        system: &'s S,
        h: f64,
        start: Start<N>,
        inputs: [&str; U],
        values: &[[f64; U]],
    ) -> Result<Self, DerivativeError> {
        let legs: Vec<&[f64]> = values.iter().map(|values| &values[..]).collect();
        plan(system.kernel(), h, &start.given(), &inputs, &legs).map(Self::of)
    }

    /// The path with its number of coordinates at compile time.
    fn of(any: AnyPath<'s>) -> Self {
        Self {
            end: any.end().sized(),
            any,
        }
    }

    /// The last node.
    #[must_use]
    pub fn end(&self) -> &Node<N> {
        &self.end
    }

    /// The number of steps. Nodes are numbered from 0 (the start) to this number.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.any.steps()
    }
}

/// A [`Path`] with any number of coordinates, of a system without its type.
///
/// ```
/// # #[cfg(feature = "text")] {
/// use dsocs_core::text::Text;
/// use dsocs_core::{AnyPath, AnyStart, Variable};
///
/// let text = Text::parse(
///     "spring",
///     "parameters { stiffness = 4.0 }
///      coordinates(x);
///      lagrangian = dot(x).powi(2) / 2 - stiffness * x.powi(2) / 2;",
/// )?;
/// let path = AnyPath::new(&text.system, 0.001, &AnyStart::second_order(&[1.0], &[0.0]), 1.0)?;
/// // x = cos(ω t) with ω² = k: ∂x/∂k = −t sin(ω t) / 2ω
/// let tangents = path.tangents(&[Variable::Parameter("stiffness")])?;
/// let by_stiffness = tangents.get(0).map_or(f64::NAN, |by| by.q[0]);
/// assert!((by_stiffness + 2.0_f64.sin() / 4.0).abs() < 1e-6);
/// let gradient = path.gradient_at_end(&mut |end| end.q[0])?;
/// assert!((gradient.parameters[0] - by_stiffness).abs() < 1e-12);
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct AnyPath<'s> {
    /// The steps.
    pub(super) recording: Recording<'s>,
    /// The last node.
    end: OwnedNode,
}

// by hand, because the steps are not printed
impl fmt::Debug for AnyPath<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, "AnyPath")
    }
}

impl<'s> AnyPath<'s> {
    /// Largest memory of a path's steps in bytes, unless set by [`AnyPath::within`]: 256 MiB.
    pub const MEMORY: usize = 1 << 28;

    /// Runs from a start with the step `h`, up to the last node at or before `t`.
    ///
    /// # Errors
    ///
    /// The errors of [`Path::new`], and [`SetupError::StartLength`] if the start has another number of coordinates.
    pub fn new(system: &'s dyn Kernel, h: f64, start: &AnyStart, t: f64) -> Result<Self, DerivativeError> {
        Self::within(system, h, start, t, Self::MEMORY)
    }

    /// [`AnyPath::new`] with at most `memory` bytes for the steps; see [`Path::within`].
    ///
    /// # Errors
    ///
    /// The errors of [`AnyPath::new`].
    pub fn within(
        system: &'s dyn Kernel,
        h: f64,
        start: &AnyStart,
        t: f64,
        memory: usize,
    ) -> Result<Self, DerivativeError> {
        let start = start.fitted(system.shape()).map_err(RunError::from)?;
        run(system, h, &start, t, memory, &mut go_on)
    }

    /// Like [`AnyPath::new`], but calls `ask` about every thousand steps, and stops if it breaks.
    ///
    /// # Errors
    ///
    /// The errors of [`AnyPath::new`], and [`DerivativeError::Stopped`].
    pub fn new_while(
        system: &'s dyn Kernel,
        h: f64,
        start: &AnyStart,
        t: f64,
        ask: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<Self, DerivativeError> {
        let start = start.fitted(system.shape()).map_err(RunError::from)?;
        run(system, h, &start, t, Self::MEMORY, ask)
    }

    /// Runs with inputs that are held on each leg: `values[k]` are the values of the parameters `inputs` on
    /// the leg from node `k` to node `k + 1`; see [`Path::plan`]. Missing values are NaN.
    ///
    /// # Errors
    ///
    /// The errors of [`Path::plan`], and [`SetupError::StartLength`] if the start has another number of coordinates.
    pub fn plan(
        system: &'s dyn Kernel,
        h: f64,
        start: &AnyStart,
        inputs: &[&str],
        values: &[&[f64]],
    ) -> Result<Self, DerivativeError> {
        let start = start.fitted(system.shape()).map_err(RunError::from)?;
        plan(system, h, &start, inputs, values)
    }

    /// The last node.
    #[must_use]
    pub fn end(&self) -> AnyNode<'_> {
        self.end.any()
    }

    /// The number of steps. Nodes are numbered from 0 (the start) to this number.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.recording.length
    }

    /// The debug format, under a name.
    fn write(&self, f: &mut fmt::Formatter<'_>, name: &str) -> fmt::Result {
        f.debug_struct(name)
            .field("h", &self.recording.h)
            .field("steps", &self.recording.length)
            .field("end", &self.end)
            .finish_non_exhaustive()
    }
}

/// Number of steps after which the caller is asked whether to continue.
const ASK: u64 = 1024;

/// Always continues.
fn go_on() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Runs to a time and stores the steps.
fn run<'s>(
    kernel: &'s dyn Kernel,
    h: f64,
    start: &StartData,
    t: f64,
    memory: usize,
    ask: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<AnyPath<'s>, DerivativeError> {
    if !t.is_finite() {
        return Err(RunError::Until { until: t }.into());
    }
    if kernel.shape().is_of_third_order() {
        let method = "the derivative of a run (Path)";
        return Err(RunError::from(SetupError::ThirdOrder { method }).into());
    }
    let mut flow = Discrete::new(kernel, values_of(kernel), h, start).map_err(RunError::from)?;
    let end = flow.clock().until(t)?;
    let count = end
        .index()
        .map_or(0, |count| usize::try_from(count).unwrap_or(usize::MAX));
    let mut recorder = Recorder::new(&flow, count, memory);
    flow.clock_mut().hand_out(true);
    while !flow.clock().has_reached(&end) {
        if flow.clock().index() % ASK == ASK - 1 && ask().is_break() {
            return Err(DerivativeError::Stopped {
                time: flow.clock().time(),
            });
        }
        recorder.mark(&flow);
        flow.step(end.time())?;
        recorder.record(&flow)?;
    }
    recorder.ended(&flow, start)
}

/// Runs with inputs that are held on each leg, and stores the steps.
fn plan<'s>(
    kernel: &'s dyn Kernel,
    h: f64,
    start: &StartData,
    names: &[&str],
    values: &[&[f64]],
) -> Result<AnyPath<'s>, DerivativeError> {
    let Some(first) = values.first() else {
        return Err(DerivativeError::NoLegs);
    };
    let shape = kernel.shape();
    for (count, constraints) in [
        (shape.kinematic, "kinematic"),
        (shape.nonholonomic, "nonholonomic"),
    ] {
        if count > 0 {
            return Err(DerivativeError::Constraints { constraints });
        }
    }
    let all = |values: &[f64]| -> Vec<f64> {
        let missing = core::iter::repeat(f64::NAN);
        values.iter().copied().chain(missing).take(names.len()).collect()
    };
    let mut own = values_of(kernel);
    let mut places = Vec::with_capacity(names.len());
    for (name, value) in names.iter().zip(all(first)) {
        let place = inputs::place(shape, name, value)?;
        if let Some(parameter) = own.get_mut(place) {
            *parameter = value;
        }
        places.push(place);
    }
    let mut flow = Discrete::new(kernel, own, h, start).map_err(RunError::from)?;
    let mut recorder = Recorder::new(&flow, values.len(), usize::MAX);
    for leg in 1..=values.len() {
        if let Some(values) = values.get(leg) {
            for (name, value) in names.iter().zip(all(values)) {
                (&mut flow as &mut dyn Run).set_input(name, value)?;
            }
            recorder.stretches.push(stretch(leg, &flow));
        }
        flow.step(f64::INFINITY * h)?;
        recorder.record(&flow)?;
    }
    let mut path = recorder.ended(&flow, start)?;
    path.recording.inputs = places;
    Ok(path)
}

/// Stores the steps of a flow.
struct Recorder<'s> {
    /// The start.
    computed_start: ComputedStart,
    /// The increment to the second node.
    increment: Vec<f64>,
    /// The continuous motion there.
    accelerated: Option<ContinuousSolution>,
    /// The stretches of constant inputs.
    stretches: Vec<Stretch>,
    /// The jumps of the acceleration, each argument once.
    jumps: Vec<JumpInTime>,
    /// The number of coordinates, and the number of unknowns of a step.
    sizes: [usize; 2],
    /// The number of steps for which there is memory.
    window: usize,
    /// The number of steps.
    length: usize,
    /// The recorded steps: all, or those from the last checkpoint on.
    record: RecordedSteps,
    /// The states from which the other steps are computed again.
    checkpoints: Checkpoints<'s>,
}

impl<'s> Recorder<'s> {
    /// A recorder without steps yet, of a flow that is to take `count`.
    fn new(flow: &Discrete<'s>, count: usize, memory: usize) -> Self {
        let computed_start = flow.computed_start.clone();
        let ComputedStart { q0, v0, a0, t0, .. } = &computed_start;
        let near = a0.as_deref().or(computed_start.near.as_deref());
        let found = start::acceleration(&flow.declaration(), (*t0, q0, v0), near).ok();
        let accelerated = found.map(|(a, multipliers)| ContinuousSolution {
            a: a.to_vec(),
            multipliers: multipliers.to_vec(),
        });
        let shape = flow.shape();
        let sizes = [shape.increments, shape.unknowns];
        let state = size_of::<Discrete>() + size_of::<f64>() * flow.run_state.numbers();
        let checkpoints = Checkpoints::new(count, [RecordedSteps::bytes(sizes), state], memory);
        let window = count.min(checkpoints.every);
        Self {
            computed_start,
            increment: flow.run_state.vectors.increment().to_vec(),
            accelerated,
            stretches: vec![stretch(0, flow)],
            jumps: Vec::new(),
            sizes,
            window,
            length: 0,
            record: RecordedSteps::from(1, window, sizes),
            checkpoints,
        }
    }

    /// Stores the state of the flow if a checkpoint is due.
    #[inline]
    fn mark(&mut self, flow: &Discrete<'s>) {
        if self.checkpoints.record(flow, self.length) && self.length > 0 {
            self.record = RecordedSteps::from(self.length + 1, self.window, self.sizes);
        }
    }

    /// Stores the last step of the flow.
    #[inline]
    fn record(&mut self, flow: &Discrete<'s>) -> Result<(), DerivativeError> {
        if matches!(flow.run_state.report.stop, Stop::Jump | Stop::Sticks) || flow.has_sides() {
            let index = self.length + 1;
            let time = flow.clock().time();
            return Err(DerivativeError::Jump { index, time });
        }
        for &argument in flow.jumped() {
            if !self.jumps.iter().any(|known| known.argument == argument) {
                self.jumps.push(JumpInTime::of(flow, argument, self.length + 1)?);
            }
        }
        record_last(&mut self.record, flow);
        self.length += 1;
        Ok(())
    }

    /// The path up to the last node of the flow.
    fn ended(self, flow: &Discrete<'s>, start: &StartData) -> Result<AnyPath<'s>, DerivativeError> {
        let h = flow.run_state.h;
        if self.length == 0 {
            return Err(DerivativeError::NoSteps { h });
        }
        let ComputedStart { q0, v0, a0, t0, .. } = self.computed_start;
        let mut end = OwnedNode::new(q0.len());
        end.take(flow);
        Ok(AnyPath {
            recording: Recording {
                source: flow.kernel,
                h,
                first: AppliedStart {
                    order: start.order(),
                    t0,
                    q0: q0.to_vec(),
                    v0: v0.to_vec(),
                    a0: a0.map(|a0| a0.to_vec()),
                    d: self.increment,
                    given: start.moved_from().map(|[mut q, v]| {
                        rotation::unit(&flow.shape().rotations, &mut q);
                        [q, v]
                    }),
                },
                accelerated: self.accelerated,
                stretches: self.stretches,
                jumps: self.jumps,
                inputs: Vec::new(),
                length: self.length,
                record: self.record,
                checkpoints: self.checkpoints,
            },
            end,
        })
    }
}

/// The stretch of a path that begins at a node, with the parameters of a flow.
fn stretch(from: usize, flow: &Discrete<'_>) -> Stretch {
    Stretch {
        from,
        values: flow.values.clone(),
    }
}

/// The index of a parameter.
pub(crate) fn parameter(name: &str, parameters: &[Quantity]) -> Result<usize, DerivativeError> {
    let place = parameters.iter().position(|known| known.name == name);
    place.ok_or_else(|| DerivativeError::Parameter {
        name: name.to_owned(),
        known: parameters.iter().map(|known| known.name.clone()).collect(),
    })
}
