use core::any::TypeId;

use wide::f64x8;

use super::*;
use crate::number::instructions::Instructions;

/// Values at which functions have special cases, and many others of all sizes and both signs.
fn arguments() -> Vec<f64> {
    let mut values = vec![
        0.0,
        f64::MIN_POSITIVE,
        5e-324,
        1e-300,
        1e-17,
        0.25,
        0.5,
        1.0,
        1.0 + f64::EPSILON,
        1.0 - f64::EPSILON / 2.0,
        2.0,
        19.99,
        20.0,
        22.0,
        355.0,
        707.9,
        708.1,
        709.78,
        709.79,
        745.0,
        746.0,
        1e5,
        1e6,
        1.000_001e6,
        1e22,
        f64::MAX,
        f64::INFINITY,
        f64::NAN,
    ];
    // multiples of π/2 and their neighbours
    for k in (1..400).chain([1 << 15, 345_678, 636_619]) {
        let angle = f64::from(k) * core::f64::consts::FRAC_PI_2;
        values.extend([angle, angle.next_up(), angle.next_down()]);
    }
    let mut seed = 7_u64;
    let mut uniform = move || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..20_000 {
        values.push(uniform());
        values.push(uniform() * 30.0);
        values.push(10_f64.powf(uniform() * 30.0 - 22.0));
        values.push(10_f64.powf(uniform() * 600.0 - 300.0));
    }
    values.iter().flat_map(|&x| [x, -x]).collect()
}

/// The distance of two numbers in units in the last place of the second; 0 if both are NaN, or the same.
fn distance(x: f64, exact: f64) -> f64 {
    if x.to_bits() == exact.to_bits() || x.is_nan() && exact.is_nan() {
        return 0.0;
    }
    if !x.is_finite() || !exact.is_finite() || x == exact {
        // zeros of different signs are not the same
        return f64::INFINITY;
    }
    (x - exact).abs() / (exact.abs().next_up() - exact.abs())
}

#[track_caller]
fn check<R: Register>(
    name: &str,
    units: f64,
    lanes: impl Fn(Lanes<R>) -> Lanes<R>,
    single: impl Fn(f64) -> f64,
) {
    let arguments = arguments();
    let mut worst = (0.0, 0.0);
    // only the registers for which the program was compiled are tested with all arguments
    let stride = if TypeId::of::<R>() == TypeId::of::<f64x8>() {
        1
    } else {
        17
    };
    for chunk in arguments.chunks(LANES).step_by(stride) {
        let x: [f64; LANES] = core::array::from_fn(|i| chunk[i % chunk.len()]);
        let result = lanes(Lanes::from(x));
        for (lane, &x) in x.iter().enumerate() {
            let distance = distance(result.lane(lane), single(x));
            if distance > worst.0 {
                worst = (distance, x);
            }
        }
    }
    assert!(
        worst.0 <= units,
        "{name}: {} units away at {:e}",
        worst.0,
        worst.1
    );
}

/// Tests a function of two numbers.
#[track_caller]
fn check_pair<R: Register>(
    name: &str,
    lanes: impl Fn(Lanes<R>, Lanes<R>) -> Lanes<R>,
    single: impl Fn(f64, f64) -> f64,
) {
    for y in [
        0.0,
        -0.0,
        1.0,
        -2.5,
        1e-5,
        1e300,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ] {
        check(name, 0.0, |x| lanes(x, Lanes::splat(y)), |x| single(x, y));
    }
}

macro_rules! in_all_registers {
    ($($name:ident),* $(,)?) => {
        $(
            #[test]
            fn $name() {
                super::$name::<super::f64x8>();
                #[cfg(target_arch = "x86_64")]
                if super::Instructions::Avx2.are_available() {
                    super::$name::<super::x86::Avx2>();
                }
                #[cfg(target_arch = "x86_64")]
                if super::Instructions::Avx512.are_available() {
                    super::$name::<super::x86::Avx512>();
                }
            }
        )*
    };
}

mod in_registers {
    in_all_registers!(
        arithmetic_is_that_of_one_number,
        comparisons_select_by_lane,
        functions_without_vector_code_are_those_of_one_number,
        functions_with_vector_code_are_within_units_in_the_last_place,
        a_lane_does_not_see_the_others,
        a_function_of_one_lane_is_called_for_each,
        functions_give_the_same_bits
    );
}

/// Compares the vector code of functions with that in the registers for which the program was compiled.
fn functions_give_the_same_bits<R: Register>() {
    let narrow: [fn(Lanes) -> Lanes; 5] = [
        Scalar::sin,
        Scalar::cos,
        Scalar::exp,
        Scalar::exp_m1,
        Scalar::tanh,
    ];
    let wide: [fn(Lanes<R>) -> Lanes<R>; 5] = [
        Scalar::sin,
        Scalar::cos,
        Scalar::exp,
        Scalar::exp_m1,
        Scalar::tanh,
    ];
    for chunk in arguments().chunks_exact(LANES).step_by(7) {
        let x: [f64; LANES] = core::array::from_fn(|lane| chunk[lane]);
        for (narrow, wide) in narrow.into_iter().zip(wide) {
            let narrow: [f64; LANES] = narrow(Lanes::from(x)).into();
            let wide: [f64; LANES] = wide(Lanes::from(x)).into();
            for lane in 0..LANES {
                let same = narrow[lane].to_bits() == wide[lane].to_bits();
                assert!(same || narrow[lane].is_nan() && wide[lane].is_nan(), "{x:?}");
            }
        }
    }
}

