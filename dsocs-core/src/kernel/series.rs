//! The recurrences of Taylor series as data, for systems that were not compiled.
//!
//! # The format
//!
//! The front end writes the bytes and nobody else reads them: they belong to one version of this crate. They begin
//! with [`VERSION`]. Whole numbers are unsigned LEB128, as on a [`Tape`]. Then come
//!
//! - the factors that are numbers: their count, and eight bytes for each, little-endian;
//! - the numbers of coordinates and of multipliers, whether the rows are affine in the accelerations, whether inner
//!   sums leave out their newest terms, and the number of factors of the parameters ([`Series::constants`]);
//! - the numbers of inner sums of products, of inner sums of squares, of switches and of calls of functions, and the
//!   names of the last two, each with its length in bytes;
//! - the number of sequences, and the operation of each: a [`Code`], the lists that contain it ([`LASTING`],
//!   [`ACCELERATED`], [`AGAIN`]), the sequences that it reads, its switch plus one (0 for none) if it may have one,
//!   and if it lasts its inner sums, `2 i` for a product and `2 i + 1` for a square. A factor is `2 i` for a number
//!   and `2 i + 1` for one of the parameters;
//! - the operands of the inner sums, `2 i` for a sequence and `2 i + 1` for `k` times it: two for a product, one for a
//!   square;
//! - the switches, each a kind with its sequences: 0 a sign; 1 the argument of a steep function; 2 the difference of two
//!   sequences; 3 and 4 the base of a power and its degree, in a divisor and elsewhere; 5, 6 and 7 a value that is not
//!   negative, or bounded by π/2 or by π;
//! - the sequences of the accelerations;
//! - the number of accelerations and multipliers that stay unknown, `2 i` or `2 i + 1` for each; the sequences of as
//!   many rows; and the entries of their Jacobian: their count, and row, column and sequence of each;
//! - the number of divisors whose sign may change, and their sequences.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use crate::series::orders::LANES;
use crate::tape::{MalformedTape, Reader, Tape, TapeCall};

/// The version of the format.
const VERSION: u8 = 4;

/// The operation is needed beyond order 0.
pub(crate) const LASTING: u8 = 1;
/// The operation depends on accelerations that are solved for numerically.
pub(crate) const ACCELERATED: u8 = 2;
/// The operation is evaluated again once these accelerations are known.
pub(crate) const AGAIN: u8 = 4;

/// Largest count that is read, so that malformed bytes cannot exhaust the memory.
const MOST: usize = 1 << 24;

/// The index of a sequence, a factor or a sum.
pub(crate) type Place = u32;

/// The kind of an operation, in the order of the bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Code {
    /// The time.
    Time,
    /// A coordinate.
    Position,
    /// A velocity.
    Velocity,
    /// An acceleration that is solved for.
    Acceleration,
    /// A multiplier.
    Multiplier,
    /// A factor that does not change in time.
    Constant,
    /// `constant + Σ coefficient · term`.
    Linear,
    /// `u v`.
    Product,
    /// `u²`.
    Square,
    /// `u / v`.
    Quotient,
    /// `1 / v`.
    Reciprocal,
    /// The square root.
    Root,
    /// The cube root.
    CubeRoot,
    /// `u^α`.
    Power,
    /// `eᵘ`.
    Exp,
    /// `eᵘ - 1`.
    ExpM1,
    /// The natural logarithm.
    Ln,
    /// `ln(1 + u)`.
    Ln1p,
    /// The sine, with its cosine after it.
    Sin,
    /// The cosine, with its sine before it.
    Cos,
    /// The hyperbolic sine, and its cosine.
    Sinh,
    /// The hyperbolic cosine, and its sine.
    Cosh,
    /// The tangent, and `1 + w²`.
    Tan,
    /// The hyperbolic tangent, and `1 - w²`.
    Tanh,
    /// `1 - u²`, of `u` and `u²`.
    Conjugate,
    /// The inverse sine, with the derivative of the inverted function.
    Asin,
    /// The inverse cosine, as [`Code::Asin`].
    Acos,
    /// The inverse tangent, as [`Code::Asin`].
    Atan,
    /// The inverse hyperbolic sine, as [`Code::Asin`].
    Asinh,
    /// The inverse hyperbolic cosine, as [`Code::Asin`].
    Acosh,
    /// The inverse hyperbolic tangent, as [`Code::Asin`].
    Atanh,
    /// `atan2(y, x)`, and `x² + y²`.
    Atan2,
    /// `|u|`.
    Abs,
    /// The sign.
    Signum,
    /// `if a < b { c } else { d }`.
    Less,
    /// `if a <= b { c } else { d }`.
    LessOrEqual,
    /// A table of samples.
    Call,
}

