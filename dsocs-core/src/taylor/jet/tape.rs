//! What a function did with its arguments, and its Taylor coefficients.

use std::cell::RefCell;

use super::Jet;
use super::plan::{Next, Plan};
use crate::dispatch;
use crate::taylor::kernel::ROWS;
use crate::taylor::switch::Switch;

/// An operation on former entries of the tape; primes are derivatives by time.
#[derive(Clone, Copy, Debug, PartialEq)]
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
pub(super) fn partner(place: usize, distance: i32) -> Option<usize> {
    place.checked_add_signed(isize::try_from(distance).ok()?)
}

/// An entry: an operation, and its value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) op: Op,
    /// Whether the result is made of it.
    pub(super) live: bool,
    /// The coefficient of order 0.
    pub(super) value: f64,
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
    plan: Plan,
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
        let entry = Entry {
            op,
            live: false,
            value,
        };
        match recording.entries.get_mut(recording.length) {
            Some(old) => *old = entry,
            None => recording.entries.push(entry),
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
        let Recording {
            entries,
            length,
            arguments,
            noted,
            ..
        } = &mut self.recording;
        let entries = &mut entries[..*length];
        let arguments = arguments[..*noted].iter().filter_map(|argument| argument.node);
        let roots = self.result.into_iter().chain(arguments);
        // a function does the same at every point, unless it branches
        if !self.plan.is_of(entries, roots.clone()) {
            mark(entries, roots.clone());
            self.plan.make(entries, roots);
        }
        self.plan.begin(entries);
        result.value
    }

    /// The function's coefficient of order `k`, `k ≥ 1`, from those of its arguments; lower orders come first.
    /// Products are rounded before they are summed if `rounded`.
    #[inline]
    pub fn coefficient<const A: usize>(&mut self, k: usize, rounded: bool, inputs: [f64; A]) -> f64 {
        if self.is_still() {
            return 0.0;
        }
        self.next(k, rounded, &inputs)
    }

    /// Whether the function's value does not move, and nothing was compared.
    #[inline]
    pub(crate) fn is_still(&self) -> bool {
        self.result.is_none() && self.recording.noted == 0
    }

    /// As [`Tape::coefficient`], for any number of arguments.
    pub(crate) fn next(&mut self, k: usize, rounded: bool, inputs: &[f64]) -> f64 {
        if self.is_still() {
            return 0.0;
        }
        let Recording {
            switches,
            arguments,
            noted,
            ..
        } = &mut self.recording;
        let k = k.clamp(1, ROWS - 1);
        let plan = &mut self.plan;
        let next = Next {
            plan: &mut *plan,
            k,
            inputs,
        };
        dispatch::run_as(rounded, next);
        for (switch, argument) in switches.iter_mut().zip(arguments).take(*noted) {
            switch.push(k, argument.node.map_or(0.0, |node| plan.coefficient(node)));
        }
        self.result.map_or(0.0, |node| plan.coefficient(node))
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

/// Marks what the result and the switches are made of.
fn mark(entries: &mut [Entry], roots: impl Iterator<Item = u32>) {
    let mut none = true;
    for root in roots {
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
        for place in (0..entries.len()).rev() {
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
