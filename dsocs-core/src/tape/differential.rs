//! The derivatives of a tape's results by its inputs.
//!
//! A [`Differential`] evaluates its operations at eight points at once and keeps every value. Derivatives
//! then go through the operations by the chain rule: *pulled back* from results to inputs (the gradient of a
//! weighted sum of results costs about as much as the results, for any number of inputs), or *pushed forward*
//! from inputs to results. Both are lists of products, without zero terms, that were derived when the
//! differential was made.
//!
//! Derivatives are exact to rounding, also those of the user's functions ([`Source::call_dual`]).

use super::eight::Eight;
use super::link::{self, Register};
use super::read::{Binary, Body, Comparison, Function, Op};
use super::{Leaf, Part, Segment, Source, Tape};
use crate::number::dispatch::{self, Work};
use crate::number::dual::Dual;
use crate::number::lanes::Lanes;
use crate::number::scalar::Scalar as _;

/// An input of the results.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Input {
    /// A leaf.
    Leaf(Leaf),
    /// A result of [`Segment::Constants`].
    Constant(usize),
}

/// The place of a number.
type Place = Register;

/// The operation at a place, on places before it. The inputs list which leaf is read where.
type Kind = link::Kind<()>;

/// An operation, and the first place of those of its slopes that are not the numbers of other places.
#[derive(Clone, Copy, Debug)]
struct Step {
    kind: Kind,
    slopes: Option<u32>,
}

/// A slope of an operation by an operand.
#[derive(Clone, Copy, Debug)]
enum Slope {
    One,
    Minus,
    /// The number at another place.
    Value(Place),
    /// A number among the slopes.
    Own(u32),
}

/// One product of the chain rule: `to = from · slope`, or added to `to`.
#[derive(Clone, Copy, Debug)]
struct Link {
    from: Place,
    to: Place,
    slope: Slope,
    first: bool,
}

/// The products of a derivative through the operations, and the inputs that it reaches.
#[derive(Clone, Debug, Default)]
struct ReverseSweep {
    links: Vec<Link>,
    reached: Vec<(usize, Place)>,
}

/// The operations behind some results, with their chain rule.
#[derive(Clone, Debug)]
pub(crate) struct Differential {
    steps: Vec<Step>,
    arguments: Vec<Place>,
    inputs: Vec<(Input, Place)>,
    results: Vec<Place>,
    slopes: usize,
    /// Whether an operation may have an infinite slope on a branch that is not taken.
    branches: bool,
    /// The products from each result to the inputs.
    back: Vec<ReverseSweep>,
    /// The products from all results at once.
    back_from_all: ReverseSweep,
    /// The products from the inputs to the results.
    forward: Vec<Link>,
}

/// The products from one result after another to the inputs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sweeps {
    links: Vec<Link>,
    /// Pairs of places: the derivative at the first is stored at the second.
    taken: Vec<(Place, Place)>,
    /// For each result: its place, and where its products and its stored derivatives end.
    parts: Vec<(Place, usize, usize)>,
}

/// The workspace of a differential, kept by the caller, so that an evaluation allocates nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
    values: Vec<Eight>,
    slopes: Vec<Eight>,
    moving: Vec<Eight>,
}

impl Tape {
    /// The derivatives of the results of some segments, one after another, by the inputs that `is_moving`
    /// selects.
    pub(crate) fn differential(
        &self,
        wanted: &[(Segment, Part)],
        is_moving: &dyn Fn(Input) -> bool,
    ) -> Differential {
        let (ops, results) = gathered(self.bodies(), wanted);
        Differential::new(&ops, &results, is_moving)
    }
}

