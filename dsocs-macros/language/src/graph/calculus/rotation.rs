//! Coordinates that are rotations, and their derivatives.
//!
//! A rotation takes four slots among the coordinates. A position holds its unit quaternion `(w, x, y, z)`; a velocity, an acceleration, an increment and a
//! covector hold a zero and the three components in the frame of the body. So vectors of all kinds have the same length, and the slot of the zero is a
//! particle at rest.
//!
//! A leg goes from `g0` to `g1 = g0 τ(x)` by a local increment `x`, with the Padé map `τ`. The derivative of
//! a position along a body slot is `½ q∘(0, e)`, and by time `½ q∘(0, ω)`. The derivative of the increment of
//! a leg is `T(x)` by its second node and `-T(-x)` by its first, where `T(x)` is the inverse of the left
//! tangent of `τ`. All other derivatives follow by the chain rule.

use crate::graph::calculus::derivative::Direction;
use crate::graph::{Graph, Leaf, NodeId, Unary};

/// The number of slots of a rotation.
pub(crate) const SLOTS: usize = 4;

/// A unit quaternion `(w, x, y, z)`.
pub(crate) type Quaternion = [NodeId; SLOTS];

/// A kind of leaf, as the function from slot to leaf.
type LeafOf = fn(usize) -> Leaf;

impl Graph {
    /// Sets the first slots of the rotations.
    pub(crate) fn set_rotations(&mut self, first: Vec<usize>) {
        self.rotations = first;
    }

    /// The first slots of the rotations.
    pub(crate) fn rotations(&self) -> &[usize] {
        &self.rotations
    }

    /// The first slot of the rotation that a slot belongs to; `None` if it belongs to none.
    pub(crate) fn rotation_at(&self, slot: usize) -> Option<usize> {
        let mut rotations = self.rotations.iter();
        rotations
            .find(|&&first| (first..first + SLOTS).contains(&slot))
            .copied()
    }

    /// Whether a leaf is a component of a rotation's position or of its increment, whose derivatives are not
    /// those of numbers.
    pub(crate) fn is_of_rotation(&self, leaf: Leaf) -> bool {
        match leaf {
            Leaf::Q(i) | Leaf::X0(i) | Leaf::X1(i) | Leaf::Chord(i) => self.rotation_at(i).is_some(),
            _ => false,
        }
    }

    /// The leaves that vary in the direction of a leaf: the leaf itself or, of a rotation, all components of
    /// the node and of the increment.
    pub(crate) fn leaves_varying_with(&self, leaf: Leaf) -> [Option<Leaf>; 2 * SLOTS] {
        let mut leaves = [None; 2 * SLOTS];
        let node: LeafOf = match leaf {
            Leaf::Q(_) => Leaf::Q,
            Leaf::X0(_) => Leaf::X0,
            Leaf::X1(_) => Leaf::X1,
            _ => return [Some(leaf), None, None, None, None, None, None, None],
        };
        let Some(first) = leaf.place().and_then(|slot| self.rotation_at(slot)) else {
            leaves[0] = Some(leaf);
            return leaves;
        };
        let has_chord = !matches!(leaf, Leaf::Q(_));
        for k in 0..SLOTS {
            leaves[k] = Some(node(first + k));
            leaves[SLOTS + k] = has_chord.then_some(Leaf::Chord(first + k));
        }
        leaves
    }

    /// The derivative of a component of a rotation, or of its increment, in a direction.
    pub(crate) fn rotation_derivative(&mut self, leaf: Leaf, direction: Direction) -> NodeId {
        let zero = self.constant(0.0);
        let Some(slot) = leaf.place() else { return zero };
        let Some(first) = self.rotation_at(slot) else {
            return zero;
        };
        let k = slot - first;
        let quaternion = |graph: &mut Self, node: LeafOf| -> Quaternion {
            [0, 1, 2, 3].map(|k| graph.leaf(node(first + k)))
        };
        let body = |graph: &mut Self, node: LeafOf| [1, 2, 3].map(|k| graph.leaf(node(first + k)));
        let along = match direction {
            Direction::Time => None,
            Direction::Of(along) => Some(along),
        };
        let place = along
            .and_then(Leaf::place)
            .filter(|place| (first..first + SLOTS).contains(place));
        match (leaf, along, place) {
            (Leaf::Q(_), None, _) => {
                let q = quaternion(self, Leaf::Q);
                let rate = body(self, Leaf::V);
                self.half_product(q, rate)[k]
            }
            (Leaf::Q(_), Some(Leaf::Q(_)), Some(place)) => {
                let q = quaternion(self, Leaf::Q);
                self.along_slot(q, place - first)[k]
            }
            (Leaf::X0(_), Some(Leaf::X0(_)), Some(place)) => {
                let q = quaternion(self, Leaf::X0);
                self.along_slot(q, place - first)[k]
            }
            (Leaf::X1(_), Some(Leaf::X1(_)), Some(place)) => {
                let q = quaternion(self, Leaf::X1);
                self.along_slot(q, place - first)[k]
            }
            // the slot of the zero: a particle at rest
            (Leaf::Chord(_), Some(Leaf::X0(_) | Leaf::X1(_)), Some(place)) if k == 0 || place == first => {
                let sign = if matches!(along, Some(Leaf::X1(_))) {
                    1.0
                } else {
                    -1.0
                };
                self.constant(if k == 0 && place == first { sign } else { 0.0 })
            }
            (Leaf::Chord(_), Some(Leaf::X1(_)), Some(place)) => {
                let x = body(self, Leaf::Chord);
                self.inverse_tangent(x, 1.0)[k - 1][place - first - 1]
            }
            (Leaf::Chord(_), Some(Leaf::X0(_)), Some(place)) => {
                let x = body(self, Leaf::Chord);
                let entry = self.inverse_tangent(x, -1.0)[k - 1][place - first - 1];
                self.neg(entry)
            }
            (Leaf::Chord(i), Some(Leaf::Chord(j)), _) if i == j => self.constant(1.0),
            _ => zero,
        }
    }

