//! A declaration as data, from which an engine runs it without a compiler.

use super::facts::Facts;
use super::tape::TapeWithCalls;
use crate::mechanics::Symmetry;
use crate::model::{Model, unraw};
use crate::passes::sparse::Order;

/// A declaration as data, from [`Model::data`]. `dsocs_core::Shape` explains the counts and kinds,
/// `dsocs_core::tape` the bytes of the tape.
#[expect(
    clippy::struct_excessive_bools,
    reason = "facts that do not depend on each other"
)]
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    /// The tape of operations.
    pub tape: Vec<u8>,
    /// The functions and numbers that the tape calls, in the order of their numbers.
    pub calls: Vec<Call>,
    /// The name of the system, and its documentation.
    pub itself: Quantity,
    /// The declaration as text: the body of the attribute.
    pub declaration: String,
    /// The coordinates.
    pub coordinates: Vec<Quantity>,
    /// The parameters that are numbers.
    pub parameters: Vec<Quantity>,
    /// The other parameters, each with its type in place of the documentation.
    pub others: Vec<Quantity>,
    /// The observed expressions.
    pub observables: Vec<Quantity>,
    /// The number of unknowns of a step.
    pub unknowns: usize,
    /// The number of unknowns of the continuous system.
    pub motion: usize,
    /// The number of values known when a run begins.
    pub constants: usize,
    /// The number of values known when a step begins.
    pub known: usize,
    /// The highest order of a derivative in the constraints, at least 2.
    pub order: usize,
    /// The number of holonomic constraints.
    pub holonomic: usize,
    /// The number of nonholonomic constraints.
    pub nonholonomic: usize,
    /// The number of kinematic constraints.
    pub kinematic: usize,
    /// The number of one-forms of constraint forces that are known.
    pub forms: usize,
    /// The indices of the constraints of third order among all constraints.
    pub third_order: Vec<usize>,
    /// The index of the first of the four coordinates of each rotation.
    pub rotations: Vec<usize>,
    /// The indices of the parameters that holonomic constraints depend on.
    pub of_positions: Vec<usize>,
    /// The indices of the parameters inside a `dot(…)`.
    pub of_rates: Vec<usize>,
    /// Whether any expression depends on time.
    pub depends_on_time: bool,
    /// Whether external forces act.
    pub external_forces: bool,
    /// Whether the rows of a step are affine in the unknowns.
    pub linear: bool,
    /// Whether a row may jump when an unknown changes.
    pub jumps: bool,
    /// Whether a row has a `signum` or a comparison that depends on positions or velocities.
    pub piecewise: bool,
    /// Whether a switch or a pole depends on the motion or the time.
    pub switches: bool,
    /// Whether a row has a factor that is not a number.
    pub scaled: bool,
    /// Whether the declaration has a factor to be divided out of a row.
    pub divided: bool,
    /// Whether steps of different lengths can be composed, or why not.
    pub symmetry: Symmetry,
    /// The Jacobian's entries that are not identically zero, and the pivots, by row and column, if the
    /// elimination is sparse.
    pub sparse: Option<[Vec<[usize; 2]>; 2]>,
}

/// A name with its documentation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// The name.
    pub name: String,
    /// The documentation in one line.
    pub doc: String,
}

/// A call of a tape: a function or a number that is no operation.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Call {
    /// A number.
    Number(f64),
    /// A derivative of a table of samples at its one argument; of order 0 its value.
    Samples {
        /// The name of the table's parameter.
        name: String,
        /// The order of the derivative.
        derivative: usize,
    },
    /// An expression that needs a compiler, as it is written in Rust.
    Rust(String),
}

/// A name with its documentation.
fn quantity(name: impl Into<String>, doc: &str) -> Quantity {
    Quantity {
        name: name.into(),
        doc: doc.to_owned(),
    }
}

impl Data {
    /// The data of a declaration from its facts and its tape.
    pub(crate) fn new(model: &Model, facts: Facts, tape: TapeWithCalls, sparse: Option<Order>) -> Self {
        let docs = &model.docs;
        let coordinates = model.coordinates.iter().zip(&docs.coordinates);
        let observables = model.observe.iter().zip(&docs.observe);
        let parameters = model.parameters.iter();
        let others = model.others.iter();
        Self {
            calls: tape.calls.data(&model.graph),
            tape: tape.bytes,
            itself: quantity(model.name(), &docs.system),
            declaration: model.text.clone(),
            coordinates: coordinates
                .map(|(name, doc)| quantity(unraw(name), doc))
                .collect(),
            parameters: parameters
                .map(|field| quantity(&field.name, &field.doc))
                .collect(),
            others: others.map(|(name, ty)| quantity(name, ty)).collect(),
            observables: observables
                .map(|((name, _), doc)| quantity(unraw(name), doc))
                .collect(),
            unknowns: facts.unknowns,
            motion: facts.motion,
            constants: facts.constants,
            known: facts.known,
            order: facts.order,
            holonomic: facts.holonomic,
            nonholonomic: facts.nonholonomic,
            kinematic: facts.kinematic,
            forms: facts.forms,
            third_order: facts.third_order,
            rotations: facts.rotations,
            of_positions: facts.of_positions,
            of_rates: facts.of_rates,
            depends_on_time: facts.depends_on_time,
            external_forces: facts.external_forces,
            linear: facts.linear,
            jumps: facts.jumps,
            piecewise: facts.piecewise,
            switches: facts.switches,
            scaled: facts.scaled,
            divided: facts.divided,
            symmetry: facts.symmetry,
            sparse: sparse.map(|order| [order.entries, order.pivots]),
        }
    }
}
