//! The code of a recurrence: order 0, and any other order.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{ToTokens, quote, quote_spanned};

use super::sequence::{Argument, Constant, Lane, Op, Operand, Sequence, Sequences};
use crate::emit::functions;
use crate::graph::{Comparison, Graph, Leaf, NodeId};

/// How many sums a block of lanes holds, as `LANES` in `dsocs-core/src/series/orders.rs`.
pub(super) const LANES: usize = 4;

/// Longer sums are formed by a function, in several sums side by side.
const SHORT_SUM: usize = 4;

/// Writes the recurrences of some sequences.
pub(super) struct Writer<'g> {
    pub(super) graph: &'g Graph,
    pub(super) sequences: Sequences,
    /// What is computed once a run, by place in `c`.
    pub(super) constants: Vec<NodeId>,
    /// The sequences that are calls of the user's functions, by place.
    pub(super) calls: Vec<Sequence>,
    /// Whether inner sums take the newest coefficients from variables.
    pub(super) eager: bool,
}

/// A name that no name of the user's can be.
pub(super) fn local(name: &str) -> Ident {
    Ident::new(name, Span::mixed_site())
}

fn at(index: usize) -> Literal {
    Literal::usize_unsuffixed(index)
}

/// The element of an array.
fn element(array: &str, sequence: Sequence) -> TokenStream {
    let (array, index) = (local(array), at(sequence.index()));
    quote!(#array[#index])
}

/// The coefficient of order 0.
pub(super) fn zeroth(sequence: Sequence) -> TokenStream {
    element("z", sequence)
}

/// The coefficient of order `k`.
pub(super) fn kth(sequence: Sequence) -> TokenStream {
    element("s", sequence)
}

/// What is divided by in every order, inverted.
fn inverse(sequence: Sequence) -> TokenStream {
    element("y", sequence)
}

/// A component of the motion's coefficients.
pub(super) fn leaf(leaf: Leaf) -> TokenStream {
    let (array, i) = match leaf {
        Leaf::Q(i) => ("q", i),
        Leaf::V(i) => ("v", i),
        Leaf::A(i) => ("a", i),
        Leaf::Lambda(j) => ("l", j),
        Leaf::T => {
            let series = local("series");
            return quote!(#series.time());
        }
        // the continuous system has no other leaves
        _ => return quote!(::core::unreachable!()),
    };
    let (array, i) = (local(array), at(i));
    quote!(#array[#i])
}

impl<'g> Writer<'g> {
    pub(super) fn new(graph: &'g Graph, sequences: Sequences) -> Self {
        Self {
            graph,
            sequences,
            constants: Vec::new(),
            calls: Vec::new(),
            eager: false,
        }
    }

    /// A factor that does not change in time.
    pub(super) fn constant(&mut self, constant: Constant) -> TokenStream {
        if let Some(value) = self.graph.as_constant(constant)
            && value.is_finite()
        {
            let magnitude = Literal::f64_suffixed(value.abs());
            return if value < 0.0 {
                quote!(__T::splat(-#magnitude))
            } else {
                quote!(__T::splat(#magnitude))
            };
        }
        let known = self.constants.iter().position(|&known| known == constant);
        let place = known.unwrap_or_else(|| {
            self.constants.push(constant);
            self.constants.len() - 1
        });
        let (array, place) = (local("c"), at(place));
        quote!(#array[#place])
    }

    /// `constant + Σ coefficient · term`.
    fn linear(
        &mut self,
        constant: Option<Constant>,
        terms: &[(Constant, Sequence)],
        value: fn(Sequence) -> TokenStream,
    ) -> TokenStream {
        let mut sum = constant.map(|constant| self.constant(constant));
        if terms.len() > SHORT_SUM {
            let coefficients: Vec<_> = terms.iter().map(|&(c, _)| self.constant(c)).collect();
            let values = terms.iter().map(|&(_, term)| value(term));
            let rest = quote!(::dsocs_core::__private::weighted::<__FUSED, _, __T>([#(#coefficients),*], [#(#values),*]));
            return match sum {
                Some(sum) => quote!(#sum + #rest),
                None => rest,
            };
        }
        for &(coefficient, term) in terms {
            let value = value(term);
            let number = self.graph.as_constant(coefficient);
            sum = Some(match (sum, number) {
                (None, Some(1.0)) => value,
                (None, Some(-1.0)) => quote!(-#value),
                (None, _) => {
                    let coefficient = self.constant(coefficient);
                    quote!(#coefficient * #value)
                }
                (Some(sum), Some(1.0)) => quote!(#sum + #value),
                (Some(sum), Some(-1.0)) => quote!(#sum - #value),
                (Some(sum), _) => {
                    let coefficient = self.constant(coefficient);
                    quote!(::dsocs_core::__private::add_product::<__FUSED, __T>(#sum, #coefficient, #value))
                }
            });
        }
        sum.unwrap_or_else(|| quote!(__T::splat(0.0)))
    }

    /// The statements of order 0 for one sequence.
    #[allow(clippy::too_many_lines)] // one operation after another, each a few lines
    pub(super) fn start(&mut self, sequence: Sequence, op: &Op) -> TokenStream {
        let to = zeroth(sequence);
        let z = |u: &Sequence| zeroth(*u);
        let method = |name: &str, u: &Sequence| {
            let (name, u) = (Ident::new(name, Span::call_site()), zeroth(*u));
            quote!(#to = __T::#name(#u);)
        };
        let reciprocal = |of: TokenStream| {
            let y = inverse(sequence);
            quote!(#y = __T::splat(1.0) / (#of);)
        };
        match op {
            Op::Leaf(which) => {
                let leaf = leaf(*which);
                quote!(#to = #leaf;)
            }
            Op::Constant(constant) => {
                let constant = self.constant(*constant);
                quote!(#to = #constant;)
            }
            Op::Linear(constant, terms) => {
                let sum = self.linear(*constant, terms, zeroth);
                quote!(#to = #sum;)
            }
            Op::Product(u, v) => {
                let (u, v) = (z(u), z(v));
                quote!(#to = #u * #v;)
            }
            Op::Square(u) => {
                let u = z(u);
                quote!(#to = #u * #u;)
            }
            Op::Quotient(u, v) => {
                let (u, y) = (z(u), reciprocal(z(v)));
                let v = z(v);
                quote!(#to = #u / #v; #y)
            }
            Op::Reciprocal(v) => {
                let (y, v) = (reciprocal(z(v)), z(v));
                quote!(#to = __T::splat(1.0) / #v; #y)
            }
            Op::Root(u) => {
                let (value, y) = (method("sqrt", u), reciprocal(quote!(__T::splat(2.0) * #to)));
                quote!(#value #y)
            }
            Op::CubeRoot(u) => {
                let (value, y) = (method("cbrt", u), reciprocal(z(u)));
                quote!(#value #y)
            }
            Op::Power(u, exponent) => {
                let (y, u, exponent) = (reciprocal(z(u)), z(u), self.constant(*exponent));
                quote!(#to = __T::powf(#u, #exponent); #y)
            }
            Op::Exp(u) => method("exp", u),
            Op::ExpM1(u) => method("exp_m1", u),
            Op::Ln(u) => {
                let (value, y) = (method("ln", u), reciprocal(z(u)));
                quote!(#value #y)
            }
            Op::Ln1p(u) => {
                let (value, u) = (method("ln_1p", u), z(u));
                let y = reciprocal(quote!(__T::splat(1.0) + #u));
                quote!(#value #y)
            }
            Op::Sin(u, partner) => {
                let (u, partner) = (z(u), z(partner));
                quote!((#to, #partner) = __T::sin_cos(#u);)
            }
            // written with its sine
            Op::Cos(..) => TokenStream::new(),
            Op::Sinh(u, _) => method("sinh", u),
            Op::Cosh(u, _) => method("cosh", u),
            Op::Tan(u, _) => method("tan", u),
            Op::Tanh(u, _) => {
                let (value, switch, u) = (method("tanh", u), self.switch(Argument::Steep(*u)), z(u));
                let steep = switch.map(|[table, place]| quote!(#table.steep(#place, #u);));
                quote!(#value #steep)
            }
            Op::Conjugate(u, _) => {
                let u = z(u);
                quote!(#to = (__T::splat(1.0) - #u) * (__T::splat(1.0) + #u);)
            }
            Op::Inverse(function, u, slope) => {
                let (value, y) = (method(function.name(), u), reciprocal(z(slope)));
                quote!(#value #y)
            }
            Op::Atan2(ordinate, abscissa, radius) => {
                let (ordinate, abscissa, y) = (z(ordinate), z(abscissa), reciprocal(z(radius)));
                quote!(#to = __T::atan2(#ordinate, #abscissa); #y)
            }
            Op::Abs(u) => {
                // its sign serves in every order
                let (value, y, sign) = (method("abs", u), inverse(sequence), self.sign(*u));
                quote!(#value #y = #sign;)
            }
            Op::Signum(u) => {
                let sign = self.sign(*u);
                quote!(#to = #sign;)
            }
            Op::Select(op, [left, right, then, otherwise]) => {
                let switch = self.switch(Argument::Difference(*left, *right));
                let [left, right, then, otherwise] = [left, right, then, otherwise].map(z);
                let select = match op {
                    Comparison::Lt => quote!(__T::select_lt),
                    Comparison::Le => quote!(__T::select_le),
                };
                let y = inverse(sequence);
                let of_value = quote!(#select(#left, #right, __T::splat(1.0), __T::splat(0.0)));
                let decides = if let Some([table, place]) = switch {
                    quote! {
                        #y = #select(#left, #right, __T::splat(-1.0), __T::splat(1.0));
                        #y = #table.start(#place, #left - #right, #y);
                        #y = __T::select_lt(#y, __T::splat(0.0), __T::splat(1.0), __T::splat(0.0));
                    }
                } else {
                    quote!(#y = #of_value;)
                };
                quote! {
                    #decides
                    #to = __T::select_lt(__T::splat(0.0), #y, #then, #otherwise);
                }
            }
            Op::Call { args, .. } => {
                let (table, place) = (local("table"), at(self.call(sequence)));
                let values = args.iter().map(z);
                let (moves, function) = (self.all_move(args), self.function(op));
                quote!(#to = #table.call(#place, [#(#values),*], #moves, #function);)
            }
        }
    }

    /// A call of the user's function, as a function of jets.
    fn function(&self, op: &Op) -> TokenStream {
        let Op::Call { callee, args, wrt } = op else {
            return TokenStream::new();
        };
        // at the user's name, so that rustc's word on a wrong function points there
        let span = Span::mixed_site().located_at(self.graph.callee(*callee).span());
        let names: Vec<_> = (0..args.len())
            .map(|i| Ident::new(&format!("x{i}"), span))
            .collect();
        let arguments: Vec<_> = names.iter().map(ToTokens::to_token_stream).collect();
        let number = |number: Literal| quote_spanned!(span=> ::dsocs_core::taylor::Jet::from(#number));
        let result = functions::call(self.graph, *callee, &arguments, wrt, &number);
        quote!(|[#(#names),*]| #result)
    }

    /// Which of some sequences have coefficients beyond order 0, as an array.
    fn all_move(&self, sequences: &[Sequence]) -> TokenStream {
        let moves = sequences.iter().map(|&sequence| self.moves(sequence));
        quote!([#(#moves),*])
    }

    /// The table of a switch and its place there, if its argument moves.
    fn switch(&self, argument: Argument) -> Option<[TokenStream; 2]> {
        let (table, place) = (local("table"), at(self.sequences.place(argument)?));
        Some([quote!(#table), quote!(#place)])
    }

    /// The sign of a sequence at order 0, or that of the piece that is continued.
    fn sign(&self, u: Sequence) -> TokenStream {
        let value = zeroth(u);
        let own = quote!(__T::signum(#value));
        match self.switch(Argument::Sign(u)) {
            Some([table, place]) => quote!(#table.start(#place, #value, #own)),
            None => own,
        }
    }

    /// Hands the coefficients of order `k` of their arguments to the switches.
    pub(super) fn watch(&self) -> TokenStream {
        let (table, k) = (local("table"), local("k"));
        let switches = self.sequences.switches().iter().enumerate();
        switches
            .map(|(place, &(argument, _))| {
                let place = at(place);
                let value = match argument {
                    Argument::Sign(u) | Argument::Steep(u) => kth(u),
                    Argument::Difference(left, right) => {
                        let (left, right) = (kth(left), kth(right));
                        quote!(#left - #right)
                    }
                };
                quote!(#table.watch(#place, #k, #value);)
            })
            .collect()
    }

    /// The place of a call among all.
    fn call(&mut self, sequence: Sequence) -> usize {
        let known = self.calls.iter().position(|&known| known == sequence);
        known.unwrap_or_else(|| {
            self.calls.push(sequence);
            self.calls.len() - 1
        })
    }

    /// Whether a sequence has coefficients beyond order 0.
    fn moves(&self, sequence: Sequence) -> bool {
        !matches!(
            self.sequences.ops().nth(sequence.index()),
            Some((_, Op::Constant(_)))
        )
    }

    /// The inner sum of a lane. Its newest terms, of the orders 1 and `k-1`, may come from variables: what has just been
    /// stored, number by number, cannot be loaded at once as a row.
    fn inner(&mut self, x: Operand, y: Operand) -> TokenStream {
        let (array, place) = match self.sequences.lane(x, y) {
            Lane::Product(place) => (local("products"), place),
            Lane::Square(place) => (local("squares"), place),
        };
        let (block, lane) = (at(place / LANES), at(place % LANES));
        let sum = quote!(#array[#block][#lane]);
        if !self.eager {
            return sum;
        }
        let add = |sum: TokenStream, a: TokenStream, b: TokenStream| quote!(::dsocs_core::__private::newest::<__FUSED, __T>(#sum, #a, #b));
        // j x_j is x_1 for j = 1
        let first = |operand: Operand| element("o", operand.sequence());
        let before = |operand: Operand| {
            let value = element("p", operand.sequence());
            let below = local("below");
            match operand {
                Operand::Plain(_) => value,
                Operand::Rate(_) => quote!((#below * #value)),
            }
        };
        if x == y {
            let first = first(x);
            return add(sum, quote!(__T::splat(2.0) * #first), before(x));
        }
        let sum = add(sum, first(x), before(y));
        add(sum, first(y), before(x))
    }

    /// The statement of order `k` for one sequence.
    #[allow(clippy::too_many_lines)] // one recurrence after another, each a few lines
    pub(super) fn next(&mut self, sequence: Sequence, op: &Op) -> TokenStream {
        use Operand::{Plain, Rate};
        let (to, y) = (kth(sequence), inverse(sequence));
        let (s, z) = (|u: &Sequence| kth(*u), |u: &Sequence| zeroth(*u));
        let (own, r, k) = (zeroth(sequence), local("r"), local("k"));
        let add = |sum: TokenStream, a: TokenStream, b: TokenStream| quote!(::dsocs_core::__private::add_product::<__FUSED, __T>(#sum, #a, #b));
        let value = match op {
            Op::Leaf(Leaf::T) => quote!(__T::splat(if #k == 1 { 1.0 } else { 0.0 })),
            Op::Leaf(which) => leaf(*which),
            Op::Constant(_) | Op::Signum(_) => quote!(__T::splat(0.0)),
            Op::Linear(_, terms) => self.linear(None, terms, kth),
            Op::Product(u, v) => {
                let inner = self.inner(Plain(*u), Plain(*v));
                let inner = add(inner, z(u), s(v));
                add(inner, s(u), z(v))
            }
            Op::Square(u) => {
                let inner = self.inner(Plain(*u), Plain(*u));
                let u0 = z(u);
                add(inner, quote!(__T::splat(2.0) * #u0), s(u))
            }
            Op::Quotient(u, v) => {
                let inner = self.inner(Plain(sequence), Plain(*v));
                let (u, inner) = (s(u), add(inner, own, s(v)));
                quote!((#u - #inner) * #y)
            }
            Op::Reciprocal(v) => {
                let inner = self.inner(Plain(sequence), Plain(*v));
                let inner = add(inner, own, s(v));
                quote!(-#inner * #y)
            }
            Op::Root(u) => {
                let inner = self.inner(Plain(sequence), Plain(sequence));
                let u = s(u);
                quote!((#u - #inner) * #y)
            }
            Op::CubeRoot(u) => self.power(sequence, *u, &quote!(__T::splat(1.0 / 3.0))),
            Op::Power(u, exponent) => {
                let exponent = self.constant(*exponent);
                self.power(sequence, *u, &exponent)
            }
            Op::Exp(u) => {
                let inner = self.inner(Rate(*u), Plain(sequence));
                add(quote!(#inner * #r), s(u), own)
            }
            Op::ExpM1(u) => {
                let inner = self.inner(Rate(*u), Plain(sequence));
                add(quote!(#inner * #r), s(u), quote!((__T::splat(1.0) + #own)))
            }
            Op::Ln(u) | Op::Ln1p(u) => {
                let inner = self.inner(Rate(sequence), Plain(*u));
                let u = s(u);
                quote!((#u - #inner * #r) * #y)
            }
            Op::Sin(u, partner) | Op::Sinh(u, partner) | Op::Cosh(u, partner) => {
                let inner = self.inner(Rate(*u), Plain(*partner));
                add(quote!(#inner * #r), s(u), z(partner))
            }
            Op::Cos(u, partner) => {
                let inner = self.inner(Rate(*u), Plain(*partner));
                let sum = add(quote!(#inner * #r), s(u), z(partner));
                quote!(-#sum)
            }
            Op::Tan(u, slope) | Op::Tanh(u, slope) => {
                let inner = self.inner(Rate(*u), Plain(*slope));
                add(quote!(#inner * #r), s(u), z(slope))
            }
            Op::Conjugate(_, square) => {
                let square = s(square);
                quote!(-#square)
            }
            Op::Inverse(_, u, slope) => {
                let inner = self.inner(Rate(sequence), Plain(*slope));
                let u = s(u);
                quote!((#u - #inner * #r) * #y)
            }
            Op::Atan2(ordinate, abscissa, radius) => {
                let turn = [
                    self.inner(Rate(*ordinate), Plain(*abscissa)),
                    self.inner(Rate(*abscissa), Plain(*ordinate)),
                    self.inner(Rate(sequence), Plain(*radius)),
                ];
                let [left, right, rest] = turn;
                let (ordinate, ordinate0) = (s(ordinate), z(ordinate));
                let (abscissa, abscissa0) = (s(abscissa), z(abscissa));
                quote! {
                    ((#left - #right - #rest) * #r + (#ordinate * #abscissa0 - #abscissa * #ordinate0)) * #y
                }
            }
            Op::Abs(u) => {
                let u = s(u);
                quote!(#y * #u)
            }
            Op::Select(_, [_, _, then, otherwise]) => {
                let (then, otherwise) = (s(then), s(otherwise));
                quote!(__T::select_lt(__T::splat(0.0), #y, #then, #otherwise))
            }
            Op::Call { args, .. } => {
                let (table, place) = (local("table"), at(self.call(sequence)));
                let (moves, function) = (self.all_move(args), self.function(op));
                let (values, args) = (args.iter().map(|&arg| zeroth(arg)), args.iter().map(s));
                quote! {
                    #table.coefficient::<__FUSED, _>(
                        #place, #k, [[#(#values),*], [#(#args),*]], #moves, #function,
                    )
                }
            }
        };
        quote!(#to = #value;)
    }

    /// `w = u^α`: `k u₀ w_k = α k w₀ u_k + Σ (α (k-j) - j) w_j u_{k-j}`.
    fn power(&mut self, w: Sequence, u: Sequence, exponent: &TokenStream) -> TokenStream {
        let outer = self.inner(Operand::Plain(w), Operand::Rate(u));
        let inner = self.inner(Operand::Rate(w), Operand::Plain(u));
        let (w0, u, y, r) = (zeroth(w), kth(u), inverse(w), local("r"));
        quote!((#exponent * (#outer * #r + #w0 * #u) - #inner * #r) * #y)
    }

    /// Stores the operands of order `k` for the inner sums of the orders to come.
    pub(super) fn store(&self) -> TokenStream {
        let (table, k, degree) = (local("table"), local("k"), local("degree"));
        let operand = |operand: Option<&Operand>| match operand {
            None => quote!(__T::splat(0.0)),
            Some(Operand::Plain(u)) => kth(*u),
            Some(Operand::Rate(u)) => {
                let u = kth(*u);
                quote!(#degree * #u)
            }
        };
        let mut code = TokenStream::new();
        for (block, lanes) in self.sequences.products.chunks(LANES).enumerate() {
            let block = at(block);
            let sides = [0, 1].map(|side| {
                let lanes = (0..LANES).map(|lane| operand(lanes.get(lane).map(|operands| &operands[side])));
                quote!([#(#lanes),*])
            });
            let [left, right] = sides;
            code.extend(quote! {
                #table.products[#block].left[#k] = #left;
                #table.products[#block].right[#k] = #right;
            });
        }
        for (block, lanes) in self.sequences.squares.chunks(LANES).enumerate() {
            let block = at(block);
            let lanes = (0..LANES).map(|lane| operand(lanes.get(lane)));
            code.extend(quote!(#table.squares[#block].rows[#k] = [#(#lanes),*];));
        }
        code
    }

    /// The numbers of blocks of products and of squares.
    pub(super) fn blocks(&self) -> [usize; 2] {
        [
            self.sequences.products.len().div_ceil(LANES),
            self.sequences.squares.len().div_ceil(LANES),
        ]
    }
}
