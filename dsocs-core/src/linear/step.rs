//! The linear model of the paper's step.
//!
//! The state of a step is the middle node as a run reports it: its position `q1` and the velocity of
//! `φ_{D_K}⁻¹(q0, q1, q2)`. The step maps the pair of nodes `(q0, q1)`, which has the same free directions,
//! to `(q1, q2)`; its derivatives follow from its rows by the implicit function theorem.

use super::chart::{Chart, ConstraintRows, Rows};
use super::continuous::{ROUNDINGS, Variational, singular, without_rounding};
use super::corner;
use super::error::LinearizationError;
use super::inputs_outputs::{InputsOutputs, Measured};
use super::model::{Columns, Frame, LinearModel, LinearTime};
use super::slopes::{At, Direction, Slopes};
use crate::geometry::{GeometryError, Triple, solvable};
use crate::kernel::Kernel;
use crate::number::bounded::UNIT;
use crate::number::point::{AnyLeg, OwnedLeg, OwnedPoint};
use crate::solve::{Square, rotation};
use crate::tape::declaration::Declaration;
use crate::tape::{Leaf, Part, Segment};

/// Largest number of iterations for the leg with a given velocity.
const MAX_ITERATIONS: u32 = 30;

/// An update below this part of leg and position is the last.
const SETTLED: f64 = 8.0 * f64::EPSILON;

/// An update below this is the last if it is no smaller than the one before.
const GOOD: f64 = 1e-11;

/// A solved step, with the derivatives of its equations and its node.
struct SolvedStep {
    h: f64,
    rotations: Vec<usize>,
    leg: OwnedLeg<f64>,
    e: Vec<f64>,
    rows: Slopes,
    jacobian: Square,
    second: Slopes,
    node: Slopes,
}

/// A change of the first two nodes of a step: of the middle node, and of the increment divided by the step.
#[derive(Clone, Debug)]
struct LegChange {
    q: Vec<f64>,
    rate: Vec<f64>,
    parameter: Option<usize>,
}

impl LegChange {
    /// The pair from both changes, one after the other.
    fn of(both: &[f64], parameter: Option<usize>) -> Self {
        let (q, rate) = both.split_at(both.len() / 2);
        Self {
            q: q.to_vec(),
            rate: rate.to_vec(),
            parameter,
        }
    }

    /// The change of a leaf of the tape for a leg of the length `h`.
    fn rate(&self, h: f64, leaf: Leaf) -> f64 {
        match leaf {
            Leaf::N(i) => self.q.get(i).copied().unwrap_or(0.0),
            Leaf::D(i) => h * self.rate.get(i).copied().unwrap_or(0.0),
            Leaf::Parameter(i) => f64::from(u8::from(self.parameter == Some(i))),
            _ => 0.0,
        }
    }
}

/// The changes of a step's results.
struct ResultChange {
    e: Vec<f64>,
    /// Position, velocity, acceleration and time of the node, then the constraint force.
    node: Vec<f64>,
}

impl SolvedStep {
    /// Solves the step after a leg, near a second difference.
    fn of(system: &dyn Kernel, h: f64, leg: OwnedLeg<f64>, near: &[f64]) -> Result<Self, LinearizationError> {
        let declaration = Declaration::of(system);
        let found = solvable::step(system, h, leg.any(), solvable::WantedSolution::Near(near));
        let rotations = &declaration.shape().rotations;
        let solution = found.map_err(|cause| failed(rotations, leg.any(), Box::new(cause)))?;
        let value = |leaf: Leaf| -> f64 {
            let of = |vector: &[f64], i: usize| vector.get(i).copied().unwrap_or(f64::NAN);
            match leaf {
                Leaf::Z(i) => of(&solution.z, i),
                Leaf::E(i) => of(&solution.e, i),
                other => of_leg(&declaration, h, leg.any(), other),
            }
        };
        let slopes = |segment, part| Slopes::of(&declaration, &[(segment, part)], &value);
        let rows = slopes(Segment::Residual, Part::Head);
        Ok(Self {
            jacobian: rows.square(Leaf::Z),
            rows,
            second: slopes(Segment::SecondDifference, Part::All),
            node: slopes(Segment::Node, Part::All),
            e: solution.e,
            rotations: declaration.shape().rotations.to_vec(),
            leg,
            h,
        })
    }

