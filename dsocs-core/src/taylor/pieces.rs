//! Pieces of what is given by pieces, along a way.

use crate::solve::Vector;
use crate::start::place::Place;
use crate::tape::declaration::Declaration;

/// An event is found up to this part of the step.
pub(super) const FOUND: f64 = 4.0 * f64::EPSILON;

/// Arguments that differ by less than this part of themselves are one.
pub(super) const SAME: f64 = 1e-12;

/// The pieces of what is given by pieces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Known {
    /// The arguments of what changes its piece with a sign, where they were other than zero last.
    pub(super) arguments: Vec<f64>,
    /// Between which samples the argument of each table is.
    pub(super) samples: Vec<usize>,
}

/// The first place between two at which something is true that is true at the second, up to rounding.
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

/// The pieces of what is given by pieces, along a way.
pub(super) struct Pieces<'a> {
    pub(super) declaration: Declaration<'a>,
    /// Which arguments are those of sides, and looked at as such.
    pub(super) of_sides: Vec<bool>,
    /// The time at which the way begins, and its length.
    pub(super) times: (f64, f64),
    /// Position and velocity at a part of it.
    pub(super) way: &'a dyn Fn(f64) -> (Vector, Vector),
    /// Those so far.
    pub(super) known: Known,
}

impl<'a> Pieces<'a> {
    /// Those of a way, from what is known of them before; `None` if nothing is given by pieces.
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

    /// Those at a part of the way.
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

    /// Remembers them, and the signs of arguments that are not zero.
    pub(super) fn take(&mut self, now: Known) {
        for (known, argument) in self.known.arguments.iter_mut().zip(now.arguments) {
            if argument != 0.0 {
                *known = argument;
            }
        }
        self.known.samples = now.samples;
    }

    /// The first change between two parts of the way.
    pub(super) fn change(&mut self, ends: [f64; 2]) -> Option<f64> {
        let differs = |now: &Known| {
            let mut signs = self.known.arguments.iter().zip(&now.arguments);
            now.samples != self.known.samples || signs.any(|(known, now)| known * now < 0.0)
        };
        let now = self.at(ends[1]);
        if differs(&now) {
            return Some(first(ends, &|x| differs(&self.at(x))));
        }
        self.take(now);
        None
    }
}

/// Which arguments of what is given by pieces are those of sides: at another velocity, where none is zero, they are equal.
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
