//! `impl Jets`: the recurrences of Taylor series as code, of order 0 and of any other order. The orders are a
//! loop, so the code is as long as the declaration, whatever the order.

mod switches;
mod whole;
mod write;

use proc_macro2::{Literal, TokenStream};
use quote::{ToTokens as _, quote};
use syn::{Generics, Ident};

use super::kernel::send_and_sync;
use super::phase_slopes;
use super::place::Place;
use super::straight_line::matrix;
use crate::graph::{Graph, NodeId};
use crate::hash::HashMap;
use crate::model::Model;
use crate::program::stages::single;
use crate::recurrences::plan::{LANES, Plan};
use crate::recurrences::sequence::{Op, Sequence};
use write::{Writer, kth, local, zeroth};

/// If fewer than one in this many entries of the Jacobian are nonzero, only these are written.
const MOSTLY_ZERO: usize = 4;

/// The `impl Jets` of the declaration.
pub(crate) fn jets(model: &Model) -> TokenStream {
    let mut graph = model.graph.clone();
    let plan = Plan::of(model, &mut graph);
    let writer = Writer::new(&graph, &plan);
    let body = writer.body();

    let [products, squares] = writer.blocks().map(Literal::usize_unsuffixed);
    let calls = Literal::usize_unsuffixed(plan.calls.len());
    let [groups, size] = writer.whole_blocks().map(Literal::usize_unsuffixed);
    let (switches, names) = switches(model, &graph, &plan);
    let (constants_code, constants) = constants(&graph, &plan.constants);
    let count = Literal::usize_unsuffixed(constants.len());
    let name = &model.item.ident;
    let generics = send_and_sync(&model.item.generics);
    let (impl_generics, type_generics, where_clause) = generics.split_for_impl();
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    let (c, series, table) = (local("c"), local("series"), local("table"));
    let phase_slopes = phase_slopes::method(model);
    quote! {
        // generated straight-line code needs no lints
        #[allow(unused, clippy::all, clippy::pedantic, clippy::nursery)]
        #[automatically_derived]
        impl #impl_generics ::dsocs_core::__private::Jets<#n> for #name #type_generics #where_clause {
            type Fixed<__T: ::dsocs_core::__private::Coefficient> = [__T; #count];
            type Table<__T: ::dsocs_core::__private::Coefficient> =
                ::dsocs_core::__private::Table<__T, #products, #squares, #calls, #switches, #groups, #size>;
            #names

            #[inline]
            fn fixed<__T: ::dsocs_core::__private::Coefficient>(
                &self,
                parameters: &<Self as ::dsocs_core::__private::Compiled<#n>>::Parameters<__T>,
            ) -> Self::Fixed<__T> {
                #constants_code
                [#(#constants),*]
            }

            #[inline(always)]
            fn expand<__T: ::dsocs_core::__private::Coefficient, const __FUSED: bool>(
                &self,
                #c: &Self::Fixed<__T>,
                #series: &mut ::dsocs_core::__private::Rows<'_, #n, __T>,
                #table: &mut Self::Table<__T>,
            ) {
                #body
            }

            #phase_slopes
        }
    }
}

/// The number of switches behind a comma, and their names; both empty if there are none.
fn switches(model: &Model, graph: &Graph, plan: &Plan) -> (TokenStream, TokenStream) {
    let names = plan.names(model, graph);
    let count = Literal::usize_unsuffixed(names.len() - plan.calls.len()).into_token_stream();
    if names.is_empty() {
        return (count, TokenStream::new());
    }
    (
        count,
        quote!(const SWITCHES: &'static [&'static str] = &[#(#names),*];),
    )
}

/// The `impl Jets` of a type without Taylor series, for a constraint of third order or a wrong declaration.
/// It is never called.
pub(crate) fn none(ident: &Ident, generics: &Generics, n: usize) -> TokenStream {
    let generics = send_and_sync(generics);
    let (generics, arguments, bounds) = generics.split_for_impl();
    let n = Literal::usize_unsuffixed(n);
    quote! {
        #[allow(unused, clippy::all, clippy::pedantic, clippy::nursery)]
        #[automatically_derived]
        impl #generics ::dsocs_core::__private::Jets<#n> for #ident #arguments #bounds {
            type Fixed<__T: ::dsocs_core::__private::Coefficient> = [__T; 0];
            type Table<__T: ::dsocs_core::__private::Coefficient> = ::dsocs_core::__private::Table<__T, 0, 0, 0>;

            fn fixed<__T: ::dsocs_core::__private::Coefficient>(
                &self,
                parameters: &<Self as ::dsocs_core::__private::Compiled<#n>>::Parameters<__T>,
            ) -> Self::Fixed<__T> {
                []
            }

            fn expand<__T: ::dsocs_core::__private::Coefficient, const __DSOCS_FUSED: bool>(
                &self,
                fixed: &Self::Fixed<__T>,
                series: &mut ::dsocs_core::__private::Rows<'_, #n, __T>,
                table: &mut Self::Table<__T>,
            ) {
            }
        }
    }
}

impl Writer<'_> {
    /// The statements of order 0 for some sequences.
    fn all_start<'p>(&self, ops: impl Iterator<Item = (Sequence, &'p Op)>) -> TokenStream {
        ops.map(|(to, op)| self.start(to, op)).collect()
    }

    /// The statements of order `k`.
    fn all_next<'p>(&self, ops: impl Iterator<Item = (Sequence, &'p Op)>) -> TokenStream {
        ops.map(|(to, op)| self.next(to, op)).collect()
    }

    /// The Jacobian at order 0. If it is mostly zero, the other entries are written one by one, because the
    /// compiler looks at every entry.
    fn matrix(&self, m: usize) -> TokenStream {
        let Plan { motion, jacobian, .. } = self.plan;
        if motion.entries.len() * MOSTLY_ZERO >= m * m {
            let entries: Vec<_> = jacobian.iter().map(|&entry| zeroth(entry)).collect();
            return matrix(&entries, m);
        }
        let matrix = local("jacobian");
        let size = Literal::usize_unsuffixed(m);
        let entries = motion.entries.iter().map(|&[row, column]| {
            let entry = zeroth(jacobian[row * m + column]);
            let [row, column] = [row, column].map(Literal::usize_unsuffixed);
            quote!(#matrix[#row][#column] = #entry;)
        });
        quote!({
            let mut #matrix = [[__T::splat(0.0); #size]; #size];
            #(#entries)*
            #matrix
        })
    }

    /// The method that adds an order to the series, and the first slots of rotations if there are any.
    fn push(&self) -> (TokenStream, TokenStream) {
        let first = self.graph.rotations().iter();
        let first: Vec<_> = first.map(|&first| Literal::usize_unsuffixed(first)).collect();
        if first.is_empty() {
            (quote!(push), TokenStream::new())
        } else {
            (quote!(push_turning::<__FUSED>), quote!(&[#(#first),*],))
        }
    }

    /// The body of `expand`.
    #[allow(clippy::too_many_lines)] // one quotation: the whole of what is generated
    fn body(&self) -> TokenStream {
        let Plan {
            sequences,
            eager,
            motion,
            rows,
            ..
        } = self.plan;
        let [q, v, a, z, s, y] = ["q", "v", "a", "z", "s", "y"].map(local);
        let [k, r, degree, series, table] = ["k", "r", "degree", "series", "table"].map(local);
        let [products, squares, inverse] = ["products", "squares", "inverse"].map(local);
        let [o, p, f, below] = ["o", "p", "f", "below"].map(local);
        let length = Literal::usize_unsuffixed(sequences.ops().count());
        let n = Literal::usize_unsuffixed(self.plan.accelerations.len());
        let whole_squares = Literal::usize_unsuffixed(self.plan.whole[1]);
        let [sums_of_products, sums_of_squares] = [
            sequences
                .products
                .len()
                .saturating_sub(self.plan.whole[0] * LANES),
            sequences.squares.len(),
        ]
        .map(Literal::usize_unsuffixed);
        let [begin_blocks, next_blocks] = self.blocks_at_once();
        let (start, next) = (
            self.all_start(self.plan.at_start(false)),
            self.all_next(self.plan.beyond(false)),
        );
        let (remember, declare) = if *eager {
            (
                quote! {
                    if <__T as ::dsocs_core::__private::Coefficient>::PACKED {
                        if #k == 1 {
                            #f = #s;
                        }
                        if #k == 2 {
                            #o = #f;
                        }
                        #p = #s;
                    }
                },
                quote! {
                    let (mut #o, mut #p, mut #f) =
                        ([__T::splat(0.0); #length], [__T::splat(0.0); #length], [__T::splat(0.0); #length]);
                },
            )
        } else {
            (TokenStream::new(), TokenStream::new())
        };
        let accelerations = self.plan.accelerations.iter();
        let (first, later): (Vec<_>, Vec<_>) =
            accelerations.map(|&output| (zeroth(output), kth(output))).unzip();
        let (solve_start, solve_next) = if motion.unknown.is_empty() {
            (TokenStream::new(), TokenStream::new())
        } else {
            let (start, next) = (
                self.all_start(self.plan.at_start(true)),
                self.all_next(self.plan.beyond(true)),
            );
            let after_solve = self.all_next(self.plan.after_solve());
            let unknown: Vec<_> = motion.unknown.iter().map(|&leaf| write::leaf(leaf)).collect();
            let multipliers = Literal::usize_unsuffixed(motion.multipliers);
            let l = local("l");
            let m = unknown.len();
            let places: Vec<_> = (0..m).map(Literal::usize_unsuffixed).collect();
            let jacobian = self.matrix(m);
            let (zeroth_rows, kth_rows) = (
                rows.iter().map(|&row| zeroth(row)),
                rows.iter().map(|&row| kth(row)),
            );
            let affine = motion.affine;
            (
                quote! {
                    let mut #a = #series.guess();
                    let mut #l = [__T::splat(0.0); #multipliers];
                    let mut #inverse = ::dsocs_core::__private::Accelerations::new(#affine);
                    loop {
                        let update = #inverse.update();
                        #(#unknown = #unknown + update[#places];)*
                        #start
                        let more = #inverse.improve::<__FUSED>(
                            &[#(#zeroth_rows),*],
                            &#jacobian,
                            &[#(#unknown),*],
                        );
                        if !more {
                            break;
                        }
                    }
                },
                quote! {
                    let mut #a = [__T::splat(0.0); #n];
                    let mut #l = [__T::splat(0.0); #multipliers];
                    #next
                    let update = ::dsocs_core::__private::back::<__FUSED, _, __T>(#inverse.inverse(), &[#(#kth_rows),*]);
                    #(#unknown = update[#places];)*
                    #after_solve
                },
            )
        };
        let (store, watch) = (self.store(), self.watch());
        let watch_narrow_features = self.watch_narrow_features();
        let set_signs = self.set_signs();
        let (push, turning) = self.push();
        quote! {
            let (mut #q, mut #v) = #series.start();
            let mut #z = [__T::splat(0.0); #length];
            let mut #y = [__T::splat(0.0); #length];
            #start
            #solve_start
            #set_signs
            #watch_narrow_features
            #begin_blocks
            #series.#push(0, #turning &mut #q, &mut #v, [#(#first),*]);
            #declare
            for #k in 1..#series.order() {
                let #products = #table.product_sums::<__FUSED, #eager, #sums_of_products>(#k);
                let #squares = #table.square_sums::<__FUSED, #eager, #sums_of_squares, #whole_squares>(#k);
                #next_blocks
                let #r = __T::splat(::dsocs_core::__private::RECIPROCALS[#k]);
                let #degree = __T::splat(#k as f64);
                let #below = __T::splat(#k as f64 - 1.0);
                let mut #s = [__T::splat(0.0); #length];
                #next
                #solve_next
                #watch
                #store
                #remember
                #series.#push(#k, #turning &mut #q, &mut #v, [#(#later),*]);
            }
        }
    }
}

/// Code for expressions of the parameters.
fn constants(graph: &Graph, nodes: &[NodeId]) -> (TokenStream, Vec<TokenStream>) {
    let (program, values) = single(graph, nodes);
    program.code(&values, &HashMap::default(), "n", &|_| Place::nowhere())
}
