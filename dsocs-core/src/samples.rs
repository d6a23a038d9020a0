//! Sampled functions: a measured wind, a planned torque.

use std::path::{Path, PathBuf};
use std::{fs, io};

use thiserror::Error;

use crate::number::real::Real;

/// A function of one variable that interpolates samples by straight lines or cubic polynomials. A sample is a
/// place (a value of the argument) and the value of the function there.
///
/// A declaration calls [`Samples::at`] like any other function, with the time or a coordinate as argument. Before the first and after the
/// last sample the function is constant.
///
/// Where two pieces meet, a derivative jumps: the first one for straight lines ([`Samples::linear`]), the
/// second for monotone cubics ([`Samples::monotone`]), the third for a spline ([`Samples::cubic`]). This does
/// not lower the order 2 of the step. A step of a [`TaylorFlow`](crate::TaylorFlow) ends at such a place.
///
/// ```
/// use dsocs_core::prelude::*;
/// use dsocs_core::Samples;
///
/// /// A mass that is pushed by a planned force.
/// #[dsocs {
///     coordinates(x);
///     lagrangian = mass * dot(x).powi(2) / 2;
///     external_forces = push.at(t);
/// }]
/// struct Mass {
///     mass: f64,
///     push: Samples,
/// }
///
/// // up to 1 N in a second, and down again
/// let push = Samples::linear([(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)])?;
/// let mass = Mass { mass: 1.0, push };
/// let start = Start::second_order([0.0], [0.0]);
/// let mut flow = TaylorFlow::new(&mass, start, Tolerance::relative(1e-14))?;
/// let node = flow.to(2.0)?;
/// assert!((node.v[0] - 1.0).abs() < 1e-15 && (node.q[0] - 1.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// The places, in ascending order.
    places: Vec<f64>,
    /// Coefficients of each piece in powers of the distance from its place; the last one is the constant
    /// value beyond.
    pieces: Vec<[f64; 4]>,
}

/// A jump of a slope or a curvature above this relative size is not rounding.
pub(crate) const BENDS: f64 = 1e-6;

/// Samples that do not define a function.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SamplesError {
    /// There are no samples.
    #[error("expected at least one sample")]
    None,
    /// A place or a value is infinite or not a number.
    #[error("sample {index} is ({place}, {value}); expected finite numbers")]
    NotFinite {
        /// Its index, from 0.
        index: usize,
        /// The place.
        place: f64,
        /// The value.
        value: f64,
    },
    /// A place is not beyond the one before it.
    #[error(
        "sample {index} is at {place}, and the one before it at {before}; expected places in ascending order"
    )]
    Order {
        /// Its index, from 0.
        index: usize,
        /// Its place.
        place: f64,
        /// The place before.
        before: f64,
    },
    /// A file of samples cannot be read.
    #[error("cannot read {}: {cause}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The reason.
        cause: String,
    },
    /// A line of a file is no sample.
    #[error("line {line} of {} has {found}; expected a place and a value, two numbers", .file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// The number of the line, from 1.
        line: usize,
        /// A description of its columns, without their content: the file may be confidential.
        found: String,
    },
}

crate::debug_is_message!(SamplesError);

impl Samples {
    /// Straight lines from sample to sample. A sample is a place and a value.
    ///
    /// # Errors
    ///
    /// [`SamplesError`] if there is no sample, one is not finite, or the places do not ascend.
    pub fn linear(samples: impl IntoIterator<Item = (f64, f64)>) -> Result<Self, SamplesError> {
        let (places, values) = checked(samples)?;
        let pieces = slopes(&places, &values);
        let mut pieces: Vec<_> = (pieces.iter().zip(&values))
            .map(|(&slope, &value)| [value, slope, 0.0, 0.0])
            .collect();
        pieces.extend(values.last().map(|&last| [last, 0.0, 0.0, 0.0]));
        Ok(Self { places, pieces })
    }

    /// The cubic spline through samples; a sample is a place and a value. It is twice continuously differentiable, with the end conditions
    /// "not a knot": at the second and the last but one place the third derivative is continuous, too. For a smooth function its error is of
    /// fourth order in the distances of the places.
    ///
    /// # Errors
    ///
    /// The errors of [`Samples::linear`].
    pub fn cubic(samples: impl IntoIterator<Item = (f64, f64)>) -> Result<Self, SamplesError> {
        let (places, values) = checked(samples)?;
        let chords = slopes(&places, &values);
        let lengths = lengths(&places);
        let tangents = tangents(&lengths, &chords);
        Ok(Self::hermite(places, &values, (&lengths, &chords), &tangents))
    }

