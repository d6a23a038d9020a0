//! Division of a row by its declared factor.
//!
//! Where the variational equations hold, a Lyapunov constraint `dV/dt + F` has a factor `w` that is linear in
//! the unknowns (see `branch = divide(w)`). Evaluated as a quotient of numbers it is noise near `w = 0`; as a
//! quotient of polynomials it has no singularity there, costs less, and rounds like a formula derived by
//! hand.
//!
//! If the factor divides the row only together with the other rows, these are solved for unknowns, one row
//! after the other, and the solutions substituted in this row, until it does. Of rows that cannot be solved
//! at all parameters and positions, multiples are subtracted.

pub(super) mod continuous;

use super::eliminate::{Elimination, Rule};
use crate::graph::{Graph, Leaf, Node, NodeId, Unary};
use crate::hash::{HashMap, HashSet};
use crate::mechanics::Equation;

/// The highest degree in the unknown that is divided as a polynomial. The rate of the square of an energy, as
/// in a Lyapunov function that pumps it, has degree 5, and with the square of its power 6.
const HIGHEST_DEGREE: usize = 8;

/// The highest degree that is tried where the operations do not show a polynomial: derivatives of other
/// functions grow with every order.
const HIGHEST_DEGREE_TRIED: usize = 4;

/// The most unknowns with which other rows are used: the solutions for more would be longer than all rows.
const MOST_UNKNOWNS: usize = 16;
/// The most rows of which multiples are subtracted.
const MOST_MULTIPLES: usize = 3;

/// The leaves in which rows are solved and divided.
#[derive(Clone, Copy)]
pub(super) struct Leaves<'a> {
    /// The unknowns for which rows are solved.
    pub(super) unknown: &'a [Leaf],
    /// The variables in which rows may be divided as polynomials: the first group if the factor depends on
    /// it, else the second.
    pub(super) variables: [&'a [Leaf]; 2],
    /// The number of multipliers that are, or were, among the unknowns.
    pub(super) multipliers: usize,
}

/// The rows without their declared factors. A row becomes a polynomial quotient if its factor divides it, by
/// itself or where the other rows hold; otherwise a quotient of numbers.
pub(super) fn without_factors(graph: &mut Graph, rows: &[Equation], leaves: Leaves) -> Vec<Equation> {
    (0..rows.len())
        .map(|place| exact(graph, rows, place, leaves).unwrap_or_else(|| of_numbers(graph, rows[place])))
        .collect()
}

/// A row without its factor, as a quotient of numbers.
pub(super) fn of_numbers(graph: &mut Graph, row: Equation) -> Equation {
    match row.divide {
        Some(factor) => Equation {
            value: graph.div(row.value, factor),
            by_subtraction: graph.div(row.by_subtraction, factor),
            divide: None,
            ..row
        },
        None => row,
    }
}

/// A row without its factor, if that divides it exactly, by itself or where the other rows hold.
pub(super) fn exact(graph: &mut Graph, rows: &[Equation], place: usize, leaves: Leaves) -> Option<Equation> {
    by_itself(graph, rows[place], leaves).or_else(|| with_others(graph, rows, place, leaves))
}

/// A row without its factor, if that divides it by itself.
fn by_itself(graph: &mut Graph, row: Equation, leaves: Leaves) -> Option<Equation> {
    let factor = row.divide?;
    let mut divided = |value| {
        let slopes = leaves.variables.map(|group| slopes(graph, factor, group));
        // with multipliers, a parameter may decide which components of a force are zero
        let sure =
            |graph: &Graph, slope| leaves.multipliers == 0 && graph.leaves(slope).all(|leaf| leaf == Leaf::H);
        let careful = slopes.iter().find_map(|slopes| {
            let mut single = slopes
                .iter()
                .filter(|&&(_, slope)| slopes.len() == 1 || sure(graph, slope));
            match single.next() {
                Some(&single) => divide_exactly(graph, value, factor, single),
                None => divide_along(graph, value, factor, slopes),
            }
        });
        careful.or_else(|| {
            let mut all = slopes.iter().flatten();
            all.find_map(|&single| divide_exactly(graph, value, factor, single))
        })
    };
    Some(Equation {
        value: divided(row.value)?,
        by_subtraction: divided(row.by_subtraction)?,
        divide: None,
        ..row
    })
}

