//! The steps of a path, for any system, from which derivatives are computed.

use std::borrow::Cow;

use super::block::{Equations, Fixed, Rooms, Steps};
use super::changed::{DerivativesAtChange, StepAcrossChange};
use super::error::DerivativeError;
use super::memory::{Checkpoints, RecordedSteps};
use super::start::{AppliedStart, ContinuousSolution, StartDerivatives};
use crate::flow::discrete::Discrete;
use crate::kernel::clock::Clock;
use crate::regularity::undefined;
use crate::tape::declaration::Declaration;
use crate::tape::quantity::Quantity;
use crate::tape::{Eight, Leaf, Source};

/// A stretch of a path with constant inputs.
pub(super) struct Stretch {
    /// The number of the node at which it begins.
    pub from: usize,
    /// The values of the parameters.
    pub values: Vec<f64>,
}

/// A jump of the acceleration at a time that the motion does not move.
pub(super) struct JumpInTime {
    /// The number of the argument that is zero there.
    pub argument: usize,
    /// The parameters that move it, by their indices.
    pub parameters: Vec<usize>,
    /// The error of a derivative by one of them.
    pub error: DerivativeError,
}

impl JumpInTime {
    /// The jump in the last step of a flow, about the node `index`.
    ///
    /// # Errors
    ///
    /// [`DerivativeError::MovingJump`] if its place depends on the motion.
    pub fn of(flow: &Discrete<'_>, argument: usize, index: usize) -> Result<Self, DerivativeError> {
        let declaration = flow.declaration();
        let found = declaration.argument(argument, &|leaf| undefined::named(&declaration, leaf));
        let (text, leaves) = found.map_or_else(Default::default, |found| (found.text, found.leaves));
        let jump = |others| DerivativeError::MovingJump {
            argument: text.clone(),
            index,
            time: Clock::even(flow.computed_start.t0, flow.run_state.h).time_of(index as u64),
            others,
        };
        let parameter = |leaf: &Leaf| match leaf {
            Leaf::Parameter(place) => Some(*place),
            _ => None,
        };
        if leaves
            .iter()
            .any(|(leaf, _)| !matches!(leaf, Leaf::T | Leaf::Parameter(_)))
        {
            return Err(jump(""));
        }
        Ok(Self {
            argument,
            parameters: leaves.iter().filter_map(|(leaf, _)| parameter(leaf)).collect(),
            error: jump("; the tangents by other variables are those of the motion"),
        })
    }
}

/// The steps of a path.
pub(super) struct Recording<'s> {
    /// The system, for its tape and the user's functions.
    pub source: &'s dyn Source,
    /// The step.
    pub h: f64,
    /// The start.
    pub first: AppliedStart,
    /// The continuous motion there; `None` if it cannot be computed.
    pub accelerated: Option<ContinuousSolution>,
    /// The stretches of constant inputs; the first begins with the start.
    pub stretches: Vec<Stretch>,
    /// The jumps of the acceleration, each argument once.
    pub jumps: Vec<JumpInTime>,
    /// The inputs, as indices of parameters.
    pub inputs: Vec<usize>,
    /// The number of steps.
    pub length: usize,
    /// The recorded steps: all, or those from the last checkpoint on.
    pub record: RecordedSteps,
    /// The states from which the other steps are computed again.
    pub checkpoints: Checkpoints<'s>,
}

impl Recording<'_> {
    /// The parameters.
    pub fn parameters(&self) -> &[Quantity] {
        &self.source.shape().parameters
    }

    /// The first places of rotations.
    pub fn rotations(&self) -> &[usize] {
        &self.source.shape().rotations
    }

    /// The inputs of a plan, in its order, by their names.
    pub fn input_names(&self) -> Vec<Cow<'static, str>> {
        self.inputs
            .iter()
            .filter_map(|&place| Some(self.parameters().get(place)?.name.clone()))
            .collect()
    }

    /// The number of legs with inputs of their own.
    pub fn legs(&self) -> usize {
        if self.inputs.is_empty() {
            0
        } else {
            self.stretches.len()
        }
    }

    /// Whether there is a derivative by a parameter: not if it moves a jump of the acceleration.
    pub fn has_derivative_by(&self, parameter: usize) -> Result<(), DerivativeError> {
        let moves = |jump: &&JumpInTime| jump.parameters.contains(&parameter);
        let jump = self.jumps.iter().find(moves);
        jump.map_or(Ok(()), |jump| Err(jump.error.clone()))
    }

    /// The data from which derivatives are computed.
    pub fn motion(&self) -> Result<Motion<'_>, DerivativeError> {
        let stretches: Vec<(usize, Declaration<'_>)> = (self.stretches.iter())
            .map(|stretch| {
                let own = Declaration::of(self.source).with(&stretch.values);
                (stretch.from, own)
            })
            .collect();
        let own = stretches
            .first()
            .map_or(Declaration::of(self.source), |own| own.1);
        Ok(Motion {
            recording: self,
            at_start: StartDerivatives::new(&own, self.h, &self.first, self.accelerated.as_ref())?,
            equations: Equations::new(
                self.source.tape(),
                own.dimension(),
                self.parameters().len(),
                self.rotations(),
            ),
            stretches,
        })
    }
}

