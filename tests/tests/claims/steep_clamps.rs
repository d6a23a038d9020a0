//! Friction that saturates: a force that is linear in a slip up to a limit, with a slope so steep that it acts as a jump. Written by `min`, `max` or `abs`,
//! the steps in which it does so are counted. It holds nothing at rest, so no run asks how a motion goes on.

use dsocs_core::text::Text;
use dsocs_core::{Flow, Start, Stepper as _};
use proptest::prelude::*;

use super::draws;

/// The end of a run, after which the velocity has changed its sign four times at least.
const END: f64 = 6.0;

/// The spellings of a function that is `slope slip` between -1 and 1.
fn clamps(slope: f64, slip: &str) -> [String; 5] {
    let width = 1.0 / slope;
    [
        format!("({slope:?} * ({slip})).max(-1).min(1)"),
        format!("({slope:?} * ({slip})).min(1).max(-1)"),
        format!("2 * ({:?} * ({slip})).max(-0.5).min(0.5)", 0.5 * slope),
        format!("({slip}) / ({slip}).abs().max({width:?})"),
        format!("((({slope:?} * ({slip})) + 1).abs() - (({slope:?} * ({slip})) - 1).abs()) / 2"),
    ]
}

/// The number of steps that are counted in a run of a mass on a spring with such friction.
fn counted(force: &str, h: f64) -> Result<u64, String> {
    let text = format!(
        "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 2 * x.powi(2); external_forces = ({force});"
    );
    let text = Text::parse("clamp", &text).map_err(|error| format!("{error:?}"))?;
    let mut flow =
        Flow::of(&text.system, h, Start::second_order([1.0], [0.3])).map_err(|error| error.to_string())?;
    flow.to(END).map_err(|error| error.to_string())?;
    Ok(flow.unresolved().map_or(0, |unresolved| unresolved.steps))
}

#[test]
fn a_steep_clamp_by_min_max_or_abs_is_a_jump() {
    // at the places of the slip's zeros the acceleration is about 4
    let scenes = (4.7..7.0, 0.003..0.03, 0.2..0.6, any::<bool>());
    draws::test(60, 51, scenes, &|(decades, h, friction, moves): (
        f64,
        f64,
        f64,
        bool,
    )| {
        let slope = f64::powf(10.0, decades);
        let slip = if moves { "dot(x) - 0.1 * x" } else { "dot(x)" };
        for clamp in clamps(slope, slip) {
            let found = counted(&format!("-{friction:?} * ({clamp})"), h);
            prop_assert!(
                found.as_ref().is_ok_and(|steps| *steps >= 3),
                "{clamp} {h}: {found:?}"
            );
        }
        Ok(())
    });
}

#[test]
fn a_gentle_clamp_is_none() {
    let scenes = (0.5..6.0, 0.002..0.02, 0.2..0.6, any::<bool>());
    draws::test(60, 52, scenes, &|(slope, h, friction, moves): (
        f64,
        f64,
        f64,
        bool,
    )| {
        let slip = if moves { "dot(x) - 0.1 * x" } else { "dot(x)" };
        for clamp in clamps(slope, slip) {
            let found = counted(&format!("-{friction:?} * ({clamp})"), h);
            prop_assert_eq!(found, Ok(0), "{} {}", clamp, h);
        }
        Ok(())
    });
}
