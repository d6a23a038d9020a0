//! Declarations in a crate that has `dsocs-core` under another name only, such as one that gets it through
//! another crate.

/// The prelude that such a crate would have.
pub mod prelude {
    pub use engine as core;
    pub use engine::dsocs;

    /// Declares an oscillator where it is used.
    #[macro_export]
    macro_rules! oscillator {
        ($name:ident) => {
            /// An oscillator.
            #[$crate::prelude::dsocs {
                                                    crate = $crate::prelude::core;
                                                    coordinates(x);
                                                    lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
                                                }]
            pub struct $name {}
        };
    }
}

#[cfg(test)]
mod tests {
    use crate::prelude::core::{Flow, Real, Start, Stepper, TaylorFlow, Tolerance, dsocs};

    /// A potential.
    fn well<R: Real>(x: R) -> R {
        x.powi(2) / 2.0
    }

    /// A system with a user's function, which the core differentiates.
    #[dsocs {
        crate = crate::prelude::core;
        coordinates(x);
        lagrangian = dot(x).powi(2) / 2 - well(x);
    }]
    struct Called {}

    crate::oscillator!(Written);

    #[test]
    fn the_core_is_found_under_another_path() -> Result<(), Box<dyn std::error::Error>> {
        let end = Flow::new(&Called {}, 0.01, Start::second_order([1.0], [0.0]))?.until(1.0)?;
        let last = end.nodes.last().ok_or("an empty run")?;
        assert!((last.q[0] - 1_f64.cos()).abs() < 1e-4);
        for relative in [1e-6, 1e-12] {
            let start = Start::second_order([1.0], [0.0]);
            let end = TaylorFlow::new(&Written {}, start, Tolerance::relative(relative))?.to(1.0)?;
            assert!((end.q[0] - 1_f64.cos()).abs() < relative);
        }
        Ok(())
    }
}
