//! Whether steps of different lengths can be composed.
//!
//! The parabola through three nodes has a value, a slope and a curvature at `q1` for legs of any lengths. If
//! the equations of a step depend on its nodes through this point alone, and agree there with those of the
//! continuous system, the map from node to node is symmetric in time for every leg, and compositions of it
//! have higher orders. That is decided here, with the nodes expressed by the point: `q1 = q`,
//! `q1 - q0 = h v - h² a/2`, `q2 - 2 q1 + q0 = h² a`.
//!
//! Where `L_d` gives other equations, as with a mass matrix that varies, legs of different lengths are joined
//! by the momenta at the nodes instead. That map is symmetric if `L_d` is: if it stays the same when its
//! nodes are exchanged and `h` becomes `-h`.

use crate::graph::algebra::Merge;
use crate::graph::{Graph, Leaf, NodeId, Substitution};
use crate::hash::HashMap;
use crate::mechanics::force::quadrature_points;
use crate::mechanics::nodes::{LeafOf, Nodes};
use crate::mechanics::step::StepEquations;
use crate::model::{Model, PairPoint, TriplePoint};

/// Whether steps of different lengths can be composed, or why not. The variants are those of
/// `dsocs_core::Symmetry`, where they are explained.
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
    /// Whether the step is symmetric with any legs, or the first reason why not. The given graph is not
    /// changed: expressions made for the decision do not belong among those from which code is made.
    pub(crate) fn decide(model: &Model, graph: &Graph, step: &StepEquations) -> Self {
        if model.order() > 2 {
            return Self::ThirdOrder;
        }
        if model.constraints.iter().any(|row| row.order < 2) {
            return Self::LowerOrder;
        }
        let mut declared = model.graph.clone();
        if !declared.rotations().is_empty() {
            // no parabola joins the legs of a rotation, whose velocities are in the frames of different
            // bodies
            return Self::by_momenta(model, &mut declared);
        }
        if is_paper(model, &mut declared) && !momentum_is_linear(model, &mut declared) {
            return Self::by_momenta(model, &mut declared);
        }
        let mut graph = graph.clone();
        let continuous = crate::mechanics::continuous(model, &mut graph);
        let point = parabola(&mut graph, model.coordinates.len());
        let mut merge = Merge::default();
        let mut at_point = Substitution::new(&point);
        let mut same = |step: NodeId, continuous: NodeId| {
            let step = graph.rewrite(step, &mut at_point);
            // functions of equal arguments become the same node
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
        let (nodes, point) = (Nodes::new(graph, n).substitution(), parabola(graph, n));
        let (mut at_nodes, mut at_point) = (Substitution::new(&nodes), Substitution::new(&point));
        let mut is_its_point = |map: &Option<TriplePoint>| {
            let Some(TriplePoint { t, q, v, a }) = map else {
                return true; // the paper's map
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

/// Whether `L_d` stays the same when its nodes are exchanged and `h` becomes `-h`. The paper's map counts as
/// the trapezoid, see [`crate::mechanics::momentum_at_second_node`].
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
    let points = quadrature_points(model, graph);
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
    // the middle of a rotation's leg is symmetric, but its expression, which starts from the first node, does
    // not show it
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

/// Whether `φ_{L_d}⁻¹` is the paper's map.
fn is_paper(model: &Model, graph: &mut Graph) -> bool {
    let first =
        |graph: &mut Graph, q: &[NodeId]| q.iter().enumerate().all(|(i, &q)| q == graph.leaf(Leaf::X0(i)));
    model.discrete_lagrangian.is_none()
        && matches!(model.phi_lagrangian.as_slice(), [point] if first(graph, &point.q))
}

/// Whether `∂L/∂v` is a constant matrix times `v`, plus a constant. Then with the paper's map its difference
/// over a step is the matrix times the curvature.
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

/// The nodes of a step, expressed by value, slope and curvature of its parabola.
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
