//! What a function did with its arguments, and its Taylor coefficients.

use std::cell::RefCell;

use super::Jet;
use crate::taylor::kernel::{RECIPROCALS, ROWS};

/// An operation on former entries of the tape; primes are derivatives by time.
#[derive(Clone, Copy, Debug)]
pub(super) enum Op {
    /// An argument of the function.
    Input(usize),
    /// Something that is not known beyond order 0.
    Unseen,
    /// `scale · u`, from order 1 on.
    Affine {
        u: u32,
        scale: f64,
    },
    Add(u32, u32),
    Sub(u32, u32),
    Mul(u32, u32),
    Square(u32),
    /// `w = u / v` from `w v = u`.
    Div(u32, u32),
    /// `w = c / v` from `w v = c`.
    Recip(u32),
    /// `w = √u` from `w² = u`.
    Sqrt(u32),
    /// `w = u^α` from `u w' = α w u'`.
    Power(u32, f64),
    /// `w' = (w + shift) u'`.
    Exp(u32, f64),
    /// `(u + shift) w' = u'`.
    Ln(u32, f64),
    /// `w' = scale p u'`, where the partner `p` stands at the distance given.
    Partner {
        u: u32,
        distance: i32,
        scale: f64,
    },
    /// `g w' = scale u'`.
    Inverse {
        u: u32,
        slope: u32,
        scale: f64,
    },
    /// `w = atan2(y, x)` from `r w' = x y' - y x'`, `r = x² + y²`.
    Atan2 {
        y: u32,
        x: u32,
        radius: u32,
    },
}

/// An entry: an operation and its coefficients.
#[derive(Clone, Debug)]
struct Entry {
    op: Op,
    coefficients: [f64; ROWS],
}

/// Entries, of which those from `length` on are left from before and will be written over.
#[derive(Clone, Debug, Default)]
struct Recording {
    entries: Vec<Entry>,
    length: usize,
}

/// A function of the user's, recorded at a point.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    recording: Recording,
    result: Option<u32>,
}

thread_local! {
    /// What jets write on.
    static RECORDING: RefCell<Recording> = const {
        RefCell::new(Recording {
            entries: Vec::new(),
            length: 0,
        })
    };
}

/// Writes an operation down; `None` if the tape is at its end, which 2³² operations would take.
pub(super) fn push(op: Op, value: f64) -> Option<u32> {
    RECORDING.with_borrow_mut(|recording| {
        let place = u32::try_from(recording.length).ok()?;
        match recording.entries.get_mut(recording.length) {
            Some(entry) => (entry.op, entry.coefficients[0]) = (op, value),
            None => {
                let mut coefficients = [0.0; ROWS];
                coefficients[0] = value;
                recording.entries.push(Entry { op, coefficients });
            }
        }
        recording.length += 1;
        Some(place)
    })
}

impl Tape {
    /// Calls a function with jets of the given values, writes down what it does, and returns its value. An argument
    /// that does not move enters as a number.
    pub fn record<const A: usize>(
        &mut self,
        values: [f64; A],
        moves: [bool; A],
        function: impl FnOnce([Jet; A]) -> Jet,
    ) -> f64 {
        self.written(|| {
            function(core::array::from_fn(|i| {
                if moves[i] {
                    Jet::input(i, values[i])
                } else {
                    Jet::from(values[i])
                }
            }))
        })
    }

    /// Writes down what a function does that makes its jets by [`Jet::input`].
    pub(in crate::taylor) fn written(&mut self, function: impl FnOnce() -> Jet) -> f64 {
        self.recording.length = 0;
        let outer = RECORDING.replace(core::mem::take(&mut self.recording));
        let result = function();
        self.recording = RECORDING.replace(outer);
        self.result = result.node;
        result.value
    }

    /// The function's coefficient of order `k`, `k ≥ 1`, from those of its arguments; lower orders come first.
    pub fn coefficient<const A: usize>(&mut self, k: usize, inputs: [f64; A]) -> f64 {
        self.next(k, &|i| inputs.get(i).copied().unwrap_or(f64::NAN))
    }