    fn coordinates(&self) -> usize {
        self.leg.q.len()
    }

    /// The middle node as a run reports it.
    fn point(&self) -> OwnedPoint<f64> {
        let n = self.coordinates();
        OwnedPoint::new(n, self.node.values[..=3 * n].to_vec())
    }

    /// The velocity of the middle node.
    fn velocity(&self) -> &[f64] {
        let n = self.coordinates();
        &self.node.values[n..2 * n]
    }

    /// The changes of the second difference and the node for a change of the first two nodes.
    fn change(&self, pair: &LegChange) -> Option<ResultChange> {
        let right = self.rows.along(&|leaf| pair.rate(self.h, leaf));
        let right: Vec<f64> = right.iter().map(|row| -row).collect();
        let z = self.jacobian.solve(&right)?;
        let e = self.second.along(&|leaf| match leaf {
            Leaf::Z(i) => z.get(i).copied().unwrap_or(0.0),
            other => pair.rate(self.h, other),
        });
        let node = self.node.along(&|leaf| match leaf {
            Leaf::E(i) => e.get(i).copied().unwrap_or(0.0),
            other => pair.rate(self.h, other),
        });
        Some(ResultChange { e, node })
    }

    /// The leg to the next node.
    fn next(&self) -> OwnedLeg<f64> {
        let d = self.next_increment();
        OwnedLeg {
            t: self.leg.t + self.h,
            q: rotation::moved(&self.rotations, &self.leg.q, &d),
            d,
        }
    }

    /// The increment of the leg to the next node.
    fn next_increment(&self) -> Vec<f64> {
        self.leg.d.iter().zip(&self.e).map(|(d, e)| d + e).collect()
    }

    /// The change of the next leg.
    fn next_pair(&self, pair: &LegChange, e: &[f64]) -> LegChange {
        let rate: Vec<f64> = pair
            .rate
            .iter()
            .zip(e)
            .map(|(rate, e)| rate + e / self.h)
            .collect();
        let increment: Vec<f64> = rate.iter().map(|rate| self.h * rate).collect();
        LegChange {
            q: rotation::carried(&self.rotations, &self.next_increment(), &pair.q, &increment),
            rate,
            parameter: pair.parameter,
        }
    }
}

/// The value of a leaf of the tape for a leg of the length `h`, or of a parameter.
fn of_leg(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>, leaf: Leaf) -> f64 {
    let of = |vector: &[f64], i: usize| vector.get(i).copied().unwrap_or(f64::NAN);
    match leaf {
        Leaf::H => h,
        Leaf::Clock => leg.t,
        Leaf::Parameter(i) => declaration.value(i),
        Leaf::N(i) => of(leg.q, i),
        Leaf::D(i) => of(leg.d, i),
        Leaf::P(_) => 0.0,
        _ => f64::NAN,
    }
}

/// The error of a step without a solution.
fn failed(
    rotations: &[usize],
    leg: AnyLeg<'_, f64>,
    cause: Box<crate::solve::failure::NewtonFailure>,
) -> LinearizationError {
    let back: Vec<f64> = leg.d.iter().map(|d| -d).collect();
    LinearizationError::Step(GeometryError::Step {
        q0: rotation::moved(rotations, leg.q, &back),
        q1: leg.q.to_vec(),
        cause,
    })
}

/// The constraints on positions and velocities on a leg: on its first node, and on the leg; as functions of
/// the middle node and the increment.
struct LegConstraints {
    h: f64,
    rotations: Vec<usize>,
    /// The increment from the second node back to the first.
    back: Vec<f64>,
    first: Slopes,
    pair: Slopes,
}

