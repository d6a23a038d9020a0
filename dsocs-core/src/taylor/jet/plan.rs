//! How the orders of a tape are computed: as the generated code does it.
//!
//! The inner sums of all entries that have one stand in blocks of [`LANES`] and are formed together. What is left for an entry is a few
//! operations. A plan serves as long as the function does the same.

use super::tape::{Entry, Op, partner};
use crate::dispatch::Work;
use crate::taylor::kernel::{LANES, Products, RECIPROCALS, ROWS, Row, add_product, inner_sums};

/// An operand of an inner sum: an entry, and whether its coefficients `c_j` enter as `j c_j`.
#[derive(Clone, Copy, Debug, Default)]
struct Operand {
    entry: u32,
    rate: bool,
}

/// What is known of an entry.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    /// Its coefficient of order 0.
    start: f64,
    /// What is divided by in every order, inverted.
    inverse: f64,
    /// Its coefficient of the present order.
    now: f64,
}

/// An entry that the result is made of.
#[derive(Clone, Copy, Debug)]
struct Planned {
    op: Op,
    place: u32,
    /// The first of its inner sums.
    sum: u32,
}

/// What is computed in each order, and what is kept of the orders before.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    /// The operations that it is for, and of which of them the result and the switches are made.
    ops: Vec<Op>,
    roots: Vec<u32>,
    steps: Vec<Planned>,
    /// All entries, and one more that is always zero.
    known: Vec<Known>,
    /// The operands of each inner sum.
    operands: Vec<[Operand; 2]>,
    blocks: Vec<Products>,
    sums: Vec<Row<f64>>,
}

impl Plan {
    /// Whether it is the plan for these entries.
    pub(super) fn is_of(&self, entries: &[Entry], roots: impl Iterator<Item = u32>) -> bool {
        let same = |(entry, op): (&Entry, &Op)| entry.op == *op;
        entries.len() == self.ops.len()
            && entries.iter().zip(&self.ops).all(same)
            && roots.eq(self.roots.iter().copied())
    }

    /// Plans these entries.
    pub(super) fn make(&mut self, entries: &[Entry], roots: impl Iterator<Item = u32>) {
        self.ops.clear();
        self.ops.extend(entries.iter().map(|entry| entry.op));
        self.roots.clear();
        self.roots.extend(roots);
        self.steps.clear();
        self.operands.clear();
        for (place, entry) in entries.iter().enumerate() {
            if entry.live {
                self.plan(place, entry.op);
            }
        }
        self.known.clear();
        self.known.resize(entries.len() + 1, Known::default());
        let nothing = Operand {
            entry: u32::try_from(entries.len()).unwrap_or(u32::MAX),
            rate: false,
        };
        let lanes = self.operands.len().next_multiple_of(LANES);
        self.operands.resize(lanes, [nothing; 2]);
        self.blocks.resize_with(lanes / LANES, Products::default);
        self.sums.resize(lanes / LANES, [0.0; LANES]);
    }

    /// Takes an entry in.
    fn plan(&mut self, place: usize, op: Op) {
        let plain = |entry: u32| Operand { entry, rate: false };
        let rate = |entry: u32| Operand { entry, rate: true };
        let sum = u32::try_from(self.operands.len()).unwrap_or(u32::MAX);
        let own = u32::try_from(place).unwrap_or(u32::MAX);
        let sums: &[[Operand; 2]] = match op {
            Op::Input(_) | Op::Unseen | Op::Affine { .. } | Op::Add(..) | Op::Sub(..) => &[],
            Op::Mul(u, v) => &[[plain(u), plain(v)]],
            Op::Square(u) => &[[plain(u), plain(u)]],
            Op::Div(_, v) | Op::Recip(v) => &[[plain(own), plain(v)]],
            Op::Sqrt(_) => &[[plain(own), plain(own)]],
            Op::Power(u, _) => &[[rate(u), plain(own)], [rate(own), plain(u)]],
            Op::Exp(u, _) => &[[rate(u), plain(own)]],
            Op::Ln(u, _) => &[[rate(own), plain(u)]],
            Op::Partner { u, distance, .. } => {
                let partner = partner(place, distance).and_then(|place| u32::try_from(place).ok());
                &[[rate(u), plain(partner.unwrap_or(own))]]
            }
            Op::Inverse { slope, .. } => &[[rate(own), plain(slope)]],
            Op::Atan2 { y, x, radius } => &[
                [rate(y), plain(x)],
                [rate(x), plain(y)],
                [rate(own), plain(radius)],
            ],
        };
        self.operands.extend_from_slice(sums);
        self.steps.push(Planned { op, place: own, sum });
    }

