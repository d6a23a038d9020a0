//! Whether an expression is identically zero in its leaves and parameters.
//!
//! The normal form does not multiply out products of sums, because that would cost more and round worse; so
//! it does not see that `(I + J)/h - I/h - J/h` is zero, or that a declared factor divides a constraint. Here
//! an expression is evaluated as a rational function in arithmetic modulo a prime, at random values of its
//! leaves, its parameters and all functions in it. A function that is not identically zero is zero at a
//! random point with a probability of about its degree divided by 2⁶¹ (Schwartz and Zippel). Numbers count as
//! their author means them: `0.1 * 0.3` is three hundredths, although no double is. Functions count as
//! unrelated unknowns, so `sin² + cos² - 1` is not recognised, and nothing is taken for zero that differs
//! from it by more than the rounding of numbers.

use crate::graph::{Graph, Leaf, Node, NodeId, Unary};

use crate::hash::HashMap;

/// A Mersenne prime, the modulus.
const PRIME: u64 = (1 << 61) - 1;
/// The exponent of [`PRIME`]: `2^61 = 1` modulo the prime.
const EXPONENT: i32 = 61;
/// The number of random points: two, so that one unlucky value decides nothing.
pub(crate) const POINTS: usize = 2;
const SEEDS: [u64; POINTS] = [0x9e37_79b9_7f4a_7c15, 0xd1b5_4a32_d192_ed03];

/// The residues of nodes computed so far; `None` where a node has none.
pub(crate) type Residues = HashMap<NodeId, Option<u64>>;
/// The residues at each of the random points.
pub(crate) type PointResidues = [Residues; POINTS];

impl Graph {
    /// Whether the expression is zero as a rational function of its leaves, parameters and function values.
    pub(crate) fn vanishes(&mut self, id: NodeId) -> bool {
        if let Some(value) = self.as_constant(id) {
            return value == 0.0;
        }
        (0..POINTS).all(|point| self.residue(id, point) == Some(0))
    }

    /// Whether an expression certainly varies with a leaf: the leaf occurs in one place only, and none
    /// of its cofactors vanishes.
    pub(crate) fn surely_varies_with(&mut self, id: NodeId, leaf: Leaf) -> bool {
        let with = |parts: Vec<NodeId>| {
            let mut with = parts.into_iter().filter(|&part| self.depends_on(part, leaf));
            match (with.next(), with.next()) {
                (Some(part), None) => Some(part),
                _ => None,
            }
        };
        let (part, cofactors) = match self.node(id).clone() {
            Node::Leaf(own) => return own == leaf,
            Node::Sum(_, terms) => (
                with(terms.into_iter().map(|(term, _)| term).collect()),
                Vec::new(),
            ),
            Node::Product(factors) => {
                let factors: Vec<_> = factors.into_iter().map(|(factor, _)| factor).collect();
                (with(factors.clone()), factors)
            }
            Node::Unary(function, a) if function != Unary::Signum => (Some(a), Vec::new()),
            _ => (None, Vec::new()),
        };
        part.is_some_and(|part| self.surely_varies_with(part, leaf))
            && cofactors
                .into_iter()
                .all(|factor| Some(factor) == part || !self.vanishes(factor))
    }

    /// A key that is equal for expressions that are equal as rational functions, and the key of the opposite
    /// expression; `None` where the expression cannot be evaluated.
    pub(crate) fn fingerprint(&mut self, id: NodeId) -> Option<([u64; 2], [u64; 2])> {
        let key = [self.residue(id, 0)?, self.residue(id, 1)?];
        Some((key, key.map(|residue| (PRIME - residue) % PRIME)))
    }

    /// The expression's value modulo the prime at a random point; `None` where a denominator is zero or a number is not finite.
    pub(crate) fn residue(&mut self, id: NodeId, point: usize) -> Option<u64> {
        let mut known = std::mem::take(&mut self.residues[point]);
        let result = self.residue_with(id, point, &mut known);
        self.residues[point] = known;
        result
    }