/// The slopes of a factor by the variables in which it is affine.
fn slopes(graph: &mut Graph, factor: NodeId, variables: &[Leaf]) -> Vec<(Leaf, NodeId)> {
    let mut slopes = Vec::new();
    for &variable in variables {
        let slope = graph.derivative(factor, variable);
        if graph.is_affine(factor, slope, variable) && !graph.vanishes(slope) {
            slopes.push((variable, slope));
        }
    }
    slopes
}

/// The quotient as polynomials in the distance along the factor's gradient. The square of the gradient is
/// nonzero for all parameters and positions as long as the factor depends on any of the variables.
fn divide_along(
    graph: &mut Graph,
    value: NodeId,
    factor: NodeId,
    slopes: &[(Leaf, NodeId)],
) -> Option<NodeId> {
    let variables = || slopes.iter().map(|&(variable, _)| variable);
    let varies = |slope| variables().any(|variable| graph.depends_on(slope, variable));
    if slopes.is_empty() || slopes.iter().any(|&(_, slope)| varies(slope)) {
        return None;
    }
    // this leaf is free: maps of nodes have been substituted in all rows
    let along = Leaf::X0(0);
    let distance = graph.leaf(along);
    let mut places = HashMap::default();
    for &(variable, slope) in slopes {
        let (leaf, step) = (graph.leaf(variable), graph.mul(slope, distance));
        places.insert(variable, graph.add(leaf, step));
    }
    let [value, factor] = [value, factor].map(|part| graph.substitute(part, &places));
    let slope = graph.derivative(factor, along);
    let quotient = divide_exactly(graph, value, factor, (along, slope))?;
    let zero = graph.constant(0.0);
    Some(graph.substitute(quotient, &HashMap::from_iter([(along, zero)])))
}

/// A row without its factor, where the other rows hold. Rows whose coefficient has to be nonzero are solved,
/// as few as possible; then multiples of the rest are subtracted.
fn with_others(graph: &mut Graph, rows: &[Equation], place: usize, leaves: Leaves) -> Option<Equation> {
    if leaves.unknown.len() > MOST_UNKNOWNS {
        return None;
    }
    let parameters = Rule {
        early: |graph, coefficient| graph.leaves(coefficient).all(|leaf| leaf == Leaf::H),
        most_unknowns: usize::MAX,
    };
    // the row itself stands last, so that rows solved before it do not move it
    let mut others: Vec<Equation> = rows.iter().filter(|row| row.divide.is_none()).copied().collect();
    others.push(rows[place]);
    let mut system = Elimination::new(&others, leaves.unknown.iter().copied());
    while system.run_once(graph, parameters) {
        if let Some(divided) = by_itself(graph, *system.rows.last()?, leaves) {
            return Some(divided);
        }
    }
    let (row, others) = system.rows.split_last()?;
    let reduced = without_multiples(graph, *row, others, &system.unknown)?;
    by_itself(graph, reduced, leaves)
}

