//! The walk through recurrences, order by order; compiled for the machine's own instructions.

use core::cell::Cell;

use super::order::{Lists, SHORT_SUM, Step};
use crate::kernel::series::{ACCELERATED, Argument, Code, Operation, Place, Series, Term};
use crate::number::compensated;
use crate::number::dispatch::Work;
use crate::number::scalar::Scalar;
use crate::series::coefficient::Coefficient;
use crate::series::formulas;
use crate::series::jet::{Call, Jet};
use crate::series::orders::{LANES, RECIPROCALS, Row};
use crate::series::rows;
use crate::series::sums::{Products, Squares, add_product, all_sums};
use crate::series::switch::Switch;
use crate::taylor::control::{self, Judged, Sizes};
use crate::taylor::recurrences::Along;
use crate::taylor::solve::{AnyAccelerations, back_into};
use crate::taylor::state::State;

/// A sequence: what is kept of its coefficients.
#[derive(Clone, Copy, Debug, Default)]
struct Sequence {
    /// The coefficient of order 0.
    start: f64,
    /// What is divided by in every order, inverted; or what decides between pieces.
    inverse: f64,
    /// That of order 1; zero up to order 2, where the newest terms are the same one.
    first: f64,
    /// Those of this order and of the one before, by turns.
    now: [f64; 2],
}

/// The operands of a row: the sequences, and 1 for those that are multiplied by the order.
#[derive(Clone, Copy, Debug)]
struct Stored {
    from: [Place; LANES],
    rate: Row<f64>,
}

/// What recurrences keep of the orders before.
pub(super) struct Tables {
    sequences: Vec<Sequence>,
    products: Vec<Products>,
    squares: Vec<Squares>,
    /// What is stored of each order: left and right of each block of products, then the blocks of squares.
    stored: Vec<Stored>,
    /// The inner sums of an order, products before squares.
    sums: Vec<Row<f64>>,
    /// Position and velocity of an order.
    row: Vec<f64>,
    /// The accelerations of an order as the recurrences give them.
    outputs: Vec<f64>,
    /// Accelerations, then multipliers, that are solved for, and the same in the order of the unknowns.
    solved: Vec<f64>,
    unknown: Vec<f64>,
    rows: Vec<f64>,
    jacobian: Vec<f64>,
    accelerations: AnyAccelerations,
    pub(super) switches: Vec<Switch>,
    pub(super) calls: Vec<Call>,
}

impl Tables {
    /// Tables before the first order.
    pub(super) fn new(series: &Series) -> Self {
        let zero = Place::try_from(series.operations.len()).unwrap_or(Place::MAX);
        let rows = |operands: &mut dyn Iterator<Item = (Place, bool)>| {
            let operands: Vec<_> = operands.collect();
            let rows = operands.chunks(LANES).map(|lanes| {
                let lane = |lane: usize| lanes.get(lane).copied().unwrap_or((zero, false));
                Stored {
                    from: core::array::from_fn(|i| lane(i).0),
                    rate: core::array::from_fn(|i| if lane(i).1 { 1.0 } else { 0.0 }),
                }
            });
            rows.collect::<Vec<_>>()
        };
        let [left, right] =
            [0, 1].map(|side: usize| rows(&mut series.products.iter().map(|operands| operands[side])));
        let products = left.into_iter().zip(right).flat_map(<[Stored; 2]>::from);
        let squares = rows(&mut series.squares.iter().copied());
        let [blocks, of_squares] =
            [series.products.len(), series.squares.len()].map(|count| count.div_ceil(LANES));
        let m = series.rows.len();
        Self {
            // behind the last stands one that is zero
            sequences: vec![Sequence::default(); series.operations.len() + 1],
            products: vec![Products::default(); blocks],
            squares: vec![Squares::default(); of_squares],
            stored: products.chain(squares).collect(),
            sums: vec![[0.0; LANES]; blocks + of_squares],
            row: vec![0.0; 2 * series.coordinates],
            outputs: vec![0.0; series.coordinates],
            solved: vec![0.0; series.coordinates + series.multipliers],
            unknown: vec![0.0; m],
            rows: vec![0.0; m],
            jacobian: vec![0.0; m * m],
            accelerations: AnyAccelerations::new(series.affine, m),
            switches: vec![Switch::default(); series.switches],
            calls: vec![Call::default(); series.functions()],
        }
    }
}

