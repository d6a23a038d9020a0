import numpy as np
from scipy.integrate import solve_ivp

i, j, m, d, e, chi, n, rho = 312.5, 2.0772, 37.98, 1.0, 1000.0, 100.0, -154.0, 2.0
g_c, h_c = d * (n + 1) * j, -d * (i + (n + 1) * j)


# momenta instead of velocities; the torque of the motor was solved for by hand
def rate(t, y):
    theta, psi, p1, p2 = y
    theta_rate = (p1 - p2) / i
    w = g_c * p1 + h_c * p2
    torque = chi / (i * j * d) * np.sin(psi - n * theta) - m * (g_c / h_c - e / (i * d * h_c)) * np.sin(theta)
    return theta_rate, p2 / j - theta_rate, m * np.sin(theta), torque - rho * np.tanh(w)


def solve():
    start = [0.5, 0.0, j * 0.5, j * 0.5]
    return solve_ivp(rate, (0, 500), start, "DOP853", np.linspace(0, 500, 5001), rtol=1e-10, atol=1e-10).y[:2, -1]
