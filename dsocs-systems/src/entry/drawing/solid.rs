//! Bodies in space for drawings: flat faces in the frame of the body, and the body's position and attitude.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};
use std::sync::Arc;

/// The number of sides of a cylinder, a multiple of four.
const SIDES: usize = 24;
/// The number of parts of a ball from pole to pole, and around.
const PARTS: [usize; 2] = [8, 12];
/// The number of parts of the circles of a table.
const ROUND: usize = 48;
/// The number of parts of an axis: each is hidden or visible by itself.
const PIECES: usize = 18;

/// A body in space: its faces, in m, its position and its attitude. It is built about the origin of its own
/// frame, and placed from there.
///
/// ```
/// use dsocs_systems::entry::{Drawing, Solid};
///
/// // a plate with its three axes, upright at the height 1 m
/// let attitude = [0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0, 0.0];
/// let plate = Solid::cuboid([0.4, 0.3, 0.02]).with(&Solid::axes(0.3));
/// let drawing = Drawing::new().solid(plate.placed([0.0, 0.0, 1.0], attitude));
/// assert_eq!(drawing.shapes().len(), 1);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Solid {
    /// Its faces, in its own frame.
    faces: Arc<[Face]>,
    /// The position of the origin of its frame, in m.
    at: [f64; 3],
    /// The unit quaternion `(w, x, y, z)` that turns its axes into those of space.
    attitude: [f64; 4],
}

/// A flat face, or a line if it has two corners.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Face {
    /// Its corners, counter-clockwise as seen from outside.
    pub(crate) corners: Vec<[f64; 3]>,
    /// Its colour.
    pub(crate) colour: Colour,
}

/// The colour of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Colour {
    /// Most faces.
    Plain,
    /// Alternate faces, which make the rotation of a body visible.
    Other,
    /// The first axis.
    First,
    /// The second axis.
    Second,
    /// The third axis.
    Third,
    /// The ground.
    Ground,
}

impl Colour {
    /// Whether it is the colour of the ground, which is behind everything.
    pub(crate) fn is_ground(self) -> bool {
        self == Self::Ground
    }

    /// Red, green and blue, each of 255.
    pub(crate) fn rgb(self) -> [f64; 3] {
        match self {
            Self::Plain => [106.0, 168.0, 211.0],
            Self::Other => [247.0, 247.0, 242.0],
            Self::First => [213.0, 94.0, 0.0],
            Self::Second => [0.0, 130.0, 95.0],
            Self::Third => [30.0, 60.0, 160.0],
            Self::Ground => [205.0, 205.0, 205.0],
        }
    }
}

impl Solid {
    /// A body with these faces.
    fn of(faces: impl IntoIterator<Item = Face>) -> Self {
        Self {
            faces: faces.into_iter().collect(),
            at: [0.0; 3],
            attitude: [1.0, 0.0, 0.0, 0.0],
        }
    }

