//! The operations of one order beyond 0 in the form that is interpreted: those of [`Series`] with fixed
//! places.

use crate::kernel::series::{ACCELERATED, AGAIN, Code, LASTING, Operation, Series};
use crate::series::orders::LANES;

/// The place of a sequence, a factor or a sum. Tables have an entry for every possible place, so that no
/// bounds are checked.
pub(super) type Place = u16;

/// The number of possible places.
pub(super) const ROOM: usize = 1 << Place::BITS;

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
    /// `c u + d v + e w`, the largest sum with its terms inside a step.
    Three {
        to: Place,
        c: [Place; 3],
        u: [Place; 3],
    },
    /// A sum of terms, stored from the first on.
    Linear {
        to: Place,
        first: u32,
        count: u32,
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
        cosine: Place,
        u: Place,
        sums: [Place; 2],
    },
    /// A function with `w' = g u'`, its square, and `g = 1 - w²`, one after the other.
    Tangent {
        to: Place,
        u: Place,
        slope: Place,
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
    /// A call of a table, by the index of the operation among all.
    Call {
        to: Place,
    },
}

/// Longer sums are split into several independent sums, as in the attribute's code.
pub(super) const SHORT_SUM: usize = 4;

/// The operations of an order: those independent of accelerations that are solved for, those that depend on
/// them, and those of the latter that are evaluated again.
#[derive(Debug)]
pub(super) struct Lists {
    /// The terms of long sums: factors and sequences.
    pub(super) terms: Vec<[Place; 2]>,
    /// The sequences of each coordinate: position, velocity and acceleration. Those that are no operands have
    /// the place that nothing reads.
    pub(super) coordinates: Vec<[Place; 3]>,
    pub(super) known: Vec<Step>,
    pub(super) accelerated: Vec<Step>,
    pub(super) again: Vec<Step>,
}

impl Lists {
    /// The lists of some recurrences; `None` if there are more than possible places.
    pub(super) fn new(series: &Series) -> Option<Self> {
        // after the others come a sequence that is zero, one that nothing reads, and a factor 1/3
        let third = narrow(u32::try_from(series.factors()).ok()?)?;
        let unread = narrow(u32::try_from(series.operations.len() + 1).ok()?)?;
        let blocks = series.products.len().div_ceil(LANES) + series.squares.len().div_ceil(LANES);
        if blocks * LANES > ROOM {
            return None;
        }
        let mut lists = Self {
            terms: Vec::new(),
            coordinates: Vec::new(),
            known: Vec::new(),
            accelerated: Vec::new(),
            again: Vec::new(),
        };
        for &term in &series.terms {
            lists.terms.push(all(term)?);
        }
        for &acceleration in &series.accelerations {
            lists.coordinates.push([unread, unread, narrow(acceleration)?]);
        }
        for (to, op) in (0..).zip(&series.operations) {
            let to = narrow(to)?;
            if op.lists & LASTING == 0 {
                continue;
            }
            match op.code {
                Code::Position => lists.coordinates.get_mut(op.index as usize)?[0] = to,
                Code::Velocity => lists.coordinates.get_mut(op.index as usize)?[1] = to,
                // their higher coefficients are zero, and a cosine is computed with its sine
                Code::Constant | Code::Signum | Code::Cos => {}
                _ => {
                    let step = step(series, to, op, third)?;
                    if op.lists & ACCELERATED == 0 {
                        lists.known.push(step);
                        join(&mut lists.known);
                        continue;
                    }
                    lists.accelerated.push(step);
                    join(&mut lists.accelerated);
                    if op.lists & AGAIN > 0 {
                        lists.again.push(step);
                        join(&mut lists.again);
                    }
                }
            }
        }
        Some(lists)
    }
}

/// A place, if it is possible.
pub(super) fn narrow(place: u32) -> Option<Place> {
    Place::try_from(place).ok()
}

/// Several places, if all are possible.
fn all<const K: usize>(places: [u32; K]) -> Option<[Place; K]> {
    let mut narrow = [0; K];
    for (to, place) in narrow.iter_mut().zip(places) {
        *to = Place::try_from(place).ok()?;
    }
    Some(narrow)
}

/// Joins the last steps to one if there is an operation for all of them.
fn join(steps: &mut Vec<Step>) {
    if let [
        ..,
        Step::Rate { to, u, factor, sum },
        Step::Square {
            to: square,
            u: value,
            sum: of_square,
        },
        Step::Minus {
            to: slope,
            u: negative,
        },
    ] = **steps
        && (factor, value, negative) == (slope, to, square)
        && (usize::from(square), usize::from(slope)) == (usize::from(to) + 1, usize::from(to) + 2)
    {
        let before = steps.len() - 3;
        steps.truncate(before);
        steps.push(Step::Tangent {
            to,
            u,
            slope,
            sums: [sum, of_square],
        });
    }
}

/// The step of an operation.
fn step(series: &Series, to: Place, op: &Operation, third: Place) -> Option<Step> {
    let [u, v, w, z] = all(op.parts)?;
    let sums = all(op.sums)?;
    let sum = sums[0];
    Some(match op.code {
        Code::Time => Step::Time { to },
        Code::Acceleration => Step::Acceleration {
            to,
            index: narrow(op.index)?,
        },
        Code::Multiplier => Step::Multiplier {
            to,
            index: narrow(op.index)?,
        },
        // these are done before, or need no operation
        Code::Constant | Code::Signum | Code::Cos | Code::Position | Code::Velocity => return None,
        Code::Linear => {
            let [first, count] = op.terms;
            let terms = series.terms.get(first as usize..)?;
            match (count, terms) {
                (1, &[term, ..]) => {
                    let [c, u] = all(term)?;
                    Step::Scaled { to, c, u }
                }
                (2, &[one, other, ..]) => {
                    let ([c, u], [d, v]) = (all(one)?, all(other)?);
                    Step::Two {
                        to,
                        c: [c, d],
                        u: [u, v],
                    }
                }
                (3, &[one, other, third, ..]) => {
                    let ([c, u], [d, v], [e, w]) = (all(one)?, all(other)?, all(third)?);
                    Step::Three {
                        to,
                        c: [c, d, e],
                        u: [u, v, w],
                    }
                }
                _ => Step::Linear { to, first, count },
            }
        }
        Code::Product => Step::Product { to, u, v, sum },
        Code::Square => Step::Square { to, u, sum },
        Code::Quotient => Step::Quotient { to, u, v, sum },
        Code::Reciprocal => Step::Reciprocal { to, v: u, sum },
        Code::Root => Step::Root { to, u, sum },
        Code::CubeRoot => Step::Power {
            to,
            u,
            exponent: third,
            sums: [sum, sums[1]],
        },
        Code::Power => Step::Power {
            to,
            u,
            exponent: narrow(op.index)?,
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
            let [other, ..] = all(series.operations.get(usize::from(v))?.sums)?;
            Step::Circle {
                sine: to,
                cosine: v,
                u,
                sums: [sum, other],
            }
        }
        Code::Sinh | Code::Cosh | Code::Tan | Code::Tanh => Step::Rate {
            to,
            u,
            factor: v,
            sum,
        },
        Code::Ln | Code::Ln1p => Step::BySlope { to, u, slope: u, sum },
        Code::Asin | Code::Acos | Code::Atan | Code::Asinh | Code::Acosh | Code::Atanh => {
            Step::BySlope { to, u, slope: v, sum }
        }
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
