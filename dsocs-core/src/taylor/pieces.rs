//! The pieces of piecewise functions along a path.

use crate::solve::Vector;
use crate::start::place::Place;
use crate::tape::declaration::Declaration;

/// Relative accuracy to which an event is located in a step.
pub(super) const FOUND: f64 = 4.0 * f64::EPSILON;

/// The distance beyond a change of a piece is doubled so often at most.
const CLEARINGS: u32 = 8;

/// Arguments that differ by less than this part of themselves are the same.
pub(super) const SAME: f64 = 1e-12;

/// The pieces of piecewise functions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Known {
    /// The last nonzero values of the arguments whose sign selects a piece.
    pub(super) arguments: Vec<f64>,
    /// For each table, the index of the interval between samples that contains its argument.
    pub(super) samples: Vec<usize>,
}

/// The first place between two at which a condition holds that holds at the second, up to rounding.
pub(super) fn first([mut low, mut high]: [f64; 2], is_beyond: &dyn Fn(f64) -> bool) -> f64 {
    while high - low > FOUND * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if is_beyond(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// The pieces of piecewise functions, along a path.
pub(super) struct Pieces<'a> {
    pub(super) declaration: Declaration<'a>,
    /// Whether each argument is that of a side, which is watched separately.
    pub(super) of_sides: Vec<bool>,
    /// The time at the beginning of the path, and its length.
    pub(super) times: (f64, f64),
    /// Position and velocity at a part of the path.
    pub(super) way: &'a dyn Fn(f64) -> (Vector, Vector),
    /// The pieces so far.
    pub(super) known: Known,
}

impl<'a> Pieces<'a> {
    /// The pieces of a path, from those before it; `None` if nothing is piecewise.
    pub(super) fn new(
        declaration: Declaration<'a>,
        known: Option<&Known>,
        times: (f64, f64),
        way: &'a dyn Fn(f64) -> (Vector, Vector),
    ) -> Option<Self> {
        if declaration.switches() == 0 && !declaration.has_tables() {
            return None;
        }
        let mut pieces = Self {
            declaration,
            of_sides: of_sides(&declaration, times.0, way(0.0)),
            times,
            way,
            known: Known {
                arguments: vec![0.0; declaration.switches()],
                samples: Vec::new(),
            },
        };
        if let Some(known) = known {
            pieces.known.clone_from(known);
        } else {
            let now = pieces.at(0.0);
            pieces.take(now);
        }
        Some(pieces)
    }

    /// The pieces at a part of the path.
    pub(super) fn at(&self, x: f64) -> Known {
        let (q, v) = (self.way)(x);
        let place = Place::of_phase(self.times.0 + x * self.times.1, q, v);
        let tables = place.tables(&self.declaration);
        let samples = tables.iter().map(|at| {
            let places = at.samples.places();
            places.partition_point(|place| *place <= at.argument)
        });
        Known {
            arguments: place
                .arguments(&self.declaration)
                .into_iter()
                .zip(&self.of_sides)
                .map(|(argument, is_of_side)| if *is_of_side { 0.0 } else { argument })
                .collect(),
            samples: samples.collect(),
        }
    }

    /// Stores the pieces, and the signs of arguments that are not zero.
    pub(super) fn take(&mut self, now: Known) {
        for (known, argument) in self.known.arguments.iter_mut().zip(now.arguments) {
            if argument != 0.0 {
                *known = argument;
            }
        }
        self.known.samples = now.samples;
    }

    /// The first change between two parts of the way, so far beyond its place that the pieces there are the new ones also after a
    /// `rounding` of the place.
    pub(super) fn change(&mut self, ends: [f64; 2], rounding: f64) -> Option<f64> {
        let differs = |now: &Known| {
            let mut signs = self.known.arguments.iter().zip(&now.arguments);
            now.samples != self.known.samples || signs.any(|(known, now)| known * now < 0.0)
        };
        let now = self.at(ends[1]);
        if differs(&now) {
            let place = first(ends, &|x| differs(&self.at(x)));
            let rounding = rounding + FOUND * place;
            let beyond = (0..CLEARINGS).map(|k| place + rounding * f64::from(2_u32.pow(k)));
            let mut beyond = beyond.filter(|x| [*x, x - rounding].iter().all(|x| differs(&self.at(*x))));
            return Some(beyond.next().unwrap_or(place));
        }
        self.take(now);
        None
    }
}

/// Whether each argument of piecewise functions is that of a side: the two are equal at another velocity,
/// where none is zero.
pub(super) fn of_sides(declaration: &Declaration<'_>, t: f64, (q, mut v): (Vector, Vector)) -> Vec<bool> {
    for (i, v) in v.iter_mut().enumerate() {
        *v += (1.0 + v.abs()) * (0.37 + 0.11 * i as f64);
    }
    let sides = declaration.side_arguments(t, &q[..], &v[..]);
    let arguments = Place::of_phase(t, q, v).arguments(declaration);
    let is_one = |argument: f64| {
        let mut sides = sides.iter();
        sides.any(|side| (side - argument).abs() <= SAME * argument.abs())
    };
    arguments.into_iter().map(is_one).collect()
}
