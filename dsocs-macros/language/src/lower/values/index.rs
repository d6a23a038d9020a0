//! Integers known while the declaration is read, and their uses: coordinates of arrays, elements of
//! parameters, branches.

use proc_macro2::Ident;
use quote::ToTokens;
use syn::{BinOp, Expr, ExprIndex, Member, UnOp};

use crate::graph::Leaf;
use crate::lower::lowering::Lowering;
use crate::lower::names::Binding;
use crate::lower::values::{Value, Valued};
use crate::mistakes::errors::Reported;
use crate::syntax::{bare, integer, plain_name};

/// The error for an index behind a rotation.
pub(crate) const INDEX_OF_ROTATION: &str = "the components of a rotation have no names, since `q` and `-q` are the same one; expected those of its matrix, `r.matrix()[0][0]`, or of \
                           what it turns, `(r * c)[0]`";

impl Lowering<'_> {
    /// The value of an integer expression of literals, indices and whole `let`s; `None` for other
    /// expressions.
    pub(crate) fn integer(&self, expr: &Expr) -> Option<i64> {
        integer(expr, &|path| match self.scope.get(plain_name(path)?)? {
            Binding::Index(value) => Some(*value),
            Binding::Let(Ok(Value::Number(node))) => self.graph.as_constant(*node).and_then(as_integer),
            _ => None,
        })
    }

    /// Whether a condition on integers holds; `None` for other conditions.
    pub(crate) fn known_condition(&self, condition: &Expr) -> Option<bool> {
        match bare(condition) {
            Expr::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => {
                self.known_condition(&unary.expr).map(|holds| !holds)
            }
            Expr::Binary(binary) => match binary.op {
                BinOp::And(_) => {
                    Some(self.known_condition(&binary.left)? && self.known_condition(&binary.right)?)
                }
                BinOp::Or(_) => {
                    Some(self.known_condition(&binary.left)? || self.known_condition(&binary.right)?)
                }
                _ => {
                    let (left, right) = (self.integer(&binary.left)?, self.integer(&binary.right)?);
                    match binary.op {
                        BinOp::Lt(_) => Some(left < right),
                        BinOp::Le(_) => Some(left <= right),
                        BinOp::Gt(_) => Some(left > right),
                        BinOp::Ge(_) => Some(left >= right),
                        BinOp::Eq(_) => Some(left == right),
                        BinOp::Ne(_) => Some(left != right),
                        _ => None,
                    }
                }
            },
            _ => None,
        }
    }

    /// The value of `theta[2]`, `masses[i + 1]`, or in a map `q0.theta[2]`.
    pub(crate) fn index(&mut self, index: &ExprIndex, whole: &Expr) -> Valued {
        let base = bare(&index.expr);
        if self.discrete.is_some()
            && let Some(coordinate) = self.coordinate_of_node(base)
        {
            let leaf = self.at_node(coordinate?, &index.index)?;
            return Ok(Value::Number(self.graph.leaf(leaf)));
        }
        if self.discrete.is_some() && plain_name(base).is_some_and(|name| name == "t") {
            let leaf = self.time_of_node(&index.index)?;
            return Ok(Value::Number(self.graph.leaf(leaf)));
        }
        if plain_name(base).is_some_and(|name| name == "t") {
            return Err(self.errors.at(
                index,
                "`t` is time, and stands without an index: a system is continuous until maps discretize it; times of nodes, `t[0]`, \
                 stand in discrete expressions alone",
            ));
        }
        let array = match base {
            Expr::Path(_) => plain_name(base).and_then(|name| self.array(name)),
            _ => None,
        };
        if let Some(group) = array {
            if self.component.is_some() {
                return Err(self.motion_in_map(whole, whole));
            }
            let coordinate = self.element(group, &index.index)?;
            if self.discrete.is_some() {
                return Err(self.motion_among_nodes(whole, true));
            }
            return Ok(Value::Number(self.graph.leaf(Leaf::Q(coordinate))));
        }
        if let Expr::Field(field) = base
            && self.is_of_map(&field.base)
        {
            let array = match &field.member {
                Member::Named(name) => self.array(name),
                Member::Unnamed(_) => None,
            };
            if let Some(group) = array {
                let component = self.element(group, &index.index)?;
                return self.component_of(&field.base, component).map(Value::Number);
            }
        }
        self.check_base(base)?;
        self.check_parameter(base, &index.index)?;
        let rank = if self.component.is_none() {
            self.rank(base)
        } else {
            0
        };
        let is_known = self.integer(&index.index).is_some();
        if self.is_closed(whole) && (rank == 0 || !is_known || self.is_element(whole)) {
            return self.param(whole).map(Value::Number);
        }
        if self.component.is_none() && (is_known && rank > 0 || !self.is_closed(base)) {
            let value = self.value(base)?;
            if value.rank() > 0 {
                return self.component(&value, base, &index.index);
            }
            if matches!(value, Value::Rotation(_)) {
                return Err(self.errors.at(&index.expr, INDEX_OF_ROTATION));
            }
            let message = "expected a vector before the index, found a number";
            return Err(self.errors.at(&index.expr, message));
        }
        Err(self.errors.at(
            index,
            "expected an index without coordinates and `let`s; what varies with the motion is a function, `table.at(x)`",
        ))
    }

    /// The index of an array of coordinates among the groups.
    pub(crate) fn array(&self, name: &Ident) -> Option<usize> {
        self.groups
            .iter()
            .position(|group| group.length.is_some() && group.name == *name)
    }

    /// Reports an array of coordinates in place of one of them.
    pub(crate) fn whole_array(&self, tokens: impl ToTokens, used: impl ToTokens, group: usize) -> Reported {
        let length = self.groups.get(group).and_then(|group| group.length).unwrap_or(1);
        let used = used.to_token_stream().to_string().replace(' ', "");
        self.errors.at(
            tokens,
            format!(
                "expected one of the {length} coordinates of this array, `{used}[0]` to `{used}[{}]`",
                length - 1
            ),
        )
    }

    /// The coordinate at an index of an array.
    pub(crate) fn element(&self, group: usize, index: &Expr) -> Result<usize, Reported> {
        let Some((group, length)) = self
            .groups
            .get(group)
            .and_then(|group| Some((group, group.length?)))
        else {
            return Err(self.errors.at(index, "expected an array of coordinates"));
        };
        let value = self.known_integer(index)?;
        match usize::try_from(value) {
            Ok(place) if place < length => Ok(group.first + place),
            _ => Err(self.out_of_range(index, value, &format!("`{}`", group.name), length)),
        }
    }

    /// The value of an integer expression; an error if it is not known.
    pub(crate) fn known_integer(&self, expr: &Expr) -> Result<i64, Reported> {
        self.integer(expr).ok_or_else(|| {
            let message = self.errors.words(
                "expected an integer that the declaration itself tells: a literal or an index of `sum`, such as `i + 1`",
                "expected a whole number: one that is written here, a constant, `const n = 3;`, or an index, such as `i + 1`",
            );
            self.errors.at(expr, message)
        })
    }

    pub(crate) fn out_of_range(&self, index: &Expr, value: i64, array: &str, length: usize) -> Reported {
        self.errors.at(
            index,
            format!(
                "this index is {value}, but {array} has the length {length}; expected an index from 0 to {}",
                length.saturating_sub(1)
            ),
        )
    }

    /// Reports an index behind something that cannot have one.
    fn check_base(&self, base: &Expr) -> Result<(), Reported> {
        let Some((name, binding)) = plain_name(base).and_then(|name| Some((name, self.scope.get(name)?)))
        else {
            return Ok(());
        };
        let expected = match binding {
            Binding::Let(Ok(Value::Vector(_) | Value::Matrix(_)) | Err(_))
            | Binding::Array(_)
            | Binding::Field(_) => return Ok(()),
            Binding::Rotation(_) | Binding::Let(Ok(Value::Rotation(_))) => {
                return Err(self.errors.at(name, INDEX_OF_ROTATION));
            }
            Binding::Coordinate(_) | Binding::Let(_) | Binding::Index(_) | Binding::NodeTime(_) => {
                "it stands without an index".to_owned()
            }
            Binding::Function(_) => format!("expected parentheses, `{name}(…)`"),
            Binding::Node(_) | Binding::OfMap(_) => {
                format!(
                    "expected a component by the name of its coordinate, such as `{name}.{}`",
                    self.example()
                )
            }
        };
        Err(self
            .errors
            .at(name, format!("`{name}` is {}: {expected}", binding.kind())))
    }

    /// A coordinate for a message, as it would be written.
    fn example(&self) -> String {
        self.groups
            .last()
            .map_or_else(String::new, |group| match group.length {
                Some(_) => format!("{}[0]", group.name),
                None => group.name.to_string(),
            })
    }

    /// Reports an index beyond the length of a field, if its type shows the length.
    fn check_parameter(&self, base: &Expr, index: &Expr) -> Result<(), Reported> {
        let Some(name) = plain_name(base) else {
            return Ok(());
        };
        let length = match self.scope.get(name) {
            Some(Binding::Field(field)) => self.fields.get(*field).and_then(|field| field.length),
            _ => None,
        };
        match (self.integer(index), length) {
            (Some(value), Some(length)) if usize::try_from(value).map_or(true, |place| place >= length) => {
                Err(self.out_of_range(index, value, &format!("`{name}`"), length))
            }
            _ => Ok(()),
        }
    }
}

/// A number as an integer, if it is one and is exact in double precision.
#[allow(clippy::cast_possible_truncation, clippy::float_cmp)] // exactly an integer
fn as_integer(value: f64) -> Option<i64> {
    (value.trunc() == value && value.abs() < 1e15).then_some(value as i64)
}