/// The way along a series.
pub(super) struct Way<'a> {
    pub(super) series: &'a rows::Series,
    pub(super) h: f64,
    pub(super) from: &'a State,
    pub(super) to: &'a mut State,
    /// Room for the increments.
    pub(super) room: &'a Cell<Vec<f64>>,
}

impl Work for Way<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let n = self.series.dimension();
        let mut room = self.room.take();
        room.resize(2 * n, 0.0);
        let (dq, dv) = room.split_at_mut(n);
        self.to.copy(self.from);
        let to = self.to.parts();
        self.series
            .increments_as::<FUSED>(self.h, [&mut *dq, &mut *dv, to.a]);
        for ([hi, lo], by) in [(to.q, dq), (to.v, dv)] {
            compensated::add_all(hi, lo, by);
        }
        self.room.set(room);
    }
}

/// One expansion, at the end of a step if there is one.
pub(super) struct Expansion<'a, 'c> {
    pub(super) series: &'a Series,
    pub(super) lists: &'a Lists,
    /// The factors by their places.
    pub(super) factors: &'a [f64],
    pub(super) tables: &'a mut Tables,
    pub(super) room: &'a Cell<Vec<f64>>,
    pub(super) next: &'a mut rows::Series,
    pub(super) step: Option<Along<'c>>,
}

impl Work for Expansion<'_, '_> {
    type Output = Judged;

    #[inline(always)]
    fn run<const FUSED: bool>(mut self) -> Judged {
        let Some(step) = self.step.take() else {
            self.expand::<FUSED>();
            return Judged::NONE;
        };
        let Along {
            series,
            h,
            from,
            to,
            t,
            weights,
            p,
        } = step;
        let way = Way {
            series,
            h,
            from,
            to: &mut *to,
            room: self.room,
        };
        way.run::<FUSED>();
        self.next.begin(t, to.q(), to.v());
        self.next.expect(to.a());
        self.expand::<FUSED>();
        let own = self.next.velocity_of(1);
        Judged {
            sizes: Sizes::of(self.next, weights, p),
            end: [
                control::size(own, weights),
                control::distance(own, to.a(), weights),
            ],
        }
    }
}

impl Expansion<'_, '_> {
    /// Expands the series.
    #[inline(always)]
    fn expand<const FUSED: bool>(&mut self) {
        self.start::<FUSED>();
        if self.series.eager {
            self.orders::<FUSED, true>();
        } else {
            self.orders::<FUSED, false>();
        }
    }

    /// Order 0.
    #[inline(always)]
    fn start<const FUSED: bool>(&mut self) {
        let Self { series, next, .. } = self;
        let tables = &mut *self.tables;
        let walk = Start {
            series,
            factors: self.factors,
            next,
        };
        for sequence in &mut tables.sequences {
            (sequence.first, sequence.now) = (0.0, [0.0; 2]);
        }
        walk.operations::<FUSED>(tables, false);
        if !series.unknown.is_empty() {
            let n = series.coordinates;
            for (a, &guess) in tables.solved.iter_mut().zip(walk.next.velocity_of(1)) {
                *a = if guess.is_finite() { guess } else { 0.0 };
            }
            tables.solved[n..].fill(0.0);
            tables.accelerations.begin();
            loop {
                for (place, &unknown) in series.unknown.iter().enumerate() {
                    let x = &mut tables.solved[at(unknown, n)];
                    *x += tables.accelerations.update[place];
                    tables.unknown[place] = *x;
                }
                walk.operations::<FUSED>(tables, true);
                for (row, &from) in tables.rows.iter_mut().zip(&series.rows) {
                    *row = tables.sequences[from as usize].start;
                }
                let size = series.rows.len();
                tables.jacobian.fill(0.0);
                for &[row, column, from] in &series.jacobian {
                    tables.jacobian[row as usize * size + column as usize] =
                        tables.sequences[from as usize].start;
                }
                let more = tables.accelerations.improve::<FUSED>(
                    &tables.rows,
                    &mut tables.jacobian,
                    &tables.unknown,
                );
                if !more {
                    break;
                }
            }
        }
        for (output, &from) in tables.outputs.iter_mut().zip(&series.accelerations) {
            *output = tables.sequences[from as usize].start;
        }
        next.advance(0, &tables.outputs);
    }