    /// The derivative `½ q∘(0, e)` along a body slot; zero along the first.
    fn along_slot(&mut self, q: Quaternion, slot: usize) -> Quaternion {
        let (zero, one) = (self.constant(0.0), self.constant(1.0));
        let axis = [1, 2, 3].map(|k| if k == slot { one } else { zero });
        self.half_product(q, axis)
    }

    /// `½ q∘(0, v)`
    fn half_product(&mut self, q: Quaternion, v: [NodeId; 3]) -> Quaternion {
        let zero = self.constant(0.0);
        let product = self.quaternion_product(q, [zero, v[0], v[1], v[2]]);
        product.map(|component| self.scale(0.5, component))
    }

    /// `p∘q`
    pub(crate) fn quaternion_product(&mut self, p: Quaternion, q: Quaternion) -> Quaternion {
        /// For each component of the product, the indices of the factors and the signs.
        const TERMS: [[(usize, usize, f64); 4]; 4] = [
            [(0, 0, 1.0), (1, 1, -1.0), (2, 2, -1.0), (3, 3, -1.0)],
            [(0, 1, 1.0), (1, 0, 1.0), (2, 3, 1.0), (3, 2, -1.0)],
            [(0, 2, 1.0), (2, 0, 1.0), (3, 1, 1.0), (1, 3, -1.0)],
            [(0, 3, 1.0), (3, 0, 1.0), (1, 2, 1.0), (2, 1, -1.0)],
        ];
        TERMS.map(|terms| {
            let terms = terms.map(|(i, j, sign)| (self.mul(p[i], q[j]), sign));
            self.linear(0.0, &terms)
        })
    }

    /// `q∘(τ(x) - 1)`: the change of a quaternion that an increment moves.
    pub(crate) fn quaternion_change(&mut self, q: Quaternion, x: [NodeId; 3]) -> Quaternion {
        let [a, b] = self.pade(x);
        // the quaternion of `τ` is (a² - b, a x/2)/(a² + b)
        let square = self.powi(a, 2);
        let denominator = self.add(square, b);
        let scalar = self.product(&[(b, 1), (denominator, -1)]);
        let scalar = self.scale(-2.0, scalar);
        let half = self.product(&[(a, 1), (denominator, -1)]);
        let half = self.scale(0.5, half);
        let [x, y, z] = x.map(|x| self.mul(half, x));
        self.quaternion_product(q, [scalar, x, y, z])
    }

    /// The middle of a leg, `X0 (a + x/4)/√(a² + b)`: half of the turn `τ(x)` from either end.
    pub(crate) fn middle(&mut self, first: usize) -> Quaternion {
        let q = [0, 1, 2, 3].map(|k| self.leaf(Leaf::X0(first + k)));
        let x = [1, 2, 3].map(|k| self.leaf(Leaf::Chord(first + k)));
        let [a, b] = self.pade(x);
        let square = self.powi(a, 2);
        let norm = self.add(square, b);
        let norm = self.unary(Unary::Sqrt, norm);
        let [x, y, z] = x.map(|x| self.scale(0.25, x));
        self.quaternion_product(q, [a, x, y, z])
            .map(|component| self.div(component, norm))
    }

    /// The derivative of the body slot `k` of a leg's middle by the slot `i` of its second node, or with
    /// `sign = -1` of its first: `M(±y) = (I ± ŷ/2)/2` with `y = x/(2 a)`.
    pub(crate) fn slope_of_middle(&mut self, first: usize, [k, i]: [usize; 2], sign: f64) -> NodeId {
        if k == 0 || i == 0 {
            return self.constant(0.0);
        }
        if k == i {
            return self.constant(0.5);
        }
        let x = [1, 2, 3].map(|k| self.leaf(Leaf::Chord(first + k)));
        let [a, _] = self.pade(x);
        let other = 6 - k - i;
        let odd = k % 3 + 1 == i;
        let y = self.div(x[other - 1], a);
        self.scale(if odd { -0.125 * sign } else { 0.125 * sign }, y)
    }

