//! Whether an acceleration jumps in a composed step.
//!
//! The order of a composed step is that of a smooth motion. A jump between its legs leaves no trace in their equations, but the acceleration at the next
//! node is not the one that those before lead to expect. Then it is looked at on the way of the step, and on that of the step before.

use super::run::Composed;
use super::stages::State;
use crate::run::Unresolved;
use crate::solve::Vector;
use crate::solve::predictor::Predictor;
use crate::step::jumps;
use crate::step::smooth::FORESEEN;

/// A node.
#[derive(Clone, Debug)]
struct Node {
    /// The time.
    t: f64,
    /// Position.
    q: Vector,
    /// Velocity.
    v: Vector,
}

/// The last nodes, the last first, and the accelerations that they lead to expect.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    /// At most two nodes.
    nodes: Vec<Node>,
    /// The accelerations at the past nodes.
    accelerations: Predictor,
    /// Whether the last step has been looked at.
    looked: bool,
}

impl Composed<'_> {
    /// Begins to watch accelerations at the current node, if they may jump.
    pub(super) fn watch_anew(&mut self) {
        let shape = self.kernel.shape();
        if !shape.external_forces && !shape.piecewise {
            return;
        }
        let mut accelerations = Predictor::new(shape.increments);
        accelerations.push(&self.course.now.a);
        self.watch = Some(Box::new(Watch {
            nodes: vec![self.here()],
            accelerations,
            looked: true,
        }));
    }

    /// The current node.
    fn here(&self) -> Node {
        let State { q, v, .. } = &self.course.now;
        Node {
            t: self.course.clock.time(),
            q: q.hi.clone(),
            v: v.hi.clone(),
        }
    }

    /// Watches the acceleration at the end of a step.
    pub(super) fn watch(&mut self) {
        let Some(mut watch) = self.watch.take() else {
            return;
        };
        let here = self.here();
        let a = &self.course.now.a;
        let foreseen = watch.accelerations.foresees(a, FORESEEN);
        watch.accelerations.push(a);
        if !foreseen {
            let looked = watch.looked;
            if let [last, before] = &watch.nodes[..]
                && !looked
            {
                self.look_between(before, last);
            }
            if let Some(last) = watch.nodes.first() {
                self.look_between(last, &here);
            }
        }
        watch.looked = !foreseen;
        watch.nodes.insert(0, here);
        watch.nodes.truncate(2);
        self.watch = Some(watch);
    }

    /// Counts the step between two nodes if an acceleration jumps in it.
    #[cold]
    fn look_between(&mut self, from: &Node, to: &Node) {
        let h = to.t - from.t;
        // the cubic polynomial with the positions and the velocities of both nodes
        let way = |part: f64| {
            let d = to.q.zip(&from.q, |to, from| to - from);
            let rate = |x: f64| {
                [
                    6.0 * x * (1.0 - x),
                    (1.0 - x) * (1.0 - 3.0 * x),
                    x * (3.0 * x - 2.0),
                ]
            };
            let place = |x: f64| {
                [
                    x * x * (3.0 - 2.0 * x),
                    x * (1.0 - x) * (1.0 - x),
                    x * x * (x - 1.0),
                ]
            };
            let of = |[by_d, by_from, by_to]: [f64; 3]| {
                Vector::from_fn(d.len(), |i| {
                    by_d * d[i] + h * (by_from * from.v[i] + by_to * to.v[i])
                })
            };
            let q = from.q.zip(&of(place(part)), |q, d| q + d);
            (from.t + part * h, q, of(rate(part)).map(|d| d / h))
        };
        let Some(accelerations) = jumps::accelerations(&self.declaration(), way) else {
            return;
        };
        let part = jumps::departure(&accelerations);
        if part > jumps::UNRESOLVED {
            Unresolved::count(&mut self.unresolved, from.t + 0.5 * h, part);
        }
    }
}
