//! Bodies in space on a page: in perspective, only the faces towards the eye, the nearest body drawn last.
//!
//! Bodies are convex. Where the plane of a face separates two of them, the one on the far side from the eye
//! cannot hide the other.

use serde_json::{Value, json};

use super::rounded;
use crate::entry::{Drawing, Face, Shape, Solid};

/// The direction of the eye, in degrees: the angle about the vertical from the first axis, and the angle
/// above the ground.
const EYE: [f64; 2] = [-58.0, 20.0];
/// The distance of the eye from the centre of the scene, in radii of the scene.
const DISTANCE: f64 = 4.0;
/// The brightness of a face turned away from the light; one that faces it has 1.
const DARKEST: f64 = 0.62;
/// The direction of the light: its components to the right, upward and towards the eye.
const LIGHT: [f64; 3] = [-0.42, 0.76, 0.5];
/// The tolerance of a corner that touches a plane, relative to the distance of the eye: the script's numbers
/// are rounded.
const TOUCHING_DISTANCE: f64 = 1e-4;

/// The camera.
pub struct Camera {
    /// The centre of the scene.
    centre: [f64; 3],
    /// The directions to the right, upward and towards the eye.
    axes: [[f64; 3]; 3],
    /// The distance of the eye from the centre.
    distance: f64,
}

/// A face as the camera sees it.
pub struct VisibleFace {
    /// Its corners in the plane, in m.
    pub corners: Vec<[f64; 2]>,
    /// Its colour: red, green, blue, each of 255.
    pub fill: [f64; 3],
    /// Whether it is a line of the ground.
    pub is_ground: bool,
    /// The distance of its middle behind the centre of the scene, along the line of sight.
    depth: f64,
}

/// A convex body, or a line, in space.
struct BodyPart {
    /// Its corners.
    corners: Vec<[f64; 3]>,
    /// The planes of its faces.
    planes: Vec<Plane>,
    /// The distance of its middle behind the centre of the scene, along the line of sight.
    depth: f64,
    /// Whether it lies on the ground, which is behind everything.
    is_ground: bool,
    /// Its visible faces.
    visible_faces: Vec<VisibleFace>,
}

impl BodyPart {
    /// Whether it is in front of another, for an eye at this point.
    fn is_before(&self, other: &Self, eye: [f64; 3], touches: f64) -> bool {
        if self.is_ground || other.is_ground {
            return other.is_ground && !self.is_ground;
        }
        // a line hides no line, and what is inside a body is not seen
        if self.planes.is_empty() && other.planes.is_empty() || other.contains(self, touches) {
            return false;
        }
        if self.contains(other, touches) {
            return true;
        }
        !self.cannot_hide(other, eye, touches)
            && (other.cannot_hide(self, eye, touches) || self.depth < other.depth)
    }

    /// Whether the plane of a face has the other part on the eye's side and this one on its far side.
    fn cannot_hide(&self, other: &Self, eye: [f64; 3], touches: f64) -> bool {
        let is_beyond =
            |plane: &Plane, part: &Self| part.corners.iter().all(|&corner| plane.side(corner) > -touches);
        let outside = |plane: &Plane| plane.side(eye) > 0.0 && is_beyond(plane, other);
        let inside = |plane: &Plane| plane.side(eye) < 0.0 && is_beyond(plane, self);
        self.planes.iter().any(outside) || other.planes.iter().any(inside)
    }

    /// Whether it is a body that contains the other part.
    fn contains(&self, other: &Self, touches: f64) -> bool {
        let is_within = |&corner: &[f64; 3]| self.planes.iter().all(|plane| plane.side(corner) < touches);
        !self.planes.is_empty() && other.corners.iter().all(is_within)
    }
}

/// The plane of a face.
struct Plane {
    /// Its normal, outward.
    normal: [f64; 3],
    /// A point of it.
    at: [f64; 3],
}

impl Plane {
    /// The distance of a point from the plane, positive outside.
    fn side(&self, point: [f64; 3]) -> f64 {
        inner(self.normal, less(point, self.at))
    }
}

impl Camera {
    /// The camera for drawings of bodies in space; `None` if there is no such body.
    pub fn new(drawings: &[Drawing]) -> Option<Self> {
        let corners = drawings.iter().flat_map(Drawing::shapes).flat_map(corners);
        let finite: Vec<[f64; 3]> = corners
            .filter(|corner| corner.iter().all(|x| x.is_finite()))
            .collect();
        if finite.is_empty() {
            return None;
        }
        let centre = [0, 1, 2].map(|i| {
            let along = || finite.iter().map(|corner| corner[i]);
            f64::midpoint(
                along().fold(f64::INFINITY, f64::min),
                along().fold(f64::NEG_INFINITY, f64::max),
            )
        });
        let far = finite.iter().map(|&corner| {
            let from = less(corner, centre);
            inner(from, from)
        });
        let radius = far.fold(0.0, f64::max).sqrt().max(1e-300);
        let [(sin, cos), (rise, level)] = EYE.map(|angle| angle.to_radians().sin_cos());
        let (right, toward) = ([-sin, cos, 0.0], [level * cos, level * sin, rise]);
        Some(Self {
            centre,
            axes: [right, cross(toward, right), toward],
            distance: DISTANCE * radius,
        })
    }

