//! Discrete Lagrangians and constraints that are declared in terms of the nodes: `x[0]`, `x[1]`, `x[2]`.

use proc_macro2::Ident;
use quote::ToTokens;
use syn::{Expr, ExprCall};

use crate::graph::{Leaf, NodeId};
use crate::hash::HashMap;
use crate::lower::lowering::{Lowered, Lowering, Maps, Nodes};
use crate::lower::names::Binding;
use crate::lower::values::Valued;
use crate::mistakes::errors::Reported;
use crate::model::{PairPoint, TriplePoint};
use crate::syntax::ast::Constraints;
use crate::syntax::bare;

impl Lowering<'_> {
    /// `L_d`, a function of two nodes.
    pub(crate) fn discrete_lagrangian(&mut self, value: &Expr, maps: &Maps) -> Lowered {
        let discrete = self.of_nodes(value, 2, maps)?;
        self.expect_number(value, &discrete)
    }

    /// The rows of `D_K`, functions of three nodes, grouped by the entries of the statement.
    pub(crate) fn discrete_kinematic(
        &mut self,
        constraints: &Constraints,
        maps: &Maps,
    ) -> Result<Vec<Vec<NodeId>>, Reported> {
        self.each_entry(&constraints.rows, |lowering, row| {
            let values = lowering.of_nodes(row, 3, maps)?.numbers();
            for &value in &values {
                let last = |leaf| matches!(leaf, Leaf::X2(_));
                if !lowering.graph.leaves(value).any(last) {
                    return Err(lowering.errors.at(
                        row,
                        "expected the third node in a discrete constraint, such as `x[2]`: a step looks for it",
                    ));
                }
            }
            Ok(values)
        })
    }

    fn of_nodes(&mut self, value: &Expr, count: usize, maps: &Maps) -> Valued {
        self.derivatives.clear();
        self.discrete = Some(Nodes {
            count,
            maps: maps.clone(),
        });
        let value = self.value(value);
        self.discrete = None;
        value
    }

    /// A coordinate at a node, `x[0]`, in a discrete expression.
    pub(crate) fn at_node(&self, coordinate: usize, index: &Expr) -> Result<Leaf, Reported> {
        self.of_node(
            [Leaf::X0(coordinate), Leaf::X1(coordinate), Leaf::X2(coordinate)],
            index,
        )
    }

    /// The time of a node, `t[0]`.
    pub(crate) fn time_of_node(&self, index: &Expr) -> Result<Leaf, Reported> {
        self.of_node([Leaf::T0, Leaf::T1, Leaf::T2], index)
    }

    /// The leaf of the node that an index names.
    fn of_node(&self, [first, second, third]: [Leaf; 3], index: &Expr) -> Result<Leaf, Reported> {
        let count = self.discrete.as_ref().map_or(0, |nodes| nodes.count);
        match self.known_integer(index)? {
            0 => Ok(first),
            1 if count > 1 => Ok(second),
            2 if count > 2 => Ok(third),
            other => Err(self.errors.at(
                index,
                format!(
                    "there is no node {other} here; expected a node from 0 to {}",
                    count - 1
                ),
            )),
        }
    }

    /// The index of the coordinate at a node: of `x` in `x[0]`, of `theta[1]` in `theta[1][0]`.
    pub(crate) fn coordinate_of_node(&self, base: &Expr) -> Option<Result<usize, Reported>> {
        match bare(base) {
            Expr::Path(path) => match self.scope.get(path.path.get_ident()?)? {
                Binding::Coordinate(coordinate) => Some(Ok(*coordinate)),
                _ => None,
            },
            Expr::Index(index) => match bare(&index.expr) {
                Expr::Path(path) => {
                    let group = self.array(path.path.get_ident()?)?;
                    Some(self.element(group, &index.index))
                }
                _ => None,
            },
            _ => None,
        }
    }

    /// The error for an expression of the motion in a discrete expression.
    pub(crate) fn motion_among_nodes(&self, tokens: impl ToTokens, is_coordinate: bool) -> Reported {
        let tokens = tokens.into_token_stream();
        let text = tokens.to_string().replace(' ', "");
        let last = self.discrete.as_ref().map_or(0, |nodes| nodes.count - 1);
        let message = if is_coordinate {
            format!("a discrete expression is made of nodes; expected `{text}[0]` to `{text}[{last}]`")
        } else {
            let at = if last < 2 {
                format!("on the leg, `leg({text}, 0)`")
            } else {
                format!("on a leg or at the triple, `leg({text}, 0)`, `node({text})`")
            };
            format!(
                "a discrete expression is made of nodes, and this is one of the motion; expected difference quotients, \
                 such as `(x[1] - x[0]) / h`, or its value {at}"
            )
        };
        self.errors.at(tokens, message)
    }

    /// `leg(e, 0)`, the value of `e(q, v)` on the leg from node 0 to node 1, or `node(e)`, that of
    /// `e(q, v, a)` at the triple.
    pub(crate) fn leg_or_node(&mut self, name: &Ident, call: &ExprCall) -> Valued {
        let Some(nodes) = self.discrete.clone() else {
            return Err(self.unknown_name(name));
        };
        let on_leg = name == "leg";
        let example = if on_leg { "leg(e, 0)" } else { "node(e)" };
        let mut arguments = call.args.iter();
        let (Some(value), index, None) = (arguments.next(), arguments.next(), arguments.next()) else {
            return Err(self.errors.at(call, format!("expected `{example}`")));
        };
        if !on_leg && (index.is_some() || nodes.count < 3) {
            let message = if nodes.count < 3 {
                "a discrete Lagrangian knows a single leg; expected `leg(e, 0)`"
            } else {
                "expected `node(e)`, with one argument: there is one triple of nodes"
            };
            return Err(self.errors.at(call, message));
        }
        let leg = index.map_or(Ok(0), |index| self.known_integer(index))?;
        if !(0..2).contains(&leg) || leg > 0 && nodes.count < 3 {
            return Err(self.errors.at(
                index,
                format!(
                    "there is no leg {leg} here; expected a leg from 0 to {}",
                    nodes.count - 2
                ),
            ));
        }
        self.discrete = None;
        self.derivatives.clear();
        let written = self.value(value);
        let checked = written.and_then(|written| {
            let expected =
                "what a triple of nodes knows, an expression of positions, velocities and accelerations";
            written.map(|number| {
                if on_leg {
                    self.check_order_below(2, number, value, ON_LEG)
                } else {
                    self.without_jerk(number, value, expected)
                }
            })
        });
        self.discrete = Some(nodes.clone());
        let value = checked?;
        if on_leg {
            let points = nodes.maps.0?;
            return value.map(|number| Ok(self.on_leg(number, &points, leg > 0)));
        }
        let TriplePoint { t, q, v, a } = nodes.maps.1?.unwrap_or_else(|| self.paper_triple());
        let point = point(t, &[q.as_slice(), v.as_slice(), a.as_slice()]);
        value.map(|number| Ok(self.graph.substitute(number, &point)))
    }

    /// The value of an expression on a leg: on the second one if `is_later`, else on the first.
    fn on_leg(&mut self, value: NodeId, points: &[PairPoint], is_later: bool) -> NodeId {
        let weight = 1.0 / points.len() as f64;
        let terms: Vec<_> = points
            .iter()
            .map(|PairPoint { t, q, v }| {
                let point = point(*t, &[q.as_slice(), v.as_slice()]);
                (self.graph.substitute(value, &point), weight)
            })
            .collect();
        let value = self.graph.linear(0.0, &terms);
        if !is_later {
            return value;
        }
        let [t1, t2] = [Leaf::T1, Leaf::T2].map(|leaf| self.graph.leaf(leaf));
        let mut later = HashMap::from_iter([(Leaf::T0, t1), (Leaf::T1, t2)]);
        for i in 0..self.coordinates.len() {
            later.insert(Leaf::X0(i), self.graph.leaf(Leaf::X1(i)));
            later.insert(Leaf::X1(i), self.graph.leaf(Leaf::X2(i)));
        }
        self.graph.substitute(value, &later)
    }
}

/// The error for an acceleration on a leg.
const ON_LEG: &str = "an acceleration comes in here; expected an expression of positions and velocities, which a leg gives; `node(e)` knows \
                      accelerations";

/// The substitution for time, position, velocity and, if it is given, acceleration.
fn point(t: NodeId, vectors: &[&[NodeId]]) -> HashMap<Leaf, NodeId> {
    let leaves: [fn(usize) -> Leaf; 3] = [Leaf::Q, Leaf::V, Leaf::A];
    let parts = leaves.iter().zip(vectors);
    parts
        .flat_map(|(leaf, nodes)| nodes.iter().enumerate().map(move |(i, &node)| (leaf(i), node)))
        .chain([(Leaf::T, t)])
        .collect()
}
