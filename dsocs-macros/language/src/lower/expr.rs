//! The meaning of an expression: a node of the graph.

use proc_macro2::Ident;
use quote::ToTokens;
use syn::{BinOp, Block, Expr, ExprField, ExprLit, ExprPath, Lit, Member, Stmt, UnOp};

use crate::graph::Leaf;
use crate::lower::functions::closed::{free, is_circle_constant};
use crate::lower::lowering::{Lowered, Lowering};
use crate::lower::names::Binding;
use crate::lower::names::unknown_names::{is_zero, not_a_number};
use crate::lower::values::{Value, Valued};
use crate::mistakes::errors::Reported;
use crate::mistakes::nearest::nearest;
use crate::parse::plain_let;
use crate::syntax::input::Field;
use crate::syntax::{bare, plain_name};

/// The error for a sign before a rotation.
pub(crate) const SIGN_OF_ROTATION: &str = "a rotation has no sign; expected that of a vector that it turns, `-(r * c)`, or its inverse, `r.inverse()`, which turns back";

/// The operand of a negation; `None` for other expressions.
fn negated(expr: &Expr) -> Option<&Expr> {
    match bare(expr) {
        Expr::Unary(unary) if matches!(unary.op, UnOp::Neg(_)) => Some(&unary.expr),
        _ => None,
    }
}

