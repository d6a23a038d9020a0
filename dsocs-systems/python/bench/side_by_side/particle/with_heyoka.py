import heyoka as hy
import numpy as np

x, y, vx, vy = hy.make_vars("x", "y", "vx", "vy")
# the constraint force, orthogonal to the motion, was solved for by hand
speed = hy.sqrt(vx**2 + vy**2)
rates = [(x, vx), (y, vy), (vx, -speed * vy), (vy, speed * vx)]
integrator = hy.taylor_adaptive(rates, [0.0, 0.0, 1.0, 1.0], tol=1e-10)


def solve():
    integrator.time = 0.0
    integrator.state[:] = [0.0, 0.0, 1.0, 1.0]
    return integrator.propagate_grid(np.linspace(0, 500, 5001))[-1][-1, :2]
