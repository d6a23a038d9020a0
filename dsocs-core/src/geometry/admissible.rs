//! The admissible variations of a discrete path at a node.

use super::array::{along, minus, moving, moving_leg, plus, slopes, times};
use super::map::Triple;
use super::solvable::Declared;
use crate::any::sized;
use crate::declaration::Declaration;
use crate::dense::Matrix;
use crate::scalar::Scalar as _;
use crate::system::Leg;
use crate::tangent::Tangent;

/// A pivot below this part of the largest entry is zero.
const PIVOT: f64 = 1e-12;

/// So often the triple without a force is improved.
const ITERATIONS: u32 = 40;

/// An update of this part of the second difference is the last.
const LAST: f64 = 1e-14;

/// How well fields have to foretell a work elsewhere.
const FORETOLD: f64 = 1e-8;

/// A basis of the admissible variations `δq1 ∈ D_V` at a triple, on which the discrete action `S_d = Σ L_d` is stationary (paper,
/// section 3). `constraints` is how many constraints there are in all.
///
/// If the constraints' forms `α_j` are known, the result is their kernel. If fields `u` are declared, the rows of the step contain
/// only the works `⟨u, Q⟩`, and the fields are computed from these: at a triple without a force, the derivative of a work is
/// `⟨u, ∂Q⟩`. This triple has the same `q1` and the same `(q2 − q0)/2h`. `None` is returned if the fields depend on more than
/// these two, or if there is no such triple.
#[must_use]
pub fn admissible_variations<const N: usize>(
    system: &dyn Declared<N>,
    h: f64,
    triple: &Triple<N>,
    constraints: usize,
) -> Option<Vec<[f64; N]>> {
    let declaration = system.declaration();
    let forms = declaration.forms(h, triple.leg.any(), &triple.e);
    if constraints == 0 || forms.len() == constraints {
        let forms: Vec<[f64; N]> = forms.iter().map(|form| sized(form)).collect();
        return Some(kernel(&forms));
    }
    fields(&declaration, h, triple, constraints)
}

/// The vectors on which some forms vanish, by elimination.
fn kernel<const N: usize>(forms: &[[f64; N]]) -> Vec<[f64; N]> {
    let mut rows = forms.to_vec();
    let mut pivots: Vec<usize> = Vec::new();
    for k in 0..rows.len() {
        let row = rows[k];
        let largest = (0..N).max_by(|&i, &j| row[i].abs().total_cmp(&row[j].abs()));
        let Some(pivot) = largest.filter(|&j| row[j] != 0.0) else {
            continue;
        };
        rows[k] = times(rows[k][pivot].recip(), &rows[k]);
        let row = rows[k];
        for (i, other) in rows.iter_mut().enumerate() {
            if i != k {
                let size = other.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
                *other = minus(other, &times(other[pivot], &row));
                other[pivot] = 0.0;
                for x in other.iter_mut().filter(|x| x.abs() <= PIVOT * size) {
                    *x = 0.0;
                }
            }
        }
        pivots.push(pivot);
    }
    rows.retain(|row| row.iter().any(|x| *x != 0.0));
    let free = (0..N).filter(|j| !pivots.contains(j));
    free.map(|j| {
        let mut vector = along(j, 1.0);
        for (row, &pivot) in rows.iter().zip(&pivots) {
            vector[pivot] = -row[j];
        }
        vector
    })
    .collect()
}

/// The fields, from the works of a triple without a force.
fn fields<const N: usize>(
    declaration: &Declaration<'_>,
    h: f64,
    triple: &Triple<N>,
    constraints: usize,
) -> Option<Vec<[f64; N]>> {
    // q1 and d + e/2 stay
    let middle = plus(&triple.leg.d, &times(0.5, &triple.e));
    let leg = |e: &[f64; N]| Leg {
        t: triple.leg.t,
        q: triple.leg.q,
        d: minus(&middle, &times(0.5, e)),
    };
    let mut e = triple.e;
    let mut found = false;
    for _ in 0..ITERATIONS {
        let mut by_e = [[0.0; N]; N];
        for (j, column) in by_e.iter_mut().enumerate() {
            let unit = along(j, 1.0);
            let leg = moving_leg(&leg(&e), &[0.0; N], &times(-0.5, &unit));
            let force = declaration.force(Tangent::splat(h), leg.any(), &moving(&e, &unit));
            *column = slopes(&sized(&force), 1.0);
        }
        let force = declaration.force(h, leg(&e).any(), &e);
        let matrix = Matrix::from_fn(N, N, |i, j| by_e[j][i]);
        if !matrix.is_finite() || force.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let change: [f64; N] = *matrix.decomposed().solve(&force, 0.0).first_chunk()?;
        e = minus(&e, &change);
        let size = |x: &[f64; N]| x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        if size(&change) <= LAST * size(&e).max(size(&middle)) {
            found = true;
            break;
        }
    }
    if !found {
        return None;
    }
    // ∂⟨u, Q⟩ = ⟨u, ∂Q⟩ where Q is zero
    let free = leg(&e);
    let mut works = vec![[0.0; N]; 0];
    let mut by_e = [[0.0; N]; N];
    for j in 0..N {
        let unit = along(j, 1.0);
        let leg = moving_leg(&free, &[0.0; N], &[0.0; N]);
        let moved = moving(&e, &unit);
        by_e[j] = slopes(
            &sized(&declaration.force(Tangent::splat(h), leg.any(), &moved)),
            1.0,
        );
        let rows = declaration.declared(Tangent::splat(h), leg.any(), &moved, &[]);
        for (k, row) in rows.iter().skip(constraints).enumerate() {
            if works.len() <= k {
                works.push([0.0; N]);
            }
            works[k][j] = row.derivative();
        }
    }
    let matrix = Matrix::from_fn(N, N, |i, j| by_e[i][j]);
    if !matrix.is_finite() || works.as_flattened().iter().any(|x| !x.is_finite()) {
        return None;
    }
    let decomposed = matrix.decomposed();
    let fields: Option<Vec<[f64; N]>> = works
        .iter()
        .map(|work| decomposed.solve(work, 0.0).first_chunk().copied())
        .collect();
    let fields = fields?;
    // fields that depend on the acceleration are others elsewhere
    let halfway = times(0.5, &plus(&e, &triple.e));
    let force = declaration.force(h, leg(&halfway).any(), &halfway);
    let rows = declaration.declared(h, leg(&halfway).any(), &halfway, &[]);
    let foretold = rows.iter().skip(constraints).zip(&fields).all(|(row, field)| {
        let terms = field.iter().zip(&force).map(|(u, q)| u * q);
        let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), term| {
            (sum + term, size + f64::abs(term))
        });
        (sum - row).abs() <= FORETOLD * size
    });
    foretold.then_some(fields)
}
