import heyoka as hy
import numpy as np

theta, speed = hy.make_vars("theta", "speed")
rates = hy.lagrangian(speed**2 / 2 + 9.81 * hy.cos(theta), [theta], [speed])
integrator = hy.taylor_adaptive(rates, [0.0, 0.0], tol=1e-10)
starts = np.linspace(0.1, 3.0, 1000)


def begin(integrator, i):
    integrator.time = 0.0
    integrator.state[:] = [starts[i], 0.0]
    return integrator


def solve():
    ends = hy.ensemble_propagate_until(integrator, 20.0, len(starts), begin)
    return np.array([end[0].state[0] for end in ends])
