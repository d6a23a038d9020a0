//! The smooth steps of an interpreted system with few coordinates and unknowns: those of
//! [`smooth`](super::smooth), compiled here for each number of them.

#![allow(clippy::inline_always)] // parts of every step

use core::cell::Cell;
use core::ops::Range;

use super::declared::{Smooth, evaluated};
use super::interpreted::{TapeKernel, take};
use super::slices::SliceSystem;
use super::smooth;
use crate::kernel::halt::Halt;
use crate::kernel::run_state::RunState;
use crate::number::point::Leg;
use crate::solve::Numbers;
use crate::solve::newton::Evaluation;
use crate::solve::unknown::Linearization;

/// Fewer numbers than this are copied one by one: a wide load of numbers that were just written one by one
/// would stall the processor.
const FEWER: usize = 4;

/// Copies values into the numbers of a system.
#[inline(always)]
fn hand_over<const K: usize>(numbers: &mut [f64], places: Range<usize>, values: &[f64; K]) {
    if K > FEWER {
        take(numbers, &places, values);
        return;
    }
    for (place, value) in places.zip(values) {
        if let Some(number) = numbers.get_mut(place) {
            *number = *value;
        }
    }
}

/// An interpreted system with `M` unknowns, and the numbers that its programs compute in.
struct FewUnknowns<'k, const M: usize> {
    kernel: &'k TapeKernel,
    numbers: Cell<&'k mut [f64]>,
    are_linear: bool,
}

impl<const M: usize> FewUnknowns<'_, M> {
    /// Calls `work` with the kernel and the numbers.
    #[inline(always)]
    fn compute<R>(&self, work: impl FnOnce(&TapeKernel, &mut [f64]) -> R) -> R {
        let numbers = self.numbers.take();
        let result = work(self.kernel, numbers);
        self.numbers.set(numbers);
        result
    }
}

