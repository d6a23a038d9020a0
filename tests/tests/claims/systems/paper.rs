//! The systems of the paper by hand; their declarations stand in `dsocs-systems`.

use dsocs_core::Real;
use dsocs_systems::{Curvature, CurvedParticle, InertiaWheelPendulum};
use dsocs_tests::independent::{Declaration, Number, rate};

/// The particle with prescribed curvature.
pub struct Particle<'a, K: Curvature>(pub &'a CurvedParticle<K>);

impl<K: Curvature> Declaration<2> for Particle<'_, K> {
    fn lagrangian<R: Number>(&self, _: [R; 2], v: [R; 2]) -> R {
        (v[0] * v[0] + v[1] * v[1]) * (0.5 * self.0.mass)
    }

    fn kinematic<R: Number>(&self, q: [R; 2], v: [R; 2], a: [R; 2]) -> Vec<R> {
        let squared = v[0] * v[0] + v[1] * v[1];
        vec![(v[0] * a[1] - a[0] * v[1]) / (squared * squared.sqrt()) - self.0.curvature.at(q[0], q[1])]
    }

    fn variational<R: Number>(&self, _: [R; 2], v: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
        vec![v]
    }
}

/// The hyperbolic tangent also where hyperbolic sines overflow, as that of `num-dual` does for `|x| > 355`.
fn tanh<R: Real>(x: R) -> R {
    let zero = R::from(0.0);
    let decay = if x < zero {
        (x * 2.0).exp()
    } else {
        (x * -2.0).exp()
    };
    let size = (-decay + 1.0) / (decay + 1.0);
    if x < zero { -size } else { size }
}

/// The inertia wheel pendulum.
pub struct Pendulum<'a>(pub &'a InertiaWheelPendulum);

impl Pendulum<'_> {
    fn factor<R: Real>(&self, v: [R; 2]) -> R {
        let &InertiaWheelPendulum { i, j, d, n, .. } = self.0;
        let [p1, p2] = self.momenta(v);
        p1 * (d * (n + 1.0) * j) - p2 * (d * (i + (n + 1.0) * j))
    }

    fn momenta<R: Real>(&self, v: [R; 2]) -> [R; 2] {
        let p2 = (v[0] + v[1]) * self.0.j;
        [v[0] * self.0.i + p2, p2]
    }

    fn lyapunov<R: Real>(&self, q: [R; 2], v: [R; 2]) -> R {
        let &InertiaWheelPendulum {
            i,
            j,
            m,
            d,
            e,
            chi,
            n,
            ..
        } = self.0;
        let (g, k) = (d * (n + 1.0) * j, -d * (i + (n + 1.0) * j));
        let [p1, p2] = self.momenta(v);
        let kinetic = p1 * p1 * ((g * g + e) / k / 2.0) + p2 * p2 * (k / 2.0) + p1 * p2 * g;
        kinetic + (-(q[1] - q[0] * n).cos() + 1.0) * chi + (-q[0].cos() + 1.0) * (m * e / d)
    }
}

impl Declaration<2> for Pendulum<'_> {
    fn lagrangian<R: Number>(&self, q: [R; 2], v: [R; 2]) -> R {
        let &InertiaWheelPendulum { i, j, m, .. } = self.0;
        let wheel = v[0] + v[1];
        v[0] * v[0] * (i / 2.0) + wheel * wheel * (j / 2.0) - (q[0].cos() + 1.0) * m
    }

    fn kinematic<R: Number>(&self, q: [R; 2], v: [R; 2], a: [R; 2]) -> Vec<R> {
        let w = self.factor(v);
        vec![rate(q, v, a, |q, v| self.lyapunov(q, v)) + w * tanh(w) * self.0.rho]
    }

    fn divide<R: Number>(&self, _: [R; 2], v: [R; 2]) -> Vec<Option<R>> {
        vec![Some(self.factor(v))]
    }

    fn variational<R: Number>(&self, _: [R; 2], _: [R; 2], _: [R; 2]) -> Vec<[R; 2]> {
        vec![[R::from(1.0), R::from(0.0)]]
    }
}