/// A row `c` minus the multiples `m` of other rows, `f = F x + …`, that leave the least of its slopes:
/// `F Fᵀ m = F c'`.
fn without_multiples(
    graph: &mut Graph,
    row: Equation,
    others: &[Equation],
    unknown: &[Leaf],
) -> Option<Equation> {
    let mut slopes: Vec<Vec<NodeId>> = Vec::new();
    for row in others.iter().chain([&row]) {
        let slope = unknown.iter().map(|&leaf| graph.derivative(row.value, leaf));
        slopes.push(slope.collect());
    }
    let own = slopes.pop()?;
    let right = slopes.iter().map(|slopes| dot(graph, slopes, &own)).collect();
    let multiples = multiples(graph, &slopes, right)?;
    let mut left = |own: NodeId, of: fn(&Equation) -> NodeId| {
        let mut terms = vec![(own, 1.0)];
        for (other, &multiple) in others.iter().zip(&multiples) {
            terms.push((graph.mul(multiple, of(other)), -1.0));
        }
        graph.linear(0.0, &terms)
    };
    Some(Equation {
        value: left(row.value, |row| row.value),
        by_subtraction: left(row.by_subtraction, |row| row.by_subtraction),
        ..row
    })
}

/// The solution `m` of `F Fᵀ m = b` for rows `F` that depend on the position alone. No coefficient has to be
/// nonzero for it to exist: the matrix is positive definite where the rows are independent. `None` for no
/// rows, for many, and for other rows.
pub(super) fn multiples(
    graph: &mut Graph,
    slopes: &[Vec<NodeId>],
    mut right: Vec<NodeId>,
) -> Option<Vec<NodeId>> {
    // such as a mass that depends on the position, or the component of a virtual displacement
    let early = |leaf| matches!(leaf, Leaf::H | Leaf::Q(_) | Leaf::T | Leaf::N(_) | Leaf::Clock);
    let k = slopes.len();
    if k == 0
        || k > MOST_MULTIPLES
        || !slopes
            .iter()
            .flatten()
            .all(|&slope| graph.leaves(slope).all(early))
    {
        return None;
    }
    let mut matrix: Vec<Vec<NodeId>> = slopes
        .iter()
        .map(|a| slopes.iter().map(|b| dot(graph, a, b)).collect())
        .collect();
    for column in 0..k {
        let (above, below) = matrix.split_at_mut(column + 1);
        let (pivot, known) = (&above[column], right[column]);
        for (row, right) in below.iter_mut().zip(&mut right[column + 1..]) {
            let factor = graph.div(row[column], pivot[column]);
            for (entry, &above) in row.iter_mut().zip(pivot).skip(column) {
                let taken = graph.mul(factor, above);
                *entry = graph.sub(*entry, taken);
            }
            let taken = graph.mul(factor, known);
            *right = graph.sub(*right, taken);
        }
    }
    for i in (0..k).rev() {
        for j in i + 1..k {
            let known = graph.mul(matrix[i][j], right[j]);
            right[i] = graph.sub(right[i], known);
        }
        right[i] = graph.div(right[i], matrix[i][i]);
    }
    Some(right)
}

fn dot(graph: &mut Graph, a: &[NodeId], b: &[NodeId]) -> NodeId {
    let terms: Vec<NodeId> = a.iter().zip(b).map(|(&a, &b)| graph.mul(a, b)).collect();
    graph.sum(&terms)
}