    /// A cuboid with these edges along the three axes, and its middle at the origin.
    pub fn cuboid(edges: [f64; 3]) -> Self {
        let half = edges.map(|edge| edge / 2.0);
        Self::of((0..6).map(|side| {
            let (axis, sign) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
            let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[one, other]| {
                let mut corner = [0.0; 3];
                corner[axis] = sign * half[axis];
                corner[(axis + 1) % 3] = sign * one * half[(axis + 1) % 3];
                corner[(axis + 2) % 3] = other * half[(axis + 2) % 3];
                corner
            });
            Face::new(corners, if side == 4 { Colour::Other } else { Colour::Plain })
        }))
    }

    /// A cylinder, a disc or a wheel about the third axis, with its middle at the origin. Its quarters have two colours.
    pub fn cylinder(radius: f64, length: f64) -> Self {
        let rim = |side: usize, height: f64| {
            let (sin, cos) = (TAU * side as f64 / SIDES as f64).sin_cos();
            [radius * cos, radius * sin, height]
        };
        let (top, bottom) = (length / 2.0, -length / 2.0);
        let colour = |side: usize| [Colour::Plain, Colour::Other][side * 4 / SIDES % 2];
        let sides = (0..SIDES).map(|side| {
            let (from, to) = (side, side + 1);
            let corners = [rim(from, bottom), rim(to, bottom), rim(to, top), rim(from, top)];
            Face::new(corners, colour(side))
        });
        let quarters = (0..4).flat_map(|quarter| {
            let first = quarter * SIDES / 4;
            let arc = |height| (first..=first + SIDES / 4).map(move |side| rim(side, height));
            let above = [[0.0, 0.0, top]].into_iter().chain(arc(top));
            let below = [[0.0, 0.0, bottom]].into_iter().chain(arc(bottom).rev());
            [Face::new(above, colour(first)), Face::new(below, colour(first))]
        });
        Self::of(sides.chain(quarters))
    }

    /// A ball with its middle at the origin. Its eighths have two colours.
    pub fn ball(radius: f64) -> Self {
        let [rows, columns] = PARTS;
        let point = |row: usize, column: usize| {
            let (sin, cos) = (PI * row as f64 / rows as f64).sin_cos();
            let (aside, ahead) = (TAU * column as f64 / columns as f64).sin_cos();
            [radius * sin * ahead, radius * sin * aside, radius * cos]
        };
        let patches = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        Self::of(patches.map(|(row, column)| {
            let (below, beside) = (row + 1, column + 1);
            let corners = [
                point(row, column),
                point(below, column),
                point(below, beside),
                point(row, beside),
            ];
            let eighth = 4 * column / columns + 2 * row / rows;
            Face::new(corners, [Colour::Plain, Colour::Other][eighth % 2])
        }))
    }

    /// The three axes of a frame, from its origin: red, green and blue.
    pub fn axes(length: f64) -> Self {
        let colours = [Colour::First, Colour::Second, Colour::Third];
        let pieces = colours.into_iter().enumerate().flat_map(|(axis, colour)| {
            (0..PIECES).map(move |piece| {
                let ends = [piece, piece + 1].map(|end| {
                    let mut corner = [0.0; 3];
                    corner[axis] = length * end as f64 / PIECES as f64;
                    corner
                });
                Face::new(ends, colour)
            })
        });
        Self::of(pieces)
    }

    /// A square of the ground, with lines a tenth of its edge apart.
    pub fn ground(edge: f64) -> Self {
        let lines = (0..=10).flat_map(|line| {
            let (aside, end) = (edge * (f64::from(line) / 10.0 - 0.5), edge / 2.0);
            [
                [[aside, -end, 0.0], [aside, end, 0.0]],
                [[-end, aside, 0.0], [end, aside, 0.0]],
            ]
        });
        Self::of(lines.map(|ends| Face::new(ends, Colour::Ground)))
    }

    /// A round table in the plane of the ground, with its middle at the origin: four circles, and a spoke every 15 degrees.
    pub fn table(radius: f64) -> Self {
        let at = |part: f64, place: usize| {
            let (sin, cos) = (TAU * place as f64 / ROUND as f64).sin_cos();
            [radius * part * cos, radius * part * sin, 0.0]
        };
        let circles = [1.0, 0.75, 0.5, 0.25].into_iter().flat_map(|part| {
            let pieces = (0..ROUND).map(move |place| [at(part, place), at(part, place + 1)]);
            pieces.collect::<Vec<_>>()
        });
        let spokes = (0..ROUND)
            .step_by(2)
            .map(|place| [at(0.25, place), at(1.0, place)]);
        let lines: Vec<_> = circles.chain(spokes).collect();
        Self::of(lines.into_iter().map(|ends| Face::new(ends, Colour::Ground)))
    }

    /// The body rotated by the unit quaternion `(w, x, y, z)`, then moved by `at`, in m. Bodies placed on it
    /// before move along: a wheel is placed on its body, and both with the body in space.
    pub fn placed(mut self, at: [f64; 3], attitude: [f64; 4]) -> Self {
        let moved = rotated(attitude, self.at);
        self.at = [0, 1, 2].map(|i| at[i] + moved[i]);
        self.attitude = product(attitude, self.attitude);
        self
    }

    /// The body moved by `by`, in m, along the axes of space.
    pub fn moved(self, by: [f64; 3]) -> Self {
        self.placed(by, [1.0, 0.0, 0.0, 0.0])
    }

    /// Both bodies as one.
    pub fn with(&self, other: &Self) -> Self {
        Self::of(self.in_space().chain(other.in_space()).collect::<Vec<_>>())
    }

    /// The faces in space.
    fn in_space(&self) -> impl Iterator<Item = Face> {
        self.faces.iter().map(|face| Face {
            corners: face.corners.iter().map(|&corner| self.place(corner)).collect(),
            colour: face.colour,
        })
    }

    /// Its faces, in its own frame.
    pub(crate) fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The position in space of a point of its frame.
    pub(crate) fn place(&self, point: [f64; 3]) -> [f64; 3] {
        let of_body = rotated(self.attitude, point);
        [0, 1, 2].map(|i| self.at[i] + of_body[i])
    }

    /// Its position and its quaternion.
    pub(crate) fn pose(&self) -> [f64; 7] {
        let ([x, y, z], [a, b, c, d]) = (self.at, self.attitude);
        [x, y, z, a, b, c, d]
    }
}

