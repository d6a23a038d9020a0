"""Gradients of whole runs whose starts are bound by constraints, against differences."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROD

import dsocs

SLEIGH = """
parameters { mass = 1.0, inertia = 0.4, offset = 0.3 }
coordinates(x, y, theta);
lagrangian = mass * (dot(x).powi(2) + dot(y).powi(2)) / 2 + inertia * dot(theta).powi(2) / 2;
nonholonomic = dot(y) * theta.cos() - dot(x) * theta.sin() - offset * dot(theta);
"""


def difference(end: object, shift: float = 1e-3) -> float:
    """A difference quotient of fourth order."""
    assert callable(end)
    far, near, back, behind = (end(k * shift) for k in (2, 1, -1, -2))
    return float((8 * (near - back) - (far - behind)) / (12 * shift))


@pytest.mark.parametrize("start", ["second-order", "paper"])
def test_a_start_on_a_rod_moves_with_parameters(start: str) -> None:
    rod = dsocs.System(ROD, name="rod")

    def end(by: float) -> float:
        return float(rod.flow(h=0.05, q=[1, 0], v=[0, 0.5], start=start, gravity=9.81 + by).until(2.0)["x"][-1])

    path = rod.path(2.0, h=0.05, q=[1, 0], v=[0, 0.5], start=start)
    found = path.gradient(lambda last: last["x"])
    assert found.cost == path.end["x"]
    assert found.parameters["gravity"] == pytest.approx(difference(end), rel=1e-8)
    assert path.tangents("gravity")["gravity"][0][0] == pytest.approx(found.parameters["gravity"], rel=1e-12)


@pytest.mark.parametrize("name", ["length", "gravity", "q", "v"])
def test_a_start_that_is_projected_is_differentiated(name: str) -> None:
    rod = dsocs.System(ROD, name="rod")

    def given(by: float) -> dict[str, object]:
        q, v = np.array([0.6, -0.9]), np.array([0.5, 0.2])
        if name == "q":
            q[0] += by
        elif name == "v":
            v[1] += by
        values = {"length": 1.0, "gravity": 9.81}
        if name in values:
            values[name] += by
        return {"h": 0.05, "q": q, "v": v, "project": True, "parameters": values}

    def end(by: float) -> float:
        return float(rod.flow(**given(by)).until(1.0)["y"][-1])  # type: ignore[arg-type]

    found = rod.path(1.0, **given(0.0)).gradient(lambda last: last["y"])  # type: ignore[arg-type]
    value = found.q[0] if name == "q" else found.v[1] if name == "v" else found.parameters[name]
    assert value == pytest.approx(difference(end), rel=1e-8)


def test_a_start_of_a_sleigh_moves_with_its_offset() -> None:
    sleigh = dsocs.System(SLEIGH, name="sleigh")
    start = dict(h=0.05, q=[0.1, 0.2, 0.3], v=[1.0, 0.4, 0.5], project=True)

    def end(by: float) -> float:
        return float(sleigh.flow(**start, offset=0.3 + by).until(1.0)["x"][-1])  # type: ignore[arg-type]

    found = sleigh.path(1.0, **start).gradient(lambda last: last["x"])  # type: ignore[arg-type]
    assert found.parameters["offset"] == pytest.approx(difference(end), rel=1e-8)


def test_a_cost_at_some_nodes() -> None:
    rod = dsocs.System(ROD, name="rod")
    path = rod.path(1.0, h=0.05, q=[1, 0], v=[0, 0.5])
    places = [0, 7, -1]
    found = path.gradient(lambda node: node["x"] ** 2, of="nodes", at=places)
    wanted = {index % 21 for index in places}
    same = path.gradient(lambda node: node["x"] ** 2 if node.index in wanted else 0.0 * node["x"], of="nodes")
    assert found.cost == same.cost and found.parameters == same.parameters
    run = rod.flow(h=0.05, q=[1, 0], v=[0, 0.5]).until(1.0)
    assert found.cost == pytest.approx(float((run["x"][[0, 7, 20]] ** 2).sum()), rel=1e-14)
    with pytest.raises(dsocs.SetupError, match="the last one has the number 20"):
        path.gradient(lambda node: node["x"], of="nodes", at=[21])
    with pytest.raises(dsocs.SetupError, match="of='nodes'"):
        path.gradient(lambda node: node["x"], at=[1])


def test_a_cost_takes_arrays_of_coordinates() -> None:
    masses = dsocs.System("parameters { k = 2.0 } coordinates(x: [2]); lagrangian = dot(x).norm_squared() / 2 - k * x[0].powi(2) * x[1].powi(2);")
    path = masses.path(1.0, h=0.1, q={"x": [1.0, 0.5]}, v={"x": [0.0, 0.3]})
    whole = path.gradient(lambda last: last["x"] @ last["x"] + last["v_x"][1])
    single = path.gradient(lambda last: last["x_0"] ** 2 + last["x_1"] ** 2 + last["v_x_1"])
    assert whole.cost == pytest.approx(single.cost, rel=1e-15)
    np.testing.assert_allclose(whole.q, single.q, rtol=1e-14)
    np.testing.assert_allclose(whole.parameters["k"], single.parameters["k"], rtol=1e-14)


def test_ctrl_c_in_a_cost_ends_a_gradient(swing: dsocs.System) -> None:
    def cost(last: object) -> float:
        raise KeyboardInterrupt

    with pytest.raises(dsocs.Interrupted, match="interrupted: no derivative is known"):
        swing.path(0.1).gradient(cost)