    /// The orders beyond.
    #[inline(always)]
    fn orders<const FUSED: bool, const EAGER: bool>(&mut self) {
        let (series, lists, next) = (self.series, self.lists, &mut *self.next);
        let n = series.coordinates;
        let tables = &mut *self.tables;
        for k in 1..next.order() {
            let Tables {
                sequences,
                products,
                squares,
                stored,
                sums,
                row,
                outputs,
                solved,
                rows,
                accelerations,
                switches,
                calls,
                unknown,
                ..
            } = &mut *tables;
            all_sums::<FUSED, EAGER>(products, squares, k, sums);
            let turn = k & 1;
            let mut order = Order {
                series,
                factors: self.factors,
                sums: sums.as_flattened(),
                sequences,
                solved,
                calls,
                k,
                turn,
                r: RECIPROCALS[k],
                below: k as f64 - 1.0,
            };
            row[..n].copy_from_slice(next.position_of(k));
            row[n..].copy_from_slice(next.velocity_of(k));
            for &[to, from] in &lists.moves {
                order.sequences[to as usize].now[turn] = row[from as usize];
            }
            order.walk::<FUSED, EAGER>(&lists.known);
            if !series.unknown.is_empty() {
                order.solved.fill(0.0);
                order.walk::<FUSED, EAGER>(&lists.accelerated);
                for (row, &from) in rows.iter_mut().zip(&series.rows) {
                    *row = order.sequences[from as usize].now[turn];
                }
                back_into::<FUSED>(&accelerations.inverse, rows, unknown);
                for (&place, x) in series.unknown.iter().zip(&*unknown) {
                    order.solved[at(place, n)] = *x;
                }
                order.walk::<FUSED, EAGER>(&lists.again);
            }
            for (switch, argument) in switches.iter_mut().zip(&series.arguments) {
                let of = |place: Place| order.sequences[place as usize].now[turn];
                switch.push(
                    k,
                    match *argument {
                        Argument::One(u) => of(u),
                        Argument::Difference(u, v) => of(u) - of(v),
                    },
                );
            }
            for (output, &from) in outputs.iter_mut().zip(&series.accelerations) {
                *output = order.sequences[from as usize].now[turn];
            }
            let below = order.below;
            let (of_products, of_squares) = stored.split_at(2 * products.len());
            for (block, [left, right]) in products.iter_mut().zip(of_products.as_chunks().0) {
                block.left[k] = left.row(sequences, turn, below);
                block.right[k] = right.row(sequences, turn, below);
            }
            for (block, stored) in squares.iter_mut().zip(of_squares) {
                block.rows[k] = stored.row(sequences, turn, below);
            }
            if EAGER && k == 2 {
                for sequence in &mut *sequences {
                    sequence.first = sequence.now[1];
                }
            }
            next.advance(k, outputs);
        }
    }
}

impl Stored {
    /// The operands of an order.
    #[inline(always)]
    fn row(&self, sequences: &[Sequence], turn: usize, below: f64) -> Row<f64> {
        let mut row = [0.0; LANES];
        for i in 0..LANES {
            row[i] = sequences[self.from[i] as usize].now[turn];
        }
        // exact: a small whole number, and 1 for those that are not multiplied
        for i in 0..LANES {
            row[i] *= 1.0 + self.rate[i] * below;
        }
        row
    }
}