impl Face {
    /// A face.
    fn new(corners: impl IntoIterator<Item = [f64; 3]>, colour: Colour) -> Self {
        Self {
            corners: corners.into_iter().collect(),
            colour,
        }
    }
}

/// The quaternion of a rotation about the axis `axis` (0, 1 or 2) by an angle, in rad: the attitude of a
/// wheel on its body.
#[must_use]
pub fn about(axis: usize, angle: f64) -> [f64; 4] {
    let (sin, cos) = (angle / 2.0).sin_cos();
    let mut quaternion = [cos, 0.0, 0.0, 0.0];
    if let Some(component) = quaternion.get_mut(1 + axis) {
        *component = sin;
    }
    quaternion
}

/// The rotation that takes the third axis to the axis `axis` (0, 1 or 2): the attitude of a cylinder along
/// it.
#[must_use]
pub fn along(axis: usize) -> [f64; 4] {
    match axis {
        0 => [FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2, 0.0],
        1 => [FRAC_1_SQRT_2, -FRAC_1_SQRT_2, 0.0, 0.0],
        _ => [1.0, 0.0, 0.0, 0.0],
    }
}

/// `p∘q`
fn product([a, b, c, d]: [f64; 4], [w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y + c * w + d * x - b * z,
        a * z + d * w + b * y - c * x,
    ]
}

/// A vector rotated by a unit quaternion `(w, x, y, z)`.
#[must_use]
pub fn rotated(q: [f64; 4], [x, y, z]: [f64; 3]) -> [f64; 3] {
    let [w, a, b, c] = q;
    let [_, x, y, z] = product(product(q, [0.0, x, y, z]), [w, -a, -b, -c]);
    [x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area of a face along its normal, which points outward by declaration.
    fn normal(corners: &[[f64; 3]]) -> [f64; 3] {
        let next = corners.iter().cycle().skip(1);
        corners
            .iter()
            .zip(next)
            .fold([0.0; 3], |[l, m, n], ([a, b, c], [x, y, z])| {
                [l + b * z - c * y, m + c * x - a * z, n + a * y - b * x]
            })
    }

    #[test]
    fn faces_look_outward() {
        for solid in [
            Solid::cuboid([1.0, 2.0, 0.5]),
            Solid::cylinder(1.0, 0.3),
            Solid::ball(0.7),
        ] {
            for face in solid.faces() {
                let corners = &face.corners;
                let middle = [0, 1, 2]
                    .map(|i| corners.iter().map(|corner| corner[i]).sum::<f64>() / corners.len() as f64);
                let outward: f64 = middle.iter().zip(normal(corners)).map(|(x, n)| x * n).sum();
                assert!(outward > 0.0, "{face:?}");
            }
        }
    }

    #[test]
    fn what_is_placed_on_a_body_moves_with_it() {
        let quarter = about(2, PI / 2.0);
        let wheel = Solid::ball(0.1).moved([1.0, 0.0, 0.0]);
        let [x, y, z, ..] = wheel.placed([0.0, 0.0, 5.0], quarter).pose();
        assert!(x.abs() < 1e-15 && (y - 1.0).abs() < 1e-15 && (z - 5.0).abs() < 1e-15);
        for axis in 0..3 {
            let led = rotated(along(axis), [0.0, 0.0, 1.0]);
            assert!((led[axis] - 1.0).abs() < 1e-15, "{axis}: {led:?}");
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            let stays = rotated(about(axis, 0.7), unit)[axis];
            assert!((stays - 1.0).abs() < 1e-15, "{axis}: {stays}");
        }
    }
}
