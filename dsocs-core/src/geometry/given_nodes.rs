//! The equations of a step at given nodes, in twice the precision.

use super::array::{along, moving, moving_leg, times};
use crate::kernel::Kernel;
use crate::number::bounded::{Bounded, UNIT};
use crate::number::double::Double;
use crate::number::point::OwnedLeg;
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::fit;
use crate::regularity::multipliers::of_step;
use crate::solve::dense::Matrix;
use crate::tape::declaration::Declaration;

/// Number of iterations for the multipliers; each gains as many digits as a double has.
const IMPROVED: u32 = 3;

/// The changes of the node, the increment, the last second difference and the second difference with `q0`,
/// `q1` and `q2`.
const NODES: [[f64; 4]; 3] = [[0.0, -1.0, 0.0, 1.0], [1.0, 1.0, 0.0, -2.0], [0.0, 0.0, 0.0, 1.0]];

/// The changes of the node, the increment, the last second difference and the third difference with the four
/// nodes of a step of third order.
const FOUR_NODES: [[f64; 4]; 4] = [
    [0.0, 0.0, 1.0, -1.0],
    [0.0, -1.0, -2.0, 3.0],
    [1.0, 1.0, 1.0, -3.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// The values of the declared rows of a step at three nodes, the second at the time `t`, each with a bound of
/// its rounding error.
///
/// The first number of each pair is the row, evaluated in twice the precision from the nodes alone, with
/// exact differences of the nodes. The second number bounds its distance from zero by rounding, for three
/// reasons: the time and each component of the nodes were rounded to the nearest double; the second
/// difference was known to one unit of rounding of itself or of a leg; and the row was solved in doubles.
/// Rows that call your own Rust functions are evaluated in the precision of doubles only.
///
/// Nodes have one component for each coordinate; for nodes of another length the result is empty. Rows come
/// in the order of [`System::residual`](crate::System::residual). Unknown multipliers are fitted to the rows.
#[must_use]
pub fn rows_at_given_nodes(system: &dyn Kernel, t: f64, h: f64, nodes: [&[f64]; 3]) -> Vec<[f64; 2]> {
    rows_at_nodes(Declaration::of(system), t, h, None, nodes)
}

/// [`rows_at_given_nodes`] for a step of third order, which has four nodes, the third at the time `t`.
#[must_use]
pub fn rows_at_four_given_nodes(
    system: &dyn Kernel,
    t: f64,
    h: f64,
    [first, nodes @ ..]: [&[f64]; 4],
) -> Vec<[f64; 2]> {
    rows_at_nodes(Declaration::of(system), t, h, Some(first), nodes)
}

/// The rows at three nodes, and for a step of third order the node before them.
fn rows_at_nodes(
    declaration: Declaration<'_>,
    t: f64,
    h: f64,
    before: Option<&[f64]>,
    nodes: [&[f64]; 3],
) -> Vec<[f64; 2]> {
    let n = declaration.dimension();
    if !fit(&declaration, &nodes) || !fit(&declaration, before.as_slice()) {
        return Vec::new();
    }
    let [q0, q1, q2] = nodes;
    let exact = |x: &[f64]| x.iter().copied().map(Double::exact).collect();
    let mut leg: OwnedLeg<Double> = OwnedLeg {
        t: Double::exact(t),
        q: exact(q1),
        d: exact(q1),
    };
    let mut e = leg.d.clone();
    for i in 0..n {
        leg.d[i] = Double::difference(q1[i], q0[i]);
        e[i] = Double::difference(q2[i], q1[i]) - leg.d[i];
    }
    let mut past = vec![Double::exact(0.0); n];
    if let Some(before) = before {
        for i in 0..n {
            past[i] = leg.d[i] - Double::difference(q0[i], before[i]);
            e[i] = e[i] - past[i];
        }
    }
    let rounded = |x: &[Double]| -> Vec<f64> { x.iter().map(|x| x.rounded()).collect() };
    let past_rounded = rounded(&past);
    let declaration = declaration.after(&past_rounded);
    let e_rounded = rounded(&e);
    let rounded = OwnedLeg {
        t,
        q: q1.to_vec(),
        d: rounded(&leg.d),
    };
    let step = Double::exact(h);

    let first = of_step(&declaration, h, rounded.any(), &e_rounded);
    let mut multipliers: Vec<Double> = first.iter().copied().map(Double::exact).collect();
    let mut rows = declaration.declared_after(step, leg.any(), &past, &e, &multipliers);

    let fixed: Vec<Tangent> = multipliers.iter().map(|x| Tangent::splat(x.rounded())).collect();
    let mut allowed = vec![0.0; rows.len()];
    let mut add = |[by_q, by_d, by_past, by_e]: [f64; 4], j: usize, size: f64| {
        let unit = along(n, j, 1.0);
        let leg = moving_leg(rounded.any(), &times(by_q, &unit), &times(by_d, &unit));
        let e = moving(&e_rounded, &times(by_e, &unit));
        let past = moving(&past_rounded, &times(by_past, &unit));
        let rows = declaration.declared_after(Tangent::splat(h), leg.any(), &past, &e, &fixed);
        for (allowed, row) in allowed.iter_mut().zip(rows) {
            *allowed += row.derivative().abs() * size;
        }
    };
    for j in 0..n {
        if let Some(before) = before {
            for (node, by) in [before].into_iter().chain(nodes).zip(FOUR_NODES) {
                add(by, j, 0.5 * unit_in_the_last_place(node[j]));
            }
        } else {
            for (node, by) in nodes.into_iter().zip(NODES) {
                add(by, j, 0.5 * unit_in_the_last_place(node[j]));
            }
        }
        add(
            [0.0, 0.0, 0.0, 1.0],
            j,
            f64::EPSILON * rounded.d[j].abs().max(e_rounded[j].abs()),
        );
    }
    let bounded = |x: &[f64]| -> Vec<Bounded> { x.iter().copied().map(Bounded::splat).collect() };
    let bounded_leg = OwnedLeg {
        // the last digit of a node's time is rounded
        t: Bounded::known(t, UNIT * t.abs()),
        q: bounded(&rounded.q),
        d: bounded(&rounded.d),
    };
    let fixed: Vec<Bounded> = fixed.iter().map(|x| Bounded::splat(x.value())).collect();
    let [bounded_past, bounded_e] = [bounded(&past_rounded), bounded(&e_rounded)];
    let evaluated = declaration.declared_after(
        Bounded::splat(h),
        bounded_leg.any(),
        &bounded_past,
        &bounded_e,
        &fixed,
    );
    for (allowed, row) in allowed.iter_mut().zip(evaluated) {
        *allowed += row.error();
    }
    if !multipliers.is_empty() {
        let forms = declaration.forms(h, rounded.any(), &e_rounded);
        let from = rows.len().saturating_sub(n);
        for _ in 0..IMPROVED {
            let changes = nearest(&forms, &rows[from..], &allowed[from..]);
            for (multiplier, change) in multipliers.iter_mut().zip(changes) {
                *multiplier = *multiplier + Double::exact(change);
            }
            rows = declaration.declared_after(step, leg.any(), &past, &e, &multipliers);
        }
    }
    rows.iter()
        .map(|row| row.rounded())
        .zip(allowed)
        .map(Into::into)
        .collect()
}

/// The change of the multipliers that makes `row − Σ δλ α` smallest, with each row in units of its rounding
/// bound.
fn nearest(forms: &[Vec<f64>], rows: &[Double], units: &[f64]) -> Vec<f64> {
    let weight = |i: usize| {
        let weight = units.get(i).map_or(f64::NAN, |unit| unit.recip());
        if weight.is_finite() { weight } else { 0.0 }
    };
    let entry = |i: usize, j: usize| forms[j].get(i).copied().unwrap_or(f64::NAN);
    let matrix = Matrix::from_fn(rows.len(), forms.len(), |i, j| weight(i) * entry(i, j));
    let right: Vec<f64> = (0..rows.len()).map(|i| weight(i) * rows[i].rounded()).collect();
    if !matrix.is_finite() || right.iter().any(|x| !x.is_finite()) {
        return vec![0.0; forms.len()];
    }
    matrix.decomposed().solve(&right, f64::EPSILON)
}

/// The distance of a number from the next larger one.
fn unit_in_the_last_place(x: f64) -> f64 {
    x.abs().next_up() - x.abs()
}
