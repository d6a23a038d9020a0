//! A declaration as data: what an engine runs it from that no compiler has seen.

use super::cold::Cold;
use super::facts::Facts;
use crate::mechanics::Symmetry;
use crate::model::{Model, plain};
use crate::passes::sparse::Order;

/// A declaration as data, from [`Model::data`]. `dsocs_core::Shape` says what the counts and kinds are, `dsocs_core::tape` what the bytes of the tape.
#[expect(
    clippy::struct_excessive_bools,
    reason = "facts that do not depend on each other"
)]
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    /// The operations of the declaration.
    pub tape: Vec<u8>,
    /// The functions and numbers that the tape asks for, by their places.
    pub calls: Vec<Call>,
    /// The name of the system and its documentation.
    pub itself: Quantity,
    /// The declaration as text: the body of the attribute.
    pub declaration: String,
    /// The coordinates.
    pub coordinates: Vec<Quantity>,
    /// The parameters that are numbers.
    pub parameters: Vec<Quantity>,
    /// The other parameters, each with its type in the place of the documentation.
    pub others: Vec<Quantity>,
    /// The observed expressions.
    pub observables: Vec<Quantity>,
    /// How many unknowns a step has.
    pub unknowns: usize,
    /// How many the continuous system has.
    pub motion: usize,
    /// How many values are known when a run begins.
    pub constants: usize,
    /// How many are known when a step begins.
    pub known: usize,
    /// The highest order of a derivative in a constraint, and at least 2.
    pub order: usize,
    /// How many holonomic constraints there are.
    pub holonomic: usize,
    /// How many nonholonomic constraints.
    pub nonholonomic: usize,
    /// How many kinematic constraints.
    pub kinematic: usize,
    /// How many one-forms of constraint forces are known.
    pub forms: usize,
    /// The places of the constraints of third order among all constraints.
    pub third_order: Vec<usize>,
    /// The first of the four places of each coordinate that is a rotation.
    pub rotations: Vec<usize>,
    /// The places of the parameters that holonomic constraints depend on.
    pub of_positions: Vec<usize>,
    /// The places of the parameters inside a `dot(…)`.
    pub of_rates: Vec<usize>,
    /// Whether any expression depends on time.
    pub depends_on_time: bool,
    /// Whether external forces act.
    pub external_forces: bool,
    /// Whether the rows of a step are affine in the unknowns.
    pub linear: bool,
    /// Whether a row may jump where an unknown changes.
    pub jumps: bool,
    /// Whether a row has a `signum` or a comparison that positions or velocities decide.
    pub piecewise: bool,
    /// Whether anything is given by pieces or divided by what may be zero, as the motion or the time decides.
    pub switches: bool,
    /// Whether rows were multiplied by more than a number.
    pub scaled: bool,
    /// Whether the declaration names a factor to be divided out of a row.
    pub divided: bool,
    /// Whether steps of different lengths can be composed, or why not.
    pub symmetry: Symmetry,
    /// Row and column of the entries of the Jacobian that are not zero everywhere, and of the pivots, where most are zero.
    pub sparse: Option<[Vec<[usize; 2]>; 2]>,
}

/// A name and what is said of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// The name.
    pub name: String,
    /// The documentation in one line.
    pub doc: String,
}

/// What a tape asks for beside its operations.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Call {
    /// A number.
    Number(f64),
    /// The derivative of some order of a table of samples at its one argument; of order 0 its value.
    Samples {
        /// The name of the parameter.
        name: String,
        /// The order.
        derivative: usize,
    },
    /// Something that only a compiler can make sense of, as it is written.
    Rust(String),
}

/// A quantity.
fn quantity(name: impl Into<String>, doc: &str) -> Quantity {
    Quantity {
        name: name.into(),
        doc: doc.to_owned(),
    }
}

impl Data {
    /// The data of a declaration from its facts and its tape.
    pub(super) fn new(model: &Model, facts: Facts, cold: Cold, sparse: Option<Order>) -> Self {
        let docs = &model.docs;
        let coordinates = model.coordinates.iter().zip(&docs.coordinates);
        let observables = model.observe.iter().zip(&docs.observe);
        let parameters = model.parameters.iter();
        let others = model.others.iter();
        Self {
            calls: cold.calls.asked(&model.graph),
            tape: cold.bytes,
            itself: quantity(model.name(), &docs.system),
            declaration: model.text.clone(),
            coordinates: coordinates
                .map(|(name, doc)| quantity(plain(name), doc))
                .collect(),
            parameters: parameters
                .map(|field| quantity(&field.name, &field.doc))
                .collect(),
            others: others.map(|(name, ty)| quantity(name, ty)).collect(),
            observables: observables
                .map(|((name, _), doc)| quantity(plain(name), doc))
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
