"""Defaults are never silent: steps, ends and values are given or refused, and steps that are too long are reported."""

from __future__ import annotations

import copy
import json
import pickle
import warnings
from typing import Any

import numpy as np
import pytest
from conftest import SWING

import dsocs

BARE = "coordinates(x); lagrangian = dot(x).powi(2) / 2 - 8 * x.powi(2);"


def test_a_step_is_asked_for_where_no_text_says_it() -> None:
    bare = dsocs.System(BARE, name="bare")
    start: dict[str, Any] = {"q": [1.0], "v": [0.0]}
    for call in (bare.flow, bare.check, lambda **given: bare.path(1.0, **given), lambda **given: bare.ensemble(**{**given, "q": [[1.0], [2.0]]})):
        with pytest.raises(dsocs.SetupError, match="h is not given, and the text of bare has no run with a step"):
            call(**start)
    # the distance of the nodes of the continuous motion
    assert bare.flow(tolerance=1e-9, **start).h == 0.01
    # a text's run has a step
    assert dsocs.System(SWING).flow(run="far").h == 0.01


def test_an_end_is_asked_for_where_no_text_says_it() -> None:
    bare = dsocs.System(BARE, name="bare")
    run = bare.flow(h=0.01, q=[1.0], v=[0.0])
    ends = bare.ensemble(h=0.01, q=[[1.0], [2.0]], v=[0.0])
    for call in (run.until, lambda: next(run.steps()), lambda: run.watch(None, "x"), ends.until, lambda: bare.path(h=0.01, q=[1.0], v=[0.0]), lambda: bare.check(h=0.01, q=[1.0], v=[0.0])):
        with pytest.raises(dsocs.SetupError, match="is not given, and the text of bare has no run with an end"):
            call()
    assert run.until(0.5).t[-1] == 0.5


FAST = "coordinates(theta); lagrangian = dot(theta).powi(2) / 2 - (2 * PI * 50.0).powi(2) * theta.powi(2) / 2;"


@pytest.mark.parametrize("every", [1, 10])
def test_an_energy_that_explodes_is_told_once(every: int) -> None:
    fast = dsocs.System(FAST)
    with pytest.warns(dsocs.StepWarning, match="the energy grows from .* the step h = 0.01 is too long .*smaller `h`; estimate_error") as warned:
        run = fast.flow(h=0.01, q=[0.1], v=[0.0], every=every).until(1.0).until(2.0)
    assert len([one for one in warned if "the energy grows" in str(one.message)]) == 1
    assert "the energy grows" in run.page() and "--step" not in run.page()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pickle.loads(pickle.dumps(run)).until(2.1)
        # a step that resolves the motion
        fast.flow(h=0.0005, q=[0.1], v=[0.0], every=every).until(1.0)
        list(fast.flow(h=0.0005, q=[0.1], v=[0.0], every=every).steps(1.0))
    with pytest.warns(dsocs.StepWarning, match="the energy grows"):
        list(fast.flow(h=0.01, q=[0.1], v=[0.0]).steps(1.0))


def test_what_goes_to_and_fro_is_told() -> None:
    with pytest.warns(dsocs.StepWarning, match="`theta` goes to and fro from step to step.* .a smaller `h`;"):
        dsocs.System(FAST).flow(h=0.01, q=[0.1], v=[0.0]).until(1.0)


@pytest.mark.parametrize("push", [0.5, 0.9])
@pytest.mark.parametrize("h", [0.1, 0.01, 0.002])
def test_what_rests_is_not_warned_of(push: float, h: float) -> None:
    # friction holds a body against a push that is smaller: its energy is rounding
    held = dsocs.System(
        f"coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = ({push} * (1.3 * t).sin().powi(3) - dot(x).signum());",
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        held.flow(h=h, q=[0.0], v=[0.0]).until(3.0)


def test_a_controller_that_gives_energy_is_not_warned_of() -> None:
    cart = dsocs.System("parameters { u = 0.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = u;")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cart.flow(h=0.01, q=[0.0], v=[0.001]).until(20.0, control=lambda node: {"u": 1.0})


def test_values_that_are_read_cannot_be_written() -> None:
    swing = dsocs.System(SWING, name="swing")
    run = swing.flow()
    for values in (swing.parameters, run.parameters):
        with pytest.raises(dsocs.InputTypeError, match=r"cannot be changed: .*`system.flow\(length=1.2\)`"):
            values["length"] = 2.0
        with pytest.raises(dsocs.InputTypeError, match="cannot be changed"):
            values.update(length=2.0)
        assert {**values} == dict(values) == pickle.loads(pickle.dumps(values)) == copy.deepcopy(values) == json.loads(json.dumps(values))
    with pytest.raises(AttributeError):
        swing.name = "other"  # type: ignore[misc]


KEYWORDS = [
    ("tolerence", 1e-9, "did you mean the argument `tolerance`?"),
    ("oder", 4, "did you mean the argument `order`?"),
    ("dt", 0.01, "did you mean the argument `h`?"),
    ("step", 0.01, "did you mean the argument `h`?"),
    ("rtol", 1e-9, "did you mean the argument `tolerance`?"),
    ("q0", [1.0], "did you mean the argument `q`?"),
    ("x0", [1.0], "did you mean the argument `q`?"),
    ("v0", [1.0], "did you mean the argument `v`?"),
    ("t_end", 1.0, r"the end is said to flow\(…\).until\(t\)"),
    ("lenght", 1.0, "did you mean `length`?"),
]


@pytest.mark.parametrize(("name", "value", "hint"), KEYWORDS)
def test_a_keyword_that_is_misspelt_is_told_before_what_is_missing(name: str, value: Any, hint: str) -> None:
    system = dsocs.System("parameters { length = 1.0 } coordinates(theta); lagrangian = length * dot(theta).powi(2) / 2;")
    with pytest.raises(dsocs.SetupError, match=f"there is no parameter `{name}` .{hint}") as raised:
        system.flow(**{name: value})
    assert "arguments of flow: h, q, v," in str(raised.value)


def test_a_path_says_what_it_does_not_take() -> None:
    system = dsocs.System(BARE)
    for name in ("order", "tolerance", "rtol", "every"):
        with pytest.raises(dsocs.SetupError, match="a path is made of the paper's step, of order 2"):
            system.path(1.0, h=0.01, q=[1.0], v=[0.0], **{name: 4})


def test_energies_have_a_unit_where_coordinates_have_one() -> None:
    bare, swing = dsocs.System(BARE).flow(h=0.1, q=[0.0], v=[0.0]), dsocs.System(SWING).flow()
    assert bare.units["energy"] is None and bare.units["force_x"] is None
    assert swing.units["energy"] == "J" and swing.units["force_theta"] == "N m"
    np.testing.assert_array_equal(list(bare.units), bare.columns)


def test_constraints_that_nearly_depend_on_each_other_are_told_where_the_tolerance_asks_for_more() -> None:
    ball = dsocs.System("""
        coordinates(x, y, z);
        lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2 - 9.81 * z;
        let ball = x.powi(2) + y.powi(2) + z.powi(2) - 1;
        holonomic = [ball, ball + 1e-9 * (z - 0.3 * x)];
    """)
    flow = ball.flow(tolerance=1e-12, q=[0.95782628522115132, 0.0, 0.28734788556634538], v=[0.0, 1.0, 0.0])
    with pytest.warns(dsocs.StepWarning, match="holonomic constraint 2 says nothing beside those before it"):
        flow.until(1.0)
