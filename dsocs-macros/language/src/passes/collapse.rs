//! Affine expressions, gathered.
//!
//! Much of a residual is affine in the unknowns: velocities, momenta, `vₓ a_y - aₓ v_y` (its quadratic terms cancel).
//! Written as `c₀ + Σ cⱼ zⱼ` such an expression costs one product and one sum an unknown in the iteration, and its
//! coefficients are known when the step begins. The same holds one stage earlier: what the step's leg and functions of
//! it enter linearly has coefficients that are known when the run begins, and a coefficient that is identically zero
//! takes its term along. Only affine expressions are gathered: multiplying out a square of the velocity would turn a sum
//! of positive terms into a cancellation.

use std::collections::{BTreeMap, HashMap};

use crate::graph::{Graph, Leaf, Node, NodeId};

/// Polynomials with more terms are left alone.
const MOST_TERMS: usize = 64;
/// A product of two affine expressions may turn out affine after all.
const HIGHEST_DEGREE: u32 = 2;

/// A polynomial in the variables: exponents by variable, and the coefficient.
type Polynomial = BTreeMap<Vec<(NodeId, u32)>, NodeId>;

/// In what an expression is to be affine.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Variables {
    /// The unknowns of the step.
    Unknowns,
    /// The components of the leg and functions of them.
    Leg,
    /// Positions, velocities, accelerations and functions of them.
    Motion,
}

/// Rewrites expressions so that everything affine in the variables is in the form `c₀ + Σ cⱼ xⱼ`.
pub(crate) struct Collapse<'g> {
    graph: &'g mut Graph,
    variables: Variables,
    polynomials: HashMap<NodeId, Option<Polynomial>>,
    done: HashMap<NodeId, NodeId>,
}

impl<'g> Collapse<'g> {
    pub(crate) fn new(graph: &'g mut Graph, variables: Variables) -> Self {
        Self {
            graph,
            variables,
            polynomials: HashMap::new(),
            done: HashMap::new(),
        }
    }

    /// Whether an expression contains variables.
    fn varies(&self, id: NodeId) -> bool {
        self.graph.leaves(id).any(|leaf| match self.variables {
            Variables::Unknowns => matches!(leaf, Leaf::Z(_)),
            Variables::Leg => matches!(leaf, Leaf::N(_) | Leaf::D(_)),
            Variables::Motion => matches!(leaf, Leaf::Q(_) | Leaf::V(_) | Leaf::A(_) | Leaf::Lambda(_)),
        })
    }

    /// Whether an expression depends on what is known only after the variables.
    fn beyond(&self, id: NodeId) -> bool {
        self.variables == Variables::Leg
            && self
                .graph
                .leaves(id)
                .any(|leaf| matches!(leaf, Leaf::Z(_) | Leaf::E(_)))
    }

    fn rewrite_parts(&mut self, id: NodeId) -> NodeId {
        let parts: Vec<_> = self
            .graph
            .parts(id)
            .into_iter()
            .map(|part| self.rewrite(part))
            .collect();
        self.graph.rebuild(id, &parts)
    }

    /// The expression with its affine parts gathered.
    pub(crate) fn rewrite(&mut self, id: NodeId) -> NodeId {
        if let Some(&done) = self.done.get(&id) {
            return done;
        }
        let result = if !self.varies(id) {
            id
        } else if let Some(affine) = self.affine(id) {
            affine
        } else if let Node::Sum(constant, terms) = self.graph.node(id).clone() {
            // several terms may be affine together
            let mut whole: Polynomial = BTreeMap::new();
            let mut rest = Vec::new();
            for (term, c) in terms {
                match self.polynomial(term) {
                    Some(polynomial) => {
                        for (monomial, coefficient) in polynomial {
                            let coefficient = self.graph.scale(c.get(), coefficient);
                            add(self.graph, &mut whole, monomial, coefficient);
                        }
                        rest.push((term, c.get(), true));
                    }
                    None => rest.push((term, c.get(), false)),
                }
            }
            let mut sum = Vec::new();
            if degree(&whole) <= 1 {
                sum.push((self.affine_sum(&whole), 1.0));
                rest.retain(|&(_, _, polynomial)| !polynomial);
            } else {
                let (affine, others): (Vec<_>, Vec<_>) = rest
                    .into_iter()
                    .partition(|&(term, _, polynomial)| polynomial && self.is_affine(term));
                let affine: Vec<_> = affine.iter().map(|&(term, c, _)| (term, c)).collect();
                let affine = self.graph.linear(0.0, &affine);
                let affine = self.affine(affine).unwrap_or(affine);
                sum.push((affine, 1.0));
                rest = others;
            }
            for (term, c, _) in rest {
                sum.push((self.rewrite(term), c));
            }
            self.graph.linear(constant.get(), &sum)
        } else {
            self.rewrite_parts(id)
        };
        self.done.insert(id, result);
        result
    }

