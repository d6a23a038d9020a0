//! The interpreter of recurrences, order by order; compiled for the machine's own instructions.

use core::cell::Cell;

use super::order::{Lists, Place, ROOM, SHORT_SUM, Step, narrow};
use super::start::Start;
use crate::kernel::series::{Argument, Series};
use crate::number::compensated;
use crate::number::dispatch::Work;
use crate::number::fours::on_doubles;
use crate::series::blocks::ones;
use crate::series::convolutions::{InnerSums, Pair};
use crate::series::formulas;
use crate::series::jet::{Call, Jet};
use crate::series::orders::{LANES, RECIPROCALS, Row};
use crate::series::rows;
use crate::series::sums::add_product;
use crate::series::switch::Switch;
use crate::solve::rotation::{self, SLOTS};
use crate::taylor::control::{self, Assessment, Sizes};
use crate::taylor::recurrences::Along;
use crate::taylor::solve::{AnyAccelerations, back_into};
use crate::taylor::state::State;

/// The fields of the numbers. Of each sequence: the coefficient of the order at hand.
const NOW: usize = 0;
/// The coefficient of order 0.
pub(super) const START: usize = 1;
/// The reciprocal of the divisor of all orders, or the sign that selects a piece.
pub(super) const INVERSE: usize = 2;
/// The factors.
pub(super) const FACTOR: usize = 3;
/// The inner sums of an order, products before squares.
const SUM: usize = 4;
const FIELDS: usize = 5;

/// The distance of two fields. The numbers of a sequence are in different sets of the cache.
const FIELD: usize = ROOM + 72;

/// All numbers: of each field one for every possible [`Place`], so that no bounds are checked. Unwritten pages take no physical memory.
pub(super) type Memory = [f64; FIELDS * FIELD];

/// The number of a field at a place.
#[inline(always)]
fn number<const OF: usize>(memory: &Memory, place: impl Into<u32>) -> f64 {
    memory[OF * FIELD + place.into() as usize]
}

/// Access to the numbers.
pub(super) struct Numbers<'a>(pub(super) &'a mut Memory);

impl Numbers<'_> {
    /// The number of a field at a place.
    #[inline(always)]
    pub(super) fn at<const OF: usize>(&self, place: impl Into<u32>) -> f64 {
        number::<OF>(self.0, place)
    }

    #[inline(always)]
    pub(super) fn set<const OF: usize>(&mut self, place: impl Into<u32>, value: f64) {
        self.0[OF * FIELD + place.into() as usize] = value;
    }

    /// The numbers of a field.
    #[inline(always)]
    pub(super) fn all<const OF: usize>(&mut self) -> &mut [f64] {
        &mut self.0[OF * FIELD..OF * FIELD + ROOM]
    }
}

/// The operands of a row: the sequences, and 1 for those that are multiplied by the order.
#[derive(Clone, Copy, Debug)]
struct Stored {
    from: [Place; LANES],
    rate: Row<f64>,
    /// Whether any is multiplied.
    any: bool,
    /// What the coefficients of order 1 are multiplied by in the newest terms: 1, or in a square 2 on the left and 0 on the right.
    newest: Row<f64>,
}

/// The operands of a block of inner sums.
#[derive(Clone, Copy, Debug)]
struct Operands {
    /// The pair of blocks, and which of them it is.
    place: [usize; 2],
    /// Left and right; of a block of squares only those on the left are read.
    sides: [Stored; 2],
    is_square: bool,
}

/// The state of the recurrences.
pub(super) struct Tables {
    pub(super) numbers: Box<Memory>,
    /// The pairs of blocks of inner sums: products, then squares.
    pairs: Vec<Pair>,
    /// The number of pairs of products, and of leading blocks of them that form one sum in each lane.
    products: usize,
    ones: usize,
    /// What is stored in each order.
    operands: Vec<Operands>,
    /// The velocity of an order.
    velocity: Vec<f64>,
    /// Accelerations, then multipliers, that are solved for; then the same in the order of the unknowns.
    pub(super) solved: Vec<f64>,
    unknown: Vec<f64>,
    rows: Vec<f64>,
    jacobian: Vec<f64>,
    accelerations: AnyAccelerations,
    pub(super) switches: Vec<Switch>,
    pub(super) calls: Vec<Call>,
    /// The coefficients of rotations.
    pub(super) turning: Turning,
}

