//! Operations of rotations, and statements that a declaration may not have beside them.

use proc_macro2::Ident;
use syn::{BinOp, Expr};

use crate::graph::calculus::rotation::Quaternion;
use crate::graph::{Leaf, NodeId};
use crate::lower::expr::SIGN_OF_ROTATION;
use crate::lower::lowering::Lowering;
use crate::lower::values::index::INDEX_OF_ROTATION;
use crate::lower::values::vectors::ROTATION_METHODS;
use crate::lower::values::{Value, Valued};
use crate::mistakes::errors::{Errors, Reported};
use crate::model::Row;
use crate::syntax::ast::{Declaration, MapRule};

impl Lowering<'_> {
    /// A rotation by the index of its group.
    pub(crate) fn rotation(&mut self, group: usize) -> Value {
        let first = self.groups.get(group).map_or(0, |group| group.first);
        Value::Rotation([0, 1, 2, 3].map(|k| self.graph.leaf(Leaf::Q(first + k))))
    }

    /// The Lagrangian plus the kinetic energies of the particles at rest in the first slots of rotations,
    /// with mass 1.
    pub(crate) fn with_particles_at_rest(&mut self, lagrangian: NodeId) -> NodeId {
        let mut terms = vec![(lagrangian, 1.0)];
        for first in self.graph.rotations().to_vec() {
            let velocity = self.graph.leaf(Leaf::V(first));
            terms.push((self.graph.powi(velocity, 2), 0.5));
        }
        if terms.len() == 1 {
            return lagrangian;
        }
        self.graph.linear(0.0, &terms)
    }

    /// The product `r * c` or `r * s`.
    pub(crate) fn rotation_product(&mut self, op: &BinOp, r: Quaternion, right: &Value) -> Valued {
        match right {
            Value::Vector(components) => {
                if let &[x, y, z] = components.as_slice() {
                    return Ok(Value::Vector(self.graph.rotated(r, [x, y, z]).to_vec()));
                }
                let message = format!("a rotation turns vectors of 3 components, found {}", right.kind());
                Err(self.errors.at(op, message))
            }
            Value::Rotation(s) => Ok(Value::Rotation(self.graph.quaternion_product(r, *s))),
            _ => {
                let message = format!(
                    "a rotation turns a vector, `r * c`, or goes on with another, `r * s`; found {}",
                    right.kind()
                );
                Err(self.errors.at(op, message))
            }
        }
    }

    /// `-r * c`: the negative of the turned vector.
    pub(crate) fn negated_and_rotated(
        &mut self,
        op: &BinOp,
        left: &Expr,
        r: Quaternion,
        c: &Value,
    ) -> Valued {
        if !matches!(c, Value::Vector(_)) {
            return Err(self.errors.at(left, SIGN_OF_ROTATION));
        }
        let rotated = self.rotation_product(op, r, c)?;
        rotated.map(|component| Ok(self.graph.neg(component)))
    }

    /// `r.inverse()`, `r.angular_velocity()` or `r.matrix()`
    pub(crate) fn of_rotation(&mut self, name: &Ident, r: Quaternion) -> Valued {
        match name.to_string().as_str() {
            "inverse" => Ok(Value::Rotation(self.graph.inverse(r))),
            "angular_velocity" => Ok(Value::Vector(self.angular_velocity(name, r))),
            "matrix" => {
                let (zero, one) = (self.graph.constant(0.0), self.graph.constant(1.0));
                let axes = [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { one } else { zero }));
                let columns = axes.map(|axis| self.graph.rotated(r, axis));
                Ok(Value::Matrix(
                    (0..3)
                        .map(|i| columns.iter().map(|column| column[i]).collect())
                        .collect(),
                ))
            }
            _ => Err(self.no_method_of_rotation(name)),
        }
    }

    /// The error for a method that rotations do not have.
    pub(crate) fn no_method_of_rotation(&self, name: &Ident) -> Reported {
        let message = format!(
            "a rotation has no `{name}`; expected `r * c`, a vector turned, `r.inverse()`, `r.angular_velocity()` or `r.matrix()`, from whose elements angles \
             follow"
        );
        self.errors.at(name, message)
    }

    /// The error for a field of a rotation, such as `r.w`.
    pub(crate) fn field_of_rotation(&self, name: &Ident) -> Reported {
        let text = name.to_string();
        if ROTATION_METHODS.contains(&&*text) {
            let message = format!("expected parentheses, `.{text}()`");
            return self.errors.at(name, message);
        }
        if matches!(&*text, "w" | "x" | "y" | "z") {
            return self.errors.at(name, INDEX_OF_ROTATION);
        }
        self.no_method_of_rotation(name)
    }

    /// The error for the name of a column of a rotation's quaternion or velocity, such as `r_w` or `v_r_x`.
    pub(crate) fn column_of_rotation(&self, text: &str) -> Option<String> {
        let (stem, component) = text.rsplit_once('_')?;
        if !matches!(component, "w" | "x" | "y" | "z") {
            return None;
        }
        let is_rotation =
            |name: &str| (self.groups.iter()).any(|group| group.is_rotation && group.name == name);
        if is_rotation(stem) {
            return Some(format!("no name `{text}` is known here: {INDEX_OF_ROTATION}"));
        }
        let body = stem.strip_prefix("v_").filter(|name| is_rotation(name))?;
        let place = ["x", "y", "z"].iter().position(|own| *own == component)?;
        Some(format!(
            "no name `{text}` is known here: expected `{body}.angular_velocity()[{place}]`"
        ))
    }

    /// The angular velocity in the frame of the body: the velocity of a coordinate, or else `2 r̄∘dr/dt`.
    fn angular_velocity(&mut self, name: &Ident, r: Quaternion) -> Vec<NodeId> {
        for first in self.graph.rotations().to_vec() {
            if [0, 1, 2, 3].map(|k| self.graph.leaf(Leaf::Q(first + k))) == r {
                let rate = (1..4).map(|k| self.graph.leaf(Leaf::V(first + k)));
                let rate: Vec<_> = rate.collect();
                for &node in &rate {
                    self.record_derivative(name, node);
                }
                return rate;
            }
        }
        let rate = r.map(|component| self.graph.total_derivative(component));
        let inverse = self.graph.inverse(r);
        let [_, x, y, z] = self.graph.quaternion_product(inverse, rate);
        [x, y, z]
            .map(|component| self.graph.scale(2.0, component))
            .to_vec()
    }
}

