//! Accelerations at the start that Newton's iteration does not find from zero.

use crate::solve::Vector;

/// The sizes of the initial guesses for the acceleration, used with both signs.
const GUESSES: [f64; 13] = [
    1.0, 1e-1, 1e1, 1e-2, 1e2, 1e-3, 1e3, 1e-4, 1e4, 1e-5, 1e5, 1e-6, 1e6,
];

/// Solutions that differ by less than this part of themselves are the same.
const SAME: f64 = 1e-9;

/// The only acceleration that is found from guesses of all sizes, if none is found from zero, where a law
/// such as `a³ = 8` is flat. `None` if there are several, between which the user has to choose.
#[cold]
pub(super) fn only(n: usize, unknowns: usize, solve: &dyn Fn(&Vector) -> Option<Vector>) -> Option<Vector> {
    let mut only: Option<Vector> = None;
    for size in GUESSES.into_iter().flat_map(|size| [size, -size]) {
        let guess = Vector::from_fn(unknowns, |i| if i < n { size } else { 0.0 });
        let Some(found) = solve(&guess) else { continue };
        let Some(known) = &only else {
            only = Some(found);
            continue;
        };
        let length = known.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let mut pairs = known.iter().zip(found.iter());
        if !pairs.all(|(one, other)| (one - other).abs() <= SAME * length) {
            return None;
        }
    }
    only
}