/// The place of an unknown among accelerations and multipliers.
#[inline(always)]
fn at((is_multiplier, place): (bool, Place), coordinates: usize) -> usize {
    place as usize + if is_multiplier { coordinates } else { 0 }
}

/// Order 0.
struct Start<'a> {
    series: &'a Series,
    factors: &'a [f64],
    next: &'a rows::Series,
}

impl Start<'_> {
    /// The operations that depend on accelerations that are solved for, or the others.
    #[inline(always)]
    fn operations<const FUSED: bool>(&self, tables: &mut Tables, accelerated: bool) {
        for (to, op) in self.series.operations.iter().enumerate() {
            if (op.lists & ACCELERATED > 0) == accelerated {
                self.operation::<FUSED>(to, op, tables);
            }
        }
    }

    /// One operation.
    #[inline(always)]
    fn operation<const FUSED: bool>(&self, to: usize, op: &Operation, tables: &mut Tables) {
        let Tables {
            sequences,
            solved,
            switches,
            calls,
            ..
        } = tables;
        let z = |part: usize| sequences[op.parts[part] as usize].start;
        let u = z(0);
        let index = op.index as usize;
        let switch = op.switch.map(|switch| switch as usize);
        let mut inverse = 0.0;
        let value = match op.code {
            Code::Time => self.next.time(),
            Code::Position => self.next.position_of(0)[index],
            Code::Velocity => self.next.velocity_of(0)[index],
            Code::Acceleration => solved[index],
            Code::Multiplier => solved[self.series.coordinates + index],
            Code::Constant => self.factors[index],
            Code::Linear => {
                let constant = op.constant.map(|constant| self.factors[constant as usize]);
                let terms = terms(self.series, op.terms);
                linear::<FUSED>(constant, terms, self.factors, |place| {
                    sequences[place as usize].start
                })
            }
            Code::Product => u * z(1),
            Code::Square => u * u,
            Code::Quotient => {
                inverse = formulas::inverted(z(1));
                u / z(1)
            }
            Code::Reciprocal => {
                inverse = formulas::inverted(u);
                1.0 / u
            }
            Code::Root => {
                let root = Scalar::sqrt(u);
                inverse = formulas::inverted(2.0 * root);
                root
            }
            Code::CubeRoot => {
                inverse = formulas::inverted(u);
                Scalar::cbrt(u)
            }
            Code::Power => {
                inverse = formulas::inverted(u);
                Scalar::powf(u, self.factors[index])
            }
            Code::Exp => Scalar::exp(u),
            Code::ExpM1 => Scalar::exp_m1(u),
            Code::Ln => {
                inverse = formulas::inverted(u);
                Scalar::ln(u)
            }
            Code::Ln1p => {
                inverse = formulas::inverted(1.0 + u);
                Scalar::ln_1p(u)
            }
            Code::Sin => {
                let (sine, cosine) = Coefficient::sin_cos(u);
                if let Some(partner) = sequences.get_mut(to + 1) {
                    partner.start = cosine;
                }
                sine
            }
            // computed with its sine
            Code::Cos => return,
            Code::Sinh => Scalar::sinh(u),
            Code::Cosh => Scalar::cosh(u),
            Code::Tan => Scalar::tan(u),
            Code::Tanh => {
                if let Some(switch) = switch.and_then(|switch| switches.get_mut(switch)) {
                    switch.steep(u);
                }
                Scalar::tanh(u)
            }
            Code::Conjugate => formulas::conjugate(u),
            Code::Asin | Code::Acos | Code::Atan | Code::Asinh | Code::Acosh | Code::Atanh => {
                inverse = formulas::inverted(z(1));
                match op.code {
                    Code::Asin => Scalar::asin(u),
                    Code::Acos => Scalar::acos(u),
                    Code::Atan => Scalar::atan(u),
                    Code::Asinh => Scalar::asinh(u),
                    Code::Acosh => Scalar::acosh(u),
                    _ => Scalar::atanh(u),
                }
            }
            Code::Atan2 => {
                inverse = formulas::inverted(z(2));
                Scalar::atan2(u, z(1))
            }
            Code::Abs | Code::Signum => {
                let own = Scalar::signum(u);
                let sign = match switch.and_then(|switch| switches.get_mut(switch)) {
                    Some(switch) => switch.start(u, own),
                    None => own,
                };
                if op.code == Code::Signum {
                    sign
                } else {
                    // its sign serves in every order
                    inverse = sign;
                    Scalar::abs(u)
                }
            }
            Code::Less | Code::LessOrEqual => {
                let holds = if op.code == Code::Less {
                    u < z(1)
                } else {
                    u <= z(1)
                };
                inverse = match switch.and_then(|switch| switches.get_mut(switch)) {
                    Some(switch) => {
                        let side = switch.start(u - z(1), if holds { -1.0 } else { 1.0 });
                        if side < 0.0 { 1.0 } else { 0.0 }
                    }
                    None => f64::from(holds),
                };
                formulas::select(inverse, z(2), z(3))
            }
            Code::Call => {
                let moves = self.series.moves(op.parts[0]);
                match (self.series.calls.get(index), switch.and_then(|call| calls.get_mut(call))) {
                    (Some(table), Some(call)) => call.first([u], [moves], |[x]| table.value::<Jet>(Some(x))),
                    _ => f64::NAN,
                }
            }
        };
        if let Some(to) = sequences.get_mut(to) {
            (to.start, to.inverse) = (value, inverse);
        }
    }
}

