//! Mistakes in the parts that an entry adds to its declaration.

use super::{Entry, EntryError, Mistake, Parameters, UnknownName};

impl Entry {
    /// Looks for mistakes in the parts that the entry adds to the declaration.
    ///
    /// # Errors
    ///
    /// [`EntryError`] for the first mistake.
    pub fn verify(&self) -> Result<(), EntryError> {
        let coordinates = self.description.coordinates.len();
        let fail = |cause| {
            Err(EntryError {
                name: self.name.clone(),
                cause,
            })
        };
        let vectors = self.start.iter().flatten().zip(["q0", "v0"]);
        let accelerations = self.acceleration.iter().chain(&self.near);
        let vectors = vectors.chain(accelerations.map(|a0| (a0, "a0")));
        let vectors = vectors.map(|(vector, name)| (format!("{name} of its start"), vector.len()));
        let generators = self.symmetries.iter();
        let generators = generators.map(|symmetry| {
            (
                format!("its symmetry `{}`", symmetry.name()),
                symmetry.components(),
            )
        });
        let drawn = self
            .drawn
            .iter()
            .map(|drawn| ("its drawing".to_owned(), drawn.components));
        for (what, found) in vectors.chain(generators).chain(drawn) {
            if found != coordinates {
                return fail(Mistake::Length {
                    what,
                    found,
                    coordinates: self.description.names().map(str::to_owned).collect(),
                });
            }
        }
        if self.name.is_empty() || self.name.starts_with('-') || self.name.contains(char::is_whitespace) {
            return fail(Mistake::Name);
        }
        if let Some(drawn) = &self.drawn {
            let parameters = &self.description.parameters;
            let values = Parameters::new(parameters.iter().map(|parameter| (parameter.clone(), 1.0)));
            let zeros = vec![0.0; coordinates];
            let _drawing = (drawn.draw)(self.start.as_ref().map_or(&zeros, |[q0, _]| q0), &values);
            if let Some(name) = values.unknown_name() {
                let known = parameters.iter().map(|parameter| parameter.name.clone());
                return fail(Mistake::Parameter(UnknownName::new("parameter", name, known)));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use dsocs_core::{Quantity, dsocs};

    use crate::Entry;
    use crate::entry::{Drawing, Kind};

    /// A mass on a rod,
    /// in a plane.
    ///
    /// Not part of the summary.
    #[dsocs {
        coordinates(
            /// The position [m]
            x,
            /// The height [m]
            y
        );
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2)) - mass * gravity * y;
        holonomic = x.powi(2) + y.powi(2) - length.powi(2);
    }]
    #[derive(Clone)]
    struct PlanarPendulum {
        mass: f64,
        length: f64,
        gravity: f64,
    }

    const PENDULUM: PlanarPendulum = PlanarPendulum {
        mass: 1.0,
        length: 1.0,
        gravity: 9.81,
    };

    /// A rod whose one end slides along itself.
    #[dsocs {
        coordinates(x, y, u, w);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(u).powi(2) + dot(w).powi(2)) / 2;
        holonomic = (x - u).powi(2) + (y - w).powi(2) - 1;
        nonholonomic = dot(x) * (w - y) - dot(y) * (u - x);
    }]
    #[derive(Clone)]
    struct RodAndWheel {}

    #[test]
    fn an_entry_says_what_its_declaration_says() {
        let mut entry = Entry::new(PENDULUM);
        assert_eq!(entry.name(), "planar-pendulum");
        assert_eq!(entry.summary(), "A mass on a rod, in a plane");
        assert_eq!(entry.kind(), Kind::Holonomic);
        assert_eq!(Entry::new(RodAndWheel {}).kind(), Kind::Mixed);
        let units: Vec<_> = entry
            .description()
            .coordinates
            .iter()
            .map(Quantity::unit)
            .collect();
        assert_eq!(units, [Some("m"), Some("m")]);
        entry.set("length", 2.0).unwrap();
        let lengths = entry
            .parameters()
            .into_iter()
            .filter(|(of, _)| of.name == "length");
        assert_eq!(lengths.map(|(_, value)| value).collect::<Vec<_>>(), [2.0]);
        let error = entry.set("lenght", 2.0).unwrap_err();
        assert_eq!(error.nearest.as_deref(), Some("length"));
        assert!(
            error.to_string().contains("known: mass, length, gravity"),
            "{error}"
        );
    }

    #[test]
    fn what_contradicts_the_declaration_is_told() {
        let entry = || Entry::new(PENDULUM);
        assert_eq!(entry().verify(), Ok(()));
        for (entry, expected) in [
            (
                entry().start([0.0], [0.0]),
                "q0 of its start has 1 component, but there are 2 coordinates: x, y",
            ),
            (
                entry().symmetry("rotation", |[x, y, _]| [-y, *x, 0.0]),
                "its symmetry `rotation` has 3 components, but",
            ),
            (
                entry().drawn(|[x, _]: &[f64; 2], parameters| {
                    Drawing::new().point([*x, parameters.get("lenght")])
                }),
                "no parameter `lenght` (did you mean `length`?)",
            ),
            (entry().named("a pendulum"), "has no blanks"),
            (entry().named(""), "is not empty"),
        ] {
            let error = entry.verify().unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
