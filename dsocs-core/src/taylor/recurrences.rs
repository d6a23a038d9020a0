//! The recurrences of a system without its type.
//!
//! Only the expansion, and the step along it, are compiled for each system, and for each kind of machine. The
//! integrator, the grid of output times, events and errors are compiled once and call them by virtual calls,
//! which cost some nanoseconds of a microsecond.

use std::borrow::Cow;

use super::control::{self, Assessment, Sizes};
use super::state::State;
use crate::kernel::Kernel;
use crate::kernel::jets::Jets;
use crate::number::dispatch::{self, Work};
use crate::series::rows::Series;
use crate::series::switch::{Switch, Switches};
use crate::solve::rotation;
use crate::system::System;
use crate::tape::declaration::Declaration;

/// The series of a system without its type, with the state of its recurrences, as the integrator uses it. All
/// vectors are slices.
pub(crate) trait SeriesKernel: Send {
    /// The system.
    fn kernel(&self) -> &dyn Kernel;

    /// The values of its parameters.
    fn values(&self) -> &[f64];

    /// Sets the values of the parameters. The next series begins anew.
    fn set_values(&mut self, values: &[f64]);

    /// The Taylor coefficients of the motion from the point where the series begins.
    fn expand(&mut self, series: &mut Series);

    /// Evaluates a series a time `h` later: adds the increments to the sums of a state, and sets its
    /// acceleration.
    fn along(&self, series: &Series, h: f64, from: &State, to: &mut State);

    /// Begins a series at a time and a state, and expands it there.
    fn begin(&mut self, series: &mut Series, t: f64, state: &State) {
        series.begin(t, state.q(), state.v());
        series.expect(state.a());
        self.expand(series);
    }

    /// Assesses a step by the series at its end; `a` is the acceleration at the end of the old series.
    fn assess(&self, series: &Series, a: &[f64], weights: &[f64], p: usize) -> Assessment {
        let own = series.velocity_of(1);
        Assessment {
            sizes: Sizes::of(series, weights, p),
            end: [control::size(own, weights), control::distance(own, a, weights)],
        }
    }

    /// A whole step: evaluates its series at its end, expands the next one there, and assesses the step.
    fn arrive(&mut self, step: Along<'_>, next: &mut Series) -> Assessment {
        self.along(step.series, step.h, step.from, step.to);
        self.begin(next, step.t, step.to);
        self.assess(next, step.to.a(), step.weights, step.p)
    }

    /// The number of switches: those of the declaration, then one for each group of the user's functions.
    fn switches(&self) -> usize;

    /// The name of a switch; empty for those of steep smooth functions.
    fn name(&self, switch: usize) -> Cow<'static, str>;

    /// The number of groups of switches.
    fn groups(&self) -> usize;

    /// A group of switches: first those of the declaration, including those of steep functions, then those of
    /// each call.
    fn group(&mut self, group: usize) -> &mut [Switch];

    /// Lets piecewise functions enter the piece at whose end they are; returns whether there are any.
    fn enter(&mut self) -> bool;

    /// The declaration, with the values of the parameters.
    fn declaration(&self) -> Declaration<'_> {
        Declaration::of(self.kernel()).with(self.values())
    }

    /// The rows of lower-order constraints on a position or on a velocity, with the derivatives by its
    /// components, row by row.
    fn phase_slopes(&self, of_velocity: bool, (t, q, v): (f64, &[f64], &[f64]), out: &mut [f64]) {
        self.declaration().phase_slopes(of_velocity, t, q, v, out);
    }
}

impl dyn SeriesKernel + '_ {
    /// Whether a sign may select a piece.
    pub(super) fn has_pieces(&self) -> bool {
        (0..self.switches()).any(|switch| !self.name(switch).is_empty())
    }

    /// Whether a sign may select a piece in the declaration, or in a user's function at the last point of
    /// expansion.
    pub(super) fn has_pieces_here(&mut self) -> bool {
        let groups = self.groups();
        let declared = self.switches().saturating_sub(groups.saturating_sub(1));
        (0..declared).any(|switch| !self.name(switch).is_empty())
            || (1..groups).any(|group| !self.group(group).is_empty())
    }

    /// The name of a switch.
    pub(super) fn switch(&self, group: usize, place: usize) -> Cow<'static, str> {
        // functions stand at the end, one for each group but the first
        let functions = self.groups().saturating_sub(1);
        match group {
            0 => self.name(place),
            _ => self.name(self.switches().saturating_sub(functions) + group - 1),
        }
    }
}

/// A step along a series.
pub(crate) struct Along<'a> {
    /// The series of its beginning.
    pub series: &'a Series,
    /// Its length.
    pub h: f64,
    /// The state at its beginning.
    pub from: &'a State,
    /// The state at its end, which is written.
    pub to: &'a mut State,
    /// The time at its end.
    pub t: f64,
    /// The weights of the components, before they are compared.
    pub weights: &'a [f64],
    /// The order of the step after it.
    pub p: usize,
}

/// The recurrences that the attribute generates, with their state.
pub(super) struct Recurrences<'s, S: System<N>, const N: usize> {
    /// The system.
    system: &'s S,
    /// The values of its parameters.
    values: S::Parameters<f64>,
    /// The expressions of the parameters.
    fixed: S::Fixed<f64>,
    /// The coefficients of lower orders that the recurrences need.
    table: S::Table<f64>,
    /// Whether only instructions that all machines have are used, so that the results are the same on all.
    rounded: bool,
}

