//! Hard cases: values (*figures*) that are measured, and the limits that they have to meet (*bars*). `dsocs stability` prints the table.
//!
//! `CASES` are those of the systems of this crate, with their exact solutions and constants; [`any`] has
//! those that apply to any system.
//!
//! Every case is a function that measures one figure after the other and passes each to a `Report`. Random
//! numbers come from a generator with a fixed seed, so the figures are the same in every run on one kind of
//! machine.

pub mod any;
#[cfg(all(feature = "dsocs", not(test)))]
mod library;

use std::error::Error;
use std::time::Instant;

#[cfg(all(feature = "dsocs", not(test)))]
pub use library::{CASES, Case};

/// The limit that a figure has to meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bar {
    /// The figure must not be larger than this limit.
    AtMost(f64),
    /// The figure must not be smaller than this limit.
    AtLeast(f64),
    /// There is no limit; the figure is for information only.
    Reported,
}

impl Bar {
    /// Whether a figure meets the limit. NaN never does, even if there is no limit.
    #[must_use]
    pub fn holds(self, figure: f64) -> bool {
        match self {
            Self::AtMost(bar) => figure <= bar,
            Self::AtLeast(bar) => figure >= bar,
            Self::Reported => !figure.is_nan(),
        }
    }
}

/// One measured value.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The number of the case.
    pub number: u8,
    /// The case's name.
    pub case: &'static str,
    /// The quantity that is measured.
    pub what: String,
    /// The figure; NaN where there is none.
    pub figure: f64,
    /// The bar.
    pub bar: Bar,
    /// The reason, if there is no figure.
    pub failure: Option<String>,
    /// The time of the measurement, in s.
    pub seconds: f64,
}

impl Row {
    /// Whether the figure reaches its bar.
    #[must_use]
    pub fn ok(&self) -> bool {
        self.failure.is_none() && self.bar.holds(self.figure)
    }
}

/// A measured value, or the reason why there is none.
type Measured = Result<f64, Box<dyn Error>>;

/// The failure of a measurement that results in NaN.
const UNDEFINED: &str = "it has no value here: some expression of the declaration, or a derivative of it, has none at a state that is looked at";

/// A number in two or three digits; a dash for none.
pub(crate) fn number(x: f64) -> String {
    if x.is_nan() {
        "–".to_owned()
    } else if x == 0.0 || ((0.01..1e5).contains(&x.abs()) && (x * 100.0).fract() == 0.0) {
        format!("{x}")
    } else if (0.01..1e5).contains(&x.abs()) {
        format!("{x:.3}")
    } else {
        format!("{x:.1e}")
    }
}

/// A time as text: a late one with all the digits that tell one step from the next.
pub(crate) fn written_time(t: f64) -> String {
    if t.abs() < 1e5 || !t.is_finite() {
        number(t)
    } else {
        format!("{t:.3}")
    }
}

/// A figure, or NaN and the reason why there is none.
pub(crate) fn measured_or_reason(measured: Measured) -> (f64, Option<String>) {
    match measured {
        Ok(figure) if figure.is_nan() => (figure, Some(UNDEFINED.to_owned())),
        Ok(figure) => (figure, None),
        Err(error) => (f64::NAN, Some(error.to_string())),
    }
}

/// The figures of one case.
struct Report<'a> {
    /// The number of the case.
    number: u8,
    /// Its name.
    case: &'static str,
    /// Whether cases that take more than seconds are shortened.
    quick: bool,
    /// The figures so far.
    rows: Vec<Row>,
    /// Receives every figure.
    done: &'a mut dyn FnMut(&Row),
}

impl Report<'_> {
    /// Measures a figure.
    fn measure(&mut self, what: impl Into<String>, bar: Bar, figure: impl FnOnce() -> Measured) {
        let begun = Instant::now();
        let measured = figure();
        self.push(what.into(), bar, measured, begun);
    }

    /// Measures several figures together; each has the time of all.
    #[cfg(all(feature = "dsocs", not(test)))]
    fn measure_all<const K: usize>(
        &mut self,
        whats: [(String, Bar); K],
        figures: impl FnOnce() -> Result<[f64; K], Box<dyn Error>>,
    ) {
        let begun = Instant::now();
        let figures = figures().map_err(|error| error.to_string());
        self.push_all(whats.into(), figures.as_ref().map(|figures| &figures[..]), begun);
    }

    /// Adds several figures that were measured together.
    #[cfg(all(feature = "dsocs", not(test)))]
    fn push_all(&mut self, whats: Vec<(String, Bar)>, figures: Result<&[f64], &String>, begun: Instant) {
        for (place, (what, bar)) in whats.into_iter().enumerate() {
            let figure = match figures {
                Ok(figures) => Ok(figures[place]),
                Err(error) => Err(error.as_str().into()),
            };
            self.push(what, bar, figure, begun);
        }
    }

    /// Adds a figure.
    fn push(&mut self, what: String, bar: Bar, measured: Measured, begun: Instant) {
        let seconds = begun.elapsed().as_secs_f64();
        let (figure, failure) = measured_or_reason(measured);
        let row = Row {
            number: self.number,
            case: self.case,
            what,
            figure,
            bar,
            failure,
            seconds,
        };
        (self.done)(&row);
        self.rows.push(row);
    }
}

/// The larger of two numbers; NaN if either is, which `f64::max` would ignore.
pub(crate) fn larger(x: f64, y: f64) -> f64 {
    if x >= y || x.is_nan() { x } else { y }
}

/// The largest difference of two vectors' components; NaN if one is.
fn distance(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, larger)
}
