//! Machine code gives the bits of the same operations in Rust, and its memory is freed.

#![cfg(target_arch = "x86_64")] // where code is made
// powers and signs are compared as they are
#![allow(clippy::float_cmp)]

use std::cell::Cell;
use std::hint::black_box;

use dsocs_jit::{Calls, Code, Compiler, NoCalls, Operand, Operation, PIECE, Program};

/// Numbers at which similar operations have different results.
const SPECIAL: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.3,
    -0.7,
    1.5,
    -2.0,
    3.0,
    1e-3,
    -12345.678,
    1e16,
    1e200,
    -1e200,
    1e-200,
    f64::MIN_POSITIVE,
    5e-324,
    -5e-324,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    core::f64::consts::PI,
];

extern "C" fn sin(a: f64) -> f64 {
    a.sin()
}

extern "C" fn powf(a: f64, b: f64) -> f64 {
    a.powf(b)
}

/// Calls of a program: a sum, or the number of the call.
struct Sums;

impl Calls for Sums {
    fn call(&self, which: u32, argument: Option<f64>) -> f64 {
        argument.map_or(f64::from(which), |argument| f64::from(which) + argument)
    }
}

/// Numbers on which code runs.
fn cells(numbers: &mut [f64]) -> &[Cell<f64>] {
    Cell::from_mut(numbers).as_slice_of_cells()
}

/// The bits of a number; all that are none are alike.
fn bits(x: f64) -> u64 {
    if x.is_nan() { u64::MAX } else { x.to_bits() }
}

/// The result of an operation in Rust.
fn by_rust(operation: &Operation, at: &dyn Fn(Operand) -> f64) -> f64 {
    match *operation {
        Operation::Neg(a) => -at(a),
        Operation::Recip(a) => at(a).recip(),
        Operation::Sqrt(a) => at(a).sqrt(),
        Operation::Abs(a) => at(a).abs(),
        Operation::Signum(a) => at(a).signum(),
        Operation::Sin(a) => black_box(at(a)).sin(),
        Operation::Cos(a) => black_box(at(a)).cos(),
        Operation::Powi(a, power) => black_box(at(a)).powi(black_box(power)),
        Operation::Add(a, b) => at(a) + at(b),
        Operation::Sub(a, b) => at(a) - at(b),
        Operation::Mul(a, b) => at(a) * at(b),
        Operation::Div(a, b) => at(a) / at(b),
        Operation::Less([a, b, c, d]) => at(if at(a) < at(b) { c } else { d }),
        Operation::LessOrEqual([a, b, c, d]) => at(if at(a) <= at(b) { c } else { d }),
        Operation::Function(function, a) => function(at(a)),
        Operation::Function2(function, a, b) => function(at(a), at(b)),
        Operation::Call(which, a) => Sums.call(which, Some(at(a))),
        Operation::Datum(which) => Sums.call(which, None),
    }
}

/// All results of some operations on numbers in Rust.
fn results_by_rust(operations: &[Operation], numbers: &[f64]) -> Vec<f64> {
    let mut results: Vec<f64> = Vec::new();
    for operation in operations {
        let at = |operand: Operand| match operand {
            Operand::Place(place) => numbers[place as usize],
            Operand::Result(of) => results[of as usize],
        };
        let result = by_rust(operation, &at);
        results.push(result);
    }
    results
}

/// The code of some operations, with the places of their results behind `given` numbers.
fn code(operations: &[Operation], given: u32, wanted: impl Iterator<Item = u32>) -> Code {
    let results: Vec<_> = wanted.map(|of| (Operand::Result(of), given + of)).collect();
    let program = Program::new(operations, &results).unwrap();
    let [code] = <[Code; 1]>::try_from(Compiler::new().unwrap().compile(&[program]).unwrap()).unwrap();
    code
}

