//! A control that switches along a curve which the motion then follows.

use dsocs_core::prelude::{RunError, Start, Stepper, Tolerance};
use dsocs_tests::declared;
use dsocs_tests::scenes::random::Random;
use dsocs_tests::short_or_long;
use dsocs_tests::text::TaylorFlow;

declared! {
    /// A mass under the control that brings it to a place in the shortest time.
    #[derive(Debug)]
    struct Shortest {
        u: f64,
        goal: f64,
    }
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2;
    external_forces = (-u * (x - goal + dot(x) * dot(x).abs() / (2 * u)).signum());
}

/// Random starts, against the closed form of two parabolas. Along the second one the argument of the control stays zero: a series follows
/// it, or says that it does not go on; at the goal it stays, or says so, too.
#[test]
fn a_control_in_the_shortest_time_is_not_left_at_its_goal() {
    let [mut runs, mut followed] = [0; 2];
    for seed in 0..short_or_long(20, 500) {
        let mut random = Random::new(seed);
        let law = Shortest {
            u: random.between(0.5, 2.0),
            goal: random.between(-1.0, 1.0),
        };
        let (x, v) = (random.between(-2.0, 2.0), random.between(-1.0, 1.0));
        let v = if random.chance(0.5) { v } else { 0.0 };
        let away = x - law.goal + v * v.abs() / (2.0 * law.u);
        let toward = -away.signum();
        // the first parabola is left at the speed w
        let w = (v * v / 2.0 - toward * law.u * (x - law.goal)).sqrt();
        let [turns, arrives] = [(w - toward * v) / law.u, (2.0 * w - toward * v) / law.u];
        let halfway = 0.5 * (turns + arrives);
        let left = arrives - halfway;
        let expected = law.goal - toward * law.u * left * left / 2.0;
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let flow = || {
                let start = Start::second_order([x], [v]);
                TaylorFlow::new(&law, start, Tolerance::relative(tolerance)).unwrap()
            };
            runs += 1;
            match flow().to(halfway) {
                Ok(node) => {
                    let found = node.q[0];
                    assert!(
                        (found - expected).abs() < 10.0 * tolerance,
                        "{seed}: {law:?}, {found}"
                    );
                }
                // rounding decides there from step to step which side the control has
                Err(RunError::Series(error)) => {
                    let ends = error.ends_at();
                    assert!(ends > turns - tolerance, "{seed}: {law:?}, {ends}: {error}");
                    continue;
                }
                Err(error) => panic!("{seed}: {law:?}, {error}"),
            }
            followed += 1;
            let mut flow = flow();
            match flow.to(arrives + 1.0) {
                Ok(last) => {
                    assert!(
                        (last.q[0] - law.goal).abs() < 10.0 * tolerance,
                        "{seed}: {law:?}, {last:?}"
                    );
                }
                Err(RunError::Series(error)) => {
                    let ends = error.ends_at();
                    // a place that is missed by a little is passed with its root as velocity
                    let late = (100.0 * tolerance).sqrt();
                    assert!(
                        ends > turns - tolerance && ends < arrives + late,
                        "{seed}: {law:?}, {ends}: {error}"
                    );
                }
                Err(error) => panic!("{seed}: {law:?}, {error}"),
            }
        }
    }
    println!("{followed} of {runs}");
    assert!(2 * followed > runs, "{followed} of {runs}");
}
