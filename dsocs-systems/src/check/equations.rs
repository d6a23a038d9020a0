//! Whether the motion obeys the paper's principle: equations and action, each by other code than that which made the motion.

use dsocs_core::Leg;
use dsocs_core::geometry::{
    Displacement, Triple, admissible_variations, discrete_form, external_forces, legendre_minus,
    legendre_plus, rows_of_written,
};

use super::{Report, Subject, larger, largest};
use crate::stability::Bar;

/// A row at the written nodes may be so many times what their rounding makes of it.
pub const WRITTEN: f64 = 2.0;

/// The derivative of the action may be this part of its terms.
const STATIONARY: f64 = 1e-12;

/// The equations at the nodes as they are written, and the discrete action.
pub fn equations<const N: usize>(subject: &Subject<'_, N>, report: &mut Report) {
    let mut worst = (0.0, 0);
    for &place in &subject.places {
        let row = written(subject, subject.legs[place].t, &nodes(&subject.legs, place));
        if larger(worst.0, row).to_bits() != f64::to_bits(worst.0) {
            worst = (row, place);
        }
    }
    report.push(
        "rows at the nodes as written, in 32 digits, over what their rounding explains",
        Bar::AtMost(WRITTEN),
        Ok(worst.0),
    );
    if !Bar::AtMost(WRITTEN).holds(worst.0) {
        report.note(&format!("the worst rows are those of node {}", worst.1 + 1));
    }
    let [holonomic, nonholonomic, kinematic] = subject.system.constraints();
    let constraints = holonomic + nonholonomic + kinematic;
    let mut unknown = 0;
    let sizes = sizes(subject);
    let action = largest(&subject.triples, |triple| {
        let admissible = admissible_variations(subject.system, subject.h, triple, constraints);
        let Some(admissible) = admissible else {
            unknown += 1;
            return Ok(0.0);
        };
        Ok(derivative(subject, triple, &admissible, &sizes))
    });
    let what = "dS_d along admissible variations, from L_d alone, relative to its terms";
    if unknown == subject.triples.len() {
        let why =
            "the fields of the variations depend on more than position and velocity: dS_d is not looked at";
        report.note(why);
    } else {
        report.push(what, Bar::AtMost(STATIONARY), action);
    }
}

/// The three nodes about a place of the motion, as they are written.
pub fn nodes<const N: usize>(legs: &[Leg<f64, N>], place: usize) -> [[f64; N]; 3] {
    let first = match place.checked_sub(1) {
        Some(before) => legs[before].q,
        None => core::array::from_fn(|i| legs[0].q[i] - legs[0].d[i]),
    };
    [first, legs[place].q, legs[place + 1].q]
}

/// The largest row at three nodes, the second at the time `t`, over what their rounding explains.
fn written<const N: usize>(subject: &Subject<'_, N>, t: f64, nodes: &[[f64; N]; 3]) -> f64 {
    let rows = rows_of_written(subject.system, t, subject.h, nodes);
    rows.iter().fold(0.0, |most, &[row, explained]| {
        larger(most, if row == 0.0 { 0.0 } else { row.abs() / explained })
    })
}

/// How large the derivatives of `L_d` by each coordinate of a node become along the motion, and the terms that they are the sums of:
/// masses times increments. These terms cancel in a momentum that is conserved and zero.
fn sizes<const N: usize>(subject: &Subject<'_, N>) -> [f64; N] {
    let mut sizes = [0.0; N];
    for triple in &subject.triples {
        let leg = triple.first();
        let arriving = legendre_plus(subject.system, subject.h, &leg);
        let form = discrete_form(subject.system, subject.h, &leg);
        for (i, (size, part)) in sizes.iter_mut().zip(arriving).enumerate() {
            let terms = leg.d.iter().enumerate().map(|(j, d)| {
                let mass = form.of(&Displacement::unit(i), &Displacement::unit(N + j));
                (mass * d).abs()
            });
            *size = larger(*size, larger(part.abs(), terms.sum()));
        }
    }
    sizes
}

/// The derivative of `L_d(q0, q1) + L_d(q1, q2)` along variations of `q1`, with the work of external forces, relative to its terms.
fn derivative<const N: usize>(
    subject: &Subject<'_, N>,
    triple: &Triple<N>,
    along: &[[f64; N]],
    sizes: &[f64; N],
) -> f64 {
    let arriving = legendre_plus(subject.system, subject.h, &triple.first());
    let leaving = legendre_minus(subject.system, subject.h, &triple.last(subject.h));
    let external = external_forces(subject.system, subject.h, triple);
    let mut most = 0.0;
    for variation in along {
        let (mut sum, mut terms) = (0.0, 0.0);
        for (i, part) in variation.iter().enumerate() {
            sum += part * (arriving[i] - leaving[i] + external[i]);
            terms += part.abs() * sizes[i];
        }
        most = larger(most, if sum == 0.0 { 0.0 } else { sum.abs() / terms });
    }
    most
}