    /// Monotone cubic polynomials: between two samples the function lies between their values, and it rises
    /// or falls where they do. It is once continuously differentiable. For a smooth monotone function its
    /// error is at least of third order in the distances of the places; near an extremum it is of second
    /// order, since the curve is flat at an extremal sample.
    ///
    /// The slopes at the samples are weighted harmonic means of those of the chords (F. N. Fritsch and J. Butland, *A method for constructing
    /// local monotone piecewise cubic interpolants*, SIAM J. Sci. Stat. Comput. 5, 1984), as in `PchipInterpolator` of scipy.
    ///
    /// ```
    /// use dsocs_core::Samples;
    ///
    /// // a valve that opens: a spline would swing below 0 and above 1
    /// let valve = Samples::monotone([(0.0, 0.0), (1.0, 0.0), (1.1, 1.0), (2.0, 1.0)])?;
    /// assert!((0..=200).all(|k| (0.0..=1.0).contains(&valve.at(0.01 * f64::from(k)))));
    /// # Ok::<(), dsocs_core::SamplesError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// The errors of [`Samples::linear`].
    pub fn monotone(samples: impl IntoIterator<Item = (f64, f64)>) -> Result<Self, SamplesError> {
        let (places, values) = checked(samples)?;
        let (lengths, chords) = (lengths(&places), slopes(&places, &values));
        let tangents = monotone_tangents(&lengths, &chords);
        Ok(Self::hermite(places, &values, (&lengths, &chords), &tangents))
    }

    /// Reads the samples of a text file, such as a `.csv` file: each line has a place and a value, separated
    /// by a comma, a semicolon or blanks. A first line of column names, empty lines and lines that begin with
    /// `#` are skipped.
    ///
    /// ```
    /// use dsocs_core::Samples;
    ///
    /// # let folder = std::env::temp_dir().join(format!("dsocs-samples-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder)?;
    /// # let file = folder.join("wind.csv");
    /// std::fs::write(&file, "time,wind\n0,1.5\n1,2.5\n")?;
    /// let wind = Samples::monotone(Samples::read(&file)?)?;
    /// assert_eq!(wind.at(0.5), 2.0);
    /// # std::fs::remove_dir_all(folder)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`SamplesError::File`] if the file cannot be read; [`SamplesError::Line`] if a line does not have
    /// exactly two numbers.
    pub fn read(file: impl AsRef<Path>) -> Result<Vec<(f64, f64)>, SamplesError> {
        let file = file.as_ref();
        let refused = |error: io::Error| SamplesError::File {
            file: file.to_owned(),
            cause: plainly(&error),
        };
        let text = fs::read_to_string(file).map_err(refused)?;
        let lines = text
            .trim_start_matches('\u{feff}')
            .lines()
            .map(str::trim)
            .enumerate();
        let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let mut samples = Vec::new();
        for (row, (number, line)) in lines.enumerate() {
            let fields = line
                .split([',', ';', '\t', ' '])
                .map(|field| field.trim().trim_matches('"'));
            let numbers: Vec<Option<f64>> = (fields.filter(|field| !field.is_empty()))
                .map(|field| field.parse().ok())
                .collect();
            match numbers.as_slice() {
                &[Some(place), Some(value)] => samples.push((place, value)),
                // column names
                names if row == 0 && names.iter().all(Option::is_none) => {}
                _ => {
                    return Err(SamplesError::Line {
                        file: file.to_owned(),
                        line: number + 1,
                        found: columns(&numbers, line),
                    });
                }
            }
        }
        Ok(samples)
    }

    /// Piecewise cubic polynomials with these values and slopes at the samples.
    fn hermite(
        places: Vec<f64>,
        values: &[f64],
        (lengths, chords): (&[f64], &[f64]),
        tangents: &[f64],
    ) -> Self {
        let mut pieces: Vec<_> = (0..chords.len())
            .map(|i| {
                let (h, chord, [left, right]) = (lengths[i], chords[i], [tangents[i], tangents[i + 1]]);
                let bend = (left + right - 2.0 * chord) / h;
                [values[i], left, (chord - left) / h - bend, bend / h]
            })
            .collect();
        pieces.extend(values.last().map(|&last| [last, 0.0, 0.0, 0.0]));
        Self { places, pieces }
    }

