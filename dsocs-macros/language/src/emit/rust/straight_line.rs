//! Straight-line code of a [`Program`].

use std::collections::BTreeSet;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{quote, quote_spanned};

use super::functions;
use super::loops::Loops;
use super::place::{Place, number};
use crate::graph::{Comparison, Graph, Leaf, Param};
use crate::hash::HashMap;
use crate::program::schedule::{Product, Schedule};
use crate::program::{Given, Op, Program, Value};

/// The most operations of a method that is written without loops, even if the program has cells.
const FEWEST_WITH_CELLS: usize = 200;

/// The most `let`s in one block. Every `let` opens a scope inside the one before it, and some thousands of
/// nested scopes overflow the compiler's stack when it writes debug information. Longer code is split into
/// blocks, which return the values used later.
const MOST_SCOPES: usize = 200;

/// The most statements of a function. Compiling time grows faster than a function's length, so longer code
/// becomes several functions.
const LONGEST_FUNCTION: usize = 2000;

impl Program<'_> {
    /// Straight-line code for `outputs`: the statements, then an expression for each output.
    ///
    /// `given` values come from the arrays `constants` and `known`, leaves from `leaf`. Names begin with `prefix`.
    pub(crate) fn code(
        &self,
        outputs: &[Value],
        given: &Given,
        prefix: &str,
        leaf: &dyn Fn(Leaf) -> Place,
    ) -> (TokenStream, Vec<TokenStream>) {
        let schedule = self.schedule(outputs, given);
        // numbered in the order of computation, so that the code does not depend on the order of lowering
        let names: HashMap<Value, Ident> = schedule
            .values
            .iter()
            .enumerate()
            // mixed-site hygiene: a generated name cannot capture one of the user's
            .map(|(place, &value)| (value, Ident::new(&format!("{prefix}{place}"), Span::mixed_site())))
            .collect();
        let operand = |value: Value| match (names.get(&value), self.op(value)) {
            (Some(name), _) => quote!(#name),
            (None, Op::Constant(bits)) => number(bits.get()),
            (None, _) => quote!(::core::unreachable!()), // a folded reciprocal is never an operand
        };
        let place = |value: Value| match (given.get(&value), self.op(value)) {
            (Some(&stored), _) => Some(Place::stored(stored)),
            (None, Op::Leaf(which)) => Some(leaf(*which)),
            (None, Op::Param(param)) => match self.graph.read_param(*param) {
                Param::Number(index) => Some(Place::element("parameters", index)),
                Param::Expression(_) => None,
            },
            _ => None,
        };
        if self.has_cells() && schedule.values.len() > FEWEST_WITH_CELLS {
            let places = schedule
                .values
                .iter()
                .filter_map(|&value| Some((value, place(value)?)));
            let kind = |value: Value| self.cell(value).kind;
            let loops = Loops::new(self, &schedule, (prefix, &names), places.collect(), &kind);
            return loops.code(outputs, &|value, operand| {
                self.operation(value, &schedule, operand)
            });
        }
        let statement = |value: Value| {
            let name = &names[&value];
            let right = self.operation(value, &schedule, &operand);
            quote!(let #name = #right;)
        };
        // the operands of an operation, and those of the reciprocals folded into it
        let reads = |value: Value| -> Vec<Value> {
            let mut reads = self.op(value).parts();
            for place in 0..reads.len() {
                if schedule.folded.contains(&reads[place]) {
                    reads.extend(self.op(reads[place]).parts());
                }
            }
            reads
        };
        // arguments can be read again in every function
        let mut loads: Vec<(Value, Place)> = Vec::new();
        let mut computed: Vec<Value> = Vec::new();
        for &value in &schedule.values {
            match place(value) {
                Some(place) => loads.push((value, place)),
                None => computed.push(value),
            }
        }
        let mut last_use: HashMap<Value, usize> =
            outputs.iter().map(|&output| (output, usize::MAX)).collect();
        for (place, &value) in computed.iter().enumerate().rev() {
            for part in reads(value) {
                last_use.entry(part).or_insert(place);
            }
        }
        let layout = Layout {
            names: &names,
            last_use: &last_use,
            statement: &statement,
            reads: &reads,
        };
        let results = outputs.iter().map(|&output| operand(output)).collect();
        (layout.functions(&loads, &computed, outputs), results)
    }

    fn operation(
        &self,
        value: Value,
        schedule: &Schedule,
        operand: &dyn Fn(Value) -> TokenStream,
    ) -> TokenStream {
        let operand = |value: &Value| operand(*value);
        match self.op(value) {
            Op::Constant(bits) => number(bits.get()),
            Op::Param(param) => {
                let tokens = self.graph.param_tokens(*param);
                quote!(__T::splat(#tokens))
            }
            Op::Leaf(_) => quote!(::core::unreachable!()), // leaves are arguments
            Op::Neg(a) => {
                let a = operand(a);
                quote!(-#a)
            }
            Op::Add(a, b) => {
                let (a, b) = (operand(a), operand(b));
                quote!(#a + #b)
            }
            Op::Sub(a, b) => {
                let (a, b) = (operand(a), operand(b));
                quote!(#a - #b)
            }
            Op::Mul(a, b) => match schedule.product(self, *a, *b) {
                Product::Of(a, b) => {
                    let (a, b) = (operand(&a), operand(&b));
                    quote!(#a * #b)
                }
                Product::Quotient(top, bottom) => {
                    let (top, bottom) = (operand(&top), operand(&bottom));
                    quote!(#top / #bottom)
                }
            },
            Op::Recip(a) => {
                let a = operand(a);
                quote!(__T::recip(#a))
            }
            Op::Powi(a, n) => {
                let (a, n) = (operand(a), Literal::i32_unsuffixed(*n));
                quote!(__T::powi(#a, #n))
            }
            Op::Unary(op, a) => {
                let (function, a) = (Ident::new(op.name(), Span::call_site()), operand(a));
                quote!(__T::#function(#a))
            }
            Op::Powf(a, b) => {
                let (a, b) = (operand(a), operand(b));
                quote!(__T::powf(#a, #b))
            }
            Op::Atan2(y, x) => {
                let (y, x) = (operand(y), operand(x));
                quote!(__T::atan2(#y, #x))
            }
            Op::Select(op, parts) => {
                let function = match op {
                    Comparison::Lt => quote!(select_lt),
                    Comparison::Le => quote!(select_le),
                };
                let parts = parts.iter().map(operand);
                quote!(__T::#function(#(#parts),*))
            }
            Op::Call { callee, args, wrt } => {
                let args: Vec<_> = args.iter().map(operand).collect();
                call(self.graph, *callee, &args, wrt)
            }
        }
    }
}

/// The statements that name the values in the arguments, with one pattern per argument: a pattern needs no
/// bounds checks that the compiler would have to remove.
fn loads(values: &[(&Ident, &Place)]) -> TokenStream {
    let mut groups: Vec<(String, Vec<(&Ident, &Place)>)> = Vec::new();
    for &(name, place) in values {
        let text = place.array.to_string();
        match groups.iter_mut().find(|(known, _)| *known == text) {
            Some((_, group)) => group.push((name, place)),
            None => groups.push((text, vec![(name, place)])),
        }
    }
    let statements = groups.iter().map(|(_, group)| {
        let (first, place) = group[0];
        let Some((_, is_reference)) = place.element.filter(|_| group.len() > 1) else {
            let read = place.read();
            return quote!(let #first = #read;);
        };
        let mut elements: Vec<TokenStream> = Vec::new();
        for (name, place) in group {
            let index = place.element.map_or(0, |(index, _)| index);
            if elements.len() <= index {
                elements.resize_with(index + 1, || quote!(_));
            }
            elements[index] = quote!(#name);
        }
        let array = &place.array;
        let star = is_reference.then(|| quote!(*));
        quote!(let [#(#elements,)* ..] = #star #array;)
    });
    statements.collect()
}

/// The split of statements into blocks and functions.
struct Layout<'a> {
    names: &'a HashMap<Value, Ident>,
    /// The index of the last statement that reads a value.
    last_use: &'a HashMap<Value, usize>,
    statement: &'a dyn Fn(Value) -> TokenStream,
    /// The operands of a statement.
    reads: &'a dyn Fn(Value) -> Vec<Value>,
}

impl Layout<'_> {
    /// The statements, in several functions if they are too many for one; each function reads the arguments
    /// itself.
    fn functions(&self, all: &[(Value, Place)], computed: &[Value], outputs: &[Value]) -> TokenStream {
        let loads_of = |is_read: &dyn Fn(&Value) -> bool| {
            let read = all.iter().filter(|(value, _)| is_read(value));
            let named: Vec<_> = read.map(|(value, place)| (&self.names[value], place)).collect();
            loads(&named)
        };
        if computed.len() <= LONGEST_FUNCTION {
            let (loads, code) = (loads_of(&|_| true), self.blocks(computed, 0));
            return quote!(#loads #code);
        }
        let mut functions = TokenStream::new();
        for (part, values) in computed.chunks(LONGEST_FUNCTION).enumerate() {
            let start = part * LONGEST_FUNCTION;
            let read: BTreeSet<Value> = values.iter().flat_map(|&value| (self.reads)(value)).collect();
            let (own, code, live) = (
                loads_of(&|value| read.contains(value)),
                self.blocks(values, start),
                self.live_after(values, start),
            );
            functions.extend(quote! {
                let [#(#live),*] = ::dsocs_core::__private::apart(move || { #own #code [#(#live),*] });
            });
        }
        let last = loads_of(&|value| outputs.contains(value));
        quote!(#functions #last)
    }

    /// The statements of one function, in blocks if they are many. `start` is the index of the first.
    fn blocks(&self, values: &[Value], start: usize) -> TokenStream {
        let mut blocks = TokenStream::new();
        for (block, part) in values.chunks(MOST_SCOPES).enumerate() {
            let code: TokenStream = part.iter().map(|&value| (self.statement)(value)).collect();
            if values.len() <= MOST_SCOPES {
                return code;
            }
            let live = self.live_after(part, start + block * MOST_SCOPES);
            blocks.extend(quote!(let [#(#live),*] = { #code [#(#live),*] };));
        }
        blocks
    }

    /// The values of a block that are read after it. `start` is the index of the first.
    fn live_after(&self, values: &[Value], start: usize) -> Vec<&Ident> {
        let end = start + values.len();
        let lasts = |value: &&Value| self.last_use.get(value).is_some_and(|&place| place >= end);
        values
            .iter()
            .filter(lasts)
            .map(|value| &self.names[value])
            .collect()
    }
}

/// A call of a user's function in each lane: at plain numbers for its value, at dual numbers for a
/// derivative.
fn call(graph: &Graph, callee: usize, args: &[TokenStream], wrt: &[usize]) -> TokenStream {
    let span = graph.callee(callee).span();
    let lane = Ident::new("lane", Span::mixed_site());
    let args: Vec<_> = args
        .iter()
        .map(|arg| quote_spanned!(span=> __T::lane(#arg, #lane)))
        .collect();
    let result = functions::call(graph, callee, &args, wrt, &|number| quote!(#number));
    quote_spanned!(span=> __T::from_lanes(|#lane| [#result])[0])
}

/// The array `[[a, b], [c, d]]` of some entries, row by row.
pub(super) fn matrix(rows: &[TokenStream], width: usize) -> TokenStream {
    let rows = rows.chunks(width.max(1)).map(|row| quote!([#(#row),*]));
    quote!([#(#rows),*])
}
