//! A kernel that was not compiled: a declaration's tape, walked.

use core::fmt;
use std::sync::{Arc, OnceLock};

use thiserror::Error;

use super::{At, Kernel};
use crate::kernel::course::Course;
use crate::kernel::question::{Halt, Question};
use crate::kernel::report::NodeMut;
use crate::kernel::series::Series;
use crate::number::dual::Dual;
use crate::number::point::{AnyLeg, copy};
use crate::number::tangent::Tangent;
use crate::solve::sparse::Sparse;
use crate::tape::Shape;
use crate::tape::{Leaf, Number as _, Part, Program, Segment, Source, Tape, TapeCall};

/// A declared system as its tape and its shape alone: what a declaration becomes that is read at run time.
///
/// It does the same operations in the same order as the code that the attribute writes for the declaration, and so gives the same bits. A
/// step takes several times as long.
#[derive(Clone, Debug)]
pub struct TapeKernel {
    tape: Arc<Tape>,
    shape: Shape,
    /// The values of the parameters, where a run holds no others.
    values: Vec<f64>,
    sparse: Option<Sparse>,
    /// What the tape calls, which is data.
    calls: Vec<TapeCall>,
    hot: Arc<Hot>,
    series: Arc<Recurrences>,
}

/// The recurrences of Taylor series, which are made when they are asked for.
#[derive(Default)]
struct Recurrences {
    made: OnceLock<Option<Arc<Series>>>,
    make: Option<Box<Make>>,
}

/// What makes recurrences.
type Make = dyn Fn() -> Option<Series> + Send + Sync;

impl fmt::Debug for Recurrences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Recurrences").field(&self.made).finish()
    }
}

/// Why a tape and a shape make no system.
#[derive(Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TapeError {
    /// The tape and the shape belong to different declarations, or the tape is malformed.
    #[error("the tape has {found} {what}, and the shape says {expected}")]
    Count {
        /// What is counted.
        what: &'static str,
        /// How many the tape has.
        found: usize,
        /// How many the shape says.
        expected: usize,
    },
    /// The declaration calls functions that only a compiled system has.
    #[error(
        "the tape calls functions of the user's, or reads parameters that are no numbers: only a compiled system has them"
    )]
    Functions,
}

crate::debug_is_message!(TapeError);

/// What is evaluated often. Each program reads what was computed before from the slices that it is handed.
#[derive(Debug)]
struct Hot {
    constants: Program,
    known: Program,
    /// The rows, then their Jacobian row by row.
    residual: Program,
    /// The rows, then the entries of a sparse Jacobian.
    entries: Program,
    scales: Program,
    unknown: Program,
    second_difference: Program,
    /// Position, velocity, acceleration, time and constraint force.
    node: Program,
    energy: Program,
}

impl Hot {
    fn new(tape: &Tape, unknowns: usize, sparse: Option<&Sparse>) -> Self {
        let program = |segment, given: &[Segment]| {
            let all: Vec<usize> = (0..tape.count(segment, Part::All)).collect();
            tape.later(segment, &all, given)
        };
        let both = [Segment::Constants, Segment::Known];
        let entries = sparse.map(|sparse| {
            let places = sparse.places().iter().map(|place| place.map(usize::from));
            let entries = places.map(|[row, column]| unknowns * (1 + row) + column);
            let wanted: Vec<usize> = (0..unknowns).chain(entries).collect();
            tape.later(Segment::Residual, &wanted, &both)
        });
        Self {
            constants: program(Segment::Constants, &[]),
            known: program(Segment::Known, &both[..1]),
            residual: program(Segment::Residual, &both),
            entries: entries.unwrap_or_default(),
            scales: program(Segment::Scales, &both),
            unknown: program(Segment::Unknown, &[]),
            second_difference: program(Segment::SecondDifference, &both),
            node: program(Segment::Node, &both[..1]),
            energy: program(Segment::Energy, &both[..1]),
        }
    }
}

impl TapeKernel {
    /// Sets a parameter, by its place among [`Shape::parameters`].
    pub fn parameter_mut(&mut self, index: usize) -> Option<&mut f64> {
        self.values.get_mut(index)
    }

    /// The system of a tape. `values` are those of the parameters; missing ones are NaN.
    ///
    /// # Errors
    ///
    /// [`TapeError`] if the tape and the shape do not fit together, or if the tape calls functions.
    pub fn new(tape: Tape, shape: Shape, values: Vec<f64>) -> Result<Self, TapeError> {
        Self::with_calls(tape, shape, values, Vec::new())
    }

