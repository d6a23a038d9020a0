//! The hard cases of the systems of this crate.

mod backward;
mod certificates;
mod chains;
mod friction;
mod functions;
mod garbage;
mod long;
mod peers;
mod roots;
mod scales;
mod scenes;
mod singular;
mod small;
mod switch;
mod turns;
mod two_roots;

use dsocs_core::text::TapeKernel;
use dsocs_core::text::{Text, TextError};

use super::{Bar, Measured, Report, Row, distance, larger};

/// A system that is declared for one figure. It is parsed when the figure is measured, which takes a
/// millisecond; to compile it would take seconds.
fn read(text: &str) -> Result<TapeKernel, TextError> {
    Ok(Text::parse("stability", text)?.system)
}

/// A copy of a system with other values of its parameters, in the order of the declaration.
fn with(system: &TapeKernel, values: &[f64]) -> TapeKernel {
    let mut system = system.clone();
    for (place, &value) in values.iter().enumerate() {
        if let Some(parameter) = system.parameter_mut(place) {
            *parameter = value;
        }
    }
    system
}

/// A hard case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its number.
    pub number: u8,
    /// Its name.
    pub name: &'static str,
    /// Measures the figures.
    run: fn(&mut Report<'_>),
}

impl Case {
    /// Measures all figures of the case, and calls `done` with each. Quick cases take seconds.
    pub fn run(&self, quick: bool, done: &mut dyn FnMut(&Row)) -> Vec<Row> {
        let mut report = Report {
            number: self.number,
            case: self.name,
            quick,
            rows: Vec::new(),
            done,
        };
        (self.run)(&mut report);
        report.rows
    }
}

/// All cases.
pub const CASES: &[Case] = &[
    Case {
        number: 1,
        name: "long runs",
        run: long::run,
    },
    Case {
        number: 2,
        name: "small steps",
        run: small::run,
    },
    Case {
        number: 3,
        name: "large turns",
        run: turns::run,
    },
    Case {
        number: 4,
        name: "scales",
        run: scales::run,
    },
    Case {
        number: 5,
        name: "close roots",
        run: roots::run,
    },
    Case {
        number: 6,
        name: "singular points",
        run: singular::run,
    },
    Case {
        number: 7,
        name: "stiff switch",
        run: switch::run,
    },
    Case {
        number: 8,
        name: "backward",
        run: backward::run,
    },
    Case {
        number: 9,
        name: "garbage",
        run: garbage::run,
    },
    Case {
        number: 10,
        name: "library functions",
        run: functions::run,
    },
    Case {
        number: 11,
        name: "beside a general method",
        run: peers::run,
    },
    Case {
        number: 12,
        name: "two roots",
        run: two_roots::run_all,
    },
    Case {
        number: 13,
        name: "chains at rest",
        run: chains::run_all,
    },
    Case {
        number: 14,
        name: "certificates",
        run: certificates::run,
    },
    Case {
        number: 15,
        name: "random scenes",
        run: scenes::run,
    },
    Case {
        number: 16,
        name: "friction on moving surfaces",
        run: friction::run,
    },
];
