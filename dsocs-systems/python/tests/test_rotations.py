"""Rotations: the number of components of each vector, and results in closed form."""

from __future__ import annotations

import pickle

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


FLYING = """
parameters { inertia = [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]], torque = [0.0, 0.0, 0.0] }
coordinates(a, r: rotation, x: [3]);
let w = r.angular_velocity();
lagrangian = w.inner(inertia * w) / 2 + dot(x).norm_squared() / 2 + dot(a).powi(2) / 2 - 9.81 * x[2];
external_forces = (0, torque, [0, 0, 0]);
let momentum = r * (inertia * w);
observe = [momentum];
"""
BEGIN = {"q": {"a": 0.5, "r": [1.0, 0.0, 0.0, 0.0], "x": [1.0, 2.0, 3.0]}, "v": {"a": 0.0, "r": [0.5, -0.2, 0.3], "x": [0.0, 1.0, 2.0]}}


def test_arrays_and_rotations_are_taken_by_their_own_names() -> None:
    flying = dsocs.System(FLYING)
    run = flying.flow(h=0.05, **BEGIN).until(1.0, control=lambda node: {"torque": -0.1 * node["v_r"]})
    same = flying.flow(h=0.05, q=[0.5, 1, 0, 0, 0, 1, 2, 3], v=[0, 0.5, -0.2, 0.3, 0, 1, 2]).until(1.0, control=lambda node: {"torque": -0.1 * node.v[2:5]})
    np.testing.assert_array_equal(run.q, same.q)
    for name, expected in {
        "r": run.q[:, 1:5], "x": run.q[:, 5:], "v_r": run.v[:, 2:5], "v_x": run.v[:, 5:], "a_r": run.a[:, 2:5], "force_x": run.force[:, 5:],
        "momentum": run.observed, "torque": np.stack([run[f"torque_{i}"] for i in range(3)], axis=1),
    }.items():  # fmt: skip
        np.testing.assert_array_equal(run[name], expected)
        assert not run[name].flags.writeable, name
        if name not in ("momentum", "torque"):
            np.testing.assert_array_equal(run[-1][name], expected[-1])
    assert run["inertia"].shape == (21, 3, 3) and (run["inertia"] == [[2.0, 0.1, 0.0], [0.1, 1.5, 0.2], [0.0, 0.2, 1.0]]).all()
    points = run.sample([0.1, 0.33])
    np.testing.assert_array_equal(points["r"], points.q[:, 1:5])
    np.testing.assert_array_equal(points["momentum"], points.observed)
    for name in ("w", "v_y", "r_v", "x_", ""):
        with pytest.raises(KeyError):
            run[name]
        with pytest.raises(KeyError):
            run[-1][name]
    with pytest.raises(dsocs.SetupError, match=r"q\['x'\] has the shape \(2,\); expected 3 numbers: x_0, x_1, x_2"):
        flying.flow(h=0.05, q={**BEGIN["q"], "x": [1.0, 2.0]}, v=BEGIN["v"])
    with pytest.raises(dsocs.SetupError, match="no parameter `torques`"):
        flying.flow(h=0.05, **BEGIN).until(1.0, control=lambda node: {"torques": [1.0, 2.0, 3.0]})


def test_an_ensemble_varies_vectors_and_matrices() -> None:
    flying = dsocs.System(FLYING)
    torques, inertias = np.array([[0.1, 0.0, 0.2], [0.0, -0.3, 0.0]]), np.array([np.eye(3), np.diag([1.0, 2.0, 3.0])])
    ends = flying.ensemble(h=0.05, **BEGIN, torque=torques, inertia=inertias).until(1.0)
    for place in range(2):
        run = flying.flow(h=0.05, **BEGIN, torque=torques[place], inertia=inertias[place]).until(1.0)
        np.testing.assert_allclose(ends["r"][place], run["r"][-1], atol=1e-13)
        np.testing.assert_allclose(ends["momentum"][place], run["momentum"][-1], atol=1e-12)
    assert ends["v_r"].shape == (2, 3)
    with pytest.raises(dsocs.SetupError, match=r"torque has the shape \(5, 2\); expected \(3,\), or \(runs, 3\)"):
        flying.ensemble(h=0.05, **BEGIN, torque=np.zeros((5, 2)))


