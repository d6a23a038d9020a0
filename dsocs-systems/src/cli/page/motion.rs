//! The page of one run: the mechanism, its coordinates, energy and forces over time, under one slider.

use serde_json::{Map, Value, json};

use crate::cli::figures::label::{label, plain, short};
use crate::cli::figures::moments::Moments;
use crate::cli::page::bodies::Bodies;
use crate::cli::page::{self, Cell, Page, Scene, rounded};
use crate::entry::{Column, Description, Drawing, Entry};
use crate::figure::{Axis, BLUE, Curve, Envelope, Figure, Panel, Style, escaped};

/// Width and height of a figure, in pixels: readable on a telephone.
const FIGURE_SIZE: [f64; 2] = [400.0, 230.0];
/// Width and height of the figure of a path, in pixels.
const PATH_SIZE: [f64; 2] = [560.0, 460.0];
/// The largest number of numbers for the script: a page stays below a megabyte.
const MOST_NUMBERS: usize = 36_000;
/// The largest number of points in all figures together.
const MOST_POINTS: usize = 28_000;
/// The number of significant digits for the script.
const SCRIPT_DIGITS: usize = 8;

/// A page in the making. Its memory does not grow with the run.
pub struct MotionPage {
    /// The moments that the slider goes through.
    moments: Moments,
    /// The system and its figures.
    content: PageContent,
}

/// Draws the mechanism at a position.
type DrawAtPosition = dyn Fn(&[f64]) -> Drawing;

/// The columns, drawings and figures on the page of a run.
struct PageContent {
    /// The columns, time first.
    columns: Vec<Column>,
    /// The description of the system.
    description: Description,
    /// The mechanism's drawing at a position.
    draw: Option<Box<DrawAtPosition>>,
    /// The bodies that rotate, for a system without a drawing of its own.
    bodies: Option<Bodies>,
    /// The figures of all columns but time, as envelopes.
    envelopes: Vec<Envelope>,
}

impl MotionPage {
    /// A page without moments.
    pub fn new(
        columns: &[Column],
        description: &Description,
        draw: Option<impl Fn(&[f64]) -> Drawing + 'static>,
    ) -> Self {
        let zeros = vec![0.0; description.coordinates.len()];
        let bodies = Bodies::of(description).filter(|_| draw.is_none());
        let shapes = match (&draw, &bodies) {
            (Some(draw), _) => draw(&zeros),
            (None, Some(bodies)) => bodies.drawing(&zeros, 1.0),
            (None, None) => Drawing::new(),
        };
        let numbers = shapes.shapes().iter().map(|shape| shape.numbers().len());
        let numbers = columns.len() + numbers.sum::<usize>();
        let cells = (MOST_POINTS / 4 / columns.len()).clamp(24, 320);
        Self {
            moments: Moments::new((MOST_NUMBERS / numbers).clamp(100, 2000)),
            content: PageContent {
                columns: columns.to_vec(),
                description: description.clone(),
                draw: draw.map(|draw| Box::new(draw) as Box<DrawAtPosition>),
                bodies,
                envelopes: vec![Envelope::with_cells(cells); columns.len() - 1],
            },
        }
    }

    /// Takes the number of a node and the values of all columns there.
    pub fn push(&mut self, index: u64, values: &[f64]) {
        for (envelope, &value) in self.content.envelopes.iter_mut().zip(&values[1..]) {
            envelope.push([values[0], value]);
        }
        self.moments.push(index, values.to_vec());
    }

    /// Whether the mechanism can be drawn.
    pub fn is_drawn(&self) -> bool {
        self.content.draw.is_some() || self.content.bodies.is_some()
    }

    /// A picture of the mechanism at some moments, as SVG; `None` if nothing can be drawn.
    pub fn picture(self, title: &str) -> Option<String> {
        let rows = &self.moments.into_rows();
        Some(self.content.scene(rows)?.picture(title))
    }

