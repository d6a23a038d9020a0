//! The paper's principle along the motion: the equations in 32 digits, and the variation of the action from
//! `L_d` alone.

use dsocs_core::OwnedLeg;
use dsocs_core::geometry::{
    Displacement, Triple, admissible_variations, discrete_form, external_forces, force_roundings,
    legendre_minus, legendre_plus, rows_at_given_nodes,
};

use crate::check::motion::motions::less;
use crate::check::reasons::beginning::BeginningFromRest;
use crate::check::{CheckedMotion, Report, larger, largest};
use crate::stability::Bar;

/// The largest residual of a row at the written nodes, relative to the rounding of its terms.
pub const LARGEST_RESIDUAL: f64 = 2.0;

/// The largest derivative of the action, relative to its terms.
const LARGEST_ACTION_DERIVATIVE: f64 = 1e-12;

/// The time and the nodes are moved by this many roundings to see whether a row jumps there. A smooth row changes by little more than as many
/// times what its rounding explains, a row that jumps by more than [`JUMP`] times.
const MOVED_BY: f64 = 16.0;
const JUMP: f64 = 1e3;

/// The excuse of rows that can nowhere be compared.
const NO_ROWS: &str = "not measured, and so neither met nor missed: at every place that is looked at, a function of the declaration jumps at a node, where \
    rounding decides on which side the node lies, or some row has no value in 32 digits; to see it, begin elsewhere, or take another `--step`, whose \
    nodes do not lie there";

/// The equations at the nodes as they are written, and the discrete action.
pub fn equations(motion: &CheckedMotion<'_>, report: &mut Report) {
    let mut worst = (0.0, 0);
    let (mut all, mut undefined, mut undecided) = (Vec::new(), 0, 0);
    for &place in &motion.places {
        let [first, second, third] = &nodes(&motion.legs, place);
        let rows = rows_at_given_nodes(
            motion.kernel,
            motion.legs[place].t,
            motion.h,
            [first, second, third],
        );
        let row = largest_residual(&rows);
        if row > LARGEST_RESIDUAL && rounding_decides(motion, place, &rows) {
            undecided += 1;
            continue;
        }
        if row.is_nan() {
            undefined += 1;
        } else if larger(worst.0, row).to_bits() != f64::to_bits(worst.0) {
            worst = (row, place);
        }
        all.push((place, rows));
    }
    report.push(
        "rows at the nodes as written, in 32 digits, over what their rounding explains",
        Bar::AtMost(LARGEST_RESIDUAL),
        Ok(if undefined == all.len() && !motion.places.is_empty() {
            f64::NAN
        } else {
            worst.0
        }),
    );
    if undefined == all.len() && !motion.places.is_empty() {
        if let Some(last) = report.findings.last_mut() {
            (last.failure, last.excuse) = (None, Some(NO_ROWS.to_owned()));
        }
    } else if undefined > 0 {
        report.note(&format!(
            "at {undefined} of {} places that are looked at some row has no value in 32 digits: an expression of the declaration, or a derivative of \
             it, has none there; these places are left out",
            motion.places.len()
        ));
    }
    if undecided > 0 {
        report.note(&format!(
            "at {undecided} of {} places that are looked at a function of the declaration jumps at a node, where rounding decides on which side the \
             node lies; these places are left out",
            motion.places.len()
        ));
    }
    if !Bar::AtMost(LARGEST_RESIDUAL).holds(worst.0) {
        report.note(&format!("the worst rows are those of node {}", worst.1 + 1));
        let excuse =
            BeginningFromRest::along(motion).and_then(|beginning| beginning.excuse_rows(&all, worst.1));
        if let Some(last) = report.findings.last_mut() {
            last.excuse = excuse;
        }
    }
    let mut unknown = 0;
    let sizes = sizes(motion);
    let action = largest(&motion.triples, |triple| {
        let admissible = admissible_variations(motion.kernel, motion.h, triple);
        let Some(admissible) = admissible else {
            unknown += 1;
            return Ok(0.0);
        };
        Ok(derivative(motion, triple, &admissible, &sizes))
    });
    let what = "dS_d along admissible variations, from L_d alone, relative to its terms";
    if unknown == motion.triples.len() {
        let why =
            "the fields of the variations depend on more than position and velocity: dS_d is not looked at";
        report.note(why);
    } else {
        report.push(what, Bar::AtMost(LARGEST_ACTION_DERIVATIVE), action);
    }
}

/// The three nodes at `place` of the motion, as written.
pub fn nodes(legs: &[OwnedLeg<f64>], place: usize) -> [Vec<f64>; 3] {
    let first = match place.checked_sub(1) {
        Some(before) => legs[before].q.clone(),
        None => less(&legs[0].q, &legs[0].d),
    };
    [first, legs[place].q.clone(), legs[place + 1].q.clone()]
}