fn arithmetic_is_that_of_one_number<R: Register>() {
    check_pair::<R>("+", |x, y| x + y, |x, y| x + y);
    check_pair::<R>("-", |x, y| x - y, |x, y| x - y);
    check_pair::<R>("*", |x, y| x * y, |x, y| x * y);
    check_pair::<R>("/", |x, y| x / y, |x, y| x / y);
    check::<R>("neg", 0.0, |x| -x, |x| -x);
    check::<R>("abs", 0.0, Scalar::abs, f64::abs);
    check::<R>("recip", 0.0, Scalar::recip, f64::recip);
    check::<R>("sqrt", 0.0, Scalar::sqrt, f64::sqrt);
    check::<R>("signum", 0.0, Scalar::signum, f64::signum);
    for exponent in [-7, -2, -1, 0, 1, 2, 3, 4, 11, 64, i32::MAX, i32::MIN] {
        // the library rounds some powers with one multiplication less
        check::<R>(
            "powi",
            2.0 * f64::from(exponent.unsigned_abs().min(128)),
            |x| x.powi(exponent),
            |x| x.powi(exponent),
        );
    }
}

fn comparisons_select_by_lane<R: Register>() {
    let (then, otherwise) = (Lanes::<R>::splat(1.0), Lanes::<R>::splat(2.0));
    check_pair::<R>(
        "<",
        |x, y| Lanes::<R>::select_lt(x, y, then, otherwise),
        |x, y| f64::select_lt(x, y, 1.0, 2.0),
    );
    check_pair::<R>(
        "<=",
        |x, y| Lanes::<R>::select_le(x, y, then, otherwise),
        |x, y| f64::select_le(x, y, 1.0, 2.0),
    );
    for bits in 0..256 {
        assert_eq!(Mask::<R>::from_bits(bits).bits(), bits);
        assert_eq!(
            (Mask::<R>::from_bits(bits) & Mask::<R>::from_bits(0x2f)).bits(),
            bits & 0x2f
        );
        assert_eq!(
            (Mask::<R>::from_bits(bits) | Mask::<R>::from_bits(0x2f)).bits(),
            bits | 0x2f
        );
    }
}

fn functions_without_vector_code_are_those_of_one_number<R: Register>() {
    macro_rules! same {
        ($($name:ident),*) => { $(check::<R>(stringify!($name), 0.0, Scalar::$name, f64::$name);)* };
    }
    same!(
        cbrt, ln, ln_1p, tan, asin, acos, atan, sinh, cosh, asinh, acosh, atanh
    );
    check_pair::<R>("powf", Scalar::powf, f64::powf);
    check_pair::<R>("atan2", Scalar::atan2, f64::atan2);
}

fn functions_with_vector_code_are_within_units_in_the_last_place<R: Register>() {
    check::<R>("sin", 1.0, Scalar::sin, f64::sin);
    check::<R>("cos", 1.0, Scalar::cos, f64::cos);
    check::<R>("exp", 1.0, Scalar::exp, f64::exp);
    check::<R>("exp_m1", 2.0, Scalar::exp_m1, f64::exp_m1);
    check::<R>("tanh", 3.0, Scalar::tanh, f64::tanh);
}

fn a_lane_does_not_see_the_others<R: Register>() {
    let functions = [
        Scalar::sin,
        Scalar::cos,
        Scalar::exp,
        Scalar::exp_m1,
        Scalar::tanh,
        Scalar::ln,
    ];
    let strangers = [f64::NAN, 1e300, f64::INFINITY, 0.0, 1e-310, -700.0, 3.0, 0.1];
    for function in functions as [fn(Lanes<R>) -> Lanes<R>; 6] {
        for x in arguments().into_iter().step_by(37) {
            let alone = function(Lanes::<R>::splat(x)).lane(0);
            for lane in 0..LANES {
                let mut company = Lanes::<R>::from(strangers);
                company.set_lane(lane, x);
                assert_eq!(function(company).lane(lane).to_bits(), alone.to_bits(), "{x:e}");
            }
        }
    }
}

fn a_function_of_one_lane_is_called_for_each<R: Register>() {
    let x = Lanes::<R>::from([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    let [square, half] = Lanes::<R>::from_lanes(|lane| [x.lane(lane).powi(2), x.lane(lane) / 2.0]);
    assert_eq!(square, x * x);
    assert_eq!(half, x / Lanes::<R>::splat(2.0));
}
