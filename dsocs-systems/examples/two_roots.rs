//! Chapter *Two roots*: a step with two solutions, and three ways to choose one of them.
//!
//! `cargo run --release --example two_roots`

use dsocs_core::prelude::*;

/// The product of an oscillator and a uniform motion: two roots at every step.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (dot(x) - drift) * (ddot(x) + x);
    constraint_forces = [(1,)];
}]
struct Either {
    drift: f64,
}

/// The product, with the factor of the uniform motion divided out.
#[dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    kinematic = (dot(x) - drift) * (ddot(x) + x);
    constraint_forces = [(1,)];
    branch = divide(dot(x) - drift);
}]
struct Divided {
    drift: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let start = Start::second_order([1.0], [0.0]);
    let either = Either { drift: 0.3 };
    let mut flow = Flow::new(&either, 0.1, start)?;
    let roots = flow.roots()?;
    println!("the first step leads to {:?}", roots.found);
    if let Some(other) = roots.other {
        println!("or to {other:?}");
    }
    flow.advance_to(&roots.found)?;
    println!("having been told the first, it stands at {:?}", flow.position());
    match flow.until(10.0) {
        Ok(trajectory) => println!("and goes on alone for {} nodes", trajectory.nodes.len()),
        Err(failure) => println!("later it asks again: {failure}"),
    }

    let divided = Divided { drift: 0.3 };
    let last = Flow::new(&divided, 0.1, start)?.to(10.0)?;
    println!(
        "with the factor divided out: x(10) = {:.4}, cos 10 = {:.4}",
        last.q[0],
        10.0_f64.cos()
    );
    Ok(())
}