#[test]
fn every_operation_has_the_bits_of_rust() {
    let [a, b, c, d] = [0, 1, 2, 3].map(Operand::Place);
    let mut operations = vec![
        Operation::Neg(a),
        Operation::Recip(a),
        Operation::Sqrt(a),
        Operation::Abs(a),
        Operation::Signum(a),
        // of one number and of two
        Operation::Sin(a),
        Operation::Cos(a),
        Operation::Sin(b),
        Operation::Cos(c),
        Operation::Add(a, b),
        Operation::Sub(a, b),
        Operation::Mul(a, b),
        Operation::Mul(a, a),
        Operation::Div(a, b),
        Operation::Less([a, b, c, d]),
        Operation::LessOrEqual([a, b, c, d]),
        Operation::Function(sin, a),
        Operation::Function2(powf, a, b),
        Operation::Call(7, b),
        Operation::Datum(3),
    ];
    let powers = [0, 1, 2, 3, 4, 5, 7, 8, 15, 31, 100, 1023, i32::MAX, i32::MIN];
    operations.extend(powers.map(|power| Operation::Powi(a, power)));
    operations.extend(powers.map(|power| Operation::Powi(a, power.saturating_neg())));
    let count = u32::try_from(operations.len()).unwrap();
    let code = code(&operations, 4, 0..count);
    for (k, a) in SPECIAL.into_iter().enumerate() {
        for b in SPECIAL {
            let others = [1, 2].map(|more| SPECIAL[(k + more) % SPECIAL.len()]);
            let mut numbers = vec![a, b, others[0], others[1]];
            let expected = results_by_rust(&operations, &numbers);
            numbers.resize(4 + operations.len(), 0.0);
            code.on(cells(&mut numbers), &Sums).unwrap().run();
            for ((operation, expected), found) in operations.iter().zip(expected).zip(&numbers[4..]) {
                let same = bits(expected) == bits(*found);
                assert!(same, "{operation:?} at {a:?}, {b:?}: {expected:?} {found:?}");
            }
        }
    }
}

#[test]
fn sums_and_products_are_not_fused() {
    let [a, b, c] = [0, 1, 2].map(Operand::Place);
    let operations = [
        Operation::Mul(a, b),
        Operation::Add(Operand::Result(0), c),
        Operation::Sub(c, Operand::Result(0)),
    ];
    let code = code(&operations, 3, 1..3);
    let tiny = f64::EPSILON;
    let mut numbers = [1.0 + tiny, 1.0 - tiny, -1.0, 0.0, 0.0, 0.0];
    code.on(cells(&mut numbers), &NoCalls).unwrap().run();
    // fused, they would be what the rounding of the product has taken away
    assert_eq!(numbers[4..], [0.0, -2.0]);
}

/// Operations of all kinds on earlier results, chosen by a fixed rule: in many pieces, which read each other's results.
fn many(count: u32) -> Vec<Operation> {
    let mut state: u64 = 1;
    let mut next = move |below: u32| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        u32::try_from((state >> 33) % u64::from(below)).unwrap()
    };
    let operations = (0..count).map(|at| {
        let mut operand = |near: bool| match (at, near) {
            (0..10, _) => Operand::Place(next(4)),
            (_, true) => Operand::Result(at - 1 - next(10)),
            (_, false) => Operand::Result(next(at)),
        };
        let (a, b) = (operand(true), operand(false));
        let angle = match (at - at % 21).checked_sub(1) {
            Some(last) => Operand::Result(last),
            None => Operand::Place(0),
        };
        match at % 7 {
            0 => Operation::Function(sin, a),
            1 => Operation::Sub(a, b),
            2 => Operation::Less([a, b, b, a]),
            3 => Operation::Add(a, b),
            4 => Operation::Call(at % 2, a),
            5 => Operation::Signum(b),
            // of one angle, at some distance
            6 if at % 21 == 6 => Operation::Sin(angle),
            6 if at % 21 == 13 => Operation::Cos(angle),
            _ => Operation::Mul(a, b),
        }
    });
    operations.collect()
}

