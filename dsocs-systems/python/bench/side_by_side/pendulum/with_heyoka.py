import heyoka as hy
import numpy as np

i, j, m, d, e, chi, n, rho = 312.5, 2.0772, 37.98, 1.0, 1000.0, 100.0, -154.0, 2.0
g_c, h_c = d * (n + 1) * j, -d * (i + (n + 1) * j)
theta, psi, p1, p2 = hy.make_vars("theta", "psi", "p1", "p2")
theta_rate = (p1 - p2) / i
w = g_c * p1 + h_c * p2
# momenta instead of velocities; the torque of the motor was solved for by hand
torque = chi / (i * j * d) * hy.sin(psi - n * theta) - m * (g_c / h_c - e / (i * d * h_c)) * hy.sin(theta)
rates = [(theta, theta_rate), (psi, p2 / j - theta_rate), (p1, m * hy.sin(theta)), (p2, torque - rho * hy.tanh(w))]
integrator = hy.taylor_adaptive(rates, [0.5, 0.0, j * 0.5, j * 0.5], tol=1e-10)


def solve():
    integrator.time = 0.0
    integrator.state[:] = [0.5, 0.0, j * 0.5, j * 0.5]
    return integrator.propagate_grid(np.linspace(0, 500, 5001))[-1][-1, :2]
