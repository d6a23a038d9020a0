//! The equations of rest at some unknowns.

use super::rest::SMALL;
use crate::linear::slopes::Slopes;
use crate::solve::dense::Matrix;

/// A row below this part of its terms is zero.
const ROUNDED: f64 = 16.0 * f64::EPSILON;

/// The equations at some unknowns, each divided by the length of its derivatives.
pub(super) struct Rows {
    pub(super) slopes: Slopes,
    /// The derivatives by the unknowns; columns of multipliers are divided by their lengths.
    pub(super) matrix: Matrix,
    /// The lengths of the columns of multipliers; 1 for the other columns.
    pub(super) columns: Vec<f64>,
    /// The lengths of the rows; 1 for rows with zero derivatives.
    pub(super) lengths: Vec<f64>,
    pub(super) values: Vec<f64>,
    /// The sizes of the terms of the rows, divided by the same lengths.
    pub(super) terms: Vec<f64>,
}

impl Rows {
    /// Whether all rows are so small that a small change of the unknowns makes them zero. Rows with zero derivatives have to vanish to
    /// rounding.
    pub(super) fn are_small(&self, unknowns: f64) -> bool {
        let mut each = self.values.iter().zip(&self.terms).enumerate();
        each.all(|(i, (value, terms))| {
            let moves = self.matrix.row(i).any(|slope| slope != 0.0);
            let bar = if moves {
                SMALL * unknowns.max(1.0)
            } else {
                ROUNDED * terms
            };
            value.abs() <= bar
        })
    }

    /// Whether all rows are zero to rounding.
    pub(super) fn are_zero(&self) -> bool {
        let mut each = self.values.iter().zip(&self.terms);
        each.all(|(value, terms)| value.abs() <= ROUNDED * terms)
    }
}
