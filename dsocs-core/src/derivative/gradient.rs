//! Backward (the discrete adjoint): the derivatives of one cost by all variables, from the last step to the first.

use super::block::{Block, Role, Rooms};
use super::error::DerivativeError;
use super::forward::first_point;
use super::path::{Motion, Path, Piece};
use crate::dual::Dual;
use crate::start::StartOrder;
use crate::system::{Point, System};
use crate::tape::Eight;

/// The derivatives of a cost of a [`Path`], in units of the cost per unit of the variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient<const N: usize> {
    /// The cost.
    pub cost: f64,
    /// The derivatives with respect to the first node. The velocity at the start stays fixed, or the second node if the start is
    /// [`Start::nodes`](crate::Start::nodes).
    pub q0: [f64; N],
    /// The derivatives with respect to the velocity at the start; zero if the start is [`Start::nodes`](crate::Start::nodes).
    pub v0: [f64; N],
    /// The derivatives with respect to the second node; zero unless the start is [`Start::nodes`](crate::Start::nodes).
    pub q1: [f64; N],
    /// The derivatives with respect to the parameters, in the order of [`System::PARAMETERS`]. Each parameter changes throughout the run. For an
    /// input this is the sum over the legs.
    pub parameters: Vec<f64>,
    /// The derivatives with respect to the inputs of a [`Path::plan`]: `inputs[k][j]` belongs to input `j` on the leg from node `k`. Empty for
    /// other paths.
    pub inputs: Vec<Vec<f64>>,
}

/// The part that a node has in the cost.
type Cost<'a, const N: usize> = dyn FnMut(usize, &Point<Dual<f64>, N>) -> Dual<f64> + 'a;

impl<S: System<N>, const N: usize> Path<'_, S, N> {
    /// The gradient of a cost that is a sum over all nodes, from the start to the last. The closure gets the number of a node, and its time,
    /// position, velocity and acceleration as dual numbers. It returns the term of the cost that belongs to this node. In products and sums,
    /// write the plain number to the right of the dual number: `node.q[0] * 2.0`.
    ///
    /// Together with the run itself, it takes as long as two to four runs, for any number of parameters. To this comes the time of the
    /// closure: with `n` coordinates it is called `2 n + 1` times per node, or `3 n + 1` times if it depends on the acceleration.
    ///
    /// ```
    /// # use dsocs_core::prelude::*;
    /// # use dsocs_core::Path;
    /// # #[dsocs { coordinates(x); lagrangian = dot(x).powi(2) / 2 - stiffness * x.powi(2) / 2; }]
    /// # struct Oscillator { stiffness: f64 }
    /// # let oscillator = Oscillator { stiffness: 4.0 };
    /// // how far the path is from another one, in the mean of squares
    /// let path = Path::new(&oscillator, 0.01, Start::second_order([1.0], [0.0]), 1.0)?;
    /// let gradient = path.gradient(&mut |_, node| {
    ///     let missed = node.q[0] - (1.9 * node.t.re).cos();
    ///     missed * missed / 101.0
    /// })?;
    /// println!("{} {:?}", gradient.cost, gradient.parameters);
    /// # Ok::<(), dsocs_core::DerivativeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`DerivativeError`] if a step or the start has no derivative.
    pub fn gradient(
        &self,
        cost: &mut dyn FnMut(usize, &Point<Dual<f64>, N>) -> Dual<f64>,
    ) -> Result<Gradient<N>, DerivativeError> {
        let motion = self.motion()?;
        let legs = if self.input_places().is_empty() {
            0
        } else {
            self.legs()
        };
        backward(&motion, cost, 0, (self.input_places(), legs))
    }

    /// The gradient of a cost that depends only on the last node.
    ///
    /// # Errors
    ///
    /// As [`Path::gradient`].
    pub fn gradient_at_end(
        &self,
        cost: &mut dyn FnMut(&Point<Dual<f64>, N>) -> Dual<f64>,
    ) -> Result<Gradient<N>, DerivativeError> {
        let motion = self.motion()?;
        let legs = if self.input_places().is_empty() {
            0
        } else {
            self.legs()
        };
        let mut cost = |_: usize, end: &Point<Dual<f64>, N>| cost(end);
        backward(&motion, &mut cost, self.steps(), (self.input_places(), legs))
    }
}

/// The derivatives of a node's cost by position, velocity and acceleration.
struct OfNode<const N: usize> {
    cost: f64,
    slopes: Option<[[f64; N]; 3]>,
}

