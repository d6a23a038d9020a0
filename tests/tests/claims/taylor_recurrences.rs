//! All elementary recurrences to order 30, against high-precision values: as expressions in a declaration,
//! and as functions of the user's, which are evaluated on jets.
//!
//! `u(t)` is a parabola and each `w''` is a function of it, so that the coefficients of `w''` are those of
//! the function.

use dsocs_core::taylor::Series;
use dsocs_core::{Real, System, dsocs};
use dsocs_tests::data::Table;

/// The functions in the order of the coordinates `w`.
const FUNCTIONS: [&str; 30] = [
    "product",
    "square",
    "fifth",
    "reciprocal",
    "quotient",
    "sqrt",
    "cbrt",
    "powf",
    "power",
    "exp",
    "exp_m1",
    "ln",
    "ln_1p",
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sinh",
    "cosh",
    "tanh",
    "asinh",
    "acosh",
    "atanh",
    "abs",
    "signum",
    "select",
    "nested",
];

/// The functions as expressions.
#[dsocs {
    coordinates(u, w: [30]);
    lagrangian = dot(u).powi(2) / 2 + sum(0..30, |i| dot(w[i]).powi(2) / 2);
    let du = dot(u);
    kinematic = [
        ddot(u) - rate,
        ddot(w[0]) - u * du,
        ddot(w[1]) - u.powi(2),
        ddot(w[2]) - u.powi(5),
        ddot(w[3]) - 1 / (1 + u),
        ddot(w[4]) - u / (1 + u.powi(2)),
        ddot(w[5]) - u.sqrt(),
        ddot(w[6]) - u.cbrt(),
        ddot(w[7]) - u.powf(2.3),
        ddot(w[8]) - (1 + u).powf(du),
        ddot(w[9]) - u.exp(),
        ddot(w[10]) - u.exp_m1(),
        ddot(w[11]) - u.ln(),
        ddot(w[12]) - u.ln_1p(),
        ddot(w[13]) - u.sin(),
        ddot(w[14]) - u.cos(),
        ddot(w[15]) - u.tan(),
        ddot(w[16]) - (u / 2).asin(),
        ddot(w[17]) - (u / 2).acos(),
        ddot(w[18]) - u.atan(),
        ddot(w[19]) - u.atan2(1 + du),
        ddot(w[20]) - u.sinh(),
        ddot(w[21]) - u.cosh(),
        ddot(w[22]) - u.tanh(),
        ddot(w[23]) - u.asinh(),
        ddot(w[24]) - (3 + u).acosh(),
        ddot(w[25]) - (u / 2).atanh(),
        ddot(w[26]) - (-u).abs() * u.sin(),
        ddot(w[27]) - (-u).signum() * u.sin(),
        ddot(w[28]) - if u < 1 { u.exp() * u } else { u },
        ddot(w[29]) - (u.sin() / (1 + du.powi(2))).exp(),
    ];
    variational = [];
}]
struct Declared {
    /// `u''`.
    rate: f64,
}

/// One of the functions, by its place.
struct Function(usize);

impl Function {
    /// Its value at a position and a velocity.
    fn at<R: Real>(&self, u: R, du: R) -> R {
        value(self.0, u, du)
    }
}

/// The value of a function.
fn value<R: Real>(place: usize, u: R, du: R) -> R {
    let (one, zero) = (R::from(1.0), R::from(0.0));
    match place {
        0 => u * du,
        1 => u * u,
        2 => u.powi(5),
        3 => (u + 1.0).recip(),
        4 => u / (u * u + 1.0),
        5 => u.sqrt(),
        6 => u.cbrt(),
        7 => u.powf(2.3),
        8 => (u + 1.0).powd(du),
        9 => u.exp(),
        10 => u.exp_m1(),
        11 => u.ln(),
        12 => u.ln_1p(),
        13 => u.sin(),
        14 => u.cos(),
        15 => u.tan(),
        16 => (u / 2.0).asin(),
        17 => (u / 2.0).acos(),
        18 => u.atan(),
        19 => u.atan2(du + 1.0),
        20 => u.sinh(),
        21 => u.cosh(),
        22 => u.tanh(),
        23 => u.asinh(),
        24 => (u + 3.0).acosh(),
        25 => (u * 0.5).atanh(),
        26 => (-u).abs() * u.sin(),
        27 => (-u).signum() * u.sin(),
        28 => {
            if u < one {
                u.exp() * u
            } else {
                zero
            }
        }
        _ => {
            let (sine, _) = u.sin_cos();
            (sine / (du * du + one)).exp()
        }
    }
}

/// The functions behind one of the user's.
#[dsocs {
    coordinates(u, w);
    lagrangian = dot(u).powi(2) / 2 + dot(w).powi(2) / 2;
    kinematic = [ddot(u) - rate, ddot(w) - function.at(u, dot(u))];
    variational = [];
}]
struct Opaque {
    rate: f64,
    function: Function,
}

