"""Rotations: how many numbers there are of what."""

from __future__ import annotations

import numpy as np
import pytest

import dsocs

TOP = """
coordinates(r: rotation, x);
let w = r.angular_velocity();
lagrangian = w[0].powi(2) + 0.75 * w[1].powi(2) + w[2].powi(2) / 2 - (r * [0.2, 0.1, 1])[2] + dot(x).powi(2) / 2;
"""


def test_a_rotation_has_four_numbers_of_position_and_three_of_velocity() -> None:
    top = dsocs.System(TOP)
    q = [1.0, 0.0, 0.0, 0.0, 0.5]
    runs = [
        top.flow(h=0.1, q=q, v=v).until(1.0)
        for v in ([0.6, -0.3, 3.0, 2.0], [0.0, 0.6, -0.3, 3.0, 2.0], {"r_x": 0.6, "r_y": -0.3, "r_z": 3.0, "x": 2.0})
    ]
    names = ["r_x", "r_y", "r_z", "x"]
    assert runs[0].columns == ["t", "r_w", *names, *(f"v_{x}" for x in names), *(f"force_{x}" for x in names), "energy"]
    for run in runs[1:]:
        np.testing.assert_array_equal(run.q, runs[0].q)
    assert runs[0].v.shape == (11, 5) and not runs[0].v[:, 0].any()
    with pytest.raises(dsocs.SetupError, match="v has 3 components, but there are 4 coordinates: r_x, r_y, r_z, x"):
        top.flow(h=0.1, q=q, v=[1.0, 2.0, 3.0])


def test_a_gradient_by_a_rotation_is_that_of_small_turns() -> None:
    top = dsocs.System(TOP)
    v = [0.6, -0.3, 3.0, 2.0]

    def height(node) -> object:  # type: ignore[no-untyped-def]
        w, x, y, z = node.q[:4]
        return w * w - x * x - y * y + z * z + node["x"] ** 2

    def path(turn: float) -> dsocs.Path:
        return top.path(h=0.1, q=[np.cos(turn / 2), np.sin(turn / 2), 0.0, 0.0, 0.5], v=v, until=1.0)

    gradient = path(0.0).gradient(height)
    assert gradient.q[0] == 0.0 and gradient.v[0] == 0.0
    ends = [path(turn).gradient(height).cost for turn in (1e-4, -1e-4)]
    assert abs(gradient.q[1] - (ends[0] - ends[1]) / 2e-4) < 1e-6
    with pytest.raises(dsocs.DerivativeError, match="the place of the scalar"):
        path(0.0).tangents("q_r_w")


BODY = """
parameters { inertia = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]], torque = [0.0, 0.0, 0.0] }
coordinates(r: rotation);
let w = r.angular_velocity();
lagrangian = w.inner(inertia * w) / 2;
external_forces = torque;
"""


def test_matrices_and_vectors_are_given_by_their_own_names() -> None:
    body = dsocs.System(BODY)
    q, v = [1.0, 0.0, 0.0, 0.0], [0.5, -0.2, 0.3]
    inertia = np.array([[1.0, 0.2, 0.1], [0.2, 3.0, 0.0], [0.1, 0.0, 2.0]])
    elements = {f"inertia_{i}_{j}": inertia[i, j] for i in range(3) for j in range(3)}
    whole, one_by_one = (body.flow(h=0.05, q=q, v=v, **given).until(1.0) for given in ({"inertia": inertia}, elements))
    np.testing.assert_array_equal(whole.q, one_by_one.q)
    assert (whole.q != body.flow(h=0.05, q=q, v=v).until(1.0).q).any()
    with pytest.raises(dsocs.SetupError, match=r"inertia has the shape \(3,\), but it is a matrix of 3 × 3 numbers"):
        body.flow(h=0.05, q=q, v=v, inertia=[1.0, 2.0, 3.0])

    def whole_torque(node: dsocs.Node) -> dict[str, object]:
        return {"torque": -0.5 * node.v[1:]}

    def elements_of_torque(node: dsocs.Node) -> dict[str, object]:
        return {f"torque_{i}": -0.5 * node.v[1 + i] for i in range(3)}

    runs = [body.flow(h=0.05, q=q, v=v).until(4.0, control=control) for control in (whole_torque, elements_of_torque)]
    np.testing.assert_array_equal(runs[0].q, runs[1].q)
    assert np.linalg.norm(runs[0].v[-1]) < 0.5 * np.linalg.norm(v)
