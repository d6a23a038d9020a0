//! Functions of the declaration that are used as numbers, before they are known, or with other arguments.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta: [8]);
    let angle = |i| if i == 0 { 0 } else { theta[i] + angle(i - 1) };
    let height = |i| lengths[i] * theta[i].cos() + offset;
    lagrangian = angle(3) + height(0) + height(1, 2) + height + speed(3) + height(1);
    let speed = |i| dot(theta[i]);
    phi_lagrangian = |q0, q1| (q0 * speed(1), (q1 - q0) / h);
}]
pub struct Chain {
    pub lengths: [f64; 8],
}

fn main() {}
