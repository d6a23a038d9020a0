//! Errors against the continuous motion.

use dsocs_core::RunError;
use dsocs_core::taylor::{AnyGlobalError, GlobalError};

/// The errors of a motion against the continuous one; see [`GlobalError`].
pub(crate) trait Errors {
    /// The error of each coordinate of a position at a time.
    fn at(&mut self, t: f64, q: &[f64]) -> Result<Vec<f64>, RunError>;

    /// The uncertainty of the continuous motion.
    fn uncertainty(&self) -> f64;
}

impl<const N: usize> Errors for GlobalError<'_, N> {
    fn at(&mut self, t: f64, q: &[f64]) -> Result<Vec<f64>, RunError> {
        let q = q.first_chunk().unwrap_or(&[f64::NAN; N]);
        Ok(Self::at(self, t, q)?.to_vec())
    }

    fn uncertainty(&self) -> f64 {
        Self::uncertainty(self)
    }
}

impl Errors for AnyGlobalError<'_> {
    fn at(&mut self, t: f64, q: &[f64]) -> Result<Vec<f64>, RunError> {
        let mut distances = q.to_vec();
        self.replace(t, &mut distances)?;
        Ok(distances)
    }

    fn uncertainty(&self) -> f64 {
        Self::uncertainty(self)
    }
}