    /// The places of the samples, in ascending order.
    #[must_use]
    pub fn places(&self) -> &[f64] {
        &self.places
    }

    /// The value at a place. Where two pieces meet, the right one is evaluated.
    #[must_use]
    pub fn at<R: Real>(&self, x: R) -> R {
        let place = x.piece(&self.places);
        let [from, a, b, c, d] = self.polynomial(place);
        // constant before the first and after the last sample
        if place == 0 || place == self.places.len() {
            return R::from(a);
        }
        let x = x - from;
        ((x * d + c) * x + b) * x + a
    }

    /// The jump of the slope at sample `index`, relative to the larger slope beside it.
    pub(crate) fn bend(&self, index: usize) -> f64 {
        let slope = |piece: Option<usize>, end: bool| {
            let Some(piece) = piece.filter(|piece| piece + 1 < self.places.len()) else {
                return 0.0;
            };
            let [_, b, c, d] = self.pieces[piece];
            let x = if end {
                self.places[piece + 1] - self.places[piece]
            } else {
                0.0
            };
            (3.0 * d * x + 2.0 * c) * x + b
        };
        let [before, after] = [slope(index.checked_sub(1), true), slope(Some(index), false)];
        let jump = (after - before).abs();
        if jump > 0.0 {
            jump / before.abs().max(after.abs())
        } else {
            0.0
        }
    }

    /// Whether a derivative of order one to three jumps at sample `index`, by more than rounding.
    pub(crate) fn is_bent(&self, index: usize) -> bool {
        // the second derivative at both ends of a piece, and the third derivative times its length
        let derivatives = |piece: Option<usize>| {
            let Some(piece) = piece.filter(|piece| piece + 1 < self.places.len()) else {
                return [0.0; 3];
            };
            let [_, _, c, d] = self.pieces[piece];
            let length = self.places[piece + 1] - self.places[piece];
            [2.0 * c, 2.0 * c + 6.0 * d * length, 6.0 * d * length]
        };
        let [before, after] = [index.checked_sub(1), Some(index)].map(derivatives);
        let all = before.into_iter().chain(after);
        let largest = all.fold(0.0, |most: f64, x| x.abs().max(most));
        let jumps = |jump: f64| jump.abs() > BENDS * largest;
        self.bend(index) > BENDS || jumps(after[0] - before[1]) || jumps(after[2] - before[2])
    }

    /// The origin and the coefficients (from order 0 on) of the piece at an argument not below the first
    /// `places` places.
    pub(crate) fn polynomial(&self, places: usize) -> [f64; 5] {
        let index = places.saturating_sub(1);
        let (Some(&piece), Some(&from)) = (self.pieces.get(index), self.places.get(index)) else {
            return [f64::NAN; 5];
        };
        // constant before the first sample
        let [a, b, c, d] = if places == 0 {
            [piece[0], 0.0, 0.0, 0.0]
        } else {
            piece
        };
        [from, a, b, c, d]
    }
}

/// The operating system's message for an error, without the error number.
pub(crate) fn plainly(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "reading it is not allowed".to_owned(),
        io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        io::ErrorKind::InvalidData => "it is no text in UTF-8".to_owned(),
        _ => {
            let said = error.to_string();
            said.split(" (os error").next().unwrap_or_default().to_owned()
        }
    }
}

/// Describes the columns of a line that is not two numbers, without their content.
fn columns(numbers: &[Option<f64>], line: &str) -> String {
    let point = if line.contains(';') && line.contains(',') {
        " (a decimal has a point)"
    } else {
        ""
    };
    match numbers.iter().position(Option::is_none) {
        Some(column) if numbers.len() == 2 => format!("no number in column {}{point}", column + 1),
        _ => match numbers.len() {
            1 => "one column".to_owned(),
            count => format!("{count} columns{point}"),
        },
    }
}

/// Checks that places and values are finite and places ascend.
fn checked(samples: impl IntoIterator<Item = (f64, f64)>) -> Result<(Vec<f64>, Vec<f64>), SamplesError> {
    let (mut places, mut values) = (Vec::<f64>::new(), Vec::new());
    for (index, (place, value)) in samples.into_iter().enumerate() {
        if !place.is_finite() || !value.is_finite() {
            return Err(SamplesError::NotFinite { index, place, value });
        }
        if let Some(&before) = places.last().filter(|&&before| place <= before) {
            return Err(SamplesError::Order { index, place, before });
        }
        places.push(place);
        values.push(value);
    }
    if places.is_empty() {
        return Err(SamplesError::None);
    }
    Ok((places, values))
}

