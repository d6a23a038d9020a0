//! The mechanism on a page: its drawings over a motion.

use std::fmt::Write as _;

use serde_json::Value;

use super::rounded;
use crate::entry::{Drawing, Shape};

/// Width and greatest height of the picture, in pixels.
const SIZE: [f64; 2] = [560.0, 460.0];
/// Space around the mechanism, in pixels.
const MARGIN: f64 = 24.0;
/// Radius of a mass, in pixels.
const BOB: f64 = 7.0;

/// The drawings of a mechanism over a motion.
pub struct Scene {
    /// A drawing for each moment.
    drawings: Vec<Drawing>,
    /// Pixels to a metre, and where the origin stands.
    scale: f64,
    /// Where the origin stands, in pixels.
    origin: [f64; 2],
    /// Width and height of the picture, in pixels.
    size: [f64; 2],
}

impl Scene {
    /// The scene of these drawings; none if nothing is to be seen.
    pub fn new(drawings: Vec<Drawing>) -> Option<Self> {
        let corners = drawings.iter().flat_map(Drawing::shapes).flat_map(Shape::corners);
        let finite = corners.filter(|corner| corner.iter().all(|x| x.is_finite()));
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
        // a mechanism that does not move in one direction keeps some room there
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
            scale,
            origin,
            size: [SIZE[0], height],
        })
    }

    /// The numbers of each moment, for the script.
    pub fn frames(&self) -> Value {
        let frame = |drawing: &Drawing| {
            let numbers = drawing.shapes().iter().flat_map(Shape::numbers);
            numbers.map(|x| rounded(x, 5)).collect::<Value>()
        };
        self.drawings.iter().map(frame).collect()
    }

    /// The picture: paths, the last moment in pale, the first one, which the script moves.
    pub fn svg(&self, title: &str) -> String {
        let [width, height] = self.size;
        let mut svg = format!(
            "<svg id=\"mechanism\" class=\"figure\" role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             data-scale=\"{:?} {:?} {:?}\">\n",
            super::escaped(title),
            self.scale,
            self.origin[0],
            self.origin[1],
        );
        let (Some(first), Some(last)) = (self.drawings.first(), self.drawings.last()) else {
            return String::new();
        };
        for (place, shape) in first.shapes().iter().enumerate() {
            if matches!(shape, Shape::Trail(_)) {
                let path = self
                    .drawings
                    .iter()
                    .filter_map(|drawing| match drawing.shapes().get(place) {
                        Some(Shape::Trail(at)) => Some(self.place(*at)),
                        _ => None,
                    });
                let path = path
                    .map(|[x, y]| format!("{x:.1},{y:.1}"))
                    .collect::<Vec<_>>()
                    .join(" ");
                let _ = writeln!(svg, "<polyline class=\"trail\" points=\"{path}\"/>");
            }
        }
        svg.push_str("<g class=\"ghost\">\n");
        last.shapes()
            .iter()
            .for_each(|shape| svg.push_str(&self.shape(shape, "")));
        svg.push_str("</g>\n");
        first
            .shapes()
            .iter()
            .for_each(|shape| svg.push_str(&self.shape(shape, "shape ")));
        svg.push_str("</svg>");
        svg
    }

    /// The place of a point, in pixels.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.origin[0] + self.scale * x, self.origin[1] - self.scale * y]
    }

    /// A shape; what the script moves is of the class `shape`.
    fn shape(&self, shape: &Shape, class: &str) -> String {
        let kind = shape.kind();
        match *shape {
            Shape::Point(at) | Shape::Trail(at) => {
                let [x, y] = self.place(at);
                let (look, radius) = match shape {
                    Shape::Point(_) => ("bob", BOB),
                    _ => ("tracer", BOB / 3.0),
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
        }
    }
}
