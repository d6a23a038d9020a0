//! The operations that some results need, in order.

use std::collections::BTreeSet;

use super::{Given, Op, Program, Value};
use crate::hash::HashSet;

/// The operations that some results need. Straight-line code and tapes are both written from this, so that
/// they compute the same bits.
pub(crate) struct Schedule {
    /// The operations to compute, read or load, in order; without numbers.
    pub(crate) values: Vec<Value>,
    /// Reciprocals that are not computed, because the product that reads one becomes a division.
    pub(crate) folded: HashSet<Value>,
}

/// A product, as it is written.
pub(crate) enum Product {
    /// A multiplication.
    Of(Value, Value),
    /// A division, in place of the product with a reciprocal.
    Quotient(Value, Value),
}

impl Schedule {
    /// A product, as a multiplication or a division.
    pub(crate) fn product(&self, program: &Program<'_>, a: Value, b: Value) -> Product {
        let (top, reciprocal) = if self.folded.contains(&b) {
            (a, b)
        } else if self.folded.contains(&a) {
            (b, a)
        } else {
            return Product::Of(a, b);
        };
        match program.op(reciprocal) {
            Op::Recip(bottom) => Product::Quotient(top, *bottom),
            _ => Product::Of(a, b), // only reciprocals are folded
        }
    }
}

impl Program<'_> {
    /// The operations that `outputs` need, if some values are given.
    pub(crate) fn schedule(&self, outputs: &[Value], given: &Given) -> Schedule {
        let mut needed = vec![false; self.ops.len()];
        let mut uses = vec![0_u32; self.ops.len()];
        let mut open: Vec<Value> = outputs.to_vec();
        for output in outputs {
            uses[output.index()] += 2; // so that an output is never folded into another operation
        }
        while let Some(value) = open.pop() {
            if std::mem::replace(&mut needed[value.index()], true) || given.contains_key(&value) {
                continue;
            }
            self.op(value).for_parts(|part| {
                uses[part.index()] += 1;
                open.push(part);
            });
        }
        let needed: Vec<Value> = self
            .values()
            .zip(needed)
            .filter_map(|(value, needed)| needed.then_some(value))
            .collect();
        let quotient = |value: Value| {
            matches!(self.op(value), Op::Recip(_)) && uses[value.index()] == 1 && !given.contains_key(&value)
        };
        let mut folded = HashSet::default();
        for &value in &needed {
            if given.contains_key(&value) {
                continue;
            }
            if let Op::Mul(a, b) = self.op(value) {
                if quotient(*b) {
                    folded.insert(*b);
                } else if quotient(*a) {
                    folded.insert(*a);
                }
            }
        }
        let values = needed
            .into_iter()
            .filter(|value| !matches!(self.op(*value), Op::Constant(_)) && !folded.contains(value))
            .collect();
        Schedule { values, folded }
    }
}

impl Program<'_> {
    /// The values that are known and that the computation of `outputs` uses directly: they are outputs, or
    /// operands of operations that are not known. Numbers are not among them. Values in `given` need not be
    /// computed.
    pub(crate) fn frontier(
        &self,
        outputs: &[Value],
        is_known: impl Fn(Value) -> bool,
        given: &BTreeSet<Value>,
    ) -> BTreeSet<Value> {
        let mut frontier = BTreeSet::new();
        let mut seen = vec![false; self.ops.len()];
        let mut open: Vec<Value> = outputs.to_vec();
        while let Some(value) = open.pop() {
            if std::mem::replace(&mut seen[value.index()], true) || matches!(self.op(value), Op::Constant(_))
            {
                continue;
            }
            if is_known(value) {
                frontier.insert(value);
            } else if !given.contains(&value) {
                self.op(value).for_parts(|part| open.push(part));
            }
        }
        frontier
    }

    /// For every operation, whether it depends on the parameters alone.
    pub(crate) fn fixed(&self) -> Vec<bool> {
        // operands come before the operations that use them
        let mut fixed: Vec<bool> = Vec::with_capacity(self.ops.len());
        for op in &self.ops {
            let mut is_fixed = !matches!(op, Op::Leaf(_));
            op.for_parts(|part| is_fixed &= fixed[part.index()]);
            fixed.push(is_fixed);
        }
        fixed
    }
}