    /// The same of a tape that calls numbers and tables of samples.
    ///
    /// # Errors
    ///
    /// [`TapeError`] as [`TapeKernel::new`], or if the tape calls more than `calls`.
    pub fn with_calls(
        tape: Tape,
        shape: Shape,
        values: Vec<f64>,
        calls: Vec<TapeCall>,
    ) -> Result<Self, TapeError> {
        if tape.calls() > calls.len() {
            return Err(TapeError::Functions);
        }
        let (n, m) = (shape.dimension(), shape.unknowns);
        let past = if shape.is_of_third_order() { n } else { 0 };
        let counts = [
            (
                "values that parameters decide",
                Segment::Constants,
                Part::All,
                shape.constants.saturating_sub(past),
            ),
            (
                "values that are known in a step",
                Segment::Known,
                Part::All,
                shape.known,
            ),
            ("rows of a step", Segment::Residual, Part::Head, m),
            (
                "entries of a Jacobian",
                Segment::Residual,
                Part::Tail,
                m.saturating_mul(m),
            ),
            ("unknowns", Segment::Unknown, Part::All, m),
            (
                "components of a second difference",
                Segment::SecondDifference,
                Part::All,
                n,
            ),
            ("components of a point", Segment::Node, Part::Head, 3 * n + 1),
            ("components of a force", Segment::Node, Part::Tail, n),
            ("energies", Segment::Energy, Part::All, 1),
            (
                "observed expressions",
                Segment::Observe,
                Part::All,
                shape.observables.len(),
            ),
        ];
        for (what, segment, part, expected) in counts {
            let found = tape.count(segment, part);
            if found != expected {
                return Err(TapeError::Count {
                    what,
                    found,
                    expected,
                });
            }
        }
        Ok(Self {
            hot: Arc::new(Hot::new(&tape, m, None)),
            tape: Arc::new(tape),
            shape,
            values,
            calls,
            sparse: None,
            series: Arc::default(),
        })
    }

    /// The same with Taylor series. Their recurrences are made when a method asks for them first.
    #[cfg_attr(not(feature = "text"), allow(dead_code))] // only what is read from a text has any
    pub(crate) fn with_series(self, make: impl Fn() -> Option<Series> + Send + Sync + 'static) -> Self {
        let series = Recurrences {
            made: OnceLock::new(),
            make: Some(Box::new(make)),
        };
        Self {
            series: Arc::new(series),
            ..self
        }
    }

    /// The recurrences of its Taylor series, if it has any.
    pub(crate) fn series(&self) -> Option<Arc<Series>> {
        let Recurrences { made, make } = &*self.series;
        let made = made.get_or_init(|| make.as_ref().and_then(|make| make()).map(Arc::new));
        made.clone()
    }

    /// The same with a Jacobian that is eliminated as a sparse matrix.
    ///
    /// # Errors
    ///
    /// [`TapeError`] if the matrix has another size.
    pub fn sparse(self, sparse: Sparse) -> Result<Self, TapeError> {
        let (found, expected) = (sparse.size(), self.shape.unknowns);
        if found != expected {
            let what = "rows of a sparse matrix";
            return Err(TapeError::Count {
                what,
                found,
                expected,
            });
        }
        Ok(Self {
            hot: Arc::new(Hot::new(&self.tape, expected, Some(&sparse))),
            sparse: Some(sparse),
            ..self
        })
    }

    /// Evaluates a program.
    fn walk(
        &self,
        program: &Program,
        leaf: &dyn Fn(Leaf) -> Option<f64>,
        result: &mut dyn FnMut(usize, f64),
    ) {
        let leaf = |which| leaf(which).unwrap_or(f64::NAN);
        f64::walk(program, self, &leaf, result);
    }

    /// Evaluates a program; as many results are written as there is room for.
    fn write(&self, program: &Program, leaf: &dyn Fn(Leaf) -> Option<f64>, out: &mut [f64]) {
        self.walk(program, leaf, &mut |place, value| {
            if let Some(out) = out.get_mut(place) {
                *out = value;
            }
        });
    }

    /// Evaluates a program; the results go to one slice and then to another.
    fn write_both(&self, program: &Program, at: At<'_>, first: &mut [f64], second: &mut [f64]) {
        self.walk(program, &|leaf| of_iteration(at, leaf), &mut |place, value| {
            let out = match place.checked_sub(first.len()) {
                None => first.get_mut(place),
                Some(place) => second.get_mut(place),
            };
            if let Some(out) = out {
                *out = value;
            }
        });
    }

    /// Where the second difference of a step of third order begins among the constants.
    fn place_of_past(&self) -> usize {
        self.tape.count(Segment::Constants, Part::All)
    }

    /// What a step begins with.
    fn of_leg(&self, constants: &[f64], leg: AnyLeg<'_, f64>, which: Leaf) -> Option<f64> {
        match which {
            Leaf::Constant(i) => constants.get(i).copied(),
            Leaf::Clock => Some(leg.t),
            Leaf::N(i) => leg.q.get(i).copied(),
            Leaf::D(i) => leg.d.get(i).copied(),
            Leaf::P(i) => constants.get(self.place_of_past() + i).copied(),
            _ => None,
        }
    }
}

/// What an iteration knows.
fn of_iteration(at: At<'_>, which: Leaf) -> Option<f64> {
    let (values, i) = match which {
        Leaf::Constant(i) => (at.constants, i),
        Leaf::Known(i) => (at.known, i),
        Leaf::Z(i) => (at.z, i),
        _ => return None,
    };
    values.get(i).copied()
}

impl Source for TapeKernel {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn tape(&self) -> &Tape {
        &self.tape
    }

