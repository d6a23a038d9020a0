//! Errors that `main` or `unwrap` prints with `Debug` show the message for people.

use std::error::Error;
use std::fs;
use std::path::Path;

use dsocs_core::{Composition, Inputs, Samples, Start, Stepper, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::text::{ComposedFlow, Flow, TaylorFlow};

use crate::roots::Either;

declared! {
    /// A mass on a rod; its push may be NaN.
    #[derive(Clone)]
    struct Rod {
        length: f64,
    }
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
    holonomic = x.powi(2) + y.powi(2) - length.powi(2);
}

declared! {
    /// A mass that falls into a singularity.
    struct Hole;
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = -1 / x.powi(2);
}

/// The error of a program that ends with it.
fn of(main: impl FnOnce() -> Result<(), Box<dyn Error>>) -> Box<dyn Error> {
    main().unwrap_err()
}

#[test]
fn is_what_main_prints() {
    let rod = Rod { length: 1.0 };
    let on = Start::second_order([0.6, -0.8], [0.0, 0.0]);
    let off = Start::second_order([0.6, -0.7], [0.0, 0.0]);
    let samples = |places: [f64; 2]| Samples::linear(places.map(|place| (place, 1.0)));
    let errors = [
        of(|| Ok(Flow::new(&rod, 0.01, off).map(|_| ())?)),
        of(|| Ok(Flow::new(&rod, 0.0, on).map(|_| ())?)),
        of(|| Ok(Flow::new(&rod, 0.01, on)?.to(-1.0).map(|_| ())?)),
        of(|| Ok(Flow::new(&rod, 0.01, on)?.to(f64::NAN).map(|_| ())?)),
        of(|| Ok(Flow::new(&rod, 0.01, on)?.set_input("length", 2.0)?)),
        of(|| Ok(Flow::new(&rod, 0.01, on)?.set_input("lenght", 2.0)?)),
        of(|| Ok(ComposedFlow::new(&rod, 0.01, Composition::SUZUKI_4, on).map(|_| ())?)),
        of(|| Ok(TaylorFlow::new(&rod, on, Tolerance::relative(2.0)).map(|_| ())?)),
        of(|| {
            let start = Start::second_order([1.5], [-1.0]);
            Ok(TaylorFlow::new(&Hole, start, Tolerance::relative(1e-9))?
                .until(9.0)
                .map(|_| ())?)
        }),
        of(|| {
            let start = Start::second_order([1.8], [1.36]);
            Ok(Flow::new(&Either { drift: 0.8 }, 0.5, start)?
                .to(8.0)
                .map(|_| ())?)
        }),
        of(|| {
            let start = Start::second_order([1.8], [1.36]);
            Ok(Flow::new(&Either { drift: 0.8 }, 0.5, start)?
                .until(8.0)
                .map(|_| ())?)
        }),
        of(|| Ok(samples([1.0, 0.0]).map(|_| ())?)),
        of(|| Ok(samples([1.0, f64::NAN]).map(|_| ())?)),
    ];
    for error in errors {
        let printed = format!("{error:?}");
        assert_eq!(printed, error.to_string());
        let is_text = printed.contains(' ') && !printed.contains(" { ") && !printed.contains("Some(");
        assert!(is_text, "{printed}");
        // every cause has a text of its own
        let mut cause = error.source();
        while let Some(error) = cause {
            assert_eq!(format!("{error:?}"), error.to_string());
            cause = error.source();
        }
    }
}

/// No error type of the library derives `Debug`.
#[test]
fn is_that_of_every_error_type() {
    let workspace = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let mut open = vec![
        workspace.join("dsocs-core/src"),
        workspace.join("dsocs-systems/src"),
        workspace.join("dsocs-macros"),
    ];
    let mut found = 0;
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
            continue;
        }
        if path.extension().is_none_or(|extension| extension != "rs") {
            continue;
        }
        let source = fs::read_to_string(&path).unwrap();
        for derived in source.split("#[derive(").skip(1) {
            let derived = derived.split_once(")]").unwrap().0;
            let mut names = derived.split(',').map(str::trim);
            if names.clone().any(|name| name == "Error") {
                found += 1;
                assert!(names.all(|name| name != "Debug"), "{}: {derived}", path.display());
            }
        }
        for written in source.split("Error for ").skip(1) {
            let name = written.split([' ', '{']).next().unwrap();
            let by_hand = format!("fmt::Debug for {name}");
            let is_implemented =
                source.contains(&format!("debug_is_message!({name})")) || source.contains(&by_hand);
            assert!(is_implemented, "{}: {name}", path.display());
        }
    }
    assert!(found > 15, "{found}");
}
