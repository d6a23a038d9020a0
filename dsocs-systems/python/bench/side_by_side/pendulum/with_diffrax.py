import diffrax
import jax
import jax.numpy as jnp

jax.config.update("jax_enable_x64", True)
i, j, m, d, e, chi, n, rho = 312.5, 2.0772, 37.98, 1.0, 1000.0, 100.0, -154.0, 2.0
g_c, h_c = d * (n + 1) * j, -d * (i + (n + 1) * j)


# momenta instead of velocities; the torque of the motor was solved for by hand
def rate(t, y, args):
    theta, psi, p1, p2 = y
    theta_rate = (p1 - p2) / i
    w = g_c * p1 + h_c * p2
    torque = chi / (i * j * d) * jnp.sin(psi - n * theta) - m * (g_c / h_c - e / (i * d * h_c)) * jnp.sin(theta)
    return jnp.array([theta_rate, p2 / j - theta_rate, m * jnp.sin(theta), torque - rho * jnp.tanh(w)])


@jax.jit
def run(start):
    control = diffrax.PIDController(rtol=1e-10, atol=1e-10)
    save = diffrax.SaveAt(ts=jnp.linspace(0, 500, 5001))
    return diffrax.diffeqsolve(
        diffrax.ODETerm(rate), diffrax.Dopri8(), 0, 500, None, start, saveat=save, stepsize_controller=control, max_steps=None
    ).ys


def solve():
    return run(jnp.array([0.5, 0.0, j * 0.5, j * 0.5]))[-1, :2]
