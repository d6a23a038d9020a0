//! The checks of an entry's motion, and the measured orders of its parts.

use super::run::{Motions, beginning};
use super::{CheckFailure, Entry};
use crate::check::orders::{MAPS, Orders, Variant};
use crate::check::{self, Finding, Settings};

impl Entry {
    /// Compares the numbers of components of a start with that of the coordinates.
    fn fits(&self, settings: &Settings<'_>) -> Result<(), CheckFailure> {
        let vectors = [
            ("q0", Some(settings.q0)),
            ("v0", Some(settings.v0)),
            ("a0", settings.a0),
        ];
        for (name, vector) in vectors {
            if let Some(vector) = vector {
                beginning::fits(name, vector, self.kernel().shape())?;
            }
        }
        Ok(())
    }

    /// Checks the paper's theorems on a motion of the system. It ends at [`Entry::checked_end`] unless the settings have another end.
    ///
    /// # Errors
    ///
    /// [`CheckFailure`] if the motion cannot be computed.
    pub fn check(&self, settings: &Settings<'_>) -> Result<Vec<Finding>, CheckFailure> {
        let default_duration = self.checked_end().abs() * settings.h.signum();
        self.fits(settings)?;
        if self.kernel().shape().is_of_third_order() {
            return check::third::check_to(self.system.kernel(), self.expected(), settings, default_duration);
        }
        let motions: &dyn Motions = &*self.system;
        check::check_to(
            motions,
            &self.symmetries,
            self.expected(),
            settings,
            default_duration,
        )
    }

    /// Measures the orders of the parts of the discrete system on a motion of it: chapter *The orders of the parts*. The motion ends after 200 steps, or at
    /// the default end where that comes first, unless the settings have another end.
    ///
    /// # Errors
    ///
    /// [`CheckFailure`] if the motion cannot be computed, and for systems with rotations or with constraints of third order.
    pub fn orders(&self, settings: &Settings<'_>) -> Result<Orders, CheckFailure> {
        self.fits(settings)?;
        check::orders::orders_to(&*self.system, settings, self.until)
    }

    /// Measures the orders with each of the [`MAPS`] that its declaration admits. A system that cannot be
    /// written as a text is measured with its own maps only.
    ///
    /// # Errors
    ///
    /// As [`Entry::orders`] for the maps as declared.
    pub fn orders_by_map(&self, settings: &Settings<'_>) -> Result<Vec<Variant>, CheckFailure> {
        let [_, others @ ..] = MAPS;
        let mut variants = vec![Variant::declared(self.orders(settings)?)];
        let Ok(text) = self.text() else {
            return Ok(variants);
        };
        let samples = self.tables.iter().map(|(table, samples)| {
            let places = samples.places().iter();
            (
                table.file.clone(),
                places.map(|&place| (place, samples.at(place))).collect(),
            )
        });
        let samples: Vec<(String, Vec<(f64, f64)>)> = samples.collect();
        let shape = self.system.kernel().shape();
        for map in others
            .into_iter()
            .filter(|map| map.is_for(&shape.declaration, shape.kinematic))
        {
            let measured = || {
                let text = map.read(&self.name, &text, &samples)?;
                let entry = Self::of_text(self.name.clone(), &text, text.runs.first());
                entry.orders(settings).map_err(|failure| failure.to_string())
            };
            let orders = measured();
            variants.push(Variant { map, orders });
        }
        Ok(variants)
    }

    /// The position and the velocity of settings, projected onto the constraints by the smallest change.
    pub(crate) fn projected_state(&self, settings: &Settings<'_>) -> Result<[Vec<f64>; 2], CheckFailure> {
        self.fits(settings)?;
        check::projected(&*self.system, settings)
    }
}
