//! The interpreter of recurrences, order by order; compiled for the machine's own instructions.

use core::cell::Cell;

use super::order::{Lists, Place, ROOM, SHORT_SUM, Step, narrow};
use super::start::Start;
use crate::kernel::series::{Argument, Series};
use crate::number::compensated;
use crate::number::dispatch::Work;
use crate::number::fours::on_doubles;
use crate::series::blocks::{Products, Squares, all_sums};
use crate::series::formulas;
use crate::series::jet::{Call, Jet};
use crate::series::orders::{LANES, RECIPROCALS, Row};
use crate::series::rows;
use crate::series::sums::add_product;
use crate::series::switch::Switch;
use crate::solve::rotation::{self, SLOTS};
use crate::taylor::control::{self, Judged, Sizes};
use crate::taylor::recurrences::Along;
use crate::taylor::solve::{AnyAccelerations, back_into};
use crate::taylor::state::State;

/// The coefficients of a sequence that are kept.
type Sequence = [f64; 5];

/// The coefficient of order 0.
pub(super) const START: usize = 0;
/// The reciprocal of the divisor of all orders, or the sign that selects a piece.
pub(super) const INVERSE: usize = 1;
/// The coefficient of order 1; zero up to order 2, where both newest terms are the same.
const FIRST: usize = 2;
/// First of the places of the coefficients of this order and of the previous one, alternating.
const NOW: usize = 3;

/// All sequences, one for every possible [`Place`]; unwritten pages take no physical memory.
type Sequences = [Sequence; ROOM];

/// All factors.
pub(super) type Factors = [f64; ROOM];

/// The inner sums of an order.
type Sums = [Row<f64>; ROOM / LANES];

/// A table of zeros that is never built on the stack.
pub(super) fn zeros<T: Clone, const M: usize>(zero: &T) -> Option<Box<[T; M]>> {
    vec![zero.clone(); M].into_boxed_slice().try_into().ok()
}

/// The operands of a row: the sequences, and 1 for those that are multiplied by the order.
#[derive(Clone, Copy, Debug)]
struct Stored {
    from: [Place; LANES],
    rate: Row<f64>,
}

