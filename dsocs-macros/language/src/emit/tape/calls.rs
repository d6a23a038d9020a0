//! The calls of a tape: functions and numbers that are no operations.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

use crate::emit::data::Call;
use crate::emit::rust::functions::Functions;
use crate::graph::{Callee, Graph, Param};
use crate::lower::circle_constant;
use crate::model::Model;

/// The calls of a tape: the user's functions, and expressions of the parameters that are not plain numbers.
#[derive(Default)]
pub(crate) struct Calls(Vec<TapeCall>);

#[derive(Clone, PartialEq, Eq)]
pub(super) enum TapeCall {
    Function {
        callee: usize,
        count: usize,
        wrt: Vec<usize>,
    },
    Expression(usize),
}

impl Calls {
    /// The number of a call.
    pub(super) fn place(&mut self, called: TapeCall) -> usize {
        let known = self.0.iter().position(|known| *known == called);
        known.unwrap_or_else(|| {
            self.0.push(called);
            self.0.len() - 1
        })
    }

    /// The number of the call of a function, or of a derivative of one.
    pub(crate) fn function(&mut self, callee: usize, count: usize, wrt: &[usize]) -> usize {
        self.place(TapeCall::Function {
            callee,
            count,
            wrt: wrt.to_vec(),
        })
    }

    /// Whether a derivative of a function is called.
    pub(crate) fn differentiates(&self, callee: usize) -> bool {
        let differentiated = |called: &TapeCall| match called {
            TapeCall::Function {
                callee: other, wrt, ..
            } => *other == callee && !wrt.is_empty(),
            TapeCall::Expression(_) => false,
        };
        self.0.iter().any(differentiated)
    }

    /// The calls as data, for an engine without a compiler.
    pub(crate) fn data(&self, graph: &Graph) -> Vec<Call> {
        let calls = self.0.iter();
        calls
            .map(|called| match called {
                TapeCall::Function { callee, wrt, .. } => {
                    let callee = graph.callee(*callee);
                    match callee.of_samples() {
                        Some(name) => Call::Samples {
                            name,
                            derivative: wrt.len(),
                        },
                        None => Call::Rust(callee.source_text()),
                    }
                }
                TapeCall::Expression(param) => {
                    let tokens = match graph.read_param(*param) {
                        Param::Expression(tokens) => tokens.to_string(),
                        Param::Number(place) => place.to_string(),
                    };
                    circle_constant(&tokens).map_or(Call::Rust(tokens), Call::Number)
                }
            })
            .collect()
    }

    /// The match arms that evaluate the calls at plain numbers.
    pub(crate) fn arms(&self, graph: &Graph, functions: &Functions) -> Vec<TokenStream> {
        let calls = self.0.iter().enumerate();
        calls
            .map(|(place, called)| {
                let place = Literal::usize_unsuffixed(place);
                match called {
                    TapeCall::Function { callee, count, wrt } => {
                        let names: Vec<_> = (0..*count)
                            .map(|i| Ident::new(&format!("x{i}"), Span::mixed_site()))
                            .collect();
                        let arguments: Vec<_> = names.iter().map(|name| quote!(#name)).collect();
                        let result = functions.on_numbers(graph, *callee, &arguments, wrt);
                        quote!((#place, &[#(#names),*]) => #result)
                    }
                    TapeCall::Expression(param) => match graph.read_param(*param) {
                        Param::Expression(tokens) => quote!((#place, &[]) => #tokens),
                        // numbers are leaves, not calls
                        Param::Number(_) => quote!((#place, &[]) => f64::NAN),
                    },
                }
            })
            .collect()
    }

    /// The match arms that evaluate calls of differentiable functions at dual numbers.
    pub(crate) fn dual_arms(&self, graph: &Graph, functions: &Functions) -> Vec<TokenStream> {
        let calls = self.0.iter().enumerate();
        calls
            .filter_map(|(place, called)| {
                let TapeCall::Function { callee, count, wrt } = called else {
                    return None;
                };
                let names: Vec<_> = (0..*count)
                    .map(|i| Ident::new(&format!("x{i}"), Span::mixed_site()))
                    .collect();
                let arguments: Vec<_> = names.iter().map(|name| quote!(#name)).collect();
                let result = functions.on_duals(graph, *callee, &arguments, wrt)?;
                let place = Literal::usize_unsuffixed(place);
                Some(quote!((#place, &[#(#names),*]) => #result))
            })
            .collect()
    }

    /// The match arms of calls that are data: tables of samples, with the order of the derivative.
    pub(crate) fn data_arms(&self, model: &Model) -> Vec<TokenStream> {
        let calls = self.0.iter().enumerate();
        calls
            .filter_map(|(place, called)| {
                let TapeCall::Function { callee, wrt, .. } = called else {
                    return None;
                };
                model.table(*callee)?;
                let Callee::Function(function) = model.graph.callee(*callee) else {
                    return None;
                };
                // `self.wind` of `self.wind.at`
                let field: TokenStream = function.clone().into_iter().take(3).collect();
                let [place, order] = [place, wrt.len()].map(Literal::usize_unsuffixed);
                Some(quote!(#place => ::dsocs_core::__private::table(&#field, #order)))
            })
            .collect()
    }
}
