//! Functions, constants and products in the notation of other languages.

use dsocs_core::dsocs;

#[dsocs {
    coordinates(theta, x);
    let a = length theta.sin();
    lagrangian = dot(theta).powi(2) + dot(x).powi(2);
}]
pub struct Product {
    length: f64,
}

#[dsocs {
    coordinates(theta, x);
    lagrangian = (diff(theta, t)).powi(2) + dot(x).squared() + pi * sign(x) + pow(theta, 2) - np.sin(theta) - x.abs - 2(x + theta) - np.pi;
}]
pub struct Functions;

fn main() {}