    /// The page. `about` describes the run, `notes` are its messages.
    pub fn finish(
        self,
        [name, kind, summary]: [&str; 3],
        about: &Map<String, Value>,
        notes: &[String],
    ) -> String {
        let Self { moments, content } = self;
        let rows = &moments.into_rows();
        let mut page = Page::new(
            &match summary {
                "" => name.to_owned(),
                summary => format!("{name}: {summary}"),
            },
            &format!("A run of {name} ({kind})."),
        );
        for note in notes {
            page.paragraph(note);
        }
        page.add(format!(
            "<div class=\"controls\" hidden><button id=\"play\" type=\"button\">Play</button>\
             <input id=\"time\" type=\"range\" min=\"0\" max=\"{}\" value=\"0\" aria-label=\"Time\">\
             <output id=\"now\" for=\"time\"></output></div>",
            rows.len().saturating_sub(1)
        ));
        page.add("<div class=\"bench\"><div class=\"stage\">");
        let (frames, space) = content.mechanism(&mut page, rows);
        page.add("</div><div>");
        content.figures(&mut page);
        page.add("</div></div>");
        content.summary(&mut page, rows);
        page.heading("The run");
        page.add(page::provenance::provenance(description_rows(about)));
        let column = |(place, column): (usize, &Column)| {
            let values: Value = rows
                .iter()
                .map(|row| rounded(row[place], SCRIPT_DIGITS))
                .collect();
            let data = json!({"label": plain(&short(&column.name)), "unit": column.unit, "values": values});
            (column.name.clone(), data)
        };
        let columns: Map<String, Value> = content.columns.iter().enumerate().skip(1).map(column).collect();
        let times: Value = rows.iter().map(|row| rounded(row[0], 12)).collect();
        page.data(
            "motion",
            json!({"t": times, "columns": columns, "frames": frames, "space": space}),
        );
        page.finish()
    }
}

impl PageContent {
    /// The mechanism over a motion, if it can be drawn.
    fn scene(&self, rows: &[Vec<f64>]) -> Option<Scene> {
        let count = self.description.coordinates.len();
        let positions = rows.iter().map(|row| &row[1..=count]);
        match &self.draw {
            Some(draw) => Scene::new(positions.map(draw).collect()),
            None => Scene::new(self.bodies.as_ref()?.drawings(positions)),
        }
    }

    /// The mechanism, or a path where it has no drawing. Returns the numbers of the moments, and the data for
    /// bodies in space.
    fn mechanism(&self, page: &mut Page, rows: &[Vec<f64>]) -> (Value, Option<Value>) {
        let scene = self.scene(rows);
        page.heading(if scene.is_some() {
            "The mechanism"
        } else {
            "The path"
        });
        if let Some(scene) = scene {
            page.add(format!(
                "<figure>{}<figcaption>Pale: the end of the run, and paths of points.</figcaption></figure>",
                scene.svg("The mechanism at the time of the slider")
            ));
            (scene.frames(), scene.space())
        } else {
            let [x, y] = path_columns(&self.description);
            let [across, up] = [x, y].map(|place| &self.columns[place]);
            let figure = self.path(rows, x, y).on_page(
                "path",
                &format!("{} against {}", plain(&label(up)), plain(&label(across))),
            );
            page.add(format!(
                "<figure data-path=\"{} {}\">{figure}<figcaption>({}, {}) = <output></output></figcaption></figure>",
                escaped(&across.name),
                escaped(&up.name),
                page::with_subscripts(&label(across)),
                page::with_subscripts(&label(up)),
            ));
            (json!([]), None)
        }
    }

    /// The path in the plane of two columns.
    fn path(&self, rows: &[Vec<f64>], x: usize, y: usize) -> Figure {
        let lengths = [x, y].map(|place| self.columns[place].unit.as_deref() == Some("m"));
        let panel = Panel {
            x: Axis::linear(label(&self.columns[x])),
            y: Axis::linear(label(&self.columns[y])),
            curves: vec![Curve {
                points: rows.iter().map(|row| [row[x], row[y]]).collect(),
                style: Style::Line(1.0),
                colour: BLUE,
                label: None,
            }],
            equal_aspect: lengths == [true; 2],
            ..Panel::default()
        };
        Figure {
            size: PATH_SIZE,
            columns: 1,
            panels: vec![panel],
        }
    }

    /// A figure for each column.
    fn figures(&self, page: &mut Page) {
        for (heading, places) in self.groups() {
            page.heading(heading);
            page.add("<div class=\"figures\">");
            for place in places {
                let column = &self.columns[place];
                let points = self.envelopes[place - 1].points();
                let ends = (points.first(), points.last());
                let time = match ends {
                    (Some(first), Some(last)) => Axis::linear("t [s]").with_range(first[0], last[0]),
                    _ => Axis::linear("t [s]"),
                };
                let width = if points.len() > 300 { 0.6 } else { 1.2 };
                let figure = Figure {
                    size: FIGURE_SIZE,
                    columns: 1,
                    panels: vec![Panel {
                        x: time,
                        y: Axis::linear(label(column)),
                        curves: vec![Curve {
                            points,
                            style: Style::Line(width),
                            colour: BLUE,
                            label: None,
                        }],
                        ..Panel::default()
                    }],
                };
                page.add(format!(
                    "<figure data-column=\"{}\">{}<figcaption>{} = <output></output></figcaption></figure>",
                    escaped(&column.name),
                    figure.on_page(
                        &format!("column-{place}"),
                        &format!("{} against time", plain(&label(column)))
                    ),
                    page::with_subscripts(&short(&column.name)),
                ));
            }
            page.add("</div>");
        }
    }

