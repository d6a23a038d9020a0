//! The Taylor series of a motion from a tape alone: the rows of the continuous system, evaluated with jets.
//!
//! At order `k` the rows are `J x_k + r_k`, where `x` are the accelerations and the multipliers, `J` the Jacobian at order 0, and `r_k` knows lower
//! orders only. So every order takes two evaluations: one with `x_k = 0`, which gives `r_k`, and one with `x_k = -J⁻¹ r_k`, which leaves what the
//! operations keep for the orders that follow. Generated recurrences need neither the second nor the interpreter, and are several times as fast.

use core::cell::Cell;

use super::Tolerance;
use super::flow::AnyTaylorFlow;
use super::recurrences::SeriesKernel;
use super::state::State;
use crate::error::SetupError;
use crate::kernel::{Kernel, TapeKernel};
use crate::series::jet::{Call, Jet};
use crate::series::rows::Series;
use crate::series::switch::Switch;
use crate::solve::convergence::LAST_UPDATE;
use crate::solve::dense::Matrix;
use crate::start::AnyStart;
use crate::tape::declaration::Declaration;
use crate::tape::{Leaf, Number as _, Part, Segment, Source as _};

/// How often the accelerations of order 0 are improved.
const MAX_ITERATIONS: u32 = 50;

/// The series of a tape, with what it needs from order to order.
pub(super) struct TapeSeries<'s> {
    kernel: &'s dyn Kernel,
    /// The values of the parameters.
    values: Vec<f64>,
    /// The rows as a function of time.
    rows: Call,
    /// How many coordinates there are.
    coordinates: usize,
    /// Accelerations and multipliers of order 0, and of the order that is computed.
    unknowns: [Vec<f64>; 2],
    /// The last update of order 0.
    update: Vec<f64>,
    /// The rows, then their Jacobian row by row.
    results: Vec<Jet>,
    /// The inverse of the Jacobian.
    inverse: Matrix,
    /// What the switches are: none has a name, and without signs they are places of steep functions.
    names: &'static [&'static str],
    /// Room for a step.
    room: Cell<Vec<f64>>,
}

