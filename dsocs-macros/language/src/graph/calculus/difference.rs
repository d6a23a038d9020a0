//! The change of an expression between two points, as an expression in the change of its leaves.
//!
//! `D₁L_d(q1,q2) + D₂L_d(q0,q1)` is the difference of two momenta that agree to `O(h)`. Subtracting their values
//! loses a factor of `1/h` in the digits of the second difference; carrying the change through every operation loses
//! nothing: `Δ(m v) = m Δv`, `Δ sin x = cos x₋ sin Δx - 2 sin x₋ sin²(Δx/2)`.

use crate::graph::{Graph, Leaf, Node, NodeId, Unary};

use crate::hash::HashMap;

/// The values of an expression at two points, and their difference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    /// At the first point.
    pub(crate) before: NodeId,
    /// At the second point.
    pub(crate) after: NodeId,
    /// `after - before`, formed without cancellation.
    pub(crate) delta: NodeId,
}

impl Graph {
    /// The change of `id`, given the changes of its leaves. `late(leaf)` holds for the leaves of the result that are known last: products
    /// keep them out of all but one term. With `whole`, factors that do not change are taken out of the change.
    pub(crate) fn difference(
        &mut self,
        id: NodeId,
        leaves: &HashMap<Leaf, Change>,
        late: &dyn Fn(Leaf) -> bool,
        whole: bool,
        done: &mut HashMap<NodeId, Change>,
    ) -> Change {
        if let Some(&change) = done.get(&id) {
            return change;
        }
        let zero = self.constant(0.0);
        let change = match &*self.shared_node(id) {
            Node::Leaf(leaf) => leaves.get(leaf).copied().unwrap_or(Change {
                before: id,
                after: id,
                delta: zero,
            }),
            Node::Constant(_) | Node::Param(_) => Change {
                before: id,
                after: id,
                delta: zero,
            },
            node => {
                let parts: Vec<Change> = self
                    .parts(id)
                    .into_iter()
                    .map(|part| self.difference(part, leaves, late, whole, done))
                    .collect();
                let before: Vec<_> = parts.iter().map(|part| part.before).collect();
                let after: Vec<_> = parts.iter().map(|part| part.after).collect();
                let before = self.rebuild(id, &before);
                let after = self.rebuild(id, &after);
                let delta = if before == after {
                    zero
                } else {
                    match node {
                        Node::Sum(_, terms) => {
                            let terms: Vec<_> = parts
                                .iter()
                                .zip(terms)
                                .map(|(part, term)| (part.delta, term.1.get()))
                                .collect();
                            self.linear(0.0, &terms)
                        }
                        Node::Product(factors) => {
                            let powers: Vec<_> = parts
                                .iter()
                                .zip(factors)
                                .map(|(&part, factor)| self.power_change(part, factor.1))
                                .collect();
                            // with constant factors taken out, several sums share the change
                            let (fixed, moving): (Vec<_>, Vec<_>) =
                                powers.into_iter().partition(|power| whole && power.delta == zero);
                            let change = self.product_change(moving, late);
                            let fixed = fixed.iter().map(|fixed| (fixed.after, 1));
                            let factors: Vec<_> = fixed.chain([(change, 1)]).collect();
                            self.product(&factors)
                        }
                        Node::Unary(op, _) => self.unary_change(*op, parts[0], before, after),
                        _ => self.sub(after, before),
                    }
                };
                Change { before, after, delta }
            }
        };
        done.insert(id, change);
        change
    }

    /// `Δ(x^n)`.
    fn power_change(&mut self, x: Change, exponent: i32) -> Change {
        let (before, after) = (self.powi(x.before, exponent), self.powi(x.after, exponent));
        if before == after {
            return Change {
                before,
                after,
                delta: self.constant(0.0),
            };
        }
        // x₊ⁿ - x₋ⁿ = Δx (x₊ⁿ⁻¹ + x₊ⁿ⁻² x₋ + … + x₋ⁿ⁻¹)
        let count = exponent.abs();
        let terms: Vec<_> = (0..count)
            .map(|k| self.product(&[(x.after, count - 1 - k), (x.before, k)]))
            .collect();
        let mean = self.sum(&terms);
        let mut delta = self.mul(x.delta, mean);
        if exponent < 0 {
            // 1/b - 1/a = -(b - a)/(a b)
            let quotient = self.product(&[(delta, 1), (x.after, exponent), (x.before, exponent)]);
            delta = self.neg(quotient);
        }
        Change { before, after, delta }
    }

