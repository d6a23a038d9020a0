//! Axes: their ranges and the labels of their ticks.

/// An axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// The quantity, with its unit in brackets; `_{}` marks a subscript. Empty for an axis that shares the
    /// label of another panel.
    pub label: String,
    /// The scale, linear or logarithmic.
    pub scale: Scale,
    /// The range; by default that of the data, with a margin.
    pub range: Option<[f64; 2]>,
    /// Whether its ticks have no labels, because another panel of the stack has them.
    pub without_labels: bool,
}

/// The map from values to positions on an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Proportional to the value.
    #[default]
    Linear,
    /// Proportional to the logarithm. Values that are not positive are left out.
    Logarithmic,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            ..Self::default()
        }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Logarithmic,
            ..Self::default()
        }
    }

    /// Sets the range.
    #[must_use]
    pub fn with_range(mut self, from: f64, to: f64) -> Self {
        self.range = Some([from.min(to), from.max(to)]);
        self
    }

    /// Leaves the labels of the ticks to another panel of the stack.
    #[must_use]
    pub fn without_labels(mut self) -> Self {
        self.without_labels = true;
        self
    }

    /// Whether a value can be shown on the axis.
    pub(super) fn shows(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0)
    }

    /// The range for these values, never empty.
    pub(super) fn range_of(&self, values: impl Iterator<Item = f64>) -> (f64, f64) {
        if let Some([from, to]) = self.range
            && from < to
        {
            return (from, to);
        }
        let (least, greatest) = values
            .filter(|&value| self.shows(value))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), value| {
                (least.min(value), greatest.max(value))
            });
        match (self.scale, least <= greatest) {
            (Scale::Linear, false) => (0.0, 1.0),
            (Scale::Logarithmic, false) => (0.1, 1.0),
            (Scale::Linear, true) => {
                let span = greatest - least;
                // a constant (to rounding) gets a range in which its ticks differ
                let floor = 1e-9 * least.abs().max(greatest.abs());
                let margin = if span > floor {
                    0.06 * span
                } else {
                    floor.max(1e-9) * 1e6
                };
                (least - margin, greatest + margin)
            }
            (Scale::Logarithmic, true) => {
                let margin = (greatest / least).powf(0.06).max(1.25);
                (least / margin, greatest * margin)
            }
        }
    }
}

/// The approximate number of ticks of a linear axis.
const TICKS: f64 = 5.0;

/// The largest number of ticks of an axis.
const MOST_TICKS: u32 = 24;

impl Scale {
    /// The position of a value in a range: 0 at its beginning, 1 at its end.
    pub(super) fn place(self, value: f64, (from, to): (f64, f64)) -> f64 {
        match self {
            Self::Linear => (value - from) / (to - from),
            Self::Logarithmic => (value / from).log10() / (to / from).log10(),
        }
    }

    /// The scale and a range of it, in the form that a page reads.
    pub(super) fn script_data(self, (from, to): (f64, f64)) -> String {
        let scale = match self {
            Self::Linear => "linear",
            Self::Logarithmic => "logarithmic",
        };
        format!("{scale} {from:?} {to:?}")
    }

    /// The ticks of a range, with their labels.
    pub(super) fn ticks(self, range: (f64, f64)) -> Vec<(f64, String)> {
        match self {
            Self::Linear => {
                let ticks = linear_ticks(range).into_iter();
                ticks.map(|tick| (tick, linear_label(tick, range))).collect()
            }
            Self::Logarithmic => {
                let ticks = logarithmic_ticks(range).into_iter();
                ticks.map(|tick| (tick, logarithmic_label(tick, range))).collect()
            }
        }
    }
}

impl Scale {
    /// The minor ticks of a range: positions between the ticks, without labels. Empty where they would be
    /// crowded.
    pub(super) fn minor_ticks(self, range: (f64, f64)) -> Vec<f64> {
        let (from, to) = range;
        let places: Vec<f64> = match self {
            Self::Linear => {
                let [first, second, ..] = linear_ticks(range)[..] else {
                    return Vec::new();
                };
                let step = second - first;
                // fifths, but halves of ones where the ticks are two apart
                let leading = step / 10f64.powf((step.log10() + 1e-9).floor());
                let parts = if (leading - 2.0).abs() < 0.1 { 4_u32 } else { 5 };
                let part = step / f64::from(parts);
                let count = parts * (MOST_TICKS + 2);
                let begin = first - f64::from(parts) * part;
                (0..count).map(|k| begin + f64::from(k) * part).collect()
            }
            Self::Logarithmic => {
                let (low, high) = (from.log10().floor(), to.log10().ceil());
                if high - low > 8.0 {
                    return Vec::new();
                }
                let decades = (0..9)
                    .map(|k| low + f64::from(k))
                    .take_while(|&decade| decade <= high);
                let nine = |decade: f64| (1..10).map(move |digit| f64::from(digit) * 10f64.powf(decade));
                decades.flat_map(nine).collect()
            }
        };
        places
            .into_iter()
            .filter(|&place| place > from && place < to)
            .collect()
    }
}

