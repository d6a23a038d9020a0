//! Sequences of Taylor coefficients, and the operations that compute them.
//!
//! A recurrence of order `k` needs sums `Σ x_j y_{k-j}`. All their terms but the first and the last have
//! lower orders only. So these inner sums of all recurrences are formed together, in lanes, before the rest
//! of the order. A [`Lane`] is one inner sum.

use std::collections::BTreeSet;

use crate::graph::{Comparison, Leaf, NodeId};
use crate::hash::HashMap;

/// A sequence of coefficients.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct Sequence(u32);

impl Sequence {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// A factor that is constant in time: an expression of the parameters.
pub(crate) type Constant = NodeId;

/// The operation that computes a sequence. `u` is the argument, and primes are time derivatives.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Op {
    /// A position, velocity, acceleration or multiplier, or the time.
    Leaf(Leaf),
    /// A number or an expression of the parameters, as a sequence.
    Constant(Constant),
    /// `constant + Σ coefficient · term`.
    Linear(Option<Constant>, Vec<(Constant, Sequence)>),
    /// `u v`.
    Product(Sequence, Sequence),
    /// `u²`.
    Square(Sequence),
    /// `w = u / v` from `w v = u`.
    Quotient(Sequence, Sequence),
    /// `w = 1 / v` from `w v = 1`.
    Reciprocal(Sequence),
    /// `w = √u` from `w² = u`.
    Root(Sequence),
    /// `w = ∛u` from `3 u w' = w u'`.
    CubeRoot(Sequence),
    /// `w = u^α` from `u w' = α w u'`.
    Power(Sequence, Constant),
    /// `w = eᵘ` from `w' = w u'`.
    Exp(Sequence),
    /// `w = eᵘ - 1` from `w' = (w + 1) u'`.
    ExpM1(Sequence),
    /// `w = ln u` from `u w' = u'`.
    Ln(Sequence),
    /// `w = ln(1 + u)` from `(1 + u) w' = u'`.
    Ln1p(Sequence),
    /// `s = sin u` from `s' = c u'`; the partner is `c`.
    Sin(Sequence, Sequence),
    /// `c = cos u` from `c' = -s u'`; the partner is `s`.
    Cos(Sequence, Sequence),
    /// `s = sinh u` from `s' = c u'`; the partner is `c`.
    Sinh(Sequence, Sequence),
    /// `c = cosh u` from `c' = s u'`; the partner is `s`.
    Cosh(Sequence, Sequence),
    /// `w = tan u` from `w' = g u'`; the second is `g = 1 + w²`.
    Tan(Sequence, Sequence),
    /// `w = tanh u` from `w' = g u'`; the second is `g = 1 - w²`.
    Tanh(Sequence, Sequence),
    /// `1 - u²`, from `u` and `u²`; at order 0 as `(1 - u)(1 + u)`.
    Conjugate(Sequence, Sequence),
    /// `w` from `g w' = u'`: an inverse function of `u`, then `u` and `g`.
    Inverse(Inverse, Sequence, Sequence),
    /// `w = atan2(y, x)` from `(x² + y²) w' = x y' - y x'`; the last is `x² + y²`.
    Atan2(Sequence, Sequence, Sequence),
    /// `|u|`, with the sign of `u` at order 0.
    Abs(Sequence),
    /// The sign of `u` at order 0.
    Signum(Sequence),
    /// The third or the fourth, by comparing the first two at order 0.
    Select(Comparison, [Sequence; 4]),
    /// A user's function, or a partial derivative of it.
    Call {
        callee: usize,
        args: Vec<Sequence>,
        wrt: Vec<usize>,
    },
}

impl Op {
    /// The operands, with the partner of a recurrence.
    pub(crate) fn parts(&self) -> Vec<Sequence> {
        match self {
            Self::Leaf(_) | Self::Constant(_) => Vec::new(),
            Self::Linear(_, terms) => terms.iter().map(|&(_, term)| term).collect(),
            Self::Square(u)
            | Self::Reciprocal(u)
            | Self::Root(u)
            | Self::CubeRoot(u)
            | Self::Power(u, _)
            | Self::Exp(u)
            | Self::ExpM1(u)
            | Self::Ln(u)
            | Self::Ln1p(u)
            | Self::Abs(u)
            | Self::Signum(u) => vec![*u],
            Self::Product(u, v)
            | Self::Quotient(u, v)
            | Self::Sin(u, v)
            | Self::Cos(u, v)
            | Self::Sinh(u, v)
            | Self::Cosh(u, v)
            | Self::Tan(u, v)
            | Self::Tanh(u, v)
            | Self::Conjugate(u, v)
            | Self::Inverse(_, u, v) => vec![*u, *v],
            Self::Atan2(y, x, radius) => vec![*y, *x, *radius],
            Self::Select(_, parts) => parts.to_vec(),
            Self::Call { args, .. } => args.clone(),
        }
    }

