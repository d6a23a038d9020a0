//! What the attribute generates for a system, and the same with the system's type erased.
//!
//! Only the expansion is compiled for each system, for each kind of machine. The integrator, the grid of output times, events and
//! errors know the dimension alone and reach the expansion by one virtual call, which costs some nanoseconds of a microsecond.

use std::borrow::Cow;

use super::coefficient::Coefficient;
use super::series::{Rows, Series};
use super::switch::{Switch, Switches};
use crate::compiled::Compiled;
use crate::declaration::Declaration;
use crate::dispatch::{self, Work};
use crate::held::Held;
use crate::kernel::Kernel;
use crate::scalar::Scalar;
use crate::system::System;

/// The recurrences for the Taylor series of the continuous motion, as `#[dsocs]` generates them.
pub trait Jets<const N: usize>: Compiled<N> {
    /// Expressions of the parameters, an array of a literal size.
    type Fixed<T: Coefficient>: Copy;
    /// What the recurrences keep of the orders before.
    type Table<T: Coefficient>: Default + Switches;

    /// What the switches are, as the declaration says it; then the user's functions, in the order of their calls. Those where a smooth
    /// function is steep have no names.
    const SWITCHES: &'static [&'static str] = &[];

    /// What the parameters alone decide.
    fn fixed<T: Coefficient>(&self, parameters: &Self::Parameters<T>) -> Self::Fixed<T>;

    /// The Taylor coefficients of the motion from the point where the series begins.
    fn expand<T: Coefficient, const FUSED: bool>(
        &self,
        constants: &Self::Fixed<T>,
        series: &mut Rows<'_, N, T>,
        table: &mut Self::Table<T>,
    );

    /// Whether [`Jets::phase_slopes`] is generated; where it is not, the tape knows the same.
    const PHASE_SLOPES: bool = false;

    /// What holonomic constraints ask of a position, or all those of lower order of a velocity, and the derivatives by its components, row by
    /// row.
    fn phase_slopes<T: Scalar>(
        &self,
        _of_velocity: bool,
        _parameters: &Self::Parameters<T>,
        _point: (T, &[T; N], &[T; N]),
        _out: &mut [T],
    ) {
    }
}

/// A system of dimension `N` of any type, as the integrator asks it.
pub(super) trait Equations<const N: usize> {
    /// The Taylor coefficients of the motion from the point where the series begins.
    fn expand(&mut self, series: &mut Series);

    /// How many groups of switches there are.
    fn groups(&self) -> usize;

    /// A group of switches.
    fn group(&mut self, group: usize) -> &mut [Switch];

    /// Whether a sign may decide between pieces.
    fn has_pieces(&self) -> bool;

    /// Lets functions that are given by pieces begin the piece at whose end they are. Returns whether there are any.
    fn enter(&mut self) -> bool;

    /// What a switch is.
    fn switch(&self, group: usize, place: usize) -> Cow<'static, str>;

    /// The declaration.
    fn declaration(&self) -> Declaration<'_>;

    /// What constraints of lower order ask of a position or of a velocity, with the derivatives by its components, row by row.
    fn phase_slopes(&self, of_velocity: bool, point: (f64, &[f64; N], &[f64; N]), out: &mut [f64]);

    /// The system.
    fn kernel(&self) -> &dyn Kernel;

    /// The values of its parameters.
    fn values(&self) -> &[f64];
}

/// The recurrences of a system, and what they keep.
pub(super) struct Recurrences<'s, S: System<N>, const N: usize> {
    /// The system.
    pub(super) system: Held<'s, S>,
    /// The values of its parameters.
    values: S::Parameters<f64>,
    /// What they decide.
    fixed: S::Fixed<f64>,
    /// What is kept of the orders before.
    table: S::Table<f64>,
    /// Whether the instructions of all machines are used, so that the results are the same on all.
    rounded: bool,
}

impl<'s, S: System<N>, const N: usize> Recurrences<'s, S, N> {
    /// The recurrences of a system with the values that its parameters have now.
    pub(super) fn new(system: &'s S) -> Self {
        Self::held(Held::new(system))
    }

    /// The same of a system that may be a copy.
    pub(super) fn held(system: Held<'s, S>) -> Self {
        Self {
            fixed: system.fixed(&system.parameters()),
            values: system.parameters(),
            system,
            table: Default::default(),
            rounded: false,
        }
    }
}

impl<S: System<N>, const N: usize> Recurrences<'_, S, N> {
    /// Uses the instructions of all machines.
    pub(super) fn rounded(mut self) -> Self {
        self.rounded = true;
        self
    }

    /// Whether a sign decides between pieces: in the declaration, or in a function of the user's at the last point of expansion.
    pub(super) fn has_pieces_here(&mut self) -> bool {
        let groups = S::Table::<f64>::GROUPS;
        let declared = S::SWITCHES.len().saturating_sub(groups.saturating_sub(1));
        S::SWITCHES[..declared].iter().any(|name| !name.is_empty())
            || (1..groups).any(|group| !self.table.group(0, group).is_empty())
    }

    /// The switches of the declaration, which are the places of steep functions if there are no pieces.
    pub(super) fn steep(&mut self) -> &mut [Switch] {
        self.table.group(0, 0)
    }
}

impl<S: System<N>, const N: usize> Equations<N> for Recurrences<'_, S, N> {
    fn expand(&mut self, series: &mut Series) {
        let rounded = self.rounded;
        let Some(series) = &mut series.rows() else {
            return; // they have as many coordinates as the system
        };
        let expansion = Expansion {
            recurrences: self,
            series,
        };
        dispatch::run_as(rounded, expansion);
    }

    fn groups(&self) -> usize {
        S::Table::<f64>::GROUPS
    }

    fn group(&mut self, group: usize) -> &mut [Switch] {
        self.table.group(0, group)
    }

    fn has_pieces(&self) -> bool {
        S::SWITCHES.iter().any(|name| !name.is_empty())
    }

    fn enter(&mut self) -> bool {
        self.table.enter(0)
    }

    fn switch(&self, group: usize, place: usize) -> Cow<'static, str> {
        // functions stand at the end, one for each group but the first
        let functions = S::Table::<f64>::GROUPS.saturating_sub(1);
        let place = match group {
            0 => place,
            _ => S::SWITCHES.len().saturating_sub(functions) + group - 1,
        };
        Cow::Borrowed(S::SWITCHES.get(place).copied().unwrap_or("an expression"))
    }

    fn declaration(&self) -> Declaration<'_> {
        Declaration::of(&*self.system)
    }

    fn phase_slopes(&self, of_velocity: bool, (t, q, v): (f64, &[f64; N], &[f64; N]), out: &mut [f64]) {
        if const { S::PHASE_SLOPES } {
            let parameters = self.system.parameters();
            Jets::phase_slopes(&*self.system, of_velocity, &parameters, (t, q, v), out);
        } else {
            self.declaration().phase_slopes(of_velocity, t, q, v, out);
        }
    }

    fn kernel(&self) -> &dyn Kernel {
        self.system.kernel()
    }

    fn values(&self) -> &[f64] {
        self.values.as_ref()
    }
}

/// One expansion.
struct Expansion<'a, 's, 'c, S: System<N>, const N: usize> {
    recurrences: &'a mut Recurrences<'s, S, N>,
    series: &'a mut Rows<'c, N>,
}

impl<S: System<N>, const N: usize> Work for Expansion<'_, '_, '_, S, N> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Recurrences {
            system, fixed, table, ..
        } = self.recurrences;
        system.expand::<f64, FUSED>(fixed, self.series, table);
    }
}