/// The slopes of the chords.
fn slopes(places: &[f64], values: &[f64]) -> Vec<f64> {
    let values = values.windows(2).map(|pair| pair[1] - pair[0]);
    let places = places.windows(2).map(|pair| pair[1] - pair[0]);
    values.zip(places).map(|(rise, run)| rise / run).collect()
}

/// The distances of the places.
fn lengths(places: &[f64]) -> Vec<f64> {
    places.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// Slopes at the samples for monotone cubic polynomials: at most three times those of the chords beside them,
/// and zero at extrema.
fn monotone_tangents(lengths: &[f64], chords: &[f64]) -> Vec<f64> {
    let last = chords.len();
    match last {
        0 => return vec![0.0],
        1 => return vec![chords[0]; 2],
        _ => {}
    }
    // one-sided slope of the parabola through three samples, limited to keep the piece monotone
    let end = |near: usize, far: usize| {
        let (h, k, chord, next) = (lengths[near], lengths[far], chords[near], chords[far]);
        let slope = ((2.0 * h + k) * chord - h * next) / (h + k);
        if slope * chord <= 0.0 {
            0.0
        } else if chord * next <= 0.0 && slope.abs() > 3.0 * chord.abs() {
            3.0 * chord
        } else {
            slope
        }
    };
    let mut tangents = Vec::with_capacity(last + 1);
    tangents.push(end(0, 1));
    for i in 1..last {
        let ([h, k], [left, right]) = ([lengths[i - 1], lengths[i]], [chords[i - 1], chords[i]]);
        let turns = left == 0.0 || right == 0.0 || (left > 0.0) != (right > 0.0);
        let weights = [2.0 * k + h, k + 2.0 * h];
        let mean = (weights[0] + weights[1]) / (weights[0] / left + weights[1] / right);
        tangents.push(if turns { 0.0 } else { mean });
    }
    tangents.push(end(last - 1, last - 2));
    tangents
}

/// The slopes of the spline at the samples, by elimination of a tridiagonal system (de Boor, *A Practical Guide to Splines*, chapter IV).
fn tangents(lengths: &[f64], chords: &[f64]) -> Vec<f64> {
    let last = chords.len();
    if last == 0 {
        return vec![0.0];
    }
    if last == 1 {
        return vec![chords[0]; 2];
    }
    if last == 2 {
        // the parabola through three samples
        let bend = (chords[1] - chords[0]) / (lengths[0] + lengths[1]);
        return vec![
            chords[0] - lengths[0] * bend,
            chords[0] + lengths[0] * bend,
            chords[1] + lengths[1] * bend,
        ];
    }
    // lower, diagonal and upper entries, and the right-hand side
    let mut rows: Vec<[f64; 4]> = Vec::with_capacity(last + 1);
    let end = |near: f64, far: f64, chord: f64, next: f64| {
        ((near + 2.0 * (near + far)) * far * chord + near * near * next) / (near + far)
    };
    let (h, k) = (lengths[0], lengths[1]);
    rows.push([0.0, k, h + k, end(h, k, chords[0], chords[1])]);
    for i in 1..last {
        let (h, k) = (lengths[i - 1], lengths[i]);
        rows.push([k, 2.0 * (h + k), h, 3.0 * (k * chords[i - 1] + h * chords[i])]);
    }
    let (h, k) = (lengths[last - 1], lengths[last - 2]);
    rows.push([h + k, k, 0.0, end(h, k, chords[last - 1], chords[last - 2])]);
    for i in 1..=last {
        let [_, pivot, upper, right] = rows[i - 1];
        let factor = rows[i][0] / pivot;
        rows[i][1] -= factor * upper;
        rows[i][3] -= factor * right;
    }
    let mut tangents = vec![0.0; last + 1];
    for i in (0..=last).rev() {
        let [_, pivot, upper, right] = rows[i];
        let beyond = tangents.get(i + 1).copied().unwrap_or(0.0);
        tangents[i] = (right - upper * beyond) / pivot;
    }
    tangents
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::dual::Dual;

    #[test]
    fn a_spline_through_a_cubic_is_the_cubic() {
        let cubic = |x: f64| x * x * x - 2.0 * x * x + 0.5;
        let places = [-1.0, -0.4, 0.3, 0.5, 1.7, 2.0];
        let samples = Samples::cubic(places.map(|x| (x, cubic(x)))).unwrap();
        for k in 0..=300 {
            let x = -1.0 + 0.01 * f64::from(k);
            assert!((samples.at(x) - cubic(x)).abs() < 1e-13, "{x}");
            let slope = samples.at(Dual::new(x.min(1.999), 1.0)).eps;
            let x = x.min(1.999);
            assert!((slope - (3.0 * x * x - 4.0 * x)).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn a_spline_is_of_fourth_order_and_twice_differentiable() {
        let error = |count: i32| {
            let h = 2.0 / f64::from(count);
            let samples =
                Samples::cubic((0..=count).map(|k| (h * f64::from(k), (h * f64::from(k)).sin()))).unwrap();
            (0..=1000)
                .map(|k| 0.002 * f64::from(k))
                .map(|x| (samples.at(x) - x.sin()).abs())
                .fold(0.0, f64::max)
        };
        let order = (error(20) / error(40)).log2();
        assert!((order - 4.0).abs() < 0.2, "{order}");
        let samples = Samples::cubic([(0.0, 1.0), (1.0, -1.0), (1.5, 0.3), (3.0, 0.2), (3.1, 2.0)]).unwrap();
        for &knot in &samples.places()[1..4] {
            let second = |x: f64| {
                samples
                    .at(Dual::new(Dual::new(x, 1.0), Dual::new(1.0, 0.0)))
                    .eps
                    .eps
            };
            let [left, right] = [knot - 1e-9, knot + 1e-9].map(second);
            assert!(
                (left - right).abs() < 1e-6 * (1.0 + left.abs()),
                "{knot}: {left} {right}"
            );
        }
    }

    /// Pseudorandom numbers between -1 and 1.
    fn draws(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as f64) / f64::from(1_u32 << 30) - 1.0
        }
    }

    #[test]
    fn a_monotone_curve_does_not_overshoot() {
        for seed in 0..200 {
            let mut draw = draws(seed);
            let mut place = 0.0;
            let samples: Vec<(f64, f64)> = (0..9)
                .map(|_| {
                    place += 1e-3 + draw().abs();
                    // some are equal, magnitudes differ
                    let value = (2.0 * draw()).round() * 10_f64.powf(2.0 * draw());
                    (place, value)
                })
                .collect();
            let curve = Samples::monotone(samples.clone()).unwrap();
            let mut spline_overshoots = false;
            let spline = Samples::cubic(samples.clone()).unwrap();
            for pair in samples.windows(2) {
                let [(from, left), (to, right)] = [pair[0], pair[1]];
                let (low, high) = (left.min(right), left.max(right));
                // rounding of the terms of a cubic
                let slack = 1e-13 * left.abs().max(right.abs());
                let mut before = left;
                for k in 1..=50 {
                    let x = from + (to - from) * f64::from(k) / 50.0;
                    let value = if k == 50 { right } else { curve.at(x) };
                    assert!(low - slack <= value && value <= high + slack, "{seed} at {x}");
                    assert!(
                        (value - before) * (right - left) >= -slack * (right - left).abs(),
                        "{seed} at {x}"
                    );
                    before = value;
                    let value = spline.at(x);
                    spline_overshoots |= value < low - 1e-3 || value > high + 1e-3;
                }
            }
            assert!(spline_overshoots, "{seed}: a spline would do as well");
            // the slope is continuous
            for around in samples.windows(3) {
                let slope = |x: f64| curve.at(Dual::new(x, 1.0)).eps;
                let [before, (knot, value), after] = [around[0], around[1], around[2]];
                // on both sides, the slopes differ by less than a fraction of their bound
                let narrow = (knot - before.0).min(after.0 - knot);
                let [left, right] = [knot - 1e-7 * narrow, knot + 1e-7 * narrow].map(slope);
                let rise = (value - before.1).abs().max((after.1 - value).abs());
                assert!(
                    (left - right).abs() <= 1e-5 * rise / narrow,
                    "{seed}: {left} {right}"
                );
            }
        }
    }

    #[test]
    fn a_monotone_curve_is_of_third_order() {
        let error = |count: i32| {
            let h = 1.0 / f64::from(count);
            let samples = (0..=count).map(|k| (h * f64::from(k), (h * f64::from(k)).exp()));
            let samples = Samples::monotone(samples).unwrap();
            (0..1000)
                .map(|k| 0.001 * f64::from(k))
                .map(|x| (samples.at(x) - x.exp()).abs())
                .fold(0.0, f64::max)
        };
        let order = (error(40) / error(80)).log2();
        assert!(order > 2.9, "{order}");
    }

    /// Compared with `PchipInterpolator` of scipy 1.17.1.
    #[test]
    fn a_monotone_curve_by_another_hand() {
        const AT: [f64; 8] = [0.25, 0.75, 1.2, 1.45, 2.0, 2.9, 3.1, 3.7];
        for (values, expected) in [
            (
                [0.0, 1.0, 4.0, 4.5, 2.0],
                [
                    0.068_965_517_241_379_31,
                    0.581_896_551_724_137_9,
                    2.154_440_099_537_859_4,
                    3.894_317_454_674_724_6,
                    4.294_578_083_237_877,
                    4.498_248_186_330_660_5,
                    4.4627,
                    3.074_099_999_999_999,
                ],
            ),
            (
                [0.0, 3.0, 1.0, -4.0, -4.5],
                [
                    1.546_875_000_000_000_2,
                    2.890_624_999_999_999_6,
                    2.473_230_769_230_769_3,
                    1.205_538_461_538_462,
                    -1.024_728_085_501_566_4,
                    -3.887_079_126_725_536_7,
                    -4.081_127_071_823_205,
                    -4.444_209_944_751_381,
                ],
            ),
        ] {
            let places = [0.0, 1.0, 1.5, 3.0, 4.0];
            let curve = Samples::monotone(places.into_iter().zip(values)).unwrap();
            for (x, expected) in AT.into_iter().zip(expected) {
                let value = curve.at(x);
                assert!(
                    (value - expected).abs() < 1e-14,
                    "{x}: {value}, expected {expected}"
                );
            }
        }
    }

    #[test]
    fn samples_of_a_file() {
        let folder = std::env::temp_dir().join(format!("dsocs-samples-of-a-file-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let read = |text: &str| {
            let file = folder.join("samples.csv");
            fs::write(&file, text).unwrap();
            Samples::read(&file)
        };
        let expected = Ok(vec![(0.0, 1.5), (1e-1, -2.0)]);
        for text in [
            "0,1.5\n0.1,-2\n",
            "\u{feff}time, value\r\n0, 1.5\r\n\r\n1e-1, -2.0",
            "# measured\nt;x\n0;1.5\n# again\n.1;-2\n",
            "0 1.5\n0.1\t-2\n",
            "\"t\",\"x\"\n\"0\",\"1.5\"\n0.1,-2\n",
        ] {
            assert_eq!(read(text), expected, "{text}");
        }
        for (text, wrong) in [
            ("0,1\nsoon,2\n", 2),
            ("0,1\n1\n", 2),
            ("0,1,2\n", 1),
            ("t,x\nt,x\n", 2),
            ("1,x\n", 1),
        ] {
            let found = read(text);
            assert!(
                matches!(&found, Err(SamplesError::Line { line, .. }) if *line == wrong),
                "{text}: {found:?}"
            );
        }
        fs::remove_dir_all(&folder).unwrap();
        let none = Samples::read(&folder).unwrap_err();
        assert!(
            matches!(none, SamplesError::File { .. }) && none.to_string().contains("cannot read"),
            "{none}"
        );
    }

    #[test]
    fn few_samples() {
        assert_eq!(Samples::cubic([(1.0, 3.0)]).unwrap().at(7.0), 3.0);
        assert_eq!(Samples::cubic([(1.0, 3.0), (2.0, 5.0)]).unwrap().at(1.25), 3.5);
        let parabola = Samples::cubic([(0.0, 0.0), (1.0, 1.0), (3.0, 9.0)]).unwrap();
        assert!((parabola.at(2.0) - 4.0).abs() < 1e-15);
        let line = Samples::linear([(0.0, 1.0), (1.0, 3.0)]).unwrap();
        assert_eq!(
            [-1.0, 0.0, 0.5, 1.0, 2.0].map(|x| line.at(x)),
            [1.0, 1.0, 2.0, 3.0, 3.0]
        );
    }

    #[test]
    fn what_makes_no_function() {
        assert_eq!(Samples::linear([]), Err(SamplesError::None));
        let twice = Samples::linear([(0.0, 1.0), (0.0, 2.0)]);
        assert!(matches!(twice, Err(SamplesError::Order { index: 1, .. })));
        let none = Samples::cubic([(0.0, 1.0), (1.0, f64::NAN)]);
        assert!(matches!(none, Err(SamplesError::NotFinite { index: 1, .. })));
    }
}
