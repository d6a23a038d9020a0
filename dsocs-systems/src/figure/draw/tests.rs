//! Tests of drawn figures.

use super::*;
use crate::figure::BLUE;

/// A figure of one panel with one curve.
fn figure(points: Vec<[f64; 2]>, style: Style) -> Figure {
    let curve = Curve {
        points,
        style,
        colour: BLUE,
        label: Some("|ψ| < θ".to_owned()),
    };
    let panel = Panel {
        x: Axis::linear("t [s]").with_range(0.0, 2.0),
        y: Axis::logarithmic("θ [rad]").with_range(1.0, 100.0),
        curves: vec![curve],
        ..Panel::default()
    };
    Figure {
        size: [400.0, 300.0],
        columns: 1,
        panels: vec![panel],
    }
}

#[test]
fn points_stand_where_the_axes_say() {
    let svg = figure(
        vec![[0.0, 1.0], [1.0, f64::NAN], [1.5, -1.0], [1.0, 10.0]],
        Style::Line(1.0),
    )
    .svg();
    // the axes reach from 92 to 374 and from 18 to 238
    assert!(svg.contains("<polyline points=\"92,238 233,128\""), "{svg}");
    assert!(
        svg.contains("<rect x=\"92\" y=\"18\" width=\"282\" height=\"220\" fill=\"none\""),
        "{svg}"
    );
}

#[test]
fn a_curve_of_one_point_is_seen() {
    let nan = [1.0, f64::NAN];
    for style in [Style::Line(1.0), Style::Dashed(1.0)] {
        let one = figure(vec![nan, [1.0, 10.0]], style).svg();
        assert!(one.contains("<circle cx=\"233\" cy=\"128\" r=\"3\""), "{one}");
        let two = figure(vec![[0.0, 1.0], nan, [1.0, 10.0]], style).svg();
        assert!(!two.contains("<circle"), "{two}");
    }
}

#[test]
fn labels_at_the_ends_of_curves_stay_in_the_frame_and_off_the_curve() {
    for (before, up) in [(100.0, false), (1.0, true)] {
        let mut figure = figure(vec![[0.0, before], [1.9, 10.0]], Style::Line(1.0));
        figure.panels[0].legend = Legend::Ends;
        figure.panels[0].curves[0].label = Some("a long label of a curve".to_owned());
        let svg = figure.svg();
        let (text, _) = svg.split_once(">a long label").unwrap();
        let (_, text) = text.rsplit_once("<text").unwrap();
        let number = |name: &str| -> f64 {
            let (_, rest) = text.split_once(&format!(" {name}=\"")).unwrap();
            rest.split('"').next().unwrap().parse().unwrap()
        };
        assert!(
            text.contains("text-anchor=\"end\"") && number("x") < 374.0,
            "{text}"
        );
        // the curve ends at 128
        assert!((number("y") < 125.0) == up, "{text}");
    }
}

/// Curves in bundles, whose ends lie on each other's lines.
#[test]
fn labels_at_the_ends_of_curves_lie_on_no_other_line() {
    for seed in 0..60_u32 {
        let slope = |k: u32| f64::from((seed * 7 + k * 13) % 17) / 17.0 - 0.5;
        let curves = (0..4_u32).map(|k| {
            let height = 20.0 + 20.0 * f64::from(k);
            let length = 1.0 + 0.25 * f64::from((seed + k) % 4);
            Curve {
                points: vec![
                    [0.0, height - 12.0 * slope(k)],
                    [length, height + 12.0 * slope(k)],
                ],
                label: Some(format!("curve {k}")),
                ..figure(Vec::new(), Style::Line(1.0)).panels[0].curves[0].clone()
            }
        });
        let mut figure = figure(Vec::new(), Style::Line(1.0));
        figure.panels[0].y = Axis::linear("θ [rad]").with_range(0.0, 100.0);
        figure.panels[0].curves = curves.collect();
        figure.panels[0].legend = Legend::Ends;
        let svg = figure.svg();
        let lines: Vec<Vec<[f64; 2]>> = svg
            .split("points=\"")
            .skip(1)
            // ticks are black
            .filter(|rest| rest.split("/>").next().unwrap().contains("#0072B2"))
            .map(|rest| {
                let pairs = rest.split('"').next().unwrap().split(' ');
                let number = |text: &str| text.parse::<f64>().unwrap();
                pairs
                    .map(|pair| pair.split_once(',').map(|(x, y)| [number(x), number(y)]).unwrap())
                    .collect()
            })
            .collect();
        assert_eq!(lines.len(), 4, "{svg}");
        let boxes: Vec<Area> = (0..4)
            .map(|k| {
                let label = format!("curve {k}");
                let (text, _) = svg.split_once(&format!(">{label}<")).unwrap();
                let (_, text) = text.rsplit_once("<text").unwrap();
                let number = |name: &str| -> f64 {
                    let (_, rest) = text.split_once(&format!(" {name}=\"")).unwrap();
                    rest.split('"').next().unwrap().parse().unwrap()
                };
                let length = width(&label, TEXT_SIZES[1]);
                let end = if text.contains("text-anchor=\"end\"") {
                    length
                } else {
                    0.0
                };
                Area {
                    left: number("x") - end,
                    top: number("y") - 0.8 * TEXT_SIZES[1],
                    width: length,
                    height: 0.8 * TEXT_SIZES[1],
                }
            })
            .collect();
        for (k, area) in boxes.iter().enumerate() {
            let crossed = lines.iter().any(|line| area.is_crossed([line[0], line[1]]));
            let met = boxes[..k].iter().any(|other| area.overlaps(other));
            assert!(!crossed && !met, "{seed}: label {k}\n{svg}");
        }
    }
}

#[test]
fn text_is_text() {
    let svg = figure(vec![[0.0, 1.0]], Style::Discs(2.0)).svg();
    for text in [">t [s]<", ">θ [rad]<", ">0.5<", ">10²<", ">|ψ| &lt; θ<"] {
        assert!(svg.contains(text), "{text} in {svg}");
    }
    assert!(svg.contains("sans-serif"));
}

#[test]
fn a_unit_has_the_same_length_on_both_axes() {
    let area = Area {
        left: 0.0,
        top: 0.0,
        width: 200.0,
        height: 100.0,
    };
    let [x, y] = of_equal_aspect([(0.0, 1.0), (-1.0, 1.0)], &area);
    assert_eq!((x, y), ((-1.5, 2.5), (-1.0, 1.0)));
}
