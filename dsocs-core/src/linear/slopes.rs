//! Results of a declaration's tape with their derivatives by everything that they are computed from.

use crate::solve::Square;
use crate::tape::declaration::Declaration;
use crate::tape::{Eight, Input, Leaf, Part, Room, Segment};

/// The results of some segments at a place, and their derivatives by every input. They are exact to rounding.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    inputs: Vec<Input>,
    /// The results.
    pub(super) values: Vec<f64>,
    /// The derivatives of each result, in the order of the inputs.
    rows: Vec<Vec<f64>>,
}

impl Slopes {
    /// The results of some segments, one after another, where the inputs have these values.
    pub(super) fn of(
        declaration: &Declaration<'_>,
        wanted: &[(Segment, Part)],
        value: &dyn Fn(Input) -> f64,
    ) -> Self {
        let source = declaration.source();
        let differential = source.tape().differential(wanted, &|_| true);
        let mut room = Room::default();
        differential.evaluate(source, &mut room, 1, &mut |input| Eight::splat(value(input)));
        let inputs: Vec<Input> = differential.inputs().collect();
        let (mut values, mut rows) = (Vec::new(), Vec::new());
        for result in 0..differential.len() {
            values.push(differential.result(&room, result).0[0]);
            let mut row = vec![0.0; inputs.len()];
            differential.back_from(&mut room, result, &mut |input, slope| row[input] = slope.0[0]);
            rows.push(row);
        }
        Self { inputs, values, rows }
    }

    /// How the results change where the inputs change at these rates. What has no derivative by an input that stays is no matter.
    pub(super) fn along(&self, rate: &dyn Fn(Input) -> f64) -> Vec<f64> {
        let rates: Vec<f64> = self.inputs.iter().map(|input| rate(*input)).collect();
        let change = |row: &Vec<f64>| {
            let moving = row.iter().zip(&rates).filter(|(_, rate)| **rate != 0.0);
            moving.map(|(slope, rate)| slope * rate).sum()
        };
        self.rows.iter().map(change).collect()
    }

    /// The derivatives of the results by a leaf.
    pub(super) fn by(&self, leaf: Leaf) -> Vec<f64> {
        let place = self.inputs.iter().position(|input| *input == Input::Leaf(leaf));
        let slope = |row: &Vec<f64>| place.map_or(0.0, |place| row[place]);
        self.rows.iter().map(slope).collect()
    }

    /// The derivatives of as many results by as many leaves, as a matrix.
    pub(super) fn square(&self, leaf: impl Fn(usize) -> Leaf) -> Square {
        let columns: Vec<Vec<f64>> = (0..self.values.len()).map(|j| self.by(leaf(j))).collect();
        Square::from_fn(self.values.len(), |i, j| columns[j][i])
    }

    /// The leaves by which a result changes, and its derivative by each.
    pub(super) fn moving(&self, result: usize) -> impl Iterator<Item = (Leaf, f64)> {
        let slopes = self.rows.get(result).map_or(&[][..], Vec::as_slice);
        self.inputs.iter().zip(slopes).filter_map(|(input, slope)| match input {
            Input::Leaf(leaf) if *slope != 0.0 => Some((*leaf, *slope)),
            _ => None,
        })
    }
}

/// A point of the continuous system with its multipliers.
#[derive(Clone, Copy, Debug)]
pub(super) struct At<'a> {
    pub(super) t: f64,
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
    pub(super) a: &'a [f64],
    pub(super) multipliers: &'a [f64],
}

impl At<'_> {
    /// The value of an input of the continuous system's segments; third derivatives, and sides of what jumps, are zero.
    pub(super) fn value(&self, declaration: &Declaration<'_>, input: Input) -> f64 {
        let of = |vector: &[f64], i: usize| vector.get(i).copied().unwrap_or(f64::NAN);
        match input {
            Input::Leaf(Leaf::T) => self.t,
            Input::Leaf(Leaf::Q(i)) => of(self.q, i),
            Input::Leaf(Leaf::V(i)) => of(self.v, i),
            Input::Leaf(Leaf::A(i)) => of(self.a, i),
            Input::Leaf(Leaf::Lambda(i)) => self.multipliers.get(i).copied().unwrap_or(0.0),
            Input::Leaf(Leaf::Parameter(i)) => declaration.value(i),
            Input::Leaf(Leaf::J(_) | Leaf::Side(_)) => 0.0,
            _ => f64::NAN,
        }
    }

    /// Results at this point, with their derivatives.
    pub(super) fn slopes(&self, declaration: &Declaration<'_>, wanted: &[(Segment, Part)]) -> Slopes {
        Slopes::of(declaration, wanted, &|input| self.value(declaration, input))
    }
}

/// A change of the state, or of a parameter.
#[derive(Clone, Debug, Default)]
pub(super) struct Direction {
    /// The change of the position.
    pub(super) q: Vec<f64>,
    /// The change of the velocity.
    pub(super) v: Vec<f64>,
    /// The parameter that changes by 1.
    pub(super) parameter: Option<usize>,
}

impl Direction {
    /// The change of an input of the continuous system's segments, where the acceleration changes by `a`.
    pub(super) fn rate(&self, input: Input, a: &[f64]) -> f64 {
        let of = |vector: &[f64], i: usize| vector.get(i).copied().unwrap_or(0.0);
        match input {
            Input::Leaf(Leaf::Q(i)) => of(&self.q, i),
            Input::Leaf(Leaf::V(i)) => of(&self.v, i),
            Input::Leaf(Leaf::A(i)) => of(a, i),
            Input::Leaf(Leaf::Parameter(i)) => f64::from(u8::from(self.parameter == Some(i))),
            _ => 0.0,
        }
    }

    /// The sum of two changes of the state; the parameter is that of the first.
    pub(super) fn plus(&self, other: &Self, factor: f64) -> Self {
        let sum = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x + factor * y).collect();
        Self {
            q: sum(&self.q, &other.q),
            v: sum(&self.v, &other.v),
            parameter: self.parameter,
        }
    }
}
