//! Forward: the changes of the nodes, from the start to the end.

use super::block::{Block, Role, Rooms};
use super::error::DerivativeError;
use super::path::{Motion, Path, Piece};
use crate::start::StartOrder;
use crate::system::{Point, System};
use crate::tape::Eight;

/// A variable with respect to which a run is differentiated. All other variables stay fixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable<'v> {
    /// A coordinate of the first node. The velocity at the start stays fixed, or the second node if the start is
    /// [`Start::nodes`](crate::Start::nodes).
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
/// unit of the variable.
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
    /// No change.
    const ZERO: Self = Self {
        q: [0.0; N],
        v: [0.0; N],
        a: [0.0; N],
    };
}

/// A variable after its name and indices were looked up.
#[derive(Clone, Copy, Debug)]
struct Moving<const N: usize> {
    q0: [f64; N],
    /// Of the velocity or of the second node.
    second: [f64; N],
    parameter: Option<usize>,
    /// The stretch on which the parameter changes; `None` for all.
    stretch: Option<usize>,
}

impl<const N: usize> Moving<N> {
    /// The rate of change of a parameter on a stretch: 1 or 0.
    fn rate(&self, stretch: usize, place: usize) -> f64 {
        let moves = self.parameter == Some(place) && self.stretch.is_none_or(|own| own == stretch);
        f64::from(u8::from(moves))
    }

    /// Whether a parameter changes on a stretch.
    fn moves(&self, stretch: usize) -> bool {
        self.parameter.is_some() && self.stretch.is_none_or(|own| own == stretch)
    }
}

/// A function that gets each node with its tangents.
type Visit<'a, const N: usize> = dyn FnMut(usize, &Point<f64, N>, &[NodeTangent<N>]) + 'a;

