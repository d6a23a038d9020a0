//! Vectors in the shape of the coordinates: `(u, v, [a, b, c])` for `(x, y, theta: [3])`.

use syn::{Expr, ExprClosure};

use crate::graph::NodeId;
use crate::lower::lowering::Lowering;
use crate::lower::values::Value;
use crate::mistakes::errors::Reported;
use crate::syntax::ast::Group;
use crate::syntax::bare;

/// A component, as written or computed.
#[derive(Clone)]
enum Entry<'e> {
    /// An expression.
    Value(&'e Expr),
    /// `|i| …` at an index.
    At(&'e ExprClosure, i64),
    /// A component of a vector that is known.
    Known(NodeId),
}

impl Lowering<'_> {
    /// The components of a vector, written as a tuple or, for a single group, as its one component or list.
    pub(crate) fn entries(&mut self, whole: &Expr) -> Result<Vec<NodeId>, Reported> {
        let entries = self.flatten(whole)?;
        let lower = |(i, entry): (usize, Entry)| {
            if self.component.is_some() {
                self.component = Some(i);
            }
            match entry {
                Entry::Value(value) => self.expr(value),
                Entry::At(closure, index) => {
                    let value = self.value_at_index(closure, index)?;
                    self.expect_number(&closure.body, &value)
                }
                Entry::Known(component) => Ok(component),
            }
        };
        let entries: Vec<_> = entries.into_iter().enumerate().map(lower).collect();
        entries.into_iter().collect()
    }

    /// The components one by one.
    fn flatten<'e>(&mut self, whole: &'e Expr) -> Result<Vec<Entry<'e>>, Reported> {
        let n = self.coordinates.len();
        let parts: Vec<&Expr> = match bare(whole) {
            Expr::Tuple(tuple) => tuple.elems.iter().collect(),
            other => vec![other],
        };
        if parts.len() == self.groups.len() {
            let groups = self.groups.iter().zip(parts);
            let lists: Vec<_> = groups.map(|(group, part)| self.list(group, part)).collect();
            let lists: Vec<_> = lists.into_iter().collect::<Result<_, _>>()?;
            return Ok(lists.into_iter().flatten().collect());
        }
        if parts.len() == n && self.graph.rotations().is_empty() {
            return Ok(parts.into_iter().map(Entry::Value).collect());
        }
        // a single vector of all components
        if self.graph.rotations().is_empty()
            && let ([one], None) = (parts.as_slice(), self.component)
            && !matches!(bare(one), Expr::Closure(_) | Expr::Array(_) | Expr::Repeat(_))
            && let Value::Vector(components) = self.value(one)?
            && components.len() == n
        {
            return Ok(components.into_iter().map(Entry::Known).collect());
        }
        let message = if self.component.is_some() {
            format!(
                "expected {n} components, one for each coordinate, found {}",
                parts.len()
            )
        } else {
            if !self.graph.rotations().is_empty() {
                return Err(self.errors.at(whole, self.entries_beside_rotations(parts.len())));
            }
            let names = self.groups.iter().map(|group| match group.length {
                Some(length) => format!("`{}: [{length}]`", group.name),
                None => format!("`{}`", group.name),
            });
            format!(
                "expected {} with a component for each of the coordinates {}: {n} components, found {}",
                self.errors.words("a tuple", "a list in parentheses"),
                names.collect::<Vec<_>>().join(", "),
                parts.len()
            )
        };
        Err(self.errors.at(whole, message))
    }

    /// The error for a vector without an entry for each coordinate, array or rotation. The entry of a
    /// rotation is a vector.
    fn entries_beside_rotations(&self, found: usize) -> String {
        let names = self.groups.iter().map(|group| match group.length {
            Some(length) => format!("`{}: [{length}]`", group.name),
            None if group.is_rotation => format!("`{}: rotation`", group.name),
            None => format!("`{}`", group.name),
        });
        let names = names.collect::<Vec<_>>().join(", ");
        let kinds = self.groups.iter().map(|group| match group.length {
            Some(3) => "[a, b, c]",
            Some(_) => "[a, b, …]",
            None if group.is_rotation => "[a, b, c]",
            None => "a",
        });
        let kinds = kinds.collect::<Vec<_>>().join(", ");
        match self.groups.len() {
            1 => format!("expected a vector for the rotation {names}, `{kinds}`, found {found} entries"),
            expected => format!(
                "expected {} with an entry for each of {names}: {expected} entries, `({kinds})`, found {found}",
                self.errors.words("a tuple", "a list in parentheses")
            ),
        }
    }

    /// The components for a rotation: a vector of three in the frame of its body, or zero.
    fn body_vector<'e>(&mut self, group: &Group, part: &'e Expr) -> Result<Vec<Entry<'e>>, Reported> {
        let zero = self.graph.constant(0.0);
        let components = match self.value(part)? {
            Value::Vector(components) if components.len() == 3 => components,
            Value::Number(number) if self.graph.is_zero(number) => vec![zero; 3],
            value => {
                let message = format!(
                    "expected the three components that belong to the rotation `{}`, a vector in the frame of its body, `[a, b, c]`, or 0; found {}",
                    group.name,
                    value.kind()
                );
                return Err(self.errors.at(part, message));
            }
        };
        // zero in the first slot, that of the particle at rest
        let all = [zero].into_iter().chain(components);
        Ok(all.map(Entry::Known).collect())
    }

    /// The components of one coordinate or array of coordinates.
    fn list<'e>(&mut self, group: &Group, part: &'e Expr) -> Result<Vec<Entry<'e>>, Reported> {
        if group.is_rotation {
            return self.body_vector(group, part);
        }
        let Some(length) = group.length else {
            return Ok(vec![Entry::Value(part)]);
        };
        let found = match bare(part) {
            Expr::Array(array) if array.elems.len() == length => {
                return Ok(array.elems.iter().map(Entry::Value).collect());
            }
            Expr::Array(array) => array.elems.len().to_string(),
            Expr::Repeat(repeat) => {
                let found = self.known_integer(&repeat.len)?;
                if usize::try_from(found).is_ok_and(|found| found == length) {
                    return Ok((0..length).map(|_| Entry::Value(&repeat.expr)).collect());
                }
                found.to_string()
            }
            Expr::Closure(closure) if closure.inputs.len() == 1 => {
                self.check_parameters(closure)?;
                return Ok((0_i64..).take(length).map(|i| Entry::At(closure, i)).collect());
            }
            // in a map it is a vector with the components of the array
            other if self.component.is_some() => {
                return Ok((0..length).map(|_| Entry::Value(other)).collect());
            }
            other => match self.value(other)? {
                Value::Vector(components) if components.len() == length => {
                    return Ok(components.into_iter().map(Entry::Known).collect());
                }
                Value::Number(number) if length == 1 => return Ok(vec![Entry::Known(number)]),
                Value::Number(number) if self.graph.is_zero(number) => {
                    return Ok(vec![Entry::Known(number); length]);
                }
                value => value.kind(),
            },
        };
        Err(self.errors.at(
            part,
            format!(
                "expected the {length} components of `{}`: a vector, `[a, b, …]`, `[a; {length}]` or `|i| …`, or 0, \
                 found {found}",
                group.name
            ),
        ))
    }
}
