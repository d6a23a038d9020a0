//! Constraints of every order, and the virtual displacements that belong to them.

use quote::ToTokens;
use syn::Expr;

use crate::graph::{Leaf, NodeId};
use crate::lower::lowering::{Lowered, Lowering};
use crate::lower::values::{Value, Valued};
use crate::mechanics::{Defect, annihilator};
use crate::mistakes::errors::Reported;
use crate::model::{Displacements, Form, Kind, Row};
use crate::syntax::ast::{Constraints, Declaration, Directions, Side};

/// Vectors of `n` components each.
type Vectors = Vec<Vec<NodeId>>;

impl Lowering<'_> {
    /// The rows of a statement, grouped by its entries: a vector stands for several rows.
    pub(crate) fn constraints(
        &mut self,
        constraints: &Constraints,
        kind: Kind,
    ) -> Result<Vec<Vec<Row>>, Reported> {
        self.each_entry(&constraints.rows, |lowering, row| {
            lowering.derivatives.clear();
            let value = lowering.value(row);
            lowering.count_rows(row, &value, kind);
            let value = value?;
            if value.rank() > 1 || matches!(value, Value::Rotation(_)) {
                let found = value.kind();
                let message = format!("expected a number or a vector that is zero, found {found}");
                return Err(lowering.errors.at(row, message));
            }
            let components = value.numbers().into_iter();
            components
                .map(|value| lowering.constraint(value, row, kind))
                .collect()
        })
    }

    /// Adds the rows of an entry to the count of its kind; an unknown number makes the count unknown.
    fn count_rows(&mut self, row: &Expr, value: &Valued, kind: Kind) {
        let count = match value {
            Ok(value) => Some(value.numbers().len()),
            // the entry is wrong, but without arrays and rotations it is no vector
            Err(_)
                if self
                    .groups
                    .iter()
                    .all(|group| group.length.is_none() && !group.is_rotation)
                    && self.rank(row) == 0 =>
            {
                Some(1)
            }
            Err(_) => None,
        };
        let all = &mut self.rows[kind as usize];
        *all = all.zip(count).map(|(all, count)| all + count);
    }

    fn constraint(&mut self, value: NodeId, row: &Expr, kind: Kind) -> Result<Row, Reported> {
        let written = self.check_order(value, row, kind)?;
        let (value, order) = self.without_cancelled_derivatives(written);
        let dropped_out = self.graph.order(written) >= Some(2) && order < Some(2);
        let message = match (kind, order) {
            (Kind::Holonomic, Some(0)) | (Kind::Nonholonomic, Some(1)) | (Kind::Kinematic, Some(2 | 3)) => {
                return Ok(Row {
                    tokens: row.to_token_stream(),
                    kind,
                    value,
                    order: order.unwrap_or(0),
                    divide: None,
                    divided: false,
                    discrete: None,
                });
            }
            (Kind::Holonomic, _) => {
                "expected a position in a holonomic constraint; this does not depend on the motion"
            }
            (Kind::Nonholonomic, Some(_)) => {
                "expected a velocity in a nonholonomic constraint; one of positions alone is written `holonomic = …;`"
            }
            (Kind::Nonholonomic, None) => {
                "expected a velocity in a nonholonomic constraint; this does not depend on the motion"
            }
            (Kind::Kinematic, Some(1)) if dropped_out => {
                "expected an acceleration in a kinematic constraint, and all of them drop out of this one; \
                 what is left is one of velocities, written `nonholonomic = …;`"
            }
            (Kind::Kinematic, Some(_)) if dropped_out => {
                "expected an acceleration in a kinematic constraint, and all of them drop out of this one; \
                 what is left is one of positions, written `holonomic = …;`"
            }
            (Kind::Kinematic, Some(1)) => {
                "expected an acceleration in a kinematic constraint; one of positions and velocities is written \
                 `nonholonomic = …;`"
            }
            (Kind::Kinematic, Some(_)) => {
                "expected an acceleration in a kinematic constraint; one of positions alone is written `holonomic = …;`"
            }
            (Kind::Kinematic, None) => {
                "expected an acceleration in a kinematic constraint; this does not depend on the motion"
            }
        };
        Err(self.errors.at(row, message))
    }

    /// An expression without derivatives that cancel in it, and the order of the highest one left.
    ///
    /// A constraint on velocities alone would be a leapfrog scheme on a triple of nodes: it has a second
    /// solution, which grows where the motion decays.
    pub(crate) fn without_cancelled_derivatives(&mut self, value: NodeId) -> (NodeId, Option<usize>) {
        let leaves: Vec<Leaf> = self.graph.leaves(value).collect();
        let highest = self.graph.order(value);
        let mut top = leaves.iter().filter(|leaf| leaf.order() == highest);
        if highest.is_none() || top.any(|&leaf| self.graph.surely_varies_with(value, leaf)) {
            return (value, highest);
        }
        // on a copy, so that the test adds no nodes to the code
        let mut graph = self.graph.clone();
        let order = (0..=3).rev().find(|&order| {
            let mut leaves = leaves.iter().filter(|leaf| leaf.order() == Some(order));
            leaves.any(|&leaf| {
                let slope = graph.derivative(value, leaf);
                !graph.vanishes(slope)
            })
        });
        if order == highest {
            return (value, order);
        }
        let zero = self.graph.constant(0.0);
        let idle = leaves.iter().filter(|leaf| leaf.order() > order);
        let rest = self
            .graph
            .substitute(value, &idle.map(|&leaf| (leaf, zero)).collect());
        let difference = self.graph.sub(value, rest);
        if self.graph.vanishes(difference) {
            (rest, order)
        } else {
            // a derivative cancels but for a step function, such as `ddot(x).signum()`
            (value, order)
        }
    }

    /// A row, refused if it has derivatives that its kind of constraint may not have.
    fn check_order(&mut self, value: NodeId, row: &Expr, kind: Kind) -> Lowered {
        match kind {
            Kind::Holonomic => self.check_order_below(
                1,
                value,
                row,
                "a velocity or an acceleration comes in here; expected a constraint of positions, g(q) = 0: \
                 with velocities it is written `nonholonomic = …;`, with accelerations `kinematic = …;`",
            ),
            Kind::Nonholonomic => self.check_order_below(
                2,
                value,
                row,
                "an acceleration comes in here; expected a constraint of positions and velocities, c(q, v) = 0: \
                 with accelerations it is written `kinematic = …;`",
            ),
            Kind::Kinematic => Ok(value),
        }
    }

    /// The fields or forms of a statement.
    pub(crate) fn fields(&mut self, directions: &Directions) -> Result<Vectors, Reported> {
        self.each_entry(&directions.fields, |lowering, field| {
            lowering.derivatives.clear();
            let components = lowering.entries(field)?;
            let expected = "directions of time, positions, velocities and accelerations, u(t, q, v, a)";
            let checked = components.iter();
            let checked = checked.map(|&component| lowering.without_jerk(component, field, expected));
            checked.collect()
        })
    }

    /// The forms that span `F_V`, if they are known, and the virtual displacements `C_V`, as fields if these
    /// can be found.
    ///
    /// `off_node`: the displacements are not taken at the middle node.
    pub(crate) fn displacements(
        &mut self,
        declaration: &Declaration,
        constraints: &[Row],
        fields: Option<Vectors>,
        off_node: bool,
    ) -> Result<(Vec<Form>, Displacements), Reported> {
        let n = self.coordinates.len();
        let directions = declaration.directions.given();
        let side = directions.map(|directions| directions.side);
        let mut given = fields.unwrap_or_default();
        if side == Some(Side::Variational) {
            // the particles at rest, in the first slots of rotations
            let (zero, one) = (self.graph.constant(0.0), self.graph.constant(1.0));
            let rotations = self.graph.rotations().iter();
            given.extend(
                rotations.map(|&first| (0..n).map(|i| if i == first { one } else { zero }).collect()),
            );
        }
        if let (Some(Side::Variational), Some(directions)) = (side, directions) {
            // the annihilator tells whether the fields are independent
            if let Err(Defect::Dependent(row)) = annihilator(&mut self.graph, &given, n) {
                return Err(self.dependent_directions(directions, row));
            }
            return Ok((Vec::new(), Displacements::Fields(given)));
        }
        let all = side == Some(Side::Forces) && given.len() == constraints.len();
        let mut given = given.into_iter();
        let mut own = Vec::new();
        let forms: Vec<Form> = constraints
            .iter()
            .map(|row| {
                let by_statement = side == Some(Side::Forces) && (all || row.kind == Kind::Kinematic);
                let written = if by_statement { given.next() } else { None };
                own.push(written.is_none());
                Form {
                    at_node: row.kind == Kind::Holonomic && written.is_none(),
                    components: written.unwrap_or_else(|| self.form_by_rule(row)),
                }
            })
            .collect();
        let vectors: Vec<_> = forms.iter().map(|form| form.components.clone()).collect();
        let displacements = match annihilator(&mut self.graph, &vectors, n) {
            Err(Defect::Dependent(row)) => {
                // a form that the user wrote, or else a constraint
                let written = own[..row].iter().filter(|&&own| !own).count();
                return Err(match directions {
                    Some(directions) if !own[row] => self.dependent_directions(directions, written),
                    _ => self.without_force(&constraints[row]),
                });
            }
            Ok(fields) if !(off_node && forms.iter().any(|form| form.at_node)) => {
                Displacements::Fields(fields)
            }
            Ok(_) | Err(Defect::NoPivot(_)) => Displacements::Annihilated,
        };
        Ok((forms, displacements))
    }

    /// The form by the rules of d'Alembert and Chetaev: the derivative of a constraint by its highest
    /// derivatives.
    fn form_by_rule(&mut self, row: &Row) -> Vec<NodeId> {
        (0..self.coordinates.len())
            .map(|i| {
                let leaf = match row.order {
                    0 => Leaf::Q(i),
                    1 => Leaf::V(i),
                    2 => Leaf::A(i),
                    _ => Leaf::J(i),
                };
                self.graph.derivative(row.value, leaf)
            })
            .collect()
    }

    fn dependent_directions(&self, directions: &Directions, row: usize) -> Reported {
        let noun = if directions.side == Side::Forces {
            "forces"
        } else {
            "fields"
        };
        let message = format!("expected independent {noun}; this one is zero or a combination of the others");
        match directions.fields.get(row) {
            Some(field) => self.errors.at(&field.value, message),
            None => self.errors.at(&directions.keyword, message),
        }
    }

    /// Reports a constraint whose force depends linearly on the others'.
    fn without_force(&self, row: &Row) -> Reported {
        let message = "expected independent constraints; the force that belongs to this one is zero or a \
                       combination of the others'";
        self.errors.at(&row.tokens, message)
    }
}
