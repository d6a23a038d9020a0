//! The classical Runge–Kutta method, written by hand.

use crate::candidate::Candidate;
use crate::problem::{Equations, INTERVAL, intervals};

/// The method, with fixed steps that divide the grid's interval.
pub fn rk4<P: Equations<D>, const D: usize>(problem: P) -> impl Iterator<Item = Candidate> {
    [
        1_u32, 2, 3, 4, 5, 7, 10, 14, 20, 30, 50, 70, 100, 140, 200, 300, 500,
    ]
    .into_iter()
    .map(move |parts| {
        let h = INTERVAL / f64::from(parts);
        Candidate {
            solver: "RK4 by hand",
            setting: format!("h {h:e}"),
            run: Box::new(move |out| {
                let mut y = problem.start();
                out.extend_from_slice(&y[..P::MEASURED]);
                for _ in 0..intervals(P::END) {
                    for _ in 0..parts {
                        y = step(&problem, &y, h);
                    }
                    out.extend_from_slice(&y[..P::MEASURED]);
                }
                y.iter().all(|y| y.is_finite())
            }),
            clock: None,
        }
    })
}

#[inline]
fn step<P: Equations<D>, const D: usize>(problem: &P, y: &[f64; D], h: f64) -> [f64; D] {
    let moved = |k: &[f64; D], h: f64| core::array::from_fn(|i| y[i] + h * k[i]);
    let k1 = problem.rate(y);
    let k2 = problem.rate(&moved(&k1, h / 2.0));
    let k3 = problem.rate(&moved(&k2, h / 2.0));
    let k4 = problem.rate(&moved(&k3, h));
    core::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}
