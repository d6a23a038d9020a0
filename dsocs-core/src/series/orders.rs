//! How high the orders of a series go, and how its coefficients stand.

/// The highest order of a series.
pub const MAX_ORDER: usize = 40;

/// Rows of a table: one for each order, and one that a position is ahead of its velocity.
pub(crate) const ROWS: usize = MAX_ORDER + 2;

/// How many inner sums stand side by side.
pub const LANES: usize = 4;

/// `1/k`, and infinity for 0.
pub const RECIPROCALS: [f64; ROWS] = {
    let mut table = [f64::INFINITY; ROWS];
    let mut k = 1;
    while k < ROWS {
        table[k] = 1.0 / k as f64;
        k += 1;
    }
    table
};

/// Coefficients of one order.
pub(crate) type Row<T> = [T; LANES];