/// The state of the recurrences.
pub(super) struct Tables {
    pub(super) sequences: Box<Sequences>,
    products: Vec<Products>,
    squares: Vec<Squares>,
    /// The operands that are stored in each order: left and right of each block of products, and the blocks
    /// of squares.
    of_products: Vec<[Stored; 2]>,
    of_squares: Vec<Stored>,
    /// The inner sums of an order, products before squares.
    sums: Box<Sums>,
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
        let rows = |operands: &mut dyn Iterator<Item = (u32, bool)>| {
            let operands: Vec<_> = operands.collect();
            let rows = operands.chunks(LANES).map(|lanes| {
                let lane = |lane: usize| lanes.get(lane).copied().unwrap_or((zero, false));
                Stored {
                    // sequences whose places are possible
                    from: core::array::from_fn(|i| narrow(lane(i).0).unwrap_or_default()),
                    rate: core::array::from_fn(|i| if lane(i).1 { 1.0 } else { 0.0 }),
                }
            });
            rows.collect::<Vec<_>>()
        };
        let [left, right] =
            [0, 1].map(|side: usize| rows(&mut series.products.iter().map(|operands| operands[side])));
        let of_products = left.into_iter().zip(right).map(<[Stored; 2]>::from);
        let of_products: Vec<_> = of_products.collect();
        let of_squares = rows(&mut series.squares.iter().copied());
        let m = series.rows.len();
        Some(Self {
            sequences: zeros(&[0.0; 5])?,
            products: vec![Products::default(); of_products.len()],
            squares: vec![Squares::default(); of_squares.len()],
            of_products,
            of_squares,
            sums: zeros(&[0.0; LANES])?,
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
    /// The factors by their places.
    pub(super) factors: &'a Factors,
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
            rotations: &self.tables.turning.rotations,
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
        let n = series.coordinates;
        tables.velocity.copy_from_slice(next.start().1);
        tables.turning.begin(next.start());
        let walk = Start {
            series,
            lists: self.lists,
            factors: self.factors,
            next,
        };
        for sequence in tables.sequences.iter_mut().take(series.operations.len()) {
            [sequence[FIRST], sequence[NOW], sequence[NOW + 1]] = [0.0; 3];
        }
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
                    *row = tables.sequences[from as usize][START];
                }
                let size = series.rows.len();
                tables.jacobian.fill(0.0);
                for &[row, column, from] in &series.jacobian {
                    tables.jacobian[row as usize * size + column as usize] =
                        tables.sequences[from as usize][START];
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
        let divisors = divisors.map(|&divisor| tables.sequences[divisor as usize][START].signum());
        next.set_signs(rows::number_of_signs(determinant.into_iter().chain(divisors)));
        for (switch, argument) in tables.switches.iter_mut().zip(&series.arguments) {
            match *argument {
                Argument::Steep(u) => switch.steep(tables.sequences[u as usize][START]),
                Argument::Power(u, exponent) => switch.power(tables.sequences[u as usize][START], exponent),
                Argument::Bounded(u, bound) => switch.bounded(tables.sequences[u as usize][START], bound),
                Argument::Sign(_) | Argument::Difference(..) => {}
            }
        }
        let [q, v] = next.tables_mut();
        let (_, v) = v.split_at_mut(n);
        advance::<START, 1>(
            &self.lists.coordinates,
            &mut tables.sequences,
            &mut tables.velocity,
            1,
            [&mut q[n..], &mut *v],
        );
        turn::<FUSED, 1>(tables, &self.lists.coordinates, 1, [&mut q[n..], v]);
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
            let row = [&mut *q, &mut *v];
            // of two coefficients the one of this order, alternating; as literals, so that no place is
            // computed
            if k % 2 == 0 {
                order_of::<FUSED, EAGER, 0, 1>(self.series, self.lists, self.factors, self.tables, k, row);
                turn::<FUSED, 1>(self.tables, &self.lists.coordinates, k + 1, [q, v]);
            } else {
                order_of::<FUSED, EAGER, 1, 0>(self.series, self.lists, self.factors, self.tables, k, row);
                turn::<FUSED, 0>(self.tables, &self.lists.coordinates, k + 1, [q, v]);
            }
        }
        // a position is one order ahead of its velocity
        let (velocities, q) = (&v[order * n..], &mut q[(order + 1) * n..]);
        for (q, v) in q.iter_mut().zip(velocities).take(n) {
            *q = v * RECIPROCALS[order + 1];
        }
        self.tables.turning.advance::<FUSED>(order + 1, q, None);
    }
}

/// Computes the coefficients of order `k` of rotations, which replace those from the velocity; they stand at
/// `TURN` of their sequences.
#[inline(always)]
fn turn<const FUSED: bool, const TURN: usize>(
    tables: &mut Tables,
    coordinates: &[[Place; 3]],
    k: usize,
    [q, v]: [&mut [f64]; 2],
) {
    let Tables {
        turning, sequences, ..
    } = tables;
    if turning.rotations.is_empty() {
        return;
    }
    turning.advance::<FUSED>(k, q, Some(v));
    for &first in &turning.rotations {
        for i in first..first + SLOTS {
            if let (Some(&[place, ..]), Some(x)) = (coordinates.get(i), q.get(i)) {
                sequences[place as usize][NOW + TURN] = *x;
            }
        }
    }
}

/// Stores the accelerations of an order, which stand at a place of their sequences. Positions and velocities
/// of the next order follow.
#[inline(always)]
fn advance<const FROM: usize, const NEXT: usize>(
    coordinates: &[[Place; 3]],
    sequences: &mut Sequences,
    velocity: &mut [f64],
    next: usize,
    [to_q, to_v]: [&mut [f64]; 2],
) {
    let scale = RECIPROCALS[next];
    let rows = to_q.iter_mut().zip(to_v).zip(velocity);
    for (&[q, v, a], ((to_q, to_v), now)) in coordinates.iter().zip(rows) {
        *to_q = *now * scale;
        *now = sequences[a as usize][FROM] * scale;
        *to_v = *now;
        sequences[q as usize][NOW + NEXT] = *to_q;
        sequences[v as usize][NOW + NEXT] = *now;
    }
}

