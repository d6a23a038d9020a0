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
# # The paper in one notebook
#
# N. Borda, J. Fernández, S. Grillo, *Discrete second order constrained Lagrangian systems: first results*. A system is a Lagrangian, kinematic
# constraints up to second order, and virtual displacements; the integrator follows from them.

# %%
import matplotlib.pyplot as plt
import numpy as np

import dsocs

# %% [markdown]
# ## Section 5.1: a particle with prescribed curvature
#
# The constraint is on accelerations. The force is orthogonal to the velocity, so the variations are along it.

# %%
particle = dsocs.System(
    """
    parameters { mass = 1.0, curvature = 1.0 }
    coordinates(x, y);
    lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
    let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
    variational = [(dot(x), dot(y))];
    """,
    name="particle",
)
run = particle.flow(h=0.01, q=[0.0, 0.0], v=[1.0, 1.0]).until(10.0)

# %% [markdown]
# With curvature 1 and speed √2 the path is the circle of radius 1 about (−1, 1)/√2, and the force is `m κ v² = 2`.

# %%
radius = np.hypot(run["x"] + np.sqrt(0.5), run["y"] - np.sqrt(0.5))
assert abs(radius - 1).max() < 1e-4
assert np.allclose(np.hypot(run["force_x"], run["force_y"])[1:-1], 2.0, atol=1e-3)
figure, axes = plt.subplots(figsize=(4, 4))
axes.plot(run["x"], run["y"])
axes.set_aspect("equal")
axes.set(xlabel="x", ylabel="y", title="a path of curvature 1");

# %% [markdown]
# The paper starts with `q1 = q0 + h v0`, whose error is of first order; with the acceleration, `q1 = q0 + h v0 + h²/2 a0`, the scheme shows its order 2.


# %%
def error(h: float, start: str) -> float:
    end = particle.flow(h=h, q=[0.0, 0.0], v=[1.0, 1.0], start=start).until(10.0)[-1]
    angle = np.sqrt(2) * end.t - np.pi / 4
    return float(np.hypot(end["x"] - np.cos(angle) + np.sqrt(0.5), end["y"] - np.sin(angle) - np.sqrt(0.5)))


steps = np.array([0.1, 0.05, 0.025, 0.0125])
for start, order in (("paper", 1.0), ("second-order", 2.0)):
    errors = np.array([error(h, start) for h in steps])
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    print(f"{start}: errors {errors[0]:.1e} to {errors[-1]:.1e}, slope {slope:.2f}")
    assert abs(slope - order) < 0.4

# %% [markdown]
# ## Section 5.2: the inertia wheel pendulum
#
# A pendulum with a wheel that a motor turns. The Lyapunov function `V` has its minimum upright, and is to decrease at the rate `F = ρ w tanh w`. This
# requirement contains accelerations: a constraint of second order. Its force is the motor's torque. It has the factor `w`, which is divided out.

# %%
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
    let dissipation = rho * w * w.tanh();
    kinematic = dot(lyapunov) + dissipation;
    constraint_forces = [(0, 1)];
    branch = divide(w);
    observe = [lyapunov, w];
    """,
    name="pendulum",
)
pendulum

# %%
run = pendulum.flow(h=0.05, q=[0.5, 0.0], v=[0.0, 0.5]).until(500.0)
lyapunov = run["lyapunov"][1:-1]
assert abs(lyapunov[-1] - 262.94) < 1.0    # of the continuous motion; the paper's plot suggests zero
figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7, 4))
axes[0].plot(run.t, run["theta"])
axes[0].set(ylabel="θ [rad]")
axes[1].semilogy(run.t[1:-1], lyapunov)
axes[1].set(xlabel="t [s]", ylabel="V [J]");

# %% [markdown]
# The linear model about the upright state: all real parts are negative, and one is nearly zero. That is why `V` decreases so slowly.

# %%
upright = pendulum.linearize(q=[0.0, 0.0], inputs=[])
print(upright.eigenvalues)
assert (upright.eigenvalues.real < 0).all() and upright.eigenvalues.real.max() > -1e-3
