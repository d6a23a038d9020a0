"""The quantities of a node, and the columns of inputs that change."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ROD, SWING

import dsocs

DRIVEN = """
parameters { u = 0.0, k: [2] = [1.0, 2.0] }
coordinates(x, y);
lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - k[0] * x.powi(2) / 2 - k[1] * y.powi(2) / 2;
external_forces = (u, 0);
let power = u * dot(x);
let place = [x, y];
observe = [power, place];
"""


def driven() -> dsocs.Run:
    return dsocs.System(DRIVEN, name="driven").flow(h=0.01, q=[1.0, 0.5], v=[0.0, 0.0])


def test_a_node_has_observed_expressions_and_inputs() -> None:
    seen = []

    def control(node: dsocs.Node) -> dict[str, float]:
        seen.append((node["u"], node["power"], node["place"], node["k"], node["k_1"]))
        return {"u": -node["v_x"]}

    run = driven().until(1.0, control=control)
    assert [u for u, *_ in seen][1:] == (-run["v_x"])[:99].tolist()
    np.testing.assert_array_equal([power for _, power, *_ in seen], run["power"][:100])
    np.testing.assert_array_equal([place for _, _, place, *_ in seen], run.q[:100])
    assert all(k.tolist() == [1.0, 2.0] and one == 2.0 for *_, k, one in seen)
    for place in (0, 1, 50, -2, -1):
        node = run[place]
        assert node["u"] == run["u"][place] and node["power"] == run["power"][place]
    assert run.node["power"] == run["power"][-1]


def test_a_node_says_what_it_has() -> None:
    node = driven().node
    with pytest.raises(KeyError, match="a node has no `z`; it has t, energy, x, y, v_x, v_y, a_x, a_y, force_x, force_y, power, place_0, place_1, u, k_0, k_1"):
        node["z"]


def test_a_node_has_multipliers() -> None:
    run = dsocs.System(ROD, name="rod").flow(h=0.01, q=[0.6, -0.8], v=[0.4, 0.3]).until(0.5)
    for place in (0, 1, 30, -1):
        node = run[place]
        for one in (node, pickle.loads(pickle.dumps(node))):
            assert one["lambda_0"] == run["lambda_0"][place]
        # the force is the multiplier times the gradient of x² + y² - length²
        np.testing.assert_allclose(node["lambda_0"] * 2 * node.q, node.force, rtol=1e-12)
    with pytest.raises(KeyError, match="force_y, lambda_0, length, gravity"):
        run.node["lambda_1"]


def test_nodes_can_be_pickled_and_copied() -> None:
    run = driven().until(0.5, control=lambda node: {"u": 0.5})
    for node in (run[-1], run[0], run.node):
        for other in (pickle.loads(pickle.dumps(node)), pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(node)))), copy.copy(node), copy.deepcopy([node])[0]):
            assert repr(other) == repr(node) and other.index == node.index
            for name in ("t", "energy", "x", "v_y", "a_x", "force_x", "power", "u"):
                assert other[name] == node[name]
            np.testing.assert_array_equal(other["place"], node["place"])
            np.testing.assert_array_equal(other.q, node.q)


def test_inputs_that_changed_are_columns() -> None:
    run = driven().until(0.5)
    assert "u" not in run.columns
    run.until(1.0, control=lambda node: {"u": -node["v_x"]})
    assert run.columns[-1] == "u" and run.units["u"] is None
    np.testing.assert_array_equal(run.table()["u"], run["u"])
    assert list(pickle.loads(pickle.dumps(run)).table()) == run.columns
    page = run.page()
    assert "u = 0.0 at the start, then as shown" in page
    held = driven().set(u=1.0).until(0.1)
    assert held.columns[-1] == "u"


def test_the_page_of_a_run_that_failed_says_why() -> None:
    vanishes = dsocs.System("coordinates(x); lagrangian = (1 - t) * dot(x).powi(2) / 2 - x;")
    with pytest.raises(dsocs.StepError) as raised:
        vanishes.flow(h=0.01, q=[0], v=[0]).until(2.0)
    run = raised.value.run
    assert run is not None
    for one in (run, pickle.loads(pickle.dumps(run))):
        assert f"error: the run ends at t = {run.t[-1]:g}: " in one.page()
    assert "error: the run ends" not in dsocs.System(SWING).flow().until(1.0).page()


def test_the_page_in_a_notebook_has_no_path_of_its_kernel(tmp_path: Path) -> None:
    # the engine reads the arguments of its process
    code = "import dsocs\nprint(dsocs.System('coordinates(x); lagrangian = dot(x).powi(2) / 2;').flow(h=0.1, q=[0], v=[1]).until(1.0).page())"
    called = [sys.executable, "-c", code, "ipykernel_launcher", "-f", "/home/someone/kernel.json"]
    page = subprocess.run(called, capture_output=True, encoding="utf-8", env={**os.environ, "PYTHONIOENCODING": "utf-8"}, cwd=tmp_path, check=True).stdout
    assert "a notebook" in page and "/home/someone" not in page
