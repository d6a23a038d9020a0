//! Affine expressions gathered as `c₀ + Σ cⱼ xⱼ`.
//!
//! Much of a residual is affine in the unknowns: velocities, momenta, `vₓ a_y - aₓ v_y` (its quadratic terms
//! cancel). Written as `c₀ + Σ cⱼ zⱼ`, such an expression costs the iteration one product and one sum per
//! unknown, and its coefficients are known when the step begins. The same holds one stage earlier:
//! expressions that are affine in the leg and in functions of it have coefficients that are known when the
//! run begins, and a term with a coefficient that is identically zero disappears. Only affine expressions are
//! gathered: multiplying out a square of the velocity would turn a sum of positive terms into a cancellation.

use std::collections::BTreeMap;

use crate::graph::{Bits, Graph, Leaf, Memory, Node, NodeId, Pass};
use crate::hash::HashMap;

/// The most terms of a polynomial that is gathered.
const MOST_TERMS: usize = 64;
/// The highest degree of intermediate polynomials: a product of two affine expressions may turn out affine
/// after all.
const HIGHEST_DEGREE: u32 = 2;

/// A polynomial in the variables: for each monomial, its variables with exponents, the coefficient.
type Polynomial = BTreeMap<Vec<(NodeId, u32)>, NodeId>;

/// The variables in which expressions are gathered.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Variables {
    /// The unknowns of the step.
    Unknowns,
    /// The components of the leg, and functions of them.
    Leg,
    /// Positions, velocities, accelerations and multipliers, and functions of them.
    Motion,
}

/// The pass that writes every expression affine in the variables as `c₀ + Σ cⱼ xⱼ`.
pub(super) struct Collapse {
    variables: Variables,
    polynomials: HashMap<NodeId, Option<Polynomial>>,
    memory: Memory,
}

impl Pass for Collapse {
    fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    fn before(&mut self, graph: &mut Graph, id: NodeId) -> Option<NodeId> {
        if !self.varies(graph, id) {
            return Some(id);
        }
        if let Some(affine) = self.affine(graph, id) {
            return Some(affine);
        }
        match graph.node(id).clone() {
            Node::Sum(constant, terms) => Some(self.sum(graph, constant.get(), &terms)),
            _ => None,
        }
    }
}

impl Collapse {
    /// The pass for some variables.
    pub(super) fn new(variables: Variables) -> Self {
        Self {
            variables,
            polynomials: HashMap::default(),
            memory: Memory::default(),
        }
    }

    /// Whether an expression depends on the variables.
    fn varies(&self, graph: &Graph, id: NodeId) -> bool {
        graph.leaves(id).any(|leaf| match self.variables {
            Variables::Unknowns => matches!(leaf, Leaf::Z(_)),
            Variables::Leg => matches!(leaf, Leaf::N(_) | Leaf::D(_) | Leaf::P(_)),
            Variables::Motion => matches!(leaf, Leaf::Q(_) | Leaf::V(_) | Leaf::A(_) | Leaf::Lambda(_)),
        })
    }

    /// Whether an expression depends on leaves that are known only after the variables.
    fn beyond(&self, graph: &Graph, id: NodeId) -> bool {
        self.variables == Variables::Leg
            && graph
                .leaves(id)
                .any(|leaf| matches!(leaf, Leaf::Z(_) | Leaf::E(_)))
    }

    /// A sum that is not affine as a whole, with those of its terms gathered that are affine together.
    fn sum(&mut self, graph: &mut Graph, constant: f64, terms: &[(NodeId, Bits)]) -> NodeId {
        let mut whole: Polynomial = BTreeMap::new();
        let mut rest = Vec::new();
        for &(term, c) in terms {
            match self.polynomial(graph, term) {
                Some(polynomial) => {
                    for (monomial, coefficient) in polynomial {
                        let coefficient = graph.scale(c.get(), coefficient);
                        add(graph, &mut whole, monomial, coefficient);
                    }
                    rest.push((term, c.get(), true));
                }
                None => rest.push((term, c.get(), false)),
            }
        }
        let mut sum = Vec::new();
        if degree(&whole) <= 1 {
            sum.push((Self::affine_sum(graph, &whole), 1.0));
            rest.retain(|&(_, _, polynomial)| !polynomial);
        } else {
            let (affine, others): (Vec<_>, Vec<_>) = rest
                .into_iter()
                .partition(|&(term, _, polynomial)| polynomial && self.is_affine(graph, term));
            let affine: Vec<_> = affine.iter().map(|&(term, c, _)| (term, c)).collect();
            let affine = graph.linear(0.0, &affine);
            let affine = self.affine(graph, affine).unwrap_or(affine);
            sum.push((affine, 1.0));
            rest = others;
        }
        for (term, c, _) in rest {
            sum.push((graph.rewrite(term, self), c));
        }
        graph.linear(constant, &sum)
    }

