//! Whole blocks of products and squares of positions and velocities, whose coefficients of an order are known before
//! its recurrences begin.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::write::{Writer, at, leaf, local};
use crate::recurrences::plan::LANES;
use crate::recurrences::sequence::{Lane, Op, Operand, Sequence};

impl Writer<'_> {
    /// The coefficient of order `k` of a product or a square that is in a whole block.
    pub(super) fn whole(&self, sequence: Sequence, op: &Op) -> Option<TokenStream> {
        if !matches!(op, Op::Product(..) | Op::Square(_)) {
            return None;
        }
        let [products, squares] = self.plan.whole;
        let operands = op.inner(sequence).first().copied()?;
        match self.plan.sequences.lane(operands)? {
            Lane::Product(place) if place / LANES < products => {
                let [_, size] = self.whole_blocks();
                let (block, lane) = (place / LANES, at(place % LANES));
                let (array, group, block) = (local("of_products"), at(block / size), at(block % size));
                Some(quote!(#array[#group][#block][#lane]))
            }
            Lane::Square(place) if place / LANES < squares => {
                let (array, block, lane) = (local("of_squares"), at(place / LANES), at(place % LANES));
                Some(quote!(#array[#block][#lane]))
            }
            _ => None,
        }
    }

    /// The statements for whole blocks, of order 0 and of order `k`.
    pub(super) fn blocks_at_once(&self) -> [TokenStream; 2] {
        let [products, squares] = self.plan.whole;
        let (table, k) = (local("table"), local("k"));
        let known = |operand: Option<Operand>| {
            let op = operand.map(|operand| self.plan.sequences.op(operand.sequence()));
            if let Some(Op::Leaf(which)) = op {
                leaf(*which)
            } else {
                quote!(__T::splat(0.0))
            }
        };
        let row = |operands: Vec<Operand>| {
            let lanes = (0..LANES).map(|lane| known(operands.get(lane).copied()));
            quote!([#(#lanes),*])
        };
        let [_, size] = self.whole_blocks();
        let [left, right] = [0, 1].map(|side| {
            let blocks = self.plan.sequences.products.chunks(LANES).take(products);
            let rows = blocks.map(|lanes| row(lanes.iter().map(|operands| operands[side]).collect()));
            let rows: Vec<_> = rows.collect();
            let groups = rows.chunks(size).map(|rows| quote!([#(#rows),*]));
            quote!([#(#groups),*])
        });
        let of_squares = self.plan.sequences.squares.chunks(LANES).take(squares);
        let of_squares = of_squares.map(|lanes| row(lanes.to_vec()));
        let of_squares = quote!([#(#of_squares),*]);
        if [products, squares] == [0; 2] {
            return [TokenStream::new(), TokenStream::new()];
        }
        let mut next = TokenStream::new();
        let (eager, [used_products, used_squares]) = (self.plan.eager, self.used());
        let [to_products, to_squares] = ["of_products", "of_squares"].map(local);
        if products > 0 {
            next.extend(quote! {
                let #to_products = #table.whole_products::<__FUSED, #eager, #used_products>(#k, [#left, #right]);
            });
        }
        if squares > 0 {
            next.extend(quote! {
                let #to_squares = #table.whole_squares::<__FUSED, #eager, #used_squares, _>(#k, #of_squares);
            });
        }
        [quote!(#table.begin_whole([#left, #right], #of_squares);), next]
    }

    /// The numbers of products and of squares.
    pub(super) fn used(&self) -> [Literal; 2] {
        [
            self.plan.sequences.products.len(),
            self.plan.sequences.squares.len(),
        ]
        .map(at)
    }

    /// The number of groups of whole blocks of products, and the number of blocks in a group.
    pub(super) fn whole_blocks(&self) -> [usize; 2] {
        let [products, _] = self.plan.whole;
        let size = products.clamp(1, 2);
        [products / size, size]
    }
}