/// The operations of some segments, and the places of their results; [`Op::Stored`] is left only for
/// constants of the run.
fn gathered(bodies: &[Body], wanted: &[(Segment, Part)]) -> (Vec<Op>, Vec<usize>) {
    let (mut ops, mut results): (Vec<Op>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut known: Vec<usize> = Vec::new();
    let own = wanted.iter().map(|&(segment, part)| (segment, Some(part)));
    for (segment, part) in core::iter::once((Segment::Known, None)).chain(own) {
        let Some(body) = bodies.get(segment as usize) else {
            continue;
        };
        let mut places: Vec<usize> = Vec::with_capacity(body.ops.len());
        for op in &body.ops {
            if let &Op::Stored(Segment::Known, place) = op {
                places.push(known[place]);
                continue;
            }
            let mut op = op.clone();
            for part in op.parts_mut() {
                *part = places[*part];
            }
            places.push(ops.len());
            ops.push(op);
        }
        match part {
            None => known = body.results.iter().map(|&result| places[result]).collect(),
            Some(part) => results.extend(body.part(part).iter().map(|&result| places[result])),
        }
    }
    (ops, results)
}

/// A count as a place; no tape is as large as this bound.
fn place(count: usize) -> Place {
    u32::try_from(count).unwrap_or(u32::MAX)
}

impl Differential {
    fn new(ops: &[Op], results: &[usize], is_moving: &dyn Fn(Input) -> bool) -> Self {
        let mut needed = vec![false; ops.len()];
        for &result in results {
            needed[result] = true;
        }
        for at in (0..ops.len()).rev().filter(|&at| needed[at]).collect::<Vec<_>>() {
            mark(ops, at, &mut needed);
        }
        let mut this = Self {
            steps: Vec::new(),
            arguments: Vec::new(),
            inputs: Vec::new(),
            results: Vec::new(),
            slopes: 0,
            branches: ops.iter().any(|op| matches!(op, Op::Select(..))),
            back: Vec::new(),
            back_from_all: ReverseSweep::default(),
            forward: Vec::new(),
        };
        let mut places = vec![0; ops.len()];
        // the operations that depend on the moving inputs
        let mut moving: Vec<bool> = Vec::new();
        let mut inputs_at: Vec<Option<usize>> = Vec::new();
        for (at, op) in ops.iter().enumerate().filter(|(at, _)| needed[*at]) {
            let input = match op {
                Op::Leaf(leaf) => Some(Input::Leaf(*leaf)),
                Op::Stored(_, constant) => Some(Input::Constant(*constant)),
                _ => None,
            };
            // several segments may read the same leaf
            if let Some(known) = input.and_then(|input| this.inputs.iter().find(|(known, _)| *known == input))
            {
                places[at] = known.1;
                continue;
            }
            places[at] = place(this.steps.len());
            let parts = op.parts().iter().map(|&part| places[part] as usize);
            moving.push(match input {
                Some(input) => is_moving(input),
                None => parts.into_iter().any(|part| moving[part]),
            });
            inputs_at.push(input.map(|_| this.inputs.len()));
            if let Some(input) = input {
                this.inputs.push((input, places[at]));
            }
            this.push(op, &places, moving[places[at] as usize]);
        }
        this.results = results.iter().map(|&result| places[result]).collect();
        this.back = (this.results.iter())
            .map(|&result| this.reverse_sweep(&[result], &moving, &inputs_at))
            .collect();
        this.back_from_all = this.reverse_sweep(&this.results, &moving, &inputs_at);
        this.forward = this.way_forward(&moving);
        this
    }

    /// Appends an operation.
    fn push(&mut self, op: &Op, places: &[Place], is_moving: bool) {
        let of = |part: &usize| places[*part];
        let kind = match op {
            Op::Number(value) => Kind::Number(*value),
            Op::Leaf(_) | Op::Stored(..) => Kind::Leaf(()),
            Op::Neg(a) => Kind::Neg(of(a)),
            Op::Recip(a) => Kind::Recip(of(a)),
            Op::Powi(a, power) => Kind::Powi(of(a), *power),
            Op::Function(function, a) => Kind::Function(*function, of(a)),
            Op::Binary(binary, parts) => Kind::Binary(*binary, [of(&parts[0]), of(&parts[1])]),
            Op::Select(comparison, parts) => Kind::Select(*comparison, [0, 1, 2, 3].map(|k| of(&parts[k]))),
            Op::Call(which, parts) => {
                let first = self.arguments.len();
                self.arguments.extend(parts.iter().map(of));
                Kind::Call {
                    which: place(*which),
                    first: place(first),
                    count: place(parts.len()),
                }
            }
        };
        let own = match kind {
            Kind::Recip(_) | Kind::Powi(..) | Kind::Function(..) => 1,
            Kind::Binary(Binary::Div | Binary::Powf | Binary::Atan2, _) | Kind::Select(..) => 2,
            Kind::Call { count, .. } => count as usize,
            _ => 0,
        };
        let slopes = (is_moving && own > 0).then_some(place(self.slopes));
        self.slopes += if is_moving { own } else { 0 };
        self.steps.push(Step { kind, slopes });
    }

    /// The operands of an operation, each with the slope by it.
    fn operands(&self, at: usize) -> Vec<(Place, Slope)> {
        let Step { kind, slopes } = self.steps[at];
        let own = |k: u32| Slope::Own(slopes.unwrap_or(0) + k);
        match kind {
            Kind::Number(_) | Kind::Leaf(()) => Vec::new(),
            Kind::Neg(a) => vec![(a, Slope::Minus)],
            Kind::Recip(a) | Kind::Powi(a, _) | Kind::Function(_, a) => vec![(a, own(0))],
            Kind::Binary(Binary::Add, [a, b]) => vec![(a, Slope::One), (b, Slope::One)],
            Kind::Binary(Binary::Sub, [a, b]) => vec![(a, Slope::One), (b, Slope::Minus)],
            Kind::Binary(Binary::Mul, [a, b]) => vec![(a, Slope::Value(b)), (b, Slope::Value(a))],
            Kind::Binary(_, [a, b]) => vec![(a, own(0)), (b, own(1))],
            Kind::Select(_, [_, _, c, d]) => vec![(c, own(0)), (d, own(1))],
            Kind::Call { first, count, .. } => (0..count)
                .map(|k| (self.arguments[(first + k) as usize], own(k)))
                .collect(),
        }
    }

    /// The products from some results to the inputs.
    fn reverse_sweep(&self, from: &[Place], moving: &[bool], inputs_at: &[Option<usize>]) -> ReverseSweep {
        let mut written = vec![false; self.steps.len()];
        for &result in from {
            written[result as usize] = true;
        }
        let mut sweep = ReverseSweep::default();
        for at in (0..self.steps.len()).rev() {
            if !written[at] || !moving[at] {
                continue;
            }
            if let Some(input) = inputs_at[at] {
                sweep.reached.push((input, place(at)));
            }
            for (to, slope) in self.operands(at) {
                if moving[to as usize] {
                    let first = !core::mem::replace(&mut written[to as usize], true);
                    sweep.links.push(Link {
                        from: place(at),
                        to,
                        slope,
                        first,
                    });
                }
            }
        }
        sweep
    }

    /// The products from the inputs to the results.
    fn way_forward(&self, moving: &[bool]) -> Vec<Link> {
        let mut links = Vec::new();
        for at in (0..self.steps.len()).filter(|&at| moving[at]) {
            let mut first = true;
            for (from, slope) in self.operands(at) {
                if moving[from as usize] {
                    links.push(Link {
                        from,
                        to: place(at),
                        slope,
                        first,
                    });
                    first = false;
                }
            }
        }
        links
    }

    /// The inputs, in the order of the derivatives.
    pub(crate) fn inputs(&self) -> impl ExactSizeIterator<Item = Input> {
        self.inputs.iter().map(|(input, _)| *input)
    }

    /// The number of results.
    pub(crate) fn len(&self) -> usize {
        self.results.len()
    }

    /// Evaluates results and slopes at eight points, of which the first `count` are used.
    pub(crate) fn evaluate(
        &self,
        source: &dyn Source,
        room: &mut Workspace,
        count: usize,
        value: &mut dyn FnMut(Input) -> Eight,
    ) {
        self.make(room);
        for (place, (input, _)) in self.inputs.iter().enumerate() {
            self.set(room, place, value(*input));
        }
        self.evaluate_again(source, room, count);
    }

    /// Allocates the workspace.
    pub(crate) fn make(&self, room: &mut Workspace) {
        room.values.resize(self.steps.len(), Eight::ZERO);
        room.moving.resize(self.steps.len(), Eight::ZERO);
        room.slopes.resize(self.slopes, Eight::ZERO);
    }

    /// Sets an input, by its place among [`Differential::inputs`].
    #[inline]
    pub(crate) fn set(&self, room: &mut Workspace, input: usize, value: Eight) {
        room.values[self.inputs[input].1 as usize] = value;
    }

    /// Evaluates at inputs that were set.
    pub(crate) fn evaluate_again(&self, source: &dyn Source, room: &mut Workspace, count: usize) {
        dispatch::run_wide(Evaluation {
            of: self,
            source,
            room,
            count,
        });
    }

    /// The derivatives of all results one by one; `place_of` gives the place for the derivative of a result
    /// by an input.
    pub(crate) fn sweeps(&self, place_of: &mut dyn FnMut(usize, usize) -> Option<usize>) -> Sweeps {
        let mut sweeps = Sweeps::default();
        for (result, (sweep, &seed)) in self.back.iter().zip(&self.results).enumerate() {
            sweeps.links.extend_from_slice(&sweep.links);
            for &(input, at) in &sweep.reached {
                if let Some(to) = place_of(result, input) {
                    sweeps.taken.push((at, place(to)));
                }
            }
            let ends = (sweeps.links.len(), sweeps.taken.len());
            sweeps.parts.push((seed, ends.0, ends.1));
        }
        sweeps
    }

    /// Evaluates results and all derivatives at inputs that were set.
    #[inline(always)]
    #[allow(clippy::inline_always)] // for the machine's own instructions
    pub(crate) fn sweep(
        &self,
        sweeps: &Sweeps,
        source: &dyn Source,
        room: &mut Workspace,
        count: usize,
        entries: &mut [Eight],
    ) {
        evaluate(self, source, room, count);
        let (mut link, mut taken) = (0, 0);
        for &(seed, links, all) in &sweeps.parts {
            room.moving[seed as usize] = Eight::splat(1.0);
            follow(&sweeps.links[link..links], room, self.branches);
            for &(at, to) in &sweeps.taken[taken..all] {
                entries[to as usize] = room.moving[at as usize];
            }
            (link, taken) = (links, all);
        }
    }

    /// An evaluated result.
    pub(crate) fn result(&self, room: &Workspace, result: usize) -> Eight {
        room.values[self.results[result] as usize]
    }

    /// The derivatives of one result by the inputs that it depends on, each with its place among
    /// [`Differential::inputs`].
    pub(crate) fn back_from(&self, room: &mut Workspace, result: usize, take: &mut dyn FnMut(usize, Eight)) {
        room.moving[self.results[result] as usize] = Eight::splat(1.0);
        self.follow(&self.back[result].links, room);
        for &(input, at) in &self.back[result].reached {
            take(input, room.moving[at as usize]);
        }
    }

    /// The derivatives of the weighted sum of all results.
    pub(crate) fn back_from_all(
        &self,
        room: &mut Workspace,
        weight: &dyn Fn(usize) -> Eight,
        take: &mut dyn FnMut(usize, Eight),
    ) {
        for &result in &self.results {
            room.moving[result as usize] = Eight::ZERO;
        }
        for (k, &result) in self.results.iter().enumerate() {
            let sum = &mut room.moving[result as usize];
            *sum = *sum + weight(k);
        }
        self.follow(&self.back_from_all.links, room);
        for &(input, at) in &self.back_from_all.reached {
            take(input, room.moving[at as usize]);
        }
    }

    /// The changes of the results for changes of the inputs.
    pub(crate) fn forward(
        &self,
        room: &mut Workspace,
        change: &mut dyn FnMut(Input) -> Eight,
        take: &mut dyn FnMut(usize, Eight),
    ) {
        // results that do not depend on the moving inputs do not change
        for &result in &self.results {
            room.moving[result as usize] = Eight::ZERO;
        }
        for &(input, at) in &self.inputs {
            room.moving[at as usize] = change(input);
        }
        self.follow(&self.forward, room);
        for (k, &result) in self.results.iter().enumerate() {
            take(k, room.moving[result as usize]);
        }
    }

    fn follow(&self, links: &[Link], room: &mut Workspace) {
        if links.is_empty() {
            return;
        }
        dispatch::run_wide(ChainRuleWork {
            links,
            room,
            branches: self.branches,
        });
    }
}

/// Marks an operation, and the operations on which it depends, as needed.
fn mark(ops: &[Op], at: usize, needed: &mut [bool]) {
    let mut open = vec![at];
    while let Some(at) = open.pop() {
        for &part in ops[at].parts() {
            if !core::mem::replace(&mut needed[part], true) {
                open.push(part);
            }
        }
    }
}

/// The work of [`Differential::evaluate`].
struct Evaluation<'a> {
    of: &'a Differential,
    source: &'a dyn Source,
    room: &'a mut Workspace,
    count: usize,
}