    /// `a = 1 - |x|²/48` and `b = |x|²/16`.
    fn pade(&mut self, x: [NodeId; 3]) -> [NodeId; 2] {
        let square = self.norm_squared(x);
        [
            self.linear(1.0, &[(square, -1.0 / 48.0)]),
            self.scale(1.0 / 16.0, square),
        ]
    }

    fn norm_squared(&mut self, x: [NodeId; 3]) -> NodeId {
        let squares = x.map(|x| self.powi(x, 2));
        self.sum(&squares)
    }

    /// `c` and `d` of [`Graph::inverse_tangent`]. With `b = 3 (1 - a)` and `1 + |x|²/48 = 2 - a` they are
    /// sums of fractions in `a` alone, which have short derivatives: `c = a + 3 - 3/a` and
    /// `d = 1/24 + 1/(16 a) - 1/(48 (2 - a))`.
    fn factors_of_tangent(&mut self, x: [NodeId; 3]) -> [NodeId; 2] {
        let [a, _] = self.pade(x);
        let inverse = self.powi(a, -1);
        let norm = self.norm_squared(x);
        let other = self.linear(1.0, &[(norm, 1.0 / 48.0)]);
        let other = self.powi(other, -1);
        let c = self.linear(3.0, &[(a, 1.0), (inverse, -3.0)]);
        let d = self.linear(1.0 / 24.0, &[(inverse, 1.0 / 16.0), (other, -1.0 / 48.0)]);
        [c, d]
    }

    /// `T(±x) = ±x̂/2 + c I + d x xᵀ`, with `c = (a² - b)/a` and `d = (1/8 - a²/24)/(a (1 + |x|²/48))`.
    fn inverse_tangent(&mut self, x: [NodeId; 3], sign: f64) -> [[NodeId; 3]; 3] {
        let [c, d] = self.factors_of_tangent(x);
        [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j: usize| {
                let outer = self.product(&[(d, 1), (x[i], 1), (x[j], 1)]);
                if i == j {
                    return self.add(c, outer);
                }
                // x̂ᵢⱼ = -εᵢⱼₖ xₖ
                let k = 3 - i - j;
                let odd = (i + 1) % 3 == j;
                let hat = if odd { -0.5 * sign } else { 0.5 * sign };
                self.linear(0.0, &[(outer, 1.0), (x[k], hat)])
            })
        })
    }

    /// The momentum `p` conjugate to the increment `x` of a leg, as covectors at its nodes:
    /// `T(x)ᵀp - T(-x)ᵀp = p × x` by both nodes together, and `T(x)ᵀp = c p + p × x/2 + d (x·p) x` by the
    /// second.
    pub(crate) fn momenta_of_increment(&mut self, first: usize, p: [NodeId; 3]) -> [[NodeId; 3]; 2] {
        let x = [1, 2, 3].map(|k| self.leaf(Leaf::Chord(first + k)));
        let [c, d] = self.factors_of_tangent(x);
        let both = self.cross(p, x);
        let products = [0, 1, 2].map(|k| self.mul(x[k], p[k]));
        let along = self.sum(&products);
        let along = self.mul(d, along);
        let second = [0, 1, 2].map(|k| {
            let (straight, outer) = (self.mul(c, p[k]), self.mul(along, x[k]));
            self.linear(0.0, &[(straight, 1.0), (both[k], 0.5), (outer, 1.0)])
        });
        [both, second]
    }

    /// A vector in the frame of the body, turned into the frame of space: `v + 2 w (u × v) + 2 u × (u × v)`.
    pub(crate) fn rotated(&mut self, [w, u @ ..]: Quaternion, v: [NodeId; 3]) -> [NodeId; 3] {
        let once = self.cross(u, v);
        let twice = self.cross(u, once);
        [0, 1, 2].map(|i| {
            let first = self.mul(w, once[i]);
            self.linear(0.0, &[(v[i], 1.0), (first, 2.0), (twice[i], 2.0)])
        })
    }

    /// `a × b`
    pub(crate) fn cross(&mut self, a: [NodeId; 3], b: [NodeId; 3]) -> [NodeId; 3] {
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
            let (left, right) = (self.mul(a[i], b[j]), self.mul(a[j], b[i]));
            self.sub(left, right)
        })
    }

    /// The inverse of a rotation.
    pub(crate) fn inverse(&mut self, [w, x, y, z]: Quaternion) -> Quaternion {
        [w, self.neg(x), self.neg(y), self.neg(z)]
    }
}
