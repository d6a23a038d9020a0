//! What a function did with its arguments, and its Taylor coefficients.

use std::cell::RefCell;

use super::Jet;
use crate::dispatch::{self, Work};
use crate::taylor::kernel::{RECIPROCALS, ROWS, add_product};
use crate::taylor::switch::Switch;

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

impl Op {
    /// The entries that an entry at `place` is made of; a partner in the recurrence is one, too.
    fn parts(self, place: usize) -> [Option<usize>; 3] {
        let at = |u: u32| Some(u as usize);
        match self {
            Self::Input(_) | Self::Unseen => [None; 3],
            Self::Affine { u, .. }
            | Self::Square(u)
            | Self::Recip(u)
            | Self::Sqrt(u)
            | Self::Power(u, _)
            | Self::Exp(u, _)
            | Self::Ln(u, _) => [at(u), None, None],
            Self::Add(u, v) | Self::Sub(u, v) | Self::Mul(u, v) | Self::Div(u, v) => [at(u), at(v), None],
            Self::Partner { u, distance, .. } => [at(u), partner(place, distance), None],
            Self::Inverse { u, slope, .. } => [at(u), at(slope), None],
            Self::Atan2 { y, x, radius } => [at(y), at(x), at(radius)],
        }
    }
}

/// The place of a partner.
fn partner(place: usize, distance: i32) -> Option<usize> {
    place.checked_add_signed(isize::try_from(distance).ok()?)
}

/// An entry: an operation and its coefficients `c_j`, also as `j c_j` and backwards, so that a convolution reads both of its
/// sequences forwards.
#[derive(Clone, Debug)]
struct Entry {
    op: Op,
    /// Whether the result is made of it.
    live: bool,
    plain: [f64; ROWS],
    rate: [f64; ROWS],
    reversed: [f64; ROWS],
}

impl Entry {
    fn new(op: Op, value: f64) -> Self {
        let mut entry = Self {
            op,
            live: false,
            plain: [0.0; ROWS],
            rate: [0.0; ROWS],
            reversed: [0.0; ROWS],
        };
        entry.begin(op, value);
        entry
    }

    fn begin(&mut self, op: Op, value: f64) {
        (self.op, self.live, self.plain[0]) = (op, false, value);
    }

    #[inline(always)]
    fn set(&mut self, k: usize, value: f64) {
        self.plain[k] = value;
        self.rate[k] = k as f64 * value;
        self.reversed[ROWS - 1 - k] = value;
    }
}

/// What a switch of a function is made of.
#[derive(Clone, Copy, Debug, Default)]
struct Argument {
    /// Its entry; a number that does not move has none.
    node: Option<u32>,
    /// The piece that a choice between many began with, and the one that was taken. It stands beside the first of two switches.
    pieces: Option<[i64; 2]>,
}

/// Entries, of which those from `length` on are left from before and will be written over, and in the same way switches.
#[derive(Clone, Debug, Default)]
struct Recording {
    entries: Vec<Entry>,
    length: usize,
    switches: Vec<Switch>,
    arguments: Vec<Argument>,
    noted: usize,
}

impl Recording {
    /// Writes a switch down, and returns the sign that it is to have.
    fn note(&mut self, node: Option<u32>, value: f64, own: f64, pieces: Option<[i64; 2]>) -> f64 {
        if self.noted == self.switches.len() {
            self.switches.push(Switch::default());
            self.arguments.push(Argument::default());
        }
        let place = self.noted;
        self.noted += 1;
        self.arguments[place] = Argument { node, pieces };
        self.switches[place].start(value, own)
    }
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
            switches: Vec::new(),
            arguments: Vec::new(),
            noted: 0,
        })
    };
}

/// Writes down that the sign of an entry decides; `own` is its sign. Returns the sign that decides.
pub(super) fn note(node: u32, value: f64, own: f64) -> f64 {
    RECORDING.with_borrow_mut(|recording| recording.note(Some(node), value, own, None))
}

