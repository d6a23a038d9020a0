//! Taylor series of the continuous motion: the recurrences of a declaration.
//!
//! The expression graph, walked a third time: after values and dual numbers, jets. [`passes::motion`] solves the continuous
//! system for the accelerations, [`lower`] makes of them sequences of coefficients ([`sequence`]), [`write`] the code of
//! order 0 and of any other order. The orders are a loop, so the code is as long as the declaration, whatever the order.

mod describe;
mod lower;
mod sequence;
mod write;

use std::collections::BTreeSet;

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::{Generics, Ident};

use self::lower::Lower;
use self::sequence::{Argument, Op, Sequence, Sequences};
use self::write::{Writer, kth, local, zeroth};
use super::phase;
use super::pieces::{between_threads, matrix};
use super::program::{Place, Program, Value};
use crate::graph::{Graph, Node, NodeId, Unary};
use crate::hash::HashMap;
use crate::mechanics;
use crate::model::Model;
use crate::passes::{self, Motion};

/// With up to so many products the time of an order is that of the longest chain of operations; with more it is that of
/// all of them.
const MOST_EAGER: usize = 16;

/// Of a Jacobian with fewer entries than one in so many, those are written alone.
const MOSTLY_ZERO: usize = 4;

/// The `impl Jets` of the declaration.
pub(super) fn jets(model: &Model) -> TokenStream {
    let mut graph = model.graph.clone();
    let motion = motion(model, &mut graph);
    let (plan, sequences) = Plan::new(&mut graph, &motion, &watched(model));
    let mut writer = Writer::new(&graph, sequences);
    let body = plan.body(&mut writer, &motion);

    let [products, squares] = writer.blocks().map(Literal::usize_unsuffixed);
    let calls = Literal::usize_unsuffixed(writer.calls.len());
    let (switches, names) = switches(model, &graph, &writer);
    let (constants_code, constants) = constants(&graph, &writer.constants);
    let count = Literal::usize_unsuffixed(constants.len());
    let name = &model.item.ident;
    let generics = between_threads(&model.item.generics);
    let (impl_generics, type_generics, where_clause) = generics.split_for_impl();
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    let (c, series, table) = (local("c"), local("series"), local("table"));
    let phase_slopes = phase::method(model);
    quote! {
        // straight-line code: the lints for people do not apply to it
        #[allow(unused, clippy::all, clippy::pedantic, clippy::nursery)]
        #[automatically_derived]
        impl #impl_generics ::dsocs_core::__private::Jets<#n> for #name #type_generics #where_clause {
            type Fixed<__T: ::dsocs_core::__private::Coefficient> = [__T; #count];
            type Table<__T: ::dsocs_core::__private::Coefficient> =
                ::dsocs_core::__private::Table<__T, #products, #squares, #calls #switches>;
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

/// What jumps in the Lagrangian and in constraints on positions or velocities. The equations may show nothing of it, since a derivative is that of
/// one side: `lagrangian = dot(x).powi(2) / 2 - x.signum()` is a step of the potential, and the acceleration is zero on both sides of it.
fn watched(model: &Model) -> Vec<NodeId> {
    let graph = &model.graph;
    let constraints = model.constraints.iter();
    let lower = constraints.filter(|row| row.order < 2).map(|row| row.value);
    let mut open: Vec<NodeId> = lower.chain([model.lagrangian]).collect();
    let (mut seen, mut found) = (BTreeSet::new(), Vec::new());
    while let Some(id) = open.pop() {
        if graph.deciding(id).next().is_none() || !seen.insert(id) {
            continue;
        }
        if matches!(graph.node(id), Node::Unary(Unary::Signum, _) | Node::Select(..)) {
            found.push(id);
        }
        open.extend(graph.parts(id));
    }
    found
}

/// How many switches there are, behind a comma, and what they are called; nothing if there are none.
fn switches(model: &Model, graph: &Graph, writer: &Writer<'_>) -> (TokenStream, TokenStream) {
    let text = |&node: &NodeId| describe::describe(graph, &model.coordinates, node);
    let declared = writer.sequences.switches().iter();
    let mut names: Vec<String> = declared
        .map(|(argument, nodes)| match argument {
            // no motion ends there
            Argument::Steep(_) => String::new(),
            _ => nodes.iter().map(text).collect::<Vec<_>>().join(" - "),
        })
        .collect();
    let count = Literal::usize_unsuffixed(names.len());
    let count = if names.is_empty() {
        TokenStream::new()
    } else {
        quote!(, #count)
    };
    names.extend(writer.calls.iter().map(|&call| match writer.sequences.op(call) {
        Op::Call { callee, .. } => format!("a comparison in {}", describe::function(graph, *callee)),
        _ => String::new(),
    }));
    if names.is_empty() {
        return (count, TokenStream::new());
    }
    (
        count,
        quote!(const SWITCHES: &'static [&'static str] = &[#(#names),*];),
    )
}

/// The `impl Jets` of what has no Taylor series, a declaration of third order or a wrong one: nothing calls it.
pub(crate) fn none(ident: &Ident, generics: &Generics, n: usize) -> TokenStream {
    let generics = between_threads(generics);
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

/// The motion of a declaration, in the form with the fewest products of sequences.
fn motion(model: &Model, graph: &mut Graph) -> Motion {
    let equations = mechanics::continuous(model, graph);
    let n = model.coordinates.len();
    let rows = (equations.rows.as_slice(), equations.velocities.as_slice());
    passes::motion(graph, rows, n, model.multipliers(), Lower::cost)
}

/// What is computed, and in which order.
struct Plan {
    /// The operations.
    ops: Vec<(Sequence, Op)>,
    /// Those that orders beyond 0 need.
    lasting: BTreeSet<Sequence>,
    /// Those that depend on accelerations that are solved for in numbers.
    accelerated: BTreeSet<Sequence>,
    accelerations: Vec<Sequence>,
    rows: Vec<Sequence>,
    jacobian: Vec<Sequence>,
}

impl Plan {
    /// The sequences of a motion, and those of functions that jump although the motion shows nothing of it.
    fn new(graph: &mut Graph, motion: &Motion, watched: &[NodeId]) -> (Self, Sequences) {
        let lasting = [motion.accelerations.as_slice(), &motion.rows].concat();
        let mut lower = Lower::new(graph, &lasting);
        let mut all =
            |nodes: &[NodeId]| -> Vec<Sequence> { nodes.iter().map(|&node| lower.lower(node)).collect() };
        let (accelerations, rows) = (all(&motion.accelerations), all(&motion.rows));
        let jacobian = all(&motion.jacobian.concat());
        all(watched);
        let sequences = lower.sequences;
        let plan = Self {
            ops: sequences
                .ops()
                .map(|(sequence, op)| (sequence, op.clone()))
                .collect(),
            lasting: sequences.needed(&[accelerations.as_slice(), &rows, &sequences.switched()].concat()),
            accelerated: sequences.accelerated(),
            accelerations,
            rows,
            jacobian,
        };
        (plan, sequences)
    }

    /// The statements of order 0, of sequences that depend on accelerations or of the others.
    fn start(&self, writer: &mut Writer<'_>, accelerated: bool) -> TokenStream {
        self.ops
            .iter()
            .filter(|(to, _)| self.accelerated.contains(to) == accelerated)
            .map(|(to, op)| writer.start(*to, op))
            .collect()
    }

    /// The statements of order `k`.
    fn next(&self, writer: &mut Writer<'_>, accelerated: bool) -> TokenStream {
        self.ops
            .iter()
            .filter(|(to, _)| self.lasting.contains(to) && self.accelerated.contains(to) == accelerated)
            .map(|(to, op)| writer.next(*to, op))
            .collect()
    }

    /// The statements of order `k` that the orders to come need once the accelerations are known.
    fn again(&self, writer: &mut Writer<'_>) -> TokenStream {
        let operands = writer.sequences.products.iter().flatten();
        let mut outputs: Vec<Sequence> = operands
            .chain(&writer.sequences.squares)
            .map(|operand| operand.sequence())
            .collect();
        outputs.extend(&self.accelerations);
        outputs.extend(writer.sequences.switched());
        let needed = writer.sequences.needed(&outputs);
        self.ops
            .iter()
            .filter(|(to, _)| self.accelerated.contains(to) && needed.contains(to))
            .map(|(to, op)| writer.next(*to, op))
            .collect()
    }

    /// The Jacobian at order 0. Where most of it is zero the rest is written entry by entry: the compiler looks at every one.
    fn matrix(&self, motion: &Motion, m: usize) -> TokenStream {
        if motion.entries.len() * MOSTLY_ZERO >= m * m {
            let entries: Vec<_> = self.jacobian.iter().map(|&entry| zeroth(entry)).collect();
            return matrix(&entries, m);
        }
        let jacobian = local("jacobian");
        let size = Literal::usize_unsuffixed(m);
        let entries = motion.entries.iter().map(|&[row, column]| {
            let entry = zeroth(self.jacobian[row * m + column]);
            let [row, column] = [row, column].map(Literal::usize_unsuffixed);
            quote!(#jacobian[#row][#column] = #entry;)
        });
        quote!({
            let mut #jacobian = [[__T::splat(0.0); #size]; #size];
            #(#entries)*
            #jacobian
        })
    }

    /// The body of `expand`.
    #[allow(clippy::too_many_lines)] // one quotation: the whole of what is generated
    fn body(&self, writer: &mut Writer<'_>, motion: &Motion) -> TokenStream {
        let [q, v, a, z, s, y] = ["q", "v", "a", "z", "s", "y"].map(local);
        let [k, r, degree, series, table] = ["k", "r", "degree", "series", "table"].map(local);
        let [products, squares, inverse] = ["products", "squares", "inverse"].map(local);
        let [o, p, f, below] = ["o", "p", "f", "below"].map(local);
        let length = Literal::usize_unsuffixed(self.ops.len());
        let n = Literal::usize_unsuffixed(self.accelerations.len());
        // how many inner sums there are is known once all recurrences are written
        for accelerated in [false, true] {
            self.next(writer, accelerated);
        }
        writer.eager = writer.sequences.products.len() <= MOST_EAGER;
        writer.sequences.fill(write::LANES);
        let eager = writer.eager;
        let [sums_of_products, sums_of_squares] =
            [writer.sequences.products.len(), writer.sequences.squares.len()].map(Literal::usize_unsuffixed);
        let (start, next) = (self.start(writer, false), self.next(writer, false));
        let (remember, declare) = if eager {
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
        let (first, later): (Vec<_>, Vec<_>) = self
            .accelerations
            .iter()
            .map(|&output| (zeroth(output), kth(output)))
            .unzip();
        let (solve_start, solve_next) = if motion.unknown.is_empty() {
            (TokenStream::new(), TokenStream::new())
        } else {
            let (start, next) = (self.start(writer, true), self.next(writer, true));
            let again = self.again(writer);
            let unknown: Vec<_> = motion.unknown.iter().map(|&leaf| write::leaf(leaf)).collect();
            let multipliers = Literal::usize_unsuffixed(motion.multipliers);
            let l = local("l");
            let m = unknown.len();
            let places: Vec<_> = (0..m).map(Literal::usize_unsuffixed).collect();
            let jacobian = self.matrix(motion, m);
            let (zeroth_rows, kth_rows) = (
                self.rows.iter().map(|&row| zeroth(row)),
                self.rows.iter().map(|&row| kth(row)),
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
                    #again
                },
            )
        };
        let (store, watch) = (writer.store(), writer.watch());
        quote! {
            let (mut #q, mut #v) = #series.start();
            let mut #z = [__T::splat(0.0); #length];
            let mut #y = [__T::splat(0.0); #length];
            #start
            #solve_start
            #series.push(0, &mut #q, &mut #v, [#(#first),*]);
            #declare
            for #k in 1..#series.order() {
                let #products = #table.product_sums::<__FUSED, #eager, #sums_of_products>(#k);
                let #squares = #table.square_sums::<__FUSED, #eager, #sums_of_squares>(#k);
                let #r = __T::splat(::dsocs_core::__private::RECIPROCALS[#k]);
                let #degree = __T::splat(#k as f64);
                let #below = __T::splat(#k as f64 - 1.0);
                let mut #s = [__T::splat(0.0); #length];
                #next
                #solve_next
                #watch
                #store
                #remember
                #series.push(#k, &mut #q, &mut #v, [#(#later),*]);
            }
        }
    }
}

/// Code for expressions of the parameters.
fn constants(graph: &Graph, nodes: &[NodeId]) -> (TokenStream, Vec<TokenStream>) {
    let mut program = Program::new(graph, |_| 0);
    program.plan(nodes);
    let values: Vec<Value> = nodes.iter().map(|&node| program.lower(node)).collect();
    program.code(&values, &HashMap::default(), "n", &|_| Place::nowhere())
}

#[cfg(test)]
mod tests;
