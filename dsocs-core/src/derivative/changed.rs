//! The derivatives of the step whose middle node is where inputs change their values.

use super::block::Recorded;
use crate::declaration::Declaration;
use crate::dense::Matrix;
use crate::flow::works;
use crate::multipliers;
use crate::scalar::Scalar as _;
use crate::system::Leg;
use crate::tangent::Tangent;

/// The number of Newton steps for the multipliers.
const MAX_ITERATIONS: u32 = 20;

/// The derivatives of the second difference, by columns.
#[derive(Clone, Debug)]
pub(super) struct Changed<const N: usize> {
    pub by_node: [[f64; N]; N],
    pub by_increment: [[f64; N]; N],
    /// By one parameter after another, as they are before the node, and from there on.
    pub by_parameters: [Vec<[f64; N]>; 2],
}

/// A step with two declarations: with the values before its middle node, and with those from there on.
pub(super) struct Change<'p, const N: usize> {
    pub sides: [Declaration<'p>; 2],
    pub h: f64,
    pub step: Recorded<N>,
}

/// The variables that change, and their rates.
struct Rates<'r, const N: usize> {
    node: [f64; N],
    increment: [f64; N],
    parameters: [&'r [f64]; 2],
    unknowns: &'r [f64],
}

impl<const N: usize> Change<'_, N> {
    /// The rows of the step, as [`crate::flow`] has them where nothing is kinematic or nonholonomic, with their change.
    fn rows(&self, unknowns: &[f64], rates: &Rates<'_, N>) -> Vec<Tangent> {
        let [old, new] = [0, 1].map(|side| self.sides[side].moving(rates.parameters[side]));
        let Recorded { leg, .. } = self.step;
        let h = Tangent::splat(self.h);
        let leg: Leg<Tangent, N> = Leg {
            t: Tangent::splat(leg.t),
            q: core::array::from_fn(|i| Tangent::new(leg.q[i], rates.node[i])),
            d: core::array::from_fn(|i| Tangent::new(leg.d[i], rates.increment[i])),
        };
        let x: Vec<Tangent> = (unknowns.iter().enumerate())
            .map(|(i, x)| Tangent::new(*x, rates.unknowns.get(i).copied().unwrap_or(0.0)))
            .collect();
        let (e, multipliers) = x.split_at(N);
        let leg = leg.any();
        let [before, after] = [&old, &new].map(|side| side.arriving(h, leg));
        let mut rows = new.declared(h, leg, e, multipliers);
        let lower = new.lower();
        rows.truncate(lower);
        let mut force = new.force(h, leg, e);
        for (i, force) in force.iter_mut().enumerate() {
            *force = *force + (after[i] - before[i]);
        }
        let sides = if lower > 0 { [&new, &new] } else { [&old, &new] };
        let [left, right] = sides.map(|side| works(side, h, leg, e, &force, multipliers));
        let half = Tangent::splat(0.5);
        rows.extend(
            left.into_iter()
                .zip(right)
                .map(|(left, right)| half * (left + right)),
        );
        rows
    }

    /// The derivatives of the second difference; `None` if they are not finite.
    pub fn slopes(&self, parameters: usize) -> Option<Changed<N>> {
        let still = Rates {
            node: [0.0; N],
            increment: [0.0; N],
            parameters: [&[], &[]],
            unknowns: &[],
        };
        let unit = |place: usize, count: usize| -> Vec<f64> {
            (0..count).map(|k| f64::from(u8::from(k == place))).collect()
        };
        let mut x = self.step.e.to_vec();
        x.extend(multipliers::of_step(
            &self.sides[1],
            self.h,
            self.step.leg.any(),
            &self.step.e,
        ));
        let by_unknowns = |x: &[f64]| {
            let columns: Vec<Vec<Tangent>> = (0..x.len())
                .map(|j| {
                    let unknowns = unit(j, x.len());
                    self.rows(
                        x,
                        &Rates {
                            unknowns: &unknowns,
                            ..still
                        },
                    )
                })
                .collect();
            let matrix = Matrix::from_fn(x.len(), x.len(), |i, j| columns[j][i].derivative());
            matrix.is_finite().then(|| (matrix.decomposed(), columns))
        };
        // both sides share their multipliers
        let mut solved = by_unknowns(&x)?;
        for _ in 0..if x.len() > N { MAX_ITERATIONS } else { 0 } {
            let rows: Vec<f64> = solved.1[0].iter().map(|row| row.value()).collect();
            let update = solved.0.solve(&rows, 0.0);
            let mut settled = true;
            for (x, update) in x.iter_mut().zip(update) {
                settled &= update.abs() <= 1e-12 * x.abs();
                *x -= update;
            }
            solved = by_unknowns(&x)?;
            if settled {
                break;
            }
        }
        let by = |rates: &Rates<'_, N>| -> [f64; N] {
            let right: Vec<f64> = self.rows(&x, rates).iter().map(|row| -row.derivative()).collect();
            let solution = solved.0.solve(&right, 0.0);
            core::array::from_fn(|i| solution.get(i).copied().unwrap_or(f64::NAN))
        };
        let vector = |j: usize| core::array::from_fn(|i| f64::from(u8::from(i == j)));
        let (mut by_node, mut by_increment) = ([[0.0; N]; N], [[0.0; N]; N]);
        for j in 0..N {
            let columns = [
                by(&Rates {
                    node: vector(j),
                    ..still
                }),
                by(&Rates {
                    increment: vector(j),
                    ..still
                }),
            ];
            for i in 0..N {
                (by_node[i][j], by_increment[i][j]) = (columns[0][i], columns[1][i]);
            }
        }
        let by_parameters = [0, 1].map(|side| {
            let column = |place: usize| {
                let rates = unit(place, parameters);
                let mut both: [&[f64]; 2] = [&[], &[]];
                both[side] = &rates;
                by(&Rates {
                    parameters: both,
                    ..still
                })
            };
            (0..parameters).map(column).collect()
        });
        let changed = Changed {
            by_node,
            by_increment,
            by_parameters,
        };
        changed.is_finite().then_some(changed)
    }
}

impl<const N: usize> Changed<N> {
    fn is_finite(&self) -> bool {
        let matrices = self.by_node.iter().chain(&self.by_increment);
        let all = matrices.chain(self.by_parameters.iter().flatten());
        all.flatten().all(|x| x.is_finite())
    }
}
