//! The discretization maps: closures of the nodes, whose values are vectors.

use proc_macro2::Ident;
use syn::visit::{self, Visit};
use syn::{Expr, ExprCall, ExprClosure, Pat, ReturnType};

use super::Lowering;
use crate::ast::{Declaration, Map, MapRule};
use crate::errors::Reported;
use crate::graph::{Leaf, NodeId};
use crate::names::Binding;
use crate::parse::{bare, plain_name};

impl Lowering<'_> {
    /// The points of the first order map whose mean is taken.
    pub(super) fn pairs(&mut self, map: &Map) -> Result<Vec<[Vec<NodeId>; 2]>, Reported> {
        Ok(match &map.rule {
            MapRule::Closure(closure) => vec![self.map(&map.keyword, closure)?],
            MapRule::Paper => self.paper_pairs(),
            MapRule::Midpoint => self.midpoint_pairs(),
            MapRule::Trapezoid => vec![self.pair([1.0, 0.0]), self.pair([0.0, 1.0])],
        })
    }

    /// The paper's map of pairs, `(q0, (q1 - q0) / h)`.
    pub(super) fn paper_pairs(&mut self) -> Vec<[Vec<NodeId>; 2]> {
        vec![self.pair([1.0, 0.0])]
    }

    /// The chord and the middle of both ends.
    fn midpoint_pairs(&mut self) -> Vec<[Vec<NodeId>; 2]> {
        vec![self.pair([0.5, 0.5])]
    }

    /// The map where none is declared, of order 2 always.
    ///
    /// The paper's is where `L = T(v) - V(q)`: its `L_d` then differs from the trapezoid's by what telescopes. Where the momentum
    /// depends on the position, and where a row is imposed on a leg, a point at one end of it is of order 1.
    pub(super) fn default_pairs(
        &mut self,
        declaration: &Declaration,
        lagrangian: NodeId,
    ) -> Vec<[Vec<NodeId>; 2]> {
        let on_legs = !declaration.nonholonomic.is_absent() || mentions_legs(declaration);
        if on_legs || self.momentum_varies(lagrangian) {
            self.midpoint_pairs()
        } else {
            self.paper_pairs()
        }
    }

    /// Whether `∂L/∂v` depends on the position, as with a mass matrix that does.
    fn momentum_varies(&mut self, lagrangian: NodeId) -> bool {
        let n = self.coordinates.len();
        // on the side: a question leaves no trace in the code
        let mut graph = self.graph.clone();
        (0..n).any(|i| {
            let momentum = graph.derivative(lagrangian, Leaf::V(i));
            (0..n).any(|j| {
                let slope = graph.derivative(momentum, Leaf::Q(j));
                !graph.vanishes(slope)
            })
        })
    }

    /// The chord at a mean of both ends.
    fn pair(&mut self, [first, second]: [f64; 2]) -> [Vec<NodeId>; 2] {
        let h = self.graph.leaf(Leaf::H);
        let point = (0..self.coordinates.len()).map(|i| {
            let (x0, x1) = (self.graph.leaf(Leaf::X0(i)), self.graph.leaf(Leaf::X1(i)));
            let q = self.graph.linear(0.0, &[(x0, first), (x1, second)]);
            let chord = self.graph.sub(x1, x0);
            (q, self.graph.div(chord, h))
        });
        let (q, v) = point.unzip();
        [q, v]
    }

    /// A map of three nodes; `None` for the paper's.
    pub(super) fn triple(&mut self, map: &Map) -> Result<Option<[Vec<NodeId>; 3]>, Reported> {
        Ok(match &map.rule {
            MapRule::Closure(closure) => Some(self.map(&map.keyword, closure)?),
            MapRule::Midpoint => Some(self.around([0.25, 0.5, 0.25])),
            MapRule::Paper | MapRule::Trapezoid => None,
        })
    }

    /// The paper's second order map, `(q1, (q2 - q0) / 2h, (q2 - 2 q1 + q0) / h²)`.
    pub(super) fn paper_triple(&mut self) -> [Vec<NodeId>; 3] {
        self.around([0.0, 1.0, 0.0])
    }

    /// The central differences at a mean of the nodes.
    fn around(&mut self, [first, second, third]: [f64; 3]) -> [Vec<NodeId>; 3] {
        let h = self.graph.leaf(Leaf::H);
        let [mut q, mut v, mut a] = [const { Vec::new() }; 3];
        for i in 0..self.coordinates.len() {
            let [x0, x1, x2] = [Leaf::X0(i), Leaf::X1(i), Leaf::X2(i)].map(|leaf| self.graph.leaf(leaf));
            q.push(self.graph.linear(0.0, &[(x0, first), (x1, second), (x2, third)]));
            let span = self.graph.linear(0.0, &[(x2, 0.5), (x0, -0.5)]);
            v.push(self.graph.div(span, h));
            let second_difference = self.graph.linear(0.0, &[(x0, 1.0), (x1, -2.0), (x2, 1.0)]);
            a.push(self.graph.product(&[(second_difference, 1), (h, -2)]));
        }
        [q, v, a]
    }

    /// The `K` vectors of a map: `q, v` of the first order map (of two nodes), `q, v, a` of the others (of three).
    fn map<const K: usize>(
        &mut self,
        keyword: &Ident,
        closure: &ExprClosure,
    ) -> Result<[Vec<NodeId>; K], Reported> {
        let expected = if K == 2 {
            "|q0, q1| (q, v)"
        } else {
            "|q0, q1, q2| (q, v, a)"
        };
        let outer = self.scope.len();
        let mut wrong = None;
        if closure.inputs.len() != K {
            let message = format!(
                "expected {K} nodes, `{keyword} = {expected};`, found {}",
                closure.inputs.len()
            );
            wrong = Some(if closure.inputs.is_empty() {
                self.errors.at(keyword, message)
            } else {
                self.errors.at(&closure.inputs, message)
            });
        }
        if let ReturnType::Type(_, ty) = &closure.output {
            wrong = Some(self.errors.at(
                ty,
                "no type is written here: a map's values are vectors of numbers",
            ));
        }
        for (index, input) in closure.inputs.iter().enumerate() {
            match node_name(input) {
                Some(name) => {
                    let defined = self.scope.define(name, Binding::Node(index), self.errors);
                    wrong = defined.err().or(wrong);
                }
                None => wrong = Some(self.errors.at(input, "expected a plain name of a node")),
            }
        }
        // with another number of nodes the body would bring a second error for the same mistake
        let value = if let Some(reported) = wrong {
            Err(reported)
        } else {
            self.component = Some(0);
            self.vectors(&closure.body, keyword, expected)
        };
        self.component = None;
        self.scope.truncate(outer);
        value
    }

    /// `(q, v)` or `(q, v, a)`, perhaps at the end of a block.
    fn vectors<const K: usize>(
        &mut self,
        body: &Expr,
        keyword: &Ident,
        expected: &str,
    ) -> Result<[Vec<NodeId>; K], Reported> {
        match bare(body) {
            Expr::Block(block) if block.label.is_none() => self.block(&block.block, |lowering, last| {
                lowering.vectors(last, keyword, expected)
            }),
            Expr::Tuple(tuple) if tuple.elems.len() == K => {
                let vectors: Vec<_> = tuple.elems.iter().map(|element| self.vector(element)).collect();
                let vectors: Vec<_> = vectors.into_iter().collect::<Result<_, _>>()?;
                vectors.try_into().map_err(|_| {
                    self.errors
                        .at(tuple, format!("expected `{keyword} = {expected};`"))
                })
            }
            Expr::Tuple(tuple) => Err(self.errors.at(
                tuple,
                format!(
                    "expected {K} vectors, `{keyword} = {expected};`, found {}",
                    tuple.elems.len()
                ),
            )),
            other => Err(self.errors.at(
                other,
                format!("expected a tuple of {K} vectors, `{keyword} = {expected};`"),
            )),
        }
    }

    /// The components of a vector: an expression that holds for each of them, or a tuple of them.
    pub(super) fn vector(&mut self, expr: &Expr) -> Result<Vec<NodeId>, Reported> {
        let outer = self.component;
        let value = self.components(expr);
        self.component = outer;
        value
    }

    fn components(&mut self, expr: &Expr) -> Result<Vec<NodeId>, Reported> {
        match bare(expr) {
            Expr::Tuple(_) => self.entries(expr),
            // the list of a single array
            Expr::Array(_) | Expr::Repeat(_) | Expr::Closure(_) if self.groups.len() == 1 => {
                self.entries(expr)
            }
            Expr::Block(block) if block.label.is_none() => self.block(&block.block, Self::components),
            // a mistake in one component is a mistake in all of them: the first one ends it
            other => (0..self.coordinates.len())
                .map(|i| {
                    self.component = Some(i);
                    self.expr(other)
                })
                .collect(),
        }
    }
}

/// Whether a discrete statement takes the value of an expression on a leg, `leg(e, 0)`.
fn mentions_legs(declaration: &Declaration) -> bool {
    struct Search(bool);
    impl<'ast> Visit<'ast> for Search {
        fn visit_expr_call(&mut self, call: &'ast ExprCall) {
            self.0 |= plain_name(&call.func).is_some_and(|name| name == "leg");
            visit::visit_expr_call(self, call);
        }
    }
    let mut search = Search(false);
    if let Some(scalar) = declaration.discrete_lagrangian.given() {
        search.visit_expr(&scalar.value);
    }
    for row in declaration
        .discrete_kinematic
        .given()
        .iter()
        .flat_map(|part| &part.rows)
    {
        search.visit_expr(row);
    }
    search.0
}

fn node_name(pattern: &Pat) -> Option<&Ident> {
    match pattern {
        Pat::Ident(name) if name.by_ref.is_none() && name.mutability.is_none() && name.subpat.is_none() => {
            Some(&name.ident)
        }
        _ => None,
    }
}
