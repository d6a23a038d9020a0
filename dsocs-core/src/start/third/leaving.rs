//! Starts at a jump: the motion has the side of the jump to which it leaves.

use crate::number::point::AnyPoint;
use crate::solve::Vector;
use crate::start::place::Place;
use crate::tape::declaration::Declaration;

/// A start leaves a jump if it has done so after this part of a step.
const BEHIND: f64 = 1e-6;

/// Two places just behind a start, if an argument of a piecewise function changes its sign there, or is zero
/// at the start and not behind it: the motion has the side to which it leaves, as with dry friction on a belt
/// at rest.
pub(super) fn leaving(declaration: &Declaration<'_>, start: &Place, h: f64, a: &[f64]) -> Option<[Place; 2]> {
    if declaration.switches() == 0 {
        return None;
    }
    let at = |steps: f64| {
        let by = steps * h;
        Place {
            t: start.t + by,
            q: start.q.zip(&start.v, |q, v| q + by * v),
            v: start.v.zip(a, |v, a| v + by * a),
            a: Vector::of(a),
        }
    };
    let behind = at(BEHIND);
    let [now, then] = [&at(0.0), &behind].map(|place| place.arguments(declaration));
    let leaves = |(now, then): (&f64, &f64)| *then != 0.0 && now * then <= 0.0;
    now.iter()
        .zip(&then)
        .any(leaves)
        .then(|| [behind, at(2.0 * BEHIND)])
}

/// The place just behind a start that leaves a jump, for a given acceleration.
pub(crate) fn left_to(declaration: &Declaration<'_>, start: AnyPoint<'_, f64>, h: f64) -> Option<Place> {
    let place = Place::of_phase(start.t, Vector::of(start.q), Vector::of(start.v));
    leaving(declaration, &place, h, start.a).map(|[place, _]| place)
}