/// Some of the terms.
#[inline(always)]
fn terms(series: &Series, [first, count]: [Place; 2]) -> &[Term] {
    let first = first as usize;
    series
        .terms
        .get(first..first + count as usize)
        .unwrap_or_default()
}

/// `constant + Σ coefficient · term`, as the attribute writes it.
#[inline(always)]
fn linear<const FUSED: bool>(
    constant: Option<f64>,
    terms: &[Term],
    factors: &[f64],
    value: impl Fn(Place) -> f64,
) -> f64 {
    if terms.len() > SHORT_SUM as usize {
        // four sums side by side
        let mut sums = [0.0; 4];
        for (i, &[c, x]) in terms.iter().enumerate() {
            sums[i % 4] = add_product::<FUSED, f64>(sums[i % 4], factors[c as usize], value(x));
        }
        let rest = (sums[0] + sums[1]) + (sums[2] + sums[3]);
        return constant.map_or(rest, |constant| constant + rest);
    }
    let mut sum = constant;
    for &[c, x] in terms {
        let (c, x) = (factors[c as usize], value(x));
        sum = Some(match sum {
            None => c * x,
            Some(sum) => add_product::<FUSED, f64>(sum, c, x),
        });
    }
    sum.unwrap_or(0.0)
}

/// An order beyond 0.
struct Order<'a> {
    series: &'a Series,
    factors: &'a [f64],
    /// The inner sums.
    sums: &'a [f64],
    sequences: &'a mut [Sequence],
    /// Accelerations and multipliers.
    solved: &'a mut [f64],
    calls: &'a mut [Call],
    k: usize,
    /// Which of two coefficients are those of this order.
    turn: usize,
    r: f64,
    below: f64,
}