impl LegConstraints {
    fn of(declaration: &Declaration<'_>, h: f64, leg: AnyLeg<'_, f64>) -> Self {
        let rotations = declaration.shape().rotations.to_vec();
        let back: Vec<f64> = leg.d.iter().map(|d| -d).collect();
        let q = rotation::moved(&rotations, leg.q, &back);
        let first = At {
            t: leg.t - h,
            q: &q,
            v: &vec![0.0; q.len()],
            a: &[],
            multipliers: &[],
        };
        let pair = Slopes::of(declaration, &[(Segment::Pair, Part::All)], &|leaf| {
            of_leg(declaration, h, leg, leaf)
        });
        Self {
            first: first.slopes(declaration, &[(Segment::Phase, Part::Head)]),
            pair,
            rotations,
            back,
            h,
        }
    }

    /// The changes of the rows for a change of the first two nodes.
    fn along(&self, pair: &LegChange) -> Vec<f64> {
        let increment: Vec<f64> = pair.rate.iter().map(|rate| -self.h * rate).collect();
        let first = Direction {
            q: rotation::carried(&self.rotations, &self.back, &pair.q, &increment),
            v: Vec::new(),
            parameter: pair.parameter,
        };
        let mut rows = self.first.along(&|leaf| first.rate(leaf, &[]));
        rows.extend(self.pair.along(&|leaf| pair.rate(self.h, leaf)));
        rows
    }

    /// The rows that bind the increment: those of the first node, and those of the leg without those of its
    /// second node.
    fn of_increment<'r>(&self, rows: &'r [f64]) -> impl Iterator<Item = &'r f64> {
        let holonomic = self.first.values.len();
        rows[..holonomic].iter().chain(&rows[2 * holonomic..])
    }

    fn values(&self) -> Vec<f64> {
        [&self.first.values[..], &self.pair.values[..]].concat()
    }

    /// The derivatives of the rows by the middle node and by the increment divided by the step.
    fn rows(&self, coordinates: usize) -> Rows {
        let unit = |j: usize| {
            (0..2 * coordinates)
                .map(|i| f64::from(u8::from(i == j)))
                .collect::<Vec<f64>>()
        };
        let columns: Vec<Vec<f64>> = (0..2 * coordinates)
            .map(|j| self.along(&LegChange::of(&unit(j), None)))
            .collect();
        let still = self
            .rotations
            .iter()
            .flat_map(|first| [*first, coordinates + first]);
        Rows::new(&columns, 0..self.values().len(), still.collect())
    }
}

/// The changes of a leg along which its state changes by one minimal coordinate after the other.
struct Tangents {
    pairs: Vec<LegChange>,
    /// Position and velocity of the middle node, one after the other.
    states: Vec<Vec<f64>>,
    constraint_rows: Rows,
    leg_constraints: LegConstraints,
}

/// The change of the state, position and velocity one after the other.
fn state(pair: &LegChange, change: &ResultChange) -> Vec<f64> {
    let n = pair.q.len();
    [&pair.q[..], &change.node[n..2 * n]].concat()
}

impl Tangents {
    /// The tangents of a solved step.
    fn of(declaration: &Declaration<'_>, solved: &SolvedStep, chart: &Chart) -> Option<Self> {
        let n = solved.coordinates();
        let leg_constraints = LegConstraints::of(declaration, solved.h, solved.leg.any());
        let constraint_rows = leg_constraints.rows(n);
        let free: Vec<LegChange> = constraint_rows
            .kernel()
            .vectors
            .iter()
            .map(|both| LegChange::of(both, None))
            .collect();
        let states: Vec<Vec<f64>> = free
            .iter()
            .map(|pair| Some(state(pair, &solved.change(pair)?)))
            .collect::<Option<_>>()?;
        let minimal: Vec<Vec<f64>> = states
            .iter()
            .map(|both| chart.coordinates(&both[..n], &both[n..]))
            .collect();
        if minimal.len() != chart.len() {
            return None;
        }
        let matrix = Square::from_fn(minimal.len(), |i, j| minimal[j][i]);
        let (mut pairs, mut along) = (Vec::new(), Vec::new());
        for k in 0..minimal.len() {
            let unit: Vec<f64> = (0..minimal.len()).map(|i| f64::from(u8::from(i == k))).collect();
            let parts = matrix.solve(&unit)?;
            let sum = |of: &dyn Fn(usize) -> Vec<f64>| -> Vec<f64> {
                let mut sum = vec![0.0; 2 * n];
                for (j, part) in parts.iter().enumerate() {
                    sum.iter_mut().zip(of(j)).for_each(|(sum, x)| *sum += part * x);
                }
                sum
            };
            pairs.push(LegChange::of(
                &sum(&|j| [&free[j].q[..], &free[j].rate[..]].concat()),
                None,
            ));
            along.push(sum(&|j| states[j].clone()));
        }
        Some(Self {
            pairs,
            states: along,
            constraint_rows,
            leg_constraints,
        })
    }

