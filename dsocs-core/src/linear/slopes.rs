//! Results of a declaration's tape with their derivatives by all of their leaves.

use crate::solve::Square;
use crate::solve::rotation::{self, SLOTS};
use crate::tape::declaration::Declaration;
use crate::tape::{Differential, Eight, Input, Leaf, Part, Segment, Workspace};

/// The results of some segments at a point, and their derivatives by every leaf, exact to rounding.
///
/// Derivatives by the position of a rotation are those by the turns in the frame of its body, at the last
/// three of its four places.
#[derive(Clone, Debug, Default)]
pub(super) struct Slopes {
    /// The leaves by which the results are differentiated.
    leaves: Vec<Leaf>,
    /// The results.
    pub(super) values: Vec<f64>,
    /// The derivatives of each result, in the order of the leaves; missing ones at the end are zero.
    rows: Vec<Vec<f64>>,
}

impl Slopes {
    /// The results of some segments, one after another, for given values of the leaves.
    pub(super) fn of(
        declaration: &Declaration<'_>,
        wanted: &[(Segment, Part)],
        value: &dyn Fn(Leaf) -> f64,
    ) -> Self {
        let differential = declaration.source().tape().differential(wanted, &|_| true);
        let reads_constants = differential
            .inputs()
            .any(|input| matches!(input, Input::Constant(_)));
        let constants = if reads_constants {
            let segment = [(Segment::Constants, Part::All)];
            let differential = declaration.source().tape().differential(&segment, &|_| true);
            Self::evaluated(declaration, &differential, value, &Self::default())
        } else {
            Self::default()
        };
        let mut slopes = Self::evaluated(declaration, &differential, value, &constants);
        for &first in declaration.shape().rotations.iter() {
            for node in [Leaf::Q, Leaf::N] {
                slopes.turn([0, 1, 2, 3].map(|k| node(first + k)), value);
            }
        }
        slopes
    }

    /// Replaces derivatives by the components of a quaternion with those by turns.
    fn turn(&mut self, leaves: [Leaf; SLOTS], value: &dyn Fn(Leaf) -> f64) {
        if !self.leaves.iter().any(|leaf| leaves.contains(leaf)) {
            return;
        }
        let by_component = leaves.map(|leaf| self.by(leaf));
        let q = leaves.map(value);
        let mut rows = core::mem::take(&mut self.rows);
        for (i, row) in rows.iter_mut().enumerate() {
            let by_turn = rotation::body_covector(q, [0, 1, 2, 3].map(|k| by_component[k][i]));
            for ((leaf, slope), component) in leaves.into_iter().zip(by_turn).zip(&by_component) {
                self.add(row, leaf, slope - component[i]);
            }
        }
        self.rows = rows;
    }

    /// [`Slopes::of`] with given constants of the run, which depend on the parameters and the step.
    fn evaluated(
        declaration: &Declaration<'_>,
        differential: &Differential,
        value: &dyn Fn(Leaf) -> f64,
        constants: &Self,
    ) -> Self {
        let source = declaration.source();
        let mut room = Workspace::default();
        differential.evaluate(source, &mut room, 1, &mut |input| {
            Eight::splat(match input {
                Input::Leaf(leaf) => value(leaf),
                Input::Constant(place) => constants.values.get(place).copied().unwrap_or(f64::NAN),
            })
        });
        let inputs: Vec<Input> = differential.inputs().collect();
        let mut slopes = Self::default();
        for result in 0..differential.len() {
            slopes.values.push(differential.result(&room, result).0[0]);
            let mut row = vec![0.0; slopes.leaves.len()];
            differential.back_from(&mut room, result, &mut |input, slope| match inputs[input] {
                Input::Leaf(leaf) => slopes.add(&mut row, leaf, slope.0[0]),
                // by the chain rule; a constant with derivative zero is skipped
                Input::Constant(place) if slope.0[0] != 0.0 => {
                    for (leaf, own) in constants.moving(place) {
                        slopes.add(&mut row, leaf, slope.0[0] * own);
                    }
                }
                Input::Constant(_) => {}
            });
            slopes.rows.push(row);
        }
        slopes
    }

