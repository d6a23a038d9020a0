//! The user's functions: each is called in one place, generic in its number type.
//!
//! Steps, tapes and jets call a function with many number types. They do so through one method of the struct
//! for each function, so that rustc reports a mistake in a function once, at its name.

use std::collections::BTreeSet;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{ToTokens, format_ident, quote, quote_spanned};

use crate::graph::{Callee, Graph, Node};
use crate::lower::Builtin;
use crate::mistakes::nearest::nearest;
use crate::model::{Displacements, Model};

/// The most arguments of a function that is called through `dsocs_core`, which has error messages for wrong
/// functions.
const MOST_ARGUMENTS: usize = 6;

/// A function, and the number of arguments of its call.
type FunctionWithArity = (usize, usize);

/// The functions in differentiated expressions.
pub(crate) struct Functions(BTreeSet<FunctionWithArity>);

impl Functions {
    /// The functions of a declaration. One that is only observed is called with plain numbers, and so need
    /// not be generic.
    pub(crate) fn new(model: &Model) -> Self {
        let mut nodes = vec![model.lagrangian];
        nodes.extend(model.discrete_lagrangian);
        for row in &model.constraints {
            nodes.push(row.value);
            nodes.extend(row.divide.into_iter().chain(row.discrete));
        }
        nodes.extend(model.forms.iter().flat_map(|form| &form.components));
        if let Displacements::Fields(fields) = &model.displacements {
            nodes.extend(fields.iter().flatten());
        }
        nodes.extend(&model.external_forces);
        for point in &model.phi_lagrangian {
            nodes.extend([point.q.as_slice(), &point.v].concat());
            nodes.push(point.t);
        }
        let triples = [&model.phi_kinematic, &model.phi_variational];
        for point in triples.into_iter().flatten() {
            nodes.extend([point.q.as_slice(), &point.v, &point.a].concat());
            nodes.push(point.t);
        }
        let mut called = BTreeSet::new();
        for node in model.graph.subexpressions(nodes, |_| true) {
            if let Node::Call { callee, args, .. } = model.graph.node(node) {
                called.insert((*callee, args.len()));
            }
        }
        Self(called)
    }