/// The order that is computed, and a point of expansion.
struct Place<'a> {
    order: usize,
    t: f64,
    /// Position and velocity, of order 0 and of this order.
    q: [&'a [f64]; 2],
    v: [&'a [f64]; 2],
    /// Accelerations, then multipliers.
    x: [&'a [f64]; 2],
}

impl Place<'_> {
    /// What a leaf is there.
    fn leaf(&self, declaration: &Declaration<'_>, leaf: Leaf) -> Jet {
        let n = self.q[0].len();
        let (vectors, i) = match leaf {
            Leaf::T => return Jet::moving(self.t, if self.order == 1 { 1.0 } else { 0.0 }),
            Leaf::Parameter(i) => return Jet::from(declaration.value(i)),
            Leaf::Q(i) => (self.q, i),
            Leaf::V(i) => (self.v, i),
            Leaf::A(i) => (self.x, i),
            Leaf::Lambda(i) => (self.x, n + i),
            _ => return Jet::from(f64::NAN),
        };
        match vectors.map(|vector| vector.get(i)) {
            [Some(&value), Some(&now)] if self.order > 0 => Jet::moving(value, now),
            [Some(&value), _] => Jet::moving(value, 0.0),
            _ => Jet::from(f64::NAN),
        }
    }
}

impl<'s> TapeSeries<'s> {
    /// The series of a kernel with the values that its parameters have. It may call no functions of the user's.
    pub(super) fn new(kernel: &'s dyn Kernel) -> Self {
        let (tape, shape) = (kernel.tape(), kernel.shape());
        let size = tape.count(Segment::Continuous, Part::Head);
        Self {
            rows: Call::default(),
            kernel,
            values: (0..shape.parameters.len())
                .map(|place| kernel.value(place))
                .collect(),
            coordinates: shape.dimension(),
            unknowns: [vec![0.0; size], vec![0.0; size]],
            update: vec![0.0; size],
            results: vec![Jet::from(f64::NAN); size * (1 + size)],
            inverse: Matrix::zeros(size, size),
            names: if tape.branches(Segment::Continuous) {
                &["an expression"]
            } else {
                &[""]
            },
            room: Cell::default(),
        }
    }

    /// The Taylor coefficients of the motion from the point where the series begins.
    fn expand_with(&mut self, declaration: &Declaration<'_>, series: &mut Series) {
        let n = self.coordinates;
        for (x, &guess) in self.unknowns[0].iter_mut().zip(series.velocity_of(1)) {
            *x = if guess.is_finite() { guess } else { 0.0 };
        }
        self.unknowns[0][n..].fill(0.0);
        self.solve(declaration, series);
        series.advance(0, &self.unknowns[0][..n]);
        for k in 1..series.order() {
            self.unknowns[1].fill(0.0);
            self.evaluate(declaration, series, k, false);
            for (i, x) in self.unknowns[1].iter_mut().enumerate() {
                let rows = self.results.iter().enumerate().take(self.update.len());
                *x = -rows
                    .map(|(j, row)| self.inverse[(i, j)] * row.coefficient())
                    .sum::<f64>();
            }
            self.evaluate(declaration, series, k, true);
            series.advance(k, &self.unknowns[1][..n]);
        }
    }

    /// Solves the rows for the accelerations and the multipliers of order 0, by Newton's method; NaN if there is no solution.
    fn solve(&mut self, declaration: &Declaration<'_>, series: &Series) {
        let size = self.update.len();
        let mut is_last = false;
        for _ in 0..=MAX_ITERATIONS {
            self.evaluate(declaration, series, 0, false);
            let (rows, jacobian) = self.results.split_at(size);
            self.inverse = Matrix::from_fn(size, size, |i, j| jacobian[i * size + j].value()).inverse();
            if is_last {
                return;
            }
            let mut largest = 0.0_f64;
            for (i, (update, x)) in self.update.iter_mut().zip(&mut self.unknowns[0]).enumerate() {
                let rows = rows.iter().enumerate();
                *update = -rows
                    .map(|(j, row)| self.inverse[(i, j)] * row.value())
                    .sum::<f64>();
                *x += *update;
                largest = largest.max(x.abs());
            }
            // after an update that is small one more has been made good by quadratic convergence
            is_last = self
                .update
                .iter()
                .all(|update| update.abs() <= LAST_UPDATE * largest);
        }
        self.unknowns[0].fill(f64::NAN);
    }

    /// Evaluates the rows and their Jacobian at an order; once more, if they have been evaluated there.
    fn evaluate(&mut self, declaration: &Declaration<'_>, series: &Series, k: usize, again: bool) {
        let source = declaration.source();
        let program = source.tape().program(Segment::Continuous, Part::All);
        let [x, now] = &self.unknowns;
        let (q, v) = series.start();
        let place = Place {
            order: k,
            t: series.time(),
            q: [q, series.position_of(k)],
            v: [v, series.velocity_of(k)],
            x: [x, now],
        };
        let results = &mut self.results;
        let function = || {
            Jet::walk(
                program,
                source,
                &|leaf| place.leaf(declaration, leaf),
                &mut |at, value| {
                    if let Some(result) = results.get_mut(at) {
                        *result = value;
                    }
                },
            );
            // the rows move
            Jet::moving(0.0, 0.0)
        };
        match (k, again) {
            (0, _) => self.rows.begin(function),
            (_, false) => self.rows.next::<false>(k, function),
            (_, true) => self.rows.again(k, function),
        };
    }
}

impl SeriesKernel for TapeSeries<'_> {
    fn kernel(&self) -> &dyn Kernel {
        self.kernel
    }

    fn values(&self) -> &[f64] {
        &self.values
    }

    fn set_values(&mut self, values: &[f64]) {
        for (own, value) in self.values.iter_mut().zip(values) {
            *own = *value;
        }
        self.rows = Call::default();
    }

    fn expand(&mut self, series: &mut Series) {
        let values = core::mem::take(&mut self.values);
        self.expand_with(&Declaration::of(self.kernel).with(&values), series);
        self.values = values;
    }

    fn along(&self, series: &Series, h: f64, from: &State, to: &mut State) {
        let n = self.coordinates;
        let mut room = self.room.take();
        room.resize(2 * n, 0.0);
        let (q, v) = room.split_at_mut(n);
        to.copy(from);
        series.increments(h, [&mut *q, &mut *v, to.parts().a]);
        to.move_position(q);
        to.move_velocity(v);
        self.room.set(room);
    }

    fn switches(&self) -> &[&'static str] {
        self.names
    }

    // the rows are one function, with all switches in its group; the declaration's own group is empty
    fn groups(&self) -> usize {
        2
    }

    fn group(&mut self, group: usize) -> &mut [Switch] {
        match group {
            1 => self.rows.switches(),
            _ => &mut [],
        }
    }

    fn enter(&mut self) -> bool {
        self.rows.enter_pieces()
    }
}

