//! Tapes that are written by hand.

use super::*;
use crate::number::tangent::Tangent;

/// A source with one function, of three parameters and a tape.
struct Hand<'t>(&'t Tape);

impl Source for Hand<'_> {
    fn shape(&self) -> &Shape {
        unreachable!("no tape asks for it")
    }

    fn tape(&self) -> &Tape {
        self.0
    }

    fn value(&self, parameter: usize) -> f64 {
        [2.0, 3.0, 5.0].get(parameter).copied().unwrap_or(f64::NAN)
    }

    fn call(&self, which: usize, arguments: &[f64]) -> f64 {
        match (which, arguments) {
            (0, [x, y]) => x * y + 1.0,
            _ => f64::NAN,
        }
    }
}

/// A segment with some operations and results, the first `head` of them in its head.
fn segment(ops: &[&[u8]], results: &[u8], head: u8) -> Vec<u8> {
    let mut body = vec![u8::try_from(ops.len()).unwrap()];
    body.extend(ops.concat());
    body.extend([u8::try_from(results.len()).unwrap(), head]);
    body.extend(results);
    let mut segment = vec![u8::try_from(body.len()).unwrap()];
    segment.extend(body);
    segment
}

/// The bytes of a tape of some segments, the others empty.
fn bytes(segments: &[(Segment, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = vec![VERSION];
    for place in 0..SEGMENTS {
        let own = segments.iter().find(|(segment, _)| *segment as usize == place);
        bytes.extend(own.map_or_else(|| segment(&[], &[], 0), |(_, body)| body.clone()));
    }
    bytes
}

/// A tape of some segments, the others empty.
fn tape(segments: &[(Segment, Vec<u8>)]) -> Tape {
    Tape::owned(bytes(segments)).unwrap()
}

fn results<T: Number>(tape: &Tape, of: Segment, part: Part, leaf: &dyn Fn(Leaf) -> T) -> Vec<T> {
    let mut results = Vec::new();
    T::walk(tape.program(of, part), &Hand(tape), leaf, &mut |place, value| {
        assert_eq!(place, results.len());
        results.push(value);
    });
    results
}

/// The constant `h p₀` of a run; `d₀` times it, known in a step; then `r = z₀ · known + f(z₀, p₁)`, and its
/// slope.
fn small() -> Tape {
    let constants = segment(&[&[1, 8, 0], &[1, 9, 0], &[7, 0, 1]], &[2], 0);
    let known = segment(&[&[1, 4, 0], &[2, 0], &[7, 0, 1]], &[2], 0);
    let residual = segment(
        &[
            &[1, 6, 0],
            &[3, 0],
            &[7, 0, 1],
            &[1, 9, 1],
            &[15, 0, 2, 0, 3],
            &[5, 2, 4],
            &[5, 1, 3],
        ],
        &[5, 6],
        1,
    );
    let energy = segment(
        &[
            &[1, 0, 0],
            &[38, 0],
            &[0, 0, 0, 0, 0, 0, 0, 0xe0, 0x3f],
            &[8, 1, 2],
        ],
        &[3, 3],
        0,
    );
    tape(&[
        (Segment::Constants, constants),
        (Segment::Known, known),
        (Segment::Residual, residual),
        (Segment::Energy, energy),
    ])
}

fn leaf(leaf: Leaf) -> f64 {
    match leaf {
        Leaf::H => 0.5,
        Leaf::D(0) => 7.0,
        Leaf::Z(0) => 11.0,
        Leaf::Q(0) => 0.25,
        Leaf::Parameter(0) => 2.0,
        Leaf::Parameter(1) => 3.0,
        _ => f64::NAN,
    }
}

#[test]
fn segments_read_what_others_have_computed() {
    let tape = &small();
    assert_eq!(results(tape, Segment::Known, Part::All, &leaf), [7.0]);
    let row = 11.0 * 7.0 + (11.0 * 3.0 + 1.0);
    assert_eq!(results(tape, Segment::Residual, Part::All, &leaf), [row, 10.0]);
    assert_eq!(results(tape, Segment::Residual, Part::Head, &leaf), [row]);
    assert_eq!(results(tape, Segment::Residual, Part::Tail, &leaf), [10.0]);
    assert_eq!(
        results(tape, Segment::Energy, Part::All, &leaf),
        [2.0 * f64::sin(0.25); 2]
    );
    assert_eq!(results(tape, Segment::Scales, Part::All, &leaf), [0.0; 0]);
}

#[test]
fn what_is_not_needed_is_not_computed() {
    let tape = &small();
    let lengths = [Part::All, Part::Head, Part::Tail].map(|part| tape.program(Segment::Residual, part).len());
    // the call belongs to the row alone, the slope's sum to the slope alone
    assert_eq!(lengths, [11, 10, 7]);
    // a register is free once its number has been read for the last time
    assert!(tape.program(Segment::Residual, Part::All).registers <= 5);
}

#[test]
fn the_same_tape_serves_other_numbers() {
    use crate::number::lanes::Lanes;
    use crate::number::scalar::Scalar as _;
    use crate::number::tangent::Tangent;
    let tape = &small();
    let slope = |place: Leaf| Tangent::new(leaf(place), f64::from(u8::from(place == Leaf::Z(0))));
    let moved = results(tape, Segment::Residual, Part::All, &slope);
    assert_eq!(moved[0].value(), leaf(Leaf::Z(0)) * 10.0 + 1.0);
    assert!((moved[0].derivative() - 10.0).abs() < 1e-12);
    let lanes = results(tape, Segment::Residual, Part::All, &|place| {
        Lanes::splat(leaf(place))
    });
    assert_eq!(lanes[1].lane(7), 10.0);
}

#[test]
fn a_malformed_tape_has_no_results() {
    let good = small();
    for length in 0..good.bytes.len() {
        let cut = Tape::owned(good.bytes()[..length].to_vec());
        assert_eq!(cut.unwrap_err(), MalformedTape);
    }
    assert_eq!(
        results(&Tape::new(&[VERSION]), Segment::Residual, Part::All, &leaf),
        [0.0; 0]
    );
    let mut seed = 1_u64;
    for _ in 0..20_000 {
        let mut bytes = good.bytes.to_vec();
        for _ in 0..2 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let place = usize::try_from(seed >> 33).unwrap() % bytes.len();
            bytes[place] = u8::try_from(seed >> 20 & 0xff).unwrap();
        }
        // malformed tapes must not panic
        let Ok(tape) = Tape::owned(bytes) else { continue };
        for place in [Segment::Constants, Segment::Residual, Segment::Energy] {
            for part in [Part::All, Part::Head, Part::Tail] {
                results(&tape, place, part, &leaf);
            }
        }
    }
}

#[test]
fn a_function_may_evaluate_tapes_itself() {
    struct Nested(Tape);
    impl Source for Nested {
        fn shape(&self) -> &Shape {
            unreachable!("no tape asks for it")
        }

        fn tape(&self) -> &Tape {
            &self.0
        }

        fn value(&self, _: usize) -> f64 {
            3.0
        }

        fn call(&self, _: usize, arguments: &[f64]) -> f64 {
            arguments[1] + results(&self.0, Segment::Energy, Part::All, &leaf)[0]
        }
    }
    let tape = &small();
    let mut rows = Vec::new();
    f64::walk(
        tape.program(Segment::Residual, Part::Head),
        &Nested(small()),
        &leaf,
        &mut |_, row| {
            rows.push(row);
        },
    );
    assert_eq!(rows, [77.0 + (3.0 + 2.0 * f64::sin(0.25))]);
}

#[test]
fn derivatives_go_back_and_forward_as_tangents_do() {
    // every function of a leaf, every operation of two, a branch
    let mut ops: Vec<Vec<u8>> = vec![vec![1, 6, 0], vec![1, 3, 0]];
    let mut places = Vec::new();
    let mut take = |op: Vec<u8>| {
        places.push(u8::try_from(ops.len()).unwrap());
        ops.push(op);
    };
    for function in 32..=51_u8 {
        take(vec![function, 0]);
    }
    for binary in [5, 6, 7, 8, 11, 12] {
        take(vec![binary, 0, 1]);
    }
    take(vec![9, 0]);
    take(vec![4, 0]);
    take([&[10, 0][..], &3_i32.to_le_bytes()].concat());
    // the square root of a negative number, on the branch that is not taken
    take(vec![6, 0, 1]);
    take(vec![32, 31]);
    take(vec![13, 0, 1, 0, 32]);
    let ops: Vec<&[u8]> = ops.iter().map(Vec::as_slice).collect();
    assert_eq!(ops.len(), 34);
    let (count, body) = (places.len(), segment(&ops, &places, 0));
    let tape = &tape(&[(Segment::Energy, body)]);
    for (z, n) in [(0.3, 0.7), (0.9, 1.4), (0.55, 2.0)] {
        let differential = tape.differential(&[(Segment::Energy, Part::All)], &|_| true);
        let mut room = Workspace::default();
        let value = |input| match input {
            Input::Leaf(Leaf::Z(_)) => z,
            _ => n,
        };
        differential.evaluate(&Hand(tape), &mut room, 1, &mut |input| Eight::splat(value(input)));
        let inputs: Vec<Input> = differential.inputs().collect();
        for result in 0..count {
            let mut found = [0.0; 2];
            differential.back_from(&mut room, result, &mut |input, slope| {
                found[usize::from(inputs[input] != Input::Leaf(Leaf::Z(0)))] = slope.0[0];
            });
            for (k, found) in found.into_iter().enumerate() {
                let leaf = |leaf| match leaf {
                    Leaf::Z(_) => Tangent::new(z, [1.0, 0.0][k]),
                    _ => Tangent::new(n, [0.0, 1.0][k]),
                };
                let expected = results(tape, Segment::Energy, Part::All, &leaf)[result].derivative();
                let same =
                    (found - expected).abs() <= 1e-13 * expected.abs() || found.is_nan() && expected.is_nan();
                assert!(same, "result {result} by {k} at {z}, {n}: {found} {expected}");
            }
        }
    }
}

#[test]
fn a_result_may_come_many_times() {
    let of = |results: &[u8], count: u8| {
        let mut body = vec![2, 1, 9, 0, 1, 9, 1, count, 0];
        body.extend(results);
        let mut own = vec![u8::try_from(body.len()).unwrap()];
        own.extend(body);
        let tape = Tape::owned(bytes(&[(Segment::Energy, own)])).ok()?;
        let mut results = Vec::new();
        f64::walk(
            tape.program(Segment::Energy, Part::All),
            &Hand(&tape),
            &|leaf| match leaf {
                Leaf::Parameter(place) => place as f64,
                _ => f64::NAN,
            },
            &mut |_, value| results.push(value),
        );
        Some(results)
    };
    // the second operation once, then three more times, then the first
    assert_eq!(of(&[1, 2, 3, 0], 5).unwrap(), [1.0, 1.0, 1.0, 1.0, 0.0]);
    for wrong in [&[2, 3, 0][..], &[1, 2, 5, 0], &[1, 2, 0, 0], &[1, 3, 0]] {
        assert!(of(wrong, 5).is_none(), "{wrong:?}");
    }
}
