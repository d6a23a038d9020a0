//! The vehicle: arcs of circles between changes of the steering, which take or give speed.

use dsocs_core::taylor::{TaylorFlow, Tolerance};
use dsocs_core::{Flow, Inputs, RunError, Start, Stepper};
use dsocs_systems::Vehicle;

use super::is_second;
use dsocs_tests::motion::distance;

/// The time for which a steering angle is held: a controller at 20 Hz.
const HELD: f64 = 0.05;

/// The number of held values.
const CHANGES: u32 = 60;

/// The steering from the time `HELD k` on.
fn steering(k: u32) -> f64 {
    0.35 * (0.21 * f64::from(k)).sin() + 0.1
}

const FROM: [f64; 3] = [1.0, -2.0, 0.4];

const SPEED: f64 = 8.0;

fn vehicle() -> Vehicle {
    Vehicle {
        steering: steering(0),
        ..Vehicle::default()
    }
}

/// Position and speed at the end, arc by arc.
fn arcs() -> ([f64; 3], f64) {
    let (mut vehicle, mut position, mut speed) = (vehicle(), FROM, SPEED);
    for k in 0..CHANGES {
        let before = vehicle.steering;
        vehicle.steering = steering(k);
        speed = vehicle.steered(before, speed);
        position = vehicle.held(position, speed, HELD);
    }
    (position, speed)
}

fn start() -> Start<3> {
    Start::second_order(FROM, vehicle().rolling(FROM, SPEED))
}

#[test]
fn the_continuous_motion_is_made_of_arcs() {
    let vehicle = vehicle();
    let tolerance = Tolerance::relative(1e-15);
    let mut run = TaylorFlow::new(&vehicle, start(), tolerance)
        .unwrap()
        .every(HELD)
        .unwrap();
    for k in 0..CHANGES {
        run.set_input("steering", steering(k)).unwrap();
        run.advance().unwrap();
    }
    let (position, speed) = arcs();
    let node = run.node();
    assert!(distance(&node.q, &position) < 1e-12, "{:?}, {position:?}", node.q);
    let found = node.v[0].hypot(node.v[1]);
    assert!((found - speed).abs() < 1e-12, "{found}, {speed}");
    // steering costs speed
    assert!(speed < SPEED - 0.1, "{speed}");
}

/// The step, under a controller that ticks at 20 Hz, is of order 2.
#[test]
fn the_discrete_motion_comes_near_it_with_order_two() {
    let (position, _) = arcs();
    let error = |h: f64| {
        let system = vehicle();
        let mut run = Flow::new(&system, h, start()).unwrap();
        let parts = (1..=16).find(|&parts| (HELD / f64::from(parts) - h).abs() < 1e-12);
        let parts = u64::from(parts.unwrap_or(1_u32));
        // an input that is set at a node holds from the node after it on
        let controlled = run.drive(HELD * f64::from(CHANGES), &mut |node, run| {
            let next = node.index + 1;
            let tick = u32::try_from(next / parts).unwrap_or(CHANGES);
            if next % parts == 0 {
                run.set_input("steering", steering(tick))
            } else {
                Ok::<(), RunError>(())
            }
        });
        controlled.unwrap();
        distance(&run.node().q, &position)
    };
    is_second("vehicle", [0.05, 0.025, 0.0125, 0.00625, 0.003_125], error);
}