/// The coefficients of rotations and of their angular velocities, by order, all rotations of one order together.
#[derive(Clone, Debug)]
pub(super) struct Turning {
    /// The first places of rotations.
    pub(super) rotations: Vec<usize>,
    q: Vec<[f64; SLOTS]>,
    w: Vec<[f64; SLOTS]>,
}

impl Turning {
    /// The coefficients of order 0.
    fn begin(&mut self, (q, v): (&[f64], &[f64])) {
        self.q.clear();
        self.w.clear();
        for &first in &self.rotations {
            self.q.push(slots(q, first));
            self.w.push(slots(v, first));
        }
    }

    /// Computes the coefficients of order `k` in a row, from those of lower orders and of the angular
    /// velocity.
    #[inline(always)]
    fn advance<const FUSED: bool>(&mut self, k: usize, q: &mut [f64], v: Option<&[f64]>) {
        let count = self.rotations.len();
        for (place, &first) in self.rotations.iter().enumerate() {
            let (known_q, known_w) = (&self.q, &self.w);
            let term = |j: usize| [known_q[j * count + place], known_w[(k - 1 - j) * count + place]];
            let next = rotation::Coefficient {
                scale: RECIPROCALS[k],
                pairs: (0..k / 2).map(|j| [term(2 * j), term(2 * j + 1)]),
                last: (k % 2 == 1).then(|| term(k - 1)),
            };
            let turned = on_doubles::<FUSED, _>(next);
            for (to, x) in q.iter_mut().skip(first).zip(turned) {
                *to = x;
            }
        }
        if let Some(v) = v {
            for &first in &self.rotations {
                self.q.push(slots(q, first));
                self.w.push(slots(v, first));
            }
        }
    }
}

/// The four numbers of a rotation.
fn slots(numbers: &[f64], first: usize) -> [f64; SLOTS] {
    let slots = numbers.get(first..).and_then(|numbers| numbers.first_chunk());
    slots.copied().unwrap_or([f64::NAN; SLOTS])
}

impl Tables {
    /// Tables before the first order.
    pub(super) fn new(series: &Series, rotations: &[usize]) -> Option<Self> {
        let zero = u32::try_from(series.operations.len()).ok()?;
        // an operand, and what its coefficient of order 1 is multiplied by
        let rows = |operands: &[((u32, bool), f64)]| {
            let lane = |lane: usize| operands.get(lane).copied().unwrap_or(((zero, false), 0.0));
            Stored {
                // sequences whose places are possible
                from: core::array::from_fn(|i| narrow(lane(i).0.0).unwrap_or_default()),
                rate: core::array::from_fn(|i| if lane(i).0.1 { 1.0 } else { 0.0 }),
                any: operands.iter().any(|lane| lane.0.1),
                newest: core::array::from_fn(|i| lane(i).1),
            }
        };
        let squares = series.squares.iter().map(|&operand| [operand; 2]);
        let (products, squares) = (&series.products, squares.collect());
        let count = |blocks: &Vec<_>| blocks.len().div_ceil(2 * LANES);
        let mut operands = Vec::new();
        for (blocks, first, is_square) in [(products, 0, false), (&squares, count(products), true)] {
            for (place, lanes) in blocks.chunks(LANES).enumerate() {
                let sides = [0, 1].map(|side: usize| {
                    let lanes = lanes.iter().map(|both| match both {
                        [left, right] if left == right => (*left, [2.0, 0.0][side]),
                        _ => (both[side], 1.0),
                    });
                    rows(&lanes.collect::<Vec<_>>())
                });
                operands.push(Operands {
                    place: [first + place / 2, place % 2],
                    sides,
                    is_square,
                });
            }
        }
        let m = series.rows.len();
        Some(Self {
            // never built on the stack
            numbers: vec![0.0; FIELDS * FIELD].into_boxed_slice().try_into().ok()?,
            pairs: vec![Pair::default(); count(products) + count(&squares)],
            products: count(products),
            ones: ones(products.len().div_ceil(LANES)),
            operands,
            velocity: vec![0.0; series.coordinates],
            solved: vec![0.0; series.coordinates + series.multipliers],
            unknown: vec![0.0; m],
            rows: vec![0.0; m],
            jacobian: vec![0.0; m * m],
            accelerations: AnyAccelerations::new(series.affine, m),
            switches: vec![Switch::default(); series.switches],
            calls: vec![Call::default(); series.functions()],
            turning: Turning {
                rotations: rotations.to_vec(),
                q: Vec::new(),
                w: Vec::new(),
            },
        })
    }
}

