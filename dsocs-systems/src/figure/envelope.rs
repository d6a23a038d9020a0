//! The envelope of a long sequence of points: fewer points with the same picture.

/// The largest number of cells unless another is asked for: more than the pixels across a figure.
const CELLS: usize = 1200;

/// Of each cell of neighbouring points, keeps the first, the last, and those with the least and the greatest
/// `y`.
///
/// A cell takes twice as many points whenever there would be too many cells, so memory stays bounded however long the
/// sequence is, and a short one is kept as it is. Points that are not finite are left out.
#[derive(Clone, Debug)]
pub struct Envelope {
    /// The largest number of cells; even.
    most: usize,
    /// The cells.
    cells: Vec<Cell>,
    /// The number of points in a full cell, as a power of two.
    doublings: u32,
    /// The number of points in the last cell.
    taken: u64,
}

/// The points kept of a cell, each with its index in the sequence.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// The first.
    first: [f64; 2],
    /// The one with the least `y`.
    least: (u64, [f64; 2]),
    /// The one with the greatest `y`.
    greatest: (u64, [f64; 2]),
    /// The last.
    last: (u64, [f64; 2]),
    /// The index of the first.
    index: u64,
}

impl Cell {
    /// A cell with one point.
    fn new(index: u64, point: [f64; 2]) -> Self {
        Self {
            first: point,
            least: (index, point),
            greatest: (index, point),
            last: (index, point),
            index,
        }
    }

    /// This cell and the next, as one.
    fn joined(self, next: &Self) -> Self {
        Self {
            least: if next.least.1[1] < self.least.1[1] {
                next.least
            } else {
                self.least
            },
            greatest: if next.greatest.1[1] > self.greatest.1[1] {
                next.greatest
            } else {
                self.greatest
            },
            last: next.last,
            ..self
        }
    }

    /// The points that are kept, in their order, each once.
    fn points(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let mut kept = [(self.index, self.first), self.least, self.greatest, self.last];
        kept.sort_by_key(|&(index, _)| index);
        let mut previous = None;
        kept.into_iter()
            .filter_map(move |(index, point)| (previous.replace(index) != Some(index)).then_some(point))
    }
}

impl Default for Envelope {
    fn default() -> Self {
        Self::new()
    }
}

impl Envelope {
    /// An empty envelope.
    #[must_use]
    pub fn new() -> Self {
        Self::with_cells(CELLS)
    }

    /// An empty envelope of at most `most` cells, and so four times as many points.
    #[must_use]
    pub fn with_cells(most: usize) -> Self {
        Self {
            most: most.max(1).next_multiple_of(2),
            cells: Vec::new(),
            doublings: 0,
            taken: 0,
        }
    }

    /// The envelope of these points.
    pub fn of(points: impl IntoIterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
        let mut envelope = Self::new();
        points.into_iter().for_each(|point| envelope.push(point));
        envelope.points()
    }

    /// Adds the next point.
    pub fn push(&mut self, point: [f64; 2]) {
        if !point.iter().all(|x| x.is_finite()) {
            return;
        }
        let index = self.cells.last().map_or(0, |cell| cell.last.0 + 1);
        let single = Cell::new(index, point);
        match self.cells.last_mut() {
            Some(cell) if self.taken < 1 << self.doublings => {
                *cell = cell.joined(&single);
                self.taken += 1;
            }
            _ => {
                if self.cells.len() >= self.most {
                    self.halve();
                }
                self.cells.push(single);
                self.taken = 1;
            }
        }
    }

    /// Joins the cells in pairs.
    fn halve(&mut self) {
        let half = self.most / 2;
        for pair in 0..half {
            self.cells[pair] = self.cells[2 * pair].joined(&self.cells[2 * pair + 1]);
        }
        self.cells.truncate(half);
        self.doublings += 1;
    }

    /// The points that are kept, in their order.
    #[must_use]
    pub fn points(&self) -> Vec<[f64; 2]> {
        self.cells.iter().flat_map(Cell::points).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_cells_keep_the_extremes_too() {
        let mut envelope = Envelope::with_cells(9);
        (0..10_000).for_each(|i| envelope.push([f64::from(i), if i == 777 { -3.0 } else { 0.0 }]));
        let kept = envelope.points();
        assert!(kept.len() <= 40 && kept.contains(&[777.0, -3.0]), "{kept:?}");
        assert_eq!(kept.last(), Some(&[9999.0, 0.0]));
    }

    #[test]
    fn a_short_sequence_is_kept() {
        let points: Vec<_> = (0..1000)
            .map(|i| [f64::from(i), f64::from(i * 7919 % 1000)])
            .collect();
        assert_eq!(Envelope::of(points.clone()), points);
    }

    #[test]
    fn a_long_sequence_keeps_its_extremes_and_its_order() {
        let spike = |i: i32| {
            if i == 123_456 {
                5.0
            } else {
                (f64::from(i) * 0.7).sin()
            }
        };
        let kept = Envelope::of((0..1_000_000).map(|i| [f64::from(i), spike(i)]));
        assert!(kept.len() <= 4 * CELLS);
        assert!(kept.is_sorted_by(|a, b| a[0] < b[0]));
        assert!(kept.contains(&[123_456.0, 5.0]));
        assert_eq!(kept.first().map(|p| p[0]), Some(0.0));
        assert_eq!(kept.last().map(|p| p[0]), Some(999_999.0));
        let floor = kept.iter().map(|p| p[1]).fold(1.0, f64::min);
        assert!(floor < -0.999_999);
    }
}
