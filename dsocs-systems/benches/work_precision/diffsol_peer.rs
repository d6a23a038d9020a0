//! The crate `diffsol`: its explicit method of Tsitouras of order 5, and its implicit BDF.

use diffsol::{MatrixCommon as _, NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod};

use crate::candidate::{Candidate, tolerances};
use crate::problem::{Equations, grid};

type Matrix = NalgebraMat<f64>;

/// A slice as an array.
fn state<const D: usize>(y: &[f64]) -> [f64; D] {
    core::array::from_fn(|i| y[i])
}

/// Tsitouras' method, over a range of tolerances.
pub fn tsit45<P: Equations<D>, const D: usize>(problem: P) -> impl Iterator<Item = Candidate> {
    tolerances(1, 12).map(move |tolerance| {
        Candidate::tolerance("diffsol TSIT45", tolerance, move |out| {
            let built = OdeBuilder::<Matrix>::new()
                .rtol(tolerance)
                .atol([tolerance])
                .rhs(move |y: &[f64], _: &[f64], _: f64, rate: &mut [f64]| {
                    rate.copy_from_slice(&problem.rate(&state(y)));
                })
                .init(
                    move |_: &[f64], _: f64, y: &mut [f64]| y.copy_from_slice(&problem.start()),
                    D,
                )
                .build();
            let Ok(built) = built else {
                return false;
            };
            let Ok(mut solver) = built.tsit45() else {
                return false;
            };
            let Ok((states, _)) = solver.solve_dense(&grid(P::END)) else {
                return false;
            };
            collect::<P, D>(&states, out);
            true
        })
    })
}

/// BDF with a Jacobian by differences along a direction, over a range of tolerances.
pub fn bdf<P: Equations<D>, const D: usize>(problem: P) -> impl Iterator<Item = Candidate> {
    tolerances(1, 10).map(move |tolerance| {
        Candidate::tolerance("diffsol BDF", tolerance, move |out| {
            let built = OdeBuilder::<Matrix>::new()
                .rtol(tolerance)
                .atol([tolerance])
                .rhs_implicit(
                    move |y: &[f64], _: &[f64], _: f64, rate: &mut [f64]| {
                        rate.copy_from_slice(&problem.rate(&state(y)));
                    },
                    move |y: &[f64], _: &[f64], _: f64, direction: &[f64], product: &mut [f64]| {
                        let y: [f64; D] = state(y);
                        let size = direction.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
                        if size == 0.0 {
                            product.fill(0.0);
                            return;
                        }
                        let step = 1e-7 / size;
                        let moved = |sign: f64| core::array::from_fn(|i| y[i] + sign * step * direction[i]);
                        let (ahead, back) = (problem.rate(&moved(1.0)), problem.rate(&moved(-1.0)));
                        for i in 0..D {
                            product[i] = (ahead[i] - back[i]) / (2.0 * step);
                        }
                    },
                )
                .init(
                    move |_: &[f64], _: f64, y: &mut [f64]| y.copy_from_slice(&problem.start()),
                    D,
                )
                .build();
            let Ok(built) = built else {
                return false;
            };
            let Ok(mut solver) = built.bdf::<NalgebraLU<f64>>() else {
                return false;
            };
            let Ok((states, _)) = solver.solve_dense(&grid(P::END)) else {
                return false;
            };
            collect::<P, D>(&states, out);
            true
        })
    })
}

/// Appends the measured components, column by column.
fn collect<P: Equations<D>, const D: usize>(states: &Matrix, out: &mut Vec<f64>) {
    for column in 0..states.ncols() {
        out.extend((0..P::MEASURED).map(|row| states[(row, column)]));
    }
}
