//! The derivatives of the step whose middle node is where inputs change their values.

use super::turning;
use crate::flow::works;
use crate::number::point::{AnyLeg, OwnedLeg};
use crate::number::scalar::Scalar as _;
use crate::number::tangent::Tangent;
use crate::regularity::multipliers;
use crate::solve::dense::Matrix;
use crate::tape::declaration::Declaration;

/// The number of Newton steps for the multipliers.
const MAX_ITERATIONS: u32 = 20;

/// The step at which inputs change.
#[derive(Clone, Debug)]
pub(super) struct DerivativesAtChange {
    /// The derivatives of its second difference.
    pub slopes: Slopes,
    /// The increment to the last node.
    pub increment: Vec<f64>,
    /// The second difference with the old values on both sides, to which the velocity of the node belongs.
    pub arriving: Vec<f64>,
    /// The derivatives of `arriving`.
    pub of_arriving: Slopes,
}

/// The derivatives of a second difference, by columns.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    /// The derivatives by the coordinates of the node, a column for each.
    by_node: Vec<Vec<f64>>,
    /// The derivatives by the components of the increment, a column for each.
    by_increment: Vec<Vec<f64>>,
    /// The derivatives by the parameters before the node, and by those after it, a column for each.
    by_parameters: [Vec<Vec<f64>>; 2],
}

/// A step with two declarations: with the values before its middle node, and with those from there on.
pub(super) struct StepAcrossChange<'p> {
    pub sides: [Declaration<'p>; 2],
    pub h: f64,
    /// The first two nodes.
    pub leg: AnyLeg<'p, f64>,
    /// The second difference.
    pub e: &'p [f64],
}

/// The variables that change, and their rates; empty ones are constant.
#[derive(Clone, Copy, Default)]
struct Rates<'r> {
    node: &'r [f64],
    increment: &'r [f64],
    parameters: [&'r [f64]; 2],
    unknowns: &'r [f64],
}

/// Numbers with rates of change.
fn moving(numbers: &[f64], rates: &[f64]) -> Vec<Tangent> {
    let rate = |i: usize| rates.get(i).copied().unwrap_or(0.0);
    let numbers = numbers.iter().enumerate();
    numbers.map(|(i, x)| Tangent::new(*x, rate(i))).collect()
}

impl StepAcrossChange<'_> {
    /// The rows of the step with their change, as in [`crate::flow`] without kinematic and nonholonomic
    /// constraints.
    fn rows(&self, unknowns: &[f64], rates: &Rates<'_>) -> Vec<Tangent> {
        let [old, new] = [0, 1].map(|side| self.sides[side].moving(rates.parameters[side]));
        let h = Tangent::splat(self.h);
        let leg = OwnedLeg {
            t: Tangent::splat(self.leg.t),
            q: moving(self.leg.q, rates.node),
            d: moving(self.leg.d, rates.increment),
        };
        let x = moving(unknowns, rates.unknowns);
        let (e, multipliers) = x.split_at(self.e.len());
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

    /// The derivatives of the step, with respect to `parameters` parameters; `None` if they are not finite.
    pub fn changed(&self, parameters: usize) -> Option<DerivativesAtChange> {
        let (slopes, _) = self.slopes(parameters)?;
        let old = StepAcrossChange {
            sides: [self.sides[0]; 2],
            ..*self
        };
        let (of_arriving, arriving) = old.slopes(parameters)?;
        Some(DerivativesAtChange {
            slopes,
            increment: self.leg.d.iter().zip(self.e).map(|(d, e)| d + e).collect(),
            arriving,
            of_arriving,
        })
    }

    /// The derivatives of the second difference that solves the rows, and the second difference; `None` if
    /// they are not finite.
    fn slopes(&self, parameters: usize) -> Option<(Slopes, Vec<f64>)> {
        let n = self.e.len();
        let still = Rates::default();
        let unit = |place: usize, count: usize| -> Vec<f64> {
            (0..count).map(|k| f64::from(u8::from(k == place))).collect()
        };
        let mut x = self.e.to_vec();
        x.extend(multipliers::of_step(&self.sides[1], self.h, self.leg, self.e));
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
        // both sides have the same multipliers
        let mut solved = by_unknowns(&x)?;
        for _ in 0..MAX_ITERATIONS {
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
        let by = |rates: &Rates<'_>| -> Vec<f64> {
            let right: Vec<f64> = self.rows(&x, rates).iter().map(|row| -row.derivative()).collect();
            let mut solution = solved.0.solve(&right, 0.0);
            solution.resize(n, f64::NAN);
            solution
        };
        let rotations = &self.sides[1].shape().rotations;
        let by_node = |j: usize| {
            by(&Rates {
                node: &turning::along(rotations, self.leg.q, j),
                ..still
            })
        };
        let by_increment = |j: usize| {
            by(&Rates {
                increment: &unit(j, n),
                ..still
            })
        };
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
        let slopes = Slopes {
            by_node: (0..n).map(by_node).collect(),
            by_increment: (0..n).map(by_increment).collect(),
            by_parameters,
        };
        x.truncate(n);
        slopes.is_finite().then_some((slopes, x))
    }
}

impl Slopes {
    /// The change of the second difference for changes of the node, the increment and the parameters, whose
    /// rates on both sides `rate` gives.
    pub fn change(&self, q: &[f64], d: &[f64], rate: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let n = q.len();
        let mut e: Vec<f64> = (0..n)
            .map(|i| {
                (0..n)
                    .map(|j| self.by_node[j][i] * q[j] + self.by_increment[j][i] * d[j])
                    .sum()
            })
            .collect();
        for (side, slopes) in self.by_parameters.iter().enumerate() {
            for (place, slope) in slopes.iter().enumerate() {
                for (e, slope) in e.iter_mut().zip(slope) {
                    *e += slope * rate(side, place);
                }
            }
        }
        e
    }

    /// Adds to the derivatives by the node, the increment and the parameters on both sides the part from
    /// those by the second difference.
    pub fn back(&self, by_e: &[f64], [q, d]: [&mut [f64]; 2], mut parameter: impl FnMut(usize, usize, f64)) {
        let product = |slope: &[f64]| {
            by_e.iter()
                .zip(slope)
                .map(|(by_e, slope)| by_e * slope)
                .sum::<f64>()
        };
        for (sums, columns) in [(q, &self.by_node), (d, &self.by_increment)] {
            for (sum, column) in sums.iter_mut().zip(columns) {
                *sum += product(column);
            }
        }
        for (side, slopes) in self.by_parameters.iter().enumerate() {
            for (place, slope) in slopes.iter().enumerate() {
                parameter(side, place, product(slope));
            }
        }
    }

    fn is_finite(&self) -> bool {
        let columns = self.by_node.iter().chain(&self.by_increment);
        let all = columns.chain(self.by_parameters.iter().flatten());
        all.flatten().all(|x| x.is_finite())
    }
}
