//! The statement `reduced(…)`: coordinates whose positions may occur in no equation.

use crate::mechanics;
use crate::mistakes::errors::{Errors, Reported};
use crate::mistakes::nearest::nearest;
use crate::model::Model;
use crate::syntax::ast::{Declaration, Group};

/// Refuses coordinates in `reduced(…)` whose positions occur in an equation.
pub(crate) fn check(
    declaration: &Declaration,
    groups: &[Group],
    model: &Model,
    errors: &Errors,
) -> Result<(), Reported> {
    let mut checked = Ok(());
    for name in declaration.reduced.given().into_iter().flatten() {
        let Some(group) = groups.iter().find(|group| group.name == *name) else {
            let known: Vec<String> = groups.iter().map(|group| group.name.to_string()).collect();
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            let message = match nearest(&name.to_string(), known.iter().copied()) {
                Some(near) => format!("no coordinate is called `{name}`; did you mean `{near}`?"),
                None => format!("no coordinate is called `{name}`; expected {}", known.join(", ")),
            };
            checked = Err(errors.at(name, message));
            continue;
        };
        let position = if group.is_rotation { "attitude" } else { "position" };
        if let Some(place) = mechanics::where_position_is(model, group.first..group.first + group.places()) {
            let message = format!("`{name}` is not reduced: its {position} is in {place}");
            checked = Err(errors.at(name, message));
        }
    }
    checked
}