/// The steps of a path with the derivatives of its system.
pub(super) struct Motion<'p> {
    pub recording: &'p Recording<'p>,
    pub at_start: StartDerivatives,
    /// The stretches, by the nodes at which they begin.
    stretches: Vec<(usize, Declaration<'p>)>,
    pub equations: Equations,
}

/// Consecutive steps of a path, all after one checkpoint.
pub(super) type Window<'p> = Cow<'p, RecordedSteps>;

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
    /// The number of its first step, the number of steps, and their stretch.
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

impl<'p> Motion<'p> {
    /// The number of coordinates.
    pub fn dimension(&self) -> usize {
        self.equations.coordinates
    }

    /// The number of stretches.
    pub fn stretches(&self) -> usize {
        self.stretches.len()
    }

    /// The declaration on a stretch.
    pub fn declaration(&self, stretch: usize) -> &Declaration<'p> {
        &self.stretches[stretch].1
    }

    /// The number of windows.
    pub fn windows(&self) -> usize {
        self.recording.length.div_ceil(self.recording.checkpoints.every)
    }

    /// The steps of a window.
    ///
    /// # Errors
    ///
    /// An error only if a step that was solved in the run fails when it is solved again.
    pub fn window(&self, window: usize) -> Result<Window<'p>, DerivativeError> {
        if window + 1 == self.windows() {
            return Ok(Cow::Borrowed(&self.recording.record));
        }
        let Recording {
            length, checkpoints, ..
        } = self.recording;
        let sizes = [self.dimension(), self.equations.rows];
        Ok(Cow::Owned(checkpoints.again(window, *length, sizes)?))
    }

    /// The pieces of a window, in order.
    pub fn pieces(&self, window: &RecordedSteps) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for (stretch, (from, _)) in self.stretches.iter().enumerate() {
            let next = self
                .stretches
                .get(stretch + 1)
                .map_or(self.recording.length + 1, |next| next.0);
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
        first + count > self.recording.length
    }

    /// Prepares the steps of a stretch; returns the values of its constants and parameters.
    pub fn enter(&self, stretch: usize, rooms: &mut Rooms) -> Fixed {
        let h = self.recording.h;
        let fixed = self.equations.fixed(self.declaration(stretch), h, rooms);
        self.equations.enter(&fixed, h, rooms);
        fixed
    }

    /// The steps of a piece of a window.
    pub fn some<'w>(&'w self, window: &'w RecordedSteps, piece: &Piece) -> Steps<'w> {
        let (first, count, stretch) = piece.steps();
        Steps {
            declaration: *self.declaration(stretch),
            recorded: window.steps(first..first + count),
        }
    }

    /// The derivatives of the step at which the parameters change.
    pub fn changed(
        &self,
        window: &RecordedSteps,
        at: usize,
        stretch: usize,
    ) -> Result<DerivativesAtChange, DerivativeError> {
        let (leg, e) = window.steps(at..at + 1).first();
        let change = StepAcrossChange {
            sides: [*self.declaration(stretch - 1), *self.declaration(stretch)],
            h: self.recording.h,
            leg,
            e,
        };
        change
            .changed(self.equations.parameters)
            .ok_or_else(|| self.singular(at))
    }

    /// The step at which parameters change, with the old values on both sides.
    pub fn arriving(
        &self,
        window: &RecordedSteps,
        at: usize,
        changed: &DerivativesAtChange,
    ) -> RecordedSteps {
        let (leg, _) = window.steps(at..at + 1).first();
        let mut record = RecordedSteps::from(at, 1, [self.dimension(), self.equations.rows]);
        let step = [leg.q, leg.d, &changed.arriving[..]].concat();
        record.push(leg.t, &step, &vec![0.0; self.equations.rows]);
        record
    }

    /// The time of a node.
    pub fn time(&self, index: usize) -> f64 {
        Clock::even(self.recording.first.t0, self.recording.h).time_of(index as u64)
    }

    /// The error of a step that cannot be differentiated.
    pub fn singular(&self, index: usize) -> DerivativeError {
        DerivativeError::Singular {
            index,
            time: self.time(index),
        }
    }
}
