//! A solver with a setting, ready to run.

/// Solves a problem and appends the measured components at every time of the grid; `false` if it gives up.
pub type Run = Box<dyn Fn(&mut Vec<f64>) -> bool>;

/// A solver with a setting.
pub struct Candidate {
    /// The solver's name; those of this library begin with `dsocs`.
    pub solver: &'static str,
    /// The setting, such as `tolerance 1e-6`.
    pub setting: String,
    /// Solves the problem.
    pub run: Run,
    /// Returns the mean time of this many solutions, in s, where another process solves the problem.
    pub clock: Option<Box<dyn Fn(u32) -> f64>>,
}

impl Candidate {
    /// A solver with a tolerance.
    pub fn tolerance(
        solver: &'static str,
        tolerance: f64,
        run: impl Fn(&mut Vec<f64>) -> bool + 'static,
    ) -> Self {
        Self {
            solver,
            setting: format!("tolerance {tolerance:.0e}"),
            run: Box::new(run),
            clock: None,
        }
    }
}

/// Tolerances from `10^-from` to `10^-to`, two a decade.
pub fn tolerances(from: i32, to: i32) -> impl Iterator<Item = f64> {
    (from..to)
        .flat_map(|k| [10.0_f64.powi(-k), 3.0 * 10.0_f64.powi(-k - 1)])
        .chain([10.0_f64.powi(-to)])
}
