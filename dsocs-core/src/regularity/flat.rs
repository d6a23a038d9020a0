//! Constraints on positions whose gradient vanishes where they hold, so that no constraint force exists
//! there.

use super::deficiency::{self, DependentRow};
use crate::tape::declaration::Declaration;

/// Distance from a position, relative to its size, at which a row and its gradient are measured for
/// comparison.
const BESIDE: f64 = 0.1;

/// A row and a gradient below this part of those beside count as zero. A step from a place where both vanish
/// stays within it.
const FLAT: f64 = 1e-2;

/// The first constraint on positions that holds at a position and has zero gradient there.
#[cold]
pub(crate) fn without_gradient(declaration: &Declaration<'_>, t: f64, q: &[f64]) -> Option<DependentRow> {
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