/// The multiples of 1, 2, 2.5 or 5 times a power of ten in a range, about [`TICKS`] of them. Empty if the
/// ends of the range are equal to rounding.
fn linear_ticks((from, to): (f64, f64)) -> Vec<f64> {
    let rough = (to - from) / TICKS;
    let power = 10f64.powf(rough.log10().floor());
    let step = power
        * match rough / power {
            part if part < 1.5 => 1.0,
            part if part < 2.25 => 2.0,
            part if part < 3.5 => 2.5,
            part if part < 7.5 => 5.0,
            _ => 10.0,
        };
    // a multiple that rounding puts just outside is kept at the end
    let first = (from / step - 1e-9).ceil();
    (0..MOST_TICKS)
        .map(|k| (first + f64::from(k)) * step)
        .take_while(|&tick| tick <= to + 1e-9 * step)
        .collect()
}

/// The powers of ten in a range, and over at most three decades also twice and five times these. Over many
/// decades some are left out.
fn logarithmic_ticks((from, to): (f64, f64)) -> Vec<f64> {
    let (first, last) = (from.log10().floor(), to.log10().ceil());
    let decades = last - first;
    let digits: &[f64] = if decades <= 3.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let every = (decades / 12.0).ceil().max(1.0);
    let first = (first / every).ceil() * every;
    (0..MOST_TICKS)
        .map(|k| first + every * f64::from(k))
        .take_while(|&exponent| exponent <= last)
        .flat_map(|exponent| digits.iter().map(move |digit| digit * 10f64.powf(exponent)))
        .filter(|tick| (from * (1.0 - 1e-8)..=to * (1.0 + 1e-8)).contains(tick))
        .collect()
}