    /// The projection of a point: its position in the plane through the centre, in m, and its distance in
    /// front of that plane.
    pub fn projection(&self, point: [f64; 3]) -> ([f64; 2], f64) {
        let from = less(point, self.centre);
        let [right, up, near] = self.axes.map(|axis| inner(axis, from));
        let scale = self.distance / (self.distance - near);
        ([scale * right, scale * up], near)
    }

    /// The projections of all corners that are drawn in space.
    pub fn corners(&self, drawing: &Drawing) -> Vec<[f64; 2]> {
        let corners = drawing.shapes().iter().flat_map(corners);
        corners.map(|corner| self.projection(corner).0).collect()
    }

    /// The visible faces of a drawing, those of the farthest body first.
    pub fn faces(&self, drawing: &Drawing) -> Vec<VisibleFace> {
        let parts = drawing.shapes().iter().flat_map(|shape| match shape {
            Shape::Solid(solid) => self.body_parts(solid),
            _ => Vec::new(),
        });
        let parts: Vec<BodyPart> = parts.collect();
        let eye = [0, 1, 2].map(|i| self.centre[i] + self.distance * self.axes[2][i]);
        let touches = TOUCHING_DISTANCE * self.distance;
        let hides: Vec<Vec<bool>> = parts
            .iter()
            .map(|one| {
                parts
                    .iter()
                    .map(|other| one.is_before(other, eye, touches))
                    .collect()
            })
            .collect();
        let mut left: Vec<usize> = (0..parts.len()).collect();
        let mut order = Vec::new();
        while !left.is_empty() {
            // a part that hides no other; where parts hide each other in a ring, the farthest
            let last = left
                .iter()
                .position(|&one| left.iter().all(|&other| one == other || !hides[one][other]));
            let farthest = || {
                let depths = left.iter().map(|&one| parts[one].depth).enumerate();
                depths
                    .max_by(|one, other| one.1.total_cmp(&other.1))
                    .map_or(0, |(place, _)| place)
            };
            order.push(left.remove(last.unwrap_or_else(farthest)));
        }
        let mut parts: Vec<Option<BodyPart>> = parts.into_iter().map(Some).collect();
        let ordered = order.into_iter().filter_map(|place| parts[place].take());
        ordered.flat_map(|part| part.visible_faces).collect()
    }

    /// The parts of a body: all of its faces, and each of its lines.
    fn body_parts(&self, solid: &Solid) -> Vec<BodyPart> {
        let placed = solid.faces().iter().map(|face| {
            let corners: Vec<_> = face.corners.iter().map(|&corner| solid.place(corner)).collect();
            (face, corners)
        });
        let (lines, faces): (Vec<_>, Vec<_>) = placed.partition(|(_, corners)| corners.len() == 2);
        let lines = lines.into_iter().map(|line| vec![line]);
        let parts = lines.chain((!faces.is_empty()).then_some(faces));
        parts.map(|faces| self.body_part(&faces)).collect()
    }

    /// A part of a body, with these faces.
    fn body_part(&self, faces: &[(&Face, Vec<[f64; 3]>)]) -> BodyPart {
        let corners: Vec<[f64; 3]> = faces.iter().flat_map(|(_, corners)| corners).copied().collect();
        let nearness = corners
            .iter()
            .map(|&corner| self.projection(corner).1)
            .sum::<f64>();
        let planes = faces.iter().filter(|(_, corners)| corners.len() > 2);
        let planes = planes.map(|(_, corners)| {
            let normal = normal(corners);
            let size = inner(normal, normal).sqrt();
            Plane {
                normal: normal.map(|n| n / size),
                at: corners[0],
            }
        });
        let mut visible_faces: Vec<VisibleFace> = faces
            .iter()
            .filter_map(|(face, corners)| self.face(face, corners))
            .collect();
        visible_faces.sort_by(|one, other| other.depth.total_cmp(&one.depth));
        BodyPart {
            planes: planes.collect(),
            depth: -nearness / corners.len() as f64,
            is_ground: faces.iter().all(|(face, _)| face.colour.is_ground()),
            corners,
            visible_faces,
        }
    }

