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
# # A regulator (LQR)
#
# A cart with a pole: its states of rest, its linear models, and a regulator that holds the pole up.

# %%
import matplotlib.pyplot as plt
import numpy as np
import scipy.linalg

import dsocs

cart = dsocs.System(
    """
    parameters { cart = 1.0, mass = 0.2, length = 0.5, gravity = 9.81, force = 0.0 }
    coordinates(
        /// The cart [m]
        x,
        /// The pole, from above [rad]
        theta
    );
    lagrangian = (cart + mass) / 2 * dot(x).powi(2) + mass * length * theta.cos() * dot(x) * dot(theta)
        + mass / 2 * (length * dot(theta)).powi(2) - mass * gravity * length * theta.cos();
    external_forces = (force, 0);
    """,
    name="cart",
)
cart.equilibria([[0.0, 0.1], [0.0, 3.0]])

# %% [markdown]
# Three lines:

# %%
model = cart.linearize(q=[0.0, 0.0], inputs="force")
P = scipy.linalg.solve_continuous_are(model.A, model.B, np.diag([1.0, 10.0, 1.0, 1.0]), np.eye(1))
K = model.B.T @ P

# %%
print("gain", K.round(2), "poles", np.linalg.eigvals(model.A - model.B @ K).round(2))
run = cart.flow(h=0.005, q=[0.0, 0.4], v=[0.0, 0.0])
run.until(8.0, control=lambda node: {"force": -(K @ model.state(node))[0]})
assert abs(run["theta"][-1]) < 1e-3

# %% [markdown]
# ## The same at 50 Hz, with noisy measurements
#
# The model of the step takes the sampling into account: the force is held for 0.02 s. A steady Kalman filter estimates the state from the position of the cart and the
# angle alone. (For the run we make ten steps between two samples.)

# %%
sampled = cart.linearize(q=[0.0, 0.0], inputs="force", outputs=["x", "theta"], h=0.02)
S = scipy.linalg.solve_discrete_are(sampled.A, sampled.B, np.diag([1.0, 10.0, 1.0, 1.0]), np.eye(1))
K = np.linalg.solve(np.eye(1) + sampled.B.T @ S @ sampled.B, sampled.B.T @ S @ sampled.A)
noise = np.diag([2e-3, 2e-3]) ** 2
Q = sampled.B @ sampled.B.T * 0.1**2 + 1e-9 * np.eye(4)
E = scipy.linalg.solve_discrete_are(sampled.A.T, sampled.C.T, Q, noise)
L = E @ sampled.C.T @ np.linalg.inv(sampled.C @ E @ sampled.C.T + noise)
assert abs(np.linalg.eigvals(sampled.A - sampled.B @ K)).max() < 1
assert abs(np.linalg.eigvals(sampled.A - L @ sampled.C @ sampled.A)).max() < 1

# %%
rng = np.random.default_rng(1)
estimate, force = np.array([0.0, 0.2, 0.0, 0.0]), 0.0


def controller(node: dsocs.Node) -> dict[str, float]:
    global estimate, force
    foreseen = sampled.A @ estimate + sampled.B[:, 0] * force
    measured = node.q + 2e-3 * rng.standard_normal(2)
    estimate = foreseen + L @ (measured - sampled.C @ foreseen)
    force = float(-(K @ estimate)[0])
    return {"force": force}


noisy = cart.flow(h=0.002, q=[0.0, 0.2], v=[0.0, 0.0]).until(10.0, control=controller, control_every=10)
assert abs(noisy["theta"][-500:]).max() < 0.05
figure, axes = plt.subplots(figsize=(7, 3))
axes.plot(run.t, run["theta"], label="all is measured")
axes.plot(noisy.t, noisy["theta"], label="50 Hz, noise")
axes.set(xlabel="t [s]", ylabel="θ [rad]")
axes.legend();
