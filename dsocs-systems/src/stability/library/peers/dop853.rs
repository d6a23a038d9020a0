//! The Runge–Kutta method: its figures, and those of the discrete flow beside it.

use std::error::Error;
use std::time::Instant;

use dsocs_core::{Flow, Start, Stepper};
use ode_solvers::dop_shared::OutputType;
use ode_solvers::{Dop853, SVector, System};

use super::{Bar, Report};
use crate::experiment::pendulum::{Q0, V0};
use crate::pendulum::InertiaWheelPendulum;
use crate::stability::larger;

/// A state of two positions and two velocities or momenta.
type State = SVector<f64, 4>;

/// The largest number of steps of a run.
const MAX_STEPS: u32 = 100_000_000;

/// The particle with curvature 1: its acceleration is `|v|` times the velocity turned to the left.
struct Turning;

impl System<f64, State> for Turning {
    fn system(&self, _: f64, state: &State, rate: &mut State) {
        let [_, _, u, v] = (*state).into();
        let speed = u.hypot(v);
        *rate = State::from([u, v, -speed * v, speed * u]);
    }
}

/// The pendulum on its proper branch.
struct Switched(InertiaWheelPendulum);

impl System<f64, State> for Switched {
    fn system(&self, _: f64, state: &State, rate: &mut State) {
        *rate = self.0.proper_branch((*state).into()).into();
    }
}

/// The state at the end of a run, and the number of evaluations of the right-hand side.
fn integrate<F: System<f64, State>>(
    system: F,
    until: f64,
    start: [f64; 4],
    tolerance: f64,
) -> Result<([f64; 4], u32), Box<dyn Error>> {
    let mut solver = Dop853::from_param(
        system,
        0.0,
        until,
        until,
        State::from(start),
        tolerance,
        tolerance,
        0.9,
        0.0,
        0.333,
        6.0,
        until,
        0.0,
        MAX_STEPS,
        MAX_STEPS,
        OutputType::Sparse,
    );
    let stats = solver.integrate()?;
    let end = solver.y_out().last().ok_or("no steps")?;
    Ok(((*end).into(), stats.num_eval))
}

/// The particle to the time `until`: the drift of its energy.
pub(super) fn particle(report: &mut Report<'_>, until: f64) {
    for tolerance in [1e-6, 1e-9, 1e-12] {
        report.measure_all(
            [
                (
                    format!(
                        "particle to t = {until:e}, Dop853 at {tolerance:e}: relative drift of the energy"
                    ),
                    Bar::Reported,
                ),
                ("the same: time [s]".to_owned(), Bar::Reported),
            ],
            || {
                let begun = Instant::now();
                let ([.., u, v], _) = integrate(Turning, until, [0.0, 0.0, 1.0, 1.0], tolerance)?;
                Ok([
                    (f64::midpoint(u * u, v * v) - 1.0).abs(),
                    begun.elapsed().as_secs_f64(),
                ])
            },
        );
    }
}

/// The pendulum with a switch that is sharper for larger `ρ`: evaluations of both codes, and the distance of
/// their final states.
pub(super) fn pendulum(report: &mut Report<'_>) {
    let seconds = if report.quick { 20.0 } else { 500.0 };
    for rho in [2.0, 20.0, 200.0, 2000.0] {
        let pendulum = InertiaWheelPendulum {
            rho,
            ..InertiaWheelPendulum::default()
        };
        report.measure_all(
            [
                (
                    format!("pendulum to t = {seconds}, ρ = {rho}: evaluations of Dop853 at 1e-6"),
                    Bar::Reported,
                ),
                (
                    "the same: evaluations of the discrete flow, h = 0.1".to_owned(),
                    Bar::Reported,
                ),
                (
                    "the same: difference in θ at the end [rad]".to_owned(),
                    Bar::Reported,
                ),
            ],
            || switched(pendulum, seconds),
        );
    }
}

/// Evaluations of both codes, and the distance of their final states.
fn switched(pendulum: InertiaWheelPendulum, until: f64) -> Result<[f64; 3], Box<dyn Error>> {
    let [p1, p2] = pendulum.momentum(V0);
    let (end, evaluations) = integrate(Switched(pendulum), until, [Q0[0], Q0[1], p1, p2], 1e-6)?;
    let mut flow = Flow::new(&pendulum, 0.1, Start::second_order(Q0, V0))?;
    let mut own = 0;
    while flow.time() < until - 0.05 {
        own += flow.advance()?.iterations;
    }
    let apart = larger(0.0, (flow.position()[0] - end[0]).abs());
    Ok([f64::from(evaluations), f64::from(own), apart])
}
