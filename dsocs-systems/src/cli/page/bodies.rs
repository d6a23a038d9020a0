//! The drawing of a system with rotations that declares none: a box with axes for each rotation.

use crate::entry::{Description, Drawing, Solid};

/// The edges of a box, relative to its size: all different, so that its attitude can be seen.
const BOX_EDGES: [f64; 3] = [1.0, 0.7, 0.4];
/// The length of its axes, relative to its size.
const AXIS_LENGTH: f64 = 0.9;
/// The distance between bodies without a position, relative to their size.
const BODY_DISTANCE: f64 = 2.2;
/// The size of a box, relative to the range of the positions.
const BOX_SIZE: f64 = 0.12;

/// The indices of each body's attitude and position among the coordinates.
pub struct Bodies {
    /// The index of the first number of each rotation, and of its position, if it has one.
    places: Vec<(usize, Option<usize>)>,
}

impl Bodies {
    /// The bodies of a system; none if nothing turns.
    ///
    /// The place of a body is an array of three lengths beside its rotation: before it, if one stands before the first rotation, else behind it.
    pub fn of(description: &Description) -> Option<Self> {
        let coordinates = &description.coordinates;
        let is_place = |first: usize| {
            let of = |i: usize| {
                coordinates
                    .get(first + i)
                    .filter(|_| !description.rotations.contains(&first))
            };
            let name = of(0)?.name.strip_suffix("_0")?;
            let named = |i: usize| of(i).is_some_and(|of| *of.name == format!("{name}_{i}"));
            let is_length = coordinates[first].unit().is_none_or(|unit| unit == "m");
            (named(1) && named(2) && !named(3) && is_length).then_some(first)
        };
        let before = |first: usize| first.checked_sub(3).and_then(is_place);
        let rotations = &description.rotations;
        let leads = rotations.first().is_some_and(|&first| before(first).is_some());
        let place = |first: usize| if leads { before(first) } else { is_place(first + 4) };
        let places: Vec<_> = rotations.iter().map(|&first| (first, place(first))).collect();
        (!places.is_empty()).then_some(Self { places })
    }

    /// The drawings at these positions.
    pub fn drawings<'q>(&self, positions: impl Iterator<Item = &'q [f64]> + Clone) -> Vec<Drawing> {
        let placed = || self.places.iter().filter_map(|&(_, place)| place);
        let range = |first: usize, i: usize| {
            let along = positions
                .clone()
                .map(move |q| q[first + i])
                .filter(|x| x.is_finite());
            let [least, most] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
                [least.min(x), most.max(x)]
            });
            [least, most]
        };
        let room = (0..3).map(|i| {
            let [least, most] = placed()
                .map(|first| range(first, i))
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], [from, to]| {
                    [least.min(from), most.max(to)]
                });
            most - least
        });
        let room = room.fold(0.0, f64::max);
        let size = if room > 0.0 { BOX_SIZE * room } else { 1.0 };
        positions.map(|q| self.drawing(q, size)).collect()
    }

    /// The drawing at a position, of boxes of this size.
    pub fn drawing(&self, q: &[f64], size: f64) -> Drawing {
        let mut aside = 0.0;
        self.places
            .iter()
            .fold(Drawing::new(), |drawing, &(first, place)| {
                let at = place.map_or([aside, 0.0, 0.0], |place| [0, 1, 2].map(|i| q[place + i]));
                if place.is_none() {
                    aside += BODY_DISTANCE * size;
                }
                let attitude = [0, 1, 2, 3].map(|i| q[first + i]);
                let axes = Solid::axes(AXIS_LENGTH * size).placed(at, attitude);
                let drawing = drawing
                    .solid(axes)
                    .solid(Solid::cuboid(BOX_EDGES.map(|edge| edge * size)).placed(at, attitude));
                if place.is_some() {
                    drawing.path(at)
                } else {
                    drawing
                }
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::entry::Entry;
    use dsocs_core::text::Text;

    fn bodies(coordinates: &str) -> Vec<(usize, Option<usize>)> {
        let text = format!("coordinates({coordinates}); lagrangian = r.angular_velocity().norm_squared();");
        let text = Text::parse("bodies", &text).unwrap_or_else(|error| panic!("{error}"));
        let entry = Entry::of_text("bodies", &text, None);
        Bodies::of(entry.description()).unwrap().places
    }

    #[test]
    fn a_body_stands_where_the_vector_beside_its_rotation_says() {
        for (coordinates, places) in [
            ("r: rotation", vec![(0, None)]),
            ("r: rotation, x: [3]", vec![(0, Some(4))]),
            ("x: [3], r: rotation", vec![(3, Some(0))]),
            ("x: [3], r: rotation, s: rotation", vec![(3, Some(0)), (7, None)]),
            (
                "r: rotation, x: [3], s: rotation, y: [3]",
                vec![(0, Some(4)), (7, Some(11))],
            ),
            (
                "x: [3], r: rotation, y: [3], s: rotation",
                vec![(3, Some(0)), (10, Some(7))],
            ),
            ("r: rotation, x: [2], y: [4]", vec![(0, None)]),
            (
                "r: rotation, /** The angle of each wheel [rad] */ x: [3]",
                vec![(0, None)],
            ),
        ] {
            assert_eq!(bodies(coordinates), places, "{coordinates}");
        }
    }

    #[test]
    fn boxes_are_as_large_as_the_room_asks() {
        let bodies = Bodies {
            places: vec![(0, Some(4))],
        };
        let at = |x: f64| vec![1.0, 0.0, 0.0, 0.0, x, 0.0, 0.0];
        let (one, other) = (at(0.0), at(50.0));
        let drawings = bodies.drawings([&one[..], &other[..]].into_iter());
        assert_eq!(drawings[0], bodies.drawing(&one, 6.0));
        assert_eq!(
            bodies.drawings([&one[..]].into_iter())[0],
            bodies.drawing(&one, 1.0)
        );
    }
}
