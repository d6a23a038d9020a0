//! Expansions of several motions in lanes, compiled for each kind of register.

use wide::f64x8;

use super::state::State;
use crate::number::compensated::Compensated;
use crate::number::instructions::{Chosen, InLanes, Instructions, OTHERS};
use crate::number::lanes::{LANES, Lanes, Mask};
use crate::number::scalar::Scalar as _;
use crate::series::orders::{MAX_ORDER, ROWS};
use crate::series::rows::Series;
use crate::series::switch::{Switch, Switches as _};
use crate::solve::rotation;
use crate::system::System;

/// Vectors, `[component][lane]`.
type Vectors<const N: usize> = [[f64; LANES]; N];

/// The states of the motions, by lanes.
pub(super) struct Ends {
    /// Times.
    pub t: [f64; LANES],
    /// Positions, high and low parts.
    q: [Box<[[f64; LANES]]>; 2],
    /// Velocities, high and low parts.
    v: [Box<[[f64; LANES]]>; 2],
    /// Accelerations at the ends of the last series.
    a: Box<[[f64; LANES]]>,
}

impl Ends {
    /// All states at zero.
    pub fn new(dimension: usize) -> Self {
        let zero = || vec![[0.0; LANES]; dimension].into_boxed_slice();
        Self {
            t: [0.0; LANES],
            q: [zero(), zero()],
            v: [zero(), zero()],
            a: zero(),
        }
    }

    /// Sets the position and the velocity of one lane.
    #[inline]
    pub fn set<const N: usize>(&mut self, lane: usize, t: f64, state: &mut State) {
        let (lane, rooms) = (lane % LANES, self.q.iter_mut().chain(&mut self.v));
        self.t[lane] = t;
        for (to, from) in rooms.zip(state.rows::<N>().into_iter().flatten()) {
            if let Some(to) = to.first_chunk_mut::<N>() {
                for (to, from) in to.iter_mut().zip(from) {
                    to[lane] = *from;
                }
            }
        }
    }

    /// Reads position, velocity and acceleration of one lane.
    #[inline]
    pub fn get<const N: usize>(&self, lane: usize, state: &mut State) {
        let [[q, q_low], [v, v_low]] = [&self.q, &self.v].map(|[hi, lo]| [hi, lo]);
        let (lane, all) = (lane % LANES, [q, q_low, v, v_low, &self.a]);
        for (from, to) in all.into_iter().zip(state.rows::<N>().into_iter().flatten()) {
            if let Some(from) = from.first_chunk::<N>() {
                for (from, to) in from.iter().zip(to) {
                    *to = from[lane];
                }
            }
        }
    }
}

/// The series of eight motions, in any kind of register. Each has its own order, beyond which its
/// coefficients are zero.
pub(super) trait LaneSeries {
    /// Sets the parameters of the motion in a lane.
    fn set_parameters(&mut self, lane: usize, values: &[f64]);

    /// Evaluates each series a time `h` after its point of expansion.
    fn arrive(&mut self, h: &[f64; LANES], ends: &mut Ends);

    /// Expands the motions there, to the order of each. Coefficients from the order `first` on will be read.
    fn expand(&mut self, ends: &Ends, orders: &[usize; LANES], first: usize);

    /// Replaces the old series by the new ones, except in the lanes of `back`, as bits.
    fn go_on(&mut self, back: u32);

    /// Reads the coefficients of the new series in a lane that the step control needs: those of the velocity
    /// of the orders 0, 1 and `first` to the last.
    fn tell(&self, lane: usize, first: usize, series: &mut Series);

    /// Sets the series of a lane.
    fn take(&mut self, lane: usize, series: &Series);

    /// The series before the last [`LaneSeries::go_on`].
    fn last(&self, lane: usize, series: &mut Series);

    /// Marks a lane as idle.
    fn clear(&mut self, lane: usize);

    /// The switches of the declaration in a lane.
    fn switches(&mut self, lane: usize) -> &mut [Switch];

    /// Whether a user's function has made a comparison in a lane.
    fn has_compared(&mut self, lane: usize) -> bool;
}

