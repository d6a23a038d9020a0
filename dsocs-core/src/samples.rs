//! Functions that are given by samples: a measured wind, a planned torque.

use thiserror::Error;

use crate::number::real::Real;

/// A function of one variable through given samples, with straight lines or a cubic spline between them. A sample is a place (a value of the
/// argument) and the value of the function there.
///
/// A declaration calls [`Samples::at`] like any other function, with the time or a coordinate as argument. Before the first and after the
/// last sample the function is constant.
///
/// Where two pieces meet, a derivative jumps: the first derivative of straight lines, the third of a spline. This does not lower the
/// order 2 of the step. A step of a [`TaylorFlow`](crate::TaylorFlow) ends at such a place.
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
    /// The pieces from each place to the next, as coefficients of the distance from it; of the last place, its value.
    pieces: Vec<[f64; 4]>,
}

/// Samples that do not define a function.
#[derive(Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum SamplesError {
    /// There are no samples.
    #[error("expected at least one sample")]
    None,
    /// A place or a value is infinite or not a number.
    #[error("sample {index} is ({place}, {value}); expected finite numbers")]
    NotFinite {
        /// Its number, from 0.
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
        /// Its number, from 0.
        index: usize,
        /// Its place.
        place: f64,
        /// The place before.
        before: f64,
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
    /// As [`Samples::linear`].
    pub fn cubic(samples: impl IntoIterator<Item = (f64, f64)>) -> Result<Self, SamplesError> {
        let (places, values) = checked(samples)?;
        let chords = slopes(&places, &values);
        let lengths: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let tangents = tangents(&lengths, &chords);
        let mut pieces: Vec<_> = (0..chords.len())
            .map(|i| {
                let (h, chord, [left, right]) = (lengths[i], chords[i], [tangents[i], tangents[i + 1]]);
                let bend = (left + right - 2.0 * chord) / h;
                [values[i], left, (chord - left) / h - bend, bend / h]
            })
            .collect();
        pieces.extend(values.last().map(|&last| [last, 0.0, 0.0, 0.0]));
        Ok(Self { places, pieces })
    }

    /// The places of the samples, in ascending order.
    #[must_use]
    pub fn places(&self) -> &[f64] {
        &self.places
    }

    /// The value at a place. Where two pieces meet, the right one is used.
    #[must_use]
    pub fn at<R: Real>(&self, x: R) -> R {
        let place = x.piece(&self.places);
        // before the first sample its value is held, as the last one's is
        let Some(index) = place.checked_sub(1) else {
            return R::from(self.pieces.first().map_or(f64::NAN, |piece| piece[0]));
        };
        let (Some(&[a, b, c, d]), Some(&from)) = (self.pieces.get(index), self.places.get(index)) else {
            return R::from(f64::NAN);
        };
        if index + 1 == self.places.len() {
            return R::from(a);
        }
        let x = x - from;
        ((x * d + c) * x + b) * x + a
    }
}

/// Places and values, once they can be used.
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
