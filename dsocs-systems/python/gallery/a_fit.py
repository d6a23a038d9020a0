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
# # A fit
#
# A pendulum with friction was filmed at 20 pictures a second. We look for its length, its friction and its first angle. The gradient of the sum of squares by all of
# them is exact, and costs two to four runs, whatever their number.

# %%
import matplotlib.pyplot as plt
import numpy as np
import scipy.optimize

import dsocs

swing = dsocs.System(
    """
    parameters {
        /// The length [m]
        length = 1.0,
        /// The friction, per mass [1/s]
        friction = 0.0,
    }
    coordinates(theta);
    lagrangian = (length * dot(theta)).powi(2) / 2 + 9.81 * length * theta.cos();
    external_forces = -friction * length.powi(2) * dot(theta);
    """,
    name="swing",
)

# %% [markdown]
# The measurements, with a noise of 0.02 rad. A picture belongs to every fifth node.

# %%
truth = {"length": 1.3, "friction": 0.15}
film = swing.flow(h=0.01, q=[1.2], v=[0.0], every=5, **truth).until(8.0)
measured = film["theta"] + 0.02 * np.random.default_rng(7).standard_normal(len(film.t))


# %%
def cost(unknown: np.ndarray) -> tuple[float, np.ndarray]:
    length, friction, angle = unknown
    path = swing.path(8.0, h=0.01, q=[angle], v=[0.0], length=length, friction=friction)

    def of_node(node: dsocs.Node) -> object:
        return (node["theta"] - measured[node.index // 5]) ** 2 if node.index % 5 == 0 else 0.0

    gradient = path.gradient(of_node, of="nodes")
    return gradient.cost, np.array([gradient.parameters["length"], gradient.parameters["friction"], gradient.q[0]])


found = scipy.optimize.minimize(cost, [1.15, 0.05, 1.0], jac=True, method="L-BFGS-B", bounds=[(0.5, 3), (0, 1), (0, 2)])
print(f"length {found.x[0]:.4f}, friction {found.x[1]:.4f}, angle {found.x[2]:.4f} after {found.nfev} gradients")
assert np.allclose(found.x, [1.3, 0.15, 1.2], rtol=0.05)

# %% [markdown]
# The gradient against differences, and what is left, which is the noise.

# %%
value, gradient = cost(found.x + 0.02)
shift = 1e-6
numbers = [(cost(found.x + 0.02 + shift * unit)[0] - cost(found.x + 0.02 - shift * unit)[0]) / (2 * shift) for unit in np.eye(3)]
assert np.allclose(gradient, numbers, rtol=1e-5)
fitted = swing.flow(h=0.01, q=[found.x[2]], v=[0.0], every=5, length=found.x[0], friction=found.x[1]).until(8.0)
assert 0.015 < np.std(measured - fitted["theta"]) < 0.025
figure, axes = plt.subplots(figsize=(7, 3))
axes.plot(film.t, measured, ".", label="measured")
axes.plot(fitted.t, fitted["theta"], label="fitted")
axes.set(xlabel="t [s]", ylabel="θ [rad]")
axes.legend();