    /// The change of a leg for a change of a parameter with constant minimal coordinates.
    fn of_parameter(&self, solved: &SolvedStep, chart: &Chart, parameter: usize) -> Option<LegChange> {
        let n = solved.coordinates();
        let still = LegChange::of(&vec![0.0; 2 * n], Some(parameter));
        let changes: Vec<f64> = self.leg_constraints.along(&still).iter().map(|x| -x).collect();
        let mut pair = LegChange::of(&self.constraint_rows.shortest(&changes), Some(parameter));
        let both = state(&pair, &solved.change(&pair)?);
        let parts = chart.coordinates(&both[..n], &both[n..]);
        for (part, own) in parts.iter().zip(&self.pairs) {
            for (sums, own) in [(&mut pair.q, &own.q), (&mut pair.rate, &own.rate)] {
                sums.iter_mut().zip(own).for_each(|(sum, x)| *sum -= part * x);
            }
        }
        Some(pair)
    }
}

/// The solved step whose middle node has the given position, and the given velocity along the free
/// directions.
fn solved_at(
    system: &dyn Kernel,
    h: f64,
    at: &At<'_>,
    chart: &Chart,
) -> Result<SolvedStep, LinearizationError> {
    let declaration = &Declaration::of(system);
    let n = at.q.len();
    let moving: Vec<usize> = (0..n).filter(|place| declaration.shape().moves(*place)).collect();
    let lost = || LinearizationError::Leg {
        h,
        q: at.q.to_vec(),
        v: at.v.to_vec(),
    };
    let mut leg = OwnedLeg {
        t: at.t,
        q: at.q.to_vec(),
        d: at
            .v
            .iter()
            .zip(at.a)
            .map(|(v, a)| h * v - h * h / 2.0 * a)
            .collect(),
    };
    let mut near: Vec<f64> = at.a.iter().map(|a| h * h * a).collect();
    let mut last = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let solved = SolvedStep::of(system, h, leg.clone(), &near)?;
        let constraint_rows = LegConstraints::of(declaration, h, leg.any());
        let rows_of = |velocity: &[f64], bound: &[f64]| -> Vec<f64> {
            let mut rows = chart.velocities.coordinates(velocity);
            rows.extend(constraint_rows.of_increment(bound));
            rows
        };
        let missing: Vec<f64> = solved
            .velocity()
            .iter()
            .zip(at.v)
            .map(|(found, v)| v - found)
            .collect();
        let bound: Vec<f64> = constraint_rows.values().iter().map(|row| -row).collect();
        let wanted = rows_of(&missing, &bound);
        let mut columns = Vec::with_capacity(moving.len());
        for &j in &moving {
            let mut pair = LegChange::of(&vec![0.0; 2 * n], None);
            pair.rate[j] = 1.0;
            let change = solved.change(&pair).ok_or_else(|| singular(declaration, at))?;
            columns.push(rows_of(&change.node[n..2 * n], &constraint_rows.along(&pair)));
        }
        if columns.iter().any(|column| column.len() != moving.len()) {
            return Err(singular(declaration, at));
        }
        let matrix = Square::from_fn(moving.len(), |i, j| columns[j][i]);
        let update = matrix.solve(&wanted).ok_or_else(|| singular(declaration, at))?;
        let (mut step, mut size) = (0.0_f64, 0.0_f64);
        for (&place, update) in moving.iter().zip(update.iter()) {
            leg.d[place] += h * update;
            step = step.max((h * update).abs());
            size = size.max(leg.d[place].abs()).max(leg.q[place].abs());
        }
        if step <= SETTLED * size || (step >= last && step <= GOOD * size) {
            // the step solved before this update is as accurate
            return Ok(solved);
        }
        near = solved.e;
        last = step;
    }
    Err(lost())
}