/// Whether a row jumps at the nodes of a place: a change of the time or of a node by a few roundings changes most of its residual.
fn rounding_decides(motion: &CheckedMotion<'_>, place: usize, rows: &[[f64; 2]]) -> bool {
    let (t, nodes) = (motion.legs[place].t, nodes(&motion.legs, place));
    let legs = [&motion.legs[place].d, &motion.legs[place + 1].d];
    let jumps = |t: f64, [first, second, third]: &[Vec<f64>; 3]| {
        let moved = rows_at_given_nodes(motion.kernel, t, motion.h, [first, second, third]);
        rows.iter().zip(&moved).any(|([row, explained], [other, _])| {
            let change = (other - row).abs();
            change > larger(0.5 * row.abs(), JUMP * explained)
        })
    };
    [-MOVED_BY, MOVED_BY].iter().any(|by| {
        let of_time = by * f64::EPSILON * larger(t.abs(), motion.h.abs());
        let by_node = || {
            (0..nodes.len()).any(|k| {
                (0..nodes[k].len()).any(|i| {
                    let size = legs
                        .iter()
                        .fold(nodes[k][i].abs(), |size, d| larger(size, d[i].abs()));
                    let mut moved = nodes.clone();
                    moved[k][i] += by * f64::EPSILON * size;
                    jumps(t, &moved)
                })
            })
        };
        jumps(t + of_time, &nodes) || by_node()
    })
}

/// The largest residual of rows, relative to the rounding of their terms.
fn largest_residual(rows: &[[f64; 2]]) -> f64 {
    rows.iter().fold(0.0, |most, &[row, explained]| {
        larger(most, if row == 0.0 { 0.0 } else { row.abs() / explained })
    })
}

/// The size of each derivative of `L_d` by a coordinate, the largest along the motion: of its value, and of
/// the sum of its terms, masses times increments. These cancel in a momentum that is conserved and zero.
fn sizes(motion: &CheckedMotion<'_>) -> Vec<f64> {
    let n = motion.kernel.shape().dimension();
    let mut sizes = vec![0.0; n];
    for triple in &motion.triples {
        let leg = triple.first();
        let arriving = legendre_plus(motion.kernel, motion.h, leg);
        let form = discrete_form(motion.kernel, motion.h, leg);
        for (i, (size, part)) in sizes.iter_mut().zip(arriving).enumerate() {
            let terms = leg.d.iter().enumerate().map(|(j, d)| {
                let mass = form.of(&Displacement::unit(n, i), &Displacement::unit(n, n + j));
                (mass * d).abs()
            });
            *size = larger(*size, larger(part.abs(), terms.sum()));
        }
    }
    sizes
}

/// The derivative of `L_d(q0, q1) + L_d(q1, q2)` along variations of `q1`, with the work of external forces,
/// relative to its terms; less the effect of the rounding of the last node and of the forces.
fn derivative(motion: &CheckedMotion<'_>, triple: &Triple, along: &[Vec<f64>], sizes: &[f64]) -> f64 {
    let covector = |triple: &Triple| -> Vec<f64> {
        let arriving = legendre_plus(motion.kernel, motion.h, triple.first());
        let leaving = legendre_minus(motion.kernel, motion.h, triple.last(motion.h).any());
        let external = external_forces(motion.kernel, motion.h, triple);
        (0..external.len())
            .map(|i| arriving[i] - leaving[i] + external[i])
            .collect()
    };
    let here = covector(triple);
    let mut most = 0.0;
    for variation in along {
        let product = |covector: &[f64]| -> f64 { variation.iter().zip(covector).map(|(v, c)| v * c).sum() };
        let terms: f64 = variation.iter().zip(sizes).map(|(v, size)| v.abs() * size).sum();
        let sum = product(&here);
        let left = if sum.abs() > LARGEST_ACTION_DERIVATIVE * terms {
            let of_node = rounding(motion.h, triple, |moved| product(&covector(moved)) - sum);
            let forces = force_roundings(motion.kernel, motion.h, triple);
            let of_forces = variation
                .iter()
                .zip(forces)
                .map(|(v, rounding)| v.abs() * rounding);
            (sum.abs() - of_node - of_forces.sum::<f64>()).max(0.0)
        } else {
            sum.abs()
        };
        most = larger(most, if left == 0.0 { 0.0 } else { left / terms });
    }
    most
}

/// The sum of the changes of a function of a triple, as each coordinate of its last node changes by a
/// rounding.
fn rounding(h: f64, triple: &Triple, change: impl Fn(&Triple) -> f64) -> f64 {
    let last = triple.last(h).q;
    let moves = last.iter().enumerate().map(|(i, q)| {
        let mut moved = triple.clone();
        moved.leg.q[i] += f64::EPSILON * q.abs();
        change(&moved).abs()
    });
    moves.sum()
}
