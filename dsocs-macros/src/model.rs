//! The checked declaration: what [`crate::emit`] makes code of, without any way left to be wrong.

use proc_macro2::Ident;
use syn::ItemStruct;

use crate::graph::{Graph, NodeId};

/// A declaration that has passed every check, its expressions in one graph.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// The struct, as the user wrote it, without the attribute.
    pub(crate) item: ItemStruct,
    /// The coordinates' names.
    pub(crate) coordinates: Vec<Ident>,
    /// The numbers among the fields, in order.
    pub(crate) parameters: Vec<ParameterField>,
    /// All expressions.
    pub(crate) graph: Graph,
    /// `L`, in `Q` and `V`.
    pub(crate) lagrangian: NodeId,
    /// The kinematic constraints.
    pub(crate) kinematic: Vec<Row>,
    /// The fields that span `C_V`, of `n` components each, in `Q`, `V` and `A`.
    pub(crate) variational: Vec<Vec<NodeId>>,
    /// The components of `q` and `v`, in `X0`, `X1` and `H`; `None` for the paper's map.
    pub(crate) phi_lagrangian: Option<[Vec<NodeId>; 2]>,
    /// The components of `q`, `v` and `a`, in `X0`, `X1`, `X2` and `H`; `None` for the paper's map.
    pub(crate) phi_kinematic: Option<[Vec<NodeId>; 3]>,
    /// As [`Model::phi_kinematic`], for the variational constraints.
    pub(crate) phi_variational: Option<[Vec<NodeId>; 3]>,
    /// The observed expressions and their names, in `Q`, `V` and `A`.
    pub(crate) observe: Vec<(Ident, NodeId)>,
}

/// A parameter that can be listed and set by name: a field of type `f64`, or an element of an array of them.
#[derive(Clone, Debug)]
pub(crate) struct ParameterField {
    /// Its name: `mass`, `masses_2`.
    pub(crate) name: String,
    /// The field.
    pub(crate) ident: Ident,
    /// The element's place in the field, if it is an array.
    pub(crate) element: Option<usize>,
    /// Its documentation in one line.
    pub(crate) doc: String,
}

/// A kinematic constraint `c = 0`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// `c`, in `Q`, `V` and `A`.
    pub(crate) value: NodeId,
    /// The highest derivative of a coordinate in `c`: 1 or 2.
    #[allow(dead_code)] // constraints of lower order will be imposed at other points of the step
    pub(crate) order: usize,
    /// The factor to divide out, of order 0 or 1.
    pub(crate) divide: Option<NodeId>,
}
