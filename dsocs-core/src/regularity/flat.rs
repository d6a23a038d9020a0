//! Constraints on positions or velocities whose gradient vanishes where they hold, so that they determine no constraint force
//! there.

use super::deficiency::{self, DependentRow};
use crate::number::point::{AnyLeg, map};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::solve::dense::Matrix;
use crate::tape::declaration::Declaration;

/// Distance from a position, relative to its size, at which a row and its gradient are measured for
/// comparison.
const BESIDE: f64 = 0.1;

/// A row and a gradient below this part of those beside count as zero. A step from a place where both vanish
/// stays within it.
const FLAT: f64 = 1e-2;

/// A velocity is near that of a leg if they differ by at most this many of the changes in a step.
const NEAR: f64 = 10.0;

/// The first constraint that holds with zero gradient at the position of a step with the second difference `e`, or at a velocity near its own.
#[cold]
pub(crate) fn without_gradient(
    declaration: &Declaration<'_>,
    h: f64,
    leg: AnyLeg<'_, f64>,
    e: &[f64],
) -> Option<DependentRow> {
    let by_velocity = || {
        let [holonomic, nonholonomic, _] = declaration.constraints();
        let mut places = holonomic..holonomic + nonholonomic;
        let place = places.find(|&place| is_flat(declaration, h, leg, e, place))?;
        Some(deficiency::row(declaration, place))
    };
    by_position(declaration, leg.t, leg.q).or_else(by_velocity)
}

/// Whether a constraint on velocities holds with zero gradient at a velocity near that of a step, as `ẋ² + ẏ² = c² ż²` does at rest. It is looked for
/// by one of Newton's iterations for a zero of the gradient, which is right for a quadratic form.
fn is_flat(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, e: &[f64], place: usize) -> bool {
    let n = leg.q.len();
    let v = map(leg.d, |d| d / h);
    let size = e.iter().fold(0.0_f64, |size, e| size.max((e / h).abs()));
    // the row and its gradient at a velocity
    let at = |v: &[f64]| -> (f64, Vec<f64>) {
        let along = |j: usize| {
            let unit = |i: usize| if i == j { 1.0 } else { 0.0 };
            let v: Vec<Tangent> = v
                .iter()
                .enumerate()
                .map(|(i, v)| Tangent::new(*v, unit(i)))
                .collect();
            let rows = declaration.phase(Tangent::splat(leg.t), &map(leg.q, Tangent::splat), &v);
            rows.get(place).copied().unwrap_or(Tangent::splat(f64::NAN))
        };
        let slopes: Vec<Tangent> = (0..n).map(along).collect();
        let value = slopes.first().map_or(f64::NAN, |slope| slope.value());
        (value, slopes.iter().map(|slope| slope.derivative()).collect())
    };
    let (_, gradient) = at(&v);
    let columns: Vec<Vec<f64>> = (0..n)
        .map(|j| {
            let mut moved = v.clone();
            moved[j] += size;
            at(&moved).1
        })
        .collect();
    let second = Matrix::from_fn(n, n, |i, j| (columns[j][i] - gradient[i]) / size);
    let most = (0..n).fold(0.0_f64, |most, i| {
        second.row(i).fold(most, |most, x| most.max(x.abs()))
    });
    // a row that is linear in the velocities has a gradient everywhere, or nowhere
    if !(second.is_finite() && most > 0.0) {
        return false;
    }
    let to = second.decomposed().solve(&gradient, FLAT * most);
    let flat: Vec<f64> = v.iter().zip(&to).map(|(v, to)| v - to).collect();
    let (value, slopes) = at(&flat);
    let small = |x: f64, of: f64| x.abs() <= of;
    to.iter().all(|&to| small(to, NEAR * size))
        && slopes.iter().all(|&slope| small(slope, FLAT * most * size))
        && small(value, FLAT * most * size * size)
}

/// The first constraint on positions that holds at a position and has zero gradient there.
fn by_position(declaration: &Declaration<'_>, t: f64, q: &[f64]) -> Option<DependentRow> {
    let count = declaration.holonomic();
    let still = vec![0.0; q.len()];
    // the size of each row, and of its gradient
    let sizes = |q: &[f64]| -> Vec<[f64; 2]> {
        let mut rows = vec![0.0; count * (1 + q.len())];
        declaration.phase_slopes(false, t, q, &still, &mut rows);
        let (values, slopes) = rows.split_at(count);
        let each = values.iter().zip(slopes.chunks_exact(q.len().max(1)));
        let steepest = |slopes: &[f64]| slopes.iter().fold(0.0_f64, |most, slope| most.max(slope.abs()));
        each.map(|(value, slopes)| [value.abs(), steepest(slopes)])
            .collect()
    };
    if count == 0 {
        return None;
    }
    let largest = q.iter().fold(0.0_f64, |largest, q| largest.max(q.abs()));
    let far = if largest > 0.0 { BESIDE * largest } else { BESIDE };
    let mut beside = vec![[0.0_f64; 2]; count];
    for place in 0..q.len() {
        let mut moved = q.to_vec();
        moved[place] += far;
        for (most, size) in beside.iter_mut().zip(sizes(&moved)) {
            *most = [most[0].max(size[0]), most[1].max(size[1])];
        }
    }
    let mut each = sizes(q).into_iter().zip(beside);
    // false also for a NaN
    let place =
        each.position(|(here, beside)| (0..2).all(|k| beside[k] > 0.0 && here[k] <= FLAT * beside[k]))?;
    Some(deficiency::row(declaration, place))
}