    fn is_affine(&mut self, graph: &mut Graph, id: NodeId) -> bool {
        self.polynomial(graph, id)
            .is_some_and(|polynomial| degree(&polynomial) <= 1)
    }

    fn affine(&mut self, graph: &mut Graph, id: NodeId) -> Option<NodeId> {
        let polynomial = self.polynomial(graph, id)?;
        (degree(&polynomial) <= 1).then(|| Self::affine_sum(graph, &polynomial))
    }

    fn affine_sum(graph: &mut Graph, polynomial: &Polynomial) -> NodeId {
        let mut terms = Vec::new();
        for (monomial, &coefficient) in polynomial {
            let term = match monomial.first() {
                Some(&(variable, _)) => graph.mul(coefficient, variable),
                None => coefficient,
            };
            terms.push(term);
        }
        graph.sum(&terms)
    }

    /// The expression as a polynomial in the variables; `None` if it is not one of low degree.
    fn polynomial(&mut self, graph: &mut Graph, id: NodeId) -> Option<Polynomial> {
        if let Some(known) = self.polynomials.get(&id) {
            return known.clone();
        }
        let result = self
            .expand(graph, id)
            .filter(|polynomial| polynomial.len() <= MOST_TERMS && degree(polynomial) <= HIGHEST_DEGREE);
        self.polynomials.insert(id, result.clone());
        result
    }

    fn expand(&mut self, graph: &mut Graph, id: NodeId) -> Option<Polynomial> {
        if self.beyond(graph, id) {
            return None;
        }
        if !self.varies(graph, id) {
            return Some(BTreeMap::from([(Vec::new(), id)]));
        }
        match graph.node(id).clone() {
            Node::Sum(constant, terms) => {
                let mut sum = BTreeMap::new();
                if constant.get() != 0.0 {
                    let constant = graph.constant(constant.get());
                    add(graph, &mut sum, Vec::new(), constant);
                }
                for (term, c) in terms {
                    for (monomial, coefficient) in self.polynomial(graph, term)? {
                        let coefficient = graph.scale(c.get(), coefficient);
                        add(graph, &mut sum, monomial, coefficient);
                    }
                }
                Some(sum)
            }
            Node::Product(factors) => {
                let one = graph.constant(1.0);
                let mut product: Polynomial = BTreeMap::from([(Vec::new(), one)]);
                for (factor, exponent) in factors {
                    if !self.varies(graph, factor) {
                        let factor = graph.powi(factor, exponent);
                        for coefficient in product.values_mut() {
                            *coefficient = graph.mul(*coefficient, factor);
                        }
                        continue;
                    }
                    let factor = self.polynomial(graph, factor)?;
                    for _ in 0..u32::try_from(exponent).ok()? {
                        product = multiply(graph, &product, &factor)?;
                    }
                }
                Some(product)
            }
            Node::Leaf(_) => Some(variable(graph, id)),
            // a function of the unknowns is no polynomial; a function of the leg counts as a variable
            _ if self.variables == Variables::Unknowns => None,
            _ => {
                let function = graph.rewrite_parts(id, self);
                Some(variable(graph, function))
            }
        }
    }
}

fn variable(graph: &mut Graph, id: NodeId) -> Polynomial {
    let one = graph.constant(1.0);
    BTreeMap::from([(vec![(id, 1)], one)])
}

fn degree(polynomial: &Polynomial) -> u32 {
    polynomial
        .keys()
        .map(|monomial| monomial.iter().map(|&(_, exponent)| exponent).sum())
        .max()
        .unwrap_or(0)
}

fn add(graph: &mut Graph, polynomial: &mut Polynomial, monomial: Vec<(NodeId, u32)>, coefficient: NodeId) {
    let sum = match polynomial.get(&monomial) {
        Some(&present) => graph.add(present, coefficient),
        None => coefficient,
    };
    if graph.vanishes(sum) {
        polynomial.remove(&monomial);
    } else {
        polynomial.insert(monomial, sum);
    }
}

fn multiply(graph: &mut Graph, a: &Polynomial, b: &Polynomial) -> Option<Polynomial> {
    if a.len() * b.len() > MOST_TERMS * MOST_TERMS || degree(a) + degree(b) > HIGHEST_DEGREE {
        return None;
    }
    let mut product = BTreeMap::new();
    for (first, &c) in a {
        for (second, &d) in b {
            let mut exponents: BTreeMap<NodeId, u32> = first.iter().copied().collect();
            for &(j, exponent) in second {
                *exponents.entry(j).or_insert(0) += exponent;
            }
            let coefficient = graph.mul(c, d);
            add(graph, &mut product, exponents.into_iter().collect(), coefficient);
        }
    }
    Some(product)
}