def test_a_step_that_turns_far_is_told() -> None:
    body = dsocs.System(BODY)
    fast = {"q": [1.0, 0.0, 0.0, 0.0], "v": [0.0, 0.0, 20.0]}
    with pytest.warns(dsocs.StepWarning, match=r"`r` turns by 2.0 rad in a step at t = [\d.]+: .* take `h=0.02`") as warned:
        run = body.flow(h=0.1, **fast).until(1.0)
    assert len(warned) == 1
    # a copy warns no more, and a shorter step does not warn
    pickle.loads(pickle.dumps(run))
    body.flow(h=0.05, **fast).until(1.0)
    body.flow(h=0.1, tolerance=1e-9, **fast).until(1.0)


def test_what_expressions_do_not_know_is_said() -> None:
    with pytest.raises(dsocs.SetupError, match="rotations and arrays of coordinates are said in a text"):
        dsocs.coordinates("r: rotation")


def test_inputs_of_a_linear_model_are_named_as_arrays() -> None:
    masses = dsocs.System("parameters { push = [0.0, 0.0] } coordinates(x: [2]); lagrangian = dot(x).norm_squared() / 2; external_forces = push;")
    model = masses.linearize(q={"x": [0.0, 0.0]}, v=[0.0, 0.0], inputs="push")
    assert list(model.inputs) == ["push_0", "push_1"] and model.B.shape == (4, 2)
    np.testing.assert_array_equal(model.state({"x": [1.0, 2.0]}), model.state([1.0, 2.0]))


