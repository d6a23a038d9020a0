//! Order 0 of recurrences.

use super::order::{Lists, Place};
use super::walk::{FACTOR, INVERSE, Numbers, START, Tables, linear, terms};
use crate::kernel::series::{Code, Operation, Series};
use crate::number::scalar::Scalar;
use crate::series::coefficient::Coefficient;
use crate::series::formulas;
use crate::series::jet::Jet;
use crate::series::rows;

/// Order 0.
pub(super) struct Start<'a> {
    pub(super) series: &'a Series,
    pub(super) lists: &'a Lists,
    pub(super) next: &'a rows::Series,
}

impl Start<'_> {
    /// Evaluates the operations that depend on accelerations that are solved for, or the others.
    #[inline(always)]
    pub(super) fn operations<const FUSED: bool>(&self, tables: &mut Tables, accelerated: bool) {
        for &to in &self.lists.start[usize::from(accelerated)] {
            if let Some(op) = self.series.operations.get(usize::from(to)) {
                self.operation::<FUSED>(to, op, tables);
            }
        }
    }

    /// One operation.
    #[inline(always)]
    #[allow(clippy::too_many_lines)] // one operation after another, each a few lines
    fn operation<const FUSED: bool>(&self, to: Place, op: &Operation, tables: &mut Tables) {
        let Tables {
            numbers,
            solved,
            switches,
            calls,
            ..
        } = tables;
        let mut numbers = Numbers(numbers);
        let z = |part: usize| numbers.at::<START>(op.parts[part]);
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
            Code::Constant => numbers.at::<FACTOR>(op.index),
            Code::Linear => {
                let constant = op.constant.map(|constant| numbers.at::<FACTOR>(constant));
                let terms = terms(self.lists, op.terms[0], op.terms[1]);
                linear::<FUSED, START>(constant, terms, &numbers)
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
                Scalar::powf(u, numbers.at::<FACTOR>(op.index))
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
                numbers.set::<START>(to.saturating_add(1), cosine);
                sine
            }
            // computed with its sine
            Code::Cos => return,
            Code::Sinh => Scalar::sinh(u),
            Code::Cosh => Scalar::cosh(u),
            Code::Tan => Scalar::tan(u),
            Code::Tanh => Scalar::tanh(u),
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
                    // its sign is used in every order
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
                match (
                    self.series.calls.get(index),
                    switch.and_then(|call| calls.get_mut(call)),
                ) {
                    (Some(table), Some(call)) => call.first([u], [moves], |[x]| table.value::<Jet>(Some(x))),
                    _ => f64::NAN,
                }
            }
        };
        numbers.set::<START>(to, value);
        numbers.set::<INVERSE>(to, inverse);
    }
}
