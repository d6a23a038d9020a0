import diffrax
import jax
import jax.numpy as jnp

jax.config.update("jax_enable_x64", True)


# Lagrange's equation was derived by hand
def rate(t, y, args):
    return jnp.array([y[1], -9.81 * jnp.sin(y[0])])


@jax.jit
@jax.vmap
def run(start):
    control = diffrax.PIDController(rtol=1e-10, atol=1e-10)
    return diffrax.diffeqsolve(
        diffrax.ODETerm(rate), diffrax.Dopri8(), 0, 20, None, start, stepsize_controller=control, max_steps=None
    ).ys[-1, 0]


def solve():
    starts = jnp.linspace(0.1, 3.0, 1000)
    return run(jnp.stack([starts, jnp.zeros(1000)], 1))