impl<'s> AnyTaylorFlow<'s> {
    /// The motion of a system that was not compiled; see [`crate::TaylorFlow::new`].
    ///
    /// # Errors
    ///
    /// As [`crate::TaylorFlow::new`]; and [`SetupError::StartLength`] if the start has another number of coordinates.
    #[doc(hidden)]
    pub fn of_tape(
        kernel: &'s TapeKernel,
        start: &AnyStart,
        tolerance: Tolerance,
    ) -> Result<Self, SetupError> {
        start.fits(kernel.shape())?;
        Self::new(Box::new(TapeSeries::new(kernel)), &start.0, &tolerance)
    }

    /// Hands out nodes on a grid of times; see [`crate::TaylorFlow::every`].
    ///
    /// # Errors
    ///
    /// [`SetupError::Step`] if `h` is zero, infinite or not a number.
    #[doc(hidden)]
    pub fn every(mut self, h: f64) -> Result<Self, SetupError> {
        self.put_on_grid(h)?;
        Ok(self)
    }

    /// How many steps were made.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.motion.steps
    }
}

#[cfg(test)]
mod tests {
    use dsocs_macros::dsocs;

    use super::*;
    use crate::system::System;
    use crate::taylor::recurrences::Recurrences;

    /// Every kind of operation that a series knows, forces and a multiplier.
    #[dsocs {
        coordinates(x, y, z);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2) * (2 + x.sin()))
            - (1 + x.powi(2)).sqrt() - (y / 3).exp() * z.cos();
        holonomic = [x.powi(2) + y.powi(2) + z - 1];
        external_forces = (-(dot(x) / 2).tanh(), t.sin() * y.atan(), dot(z).abs() / (2 + y.powi(2)));
    }]
    struct Everything {
        mass: f64,
    }

    #[test]
    fn a_tape_has_the_series_of_the_generated_recurrences() {
        let system = Everything { mass: 1.5 };
        let mut of_tape = TapeSeries::new(&system);
        let mut generated = Recurrences::<_, 3>::new(&system, false);
        for (q, v) in [
            ([0.5, 0.25, 0.6875], [1.0, -0.5, -0.75]),
            ([0.1, -0.7, 0.5], [0.2, 0.3, 0.38]),
        ] {
            let series = [false, true].map(|is_tape| {
                let mut series = Series::new(3, 24);
                series.begin(0.75, &q, &v);
                if is_tape {
                    of_tape.expand(&mut series);
                } else {
                    generated.expand(&mut series);
                }
                series
            });
            // relative to what the coefficients are in units of the radius of convergence
            let radius = (1..=24)
                .map(|k| {
                    let largest = series[0]
                        .velocity_of(k)
                        .iter()
                        .fold(0.0_f64, |most, x| most.max(x.abs()));
                    largest.powf(-1.0 / k as f64)
                })
                .fold(f64::INFINITY, f64::min);
            for k in 0..=24 {
                let [one, other] = [0, 1].map(|place: usize| series[place].velocity_of(k));
                for (one, other) in one.iter().zip(other) {
                    let apart = (one - other).abs() * radius.powi(i32::try_from(k).unwrap());
                    assert!(apart < 1e-13, "order {k}: {one:e} {other:e}");
                }
            }
            assert!(series[1].velocity_of(24).iter().all(|x| *x != 0.0));
        }
        assert_eq!(<Everything as System<3>>::COORDINATES.len(), 3);
    }
}
