//! The code of the recurrences: that of order 0, and that of any other order.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{ToTokens, quote, quote_spanned};

use crate::emit::rust::functions;
use crate::graph::{Comparison, Graph, Leaf};
use crate::recurrences::plan::{Factor, LANES, Plan};
use crate::recurrences::sequence::{Argument, Constant, Lane, Op, Operand, Sequence};

/// The longest sum that is written out; longer ones call a function, which forms several partial sums side by
/// side.
const SHORT_SUM: usize = 4;

/// The writer of the recurrences of a plan.
pub(super) struct Writer<'g> {
    pub(super) graph: &'g Graph,
    pub(super) plan: &'g Plan,
}

/// A name that cannot capture one of the user's.
pub(super) fn local(name: &str) -> Ident {
    Ident::new(name, Span::mixed_site())
}

pub(super) fn at(index: usize) -> Literal {
    Literal::usize_unsuffixed(index)
}

/// The element of an array for a sequence.
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

/// The inverted divisor of a sequence's recurrence, the same in every order.
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
    pub(super) fn new(graph: &'g Graph, plan: &'g Plan) -> Self {
        Self { graph, plan }
    }

    /// A constant factor as a generic scalar.
    fn constant(&self, constant: Constant) -> TokenStream {
        match self.plan.factor(self.graph, constant) {
            Factor::Number(value) => {
                let magnitude = Literal::f64_suffixed(value.abs());
                if value < 0.0 {
                    quote!(__T::splat(-#magnitude))
                } else {
                    quote!(__T::splat(#magnitude))
                }
            }
            Factor::Computed(place) => {
                let (array, place) = (local("c"), at(place));
                quote!(#array[#place])
            }
        }
    }

    /// `constant + Σ coefficient · term`.
    fn linear(
        &self,
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
    pub(super) fn start(&self, sequence: Sequence, op: &Op) -> TokenStream {
        let to = zeroth(sequence);
        let z = |u: &Sequence| zeroth(*u);
        let method = |name: &str, u: &Sequence| {
            let (name, u) = (Ident::new(name, Span::call_site()), zeroth(*u));
            quote!(#to = __T::#name(#u);)
        };
        let reciprocal = |of: TokenStream| {
            let y = inverse(sequence);
            quote!(#y = ::dsocs_core::__private::series::inverted::<__T>(#of);)
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
            // written together with its sine
            Op::Cos(..) => TokenStream::new(),
            Op::Sinh(u, _) => method("sinh", u),
            Op::Cosh(u, _) => method("cosh", u),
            Op::Tan(u, _) => method("tan", u),
            Op::Tanh(u, _) => method("tanh", u),
            Op::Conjugate(u, _) => {
                let u = z(u);
                quote!(#to = ::dsocs_core::__private::series::conjugate::<__T>(#u);)
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
                // stored, since every order needs its sign
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
                    #to = ::dsocs_core::__private::series::select::<__T>(#y, #then, #otherwise);
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

    /// A call of a user's function, as a closure of jets.
    fn function(&self, op: &Op) -> TokenStream {
        let Op::Call { callee, args, wrt } = op else {
            return TokenStream::new();
        };
        // with the location of the user's name, so that rustc's errors point there
        let span = Span::mixed_site().located_at(self.graph.callee(*callee).span());
        let names: Vec<_> = (0..args.len())
            .map(|i| Ident::new(&format!("x{i}"), span))
            .collect();
        let arguments: Vec<_> = names.iter().map(ToTokens::to_token_stream).collect();
        let number = |number: Literal| quote_spanned!(span=> ::dsocs_core::taylor::Jet::from(#number));
        let result = functions::call(self.graph, *callee, &arguments, wrt, &number);
        quote!(|[#(#names),*]| #result)
    }

    /// For each of some sequences, whether it has coefficients beyond order 0, as an array.
    fn all_move(&self, sequences: &[Sequence]) -> TokenStream {
        let moves = sequences.iter().map(|&sequence| self.moves(sequence));
        quote!([#(#moves),*])
    }

    /// The index of a call among all calls.
    fn call(&self, sequence: Sequence) -> usize {
        let mut calls = self.plan.calls.iter();
        calls.position(|&known| known == sequence).unwrap_or_default()
    }

    /// Whether a sequence has coefficients beyond order 0.
    fn moves(&self, sequence: Sequence) -> bool {
        !matches!(self.plan.sequences.op(sequence), Op::Constant(_))
    }

    /// An inner sum. If the plan is eager, its newest terms, of the orders 1 and `k-1`, come from variables:
    /// numbers that were just stored one by one cannot be loaded at once as a row. They are added in the order of the lane's
    /// operands, as the interpreter adds rows of them.
    fn inner(&self, operands: [Operand; 2]) -> TokenStream {
        let [x, y] = [operands[0].min(operands[1]), operands[0].max(operands[1])];
        let (array, place, beyond) = match self.plan.sequences.lane([x, y]) {
            Some(Lane::Product(place)) => (local("products"), place, self.plan.whole[0]),
            Some(Lane::Square(place)) => (local("squares"), place, 0),
            // does not occur: a sequence with a recurrence is needed beyond order 0
            None => return quote!(__T::splat(0.0)),
        };
        let (block, lane) = (at(place / LANES - beyond), at(place % LANES));
        let sum = quote!(#array[#block][#lane]);
        if !self.plan.eager {
            return sum;
        }
        let newest = |operand: Operand| {
            // j x_j is x_1 for j = 1
            let (first, value) = (element("o", operand.sequence()), element("p", operand.sequence()));
            let below = local("below");
            match operand {
                Operand::Plain(_) => quote!([#first, #value]),
                Operand::Rate(_) => quote!([#first, #below * #value]),
            }
        };
        let first = newest(x);
        if x == y {
            return quote!(::dsocs_core::__private::series::inner_square::<__FUSED, __T>(#sum, #first));
        }
        let second = newest(y);
        quote!(::dsocs_core::__private::series::inner::<__FUSED, __T>(#sum, #first, #second))
    }

    /// The statement of order `k` for one sequence.
    pub(super) fn next(&self, sequence: Sequence, op: &Op) -> TokenStream {
        let (to, y) = (kth(sequence), inverse(sequence));
        let (s, z) = (|u: &Sequence| kth(*u), |u: &Sequence| zeroth(*u));
        let pair = |u: &Sequence| {
            let (start, now) = (zeroth(*u), kth(*u));
            quote!([#start, #now])
        };
        if let Some(whole) = self.whole(sequence, op) {
            return quote!(#to = #whole;);
        }
        let (own, r, k) = (zeroth(sequence), local("r"), local("k"));
        let sums: Vec<_> = op
            .inner(sequence)
            .into_iter()
            .map(|sum| self.inner(sum))
            .collect();
        let series = quote!(::dsocs_core::__private::series);
        let rate = |u: &Sequence, factor: TokenStream| {
            let u = s(u);
            quote!(#series::rate::<__FUSED, __T>(#(#sums,)* #u, #factor, #r))
        };
        let value = match op {
            Op::Leaf(Leaf::T) => quote!(__T::splat(if #k == 1 { 1.0 } else { 0.0 })),
            Op::Leaf(which) => leaf(*which),
            Op::Constant(_) | Op::Signum(_) => quote!(__T::splat(0.0)),
            Op::Linear(_, terms) => self.linear(None, terms, kth),
            Op::Product(u, v) => {
                let (u, v) = (pair(u), pair(v));
                quote!(#series::product::<__FUSED, __T>(#(#sums,)* #u, #v))
            }
            Op::Square(u) => {
                let u = pair(u);
                quote!(#series::square::<__FUSED, __T>(#(#sums,)* #u))
            }
            Op::Quotient(u, v) => {
                let (u, v) = (s(u), s(v));
                quote!(#series::quotient::<__FUSED, __T>(#(#sums,)* #own, #u, #v, #y))
            }
            Op::Reciprocal(v) => {
                let v = s(v);
                quote!(#series::reciprocal::<__FUSED, __T>(#(#sums,)* #own, #v, #y))
            }
            Op::Root(u) => {
                let u = s(u);
                quote!(#series::root::<__T>(#(#sums,)* #u, #y))
            }
            Op::CubeRoot(u) | Op::Power(u, _) => {
                let exponent = if let Op::Power(_, exponent) = op {
                    self.constant(*exponent)
                } else {
                    quote!(__T::splat(1.0 / 3.0))
                };
                let u = s(u);
                quote!(#series::power::<__T>(#exponent, [#(#sums),*], #own, #u, [#y, #r]))
            }
            Op::Exp(u) => rate(u, own),
            Op::ExpM1(u) => rate(u, quote!((__T::splat(1.0) + #own))),
            Op::Sin(u, factor)
            | Op::Sinh(u, factor)
            | Op::Cosh(u, factor)
            | Op::Tan(u, factor)
            | Op::Tanh(u, factor) => rate(u, z(factor)),
            Op::Cos(u, partner) => {
                let sine = rate(u, z(partner));
                quote!(-#sine)
            }
            Op::Conjugate(_, square) => {
                let square = s(square);
                quote!(-#square)
            }
            Op::Ln(u) | Op::Ln1p(u) | Op::Inverse(_, u, _) => {
                let u = s(u);
                quote!(#series::by_slope::<__T>(#(#sums,)* #u, #y, #r))
            }
            Op::Atan2(ordinate, abscissa, _) => {
                let (ordinate, abscissa) = (pair(ordinate), pair(abscissa));
                quote!(#series::angle::<__T>([#(#sums),*], #ordinate, #abscissa, [#y, #r]))
            }
            Op::Abs(u) => {
                let u = s(u);
                quote!(#y * #u)
            }
            Op::Select(_, [_, _, then, otherwise]) => {
                let (then, otherwise) = (s(then), s(otherwise));
                quote!(#series::select::<__T>(#y, #then, #otherwise))
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

    /// Stores the operands of order `k` for the inner sums of higher orders.
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
        for (block, lanes) in self
            .plan
            .sequences
            .products
            .chunks(LANES)
            .skip(self.plan.whole[0])
            .enumerate()
        {
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
        for (block, lanes) in self
            .plan
            .sequences
            .squares
            .chunks(LANES)
            .enumerate()
            .skip(self.plan.whole[1])
        {
            let block = at(block);
            let lanes = (0..LANES).map(|lane| operand(lanes.get(lane)));
            code.extend(quote!(#table.squares[#block].rows[#k] = [#(#lanes),*];));
        }
        code
    }

    /// The numbers of blocks of products and of squares.
    pub(super) fn blocks(&self) -> [usize; 2] {
        [
            self.plan.sequences.products.len().div_ceil(LANES) - self.plan.whole[0],
            self.plan.sequences.squares.len().div_ceil(LANES),
        ]
    }
}
