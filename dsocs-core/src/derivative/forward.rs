//! Forward derivatives: the changes of the nodes, from the start to the end.

use super::block::{Block, Role, Rooms, Steps};
use super::error::DerivativeError;
use super::motion::{Motion, Piece, Recording};
use super::path::{AnyPath, Path, parameter};
use super::start::StartDerivatives;
use super::turning;
use crate::number::point::Point;
use crate::number::point::{AnyPoint, sized};
use crate::solve::rotation;
use crate::start::{self, StartOrder};
use crate::tape::Eight;

/// A variable with respect to which a run is differentiated. All other variables stay fixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable<'v> {
    /// A coordinate of the first node. The velocity at the start stays fixed, or the second node if the start is
    /// [`Start::nodes`](crate::Start::nodes). Of a rotation, whose quaternion begins at the place `i`, the places `i + 1`, `i + 2` and `i + 3` are the turns
    /// about the axes of its body, in rad, where the angular velocity in the frame of the body stays fixed.
    Position(usize),
    /// A component of the velocity at the start; not for [`Start::nodes`](crate::Start::nodes).
    Velocity(usize),
    /// A coordinate of the second node, only for [`Start::nodes`](crate::Start::nodes). The first node stays fixed.
    SecondNode(usize),
    /// A parameter, by its name. It changes throughout the run, even if it is an input.
    Parameter(&'v str),
    /// An input of a [`Path::plan`], by its name, on one leg.
    Input {
        /// The name.
        name: &'v str,
        /// The number of the leg's first node.
        leg: usize,
    },
}

/// The derivatives of a node with respect to a [`Variable`]. Their units are those of the coordinate, its velocity and its acceleration, per
/// unit of the variable. A rotation turns by `δq = ½ q∘(0, ξ)`: its four places have a zero and `ξ`, the turn in the frame of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeTangent<const N: usize> {
    /// The derivative of the position.
    pub q: [f64; N],
    /// The derivative of the velocity ([`Node::v`](crate::Node::v)).
    pub v: [f64; N],
    /// The derivative of the acceleration ([`Node::a`](crate::Node::a)).
    pub a: [f64; N],
}

impl<const N: usize> NodeTangent<N> {
    /// Splits the concatenated changes of position, velocity and acceleration.
    fn of(tangent: &[f64]) -> Self {
        let AnyTangent { q, v, a } = AnyTangent::of(tangent);
        Self {
            q: sized(q),
            v: sized(v),
            a: sized(a),
        }
    }
}

/// A [`NodeTangent`] with any number of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnyTangent<'a> {
    /// The derivative of the position.
    pub q: &'a [f64],
    /// The derivative of the velocity.
    pub v: &'a [f64],
    /// The derivative of the acceleration.
    pub a: &'a [f64],
}

impl<'a> AnyTangent<'a> {
    /// Splits the concatenated changes of position, velocity and acceleration.
    fn of(tangent: &'a [f64]) -> Self {
        let (q, rest) = tangent.split_at(tangent.len() / 3);
        let (v, a) = rest.split_at(q.len());
        Self { q, v, a }
    }
}

/// The derivatives of a node with respect to some variables, with any number of coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnedTangents {
    /// The number of components for one variable.
    width: usize,
    numbers: Vec<f64>,
}

impl OwnedTangents {
    /// The number of variables.
    #[must_use]
    pub fn len(&self) -> usize {
        self.iter().len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The derivatives with respect to one variable after the other.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = AnyTangent<'_>> {
        self.numbers.chunks_exact(self.width).map(AnyTangent::of)
    }

    /// The derivatives with respect to a variable, by its place.
    #[must_use]
    pub fn get(&self, variable: usize) -> Option<AnyTangent<'_>> {
        self.iter().nth(variable)
    }
}

/// The direction of a variable, after its name and indices were looked up.
#[derive(Clone, Debug)]
struct VariableDirection {
    /// The change of the first node.
    q0: Vec<f64>,
    /// The change of the velocity or of the second node.
    second: Vec<f64>,
    parameter: Option<usize>,
    /// The stretch on which the parameter changes; `None` for all.
    stretch: Option<usize>,
}

impl VariableDirection {
    /// The rate of change of a parameter on a stretch: 1 for the variable's own, otherwise 0.
    fn rate(&self, stretch: usize, place: usize) -> f64 {
        let moves = self.parameter == Some(place) && self.stretch.is_none_or(|own| own == stretch);
        f64::from(u8::from(moves))
    }

