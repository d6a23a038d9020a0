//! The struct with all its implementations.

mod compiled;
pub(crate) mod functions;
pub(crate) mod jets;
pub(crate) mod kernel;
mod loops;
mod phase_slopes;
mod place;
mod source;
mod straight_line;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

use super::assemble::{Assembled, assembled};
use super::facts::Facts;
use super::tape;
use crate::model::{Model, Warning, unraw};
use crate::passes;
use crate::syntax::input::ParameterField;

use functions::Functions;
use kernel::{kernel, send_and_sync};

/// The struct as the user wrote it, with all its implementations.
pub(crate) fn expand(model: &Model) -> TokenStream {
    let replaced = passes::with_continuous_quotients(model);
    let model = replaced.as_ref().unwrap_or(model);
    let item = &model.item;
    let system = system(model);
    let jets = if model.order() > 2 {
        jets::none(&model.item.ident, &model.item.generics, model.coordinates.len())
    } else {
        jets::jets(model)
    };
    let warnings = model.warnings.iter().map(warning);
    quote! {
        #item
        #system
        #jets
        #(#warnings)*
    }
}

/// A warning at the user's name. For an unused name it is the compiler's own. Stable Rust lets a macro give
/// other warnings only through the use of something deprecated.
fn warning(warning: &Warning) -> TokenStream {
    let Warning {
        place,
        message,
        unused,
    } = warning;
    if *unused {
        return quote! {
            const _: () = {
                let #place = ();
            };
        };
    }
    quote! {
        #[allow(non_upper_case_globals)]
        const _: () = {
            #[deprecated(note = #message)]
            const #place: () = ();
            #place
        };
    }
}

/// The implementations of the declaration, hot and cold.
fn system(model: &Model) -> TokenStream {
    assembled(model, |all| code(&all))
}

/// The code of an assembled declaration.
fn code(all: &Assembled<'_>) -> TokenStream {
    let Assembled {
        model, facts, stages, ..
    } = all;
    let metadata = metadata(model, facts);
    let compiled = compiled::compiled(model, facts, stages);
    let functions = Functions::new(model);
    let tape = tape::tape(model, stages, (all.graph, &all.declared), all.expressions);
    let source = source::source(model, &tape, &functions);
    let functions = functions.methods(model);
    let kind = kernel::Kind {
        third_order: facts.order > 2,
        sparse: stages.sparse.is_some(),
        scaled: facts.scaled,
    };
    let kernel = kernel(
        &model.item.ident,
        &model.item.generics,
        model.coordinates.len(),
        kind,
    );
    quote! {
        #metadata
        #functions
        #compiled
        #kernel
        #source
    }
}

/// The `impl System`: names, and access to the parameters by index.
fn metadata(model: &Model, facts: &Facts) -> TokenStream {
    let name = &model.item.ident;
    let generics = send_and_sync(&model.item.generics);
    let (impl_generics, type_generics, where_clause) = generics.split_for_impl();
    let n = Literal::usize_unsuffixed(model.coordinates.len());
    let quantity = |name: &str, doc: &str| quote!(::dsocs_core::Quantity::new(#name, #doc));
    let coordinates = model.coordinates.iter().zip(&model.docs.coordinates);
    let coordinates = coordinates.map(|(name, doc)| quantity(&unraw(name), doc));
    let observables = model.observe.iter().zip(&model.docs.observe);
    let observables = observables.map(|((name, _), doc)| quantity(&unraw(name), doc));
    let parameters = model.parameters.iter();
    let parameters = parameters.map(|field| quantity(&field.name, &field.doc));
    let others = (!model.others.is_empty()).then(|| {
        let others = model.others.iter().map(|(name, ty)| quantity(name, ty));
        quote!(const OTHERS: &'static [::dsocs_core::Quantity] = &[#(#others),*];)
    });
    let (own_name, doc, text) = (unraw(name), &model.docs.system, &model.text);
    let symmetry = Ident::new(facts.symmetry.name(), Span::call_site());
    let order = (facts.order > 2).then(|| {
        let order = Literal::usize_unsuffixed(facts.order);
        quote!(const ORDER: usize = #order;)
    });
    let (depends_on_time, forced) = (facts.depends_on_time, facts.external_forces);
    let [forms, holonomic, nonholonomic, kinematic] =
        [facts.forms, facts.holonomic, facts.nonholonomic, facts.kinematic].map(Literal::usize_unsuffixed);
    let indices: Vec<_> = (0..model.parameters.len())
        .map(Literal::usize_unsuffixed)
        .collect();
    let fields: Vec<_> = model.parameters.iter().map(ParameterField::read).collect();
    quote! {
        #[allow(clippy::all, clippy::pedantic, clippy::nursery)]
        #[automatically_derived]
        impl #impl_generics ::dsocs_core::System<#n> for #name #type_generics #where_clause {
            const NAME: &'static str = #own_name;
            const DOC: &'static str = #doc;
            const DECLARATION: &'static str = #text;
            const COORDINATES: [::dsocs_core::Quantity; #n] = [#(#coordinates),*];
            const PARAMETERS: &'static [::dsocs_core::Quantity] = &[#(#parameters),*];
            #others
            const OBSERVABLES: &'static [::dsocs_core::Quantity] = &[#(#observables),*];
            #order
            const FORMS: usize = #forms;
            const HOLONOMIC: usize = #holonomic;
            const NONHOLONOMIC: usize = #nonholonomic;
            const KINEMATIC: usize = #kinematic;
            const DEPENDS_ON_TIME: bool = #depends_on_time;
            const EXTERNAL_FORCES: bool = #forced;
            const SYMMETRY: ::dsocs_core::Symmetry = ::dsocs_core::Symmetry::#symmetry;

            fn kernel(&self) -> &dyn ::dsocs_core::__private::Kernel {
                self
            }

            fn parameter(&self, index: usize) -> ::core::option::Option<f64> {
                match index {
                    #(#indices => ::core::option::Option::Some(#fields),)*
                    _ => ::core::option::Option::None,
                }
            }

            fn parameter_mut(&mut self, index: usize) -> ::core::option::Option<&mut f64> {
                match index {
                    #(#indices => ::core::option::Option::Some(&mut #fields),)*
                    _ => ::core::option::Option::None,
                }
            }
        }
    }
}