    /// The value of [`Graph::residue`], with the residues of some nodes given: these are used, whatever the nodes are.
    pub(crate) fn residue_with(&self, id: NodeId, point: usize, known: &mut Residues) -> Option<u64> {
        if let Some(&known) = known.get(&id) {
            return known;
        }
        let result = match self.node(id) {
            Node::Constant(value) => residue_of_number(value.get()),
            Node::Sum(constant, terms) => {
                let mut sum = residue_of_number(constant.get());
                for &(term, c) in terms {
                    let term = self.residue_with(term, point, known);
                    sum = match (sum, residue_of_number(c.get()), term) {
                        (Some(sum), Some(c), Some(term)) => Some(add(sum, multiply(c, term))),
                        _ => None,
                    };
                }
                sum
            }
            Node::Product(factors) => {
                let mut product = Some(1);
                for &(factor, exponent) in factors {
                    let factor = self.residue_with(factor, point, known);
                    product = match (product, factor) {
                        (_, Some(0)) if exponent < 0 => None,
                        (Some(product), Some(factor)) => {
                            Some(multiply(product, signed_power(factor, exponent)))
                        }
                        _ => None,
                    };
                }
                product
            }
            _ => Some(random(
                SEEDS[point] ^ u64::from(id.0).wrapping_mul(0x2545_f491_4f6c_dd1d),
            )),
        };
        known.insert(id, result);
        result
    }
}

/// A power modulo the prime. The base is not zero if the exponent is negative.
pub(crate) fn signed_power(base: u64, exponent: i32) -> u64 {
    let base = if exponent < 0 { invert(base) } else { base };
    power(base, u64::from(exponent.unsigned_abs()))
}

/// The reciprocal modulo the prime of a number that is not zero.
pub(crate) fn invert(a: u64) -> u64 {
    power(a, PRIME - 2)
}

pub(crate) fn subtract(a: u64, b: u64) -> u64 {
    (a + (PRIME - b)) % PRIME
}

pub(crate) fn add(a: u64, b: u64) -> u64 {
    (a + b) % PRIME
}

pub(crate) fn multiply(a: u64, b: u64) -> u64 {
    // 2⁶¹ = 1 modulo the prime, so the upper bits are added to the lower ones
    let product = u128::from(a) * u128::from(b);
    let part = |bits: u128| u64::try_from(bits & u128::from(PRIME)).unwrap_or_default();
    add(part(product), part(product >> EXPONENT))
}

fn power(base: u64, exponent: u64) -> u64 {
    let (mut result, mut square, mut exponent) = (1, base, exponent);
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = multiply(result, square);
        }
        square = multiply(square, square);
        exponent >>= 1;
    }
    result
}

/// The largest denominator of a fraction that a double is taken for.
const LARGEST_DENOMINATOR: u64 = 1_000_000;

/// The largest error of a number that was computed from others, in units in the last place.
const ROUNDINGS: f64 = 8.0;

/// The residue of the number that a double stands for: a short fraction times a power of ten if there is one
/// within rounding, else the exact binary value. `None` if it is not finite.
fn residue_of_number(value: f64) -> Option<u64> {
    if !value.is_finite() {
        return None;
    }
    let magnitude = residue_of_fraction(value.abs()).unwrap_or_else(|| residue_of_dyadic(value.abs()));
    Some(if value < 0.0 {
        (PRIME - magnitude) % PRIME
    } else {
        magnitude
    })
}

/// The residue of the short fraction times a power of ten that rounds to a positive number; `None` if there
/// is none.
fn residue_of_fraction(value: f64) -> Option<u64> {
    // multiples of 1/16 are exact; beyond the bounds the powers of ten leave the range of doubles
    let is_exact = value < 1e15 && (value * 16.0).fract() == 0.0;
    if is_exact || !(1e-290..1e290).contains(&value) {
        return None;
    }
    let exponent = value.log10().floor();
    #[expect(clippy::cast_possible_truncation, reason = "between -290 and 290")]
    let exponent = exponent as i32;
    // both powers of ten are exact to a rounding or two
    let mantissa = if exponent < 0 {
        value * 10_f64.powi(-exponent)
    } else {
        value / 10_f64.powi(exponent)
    };
    // convergents of the continued fraction: `above` numerators, `below` denominators
    let (mut above, mut below) = ([1.0, 0.0], [0.0, 1.0]);
    let mut rest = mantissa;
    while below[0] <= LARGEST_DENOMINATOR as f64 {
        let whole = rest.floor();
        above = [whole * above[0] + above[1], above[0]];
        below = [whole * below[0] + below[1], below[0]];
        if below[0] > LARGEST_DENOMINATOR as f64 {
            return None;
        }
        let near = above[0] / below[0];
        if (near - mantissa).abs() <= ROUNDINGS * f64::EPSILON * mantissa {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "whole numbers below ten million"
            )]
            let [above, below] = [above[0], below[0]].map(|part| part as u64);
            let quotient = multiply(above, invert(below));
            return Some(multiply(quotient, signed_power(10, exponent)));
        }
        rest = 1.0 / (rest - whole);
    }
    None
}