impl Tables {
    /// Resets switches and calls; the other tables are written before they are read.
    pub(super) fn forget(&mut self) {
        self.switches.fill_with(Switch::default);
        self.calls.fill_with(Call::default);
    }
}

/// The evaluation of a series at the end of a step.
pub(super) struct Way<'a> {
    pub(super) series: &'a rows::Series,
    pub(super) h: f64,
    pub(super) from: &'a State,
    pub(super) to: &'a mut State,
    /// The first places of rotations.
    pub(super) rotations: &'a [usize],
    /// Workspace for the increments.
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
        rotation::keep_norm(self.rotations, self.to.parts().q);
        self.room.set(room);
    }
}

/// One expansion, preceded by a step if there is one.
pub(super) struct Expansion<'a, 'c> {
    pub(super) series: &'a Series,
    pub(super) lists: &'a Lists,
    pub(super) tables: &'a mut Tables,
    pub(super) room: &'a Cell<Vec<f64>>,
    pub(super) next: &'a mut rows::Series,
    pub(super) step: Option<Along<'c>>,
}

impl Work for Expansion<'_, '_> {
    type Output = Assessment;

    #[inline(always)]
    fn run<const FUSED: bool>(mut self) -> Assessment {
        let Some(step) = self.step.take() else {
            self.expand::<FUSED>();
            return Assessment::NONE;
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
            rotations: &self.tables.turning.rotations,
            room: self.room,
        };
        way.run::<FUSED>();
        self.next.begin(t, to.q(), to.v());
        self.next.expect(to.a());
        self.expand::<FUSED>();
        let own = self.next.velocity_of(1);
        Assessment {
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
        let n = series.coordinates;
        tables.velocity.copy_from_slice(next.start().1);
        tables.turning.begin(next.start());
        let walk = Start {
            series,
            lists: self.lists,
            next,
        };
        let mut numbers = Numbers(&mut tables.numbers);
        numbers.all::<NOW>()[..series.operations.len().min(ROOM)].fill(0.0);
        walk.operations::<FUSED>(tables, false);
        if !series.unknown.is_empty() {
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
                    *row = number::<START>(&tables.numbers, from);
                }
                let size = series.rows.len();
                tables.jacobian.fill(0.0);
                for &[row, column, from] in &series.jacobian {
                    tables.jacobian[row as usize * size + column as usize] =
                        number::<START>(&tables.numbers, from);
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
        let determinant = (!series.unknown.is_empty()).then_some(tables.accelerations.sign);
        let divisors = series.divisors.iter();
        let divisors = divisors.map(|&divisor| number::<START>(&tables.numbers, divisor).signum());
        next.set_signs(rows::number_of_signs(determinant.into_iter().chain(divisors)));
        for (switch, argument) in tables.switches.iter_mut().zip(&series.arguments) {
            match *argument {
                Argument::Steep(u) => switch.steep(number::<START>(&tables.numbers, u)),
                Argument::Power(u, exponent) => {
                    switch.power(number::<START>(&tables.numbers, u), exponent);
                }
                Argument::Bounded(u, bound) => {
                    switch.bounded(number::<START>(&tables.numbers, u), bound);
                }
                Argument::Sign(_) | Argument::Difference(..) => {}
            }
        }
        let [q, v] = next.tables_mut();
        let (_, v) = v.split_at_mut(n);
        advance::<START>(self.lists, tables, 1, [&mut q[n..], &mut *v]);
        turn::<FUSED>(tables, self.lists, 1, [&mut q[n..], v]);
    }

    /// The higher orders.
    #[inline(always)]
    fn orders<const FUSED: bool, const EAGER: bool>(&mut self) {
        let (n, order) = (self.series.coordinates, self.next.order());
        let [q, v] = self.next.tables_mut();
        let rows = q
            .chunks_exact_mut(n.max(1))
            .skip(2)
            .zip(v.chunks_exact_mut(n.max(1)).skip(2));
        for (k, (q, v)) in (1..order).zip(rows) {
            // an order is long: no registers are used for loop counters
            let k = core::hint::black_box(k);
            order_of::<FUSED, EAGER>(self.series, self.lists, self.tables, k, [&mut *q, &mut *v]);
            turn::<FUSED>(self.tables, self.lists, k + 1, [q, v]);
        }
        // a position is one order ahead of its velocity
        let (velocities, q) = (&v[order * n..], &mut q[(order + 1) * n..]);
        for (q, v) in q.iter_mut().zip(velocities).take(n) {
            *q = v * RECIPROCALS[order + 1];
        }
        self.tables.turning.advance::<FUSED>(order + 1, q, None);
    }
}

/// Computes the coefficients of order `k` of rotations, which replace those from the velocity.
#[inline(always)]
fn turn<const FUSED: bool>(tables: &mut Tables, lists: &Lists, k: usize, [q, v]: [&mut [f64]; 2]) {
    let Tables { turning, numbers, .. } = tables;
    if turning.rotations.is_empty() {
        return;
    }
    let mut numbers = Numbers(numbers);
    turning.advance::<FUSED>(k, q, Some(v));
    for &first in &turning.rotations {
        for i in first..first + SLOTS {
            if let (Some(&[place, ..]), Some(x)) = (lists.coordinates.get(i), q.get(i)) {
                numbers.set::<NOW>(place, *x);
            }
        }
    }
}

/// Stores the accelerations of an order, which stand in a field of their sequences. Positions and velocities
/// of the next order follow.
#[inline(always)]
fn advance<const FROM: usize>(
    lists: &Lists,
    tables: &mut Tables,
    next: usize,
    [to_q, to_v]: [&mut [f64]; 2],
) {
    let Tables {
        numbers, velocity, ..
    } = tables;
    let mut numbers = Numbers(numbers);
    let scale = RECIPROCALS[next];
    let rows = to_q.iter_mut().zip(to_v).zip(velocity);
    for (&[q, v, a], ((to_q, to_v), now)) in lists.coordinates.iter().zip(rows) {
        *to_q = *now * scale;
        *now = numbers.at::<FROM>(a) * scale;
        *to_v = *now;
        numbers.set::<NOW>(q, *to_q);
        numbers.set::<NOW>(v, *now);
    }
}

/// Computes the coefficients of one order, and of the sequences one order ahead.
#[inline(always)]
fn order_of<const FUSED: bool, const EAGER: bool>(
    series: &Series,
    lists: &Lists,
    tables: &mut Tables,
    k: usize,
    row: [&mut [f64]; 2],
) {
    let Tables {
        numbers,
        pairs,
        products,
        ones,
        operands,
        rows,
        accelerations,
        switches,
        calls,
        unknown,
        ..
    } = tables;
    let mut numbers = Numbers(numbers);
    on_doubles::<FUSED, _>(InnerSums::<EAGER> {
        pairs,
        products: *products,
        ones: *ones,
        k,
        sums: numbers.all::<SUM>().as_chunks_mut().0.as_chunks_mut().0,
    });
    numbers.set::<NOW>(lists.time, if k == 1 { 1.0 } else { 0.0 });
    let mut list = &lists.known;
    for phase in 0.. {
        let order = Order {
            series,
            lists,
            numbers: Numbers(&mut *numbers.0),
            calls,
            k,
            steps: list,
        };
        order.run::<FUSED>();
        if phase == 2 || series.unknown.is_empty() {
            break;
        }
        if phase == 0 {
            for &place in &lists.unknown {
                numbers.set::<NOW>(place, 0.0);
            }
            list = &lists.accelerated;
            continue;
        }
        for (row, &from) in rows.iter_mut().zip(&series.rows) {
            *row = numbers.at::<NOW>(from);
        }
        back_into::<FUSED>(&accelerations.inverse, rows, unknown);
        for (&place, x) in lists.unknown.iter().zip(&*unknown) {
            numbers.set::<NOW>(place, *x);
        }
        list = &lists.again;
    }
    let numbers = &numbers;
    for (switch, argument) in switches.iter_mut().zip(&series.arguments) {
        let coefficient = match *argument {
            Argument::Sign(u) | Argument::Steep(u) | Argument::Power(u, _) | Argument::Bounded(u, _) => {
                numbers.at::<NOW>(u)
            }
            Argument::Difference(u, v) => numbers.at::<NOW>(u) - numbers.at::<NOW>(v),
        };
        switch.push(k, coefficient);
    }
    let below = k as f64 - 1.0;
    for Operands {
        place: [pair, block],
        sides: [left, right],
        is_square,
    } in operands
    {
        let row = left.row(numbers, below);
        let other = if *is_square {
            row
        } else {
            right.row(numbers, below)
        };
        pairs[*pair].store(k, *block, [row, other]);
        if EAGER && k == 2 {
            pairs[*pair].keep(*block, [left.newest, right.newest]);
        }
    }
    advance::<NOW>(lists, tables, k + 1, row);
}

impl Stored {
    /// The operands of an order.
    #[inline(always)]
    fn row(&self, numbers: &Numbers<'_>, below: f64) -> Row<f64> {
        let mut row = [0.0; LANES];
        for i in 0..LANES {
            row[i] = numbers.at::<NOW>(self.from[i]);
        }
        if self.any {
            // exact: a small integer, and 1 for those that are not multiplied
            for i in 0..LANES {
                row[i] *= 1.0 + self.rate[i] * below;
            }
        }
        row
    }
}

/// The place of an unknown among accelerations and multipliers.
#[inline(always)]
fn at((is_multiplier, place): (bool, u32), coordinates: usize) -> usize {
    place as usize + if is_multiplier { coordinates } else { 0 }
}

/// A range of the terms.
#[inline(always)]
pub(super) fn terms(lists: &Lists, first: u32, count: u32) -> &[[Place; 2]] {
    let first = first as usize;
    lists.terms.get(first..first + count as usize).unwrap_or_default()
}

/// `constant + Σ coefficient · term`, with the operations of the attribute's code.
#[inline(always)]
pub(super) fn linear<const FUSED: bool, const OF: usize>(
    constant: Option<f64>,
    terms: &[[Place; 2]],
    numbers: &Numbers<'_>,
) -> f64 {
    if terms.len() > SHORT_SUM {
        // four independent sums
        let mut sums = [0.0; 4];
        for (i, &[c, x]) in terms.iter().enumerate() {
            let (c, x) = (numbers.at::<FACTOR>(c), numbers.at::<OF>(x));
            sums[i % 4] = add_product::<FUSED, f64>(sums[i % 4], c, x);
        }
        let rest = (sums[0] + sums[1]) + (sums[2] + sums[3]);
        return constant.map_or(rest, |constant| constant + rest);
    }
    let mut sum = constant;
    for &[c, x] in terms {
        let (c, x) = (numbers.at::<FACTOR>(c), numbers.at::<OF>(x));
        sum = Some(match sum {
            None => c * x,
            Some(sum) => add_product::<FUSED, f64>(sum, c, x),
        });
    }
    sum.unwrap_or(0.0)
}

/// Operations of one order beyond 0.
struct Order<'a> {
    series: &'a Series,
    lists: &'a Lists,
    numbers: Numbers<'a>,
    calls: &'a mut [Call],
    k: usize,
    steps: &'a [Step],
}

impl Order<'_> {
    /// The coefficient of this order at a place.
    #[inline(always)]
    fn now(&self, place: Place) -> f64 {
        self.numbers.at::<NOW>(place)
    }

