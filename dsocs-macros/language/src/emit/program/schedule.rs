//! Which operations some results need, and in which order.

use std::collections::BTreeSet;

use crate::hash::HashMap;

use super::{Given, Op, Program, Value};

/// The operations that some results need: straight-line code and tapes are both written from this, so that they compute the
/// same bits.
pub(super) struct Schedule {
    /// What is computed, read or loaded, in order; no numbers.
    pub(super) values: Vec<Value>,
    /// Reciprocals that are not computed: the product that reads one is a division.
    pub(super) folded: BTreeSet<Value>,
}

/// What a product is.
pub(super) enum Product {
    /// A product.
    Of(Value, Value),
    /// A division, by what stands in a reciprocal.
    Quotient(Value, Value),
}

impl Schedule {
    /// A product, or the division that it becomes.
    pub(super) fn product(&self, program: &Program<'_>, a: Value, b: Value) -> Product {
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
    /// What has to be computed for `outputs` where some values are given.
    pub(super) fn schedule(&self, outputs: &[Value], given: &Given) -> Schedule {
        let mut needed = BTreeSet::new();
        let mut uses: HashMap<Value, usize> = HashMap::default();
        let mut open: Vec<Value> = outputs.to_vec();
        for &output in outputs {
            *uses.entry(output).or_default() += 2; // an output is never folded into another operation
        }
        while let Some(value) = open.pop() {
            if !needed.insert(value) || given.contains_key(&value) {
                continue;
            }
            for part in self.op(value).parts() {
                *uses.entry(part).or_default() += 1;
                open.push(part);
            }
        }
        let quotient = |value: Value| {
            matches!(self.op(value), Op::Recip(_))
                && uses.get(&value) == Some(&1)
                && !given.contains_key(&value)
        };
        let mut folded = BTreeSet::new();
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
