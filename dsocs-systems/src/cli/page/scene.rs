//! The mechanism on a page: its drawings over a motion.

use std::fmt::Write as _;

use serde_json::Value;

use super::rounded;
use super::space::{Camera, VisibleFace};
use crate::entry::{Drawing, Shape};
use crate::figure::escaped;

/// Width and largest height of the picture, in pixels.
const SIZE: [f64; 2] = [560.0, 460.0];
/// Space around the mechanism, in pixels.
const MARGIN: f64 = 24.0;
/// Radius of a mass, in pixels.
const MASS_RADIUS: f64 = 7.0;

/// The number of moments in a picture.
const PICTURE_MOMENTS: usize = 4;
/// The opacity of the first of them.
const FIRST_OPACITY: f64 = 0.25;

/// The style sheet of a picture in a file of its own: as on a page.
const STYLE: &str = ".rod { stroke: #1b1b1b; stroke-width: 3; stroke-linecap: round; } .bob { fill: #0072B2; } \
    .wheel { fill: #0072B2; fill-opacity: .15; stroke: #0072B2; stroke-width: 2; } .face { stroke: #1b1b1b; stroke-opacity: .5; stroke-width: .6; stroke-linejoin: round; } \
    .edge { fill: none; stroke-width: 2.5; stroke-linecap: round; } .ground { stroke-width: .7; } .trail { fill: none; stroke: #9ecae1; stroke-width: 1.2; stroke-linejoin: round; } .tracer { fill: #4a90b8; }";

/// The drawings of a mechanism over a motion.
pub struct Scene {
    /// A drawing for each moment.
    drawings: Vec<Drawing>,
    /// The camera, if there are bodies in space.
    camera: Option<Camera>,
    /// The scale, in pixels per metre.
    scale: f64,
    /// The position of the origin, in pixels.
    origin: [f64; 2],
    /// Width and height of the picture, in pixels.
    size: [f64; 2],
}

impl Scene {
    /// The scene of these drawings; `None` if they show nothing.
    pub fn new(drawings: Vec<Drawing>) -> Option<Self> {
        let camera = Camera::new(&drawings);
        let corners: Vec<[f64; 2]> = match &camera {
            None => {
                let shapes = drawings.iter().flat_map(Drawing::shapes);
                shapes.filter_map(Shape::corners).flatten().collect()
            }
            Some(camera) => {
                let all = drawings.iter().flat_map(|drawing| camera.corners(drawing));
                all.collect()
            }
        };
        let finite = corners
            .into_iter()
            .filter(|corner| corner.iter().all(|x| x.is_finite()));
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let [x, y] = finite.fold([none; 2], |ranges, corner| {
            [0, 1].map(|axis| {
                [
                    ranges[axis][0].min(corner[axis]),
                    ranges[axis][1].max(corner[axis]),
                ]
            })
        });
        if x[0] > x[1] {
            return None;
        }
        // a direction without motion needs a scale, too
        let largest = (x[1] - x[0]).max(y[1] - y[0]).max(1e-300);
        let [x, y] = [x, y].map(|[from, to]| {
            let half = ((to - from) / 2.0).max(0.1 * largest);
            let middle = f64::midpoint(from, to);
            [middle - half, middle + half]
        });
        let room = SIZE.map(|length| length - 2.0 * MARGIN);
        let scale = (room[0] / (x[1] - x[0])).min(room[1] / (y[1] - y[0]));
        let height = scale * (y[1] - y[0]) + 2.0 * MARGIN;
        let middle = [f64::midpoint(x[0], x[1]), f64::midpoint(y[0], y[1])];
        let origin = [
            SIZE[0] / 2.0 - scale * middle[0],
            height / 2.0 + scale * middle[1],
        ];
        Some(Self {
            drawings,
            camera,
            scale,
            origin,
            size: [SIZE[0], height],
        })
    }

    /// The coordinates of the shapes at each moment, for the script.
    pub fn frames(&self) -> Value {
        let frame = |drawing: &Drawing| {
            let shown = drawing.shapes().iter().filter(|shape| self.shows(shape));
            let numbers = shown.flat_map(Shape::numbers);
            numbers.map(|x| rounded(x, 5)).collect::<Value>()
        };
        self.drawings.iter().map(frame).collect()
    }

    /// The picture: the paths, the mechanism at the last moment in pale colours, and at the first moment,
    /// which the script moves.
    pub fn svg(&self, title: &str) -> String {
        let [width, height] = self.size;
        let mut svg = format!(
            "<svg id=\"mechanism\" class=\"figure\" role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             data-scale=\"{:?} {:?} {:?}\">\n",
            escaped(title),
            self.scale,
            self.origin[0],
            self.origin[1],
        );
        let (Some(first), Some(last)) = (self.drawings.first(), self.drawings.last()) else {
            return String::new();
        };
        self.trails(&mut svg);
        self.moment(&mut svg, last, "<g class=\"ghost\">", "");
        self.moment(&mut svg, first, "<g id=\"moving\">", "shape ");
        svg.push_str("</svg>");
        svg
    }

