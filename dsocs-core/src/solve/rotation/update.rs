//! How much of an update of a position is taken, where it would turn bodies far.

use super::longest_square;

/// An update turns a body by no more, in rad: a row that is the sine of an angle leads from 1.2 rad on to the other side of the circle.
const FARTHEST: f64 = 0.4;

/// The largest power of a half that, as a part of an update, turns no body farther. It is the same for updates nearby, so that what is made of it has
/// derivatives.
pub(crate) fn part_of_update(rotations: &[usize], update: &[f64]) -> f64 {
    let longest = longest_square(rotations, update).sqrt();
    let mut part = 1.0;
    while part * longest > FARTHEST && longest.is_finite() {
        part *= 0.5;
    }
    part
}