/// The quotient of polynomials in one variable, by which the factor has the given slope.
fn divide_exactly(
    graph: &mut Graph,
    value: NodeId,
    factor: NodeId,
    (unknown, slope): (Leaf, NodeId),
) -> Option<NodeId> {
    if !graph.is_affine(factor, slope, unknown) {
        return None;
    }
    let zero = graph.constant(0.0);
    let at_zero = HashMap::from_iter([(unknown, zero)]);
    let offset = graph.substitute(factor, &at_zero);

    // terms with the factor in them, such as w tanh(w) or |w|, need no division
    let (scale, base) = graph.split(factor);
    let (constant, terms) = match graph.node(value).clone() {
        Node::Sum(constant, terms) => (constant.get(), terms.iter().map(|&(t, c)| (t, c.get())).collect()),
        _ => (0.0, vec![(value, 1.0)]),
    };
    let (mut open, mut rest, mut known) = (Vec::new(), Vec::new(), Quotients::default());
    for (term, c) in terms {
        match without_base(graph, term, base, &mut known) {
            Some(quotient) => open.push((quotient, c / scale)),
            None => rest.push((term, c)),
        }
    }
    let mut polynomial = graph.linear(constant, &rest);

    // Taylor coefficients at 0, until all further ones vanish
    let highest = if is_polynomial(graph, polynomial, unknown) {
        HIGHEST_DEGREE
    } else {
        HIGHEST_DEGREE_TRIED
    };
    let mut coefficients = Vec::new();
    while !graph.vanishes(polynomial) {
        // derivatives are those of one side, so a corner shows as a jump of one of them
        if coefficients.len() > highest || graph.jumps_with(polynomial, unknown) {
            return None;
        }
        coefficients.push(graph.substitute(polynomial, &at_zero));
        let degree = f64::from(u32::try_from(coefficients.len()).ok()?);
        let derivative = graph.derivative(polynomial, unknown);
        polynomial = graph.scale(1.0 / degree, derivative);
    }

    // synthetic division by offset + slope · unknown, from the highest degree down
    let mut quotient = Vec::new();
    let mut carried = zero;
    for &coefficient in coefficients.iter().skip(1).rev() {
        let taken = graph.mul(carried, offset);
        let left = graph.sub(coefficient, taken);
        carried = graph.div(left, slope);
        quotient.push(carried);
    }
    let taken = graph.mul(carried, offset);
    let remainder = match coefficients.first() {
        Some(&first) => graph.sub(first, taken),
        None => zero,
    };
    if !graph.vanishes(remainder) {
        return None;
    }
    let variable = graph.leaf(unknown);
    let degree = i32::try_from(quotient.len()).ok()?;
    for (coefficient, power) in quotient.into_iter().zip((0..degree).rev()) {
        open.push((graph.product(&[(coefficient, 1), (variable, power)]), 1.0));
    }
    Some(graph.linear(0.0, &open))
}

/// The quotients of expressions by one and the same, where there are any: choices share their parts.
type Quotients = HashMap<NodeId, Option<NodeId>>;

/// A term divided by an expression that stands in it as a factor, or within an absolute value or a choice.
fn without_base(graph: &mut Graph, term: NodeId, base: NodeId, known: &mut Quotients) -> Option<NodeId> {
    let factors = graph.factors(term);
    if factors.iter().any(|&(node, n)| node == base && n > 0) {
        return Some(graph.product(&[(term, 1), (base, -1)]));
    }
    factors.into_iter().filter(|&(_, n)| n > 0).find_map(|(node, _)| {
        if !matches!(graph.node(node), Node::Unary(Unary::Abs, _) | Node::Select(..)) {
            return None;
        }
        let quotient = by_pieces(graph, node, base, known)?;
        Some(graph.product(&[(term, 1), (node, -1), (quotient, 1)]))
    })
}

/// An expression divided by one that stands in all of its terms: `|b c| / b = sign(b) |c|`, and a choice between multiples of `b` is
/// one between their quotients. Their values at `b = 0` are those of one side.
fn by_pieces(graph: &mut Graph, value: NodeId, base: NodeId, known: &mut Quotients) -> Option<NodeId> {
    if let Some(&quotient) = known.get(&value) {
        return quotient;
    }
    let quotient = divided_by_pieces(graph, value, base, known);
    known.insert(value, quotient);
    quotient
}

