# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A million starts
#
# From where does the law of the paper's inertia wheel pendulum bring it upright? Every point of a map is a run of its own: its angle θ at the start, and the velocity of
# its wheel. Runs are computed eight at a time in SIMD lanes, and on all cores. A million takes some minutes; the environment variable `STARTS` sets
# another number.

# %%
import os
import time

import matplotlib.pyplot as plt
import numpy as np

import dsocs

pendulum = dsocs.System(
    """
    parameters { i = 312.5, j = 2.0772, m = 37.98, d = 1.0, e = 1000.0, chi = 100.0, n = -154.0, rho = 2.0 }
    coordinates(theta, psi);
    lagrangian = i / 2 * dot(theta).powi(2) + j / 2 * (dot(theta) + dot(psi)).powi(2) - m * (1 + theta.cos());
    let a = 1 / i;
    let b = -1 / i;
    let c = 1 / i + 1 / j;
    let g_c = d * (n * a - b) * (i * j);
    let h_c = d * (n * b - c) * (i * j);
    let f = (g_c.powi(2) + e) / h_c;
    let p1 = (i + j) * dot(theta) + j * dot(psi);
    let p2 = j * (dot(theta) + dot(psi));
    let w = g_c * p1 + h_c * p2;
    let lyapunov = f / 2 * p1.powi(2) + h_c / 2 * p2.powi(2) + g_c * p1 * p2
        + chi * (1 - (psi - n * theta).cos()) + m * e / d * (1 - theta.cos());
    kinematic = dot(lyapunov) + rho * w * w.tanh();
    constraint_forces = [(0, 1)];
    branch = divide(w);
    observe = [lyapunov];
    """,
    name="pendulum",
)
side = round(np.sqrt(int(os.environ.get("STARTS", 1_000_000))))
theta, wheel = np.meshgrid(np.linspace(-1.2, 1.2, side), np.linspace(-1.5, 1.5, side))
q = np.column_stack([theta.ravel(), np.zeros(theta.size)])
v = np.column_stack([np.zeros(theta.size), wheel.ravel()])

# %%
began = time.perf_counter()
ends = pendulum.ensemble(h=0.1, q=q, v=v).until(400.0, progress=True)
seconds = time.perf_counter() - began
print(f"{len(ends)} runs of 4000 steps in {seconds:.1f} s, {1e9 * seconds / (4000 * len(ends)):.0f} ns a step; {len(ends.failures)} failed")

# %% [markdown]
# The Lyapunov function at the ends. Where it is small, the pendulum is upright and nearly at rest; elsewhere it stays near a saddle. A run that failed does not end the others:
# the map has a hole there, and `ends.failures` says why.


# %%
def lyapunov(theta: np.ndarray, psi: np.ndarray, v_theta: np.ndarray, v_psi: np.ndarray) -> np.ndarray:
    i, j, m, d, e, chi, n = (pendulum.parameters[name] for name in ("i", "j", "m", "d", "e", "chi", "n"))
    a, b, c = 1 / i, -1 / i, 1 / i + 1 / j
    g_c, h_c = d * (n * a - b) * i * j, d * (n * b - c) * i * j
    p1, p2 = (i + j) * v_theta + j * v_psi, j * (v_theta + v_psi)
    kinetic = (g_c**2 + e) / h_c / 2 * p1**2 + h_c / 2 * p2**2 + g_c * p1 * p2
    return kinetic + chi * (1 - np.cos(psi - n * theta)) + m * e / d * (1 - np.cos(theta))


left = lyapunov(*(ends[name] for name in ("theta", "psi", "v_theta", "v_psi")))
assert len(ends.failures) < 0.01 * len(ends)
# lanes and single runs agree; a start at rest, where V is zero, has nothing to compare
moving = np.flatnonzero(left > 0)
for k in moving[[len(moving) // 5, len(moving) // 2]]:
    single = pendulum.flow(h=0.1, q=q[k], v=v[k]).until(400.0)
    assert abs(single["lyapunov"][-1] - left[k]) < 1e-6 * left[k]
figure, axes = plt.subplots(figsize=(6, 4))
shown = axes.pcolormesh(theta, wheel, np.log10(np.maximum(left, 1e-30).reshape(side, side)), shading="nearest")
figure.colorbar(shown, label="log₁₀ of V after 400 s [J]")
axes.set(xlabel="θ at the start [rad]", ylabel="velocity of the wheel at the start [rad/s]");
