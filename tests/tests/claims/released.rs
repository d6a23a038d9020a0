//! A body that friction holds goes on where the friction ends: its normal force vanishes, its brake is released, or its law is switched
//! off. Taylor flows follow it to the tolerance, and so they do where it is held again. The references are closed forms.

use dsocs_core::text::Text;
use dsocs_core::{Flow, Start, Stepper, Tolerance};
use dsocs_tests::text::TaylorFlow;

use super::draws;

const UNTIL: f64 = 3.0;

/// A scene of one random declaration with its exact end.
struct Scene<const N: usize> {
    text: String,
    start: [[f64; N]; 2],
    /// Position and velocity at [`UNTIL`].
    end: [[f64; N]; 2],
    /// Whether no force jumps in time.
    is_continuous: bool,
}

fn check<const N: usize>(scene: &Scene<N>) {
    let text = Text::parse("released", &scene.text).unwrap();
    let start = Start::second_order(scene.start[0], scene.start[1]);
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let mut flow = TaylorFlow::read(&text.system, start, Tolerance::relative(tolerance)).unwrap();
        if let Err(error) = flow.to(UNTIL) {
            panic!("{} {tolerance}: {error}", scene.text);
        }
        let node = flow.node();
        let pairs = node
            .q
            .iter()
            .zip(&scene.end[0])
            .chain(node.v.iter().zip(&scene.end[1]));
        let error = pairs.fold(0.0_f64, |most, (found, exact)| most.max((found - exact).abs()));
        assert!(
            error < 100.0 * tolerance.max(1e-11),
            "{} {tolerance}: {error}",
            scene.text
        );
    }
    if scene.is_continuous {
        let mut flow = Flow::of(&text.system, UNTIL / 601.0, start).unwrap();
        flow.to(UNTIL).unwrap();
        assert!(
            flow.unresolved().is_none(),
            "{}: {:?}",
            scene.text,
            flow.unresolved()
        );
    }
}

/// A mass that a brake holds against a force until the brake is released at a time.
fn brake([force, more, at]: [f64; 3]) -> Scene<1> {
    let since = UNTIL - at;
    Scene {
        text: format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = -{force:?} - {:?} * dot(x).signum() * (if t < {at:?} {{ 1 }} else {{ 0 }});",
            force + more
        ),
        start: [[0.0]; 2],
        end: [[-force * since * since / 2.0], [-force * since]],
        is_continuous: false,
    }
}

/// A parcel on a belt, pressed on it by a roller that goes away, and comes back later.
fn parcel([belt, push, at]: [f64; 3]) -> Scene<1> {
    Scene {
        text: format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
             external_forces = -{push:?} * ((1 - t / {at:?}).max(0) + (t - 2.2).max(0)) * (dot(x) - {belt:?}).signum();"
        ),
        start: [[0.0], [belt]],
        end: [[belt * UNTIL], [belt]],
        is_continuous: true,
    }
}

/// A ball that falls on a springy floor with friction, without a spin, and leaves it once.
fn ball([mu, stiff, height]: [f64; 3]) -> Scene<3> {
    let (g, radius, w) = (0.5, 0.1, stiff.sqrt());
    let falls = (2.0 * (height - radius) / g).sqrt();
    let v = g * falls;
    let touches = 2.0 * (core::f64::consts::PI - (v * w / g).atan()) / w;
    let since = UNTIL - falls - touches;
    assert!(since > 0.0 && since < 2.0 * falls);
    Scene {
        text: format!(
            "coordinates(x, y, th); let n = {stiff:?} * ({radius:?} - y).max(0); let slip = dot(x) + {radius:?} * dot(th); \
             lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 + 0.002 * dot(th).powi(2) - {g:?} * y - {stiff:?} / 2 * ({radius:?} - y).max(0).powi(2); \
             let f = -{mu:?} * n * slip.signum(); external_forces = (f, 0, {radius:?} * f);"
        ),
        start: [[0.0, height, 0.0], [0.0; 3]],
        end: [
            [0.0, radius + v * since - g * since * since / 2.0, 0.0],
            [0.0, v - g * since, 0.0],
        ],
        is_continuous: true,
    }
}

/// A law that holds `v = -x` from some time on, up to a place where it is switched off.
fn sliding([force, speed, at]: [f64; 3]) -> Scene<1> {
    let slope = force - speed;
    // speed + 1 - (force - speed) t - force t²/2 = 0
    let meets = (-slope + (slope * slope + 2.0 * force * (1.0 + speed)).sqrt()) / force;
    let place = 1.0 + speed * meets - force * meets * meets / 2.0;
    let off = place * at;
    let since = UNTIL - meets - (1.0 / at).ln();
    assert!(since > 0.0 && place > 0.0);
    Scene {
        text: format!(
            "coordinates(x); lagrangian = dot(x).powi(2) / 2; \
             external_forces = -{force:?} * (dot(x) + x).signum() * (if x > {off:?} {{ 1 }} else {{ 0 }});"
        ),
        start: [[1.0], [speed]],
        end: [[off - off * since], [-off]],
        is_continuous: false,
    }
}

#[test]
fn what_friction_no_longer_holds_goes_on() {
    let numbers = [0.2..2.0, 0.3..2.0, 0.5..1.5];
    draws::test(160, 28, (0..4, numbers), &|(which, [a, b, c])| {
        match which {
            0 => check(&brake([a, b, c])),
            1 => check(&parcel([a, b, c])),
            2 => check(&ball([a, 400.0 * b, 0.6 + 0.3 * c])),
            _ => check(&sliding([2.0 + a, 0.5 * b, 0.3 + 0.4 * c])),
        }
        Ok(())
    });
}
