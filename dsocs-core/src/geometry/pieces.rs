//! Changes of piece of a declaration's piecewise functions.

use crate::kernel::Kernel;
use crate::number::point::AnyPoint;
use crate::tape::declaration::Declaration;

/// The number of changes of piece from one place of a motion to the next, at each of which the acceleration
/// or its slope may jump: each argument of an `if`, `abs`, `max` … that changes its sign, and each sample
/// that the argument of a table passes where a derivative of the table jumps (the third one of a cubic
/// spline). Places are a time, a position, a velocity and an acceleration, which is used in third order
/// alone.
#[must_use]
pub fn corners(system: &dyn Kernel, places: [AnyPoint<'_, f64>; 2]) -> usize {
    let declaration = Declaration::of(system);
    let [before, now] = places.map(|AnyPoint { t, q, v, a }| switch_arguments(&declaration, (t, q, v, a)));
    let pairs = before.iter().zip(&now);
    // an argument that is zero at a place changes there, or touches zero
    let changes = |before: f64, now: f64| before * now < 0.0 || (before != 0.0 && now == 0.0);
    let signs = pairs.filter(|(before, now)| changes(**before, **now)).count();
    if !declaration.has_tables() {
        return signs;
    }
    let [before, now] = places.map(|AnyPoint { t, q, v, a }| declaration.tables(t, q, v, a));
    let tables = before.iter().zip(&now).map(|(before, now)| {
        let samples = now.samples;
        let [least, most] = [
            before.argument.min(now.argument),
            before.argument.max(now.argument),
        ];
        let passed = samples.places().iter().enumerate();
        let passed = passed.filter(|(_, place)| least < **place && **place <= most);
        passed.filter(|(k, _)| samples.is_bent(*k)).count()
    });
    signs + tables.sum::<usize>()
}

/// The arguments of all piecewise functions of a declaration, such as `x - 0.2` of `(x - 0.2).max(0)`, and
/// its divisors that may vanish. Empty if there are none.
fn switch_arguments(declaration: &Declaration<'_>, (t, q, v, a): (f64, &[f64], &[f64], &[f64])) -> Vec<f64> {
    if declaration.switches() == 0 {
        return Vec::new();
    }
    declaration.switch_arguments(t, q, v, a)
}

/// The pieces at a place of a motion (a time, a position, a velocity and an acceleration, which is used in
/// third order alone): the sign of each argument of an `if`, `abs`, `max` …, and the interval between samples
/// that contains the argument of each table. Two nearby places with the same pieces have the same smooth
/// functions between them. `None` where two pieces meet.
#[must_use]
pub fn pieces(system: &dyn Kernel, (t, q, v, a): (f64, &[f64], &[f64], &[f64])) -> Option<Vec<usize>> {
    let declaration = Declaration::of(system);
    let mut pieces = Vec::new();
    for argument in switch_arguments(&declaration, (t, q, v, a)) {
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
