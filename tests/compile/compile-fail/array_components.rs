//! Fields whose components have another shape than the coordinates.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(x, theta: [3]);
    lagrangian = dot(x).powi(2) + sum(0..3, |i| dot(theta[i]).powi(2));
    kinematic = ddot(x) + dot(theta[0]);
    variational = [(1, [0; 2]), (0, theta[1]), (0, 1, 2)];
    phi_lagrangian = |q0, q1| ((q0.x, q0.theta[3]), (q1 - q0.theta) / h);
}]
pub struct Chain;

fn main() {}
