//! Whether the step can be composed with others of different lengths.
//!
//! Value, slope and curvature at `q1` of the parabola through three nodes exist for legs of any lengths. Where the equations of a
//! step depend on its nodes through this point alone, and are there those of the continuous system, the map from
//! node to node is symmetric in time for every leg, and compositions of it have higher orders. That is decided here, with
//! the point written in place of the nodes: `q1 = q`, `q1 - q0 = h v - h² a/2`, `q2 - 2 q1 + q0 = h² a`.
//!
//! Where `L_d` leads to other equations, as with a mass matrix that varies, legs of different lengths are joined by the momenta at
//! the nodes instead. That map is symmetric where `L_d` is: where it is the same with its nodes exchanged and `-h` in place of `h`.

use super::force::points_of_arriving;
use super::nodes::{LeafOf, Nodes};
use super::step::StepEquations;
use crate::graph::algebra::Merge;
use crate::graph::{Graph, Leaf, NodeId, Substitution};
use crate::hash::HashMap;
use crate::model::{Model, PairPoint, TriplePoint};

/// Whether steps of different lengths can be composed, or why not: a variant of `dsocs_core::Symmetry`, which says what each is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
#[allow(missing_docs, reason = "what each is, dsocs_core says")]
pub enum Symmetry {
    AnyLegs,
    Momenta,
    LowerOrder,
    ThirdOrder,
    LagrangianMap,
    KinematicMap,
    VariationalMap,
}

impl Symmetry {
    /// The name of the variant.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::AnyLegs => "AnyLegs",
            Self::Momenta => "Momenta",
            Self::LowerOrder => "LowerOrder",
            Self::ThirdOrder => "ThirdOrder",
            Self::LagrangianMap => "LagrangianMap",
            Self::KinematicMap => "KinematicMap",
            Self::VariationalMap => "VariationalMap",
        }
    }
}

impl Symmetry {
    /// Whether the step is symmetric with any legs, or the first reason why not. The step is that of the declaration, in a graph that stays as it is:
    /// what is written on the way to an answer has no place among the expressions that code is made of.
    pub(crate) fn decide(model: &Model, graph: &Graph, step: &StepEquations) -> Self {
        if model.order() > 2 {
            return Self::ThirdOrder;
        }
        if model.constraints.iter().any(|row| row.order < 2) {
            return Self::LowerOrder;
        }
        let mut declared = model.graph.clone();
        if !declared.rotations().is_empty() {
            // no parabola joins legs that turn: the velocities of two legs are seen from one body through `T`
            return Self::by_momenta(model, &mut declared);
        }
        if is_paper(model, &mut declared) && !momentum_is_linear(model, &mut declared) {
            return Self::by_momenta(model, &mut declared);
        }
        let mut graph = graph.clone();
        let continuous = super::continuous(model, &mut graph);
        let point = parabola(&mut graph, model.coordinates.len());
        let mut merge = Merge::default();
        let mut at_point = Substitution::new(&point);
        let mut same = |step: NodeId, continuous: NodeId| {
            let step = graph.rewrite(step, &mut at_point);
            // functions of equal arguments become one function
            let continuous = graph.rewrite(continuous, &mut merge);
            let step = graph.rewrite(step, &mut merge);
            let difference = graph.sub(step, continuous);
            graph.vanishes(difference)
        };
        let force = step.force.iter().zip(&continuous.force);
        if !force
            .into_iter()
            .all(|(&step, &continuous)| same(step, continuous))
        {
            return Self::by_momenta(model, &mut declared);
        }
        let count = model.constraints.len();
        for (place, (step, continuous)) in step.rows.iter().zip(&continuous.rows).enumerate() {
            let factors = match (step.divide, continuous.divide) {
                (Some(step), Some(continuous)) => same(step, continuous),
                (step, continuous) => step.is_none() && continuous.is_none(),
            };
            if !factors || !same(step.value, continuous.value) {
                return if place < count {
                    Self::KinematicMap
                } else {
                    Self::VariationalMap
                };
            }
        }
        Self::AnyLegs
    }

    /// Whether legs of any lengths can be joined by the momenta at the nodes, or why not.
    fn by_momenta(model: &Model, graph: &mut Graph) -> Self {
        let n = model.coordinates.len();
        let (nodes, point) = (Nodes::new(graph, n).places(), parabola(graph, n));
        let (mut at_nodes, mut at_point) = (Substitution::new(&nodes), Substitution::new(&point));
        let mut is_its_point = |map: &Option<TriplePoint>| {
            let Some(TriplePoint { t, q, v, a }) = map else {
                return true; // the paper's
            };
            let leaves = [Leaf::Q as LeafOf, Leaf::V, Leaf::A]
                .into_iter()
                .flat_map(|leaf| (0..n).map(leaf));
            let components = [q, v, a].into_iter().flatten().zip(leaves);
            components.chain([(t, Leaf::T)]).all(|(&component, leaf)| {
                let component = graph.rewrite(component, &mut at_nodes);
                let component = graph.rewrite(component, &mut at_point);
                let leaf = graph.leaf(leaf);
                let difference = graph.sub(component, leaf);
                graph.vanishes(difference)
            })
        };
        let written = model.constraints.iter().any(|row| row.discrete.is_some());
        if written || !is_its_point(&model.phi_kinematic) {
            Self::KinematicMap
        } else if !is_its_point(&model.phi_variational) {
            Self::VariationalMap
        } else if is_symmetric_leg(model, graph) {
            Self::Momenta
        } else {
            Self::LagrangianMap
        }
    }
}

