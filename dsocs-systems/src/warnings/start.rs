//! Detects a start that was projected far onto the constraints.

use dsocs_core::Shape;
use dsocs_core::linear::state_change;

use crate::entry::Beginning;

/// A body or an angle that the projection rotates by more than this, in rad, may be in another assembly than
/// intended: the change is the smallest to first order only, and constraints that also hold far away, as
/// those of a hinge with reversed axis, may be reached there.
const LARGEST_TURN: f64 = 0.5;

/// The warning for a start that was projected onto constraints, where the run begins at the position `q`: the
/// rotations of bodies and angles, if one of them is large.
#[must_use]
pub fn moved_start(beginning: &Beginning, shape: &Shape, q: &[f64]) -> Option<String> {
    let given = beginning.projected_from()?;
    let change = state_change(&shape.rotations, [given, &[]], [q, &[]]);
    let mut turned: Vec<(&str, f64)> = Vec::new();
    for (place, own) in shape.coordinates.iter().enumerate() {
        match shape.rotation_of(place) {
            Some(first) if first == place => {
                let turn = change
                    .get(first..first + 4)?
                    .iter()
                    .map(|x| x * x)
                    .sum::<f64>()
                    .sqrt();
                turned.push((own.name.strip_suffix("_w").unwrap_or(&own.name), turn));
            }
            None if own.unit() == Some("rad") => turned.push((&own.name, change.get(place)?.abs())),
            _ => {}
        }
    }
    if turned.iter().all(|(_, turn)| *turn < LARGEST_TURN) {
        return None;
    }
    let each: Vec<String> = (turned.iter().filter(|(_, turn)| *turn >= LARGEST_TURN / 10.0))
        .map(|(name, turn)| format!("`{name}` by {turn:.2} rad"))
        .collect();
    Some(format!(
        "warning: to obey the constraints the start was turned far: {}; the change is the smallest one to first order only, and where the constraints hold in several \
         assemblies, a nearer one may be meant: look at the first node, and give a start that nearly obeys them",
        each.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::entry::{Entry, Method, Plan};

    /// A link whose one end is held by a hinge to the ground, about the first axis of the ground and of the link.
    const LINK: &str = "coordinates(
            r: rotation,
            /// [rad]
            phi
        );
        lagrangian = r.angular_velocity().norm_squared() + dot(phi).powi(2) - (r * [0, 0, 1])[2];
        holonomic = [(r * [1, 0, 0])[1], (r * [1, 0, 0])[2]];";

    /// The warning for a start whose axis is this far from that of the hinge, in rad.
    fn warning(angle: f64) -> Option<String> {
        let text = dsocs_core::text::Text::parse("link", LINK).unwrap();
        let entry = Entry::of_text("link", &text, None);
        let q0 = vec![(angle / 2.0).cos(), 0.0, 0.0, (angle / 2.0).sin(), 0.0];
        let beginning = Beginning::SecondOrder { q0, v0: vec![0.0; 5] };
        let beginning = Beginning::Projected(Box::new(beginning));
        let plan = Plan {
            h: 0.01,
            until: 0.01,
            method: Method::Step,
            certify: false,
            estimate: false,
            inputs: Vec::new(),
        };
        let mut first: Option<Vec<f64>> = None;
        entry
            .run(&plan, &beginning, &mut |row| {
                first.get_or_insert_with(|| row.node.q.to_vec());
                std::ops::ControlFlow::Continue(())
            })
            .unwrap();
        moved_start(&beginning, entry.kernel().shape(), &first.unwrap())
    }

    #[test]
    fn a_start_that_is_turned_far_is_told() {
        assert_eq!(warning(0.3), None);
        let far = warning(1.2).unwrap();
        assert!(far.contains("`r` by 1.20 rad") && !far.contains("phi"), "{far}");
    }
}
