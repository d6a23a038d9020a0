//! `summary.json`: every number behind the figures.

use serde_json::{Value, json};

use super::Results;
use crate::experiment::{ErrorRow, StartRule, particle, pendulum, slope};
use crate::particle::CurvedParticle;
use crate::pendulum::InertiaWheelPendulum;

/// The summary as JSON.
pub fn json(results: &Results) -> Vec<u8> {
    let unit = CurvedParticle::default();
    let nodes = &results.particle;
    let exact: Vec<[f64; 2]> = nodes.iter().map(|node| particle::exact(&unit, node.t)).collect();
    let moments = &results.pendulum;
    let column = |value: fn(&pendulum::Moment) -> f64| moments.iter().map(value).collect::<Vec<f64>>();
    let reference = &results.reference;
    let final_value = reference.lyapunov(&InertiaWheelPendulum::default(), reference.states.len() - 1);
    let summary = json!({
        "particle": {
            "errors": errors(&results.particle_errors, "max_error_x"),
            "slope": slopes(&results.particle_errors),
            "motion": {
                "h": particle::SHOWN_STEP,
                "start": StartRule::Paper,
                "t": nodes.iter().map(|node| node.t).collect::<Vec<_>>(),
                "x": nodes.iter().map(|node| node.q[0]).collect::<Vec<_>>(),
                "y": nodes.iter().map(|node| node.q[1]).collect::<Vec<_>>(),
                "exact_x": exact.iter().map(|q| q[0]).collect::<Vec<_>>(),
                "exact_y": exact.iter().map(|q| q[1]).collect::<Vec<_>>(),
            },
        },
        "pendulum": {
            "errors": errors(&results.pendulum_errors, "max_error_theta"),
            "slope": slopes(&results.pendulum_errors),
            "reference_lyapunov_2000": final_value,
            "motion": {
                "h": pendulum::SHOWN_STEP,
                "start": StartRule::Paper,
                "t": column(|moment| moment.t),
                "theta": column(|moment| moment.theta),
                "psi": column(|moment| moment.psi),
                "torque": column(|moment| moment.torque),
            },
            "lyapunov": moments
                .iter()
                .map(|moment| json!({"t": moment.t, "value": moment.lyapunov}))
                .collect::<Vec<_>>(),
        },
    });
    format!("{summary}\n").into_bytes()
}

/// The rows of an error table.
fn errors(rows: &[ErrorRow], key: &str) -> Vec<Value> {
    rows.iter()
        .map(|row| json!({"h": row.h, "start": row.start, key: row.max_error}))
        .collect()
}

/// The fitted slopes.
fn slopes(rows: &[ErrorRow]) -> Value {
    json!({"paper": slope(rows, StartRule::Paper), "second_order": slope(rows, StartRule::SecondOrder)})
}
