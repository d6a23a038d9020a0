import numpy as np
from scipy.integrate import solve_ivp

starts = np.linspace(0.1, 3.0, 1000)


# Lagrange's equation was derived by hand
def rate(t, y):
    return y[1], -9.81 * np.sin(y[0])


def solve():
    return np.array([solve_ivp(rate, (0, 20), [q, 0.0], "DOP853", rtol=1e-10, atol=1e-10).y[0, -1] for q in starts])