    /// The inner sums of the recurrence beyond order 0, in the order in which it uses them; `own` is the
    /// sequence itself.
    pub(crate) fn inner(&self, own: Sequence) -> Vec<[Operand; 2]> {
        use Operand::{Plain, Rate};
        match *self {
            Self::Product(u, v) => vec![[Plain(u), Plain(v)]],
            Self::Square(u) => vec![[Plain(u), Plain(u)]],
            Self::Quotient(_, v) | Self::Reciprocal(v) => vec![[Plain(own), Plain(v)]],
            Self::Root(_) => vec![[Plain(own), Plain(own)]],
            Self::CubeRoot(u) | Self::Power(u, _) => vec![[Plain(own), Rate(u)], [Rate(own), Plain(u)]],
            Self::Exp(u) | Self::ExpM1(u) => vec![[Rate(u), Plain(own)]],
            Self::Ln(u) | Self::Ln1p(u) => vec![[Rate(own), Plain(u)]],
            Self::Sin(u, partner)
            | Self::Cos(u, partner)
            | Self::Sinh(u, partner)
            | Self::Cosh(u, partner)
            | Self::Tan(u, partner)
            | Self::Tanh(u, partner) => vec![[Rate(u), Plain(partner)]],
            Self::Inverse(_, _, slope) => vec![[Rate(own), Plain(slope)]],
            Self::Atan2(y, x, radius) => {
                vec![
                    [Rate(y), Plain(x)],
                    [Rate(x), Plain(y)],
                    [Rate(own), Plain(radius)],
                ]
            }
            Self::Leaf(_)
            | Self::Constant(_)
            | Self::Linear(..)
            | Self::Conjugate(..)
            | Self::Abs(_)
            | Self::Signum(_)
            | Self::Select(..)
            | Self::Call { .. } => Vec::new(),
        }
    }

    /// The constants in the recurrence: at order 0 if `is_start`, else beyond.
    pub(crate) fn constants(&self, is_start: bool) -> Vec<Constant> {
        match self {
            Self::Constant(constant) if is_start => vec![*constant],
            Self::Linear(constant, terms) => {
                let constant = constant.filter(|_| is_start);
                constant
                    .into_iter()
                    .chain(terms.iter().map(|&(c, _)| c))
                    .collect()
            }
            Self::Power(_, exponent) => vec![*exponent],
            _ => Vec::new(),
        }
    }
}

/// A function whose derivative is the reciprocal of a sequence.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Inverse {
    Asin,
    Acos,
    Atan,
    Asinh,
    Acosh,
    Atanh,
}

impl Inverse {
    /// The method of `f64`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Asin => "asin",
            Self::Acos => "acos",
            Self::Atan => "atan",
            Self::Asinh => "asinh",
            Self::Acosh => "acosh",
            Self::Atanh => "atanh",
        }
    }
}

/// An operand of a convolution: a sequence `x_j`, or `j x_j`, from its time derivative. The latter comes first, as in nearly all recurrences: the
/// newest terms of their sums are added in this order.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) enum Operand {
    Rate(Sequence),
    Plain(Sequence),
}

impl Operand {
    /// The sequence itself.
    pub(crate) fn sequence(self) -> Sequence {
        match self {
            Self::Plain(sequence) | Self::Rate(sequence) => sequence,
        }
    }
}

/// The inner sum `Σ x_j y_{k-j}` over `0 < j < k`, by its index.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Lane {
    /// The sum of the products of two operands.
    Product(usize),
    /// The sum of the products of an operand with itself.
    Square(usize),
}

/// The argument of a switch, which decides between pieces or shows that a narrow feature may be missed.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Argument {
    /// The argument of a function that depends on its sign.
    Sign(Sequence),
    /// The argument of a smooth function that is flat except near zero.
    Steep(Sequence),
    /// The base of a power of a high degree, with its exponent, which is negative in a divisor: the power may
    /// be flat except where it is large.
    Power(Sequence, i32),
    /// A value that has bounds, which its series may leave: that of `√(u²)` is the series of `u` or of `-u`.
    Bounded(Sequence, Bound),
    /// The difference of the first and the second.
    Difference(Sequence, Sequence),
}