/// The residue of a positive double as a dyadic rational.
fn residue_of_dyadic(value: f64) -> u64 {
    let bits = value.to_bits();
    let biased = i32::try_from(bits >> 52 & 0x7ff).unwrap_or_default();
    let fraction = bits & ((1 << 52) - 1);
    let (mantissa, exponent) = if biased == 0 {
        (fraction, -1074)
    } else {
        (fraction | 1 << 52, biased - 1075)
    };
    // 2⁶¹ = 1, so the exponent counts modulo 61
    let shift = u64::try_from(exponent.rem_euclid(EXPONENT)).unwrap_or_default();
    multiply(mantissa % PRIME, power(2, shift))
}

/// A pseudo-random number below the prime (splitmix64).
pub(crate) fn random(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) % PRIME
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Leaf, Unary};

    #[test]
    fn rational_identities_are_recognised() {
        let mut graph = Graph::new();
        let (x, y, z) = (
            graph.leaf(Leaf::Q(0)),
            graph.leaf(Leaf::Q(1)),
            graph.leaf(Leaf::V(0)),
        );
        // (x + y)/z - x/z - y/z
        let sum = graph.add(x, y);
        let (whole, first, second) = (graph.div(sum, z), graph.div(x, z), graph.div(y, z));
        let zero = graph.linear(0.0, &[(whole, 1.0), (first, -1.0), (second, -1.0)]);
        assert!(!graph.is_zero(zero) && graph.vanishes(zero));
        // (x² - y²)/(x - y) - (x + y)
        let (squares, difference) = ([graph.powi(x, 2), graph.powi(y, 2)], graph.sub(x, y));
        let squares = graph.sub(squares[0], squares[1]);
        let quotient = graph.div(squares, difference);
        let zero = graph.sub(quotient, sum);
        assert!(graph.vanishes(zero));
        let other = graph.linear(1e-300, &[(zero, 1.0)]);
        assert!(!graph.vanishes(other));
    }

    #[test]
    fn functions_are_unknowns() {
        let mut graph = Graph::new();
        let x = graph.leaf(Leaf::Q(0));
        let sine = graph.unary(Unary::Sin, x);
        let (twice, sum) = (graph.scale(2.0, sine), graph.add(sine, x));
        let zero = graph.linear(0.0, &[(twice, 0.5), (sum, -1.0), (x, 1.0)]);
        assert!(graph.vanishes(zero));
        assert!(!graph.vanishes(sine));
    }

    #[test]
    fn numbers_are_exact() {
        for value in [1.0, -3.0, 0.1, 1e-300, 5e-324, 1e300, -0.75] {
            let (a, b) = (
                residue_of_number(value).unwrap(),
                residue_of_number(-value).unwrap(),
            );
            assert_eq!(add(a, b), 0, "{value}");
        }
        assert_eq!(multiply(residue_of_number(0.25).unwrap(), 4), 1);
        // numbers that are rounded stand for the decimal that is meant
        for (value, meant) in [
            (0.1 + 0.2, 0.3),
            (0.1 * 0.1, 0.01),
            (1.1 * 1.1, 1.21),
            (9.81 * 0.3e-12, 2.943e-12),
            (2.0 * 0.6, 1.2),
        ] {
            assert_eq!(residue_of_number(value), residue_of_number(meant), "{meant}");
        }
        assert_eq!(multiply(residue_of_number(1.2).unwrap(), 10), 12);
        assert_eq!(
            multiply(residue_of_number(6.02e23).unwrap(), 50),
            residue_of_number(3.01e25).unwrap()
        );
        // no other number does
        assert_ne!(residue_of_number(0.3), residue_of_number(0.3 + 1e-14));
        assert_ne!(
            residue_of_number(core::f64::consts::PI),
            residue_of_number(355.0 / 113.0)
        );
    }
}
