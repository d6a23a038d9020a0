//! The rules between the parts of a declaration, as far as they need no expression.

use crate::ast::{Branch, Declaration, Directions, Part, Side};
use crate::errors::{Errors, Reported};
use crate::input::Fields;
use crate::names;

/// Checks the names, and how many there are of each thing.
pub(crate) fn check(declaration: &Declaration, fields: &Fields, errors: &Errors) -> Result<(), Reported> {
    names::check(declaration, fields, errors);
    counts(declaration, errors).and(branch(declaration, errors))
}

/// As many equations as coordinates, as many components as coordinates.
fn counts(declaration: &Declaration, errors: &Errors) -> Result<(), Reported> {
    let Some(coordinates) = declaration.coordinates.given() else {
        return Ok(());
    };
    let kinematic = match &declaration.kinematic {
        Part::Absent => None,
        Part::Broken(_) => return Ok(()),
        Part::Given(kinematic) => Some(kinematic),
    };
    let rows = kinematic.map_or(0, |kinematic| kinematic.rows.len());
    match (&declaration.directions, kinematic) {
        (Part::Broken(_), _) | (Part::Absent, None) => Ok(()),
        (Part::Absent, Some(kinematic)) => Err(errors.at(
            &kinematic.keyword,
            "expected `variational = […];` or `forces = […];` beside `kinematic`: \
             the kinematic constraints do not tell in which directions the constraint forces act",
        )),
        (Part::Given(directions), _) => equations(directions, rows, coordinates.names.len(), errors),
    }
}

fn equations(directions: &Directions, rows: usize, n: usize, errors: &Errors) -> Result<(), Reported> {
    let fields = directions.fields.len();
    let message = match directions.side {
        Side::Variational if rows + fields != n => format!(
            "expected as many equations as coordinates: {} and {} make {}, for {}",
            count(rows, "kinematic constraint"),
            count(fields, "variational field"),
            count(rows + fields, "equation"),
            count(n, "coordinate"),
        ),
        Side::Forces if rows != fields || rows > n => format!(
            "expected as many forces as kinematic constraints, and no more than coordinates: found {} and {}, for {}",
            count(fields, "force"),
            count(rows, "kinematic constraint"),
            count(n, "coordinate"),
        ),
        _ => return Ok(()),
    };
    Err(errors.at(&directions.keyword, message))
}

fn branch(declaration: &Declaration, errors: &Errors) -> Result<(), Reported> {
    let Some(Branch { keyword, factors, .. }) = declaration.branch.given() else {
        return Ok(());
    };
    let rows = match &declaration.kinematic {
        Part::Absent => {
            return Err(errors.at(
                keyword,
                "expected `kinematic = …;`: `branch` divides a factor out of its constraints",
            ));
        }
        Part::Broken(_) => return Ok(()),
        Part::Given(kinematic) => kinematic.rows.len(),
    };
    if factors.len() == rows {
        return Ok(());
    }
    Err(errors.at(
        keyword,
        format!(
            "expected an entry for each of the {}, such as `branch = [divide(w), _];`, found {}",
            count(rows, "kinematic constraint"),
            factors.len()
        ),
    ))
}

/// `1 force`, `2 forces`.
fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}