/// The bounds of a function's values.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Bound {
    /// Zero from below, of a root.
    Zero,
    /// ±π/2, of an angle.
    Quarter,
    /// ±π, of an angle.
    Half,
}

impl Bound {
    /// The largest absolute value of an angle; zero for a root.
    pub(crate) fn value(self) -> f64 {
        match self {
            Self::Zero => 0.0,
            Self::Quarter => core::f64::consts::FRAC_PI_2,
            Self::Half => core::f64::consts::PI,
        }
    }
}

/// All sequences of a system, each once, in the order in which they are computed.
#[derive(Default)]
pub(crate) struct Sequences {
    ops: Vec<Op>,
    known: HashMap<Op, Sequence>,
    /// The operands of the product lanes.
    pub(crate) products: Vec<[Operand; 2]>,
    /// The operands of the square lanes.
    pub(crate) squares: Vec<Operand>,
    places: HashMap<[Operand; 2], Lane>,
    /// The arguments of switches with their expressions; a difference has two.
    switches: Vec<(Argument, Vec<NodeId>)>,
    /// The divisors whose sign may change.
    divisors: Vec<Sequence>,
}

impl Sequences {
    /// Adds a divisor whose sign may change.
    pub(super) fn add_divisor(&mut self, divisor: Sequence) {
        if !self.divisors.contains(&divisor) {
            self.divisors.push(divisor);
        }
    }

    /// The divisors whose sign may change.
    pub(crate) fn divisors(&self) -> &[Sequence] {
        &self.divisors
    }

    /// The sequence of an operation, shared with equal ones.
    pub(crate) fn push(&mut self, op: Op) -> Sequence {
        if let Some(&known) = self.known.get(&op) {
            return known;
        }
        let sequence = self.add(op.clone());
        self.known.insert(op, sequence);
        sequence
    }

    /// The sequence of an operation, without sharing.
    fn add(&mut self, op: Op) -> Sequence {
        let sequence = Sequence(u32::try_from(self.ops.len()).unwrap_or(u32::MAX));
        self.ops.push(op);
        sequence
    }

    /// Two functions of one argument whose recurrences need each other.
    pub(crate) fn pair(
        &mut self,
        argument: Sequence,
        first: fn(Sequence, Sequence) -> Op,
        second: fn(Sequence, Sequence) -> Op,
    ) -> [Sequence; 2] {
        let next = u32::try_from(self.ops.len()).unwrap_or(u32::MAX);
        let partners = [Sequence(next), Sequence(next.saturating_add(1))];
        self.add(first(argument, partners[1]));
        self.add(second(argument, partners[0]));
        partners
    }

    /// A function `w` with `w' = g u'`, where `g` is `1 + w²` or, if `conjugate`, `1 - w²`.
    pub(crate) fn tangent(&mut self, argument: Sequence, one: Constant, conjugate: bool) -> Sequence {
        let next = u32::try_from(self.ops.len()).unwrap_or(u32::MAX);
        let slope = Sequence(next.saturating_add(2));
        let value = self.add(if conjugate {
            Op::Tanh(argument, slope)
        } else {
            Op::Tan(argument, slope)
        });
        let square = self.add(Op::Square(value));
        self.add(if conjugate {
            Op::Conjugate(value, square)
        } else {
            Op::Linear(Some(one), vec![(one, square)])
        });
        value
    }

    /// The operations, each with its sequence.
    pub(crate) fn ops(&self) -> impl Iterator<Item = (Sequence, &Op)> {
        self.ops
            .iter()
            .enumerate()
            .map(|(place, op)| (Sequence(u32::try_from(place).unwrap_or(u32::MAX)), op))
    }

    pub(crate) fn op(&self, sequence: Sequence) -> &Op {
        &self.ops[sequence.index()]
    }

    /// The sequences that some outputs depend on, with the outputs.
    pub(crate) fn needed(&self, outputs: &[Sequence]) -> BTreeSet<Sequence> {
        let mut needed = BTreeSet::new();
        let mut open = outputs.to_vec();
        while let Some(sequence) = open.pop() {
            if needed.insert(sequence) {
                open.extend(self.op(sequence).parts());
            }
        }
        needed
    }

    /// The sequences that depend on an acceleration or a multiplier.
    pub(crate) fn accelerated(&self) -> BTreeSet<Sequence> {
        let mut found = BTreeSet::new();
        // repeated, because a partner may come later, and depends on the same argument
        loop {
            let before = found.len();
            for (sequence, op) in self.ops() {
                let own = matches!(op, Op::Leaf(Leaf::A(_) | Leaf::Lambda(_)));
                if own || op.parts().iter().any(|part| found.contains(part)) {
                    found.insert(sequence);
                }
            }
            if found.len() == before {
                return found;
            }
        }
    }

