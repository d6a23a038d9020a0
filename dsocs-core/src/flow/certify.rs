//! Runs that watch the regularity of their equations.

use core::ops::ControlFlow;

use super::Flow;
use crate::error::RunError;
use crate::regularity::Regularity;
use crate::system::System;
use crate::trajectory::Node;

impl<S: System<N>, const N: usize> Flow<'_, S, N> {
    /// The regularity of the equations at the last step that was solved: at the triple whose middle node [`Flow::node`]
    /// gives. `None` before the first step.
    #[must_use]
    pub fn regularity(&self) -> Option<Regularity> {
        let solved = self.solved?;
        Some(Regularity::of(self.system, self.h, &solved.leg, &solved.e))
    }

    /// Runs like [`Flow::stream`] and hands each node on with the regularity of its step; the node of the start has none.
    ///
    /// # Errors
    ///
    /// As [`Flow::stream`].
    pub fn certify(
        &mut self,
        t: f64,
        mut observer: impl FnMut(&Node<N>, Option<Regularity>) -> ControlFlow<()>,
    ) -> Result<(), RunError> {
        let last = self.last_index(t)?;
        while self.upcoming() <= last {
            let node = self.step()?;
            if observer(&node, self.regularity()).is_break() {
                break;
            }
        }
        Ok(())
    }
}
