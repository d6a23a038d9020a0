//! Dry friction on surfaces that move: a stop and a release cost no order.

use dsocs_core::text::{TapeKernel, TextError};
use dsocs_core::{AnyComposedFlow, AnyFlow, AnyStart, Composition, OwnedNode, Run};

use super::{Bar, Measured, Report, larger, read, with};

/// A block on a belt whose speed changes linearly, with a pull backward that grows.
const BLOCK: &str = "
    parameters { pull = 0, dry = 0, speed = 0, change = 0 }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = pull * (1 - t.exp()) - dry * (dot(x) - (speed + change * t)).signum();
";

/// The values of its parameters.
struct Belt {
    pull: f64,
    dry: f64,
    speed: f64,
    change: f64,
}

impl Belt {
    /// A belt that slows down, from which the block is torn off at `eᵗ = 2.1`.
    const SLOWING_BELT: Self = Self {
        pull: 1.0,
        dry: 1.0,
        speed: 0.5,
        change: -0.1,
    };

    /// A belt that speeds up, and catches a block that is faster at first, at `t = 10/7`.
    const ACCELERATING_BELT: Self = Self {
        pull: 0.0,
        dry: 0.5,
        speed: 0.0,
        change: 0.2,
    };

    /// The block on this belt.
    fn block(&self) -> Result<TapeKernel, TextError> {
        Ok(with(
            &read(BLOCK)?,
            &[self.pull, self.dry, self.speed, self.change],
        ))
    }

    /// Position and velocity of a block that sticks to the belt from the origin on.
    fn stuck_state(&self, t: f64) -> [f64; 2] {
        [
            self.speed * t + self.change * t * t / 2.0,
            self.speed + self.change * t,
        ]
    }
}

/// Position and velocity of the block on the belt that slows down.
fn torn_off(t: f64) -> [f64; 2] {
    let belt = Belt::SLOWING_BELT;
    let begins = 2.1_f64.ln();
    if t <= begins {
        return belt.stuck_state(t);
    }
    let ([x, v], s) = (belt.stuck_state(begins), t - begins);
    [
        x + v * s + s * s - (t.exp() - 2.1 - 2.1 * s),
        v + 2.0 * s - (t.exp() - 2.1),
    ]
}

/// Position and velocity of the block that is caught.
fn caught(t: f64) -> [f64; 2] {
    let (belt, stops) = (Belt::ACCELERATING_BELT, 10.0 / 7.0);
    if t <= stops {
        return [t - t * t / 4.0, 1.0 - t / 2.0];
    }
    let [[now, v], [then, _]] = [t, stops].map(|t| belt.stuck_state(t));
    [stops - stops * stops / 4.0 + now - then, v]
}

/// The largest error of position and velocity after t = 1.6, in units of `h²`, over ten steps of which none
/// is half of another.
fn error_in_squares(run: impl Fn(f64) -> Measured) -> Measured {
    let mut largest = 0.0;
    for k in 0..10 {
        let h = 0.05 * 0.73_f64.powi(k);
        largest = larger(largest, run(h)? / (h * h));
    }
    Ok(largest)
}

/// The largest error of position and velocity of a run, from t = 1.6 to t = 3.
fn error(run: &mut dyn Run, exact: fn(f64) -> [f64; 2]) -> Measured {
    let mut largest = 0.0;
    let mut node = OwnedNode::new(1);
    loop {
        run.advance()?;
        node.take(run);
        let node = node.any();
        if node.t > 3.0 {
            return Ok(largest);
        }
        if node.t > 1.6 {
            let [x, v] = exact(node.t);
            largest = larger(largest, larger((node.q[0] - x).abs(), (node.v[0] - v).abs()));
        }
    }
}

/// Measures the figures of the case.
pub fn run(report: &mut Report<'_>) {
    for (what, belt, v0, exact, method) in [
        (
            "a block is torn off a belt that slows down: largest error of position and velocity over ten steps, in h²",
            Belt::SLOWING_BELT,
            0.5,
            torn_off as fn(f64) -> [f64; 2],
            None,
        ),
        (
            "a belt that speeds up catches a block: the same",
            Belt::ACCELERATING_BELT,
            1.0,
            caught,
            None,
        ),
        (
            "the first one by Suzuki's composition",
            Belt::SLOWING_BELT,
            0.5,
            torn_off,
            Some(Composition::SUZUKI_4),
        ),
    ] {
        let bar = if method.is_some() { 0.1 } else { 4.0 };
        report.measure(what, Bar::AtMost(bar), || {
            let (block, start) = (belt.block()?, AnyStart::second_order(&[0.0], &[v0]));
            error_in_squares(|h| match method {
                None => error(AnyFlow::new(&block, h, &start)?.run_mut(), exact),
                Some(method) => error(
                    &mut *AnyComposedFlow::new(&block, h, method, &start)?.into_run(),
                    exact,
                ),
            })
        });
    }
}