    /// Moves the squares into free places of the last block of products, if there are enough: that spares a
    /// loop. Squares of positions and velocities come first. Returns the number of blocks of products and of
    /// squares that have such operands alone.
    pub(crate) fn fill(&mut self, lanes: usize) -> [usize; 2] {
        let free = self.products.len().next_multiple_of(lanes) - self.products.len();
        if self.squares.len() <= free {
            self.products.extend(
                core::mem::take(&mut self.squares)
                    .into_iter()
                    .map(|square| [square; 2]),
            );
        }
        let (products, squares) = (
            core::mem::take(&mut self.products),
            core::mem::take(&mut self.squares),
        );
        let is_known = |operand: &Operand| self.is_known(*operand);
        // a square has a recurrence of its own
        let (known, others): (Vec<_>, Vec<_>) = products
            .into_iter()
            .partition(|both| both[0] != both[1] && both.iter().all(is_known));
        let (known_squares, other_squares): (Vec<_>, Vec<_>) = squares.into_iter().partition(is_known);
        let whole = [
            (known.len(), others.len()),
            (known_squares.len(), other_squares.len()),
        ];
        self.products = [known, others].concat();
        self.squares = [known_squares, other_squares].concat();
        for (place, &key) in self.products.iter().enumerate() {
            self.places.insert(key, Lane::Product(place));
        }
        for (place, &square) in self.squares.iter().enumerate() {
            self.places.insert([square; 2], Lane::Square(place));
        }
        // if all products have known factors, the last block of lanes may be incomplete
        let whole = whole.map(|(known, others)| {
            if others == 0 {
                known.div_ceil(lanes)
            } else {
                known / lanes
            }
        });
        // of more than two, two share a loop; a single block costs more than its registers spare
        match whole {
            [products, squares] if products + squares < 2 => [0, 0],
            [products, squares] if products > 2 => [products / 2 * 2, squares],
            few => few,
        }
    }

    /// Whether the coefficients of an operand are known before anything of an order is computed.
    fn is_known(&self, operand: Operand) -> bool {
        matches!(operand, Operand::Plain(u) if matches!(self.op(u), Op::Leaf(Leaf::Q(_) | Leaf::V(_))))
    }

    /// Adds a switch, unless its argument is constant in time or it is known.
    pub(crate) fn switch(&mut self, argument: Argument, nodes: Vec<NodeId>) {
        let moves = |sequence: Sequence| !matches!(self.op(sequence), Op::Constant(_));
        let any = match argument {
            Argument::Sign(u) | Argument::Steep(u) | Argument::Power(u, _) | Argument::Bounded(u, _) => {
                moves(u)
            }
            Argument::Difference(u, v) => moves(u) || moves(v),
        };
        if any && self.place(argument).is_none() {
            self.switches.push((argument, nodes));
        }
    }

    /// The index of a switch; `None` if there is none with this argument.
    pub(crate) fn place(&self, argument: Argument) -> Option<usize> {
        self.switches.iter().position(|(known, _)| *known == argument)
    }

    /// All switches with their expressions.
    pub(crate) fn switches(&self) -> &[(Argument, Vec<NodeId>)] {
        &self.switches
    }

    /// The sequences in the arguments of switches.
    pub(crate) fn switched(&self) -> Vec<Sequence> {
        let arguments = self.switches.iter().flat_map(|(argument, _)| match *argument {
            Argument::Sign(u) | Argument::Steep(u) | Argument::Power(u, _) | Argument::Bounded(u, _) => {
                [Some(u), None]
            }
            Argument::Difference(u, v) => [Some(u), Some(v)],
        });
        arguments.flatten().collect()
    }

    /// The lane of an inner sum, if it was added.
    pub(crate) fn lane(&self, [x, y]: [Operand; 2]) -> Option<Lane> {
        self.places.get(&[x.min(y), x.max(y)]).copied()
    }

    /// Adds an inner sum, if it is new.
    pub(crate) fn add_lane(&mut self, [x, y]: [Operand; 2]) {
        let key = [x.min(y), x.max(y)];
        if self.places.contains_key(&key) {
            return;
        }
        let lane = if x == y {
            self.squares.push(x);
            Lane::Square(self.squares.len() - 1)
        } else {
            self.products.push(key);
            Lane::Product(self.products.len() - 1)
        };
        self.places.insert(key, lane);
    }
}