    /// As [`Tape::coefficient`], for arguments that are asked for by their place.
    pub(in crate::taylor) fn next(&mut self, k: usize, inputs: &dyn Fn(usize) -> f64) -> f64 {
        let Some(result) = self.result else {
            return 0.0;
        };
        let k = k.clamp(1, ROWS - 1);
        let Recording { entries, length } = &mut self.recording;
        for place in 0..*length {
            let (before, rest) = entries.split_at_mut(place);
            if let Some((entry, after)) = rest.split_first_mut() {
                entry.coefficients[k] = entry.next(k, inputs, place, before, after);
            }
        }
        entries
            .get(result as usize)
            .map_or(f64::NAN, |entry| entry.coefficients[k])
    }
}

impl Entry {
    /// The coefficient of order `k`.
    fn next(
        &self,
        k: usize,
        inputs: &dyn Fn(usize) -> f64,
        place: usize,
        before: &[Self],
        after: &[Self],
    ) -> f64 {
        let of = |u: u32| -> &[f64; ROWS] {
            const NONE: &[f64; ROWS] = &[f64::NAN; ROWS];
            before.get(u as usize).map_or(NONE, |entry| &entry.coefficients)
        };
        let own = &self.coefficients;
        let inverse_k = RECIPROCALS[k];
        match self.op {
            Op::Input(i) => inputs(i),
            Op::Unseen => f64::NAN,
            Op::Affine { u, scale } => scale * of(u)[k],
            Op::Add(u, v) => of(u)[k] + of(v)[k],
            Op::Sub(u, v) => of(u)[k] - of(v)[k],
            Op::Mul(u, v) => {
                let (u, v) = (of(u), of(v));
                inner(u, v, k) + u[0] * v[k] + u[k] * v[0]
            }
            Op::Square(u) => {
                let u = of(u);
                inner(u, u, k) + 2.0 * u[0] * u[k]
            }
            Op::Div(u, v) => {
                let (u, v) = (of(u), of(v));
                (u[k] - inner(own, v, k) - own[0] * v[k]) / v[0]
            }
            Op::Recip(v) => {
                let v = of(v);
                (-inner(own, v, k) - own[0] * v[k]) / v[0]
            }
            Op::Sqrt(u) => (of(u)[k] - inner(own, own, k)) / (2.0 * own[0]),
            Op::Power(u, exponent) => {
                let u = of(u);
                let (outer, inner) = (rated(u, own, k), rated(own, u, k));
                ((exponent * outer - inner) * inverse_k + exponent * own[0] * u[k]) / u[0]
            }
            Op::Exp(u, shift) => {
                let u = of(u);
                rated(u, own, k) * inverse_k + u[k] * (own[0] + shift)
            }
            Op::Ln(u, shift) => {
                let u = of(u);
                (u[k] - rated(own, u, k) * inverse_k) / (u[0] + shift)
            }
            Op::Partner { u, distance, scale } => {
                let partner = match usize::try_from(distance) {
                    Ok(ahead) => after.get(ahead.wrapping_sub(1)),
                    Err(_) => before.get(place.wrapping_sub(distance.unsigned_abs() as usize)),
                };
                let (u, partner) = (of(u), partner.map_or(own, |entry| &entry.coefficients));
                scale * (rated(u, partner, k) * inverse_k + u[k] * partner[0])
            }
            Op::Inverse { u, slope, scale } => {
                let slope = of(slope);
                (scale * of(u)[k] - rated(own, slope, k) * inverse_k) / slope[0]
            }
            Op::Atan2 { y, x, radius } => {
                let (y, x, radius) = (of(y), of(x), of(radius));
                let turn = rated(y, x, k) - rated(x, y, k) - rated(own, radius, k);
                (turn * inverse_k + (y[k] * x[0] - x[k] * y[0])) / radius[0]
            }
        }
    }
}

/// `Σ x_j y_{k-j}` over `0 < j < k`. Four sums run beside one another: one alone would wait for itself.
fn inner(x: &[f64; ROWS], y: &[f64; ROWS], k: usize) -> f64 {
    sum(&x[1..k], &y[1..k], |_, x, y| x * y)
}

/// `Σ j x_j y_{k-j}` over `0 < j < k`.
fn rated(x: &[f64; ROWS], y: &[f64; ROWS], k: usize) -> f64 {
    sum(&x[1..k], &y[1..k], |j, x, y| (j + 1) as f64 * (x * y))
}

fn sum(x: &[f64], y: &[f64], term: impl Fn(usize, f64, f64) -> f64) -> f64 {
    let mut sums = [0.0; 4];
    for (j, (&x, &y)) in x.iter().zip(y.iter().rev()).enumerate() {
        sums[j % 4] += term(j, x, y);
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}
