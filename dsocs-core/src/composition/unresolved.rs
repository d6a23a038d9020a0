//! Jumps of the acceleration in a composed step.
//!
//! The order of a composed step holds for a smooth motion. A jump between its legs leaves no trace in their
//! equations. So the arguments of piecewise functions are watched on its path. Steep functions and the user's
//! functions show in the acceleration at the next node, if it differs from its extrapolation: then
//! accelerations are examined on the path of the step and of the step before.

use super::run::Composed;
use super::stages::State;
use crate::number::largest;
use crate::number::point::AnyPoint;
use crate::run::Unresolved;
use crate::solve::Vector;
use crate::solve::predictor::Predictor;
use crate::solve::rotation;
use crate::start::place::{MotionPath, Place};
use crate::step::crossing::StepPath;
use crate::step::jumps;
use crate::step::smooth::NEAR_PREDICTION;
use crate::step::switches::{self, Crossing, LastArguments};
use crate::tape::declaration::Declaration;

/// An acceleration may vary by this many times what moves a node by one rounding, before it is examined.
const NOISE: f64 = 8.0;

/// A node.
#[derive(Clone, Debug)]
struct Node {
    /// The time.
    t: f64,
    /// Position.
    q: Vector,
    /// Velocity.
    v: Vector,
    /// Acceleration.
    a: Vector,
    /// The extrapolated acceleration at the next node.
    next: Option<Vector>,
}

impl Node {
    /// The point of the motion.
    fn point(&self) -> AnyPoint<'_, f64> {
        AnyPoint {
            t: self.t,
            q: &self.q,
            v: &self.v,
            a: &self.a,
        }
    }

    /// The node a time `h` later that is expected: the acceleration changes linearly to the extrapolated one.
    fn goes_on(&self, rotations: &[usize], h: f64) -> Option<Self> {
        let next = self.next.as_ref()?;
        let along = |i: usize| (self.v[i], self.a[i], next[i]);
        let displacement = Vector::from_fn(self.q.len(), |i| {
            let (v, a, next) = along(i);
            h * v + h * h * (a / 3.0 + next / 6.0)
        });
        Some(Self {
            t: self.t + h,
            q: rotation::moved_vector(rotations, &self.q, &displacement),
            v: Vector::from_fn(self.q.len(), |i| {
                let (v, a, next) = along(i);
                v + 0.5 * h * (a + next)
            }),
            a: next.clone(),
            next: None,
        })
    }
}

/// The last nodes, the last first, and the extrapolation of their accelerations.
#[derive(Clone, Debug)]
pub(super) struct RecentNodes {
    /// At most two nodes.
    nodes: Vec<Node>,
    /// The accelerations at the past nodes.
    accelerations: Predictor,
    /// Whether the last step has been examined.
    is_examined: bool,
    /// The arguments at the end of the step that was examined last.
    came: LastArguments,
    /// The number of the node at the end of that step.
    looked_at: u64,
    /// The number of the node before which arguments and tables of samples are evaluated again; `None` if
    /// there are none.
    next_examination: Option<u64>,
}