impl Work for Evaluation<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // for the machine's own instructions
    fn run<const FUSED: bool>(self) {
        evaluate(self.of, self.source, self.room, self.count);
    }
}

/// Evaluates operations and slopes.
#[inline(always)]
#[allow(clippy::inline_always)] // for the machine's own instructions
fn evaluate(of: &Differential, source: &dyn Source, room: &mut Workspace, count: usize) {
    let (values, slopes) = (&mut room.values[..], &mut room.slopes[..]);
    for (place, step) in of.steps.iter().enumerate() {
        let at = |place: Place| values[place as usize];
        let own = step.slopes.map(|own| own as usize);
        let mut slope = |k: usize, slope: Eight| {
            if let Some(own) = own {
                slopes[own + k] = slope;
            }
        };
        let value = match step.kind {
            Kind::Number(value) => Eight::splat(value),
            Kind::Leaf(()) => continue,
            Kind::Neg(a) => -at(a),
            Kind::Recip(a) => {
                let value = Eight::splat(1.0) / at(a);
                slope(0, -(value * value));
                value
            }
            Kind::Powi(a, power) => {
                let a = at(a);
                if own.is_some() {
                    let below = a.lanes(|a| a.powi(power.saturating_sub(1)));
                    slope(0, Eight::splat(f64::from(power)) * below);
                }
                a.lanes(|a| a.powi(power))
            }
            Kind::Binary(binary, [a, b]) => {
                let (a, b) = (at(a), at(b));
                match binary {
                    Binary::Add => a + b,
                    Binary::Sub => a - b,
                    Binary::Mul => a * b,
                    Binary::Div => {
                        let value = a / b;
                        if own.is_some() {
                            let inverse = Eight::splat(1.0) / b;
                            slope(0, inverse);
                            slope(1, -(value * inverse));
                        }
                        value
                    }
                    Binary::Powf => {
                        let value = a.zip(b, f64::powf);
                        slope(0, a.zip(b, |a, b| b * a.powf(b - 1.0)));
                        slope(1, a.zip(value, |a, value| value * a.ln()));
                        value
                    }
                    Binary::Atan2 => {
                        let square = a * a + b * b;
                        slope(0, b / square);
                        slope(1, -(a / square));
                        a.zip(b, f64::atan2)
                    }
                }
            }
            Kind::Select(comparison, [a, b, c, d]) => {
                let (a, b, c, d) = (at(a), at(b), at(c), at(d));
                let holds = match comparison {
                    Comparison::Less => a.zip(b, |a, b| f64::from(u8::from(a < b))),
                    Comparison::LessOrEqual => a.zip(b, |a, b| f64::from(u8::from(a <= b))),
                };
                slope(0, holds);
                slope(1, Eight::splat(1.0) - holds);
                Eight::from_fn(|lane| if holds.0[lane] > 0.0 { c.0[lane] } else { d.0[lane] })
            }
            Kind::Function(name, a) => {
                let a = at(a);
                let value = function(name, a);
                if own.is_some() {
                    slope(0, steepness(name, a, value));
                }
                value
            }
            Kind::Call {
                which,
                first,
                count: arguments,
            } => {
                let range = first as usize..(first + arguments) as usize;
                let arguments = &of.arguments[range];
                call(source, which as usize, arguments, count, values, &mut slope)
            }
        };
        values[place] = value;
    }
}