impl<'s, S: System<N>, const N: usize> Recurrences<'s, S, N> {
    /// The recurrences of a system with the current values of its parameters; the results are the same on all
    /// machines if `rounded`.
    pub(super) fn new(system: &'s S, rounded: bool) -> Self {
        let values = system.parameters();
        Self {
            fixed: system.fixed(&values),
            values,
            system,
            table: Default::default(),
            rounded,
        }
    }

    /// Expands a series, after a step if there is one. All expansions call this one function, so that the
    /// recurrences are compiled once for each kind of machine.
    #[inline(never)]
    fn expand_at(&mut self, next: &mut Series, step: Option<Along<'_>>) -> Assessment {
        let expansion = Expansion {
            recurrences: self,
            next,
            step,
        };
        dispatch::run_as(expansion.recurrences.rounded, expansion)
    }
}

impl<S: System<N>, const N: usize> SeriesKernel for Recurrences<'_, S, N> {
    fn kernel(&self) -> &dyn Kernel {
        self.system.kernel()
    }

    fn values(&self) -> &[f64] {
        self.values.as_ref()
    }

    fn set_values(&mut self, values: &[f64]) {
        for (own, value) in self.values.as_mut().iter_mut().zip(values) {
            *own = *value;
        }
        self.fixed = self.system.fixed(&self.values);
        self.table = Default::default();
    }

    fn expand(&mut self, series: &mut Series) {
        self.expand_at(series, None);
    }

    fn along(&self, series: &Series, h: f64, from: &State, to: &mut State) {
        let rotations = S::ROTATIONS;
        let moves = Moves::<N> {
            rotations,
            series,
            h,
            from,
            to,
        };
        dispatch::run_as(self.rounded, moves);
    }

    fn assess(&self, series: &Series, a: &[f64], weights: &[f64], p: usize) -> Assessment {
        match (
            series.velocity_table::<N>(),
            a.first_chunk(),
            weights.first_chunk(),
        ) {
            (Some(v), Some(a), Some(weights)) => Assessment::of(v, series.order(), a, (weights, p)),
            _ => Assessment::NONE,
        }
    }

    fn arrive(&mut self, step: Along<'_>, next: &mut Series) -> Assessment {
        self.expand_at(next, Some(step))
    }

    fn switches(&self) -> usize {
        S::SWITCHES.len()
    }

    fn name(&self, switch: usize) -> Cow<'static, str> {
        Cow::Borrowed(S::SWITCHES.get(switch).copied().unwrap_or("an expression"))
    }

    fn groups(&self) -> usize {
        S::Table::<f64>::GROUPS
    }

    fn group(&mut self, group: usize) -> &mut [Switch] {
        self.table.group(0, group)
    }

    fn enter(&mut self) -> bool {
        self.table.enter(0)
    }

    fn phase_slopes(&self, of_velocity: bool, (t, q, v): (f64, &[f64], &[f64]), out: &mut [f64]) {
        match (q.first_chunk(), v.first_chunk()) {
            (Some(q), Some(v)) if const { S::PHASE_SLOPES } => {
                Jets::phase_slopes(self.system, of_velocity, &self.values, (t, q, v), out);
            }
            _ => self.declaration().phase_slopes(of_velocity, t, q, v, out),
        }
    }
}

/// The evaluation of a series at the end of a step.
struct Moves<'a, const N: usize> {
    rotations: &'static [usize],
    series: &'a Series,
    h: f64,
    from: &'a State,
    to: &'a mut State,
}

impl<const N: usize> Moves<'_, N> {
    /// Writes the state at the end, and returns position, velocity and acceleration there.
    #[inline(always)]
    fn make<const FUSED: bool>(self) -> [[f64; N]; 3] {
        let Self {
            rotations,
            series,
            h,
            from,
            to,
        } = self;
        let [dq, dv, a] = series.increments_of::<FUSED, N>(h);
        let Some([mut q, mut v]) = from.sized::<N>() else {
            return [[f64::NAN; N]; 3]; // never: the lengths agree
        };
        q.add(&dq);
        v.add(&dv);
        if !rotations.is_empty() {
            rotation::keep_norm(rotations, [&mut q.hi, &mut q.lo]);
        }
        to.take(&q, &v, &a);
        [q.hi, v.hi, a]
    }
}

impl<const N: usize> Work for Moves<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        self.make::<FUSED>();
    }
}

/// One expansion, after a step if there is one.
struct Expansion<'a, 's, 'c, S: System<N>, const N: usize> {
    recurrences: &'a mut Recurrences<'s, S, N>,
    next: &'a mut Series,
    step: Option<Along<'c>>,
}

impl<S: System<N>, const N: usize> Work for Expansion<'_, '_, '_, S, N> {
    type Output = Assessment;

    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Assessment {
        let Recurrences {
            system, fixed, table, ..
        } = self.recurrences;
        if let Some(step) = &self.step {
            self.next.set_time(step.t);
        }
        let Some(next) = &mut self.next.rows() else {
            return Assessment::NONE; // never: the lengths agree
        };
        let mut judges = None;
        if let Some(Along {
            series,
            h,
            from,
            to,
            weights,
            p,
            ..
        }) = self.step
        {
            let rotations = S::ROTATIONS;
            let moves = Moves {
                rotations,
                series,
                h,
                from,
                to,
            };
            let [q, v, a] = moves.make::<FUSED>();
            next.begin(&q, &v, &a);
            judges = weights.first_chunk().map(|weights| (a, (weights, p)));
        }
        system.expand::<f64, FUSED>(fixed, next, table);
        match &judges {
            Some((a, by)) => Assessment::of(next.velocities(), next.order(), a, *by),
            None => Assessment::NONE,
        }
    }
}
