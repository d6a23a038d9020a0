//! Checks of a declaration that need no expression: names, and numbers of equations.

pub(crate) mod names;

use proc_macro2::Ident;

use crate::mistakes::errors::{Errors, Reported};
use crate::syntax::ast::{Branch, Constraints, Declaration, Directions, Side, Statement};
use crate::syntax::input::Fields;

/// Checks the names, and the numbers of entries in `branch` and `discrete_kinematic`.
pub(crate) fn check(declaration: &Declaration, fields: &Fields, errors: &Errors) -> Result<(), Reported> {
    names::check(declaration, fields, errors);
    check_branch(declaration, errors).and(check_discrete(declaration, errors))
}

/// The number of constraints of each kind.
struct Counts<'d> {
    /// For each statement of constraints: the noun for one row, the statement, and the number of rows.
    given: Vec<(&'static str, &'d Constraints, usize)>,
}

impl<'d> Counts<'d> {
    /// The counts of a declaration with these numbers of holonomic, nonholonomic and kinematic rows.
    fn of(declaration: &'d Declaration, rows: [usize; 3]) -> Self {
        let statements = [
            ("holonomic constraint", &declaration.holonomic),
            ("nonholonomic constraint", &declaration.nonholonomic),
            ("kinematic constraint", &declaration.kinematic),
        ];
        let statements = statements.into_iter().zip(rows);
        let given = statements.filter_map(|((noun, statement), rows)| Some((noun, statement.given()?, rows)));
        Self {
            given: given.collect(),
        }
    }

    /// The number of all rows.
    fn rows(&self) -> usize {
        self.given.iter().map(|(.., rows)| rows).sum()
    }

    /// The keyword of the last statement.
    fn last_keyword(&self) -> Option<&'d Ident> {
        self.given.last().map(|(_, constraints, _)| &constraints.keyword)
    }

    /// `1 holonomic constraint, 2 kinematic constraints`.
    fn in_words(&self) -> String {
        let counts: Vec<_> = self
            .given
            .iter()
            .map(|(noun, _, rows)| count(*rows, noun))
            .collect();
        if counts.is_empty() {
            return count(0, "constraint");
        }
        counts.join(", ")
    }
}

/// Checks that there are as many equations as coordinates. `rows` are the numbers of holonomic, nonholonomic
/// and kinematic rows; `None` where unknown, since a vector stands for several rows.
pub(crate) fn check_counts(
    declaration: &Declaration,
    rows: [Option<usize>; 3],
    errors: &Errors,
) -> Result<(), Reported> {
    let Some(coordinates) = declaration.coordinates.given() else {
        return Ok(());
    };
    let (&[Some(holonomic), Some(nonholonomic), Some(of_accelerations)], false) =
        (&rows, is_malformed(declaration))
    else {
        return Ok(());
    };
    let rows = [holonomic, nonholonomic, of_accelerations];
    let counts = Counts::of(declaration, rows);
    // a rotation has three degrees of freedom in four coordinates
    let n = coordinates.names.len() - coordinates.rotations().count();
    match (&declaration.directions, declaration.kinematic.given()) {
        (Statement::Malformed(_), _) => Ok(()),
        (Statement::Absent, Some(kinematic)) => Err(errors.at(
            &kinematic.keyword,
            "expected `variational = […];`, `variational = chetaev;` or `constraint_forces = […];` beside `kinematic`: \
             the kinematic constraints do not tell in which directions the constraint forces act",
        )),
        (Statement::Absent, None) => match counts.last_keyword() {
            Some(keyword) if counts.rows() > n => Err(errors.at(keyword, too_many_constraints(&counts, n))),
            _ => Ok(()),
        },
        (Statement::Given(directions), _) => check_equations(directions, of_accelerations, &counts, n, errors),
    }
}

/// Whether a statement of constraints could not be read, so that the number of its rows is unknown.
fn is_malformed(declaration: &Declaration) -> bool {
    let statements = [
        &declaration.holonomic,
        &declaration.nonholonomic,
        &declaration.kinematic,
    ];
    statements
        .into_iter()
        .any(|statement| matches!(statement, Statement::Malformed(_)))
}

fn check_equations(
    directions: &Directions,
    kinematic: usize,
    counts: &Counts<'_>,
    n: usize,
    errors: &Errors,
) -> Result<(), Reported> {
    let (fields, rows) = (directions.fields.len(), counts.rows());
    let message = match directions.side {
        Side::Variational if rows + fields != n => format!(
            "expected as many equations as coordinates: {} and {} make {}, for {}",
            counts.in_words(),
            count(fields, "variational field"),
            count(rows + fields, "equation"),
            count(n, "coordinate"),
        ),
        Side::Forces if fields != kinematic && fields != rows => {
            let wanted = match kinematic {
                0 => "constraints",
                all if all == rows => "kinematic constraints",
                _ => "kinematic constraints, or as all constraints",
            };
            format!(
                "expected as many forces as {wanted}: found {} and {}",
                count(fields, "force"),
                counts.in_words(),
            )
        }
        Side::Chetaev if kinematic == 0 => {
            "Chetaev's rule is for kinematic constraints, and there is no `kinematic = …;`; \
             the displacements of the other kinds follow without it"
                .to_owned()
        }
        Side::Forces | Side::Chetaev if rows > n => too_many_constraints(counts, n),
        _ => return Ok(()),
    };
    Err(errors.at(&directions.keyword, message))
}

fn too_many_constraints(counts: &Counts<'_>, n: usize) -> String {
    format!(
        "expected no more constraints than coordinates: found {}, for {}",
        counts.in_words(),
        count(n, "coordinate")
    )
}

fn check_branch(declaration: &Declaration, errors: &Errors) -> Result<(), Reported> {
    let Some(Branch { keyword, factors, .. }) = declaration.branch.given() else {
        return Ok(());
    };
    let rows = match &declaration.kinematic {
        Statement::Absent => {
            return Err(errors.at(
                keyword,
                "expected `kinematic = …;`: `branch` divides a factor out of its constraints",
            ));
        }
        Statement::Malformed(_) => return Ok(()),
        Statement::Given(kinematic) => kinematic.rows.len(),
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

/// Checks that `discrete_kinematic` stands beside `kinematic` and has as many rows.
fn check_discrete(declaration: &Declaration, errors: &Errors) -> Result<(), Reported> {
    let Some(discrete) = declaration.discrete_kinematic.given() else {
        return Ok(());
    };
    let rows = match &declaration.kinematic {
        Statement::Absent => {
            return Err(errors.at(
                &discrete.keyword,
                "expected `kinematic = …;` beside it: the constraint of the continuous system, in whose place this one \
                 stands in a step",
            ));
        }
        Statement::Malformed(_) => return Ok(()),
        Statement::Given(kinematic) => kinematic.rows.len(),
    };
    if discrete.rows.len() == rows {
        return Ok(());
    }
    Err(errors.at(
        &discrete.keyword,
        format!(
            "expected as many discrete constraints as kinematic ones, {rows}, found {}",
            discrete.rows.len()
        ),
    ))
}

/// `1 force`, `2 forces`.
fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}
