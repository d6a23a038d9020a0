//! Whether the tape of a declaration computes what its straight-line code does, to the last bit.

use dsocs_core::__private::{Declaration, Report};
use dsocs_core::{Leg, System};

/// Compares all methods of a step at a leg, with the unknowns that belong to a second difference and to multipliers.
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
    let told = tape.point(h, leg.any(), e);
    same("time", &[point.t], &[told.any().t])?;
    same("coordinate", &point.q, told.any().q)?;
    same("velocity", &point.v, told.any().v)?;
    same("acceleration", &point.a, told.any().a)?;
    same("force", &force, &tape.force(h, leg.any(), e))?;
    same("energy", &[energy], &[tape.energy(point.t, &point.q, &point.v)])
}

fn same(name: &str, code: &[f64], tape: &[f64]) -> Result<(), String> {
    // which NaN it is depends on the order of operands, which is the compiler's choice
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