const CODES: [Code; 37] = [
    Code::Time,
    Code::Position,
    Code::Velocity,
    Code::Acceleration,
    Code::Multiplier,
    Code::Constant,
    Code::Linear,
    Code::Product,
    Code::Square,
    Code::Quotient,
    Code::Reciprocal,
    Code::Root,
    Code::CubeRoot,
    Code::Power,
    Code::Exp,
    Code::ExpM1,
    Code::Ln,
    Code::Ln1p,
    Code::Sin,
    Code::Cos,
    Code::Sinh,
    Code::Cosh,
    Code::Tan,
    Code::Tanh,
    Code::Conjugate,
    Code::Asin,
    Code::Acos,
    Code::Atan,
    Code::Asinh,
    Code::Acosh,
    Code::Atanh,
    Code::Atan2,
    Code::Abs,
    Code::Signum,
    Code::Less,
    Code::LessOrEqual,
    Code::Call,
];

impl Code {
    /// The numbers of sequences that it reads, and of its inner sums.
    fn counts(self) -> [usize; 2] {
        match self {
            Self::Time
            | Self::Position
            | Self::Velocity
            | Self::Acceleration
            | Self::Multiplier
            | Self::Constant
            | Self::Linear => [0, 0],
            Self::Product
            | Self::Quotient
            | Self::Sin
            | Self::Cos
            | Self::Sinh
            | Self::Cosh
            | Self::Tan
            | Self::Tanh
            | Self::Asin
            | Self::Acos
            | Self::Atan
            | Self::Asinh
            | Self::Acosh
            | Self::Atanh => [2, 1],
            Self::Square
            | Self::Reciprocal
            | Self::Root
            | Self::Exp
            | Self::ExpM1
            | Self::Ln
            | Self::Ln1p => [1, 1],
            Self::CubeRoot | Self::Power => [1, 2],
            Self::Conjugate => [2, 0],
            Self::Atan2 => [3, 3],
            // a call has one argument
            Self::Abs | Self::Signum | Self::Call => [1, 0],
            Self::Less | Self::LessOrEqual => [4, 0],
        }
    }

    /// Whether it may have a switch.
    fn may_switch(self) -> bool {
        matches!(self, Self::Abs | Self::Signum | Self::Less | Self::LessOrEqual)
    }
}

/// A term of a linear combination: the factor, and the sequence.
pub(crate) type Term = [Place; 2];

/// An operation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Operation {
    pub(crate) code: Code,
    /// The lists that contain it.
    pub(crate) lists: u8,
    /// The sequences that it reads.
    pub(crate) parts: [Place; 4],
    /// Its inner sums, products before squares, if it is in the list [`LASTING`].
    pub(crate) sums: [Place; 3],
    /// Its factor, the index of its leaf, or its table.
    pub(crate) index: Place,
    /// The constant of a sum.
    pub(crate) constant: Option<Place>,
    /// The index of its first term among all, and the number of its terms.
    pub(crate) terms: [Place; 2],
    /// Its switch, or its index among the calls.
    pub(crate) switch: Option<Place>,
}

/// The argument of a switch.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Argument {
    /// A sign.
    Sign(Place),
    /// The argument of a steep smooth function.
    Steep(Place),
    /// The base of a power of a high degree; the degree is negative in a divisor.
    Power(Place, i32),
    /// The value of a function, and the bound of its absolute value; a bound of zero says that it is not
    /// negative.
    Bounded(Place, f64),
    /// The first minus the second.
    Difference(Place, Place),
}