impl<S: System<N>, const N: usize> Path<'_, S, N> {
    /// The derivatives of the last node, one for each variable.
    ///
    /// The first variable takes about as long as a run. Each further variable takes little time, because the steps are linearized once for all
    /// variables.
    ///
    /// # Errors
    ///
    /// [`DerivativeError`] if a variable is unknown, or if a step or the start has no derivative.
    pub fn tangents(&self, variables: &[Variable<'_>]) -> Result<Vec<NodeTangent<N>>, DerivativeError> {
        forward(&self.motion()?, &self.found(variables)?, None)
    }

    /// Calls `visit` at every node, from the start to the last. It gets the number of the node, its time, position, velocity and
    /// acceleration, and their derivatives, one for each variable.
    ///
    /// # Errors
    ///
    /// As [`Path::tangents`].
    pub fn tangents_along(
        &self,
        variables: &[Variable<'_>],
        visit: &mut dyn FnMut(usize, &Point<f64, N>, &[NodeTangent<N>]),
    ) -> Result<(), DerivativeError> {
        forward(&self.motion()?, &self.found(variables)?, Some(visit)).map(|_| ())
    }

    /// The variables after their names and indices were looked up.
    fn found(&self, variables: &[Variable<'_>]) -> Result<Vec<Moving<N>>, DerivativeError> {
        variables.iter().map(|variable| self.find(*variable)).collect()
    }

    fn find(&self, variable: Variable<'_>) -> Result<Moving<N>, DerivativeError> {
        let nodes = self.order() == StartOrder::Nodes;
        let still = Moving {
            q0: [0.0; N],
            second: [0.0; N],
            parameter: None,
            stretch: None,
        };
        let along = |index: usize| {
            if index >= N {
                let what = "coordinate";
                return Err(DerivativeError::Index {
                    what,
                    index,
                    count: N,
                });
            }
            Ok(core::array::from_fn(|i| f64::from(u8::from(i == index))))
        };
        Ok(match variable {
            Variable::Position(index) => Moving {
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
            Variable::Velocity(index) | Variable::SecondNode(index) => Moving {
                second: along(index)?,
                ..still
            },
            Variable::Parameter(name) => Moving {
                parameter: Some(Self::parameter(name)?),
                ..still
            },
            Variable::Input { name, leg } => {
                let place = Self::parameter(name)?;
                if !self.input_places().contains(&place) {
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
                Moving {
                    parameter: Some(place),
                    stretch: Some(leg),
                    ..still
                }
            }
        })
    }
}

/// The changes of the first two nodes of a step.
#[derive(Clone, Copy)]
struct State<const N: usize> {
    q: [f64; N],
    d: [f64; N],
}

impl<const N: usize> State<N> {
    /// Goes on to the next step.
    fn go_on(&mut self, e: &[f64; N]) {
        for i in 0..N {
            self.d[i] += e[i];
            self.q[i] += self.d[i];
        }
    }
}

/// Computes the changes from the start to the end.
fn forward<const N: usize>(
    motion: &Motion<'_, N>,
    variables: &[Moving<N>],
    mut visit: Option<&mut Visit<'_, N>>,
) -> Result<Vec<NodeTangent<N>>, DerivativeError> {
    let (mut rooms, mut block) = (Rooms::default(), Block::new());
    let mut states = Vec::with_capacity(variables.len());
    let mut tangents = Vec::with_capacity(variables.len());
    for variable in variables {
        let (state, tangent) = begin(motion, variable);
        states.push(state);
        tangents.push(tangent);
    }
    if let Some(visit) = &mut visit {
        visit(0, &first_point(motion), &tangents);
    }
    let (mut moved, mut shown) = (Vec::with_capacity(variables.len()), Vec::new());
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
            // the change of each variable, lane by lane
            let is_shown = visit.is_some() || motion.is_last(piece);
            moved.clear();
            if let Piece::Plain { .. } = piece {
                let linearized = motion.equations.linearize(&steps, &mut rooms, &mut block);
                linearized.map_err(|lane| motion.singular(first + lane))?;
                for (state, change) in states.iter_mut().zip(changes) {
                    let by_fixed = match change {
                        Some(change) => block.by_change(&motion.equations, change),
                        None => [Eight::ZERO; N],
                    };
                    moved.push(along(state, &block, &by_fixed, count));
                }
            } else {
                let changed = motion.changed(&window, first, stretch)?;
                for (state, variable) in states.iter_mut().zip(variables) {
                    let before = *state;
                    let mut e = [0.0; N];
                    for (i, e) in e.iter_mut().enumerate() {
                        *e = (0..N)
                            .map(|j| {
                                changed.by_node[i][j] * state.q[j] + changed.by_increment[i][j] * state.d[j]
                            })
                            .sum();
                        for (side, slopes) in changed.by_parameters.iter().enumerate() {
                            for (place, slope) in slopes.iter().enumerate() {
                                *e += slope[i] * variable.rate(stretch - 1 + side, place);
                            }
                        }
                    }
                    state.go_on(&e);
                    moved.push([before.q, before.d, e].map(|x| x.map(Eight::splat)));
                }
            }
            if !is_shown {
                continue;
            }
            let points = motion.equations.points(&steps, &mut rooms);
            let width = variables.len();
            shown.resize(count * width, NodeTangent::ZERO);
            for (number, (moved, change)) in moved.iter().zip(changes).enumerate() {
                let points = motion
                    .equations
                    .change_points::<N>(&mut rooms, &|role| match role {
                        Role::Node(i) => moved[0][i],
                        Role::Increment(i) => moved[1][i],
                        Role::Difference(i) => moved[2][i],
                        Role::Fixed(k) => change
                            .as_ref()
                            .map_or(Eight::ZERO, |change| Eight::splat(change[k])),
                        Role::Unknown(_) | Role::Still => Eight::ZERO,
                    });
                for lane in 0..count {
                    let [q, v, a] = points.map(|x| x.map(|x| x.0[lane]));
                    shown[lane * width + number] = NodeTangent { q, v, a };
                }
            }
            if let Some(visit) = &mut visit {
                for lane in 0..count {
                    let [q, v, a] = points.map(|x| x.map(|x| x.0[lane]));
                    let t = motion.time(first + lane);
                    let own = &shown[lane * width..(lane + 1) * width];
                    visit(first + lane, &Point { t, q, v, a }, own);
                }
            }
            tangents.copy_from_slice(&shown[(count - 1) * width..]);
        }
    }
    Ok(tangents)
}

/// The changes of constants and parameters on a stretch, for each variable; `None` if they do not change.
fn changes<const N: usize>(
    motion: &Motion<'_, N>,
    variables: &[Moving<N>],
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
        let source = motion.declaration(stretch).source();
        let all = motion.equations.change_fixed(source, motion.h, rooms, &rate);
        changes.extend(some.iter().enumerate().map(|(lane, variable)| {
            let own = || all.iter().map(|change| change.0[lane]).collect();
            variable.moves(stretch).then(own)
        }));
    }
    changes
}

/// Carries a change through a block. Returns the changes of node, increment and second difference, one lane for each step.
fn along<const N: usize>(
    state: &mut State<N>,
    block: &Block<N>,
    by_fixed: &[Eight; N],
    count: usize,
) -> [[Eight; N]; 3] {
    let mut moved = [[Eight::ZERO; N]; 3];
    for lane in 0..count {
        let mut e = [0.0; N];
        for i in 0..N {
            let mut sum = by_fixed[i].0[lane];
            for j in 0..N {
                sum +=
                    block.by_node[i][j].0[lane] * state.q[j] + block.by_increment[i][j].0[lane] * state.d[j];
            }
            e[i] = sum;
            (moved[0][i].0[lane], moved[1][i].0[lane], moved[2][i].0[lane]) = (state.q[i], state.d[i], sum);
        }
        state.go_on(&e);
    }
    moved
}

/// The changes of the first two nodes, and the tangent at the start.
fn begin<const N: usize>(motion: &Motion<'_, N>, variable: &Moving<N>) -> (State<N>, NodeTangent<N>) {
    let begun = &motion.begun;
    let parameters: Vec<f64> = (0..motion.equations.parameters)
        .map(|place| variable.rate(0, place))
        .collect();
    let (d, v) = if begun.order == StartOrder::Nodes {
        let d: [f64; N] = core::array::from_fn(|i| variable.second[i] - variable.q0[i]);
        (d, d.map(|d| d / motion.h))
    } else {
        let d = begun
            .increment
            .change(&variable.q0, &variable.second, &parameters);
        (d, variable.second)
    };
    let a = match &begun.acceleration {
        Some((_, slopes)) => slopes.change(&variable.q0, &v, &parameters),
        None => [f64::NAN; N],
    };
    let q = core::array::from_fn(|i| variable.q0[i] + d[i]);
    (State { q, d }, NodeTangent { q: variable.q0, v, a })
}

/// The start as a point.
pub(super) fn first_point<const N: usize>(motion: &Motion<'_, N>) -> Point<f64, N> {
    let a = motion.begun.acceleration.as_ref();
    Point {
        t: motion.beginning.t0,
        q: motion.beginning.q0,
        v: motion.beginning.v0,
        a: a.map_or([f64::NAN; N], |(a, _)| *a),
    }
}