    /// The columns by kind: coordinates, velocities and so on.
    fn groups(&self) -> Vec<(&'static str, Vec<usize>)> {
        let count = self.description.coordinates.len();
        let observed = self.description.observables.len();
        // a rotation has four coordinates, and three components of velocity and force
        let moving = count - self.description.rotations.len();
        let lengths = [
            ("Coordinates", count),
            ("Velocities", moving),
            ("Constraint force", moving),
            ("Energy", 1),
            ("Observed", observed),
            ("Multipliers", self.description.forms),
        ];
        let mut groups = Vec::new();
        let mut next = 1;
        for (heading, length) in lengths {
            groups.push((heading, (next..next + length).collect()));
            next += length;
        }
        let named = |prefix: &str| {
            let rest = next..self.columns.len();
            rest.filter(|&place| self.columns[place].name.starts_with(prefix))
                .collect::<Vec<_>>()
        };
        groups.push((
            "Certificate: smallest singular values of D₃ and D₁",
            named("regularity_"),
        ));
        groups.push(("Estimated errors", named("error_")));
        // without constraints there is no constraint force
        let forceless = self.description.constraints == [0; 3];
        groups.retain(|(heading, places): &(_, Vec<usize>)| {
            let idle = forceless && *heading == "Constraint force";
            !places.is_empty() && !idle
        });
        groups
    }

    /// The first, last, least and greatest value of each column: readable without a script.
    fn summary(&self, page: &mut Page, rows: &[Vec<f64>]) {
        let number = |x: f64| Cell::Number(rounded(x, 7).to_string().replace("null", "–").replace('-', "−"));
        let cells = self.columns.iter().enumerate().map(|(place, column)| {
            let first = rows.first().map_or(f64::NAN, |row| row[place]);
            let last = rows.last().map_or(f64::NAN, |row| row[place]);
            let points = place.checked_sub(1).map(|place| self.envelopes[place].points());
            let values = || points.iter().flatten().map(|point| point[1]);
            let (least, most) = match place {
                0 => (first.min(last), first.max(last)),
                _ => (
                    values().fold(f64::NAN, f64::min),
                    values().fold(f64::NAN, f64::max),
                ),
            };
            vec![
                Cell::Text(column.name.clone()),
                Cell::Text(column.unit.clone().unwrap_or_default()),
                number(first),
                number(last),
                number(least),
                number(most),
            ]
        });
        page.heading("In numbers");
        let head = [
            "column",
            "unit",
            "#at the start",
            "#at the end",
            "#least",
            "#greatest",
        ];
        page.add(page::table("Every column of the run's table", &head, cells));
    }
}

/// The columns of the path that is shown for a mechanism without a drawing: two lengths, else the first two
/// coordinates, else the coordinate and its velocity.
fn path_columns(description: &Description) -> [usize; 2] {
    let coordinates = &description.coordinates;
    let lengths = coordinates
        .iter()
        .enumerate()
        .filter(|(_, of)| of.unit() == Some("m"));
    match lengths.map(|(place, _)| place + 1).collect::<Vec<_>>()[..] {
        [x, y, ..] => [x, y],
        _ => [1, 2], // the velocities follow the coordinates
    }
}

/// The description of a run as rows of a table.
fn description_rows(about: &Map<String, Value>) -> Vec<(String, String)> {
    let plain = |value: &Value| match value {
        Value::String(text) => text.clone(),
        Value::Object(map) => {
            let parts = map
                .iter()
                .map(|(key, value)| format!("{key} = {}", value.to_string().replace('"', "")));
            parts.collect::<Vec<_>>().join(", ")
        }
        other => other.to_string(),
    };
    about
        .iter()
        .map(|(key, value)| (key.clone(), plain(value)))
        .collect()
}

/// Name, kind and summary of a system.
pub fn titles(entry: &Entry) -> [String; 3] {
    [
        entry.name().to_owned(),
        entry.kind().to_string(),
        entry.summary().to_owned(),
    ]
}