    /// The projection of a face with these corners in space, if it is visible.
    fn face(&self, face: &Face, corners: &[[f64; 3]]) -> Option<VisibleFace> {
        let count = corners.len() as f64;
        let (places, near): (Vec<[f64; 2]>, Vec<f64>) =
            corners.iter().map(|&corner| self.projection(corner)).unzip();
        let next = places.iter().cycle().skip(1);
        let area: f64 = places
            .iter()
            .zip(next)
            .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
            .sum();
        let is_line = corners.len() == 2;
        let is_seen = is_line || area > 0.0;
        if !is_seen {
            return None;
        }
        let light = if is_line { 1.0 } else { self.light(corners) };
        Some(VisibleFace {
            corners: places,
            fill: face.colour.rgb().map(|part| part * light),
            is_ground: face.colour.is_ground(),
            depth: -near.iter().sum::<f64>() / count,
        })
    }

    /// The brightness of a face.
    fn light(&self, corners: &[[f64; 3]]) -> f64 {
        let normal = normal(corners);
        let size = inner(normal, normal).sqrt();
        let falls: f64 = LIGHT
            .iter()
            .zip(self.axes)
            .map(|(part, axis)| part * inner(axis, normal))
            .sum();
        DARKEST + (1.0 - DARKEST) * (falls / size).max(0.0)
    }

    /// The data for the script: the camera, and for each shape its kind and its faces.
    pub fn script_data(&self, drawing: &Drawing) -> Value {
        let shapes = drawing.shapes().iter().filter_map(|shape| match shape {
            Shape::Solid(solid) => Some(solid.faces().iter().map(script_face).collect()),
            Shape::Path(_) => Some(Value::Null),
            _ => None,
        });
        json!({
            "centre": self.centre, "axes": self.axes, "distance": self.distance, "light": LIGHT, "shade": DARKEST,
            "shapes": shapes.collect::<Value>(),
        })
    }
}

impl VisibleFace {
    /// Its colour as SVG writes it.
    pub fn colour(&self) -> String {
        let [red, green, blue] = self.fill.map(f64::round);
        format!("rgb({red:.0},{green:.0},{blue:.0})")
    }
}

/// A face for the script: its colour, whether it is a line of the ground, and the coordinates of its corners.
fn script_face(face: &Face) -> Value {
    let corners: Value = face.corners.iter().flatten().map(|&x| rounded(x, 5)).collect();
    json!([face.colour.rgb(), face.colour.is_ground(), corners])
}

/// The corners of a shape in space, and the point of a path.
fn corners(shape: &Shape) -> Vec<[f64; 3]> {
    match shape {
        Shape::Solid(solid) => {
            let corners = solid.faces().iter().flat_map(|face| &face.corners);
            corners.map(|&corner| solid.place(corner)).collect()
        }
        Shape::Path(at) => vec![*at],
        _ => Vec::new(),
    }
}

/// Twice the area of a face along its normal.
fn normal(corners: &[[f64; 3]]) -> [f64; 3] {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).fold([0.0; 3], |sum, (&a, &b)| {
        let part = cross(a, b);
        [0, 1, 2].map(|i| sum[i] + part[i])
    })
}

/// `a - b`
fn less(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

/// `a·b`
fn inner(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a × b`
fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_faces_of_a_cuboid_are_seen_and_the_nearer_body_comes_last() {
        let near = Solid::cuboid([1.0; 3]).moved([0.0, -3.0, 0.0]);
        let far = Solid::cuboid([1.0; 3]).moved([0.0, 3.0, 0.0]);
        let drawing = Drawing::new().solid(near).solid(far);
        let camera = Camera::new(std::slice::from_ref(&drawing)).unwrap();
        let faces = camera.faces(&drawing);
        assert_eq!(faces.len(), 6);
        let height = |face: &VisibleFace| face.corners.iter().map(|corner| corner[1]).sum::<f64>();
        // the eye is above the ground, so nearer points are seen lower
        let [last, first] = [&faces[3..], &faces[..3]].map(|faces| faces.iter().map(height).sum::<f64>());
        assert!(last < first, "{last} {first}");
        // a plate on the front of a large body is visible, and one on its back is not
        for (side, is_seen) in [(-1.0, true), (1.0, false)] {
            let plate = Solid::cuboid([0.2, 0.1, 0.2]).moved([0.9, 1.05 * side, -0.9]);
            let drawing = Drawing::new().solid(plate).solid(Solid::cuboid([2.0; 3]));
            let camera = Camera::new(std::slice::from_ref(&drawing)).unwrap();
            let faces = camera.faces(&drawing);
            let width = |face: &VisibleFace| {
                (face.corners[0][0] - face.corners[2][0]).hypot(face.corners[0][1] - face.corners[2][1])
            };
            assert_eq!(width(&faces[5]) < 1.0, is_seen, "{side}");
        }
        assert!(Camera::new(&[Drawing::new().point([0.0, 1.0])]).is_none());
    }
}
