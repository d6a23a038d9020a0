//! Statements that several declarations share.

use dsocs_core::{Flow, Start, Stepper, System, dsocs, statements};

/// Statements in another module, and of one name with those here.
mod elsewhere {
    dsocs_core::statements! {
        pub(super) oscillator {
            coordinates(x);
            lagrangian = kinetic - stiffness * x.powi(2) / 2;
        }
    }
}

statements! {
    /// A mass that oscillates: its kinetic energy.
    oscillator {
        let kinetic = mass * dot(x).powi(2) / 2;
        let never_needed = mass;
        use elsewhere::oscillator;
    }

    pub(crate) damping {
        external_forces = -friction * dot(x);
    }

    nothing {}
}

/// Shared statements, also of shared statements.
#[dsocs {
    use oscillator;
}]
struct Free {
    mass: f64,
    stiffness: f64,
}

/// Several of them, and the declaration's own.
#[dsocs {
    use self::oscillator;
    use nothing;
    /// The energy, written out [J].
    let whole = kinetic + stiffness * x.powi(2) / 2;
    observe = [whole];
    use damping;
}]
struct Damped<T> {
    mass: f64,
    stiffness: f64,
    /// The friction [kg/s].
    friction: f64,
    _other: T,
}

/// All written out.
#[dsocs {
    coordinates(x);
    let kinetic = mass * dot(x).powi(2) / 2;
    lagrangian = kinetic - stiffness * x.powi(2) / 2;
    external_forces = -friction * dot(x);
    /// The energy, written out [J].
    let whole = kinetic + stiffness * x.powi(2) / 2;
    observe = [whole];
}]
struct Written {
    mass: f64,
    stiffness: f64,
    friction: f64,
}

/// A struct that is itself made by a macro by example.
#[rustfmt::skip] // it moves the declaration further with every run
macro_rules! with_factor {
    ($name:ident, $factor:expr) => {
        #[dsocs {
            use oscillator;
            external_forces = -$factor * dot(x);
        }]
        struct $name {
            mass: f64,
            stiffness: f64,
        }
    };
}

with_factor!(Halved, 0.25);

/// The last node of a run, and what is observed there, bit for bit.
macro_rules! end {
    ($system:expr) => {{
        let system = $system;
        let start = Start::second_order([1.0], [0.25]);
        let mut flow = Flow::new(&system, 0.125, start).unwrap();
        let node = flow.to(4.0).unwrap();
        (node.q[0].to_bits(), system.energy(0.0, &[1.0], &[0.25]).to_bits())
    }};
}

#[test]
fn they_mean_what_they_mean_written_out() {
    let (mass, stiffness) = (2.0, 3.0);
    let written = |friction| {
        end!(Written {
            mass,
            stiffness,
            friction
        })
    };
    let damped = Damped {
        mass,
        stiffness,
        friction: 0.25,
        _other: "anything",
    };
    assert_eq!(end!(damped), written(0.25));
    assert_eq!(end!(Halved { mass, stiffness }), written(0.25));
    assert_eq!(end!(Free { mass, stiffness }), written(0.0));
    assert_ne!(written(0.25).0, written(0.0).0);
}
