//! Lines that oscillate faster than pixels can show are drawn as a band between their extremes: as lines they
//! would make a moiré pattern.

/// A part of a line, in pixels.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum LinePart {
    /// Points that are joined by lines.
    Line(Vec<[f64; 2]>),
    /// The outline of the band between the upper and the lower extremes.
    Band(Vec<[f64; 2]>),
}

/// The width of a column in which turning points are counted, in pixels.
const COLUMN_WIDTH: f64 = 3.0;

/// A line is a band where it has more turning points per column.
const BAND_TURNS: f64 = 1.6;

/// A turning point counts if the line goes back by more than this, in pixels.
const LEAST_SWING: f64 = 3.0;

/// The number of columns on both sides over which turning points are averaged.
const AVERAGED_COLUMNS: usize = 3;

/// The smallest number of columns of a band; shorter ones are lines.
const SHORTEST_BAND: usize = 6;

/// A column of pixels.
struct Column {
    /// The index of its first point, and of the one after its last.
    points: [usize; 2],
    /// The least and the greatest height.
    extremes: [f64; 2],
    /// The number of its turning points.
    turns: u32,
}

/// The parts of a line through these points.
pub(super) fn parts(points: Vec<[f64; 2]>) -> Vec<LinePart> {
    if !points.is_sorted_by(|a, b| a[0] <= b[0]) {
        return vec![LinePart::Line(points)];
    }
    let columns = columns(&points);
    let dense: Vec<bool> = (0..columns.len())
        .map(|place| {
            let near = &columns
                [place.saturating_sub(AVERAGED_COLUMNS)..columns.len().min(place + AVERAGED_COLUMNS + 1)];
            let turns: u32 = near.iter().map(|column| column.turns).sum();
            f64::from(turns) > BAND_TURNS * near.len() as f64
        })
        .collect();
    let mut parts = Vec::new();
    let mut line_from = 0;
    let mut place = 0;
    while place < columns.len() {
        let length = dense[place..].iter().take_while(|dense| **dense).count();
        if length < SHORTEST_BAND {
            place += length.max(1);
            continue;
        }
        let run = &columns[place..place + length];
        let (first, end) = (run[0].points[0], run[length - 1].points[1]);
        if first > line_from {
            // the line up to the first point of the band
            parts.push(LinePart::Line(points[line_from..=first].to_vec()));
        }
        let middle =
            |column: &Column| f64::midpoint(points[column.points[0]][0], points[column.points[1] - 1][0]);
        let upper = run.iter().map(|column| [middle(column), column.extremes[0]]);
        let lower = run
            .iter()
            .rev()
            .map(|column| [middle(column), column.extremes[1]]);
        parts.push(LinePart::Band(upper.chain(lower).collect()));
        line_from = end - 1;
        place += length;
    }
    if line_from + 1 < points.len() || parts.is_empty() {
        parts.push(LinePart::Line(points[line_from..].to_vec()));
    }
    parts
}

/// The columns of a line.
fn columns(points: &[[f64; 2]]) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    let mut number = None;
    // the farthest point since the last turning point, and the direction of the line: down to begin with
    let (mut extreme, mut direction) = (points.first().map_or(0.0, |point| point[1]), 1.0);
    for (place, &[x, y]) in points.iter().enumerate() {
        #[allow(clippy::cast_possible_truncation)] // saturates, far outside of any picture
        let own = (x / COLUMN_WIDTH).floor() as i64;
        if number.replace(own) != Some(own) {
            columns.push(Column {
                points: [place, place],
                extremes: [y, y],
                turns: 0,
            });
        }
        let Some(column) = columns.last_mut() else {
            continue;
        };
        column.points[1] = place + 1;
        column.extremes = [column.extremes[0].min(y), column.extremes[1].max(y)];
        let back = (extreme - y) * direction;
        if back > LEAST_SWING {
            column.turns += 1;
            (extreme, direction) = (y, -direction);
        } else if back < 0.0 {
            extreme = y;
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave of this period over 600 pixels.
    fn wave(period: f64) -> Vec<[f64; 2]> {
        let place = |i: u32| f64::from(i) / 10.0;
        let height = |x: f64| 100.0 + 50.0 * (std::f64::consts::TAU * x / period).sin();
        (0..6000).map(|i| [place(i), height(place(i))]).collect()
    }

    #[test]
    fn slow_waves_are_lines() {
        assert_eq!(parts(wave(20.0)), [LinePart::Line(wave(20.0))]);
        let circle: Vec<_> = (0..100)
            .map(|i| f64::from(i).sin_cos())
            .map(|(x, y)| [x, y])
            .collect();
        assert_eq!(parts(circle.clone()), [LinePart::Line(circle)]);
        assert_eq!(parts(Vec::new()), [LinePart::Line(Vec::new())]);
    }

    #[test]
    fn fast_waves_are_bands_between_their_extremes() {
        let [LinePart::Band(outline)] = &parts(wave(1.7))[..] else {
            panic!("one band")
        };
        let (upper, lower) = outline.split_at(outline.len() / 2);
        assert!(upper.iter().all(|[_, y]| (*y - 50.0).abs() < 3.0), "{upper:?}");
        assert!(lower.iter().all(|[_, y]| (*y - 150.0).abs() < 3.0), "{lower:?}");
        assert!(upper[0][0] < 3.0 && upper[upper.len() - 1][0] > 597.0);
    }

    #[test]
    fn ripples_are_no_band() {
        let points = wave(1.7)
            .into_iter()
            .map(|[x, y]| [x, 100.0 + 0.02 * (y - 100.0) + x / 5.0]);
        let parts = parts(points.collect());
        assert!(matches!(parts[..], [LinePart::Line(_)]), "{} parts", parts.len());
    }

    #[test]
    fn a_line_that_settles_is_both() {
        let mut points = wave(1.7);
        points.extend((6000..9000).map(|i| [f64::from(i) / 10.0, 100.0]));
        let parts = parts(points);
        let [LinePart::Band(_), LinePart::Line(line)] = &parts[..] else {
            panic!("{} parts", parts.len())
        };
        assert!(line.len() > 2900 && line[line.len() - 1][0] > 899.0);
    }
}
