//! The discretization maps: closures of the nodes, whose values are vectors.

use proc_macro2::Ident;
use syn::visit::{self, Visit};
use syn::{Expr, ExprCall, ExprClosure, Pat, ReturnType};

use crate::graph::{Leaf, NodeId};
use crate::lower::lowering::{Lowered, Lowering};
use crate::lower::names::Binding;
use crate::mistakes::errors::Reported;
use crate::model::{PairPoint, TriplePoint};
use crate::syntax::ast::{Declaration, Map, MapRule};
use crate::syntax::{bare, plain_name};

impl Lowering<'_> {
    /// The points of `φ_{L_d}⁻¹`, one or two.
    pub(crate) fn pairs(&mut self, map: &Map) -> Result<Vec<PairPoint>, Reported> {
        Ok(match &map.rule {
            MapRule::Closure(closure) => {
                let (t, [q, v]) = self.map(&map.keyword, closure)?;
                let t = t.unwrap_or_else(|| self.time_on_leg(&q));
                vec![PairPoint { t, q, v }]
            }
            MapRule::Paper => self.paper_pairs(),
            MapRule::Midpoint => self.midpoint_pairs(),
            MapRule::Trapezoid => vec![self.chord_velocity([1.0, 0.0]), self.chord_velocity([0.0, 1.0])],
        })
    }

    /// The paper's map of pairs, `(q0, (q1 - q0) / h)`.
    pub(crate) fn paper_pairs(&mut self) -> Vec<PairPoint> {
        vec![self.chord_velocity([1.0, 0.0])]
    }

    /// The chord velocity at the middle of the leg.
    fn midpoint_pairs(&mut self) -> Vec<PairPoint> {
        vec![self.chord_velocity([0.5, 0.5])]
    }

    /// The map if none is declared, always of order 2.
    ///
    /// The paper's map is of order 2 where `L = T(v) - V(q)`: its `L_d` differs from the trapezoid's by terms
    /// that cancel in the sum over the path. Where the momentum depends on the position or on time, or a row
    /// is imposed on a leg, a point at one end of the leg is of order 1.
    pub(crate) fn default_pairs(&mut self, declaration: &Declaration, lagrangian: NodeId) -> Vec<PairPoint> {
        let on_legs = !declaration.nonholonomic.is_absent() || mentions_legs(declaration);
        if on_legs || self.momentum_varies(lagrangian) {
            self.midpoint_pairs()
        } else {
            self.paper_pairs()
        }
    }

    /// Whether `∂L/∂v` depends on the position, as with a mass matrix that does, or on time.
    fn momentum_varies(&mut self, lagrangian: NodeId) -> bool {
        let n = self.coordinates.len();
        // on a copy, so that the test adds no nodes to the code
        let mut graph = self.graph.clone();
        (0..n).any(|i| {
            let momentum = graph.derivative(lagrangian, Leaf::V(i));
            (0..n).map(Leaf::Q).chain([Leaf::T]).any(|leaf| {
                let slope = graph.derivative(momentum, leaf);
                !graph.vanishes(slope)
            })
        })
    }

    /// The chord velocity, at a weighted mean of both ends.
    fn chord_velocity(&mut self, [first, second]: [f64; 2]) -> PairPoint {
        let [h, t0, t1] = [Leaf::H, Leaf::T0, Leaf::T1].map(|leaf| self.graph.leaf(leaf));
        let t = self.graph.linear(0.0, &[(t0, first), (t1, second)]);
        let point = (0..self.coordinates.len()).map(|i| {
            let (x0, x1) = (self.graph.leaf(Leaf::X0(i)), self.graph.leaf(Leaf::X1(i)));
            let q = self.graph.linear(0.0, &[(x0, first), (x1, second)]);
            let chord = match self.graph.rotation_at(i) {
                Some(_) => self.graph.leaf(Leaf::Chord(i)),
                None => self.graph.sub(x1, x0),
            };
            (q, self.graph.div(chord, h))
        });
        let (mut q, v): (Vec<_>, _) = point.unzip();
        if first > 0.0 && second > 0.0 {
            for slot in self.graph.rotations().to_vec() {
                let middle = self.graph.middle(slot);
                q.splice(slot..slot + middle.len(), middle);
            }
        }
        PairPoint { t, q, v }
    }

    /// The time of a point, if a formula does not give it: that of a node whose position the point has, else
    /// that of the middle of the leg.
    fn time_on_leg(&mut self, q: &[NodeId]) -> NodeId {
        let [t0, t1] = [Leaf::T0, Leaf::T1].map(|leaf| self.graph.leaf(leaf));
        for (x, t) in [(Leaf::X0 as fn(usize) -> Leaf, t0), (Leaf::X1, t1)] {
            if q.iter().enumerate().all(|(i, &q)| q == self.graph.leaf(x(i))) {
                return t;
            }
        }
        self.graph.linear(0.0, &[(t0, 0.5), (t1, 0.5)])
    }

    /// A map of three nodes; `None` for the paper's.
    pub(crate) fn triple(&mut self, map: &Map) -> Result<Option<TriplePoint>, Reported> {
        Ok(match &map.rule {
            MapRule::Closure(closure) => {
                let (t, [q, v, a]) = self.map(&map.keyword, closure)?;
                let t = t.unwrap_or_else(|| self.graph.leaf(Leaf::T1));
                Some(TriplePoint { t, q, v, a })
            }
            MapRule::Midpoint => Some(self.central_differences([0.25, 0.5, 0.25])),
            MapRule::Paper | MapRule::Trapezoid => None,
        })
    }

    /// The paper's second order map, `(q1, (q2 - q0) / 2h, (q2 - 2 q1 + q0) / h²)`.
    pub(crate) fn paper_triple(&mut self) -> TriplePoint {
        self.central_differences([0.0, 1.0, 0.0])
    }

    /// The central differences, at a weighted mean of the nodes.
    fn central_differences(&mut self, [first, second, third]: [f64; 3]) -> TriplePoint {
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
        let t = self.graph.leaf(Leaf::T1);
        TriplePoint { t, q, v, a }
    }

    /// The `K` vectors of a map: `q, v` for a map of two nodes, `q, v, a` for one of three; with the time, if
    /// the nodes are named with their times.
    fn map<const K: usize>(
        &mut self,
        keyword: &Ident,
        closure: &ExprClosure,
    ) -> Result<(Option<NodeId>, [Vec<NodeId>; K]), Reported> {
        let timed = closure.inputs.len() == 2 * K;
        let expected = match (K, timed) {
            (2, false) => "|q0, q1| (q, v)",
            (2, true) => "|t0, q0, t1, q1| (t, q, v)",
            (_, false) => "|q0, q1, q2| (q, v, a)",
            (_, true) => "|t0, q0, t1, q1, t2, q2| (t, q, v, a)",
        };
        let outer = self.scope.len();
        let mut wrong = None;
        if closure.inputs.len() != K && !timed {
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
            let binding = match (timed, index % 2) {
                (false, _) => Binding::Node(index),
                (true, 0) => Binding::NodeTime(index / 2),
                (true, _) => Binding::Node(index / 2),
            };
            match node_name(input) {
                Some(name) => {
                    let defined = self.scope.define(name, binding, self.errors);
                    wrong = defined.err().or(wrong);
                }
                None => wrong = Some(self.errors.at(input, "expected a plain name of a node")),
            }
        }
        // with a wrong number of nodes, the body would cause a second error for the same mistake
        let value = if let Some(reported) = wrong {
            Err(reported)
        } else {
            self.component = Some(0);
            self.point(
                &closure.body,
                &Shape {
                    keyword,
                    expected,
                    timed,
                },
            )
        };
        self.component = None;
        self.scope.truncate(outer);
        value
    }

    /// The time that a map gives its point, in terms of the nodes' times.
    fn time_of_point(&mut self, time: &Expr, expected: &str) -> Lowered {
        let value = self.expr(time)?;
        let mut leaves = self.graph.leaves(value);
        if leaves.any(|leaf| matches!(leaf, Leaf::X0(_) | Leaf::X1(_) | Leaf::X2(_))) {
            let message = format!(
                "expected a time, made of the times of the nodes; here a position comes in: where nodes are named with their times, the time stands \
                 before its node, `{expected}`"
            );
            return Err(self.errors.at(time, message));
        }
        Ok(value)
    }

    /// `(q, v)` or `(q, v, a)`, or with the time first, and perhaps at the end of a block.
    fn point<const K: usize>(
        &mut self,
        body: &Expr,
        shape: &Shape<'_>,
    ) -> Result<(Option<NodeId>, [Vec<NodeId>; K]), Reported> {
        let Shape {
            keyword,
            expected,
            timed,
        } = *shape;
        let count = K + usize::from(timed);
        match bare(body) {
            Expr::Block(block) if block.label.is_none() => {
                self.block(&block.block, |lowering, last| lowering.point(last, shape))
            }
            Expr::Tuple(tuple) if tuple.elems.len() == count => {
                let mut elements = tuple.elems.iter();
                let time = if timed { elements.next() } else { None };
                let time = time.map(|time| self.time_of_point(time, expected));
                let vectors: Vec<_> = elements.map(|element| self.vector(element)).collect();
                let vectors: Vec<_> = vectors.into_iter().collect::<Result<_, _>>()?;
                let vectors = vectors.try_into().map_err(|_| {
                    self.errors
                        .at(tuple, format!("expected `{keyword} = {expected};`"))
                })?;
                Ok((time.transpose()?, vectors))
            }
            Expr::Tuple(tuple) if timed => Err(self.errors.at(
                tuple,
                format!(
                    "expected the time and {K} vectors, `{keyword} = {expected};`, found {}",
                    tuple.elems.len()
                ),
            )),
            Expr::Tuple(tuple) => Err(self.errors.at(
                tuple,
                format!(
                    "expected {K} vectors, `{keyword} = {expected};`, found {}",
                    tuple.elems.len()
                ),
            )),
            other => Err(self.errors.at(
                other,
                format!(
                    "expected {} {K} vectors, `{keyword} = {expected};`",
                    self.errors.words("a tuple of", "parentheses with")
                ),
            )),
        }
    }

    /// The components of a vector: a tuple, or one expression that is read for each component.
    pub(crate) fn vector(&mut self, expr: &Expr) -> Result<Vec<NodeId>, Reported> {
        let outer = self.component;
        let value = self.components(expr);
        self.component = outer;
        value
    }

    fn components(&mut self, expr: &Expr) -> Result<Vec<NodeId>, Reported> {
        match bare(expr) {
            Expr::Tuple(_) => self.entries(expr),
            // the list for a single array
            Expr::Array(_) | Expr::Repeat(_) | Expr::Closure(_) if self.groups.len() == 1 => {
                self.entries(expr)
            }
            Expr::Block(block) if block.label.is_none() => self.block(&block.block, Self::components),
            // one mistake would be reported for every component: the first error ends the loop
            other => (0..self.coordinates.len())
                .map(|i| {
                    self.component = Some(i);
                    self.expr(other)
                })
                .collect(),
        }
    }
}

/// The expected form of a map.
struct Shape<'s> {
    /// The keyword of the statement.
    keyword: &'s Ident,
    /// The form, written out for messages.
    expected: &'static str,
    /// Whether the nodes are named with their times.
    timed: bool,
}

/// Whether a discrete statement uses `leg(e, …)`.
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
        search.visit_expr(&row.value);
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