    fn value(&self, parameter: usize) -> f64 {
        self.values.get(parameter).copied().unwrap_or(f64::NAN)
    }

    fn call(&self, which: usize, arguments: &[f64]) -> f64 {
        let call = self.calls.get(which);
        call.map_or(f64::NAN, |call| call.value(arguments.first().copied()))
    }

    fn call_dual(&self, which: usize, arguments: &[Dual<f64>]) -> Dual<f64> {
        let argument = arguments
            .first()
            .map(|argument| Tangent::new(argument.re, argument.eps));
        let value = self.calls.get(which).map(|call| call.value(argument));
        value.map_or(Dual::new(f64::NAN, f64::NAN), |value| {
            Dual::new(value.value(), value.derivative())
        })
    }

    fn data(&self, which: usize) -> Option<&TapeCall> {
        self.calls.get(which)
    }
}

impl Kernel for TapeKernel {
    /// Every step is made on slices.
    fn smooth(&self, _: &mut Course, count: u64) -> Halt {
        if count == 0 {
            Halt::Done
        } else {
            Halt::Asks(Question::Interpreted)
        }
    }

    fn constants(&self, parameters: &[f64], h: f64, constants: &mut [f64]) {
        // the last second difference is not known yet
        if let Some(past) = constants.get_mut(self.place_of_past()..) {
            past.fill(0.0);
        }
        let leaf = |which| match which {
            Leaf::H => Some(h),
            Leaf::Parameter(i) => parameters.get(i).copied(),
            _ => None,
        };
        self.write(&self.hot.constants, &leaf, constants);
    }

    fn remember(&self, constants: &mut [f64], past: &[f64]) {
        let places = constants.iter_mut().skip(self.place_of_past());
        for (out, &past) in places.zip(past) {
            *out = past;
        }
    }

    fn past(&self, constants: &[f64], past: &mut [f64]) {
        let known = constants.iter().skip(self.place_of_past());
        let known = known.copied().chain(core::iter::repeat(0.0));
        for (out, known) in past.iter_mut().zip(known) {
            *out = known;
        }
    }

    fn known(&self, constants: &[f64], leg: AnyLeg<'_, f64>, known: &mut [f64]) {
        self.write(
            &self.hot.known,
            &|which| self.of_leg(constants, leg, which),
            known,
        );
    }

    fn linearize(&self, at: At<'_>, rows: &mut [f64], jacobian: &mut [f64]) {
        self.write_both(&self.hot.residual, at, rows, jacobian);
    }

    fn sparse(&self) -> Option<&Sparse> {
        self.sparse.as_ref()
    }

    fn entries(&self, at: At<'_>, rows: &mut [f64], entries: &mut [f64]) {
        if self.sparse.is_some() {
            self.write_both(&self.hot.entries, at, rows, entries);
        }
    }

    fn scales(&self, at: At<'_>, scales: &mut [f64]) {
        scales.fill(1.0);
        if self.shape.scaled {
            self.write(&self.hot.scales, &|which| of_iteration(at, which), scales);
        }
    }

    fn unknown(&self, e: &[f64], multipliers: &[f64], z: &mut [f64]) {
        let leaf = |which| match which {
            Leaf::E(i) => e.get(i).copied(),
            // missing ones are zero
            Leaf::Lambda(i) => Some(multipliers.get(i).copied().unwrap_or(0.0)),
            _ => None,
        };
        self.write(&self.hot.unknown, &leaf, z);
    }

    fn second_difference(&self, at: At<'_>, e: &mut [f64]) {
        self.write(&self.hot.second_difference, &|which| of_iteration(at, which), e);
    }

    fn report(&self, course: &Course, mut node: NodeMut<'_>) {
        let n = self.shape.dimension();
        let (leg, e) = (course.solved_leg(), course.vectors.e());
        // as it was before the step
        let mut constants = course.constants.clone();
        self.remember(&mut constants, course.vectors.before());
        let leaf = |which| match which {
            Leaf::E(i) => e.get(i).copied(),
            which => self.of_leg(&constants, leg, which),
        };
        let mut t = f64::NAN;
        let [q, v, a, force] = node.split();
        self.walk(&self.hot.node, &leaf, &mut |place, value| {
            let (out, first) = match place.checked_div(n).unwrap_or(3) {
                0 => (&mut *q, 0),
                1 => (&mut *v, n),
                2 => (&mut *a, 2 * n),
                _ if place == 3 * n => (core::slice::from_mut(&mut t), 3 * n),
                _ => (&mut *force, 3 * n + 1),
            };
            if let Some(out) = out.get_mut(place - first) {
                *out = value;
            }
        });
        let leaf = |which| match which {
            Leaf::Constant(i) => constants.get(i).copied(),
            Leaf::T => Some(t),
            Leaf::Q(i) => q.get(i).copied(),
            Leaf::V(i) => v.get(i).copied(),
            _ => None,
        };
        let mut energy = f64::NAN;
        self.write(&self.hot.energy, &leaf, core::slice::from_mut(&mut energy));
        // the node is the one between the legs, whatever the maps say
        copy(q, leg.q);
        node.scalars.energy = energy;
    }
}