/// The label of a tick on a logarithmic axis with this range: a power of ten. Over less than two decades
/// every tick has a label with the whole number: a digit alone would not show its power.
fn logarithmic_label(value: f64, (from, to): (f64, f64)) -> String {
    // a tick is one digit times a power of ten, up to rounding
    let exponent = (value.log10() + 1e-6).floor();
    let digit = (value / 10f64.powf(exponent)).round();
    let few = to < 100.0 * from;
    let ordinary = from >= 5e-4 && to <= 2e5;
    if few && ordinary {
        let digits = (-exponent).max(0.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and 4
        let text = format!("{:.*}", digits as usize, digit * 10f64.powf(exponent));
        text
    } else if digit < 1.5 {
        format!("10{}", superscript(exponent))
    } else if few {
        format!("{digit}·10{}", superscript(exponent))
    } else {
        String::new()
    }
}

/// An integer in superscript digits.
fn superscript(number: f64) -> String {
    format!("{number}")
        .chars()
        .map(|character| match character {
            '-' => '⁻',
            '0' => '⁰',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            other => other,
        })
        .collect()
}

/// The label of a tick on a linear axis with this range: only as many digits as distinguish its ticks, and a
/// true minus sign.
fn linear_label(value: f64, (from, to): (f64, f64)) -> String {
    let span = to - from;
    let value = if value.abs() < 1e-9 * span { 0.0 } else { value };
    let size = from.abs().max(to.abs());
    let text = if (1e-3..1e6).contains(&size) {
        // ticks are at least a fiftieth of the span apart
        let digits = (2.0 - span.log10().floor()).clamp(0.0, 15.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and 15
        let text = format!("{value:.*}", digits as usize);
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else if value == 0.0 {
        "0".to_owned()
    } else {
        let exponent = value.abs().log10().floor();
        let digits = format!("{:.4}", value / 10f64.powf(exponent));
        format!(
            "{}·10{}",
            digits.trim_end_matches('0').trim_end_matches('.'),
            superscript(exponent)
        )
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_ticks() {
        assert_eq!(logarithmic_label(1e-3, (1e-4, 1e-2)), "10⁻³");
        assert_eq!(logarithmic_label(1e12, (1e11, 2e12)), "10¹²");
        assert_eq!(logarithmic_label(0.02, (1e-3, 0.3)), "");
        assert_eq!(logarithmic_label(2e-5, (1e-5, 3e-4)), "2·10⁻⁵");
        assert_eq!(logarithmic_label(1e-5, (1e-5, 3e-4)), "10⁻⁵");
        assert_eq!(logarithmic_label(2e7, (1.5e7, 8e7)), "2·10⁷");
        // the labels of an axis over few decades are increasing numbers
        for (range, expected) in [
            ((0.01, 0.3), &["0.01", "0.02", "0.05", "0.1", "0.2"][..]),
            ((0.15, 3.0), &["0.2", "0.5", "1", "2"]),
            ((1.7, 60.0), &["2", "5", "10", "20", "50"]),
            ((150.0, 2500.0), &["200", "500", "1000", "2000"]),
            ((0.015, 0.08), &["0.02", "0.05"]),
        ] {
            let ticks = Scale::Logarithmic.ticks(range).into_iter();
            let labels: Vec<String> = ticks.map(|(_, label)| label).collect();
            assert_eq!(labels, expected);
        }
        assert_eq!(linear_label(-0.5, (-1.0, 1.0)), "−0.5");
        assert_eq!(linear_label(1e-17, (-1.0, 1.0)), "0");
        assert_eq!(linear_label(15_000.0, (0.0, 16_000.0)), "15000");
        assert_eq!(linear_label(2.5e7, (0.0, 3e7)), "2.5·10⁷");
        assert_eq!(linear_label(100.0, (99.9, 100.1)), "100");
    }

    #[test]
    fn ticks() {
        let close = |found: Vec<f64>, wanted: &[f64]| {
            let apart = found
                .iter()
                .zip(wanted)
                .any(|(x, y)| (x - y).abs() > 1e-12 * y.abs());
            assert!(found.len() == wanted.len() && !apart, "{found:?} {wanted:?}");
        };
        close(linear_ticks((0.0, 2000.0)), &[0.0, 500.0, 1000.0, 1500.0, 2000.0]);
        close(linear_ticks((-0.58, 0.58)), &[-0.5, -0.25, 0.0, 0.25, 0.5]);
        close(linear_ticks((-1.9, 1.4)), &[-1.5, -1.0, -0.5, 0.0, 0.5, 1.0]);
        close(linear_ticks((480.0, 500.0)), &[480.0, 485.0, 490.0, 495.0, 500.0]);
        close(logarithmic_ticks((8e-4, 0.13)), &[1e-3, 1e-2, 1e-1]);
        close(
            logarithmic_ticks((150.0, 2500.0)),
            &[200.0, 500.0, 1000.0, 2000.0],
        );
        assert!(logarithmic_ticks((1e-300, 1e300)).len() < MOST_TICKS as usize);
        assert!(linear_ticks((1.0, 1.0 + f64::EPSILON)).len() <= MOST_TICKS as usize);
    }

    #[test]
    fn minor_ticks_lie_between() {
        let minor = Scale::Linear.minor_ticks((0.0, 2000.0));
        assert!(minor.iter().any(|tick| (tick - 100.0).abs() < 1e-9), "{minor:?}");
        assert!(minor.iter().all(|tick| (0.0..2000.0).contains(tick)));
        let minor = Scale::Linear.minor_ticks((0.0, 1.0)); // ticks every 0.2
        assert!(minor.iter().any(|tick| (tick - 0.05).abs() < 1e-9), "{minor:?}");
        let minor = Scale::Logarithmic.minor_ticks((8e-4, 0.13));
        assert!(
            minor.iter().any(|tick| (tick / 3e-2 - 1.0).abs() < 1e-9),
            "{minor:?}"
        );
        assert!(Scale::Logarithmic.minor_ticks((1e-300, 1e300)).is_empty());
    }

    #[test]
    fn a_range_is_never_empty() {
        for scale in [Scale::Linear, Scale::Logarithmic] {
            let axis = Axis {
                scale,
                ..Axis::default()
            };
            for values in [
                vec![],
                vec![0.0],
                vec![1e9],
                vec![f64::NAN],
                vec![1.0, 1.0 + 1e-16],
                vec![-3.0],
            ] {
                let (from, to) = axis.range_of(values.iter().copied());
                assert!(
                    from < to && from.is_finite() && to.is_finite(),
                    "{scale:?} {values:?}"
                );
            }
        }
    }
}