impl<const N: usize, const M: usize> Smooth<N> for FewUnknowns<'_, M> {
    type Unknown = [f64; M];
    type Constants = [f64];
    /// Empty: the known values of a step are among the kernel's numbers.
    type Known = ();

    #[inline(always)]
    fn has_affine_rows(&self) -> bool {
        self.kernel.shape().linear
    }

    #[inline(always)]
    fn may_jump(&self) -> bool {
        self.kernel.shape().jumps
    }

    #[inline(always)]
    fn is_divided(&self) -> bool {
        self.kernel.shape().divided
    }

    #[inline(always)]
    fn is_scaled(&self) -> bool {
        self.kernel.shape().scaled
    }

    #[inline(always)]
    fn is_switching(&self) -> bool {
        self.kernel.shape().switches
    }

    #[inline(always)]
    fn asks_for_time(&self) -> bool {
        self.kernel.shape().depends_on_time
    }

    #[inline(always)]
    fn is_of_third_order(&self) -> bool {
        self.kernel.shape().is_of_third_order()
    }

    #[inline(always)]
    fn rotations(&self) -> &[usize] {
        &self.kernel.shape().rotations
    }

    #[inline(always)]
    fn is_forced(&self) -> bool {
        self.kernel.shape().external_forces
    }

    #[inline(always)]
    fn constants_of<'c>(&self, run: &'c mut Numbers) -> Option<&'c mut [f64]> {
        self.compute(|kernel, numbers| {
            kernel.take_constants(numbers, run);
            // a guess has no multipliers
            let multipliers = numbers.get_mut(kernel.programs().places.multipliers.clone());
            multipliers.unwrap_or_default().fill(0.0);
        });
        Some(run)
    }

    #[inline(always)]
    fn set_past(&self, constants: &mut [f64], past: &[f64; N]) {
        self.compute(|kernel, numbers| kernel.take_past(numbers, constants, past));
    }

    #[inline(always)]
    fn known_of(&self, _: &[f64], leg: &Leg<f64, N>) {
        self.compute(|kernel, numbers| {
            let programs = kernel.programs();
            let places = &programs.places;
            hand_over(numbers, places.clock..places.clock + 1, &[leg.t]);
            hand_over(numbers, places.n.clone(), &leg.q);
            hand_over(numbers, places.d.clone(), &leg.d);
            programs.known.run(&programs.layout, kernel.calls(), numbers);
        });
    }

    #[inline(always)]
    fn evaluation(&self, _: &[f64], (): &(), z: &[f64; M]) -> Evaluation<[f64; M]> {
        let mut linearization = self.compute(|kernel, numbers| {
            let programs = kernel.programs();
            hand_over(numbers, programs.places.z.clone(), z);
            programs.residual.run(&programs.layout, kernel.calls(), numbers);
            let (mut rows, mut jacobian) = ([f64::NAN; M], [[f64::NAN; M]; M]);
            if M > FEWER {
                let found = numbers.get(programs.places.rows.clone()).unwrap_or_default();
                if let Some((first, rest)) = found.split_first_chunk() {
                    rows = *first;
                    for (row, found) in jacobian.iter_mut().zip(rest.chunks_exact(M.max(1))) {
                        row.copy_from_slice(found);
                    }
                }
            } else if let Some((first, rest)) = programs.residual.places().split_first_chunk() {
                let at = |place: u32| numbers.get(place as usize).copied().unwrap_or(f64::NAN);
                rows = first.map(at);
                for (row, places) in jacobian.iter_mut().zip(rest.chunks_exact(M.max(1))) {
                    for (entry, &place) in row.iter_mut().zip(places) {
                        *entry = at(place);
                    }
                }
            }
            Linearization { rows, jacobian }
        });
        evaluated(&mut linearization, self.are_linear)
    }

    #[inline(always)]
    fn row_scales(&self, _: &[f64], (): &(), z: &[f64; M]) -> [f64; M] {
        let mut scales = [0.0; M];
        self.compute(|kernel, numbers| {
            hand_over(numbers, kernel.programs().places.z.clone(), z);
            kernel.row_scales(numbers, &mut scales);
        });
        scales
    }

    #[inline(always)]
    fn unknown_of(&self, e: &[f64; N]) -> [f64; M] {
        let mut z = [0.0; M];
        self.compute(|kernel, numbers| {
            let programs = kernel.programs();
            hand_over(numbers, programs.places.e.clone(), e);
            kernel.write(&programs.unknown, numbers, &mut z);
        });
        z
    }

    #[inline(always)]
    fn difference(&self, _: &[f64], (): &(), z: &[f64; M]) -> [f64; N] {
        let mut e = [0.0; N];
        self.compute(|kernel, numbers| {
            hand_over(numbers, kernel.programs().places.z.clone(), z);
            kernel.difference(numbers, &mut e);
        });
        e
    }
}

/// Steps of `N` coordinates and `M` unknowns.
#[inline(never)] // one copy for each pair of sizes
fn steps<const N: usize, const M: usize>(
    kernel: &TapeKernel,
    numbers: &mut [f64],
    run_state: &mut RunState,
    count: u64,
) -> Halt {
    let shape = kernel.shape();
    let system = FewUnknowns::<M> {
        kernel,
        numbers: Cell::new(numbers),
        are_linear: shape.linear && !shape.jumps,
    };
    smooth::steps::<_, N>(&system, run_state, count)
}

/// Makes up to `count` steps of a run; `None` if no instance has the system's numbers of coordinates and
/// unknowns.
pub(super) fn smooth(
    kernel: &TapeKernel,
    numbers: &mut [f64],
    run_state: &mut RunState,
    count: u64,
) -> Option<Halt> {
    let shape = kernel.shape();
    if shape.increments != shape.dimension() || kernel.sparse().is_some() {
        return None;
    }
    macro_rules! of {
        ($($n:literal: $($m:literal),*);* $(;)?) => {
            match (shape.increments, shape.unknowns) {
                $($(($n, $m) => steps::<$n, $m>(kernel, numbers, run_state, count),)*)*
                _ => return None,
            }
        };
    }
    Some(of! {
        1: 0, 1, 2;
        2: 0, 1, 2, 3;
        3: 0, 1, 2, 3, 4;
        4: 0, 1, 2, 3, 4;
        5: 5;
        6: 6;
        7: 7;
        8: 8;
    })
}