/// The recurrences of a system. All indices in it are valid.
#[derive(Debug)]
pub(crate) struct Series {
    /// The factors that are numbers; those of the parameters stand behind them.
    pub(crate) numbers: Vec<f64>,
    /// The factors of the parameters, as a tape.
    pub(crate) constants: Tape,
    /// The number of factors of the parameters.
    pub(crate) computed: usize,
    /// The calls of the tape and of the recurrences.
    pub(crate) calls: Vec<TapeCall>,
    pub(crate) coordinates: usize,
    pub(crate) multipliers: usize,
    pub(crate) affine: bool,
    pub(crate) eager: bool,
    /// The number of switches of the declaration; the other names are those of calls.
    pub(crate) switches: usize,
    pub(crate) names: Vec<Arc<str>>,
    pub(crate) operations: Vec<Operation>,
    pub(crate) terms: Vec<Term>,
    /// The operands of products: sequences, and whether they are rates.
    pub(crate) products: Vec<[(Place, bool); 2]>,
    pub(crate) squares: Vec<(Place, bool)>,
    pub(crate) arguments: Vec<Argument>,
    pub(crate) accelerations: Vec<Place>,
    /// The unknown ones: whether it is a multiplier, and its index.
    pub(crate) unknown: Vec<(bool, Place)>,
    pub(crate) rows: Vec<Place>,
    /// Row, column, and sequence.
    pub(crate) jacobian: Vec<[Place; 3]>,
    /// The divisors whose sign may change.
    pub(crate) divisors: Vec<Place>,
}

impl Series {
    /// Reads the recurrences from bytes, with a tape of the factors of the parameters, and the calls of both.
    ///
    /// # Errors
    ///
    /// [`MalformedTape`] if the bytes break the format.
    #[cfg_attr(not(feature = "text"), allow(dead_code))] // only systems read from a text have series
    pub(crate) fn new(bytes: &[u8], constants: Vec<u8>, calls: Vec<TapeCall>) -> Result<Self, MalformedTape> {
        let constants = Tape::owned(constants)?;
        if constants.calls() > calls.len() {
            return Err(MalformedTape);
        }
        read(&mut Reader::new(bytes), constants, calls).ok_or(MalformedTape)
    }

    /// The number of factors.
    pub(crate) fn factors(&self) -> usize {
        self.numbers.len() + self.computed
    }

    /// Whether a sequence has coefficients beyond order 0.
    pub(crate) fn moves(&self, sequence: Place) -> bool {
        let op = self.operations.get(sequence as usize);
        op.is_none_or(|op| op.code != Code::Constant)
    }

    /// The number of calls of functions: each has a name behind those of the declared switches.
    pub(crate) fn functions(&self) -> usize {
        self.names.len() - self.switches
    }
}

/// The counts against which indices are checked.
struct Counts {
    numbers: usize,
    computed: usize,
    sequences: usize,
    products: usize,
    squares: usize,
    switches: usize,
    functions: usize,
}

impl Counts {
    fn sequence(&self, reader: &mut Reader<'_>) -> Option<Place> {
        place(reader.number()?, self.sequences)
    }

    fn factor(&self, reader: &mut Reader<'_>) -> Option<Place> {
        let number = reader.number()?;
        match number % 2 {
            0 => place(number / 2, self.numbers),
            _ => Some(place(number / 2, self.computed)? + Place::try_from(self.numbers).ok()?),
        }
    }

    fn operand(&self, reader: &mut Reader<'_>) -> Option<(Place, bool)> {
        let number = reader.number()?;
        Some((place(number / 2, self.sequences)?, number % 2 == 1))
    }

    /// The place of an inner sum; squares stand behind the products, whose blocks come in pairs.
    fn sum(&self, reader: &mut Reader<'_>) -> Option<Place> {
        let number = reader.number()?;
        if number.is_multiple_of(2) {
            return place(number / 2, self.products);
        }
        let first = Place::try_from(self.products.next_multiple_of(2 * LANES)).ok()?;
        Some(place(number / 2, self.squares)? + first)
    }

