//! The slope of errors by the step, in logarithms.

/// The number of errors in a fit: the smallest that are above rounding. Larger steps may be too large for a
/// power law.
pub const FITTED_POINTS: usize = 4;

/// Slopes from error to error that differ by more are those of no power.
const SCATTERS: f64 = 0.5;

/// An error is also rounding, where it stops falling, if it is below the first number, and more than the
/// second times the error with twice the step. Where a factor that was divided out passes through zero,
/// rounding is divided by it.
const STOPPED_FALLING: [f64; 2] = [1e-6, core::f64::consts::FRAC_1_SQRT_2];

/// The last points, in order of decreasing steps, that are above the plateau of rounding; `None` if they are
/// too few for a slope.
pub fn above_plateau(plateau: f64, mut points: Vec<[f64; 2]>) -> Option<Vec<[f64; 2]>> {
    points.retain(|[_, value]| *value > plateau || value.is_nan());
    let last = points.split_off(points.len().saturating_sub(FITTED_POINTS));
    (last.len() > 2).then_some(last)
}

/// The index from which on errors have stopped falling and are rounding.
pub fn start_of_rounding(points: &[[f64; 2]]) -> Option<usize> {
    let stops =
        |pair: &[[f64; 2]]| pair[1][1] < STOPPED_FALLING[0] && pair[1][1] > STOPPED_FALLING[1] * pair[0][1];
    Some(points.windows(2).position(stops)? + 1)
}

/// Whether points are on no line: the slopes from each to the next differ.
pub fn scatter(points: &[[f64; 2]]) -> bool {
    let slopes = points.windows(2).map(fitted_slope);
    let [least, most] = slopes.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], slope| {
        [least.min(slope), most.max(slope)]
    });
    most - least > SCATTERS
}

/// The slope of the line through the logarithms of some points.
pub fn fitted_slope(points: &[[f64; 2]]) -> f64 {
    let count = points.len() as f64;
    let logarithm = |k: usize| points.iter().map(move |point| point[k].ln());
    let mean = |k: usize| logarithm(k).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let (mut above, mut below) = (0.0, 0.0);
    for (h, error) in logarithm(0).zip(logarithm(1)) {
        above += (h - x) * (error - y);
        below += (h - x).powi(2);
    }
    above / below
}