/// Whether the next switch has to have a given sign.
pub(super) fn is_held() -> bool {
    RECORDING.with_borrow(|recording| {
        recording
            .switches
            .get(recording.noted)
            .is_some_and(Switch::is_held)
    })
}

/// Writes down that a choice between many pieces depends on `x`: `own` is the piece that its value belongs to, and `ends` are the ends of
/// a piece. Returns the piece that is taken.
pub(super) fn choose(x: Jet, own: i64, ends: impl Fn(i64) -> [Option<f64>; 2]) -> i64 {
    if x.node.is_none() {
        return own;
    }
    let base = RECORDING.with_borrow(|recording| {
        let place = recording.noted;
        let known = recording
            .arguments
            .get(place)
            .and_then(|argument| argument.pieces);
        let held = recording.switches.get(place).is_some_and(Switch::is_held);
        known.filter(|_| held).map_or(own, |[base, _]| base)
    });
    let sides = ends(base).map(|end| end.map(|end| x - Jet::from(end)));
    RECORDING.with_borrow_mut(|recording| {
        let place = recording.noted;
        let mut side = |argument: Option<Jet>, own: f64| match argument {
            Some(Jet { value, node }) => recording.note(node, value, own, None),
            None => recording.note(None, own, own, None),
        };
        let [from, to] = sides;
        let (lower, upper) = (side(from, 1.0), side(to, -1.0));
        let piece = base + i64::from(upper > 0.0) - i64::from(lower < 0.0);
        recording.arguments[place].pieces = Some([base, piece]);
        piece
    })
}