    /// An operation, and its terms.
    fn operation(&self, own: usize, reader: &mut Reader<'_>, terms: &mut Vec<Term>) -> Option<Operation> {
        let code = *CODES.get(usize::from(reader.byte()?))?;
        let mut op = Operation {
            code,
            lists: reader.byte()?,
            parts: [0; 4],
            sums: [0; 3],
            index: 0,
            constant: None,
            terms: [Place::try_from(terms.len()).ok()?, 0],
            switch: None,
        };
        let [parts, sums] = code.counts();
        match code {
            Code::Position | Code::Velocity | Code::Acceleration | Code::Multiplier => {
                op.index = place(reader.number()?, MOST)?;
            }
            Code::Constant => op.index = self.factor(reader)?,
            Code::Linear => {
                if reader.number()? > 0 {
                    op.constant = Some(self.factor(reader)?);
                }
                op.terms[1] = place(reader.number()?, MOST)?;
                for _ in 0..op.terms[1] {
                    terms.push([self.factor(reader)?, self.sequence(reader)?]);
                }
            }
            Code::Call => {
                op.index = place(reader.number()?, MOST)?;
                op.switch = Some(place(reader.number()?, self.functions)?);
                if reader.number()? != 1 {
                    return None;
                }
            }
            _ => {}
        }
        for part in op.parts.iter_mut().take(parts) {
            *part = self.sequence(reader)?;
        }
        if code == Code::Power {
            op.index = self.factor(reader)?;
        }
        if code.may_switch() {
            let number = reader.number()?;
            op.switch = match number.checked_sub(1) {
                None => None,
                Some(number) => Some(place(number, self.switches)?),
            };
        }
        if op.lists & LASTING > 0 {
            for sum in op.sums.iter_mut().take(sums) {
                *sum = self.sum(reader)?;
            }
        }
        // each of a pair is computed with the other
        let partner = usize::try_from(op.parts[1]).ok()?;
        let in_pair = match code {
            Code::Sin => partner == own + 1,
            Code::Cos => partner + 1 == own,
            _ => true,
        };
        in_pair.then_some(op)
    }
}

/// An index below `count`.
fn place(number: usize, count: usize) -> Option<Place> {
    (number < count.min(MOST)).then(|| Place::try_from(number).ok())?
}

/// A list of a length that was read.
fn list<T>(count: usize, mut next: impl FnMut() -> Option<T>) -> Option<Vec<T>> {
    let mut list = Vec::new();
    for _ in 0..count {
        list.push(next()?);
    }
    Some(list)
}