impl Lowering<'_> {
    /// The value of an expression that has to be a number; in a map, its component [`Lowering::component`].
    pub(crate) fn expr(&mut self, expr: &Expr) -> Lowered {
        let value = self.value(expr)?;
        self.expect_number(expr, &value)
    }

    /// The value of an expression: a number, a vector, a matrix or a rotation.
    pub(crate) fn value(&mut self, expr: &Expr) -> Valued {
        let value = self.value_unchecked(expr)?;
        let mut numbers = value.numbers().into_iter();
        match numbers.find_map(|number| self.graph.not_finite(number)) {
            None => Ok(value),
            Some(number) if number.is_nan() => Err(self.errors.at(
                expr,
                "worked out, this is not a number, as `0 / 0` and the square root of -1 are none; expected a finite number",
            )),
            Some(_) => Err(self.errors.at(
                expr,
                "worked out, this is infinite or has an infinite coefficient; the largest number is about 1.8e308",
            )),
        }
    }

    /// The value, which may have numbers that are not finite.
    fn value_unchecked(&mut self, expr: &Expr) -> Valued {
        let number = match expr {
            Expr::Paren(inner) => return self.value(&inner.expr),
            Expr::Group(inner) => return self.value(&inner.expr),
            Expr::Lit(literal) => self.literal(literal),
            Expr::Path(path) => return self.path(path),
            Expr::Unary(unary) => match unary.op {
                UnOp::Neg(_) => {
                    let value = self.value(&unary.expr)?;
                    if let Value::Rotation(_) = value {
                        return Err(self.errors.at(unary, SIGN_OF_ROTATION));
                    }
                    return value.map(|number| Ok(self.graph.neg(number)));
                }
                UnOp::Deref(_) if self.is_closed(expr) => self.param(expr),
                _ => Err(self
                    .errors
                    .at(unary, "expected a number; the only sign before one is `-`")),
            },
            Expr::Binary(binary) => return self.binary(&binary.left, &binary.op, &binary.right),
            Expr::Block(block) if block.label.is_none() => return self.block(&block.block, Self::value),
            Expr::If(choice) => return self.choice(choice),
            Expr::Call(call) => return self.call(call, expr),
            Expr::MethodCall(call) => return self.method_call(call, expr),
            Expr::Field(field) => self.field(field, expr),
            Expr::Index(index) => return self.index(index, expr),
            Expr::Array(array) if self.component.is_none() => {
                let elements: Vec<_> = array.elems.iter().map(|element| self.value(element)).collect();
                let elements = elements.into_iter().collect::<Result<_, _>>()?;
                return self.vector_or_matrix(expr, elements);
            }
            Expr::Repeat(repeat) if self.component.is_none() => {
                let (element, count) = (self.value(&repeat.expr), self.known_integer(&repeat.len));
                let (element, count) = (element?, count?);
                let Some(count) = usize::try_from(count).ok().filter(|&count| count <= LONGEST) else {
                    let message = format!("expected a length of at most {LONGEST}");
                    return Err(self.errors.at(&repeat.len, message));
                };
                return self.vector_or_matrix(expr, vec![element; count]);
            }
            Expr::Cast(cast) => {
                if self.is_closed(expr) {
                    return self.param(expr).map(Value::Number);
                }
                Err(self.errors.at(
                    cast,
                    "every expression is a number already; expected it without `as`",
                ))
            }
            Expr::Assign(assign) => Err(self.equation(assign.eq_token, &assign.right)),
            other => Err(self.errors.at(other, not_a_number(other, self.errors))),
        };
        number.map(Value::Number)
    }

    /// An expression of the parameters alone, as a node.
    pub(crate) fn param(&mut self, expr: &Expr) -> Lowered {
        let tokens = self.closed(expr)?;
        Ok(self.graph.param(tokens))
    }

    fn literal(&mut self, literal: &ExprLit) -> Lowered {
        let (digits, suffix) = match &literal.lit {
            Lit::Int(number) => (number.base10_digits(), number.suffix()),
            Lit::Float(number) => (number.base10_digits(), number.suffix()),
            other => return Err(self.errors.at(other, "expected a number")),
        };
        if !matches!(suffix, "" | "f64") {
            return Err(self.errors.at(literal, self.suffix(digits, suffix)));
        }
        match digits.parse() {
            Ok(value) if f64::is_finite(value) => Ok(self.graph.constant(value)),
            Ok(_) => {
                let message = self.errors.words(
                    "this number is larger than any `f64`",
                    "this number is too large; the largest one is about 1.8e308",
                );
                Err(self.errors.at(literal, message))
            }
            Err(_) => Err(self.errors.at(literal, "expected a number")),
        }
    }

    /// The error for a suffix right behind a number.
    fn suffix(&self, digits: &str, suffix: &str) -> String {
        if !self.errors.are_of_text() {
            return format!("every number is an `f64`; expected it without the suffix `{suffix}`");
        }
        let is_known = Ident::new(suffix, proc_macro2::Span::call_site());
        if self.scope.get(&is_known).is_some() || suffix == "t" || is_circle_constant(&is_known) {
            return format!("a product is written with `*`: expected `{digits} * {suffix}`");
        }
        if matches!(suffix, "deg" | "degrees") {
            return format!("angles are in radians: expected `{digits} * pi / 180`");
        }
        format!(
            "a number has no unit: expected `{digits}` alone (`/// … [{suffix}]` above a parameter says its unit)"
        )
    }

    fn path(&mut self, path: &ExprPath) -> Valued {
        let name = match path.path.get_ident() {
            Some(name) if path.qself.is_none() => name,
            _ if self.fields.have_compiler() => {
                return Ok(Value::Number(self.graph.param(path.to_token_stream())));
            }
            _ => match path.path.segments.last() {
                // `std::f64::consts::PI` is read as in Rust
                Some(last) if is_circle_constant(&last.ident) && path.qself.is_none() => &last.ident,
                _ => return Err(self.needs_compiler(path)),
            },
        };
        let node = match self.scope.get(name) {
            Some(Binding::Field(index)) => {
                let Some(field) = self.fields.get(*index) else {
                    return Err(self.unknown_name(name));
                };
                if self.component.is_none() && !field.shape().is_empty() {
                    return self.parameters(name, field.shape());
                }
                if self.is_table_at(*index) {
                    return Err(self.whole_table(name));
                }
                let tokens = field.number(name, self.errors)?;
                self.graph.param(tokens)
            }
            Some(&Binding::Index(value)) => self.graph.constant(value as f64),
            Some(Binding::Array(_)) if self.component.is_some() => return Err(self.motion_in_map(path, path)),
            Some(&Binding::Array(group)) if self.discrete.is_some() => {
                return Err(self.whole_array(path, path, group));
            }
            Some(&Binding::Array(group)) => return Ok(self.coordinates_of(group)),
            Some(Binding::Rotation(_)) if self.component.is_some() || self.discrete.is_some() => {
                return Err(self.errors.at(
                    path,
                    "a rotation stands in expressions of the motion alone, so far",
                ));
            }
            Some(&Binding::Rotation(group)) => return Ok(self.rotation(group)),
            Some(Binding::Function(_)) => {
                return Err(self.errors.at(
                    name,
                    format!("`{name}` is a function; expected its arguments, `{name}(…)`"),
                ));
            }
            Some(Binding::Coordinate(_)) if self.component.is_some() => {
                return Err(self.motion_in_map(name, name));
            }
            Some(Binding::Coordinate(_)) if self.discrete.is_some() => {
                return Err(self.motion_among_nodes(name, true));
            }
            Some(Binding::Let(Ok(value)))
                if self.discrete.is_some()
                    && (value.numbers().into_iter()).any(|node| {
                        self.graph.order(node).is_some() || self.graph.depends_on(node, Leaf::T)
                    }) =>
            {
                return Err(self.motion_among_nodes(name, false));
            }
            Some(Binding::Let(_)) if self.component.is_some() => {
                return Err(self.errors.at(
                    name,
                    format!(
                        "a map knows the nodes, not the motion, and `{name}` is an expression of the motion; \
                         expected it written out in terms of the nodes"
                    ),
                ));
            }
            Some(&Binding::Coordinate(index)) => self.graph.leaf(Leaf::Q(index)),
            Some(Binding::Let(Ok(value))) => {
                let value = value.clone();
                for node in value.numbers() {
                    self.record_derivative(path, node);
                }
                return Ok(value);
            }
            Some(Binding::OfMap(Ok(nodes))) => match nodes.get(self.component.unwrap_or(0)) {
                Some(&node) => node,
                None => return Err(self.unknown_name(name)),
            },
            Some(Binding::Let(Err(reported)) | Binding::OfMap(Err(reported))) => return Err(*reported),
            Some(&Binding::Node(node)) => {
                let leaf = node_leaf(node, self.component.unwrap_or(0));
                self.graph.leaf(leaf)
            }
            Some(&Binding::NodeTime(node)) => self.graph.leaf(node_time(node)),
            None if name == "t" => self.time(name)?,
            None if name == "h" && (self.component.is_some() || self.discrete.is_some()) => {
                self.graph.leaf(Leaf::H)
            }
            None => {
                if !is_circle_constant(name) {
                    self.check_free_name(name)?;
                }
                self.graph.param(free(name, self.fields.have_compiler()))
            }
        };
        Ok(Value::Number(node))
    }

    /// A vector or a matrix of parameters.
    fn parameters(&mut self, name: &Ident, shape: &[usize]) -> Valued {
        let mut element = |indices: &[usize]| self.graph.param(Field::element(name, indices));
        match *shape {
            [length] if length > 0 => Ok(Value::Vector((0..length).map(|i| element(&[i])).collect())),
            [rows, columns] if rows * columns > 0 => {
                let row = |i| (0..columns).map(|j| element(&[i, j])).collect();
                Ok(Value::Matrix((0..rows).map(row).collect()))
            }
            _ => Err(self
                .errors
                .at(name, "expected at least one element in this array")),
        }
    }

    /// A whole array of coordinates, as a vector.
    fn coordinates_of(&mut self, group: usize) -> Value {
        let (first, length) = self
            .groups
            .get(group)
            .map_or((0, 0), |group| (group.first, group.length.unwrap_or(1)));
        let places = first..first + length;
        Value::Vector(places.map(|place| self.graph.leaf(Leaf::Q(place))).collect())
    }

    /// The time `t`.
    fn time(&mut self, name: &Ident) -> Lowered {
        if self.component.is_some() {
            return Err(self.errors.at(
                name,
                "a map knows the nodes, not the motion; expected the time of a node, which has a name where the nodes are named with \
                 their times: `|t0, q0, t1, q1| (t, q, v)`",
            ));
        }
        if self.discrete.is_some() {
            return Err(self.motion_among_nodes(name, true));
        }
        Ok(self.graph.leaf(Leaf::T))
    }

    pub(crate) fn unknown_name(&self, name: &Ident) -> Reported {
        self.errors.at(name, format!("no name `{name}` is known here"))
    }

    fn binary(&mut self, left: &Expr, op: &BinOp, right: &Expr) -> Valued {
        if let BinOp::Mul(star) = op
            && let Some(reported) = self.power(star, right)
        {
            return self.value(left).and(Err(reported));
        }
        let right_side = right;
        if let (BinOp::Mul(_), Some(operand)) = (op, negated(left)) {
            // the sign binds tighter than the product: `-r * c` negates the turned vector
            let operand = self.value(operand);
            if let Ok(Value::Rotation(r)) = operand {
                let right = self.value(right)?;
                return self.negated_and_rotated(op, left, r, &right);
            }
            let operand = operand.and_then(|value| value.map(|number| Ok(self.graph.neg(number))));
            let right = self.value(right);
            return self.product(op, &operand?, &right?);
        }
        let (left, right) = (self.value(left), self.value(right));
        let message = match op {
            BinOp::Add(_) | BinOp::Sub(_) => return self.sum_or_difference(op, &left?, &right?),
            BinOp::Mul(_) => return self.product(op, &left?, &right?),
            BinOp::Div(_) => return self.quotient(op, &left?, &right?),
            BinOp::Eq(equals) if is_zero(right_side) => return Err(self.equation(equals, right_side)),
            BinOp::BitXor(_) if !self.fields.have_compiler() => {
                "`^` is no power here; expected `.powi(2)` or `.powf(a)`"
            }
            BinOp::BitXor(_) => "`^` is no power in Rust; expected `.powi(2)` or `.powf(a)`",
            BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) | BinOp::Eq(_) | BinOp::Ne(_) => {
                "expected a number; a comparison stands in the condition of `if … { … } else { … }` only"
            }
            BinOp::BitAnd(_) | BinOp::BitOr(_) | BinOp::And(_) | BinOp::Or(_) => {
                "expected a number; `&&` and `||` stand between comparisons, in the condition of `if … { … } else { … }`"
            }
            _ => "expected one of the operators `+`, `-`, `*`, `/`",
        };
        Err(self.errors.at(op, message))
    }

    /// A block: its `let`s, then `tail` of its last expression.
    pub(crate) fn block<T>(
        &mut self,
        block: &Block,
        tail: impl FnOnce(&mut Self, &Expr) -> Result<T, Reported>,
    ) -> Result<T, Reported> {
        let outer = self.scope.len();
        let Some((Stmt::Expr(last, None), statements)) = block.stmts.split_last() else {
            return Err(self.errors.at(
                block,
                "expected a block that ends with an expression, without `;`",
            ));
        };
        let mut wrong = None;
        for statement in statements {
            let Stmt::Local(local) = statement else {
                wrong = Some(self.errors.at(statement, "expected `let name = …;`"));
                continue;
            };
            let (name, value) = match plain_let(local.clone(), self.errors) {
                Ok(parts) => parts,
                Err(reported) => {
                    wrong = Some(reported);
                    continue;
                }
            };
            let binding = self.binding(&value);
            wrong = self.scope.define(&name, binding, self.errors).err().or(wrong);
        }
        let value = tail(self, last);
        self.scope.truncate(outer);
        wrong.map_or(value, Err)
    }

    fn field(&mut self, field: &ExprField, whole: &Expr) -> Lowered {
        if let (Some(module), Member::Named(name)) = (self.module(&field.base), &field.member) {
            return Err(self.constant_of_module(module, name));
        }
        if self.is_closed(whole) {
            if let Some(name) = plain_name(&field.base).filter(|name| *name == "self") {
                let member = field.member.to_token_stream();
                return Err(self.errors.at(
                    name,
                    format!("expected `{member}`: a parameter stands without `self`"),
                ));
            }
            return self.param(whole);
        }
        if self.is_of_map(&field.base) {
            let component = self.coordinate(field)?;
            return self.component_of(&field.base, component);
        }
        let value = self.value(&field.base);
        value.and_then(|value| {
            if let (Value::Rotation(_), Member::Named(name)) = (&value, &field.member) {
                return Err(self.field_of_rotation(name));
            }
            if let Member::Named(name) = &field.member
                && self.component.is_none()
                && let Some(reported) = self.method_without_call(name)
            {
                return Err(reported);
            }
            let message = if self.component.is_some() {
                "expected a coordinate of a node, such as `q0.x`; this is no node"
            } else {
                self.errors.words(
                    "expected a number, which has no fields; the velocity is written `dot(x)`",
                    "a number has no parts; the velocity is written `dot(x)`",
                )
            };
            Err(self.errors.at(&field.member, message))
        })
    }

    /// Whether an expression is the name of a node, or of a `let` in a map.
    pub(crate) fn is_of_map(&self, expr: &Expr) -> bool {
        plain_name(bare(expr))
            .and_then(|name| self.scope.get(name))
            .is_some_and(|binding| matches!(binding, Binding::Node(_) | Binding::OfMap(_)))
    }

    /// One component of a vector in a map.
    pub(crate) fn component_of(&mut self, vector: &Expr, component: usize) -> Lowered {
        let outer = self.component.replace(component);
        let value = self.expr(vector);
        self.component = outer;
        value
    }

    /// The error for a coordinate in a map.
    pub(crate) fn motion_in_map(&self, tokens: impl ToTokens, coordinate: impl ToTokens) -> Reported {
        let coordinate = coordinate.to_token_stream().to_string().replace(' ', "");
        self.errors.at(
            tokens,
            format!("a map knows the nodes, not the motion; expected a coordinate of a node, such as `q0.{coordinate}`"),
        )
    }

    fn coordinate(&self, field: &ExprField) -> Result<usize, Reported> {
        let n = self.coordinates.len();
        if let Member::Named(name) = &field.member
            && let Some(group) = self.array(name)
        {
            return Err(self.whole_array(name, field, group));
        }
        match &field.member {
            Member::Named(name) => self
                .coordinates
                .iter()
                .position(|known| known == name)
                .ok_or_else(|| {
                    let names: Vec<_> = self.coordinates.iter().map(ToString::to_string).collect();
                    let message = match nearest(&name.to_string(), names.iter().map(String::as_str)) {
                        Some(near) => format!("no coordinate is called `{name}`; did you mean `{near}`?"),
                        None => format!(
                            "no coordinate is called `{name}`; expected one of `{}`",
                            names.join("`, `")
                        ),
                    };
                    self.errors.at(name, message)
                }),
            Member::Unnamed(index) if (index.index as usize) < n => Ok(index.index as usize),
            Member::Unnamed(index) => Err(self.errors.at(
                index,
                format!("expected a coordinate's index, from 0 to {}", n - 1),
            )),
        }
    }
}

/// The most components of a vector `[a; n]`.
const LONGEST: usize = 1000;

/// The time of a node, as a leaf.
fn node_time(node: usize) -> Leaf {
    match node {
        0 => Leaf::T0,
        1 => Leaf::T1,
        _ => Leaf::T2,
    }
}

/// A component of a node, as a leaf.
fn node_leaf(node: usize, component: usize) -> Leaf {
    match node {
        0 => Leaf::X0(component),
        1 => Leaf::X1(component),
        _ => Leaf::X2(component),
    }
}