/// Refuses statements that are not supported beside rotations.
pub(crate) fn check(declaration: &Declaration, kinematic: &[Row], errors: &Errors) -> Result<(), Reported> {
    let groups = declaration
        .coordinates
        .given()
        .into_iter()
        .flat_map(|part| &part.groups);
    let Some(rotation) = groups.into_iter().find(|group| group.is_rotation) else {
        return Ok(());
    };
    if kinematic.iter().any(|row| row.order > 2) {
        let message = "beside a rotation constraints are of second order at most, so far";
        return Err(errors.at(&rotation.name, message));
    }
    for (map, of_pairs) in [
        (&declaration.phi_lagrangian, true),
        (&declaration.phi_kinematic, false),
        (&declaration.phi_variational, false),
    ] {
        let Some(map) = map.given() else { continue };
        let message = match map.rule {
            MapRule::Paper | MapRule::Trapezoid => continue,
            MapRule::Midpoint if of_pairs => continue,
            MapRule::Midpoint => "a mean of three positions is no rotation; expected `paper` beside one",
            MapRule::Closure(_) => {
                "a formula of positions is no rotation; expected a map by its name beside one, such as `paper`"
            }
        };
        return Err(errors.at(&map.keyword, message));
    }
    let discrete = declaration.discrete_kinematic.given();
    if let Some(discrete) = discrete {
        let message = "beside a rotation there are no discrete rows, so far: expected `kinematic` alone";
        return Err(errors.at(&discrete.keyword, message));
    }
    if let Some(discrete) = declaration.discrete_lagrangian.given() {
        let message =
            "beside a rotation there is no discrete Lagrangian, so far: expected `lagrangian` alone";
        return Err(errors.at(&discrete.value, message));
    }
    Ok(())
}