    /// A factor.
    #[inline(always)]
    fn factor(&self, place: Place) -> f64 {
        self.numbers.at::<FACTOR>(place)
    }

    /// The coefficient of order 0 at a place.
    #[inline(always)]
    fn start(&self, place: Place) -> f64 {
        self.numbers.at::<START>(place)
    }

    /// The reciprocal of the divisor of all orders, or the sign, at a place.
    #[inline(always)]
    fn inverse(&self, place: Place) -> f64 {
        self.numbers.at::<INVERSE>(place)
    }

    /// The coefficients of order 0 and of this order.
    #[inline(always)]
    fn pair(&self, of: Place) -> [f64; 2] {
        [self.start(of), self.now(of)]
    }

    /// An inner sum.
    #[inline(always)]
    fn inner(&self, sum: Place) -> f64 {
        self.numbers.at::<SUM>(sum)
    }

    /// Evaluates the operations.
    #[inline(always)]
    #[allow(clippy::too_many_lines)] // one recurrence after another, each a few lines
    fn run<const FUSED: bool>(mut self) {
        let r = RECIPROCALS[self.k];
        for step in self.steps {
            let (to, value) = match *step {
                Step::Scaled { to, c, u } => (to, self.factor(c) * self.now(u)),
                Step::Two {
                    to,
                    c: [c, d],
                    u: [u, v],
                } => {
                    let sum = self.factor(c) * self.now(u);
                    (to, add_product::<FUSED, f64>(sum, self.factor(d), self.now(v)))
                }
                Step::Three {
                    to,
                    c: [c, d, e],
                    u: [u, v, w],
                } => {
                    let sum = self.factor(c) * self.now(u);
                    let sum = add_product::<FUSED, f64>(sum, self.factor(d), self.now(v));
                    (to, add_product::<FUSED, f64>(sum, self.factor(e), self.now(w)))
                }
                Step::Linear { to, first, count } => {
                    let terms = terms(self.lists, first, count);
                    (to, linear::<FUSED, NOW>(None, terms, &self.numbers))
                }
                Step::Product { to, u, v, sum } => {
                    let inner = self.inner(sum);
                    (
                        to,
                        formulas::product::<FUSED, f64>(inner, self.pair(u), self.pair(v)),
                    )
                }
                Step::Square { to, u, sum } => {
                    let inner = self.inner(sum);
                    (to, formulas::square::<FUSED, f64>(inner, self.pair(u)))
                }
                Step::Quotient { to, u, v, sum } => {
                    let inner = self.inner(sum);
                    let (own, u, v, y) = (self.start(to), self.now(u), self.now(v), self.inverse(to));
                    (to, formulas::quotient::<FUSED, f64>(inner, own, u, v, y))
                }
                Step::Reciprocal { to, v, sum } => {
                    let inner = self.inner(sum);
                    let (own, v, y) = (self.start(to), self.now(v), self.inverse(to));
                    (to, formulas::reciprocal::<FUSED, f64>(inner, own, v, y))
                }
                Step::Root { to, u, sum } => {
                    let inner = self.inner(sum);
                    (to, formulas::root(inner, self.now(u), self.inverse(to)))
                }
                Step::Power {
                    to,
                    u,
                    exponent,
                    sums: [outer, inner],
                } => {
                    let outer = self.inner(outer);
                    let inner = self.inner(inner);
                    let (exponent, own, u) = (self.factor(exponent), self.start(to), self.now(u));
                    (
                        to,
                        formulas::power(exponent, [outer, inner], own, u, [self.inverse(to), r]),
                    )
                }
                Step::Rate { to, u, factor, sum } => {
                    let inner = self.inner(sum);
                    let (u, factor) = (self.now(u), self.start(factor));
                    (to, formulas::rate::<FUSED, f64>(inner, u, factor, r))
                }
                Step::ExpM1 { to, u, sum } => {
                    let inner = self.inner(sum);
                    let (u, factor) = (self.now(u), 1.0 + self.start(to));
                    (to, formulas::rate::<FUSED, f64>(inner, u, factor, r))
                }
                Step::Circle {
                    sine,
                    cosine,
                    u,
                    sums,
                } => {
                    let u = self.now(u);
                    let inner = [self.inner(sums[0]), self.inner(sums[1])];
                    let value = formulas::rate::<FUSED, f64>(inner[0], u, self.start(cosine), r);
                    let other = -formulas::rate::<FUSED, f64>(inner[1], u, self.start(sine), r);
                    self.numbers.set::<NOW>(sine, value);
                    (cosine, other)
                }
                Step::Tangent {
                    to,
                    u,
                    slope,
                    sums: [sum, of_square],
                } => {
                    let inner = self.inner(sum);
                    let now = formulas::rate::<FUSED, f64>(inner, self.now(u), self.start(slope), r);
                    let inner = self.inner(of_square);
                    let square = formulas::square::<FUSED, f64>(inner, [self.start(to), now]);
                    self.numbers.set::<NOW>(to, now);
                    self.numbers.set::<NOW>(slope.saturating_sub(1), square);
                    (slope, -square)
                }
                Step::BySlope { to, u, sum } => {
                    let inner = self.inner(sum);
                    (to, formulas::by_slope(inner, self.now(u), self.inverse(to), r))
                }
                Step::Minus { to, u } => (to, -self.now(u)),
                Step::Angle {
                    to,
                    y,
                    x,
                    sums: [left, right, rest],
                } => {
                    let sums = [self.inner(left), self.inner(right), self.inner(rest)];
                    let (y, x) = (self.pair(y), self.pair(x));
                    (to, formulas::angle(sums, y, x, [self.inverse(to), r]))
                }
                Step::Abs { to, u } => (to, self.inverse(to) * self.now(u)),
                Step::Select { to, then, otherwise } => {
                    let decides = self.inverse(to);
                    (to, formulas::select(decides, self.now(then), self.now(otherwise)))
                }
                Step::Call { to } => {
                    let Self { series, k, .. } = self;
                    let argument = series.operations.get(usize::from(to)).map_or(0, |op| op.parts[0]);
                    let pair = [
                        self.numbers.at::<START>(argument),
                        self.numbers.at::<NOW>(argument),
                    ];
                    (to, call::<FUSED>(series, self.calls, to, k, pair))
                }
            };
            self.numbers.set::<NOW>(to, value);
        }
    }
}

/// The coefficient of order `k` of a table of samples; the argument by its coefficients of order 0 and `k`. Not inlined: it is long and rare, and would
/// take registers from the others. It takes no address of the numbers that are kept in registers.
#[cold]
#[inline(never)]
fn call<const FUSED: bool>(
    series: &Series,
    calls: &mut [Call],
    to: Place,
    k: usize,
    [value, now]: [f64; 2],
) -> f64 {
    let Some(op) = series.operations.get(usize::from(to)) else {
        return f64::NAN;
    };
    let moves = series.moves(op.parts[0]);
    let table = series.calls.get(op.index as usize);
    let call = op.switch.and_then(|call| calls.get_mut(call as usize));
    match (table, call) {
        (Some(_), Some(call)) if call.is_still() => 0.0,
        (Some(table), Some(call)) => {
            call.coefficient::<FUSED, 1>(k, [value], [now], [moves], |[x]| table.value::<Jet>(Some(x)))
        }
        _ => f64::NAN,
    }
}