/// [`by_pieces`] of an expression that is not known yet.
fn divided_by_pieces(
    graph: &mut Graph,
    value: NodeId,
    base: NodeId,
    known: &mut Quotients,
) -> Option<NodeId> {
    let (scale, unscaled) = graph.split(value);
    if unscaled == base {
        return Some(graph.constant(scale));
    }
    if graph.vanishes(value) {
        return Some(graph.constant(0.0));
    }
    match *graph.node(value) {
        Node::Unary(Unary::Abs, inner) => {
            let other = by_pieces(graph, inner, base, known)?;
            let (other, sign) = (graph.unary(Unary::Abs, other), graph.unary(Unary::Signum, base));
            Some(graph.mul(other, sign))
        }
        Node::Select(op, [left, right, then, otherwise]) => {
            let then = by_pieces(graph, then, base, known)?;
            let otherwise = by_pieces(graph, otherwise, base, known)?;
            Some(graph.select(op, left, right, then, otherwise))
        }
        Node::Sum(constant, ref terms) if constant.get() == 0.0 => {
            let terms: Vec<(NodeId, f64)> = terms.iter().map(|&(term, c)| (term, c.get())).collect();
            let divided = terms
                .into_iter()
                .map(|(term, c)| Some((by_pieces(graph, term, base, known)?, c)));
            let divided: Option<Vec<_>> = divided.collect();
            Some(graph.linear(0.0, &divided?))
        }
        Node::Product(_) => without_base(graph, value, base, known),
        _ => None,
    }
}

