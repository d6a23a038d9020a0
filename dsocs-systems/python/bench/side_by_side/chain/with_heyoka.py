import heyoka as hy
import numpy as np

n, length, gravity = 8, 0.125, 9.81
theta, speed = hy.make_vars(*(f"theta{i}" for i in range(n))), hy.make_vars(*(f"v{i}" for i in range(n)))
L = sum(
    (n - i) * (
        (length * speed[i]) ** 2 / 2
        + sum((length**2 * hy.cos(theta[i] - theta[j]) * speed[i] * speed[j] for j in range(i)), hy.expression(0.0))
        + gravity * length * hy.cos(theta[i])
    )
    for i in range(n)
)
integrator = hy.taylor_adaptive(hy.lagrangian(L, theta, speed), [0.5] * n + [0.0] * n, tol=1e-10, compact_mode=True)


def solve():
    integrator.time = 0.0
    integrator.state[:] = [0.5] * n + [0.0] * n
    return integrator.propagate_grid(np.linspace(0, 10, 101))[-1][-1, :n]
