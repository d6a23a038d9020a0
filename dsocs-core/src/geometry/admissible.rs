//! The admissible variations of a discrete path at a node.

use super::array::{along, minus, moving, moving_leg, plus, slopes, square, times, zero};
use super::map::Triple;
use crate::kernel::Kernel;
use crate::number::largest;
use crate::number::point::OwnedLeg;
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::solve::dense::Matrix;
use crate::tape::declaration::Declaration;

/// A pivot below this part of the largest entry is zero.
const PIVOT: f64 = 1e-12;

/// Largest number of iterations for the second difference at which the constraint force vanishes.
const ITERATIONS: u32 = 40;

/// An update below this part of the second difference is the last.
const LAST: f64 = 1e-14;

/// Relative accuracy with which the fields have to reproduce the works at another triple.
const FORETOLD: f64 = 1e-8;

/// A basis of the admissible variations `δq1 ∈ D_V` at a triple, on which the discrete action `S_d = Σ L_d` is stationary (paper,
/// section 3). Each has one component for each coordinate.
///
/// If the constraints' forms `α_j` are known, the result is their kernel. If fields `u` are declared, the rows of the step contain
/// only the works `⟨u, Q⟩`, and the fields are computed from these: at a triple without a force, the derivative of a work is
/// `⟨u, ∂Q⟩`. This triple has the same `q1` and the same `(q2 − q0)/2h`. `None` is returned if the fields depend on more than
/// these two, or if there is no such triple.
#[must_use]
pub fn admissible_variations(system: &dyn Kernel, h: f64, triple: &Triple) -> Option<Vec<Vec<f64>>> {
    let declaration = Declaration::of(system);
    let constraints = declaration.constraints().iter().sum();
    let forms = declaration.forms(h, triple.leg.any(), &triple.e);
    if constraints == 0 || forms.len() == constraints {
        return Some(kernel(declaration.dimension(), forms));
    }
    fields(&declaration, h, triple, constraints)
}

/// A basis of the common kernel of some forms, by elimination.
fn kernel(coordinates: usize, mut rows: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut pivots: Vec<usize> = Vec::new();
    for k in 0..rows.len() {
        let row = &rows[k];
        let pivot = (0..coordinates).max_by(|&i, &j| row[i].abs().total_cmp(&row[j].abs()));
        let Some(pivot) = pivot.filter(|&j| row[j] != 0.0) else {
            continue;
        };
        let row = times(row[pivot].recip(), row);
        for (i, other) in rows.iter_mut().enumerate() {
            if i != k {
                let size = largest(other);
                *other = minus(other, &times(other[pivot], &row));
                other[pivot] = 0.0;
                for x in other.iter_mut().filter(|x| x.abs() <= PIVOT * size) {
                    *x = 0.0;
                }
            }
        }
        rows[k] = row;
        pivots.push(pivot);
    }
    rows.retain(|row| row.iter().any(|x| *x != 0.0));
    let free = (0..coordinates).filter(|j| !pivots.contains(j));
    free.map(|j| {
        let mut vector = along(coordinates, j, 1.0);
        for (row, &pivot) in rows.iter().zip(&pivots) {
            vector[pivot] = -row[j];
        }
        vector
    })
    .collect()
}

/// The fields, from the works at a triple without a force.
fn fields(
    declaration: &Declaration<'_>,
    h: f64,
    triple: &Triple,
    constraints: usize,
) -> Option<Vec<Vec<f64>>> {
    let n = declaration.dimension();
    let zero = zero(n);
    // q1 and d + e/2 stay constant
    let middle = plus(&triple.leg.d, &times(0.5, &triple.e));
    let leg = |e: &[f64]| OwnedLeg {
        t: triple.leg.t,
        q: triple.leg.q.clone(),
        d: minus(&middle, &times(0.5, e)),
    };
    let mut e = triple.e.clone();
    let mut found = false;
    for _ in 0..ITERATIONS {
        let mut by_e = square(n);
        for (j, column) in by_e.iter_mut().enumerate() {
            let unit = along(n, j, 1.0);
            let leg = moving_leg(leg(&e).any(), &zero, &times(-0.5, &unit));
            let force = declaration.force(Tangent::splat(h), leg.any(), &moving(&e, &unit));
            *column = slopes(&force, 1.0);
        }
        let force = declaration.force(h, leg(&e).any(), &e);
        let matrix = Matrix::from_fn(n, n, |i, j| by_e[j][i]);
        if !matrix.is_finite() || force.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let change = matrix.decomposed().solve(&force, 0.0);
        e = minus(&e, &change);
        if largest(&change) <= LAST * largest(&e).max(largest(&middle)) {
            found = true;
            break;
        }
    }
    if !found {
        return None;
    }
    // ∂⟨u, Q⟩ = ⟨u, ∂Q⟩ where Q is zero
    let free = leg(&e);
    let free = moving_leg(free.any(), &zero, &zero);
    let mut works: Vec<Vec<f64>> = Vec::new();
    let mut by_e = square(n);
    for (j, by_e) in by_e.iter_mut().enumerate() {
        let moved = moving(&e, &along(n, j, 1.0));
        *by_e = slopes(&declaration.force(Tangent::splat(h), free.any(), &moved), 1.0);
        let rows = declaration.declared(Tangent::splat(h), free.any(), &moved, &[]);
        for (k, row) in rows.iter().skip(constraints).enumerate() {
            if works.len() <= k {
                works.push(zero.clone());
            }
            works[k][j] = row.derivative();
        }
    }
    let matrix = Matrix::from_fn(n, n, |i, j| by_e[i][j]);
    if !matrix.is_finite() || works.iter().flatten().any(|x| !x.is_finite()) {
        return None;
    }
    let decomposed = matrix.decomposed();
    let fields: Vec<Vec<f64>> = works.iter().map(|work| decomposed.solve(work, 0.0)).collect();
    // fields that depend on the acceleration differ at another triple
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
