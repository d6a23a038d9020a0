//! The operations of one order beyond 0, as they are walked: what an operation of [`Series`] becomes whose places are known.

use crate::kernel::series::{ACCELERATED, AGAIN, Code, LASTING, Operation, Place, Series};

/// An operation of an order. Places are those of sequences; `sum` is that of an inner sum.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    Time {
        to: Place,
    },
    Acceleration {
        to: Place,
        index: Place,
    },
    Multiplier {
        to: Place,
        index: Place,
    },
    /// `c u`.
    Scaled {
        to: Place,
        c: Place,
        u: Place,
    },
    /// `c u + d v`.
    Two {
        to: Place,
        c: [Place; 2],
        u: [Place; 2],
    },
    /// A sum of terms, which stand from the first on.
    Linear {
        to: Place,
        first: Place,
        count: Place,
    },
    Product {
        to: Place,
        u: Place,
        v: Place,
        sum: Place,
    },
    Square {
        to: Place,
        u: Place,
        sum: Place,
    },
    Quotient {
        to: Place,
        u: Place,
        v: Place,
        sum: Place,
    },
    Reciprocal {
        to: Place,
        v: Place,
        sum: Place,
    },
    Root {
        to: Place,
        u: Place,
        sum: Place,
    },
    Power {
        to: Place,
        u: Place,
        exponent: Place,
        sums: [Place; 2],
    },
    /// `w' = factor u'`.
    Rate {
        to: Place,
        u: Place,
        factor: Place,
        sum: Place,
    },
    /// `w' = (w + 1) u'`.
    ExpM1 {
        to: Place,
        u: Place,
        sum: Place,
    },
    /// A sine, and the cosine after it.
    Circle {
        sine: Place,
        u: Place,
        sums: [Place; 2],
    },
    /// `slope w' = u'`.
    BySlope {
        to: Place,
        u: Place,
        slope: Place,
        sum: Place,
    },
    /// `-u`.
    Minus {
        to: Place,
        u: Place,
    },
    Angle {
        to: Place,
        y: Place,
        x: Place,
        radius: Place,
        sums: [Place; 3],
    },
    Abs {
        to: Place,
        u: Place,
    },
    Select {
        to: Place,
        then: Place,
        otherwise: Place,
    },
    /// A call of a table, by the place of the operation among all.
    Call {
        to: Place,
    },
}

/// Longer sums are formed in several sums side by side, as the attribute has it.
pub(super) const SHORT_SUM: Place = 4;

/// The operations of an order: those that depend on no acceleration that is solved for, those that do, and those of the latter that are computed
/// again.
#[derive(Debug)]
pub(super) struct Lists {
    /// Positions and velocities, which come first: the sequence, and the place in a row of all of them.
    pub(super) moves: Vec<[Place; 2]>,
    pub(super) known: Vec<Step>,
    pub(super) accelerated: Vec<Step>,
    pub(super) again: Vec<Step>,
}

impl Lists {
    /// Those of some recurrences; `third` is the place of the factor 1/3.
    pub(super) fn new(series: &Series, third: Place) -> Self {
        let velocities = Place::try_from(series.coordinates).unwrap_or(Place::MAX);
        let mut lists = Self {
            moves: Vec::new(),
            known: Vec::new(),
            accelerated: Vec::new(),
            again: Vec::new(),
        };
        for (to, op) in (0..).zip(&series.operations) {
            if op.lists & LASTING == 0 {
                continue;
            }
            match op.code {
                Code::Position => lists.moves.push([to, op.index]),
                Code::Velocity => lists.moves.push([to, velocities + op.index]),
                _ => {
                    let Some(step) = step(series, to, op, third) else {
                        continue;
                    };
                    if op.lists & ACCELERATED == 0 {
                        lists.known.push(step);
                        continue;
                    }
                    lists.accelerated.push(step);
                    if op.lists & AGAIN > 0 {
                        lists.again.push(step);
                    }
                }
            }
        }
        lists
    }
}

/// An operation as it is walked; `None` if nothing is left to be done.
fn step(series: &Series, to: Place, op: &Operation, third: Place) -> Option<Step> {
    let [u, v, w, z] = op.parts;
    let sums = op.sums;
    let sum = sums[0];
    Some(match op.code {
        Code::Time => Step::Time { to },
        Code::Acceleration => Step::Acceleration { to, index: op.index },
        Code::Multiplier => Step::Multiplier { to, index: op.index },
        // their coefficients are zero, a cosine is computed with its sine, and leaves have come first
        Code::Constant | Code::Signum | Code::Cos | Code::Position | Code::Velocity => return None,
        Code::Linear => {
            let [first, count] = op.terms;
            let terms = series.terms.get(first as usize..)?;
            match (count, terms) {
                (1, &[[c, u], ..]) => Step::Scaled { to, c, u },
                (2, &[[c, u], [d, v], ..]) => Step::Two {
                    to,
                    c: [c, d],
                    u: [u, v],
                },
                _ => Step::Linear { to, first, count },
            }
        }
        Code::Product => Step::Product { to, u, v, sum },
        Code::Square => Step::Square { to, u, sum },
        Code::Quotient => Step::Quotient { to, u, v, sum },
        Code::Reciprocal => Step::Reciprocal { to, v: u, sum },
        Code::Root => Step::Root { to, u, sum },
        Code::CubeRoot | Code::Power => Step::Power {
            to,
            u,
            exponent: if op.code == Code::Power { op.index } else { third },
            sums: [sum, sums[1]],
        },
        Code::Exp => Step::Rate {
            to,
            u,
            factor: to,
            sum,
        },
        Code::ExpM1 => Step::ExpM1 { to, u, sum },
        Code::Sin => {
            let cosine = series.operations.get(v as usize)?;
            Step::Circle {
                sine: to,
                u,
                sums: [sum, cosine.sums[0]],
            }
        }
        Code::Sinh | Code::Cosh | Code::Tan | Code::Tanh => Step::Rate {
            to,
            u,
            factor: v,
            sum,
        },
        Code::Ln | Code::Ln1p => Step::BySlope {
            to,
            u,
            slope: u,
            sum,
        },
        Code::Asin | Code::Acos | Code::Atan | Code::Asinh | Code::Acosh | Code::Atanh => Step::BySlope {
            to,
            u,
            slope: v,
            sum,
        },
        Code::Conjugate => Step::Minus { to, u: v },
        Code::Atan2 => Step::Angle {
            to,
            y: u,
            x: v,
            radius: w,
            sums,
        },
        Code::Abs => Step::Abs { to, u },
        Code::Less | Code::LessOrEqual => Step::Select {
            to,
            then: w,
            otherwise: z,
        },
        Code::Call => Step::Call { to },
    })
}