/// The series with the requested instructions, or the widest available below them.
pub(super) fn engine<'s, S: System<N>, const N: usize>(
    instructions: Instructions,
    system: &'s S,
) -> Box<dyn LaneSeries + 's> {
    #[cfg(target_arch = "x86_64")]
    if const { OTHERS } {
        use crate::number::lanes::x86::{Avx2, Avx512};
        if instructions >= Instructions::Avx512
            && let Some(token) = Avx512::token()
        {
            return Box::new(Expansions::<Avx512, S, N>::new(token, system));
        }
        if instructions >= Instructions::Avx2
            && let Some(token) = Avx2::token()
        {
            return Box::new(Expansions::<Avx2, S, N>::new(token, system));
        }
    }
    let _ = instructions;
    Box::new(Expansions::<f64x8, S, N>::new((), system))
}

/// The series in registers of one kind.
struct Expansions<'s, R: Chosen, S: System<N>, const N: usize> {
    /// Proof that the machine has them.
    token: R::Token,
    /// The system, for everything but the parameters.
    system: &'s S,
    /// The parameters.
    parameters: S::Parameters<Lanes<R>>,
    /// The expressions of the parameters.
    fixed: S::Fixed<Lanes<R>>,
    /// The coefficients of lower orders that the recurrences need.
    table: S::Table<Lanes<R>>,
    /// The series at the current points.
    series: Series<Lanes<R>>,
    /// The series at the ends of the trial steps.
    next: Series<Lanes<R>>,
    /// Coefficients of their velocities, copied out of registers.
    told: Box<[Vectors<N>; ROWS]>,
    /// Coefficients of their positions, if there are rotations, which limit the steps, too.
    told_positions: Vec<Vectors<N>>,
}

impl<'s, R: Chosen, S: System<N>, const N: usize> Expansions<'s, R, S, N> {
    fn new(token: R::Token, system: &'s S) -> Self {
        let parameters = system.parameters::<Lanes<R>>();
        Self {
            token,
            system,
            fixed: system.fixed(&parameters),
            parameters,
            table: S::Table::default(),
            series: Series::new(N, 2),
            next: Series::new(N, 2),
            told: Box::new([[[0.0; LANES]; N]; ROWS]),
            told_positions: if S::ROTATIONS.is_empty() {
                Vec::new()
            } else {
                vec![[[0.0; LANES]; N]; ROWS]
            },
        }
    }
}

/// Vectors in registers.
#[inline(always)]
fn loaded<R: Chosen, const N: usize>(x: &[[f64; LANES]]) -> [Lanes<R>; N] {
    let mut lanes = [Lanes::splat(0.0); N];
    for (lanes, &x) in lanes.iter_mut().zip(x) {
        *lanes = x.into();
    }
    lanes
}

/// [`loaded`] reversed: copies vectors out of registers.
#[inline(always)]
fn stored<R: Chosen, const N: usize>(lanes: &[Lanes<R>; N], x: &mut [[f64; LANES]]) {
    for (x, &lanes) in x.iter_mut().zip(lanes) {
        *x = lanes.into();
    }
}

/// The lanes whose order is at least `least`, as bits.
#[inline(always)]
fn lanes_where(orders: &[usize; LANES], least: usize) -> u32 {
    let mut bits = 0;
    for (lane, &order) in orders.iter().enumerate() {
        bits |= u32::from(order >= least) << lane;
    }
    bits
}

/// The ends of steps, as a function that is compiled for each kind of register.
struct Arrival<'a, R: Chosen, const N: usize> {
    series: &'a Series<Lanes<R>>,
    h: &'a [f64; LANES],
    rotations: &'static [usize],
    ends: &'a mut Ends,
}

impl<R: Chosen, const N: usize> InLanes for Arrival<'_, R, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            series,
            h,
            rotations,
            ends,
        } = self;
        let [dq, dv, a] = series.increments_of::<false, N>(Lanes::from(*h));
        for ([hi, lo], dx, rotations) in [(&mut ends.q, dq, rotations), (&mut ends.v, dv, &[])] {
            let mut sum = Compensated::<N, Lanes<R>> {
                hi: loaded(hi),
                lo: loaded(lo),
            };
            sum.add(&dx);
            if !rotations.is_empty() {
                rotation::keep_norm_in(rotations, [&mut sum.hi, &mut sum.lo]);
            }
            stored(&sum.hi, hi);
            stored(&sum.lo, lo);
        }
        stored(&a, &mut ends.a);
    }
}

