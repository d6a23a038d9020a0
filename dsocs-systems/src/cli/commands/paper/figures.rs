//! The paper's figures.

use super::Results;
use crate::experiment::{ErrorRow, StartRule, fit, particle};
use crate::figure::{Axis, BLUE, Curve, Envelope, Figure, GREEN, Legend, PURPLE, Panel, Style, VERMILION};
use crate::particle::CurvedParticle;

/// The windows in which the particle is compared with the exact solution, in s.
const WINDOWS: [[f64; 2]; 2] = [[0.0, 20.0], [480.0, 500.0]];
/// The number of points of an exact curve in a window.
const CURVE_POINTS: u32 = 400;

/// The figures with the names of their files.
pub fn all(results: &Results) -> Vec<(&'static str, Figure)> {
    vec![
        ("particle-path", particle_path(results)),
        ("particle-xy", particle_xy(results)),
        (
            "particle-error",
            error_figure(&results.particle_errors, "max |x error| over [0, 500 s] [m]"),
        ),
        ("pendulum-motion", pendulum_motion(results)),
        (
            "pendulum-error",
            error_figure(&results.pendulum_errors, "max |θ error| over [0, 2000 s] [rad]"),
        ),
    ]
}

/// The particle's path: all of its turns lie on one circle, on which the nodes of the first turn are marked.
fn particle_path(results: &Results) -> Figure {
    let period = std::f64::consts::TAU / 2f64.sqrt();
    let unit = CurvedParticle::default();
    let exact = (0..=CURVE_POINTS)
        .map(|k| particle::exact(&unit, period * f64::from(k) / f64::from(CURVE_POINTS)))
        .collect();
    let nodes = || results.particle.iter().map(|node| node.q);
    let turn = results
        .particle
        .iter()
        .take_while(|node| node.t < period)
        .map(|node| node.q)
        .collect();
    let curves = vec![
        Curve {
            points: nodes().collect(),
            style: Style::Line(0.6),
            colour: "#9ecae1",
            label: Some("discrete, t ≤ 500 s, h = 0.1 s".into()),
        },
        Curve {
            points: exact,
            style: Style::Line(1.2),
            colour: VERMILION,
            label: Some("exact".into()),
        },
        Curve {
            points: turn,
            style: Style::Discs(2.4),
            colour: BLUE,
            label: Some("discrete, nodes of the first turn".into()),
        },
    ];
    let panel = Panel {
        x: Axis::linear("x [m]"),
        y: Axis::linear("y [m]"),
        curves,
        legend: Legend::At([-1.28, 0.92]),
        equal_aspect: true,
        #[cfg(feature = "sweep")]
        map: None,
    };
    Figure {
        size: [760.0, 722.0],
        columns: 1,
        panels: vec![panel],
    }
}

/// The particle's coordinates in an early and a late window.
fn particle_xy(results: &Results) -> Figure {
    let unit = CurvedParticle::default();
    let mut panels = Vec::new();
    // the first row leaves room for a legend
    for (component, (name, range)) in [("x [m]", [-1.9, 1.4]), ("y [m]", [-0.5, 2.0])]
        .into_iter()
        .enumerate()
    {
        for [from, to] in WINDOWS {
            let exact = (0..=CURVE_POINTS).map(|k| {
                let t = from + (to - from) * f64::from(k) / f64::from(CURVE_POINTS);
                [t, particle::exact(&unit, t)[component]]
            });
            let nodes = results
                .particle
                .iter()
                .filter(|node| (from..=to).contains(&node.t));
            let corner = component == 0 && from == 0.0;
            let label = |text: &str| corner.then(|| text.to_owned());
            panels.push(Panel {
                x: Axis::linear(if component == 1 { "t [s]" } else { "" }).with_range(from, to),
                y: Axis::linear(if from == 0.0 { name } else { "" }).with_range(range[0], range[1]),
                curves: vec![
                    Curve {
                        points: exact.collect(),
                        style: Style::Line(1.4),
                        colour: VERMILION,
                        label: label("exact"),
                    },
                    Curve {
                        points: nodes.map(|node| [node.t, node.q[component]]).collect(),
                        style: Style::Discs(1.8),
                        colour: BLUE,
                        label: label("discrete, h = 0.1 s"),
                    },
                ],
                ..Panel::default()
            });
        }
    }
    Figure {
        size: [980.0, 620.0],
        columns: 2,
        panels,
    }
}

/// The pendulum's angles, Lyapunov function and control torque.
fn pendulum_motion(results: &Results) -> Figure {
    let moments = &results.pendulum;
    let end = moments.last().map_or(1.0, |moment| moment.t);
    let panel = |axis: Axis, colour, last: bool, value: fn(&super::Moment) -> f64| Panel {
        x: Axis {
            without_labels: !last,
            ..Axis::linear(if last { "t [s]" } else { "" }).with_range(0.0, end)
        },
        y: axis,
        curves: vec![Curve {
            points: Envelope::of(moments.iter().map(|moment| [moment.t, value(moment)])),
            style: Style::Line(0.6),
            colour,
            label: None,
        }],
        ..Panel::default()
    };
    let panels = vec![
        panel(Axis::linear("θ [rad]"), BLUE, false, |moment| moment.theta),
        panel(Axis::linear("ψ [rad]"), GREEN, false, |moment| moment.psi),
        panel(Axis::logarithmic("V [J]"), VERMILION, false, |moment| {
            moment.lyapunov
        }),
        panel(Axis::linear("control torque [N m]"), PURPLE, true, |moment| {
            moment.torque
        }),
    ];
    Figure {
        size: [900.0, 1000.0],
        columns: 1,
        panels,
    }
}

/// Errors against the step, with the fitted lines.
fn error_figure(rows: &[ErrorRow], quantity: &str) -> Figure {
    let steps = || rows.iter().map(|row| row.h);
    let (least, greatest) = (steps().fold(f64::INFINITY, f64::min), steps().fold(0.0, f64::max));
    let mut curves = Vec::new();
    for start in StartRule::ALL {
        let (slope, intercept) = fit(rows, start);
        let line = |h: f64| [h, (intercept + slope * h.ln()).exp()];
        let (colour, style) = match start {
            StartRule::Paper => (VERMILION, Style::Discs(4.5)),
            StartRule::SecondOrder => (BLUE, Style::Squares(4.5)),
        };
        curves.push(Curve {
            points: vec![line(least), line(greatest)],
            style: Style::Dashed(1.3),
            colour,
            label: None,
        });
        curves.push(Curve {
            points: rows
                .iter()
                .filter(|row| row.start == start)
                .map(|row| [row.h, row.max_error])
                .collect(),
            style,
            colour,
            label: Some(format!("{}, fitted slope {slope:.2}", start.name())),
        });
    }
    let panel = Panel {
        x: Axis::logarithmic("step h [s]"),
        y: Axis::logarithmic(quantity),
        curves,
        ..Panel::default()
    };
    Figure {
        size: [900.0, 600.0],
        columns: 1,
        panels: vec![panel],
    }
}
