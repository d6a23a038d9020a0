//! What decides between the pieces of a function.

use std::cell::RefCell;

use super::{Jet, memory};
use crate::series::switch::Switch;

/// The switches of a function, in the order in which it meets them.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces {
    switches: Vec<Switch>,
    /// The piece that a choice between many began with, and the one that was taken. It stands beside the first of two switches.
    chosen: Vec<Option<[i64; 2]>>,
    /// How many switches there are; those beyond are left from before.
    noted: usize,
    /// The next one.
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
    /// Calls a function that meets these switches.
    pub(super) fn during<T>(&mut self, function: impl FnOnce() -> T) -> T {
        self.at = 0;
        let outer = PIECES.replace(core::mem::take(self));
        let result = function();
        *self = PIECES.replace(outer);
        result
    }

    /// Takes those that the function has met for all that it has.
    pub(super) fn keep(&mut self) {
        self.noted = self.at;
    }

    /// Whether the function has met none.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.noted == 0
    }

    /// The switches that the function has met.
    pub(super) fn switches(&mut self) -> &mut [Switch] {
        let noted = self.noted.min(self.switches.len());
        &mut self.switches[..noted]
    }

    /// Begins the pieces that choices have gone over to. Returns whether there are any.
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

    /// Goes on to the next switch, whose argument is a jet, and returns the sign that it is to have; `own` is that of its value.
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

    /// Whether the next switch has to have a given sign.
    fn is_held(&self) -> bool {
        self.switches.get(self.at).is_some_and(Switch::is_held)
    }
}

/// The sign that decides where that of a jet does: its own, or the one that is continued.
pub(super) fn decide(argument: Jet, own: f64) -> f64 {
    if argument.moves {
        PIECES.with_borrow_mut(|pieces| pieces.next(argument, own))
    } else {
        own
    }
}

/// Notes the argument of a smooth function that is steep near zero: no sign is to be kept.
pub(super) fn steep(argument: Jet) {
    decide(argument, 0.0);
}

/// Whether the next switch has to have a given sign.
pub(super) fn is_held() -> bool {
    PIECES.with_borrow(Pieces::is_held)
}

/// The piece that is taken where a choice between many depends on `x`: `own` is the piece that its value belongs to, and `ends` are the ends of
/// a piece.
pub(super) fn choose(x: Jet, own: i64, ends: impl Fn(i64) -> [Option<f64>; 2]) -> i64 {
    if !x.moves {
        return own;
    }
    let (place, base) = PIECES.with_borrow(|pieces| {
        let place = pieces.at;
        let known = pieces.chosen.get(place).copied().flatten();
        // in higher orders as in the first
        let goes_on = memory::order() > 0 || pieces.is_held();
        (place, known.filter(|_| goes_on).map_or(own, |[base, _]| base))
    });
    // arithmetic of jets meets no switches
    let [from, to] = ends(base).map(|end| end.map(|end| x - Jet::from(end)));
    PIECES.with_borrow_mut(|pieces| {
        let mut side = |argument: Option<Jet>, own: f64| pieces.next(argument.unwrap_or(Jet::from(own)), own);
        let (lower, upper) = (side(from, 1.0), side(to, -1.0));
        let piece = base + i64::from(upper > 0.0) - i64::from(lower < 0.0);
        pieces.chosen[place] = Some([base, piece]);
        piece
    })
}
