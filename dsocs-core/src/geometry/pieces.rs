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