#[test]
fn a_program_of_many_pieces_has_the_bits_of_rust() {
    let count = u32::try_from(4 * PIECE + 17).unwrap();
    let operations = many(count);
    // the results in between are needed, too
    let wanted = (0..count).filter(|of| of % 3 == 0 || of + 40 > count);
    let code = code(&operations, 4, wanted.clone());
    for numbers in [[0.3, -0.7, 1.1, 2.0], [1.0, 0.0, -0.0, -3.0]] {
        let expected = results_by_rust(&operations, &numbers);
        let mut numbers = numbers.to_vec();
        numbers.resize(4 + operations.len(), 0.0);
        code.on(cells(&mut numbers), &Sums).unwrap().run();
        for of in wanted.clone().map(|of| of as usize) {
            assert_eq!(bits(numbers[4 + of]), bits(expected[of]), "operation {of}");
        }
    }
}

#[test]
fn results_may_be_numbers_that_were_there() {
    let results = [(Operand::Place(0), 1), (Operand::Place(0), 2)];
    let program = Program::new(&[], &results).unwrap();
    let code = Compiler::new().unwrap().compile(&[program]).unwrap();
    let mut numbers = [5.0, 0.0, 0.0];
    code[0].on(cells(&mut numbers), &NoCalls).unwrap().run();
    assert_eq!(numbers, [5.0; 3]);
}

#[test]
fn what_would_read_or_write_elsewhere_is_refused() {
    let read = Operand::Place(0);
    let later = Operation::Neg(Operand::Result(0));
    assert!(Program::new(&[later], &[]).is_err());
    assert!(Program::new(&[], &[(Operand::Result(0), 1)]).is_err());
    // a place that is read and written
    assert!(Program::new(&[Operation::Neg(read)], &[(Operand::Result(0), 0)]).is_err());
    // a place that is written twice
    assert!(Program::new(&[], &[(read, 1), (read, 1)]).is_err());
    let program = Program::new(&[Operation::Neg(read)], &[(Operand::Result(0), 5)]).unwrap();
    let code = Compiler::new().unwrap().compile(&[program]).unwrap();
    let error = code[0].on(cells(&mut [0.0; 5]), &NoCalls).unwrap_err();
    assert_eq!([error.found, error.expected], [5, 6]);
}

#[test]
fn code_runs_on_several_threads() {
    let code = code(&many(3000), 4, 2900..3000);
    let run = |numbers: &mut Vec<f64>| {
        numbers.resize(3004, 0.0);
        code.on(cells(numbers), &Sums).unwrap().run();
    };
    let start = vec![0.3, -0.7, 1.1, 2.0];
    let mut one = start.clone();
    run(&mut one);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let mut other = start.clone();
                run(&mut other);
                let same = one
                    .iter()
                    .zip(&other)
                    .all(|(one, other)| bits(*one) == bits(*other));
                assert!(same);
            });
        }
    });
}

/// The number of memory mappings of this process.
#[cfg(target_os = "linux")]
fn mapped() -> usize {
    std::fs::read_to_string("/proc/self/maps")
        .unwrap()
        .lines()
        .count()
}

#[cfg(target_os = "linux")]
#[test]
fn memory_is_freed_with_the_last_code() {
    let sum = Operation::Add(Operand::Place(0), Operand::Place(1));
    let program = Program::new(&[sum], &[(Operand::Result(0), 4)]).unwrap();
    let make = |count: usize| {
        let programs = vec![program.clone(); count];
        Compiler::new().unwrap().compile(&programs).unwrap()
    };
    let kept: Vec<_> = (0..100).map(|_| make(2)).collect();
    let with_all = mapped();
    // one of two programs keeps the memory of both
    let halves: Vec<Code> = kept.into_iter().map(|mut codes| codes.swap_remove(1)).collect();
    let mut numbers = vec![0.5; 5];
    halves[99].on(cells(&mut numbers), &NoCalls).unwrap().run();
    assert_eq!(numbers[4], 1.0);
    drop(halves);
    let before = mapped();
    assert!(before < with_all, "{before} {with_all}");
    for _ in 0..10_000 {
        drop(make(1));
    }
    // other tests of this process map memory, too
    let after = mapped();
    assert!(after < before + 50, "{before} {after}");
}
