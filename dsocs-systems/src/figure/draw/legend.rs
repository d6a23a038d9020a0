//! The labels of curves: in a frame, or at the ends of the curves, off other lines and labels.

use super::{Axes, DASHES, FRAME_COLOUR, LEGEND_SPACE, TEXT_SIZES, plain, square};
use crate::figure::svg::{Anchor, Area, Lettering, Svg, width};
use crate::figure::{Curve, Legend, Style};

/// Height of a line of the legend, width of its sign, and space around both, in pixels.
const LEGEND_ENTRY: [f64; 3] = [19.0, 22.0, 10.0];

impl<'p> Axes<'p> {
    /// The labels of the curves.
    pub(super) fn legend(&self, svg: &mut Svg) {
        let labelled = |curve: &'p Curve| Some((curve, curve.label.as_deref()?));
        let entries: Vec<_> = self.panel.curves.iter().filter_map(labelled).collect();
        if entries.is_empty() {
            return;
        }
        let [line, sign, space] = LEGEND_ENTRY;
        let widest = entries.iter().map(|(_, label)| width(label, TEXT_SIZES[1]));
        let [left, top] = match self.panel.legend {
            Legend::TopLeft => [self.area.left + LEGEND_SPACE, self.area.top + LEGEND_SPACE / 2.0],
            Legend::At([x, y]) => [self.across(x), self.down(y)],
            Legend::Right => [self.area.right() + LEGEND_SPACE, self.area.top],
            Legend::Ends => return self.labels_at_ends(svg, &entries),
        };
        let frame = Area {
            left,
            top,
            width: widest.fold(0.0, f64::max) + sign + 3.0 * space,
            height: line * entries.len() as f64 + space,
        };
        svg.rectangle(&frame, "#ffffff", FRAME_COLOUR);
        for (place, (curve, label)) in entries.into_iter().enumerate() {
            let y = top + space / 2.0 + line * (place as f64 + 0.5);
            let x = left + space;
            let (ends, middle) = ([[x, y], [x + sign, y]], [x + sign / 2.0, y]);
            match curve.style {
                Style::Line(width) => svg.polyline(ends, curve.colour, width.max(1.2), None),
                Style::Dashed(width) => svg.polyline(ends, curve.colour, width.max(1.2), Some(DASHES)),
                Style::Discs(size) => svg.disc(middle, size.max(3.0), curve.colour),
                Style::Squares(size) => square(svg, middle, size.max(3.0), curve.colour),
            }
            svg.text(label, &plain([x + sign + space, y], Anchor::Start));
        }
    }

    /// The labels of curves at their ends: right of the last point or, where there is no room, left of it and
    /// beside the curve; within the frame, off the lines of other curves, and off each other.
    fn labels_at_ends(&self, svg: &mut Svg, entries: &[(&Curve, &str)]) {
        let shown = |point: &&[f64; 2]| self.panel.x.shows(point[0]) && self.panel.y.shows(point[1]);
        let lines: Vec<Vec<[f64; 2]>> = (self.panel.curves.iter())
            .map(|curve| {
                let points = curve.points.iter().filter(shown);
                points.map(|&[x, y]| [self.across(x), self.down(y)]).collect()
            })
            .collect();
        let mut places: Vec<_> = entries
            .iter()
            .filter_map(|(curve, label)| {
                let mut points = curve.points.iter().rev().filter(shown);
                let &[x, y] = points.next()?;
                // a curve that comes from below has room above its end, others below it
                let rises = points
                    .next()
                    .is_some_and(|&[_, before]| self.down(before) > self.down(y));
                Some(([self.across(x), self.down(y)], rises, *label, curve.colour))
            })
            .collect();
        places.sort_by(|(a, ..), (b, ..)| a[1].total_cmp(&b[1]));
        let mut taken: Vec<Area> = Vec::new();
        for ([x, y], rises, label, colour) in places {
            let length = width(label, TEXT_SIZES[1]);
            let box_of = |anchor, [x, y]: [f64; 2]| Area {
                left: if anchor == Anchor::Start { x } else { x - length },
                top: y - TEXT_SIZES[1] / 2.0,
                width: length,
                height: TEXT_SIZES[1],
            };
            // the number of obstacles of a label: other labels (weighted by 1000) and lines
            let crowd = |candidate: &Area| -> usize {
                let labels = taken.iter().filter(|other| candidate.overlaps(other)).count();
                let crossed = (lines.iter())
                    .filter(|line| line.windows(2).any(|leg| candidate.is_crossed([leg[0], leg[1]])));
                1000 * labels + crossed.count()
            };
            let mut best: Option<(usize, Anchor, [f64; 2], Area)> = None;
            for (anchor, at) in self.label_positions([x, y], rises, length) {
                let area = box_of(anchor, at);
                let crowd = crowd(&area);
                if best.as_ref().is_none_or(|(least, ..)| crowd < *least) {
                    best = Some((crowd, anchor, at, area));
                }
            }
            let Some((_, anchor, at, area)) = best else {
                continue;
            };
            taken.push(area);
            let lettering = Lettering {
                colour,
                ..plain(at, anchor)
            };
            svg.text(label, &lettering);
        }
    }

    /// Candidate positions for the label of a curve that ends at this point, the best first.
    fn label_positions(&self, [x, y]: [f64; 2], rises: bool, length: f64) -> Vec<(Anchor, [f64; 2])> {
        let within = |y: f64| {
            y.clamp(
                self.area.top + TEXT_SIZES[1],
                self.area.bottom() - TEXT_SIZES[1] / 2.0,
            )
        };
        let (right, left) = (
            x + LEGEND_SPACE / 2.0,
            x.min(self.area.right() - LEGEND_SPACE / 2.0),
        );
        let aside = if rises { -TEXT_SIZES[1] } else { TEXT_SIZES[1] };
        let mut places = Vec::new();
        if x + LEGEND_SPACE + length < self.area.right() {
            places.push((Anchor::Start, [right, within(y)]));
            for k in [0.5, -0.5, 1.0, -1.0] {
                places.push((Anchor::Start, [right, within(y + k * aside)]));
            }
        }
        for k in [1.0, -1.0, 1.5, -1.5, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0, 5.0, -5.0] {
            places.push((Anchor::End, [left, within(y + k * aside)]));
        }
        places
    }
}

impl Area {
    /// Whether two areas have points in common.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right()
            && other.left < self.right()
            && self.top < other.bottom()
            && other.top < self.bottom()
    }

    /// Whether a line segment crosses the area (Liang and Barsky's algorithm).
    pub(super) fn is_crossed(&self, [from, to]: [[f64; 2]; 2]) -> bool {
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        let sides = [[self.left, self.right()], [self.top, self.bottom()]];
        for (k, [low, high]) in sides.into_iter().enumerate() {
            let change = to[k] - from[k];
            if change == 0.0 {
                if from[k] <= low || from[k] >= high {
                    return false;
                }
                continue;
            }
            let ends = [low, high].map(|side| (side - from[k]) / change);
            first = first.max(ends[0].min(ends[1]));
            last = last.min(ends[0].max(ends[1]));
        }
        first < last
    }
}
