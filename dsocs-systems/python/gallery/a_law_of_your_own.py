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
# # A Lyapunov law for a system of your own
#
# Two carts on a rail are joined by a spring, a second spring ties the first cart to a wall, and a motor pushes the second cart. We want the energy `V`
# to decrease at the rate `F = k ẏ²`. We need not solve for the motor's force: we declare `V` and `F`, and say where the motor acts.

# %%
import matplotlib.pyplot as plt
import numpy as np

import dsocs

x, y = dsocs.coordinates("x", "y")
mass = dsocs.parameter("mass", 1.0, "The mass of a cart [kg]")
stiffness = dsocs.parameter("stiffness", 4.0, "The stiffness of a spring [N/m]")
gain = dsocs.parameter("gain", 0.8, "The gain k [kg/s]")

kinetic = mass / 2 * (dsocs.dot(x) ** 2 + dsocs.dot(y) ** 2)
potential = stiffness / 2 * (x**2 + (y - x) ** 2)
V = kinetic + potential
F = gain * dsocs.dot(y) ** 2

carts = dsocs.System.of(
    coordinates=(x, y),
    lagrangian=kinetic - potential,
    kinematic=dsocs.dot(V) + F,             # dV/dt = −F
    constraint_forces=[(0, 1)],             # the motor acts on the second cart
    branch=dsocs.dot(y),                    # a cart at rest obeys dV/dt = −F whatever the motor does
    observe={"V": V},
    name="carts",
)
print(carts.text)

# %%
run = carts.flow(h=0.01, q=[0.3, -0.2], v=[0.0, 0.5]).until(20.0)
inner = slice(1, -1)
assert run["V"][-2] < 0.02 * run["V"][1]

# %% [markdown]
# The constraint force is the control law. Here it is one that we know: a damper, `u = −k ẏ`.

# %%
assert np.allclose(run["force_y"][inner], -0.8 * run["v_y"][inner], atol=1e-9)
figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7, 4))
axes[0].semilogy(run.t[inner], run["V"][inner])
axes[0].set(ylabel="V [J]")
axes[1].plot(run.t[inner], run["force_y"][inner])
axes[1].set(xlabel="t [s]", ylabel="u [N]");

# %% [markdown]
# The linear model of the system *with its law* about the target: stable, and the row of the force is the gain.

# %%
target = carts.linearize(q=[0.0, 0.0], inputs=[], outputs=["force_y"])
print(dict(zip(target.states, target.C[0])))
assert (target.eigenvalues.real < 0).all()
assert np.allclose(target.C, [[0, 0, 0, -0.8]], atol=1e-12)

# %% [markdown]
# Are the paper's theorems met on this motion, and is it accurate?

# %%
assert run.check().ok
run.estimate_error()
