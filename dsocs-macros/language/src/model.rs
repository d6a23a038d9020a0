//! The checked declaration, from which code is made.

use std::collections::BTreeSet;
use std::fmt;

use proc_macro2::{Ident, TokenStream, TokenTree};
use syn::{ItemStruct, Path};

use crate::graph::{Graph, Leaf, NodeId, Param};
use crate::mistakes::Mistake;
use crate::syntax::input::{ParameterField, is_of_samples};

/// A declaration that has passed every check, with its expressions in one graph.
///
/// From [`analyze`](crate::analyze).
#[derive(Clone)]
pub struct Model {
    /// The path of `dsocs-core`, if it is not `::dsocs_core`.
    pub(crate) core: Option<Path>,
    /// The declaration as text.
    pub(crate) text: String,
    /// The struct, as the user wrote it, without the attribute.
    pub(crate) item: ItemStruct,
    /// The coordinates' names.
    pub(crate) coordinates: Vec<Ident>,
    /// The numbers in the fields of the struct, in order.
    pub(crate) parameters: Vec<ParameterField>,
    /// The other fields, each with its type.
    pub(crate) others: Vec<(String, String)>,
    /// The graph of all expressions.
    pub(crate) graph: Graph,
    /// `L`, in `Q`, `V` and `T`.
    pub(crate) lagrangian: NodeId,
    /// The constraints: holonomic, then nonholonomic, then kinematic ones.
    pub(crate) constraints: Vec<Row>,
    /// The forms that span `F_V`, if they are known: one for each constraint, or none.
    pub(crate) forms: Vec<Form>,
    /// The virtual displacements `C_V`.
    pub(crate) displacements: Displacements,
    /// `L_d`, in `X0`, `X1`, `T0`, `T1` and `H`, if it is declared.
    pub(crate) discrete_lagrangian: Option<NodeId>,
    /// The external forces, one for each coordinate, in `Q`, `V` and `T`; empty if there are none.
    pub(crate) external_forces: Vec<NodeId>,
    /// `φ_{L_d}⁻¹`: one point, or two whose values are averaged.
    pub(crate) phi_lagrangian: Vec<PairPoint>,
    /// `φ_{D_K}⁻¹`; `None` for the paper's map.
    pub(crate) phi_kinematic: Option<TriplePoint>,
    /// `φ_{D_V}⁻¹`; `None` for the paper's map.
    pub(crate) phi_variational: Option<TriplePoint>,
    /// The observed expressions, in `Q`, `V`, `A` and `T`, with their names.
    pub(crate) observe: Vec<(Ident, NodeId)>,
    /// The arguments of `dot(…)`.
    pub(crate) differentiated: Vec<NodeId>,
    /// Declared names that have no effect, or probably not the one that is meant.
    pub(crate) warnings: Vec<Warning>,
    /// The documentation of the system, the coordinates and the observables; parameters carry their own.
    pub(crate) docs: Docs,
}

impl Model {
    /// The table of samples (a field of type `Samples`) that a callee reads; `None` for other functions.
    pub(crate) fn table(&self, callee: usize) -> Option<String> {
        let name = self.graph.callee(callee).of_samples()?;
        let mut fields = self.others.iter();
        fields
            .any(|(field, ty)| *field == name && is_of_samples(ty))
            .then_some(name)
    }

    /// The name of the struct.
    #[must_use]
    pub fn name(&self) -> String {
        unraw(&self.item.ident)
    }

    /// The names of the coordinates, in order: `x`, `theta_0`, `theta_1`.
    #[must_use]
    pub fn coordinates(&self) -> Vec<String> {
        self.coordinates.iter().map(unraw).collect()
    }

    /// The names of the parameters that are numbers, in order: `mass`, `masses_0`, `masses_1`.
    #[must_use]
    pub fn parameters(&self) -> Vec<&str> {
        self.parameters.iter().map(|field| field.name.as_str()).collect()
    }

    /// The names of the observables, in order.
    #[must_use]
    pub fn observables(&self) -> Vec<String> {
        self.observe.iter().map(|(name, _)| unraw(name)).collect()
    }

    /// Warnings: declared names that have no effect, or probably not the one that is meant.
    #[must_use]
    pub fn warnings(&self) -> Vec<Mistake> {
        let warnings = self.warnings.iter();
        warnings
            .map(|warning| Mistake::of(warning.place.span(), warning.message.clone()))
            .collect()
    }

    /// The number of unknown multipliers, in a step and in the continuous system.
    pub(crate) fn multipliers(&self) -> usize {
        match self.displacements {
            Displacements::Fields(_) => 0,
            Displacements::Annihilated => self.forms.len(),
        }
    }

    /// Whether any expression depends on time.
    pub(crate) fn depends_on_time(&self) -> bool {
        self.graph.has_leaf(Leaf::T)
            || [Leaf::T0, Leaf::T1, Leaf::T2]
                .into_iter()
                .any(|leaf| self.discrete_has(leaf))
    }

    /// The indices of the parameters in holonomic constraints: if one of them changed in a run, the position
    /// would have to jump.
    pub(crate) fn parameters_of_positions(&self) -> Vec<usize> {
        let holonomic = self.constraints.iter().filter(|row| row.kind == Kind::Holonomic);
        self.parameters_of(holonomic.map(|row| row.value))
    }

    /// The indices of the parameters inside a `dot(…)`, whose rates are taken to be zero. If one of them
    /// changed in a run, the differentiated expression would jump.
    pub(crate) fn parameters_of_rates(&self) -> Vec<usize> {
        self.parameters_of(self.differentiated.iter().copied())
    }

