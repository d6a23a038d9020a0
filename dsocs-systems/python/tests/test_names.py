"""Parameters with the names of arguments, and names in messages."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import dsocs

CART = """
parameters { force = 0.0, a = 1.0, near = 0.0, order = 0.0, every = 0.0, tolerance = 0.5, v = 1.0 }
coordinates(x);
lagrangian = (1 + a) * dot(x).powi(2) / 2 - v * x.powi(2) / 2;
external_forces = (force + near + order + every + tolerance);
"""


@pytest.fixture
def cart() -> dsocs.System:
    return dsocs.System(CART, name="cart")


@pytest.mark.parametrize("name", ["force", "a", "near", "order", "every", "tolerance"])
def test_a_keyword_that_is_a_parameter_too_is_refused(cart: dsocs.System, name: str) -> None:
    given: dict[str, Any] = {name: 4}
    with pytest.raises(dsocs.SetupError, match=f"`{name}` is an argument of flow and also a parameter of cart: say parameters={{'{name}': …}}"):
        cart.flow(q=[0.0], v=[0.0], **given)


@pytest.mark.parametrize("call", ["flow", "path", "ensemble", "linearize", "check"])
def test_every_call_refuses_it(cart: dsocs.System, call: str) -> None:
    asked: dict[str, Any] = {"q": np.zeros((2, 1)) if call == "ensemble" else [0.0], "v": 0.0}
    with pytest.raises(dsocs.SetupError, match=f"`v` is an argument of {call} and also a parameter"):
        getattr(cart, call)(**asked)


def test_a_dict_says_which_is_meant(cart: dsocs.System) -> None:
    run = cart.flow(h=0.01, order=4, every=2, q=[0.0], v=[0.0], parameters={"v": 3.0, "order": 0.1, "every": 0.2})
    assert (run.h, run.order, run.every) == (0.01, 4, 2)
    assert (run.parameters["v"], run.parameters["order"], run.parameters["every"]) == (3.0, 0.1, 0.2)
    # a vector is not a number, so it can only be the argument
    near = cart.flow(h=0.01, q=[0.0], v=[0.0], near=[1.0])
    assert near.parameters["near"] == 0.0


def test_in_an_ensemble_a_row_may_be_a_parameter() -> None:
    system = dsocs.System("parameters { v = 1.0 } coordinates(x); lagrangian = v * dot(x).powi(2) / 2 - x.powi(2) / 2;")
    with pytest.raises(dsocs.SetupError, match=re.escape("say parameters={'v': …}")):
        system.ensemble(h=0.01, q=[[0.1], [0.2]], v=[0.0])
    assert len(system.ensemble(h=0.01, q=[[0.1], [0.2]], v=[[0.0], [0.0]]).until(0.1)) == 2
    assert len(system.ensemble(h=0.01, q=[[0.1], [0.2]], v={"x": 0.0}, parameters={"v": [1.0, 2.0]}).until(0.1)) == 2


ROD = "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - y; holonomic = x.powi(2) + y.powi(2) - 1;"


def test_messages_have_no_names_of_rust() -> None:
    rod = dsocs.System(ROD, name="rod")
    with pytest.raises(dsocs.SetupError, match="`project=True`") as raised:
        rod.flow(h=0.01, q=[1.1, 0], v=[0, 0])
    assert "::" not in str(raised.value)
    run = rod.flow(h=0.01, q=[1, 0], v=[0, 0]).until(1.0)
    with pytest.raises(dsocs.SetupError, match="a negative `h` runs back in time"):
        run.until(0.5)


def test_arrays_are_set_by_their_name() -> None:
    system = dsocs.System(
        "parameters { push: [2] = [0.0; 2] } coordinates(x: [2]); lagrangian = sum(0..2, |i| dot(x[i]).powi(2) / 2); external_forces = (push[0], push[1]);"
    )
    one, other = (system.flow(h=0.01, q=[0, 0], v=[0, 0]).until(0.5) for _ in range(2))
    one.set(push=[1.0, 2.0]).until(1.0)
    other.set(push_0=1.0).set(push_1=2.0).until(1.0)
    np.testing.assert_array_equal(one.q, other.q)
    assert one.q[-1, 1] > one.q[-1, 0] > 0
    with pytest.raises(dsocs.SetupError, match="push has the shape"):
        one.set(push=[1.0])


def test_inputs_are_columns() -> None:
    system = dsocs.System("parameters { u = 0.0, k = 1.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2 - k * x.powi(2) / 2; external_forces = u;")
    run = system.flow(h=0.01, q=[1.0], v=[0.0]).until(1.0, control=lambda node: {"u": -node["v_x"]})
    np.testing.assert_array_equal(run["u"][:-1], -run["v_x"][:-1])
    np.testing.assert_array_equal(run["k"], np.ones(101))
    some = system.flow(h=0.01, every=10, q=[1.0], v=[0.0]).until(0.5).set(u=2.0).until(1.0)
    np.testing.assert_array_equal(some["u"], [0.0] * 5 + [2.0] * 6)
    with pytest.raises(KeyError, match="there is no column `w`"):
        run["w"]