/// A user's function, with its slopes.
#[inline(never)]
fn call(
    source: &dyn Source,
    which: usize,
    arguments: &[Place],
    count: usize,
    values: &[Eight],
    slope: &mut dyn FnMut(usize, Eight),
) -> Eight {
    let mut value = Eight::ZERO;
    let (mut few, mut many) = ([Dual::new(0.0, 0.0); 8], Vec::new());
    let duals = if let Some(few) = few.get_mut(..arguments.len()) {
        few
    } else {
        many.resize(arguments.len(), Dual::new(0.0, 0.0));
        &mut many[..]
    };
    // a call without arguments has a value, too
    for k in 0..arguments.len().max(1) {
        let mut slopes = Eight::ZERO;
        for lane in 0..count {
            for (place, (dual, &argument)) in duals.iter_mut().zip(arguments).enumerate() {
                let moves = f64::from(u8::from(place == k));
                *dual = Dual::new(values[argument as usize].0[lane], moves);
            }
            let Dual { re, eps } = source.call_dual(which, duals);
            (value.0[lane], slopes.0[lane]) = (re, eps);
        }
        if k < arguments.len() {
            slope(k, slopes);
        }
    }
    value
}

/// The work of [`follow`].
struct ChainRuleWork<'a> {
    links: &'a [Link],
    room: &'a mut Workspace,
    branches: bool,
}

