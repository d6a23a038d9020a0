//! Sums without a range or a closure, over a range that varies, and with names that are taken.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, theta: [8]);
    let a = sum(8, |i| theta[i]);
    let b = sum(0..count, |i| theta[i]);
    let c = sum(0..8, theta);
    let d = sum(0..8, |x| theta[x]);
    let e = sum(0..8, |i| thta[i]);
    lagrangian = a + b + c + d + e;
}]
pub struct Chain {
    pub count: usize,
}

fn main() {}
