//! Functions of the user's in Taylor series: long ones, several, and one that itself computes a motion.

use core::sync::atomic::{AtomicUsize, Ordering};

use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{Real, Start, Stepper, System, dsocs};

/// A mass between walls that get stiffer; their potential is a function of the user's.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - wall.at(x);
}]
struct Walled<W: Wall + 'static> {
    wall: W,
}

trait Wall {
    fn at<R: Real>(&self, x: R) -> R;
}

/// `(1 + x²/100)^100` by a hundred products: more intermediate values than the fast memory holds.
struct Long;

impl Wall for Long {
    fn at<R: Real>(&self, x: R) -> R {
        let factor = x * x * 0.01 + 1.0;
        (0..100).map(|_| factor).product()
    }
}

/// The function of `Long`, by `powi`.
struct Short;

impl Wall for Short {
    fn at<R: Real>(&self, x: R) -> R {
        (x * x * 0.01 + 1.0).powi(100)
    }
}

/// The function of `Long`; each call also computes another motion.
struct Busy;

impl Wall for Busy {
    fn at<R: Real>(&self, x: R) -> R {
        let factor = x * x * 0.01 + 1.0;
        let inner = Walled { wall: Short };
        let end = end(&inner, 1.0);
        assert!(end.is_finite());
        factor.powi(100)
    }
}

/// A function whose number of terms grows with each call.
#[derive(Default)]
struct Changing(AtomicUsize);

impl Wall for Changing {
    fn at<R: Real>(&self, x: R) -> R {
        let terms = self.0.fetch_add(1, Ordering::Relaxed);
        (0..=terms).map(|_| x * x).sum()
    }
}

/// Two functions of each coordinate, called in turn.
#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - well(x) * bump(y) - well(y - x);
}]
struct Called;

#[dsocs {
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - (x.cosh() + x.sin() / 3) * (2 + (y / 2).tanh())
        - ((y - x).cosh() + (y - x).sin() / 3);
}]
struct Declared;

fn well<R: Real>(x: R) -> R {
    x.cosh() + x.sin() / 3.0
}

fn bump<R: Real>(y: R) -> R {
    (y / 2.0).tanh() + 2.0
}

/// The position at a time.
fn at<const N: usize>(flow: &mut dyn Stepper<N>, time: f64) -> [f64; N] {
    let mut found = [f64::NAN; N];
    flow.sample(&[time], &mut |_, point| found = point.q)
        .expect("a motion");
    found
}

/// The position after a time.
fn end<S: System<1>>(system: &S, time: f64) -> f64 {
    let start = Start::second_order([0.5], [1.0]);
    let mut flow = TaylorFlow::new(system, start, Tolerance::relative(1e-12)).expect("a start");
    at(&mut flow, time)[0]
}

#[test]
fn a_function_may_have_any_number_of_operations() {
    let (long, short) = (
        end(&Walled { wall: Long }, 5.0),
        end(&Walled { wall: Short }, 5.0),
    );
    assert!((long - short).abs() < 1e-10, "{long} {short}");
    assert!(long.abs() < 3.0, "the walls hold: {long}");
}

#[test]
fn a_function_may_compute_a_motion_itself() {
    let (busy, short) = (
        end(&Walled { wall: Busy }, 0.5),
        end(&Walled { wall: Short }, 0.5),
    );
    assert_eq!(busy.to_bits(), short.to_bits(), "{busy} {short}");
}

#[test]
fn a_function_that_does_something_else_in_each_call_is_refused() {
    let walled = Walled {
        wall: Changing::default(),
    };
    let start = Start::second_order([0.5], [1.0]);
    let flow = TaylorFlow::new(&walled, start, Tolerance::relative(1e-12));
    let result = flow.map(|mut flow| flow.until(1.0).map(|_| ()));
    assert!(!matches!(result, Ok(Ok(()))), "a motion of no function");
}

#[test]
fn several_functions_are_the_same_as_expressions() {
    let start = || Start::second_order([0.5, -0.2], [1.0, 0.3]);
    let tolerance = Tolerance::relative(1e-12);
    let mut called = TaylorFlow::new(&Called, start(), tolerance).expect("a start");
    let mut declared = TaylorFlow::new(&Declared, start(), tolerance).expect("a start");
    let (called, declared) = (at(&mut called, 10.0), at(&mut declared, 10.0));
    for (called, declared) in called.iter().zip(declared) {
        assert!((called - declared).abs() < 1e-9, "{called} {declared}");
    }
}