    /// Whether a parameter changes on a stretch.
    fn moves(&self, stretch: usize) -> bool {
        self.parameter.is_some() && self.stretch.is_none_or(|own| own == stretch)
    }
}

/// A function that receives each node with its tangents, the changes of position, velocity and acceleration.
type Visit<'a> = dyn FnMut(usize, AnyPoint<'_, f64>, &[f64]) + 'a;

impl<const N: usize> Path<'_, N> {
    /// The derivatives of the last node, one for each variable.
    ///
    /// The first variable takes about as long as a run. Each further variable takes little time, because the steps are linearized once for all
    /// variables.
    ///
    /// # Errors
    ///
    /// [`DerivativeError`] if a variable is unknown, or if a step or the start has no derivative.
    pub fn tangents(&self, variables: &[Variable<'_>]) -> Result<Vec<NodeTangent<N>>, DerivativeError> {
        let tangents = forward(&self.any.recording, variables, None)?;
        Ok(tangents.chunks(3 * N).map(NodeTangent::of).collect())
    }

    /// Calls `visit` at every node, from the start to the last. It gets the number of the node, its time, position, velocity and
    /// acceleration, and their derivatives, one for each variable.
    ///
    /// # Errors
    ///
    /// The errors of [`Path::tangents`].
    pub fn tangents_along(
        &self,
        variables: &[Variable<'_>],
        visit: &mut dyn FnMut(usize, &Point<f64, N>, &[NodeTangent<N>]),
    ) -> Result<(), DerivativeError> {
        let mut shown = Vec::with_capacity(variables.len());
        let mut visit = |index: usize, point: AnyPoint<'_, f64>, tangents: &[f64]| {
            shown.clear();
            shown.extend(tangents.chunks(3 * N).map(NodeTangent::of));
            visit(index, &Point::of(point), &shown);
        };
        forward(&self.any.recording, variables, Some(&mut visit)).map(|_| ())
    }
}

impl AnyPath<'_> {
    /// The derivatives of the last node; see [`Path::tangents`].
    ///
    /// # Errors
    ///
    /// The errors of [`Path::tangents`].
    pub fn tangents(&self, variables: &[Variable<'_>]) -> Result<OwnedTangents, DerivativeError> {
        let numbers = forward(&self.recording, variables, None)?;
        Ok(OwnedTangents {
            width: (3 * self.end().q.len()).max(1),
            numbers,
        })
    }

    /// Calls `visit` at every node, from the start to the last; see [`Path::tangents_along`]. The derivatives come one variable after the other.
    ///
    /// # Errors
    ///
    /// The errors of [`Path::tangents_along`].
    pub fn tangents_along(
        &self,
        variables: &[Variable<'_>],
        visit: &mut dyn FnMut(usize, AnyPoint<'_, f64>, &mut dyn Iterator<Item = AnyTangent<'_>>),
    ) -> Result<(), DerivativeError> {
        let width = (3 * self.end().q.len()).max(1);
        let mut visit = |index: usize, point: AnyPoint<'_, f64>, tangents: &[f64]| {
            visit(
                index,
                point,
                &mut tangents.chunks_exact(width).map(AnyTangent::of),
            );
        };
        forward(&self.recording, variables, Some(&mut visit)).map(|_| ())
    }
}

