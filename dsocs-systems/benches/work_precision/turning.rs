//! Problems with rigid bodies that rotate.

use dsocs_core::dsocs;

use crate::problem::{Declared, Equations, Problem};

/// A body about a fixed point, in gravity.
#[dsocs {
    coordinates(r: rotation);
    let w = r.angular_velocity();
    let kinetic = sum(0..3, |i| moments[i] * w[i].powi(2)) / 2;
    lagrangian = kinetic - (r * arm)[2];
}]
pub struct Body {
    moments: [f64; 3],
    arm: [f64; 3],
}

/// The heavy top with three different moments of inertia and its centre of mass beside its axes.
#[derive(Clone, Copy)]
pub struct Top;

/// The moments of inertia.
const INERTIA: [f64; 3] = [2.0, 1.5, 1.0];

/// The weight times the centre of mass, in the frame of the body.
const ARM: [f64; 3] = [0.2, 0.1, 1.0];

impl Problem for Top {
    const NAME: &'static str = "top";
    const MEASURED: usize = 4;
    const END: u32 = 50;
}

impl Equations<7> for Top {
    fn start(&self) -> [f64; 7] {
        let ([a, b, c, d], [_, x, y, z]) = self.begin();
        [a, b, c, d, x, y, z]
    }

    #[inline]
    fn rate(&self, &[a, b, c, d, x, y, z]: &[f64; 7]) -> [f64; 7] {
        let [i, j, k] = INERTIA;
        let [l, m, n] = ARM;
        // the vertical, in the frame of the body
        let [e, f, g] = [
            2.0 * (b * d - a * c),
            2.0 * (a * b + c * d),
            1.0 - 2.0 * (b * b + c * c),
        ];
        [
            0.5 * (-b * x - c * y - d * z),
            0.5 * (a * x + c * z - d * y),
            0.5 * (a * y + d * x - b * z),
            0.5 * (a * z + b * y - c * x),
            ((j - k) / i) * y * z - (m / i) * g + (n / i) * f,
            ((k - i) / j) * z * x - (n / j) * e + (l / j) * g,
            ((i - j) / k) * x * y - (l / k) * f + (m / k) * e,
        ]
    }

    fn equations(&self) -> Option<[String; 7]> {
        let [i, j, k] = INERTIA;
        let [l, m, n] = ARM;
        let e = "(y1 * y3 - y0 * y2)";
        let f = "(y0 * y1 + y2 * y3)";
        let g = "(0.5 - y1**2 - y2**2)";
        Some([
            "-0.5 * (y1 * y4 + y2 * y5 + y3 * y6)".to_owned(),
            "0.5 * (y0 * y4 + y2 * y6 - y3 * y5)".to_owned(),
            "0.5 * (y0 * y5 + y3 * y4 - y1 * y6)".to_owned(),
            "0.5 * (y0 * y6 + y1 * y5 - y2 * y4)".to_owned(),
            format!(
                "({:e}) * y5 * y6 - ({:e}) * {g} + ({:e}) * {f}",
                (j - k) / i,
                2.0 * m / i,
                2.0 * n / i
            ),
            format!(
                "({:e}) * y6 * y4 - ({:e}) * {e} + ({:e}) * {g}",
                (k - i) / j,
                2.0 * n / j,
                2.0 * l / j
            ),
            format!(
                "({:e}) * y4 * y5 - ({:e}) * {f} + ({:e}) * {e}",
                (i - j) / k,
                2.0 * l / k,
                2.0 * m / k
            ),
        ])
    }
}

impl Declared<4> for Top {
    type System = Body;

    fn system(&self) -> Self::System {
        Body {
            moments: INERTIA,
            arm: ARM,
        }
    }

    fn begin(&self) -> ([f64; 4], [f64; 4]) {
        ([1.0, 0.0, 0.0, 0.0], [0.0, 0.6, -0.3, 3.0])
    }
}
