//! Where what is given by pieces changes its piece.

use crate::kernel::Kernel;
use crate::tape::declaration::Declaration;

/// The arguments of whatever a declaration gives by pieces, such as `x - 0.2` of `(x - 0.2).max(0)`, and what it divides by and may be zero, at a time,
/// a position, a velocity and an acceleration, which is asked of third order alone. Where one changes its sign the motion passes a jump or a corner. Empty
/// where a declaration has none.
#[must_use]
pub fn piece_arguments(system: &dyn Kernel, (t, q, v, a): (f64, &[f64], &[f64], &[f64])) -> Vec<f64> {
    let declaration = Declaration::of(system);
    if declaration.switches() == 0 {
        return Vec::new();
    }
    declaration.switch_arguments(t, q, v, a)
}

/// The pieces at a place of a motion, of the same arguments: on which side of zero each of the [`piece_arguments`] is, and between which samples the argument
/// of each table lies. Two places with the same pieces that are near to each other have the same smooth functions between them. `None` where two pieces meet.
#[must_use]
pub fn pieces(system: &dyn Kernel, (t, q, v, a): (f64, &[f64], &[f64], &[f64])) -> Option<Vec<usize>> {
    let declaration = Declaration::of(system);
    let mut pieces = Vec::new();
    for argument in piece_arguments(system, (t, q, v, a)) {
        if argument == 0.0 || argument.is_nan() {
            return None;
        }
        pieces.push(usize::from(argument > 0.0));
    }
    if declaration.has_tables() {
        for table in declaration.tables(t, q, v, a) {
            let places = table.samples.places();
            let before = places.partition_point(|place| *place < table.argument);
            if table.argument.is_nan() || places.get(before) == Some(&table.argument) {
                return None;
            }
            pieces.push(before);
        }
    }
    Some(pieces)
}
