//! The evaluator of tapes.

use core::cell::Cell;

use super::link::{Kind, Program, Register};
use super::read::{Binary, Comparison, Function};
use super::table::{piece, polynomial};
use super::{Leaf, Source};
use crate::number::bounded::{Bounded, Underflowing};
use crate::number::double::Double;
use crate::number::lanes::Lanes;
use crate::number::real::Real;
use crate::number::scalar::Scalar;
use crate::number::tangent::{Tangent, Tangent2};
use crate::samples::Samples;
use crate::series::jet::Jet;

/// A type of number with which tapes are evaluated.
///
/// The evaluator is compiled here, once for each type, and not again where it is called.
pub trait Number: Scalar {
    /// Evaluates a program: `leaf` gives the leaves, `result` receives each result with its place.
    fn walk(
        program: &Program,
        source: &dyn Source,
        leaf: &dyn Fn(Leaf) -> Self,
        result: &mut dyn FnMut(usize, Self),
    );

    /// A number with a rate of change, which numbers without derivatives ignore.
    #[must_use]
    fn changing(value: f64, rate: f64) -> Self;

    /// The polynomial of samples around the number; see `Samples::polynomial`.
    fn polynomial(self, samples: &Samples) -> [Self; 5] {
        polynomial(self, samples)
    }

    /// Allocates the memory of this thread for evaluations of a program.
    fn prepare(program: &Program);
}

/// The workspace of a thread's evaluations with one type of number; kept, so that an evaluation allocates
/// nothing.
struct Workspace<T> {
    registers: Vec<T>,
    arguments: Vec<f64>,
}

impl<T> Default for Workspace<T> {
    fn default() -> Self {
        Self {
            registers: Vec::new(),
            arguments: Vec::new(),
        }
    }
}

impl<T: Scalar> Workspace<T> {
    /// Allocates for a program.
    fn fit(&mut self, program: &Program) {
        if self.registers.len() < program.registers {
            self.registers.resize(program.registers, T::splat(0.0));
        }
        self.arguments.reserve(program.arguments.len());
    }
}

macro_rules! numbers {
    ($($number:ty: $changing:expr $(, $polynomial:item)?);* $(;)?) => {
        $(const _: () = {
            thread_local! {
                static ROOM: Cell<Workspace<$number>> = Cell::default();
            }

            impl Number for $number {
                fn walk(
                    program: &Program,
                    source: &dyn Source,
                    leaf: &dyn Fn(Leaf) -> Self,
                    result: &mut dyn FnMut(usize, Self),
                ) {
                    // a user's function may evaluate tapes itself: it finds an empty workspace
                    let mut room = ROOM.take();
                    walk(program, source, leaf, result, &mut room);
                    ROOM.set(room);
                }

                fn changing(value: f64, rate: f64) -> Self {
                    let changing: fn(f64, f64) -> Self = $changing;
                    changing(value, rate)
                }

                $($polynomial)?

                fn prepare(program: &Program) {
                    let mut room = ROOM.take();
                    room.fit(program);
                    ROOM.set(room);
                }
            }
        };)*
    };
}

numbers!(
    f64: |value, _| value;
    Lanes: |value, _| Self::splat(value);
    Bounded: |value, _| Self::splat(value);
    Underflowing: |value, _| Self::splat(value);
    Double: |value, _| Self::splat(value);
    Tangent: Self::new,
        fn polynomial(self, samples: &Samples) -> [Self; 5] {
            piece(self.value(), samples).map(Self::splat)
        };
    Tangent2: |value, rate| Self::second(value, [rate, 0.0]),
        fn polynomial(self, samples: &Samples) -> [Self; 5] {
            piece(self.value(), samples).map(Self::splat)
        };
    Jet: |value, _| Self::splat(value),
        fn polynomial(self, samples: &Samples) -> [Self; 5] {
            // the series has to know where the next piece begins
            samples.polynomial(self.piece(samples.places())).map(Self::from)
        };
);

/// Evaluates a program.
fn walk<T: Number>(
    program: &Program,
    source: &dyn Source,
    leaf: &dyn Fn(Leaf) -> T,
    result: &mut dyn FnMut(usize, T),
    room: &mut Workspace<T>,
) {
    room.fit(program);
    let registers = &mut room.registers[..program.registers];
    for instruction in &program.instructions {
        let at = |register: Register| registers[register as usize];
        let value = match instruction.kind {
            Kind::Number(value) => T::splat(value),
            Kind::Leaf(which) => leaf(which),
            Kind::Neg(a) => -at(a),
            Kind::Recip(a) => at(a).recip(),
            Kind::Powi(a, power) => at(a).powi(power),
            Kind::Binary(binary, [a, b]) => {
                let (a, b) = (at(a), at(b));
                match binary {
                    Binary::Add => a + b,
                    Binary::Sub => a - b,
                    Binary::Mul => a * b,
                    Binary::Div => a / b,
                    Binary::Powf => a.powf(b),
                    Binary::Atan2 => a.atan2(b),
                }
            }
            Kind::Select(comparison, [a, b, c, d]) => match comparison {
                Comparison::Less => T::select_lt(at(a), at(b), at(c), at(d)),
                Comparison::LessOrEqual => T::select_le(at(a), at(b), at(c), at(d)),
            },
            Kind::Function(name, a) => function(name, at(a)),
            Kind::Call { which, first, count } => {
                let range = first as usize..(first + count) as usize;
                let arguments = &program.arguments[range];
                if let Some(data) = source.data(which as usize) {
                    registers[instruction.to as usize] =
                        data.value(arguments.first().map(|&first| at(first)));
                    continue;
                }
                let buffer = &mut room.arguments;
                let [value] = T::from_lanes(|lane| {
                    buffer.clear();
                    buffer.extend(
                        arguments
                            .iter()
                            .map(|&argument| registers[argument as usize].lane(lane)),
                    );
                    [source.call(which as usize, buffer)]
                });
                value
            }
        };
        registers[instruction.to as usize] = value;
    }
    for (place, &register) in program.results.iter().enumerate() {
        result(place, registers[register as usize]);
    }
}

/// A function of one number.
pub(super) fn function<T: Scalar>(name: Function, a: T) -> T {
    match name {
        Function::Sqrt => a.sqrt(),
        Function::Cbrt => a.cbrt(),
        Function::Exp => a.exp(),
        Function::ExpM1 => a.exp_m1(),
        Function::Ln => a.ln(),
        Function::Ln1p => a.ln_1p(),
        Function::Sin => a.sin(),
        Function::Cos => a.cos(),
        Function::Tan => a.tan(),
        Function::Asin => a.asin(),
        Function::Acos => a.acos(),
        Function::Atan => a.atan(),
        Function::Sinh => a.sinh(),
        Function::Cosh => a.cosh(),
        Function::Tanh => a.tanh(),
        Function::Asinh => a.asinh(),
        Function::Acosh => a.acosh(),
        Function::Atanh => a.atanh(),
        Function::Abs => a.abs(),
        Function::Signum => a.signum(),
    }
}