impl Work for ChainRuleWork<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // for the machine's own instructions
    fn run<const FUSED: bool>(self) {
        follow(self.links, self.room, self.branches);
    }
}

/// Computes the products of the chain rule, in order.
#[inline(always)]
#[allow(clippy::inline_always)] // for the machine's own instructions
fn follow(links: &[Link], room: &mut Workspace, branches: bool) {
    let Workspace {
        values,
        slopes,
        moving,
    } = room;
    for link in links {
        let from = moving[link.from as usize];
        let term = match link.slope {
            Slope::One => from,
            Slope::Minus => -from,
            Slope::Value(place) => product(from, values[place as usize], branches),
            Slope::Own(place) => product(from, slopes[place as usize], branches),
        };
        let to = &mut moving[link.to as usize];
        *to = if link.first { term } else { *to + term };
    }
}

/// A change times a slope; with `branches`, zero times an infinite slope is zero, as on a branch that is not
/// taken.
#[inline(always)]
#[allow(clippy::inline_always)] // for the machine's own instructions
fn product(change: Eight, slope: Eight, branches: bool) -> Eight {
    if branches {
        change.zip(
            slope,
            |change, slope| if change == 0.0 { 0.0 } else { change * slope },
        )
    } else {
        change * slope
    }
}

/// A function of one number.
#[inline(always)]
#[allow(clippy::inline_always)] // for the machine's own instructions
fn function(name: Function, a: Eight) -> Eight {
    match name {
        Function::Sqrt => a.map(f64::sqrt),
        Function::Abs => a.map(f64::abs),
        _ => a.lanes(|a| super::evaluate::function(name, a)),
    }
}