    fn is_affine(&mut self, id: NodeId) -> bool {
        self.polynomial(id)
            .is_some_and(|polynomial| degree(&polynomial) <= 1)
    }

    fn affine(&mut self, id: NodeId) -> Option<NodeId> {
        let polynomial = self.polynomial(id)?;
        (degree(&polynomial) <= 1).then(|| self.affine_sum(&polynomial))
    }

    fn affine_sum(&mut self, polynomial: &Polynomial) -> NodeId {
        let mut terms = Vec::new();
        for (monomial, &coefficient) in polynomial {
            let term = match monomial.first() {
                Some(&(variable, _)) => self.graph.mul(coefficient, variable),
                None => coefficient,
            };
            terms.push(term);
        }
        self.graph.sum(&terms)
    }

    /// The expression as a polynomial in the unknowns, if it is one of low degree.
    fn polynomial(&mut self, id: NodeId) -> Option<Polynomial> {
        if let Some(known) = self.polynomials.get(&id) {
            return known.clone();
        }
        let result = self
            .expand(id)
            .filter(|polynomial| polynomial.len() <= MOST_TERMS && degree(polynomial) <= HIGHEST_DEGREE);
        self.polynomials.insert(id, result.clone());
        result
    }

    fn expand(&mut self, id: NodeId) -> Option<Polynomial> {
        if self.beyond(id) {
            return None;
        }
        if !self.varies(id) {
            return Some(BTreeMap::from([(Vec::new(), id)]));
        }
        match self.graph.node(id).clone() {
            Node::Sum(constant, terms) => {
                let mut sum = BTreeMap::new();
                if constant.get() != 0.0 {
                    let constant = self.graph.constant(constant.get());
                    add(self.graph, &mut sum, Vec::new(), constant);
                }
                for (term, c) in terms {
                    for (monomial, coefficient) in self.polynomial(term)? {
                        let coefficient = self.graph.scale(c.get(), coefficient);
                        add(self.graph, &mut sum, monomial, coefficient);
                    }
                }
                Some(sum)
            }
            Node::Product(factors) => {
                let one = self.graph.constant(1.0);
                let mut product: Polynomial = BTreeMap::from([(Vec::new(), one)]);
                for (factor, exponent) in factors {
                    if !self.varies(factor) {
                        let factor = self.graph.powi(factor, exponent);
                        for coefficient in product.values_mut() {
                            *coefficient = self.graph.mul(*coefficient, factor);
                        }
                        continue;
                    }
                    let factor = self.polynomial(factor)?;
                    for _ in 0..u32::try_from(exponent).ok()? {
                        product = multiply(self.graph, &product, &factor)?;
                    }
                }
                Some(product)
            }
            Node::Leaf(_) => Some(self.variable(id)),
            // a function of the unknowns is no polynomial; a function of the leg is a variable like the leg
            _ if self.variables == Variables::Unknowns => None,
            _ => {
                let function = self.rewrite_parts(id);
                Some(self.variable(function))
            }
        }
    }

    fn variable(&mut self, id: NodeId) -> Polynomial {
        let one = self.graph.constant(1.0);
        BTreeMap::from([(vec![(id, 1)], one)])
    }
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
