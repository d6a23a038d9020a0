//! A heat map: values over a plane, as colours.

use std::fmt::Write;

use base64::prelude::{BASE64_STANDARD, Engine};

use super::Axis;
use super::axis::Scale;

/// Values over a plane, cell by cell, shown as colours. By default the axes of its panel run from edge to
/// edge.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    /// The numbers of cells across and up.
    pub cells: [usize; 2],
    /// The values, row by row, the lowest row first. Values that are not finite are grey.
    pub values: Vec<f64>,
    /// The lower edge of the first cell and the upper edge of the last, across and up.
    pub edges: [[f64; 2]; 2],
    /// The quantity, scale and range of the colours.
    pub colours: Axis,
}

/// Colours from dark to light that differ evenly in grey and to colour-blind eyes, too: points of matplotlib's *viridis* (van der Walt and
/// Smith 2015), joined by straight lines.
const VIRIDIS: [[u8; 3]; 11] = [
    [68, 1, 84],
    [72, 36, 117],
    [65, 68, 135],
    [53, 95, 141],
    [42, 120, 142],
    [33, 145, 140],
    [34, 168, 132],
    [68, 191, 112],
    [122, 209, 81],
    [189, 223, 38],
    [253, 231, 37],
];

/// The colour where there is no value.
const COLOUR_WITHOUT_VALUE: [u8; 3] = [200, 200, 200];

/// The number of colours: more cannot be distinguished, and fewer make smaller pictures.
const COLOURS: u8 = 64;

/// The index of the colour where there is no value.
const INDEX_WITHOUT_VALUE: u8 = COLOURS;

impl HeatMap {
    /// The range of the colours.
    pub(super) fn range(&self) -> (f64, f64) {
        if let Some([from, to]) = self.colours.range {
            return (from, to);
        }
        let shown = self
            .values
            .iter()
            .copied()
            .filter(|&value| self.colours.shows(value));
        let (least, greatest) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), value| {
            (least.min(value), greatest.max(value))
        });
        if least < greatest {
            (least, greatest)
        } else {
            // for a constant, or without values, a range with a margin
            self.colours.range_of(self.values.iter().copied())
        }
    }

    /// The picture of the cells.
    pub(super) fn picture(&self) -> String {
        let range = self.range();
        let [across, up] = self.cells;
        let colour = |&value: &f64| {
            if self.colours.shows(value) {
                number(self.colours.scale.place(value, range))
            } else {
                INDEX_WITHOUT_VALUE
            }
        };
        // a picture begins with its top row
        let rows = self.values.chunks(across.max(1)).rev();
        let pixels: Vec<u8> = rows.flatten().map(colour).collect();
        picture([across, up], &pixels)
    }
}

/// The index of the colour at this fraction of the range.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a number of a colour
fn number(part: f64) -> u8 {
    (part.clamp(0.0, 1.0) * f64::from(COLOURS)).min(f64::from(COLOURS - 1)) as u8
}

/// The picture of all colours, the last one at the top.
pub(super) fn bar() -> String {
    let pixels: Vec<u8> = (0..COLOURS).rev().collect();
    picture([1, usize::from(COLOURS)], &pixels)
}

/// The scale and the range of a bar of colours.
pub(super) fn scale(map: &HeatMap) -> (Scale, (f64, f64)) {
    (map.colours.scale, map.range())
}

/// A picture of colours as a data URL. Empty if it cannot be made, such as without cells.
fn picture([width, height]: [usize; 2], pixels: &[u8]) -> String {
    let mut address = String::new();
    if let Some(png) = encoded([width, height], pixels) {
        // writing to a string does not fail
        let _ = write!(address, "data:image/png;base64,{}", BASE64_STANDARD.encode(png));
    }
    address
}

/// Pixels as PNG.
fn encoded([width, height]: [usize; 2], pixels: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width.try_into().ok()?, height.try_into().ok()?);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(pixels).ok()?;
    writer.finish().ok()?;
    Some(bytes)
}

/// All colours.
fn palette() -> Vec<u8> {
    let last = VIRIDIS.len() - 1;
    let colour = |number: u8| {
        let place = f64::from(number) / f64::from(COLOURS - 1) * last as f64;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a place in the table
        let below = (place as usize).min(last - 1);
        let part = place - below as f64;
        let mix = |channel: usize| {
            let [from, to] = [below, below + 1].map(|point| f64::from(VIRIDIS[point][channel]));
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between two bytes
            let mixed = (from + part * (to - from)).round() as u8;
            mixed
        };
        [0, 1, 2].map(mix)
    };
    (0..COLOURS)
        .map(colour)
        .chain([COLOUR_WITHOUT_VALUE])
        .flatten()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_become_colours() {
        let map = HeatMap {
            cells: [2, 2],
            values: vec![1.0, 10.0, f64::NAN, 1000.0],
            edges: [[0.0, 1.0]; 2],
            colours: Axis::logarithmic("V [J]"),
        };
        assert_eq!(map.range(), (1.0, 1000.0));
        let png = map.picture();
        let bytes = BASE64_STANDARD
            .decode(png.strip_prefix("data:image/png;base64,").unwrap())
            .unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; 4 * 3];
        reader.next_frame(&mut pixels).unwrap();
        // the upper row first: no value, the last colour; then the first colour, and that at a third
        assert_eq!(pixels[..4], [INDEX_WITHOUT_VALUE, COLOURS - 1, 0, COLOURS / 3]);
    }

    #[test]
    fn one_value_has_a_range() {
        for values in [vec![], vec![f64::NAN], vec![3.0]] {
            let map = HeatMap {
                cells: [values.len(), 1],
                values,
                edges: [[0.0, 1.0]; 2],
                colours: Axis::linear(""),
            };
            let (from, to) = map.range();
            assert!(from < to);
            let _ = map.picture();
        }
    }
}