    /// A picture by itself: paths, and the mechanism at some moments, later ones more opaque.
    pub fn picture(&self, title: &str) -> String {
        let [width, height] = self.size;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\">\n\
             <title>{}</title>\n<style>{STYLE}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
            escaped(title),
        );
        self.trails(&mut svg);
        let last = self.drawings.len().saturating_sub(1);
        for moment in 0..PICTURE_MOMENTS {
            let Some(drawing) = self.drawings.get(last * moment / (PICTURE_MOMENTS - 1)) else {
                continue;
            };
            let part = moment as f64 / (PICTURE_MOMENTS - 1) as f64;
            let strength = FIRST_OPACITY + (1.0 - FIRST_OPACITY) * part.powi(3);
            self.moment(&mut svg, drawing, &format!("<g opacity=\"{strength:.2}\">"), "");
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// The paths of points.
    fn trails(&self, svg: &mut String) {
        let first = self.drawings.iter().take(1).flat_map(Drawing::shapes);
        for (place, shape) in first.enumerate() {
            if self.shows(shape) && matches!(shape, Shape::Trail(_) | Shape::Path(_)) {
                let path = self
                    .drawings
                    .iter()
                    .filter_map(|drawing| self.spot(drawing.shapes().get(place)?));
                let path = path
                    .map(|[x, y]| format!("{x:.1},{y:.1}"))
                    .collect::<Vec<_>>()
                    .join(" ");
                let _ = writeln!(svg, "<polyline class=\"trail\" points=\"{path}\"/>");
            }
        }
    }

    /// The mechanism at a moment, in a group.
    fn moment(&self, svg: &mut String, drawing: &Drawing, group: &str, class: &str) {
        svg.push_str(group);
        svg.push('\n');
        let faces = self.camera.iter().flat_map(|camera| camera.faces(drawing));
        faces.for_each(|face| svg.push_str(&self.face(&face)));
        let shown = drawing.shapes().iter().filter(|shape| self.shows(shape));
        shown.for_each(|shape| svg.push_str(&self.shape(shape, class)));
        svg.push_str("</g>\n");
    }

    /// The data that the script needs to show bodies in space.
    pub fn space(&self) -> Option<Value> {
        Some(self.camera.as_ref()?.script_data(self.drawings.first()?))
    }

    /// Whether a shape is shown: in a scene with bodies in space only those, else only plane shapes.
    fn shows(&self, shape: &Shape) -> bool {
        self.camera.is_some() == shape.corners().is_none()
    }

    /// The position of a point shape in the picture, in pixels.
    fn spot(&self, shape: &Shape) -> Option<[f64; 2]> {
        match shape {
            Shape::Point(at) | Shape::Trail(at) => Some(self.place(*at)),
            Shape::Path(at) => Some(self.place(self.camera.as_ref()?.projection(*at).0)),
            _ => None,
        }
    }

    /// A face of a body, as SVG.
    fn face(&self, face: &VisibleFace) -> String {
        let corners = face.corners.iter().map(|&corner| {
            let [x, y] = self.place(corner);
            format!("{x:.2},{y:.2}")
        });
        let corners = corners.collect::<Vec<_>>().join(" ");
        let colour = face.colour();
        let (class, paint) = match (face.corners.len(), face.is_ground) {
            (2, true) => ("edge ground", "stroke"),
            (2, false) => ("edge", "stroke"),
            _ => ("face", "fill"),
        };
        format!("<polygon class=\"{class}\" points=\"{corners}\" style=\"{paint}:{colour}\"/>\n")
    }

    /// The position of a point in the picture, in pixels.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.origin[0] + self.scale * x, self.origin[1] - self.scale * y]
    }

    /// A shape as SVG; shapes that the script moves have the class `shape`.
    fn shape(&self, shape: &Shape, class: &str) -> String {
        let kind = shape.kind();
        match *shape {
            Shape::Point(_) | Shape::Trail(_) | Shape::Path(_) => {
                let [x, y] = self.spot(shape).unwrap_or_default();
                let (look, radius) = match shape {
                    Shape::Point(_) => ("bob", MASS_RADIUS),
                    _ => ("tracer", MASS_RADIUS / 3.0),
                };
                format!(
                    "<circle class=\"{class}{look}\" data-kind=\"{kind}\" cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.1}\"/>\n"
                )
            }
            Shape::Rod(ends) => {
                let [[a, b], [c, d]] = ends.map(|end| self.place(end));
                format!(
                    "<line class=\"{class}rod\" data-kind=\"{kind}\" x1=\"{a:.2}\" y1=\"{b:.2}\" x2=\"{c:.2}\" y2=\"{d:.2}\"/>\n"
                )
            }
            Shape::Wheel { at, radius, angle } => {
                let [x, y] = self.place(at);
                let [a, b] = self.place([at[0] + radius * angle.cos(), at[1] + radius * angle.sin()]);
                format!(
                    "<g class=\"{class}wheel\" data-kind=\"{kind}\"><circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{:.2}\"/>\
                     <line x1=\"{x:.2}\" y1=\"{y:.2}\" x2=\"{a:.2}\" y2=\"{b:.2}\"/></g>\n",
                    self.scale * radius
                )
            }
            // its faces are written one by one
            Shape::Solid(_) => String::new(),
        }
    }
}