    /// Begins at order 0.
    pub(super) fn begin(&mut self, entries: &[Entry]) {
        for (known, entry) in self.known.iter_mut().zip(entries) {
            known.start = entry.value;
        }
        for step in &self.steps {
            let start = |u: u32| entries.get(u as usize).map_or(f64::NAN, |entry| entry.value);
            let divisor = match step.op {
                Op::Div(_, u)
                | Op::Recip(u)
                | Op::Power(u, _)
                | Op::Inverse { slope: u, .. }
                | Op::Atan2 { radius: u, .. } => start(u),
                Op::Sqrt(_) => 2.0 * start(step.place),
                Op::Ln(u, shift) => start(u) + shift,
                _ => continue,
            };
            if let Some(known) = self.known.get_mut(step.place as usize) {
                known.inverse = 1.0 / divisor;
            }
        }
    }

    /// The coefficient of an entry of the order that was computed last.
    pub(super) fn coefficient(&self, entry: u32) -> f64 {
        self.known.get(entry as usize).map_or(f64::NAN, |known| known.now)
    }
}

/// The next order of all entries.
pub(super) struct Next<'p, 'i> {
    pub(super) plan: &'p mut Plan,
    pub(super) k: usize,
    /// The coefficients of the arguments.
    pub(super) inputs: &'i [f64],
}

impl Work for Next<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { plan, k, inputs } = self;
        let k = k.clamp(1, ROWS - 1);
        let Plan {
            steps,
            known,
            operands,
            blocks,
            sums,
            ..
        } = plan;
        let blocks = &mut blocks[..sums.len()];
        inner_sums::<FUSED>(blocks, k, sums);
        let sums = sums.as_flattened();
        let (r, degree) = (RECIPROCALS[k], k as f64);
        for &Planned { op, place, sum } in steps.iter() {
            let of = |u: u32| known.get(u as usize).copied().unwrap_or_default();
            let inner = |which: u32| sums.get((sum + which) as usize).copied().unwrap_or(f64::NAN);
            let own = of(place);
            let value = match op {
                Op::Input(i) => inputs.get(i).copied().unwrap_or(f64::NAN),
                Op::Unseen => f64::NAN,
                Op::Affine { u, scale } => scale * of(u).now,
                Op::Add(u, v) => of(u).now + of(v).now,
                Op::Sub(u, v) => of(u).now - of(v).now,
                Op::Mul(u, v) => {
                    let (u, v) = (of(u), of(v));
                    let sum = add_product::<FUSED, f64>(inner(0), u.start, v.now);
                    add_product::<FUSED, f64>(sum, u.now, v.start)
                }
                Op::Square(u) => {
                    let u = of(u);
                    add_product::<FUSED, f64>(inner(0), 2.0 * u.start, u.now)
                }
                Op::Div(u, v) => {
                    (of(u).now - add_product::<FUSED, f64>(inner(0), own.start, of(v).now)) * own.inverse
                }
                Op::Recip(v) => -add_product::<FUSED, f64>(inner(0), own.start, of(v).now) * own.inverse,
                Op::Sqrt(u) => (of(u).now - inner(0)) * own.inverse,
                Op::Power(u, exponent) => {
                    let outer = add_product::<FUSED, f64>(inner(0) * r, own.start, of(u).now);
                    (exponent * outer - inner(1) * r) * own.inverse
                }
                Op::Exp(u, shift) => add_product::<FUSED, f64>(inner(0) * r, of(u).now, own.start + shift),
                Op::Ln(u, _) => (of(u).now - inner(0) * r) * own.inverse,
                Op::Partner { u, distance, scale } => {
                    let partner = partner(place as usize, distance).and_then(|place| known.get(place));
                    let partner = partner.map_or(f64::NAN, |partner| partner.start);
                    scale * add_product::<FUSED, f64>(inner(0) * r, of(u).now, partner)
                }
                Op::Inverse { u, scale, .. } => (scale * of(u).now - inner(0) * r) * own.inverse,
                Op::Atan2 { y, x, .. } => {
                    let (y, x) = (of(y), of(x));
                    let ends = y.now * x.start - x.now * y.start;
                    ((inner(0) - inner(1) - inner(2)) * r + ends) * own.inverse
                }
            };
            if let Some(known) = known.get_mut(place as usize) {
                known.now = value;
            }
        }
        // rows as a whole, since what is stored number by number cannot be loaded at once
        let factors = [1.0, degree];
        let of = |Operand { entry, rate }: Operand| {
            let now = known.get(entry as usize).map_or(0.0, |known| known.now);
            now * factors[usize::from(rate)]
        };
        let (lanes, _) = operands.as_chunks::<LANES>();
        for (block, lanes) in blocks.iter_mut().zip(lanes) {
            let [a, b, c, d] = lanes.map(|[left, _]| of(left));
            block.left[k] = [a, b, c, d];
            let [a, b, c, d] = lanes.map(|[_, right]| of(right));
            block.right[k] = [a, b, c, d];
        }
    }
}