/// Expansions, as a function that is compiled for each kind of register.
struct Expansion<'a, 's, R: Chosen, S: System<N>, const N: usize> {
    expansions: &'a mut Expansions<'s, R, S, N>,
    ends: &'a Ends,
    orders: &'a [usize; LANES],
    first: usize,
}

impl<R: Chosen, S: System<N>, const N: usize> InLanes for Expansion<'_, '_, R, S, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            expansions,
            ends,
            orders,
            first,
        } = self;
        let Expansions {
            system,
            fixed,
            table,
            next,
            told,
            told_positions,
            ..
        } = expansions;
        let (mut least, mut most) = (MAX_ORDER, 2);
        for &order in orders {
            (least, most) = (least.min(order), most.max(order));
        }
        next.set_order(most);
        next.begin(
            ends.t.into(),
            &loaded::<R, N>(&ends.q[0]),
            &loaded::<R, N>(&ends.v[0]),
        );
        next.expect(&loaded::<R, N>(&ends.a));
        if let Some(mut rows) = next.rows() {
            system.expand::<Lanes<R>, false>(fixed, &mut rows, table);
        }
        for k in least + 1..=most {
            let [velocity, position] = [lanes_where(orders, k), lanes_where(orders, k - 1)];
            next.cut(k, Mask::from_bits(velocity), Mask::from_bits(position));
        }
        if least < most {
            let bits = lanes_where(orders, most);
            next.cut(most + 1, Mask::splat(false), Mask::from_bits(bits));
        }
        let rows = next.velocity::<N>();
        stored(&rows[1], &mut told[1]);
        for (row, told) in rows.iter().zip(told.iter_mut()).skip(first.max(2)) {
            stored(row, told);
        }
        let rows = next.position::<N>().iter().zip(told_positions);
        for (row, told) in rows.skip(first) {
            stored(row, told);
        }
    }
}

impl<R: Chosen, S: System<N>, const N: usize> LaneSeries for Expansions<'_, R, S, N> {
    fn set_parameters(&mut self, lane: usize, values: &[f64]) {
        for (parameter, value) in self.parameters.as_mut().iter_mut().zip(values) {
            parameter.set_lane(lane, *value);
        }
        self.fixed = self.system.fixed(&self.parameters);
    }

    fn arrive(&mut self, h: &[f64; LANES], ends: &mut Ends) {
        let series = &self.series;
        let arrival = Arrival::<'_, R, N> {
            series,
            h,
            rotations: S::ROTATIONS,
            ends,
        };
        R::run(self.token, arrival);
    }

    fn expand(&mut self, ends: &Ends, orders: &[usize; LANES], first: usize) {
        R::run(
            self.token,
            Expansion {
                expansions: self,
                ends,
                orders,
                first,
            },
        );
    }

    fn go_on(&mut self, back: u32) {
        for lane in (0..LANES).filter(|lane| back >> lane & 1 == 1) {
            self.next.copy_lane(lane, &self.series);
        }
        core::mem::swap(&mut self.series, &mut self.next);
    }

    fn tell(&self, lane: usize, first: usize, series: &mut Series) {
        let (lane, order) = (lane % LANES, series.order());
        series.set_signs(self.next.signs().lane(lane));
        let Some(v) = series.velocity_table_mut::<N>() else {
            return; // never: the lengths agree
        };
        let mut take = |k: usize| {
            for (v, told) in v[k].iter_mut().zip(&self.told[k]) {
                *v = told[lane];
            }
        };
        take(1);
        for k in first.max(2)..=order {
            take(k);
        }
        let both = series
            .position_table_mut::<N>()
            .iter_mut()
            .zip(&self.told_positions);
        for (q, told) in both.take(order + 1).skip(first) {
            for (q, told) in q.iter_mut().zip(told) {
                *q = told[lane];
            }
        }
    }

    fn take(&mut self, lane: usize, series: &Series) {
        self.series.set_lane(lane, series);
    }

    fn last(&self, lane: usize, series: &mut Series) {
        self.next.lane(lane, series);
    }

    fn clear(&mut self, lane: usize) {
        self.series.set_lane(lane, &Series::new(N, 2));
    }

    fn switches(&mut self, lane: usize) -> &mut [Switch] {
        self.table.group(lane, 0)
    }

    fn has_compared(&mut self, lane: usize) -> bool {
        (1..S::Table::<Lanes<R>>::GROUPS).any(|group| !self.table.group(lane, group).is_empty())
    }
}