impl Recording<'_> {
    /// The variables after their names and indices were looked up.
    fn found(&self, variables: &[Variable<'_>]) -> Result<Vec<VariableDirection>, DerivativeError> {
        let found: Result<Vec<_>, _> = variables.iter().map(|variable| self.find(*variable)).collect();
        let found = found?;
        for parameter in found.iter().filter_map(|variable| variable.parameter) {
            self.has_derivative_by(parameter)?;
        }
        Ok(found)
    }

    fn find(&self, variable: Variable<'_>) -> Result<VariableDirection, DerivativeError> {
        let n = self.source.shape().dimension();
        let nodes = self.first.order == StartOrder::Nodes;
        let still = VariableDirection {
            q0: vec![0.0; n],
            second: vec![0.0; n],
            parameter: None,
            stretch: None,
        };
        let along = |index: usize| {
            if index >= n {
                let what = "coordinate";
                return Err(DerivativeError::Index {
                    what,
                    index,
                    count: n,
                });
            }
            if self.rotations().contains(&index) {
                return Err(DerivativeError::Scalar {
                    rotation: start::name_of_rotation(self.source.shape(), index),
                    index,
                });
            }
            Ok((0..n).map(|i| f64::from(u8::from(i == index))).collect())
        };
        Ok(match variable {
            Variable::Position(index) => VariableDirection {
                q0: along(index)?,
                ..still
            },
            Variable::Velocity(_) if nodes => {
                return Err(DerivativeError::Variable {
                    start: "two nodes",
                    variable: "velocity of its own",
                });
            }
            Variable::SecondNode(_) if !nodes => {
                return Err(DerivativeError::Variable {
                    start: "position and velocity",
                    variable: "second node of its own",
                });
            }
            Variable::Velocity(index) | Variable::SecondNode(index) => VariableDirection {
                second: along(index)?,
                ..still
            },
            Variable::Parameter(name) => VariableDirection {
                parameter: Some(parameter(name, self.parameters())?),
                ..still
            },
            Variable::Input { name, leg } => {
                let place = parameter(name, self.parameters())?;
                if !self.inputs.contains(&place) {
                    return Err(DerivativeError::Input {
                        name: name.to_owned(),
                        inputs: self.input_names(),
                    });
                }
                let count = self.legs();
                if leg >= count {
                    let what = "leg";
                    return Err(DerivativeError::Index {
                        what,
                        index: leg,
                        count,
                    });
                }
                VariableDirection {
                    parameter: Some(place),
                    stretch: Some(leg),
                    ..still
                }
            }
        })
    }
}

/// The changes of the first two nodes of a step.
struct State {
    q: Vec<f64>,
    d: Vec<f64>,
}

impl State {
    /// Moves on to the next step, over a leg with an increment.
    fn go_on(&mut self, rotations: &[usize], increment: &[f64], e: &[f64]) {
        for (d, e) in self.d.iter_mut().zip(e) {
            *d += e;
        }
        self.q = rotation::carried(rotations, increment, &self.q, &self.d);
    }
}

