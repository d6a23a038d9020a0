//! The few elements of SVG that a figure consists of.

use std::fmt::Write;

/// The fonts of all text: the reader's machine uses the first that it has. PNGs are made with the first.
const FONTS: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

/// The largest coordinate, in pixels: positions far outside of a picture are clipped and need not be exact.
const LARGEST_COORDINATE: f64 = 1e5;

/// The part of a text that is aligned with its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// The position and style of a text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lettering {
    /// Its position, in pixels: across, and the middle of its height.
    pub(super) at: [f64; 2],
    /// The part of it that stands there.
    pub(super) anchor: Anchor,
    /// The size of the font, in pixels.
    pub(super) size: f64,
    /// Whether it is rotated, to be read from below.
    pub(super) upright: bool,
    /// Its colour, as SVG writes it.
    pub(super) colour: &'static str,
}

/// A rectangle, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    /// Its left edge.
    pub(super) left: f64,
    /// Its upper edge.
    pub(super) top: f64,
    /// Its width.
    pub(super) width: f64,
    /// Its height.
    pub(super) height: f64,
}

impl Area {
    /// Its right edge.
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    /// Its lower edge.
    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// A picture in the making.
pub(super) struct Svg {
    /// The SVG so far.
    text: String,
    /// The number of clip paths.
    clips: usize,
    /// Its name, if it is part of a page: names of its elements begin with it.
    name: Option<String>,
}

impl Svg {
    /// A white picture of a width and a height in pixels.
    pub(super) fn new([width, height]: [f64; 2]) -> Self {
        let (width, height) = (number(width), number(height));
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{FONTS}\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
        );
        Self {
            text,
            clips: 0,
            name: None,
        }
    }

    /// A picture as an element of a page, as wide as its container, with a unique name and a title for those
    /// who cannot see it.
    pub(super) fn on_page([width, height]: [f64; 2], name: &str, title: &str) -> Self {
        let (width, height) = (number(width), number(height));
        let text = format!(
            "<svg id=\"{0}\" class=\"figure\" role=\"img\" aria-label=\"{1}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"{FONTS}\">\n",
            escaped(name),
            escaped(title),
        );
        Self {
            text,
            clips: 0,
            name: Some(name.to_owned()),
        }
    }

    /// Draws one pair of axes; on a page their element has the position and the ranges as attributes.
    pub(super) fn axes(&mut self, area: &Area, [x, y]: [&str; 2], draw: impl FnOnce(&mut Self)) {
        let on_page = self.name.is_some();
        if on_page {
            let [left, top, width, height] = [area.left, area.top, area.width, area.height].map(number);
            self.add(format_args!(
                "<g class=\"axes\" data-area=\"{left} {top} {width} {height}\" data-x=\"{x}\" data-y=\"{y}\">"
            ));
        }
        draw(self);
        if on_page {
            self.add(format_args!("</g>"));
        }
    }

    /// The whole picture.
    pub(super) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    /// Adds an element.
    fn add(&mut self, element: std::fmt::Arguments<'_>) {
        // writing to a string does not fail
        let _ = self.text.write_fmt(element);
        self.text.push('\n');
    }

    /// Lines from one point to the next; `dashes` as SVG writes them.
    pub(super) fn polyline(
        &mut self,
        points: impl IntoIterator<Item = [f64; 2]>,
        colour: &str,
        width: f64,
        dashes: Option<&str>,
    ) {
        let mut places = String::new();
        for [x, y] in points {
            if !places.is_empty() {
                places.push(' ');
            }
            places.extend([number(x).as_str(), ",", number(y).as_str()]);
        }
        let dashes = dashes.map_or_else(String::new, |dashes| format!(" stroke-dasharray=\"{dashes}\""));
        self.add(format_args!(
            "<polyline points=\"{places}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" \
             stroke-linejoin=\"round\"{dashes}/>",
            escaped(colour),
            number(width),
        ));
    }

    /// A band: an outline that is filled in a paler colour.
    pub(super) fn band(&mut self, outline: Vec<[f64; 2]>, colour: &str, width: f64) {
        let places: Vec<String> = outline
            .into_iter()
            .map(|[x, y]| format!("{},{}", number(x), number(y)))
            .collect();
        self.add(format_args!(
            "<polygon points=\"{}\" fill=\"{1}\" fill-opacity=\"0.45\" stroke=\"{1}\" stroke-width=\"{2}\" \
             stroke-linejoin=\"round\"/>",
            places.join(" "),
            escaped(colour),
            number(width),
        ));
    }

