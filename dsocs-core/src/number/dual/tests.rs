//! Cases beside the table of hard cases: two arguments, remainders, conversions. Functions of one argument
//! are compared with 420-digit arithmetic by `dsocs stability`.

use super::Dual;
use crate::number::real::Real as _;

/// A variable with derivative 1.
fn variable(x: f64) -> Dual<f64> {
    Dual::new(x, 1.0)
}

/// A constant.
fn constant(x: f64) -> Dual<f64> {
    Dual::new(x, 0.0)
}

fn parts(x: Dual<f64>) -> [f64; 2] {
    [x.re, x.eps]
}

#[test]
fn quotients_do_not_overflow_on_the_way() {
    assert_eq!(parts(variable(1e-200) / constant(1e-200)), [1.0, 1e200]);
    assert_eq!(parts(constant(1e-200) / variable(1e-200)), [1.0, -1e200]);
    assert_eq!(parts(constant(3.0) / constant(0.0)), [f64::INFINITY, 0.0]);
    let huge = variable(1e300);
    assert_eq!(parts(huge / (huge + huge)), [0.5, 0.0]);
}

#[test]
fn angles_of_any_size() {
    for scale in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
        for (y, x) in [(3.0, 4.0), (-4.0, 3.0), (0.5, -1.0), (2.0, 0.0), (0.0, -1.0)] {
            let square = y * y + x * x;
            let [value, slope] = parts(variable(y * scale).atan2(constant(x * scale)));
            assert_eq!(value, f64::atan2(y * scale, x * scale));
            assert!((slope * scale - x / square).abs() <= 1e-15, "{y} {x} {scale}");
            let [_, slope] = parts(constant(y * scale).atan2(variable(x * scale)));
            assert!((slope * scale + y / square).abs() <= 1e-15, "{y} {x} {scale}");
        }
    }
    assert_eq!(parts(constant(0.0).atan2(constant(0.0))), [0.0, 0.0]);
}

#[test]
fn powers_of_variable_exponents() {
    let [value, slope] = parts(variable(2.0).powd(variable(3.0)));
    assert!((value - 8.0).abs() < 1e-15 && (slope - (12.0 + 8.0 * 2.0_f64.ln())).abs() < 1e-14);
    // a constant exponent is a plain number, so the base may be negative or zero
    assert_eq!(parts(variable(-2.0).powd(constant(3.0))), [-8.0, 12.0]);
    assert_eq!(parts(variable(0.0).powd(constant(2.0))), [0.0, 0.0]);
    // 0ᵖ is 0 for every p > 0
    assert_eq!(parts(constant(0.0).powd(variable(2.0))), [0.0, 0.0]);
}

#[test]
fn remainders_and_signs() {
    assert_eq!(parts(variable(7.5) % constant(2.0)), [1.5, 1.0]);
    assert_eq!(parts(constant(7.5) % variable(2.0)), [1.5, -3.0]);
    assert_eq!(parts(variable(-7.5) % 2.0), [-1.5, 1.0]);
    assert_eq!(parts(variable(-3.0).abs()), [3.0, -1.0]);
    assert_eq!(parts(variable(-3.0).signum()), [-1.0, 0.0]);
    assert_eq!(parts(variable(3.0).min(constant(1.0))), [1.0, 0.0]);
    assert_eq!(parts(variable(3.0).max(constant(1.0))), [3.0, 1.0]);
}

#[test]
fn third_derivatives_by_nesting() {
    let x = Dual::new(
        Dual::new(variable(0.3), constant(1.0)),
        Dual::new(constant(1.0), constant(0.0)),
    );
    let t = 0.3_f64.tanh();
    let third = (1.0 - t * t) * (6.0 * t * t - 2.0);
    assert!((x.tanh().eps.eps.eps - third).abs() < 1e-15);
    // the third derivative of x³ at 0, and of a constant under a root of infinite slope
    let zero = x - x.re();
    assert_eq!(zero.powi(3).eps.eps.eps, 6.0);
    let root = Dual::<Dual<Dual<f64>>>::from(0.0).sqrt();
    assert_eq!((root.re(), root.eps.re(), root.eps.eps.eps), (0.0, 0.0, 0.0));
}

#[test]
fn numbers_are_converted_and_summed_up() {
    assert_eq!(parts(Dual::from(0.1)), [0.1, 0.0]);
    let sum: Dual<f64> = [variable(1.0), variable(2.0)].into_iter().sum();
    let product: Dual<f64> = [variable(2.0), variable(3.0)].into_iter().product();
    assert_eq!((parts(sum), parts(product)), ([3.0, 2.0], [6.0, 5.0]));
    assert_eq!(variable(0.5).mul_add(constant(2.0), variable(1.0)).eps, 3.0);
    assert_eq!(variable(0.5).to_string(), "0.5 + 1ε");
}
