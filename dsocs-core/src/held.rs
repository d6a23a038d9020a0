//! A system that a run has borrowed, or of which it has a copy with other values of the parameters.

use core::ops::Deref;
use std::sync::Arc;

/// A system as a run holds it.
pub(crate) struct Held<'s, S> {
    /// The caller's.
    borrowed: &'s S,
    /// A copy, once a parameter was changed.
    own: Option<Arc<S>>,
}

impl<'s, S> Held<'s, S> {
    /// The caller's system.
    pub fn new(borrowed: &'s S) -> Self {
        Self { borrowed, own: None }
    }

    /// A copy with values of its own.
    pub fn owning(borrowed: &'s S, own: S) -> Self {
        Self {
            borrowed,
            own: Some(Arc::new(own)),
        }
    }

    /// The copy, to be changed.
    pub fn own(&mut self) -> &mut S
    where
        S: Clone,
    {
        let borrowed = self.borrowed;
        Arc::make_mut(self.own.get_or_insert_with(|| Arc::new(borrowed.clone())))
    }
}

impl<S> Deref for Held<'_, S> {
    type Target = S;

    #[inline]
    fn deref(&self) -> &S {
        match &self.own {
            Some(own) => own,
            None => self.borrowed,
        }
    }
}

// by hand, because a derivation would ask the system for as much
impl<S> Clone for Held<'_, S> {
    fn clone(&self) -> Self {
        Self {
            borrowed: self.borrowed,
            own: self.own.clone(),
        }
    }
}
