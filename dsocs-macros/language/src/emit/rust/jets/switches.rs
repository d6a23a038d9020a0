//! The code that passes coefficients to the switches of a motion.

use proc_macro2::TokenStream;
use quote::quote;

use super::write::{Writer, at, kth, local, zeroth};
use crate::recurrences::plan::Plan;
use crate::recurrences::sequence::{Argument, Sequence};

impl Writer<'_> {
    /// The table of switches and the switch's index in it; `None` if its argument is constant.
    pub(super) fn switch(&self, argument: Argument) -> Option<[TokenStream; 2]> {
        let (table, place) = (local("table"), at(self.plan.sequences.place(argument)?));
        Some([quote!(#table), quote!(#place)])
    }

    /// Passes the coefficients of order 0 to the switches near which the motion may have a narrow feature.
    pub(super) fn watch_narrow_features(&self) -> TokenStream {
        let table = local("table");
        let switches = self.plan.sequences.switches().iter().enumerate();
        switches
            .map(|(place, &(argument, _))| {
                let place = at(place);
                match argument {
                    Argument::Steep(u) => {
                        let u = zeroth(u);
                        quote!(#table.steep(#place, #u);)
                    }
                    Argument::Power(u, exponent) => {
                        let u = zeroth(u);
                        quote!(#table.power(#place, #u, #exponent);)
                    }
                    Argument::Bounded(u, bound) => {
                        let (u, bound) = (zeroth(u), bound.value());
                        quote!(#table.bounded(#place, #u, #bound);)
                    }
                    Argument::Sign(_) | Argument::Difference(..) => TokenStream::new(),
                }
            })
            .collect()
    }

    /// The sign of a sequence at order 0, or that of the piece which is being continued.
    pub(super) fn sign(&self, u: Sequence) -> TokenStream {
        let value = zeroth(u);
        let own = quote!(__T::signum(#value));
        match self.switch(Argument::Sign(u)) {
            Some([table, place]) => quote!(#table.start(#place, #value, #own)),
            None => own,
        }
    }

    /// Passes the signs of the determinant and of the divisors to the series.
    pub(super) fn set_signs(&self) -> TokenStream {
        let Plan {
            sequences, motion, ..
        } = self.plan;
        let [series, inverse] = ["series", "inverse"].map(local);
        let determinant = (!motion.unknown.is_empty()).then(|| quote!(#inverse.sign()));
        let divisors = sequences.divisors().iter().map(|&divisor| {
            let value = zeroth(divisor);
            quote!(__T::signum(#value))
        });
        let signs: Vec<_> = determinant.into_iter().chain(divisors).collect();
        if signs.is_empty() {
            TokenStream::new()
        } else {
            quote!(#series.set_signs([#(#signs),*]);)
        }
    }

    /// Passes the coefficients of order `k` to the switches.
    pub(super) fn watch(&self) -> TokenStream {
        let (table, k) = (local("table"), local("k"));
        let switches = self.plan.sequences.switches().iter().enumerate();
        switches
            .map(|(place, &(argument, _))| {
                let place = at(place);
                let value = match argument {
                    Argument::Sign(u)
                    | Argument::Steep(u)
                    | Argument::Power(u, _)
                    | Argument::Bounded(u, _) => kth(u),
                    Argument::Difference(left, right) => {
                        let (left, right) = (kth(left), kth(right));
                        quote!(#left - #right)
                    }
                };
                quote!(#table.watch(#place, #k, #value);)
            })
            .collect()
    }
}