    /// `Δ(f g) = Δf g₋ + f₊ Δg`, where `f` are the factors known first.
    fn product_change(&mut self, mut factors: Vec<Change>, late: &dyn Fn(Leaf) -> bool) -> NodeId {
        factors.sort_by_key(|factor| self.leaves(factor.after).any(late));
        let mut product: Option<Change> = None;
        for g in factors {
            product = Some(match product {
                None => g,
                Some(f) => {
                    let (first, second) = (self.mul(f.delta, g.before), self.mul(f.after, g.delta));
                    Change {
                        before: self.mul(f.before, g.before),
                        after: self.mul(f.after, g.after),
                        delta: self.add(first, second),
                    }
                }
            });
        }
        match product {
            Some(product) => product.delta,
            None => self.constant(0.0),
        }
    }

    fn unary_change(&mut self, op: Unary, x: Change, before: NodeId, after: NodeId) -> NodeId {
        let half = self.scale(0.5, x.delta);
        let middle = self.linear(0.0, &[(x.before, 0.5), (x.after, 0.5)]);
        // the product `2 f(middle) g(Δ/2)`
        let twice = |graph: &mut Self, f: Unary, g: Unary, sign: f64| {
            let (f, g) = (graph.unary(f, middle), graph.unary(g, half));
            let product = graph.mul(f, g);
            graph.scale(2.0 * sign, product)
        };
        match op {
            Unary::Sqrt => {
                let sum = self.add(before, after);
                self.div(x.delta, sum)
            }
            Unary::Cbrt => {
                let terms = [self.powi(before, 2), self.mul(before, after), self.powi(after, 2)];
                let sum = self.sum(&terms);
                self.div(x.delta, sum)
            }
            Unary::Exp => twice(self, Unary::Exp, Unary::Sinh, 1.0),
            Unary::Sin | Unary::Cos => self.sine_change(op, x.before, half),
            Unary::Sinh => twice(self, Unary::Cosh, Unary::Sinh, 1.0),
            Unary::Cosh => twice(self, Unary::Sinh, Unary::Sinh, 1.0),
            Unary::Tanh => {
                let product = self.mul(before, after);
                let rest = self.linear(1.0, &[(product, -1.0)]);
                let tanh = self.unary(Unary::Tanh, x.delta);
                self.mul(tanh, rest)
            }
            Unary::Ln => {
                let ratio = self.div(x.delta, x.before);
                self.unary(Unary::Ln1p, ratio)
            }
            _ => self.sub(after, before),
        }
    }

    /// The change of a sine or cosine of `x` (`before`) when `x` grows by twice the angle `half`. With `s`,
    /// `c` the sine and cosine of `half` it is `2 s c cos x - 2 s² sin x` or `-2 s c sin x - 2 s² cos x`: the
    /// functions of `x` are known before the change.
    pub(crate) fn sine_change(&mut self, op: Unary, before: NodeId, half: NodeId) -> NodeId {
        let (s, c) = (self.unary(Unary::Sin, half), self.unary(Unary::Cos, half));
        let (sine, cosine) = (self.unary(Unary::Sin, before), self.unary(Unary::Cos, before));
        let (own, other, sign) = match op {
            Unary::Sin => (sine, cosine, 2.0),
            _ => (cosine, sine, -2.0),
        };
        let across = self.product(&[(other, 1), (s, 1), (c, 1)]);
        let along = self.product(&[(own, 1), (s, 2)]);
        self.linear(0.0, &[(across, sign), (along, -2.0)])
    }
}
