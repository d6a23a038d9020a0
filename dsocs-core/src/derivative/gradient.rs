//! The backward method (discrete adjoint): the derivatives of one cost by all variables, propagated from the last step to the first.

use super::block::{Block, Role, Rooms, Steps};
use super::error::DerivativeError;
use super::forward::{first_point, point_of};
use super::motion::{Motion, Piece, Recording};
use super::path::{AnyPath, Path};
use super::start::StartDerivatives;
use super::turning;
use crate::number::dual::Dual;
use crate::number::point::Point;
use crate::number::point::{AnyPoint, sized};
use crate::solve::rotation::SLOTS;
use crate::start::StartOrder;
use crate::tape::Eight;

/// The derivatives of a cost of a [`Path`], in units of the cost per unit of the variable.
///
/// The derivatives by a rotation, and by its angular velocity, are covectors of three numbers in the frame of
/// its body, behind a zero: a turn of the first node by `δq = ½ q∘(0, ξ)` changes the cost by the inner
/// product of the three numbers in `q0` with `ξ`.
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
    /// The derivatives with respect to the parameters, in the order of [`System::PARAMETERS`](crate::System::PARAMETERS). Each parameter
    /// changes throughout the run. For an input this is the sum over the legs.
    pub parameters: Vec<f64>,
    /// The derivatives with respect to the inputs of a [`Path::plan`]: `inputs[k][j]` belongs to input `j` on the leg from node `k`. Empty for
    /// other paths.
    pub inputs: Vec<Vec<f64>>,
}

impl<const N: usize> Gradient<N> {
    /// The gradient with the number of coordinates.
    fn of(any: AnyGradient) -> Self {
        Self {
            cost: any.cost,
            q0: sized(&any.q0),
            v0: sized(&any.v0),
            q1: sized(&any.q1),
            parameters: any.parameters,
            inputs: any.inputs,
        }
    }
}

/// A [`Gradient`] with any number of coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct AnyGradient {
    /// The cost.
    pub cost: f64,
    /// The derivatives with respect to the first node.
    pub q0: Vec<f64>,
    /// The derivatives with respect to the velocity at the start.
    pub v0: Vec<f64>,
    /// The derivatives with respect to the second node.
    pub q1: Vec<f64>,
    /// The derivatives with respect to the parameters, in the order of [`Shape::parameters`](crate::Shape::parameters).
    pub parameters: Vec<f64>,
    /// The derivatives with respect to the inputs of a plan.
    pub inputs: Vec<Vec<f64>>,
}

/// The cost of a node, by its number. It fills in the derivatives by position, velocity and acceleration, one
/// after the other, and returns the cost, and whether a derivative is nonzero.
type Cost<'a> = dyn FnMut(usize, AnyPoint<'_, f64>, &mut [f64]) -> (f64, bool) + 'a;

impl<const N: usize> Path<'_, N> {
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
    /// For a rotation, `node.q` has the four numbers of its quaternion. Only the changes of the cost by turns are used, so the cost may
    /// depend on the norm in any way.
    ///
    /// # Errors
    ///
    /// [`DerivativeError`] if a step or the start has no derivative.
    pub fn gradient(
        &self,
        cost: &mut dyn FnMut(usize, &Point<Dual<f64>, N>) -> Dual<f64>,
    ) -> Result<Gradient<N>, DerivativeError> {
        let mut cost = |index: usize, node: AnyPoint<'_, Dual<f64>>| cost(index, &moving(node));
        self.any.gradient_from(0, &mut cost).map(Gradient::of)
    }

    /// The gradient of a cost that depends only on the last node.
    ///
    /// # Errors
    ///
    /// The errors of [`Path::gradient`].
    pub fn gradient_at_end(
        &self,
        cost: &mut dyn FnMut(&Point<Dual<f64>, N>) -> Dual<f64>,
    ) -> Result<Gradient<N>, DerivativeError> {
        let mut cost = |_: usize, end: AnyPoint<'_, Dual<f64>>| cost(&moving(end));
        self.any.gradient_from(self.steps(), &mut cost).map(Gradient::of)
    }
}