/// Writes an operation down; `None` if the tape is at its end, which 2³² operations would take.
pub(super) fn push(op: Op, value: f64) -> Option<u32> {
    RECORDING.with_borrow_mut(|recording| {
        let place = u32::try_from(recording.length).ok()?;
        match recording.entries.get_mut(recording.length) {
            Some(entry) => entry.begin(op, value),
            None => recording.entries.push(Entry::new(op, value)),
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
    pub(crate) fn written(&mut self, function: impl FnOnce() -> Jet) -> f64 {
        (self.recording.length, self.recording.noted) = (0, 0);
        let outer = RECORDING.replace(core::mem::take(&mut self.recording));
        let result = function();
        self.recording = RECORDING.replace(outer);
        self.result = result.node;
        self.mark();
        result.value
    }

    /// Marks what the result and the switches are made of.
    fn mark(&mut self) {
        let Recording {
            entries,
            length,
            arguments,
            noted,
            ..
        } = &mut self.recording;
        let arguments = arguments[..*noted].iter().filter_map(|argument| argument.node);
        let mut none = true;
        for root in self.result.into_iter().chain(arguments) {
            none = false;
            if let Some(entry) = entries.get_mut(root as usize) {
                entry.live = true;
            }
        }
        if none {
            return;
        }
        // a partner may come later: until nothing is added any more
        let mut added = true;
        while added {
            added = false;
            for place in (0..*length).rev() {
                if !entries[place].live {
                    continue;
                }
                for part in entries[place].op.parts(place).into_iter().flatten() {
                    if let Some(entry) = entries.get_mut(part) {
                        added |= !entry.live && part > place;
                        entry.live = true;
                    }
                }
            }
        }
    }

    /// The function's coefficient of order `k`, `k ≥ 1`, from those of its arguments; lower orders come first.
    /// Products are rounded before they are summed if `rounded`.
    #[inline]
    pub fn coefficient<const A: usize>(&mut self, k: usize, rounded: bool, inputs: [f64; A]) -> f64 {
        if self.is_still() {
            return 0.0;
        }
        self.next(k, rounded, &|i| inputs.get(i).copied().unwrap_or(f64::NAN))
    }

    /// Whether the function's value does not move, and nothing was compared.
    #[inline]
    pub(crate) fn is_still(&self) -> bool {
        self.result.is_none() && self.recording.noted == 0
    }

    /// As [`Tape::coefficient`], for arguments that are asked for by their place.
    pub(crate) fn next(&mut self, k: usize, rounded: bool, inputs: &dyn Fn(usize) -> f64) -> f64 {
        if self.is_still() {
            return 0.0;
        }
        let Recording {
            entries,
            length,
            switches,
            arguments,
            noted,
        } = &mut self.recording;
        let k = k.clamp(1, ROWS - 1);
        let live = *length;
        let next = Next {
            entries: &mut entries[..live],
            k,
            inputs,
        };
        dispatch::run_as(rounded, next);
        let coefficient = |entry: u32| {
            entries
                .get(entry as usize)
                .map_or(f64::NAN, |entry| entry.plain[k])
        };
        for (switch, argument) in switches.iter_mut().zip(arguments).take(*noted) {
            switch.push(k, argument.node.map_or(0.0, coefficient));
        }
        self.result.map_or(0.0, coefficient)
    }

    /// The switches that the function has met.
    pub(crate) fn switches(&mut self) -> &mut [Switch] {
        let noted = self.recording.noted;
        &mut self.recording.switches[..noted]
    }

    /// Begins the pieces that choices have gone over to. Returns whether there are any.
    pub(crate) fn enter(&mut self) -> bool {
        let Recording {
            switches,
            arguments,
            noted,
            ..
        } = &mut self.recording;
        let mut any = false;
        for (place, argument) in arguments.iter_mut().enumerate().take(*noted) {
            let Some([base, piece]) = &mut argument.pieces else {
                continue;
            };
            let (Some([lower, upper]), true) = (
                switches
                    .get_mut(place..place + 2)
                    .and_then(|pair| <&mut [Switch; 2]>::try_from(pair).ok()),
                base != piece,
            ) else {
                continue;
            };
            // the place where the pieces meet is the other end of the next one
            if piece > base {
                lower.begins_as(upper);
            } else {
                upper.begins_as(lower);
            }
            lower.set(1.0);
            upper.set(-1.0);
            *base = *piece;
            any = true;
        }
        any
    }
}

/// One order of all entries.
struct Next<'t, 'i> {
    entries: &'t mut [Entry],
    k: usize,
    inputs: &'i dyn Fn(usize) -> f64,
}

impl Work for Next<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        for place in 0..self.entries.len() {
            if self.entries[place].live {
                let value = next::<FUSED>(self.entries, place, self.k, self.inputs);
                self.entries[place].set(self.k, value);
            }
        }
    }
}

/// The coefficient of order `k` of an entry.
#[inline(always)]
fn next<const FUSED: bool>(entries: &[Entry], place: usize, k: usize, inputs: &dyn Fn(usize) -> f64) -> f64 {
    let own = &entries[place];
    // every part was written down before, or is a partner
    let of = |u: u32| entries.get(u as usize).unwrap_or(own);
    let inverse_k = RECIPROCALS[k];
    let w0 = own.plain[0];
    match own.op {
        Op::Input(i) => inputs(i),
        Op::Unseen => f64::NAN,
        Op::Affine { u, scale } => scale * of(u).plain[k],
        Op::Add(u, v) => of(u).plain[k] + of(v).plain[k],
        Op::Sub(u, v) => of(u).plain[k] - of(v).plain[k],
        Op::Mul(u, v) => {
            let (u, v) = (of(u), of(v));
            inner::<FUSED>(u, v, k) + u.plain[0] * v.plain[k] + u.plain[k] * v.plain[0]
        }
        Op::Square(u) => {
            let u = of(u);
            inner::<FUSED>(u, u, k) + 2.0 * u.plain[0] * u.plain[k]
        }
        Op::Div(u, v) => {
            let (u, v) = (of(u), of(v));
            (u.plain[k] - inner::<FUSED>(own, v, k) - w0 * v.plain[k]) / v.plain[0]
        }
        Op::Recip(v) => {
            let v = of(v);
            (-inner::<FUSED>(own, v, k) - w0 * v.plain[k]) / v.plain[0]
        }
        Op::Sqrt(u) => (of(u).plain[k] - inner::<FUSED>(own, own, k)) / (2.0 * w0),
        Op::Power(u, exponent) => {
            let u = of(u);
            let (outer, inner) = (rated::<FUSED>(u, own, k), rated::<FUSED>(own, u, k));
            ((exponent * outer - inner) * inverse_k + exponent * w0 * u.plain[k]) / u.plain[0]
        }
        Op::Exp(u, shift) => {
            let u = of(u);
            rated::<FUSED>(u, own, k) * inverse_k + u.plain[k] * (w0 + shift)
        }
        Op::Ln(u, shift) => {
            let u = of(u);
            (u.plain[k] - rated::<FUSED>(own, u, k) * inverse_k) / (u.plain[0] + shift)
        }
        Op::Partner { u, distance, scale } => {
            let partner = partner(place, distance).and_then(|place| entries.get(place));
            let (u, partner) = (of(u), partner.unwrap_or(own));
            scale * (rated::<FUSED>(u, partner, k) * inverse_k + u.plain[k] * partner.plain[0])
        }
        Op::Inverse { u, slope, scale } => {
            let slope = of(slope);
            (scale * of(u).plain[k] - rated::<FUSED>(own, slope, k) * inverse_k) / slope.plain[0]
        }
        Op::Atan2 { y, x, radius } => {
            let (y, x, radius) = (of(y), of(x), of(radius));
            let turn = rated::<FUSED>(y, x, k) - rated::<FUSED>(x, y, k) - rated::<FUSED>(own, radius, k);
            let ends = y.plain[k] * x.plain[0] - x.plain[k] * y.plain[0];
            (turn * inverse_k + ends) / radius.plain[0]
        }
    }
}

/// `Σ x_j y_{k-j}` over `0 < j < k`.
#[inline(always)]
fn inner<const FUSED: bool>(x: &Entry, y: &Entry, k: usize) -> f64 {
    dot::<FUSED>(&x.plain[1..k], &y.reversed[ROWS - k..ROWS - 1])
}

/// `Σ j x_j y_{k-j}` over `0 < j < k`.
#[inline(always)]
fn rated<const FUSED: bool>(x: &Entry, y: &Entry, k: usize) -> f64 {
    dot::<FUSED>(&x.rate[1..k], &y.reversed[ROWS - k..ROWS - 1])
}

/// `Σ x_i y_i`. Eight sums run beside one another: one alone would wait for itself.
#[inline(always)]
fn dot<const FUSED: bool>(x: &[f64], y: &[f64]) -> f64 {
    let ((x, x_rest), (y, y_rest)) = (x.as_chunks::<4>(), y.as_chunks::<4>());
    let mut sums = [[0.0; 4]; 2];
    let (mut pairs, mut others) = (x.chunks_exact(2), y.chunks_exact(2));
    for (x, y) in pairs.by_ref().zip(others.by_ref()) {
        for half in 0..2 {
            for lane in 0..4 {
                sums[half][lane] = add_product::<FUSED, f64>(sums[half][lane], x[half][lane], y[half][lane]);
            }
        }
    }
    for (x, y) in pairs.remainder().iter().zip(others.remainder()) {
        for lane in 0..4 {
            sums[0][lane] = add_product::<FUSED, f64>(sums[0][lane], x[lane], y[lane]);
        }
    }
    let mut rest = 0.0;
    for (&x, &y) in x_rest.iter().zip(y_rest) {
        rest = add_product::<FUSED, f64>(rest, x, y);
    }
    let [a, b] = sums;
    ((a[0] + b[0]) + (a[1] + b[1])) + ((a[2] + b[2]) + (a[3] + b[3])) + rest
}