def test_linear_models_and_costs_take_rotations_by_their_own_names() -> None:
    body = dsocs.System(BODY)
    rest = body.linearize(q={"r": [1.0, 0.0, 0.0, 0.0]}, v={"r": [0.0, 0.0, 0.0]}, inputs="torque")
    assert list(rest.inputs) == ["torque_0", "torque_1", "torque_2"]
    turned = [1.0, 1e-3, 0.0, 0.0]
    np.testing.assert_array_equal(rest.state({"r": turned}, {"r": [0.1, 0.2, 0.3]}), rest.state(turned, [0.0, 0.1, 0.2, 0.3]))
    path = body.path(1.0, h=0.1, q=[1.0, 0.0, 0.0, 0.0], v=[0.5, -0.2, 0.3])
    whole = path.gradient(lambda last: last["r"][0] + last["v_r"] @ last["v_r"])
    single = path.gradient(lambda last: last["r_w"] + last["v_r_x"] ** 2 + last["v_r_y"] ** 2 + last["v_r_z"] ** 2)
    assert whole.cost == pytest.approx(single.cost, rel=1e-15)
    np.testing.assert_allclose(whole.v, single.v, rtol=1e-13)


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The product of two quaternions."""
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


POINTS = [[1.0, 0.0, 0.0, 0.0], [0.6, 0.0, 0.8, 0.0], [-0.6, 0.0, -0.8, 0.0], [0.0, 1.0, 0.0, 0.0]]


@pytest.mark.parametrize("point", POINTS)
def test_the_state_of_a_linear_model_is_the_turn_from_its_point(point: list[float]) -> None:
    body = dsocs.System(BODY)
    model = body.linearize(q=point, v=[0.0, 0.0, 0.0], inputs=["torque"])
    assert not model.state(-np.array(point)).any()
    for axis, angle in (([0.0, 0.0, 1.0], 1.0), ([0.0, 0.0, 1.0], 0.5), ([0.48, -0.6, 0.64], 3.0)):
        there = product(np.array(point), np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * np.array(axis)]))
        for q in (there, -there):
            expected = [*(angle * np.array(axis)), 0.1, -0.2, 0.3]
            np.testing.assert_allclose(model.state(q, [0.1, -0.2, 0.3]), expected, rtol=1e-13, atol=1e-15)
            node = body.flow(h=0.01, q=q, v=[0.1, -0.2, 0.3])[0]
            np.testing.assert_allclose(model.state(node), expected, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("point", POINTS)
def test_a_regulator_brings_a_body_back_from_either_sign(point: list[float]) -> None:
    linalg = pytest.importorskip("scipy.linalg")
    body = dsocs.System(BODY)
    model = body.linearize(q=point, v=[0.0, 0.0, 0.0], inputs=["torque"])
    gain = model.B.T @ linalg.solve_continuous_are(model.A, model.B, np.eye(6), np.eye(3))
    beside = product(np.array(point), np.concatenate([[np.cos(0.5)], np.sin(0.5) * np.array([2.0, -1.0, 2.0]) / 3]))
    for q in (beside, -beside):
        run = body.flow(h=0.01, q=q, v=[0.0, 0.0, 0.0]).until(15.0, control=lambda node: {"torque": -(gain @ model.state(node))})
        assert abs(model.state(run[-1])).max() < 1e-2


def test_a_model_in_motion_compares_two_motions_at_the_same_time() -> None:
    linalg = pytest.importorskip("scipy.linalg")
    ball = dsocs.System("coordinates(r: rotation); let w = r.angular_velocity(); lagrangian = w.norm_squared() / 2;")
    spin, turn = np.array([0.5, -0.3, 0.2]), np.array([1e-4, -2e-4, 1.5e-4])
    model = ball.linearize(q=[1.0, 0.0, 0.0, 0.0], v=spin)
    np.testing.assert_allclose(model.A[:3, :3], -np.cross(spin, np.eye(3)).T, atol=1e-15)
    beside = np.concatenate([[1.0], turn / 2])
    first, other = (ball.flow(q=q / np.linalg.norm(q), v=spin, tolerance=1e-14).until(0.4)[-1] for q in (np.array([1.0, 0, 0, 0]), beside))
    expected = linalg.expm(0.4 * model.A) @ [*turn, 0.0, 0.0, 0.0]
    np.testing.assert_allclose(model.state(other, about=first), expected, atol=1e-10)
    # relative to the fixed point, not the moving one, the term of the angular velocity is half as large
    fixed = model.A.copy()
    fixed[:3, :3] += np.cross(spin, np.eye(3)).T / 2
    affine = np.block([[fixed, model.drift[:, None]], [np.zeros((1, 7))]])
    short = [ball.flow(q=beside / np.linalg.norm(beside), v=spin, tolerance=1e-14).until(t)[-1] for t in (0.02, 0.01)]
    errors = [abs(model.state(node) - (linalg.expm(t * affine) @ [*turn, 0.0, 0.0, 0.0, 1.0])[:6]).max() for node, t in zip(short, (0.02, 0.01))]
    assert errors[0] < 1e-3 * abs(turn).max()


def test_a_start_that_is_turned_far_is_told() -> None:
    link = dsocs.System(
        "coordinates(r: rotation); lagrangian = r.angular_velocity().norm_squared() - (r * [0, 0, 1])[2]; holonomic = [(r * [1, 0, 0])[1], (r * [1, 0, 0])[2]];"
    )
    near, far = ([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)] for angle in (0.3, 1.2))
    with pytest.warns(dsocs.StepWarning, match=r"the start was turned far: `r` by 1.20 rad") as warned:
        link.flow(h=0.01, q=far, v=[0.0, 0.0, 0.0], project=True).until(0.1).until(0.2)
    assert len(warned) == 1
    link.flow(h=0.01, q=near, v=[0.0, 0.0, 0.0], project=True).until(0.1)