/// A point of dual numbers as arrays.
fn moving<const N: usize>(point: AnyPoint<'_, Dual<f64>>) -> Point<Dual<f64>, N> {
    let sized = |x: &[Dual<f64>]| x.first_chunk().copied().unwrap_or([Dual::new(f64::NAN, 0.0); N]);
    Point {
        t: point.t,
        q: sized(point.q),
        v: sized(point.v),
        a: sized(point.a),
    }
}

impl AnyPath<'_> {
    /// The gradient of a cost that is a sum over all nodes, from the start to the last; see [`Path::gradient`].
    ///
    /// # Errors
    ///
    /// The errors of [`Path::gradient`].
    pub fn gradient(
        &self,
        cost: &mut dyn FnMut(usize, AnyPoint<'_, Dual<f64>>) -> Dual<f64>,
    ) -> Result<AnyGradient, DerivativeError> {
        self.gradient_from(0, cost)
    }

    /// The gradient of a cost that depends only on the last node.
    ///
    /// # Errors
    ///
    /// The errors of [`AnyPath::gradient`].
    pub fn gradient_at_end(
        &self,
        cost: &mut dyn FnMut(AnyPoint<'_, Dual<f64>>) -> Dual<f64>,
    ) -> Result<AnyGradient, DerivativeError> {
        self.gradient_from(self.steps(), &mut |_, end| cost(end))
    }

    /// The gradient of a cost of the nodes from `first` on.
    fn gradient_from(
        &self,
        first: usize,
        cost: &mut dyn FnMut(usize, AnyPoint<'_, Dual<f64>>) -> Dual<f64>,
    ) -> Result<AnyGradient, DerivativeError> {
        let mut room = Vec::new();
        let rotations = self.recording.rotations();
        let mut of_node = |index: usize, point: AnyPoint<'_, f64>, slopes: &mut [f64]| {
            of_node((index, point), rotations, slopes, &mut room, cost)
        };
        backward(&self.recording, &mut of_node, first)
    }
}

/// Evaluates the cost of a node: see [`Cost`].
fn of_node(
    (index, point): (usize, AnyPoint<'_, f64>),
    rotations: &[usize],
    slopes: &mut [f64],
    room: &mut Vec<Dual<f64>>,
    cost: &mut dyn FnMut(usize, AnyPoint<'_, Dual<f64>>) -> Dual<f64>,
) -> (f64, bool) {
    let n = point.q.len();
    room.clear();
    let vectors = [point.q, point.v, point.a].into_iter().flatten();
    room.extend(vectors.map(|&x| Dual::new(x, 0.0)));
    let mut at = |numbers: &[Dual<f64>]| cost(index, point_of(Dual::new(point.t, 0.0), numbers));
    // few costs depend on the acceleration: with NaN as its rate, the result is NaN only if the cost does
    for a in &mut room[2 * n..] {
        a.eps = f64::NAN;
    }
    let probe = at(room);
    for a in &mut room[2 * n..] {
        a.eps = 0.0;
    }
    let parts = if probe.eps.is_nan() { 3 } else { 2 };
    slopes.fill(0.0);
    let mut depends = false;
    for (place, slope) in slopes.iter_mut().enumerate().take(parts * n) {
        let mut own = rotations.iter();
        if let Some(&first) = own.find(|&&first| (first..first + SLOTS).contains(&(place % n))) {
            // the zero in front of a turn has no derivative
            if place % n == first {
                continue;
            }
            if place < n {
                for (i, rate) in turning::along(rotations, point.q, place).iter().enumerate() {
                    room[i].eps = *rate;
                }
                *slope = at(room).eps;
                for number in &mut room[first..first + SLOTS] {
                    number.eps = 0.0;
                }
                depends |= *slope != 0.0;
                continue;
            }
        }
        room[place].eps = 1.0;
        *slope = at(room).eps;
        room[place].eps = 0.0;
        depends |= *slope != 0.0;
    }
    (probe.re, depends)
}

/// The cost of nodes, and its derivatives.
struct Costs<'a, 'c> {
    /// The cost of a node.
    cost: &'a mut Cost<'c>,
    /// The first node that has a cost.
    from: usize,
    /// The sum over all nodes so far.
    sum: f64,
    /// The derivatives of the last cost by position, velocity and acceleration.
    slopes: Vec<f64>,
}

impl Costs<'_, '_> {
    /// Adds the cost of a node. Returns whether it depends on the point: then [`Costs::slopes`] has the
    /// derivatives.
    fn add(&mut self, index: usize, point: AnyPoint<'_, f64>) -> bool {
        let (cost, depends) = (self.cost)(index, point, &mut self.slopes);
        self.sum += cost;
        depends
    }
}

/// The derivatives of the cost by the first two nodes of a piece, and by the parameters.
struct Adjoint {
    /// The derivatives by the node and by the increment of the step after.
    q: Vec<f64>,
    d: Vec<f64>,
    /// The derivative by the second difference of the last step; workspace.
    e: Vec<f64>,
    /// The derivatives by the parameters, stretch by stretch.
    parameters: Vec<Vec<f64>>,
}

impl Adjoint {
    /// Propagates the derivatives back through a step, over the leg to its last node, to the derivative by its second difference. `of_node`
    /// is the direct derivative of the last node's cost, in the first lane.
    fn by_e(&mut self, of_node: &[Eight], (rotations, increment): (&[usize], &[f64])) {
        let n = self.e.len();
        let mut legs = Vec::new();
        turning::legs(rotations, |i| Eight::splat(increment[i]), &mut legs);
        turning::back(rotations, &legs, 0, &mut self.q, &mut self.d);
        let (d, of_node) = (&self.d[..n], &of_node[..n]);
        for i in 0..n {
            self.e[i] = d[i] + of_node[i].0[0];
        }
    }
}

/// Propagates the derivatives of the cost from the end to the start. Nodes before `from` have no cost.
#[expect(clippy::too_many_lines, reason = "one pass over the steps")]
fn backward(
    recording: &Recording<'_>,
    cost: &mut Cost<'_>,
    from: usize,
) -> Result<AnyGradient, DerivativeError> {
    let motion = &recording.motion()?;
    let (n, count) = (motion.dimension(), motion.equations.parameters);
    for parameter in 0..count {
        recording.has_derivative_by(parameter)?;
    }
    let (mut rooms, mut block) = (Rooms::default(), Block::default());
    let mut costs = Costs {
        cost,
        from,
        sum: 0.0,
        slopes: vec![0.0; 3 * n],
    };
    let mut adjoint = Adjoint {
        q: vec![0.0; n],
        d: vec![0.0; n],
        e: vec![0.0; n],
        parameters: vec![vec![0.0; count]; motion.stretches()],
    };
    let mut current: Option<(usize, Vec<Eight>)> = None;
    // by position, velocity and acceleration: the points of a piece, and the derivatives of their costs
    let (mut points, mut weights) = (vec![Eight::ZERO; 3 * n], vec![Eight::ZERO; 3 * n]);
    let mut point = vec![0.0; 3 * n];
    // the derivatives of the nodes' costs by node, increment and second difference
    let mut of_both = [vec![Eight::ZERO; 3 * n], vec![Eight::ZERO; 3 * n]];
    let mut room = vec![Eight::ZERO; 3 * n];
    let mut by_e = vec![Eight::ZERO; n];
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
            let changed = match piece {
                Piece::Plain { .. } => None,
                Piece::Changed { .. } => Some(motion.changed(&window, first, stretch)?),
            };
            let record = changed
                .as_ref()
                .map(|changed| motion.arriving(&window, first, changed));
            // where parameters change, position and velocity are those at the end of the leg with the old
            // values
            let arriving = record.as_ref().map(|record| Steps {
                recorded: record.steps(first..first + 1),
                ..steps
            });
            let passes = match &arriving {
                Some(arriving) => [Some((&steps, 2 * n..3 * n)), Some((arriving, 0..2 * n))],
                None => [Some((&steps, 0..3 * n)), None],
            };
            let mut depends = false;
            if first + count > from {
                for (steps, range) in passes.iter().flatten() {
                    motion.equations.points(steps, &mut rooms, &mut room);
                    points[range.clone()].copy_from_slice(&room[range.clone()]);
                }
                depends = weigh(
                    motion,
                    &mut costs,
                    (first, count),
                    &points,
                    &mut point,
                    &mut weights,
                );
            }
            for (pass, of_nodes) in passes.iter().zip(&mut of_both) {
                of_nodes.fill(Eight::ZERO);
                let (Some((steps, range)), true) = (pass, depends) else {
                    continue;
                };
                if changed.is_some() {
                    motion.equations.points(steps, &mut rooms, &mut room);
                }
                room.fill(Eight::ZERO);
                room[range.clone()].copy_from_slice(&weights[range.clone()]);
                let lanes = Eight::from_fn(|lane| f64::from(u8::from(lane < count)));
                motion
                    .equations
                    .back_from_points(&mut rooms, &room, &mut |role, slope| {
                        let to = match role {
                            Role::Node(i) => &mut of_nodes[i],
                            Role::Increment(i) => &mut of_nodes[n + i],
                            Role::Difference(i) => &mut of_nodes[2 * n + i],
                            Role::Fixed(k) => {
                                by_fixed[k] = by_fixed[k] + slope * lanes;
                                return;
                            }
                            Role::Unknown(_) | Role::Still => return,
                        };
                        *to = *to + slope;
                    });
            }
            if let Some(changed) = &changed {
                adjoint.by_e(
                    &of_both[0][2 * n..],
                    (&motion.equations.rotations, &changed.increment),
                );
                let Adjoint { q, d, e, parameters } = &mut adjoint;
                for of_nodes in &of_both {
                    for j in 0..n {
                        q[j] += of_nodes[j].0[0];
                        d[j] += of_nodes[n + j].0[0];
                    }
                }
                let old: Vec<f64> = of_both[1][2 * n..].iter().map(|lanes| lanes.0[0]).collect();
                changed.slopes.back(e, [q, d], |side, place, slope| {
                    parameters[stretch - 1 + side][place] += slope;
                });
                changed.of_arriving.back(&old, [q, d], |_, place, slope| {
                    parameters[stretch - 1][place] += slope;
                });
            } else {
                let linearized = motion.equations.linearize(&steps, &mut rooms, &mut block);
                linearized.map_err(|lane| motion.singular(first + lane))?;
                let rotations = &motion.equations.rotations;
                back(&mut adjoint, (&block, rotations), &of_both[0], count, &mut by_e);
                block.add_by_fixed(&motion.equations, &by_e, by_fixed);
            }
        }
    }
    leave(motion, current.take(), &mut rooms, &mut adjoint);
    Ok(begin(motion, costs, adjoint))
}

/// Sums up the derivatives by constants and parameters of a stretch.
fn leave(
    motion: &Motion<'_>,
    stretch: Option<(usize, Vec<Eight>)>,
    rooms: &mut Rooms,
    adjoint: &mut Adjoint,
) {
    let Some((stretch, by_fixed)) = stretch else {
        return;
    };
    let by_fixed: Vec<f64> = by_fixed.iter().map(|lanes| lanes.0.iter().sum()).collect();
    let (declaration, h) = (motion.declaration(stretch), motion.recording.h);
    let parameters = motion.equations.of_parameters(declaration, h, rooms, &by_fixed);
    for (sum, own) in adjoint.parameters[stretch].iter_mut().zip(parameters) {
        *sum += own;
    }
}

/// Evaluates the costs of some nodes. Returns whether they depend on the points: then `weights` has the
/// derivatives by these.
fn weigh(
    motion: &Motion<'_>,
    costs: &mut Costs<'_, '_>,
    (first, count): (usize, usize),
    points: &[Eight],
    point: &mut [f64],
    weights: &mut [Eight],
) -> bool {
    let mut depends = false;
    let from = costs.from;
    for lane in (0..count).rev().filter(|lane| first + lane >= from) {
        for (to, from) in point.iter_mut().zip(points) {
            *to = from.0[lane];
        }
        if !costs.add(first + lane, point_of(motion.time(first + lane), point)) {
            continue;
        }
        if !depends {
            weights.fill(Eight::ZERO);
            depends = true;
        }
        for (weight, slope) in weights.iter_mut().zip(&costs.slopes) {
            weight.0[lane] = *slope;
        }
    }
    depends
}

/// Goes back through a block, to the derivatives by the second differences.
fn back(
    adjoint: &mut Adjoint,
    block: (&Block, &[usize]),
    of_nodes: &[Eight],
    count: usize,
    all: &mut [Eight],
) {
    // short loops of a length known to the compiler
    match all.len() {
        1 => back_of(1, adjoint, block, of_nodes, count, all),
        2 => back_of(2, adjoint, block, of_nodes, count, all),
        3 => back_of(3, adjoint, block, of_nodes, count, all),
        4 => back_of(4, adjoint, block, of_nodes, count, all),
        n => back_of(n, adjoint, block, of_nodes, count, all),
    }
}

/// [`back`] with `n` coordinates.
#[allow(clippy::inline_always)] // makes a literal `n` a constant
#[inline(always)]
fn back_of(
    n: usize,
    adjoint: &mut Adjoint,
    (block, rotations): (&Block, &[usize]),
    of_nodes: &[Eight],
    count: usize,
    all: &mut [Eight],
) {
    all.fill(Eight::ZERO);
    let Adjoint { q, d, e, .. } = adjoint;
    let (q, d, e, all) = (&mut q[..n], &mut d[..n], &mut e[..n], &mut all[..n]);
    let (slopes, of_nodes) = (&block.slopes()[..2 * n * n], &of_nodes[..3 * n]);
    for lane in (0..count.min(Eight::COUNT)).rev() {
        if rotations.is_empty() {
            for i in 0..n {
                d[i] += q[i];
            }
        } else {
            turning::back(rotations, block.legs(), lane, q, d);
        }
        for i in 0..n {
            e[i] = d[i] + of_nodes[2 * n + i].0[lane];
            all[i].0[lane] = e[i];
        }
        for j in 0..n {
            let (mut by_q, mut by_d) = (of_nodes[j].0[lane], of_nodes[n + j].0[lane]);
            for i in 0..n {
                let row = &slopes[2 * n * i..2 * n * (i + 1)];
                by_q += e[i] * row[j].0[lane];
                by_d += e[i] * row[n + j].0[lane];
            }
            q[j] += by_q;
            d[j] += by_d;
        }
    }
}

/// The gradient at the start, from the derivatives by the first step.
fn begin(motion: &Motion<'_>, mut costs: Costs<'_, '_>, adjoint: Adjoint) -> AnyGradient {
    let (n, recording) = (motion.dimension(), motion.recording);
    let Adjoint {
        mut q,
        mut d,
        parameters: mut by_stretch,
        ..
    } = adjoint;
    let (first, rotations) = (&recording.first, &motion.equations.rotations[..]);
    let (mut q0, mut v0, mut q1) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    if costs.from == 0 && costs.add(0, first_point(motion, &vec![f64::NAN; n])) {
        let (by_q, rest) = costs.slopes.split_at(n);
        let (by_v, by_a) = rest.split_at(n);
        q0.copy_from_slice(by_q);
        v0.copy_from_slice(by_v);
        if let Some((_, slopes)) = &motion.at_start.acceleration {
            slopes.add(by_a, &mut q0, &mut v0, &mut by_stretch[0]);
        }
    }
    if first.order == StartOrder::Nodes {
        for i in 0..n {
            d[i] += v0[i] / recording.h;
        }
        StartDerivatives::back_from_increment_of_nodes(rotations, &first.d, &d, [&mut q0, &mut q]);
        (q1, v0) = (q, vec![0.0; n]);
    } else {
        // the start is the beginning of the first step's increment
        let mut legs = Vec::new();
        turning::legs(rotations, |i| Eight::splat(first.d[i]), &mut legs);
        turning::back(rotations, &legs, 0, &mut q, &mut d);
        for i in 0..n {
            q0[i] += q[i];
        }
        if let Some([position, velocity]) = &motion.at_start.projection {
            let (by_q, by_v) = (q0, v0);
            (q0, v0) = (vec![0.0; n], vec![0.0; n]);
            position.add(&by_q, &mut q0, &mut v0, &mut by_stretch[0]);
            velocity.add(&by_v, &mut q0, &mut v0, &mut by_stretch[0]);
        }
        let increment = &motion.at_start.increment;
        increment.add(&d, &mut q0, &mut v0, &mut by_stretch[0]);
    }
    for &first in rotations {
        (q0[first], v0[first], q1[first]) = (0.0, 0.0, 0.0);
    }
    let mut parameters = vec![0.0; motion.equations.parameters];
    for own in &by_stretch {
        for (sum, own) in parameters.iter_mut().zip(own) {
            *sum += own;
        }
    }
    let inputs = by_stretch
        .iter()
        .take(recording.legs())
        .map(|own| recording.inputs.iter().map(|&place| own[place]).collect())
        .collect();
    AnyGradient {
        cost: costs.sum,
        q0,
        v0,
        q1,
        parameters,
        inputs,
    }
}