/// The linear model of the step `h` at a point of a motion.
pub(super) fn linearized(
    system: &dyn Kernel,
    h: f64,
    at: &At<'_>,
    inputs_outputs: &InputsOutputs,
) -> Result<LinearModel, LinearizationError> {
    let declaration = &Declaration::of(system);
    corner::check(declaration, at)?;
    let chart = ConstraintRows::of(declaration, at).chart();
    let here = solved_at(system, h, at, &chart)?;
    let next = SolvedStep::of(system, h, here.next(), &here.e)?;
    corner::check_triple(declaration, h, &Triple::new(here.leg.any(), &here.e), at)?;
    let (point, point_after) = (here.point(), next.point());
    let next_chart = {
        let after = point_after.any();
        let after = At {
            t: after.t,
            q: &next.leg.q,
            v: after.v,
            a: after.a,
            multipliers: &[],
        };
        chart.carried_to(&ConstraintRows::of(declaration, &after).chart())
    };
    let none = || singular(declaration, at);
    let tangents = Tangents::of(declaration, &here, &chart).ok_or_else(none)?;
    let tangents_after = Tangents::of(declaration, &next, &next_chart).ok_or_else(none)?;
    let reported = point.any();
    let place = At {
        t: reported.t,
        q: reported.q,
        v: reported.v,
        a: reported.a,
        multipliers: &[],
    };
    let measured = Measured::of(declaration, inputs_outputs, &place, &here.leg.q);
    let (n, rotations) = (here.coordinates(), &declaration.shape().rotations);
    // the columns of the state and of the outputs, for a change of the leg
    let column = |pair: &LegChange| -> Option<[Vec<f64>; 2]> {
        let change = here.change(pair)?;
        let pair_after = here.next_pair(pair, &change.e);
        let change_after = next.change(&pair_after)?;
        let [q, v, a] = [0, 1, 2].map(|k| change.node[k * n..(k + 1) * n].to_vec());
        let q = rotation::body(rotations, place.q, &q);
        let force = || change.node[3 * n + 1..].to_vec();
        let direction = Direction {
            q,
            v,
            parameter: pair.parameter,
        };
        let outputs = measured.change(&pair.q, &direction, &a, &force);
        let after = next_chart.coordinates(&pair_after.q, &change_after.node[n..2 * n]);
        Some([after, outputs])
    };
    let mut columns = Columns::default();
    for pair in &tangents.pairs {
        let [a, c] = column(pair).ok_or_else(none)?;
        columns.a.push(a);
        columns.c.push(c);
    }
    for &parameter in inputs_outputs.inputs() {
        let pair = tangents.of_parameter(&here, &chart, parameter).ok_or_else(none)?;
        let [b, d] = column(&pair).ok_or_else(none)?;
        columns.b.push(b);
        columns.d.push(d);
    }
    if !columns.is_finite() {
        return Err(none());
    }
    let minus = |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| x - y).collect() };
    let mut way = minus(&next.leg.q, &here.leg.q);
    rotation::difference(rotations, [&here.leg.q, &next.leg.q], &mut way);
    // the difference of two positions rounds with the positions, that of two velocities with these over h
    let of_a = Variational::of(declaration, at).rounding(declaration, at);
    let places = here.leg.q.iter().zip(&of_a);
    let of_way: Vec<f64> = places
        .map(|(q, a)| ROUNDINGS * UNIT * q.abs() + h * h * a)
        .collect();
    let of_change: Vec<f64> = of_way.iter().map(|way| way / h).collect();
    let drift = chart.coordinates(
        &without_rounding(&way, &of_way),
        &without_rounding(&minus(next.velocity(), here.velocity()), &of_change),
    );
    let force = || here.node.values[3 * n + 1..].to_vec();
    let told = (drift, measured.values(&force));
    let frame = Frame {
        declaration,
        inputs_outputs,
        chart: &chart,
        time: LinearTime::Step { h },
        point: OwnedPoint::new(
            n,
            [&here.leg.q[..], reported.v, reported.a, &[here.leg.t]].concat(),
        ),
    };
    Ok(frame.model(&columns, told, [tangents.states, tangents_after.states]))
}
