//! A particle with a prescribed curvature that gravity brings to rest and back: its path has a cusp there. In the step in which the velocity reverses, the
//! determinant of the step's equations has the other sign, though the motion is smooth in time. The reference integrates the speed along the path and the
//! direction of the path.

use core::cell::Cell;

use dsocs_core::text::Text;
use dsocs_core::{Composition, Flow, RunError, Start, Stepper};
use dsocs_tests::text::ComposedFlow;
use proptest::prelude::*;

use super::draws;

/// The end of the motion.
const END: f64 = 3.0;

/// The curvature is `bend + sway sin t`; the particle begins at the origin, horizontally.
#[derive(Clone, Copy, Debug)]
struct Scene {
    bend: f64,
    sway: f64,
    speed: f64,
}

impl Scene {
    fn text(self) -> Text {
        let Self { bend, sway, .. } = self;
        let text = format!(
            "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y;
             let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
             kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - ({bend:?} + {sway:?} * t.sin());
             variational = [(dot(x), dot(y))];"
        );
        Text::parse("cusp", &text).unwrap()
    }

    fn start(self) -> Start<2> {
        Start::second_order([0.0, 0.0], [self.speed, 0.0])
    }

    /// The rates of position, direction of the path and speed along it; the speed is negative where the particle goes back.
    fn rates(self, t: f64, [_, _, direction, speed]: [f64; 4]) -> [f64; 4] {
        let (sin, cos) = direction.sin_cos();
        let curvature = self.bend + self.sway * t.sin();
        [speed * cos, speed * sin, curvature * speed.abs(), -sin]
    }

    /// The position at the end, by the classical method of Runge and Kutta.
    fn end(self) -> [f64; 2] {
        let count = 30_000_u32;
        let h = END / f64::from(count);
        let mut x = [0.0, 0.0, 0.0, self.speed];
        for step in 0..count {
            let t = h * f64::from(step);
            let at = |rates: [f64; 4], part: f64| -> [f64; 4] {
                core::array::from_fn(|i| x[i] + part * h * rates[i])
            };
            let k1 = self.rates(t, x);
            let k2 = self.rates(t + h / 2.0, at(k1, 0.5));
            let k3 = self.rates(t + h / 2.0, at(k2, 0.5));
            let k4 = self.rates(t + h, at(k3, 1.0));
            x = core::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        [x[0], x[1]]
    }
}

/// The end of a run, and what was noticed on the way.
fn run(run: &mut impl Stepper<2>) -> Result<([f64; 2], bool), RunError> {
    run.to(END)?;
    let warns = run.nearly_singular().is_some() || run.unresolved().is_some();
    Ok((run.node().q, warns))
}

/// A step may have no solution if it leads over the rest in the middle of a leg, where its velocities have nearly no direction.
#[test]
fn the_cusp_is_no_singularity_of_the_step() {
    let scenes = (0.5..2.0, -0.5..0.5, 0.1..0.4, 0.6..1.0);
    let (made, refused) = (Cell::new(0), Cell::new(0));
    draws::test(60, 41, scenes, &|(bend, sway, speed, part): (
        f64,
        f64,
        f64,
        f64,
    )| {
        let scene = Scene { bend, sway, speed };
        let (text, end) = (scene.text(), scene.end());
        for count in [75.0, 190.0, 410.0] {
            let h = END / f64::round(count / part);
            let mut of_order_2 = Flow::of(&text.system, h, scene.start()).unwrap();
            let mut of_order_4 =
                ComposedFlow::read(&text.system, h, Composition::SUZUKI_4, scene.start()).unwrap();
            for found in [run(&mut of_order_2), run(&mut of_order_4)] {
                let Ok((q, warns)) = found else {
                    refused.set(refused.get() + 1);
                    continue;
                };
                made.set(made.get() + 1);
                let error = (q[0] - end[0]).abs().max((q[1] - end[1]).abs());
                prop_assert!(error < 12.0 * h * h, "{scene:?} {h}: {q:?} {end:?}");
                prop_assert!(!warns, "{scene:?} {h}");
            }
        }
        Ok(())
    });
    assert!(
        100 * refused.get() <= made.get(),
        "{} of {}",
        refused.get(),
        made.get()
    );
}