/// Computes the coefficients of one order, at `TURN`, and of the sequences one order ahead, at `NEXT`.
#[inline(always)]
fn order_of<const FUSED: bool, const EAGER: bool, const TURN: usize, const NEXT: usize>(
    series: &Series,
    lists: &Lists,
    factors: &Factors,
    tables: &mut Tables,
    k: usize,
    row: [&mut [f64]; 2],
) {
    let n = series.coordinates;
    let Tables {
        sequences,
        products,
        squares,
        of_products,
        of_squares,
        sums,
        velocity,
        solved,
        rows,
        accelerations,
        switches,
        calls,
        unknown,
        ..
    } = tables;
    let (sequences, sums): (&mut Sequences, &mut Sums) = (sequences, sums);
    all_sums::<FUSED, EAGER>(products, squares, k, &mut sums[..products.len() + squares.len()]);
    let below = k as f64 - 1.0;
    let mut order = Order::<TURN> {
        series,
        lists,
        factors,
        sums: sums.as_flattened(),
        sequences,
        solved,
        calls,
        k,
        r: RECIPROCALS[k],
        below,
    };
    // one call for all lists: the function is long
    let mut list = &lists.known;
    for phase in 0.. {
        order.walk::<FUSED, EAGER>(list);
        if phase == 2 || series.unknown.is_empty() {
            break;
        }
        if phase == 0 {
            order.solved.fill(0.0);
            list = &lists.accelerated;
            continue;
        }
        for (row, &from) in rows.iter_mut().zip(&series.rows) {
            *row = order.of_series(from);
        }
        back_into::<FUSED>(&accelerations.inverse, rows, unknown);
        for (&place, x) in series.unknown.iter().zip(&*unknown) {
            order.solved[at(place, n)] = *x;
        }
        list = &lists.again;
    }
    for (switch, argument) in switches.iter_mut().zip(&series.arguments) {
        let coefficient = match *argument {
            Argument::Sign(u) | Argument::Steep(u) | Argument::Power(u, _) | Argument::Bounded(u, _) => {
                order.of_series(u)
            }
            Argument::Difference(u, v) => order.of_series(u) - order.of_series(v),
        };
        switch.push(k, coefficient);
    }
    for (block, [left, right]) in products.iter_mut().zip(of_products) {
        block.left[k] = left.row::<TURN>(sequences, below);
        block.right[k] = right.row::<TURN>(sequences, below);
    }
    for (block, stored) in squares.iter_mut().zip(of_squares) {
        block.rows[k] = stored.row::<TURN>(sequences, below);
    }
    if EAGER && k == 2 {
        for sequence in sequences.iter_mut().take(series.operations.len()) {
            sequence[FIRST] = sequence[NOW + 1];
        }
    }
    if TURN == 0 {
        advance::<NOW, NEXT>(&lists.coordinates, sequences, velocity, k + 1, row);
    } else {
        advance::<{ NOW + 1 }, NEXT>(&lists.coordinates, sequences, velocity, k + 1, row);
    }
}

