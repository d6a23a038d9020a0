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
# Where does the inertia wheel pendulum of the paper come to rest? Every point of a map is a run of its own, from rest at the angles θ and ψ. Runs are computed eight at
# a time in SIMD lanes, and on all cores. The environment variable `STARTS` says another number than a million.

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
    """,
    name="pendulum",
)
side = round(np.sqrt(int(os.environ.get("STARTS", 1_000_000))))
theta, psi = np.meshgrid(np.linspace(-0.6, 0.6, side), np.linspace(-3, 3, side))
starts = np.column_stack([theta.ravel(), psi.ravel()])

# %%
began = time.perf_counter()
ends = pendulum.ensemble(h=0.1, q=starts, v=[0.0, 0.5]).until(100.0, progress=True)
seconds = time.perf_counter() - began
print(f"{len(ends)} runs of 1000 steps in {seconds:.1f} s, {1e9 * seconds / (1000 * len(ends)):.0f} ns a step; {len(ends.failures)} failed")

# %% [markdown]
# What is left of the pendulum's swing after 100 s. Each run has its own end, also those that failed, of which the map shows nothing.

# %%
assert len(ends.failures) < 0.01 * len(ends)
angle = ends["theta"].reshape(side, side)
# lanes and single runs agree
for k in (0, len(starts) // 3, len(starts) - 1):
    if k not in ends.failures:
        single = pendulum.flow(h=0.1, q=starts[k], v=[0.0, 0.5]).until(100.0)[-1]
        assert abs(single["theta"] - ends["theta"][k]) < 1e-6
figure, axes = plt.subplots(figsize=(6, 4))
shown = axes.pcolormesh(theta, psi, angle, shading="nearest", cmap="twilight")
figure.colorbar(shown, label="θ after 100 s [rad]")
axes.set(xlabel="θ at the start [rad]", ylabel="ψ at the start [rad]");