/// The derivative of a function, from its argument and its value.
#[inline(never)]
fn steepness(name: Function, a: Eight, value: Eight) -> Eight {
    let one = Eight::splat(1.0);
    match name {
        Function::Sqrt => Eight::splat(0.5) / value,
        Function::Cbrt => one / (Eight::splat(3.0) * value * value),
        Function::Exp => value,
        Function::ExpM1 => value + one,
        Function::Ln => one / a,
        Function::Ln1p => one / (one + a),
        Function::Sin => a.lanes(Lanes::cos),
        Function::Cos => -a.lanes(Lanes::sin),
        Function::Tan => one + value * value,
        Function::Asin => one / ((one - a) * (one + a)).map(f64::sqrt),
        Function::Acos => -(one / ((one - a) * (one + a)).map(f64::sqrt)),
        Function::Atan => one / (one + a * a),
        Function::Sinh => a.map(f64::cosh),
        Function::Cosh => a.map(f64::sinh),
        Function::Tanh => (one - value) * (one + value),
        Function::Asinh => one / (one + a * a).map(f64::sqrt),
        Function::Acosh => one / ((a - one) * (a + one)).map(f64::sqrt),
        Function::Atanh => one / ((one - a) * (one + a)),
        Function::Abs => a.map(f64::signum),
        Function::Signum => Eight::ZERO,
    }
}