impl Composed<'_> {
    /// Begins to watch accelerations at the current node, if they may jump.
    pub(super) fn watch_anew(&mut self) {
        let shape = self.kernel.shape();
        if !shape.external_forces && !shape.switches {
            return;
        }
        let mut accelerations = Predictor::new(shape.increments);
        let declaration = self.declaration();
        accelerations.push(&self.run_state.now.a);
        self.watch = Some(Box::new(RecentNodes {
            nodes: vec![self.here()],
            accelerations,
            is_examined: true,
            came: LastArguments::unknown(&declaration),
            looked_at: 0,
            next_examination: declaration.is_switching().then_some(0),
        }));
    }

    /// The current node.
    fn here(&self) -> Node {
        let State { q, v, a } = &self.run_state.now;
        Node {
            t: self.run_state.clock.time(),
            q: q.hi.clone(),
            v: v.hi.clone(),
            a: a.clone(),
            next: None,
        }
    }

    /// Watches the acceleration at the end of a step.
    pub(super) fn watch(&mut self) {
        let Some(mut watch) = self.watch.take() else {
            return;
        };
        let mut here = self.here();
        let a = &self.run_state.now.a;
        let foreseen = watch.accelerations.is_near_prediction(a, NEAR_PREDICTION);
        watch.accelerations.push(a);
        here.next = watch.accelerations.predict();
        let index = self.run_state.clock.index();
        if let [last, before] = &watch.nodes[..]
            && !foreseen
            && !watch.is_examined
        {
            let mut came = LastArguments::unknown(&self.declaration());
            self.look_between([before, last], None, &mut came, true);
        }
        let is_to_look = watch
            .next_examination
            .is_some_and(|next_examination| next_examination <= index);
        if let Some(last) = watch.nodes.first()
            && (is_to_look || !foreseen)
        {
            if watch.looked_at + 1 != index {
                watch.came = LastArguments::unknown(&self.declaration());
            }
            let clear = self.look_between([last, &here], watch.nodes.get(1), &mut watch.came, !foreseen);
            watch.looked_at = index;
            watch.next_examination = watch.next_examination.map(|_| index + clear.max(1));
        }
        watch.is_examined = !foreseen;
        watch.nodes.insert(0, here);
        watch.nodes.truncate(2);
        self.watch = Some(watch);
    }

    /// Examines the path between two nodes for arguments that change their signs; if there are none and the acceleration was `unforeseen`,
    /// for jumps of the acceleration itself. Returns the number of steps of this length until arguments have to be evaluated again.
    #[cold]
    fn look_between(
        &mut self,
        [from, to]: [&Node; 2],
        before: Option<&Node>,
        came: &mut LastArguments,
        unforeseen: bool,
    ) -> u64 {
        let declaration = self.declaration();
        // a jump inside a leg can reverse the motion, before or beyond it, so that the path found shows no change of sign: the expected path
        // is examined, too
        let foreseen = from.goes_on(&self.kernel.shape().rotations, to.t - from.t);
        let mut start = came.clone();
        let [at_changes, at_features] = self.changes_between([from, to], before, came);
        let mut all = vec![at_changes, at_features];
        if at_changes.is_none_or(|part| part <= jumps::REPORTED)
            && let Some(to) = &foreseen
        {
            all.extend(self.changes_between([from, to], before, &mut start));
        }
        let mut part = all.into_iter().flatten().reduce(f64::max);
        let rotations = &self.kernel.shape().rotations;
        let ends = [from.point(), to.point()];
        let path = |part: f64| Place::on_hermite(rotations, ends, part);
        let clear = match part {
            Some(_) => 0,
            None => switches::clear_after(&declaration, &path),
        };
        let mut least = jumps::REPORTED;
        if part.is_none()
            && unforeseen
            && let Some(accelerations) = jumps::accelerations(&declaration, &path)
        {
            // a force that has found its balance varies by the rounding of the velocity, which the path has from differences of positions
            let noise = |i: usize| noise([from, to], i);
            (least, part) = (jumps::UNRESOLVED, Some(jumps::departure(&accelerations, noise)));
        }
        if let Some(part) = part
            && part > least
        {
            Unresolved::count(&mut self.unresolved, 0.5 * (from.t + to.t), part);
        }
        clear
    }

    /// The largest change of the acceleration between two nodes at changes of sign of arguments, and, if it is small, that at features that
    /// are narrower than the step; `None` if there are none.
    fn changes_between(
        &self,
        [from, to]: [&Node; 2],
        before: Option<&Node>,
        came: &mut LastArguments,
    ) -> [Option<f64>; 2] {
        let (h, declaration) = (to.t - from.t, self.declaration());
        let rotations = &self.kernel.shape().rotations;
        let path = |part: f64| Place::on_hermite(rotations, [from.point(), to.point()], part);
        let with_last = |part: f64| match before {
            Some(before) if part < 0.0 => {
                let length = (from.t - before.t) / h;
                Place::on_hermite(rotations, [before.point(), from.point()], 1.0 + part / length)
            }
            _ => path(part),
        };
        let (mut at_changes, mut at_features, mut all) = (None, None, Vec::new());
        for begin in [0.0, 0.5] {
            let half = |part: f64| path(begin + 0.5 * part);
            let found = switches::crossings(declaration, &half, &mut came.signs, |_, _| true);
            let on = on(&half, h, declaration);
            let changes = found.iter().map(|crossing| on.change_at(*crossing).size);
            at_changes = changes.chain(at_changes).reduce(f64::max);
            all.extend(found.iter().map(|crossing| Crossing {
                parts: crossing.parts.map(|part| begin + 0.5 * part),
                ..*crossing
            }));
        }
        if at_changes.is_none_or(|part: f64| part <= jumps::REPORTED) {
            let on = on(&with_last, h, declaration);
            let narrow = switches::narrow_places(&declaration, &path, |_, _| true).into_iter();
            let swings = narrow.map(|place| on.swings_at(place));
            let between = came.changes.between(&all).into_iter();
            let swings = swings.chain(between.filter_map(|place| on.deviation(place)));
            let swings = swings.filter(|swing| *swing > 0.0);
            at_features = swings.reduce(f64::max);
        }
        came.changes.push(&declaration, &all, 1.0);
        [at_changes, at_features]
    }
}

/// The rounding error of an acceleration between two nodes that is found from differences of positions.
fn noise([from, to]: [&Node; 2], i: usize) -> f64 {
    let h = to.t - from.t;
    let moves = [from, to].map(|node| node.q[i].abs().max((h * node.v[i]).abs()));
    // where a coordinate is at rest, far from a narrow feature, its acceleration is 1e-300 and grows by large factors
    let speeds = [from, to].map(|node| largest(&node.v));
    let nothing = f64::EPSILON * jumps::rounding(h, h * speeds[0].max(speeds[1]));
    (NOISE * jumps::rounding(h, moves[0].max(moves[1]))).max(nothing)
}

/// A path on which no body rests.
fn on<'a>(path: &'a MotionPath<'a>, h: f64, declaration: Declaration<'a>) -> StepPath<'a> {
    StepPath {
        path,
        h,
        declarations: [declaration; 2],
        pieces: &[],
    }
}