impl Stored {
    /// The operands of an order.
    #[inline(always)]
    fn row<const TURN: usize>(&self, sequences: &Sequences, below: f64) -> Row<f64> {
        let mut row = [0.0; LANES];
        for i in 0..LANES {
            row[i] = sequences[self.from[i] as usize][NOW + TURN];
        }
        // exact: a small integer, and 1 for those that are not multiplied
        for i in 0..LANES {
            row[i] *= 1.0 + self.rate[i] * below;
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
pub(super) fn linear<const FUSED: bool>(
    constant: Option<f64>,
    terms: &[[Place; 2]],
    factors: &Factors,
    value: impl Fn(Place) -> f64,
) -> f64 {
    if terms.len() > SHORT_SUM {
        // four independent sums
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

/// One order beyond 0.
struct Order<'a, const TURN: usize> {
    series: &'a Series,
    lists: &'a Lists,
    factors: &'a Factors,
    /// The inner sums.
    sums: &'a [f64],
    sequences: &'a mut Sequences,
    /// Accelerations and multipliers.
    solved: &'a mut [f64],
    calls: &'a mut [Call],
    k: usize,
    r: f64,
    below: f64,
}

impl<const TURN: usize> Order<'_, TURN> {
    #[inline(always)]
    fn of(&self, place: Place) -> &Sequence {
        &self.sequences[place as usize]
    }

    /// The coefficient of this order at a place.
    #[inline(always)]
    fn now(&self, place: Place) -> f64 {
        self.of(place)[NOW + TURN]
    }

    /// The coefficient of this order at a place of the series.
    #[inline(always)]
    fn of_series(&self, place: u32) -> f64 {
        self.sequences[place as usize][NOW + TURN]
    }

    /// The coefficients of order 0 and of this order.
    #[inline(always)]
    fn pair(of: &Sequence) -> [f64; 2] {
        [of[START], of[NOW + TURN]]
    }

    /// The coefficients of order 1 and of the order before.
    #[inline(always)]
    fn newest(of: &Sequence) -> [f64; 2] {
        [of[FIRST], of[NOW + (TURN ^ 1)]]
    }

    /// The coefficients of order 1 and of the order before of `j x_j`.
    #[inline(always)]
    fn rates(&self, of: &Sequence) -> [f64; 2] {
        [of[FIRST], self.below * of[NOW + (TURN ^ 1)]]
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

    /// The inner sum of an operand with itself.
    #[inline(always)]
    fn inner_square<const FUSED: bool, const EAGER: bool>(&self, sum: Place, x: [f64; 2]) -> f64 {
        let sum = self.sums[sum as usize];
        if EAGER {
            formulas::inner_square::<FUSED, f64>(sum, x)
        } else {
            sum
        }
    }

    /// Evaluates some operations.
    #[inline(always)]
    #[allow(clippy::too_many_lines)] // one recurrence after another, each a few lines
    fn walk<const FUSED: bool, const EAGER: bool>(&mut self, steps: &[Step]) {
        let (k, r) = (self.k, self.r);
        for step in steps {
            let (to, value) = match *step {
                Step::Time { to } => (to, if k == 1 { 1.0 } else { 0.0 }),
                Step::Acceleration { to, index } => (to, self.solved[index as usize]),
                Step::Multiplier { to, index } => (to, self.solved[self.series.coordinates + index as usize]),
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
                Step::Three {
                    to,
                    c: [c, d, e],
                    u: [u, v, w],
                } => {
                    let sum = self.factors[c as usize] * self.now(u);
                    let sum = add_product::<FUSED, f64>(sum, self.factors[d as usize], self.now(v));
                    (
                        to,
                        add_product::<FUSED, f64>(sum, self.factors[e as usize], self.now(w)),
                    )
                }
                Step::Linear { to, first, count } => {
                    let terms = terms(self.lists, first, count);
                    (
                        to,
                        linear::<FUSED>(None, terms, self.factors, |place| self.now(place)),
                    )
                }
                Step::Product { to, u, v, sum } => {
                    let (u, v) = (self.of(u), self.of(v));
                    let inner = self.inner::<FUSED, EAGER>(sum, Self::newest(u), Self::newest(v));
                    (
                        to,
                        formulas::product::<FUSED, f64>(inner, Self::pair(u), Self::pair(v)),
                    )
                }
                Step::Square { to, u, sum } => {
                    let u = self.of(u);
                    let inner = self.inner_square::<FUSED, EAGER>(sum, Self::newest(u));
                    (to, formulas::square::<FUSED, f64>(inner, Self::pair(u)))
                }
                Step::Quotient { to, u, v, sum } => {
                    let (u, v, own) = (self.now(u), self.of(v), self.of(to));
                    let inner = self.inner::<FUSED, EAGER>(sum, Self::newest(own), Self::newest(v));
                    let v = v[NOW + TURN];
                    (
                        to,
                        formulas::quotient::<FUSED, f64>(inner, own[START], u, v, own[INVERSE]),
                    )
                }
                Step::Reciprocal { to, v, sum } => {
                    let (v, own) = (self.of(v), self.of(to));
                    let inner = self.inner::<FUSED, EAGER>(sum, Self::newest(own), Self::newest(v));
                    let v = v[NOW + TURN];
                    (
                        to,
                        formulas::reciprocal::<FUSED, f64>(inner, own[START], v, own[INVERSE]),
                    )
                }
                Step::Root { to, u, sum } => {
                    let own = self.of(to);
                    let inner = self.inner_square::<FUSED, EAGER>(sum, Self::newest(own));
                    (to, formulas::root(inner, self.now(u), own[INVERSE]))
                }
                Step::Power {
                    to,
                    u,
                    exponent,
                    sums: [outer, inner],
                } => {
                    let (u, own) = (self.of(u), self.of(to));
                    let outer = self.inner::<FUSED, EAGER>(outer, Self::newest(own), self.rates(u));
                    let inner = self.inner::<FUSED, EAGER>(inner, self.rates(own), Self::newest(u));
                    let exponent = self.factors[exponent as usize];
                    let u = u[NOW + TURN];
                    (
                        to,
                        formulas::power(exponent, [outer, inner], own[START], u, [own[INVERSE], r]),
                    )
                }
                Step::Rate { to, u, factor, sum } => {
                    let (u, factor) = (self.of(u), self.of(factor));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.rates(u), Self::newest(factor));
                    let u = u[NOW + TURN];
                    (to, formulas::rate::<FUSED, f64>(inner, u, factor[START], r))
                }
                Step::ExpM1 { to, u, sum } => {
                    let (u, own) = (self.of(u), self.of(to));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.rates(u), Self::newest(own));
                    let u = u[NOW + TURN];
                    (to, formulas::rate::<FUSED, f64>(inner, u, 1.0 + own[START], r))
                }
                Step::Circle {
                    sine,
                    cosine,
                    u,
                    sums,
                } => {
                    let [u, s, c] = [u, sine, cosine].map(|place| self.of(place));
                    let (rates, u) = (self.rates(u), u[NOW + TURN]);
                    let inner = [
                        self.inner::<FUSED, EAGER>(sums[0], rates, Self::newest(c)),
                        self.inner::<FUSED, EAGER>(sums[1], rates, Self::newest(s)),
                    ];
                    let value = formulas::rate::<FUSED, f64>(inner[0], u, c[START], r);
                    let other = -formulas::rate::<FUSED, f64>(inner[1], u, s[START], r);
                    self.sequences[sine as usize][NOW + TURN] = value;
                    (cosine, other)
                }
                Step::Tangent {
                    to,
                    u,
                    slope,
                    sums: [sum, of_square],
                } => {
                    let [u, own, factor] = [u, to, slope].map(|place| self.of(place));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.rates(u), Self::newest(factor));
                    let now = formulas::rate::<FUSED, f64>(inner, u[NOW + TURN], factor[START], r);
                    let inner = self.inner_square::<FUSED, EAGER>(of_square, Self::newest(own));
                    let square = formulas::square::<FUSED, f64>(inner, [own[START], now]);
                    self.sequences[to as usize][NOW + TURN] = now;
                    self.sequences[usize::from(slope - 1)][NOW + TURN] = square;
                    (slope, -square)
                }
                Step::BySlope { to, u, slope, sum } => {
                    let (slope, own) = (self.of(slope), self.of(to));
                    let inner = self.inner::<FUSED, EAGER>(sum, self.rates(own), Self::newest(slope));
                    (to, formulas::by_slope(inner, self.now(u), own[INVERSE], r))
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
                        self.inner::<FUSED, EAGER>(left, self.rates(y), Self::newest(x)),
                        self.inner::<FUSED, EAGER>(right, self.rates(x), Self::newest(y)),
                        self.inner::<FUSED, EAGER>(rest, self.rates(own), Self::newest(radius)),
                    ];
                    (
                        to,
                        formulas::angle(sums, Self::pair(y), Self::pair(x), [own[INVERSE], r]),
                    )
                }
                Step::Abs { to, u } => (to, self.of(to)[INVERSE] * self.now(u)),
                Step::Select { to, then, otherwise } => {
                    let decides = self.of(to)[INVERSE];
                    (to, formulas::select(decides, self.now(then), self.now(otherwise)))
                }
                Step::Call { to } => (to, self.call::<FUSED>(to)),
            };
            self.sequences[to as usize][NOW + TURN] = value;
        }
    }

    /// The coefficient of a table of samples. Not inlined: it is long and rare, and would take registers from
    /// the others.
    #[cold]
    #[inline(never)]
    fn call<const FUSED: bool>(&mut self, to: Place) -> f64 {
        let Some(op) = self.series.operations.get(to as usize) else {
            return f64::NAN;
        };
        let argument = Self::pair(&self.sequences[op.parts[0] as usize]);
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
