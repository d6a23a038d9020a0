//! Places of values in arguments, and numbers, as code.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

use crate::program::Stored;

/// The place of a value in the arguments of a method.
pub(crate) struct Place {
    /// The argument.
    pub(crate) array: TokenStream,
    /// The index, if the argument is an array, and whether it is a reference to one.
    pub(crate) element: Option<(usize, bool)>,
}

impl Place {
    /// An argument that is a number.
    pub(crate) fn number(name: &str) -> Self {
        let name = Ident::new(name, Span::call_site());
        Self {
            array: quote!(#name),
            element: None,
        }
    }

    /// A field that is a number.
    pub(crate) fn value(field: TokenStream) -> Self {
        Self {
            array: field,
            element: None,
        }
    }

    /// The place of a leaf that does not occur in the method.
    pub(crate) fn nowhere() -> Self {
        Self {
            array: quote!(::core::unreachable!()),
            element: None,
        }
    }

    /// An element of an array behind a reference.
    pub(crate) fn element(name: &str, index: usize) -> Self {
        let name = Ident::new(name, Span::call_site());
        Self {
            array: quote!(#name),
            element: Some((index, true)),
        }
    }

    /// An element of an array.
    pub(crate) fn own(array: TokenStream, index: usize) -> Self {
        Self {
            array,
            element: Some((index, false)),
        }
    }

    /// The place of a value that another method has stored.
    pub(crate) fn stored(place: Stored) -> Self {
        match place {
            Stored::Constants(index) => Self::element("constants", index),
            Stored::Known(index) => Self::element("known", index),
        }
    }

    /// The array and the index, if the place is an element.
    pub(super) fn argument(&self) -> Option<(&TokenStream, usize)> {
        self.element.map(|(element, _)| (&self.array, element))
    }

    /// The expression that reads it.
    pub(crate) fn read(&self) -> TokenStream {
        let array = &self.array;
        match self.element {
            None => quote!(#array),
            Some((index, _)) => {
                let index = Literal::usize_unsuffixed(index);
                quote!(#array[#index])
            }
        }
    }
}

/// A number as the generic scalar.
pub(crate) fn number(value: f64) -> TokenStream {
    let literal = if value.is_nan() {
        quote!(f64::NAN)
    } else if value.is_infinite() {
        if value > 0.0 {
            quote!(f64::INFINITY)
        } else {
            quote!(f64::NEG_INFINITY)
        }
    } else {
        let magnitude = Literal::f64_unsuffixed(value.abs());
        if value < 0.0 {
            quote!(-#magnitude)
        } else {
            quote!(#magnitude)
        }
    };
    quote!(__T::splat(#literal))
}
