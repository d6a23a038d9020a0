//! Chapter *Which method when*: one motion by every method, its error and its work.
//!
//! `cargo run --release --example methods`

use std::time::Instant;

use dsocs_core::prelude::*;
use dsocs_core::taylor::GlobalError;

/// A pendulum.
#[dsocs {
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 + theta.cos();
}]
struct Pendulum {}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (system, end) = (Pendulum {}, 1000.0);
    let start = Start::second_order([1.0], [0.0]);
    println!("{:<24} {:>12} {:>10}", "to t = 1000", "error", "time [ms]");
    let measure = |name: &str, run: &mut dyn Stepper<1>| -> Result<(), RunError> {
        let begun = Instant::now();
        let last = run.to(end)?;
        let time = 1e3 * begun.elapsed().as_secs_f64();
        let error = GlobalError::new(&system, start, end)?.at(last.t, &last.q)?[0];
        println!("{name:<24} {error:>12.1e} {time:>10.2}");
        Ok(())
    };
    for h in [0.1, 0.01] {
        measure(&format!("step, h = {h}"), &mut Flow::new(&system, h, start)?)?;
    }
    for order in [4, 6, 8] {
        let Some(method) = Composition::of_order(order) else {
            continue;
        };
        let mut flow = ComposedFlow::new(&system, 0.1, method, start)?;
        measure(&format!("order {order}, h = 0.1"), &mut flow)?;
    }
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let mut flow = TaylorFlow::new(&system, start, Tolerance::relative(tolerance))?;
        measure(&format!("Taylor series, {tolerance:e}"), &mut flow)?;
    }
    Ok(())
}
