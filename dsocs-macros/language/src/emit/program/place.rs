//! Where values stand, and numbers, as code.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

use super::Stored;

/// Where a value stands in the arguments.
pub(crate) struct Place {
    /// The argument.
    pub(super) array: TokenStream,
    /// Its element, if it is an array, and whether it is a reference to one.
    pub(super) element: Option<(usize, bool)>,
}

impl Place {
    /// A number.
    pub(crate) fn number(name: &str) -> Self {
        let name = Ident::new(name, Span::call_site());
        Self {
            array: quote!(#name),
            element: None,
        }
    }

    /// A number that stands in a field.
    pub(crate) fn value(field: TokenStream) -> Self {
        Self {
            array: field,
            element: None,
        }
    }

    /// The place of what does not occur.
    pub(crate) fn nowhere() -> Self {
        Self {
            array: quote!(::core::unreachable!()),
            element: None,
        }
    }

    /// An element of an array that is referred to.
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

    /// Where another method has put it.
    pub(super) fn stored(place: Stored) -> Self {
        match place {
            Stored::Constants(index) => Self::element("constants", index),
            Stored::Known(index) => Self::element("known", index),
        }
    }

    /// The array and the element, where it is one.
    pub(super) fn argument(&self) -> Option<(&TokenStream, usize)> {
        self.element.map(|(element, _)| (&self.array, element))
    }

    /// An expression for it.
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
pub(super) fn number(value: f64) -> TokenStream {
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
