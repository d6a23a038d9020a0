//! Tests of the front end: the meaning of declarations, and the messages for wrong ones.

mod arrays;
mod each;
mod meaning;
mod mistakes;
mod random;
mod rates;
mod rotations;
mod text;
mod text_files;
mod third_order;
mod vectors;

use proc_macro2::TokenStream;

use crate::expand::{self, WrongDeclaration};
use crate::graph::NodeId;
use crate::model::{Displacements, Model};

/// A struct with parameters of many types.
const ITEM: &str = "struct Body<'a, K: Curvature, F> {
    /// The mass,
    /// in [kg].
    mass: f64, count: u32, single: f32, big: usize, flag: bool,
    masses: [f64; 3], table: Table, curvature: K, shared: &'a f64, force: F,
}";

fn tokens(source: &str) -> TokenStream {
    source.parse().unwrap()
}

fn analyzed(declaration: &str, item: &str) -> Result<Model, WrongDeclaration> {
    expand::model(tokens(declaration), &syn::parse_str(item).unwrap())
}

/// The model of a declaration on [`ITEM`].
fn model(declaration: &str) -> Model {
    match analyzed(declaration, ITEM) {
        Ok(model) => model,
        Err(mistakes) => panic!("{declaration}\n{:?}", mistakes.errors),
    }
}

/// The code of a declaration on [`ITEM`], without its text.
fn code(declaration: &str) -> String {
    let model = Model {
        text: String::new(),
        ..model(declaration)
    };
    model.code().to_string()
}

/// The fields that span the virtual displacements of a model.
fn fields_of(model: &Model) -> &[Vec<NodeId>] {
    match &model.displacements {
        Displacements::Fields(fields) => fields,
        Displacements::Annihilated => panic!("no fields are known"),
    }
}