    /// Adds the derivative of a result by a leaf.
    fn add(&mut self, row: &mut Vec<f64>, leaf: Leaf, slope: f64) {
        let place = self
            .leaves
            .iter()
            .position(|known| *known == leaf)
            .unwrap_or_else(|| {
                self.leaves.push(leaf);
                self.leaves.len() - 1
            });
        if place >= row.len() {
            row.resize(place + 1, 0.0);
        }
        row[place] += slope;
    }

    /// The changes of the results for given rates of the leaves. Infinite derivatives by leaves with rate
    /// zero are skipped.
    pub(super) fn along(&self, rate: &dyn Fn(Leaf) -> f64) -> Vec<f64> {
        let rates: Vec<f64> = self.leaves.iter().map(|leaf| rate(*leaf)).collect();
        let change = |row: &Vec<f64>| {
            let moving = row.iter().zip(&rates).filter(|(_, rate)| **rate != 0.0);
            moving.map(|(slope, rate)| slope * rate).sum()
        };
        self.rows.iter().map(change).collect()
    }

    /// The derivatives of the results by a leaf.
    pub(super) fn by(&self, leaf: Leaf) -> Vec<f64> {
        let place = self.leaves.iter().position(|own| *own == leaf);
        let slope = |row: &Vec<f64>| place.and_then(|place| row.get(place)).copied().unwrap_or(0.0);
        self.rows.iter().map(slope).collect()
    }

    /// The derivatives of as many results by as many leaves, as a matrix.
    pub(super) fn square(&self, leaf: impl Fn(usize) -> Leaf) -> Square {
        let columns: Vec<Vec<f64>> = (0..self.values.len()).map(|j| self.by(leaf(j))).collect();
        Square::from_fn(self.values.len(), |i, j| columns[j][i])
    }

    /// The leaves that a result depends on, with its derivative by each.
    pub(super) fn moving(&self, result: usize) -> impl Iterator<Item = (Leaf, f64)> {
        let slopes = self.rows.get(result).map_or(&[][..], Vec::as_slice);
        let both = self.leaves.iter().copied().zip(slopes.iter().copied());
        both.filter(|(_, slope)| *slope != 0.0)
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
    /// The value of a leaf of the continuous system's segments; third derivatives and sides are zero.
    pub(super) fn value(&self, declaration: &Declaration<'_>, leaf: Leaf) -> f64 {
        let of = |vector: &[f64], i: usize| vector.get(i).copied().unwrap_or(f64::NAN);
        match leaf {
            Leaf::T => self.t,
            Leaf::Q(i) => of(self.q, i),
            Leaf::V(i) => of(self.v, i),
            Leaf::A(i) => of(self.a, i),
            Leaf::Lambda(i) => self.multipliers.get(i).copied().unwrap_or(0.0),
            Leaf::Parameter(i) => declaration.value(i),
            Leaf::J(_) | Leaf::Side(_) => 0.0,
            _ => f64::NAN,
        }
    }

    /// Results at this point, with their derivatives.
    pub(super) fn slopes(&self, declaration: &Declaration<'_>, wanted: &[(Segment, Part)]) -> Slopes {
        Slopes::of(declaration, wanted, &|leaf| self.value(declaration, leaf))
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
    /// The change of a leaf of the continuous system's segments, if the acceleration changes by `a`.
    pub(super) fn rate(&self, leaf: Leaf, a: &[f64]) -> f64 {
        let of = |vector: &[f64], i: usize| vector.get(i).copied().unwrap_or(0.0);
        match leaf {
            Leaf::Q(i) => of(&self.q, i),
            Leaf::V(i) => of(&self.v, i),
            Leaf::A(i) => of(a, i),
            Leaf::Parameter(i) => f64::from(u8::from(self.parameter == Some(i))),
            _ => 0.0,
        }
    }

    /// The first change plus `factor` times another; the parameter is that of the first.
    pub(super) fn plus(&self, other: &Self, factor: f64) -> Self {
        let sum = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x + factor * y).collect();
        Self {
            q: sum(&self.q, &other.q),
            v: sum(&self.v, &other.v),
            parameter: self.parameter,
        }
    }
}