/// The recurrences; `None` if they are malformed.
fn read(reader: &mut Reader<'_>, constants: Tape, calls: Vec<TapeCall>) -> Option<Series> {
    if reader.byte()? != VERSION {
        return None;
    }
    let count = reader.number()?;
    let numbers = list(count, || Some(f64::from_le_bytes(reader.bytes()?)))?;
    let [coordinates, multipliers, affine, eager, computed] = five(reader)?;
    let [products, squares, switches, functions] = [(); 4].map(|()| reader.number());
    let (products, squares, switches, functions) = (products?, squares?, switches?, functions?);
    let names = list(switches.checked_add(functions)?, || reader.text().map(Arc::from))?;
    let sequences = reader.number()?;
    if constants.count(crate::tape::Segment::Constants, crate::tape::Part::All) != computed {
        return None;
    }
    let counts = Counts {
        numbers: numbers.len(),
        computed,
        sequences,
        products,
        squares,
        switches,
        functions,
    };
    let mut terms = Vec::new();
    let mut own = 0..sequences;
    let operations = list(sequences, || counts.operation(own.next()?, reader, &mut terms))?;
    let products = list(products, || {
        Some([counts.operand(reader)?, counts.operand(reader)?])
    })?;
    let squares = list(squares, || counts.operand(reader))?;
    let arguments = list(switches, || match reader.number()? {
        0 => Some(Argument::Sign(counts.sequence(reader)?)),
        1 => Some(Argument::Steep(counts.sequence(reader)?)),
        kind @ (3 | 4) => {
            let base = counts.sequence(reader)?;
            let degree = i32::try_from(reader.number()?).ok()?;
            Some(Argument::Power(base, if kind == 3 { -degree } else { degree }))
        }
        kind @ 5..=7 => {
            let bound = [0.0, FRAC_PI_2, PI].get(kind - 5).copied()?;
            Some(Argument::Bounded(counts.sequence(reader)?, bound))
        }
        2 => Some(Argument::Difference(
            counts.sequence(reader)?,
            counts.sequence(reader)?,
        )),
        _ => None,
    })?;
    let accelerations = list(coordinates, || counts.sequence(reader))?;
    let count = reader.number()?;
    let unknown = list(count, || {
        let number = reader.number()?;
        let is_multiplier = number % 2 == 1;
        let of = if is_multiplier { multipliers } else { coordinates };
        Some((is_multiplier, place(number / 2, of)?))
    })?;
    let rows = list(count, || counts.sequence(reader))?;
    let entries = reader.number()?;
    let jacobian = list(entries, || {
        Some([
            place(reader.number()?, count)?,
            place(reader.number()?, count)?,
            counts.sequence(reader)?,
        ])
    })?;
    let count = reader.number()?;
    let divisors = list(count, || counts.sequence(reader))?;
    let within = operations.iter().all(|op| match op.code {
        Code::Position | Code::Velocity | Code::Acceleration => (op.index as usize) < coordinates,
        Code::Multiplier => (op.index as usize) < multipliers,
        Code::Call => (op.index as usize) < calls.len(),
        _ => true,
    });
    (reader.is_at_end() && within).then_some(Series {
        numbers,
        constants,
        computed,
        calls,
        coordinates,
        multipliers,
        affine: affine > 0,
        eager: eager > 0,
        switches,
        names,
        operations,
        terms,
        products,
        squares,
        arguments,
        accelerations,
        unknown,
        rows,
        jacobian,
        divisors,
    })
}

/// Reads five whole numbers.
fn five(reader: &mut Reader<'_>) -> Option<[usize; 5]> {
    let mut numbers = [0; 5];
    for number in &mut numbers {
        *number = reader.number()?;
    }
    Some(numbers)
}

#[cfg(all(test, feature = "text"))]
mod tests {
    use super::*;

    #[test]
    fn bytes_that_are_cut_or_changed_are_no_recurrences_or_others() {
        let text = "parameters { length = 2.0 }
            coordinates(x, y);
            lagrangian = (dot(x).powi(2) + dot(y).powi(2) * (2 + x.sin())) / 2 - length * x.cos() - y.abs() * x.exp();";
        let text = dsocs_language::read("cut", text, &[]).unwrap();
        let written = text.model.series().unwrap();
        let read = |bytes: &[u8]| Series::new(bytes, written.constants.clone(), Vec::new());
        let series = read(&written.recurrences).unwrap();
        assert_eq!(series.coordinates, 2);
        // the name of the sign's argument; that of the exponential is watched, too, without a name
        let named = series.names.iter().filter(|name| !name.is_empty());
        assert_eq!((named.count(), series.names.len()), (1, 2));
        for length in 0..written.recurrences.len() {
            assert!(read(&written.recurrences[..length]).is_err(), "{length}");
        }
        for place in 0..written.recurrences.len() {
            for value in [0, 1, 127, 255] {
                let mut changed = written.recurrences.clone();
                changed[place] = value;
                // an error, or other recurrences with valid indices
                if let Ok(series) = read(&changed) {
                    let count = series.operations.len();
                    let parts = series.operations.iter().flat_map(|op| op.parts);
                    assert!(
                        parts
                            .chain(series.rows.clone())
                            .all(|part| (part as usize) < count)
                    );
                }
            }
        }
    }
}
