//! Sums and products over ranges, and the functions of the declaration: bodies that are read once for each
//! index or call.

use std::rc::Rc;

use proc_macro2::Ident;
use quote::ToTokens;
use syn::{Expr, ExprCall, ExprClosure, Pat, ReturnType};

use crate::graph::NodeId;
use crate::lower::lowering::Lowering;
use crate::lower::names::{Binding, Function};
use crate::lower::values::{Value, Valued};
use crate::mistakes::errors::Reported;
use crate::syntax::ast::Entry;
use crate::syntax::{bare, plain_parameter, range_of};

/// The most terms and calls into which a declaration may expand.
const MOST: usize = 200_000;

impl Lowering<'_> {
    /// The binding of a `let`: a function, or a value.
    pub(crate) fn binding(&mut self, value: &Expr) -> Binding {
        match bare(value) {
            Expr::Closure(closure) => match self.check_parameters(closure) {
                Ok(()) => Binding::Function(Function {
                    closure: Rc::new(closure.clone()),
                    of_nodes: self.component.is_some(),
                }),
                Err(reported) => Binding::Let(Err(reported)),
            },
            _ if self.component.is_some() => Binding::OfMap(self.vector(value)),
            _ => Binding::Let(self.value(value)),
        }
    }

    /// `sum(0..8, |i| …)` or `product(0..8, |i| …)`
    pub(crate) fn over_range(&mut self, name: &Ident, call: &ExprCall) -> Valued {
        let arguments: Vec<_> = call.args.iter().map(bare).collect();
        let (range, closure) = match arguments.as_slice() {
            [range, Expr::Closure(closure)] if closure.inputs.len() == 1 => (*range, closure),
            _ => {
                let what = self
                    .errors
                    .words("a closure of its index", "what stands for each index");
                return Err(self.errors.at(
                    call,
                    format!("expected a range and {what}, `{name}(0..8, |i| …)`"),
                ));
            }
        };
        let range = range_of(range, |end| self.known_integer(end), self.errors);
        self.check_parameters(closure)?;
        let mut terms = Vec::new();
        for index in range? {
            terms.push(self.value_at_index(closure, index)?);
        }
        self.sum_or_product(name, &closure.body, &terms)
    }

    /// The sum or the product of some terms. Vectors have no product.
    fn sum_or_product(&mut self, name: &Ident, body: &Expr, terms: &[Value]) -> Valued {
        if name == "product" {
            let factors = terms
                .iter()
                .map(|factor| Ok((self.expect_number(body, factor)?, 1)));
            let factors: Vec<_> = factors.collect::<Result<_, _>>()?;
            return Ok(Value::Number(self.graph.product(&factors)));
        }
        let Some(first) = terms.first() else {
            return Ok(Value::Number(self.graph.sum(&[])));
        };
        if let Value::Rotation(_) = first {
            return Err(self.errors.at(body, "rotations have no sum"));
        }
        if let Some(other) = terms.iter().find(|term| term.kind() != first.kind()) {
            let message = format!(
                "expected the same for every index, found {} and {}",
                first.kind(),
                other.kind()
            );
            return Err(self.errors.at(body, message));
        }
        let terms: Vec<Vec<NodeId>> = terms.iter().map(Value::numbers).collect();
        let mut place = 0;
        first.map(|_| {
            let column: Vec<NodeId> = terms.iter().map(|term| term[place]).collect();
            place += 1;
            Ok(self.graph.sum(&column))
        })
    }

    /// The value of `|i| …` at one index.
    pub(crate) fn value_at_index(&mut self, closure: &ExprClosure, index: i64) -> Valued {
        self.count_expansion(closure)?;
        let outer = self.scope.len();
        if let Some(name) = closure.inputs.first().and_then(plain_parameter) {
            self.scope.push(name, Binding::Index(index));
        }
        let value = self.value(&closure.body);
        self.scope.truncate(outer);
        value
    }

    /// `f(2, x)` of a `let f = |i, a| …;`
    pub(crate) fn apply(&mut self, name: &Ident, function: &Function, call: &ExprCall) -> Valued {
        if self.component.is_some() && !function.of_nodes {
            return Err(self.errors.at(
                name,
                format!(
                    "a map knows the nodes, not the motion, and `{name}` is a function of the declaration; \
                     expected a `let` in a block of the map"
                ),
            ));
        }
        let closure = &function.closure;
        let (expected, found) = (closure.inputs.len(), call.args.len());
        if expected != found {
            let plural = if expected == 1 { "" } else { "s" };
            return Err(self.errors.at(
                call,
                format!("expected {expected} argument{plural} of `{name}`, found {found}"),
            ));
        }
        self.count_expansion(call)?;
        let mut arguments = Vec::new();
        for argument in &call.args {
            let binding = match self.integer(argument) {
                Some(value) => Binding::Index(value),
                None if self.component.is_some() => Binding::OfMap(self.vector(argument)),
                None => Binding::Let(self.value(argument)),
            };
            if let Binding::Let(Err(reported)) | Binding::OfMap(Err(reported)) = binding {
                return Err(reported);
            }
            arguments.push(binding);
        }
        // the body sees the names that were known at its definition, and its arguments
        let place = self.scope.place(name).unwrap_or_default();
        let removed = self.scope.split_off(place);
        let names = closure.inputs.iter().filter_map(plain_parameter);
        for (name, argument) in names.zip(arguments) {
            self.scope.push(name, argument);
        }
        let value = self.value(&closure.body);
        self.scope.restore(place, removed);
        value
    }

    /// The values of a list's entries, each at its indices. Of the entries of one `each`, only the first
    /// mistake is reported.
    pub(crate) fn each_entry<T>(
        &mut self,
        entries: &[Entry],
        mut lower: impl FnMut(&mut Self, &Expr) -> Result<T, Reported>,
    ) -> Result<Vec<T>, Reported> {
        let mut values = Vec::new();
        let (mut wrong, mut group) = (None, None);
        for entry in entries {
            let begins = group != Some(entry.group);
            if begins {
                group = Some(entry.group);
            } else if let Some((_, at)) = wrong
                && Some(at) == group
            {
                continue;
            }
            let value = self.at_indices(entry, begins, &mut lower);
            match value {
                Ok(value) => values.push(value),
                Err(reported) => wrong = Some((wrong.map_or(reported, |(first, _)| first), entry.group)),
            }
        }
        wrong.map_or(Ok(values), |(reported, _)| Err(reported))
    }

    /// The value of an entry at its indices. The names of the indices are checked at the first entry of an
    /// `each`.
    fn at_indices<T>(
        &mut self,
        entry: &Entry,
        is_first: bool,
        lower: impl FnOnce(&mut Self, &Expr) -> Result<T, Reported>,
    ) -> Result<T, Reported> {
        let outer = self.scope.len();
        let mut defined = Ok(());
        for index in &entry.indices {
            self.count_expansion(&entry.value)?;
            let binding = Binding::Index(index.value);
            if is_first {
                defined = defined.and(self.scope.define(&index.name, binding, self.errors));
            } else {
                self.scope.push(&index.name, binding);
            }
        }
        let value = defined.and_then(|()| lower(self, &entry.value));
        self.scope.truncate(outer);
        value
    }

    /// Reports parameters that are not plain names, or whose names have a meaning already.
    pub(crate) fn check_parameters(&mut self, closure: &ExprClosure) -> Result<(), Reported> {
        let outer = self.scope.len();
        let mut wrong = None;
        if let ReturnType::Type(_, ty) = &closure.output {
            wrong = Some(
                self.errors
                    .at(ty, "no type is written here: every expression is a number"),
            );
        }
        for input in &closure.inputs {
            let defined = match (plain_parameter(input), input) {
                (Some(name), _) => self.scope.define(name, Binding::Index(0), self.errors),
                (None, Pat::Type(typed)) => Err(self
                    .errors
                    .at(&typed.ty, "no type is written here: every expression is a number")),
                (None, _) => Err(self.errors.at(input, "expected a plain name")),
            };
            wrong = defined.err().or(wrong);
        }
        self.scope.truncate(outer);
        wrong.map_or(Ok(()), Err)
    }

    /// Counts a term or a call, and refuses it beyond [`MOST`].
    fn count_expansion(&mut self, tokens: impl ToTokens) -> Result<(), Reported> {
        self.expanded += 1;
        if self.expanded > MOST {
            return Err(self.errors.at(
                tokens,
                format!("written out, the sums and functions of the declaration have more than {MOST} terms"),
            ));
        }
        Ok(())
    }
}
