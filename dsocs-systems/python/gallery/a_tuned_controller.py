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
# # A controller in wind, tuned by gradients
#
# A mast on a hinge is held upright by a motor, `u = −k_p θ − k_d θ̇`, in gusts of wind. Which gains hold it best, if torque costs something? The gains are parameters of the
# declaration, the wind is a table of samples. So the cost of a whole run has an exact gradient by the gains, and an optimizer finds them.

# %%
import matplotlib.pyplot as plt
import numpy as np
import scipy.optimize

import dsocs


def gusts(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Noise with a memory of about half a second, every 0.1 s."""
    noise, wind = np.random.default_rng(seed).standard_normal(101), np.zeros(101)
    for k in range(1, 101):
        wind[k] = 0.8 * wind[k - 1] + 0.6 * noise[k]
    return np.linspace(0, 10, 101), wind


TEXT = """
    parameters {
        proportional = 15.0,
        derivative = 1.0,
        wind = samples("wind.csv"),
    }
    coordinates(theta);
    lagrangian = dot(theta).powi(2) / 2 - 9.81 * theta.cos();
    let torque = -proportional * theta - derivative * dot(theta);
    external_forces = torque + wind.at(t);
    observe = [torque];
"""
days = [dsocs.System(TEXT, name=f"day {seed}", samples={"wind": gusts(seed)}) for seed in range(4)]

# %% [markdown]
# The cost is the mean of `θ² + 0.002 u²` over the run, of four days.


# %%
def cost(gains: np.ndarray, systems: list[dsocs.System] = days) -> tuple[float, np.ndarray]:
    proportional, derivative = gains
    total, slopes = 0.0, np.zeros(2)

    def of_node(node: dsocs.Node) -> object:
        torque = -proportional * node["theta"] - derivative * node["v_theta"]
        return (node["theta"] ** 2 + 0.002 * torque**2) / 500

    for system in systems:
        path = system.path(10.0, h=0.02, q=[0.1], v=[0.0], proportional=proportional, derivative=derivative)
        found = path.gradient(of_node, of="nodes")
        # the derivative by the gains through the motion; their direct part in the cost is added by hand
        run = system.flow(h=0.02, q=[0.1], v=[0.0], proportional=proportional, derivative=derivative).until(10.0)
        torque = -proportional * run["theta"] - derivative * run["v_theta"]
        own = [-0.004 * (torque * run[name]).sum() / 500 for name in ("theta", "v_theta")]
        total += found.cost
        slopes += [found.parameters["proportional"] + own[0], found.parameters["derivative"] + own[1]]
    return total / len(systems), slopes / len(systems)


first = np.array([15.0, 1.0])
value, slopes = cost(first)
for k, unit in enumerate(np.eye(2)):
    difference = (cost(first + 1e-5 * unit)[0] - cost(first - 1e-5 * unit)[0]) / 2e-5
    assert abs(slopes[k] - difference) < 1e-5 * abs(difference), (slopes, difference)

# %%
found = scipy.optimize.minimize(cost, first, jac=True, method="L-BFGS-B", bounds=[(11, 100), (0.1, 50)])
print(f"gains {found.x.round(2)}: the cost falls from {value:.5f} to {found.fun:.5f}, with {found.nfev} gradients")
assert found.fun < 0.6 * value

# %% [markdown]
# On a day that the tuning has not seen:

# %%
other = dsocs.System(TEXT, samples={"wind": gusts(99)})
assert cost(found.x, [other])[0] < cost(first, [other])[0]
figure, axes = plt.subplots(figsize=(7, 3))
for gains, label in ((first, "before"), (found.x, "tuned")):
    run = other.flow(h=0.02, q=[0.1], v=[0.0], proportional=gains[0], derivative=gains[1]).until(10.0)
    axes.plot(run.t, run["theta"], label=label)
axes.set(xlabel="t [s]", ylabel="θ [rad]")
axes.legend();