impl Order<'_> {
    #[inline(always)]
    fn of(&self, place: Place) -> Sequence {
        self.sequences[place as usize]
    }

    /// Its coefficient of this order.
    #[inline(always)]
    fn now(&self, place: Place) -> f64 {
        self.sequences[place as usize].now[self.turn]
    }

    /// Its coefficients of order 0 and of this order.
    #[inline(always)]
    fn pair(&self, of: Sequence) -> [f64; 2] {
        [of.start, of.now[self.turn]]
    }

    /// Its coefficients of order 1 and of the order before.
    #[inline(always)]
    fn newest(&self, of: Sequence) -> [f64; 2] {
        [of.first, of.now[self.turn ^ 1]]
    }

    /// Those of `j x_j`.
    #[inline(always)]
    fn rates(&self, of: Sequence) -> [f64; 2] {
        [of.first, self.below * of.now[self.turn ^ 1]]
    }

    /// The inner sum of two operands.
    #[inline(always)]
    fn inner<const FUSED: bool, const EAGER: bool>(&self, sum: Place, x: [f64; 2], y: [f64; 2]) -> f64 {
        let sum = self.sums[sum as usize];
        if EAGER {
            formulas::inner::<FUSED, f64>(sum, x, y)
        } else {
            sum
        }
    }

    /// That of an operand with itself.
    #[inline(always)]
    fn inner_square<const FUSED: bool, const EAGER: bool>(&self, sum: Place, x: [f64; 2]) -> f64 {
        let sum = self.sums[sum as usize];
        if EAGER {
            formulas::inner_square::<FUSED, f64>(sum, x)
        } else {
            sum
        }
    }

    /// Computes some sequences.
    #[inline(always)]
    fn walk<const FUSED: bool, const EAGER: bool>(&mut self, steps: &[Step]) {
        let (k, r) = (self.k, self.r);
        for step in steps {
            let (to, value) = match *step {
                Step::Time { to } => (to, if k == 1 { 1.0 } else { 0.0 }),
                Step::Acceleration { to, index } => (to, self.solved[index as usize]),
                Step::Multiplier { to, index } => {
                    (to, self.solved[self.series.coordinates + index as usize])
                }
                Step::Scaled { to, c, u } => (to, self.factors[c as usize] * self.now(u)),
                Step::Two {
                    to,
                    c: [c, d],
                    u: [u, v],
                } => {
                    let sum = self.factors[c as usize] * self.now(u);
                    let d = self.factors[d as usize];
                    (to, add_product::<FUSED, f64>(sum, d, self.now(v)))
                }
                Step::Linear { to, first, count } => {
                    let terms = terms(self.series, [first, count]);
                    (
                        to,
                        linear::<FUSED>(None, terms, self.factors, |place| self.now(place)),
                    )
                }
                Step::Product { to, u, v, sum } => {
                    let (u, v) = (self.of(u), self.of(v));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.newest(u), self.newest(v));
                    (
                        to,
                        formulas::product::<FUSED, f64>(inner, self.pair(u), self.pair(v)),
                    )
                }
                Step::Square { to, u, sum } => {
                    let u = self.of(u);
                    let inner = self.inner_square::<FUSED, EAGER>(sum, self.newest(u));
                    (to, formulas::square::<FUSED, f64>(inner, self.pair(u)))
                }
                Step::Quotient { to, u, v, sum } => {
                    let (u, v, own) = (self.now(u), self.of(v), self.of(to));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.newest(own), self.newest(v));
                    let v = v.now[self.turn];
                    (
                        to,
                        formulas::quotient::<FUSED, f64>(inner, own.start, u, v, own.inverse),
                    )
                }
                Step::Reciprocal { to, v, sum } => {
                    let (v, own) = (self.of(v), self.of(to));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.newest(own), self.newest(v));
                    let v = v.now[self.turn];
                    (
                        to,
                        formulas::reciprocal::<FUSED, f64>(inner, own.start, v, own.inverse),
                    )
                }
                Step::Root { to, u, sum } => {
                    let own = self.of(to);
                    let inner = self.inner_square::<FUSED, EAGER>(sum, self.newest(own));
                    (to, formulas::root(inner, self.now(u), own.inverse))
                }
                Step::Power {
                    to,
                    u,
                    exponent,
                    sums: [outer, inner],
                } => {
                    let (u, own) = (self.of(u), self.of(to));
                    let outer = self.inner::<FUSED, EAGER>(outer, self.newest(own), self.rates(u));
                    let inner = self.inner::<FUSED, EAGER>(inner, self.rates(own), self.newest(u));
                    let exponent = self.factors[exponent as usize];
                    let u = u.now[self.turn];
                    (
                        to,
                        formulas::power(exponent, [outer, inner], own.start, u, [own.inverse, r]),
                    )
                }
                Step::Rate { to, u, factor, sum } => {
                    let (u, factor) = (self.of(u), self.of(factor));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.rates(u), self.newest(factor));
                    let u = u.now[self.turn];
                    (to, formulas::rate::<FUSED, f64>(inner, u, factor.start, r))
                }
                Step::ExpM1 { to, u, sum } => {
                    let (u, own) = (self.of(u), self.of(to));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.rates(u), self.newest(own));
                    let u = u.now[self.turn];
                    (to, formulas::rate::<FUSED, f64>(inner, u, 1.0 + own.start, r))
                }
                Step::Circle { sine, u, sums } => {
                    let cosine = sine + 1;
                    let u = self.of(u);
                    let [s, c] = [self.of(sine), self.of(cosine)];
                    let (rates, u) = (self.rates(u), u.now[self.turn]);
                    let inner = self.inner::<FUSED, EAGER>(sums[0], rates, self.newest(c));
                    let value = formulas::rate::<FUSED, f64>(inner, u, c.start, r);
                    self.sequences[sine as usize].now[self.turn] = value;
                    let inner = self.inner::<FUSED, EAGER>(sums[1], rates, self.newest(s));
                    (cosine, -formulas::rate::<FUSED, f64>(inner, u, s.start, r))
                }
                Step::BySlope { to, u, slope, sum } => {
                    let (slope, own) = (self.of(slope), self.of(to));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.rates(own), self.newest(slope));
                    (to, formulas::by_slope(inner, self.now(u), own.inverse, r))
                }
                Step::Minus { to, u } => (to, -self.now(u)),
                Step::Angle {
                    to,
                    y,
                    x,
                    radius,
                    sums: [left, right, rest],
                } => {
                    let (y, x, radius, own) = (self.of(y), self.of(x), self.of(radius), self.of(to));
                    let sums = [
                        self.inner::<FUSED, EAGER>(left, self.rates(y), self.newest(x)),
                        self.inner::<FUSED, EAGER>(right, self.rates(x), self.newest(y)),
                        self.inner::<FUSED, EAGER>(rest, self.rates(own), self.newest(radius)),
                    ];
                    (
                        to,
                        formulas::angle(sums, self.pair(y), self.pair(x), [own.inverse, r]),
                    )
                }
                Step::Abs { to, u } => (to, self.of(to).inverse * self.now(u)),
                Step::Select { to, then, otherwise } => {
                    let decides = self.of(to).inverse;
                    (
                        to,
                        formulas::select(decides, self.now(then), self.now(otherwise)),
                    )
                }
                Step::Call { to } => (to, self.call::<FUSED>(to)),
            };
            self.sequences[to as usize].now[self.turn] = value;
        }
    }

    /// The coefficient of a table of samples.
    #[inline(always)]
    fn call<const FUSED: bool>(&mut self, to: Place) -> f64 {
        let Some(op) = self.series.operations.get(to as usize) else {
            return f64::NAN;
        };
        let argument = self.pair(self.of(op.parts[0]));
        let moves = self.series.moves(op.parts[0]);
        let table = self.series.calls.get(op.index as usize);
        let call = op.switch.and_then(|call| self.calls.get_mut(call as usize));
        match (table, call) {
            (Some(_), Some(call)) if call.is_still() => 0.0,
            (Some(table), Some(call)) => {
                let [value, now] = argument;
                call.coefficient::<FUSED, 1>(self.k, [value], [now], [moves], |[x]| {
                    table.value::<Jet>(Some(x))
                })
            }
            _ => f64::NAN,
        }
    }
}