    /// The indices of the parameters that some values depend on.
    fn parameters_of(&self, values: impl Iterator<Item = NodeId>) -> Vec<usize> {
        let mut found = BTreeSet::new();
        for value in values {
            for param in self.graph.params_of(value) {
                match param {
                    Param::Number(place) => {
                        found.insert(place);
                    }
                    // a Rust expression is opaque: it depends on every field that it names
                    Param::Expression(tokens) => {
                        let places = self.parameters.iter().enumerate();
                        let named = places.filter(|(_, field)| mentions(tokens, &field.ident));
                        found.extend(named.map(|(place, _)| place));
                    }
                }
            }
        }
        found.into_iter().collect()
    }

    /// Whether the discrete statements depend on a leaf.
    fn discrete_has(&self, leaf: Leaf) -> bool {
        let rows = self.constraints.iter().filter_map(|row| row.discrete);
        rows.chain(self.discrete_lagrangian)
            .any(|value| self.graph.depends_on(value, leaf))
    }

    /// The order of the highest derivative that a step determines: 3 with a constraint of third order, else
    /// 2.
    pub(crate) fn order(&self) -> usize {
        let rows = self.constraints.iter().map(|row| row.order);
        rows.fold(2, usize::max)
    }

    /// The indices of the constraints of third order.
    pub(crate) fn third_order(&self) -> impl Iterator<Item = usize> {
        let rows = self.constraints.iter().enumerate();
        rows.filter(|(_, row)| row.order == 3).map(|(place, _)| place)
    }

    /// The number of constraints of a kind.
    pub(crate) fn count(&self, kind: Kind) -> usize {
        self.constraints.iter().filter(|row| row.kind == kind).count()
    }
}

/// Whether a name occurs among tokens.
fn mentions(tokens: &TokenStream, name: &Ident) -> bool {
    tokens.clone().into_iter().any(|tree| match tree {
        TokenTree::Ident(ident) => ident == *name,
        TokenTree::Group(group) => mentions(&group.stream(), name),
        _ => false,
    })
}

/// `φ⁻¹` of two nodes, in `X0`, `X1`, `T0`, `T1` and `H`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct PairPoint {
    /// The time.
    pub(crate) t: NodeId,
    /// The components of the position.
    pub(crate) q: Vec<NodeId>,
    /// The components of the velocity.
    pub(crate) v: Vec<NodeId>,
}

/// `φ⁻¹` of three nodes, in `X0`, `X1`, `X2`, `T0`, `T1`, `T2` and `H`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct TriplePoint {
    /// The time.
    pub(crate) t: NodeId,
    /// The components of the position.
    pub(crate) q: Vec<NodeId>,
    /// The components of the velocity.
    pub(crate) v: Vec<NodeId>,
    /// The components of the acceleration.
    pub(crate) a: Vec<NodeId>,
}

/// A warning about a declared name.
#[derive(Clone, Debug)]
pub(crate) struct Warning {
    /// The name, where it was declared.
    pub(crate) place: Ident,
    /// The message.
    pub(crate) message: String,
    /// Whether nothing uses the name; then the compiler has a warning of its own.
    pub(crate) unused: bool,
}

/// Documentation, each in one line.
#[derive(Clone, Debug)]
pub(crate) struct Docs {
    /// The first paragraph of the struct's documentation.
    pub(crate) system: String,
    /// The first paragraph of each coordinate's documentation, in order.
    pub(crate) coordinates: Vec<String>,
    /// The first paragraph of each observed expression's documentation, in order.
    pub(crate) observe: Vec<String>,
}

impl fmt::Debug for Model {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Model")
            .field("name", &self.name())
            .field("coordinates", &self.coordinates())
            .field("parameters", &self.parameters())
            .field("observables", &self.observables())
            .finish_non_exhaustive()
    }
}

/// A name without the prefix `r#` of a raw identifier.
pub(crate) fn unraw(name: &Ident) -> String {
    let name = name.to_string();
    name.strip_prefix("r#").unwrap_or(&name).to_owned()
}

/// The kind of a constraint: on how many nodes it is imposed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `g(q) = 0`, on every node.
    Holonomic,
    /// `c(q, v) = 0`, on every pair of nodes.
    Nonholonomic,
    /// `c(q, v, a) = 0`, on every triple, or `c(q, v, a, j) = 0`, on every four nodes.
    Kinematic,
}

/// A constraint `c = 0`.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// The user's tokens, for messages about the row.
    pub(crate) tokens: TokenStream,
    /// Its kind.
    pub(crate) kind: Kind,
    /// `c`, in `Q`, `V`, `A`, `J` and `T`.
    pub(crate) value: NodeId,
    /// The highest derivative of a coordinate in `c`.
    pub(crate) order: usize,
    /// The factor to divide out, of order 0 or 1.
    pub(crate) divide: Option<NodeId>,
    /// Whether a factor has already been divided out of it.
    pub(crate) divided: bool,
    /// The row in a step, in `X0`, `X1`, `X2`, `T0`, `T1`, `T2` and `H`, if it is declared by
    /// `discrete_kinematic`.
    pub(crate) discrete: Option<NodeId>,
}

/// A one-form, along which a constraint force acts.
#[derive(Clone, Debug)]
pub(crate) struct Form {
    /// The components, in `Q`, `V`, `A` and `T`.
    pub(crate) components: Vec<NodeId>,
    /// Whether it belongs to a holonomic constraint: then it is evaluated at the middle node, whatever the
    /// maps are.
    pub(crate) at_node: bool,
}

/// The virtual displacements `C_V`.
#[derive(Clone, Debug)]
pub(crate) enum Displacements {
    /// Spanned by these fields, of `n` components each, in `Q`, `V`, `A` and `T`.
    Fields(Vec<Vec<NodeId>>),
    /// The annihilator of the forms, of which no basis of fields is known.
    Annihilated,
}