/// Evaluates the cost of a node.
fn of_node<const N: usize>(index: usize, point: &Point<f64, N>, cost: &mut Cost<'_, N>) -> OfNode<N> {
    let moving = |x: &[f64; N], rates: &[f64; N]| core::array::from_fn(|i| Dual::new(x[i], rates[i]));
    let mut at = |[q, v, a]: &[[f64; N]; 3]| {
        cost(
            index,
            &Point {
                t: Dual::new(point.t, 0.0),
                q: moving(&point.q, q),
                v: moving(&point.v, v),
                a: moving(&point.a, a),
            },
        )
    };
    // few costs depend on the acceleration: with NaN as its rate, the result is NaN only if this one does
    let [still, unknown] = [[0.0; N], [f64::NAN; N]];
    let probe = at(&[still, still, unknown]);
    let parts = if probe.eps.is_nan() { 3 } else { 2 };
    let mut slopes = [still; 3];
    let mut depends = false;
    for part in 0..parts {
        for i in 0..N {
            let mut rates = [still; 3];
            rates[part][i] = 1.0;
            slopes[part][i] = at(&rates).eps;
            depends |= slopes[part][i] != 0.0;
        }
    }
    OfNode {
        cost: probe.re,
        slopes: depends.then_some(slopes),
    }
}

/// The derivatives of the cost by the first two nodes of a piece, and by the parameters.
struct Adjoint<const N: usize> {
    /// By the node and by the increment of the step after.
    q: [f64; N],
    d: [f64; N],
    cost: f64,
    /// By the parameters, stretch by stretch.
    parameters: Vec<Vec<f64>>,
}

impl<const N: usize> Adjoint<N> {
    /// Goes back through a step, and returns the derivative by its second difference. `of_node` is the direct one, by its node's cost.
    fn by_e(&mut self, of_node: &[f64; N]) -> [f64; N] {
        let mut by_e = [0.0; N];
        for i in 0..N {
            self.d[i] += self.q[i];
            by_e[i] = self.d[i] + of_node[i];
        }
        by_e
    }
}

/// The derivatives of the costs of a block's nodes by their points.
type OfPoints<const N: usize> = Option<[[Eight; N]; 3]>;

/// Carries the derivatives of the cost from the end to the start. Nodes before `from` have no cost.
fn backward<const N: usize>(
    motion: &Motion<'_, N>,
    cost: &mut Cost<'_, N>,
    from: usize,
    (inputs, legs): (&[usize], usize),
) -> Result<Gradient<N>, DerivativeError> {
    let count = motion.equations.parameters;
    let (mut rooms, mut block) = (Rooms::default(), Block::new());
    let mut adjoint = Adjoint {
        q: [0.0; N],
        d: [0.0; N],
        cost: 0.0,
        parameters: vec![vec![0.0; count]; motion.stretches()],
    };
    let mut current: Option<(usize, Vec<Eight>)> = None;
    for window in (0..motion.windows()).rev() {
        let window = motion.window(window)?;
        for piece in motion.pieces(&window).iter().rev() {
            let (first, count, stretch) = piece.steps();
            if current.as_ref().is_none_or(|(own, ..)| *own != stretch) {
                leave(motion, current.take(), &mut rooms, &mut adjoint);
                let values = motion.enter(stretch, &mut rooms);
                current = Some((stretch, vec![Eight::ZERO; values.len()]));
            }
            let Some((_, by_fixed)) = &mut current else {
                continue;
            };
            let steps = motion.some(&window, piece);
            let of_points = if first + count > from {
                let points = motion.equations.points(&steps, &mut rooms);
                weights(motion, &mut adjoint.cost, cost, (first, count, from), &points)
            } else {
                None
            };
            // the derivatives of the nodes' costs by node, increment and second difference
            let mut of_nodes = [[Eight::ZERO; N]; 3];
            if let Some(weights) = &of_points {
                let lanes = Eight::from_fn(|lane| f64::from(u8::from(lane < count)));
                motion
                    .equations
                    .back_from_points(&mut rooms, weights, &mut |role, slope| {
                        let to = match role {
                            Role::Node(i) => &mut of_nodes[0][i],
                            Role::Increment(i) => &mut of_nodes[1][i],
                            Role::Difference(i) => &mut of_nodes[2][i],
                            Role::Fixed(k) => {
                                by_fixed[k] = by_fixed[k] + slope * lanes;
                                return;
                            }
                            Role::Unknown(_) | Role::Still => return,
                        };
                        *to = *to + slope;
                    });
            }
            if let Piece::Plain { .. } = piece {
                let linearized = motion.equations.linearize(&steps, &mut rooms, &mut block);
                linearized.map_err(|lane| motion.singular(first + lane))?;
                let by_e = back(&mut adjoint, &block, &of_nodes, count);
                block.add_by_fixed(&motion.equations, &by_e, by_fixed);
            } else {
                let changed = motion.changed(&window, first, stretch)?;
                let of_nodes = of_nodes.map(|x| x.map(|x| x.0[0]));
                let by_e = adjoint.by_e(&of_nodes[2]);
                for j in 0..N {
                    adjoint.q[j] += of_nodes[0][j];
                    adjoint.d[j] += of_nodes[1][j];
                    for (i, by_e) in by_e.iter().enumerate() {
                        adjoint.q[j] += by_e * changed.by_node[i][j];
                        adjoint.d[j] += by_e * changed.by_increment[i][j];
                    }
                }
                for (side, slopes) in changed.by_parameters.iter().enumerate() {
                    let sums = &mut adjoint.parameters[stretch - 1 + side];
                    for (sum, slope) in sums.iter_mut().zip(slopes) {
                        *sum += by_e
                            .iter()
                            .zip(slope)
                            .map(|(by_e, slope)| by_e * slope)
                            .sum::<f64>();
                    }
                }
            }
        }
    }
    leave(motion, current.take(), &mut rooms, &mut adjoint);
    Ok(begin(motion, cost, from, adjoint, (inputs, legs)))
}