/// Computes the changes from the start to the end: those of position, velocity and acceleration for one variable after the other.
#[expect(clippy::too_many_lines, reason = "one pass over the steps")]
fn forward(
    recording: &Recording<'_>,
    variables: &[Variable<'_>],
    mut visit: Option<&mut Visit<'_>>,
) -> Result<Vec<f64>, DerivativeError> {
    let motion = &recording.motion()?;
    let variables = &recording.found(variables)?;
    let n = motion.dimension();
    let (mut rooms, mut block) = (Rooms::default(), Block::default());
    let mut states = Vec::with_capacity(variables.len());
    // the tangents of the variables at the nodes of a piece, lane by lane
    let width = 3 * n * variables.len();
    let mut tangents = Vec::with_capacity(width);
    for variable in variables {
        let (state, tangent) = begin(motion, variable);
        states.push(state);
        tangents.extend(tangent);
    }
    if let Some(visit) = &mut visit {
        visit(0, first_point(motion, &vec![f64::NAN; n]), &tangents);
    }
    // for each variable, the changes of node, increment and second difference, one lane for each step
    let mut moved = vec![Eight::ZERO; width];
    let mut by_fixed = vec![Eight::ZERO; n];
    let mut e = vec![0.0; n];
    let mut arrived = moved.clone();
    let (mut points, mut room) = (vec![Eight::ZERO; 3 * n], vec![Eight::ZERO; 3 * n]);
    let (mut shown, mut point) = (Vec::new(), vec![0.0; 3 * n]);
    let mut entered: Option<(usize, Vec<Option<Vec<f64>>>)> = None;
    for window in 0..motion.windows() {
        let window = motion.window(window)?;
        for piece in &motion.pieces(&window) {
            let (first, count, stretch) = piece.steps();
            if entered.as_ref().is_none_or(|(own, _)| *own != stretch) {
                motion.enter(stretch, &mut rooms);
                entered = Some((stretch, changes(motion, variables, stretch, &mut rooms)));
            }
            let Some((_, changes)) = &entered else {
                continue;
            };
            let steps = motion.some(&window, piece);
            let is_shown = visit.is_some() || motion.is_last(piece);
            let mut before = None;
            if let Piece::Plain { .. } = piece {
                let linearized = motion.equations.linearize(&steps, &mut rooms, &mut block);
                linearized.map_err(|lane| motion.singular(first + lane))?;
                for ((state, change), moved) in states.iter_mut().zip(changes).zip(moved.chunks_mut(3 * n)) {
                    match change {
                        Some(change) => block.by_change(&motion.equations, change, &mut by_fixed),
                        None => by_fixed.fill(Eight::ZERO),
                    }
                    let rotations = &motion.equations.rotations;
                    along(state, (&block, rotations), &by_fixed, count, &mut e, moved);
                }
            } else {
                let changed = motion.changed(&window, first, stretch)?;
                let record = motion.arriving(&window, first, &changed);
                let both = moved.chunks_mut(3 * n).zip(arrived.chunks_mut(3 * n));
                for ((state, variable), (moved, arriving)) in states.iter_mut().zip(variables).zip(both) {
                    let rate = |side: usize, place: usize| variable.rate(stretch - 1 + side, place);
                    let e = changed.slopes.change(&state.q, &state.d, rate);
                    // the second difference with the old values on both sides, to which the velocity of the node belongs
                    let old = changed
                        .of_arriving
                        .change(&state.q, &state.d, |_, place| rate(0, place));
                    for (moved, e) in [(moved, &e), (arriving, &old)] {
                        let own = state.q.iter().chain(&state.d).chain(e);
                        for (moved, own) in moved.iter_mut().zip(own) {
                            *moved = Eight::splat(*own);
                        }
                    }
                    state.go_on(&motion.equations.rotations, &changed.increment, &e);
                }
                before = Some(record);
            }
            if !is_shown {
                continue;
            }
            shown.resize(count * width, 0.0);
            // where parameters change, position and velocity are those at the end of the leg with the old
            // values
            let arriving = before.as_ref().map(|record| Steps {
                recorded: record.steps(first..first + 1),
                ..steps
            });
            let passes = match &arriving {
                Some(arriving) => [
                    Some((&steps, &moved, 2 * n..3 * n)),
                    Some((arriving, &arrived, 0..2 * n)),
                ],
                None => [Some((&steps, &moved, 0..3 * n)), None],
            };
            for (steps, moved, range) in passes.into_iter().flatten() {
                motion.equations.points(steps, &mut rooms, &mut room);
                points[range.clone()].copy_from_slice(&room[range.clone()]);
                for (number, (moved, change)) in moved.chunks(3 * n).zip(changes).enumerate() {
                    let change = |role| match role {
                        Role::Node(i) => moved[i],
                        Role::Increment(i) => moved[n + i],
                        Role::Difference(i) => moved[2 * n + i],
                        Role::Fixed(k) => change
                            .as_ref()
                            .map_or(Eight::ZERO, |change| Eight::splat(change[k])),
                        Role::Unknown(_) | Role::Still => Eight::ZERO,
                    };
                    motion.equations.change_points(&mut rooms, &change, &mut room);
                    for lane in 0..count {
                        let own = &mut shown[lane * width + 3 * n * number..];
                        for i in range.clone() {
                            own[i] = room[i].0[lane];
                        }
                    }
                }
            }
            if let Some(visit) = &mut visit {
                for lane in 0..count {
                    for (to, from) in point.iter_mut().zip(&points) {
                        *to = from.0[lane];
                    }
                    let own = &shown[lane * width..(lane + 1) * width];
                    visit(first + lane, point_of(motion.time(first + lane), &point), own);
                }
            }
            tangents.copy_from_slice(&shown[(count - 1) * width..count * width]);
        }
    }
    Ok(tangents)
}

/// The changes of constants and parameters on a stretch, for each variable; `None` if they do not change.
fn changes(
    motion: &Motion<'_>,
    variables: &[VariableDirection],
    stretch: usize,
    rooms: &mut Rooms,
) -> Vec<Option<Vec<f64>>> {
    let mut changes = Vec::with_capacity(variables.len());
    for some in variables.chunks(Eight::COUNT) {
        if !some.iter().any(|variable| variable.moves(stretch)) {
            changes.extend(some.iter().map(|_| None));
            continue;
        }
        let rate = |place: usize| {
            Eight::from_fn(|lane| {
                some.get(lane)
                    .map_or(0.0, |variable| variable.rate(stretch, place))
            })
        };
        let declaration = motion.declaration(stretch);
        let h = motion.recording.h;
        let all = motion.equations.change_fixed(declaration, h, rooms, &rate);
        changes.extend(some.iter().enumerate().map(|(lane, variable)| {
            let own = || all.iter().map(|change| change.0[lane]).collect();
            variable.moves(stretch).then(own)
        }));
    }
    changes
}

/// Propagates a change through a block. Fills in the changes of node, increment and second difference, one
/// lane for each step; `e` is workspace.
fn along(
    state: &mut State,
    (block, rotations): (&Block, &[usize]),
    by_fixed: &[Eight],
    count: usize,
    e: &mut [f64],
    moved: &mut [Eight],
) {
    let all = (state, (block, rotations), by_fixed, count, e, moved);
    // short loops of a length known to the compiler
    match by_fixed.len() {
        1 => along_of(1, all),
        2 => along_of(2, all),
        3 => along_of(3, all),
        4 => along_of(4, all),
        n => along_of(n, all),
    }
}

/// [`along`] with `n` coordinates.
#[allow(clippy::inline_always, clippy::type_complexity)] // makes a literal `n` a constant
#[inline(always)]
fn along_of(
    n: usize,
    (state, (block, rotations), by_fixed, count, e, moved): (
        &mut State,
        (&Block, &[usize]),
        &[Eight],
        usize,
        &mut [f64],
        &mut [Eight],
    ),
) {
    moved.fill(Eight::ZERO);
    let slopes = block.slopes();
    let (nodes, rest) = moved.split_at_mut(n);
    let (increments, differences) = rest.split_at_mut(n);
    let (q, d, e) = (&mut state.q[..n], &mut state.d[..n], &mut e[..n]);
    let (differences, by_fixed, slopes) = (&mut differences[..n], &by_fixed[..n], &slopes[..2 * n * n]);
    for lane in 0..count.min(Eight::COUNT) {
        for i in 0..n {
            let row = &slopes[2 * n * i..2 * n * (i + 1)];
            let mut sum = by_fixed[i].0[lane];
            for j in 0..n {
                sum += row[j].0[lane] * q[j] + row[n + j].0[lane] * d[j];
            }
            e[i] = sum;
            nodes[i].0[lane] = q[i];
            increments[i].0[lane] = d[i];
            differences[i].0[lane] = sum;
        }
        for i in 0..n {
            d[i] += e[i];
        }
        if rotations.is_empty() {
            for i in 0..n {
                q[i] += d[i];
            }
        } else {
            turning::forward(rotations, block.legs(), lane, q, d);
        }
    }
}

/// The changes of the first two nodes, and the tangent at the start.
fn begin(motion: &Motion<'_>, variable: &VariableDirection) -> (State, Vec<f64>) {
    let (at_start, n) = (&motion.at_start, motion.dimension());
    let (first, rotations) = (&motion.recording.first, &motion.equations.rotations);
    let parameters: Vec<f64> = (0..motion.equations.parameters)
        .map(|place| variable.rate(0, place))
        .collect();
    let VariableDirection { q0, second, .. } = variable;
    let (d, v) = if first.order == StartOrder::Nodes {
        let d = StartDerivatives::increment_of_nodes(rotations, &first.d, [q0, second]);
        let v = d.iter().map(|d| d / motion.recording.h).collect();
        (d, v)
    } else {
        (at_start.increment.change(q0, second, &parameters), second.clone())
    };
    let (q0, v) = match &at_start.projection {
        Some(projection) => {
            let [q, v] = projection
                .each_ref()
                .map(|slopes| slopes.change(q0, second, &parameters));
            (q, v)
        }
        None => (q0.clone(), v),
    };
    let a = match &at_start.acceleration {
        Some((_, slopes)) => slopes.change(&q0, &v, &parameters),
        None => vec![f64::NAN; n],
    };
    let q = rotation::carried(rotations, &first.d, &q0, &d);
    (State { q, d }, [&q0[..], &v, &a].concat())
}

/// The start as a point, with `unknown` as the acceleration if none is known.
pub(super) fn first_point<'m>(motion: &'m Motion<'_>, unknown: &'m [f64]) -> AnyPoint<'m, f64> {
    let first = &motion.recording.first;
    let a = motion.at_start.acceleration.as_ref();
    AnyPoint {
        t: first.t0,
        q: &first.q0,
        v: &first.v0,
        a: a.map_or(unknown, |(a, _)| a),
    }
}

/// A point from position, velocity and acceleration, one after the other.
pub(super) fn point_of<T>(t: T, numbers: &[T]) -> AnyPoint<'_, T> {
    let n = numbers.len() / 3;
    let (q, rest) = numbers.split_at(n);
    let (v, a) = rest.split_at(n);
    AnyPoint { t, q, v, a }
}