    /// A disc.
    pub(super) fn disc(&mut self, [x, y]: [f64; 2], radius: f64, colour: &str) {
        self.add(format_args!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>",
            number(x),
            number(y),
            number(radius),
            escaped(colour),
        ));
    }

    /// A rectangle, filled or framed by a line of one pixel.
    pub(super) fn rectangle(&mut self, area: &Area, fill: &str, frame: &str) {
        self.add(format_args!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\" stroke=\"{}\"/>",
            number(area.left),
            number(area.top),
            number(area.width),
            number(area.height),
            escaped(fill),
            escaped(frame),
        ));
    }

    /// A picture that fills an area; its pixels have sharp edges if they are larger than those of the screen.
    #[cfg(feature = "sweep")]
    pub(super) fn picture(&mut self, area: &Area, address: &str, sharp: bool) {
        // the older value is for renderers that do not know the newer one
        let rendering = " style=\"image-rendering:optimizeSpeed;image-rendering:pixelated\"";
        let rendering = if sharp { rendering } else { "" };
        self.add(format_args!(
            "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\"{rendering} href=\"{address}\"/>",
            number(area.left),
            number(area.top),
            number(area.width),
            number(area.height),
        ));
    }

    /// Text.
    pub(super) fn text(&mut self, text: &str, lettering: &Lettering) {
        let anchor = match lettering.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let [x, y] = lettering.at;
        // capitals and digits are seven tenths of the size high
        let shift = 0.35 * lettering.size;
        let place = if lettering.upright {
            let (x, y) = (number(x + shift), number(y));
            format!("x=\"{x}\" y=\"{y}\" transform=\"rotate(-90 {x} {y})\"")
        } else {
            format!("x=\"{}\" y=\"{}\"", number(x), number(y + shift))
        };
        let fill = match lettering.colour {
            "#000000" => String::new(),
            colour => format!(" fill=\"{}\"", escaped(colour)),
        };
        self.add(format_args!(
            "<text {place} font-size=\"{}\" text-anchor=\"{anchor}\"{fill}>{}</text>",
            number(lettering.size),
            raised(&escaped(text), lettering.size),
        ));
    }

    /// Draws clipped to an area.
    pub(super) fn clipped(&mut self, area: &Area, draw: impl FnOnce(&mut Self)) {
        self.clips += 1;
        let own = self.name.as_deref().unwrap_or("axes");
        let name = format!("{own}-{}", self.clips);
        self.add(format_args!("<clipPath id=\"{name}\">"));
        self.rectangle(area, "#000000", "none");
        self.add(format_args!("</clipPath>\n<g clip-path=\"url(#{name})\">"));
        draw(self);
        self.add(format_args!("</g>"));
    }
}

/// A length or position, to a hundredth of a pixel.
fn number(value: f64) -> String {
    let text = format!("{:.2}", value.clamp(-LARGEST_COORDINATE, LARGEST_COORDINATE));
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

/// Text escaped for SVG and HTML, between tags and in attributes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A text with its parts in `_{}` as subscripts.
fn raised(text: &str, size: f64) -> String {
    let mut parts = text.split("_{");
    let mut raised = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (below, after) = part.split_once('}').unwrap_or((part, ""));
        let shift = number(0.25 * size);
        // writing to a string does not fail
        let _ = write!(
            raised,
            "<tspan dy=\"{shift}\" font-size=\"{}\">{below}</tspan>",
            number(0.75 * size)
        );
        if !after.is_empty() {
            let _ = write!(raised, "<tspan dy=\"-{shift}\">{after}</tspan>");
        }
    }
    raised
}

/// The approximate width of a text in the first of the fonts, in pixels, to a few per cent. The others are
/// narrower.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let of = |character| match character {
        'i' | 'j' | 'l' | '\'' | '¹' => 0.28,
        ' ' | ',' | '.' | ':' | ';' | '·' | '|' | 'f' => 0.34,
        't' | 'r' | '(' | ')' | '[' | ']' | '-' | '/' | 'I' => 0.4,
        '⁰' | '²'..='³' | '⁴'..='⁹' | '⁻' => 0.42,
        'c' | 's' | 'z' => 0.54,
        'm' | 'M' | 'W' | '—' => 0.98,
        '=' | '≤' | '≥' | '−' | '+' | '<' | '>' | 'w' => 0.83,
        'A'..='Z' => 0.7,
        _ => 0.63,
    };
    size * text.chars().map(of).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_bounded() {
        assert_eq!(number(12.0), "12");
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(1.239), "1.24");
        assert_eq!(number(100.0), "100");
        assert_eq!(number(f64::INFINITY), "100000");
    }

    #[test]
    fn subscripts_stand_lower() {
        assert_eq!(
            raised("v_{θ} [1/s]", 12.0),
            "v<tspan dy=\"3\" font-size=\"9\">θ</tspan><tspan dy=\"-3\"> [1/s]</tspan>"
        );
        assert_eq!(raised("ode_solvers", 12.0), "ode_solvers");
    }

    #[test]
    fn text_is_escaped() {
        let mut svg = Svg::new([10.0, 10.0]);
        let lettering = Lettering {
            at: [0.0; 2],
            anchor: Anchor::Start,
            size: 10.0,
            upright: false,
            colour: "#000000",
        };
        svg.text("|v| < 1 & \"x\"", &lettering);
        assert!(svg.finish().contains("|v| &lt; 1 &amp; &quot;x&quot;</text>"));
    }
}