/// Sums up the derivatives by constants and parameters of a stretch.
fn leave<const N: usize>(
    motion: &Motion<'_, N>,
    stretch: Option<(usize, Vec<Eight>)>,
    rooms: &mut Rooms,
    adjoint: &mut Adjoint<N>,
) {
    let Some((stretch, by_fixed)) = stretch else {
        return;
    };
    let by_fixed: Vec<f64> = by_fixed.iter().map(|lanes| lanes.0.iter().sum()).collect();
    let source = motion.declaration(stretch).source();
    let parameters = motion.equations.of_parameters(source, motion.h, rooms, &by_fixed);
    for (sum, own) in adjoint.parameters[stretch].iter_mut().zip(parameters) {
        *sum += own;
    }
}

/// Evaluates the costs of some nodes. Returns the derivatives by their points, `None` if all are zero.
fn weights<const N: usize>(
    motion: &Motion<'_, N>,
    sum: &mut f64,
    cost: &mut Cost<'_, N>,
    (first, count, from): (usize, usize, usize),
    points: &[[Eight; N]; 3],
) -> OfPoints<N> {
    let mut weights: OfPoints<N> = None;
    for lane in (0..count).rev().filter(|lane| first + lane >= from) {
        let [q, v, a] = points.map(|x| x.map(|x| x.0[lane]));
        let point = Point {
            t: motion.time(first + lane),
            q,
            v,
            a,
        };
        let of_node = of_node(first + lane, &point, cost);
        *sum += of_node.cost;
        if let Some(slopes) = of_node.slopes {
            let weights = weights.get_or_insert([[Eight::ZERO; N]; 3]);
            for (weights, slopes) in weights.iter_mut().zip(slopes) {
                for (weight, slope) in weights.iter_mut().zip(slopes) {
                    weight.0[lane] = slope;
                }
            }
        }
    }
    weights
}

/// Goes back through a block; returns the derivatives by the second differences.
fn back<const N: usize>(
    adjoint: &mut Adjoint<N>,
    block: &Block<N>,
    of_nodes: &[[Eight; N]; 3],
    count: usize,
) -> [Eight; N] {
    let mut all = [Eight::ZERO; N];
    for lane in (0..count).rev() {
        let by_e = adjoint.by_e(&of_nodes[2].map(|x| x.0[lane]));
        for j in 0..N {
            let (mut q, mut d) = (of_nodes[0][j].0[lane], of_nodes[1][j].0[lane]);
            for (i, by_e) in by_e.iter().enumerate() {
                q += by_e * block.by_node[i][j].0[lane];
                d += by_e * block.by_increment[i][j].0[lane];
            }
            adjoint.q[j] += q;
            adjoint.d[j] += d;
        }
        for (all, by_e) in all.iter_mut().zip(by_e) {
            all.0[lane] = by_e;
        }
    }
    all
}

/// From the first step to the start.
fn begin<const N: usize>(
    motion: &Motion<'_, N>,
    cost: &mut Cost<'_, N>,
    from: usize,
    adjoint: Adjoint<N>,
    (inputs, legs): (&[usize], usize),
) -> Gradient<N> {
    let Adjoint {
        q: mut q0,
        d,
        cost: mut sum,
        parameters: mut by_stretch,
    } = adjoint;
    // the first node of the first step lies beyond the increment
    let mut by_d: [f64; N] = core::array::from_fn(|i| d[i] + q0[i]);
    let (mut v0, mut q1) = ([0.0; N], [0.0; N]);
    if from == 0 {
        let first = of_node(0, &first_point(motion), cost);
        sum += first.cost;
        if let Some([by_q, by_v, by_a]) = first.slopes {
            for i in 0..N {
                q0[i] += by_q[i];
                v0[i] += by_v[i];
            }
            if let Some((_, slopes)) = &motion.begun.acceleration {
                slopes.add(&by_a, &mut q0, &mut v0, &mut by_stretch[0]);
            }
        }
    }
    if motion.begun.order == StartOrder::Nodes {
        for i in 0..N {
            by_d[i] += v0[i] / motion.h;
            q0[i] -= by_d[i];
        }
        (q1, v0) = (by_d, [0.0; N]);
    } else {
        motion
            .begun
            .increment
            .add(&by_d, &mut q0, &mut v0, &mut by_stretch[0]);
    }
    let mut parameters = vec![0.0; motion.equations.parameters];
    for own in &by_stretch {
        for (sum, own) in parameters.iter_mut().zip(own) {
            *sum += own;
        }
    }
    let inputs = by_stretch
        .iter()
        .take(legs)
        .map(|own| inputs.iter().map(|&place| own[place]).collect())
        .collect();
    Gradient {
        cost: sum,
        q0,
        v0,
        q1,
        parameters,
        inputs,
    }
}