/// `w''` is the rate of the function of the user's: its partial derivatives are nested dual numbers of jets.
#[dsocs {
    coordinates(u, w);
    lagrangian = dot(u).powi(2) / 2 + dot(w).powi(2) / 2;
    kinematic = [ddot(u) - rate, ddot(w) - dot(function.at(u, dot(u)))];
    variational = [];
}]
struct OpaqueRate {
    rate: f64,
    function: Function,
}

/// The coefficients of the accelerations, `[order][coordinate]`.
fn coefficients<S: System<N>, const N: usize, const FUSED: bool>(system: &S, order: usize) -> Vec<[f64; N]> {
    let mut series = Series::new(N, order + 1);
    let (mut q, mut v) = ([0.0; N], [0.0; N]);
    (q[0], v[0]) = (0.4, 0.7);
    series.begin(0.0, &q, &v);
    system.expand::<f64, FUSED>(
        &system.fixed(&system.parameters()),
        &mut series.rows().unwrap(),
        &mut Default::default(),
    );
    let rates = series.velocity::<N>()[1..].iter().enumerate();
    rates.map(|(k, row)| row.map(|v| (k + 1) as f64 * v)).collect()
}

/// The high-precision coefficients of a function.
fn exact(table: &Table, function: &str) -> Vec<f64> {
    let rows = table
        .text("function")
        .into_iter()
        .zip(table.numbers("coefficient"));
    let coefficients: Vec<f64> = rows
        .filter(|(name, _)| *name == function)
        .map(|(_, c)| c)
        .collect();
    assert_eq!(coefficients.len(), 31, "{function}");
    coefficients
}

/// The largest error of coefficients, each relative to the largest that a series with this and the neighbouring coefficients
/// has there: an alternating sum of terms may vanish at one order, and is then as good as its terms.
fn error(found: &[f64], exact: &[f64]) -> f64 {
    assert_eq!(found.len(), exact.len());
    let scale = |k: usize| {
        let (low, high) = (k.saturating_sub(2), (k + 2).min(exact.len() - 1));
        (low..=high)
            // a unit of time in which coefficients neither grow nor fall is the radius of convergence, here 2/3
            .map(|j| exact[j].abs() * 1.5_f64.powi(i32::try_from(k).unwrap() - i32::try_from(j).unwrap()))
            .fold(0.0, f64::max)
    };
    (0..found.len())
        // polynomials end
        .filter(|&k| found[k] != 0.0 || exact[k] != 0.0)
        .map(|k| (found[k] - exact[k]).abs() / scale(k))
        .fold(0.0, f64::max)
}

/// Sums of up to 30 products of numbers with errors of some 1.1e-16 each, through three recurrences.
const ROUNDING: f64 = 1e-13;

/// The allowed error of the coefficients of a function, or of its derivative of order `rate`.
///
/// `u w' = α w u'` passes a rounding error on as a part of `1/u`, whose coefficients near the singularity `u = 0` are
/// `k^α` times those of `u^α` (by Darboux), and again `k` times for a derivative. The other functions have nothing of this
/// kind, or for roots (α < 1) little.
fn tolerance(function: &str, rate: i32) -> f64 {
    match function {
        "powf" => f64::EPSILON * 30.0_f64.powf(2.3) * 30.0_f64.powi(rate),
        _ => ROUNDING,
    }
}

fn declared<const FUSED: bool>() {
    let table = Table::read("taylor_coefficients.csv");
    let found = coefficients::<_, 31, FUSED>(&Declared { rate: 0.3 }, 30);
    for (place, function) in FUNCTIONS.into_iter().enumerate() {
        let found: Vec<f64> = found.iter().map(|row| row[place + 1]).collect();
        let error = error(&found, &exact(&table, function));
        println!("{function}: {error:.1e}");
        assert!(error <= tolerance(function, 0), "{function}: {error:e}");
    }
}

#[test]
fn recurrences_of_declarations_meet_high_precision() {
    declared::<false>();
    declared::<true>();
}

#[test]
fn recurrences_of_jets_meet_high_precision() {
    let table = Table::read("taylor_coefficients.csv");
    for (place, name) in FUNCTIONS.into_iter().enumerate() {
        let system = Opaque {
            rate: 0.3,
            function: Function(place),
        };
        let found: Vec<f64> = coefficients::<_, 2, false>(&system, 30)
            .iter()
            .map(|row| row[1])
            .collect();
        let error = error(&found, &exact(&table, name));
        println!("{name}: {error:.1e}");
        assert!(error <= tolerance(name, 0), "{name}: {error:e}");
    }
}

#[test]
fn derivatives_of_jets_meet_high_precision() {
    let table = Table::read("taylor_coefficients.csv");
    for (place, name) in FUNCTIONS.into_iter().enumerate() {
        let system = OpaqueRate {
            rate: 0.3,
            function: Function(place),
        };
        let found: Vec<f64> = coefficients::<_, 2, false>(&system, 29)
            .iter()
            .map(|row| row[1])
            .collect();
        let rates: Vec<f64> = exact(&table, name)
            .iter()
            .enumerate()
            .skip(1)
            .map(|(k, c)| k as f64 * c)
            .collect();
        let error = error(&found, &rates);
        println!("{name}: {error:.1e}");
        assert!(error <= tolerance(name, 1), "{name}: {error:e}");
    }
}
