//! The pieces of a user's function, and the choices between them.

use std::cell::RefCell;

use super::{Jet, memory};
use crate::series::switch::Switch;

/// The switches of a function, in the order of evaluation.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces {
    switches: Vec<Switch>,
    /// For a choice between many pieces, the one that it began with and the one that was taken; stored with
    /// the first of its two switches.
    chosen: Vec<Option<[i64; 2]>>,
    /// The number of switches; further ones are left from earlier calls.
    noted: usize,
    /// The next switch.
    at: usize,
}

thread_local! {
    /// The switches of the function that is being called.
    static PIECES: RefCell<Pieces> = const {
        RefCell::new(Pieces {
            switches: Vec::new(),
            chosen: Vec::new(),
            noted: 0,
            at: 0,
        })
    };
}

impl Pieces {
    /// Calls a function that evaluates these switches.
    pub(super) fn during<T>(&mut self, function: impl FnOnce() -> T) -> T {
        self.at = 0;
        let outer = PIECES.replace(core::mem::take(self));
        let result = function();
        *self = PIECES.replace(outer);
        result
    }

    /// Sets the number of switches to those that the function has evaluated.
    pub(super) fn keep(&mut self) {
        self.noted = self.at;
    }

    /// Whether the function has no switches.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.noted == 0
    }

    /// The switches that the function has evaluated.
    pub(super) fn switches(&mut self) -> &mut [Switch] {
        let noted = self.noted.min(self.switches.len());
        &mut self.switches[..noted]
    }

    /// Enters the pieces that choices have changed to; returns whether there are any.
    pub(super) fn enter(&mut self) -> bool {
        let mut any = false;
        for (place, chosen) in self.chosen.iter_mut().enumerate().take(self.noted) {
            let Some([base, piece]) = chosen else {
                continue;
            };
            let (Some([lower, upper]), true) = (
                self.switches
                    .get_mut(place..place + 2)
                    .and_then(|pair| <&mut [Switch; 2]>::try_from(pair).ok()),
                base != piece,
            ) else {
                continue;
            };
            // the place where the pieces meet is the other end of the new piece
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

    /// Advances to the next switch, with a jet as its argument, and returns the sign that it has to have;
    /// `own` is that of its value.
    fn next(&mut self, argument: Jet, own: f64) -> f64 {
        let place = self.at;
        self.at += 1;
        let order = memory::order();
        if order > 0 {
            return self.switches.get_mut(place).map_or(own, |switch| {
                switch.push(order, argument.now);
                switch.side()
            });
        }
        if place == self.switches.len() {
            self.switches.push(Switch::default());
            self.chosen.push(None);
        }
        self.chosen[place] = None;
        self.switches[place].start(argument.value, own)
    }

    /// Whether the sign of the next switch is set.
    fn is_held(&self) -> bool {
        self.switches.get(self.at).is_some_and(Switch::is_held)
    }
}

/// The sign by which a jet selects a piece: its own, or that of the piece that is continued.
pub(super) fn decide(argument: Jet, own: f64) -> f64 {
    if argument.moves {
        PIECES.with_borrow_mut(|pieces| pieces.next(argument, own))
    } else {
        own
    }
}

/// Records the argument of a smooth function that is steep near zero, without a sign to be kept.
pub(super) fn steep(argument: Jet) {
    decide(argument, 0.0);
}

/// Whether the sign of the next switch is set.
pub(super) fn is_held() -> bool {
    PIECES.with_borrow(Pieces::is_held)
}

/// The piece that a choice between many takes for `x`: `own` is the piece of its value, and `ends` gives the
/// ends of a piece.
pub(super) fn choose(x: Jet, own: i64, ends: impl Fn(i64) -> [Option<f64>; 2]) -> i64 {
    if !x.moves {
        return own;
    }
    let (place, base) = PIECES.with_borrow(|pieces| {
        let place = pieces.at;
        let known = pieces.chosen.get(place).copied().flatten();
        // higher orders keep the piece of order 0
        let goes_on = memory::order() > 0 || pieces.is_held();
        (place, known.filter(|_| goes_on).map_or(own, |[base, _]| base))
    });
    // the arithmetic of jets evaluates no switches
    let [from, to] = ends(base).map(|end| end.map(|end| x - Jet::from(end)));
    PIECES.with_borrow_mut(|pieces| {
        let mut side = |argument: Option<Jet>, own: f64| pieces.next(argument.unwrap_or(Jet::from(own)), own);
        let (lower, upper) = (side(from, 1.0), side(to, -1.0));
        let piece = base + i64::from(upper > 0.0) - i64::from(lower < 0.0);
        pieces.chosen[place] = Some([base, piece]);
        piece
    })
}
