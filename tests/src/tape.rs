//! Comparison of a declaration's tape with its straight-line code, to the last bit.

use dsocs_core::__private::{AnyLeg, At, Declaration, Report, RunState};
use dsocs_core::{Kernel, Leg, NodeMut, NodeScalars, System};
use dsocs_scenes::random::Random;

/// Compares all functions of a step at a leg, with the unknowns that belong to a second difference and to
/// multipliers.
///
/// # Errors
///
/// The first number that differs, in words.
pub fn same_bits<S: System<N>, const N: usize>(
    system: &S,
    h: f64,
    leg: &Leg<f64, N>,
    e: &[f64; N],
    multipliers: &[f64],
) -> Result<(), String> {
    let tape = Declaration::of(system);
    let constants = system.constants(&system.parameters(), h);
    let known = system.known(&constants, leg);
    let z = system.unknown(e, multipliers);
    same("constant", constants.as_ref(), &tape.constants(h))?;
    same("known value", known.as_ref(), &tape.known(h, leg.any()))?;
    same("unknown", z.as_ref(), &tape.unknown(e, multipliers))?;
    let z = z.as_ref();
    let at = system.linearize(&constants, &known, &system.unknown(e, multipliers));
    same("row", at.rows.as_ref(), &tape.rows(h, leg.any(), z))?;
    let mut jacobian = Vec::new();
    for row in at.jacobian.as_ref() {
        jacobian.extend_from_slice(row.as_ref());
    }
    same(
        "entry of the Jacobian",
        &jacobian,
        &tape.jacobian(h, leg.any(), z),
    )?;
    let scales = system.scales(&constants, &known, &system.unknown(e, multipliers));
    same("scale", scales.as_ref(), &tape.scales(h, leg.any(), z))?;
    let found = system.second_difference(&constants, &known, &system.unknown(e, multipliers));
    same(
        "second difference",
        &found,
        &tape.second_difference(h, leg.any(), z),
    )?;
    let Report { point, force, energy } = system.report(&constants, &known, leg, e);
    let of_tape = tape.point(h, leg.any(), e);
    same("time", &[point.t], &[of_tape.any().t])?;
    same("coordinate", &point.q, of_tape.any().q)?;
    same("velocity", &point.v, of_tape.any().v)?;
    same("acceleration", &point.a, of_tape.any().a)?;
    same("force", &force, &tape.force(h, leg.any(), e))?;
    same("energy", &[energy], &[tape.energy(point.t, &point.q, &point.v)])
}

fn same(name: &str, code: &[f64], tape: &[f64]) -> Result<(), String> {
    // the bits of a NaN depend on the order of operands, which the compiler chooses
    let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
    if code.len() != tape.len() {
        return Err(format!(
            "{name}: {} of the code, {} of the tape",
            code.len(),
            tape.len()
        ));
    }
    for (place, (&code, &tape)) in code.iter().zip(tape).enumerate() {
        if bits(code) != bits(tape) {
            return Err(format!(
                "{name} {place}: {code:?} by the code, {tape:?} by the tape"
            ));
        }
    }
    Ok(())
}

/// Random numbers up to this size.
fn numbers(random: &mut Random, count: usize, size: f64) -> Vec<f64> {
    (0..count).map(|_| random.between(-size, size)).collect()
}

/// All results of a kernel in one step, from random inputs.
fn step(kernel: &dyn Kernel, seed: u64) -> Vec<(&'static str, Vec<f64>)> {
    let shape = kernel.shape();
    let (n, m) = (shape.dimension(), shape.unknowns);
    let mut random = Random::new(seed);
    let h = [0.1, 0.01, 1e-3][usize::try_from(seed % 3).unwrap()];
    let parameters: Vec<f64> = (0..shape.parameters.len())
        .map(|place| kernel.value(place) * random.between(0.5, 1.5))
        .collect();
    let mut constants = vec![f64::NAN; shape.constants];
    kernel.constants(&parameters, h, &mut constants);
    kernel.remember(&mut constants, &numbers(&mut random, n, h * h));
    let mut past = vec![f64::NAN; n];
    kernel.past(&constants, &mut past);
    let leg = AnyLeg {
        t: random.between(-5.0, 5.0),
        q: &numbers(&mut random, n, 2.0),
        d: &numbers(&mut random, n, h),
    };
    let mut known = vec![f64::NAN; shape.known];
    kernel.known(&constants, leg, &mut known);
    let e = numbers(&mut random, n, h * h);
    let multipliers = numbers(&mut random, shape.forms, 1.0);
    let mut z = vec![f64::NAN; m];
    kernel.unknown(&e, &multipliers, &mut z);
    let at = At {
        constants: &constants,
        known: &known,
        z: &z,
    };
    let (mut rows, mut jacobian) = (vec![f64::NAN; m], vec![f64::NAN; m * m]);
    kernel.linearize(at, &mut rows, &mut jacobian);
    let (mut sparse_rows, mut entries) = (vec![f64::NAN; m], vec![f64::NAN; m * m]);
    kernel.entries(at, &mut sparse_rows, &mut entries);
    let mut scales = vec![f64::NAN; m];
    kernel.scales(at, &mut scales);
    let mut difference = vec![f64::NAN; n];
    kernel.second_difference(at, &mut difference);
    let (mut vectors, mut scalars) = (vec![f64::NAN; 4 * n], NodeScalars::UNKNOWN);
    let node = NodeMut {
        vectors: &mut vectors,
        scalars: &mut scalars,
    };
    let run_state = RunState::of_step(shape, (h, &constants), leg, [&e, &past]);
    kernel.report(&run_state, node);
    vec![
        ("constants", constants),
        ("past", past),
        ("known", known),
        ("unknowns", z),
        ("rows", rows),
        ("jacobian", jacobian),
        ("rows beside entries", sparse_rows),
        ("entries", entries),
        ("scales", scales),
        ("second difference", difference),
        ("point and force", vectors),
        ("energy", vec![scalars.energy]),
    ]
}

/// Compares the steps of two kernels of one declaration at random points. Returns the number of finite
/// numbers, and of all.
///
/// # Panics
///
/// If a number differs.
pub fn same_everywhere(one: &dyn Kernel, other: &dyn Kernel, points: u64) -> [usize; 2] {
    let mut counts = [0, 0];
    for seed in 0..points {
        let steps = [one, other].map(|kernel| step(kernel, 977 * seed + 1));
        for ((what, one_has), (_, other_has)) in steps[0].iter().zip(&steps[1]) {
            if let Err(error) = same(what, one_has, other_has) {
                panic!("{}: {error}", one.shape().name);
            }
            counts[0] += one_has.iter().filter(|x| x.is_finite()).count();
            counts[1] += one_has.len();
        }
    }
    counts
}