/// Whether an expression is a polynomial in a variable by its operations: sums, and products without negative
/// powers of it.
fn is_polynomial(graph: &Graph, value: NodeId, variable: Leaf) -> bool {
    let mut seen = HashSet::default();
    let mut open = vec![value];
    while let Some(id) = open.pop() {
        if !seen.insert(id) || !graph.depends_on(id, variable) {
            continue;
        }
        match graph.node(id) {
            Node::Leaf(_) => {}
            Node::Sum(_, terms) => open.extend(terms.iter().map(|&(term, _)| term)),
            Node::Product(factors) => {
                for &(factor, power) in factors {
                    if power < 0 && graph.depends_on(factor, variable) {
                        return false;
                    }
                    open.push(factor);
                }
            }
            _ => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Comparison;
    use crate::mechanics::equation::Pivots;

    const LEAVES: Leaves = Leaves {
        unknown: &[Leaf::Z(0)],
        variables: [&[Leaf::Z(0)], &[]],
        multipliers: 0,
    };

    /// A row without its factor.
    fn divided(graph: &mut Graph, row: NodeId, factor: NodeId) -> NodeId {
        let row = Equation {
            value: row,
            by_subtraction: row,
            divide: Some(factor),
            pivots: Pivots::Any,
        };
        without_factors(graph, &[row], LEAVES)[0].value
    }

    #[test]
    fn an_exact_factor_leaves_no_denominator() {
        let mut graph = Graph::new();
        let (z, a, b, c) = (
            graph.leaf(Leaf::Z(0)),
            graph.leaf(Leaf::N(0)),
            graph.leaf(Leaf::N(1)),
            graph.leaf(Leaf::D(0)),
        );
        // w = a + b z; row = w (c - 3 z + tanh w), the polynomial part multiplied out
        let slope = graph.mul(b, z);
        let w = graph.add(a, slope);
        let tanh = graph.unary(Unary::Tanh, w);
        let open = graph.mul(w, tanh);
        let products = [
            (a, c, 1.0, 0),
            (b, c, 1.0, 1),
            (a, a, 0.0, 0),
            (a, z, -3.0, 0),
            (b, z, -3.0, 1),
        ];
        let mut terms = vec![(open, 1.0)];
        for (first, second, scale, power) in products {
            terms.push((graph.product(&[(first, 1), (second, 1), (z, power)]), scale));
        }
        let row = graph.linear(0.0, &terms);
        let quotient = divided(&mut graph, row, w);
        let expected = graph.linear(0.0, &[(c, 1.0), (z, -3.0), (tanh, 1.0)]);
        let difference = graph.sub(quotient, expected);
        assert!(graph.vanishes(difference));
        // the quotient has no denominator that depends on the unknown
        let reciprocal = graph.recip(w);
        let inside = |graph: &Graph| {
            let mut open = vec![quotient];
            while let Some(id) = open.pop() {
                if let Node::Product(factors) = graph.node(id)
                    && factors
                        .iter()
                        .any(|&(node, n)| n < 0 && graph.depends_on(node, Leaf::Z(0)))
                {
                    return true;
                }
                open.extend(graph.parts(id));
            }
            false
        };
        assert!(!inside(&graph), "{:?}", graph.node(reciprocal));
    }

    /// `|w|`, `|2 w|`, `|w³|`, `|w c|` and `√w²` keep the sign of `w`, with and without other terms; the pieces of `max(w, 0)²` and
    /// of `min(w², |w|)` are divided each. No quotient has a denominator.
    #[test]
    fn a_corner_where_the_factor_vanishes_keeps_both_sides() {
        let mut graph = Graph::new();
        let (z, a, c) = (
            graph.leaf(Leaf::Z(0)),
            graph.leaf(Leaf::N(0)),
            graph.leaf(Leaf::N(1)),
        );
        let w = graph.add(a, z);
        let inside = [
            w,
            graph.scale(2.0, w),
            graph.powi(w, 3),
            graph.product(&[(w, 1), (c, 1)]),
        ];
        let mut rows = inside.map(|inside| graph.unary(Unary::Abs, inside)).to_vec();
        let square = graph.powi(w, 2);
        let root = graph.unary(Unary::Sqrt, square);
        let zero = graph.constant(0.0);
        let largest = graph.select(Comparison::Lt, w, zero, zero, w);
        let least = graph.select(Comparison::Lt, square, rows[0], square, rows[0]);
        rows.extend([root, graph.powi(largest, 2), least]);
        for row in rows {
            for rest in [zero, w] {
                let row = graph.add(row, rest);
                let quotient = divided(&mut graph, row, w);
                for at in [-1.7, -0.3, 0.0, 0.4, 2.1] {
                    let leaves = |leaf| match leaf {
                        Leaf::Z(0) => at - 0.7,
                        Leaf::N(0) => 0.7,
                        _ => -1.3,
                    };
                    let values = graph.values(&[row, quotient], &leaves, &|_| f64::NAN).unwrap();
                    // where the factor vanishes, the quotient has the value of one side
                    let is_right = (values[0] / at - values[1]).abs() < 1e-14;
                    assert!(is_right || at == 0.0 && values[1].is_finite(), "{at} {values:?}");
                }
            }
        }
    }

    #[test]
    fn a_polynomial_of_a_high_degree_is_divided() {
        let mut graph = Graph::new();
        let (z, a) = (graph.leaf(Leaf::Z(0)), graph.leaf(Leaf::N(0)));
        let w = graph.add(a, z);
        // w (z⁷ + a²), multiplied out
        let products = [(8, 0), (7, 1), (1, 2), (0, 3)];
        let terms: Vec<_> = products
            .iter()
            .map(|&(of_z, of_a)| (graph.product(&[(z, of_z), (a, of_a)]), 1.0))
            .collect();
        let row = graph.linear(0.0, &terms);
        let quotient = divided(&mut graph, row, w);
        let expected = [(7, 0), (0, 2)].map(|(of_z, of_a)| (graph.product(&[(z, of_z), (a, of_a)]), 1.0));
        let expected = graph.linear(0.0, &expected);
        let difference = graph.sub(quotient, expected);
        assert!(graph.vanishes(difference));
        assert!(is_polynomial(&graph, quotient, Leaf::Z(0)));
    }

    #[test]
    fn a_factor_that_does_not_divide_stays_a_denominator() {
        let mut graph = Graph::new();
        let (z, a) = (graph.leaf(Leaf::Z(0)), graph.leaf(Leaf::N(0)));
        let w = graph.add(a, z);
        let square = graph.powi(z, 2);
        let row = graph.add(square, a);
        let plain = graph.div(row, w);
        let quotient = divided(&mut graph, row, w);
        assert_eq!(quotient, plain);
    }
}
