//! Vectors and matrices: sums, products, lengths.

use proc_macro2::Ident;
use quote::ToTokens;
use syn::{BinOp, Expr, ExprMethodCall};

use crate::graph::{Graph, NodeId, Unary};
use crate::lower::lowering::{Lowered, Lowering};
use crate::lower::names::Binding;
use crate::lower::names::foreign_names::vector_method;
use crate::lower::values::{Value, Valued};
use crate::mistakes::errors::Reported;
use crate::mistakes::nearest::did_you_mean;
use crate::syntax::{bare, plain_name};

/// The names of the methods of vectors and matrices.
const METHODS: [&str; 5] = ["inner", "cross", "norm", "norm_squared", "transpose"];

/// The names of the methods of rotations.
pub(crate) const ROTATION_METHODS: [&str; 3] = ["inverse", "angular_velocity", "matrix"];

/// Whether vectors or matrices have a method of that name.
pub(crate) fn is_vector_method(name: &str) -> bool {
    METHODS.contains(&name)
}

impl Lowering<'_> {
    /// The number of a value; an error at `expr` for other values.
    pub(crate) fn expect_number(&self, expr: &Expr, value: &Value) -> Lowered {
        let length = match value {
            Value::Number(number) => return Ok(*number),
            Value::Vector(components) => components.len(),
            Value::Matrix(rows) => rows.len(),
            Value::Rotation(_) => {
                let message = "expected a number, found a rotation; a rotation turns vectors, `r * c`, `r.inverse() * c`, and its body turns with \
                               `r.angular_velocity()`";
                return Err(self.errors.at(expr, message));
            }
        };
        let name = plain_name(bare(expr)).map_or_else(|| "(…)".to_owned(), ToString::to_string);
        let last = length.saturating_sub(1);
        let message = match value {
            Value::Matrix(_) => format!(
                "expected a number, found {}; its elements are `{name}[0][0]` and so on",
                value.kind()
            ),
            _ => format!(
                "expected a number, found {}; expected one of them, `{name}[0]` to `{name}[{last}]`, or what a vector gives, `{name}.norm()`, \
                 `{name}.inner(b)`",
                value.kind()
            ),
        };
        Err(self.errors.at(expr, message))
    }

    /// `[a, b, c]`: of numbers a vector, of vectors a matrix.
    pub(crate) fn vector_or_matrix(&self, expr: &Expr, elements: Vec<Value>) -> Valued {
        let numbers: Option<Vec<NodeId>> = elements.iter().map(Value::number).collect();
        match numbers {
            Some(numbers) if !numbers.is_empty() => return Ok(Value::Vector(numbers)),
            Some(_) => {
                return Err(self
                    .errors
                    .at(expr, "expected at least one component between the brackets"));
            }
            None => {}
        }
        let mut rows: Vec<Vec<NodeId>> = Vec::new();
        for element in elements {
            match element {
                Value::Vector(row) if rows.first().is_none_or(|first| first.len() == row.len()) => {
                    rows.push(row);
                }
                _ => {
                    let message = "expected numbers, the components of a vector, or vectors of the same length, the rows of a matrix";
                    return Err(self.errors.at(expr, message));
                }
            }
        }
        Ok(Value::Matrix(rows))
    }

    /// `a + b` or `a - b`
    pub(crate) fn sum_or_difference(&mut self, op: &BinOp, left: &Value, right: &Value) -> Valued {
        let is_sum = matches!(op, BinOp::Add(_));
        let mut both = |a: &[NodeId], b: &[NodeId]| -> Vec<NodeId> {
            let pairs = a.iter().zip(b);
            pairs
                .map(|(&a, &b)| {
                    if is_sum {
                        self.graph.add(a, b)
                    } else {
                        self.graph.sub(a, b)
                    }
                })
                .collect()
        };
        match (left, right) {
            (Value::Number(a), Value::Number(b)) => Ok(Value::Number(both(&[*a], &[*b])[0])),
            (Value::Vector(a), Value::Vector(b)) if a.len() == b.len() => Ok(Value::Vector(both(a, b))),
            (Value::Matrix(a), Value::Matrix(b)) if a.len() == b.len() && width(a) == width(b) => {
                Ok(Value::Matrix(a.iter().zip(b).map(|(a, b)| both(a, b)).collect()))
            }
            (Value::Rotation(_), Value::Rotation(_)) => {
                let message = if is_sum {
                    "rotations are multiplied, not added: expected `r * s`, found a rotation and a rotation"
                } else {
                    "rotations are multiplied, not subtracted: expected `r.inverse() * s`, the turn from `r` to `s`, found a rotation and a rotation"
                };
                Err(self.errors.at(op, message))
            }
            _ => {
                let (left, right) = (left.kind(), right.kind());
                let sign = op.to_token_stream();
                let message = format!(
                    "expected the same on both sides of `{sign}`, found {left} and {right}: numbers are added to numbers, vectors to vectors of the same \
                     length"
                );
                Err(self.errors.at(op, message))
            }
        }
    }

    /// `a * b`
    pub(crate) fn product(&mut self, op: &BinOp, left: &Value, right: &Value) -> Valued {
        match (left, right) {
            (Value::Number(a), Value::Number(b)) => Ok(Value::Number(self.graph.mul(*a, *b))),
            (other @ (Value::Number(_) | Value::Vector(_) | Value::Matrix(_)), Value::Rotation(_)) => {
                let message = format!(
                    "expected the rotation on the left of what it turns, `r * c`, found {} on its left",
                    other.kind()
                );
                Err(self.errors.at(op, message))
            }
            (Value::Rotation(r), b) => self.rotation_product(op, *r, b),
            (Value::Number(a), b) => self.scaled(b, |graph, component| graph.mul(*a, component)),
            (a, Value::Number(b)) => self.scaled(a, |graph, component| graph.mul(component, *b)),
            (Value::Matrix(a), Value::Vector(b)) if width(a) == b.len() => Ok(Value::Vector(
                a.iter().map(|row| inner(&mut self.graph, row, b)).collect(),
            )),
            (Value::Matrix(a), Value::Matrix(b)) if width(a) == b.len() => {
                let columns = transposed(b);
                let row = |row: &Vec<NodeId>| -> Vec<NodeId> {
                    columns
                        .iter()
                        .map(|column| inner(&mut self.graph, row, column))
                        .collect()
                };
                Ok(Value::Matrix(a.iter().map(row).collect()))
            }
            (Value::Vector(_), Value::Vector(_)) => Err(self.errors.at(
                op,
                "vectors have several products: expected `a.inner(b)`, a number, or `a.cross(b)`, a vector",
            )),
            (Value::Vector(_), Value::Matrix(_)) => Err(self.errors.at(
                op,
                "expected the matrix on the left of the vector, `m * v`, or `m.transpose() * v`",
            )),
            (a, b) => {
                let message = format!(
                    "expected as many columns on the left as components or rows on the right, found {} and {}",
                    a.kind(),
                    b.kind()
                );
                Err(self.errors.at(op, message))
            }
        }
    }

    /// `a / b`
    pub(crate) fn quotient(&mut self, op: &BinOp, left: &Value, right: &Value) -> Valued {
        if let Value::Rotation(_) = left {
            return Err(self
                .errors
                .at(op, "a rotation is not divided; its inverse is `r.inverse()`"));
        }
        let Value::Number(b) = right else {
            let message = format!("expected a number behind `/`, found {}", right.kind());
            return Err(self.errors.at(op, message));
        };
        self.scaled(left, |graph, component| graph.div(component, *b))
    }

    /// A value with a factor applied to each component.
    fn scaled(&mut self, value: &Value, mut by: impl FnMut(&mut Graph, NodeId) -> NodeId) -> Valued {
        value.map(|component| Ok(by(&mut self.graph, component)))
    }

    /// The value of a method that only vectors, matrices and rotations have; `None` if the method is that of
    /// a user's type.
    pub(crate) fn method_of_vectors(&mut self, call: &ExprMethodCall) -> Option<Valued> {
        let name = call.method.to_string();
        let of_rotations = !self.graph.rotations().is_empty() && ROTATION_METHODS.contains(&name.as_str());
        if self.component.is_some() || !(is_vector_method(&name) || of_rotations) {
            return None;
        }
        let is_own =
            self.fields.have_compiler() && self.is_closed(&call.receiver) && self.rank(&call.receiver) == 0;
        if is_own {
            return None;
        }
        Some(self.of_vectors(call))
    }

    fn of_vectors(&mut self, call: &ExprMethodCall) -> Valued {
        let name = &call.method;
        let receiver = self.value(&call.receiver);
        let arguments: Vec<Valued> = call.args.iter().map(|argument| self.value(argument)).collect();
        let receiver = receiver?;
        let arguments: Vec<Value> = arguments.into_iter().collect::<Result<_, _>>()?;
        let text = name.to_string();
        let expected = usize::from(matches!(text.as_str(), "inner" | "cross"));
        if arguments.len() != expected {
            let expected = ["no argument", "1 argument"][expected];
            let found = arguments.len();
            let message = format!("expected {expected} in the parentheses of `{name}`, found {found}");
            return Err(self.errors.at(name, message));
        }
        match (text.as_str(), receiver, arguments.first()) {
            (_, Value::Rotation(r), _) => self.of_rotation(name, r),
            ("transpose", Value::Matrix(rows), _) => Ok(Value::Matrix(transposed(&rows))),
            ("transpose", other, _) => {
                let message = format!("expected a matrix before `.transpose()`, found {}", other.kind());
                Err(self.errors.at(name, message))
            }
            ("norm", Value::Vector(a), _) => {
                let square = inner(&mut self.graph, &a, &a);
                Ok(Value::Number(self.graph.unary(Unary::Sqrt, square)))
            }
            ("norm_squared", Value::Vector(a), _) => Ok(Value::Number(inner(&mut self.graph, &a, &a))),
            ("inner", Value::Vector(a), Some(Value::Vector(b))) if a.len() == b.len() => {
                Ok(Value::Number(inner(&mut self.graph, &a, b)))
            }
            ("cross", Value::Vector(a), Some(Value::Vector(b))) if a.len() == 3 && b.len() == 3 => {
                Ok(Value::Vector(cross(&mut self.graph, &a, b)))
            }
            (word, receiver, _) if ROTATION_METHODS.contains(&word) => {
                let message = format!(
                    "expected a rotation before `.{name}()`, found {}",
                    receiver.kind()
                );
                Err(self.errors.at(name, message))
            }
            (_, receiver @ (Value::Number(_) | Value::Matrix(_)), _) => Err(self.before(name, &receiver)),
            (word, receiver, argument) => {
                let what = if word == "cross" {
                    "two vectors of 3 components"
                } else {
                    "two vectors of the same length"
                };
                let found = argument.map_or_else(String::new, Value::kind);
                let message = format!("`{word}` is of {what}, found {} and {found}", receiver.kind());
                Err(self.errors.at(name, message))
            }
        }
    }

    /// The error for a receiver that does not have this method of vectors.
    fn before(&self, name: &Ident, receiver: &Value) -> Reported {
        let own = if self.fields.have_compiler() {
            format!(
                " (a method of your own of this name is called by the path of its trait, `Trait::{name}(…)`)"
            )
        } else {
            String::new()
        };
        let message = format!(
            "expected a vector before `.{name}(…)`, found {}{own}",
            receiver.kind()
        );
        self.errors.at(name, message)
    }

    /// The error for a method that vectors and matrices do not have.
    pub(crate) fn no_method_of_vectors(&self, name: &Ident, value: &Value) -> Reported {
        let text = name.to_string();
        if let Value::Rotation(_) = value {
            return self.no_method_of_rotation(name);
        }
        let hint = match vector_method(&text) {
            Some(meant) => format!("; expected `.{meant}`"),
            None => did_you_mean(&text, METHODS),
        };
        let message = format!(
            "expected a number before `.{name}(…)`, found {}{hint}",
            value.kind()
        );
        self.errors.at(name, message)
    }

    /// The component of a vector, or the row of a matrix, at an index.
    pub(crate) fn component(&self, value: &Value, base: &Expr, index: &Expr) -> Valued {
        let length = match value {
            Value::Number(_) | Value::Rotation(_) => 0,
            Value::Vector(components) => components.len(),
            Value::Matrix(rows) => rows.len(),
        };
        let place = self.known_integer(index)?;
        let component = usize::try_from(place).ok().and_then(|place| match value {
            Value::Number(_) | Value::Rotation(_) => None,
            Value::Vector(components) => components.get(place).copied().map(Value::Number),
            Value::Matrix(rows) => rows.get(place).cloned().map(Value::Vector),
        });
        component.ok_or_else(|| {
            let name = plain_name(bare(base)).map_or_else(|| "this".to_owned(), |name| format!("`{name}`"));
            self.out_of_range(index, place, &name, length)
        })
    }

    /// The number of indices that can follow an expression, as far as its syntax shows.
    pub(crate) fn rank(&self, expr: &Expr) -> usize {
        match bare(expr) {
            Expr::Array(array) => 1 + array.elems.first().map_or(0, |first| self.rank(first)),
            Expr::Repeat(repeat) => 1 + self.rank(&repeat.expr),
            Expr::Path(_) => match plain_name(bare(expr)).and_then(|name| self.scope.get(name)) {
                Some(Binding::Array(_)) => 1,
                Some(Binding::Let(Ok(value))) => value.rank(),
                Some(Binding::Field(field)) => self.fields.get(*field).map_or(0, |field| field.shape().len()),
                _ => 0,
            },
            Expr::Unary(unary) => self.rank(&unary.expr),
            Expr::Index(index) => self.rank(&index.expr).saturating_sub(1),
            Expr::Binary(binary) => match (self.rank(&binary.left), self.rank(&binary.right)) {
                (2, 1) if matches!(binary.op, BinOp::Mul(_)) => 1,
                (left, right) => left.max(right),
            },
            Expr::MethodCall(call) => match call.method.to_string().as_str() {
                "cross" | "transpose" => self.rank(&call.receiver),
                _ => 0,
            },
            _ => 0,
        }
    }
}

/// The number of columns of a matrix.
fn width(rows: &[Vec<NodeId>]) -> usize {
    rows.first().map_or(0, Vec::len)
}

fn transposed(rows: &[Vec<NodeId>]) -> Vec<Vec<NodeId>> {
    let column = |i: usize| rows.iter().filter_map(|row| row.get(i).copied()).collect();
    (0..width(rows)).map(column).collect()
}

/// `a₀ b₀ + a₁ b₁ + …`
fn inner(graph: &mut Graph, a: &[NodeId], b: &[NodeId]) -> NodeId {
    let products: Vec<NodeId> = a.iter().zip(b).map(|(&a, &b)| graph.mul(a, b)).collect();
    graph.sum(&products)
}

/// `a × b`
fn cross(graph: &mut Graph, a: &[NodeId], b: &[NodeId]) -> Vec<NodeId> {
    [(1, 2), (2, 0), (0, 1)]
        .into_iter()
        .map(|(i, j)| {
            let (left, right) = (graph.mul(a[i], b[j]), graph.mul(a[j], b[i]));
            graph.sub(left, right)
        })
        .collect()
}
