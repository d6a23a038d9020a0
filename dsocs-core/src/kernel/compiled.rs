//! The attribute's code behind [`Kernel`](super::Kernel): each function is compiled once for a declared type,
//! and reads slices as arrays.
#![allow(missing_docs)] // documented in the trait

use super::At;
use crate::kernel::generated::{Compiled, Report};
use crate::kernel::report::NodeMut;
use crate::kernel::run_state::{RunState, Solved};
use crate::number::array::Array;
use crate::number::point::AnyLeg;
use crate::number::point::Leg;
use crate::solve::unknown::Linearization;

/// A leg of arrays; `None` if a slice is shorter.
fn leg<const N: usize>(leg: AnyLeg<'_, f64>) -> Option<Leg<f64, N>> {
    Some(Leg {
        t: leg.t,
        q: *leg.q.first_chunk()?,
        d: *leg.d.first_chunk()?,
    })
}

/// Copies as many numbers as there is room for.
#[inline]
fn write(out: &mut [f64], numbers: &[f64]) {
    for (out, number) in out.iter_mut().zip(numbers) {
        *out = *number;
    }
}

pub fn constants<S: Compiled<N>, const N: usize>(system: &S, parameters: &[f64], h: f64, out: &mut [f64]) {
    if let Some(parameters) = Array::read(parameters) {
        write(out, system.constants(parameters, h).as_ref());
    }
}

pub fn remember<S: Compiled<N>, const N: usize>(constants: &mut [f64], past: &[f64]) {
    if let (Some((constants, _)), Some(past)) = (Array::split(constants), past.first_chunk()) {
        S::remember::<f64>(constants, past);
    }
}

pub fn past<S: Compiled<N>, const N: usize>(constants: &[f64], past: &mut [f64]) {
    if let Some(constants) = Array::read(constants) {
        write(past, &S::past::<f64>(constants));
    }
}

pub fn known<S: Compiled<N>, const N: usize>(
    system: &S,
    constants: &[f64],
    first: AnyLeg<'_, f64>,
    out: &mut [f64],
) {
    if let (Some(constants), Some(leg)) = (Array::read(constants), leg(first)) {
        write(out, system.known(constants, &leg).as_ref());
    }
}

/// The arguments of a function of the unknowns.
macro_rules! at {
    ($at:expr) => {
        (
            Array::read($at.constants),
            Array::read($at.known),
            Array::read($at.z),
        )
    };
}

pub fn linearize<S: Compiled<N>, const N: usize>(
    system: &S,
    at: At<'_>,
    rows: &mut [f64],
    jacobian: &mut [f64],
) {
    if let (Some(constants), Some(known), Some(z)) = at!(at) {
        let at: Linearization<f64, S::Unknown<f64>> = system.linearize(constants, known, z);
        write(rows, at.rows.as_ref());
        let width = rows.len().max(1);
        for (out, row) in jacobian.chunks_mut(width).zip(at.jacobian.as_ref()) {
            write(out, row.as_ref());
        }
    }
}

pub fn entries<S: Compiled<N>, const N: usize>(
    system: &S,
    at: At<'_>,
    rows: &mut [f64],
    entries: &mut [f64],
) {
    if let (Some(constants), Some(known), Some(z)) = at!(at) {
        write(rows, system.entries(constants, known, z, entries).as_ref());
    }
}

pub fn scales<S: Compiled<N>, const N: usize>(system: &S, at: At<'_>, scales: &mut [f64]) {
    if let (Some(constants), Some(known), Some(z)) = at!(at) {
        write(scales, system.scales(constants, known, z).as_ref());
    }
}

pub fn unknown<S: Compiled<N>, const N: usize>(system: &S, e: &[f64], multipliers: &[f64], z: &mut [f64]) {
    if let Some(e) = e.first_chunk() {
        write(z, system.unknown(e, multipliers).as_ref());
    }
}

pub fn second_difference<S: Compiled<N>, const N: usize>(system: &S, at: At<'_>, e: &mut [f64]) {
    if let (Some(constants), Some(known), Some(z)) = at!(at) {
        write(e, &system.second_difference(constants, known, z));
    }
}

#[expect(
    clippy::needless_pass_by_value,
    reason = "the references in it are written through"
)]
pub fn report<S: Compiled<N>, const N: usize>(system: &S, run_state: &RunState, node: NodeMut<'_>) {
    if let (Some(constants), Some(Solved { leg, e, before }), [q, v, a, q_force]) = (
        <S::Constants<f64> as Array<f64>>::read(&run_state.constants),
        run_state.vectors.solved(run_state.solved_at),
        node.vectors.as_chunks_mut().0,
    ) {
        // in third order the known values are those before the step, with the second difference that it continued
        let mut constants = *constants;
        S::remember::<f64>(&mut constants, before);
        let constants = &constants;
        let known = system.known(constants, &leg);
        let Report { point, force, energy } = system.report(constants, &known, &leg, e);
        // the reported position is the middle node `q1`, whatever the declared maps are
        (*q, *v, *a, *q_force) = (leg.q, point.v, point.a, force);
        node.scalars.energy = energy;
    }
}
