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
    /// The sequences of the time, and of the accelerations and multipliers that are solved for.
    pub(super) time: Place,
    pub(super) unknown: Vec<Place>,
    /// The operations of order 0: first those that do not depend on accelerations that are solved for, then those that do.
    pub(super) start: [Vec<Place>; 2],
    pub(super) known: Vec<Step>,
    pub(super) accelerated: Vec<Step>,
    pub(super) again: Vec<Step>,
}

impl Lists {
    /// The lists of some recurrences; `None` if there are more than possible places.
    ///
    /// Each list is in the order of depths: neighbours then seldom need each other's results, and the processor computes several at a
    /// time. Of one depth, equal operations come one after the other.
    pub(super) fn new(series: &Series) -> Option<Self> {
        // after the others come a sequence that is zero, one that nothing reads, and a factor 1/3
        let third = narrow(u32::try_from(series.factors()).ok()?)?;
        let unread = narrow(u32::try_from(series.operations.len() + 1).ok()?)?;
        let products = series.products.len().next_multiple_of(2 * LANES);
        if products + series.squares.len().next_multiple_of(2 * LANES) > ROOM {
            return None;
        }
        let mut lists = Self {
            terms: Vec::new(),
            coordinates: Vec::new(),
            time: unread,
            unknown: vec![unread; series.unknown.len()],
            start: [Vec::new(), Vec::new()],
            known: Vec::new(),
            accelerated: Vec::new(),
            again: Vec::new(),
        };
        let [mut known, mut accelerated, mut again] = [Vec::new(), Vec::new(), Vec::new()];
        let depths = depths(series);
        for &term in &series.terms {
            lists.terms.push(all(term)?);
        }
        for &acceleration in &series.accelerations {
            lists.coordinates.push([unread, unread, narrow(acceleration)?]);
        }
        for (to, op) in (0..).zip(&series.operations) {
            let to = narrow(to)?;
            // a cosine is computed with its sine
            if op.code != Code::Cos {
                lists.start[usize::from(op.lists & ACCELERATED > 0)].push(to);
            }
            if op.lists & LASTING == 0 {
                continue;
            }
            match op.code {
                Code::Position => lists.coordinates.get_mut(op.index as usize)?[0] = to,
                Code::Velocity => lists.coordinates.get_mut(op.index as usize)?[1] = to,
                Code::Time => lists.time = to,
                Code::Acceleration | Code::Multiplier => {
                    let own = (op.code == Code::Multiplier, op.index);
                    for (place, unknown) in lists.unknown.iter_mut().zip(&series.unknown) {
                        if *unknown == own {
                            *place = to;
                        }
                    }
                }
                // their higher coefficients are zero
                Code::Constant | Code::Signum | Code::Cos => {}
                _ => {
                    let key = (depths[usize::from(to)], op.code as u8);
                    let step = (key, step(series, to, op, third)?);
                    let is_known = op.lists & ACCELERATED == 0;
                    push(if is_known { &mut known } else { &mut accelerated }, step);
                    if !is_known && op.lists & AGAIN > 0 {
                        push(&mut again, step);
                    }
                }
            }
        }
        lists.known = in_order(known);
        lists.accelerated = in_order(accelerated);
        lists.again = in_order(again);
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

/// For each sequence, the length of the longest chain of operations that leads to its coefficient of an order.
fn depths(series: &Series) -> Vec<u32> {
    let mut depths: Vec<u32> = Vec::with_capacity(series.operations.len());
    for op in &series.operations {
        let [first, count] = op.terms.map(|index| index as usize);
        let terms = series.terms.iter().skip(first).take(count).map(|term| term[1]);
        // sequences behind it are read at lower orders alone
        let parts = op.parts.into_iter().chain(terms);
        let depth = parts.filter_map(|part| depths.get(part as usize)).max();
        depths.push(depth.map_or(0, |depth| depth + 1));
    }
    depths
}

/// The depth of a step, and its operation.
type Key = (u32, u8);

/// Steps in the order of their keys.
fn in_order(mut steps: Vec<(Key, Step)>) -> Vec<Step> {
    steps.sort_by_key(|&(key, _)| key);
    steps.into_iter().map(|(_, step)| step).collect()
}

/// Adds a step with its key, and joins the last steps to one if there is an operation for all of them.
fn push(steps: &mut Vec<(Key, Step)>, step: (Key, Step)) {
    steps.push(step);
    if let [
        ..,
        (key, Step::Rate { to, u, factor, sum }),
        (
            _,
            Step::Square {
                to: square,
                u: value,
                sum: of_square,
            },
        ),
        (
            _,
            Step::Minus {
                to: slope,
                u: negative,
            },
        ),
    ] = **steps
        && (factor, value, negative) == (slope, to, square)
        && (usize::from(square), usize::from(slope)) == (usize::from(to) + 1, usize::from(to) + 2)
    {
        let before = steps.len() - 3;
        steps.truncate(before);
        let step = Step::Tangent {
            to,
            u,
            slope,
            sums: [sum, of_square],
        };
        steps.push((key, step));
    }
}

/// The step of an operation.
fn step(series: &Series, to: Place, op: &Operation, third: Place) -> Option<Step> {
    let [u, v, w, z] = all(op.parts)?;
    let sums = all(op.sums)?;
    let sum = sums[0];
    Some(match op.code {
        // these are known before, or need no operation
        Code::Time
        | Code::Position
        | Code::Velocity
        | Code::Acceleration
        | Code::Multiplier
        | Code::Constant
        | Code::Signum
        | Code::Cos => return None,
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
        Code::Ln
        | Code::Ln1p
        | Code::Asin
        | Code::Acos
        | Code::Atan
        | Code::Asinh
        | Code::Acosh
        | Code::Atanh => Step::BySlope { to, u, sum },
        Code::Conjugate => Step::Minus { to, u: v },
        Code::Atan2 => Step::Angle { to, y: u, x: v, sums },
        Code::Abs => Step::Abs { to, u },
        Code::Less | Code::LessOrEqual => Step::Select {
            to,
            then: w,
            otherwise: z,
        },
        Code::Call => Step::Call { to },
    })
}