    /// The methods through which the functions are called.
    pub(crate) fn methods(&self, model: &Model) -> TokenStream {
        if self.0.is_empty() {
            return TokenStream::new();
        }
        let name = &model.item.ident;
        let (impl_generics, type_generics, where_clause) = model.item.generics.split_for_impl();
        let methods = self.0.iter();
        let methods = methods.map(|&(callee, count)| method(model.graph.callee(callee), callee, count));
        quote! {
            #[allow(clippy::all, clippy::pedantic, clippy::nursery)]
            #[automatically_derived]
            impl #impl_generics #name #type_generics #where_clause {
                #(#methods)*
            }
        }
    }

    /// The value of a function at plain numbers, or its derivative.
    pub(crate) fn on_numbers(
        &self,
        graph: &Graph,
        callee: usize,
        arguments: &[TokenStream],
        wrt: &[usize],
    ) -> TokenStream {
        if self.0.contains(&(callee, arguments.len())) {
            call(graph, callee, arguments, wrt, &|number| quote!(#number))
        } else {
            call_as_written(graph.callee(callee), arguments)
        }
    }

    /// The value of a function at dual numbers, or its derivative; `None` for a function that is called with plain numbers only.
    pub(crate) fn on_duals(
        &self,
        graph: &Graph,
        callee: usize,
        arguments: &[TokenStream],
        wrt: &[usize],
    ) -> Option<TokenStream> {
        let constant = |number| quote!(::dsocs_core::__private::Dual::new(#number, 0.0f64));
        let known = !arguments.is_empty() && self.0.contains(&(callee, arguments.len()));
        known.then(|| call(graph, callee, arguments, wrt, &constant))
    }
}

/// The method of one function.
fn method(callee: &Callee, place: usize, count: usize) -> TokenStream {
    // mistakes in a function are reported at the user's name
    let span = callee.span();
    let name = method_name(place, count, span);
    let number = Ident::new("__Number", Span::mixed_site());
    let named = |name: &str| Ident::new(name, span);
    let x: Vec<_> = (0..count).map(|i| named(&format!("__x{i}"))).collect();
    let body = match callee {
        // the function's own types come first, so that a mistake in them is reported once
        Callee::Function(_) if count <= MOST_ARGUMENTS => {
            let (function, call) = (named("__function"), call_as_written(callee, &x));
            let through = named(&format!("call_{count}"));
            quote_spanned! {span=>
                let #function = |#(#x),*| #call;
                ::dsocs_core::__private::#through(#function, #(#x),*)
            }
        }
        Callee::Function(_) => call_as_written(callee, &x),
        Callee::Method(method) => {
            let (hint, call, receiver) = (hint_for(method, count - 1), call_as_written(callee, &x), &x[0]);
            quote_spanned!(span=> #hint let mut #receiver = #receiver; #call)
        }
    };
    quote! {
        #[inline(always)]
        #[allow(unused_mut, dead_code)]
        fn #name<#number: ::dsocs_core::Real>(&self, #(#x: #number),*) -> #number {
            #body
        }
    }
}

/// A trait method with the name of a user's method, if the name resembles that of a function of `f64`. It is
/// found last, after any method of the user's, and its error names the function that is meant.
fn hint_for(method: &Ident, count: usize) -> Option<TokenStream> {
    let meant = likely_function(&method.to_string())?;
    let span = method.span();
    let message = format!("numbers have no method `{method}`; did you mean `{meant}`?");
    let label = format!("expected `{meant}`");
    let types: Vec<_> = (0..count).map(|i| format_ident!("__A{}", i)).collect();
    Some(quote_spanned! {span=>
        #[diagnostic::on_unimplemented(message = #message, label = #label)]
        trait __Meant {}
        trait __NotThere: Sized {
            // `&mut self` is tried after `self` and `&self`
            fn #method<#(#types),*>(&mut self #(, _: #types)*) -> Self
            where
                Self: __Meant,
            {
                ::core::unreachable!()
            }
        }
        impl<__T: ::dsocs_core::Real> __NotThere for __T {}
    })
}

/// The function of `f64` that a method's name probably means.
fn likely_function(name: &str) -> Option<&'static str> {
    const MEANT: [(&str, &str); 2] = [("sqr", "powi(2)"), ("cube", "powi(3)")];
    let known = MEANT.iter().find(|(known, _)| *known == name);
    known
        .map(|(_, meant)| *meant)
        .or_else(|| nearest(name, Builtin::names()))
}

/// The call as the user wrote it.
fn call_as_written(callee: &Callee, arguments: &[impl ToTokens]) -> TokenStream {
    let span = callee.span();
    match callee {
        Callee::Function(function) => quote_spanned!(span=> #function(#(#arguments),*)),
        Callee::Method(method) => {
            let (receiver, rest) = (&arguments[0], &arguments[1..]);
            quote_spanned!(span=> (#receiver).#method(#(#rest),*))
        }
    }
}

fn method_name(place: usize, count: usize, span: Span) -> Ident {
    format_ident!(
        "__dsocs_function_{}_{}",
        place,
        count,
        span = Span::call_site().located_at(span)
    )
}

/// The value of a function, or its derivative by some arguments: with nested dual numbers, one level for each
/// derivative, seeded in one argument each. `number` makes a constant of the arguments' type.
pub(crate) fn call(
    graph: &Graph,
    callee: usize,
    arguments: &[TokenStream],
    wrt: &[usize],
    number: &dyn Fn(Literal) -> TokenStream,
) -> TokenStream {
    let seeds = Seeds {
        span: graph.callee(callee).span(),
        number,
    };
    let name = method_name(callee, arguments.len(), seeds.span);
    let arguments = arguments
        .iter()
        .enumerate()
        .map(|(place, argument)| seeds.argument(argument, place, wrt));
    let receiver = Ident::new("self", Span::call_site().located_at(seeds.span));
    let parts = wrt.iter().map(|_| Ident::new("eps", seeds.span));
    quote_spanned!(seeds.span=> #receiver.#name(#(#arguments),*) #(.#parts)*)
}

/// Dual numbers that are seeded for a derivative.
struct Seeds<'s> {
    span: Span,
    number: &'s dyn Fn(Literal) -> TokenStream,
}

impl Seeds<'_> {
    fn argument(&self, value: &TokenStream, place: usize, wrt: &[usize]) -> TokenStream {
        match wrt.split_first() {
            None => value.clone(),
            Some((&first, rest)) => {
                let inner = self.argument(value, place, rest);
                let tangent = self.constant(if first == place { 1.0 } else { 0.0 }, rest.len());
                quote_spanned!(self.span=> ::dsocs_core::__private::Dual::new(#inner, #tangent))
            }
        }
    }

    fn constant(&self, value: f64, depth: usize) -> TokenStream {
        if depth == 0 {
            return (self.number)(Literal::f64_suffixed(value));
        }
        let (inner, zero) = (self.constant(value, depth - 1), self.constant(0.0, depth - 1));
        quote_spanned!(self.span=> ::dsocs_core::__private::Dual::new(#inner, #zero))
    }
}
