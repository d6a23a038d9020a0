//! The points of a sweep: the values of the quantities that vary, computed from the number of the point.

use super::error::SweepError;
use super::plan::{Plan, Sample, SampleKind, Values};
use super::random;

/// The points of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    /// The quantities that vary, in the order of the plan.
    axes: Vec<Axis>,
    /// Random points, instead of a grid.
    sample: Option<Sample>,
    /// The number of points.
    count: u64,
}

/// One quantity that varies.
#[derive(Clone, Debug, PartialEq)]
struct Axis {
    /// Its values.
    values: Values,
    /// The number of consecutive points with the same value.
    stride: u64,
}

impl Points {
    /// The points of a plan.
    ///
    /// # Errors
    ///
    /// [`SweepError::Plan`] if there are more than 2⁵³ of them.
    pub fn new(plan: &Plan) -> Result<Self, SweepError> {
        let mut axes: Vec<Axis> = Vec::new();
        let mut count = 1_u64;
        for (name, values) in plan.vary.iter().rev() {
            axes.push(Axis {
                values: values.clone(),
                stride: count,
            });
            let own = values.count().unwrap_or(1);
            count = match count.checked_mul(own).filter(|&count| count <= 1 << 53) {
                Some(count) => count,
                None => {
                    return Err(SweepError::plan(
                        &format!("vary.{name}"),
                        "the grid has more than 2⁵³ points",
                    ));
                }
            };
        }
        axes.reverse();
        if let Some(sample) = plan.sample {
            count = sample.count;
        }
        Ok(Self {
            axes,
            sample: plan.sample,
            count,
        })
    }

    /// The number of points.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The values of the quantities that vary, at a point.
    pub fn values(&self, point: u64, out: &mut Vec<f64>) {
        out.clear();
        for (dimension, axis) in (0_u64..).zip(&self.axes) {
            out.push(match self.sample {
                None => axis
                    .values
                    .nth(point / axis.stride % axis.values.count().unwrap_or(1)),
                Some(sample) => axis.values.at(sample.place(point, dimension), 1.0),
            });
        }
    }
}

impl Sample {
    /// The position of a point in the range of a dimension, in `[0, 1)`.
    fn place(&self, point: u64, dimension: u64) -> f64 {
        let Self { kind, count, seed } = *self;
        match kind {
            SampleKind::Random => random::uniform(seed, point, dimension),
            SampleKind::LatinHypercube => {
                let cell = random::permuted(seed, dimension, point, count) as f64;
                let place = (cell + random::uniform(seed, point, dimension)) / count as f64;
                // rounding may reach the end of the last cell
                place.min(1.0 - f64::EPSILON / 2.0)
            }
            #[allow(clippy::cast_possible_truncation)]
            // the plan has been checked; both halves of the seed are used
            SampleKind::Sobol => f64::from(sobol_burley::sample(
                point as u32,
                dimension as u32,
                seed as u32 ^ (seed >> 32) as u32,
            )),
        }
    }
}

impl Values {
    /// The number of values on a grid; `None` for a range without a count.
    #[must_use]
    pub fn count(&self) -> Option<u64> {
        match self {
            Self::List(list) => Some(list.len() as u64),
            Self::Range { count, .. } => *count,
        }
    }

    /// A value of a grid.
    #[must_use]
    pub fn nth(&self, place: u64) -> f64 {
        match self {
            #[allow(clippy::cast_possible_truncation)] // it is a place in the list
            Self::List(list) => list.get(place as usize).copied().unwrap_or(f64::NAN),
            Self::Range { from, count, .. } => match count.unwrap_or(1) {
                1 => *from,
                count => self.at(place as f64, (count - 1) as f64),
            },
        }
    }

    /// The value at the fraction `place/last` of a range, or the item of a list there.
    #[allow(clippy::float_cmp)] // the ends are met exactly
    fn at(&self, place: f64, last: f64) -> f64 {
        match *self {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a place in the list
            Self::List(ref list) => list[((place / last * list.len() as f64) as usize).min(list.len() - 1)],
            Self::Range { to, .. } if place == last => to,
            Self::Range {
                from,
                to,
                logarithmic: true,
                ..
            } => from * (to / from).powf(place / last),
            Self::Range { from, to, .. } => from + (to - from) * place / last,
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, clippy::cast_possible_truncation)] // values of a list, and the numbers of cells
mod tests {
    use super::*;

    fn points(text: &str) -> Vec<Vec<f64>> {
        let points = Points::new(&Plan::read(text).unwrap()).unwrap();
        (0..points.count())
            .map(|point| {
                let mut values = Vec::new();
                points.values(point, &mut values);
                values
            })
            .collect()
    }

    #[test]
    fn a_grid_has_its_first_quantity_slowest_and_meets_its_ends() {
        let grid = points("[vary]\nx = { from = -1, to = 2, count = 4 }\ny = [5, 3]");
        assert_eq!(grid.len(), 8);
        assert_eq!(grid[0], [-1.0, 5.0]);
        assert_eq!(grid[1], [-1.0, 3.0]);
        assert_eq!(grid[2], [0.0, 5.0]);
        assert_eq!(grid[7], [2.0, 3.0]);
        let decades = points("[vary]\nx = { from = -0.01, to = -100, count = 5, scale = \"logarithmic\" }");
        for (value, expected) in decades.iter().zip([-0.01, -0.1, -1.0, -10.0, -100.0]) {
            assert!((value[0] / expected - 1.0).abs() < 1e-14);
        }
        assert_eq!(decades[4], [-100.0]);
    }

    #[test]
    fn a_latin_hypercube_has_one_value_in_each_part() {
        let points = points(
            "[sample]\nkind = \"latin-hypercube\"\ncount = 50\nseed = 3\n[vary]\nx = { from = 0, to = 50 }\ny = { from = 0, to = 50 }",
        );
        for dimension in 0..2 {
            #[allow(clippy::cast_possible_truncation)]
            let mut cells: Vec<i64> = points
                .iter()
                .map(|point| point[dimension].floor() as i64)
                .collect();
            cells.sort_unstable();
            assert_eq!(cells, (0..50).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_sobol_sequence_fills_evenly_and_lists_are_drawn_from() {
        let points = points(
            "[sample]\nkind = \"sobol\"\ncount = 64\nseed = 9\n[vary]\nx = { from = 0, to = 8 }\ny = { from = 0, to = 8 }\nz = [1, 2]",
        );
        let mut cells: Vec<[i64; 2]> = points
            .iter()
            .map(|point| [point[0].floor() as i64, point[1].floor() as i64])
            .collect();
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(
            cells.len(),
            64,
            "a (0, 2) sequence has a point in each elementary interval"
        );
        assert_eq!(points.iter().filter(|point| point[2] == 1.0).count(), 32);
    }
}
