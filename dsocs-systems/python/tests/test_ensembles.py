"""The number of runs in an ensemble, its limits, and their ends."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SWING

import dsocs

PLANE = "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;"


@pytest.mark.parametrize("y", [0.5, [0.5], np.array([0.5, 0.5, 0.5])])
def test_numbers_in_a_dict_are_for_all_runs(y: object) -> None:
    plane = dsocs.System(PLANE, name="plane")
    ends = plane.ensemble(h=0.01, q={"x": np.linspace(0, 1, 3), "y": y}, v={"x": 0.0, "y": 1.0}).until(1.0)
    np.testing.assert_allclose(ends.q, [[0, 1.5], [0.5, 1.5], [1, 1.5]], rtol=1e-12)


def test_a_dict_of_numbers_is_one_start_for_all() -> None:
    plane = dsocs.System(PLANE, name="plane")
    ends = plane.ensemble(h=0.01, q={"x": 1.0, "y": 2.0}, v={"x": [0.0, 1.0, 2.0], "y": 0.0}).until(1.0)
    np.testing.assert_allclose(ends["x"], [1, 2, 3], rtol=1e-12)
    with pytest.raises(dsocs.SetupError, match="columns of different lengths: 2, 3"):
        plane.ensemble(h=0.01, q={"x": [0.0, 1.0], "y": [0.0, 1.0, 2.0]}, v=[0.0, 0.0])


@pytest.mark.parametrize("order", [2, 4])
def test_ends_have_what_is_observed(order: int) -> None:
    swing = dsocs.System(SWING, name="swing")
    lengths = np.array([0.8, 1.0, 1.3])
    ends = swing.ensemble(h=0.01, order=order, q=[[0.5], [1.0], [1.5]], v=[0.0], length=lengths).until(2.0)
    assert ends.observed.shape == (3, 1)
    np.testing.assert_allclose(ends["height"], lengths * (1 - np.cos(ends["theta"])), rtol=1e-14)
    np.testing.assert_array_equal(ends.table()["height"], ends["height"])
    single = swing.flow(h=0.01, order=order, q=[1.5], v=[0.0], length=1.3).until(2.0)
    assert ends["height"][2] == pytest.approx(single["height"][-1], rel=1e-9)


def test_more_runs_than_are_made_at_a_time() -> None:
    # 131072 runs are made at a time
    plane = dsocs.System(PLANE, name="plane")
    count = 131_072 + 1000
    x = np.linspace(-1.0, 1.0, count)
    parts: list[float] = []
    ends = plane.ensemble(h=0.5, q={"x": x, "y": 0.0}, v={"x": 1.0, "y": x}).until(1.0, progress=parts.append)
    np.testing.assert_allclose(ends.q, np.column_stack([x + 1.0, x]), rtol=1e-12, atol=1e-15)
    assert len(ends) == count and parts == sorted(parts) and all(0 <= part <= 1 for part in parts)


TURNING = """
parameters { damping = 0.1 }
coordinates(r: rotation);
let w = r.angular_velocity();
lagrangian = w.norm_squared() / 2;
external_forces = -damping * w;
"""


@pytest.mark.parametrize("v", [[1, 2, 3], [0, 1, 2, 3], {"r": [1, 2, 3]}, {"r": [0, 1, 2, 3]}, {"r_x": 1, "r_y": 2, "r_z": 3}], ids=repr)
@pytest.mark.parametrize("q", [[1, 0, 0, 0], {"r": [1, 0, 0, 0]}], ids=repr)
def test_an_angular_velocity_has_three_numbers(q: object, v: object) -> None:
    body = dsocs.System(TURNING, name="body")
    run = body.flow(h=0.01, q=q, v=v).until(0.1)  # type: ignore[arg-type]
    same = body.flow(h=0.01, q=[1, 0, 0, 0], v=[0, 1, 2, 3]).until(0.1)
    np.testing.assert_array_equal(run.q, same.q)


def test_what_is_no_rotation_is_refused() -> None:
    body = dsocs.System(TURNING, name="body")
    with pytest.raises(dsocs.SetupError, match=r"v\['r'\] has the shape \(2,\); expected 3 or 4 numbers: r_w, r_x, r_y, r_z"):
        body.flow(h=0.01, q=[1, 0, 0, 0], v={"r": [1, 2]})
    with pytest.raises(dsocs.SetupError, match="v has 2 components, but there are 3 coordinates: r_x, r_y, r_z"):
        body.flow(h=0.01, q=[1, 0, 0, 0], v=[1, 2])
    with pytest.raises(dsocs.SetupError, match=r"q\['r'\] has the shape \(3,\); expected 4 numbers"):
        body.flow(h=0.01, q={"r": [1, 0, 0]}, v=[0, 0, 0])
