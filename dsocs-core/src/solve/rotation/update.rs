//! Shortening of an update of positions that would turn bodies far.

use super::longest_square;

/// Largest turn of a body by an update, in rad: for a row that is the sine of an angle, an update from beyond
/// 1.2 rad leads to the other side of the circle.
const FARTHEST: f64 = 0.4;

/// The largest power of ½ that, as a factor of an update, turns no body farther. It is locally constant, so
/// that the shortened update is differentiable.
pub(crate) fn part_of_update(rotations: &[usize], update: &[f64]) -> f64 {
    let longest = longest_square(rotations, update).sqrt();
    let mut part = 1.0;
    while part * longest > FARTHEST && longest.is_finite() {
        part *= 0.5;
    }
    part
}