/// Whether `L_d` is the same with its nodes exchanged and `-h` in place of `h`. For the paper's map the trapezoid's is taken, see
/// [`super::arriving`].
fn is_symmetric_leg(model: &Model, graph: &mut Graph) -> bool {
    let h = graph.leaf(Leaf::H);
    let mut exchanged = HashMap::from_iter([
        (Leaf::H, graph.neg(h)),
        (Leaf::T0, graph.leaf(Leaf::T1)),
        (Leaf::T1, graph.leaf(Leaf::T0)),
    ]);
    for i in 0..model.coordinates.len() {
        exchanged.insert(Leaf::X0(i), graph.leaf(Leaf::X1(i)));
        exchanged.insert(Leaf::X1(i), graph.leaf(Leaf::X0(i)));
        let chord = graph.leaf(Leaf::Chord(i));
        exchanged.insert(Leaf::Chord(i), graph.neg(chord));
    }
    let rotations = graph.rotations().to_vec();
    let middles: Vec<_> = (rotations.iter())
        .map(|&first| (first, graph.middle(first)))
        .collect();
    let points = points_of_arriving(model, graph);
    let (mut exchange, mut merge) = (Substitution::new(&exchanged), Merge::default());
    let mut same = |left: &[NodeId], right: &[NodeId]| {
        left.iter().zip(right).all(|(&left, &right)| {
            let left = graph.rewrite(left, &mut exchange);
            let (left, right) = (graph.rewrite(left, &mut merge), graph.rewrite(right, &mut merge));
            let difference = graph.sub(left, right);
            graph.vanishes(difference)
        })
    };
    if let Some(given) = model.discrete_lagrangian {
        return same(&[given], &[given]);
    }
    // the middle of a leg that turns is the same from both ends, which its expression, from the first, does not show
    let numbers = |point: &PairPoint| {
        let mut q = point.q.clone();
        for (first, middle) in middles.iter().rev() {
            let slots = *first..first + middle.len();
            if q[slots.clone()] == *middle {
                q.drain(slots);
            }
        }
        q
    };
    let is_among = |point: &PairPoint| {
        let mut others = points.iter();
        others.any(|other| {
            let (q, other_q) = (numbers(point), numbers(other));
            q.len() == other_q.len()
                && same(&[point.t], &[other.t])
                && same(&q, &other_q)
                && same(&point.v, &other.v)
        })
    };
    points.iter().all(is_among)
}

/// Whether the first order map is the paper's.
fn is_paper(model: &Model, graph: &mut Graph) -> bool {
    let first =
        |graph: &mut Graph, q: &[NodeId]| q.iter().enumerate().all(|(i, &q)| q == graph.leaf(Leaf::X0(i)));
    model.discrete_lagrangian.is_none()
        && matches!(model.phi_lagrangian.as_slice(), [point] if first(graph, &point.q))
}

/// Whether `∂L/∂v` is a constant matrix times `v`, and a constant: with the paper's map its difference over a step is then
/// the matrix times the curvature.
fn momentum_is_linear(model: &Model, graph: &mut Graph) -> bool {
    let n = model.coordinates.len();
    (0..n).all(|i| {
        let momentum = graph.derivative(model.lagrangian, Leaf::V(i));
        (0..n).all(|j| {
            let by_position = graph.derivative(momentum, Leaf::Q(j));
            let mass = graph.derivative(momentum, Leaf::V(j));
            graph.vanishes(by_position) && graph.is_fixed(mass)
        })
    })
}

/// The nodes of a step in terms of its parabola's point.
fn parabola(graph: &mut Graph, n: usize) -> HashMap<Leaf, NodeId> {
    let h = graph.leaf(Leaf::H);
    let mut nodes = HashMap::from_iter([(Leaf::Clock, graph.leaf(Leaf::T))]);
    for i in 0..n {
        let [q, v, a] = [Leaf::Q(i), Leaf::V(i), Leaf::A(i)].map(|leaf| graph.leaf(leaf));
        let second = graph.product(&[(h, 2), (a, 1)]);
        let first = graph.mul(h, v);
        nodes.insert(Leaf::N(i), q);
        nodes.insert(Leaf::D(i), graph.linear(0.0, &[(first, 1.0), (second, -0.5)]));
        nodes.insert(Leaf::E(i), second);
    }
    nodes
}
