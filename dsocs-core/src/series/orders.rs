//! The highest order of a series, and the layout of its coefficients.

/// The highest order of a series.
pub const MAX_ORDER: usize = 40;

/// Number of rows of a table: one for each order, and one more, because a position is one order ahead of its
/// velocity.
pub(crate) const ROWS: usize = MAX_ORDER + 2;

/// Number of inner sums in one row.
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
