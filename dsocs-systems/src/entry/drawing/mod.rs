//! The drawing of a mechanism.

mod solid;

use std::borrow::Cow;
use std::cell::OnceCell;
use std::sync::Arc;

use dsocs_core::Quantity;

pub(crate) use solid::Face;
pub use solid::{Solid, about, along, rotated};

/// A picture of a mechanism at a position: shapes in a plane, or bodies in space, in m. The page of a run shows it moving.
///
/// A drawing with a body in space is seen in perspective, the third axis upward. Shapes in a plane are not seen there.
///
/// ```
/// use dsocs_systems::entry::Drawing;
///
/// // a pendulum with a wheel at its end
/// let (theta, psi, length) = (0.3_f64, 1.0, 0.5);
/// let axle = [length * theta.sin(), -length * theta.cos()];
/// let drawing = Drawing::new().rod([0.0, 0.0], axle).wheel(axle, 0.1, psi);
/// assert_eq!(drawing.shapes().len(), 2);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[must_use]
pub struct Drawing {
    /// The shapes, the first at the back.
    shapes: Vec<Shape>,
}

/// A part of a drawing.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// A mass at a point.
    Point([f64; 2]),
    /// A straight rod between two points.
    Rod([[f64; 2]; 2]),
    /// A wheel about a point, with a spoke at an angle, in rad, counted from the horizontal.
    Wheel {
        /// Its middle.
        at: [f64; 2],
        /// Its radius.
        radius: f64,
        /// The angle of its spoke.
        angle: f64,
    },
    /// A point whose path is drawn.
    Trail([f64; 2]),
    /// A body in space.
    Solid(Solid),
    /// A point in space whose path is drawn.
    Path([f64; 3]),
}

impl Drawing {
    /// An empty drawing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a mass at a point.
    pub fn point(self, at: [f64; 2]) -> Self {
        self.with(Shape::Point(at))
    }

    /// Adds a rod between two points.
    pub fn rod(self, from: [f64; 2], to: [f64; 2]) -> Self {
        self.with(Shape::Rod([from, to]))
    }

    /// Adds a wheel about a point, with a spoke at an angle.
    pub fn wheel(self, at: [f64; 2], radius: f64, angle: f64) -> Self {
        self.with(Shape::Wheel { at, radius, angle })
    }

    /// Adds the path of a point.
    pub fn trail(self, at: [f64; 2]) -> Self {
        self.with(Shape::Trail(at))
    }

    /// Adds a body in space.
    pub fn solid(self, solid: Solid) -> Self {
        self.with(Shape::Solid(solid))
    }

    /// Adds the path of a point in space.
    pub fn path(self, at: [f64; 3]) -> Self {
        self.with(Shape::Path(at))
    }

    /// Adds a shape.
    pub fn with(mut self, shape: Shape) -> Self {
        self.shapes.push(shape);
        self
    }

    /// The shapes, the first at the back.
    #[must_use]
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }
}

impl Shape {
    /// The name of its kind on a page.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Point(_) => "point",
            Self::Rod(_) => "rod",
            Self::Wheel { .. } => "wheel",
            Self::Trail(_) => "trail",
            Self::Solid(_) => "solid",
            Self::Path(_) => "path",
        }
    }

    /// Its numbers; their count depends on the kind only.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        match *self {
            Self::Point([x, y]) | Self::Trail([x, y]) => vec![x, y],
            Self::Rod([[a, b], [c, d]]) => vec![a, b, c, d],
            Self::Wheel {
                at: [x, y],
                radius,
                angle,
            } => vec![x, y, radius, angle],
            Self::Solid(ref solid) => solid.pose().to_vec(),
            Self::Path(at) => at.to_vec(),
        }
    }

    /// Two opposite corners of the box around a plane shape; `None` for shapes in space.
    pub(crate) fn corners(&self) -> Option<[[f64; 2]; 2]> {
        match *self {
            Self::Point(at) | Self::Trail(at) => Some([at, at]),
            Self::Rod(ends) => Some(ends),
            Self::Wheel {
                at: [x, y], radius, ..
            } => Some([[x - radius, y - radius], [x + radius, y + radius]]),
            Self::Solid(_) | Self::Path(_) => None,
        }
    }
}

/// The parameters of a system by their names.
#[derive(Clone, Debug, Default)]
pub struct Parameters {
    /// Names and values.
    values: Vec<(Cow<'static, str>, f64)>,
    /// The first name that was asked for and does not exist.
    unknown_name: OnceCell<String>,
}

impl Parameters {
    /// These parameters.
    pub(crate) fn new(parameters: impl IntoIterator<Item = (Quantity, f64)>) -> Self {
        Self {
            values: parameters
                .into_iter()
                .map(|(of, value)| (of.name, value))
                .collect(),
            unknown_name: OnceCell::new(),
        }
    }

    /// The value of a parameter. It is NaN if there is no parameter of this name; [`crate::Entry::verify`] reports this mistake.
    #[must_use]
    pub fn get(&self, name: &str) -> f64 {
        let found = self.values.iter().find(|(known, _)| *known == name);
        if found.is_none() {
            self.unknown_name.get_or_init(|| name.to_owned());
        }
        found.map_or(f64::NAN, |&(_, value)| value)
    }

    /// The first name that was asked for and does not exist.
    pub(crate) fn unknown_name(&self) -> Option<&str> {
        self.unknown_name.get().map(String::as_str)
    }
}

/// Draws at a position, with the parameters.
type DrawAtPosition = dyn Fn(&[f64], &Parameters) -> Drawing + Send + Sync;

/// The drawing of a system.
pub(crate) struct DrawingFunction {
    /// The number of coordinates that it expects.
    pub(crate) components: usize,
    /// The drawing at a position.
    pub(crate) draw: Arc<DrawAtPosition>,
}

impl DrawingFunction {
    /// The drawing of positions of `N` coordinates.
    pub(crate) fn new<const N: usize>(
        draw: impl Fn(&[f64; N], &Parameters) -> Drawing + Send + Sync + 'static,
    ) -> Self {
        Self {
            components: N,
            draw: Arc::new(move |q, parameters| {
                q.try_into().map(|q| draw(q, parameters)).unwrap_or_default()
            }),
        }
    }
}
