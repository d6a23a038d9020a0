"""Linear models and equilibria: by hand, against scipy and python-control, and against the command line."""

from __future__ import annotations

import copy
import json
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import BEADS, FRICTION, run_program

import dsocs

CART = """\
//! A cart with a pole, driven by a force.
parameters { cart = 1.5, mass = 0.3, length = 0.7, gravity = 9.81, force = 0.0 }
coordinates(
    /// The cart [m]
    x,
    /// The pole, from above [rad]
    theta
);
lagrangian = (cart + mass) / 2 * dot(x).powi(2) + mass * length * theta.cos() * dot(x) * dot(theta)
    + mass / 2 * (length * dot(theta)).powi(2) - mass * gravity * length * theta.cos();
external_forces = (force, 0);
let height = length * theta.cos();
observe = [height];
"""
cart = dsocs.System(CART, name="cart")


def test_a_cart_pole_by_hand() -> None:
    model = cart.linearize(q=[0.0, 0.0], inputs="force", outputs=["theta", "a_x", "height"])
    by_angle, turn = -0.3 * 9.81 / 1.5, 1.8 * 9.81 / (1.5 * 0.7)
    np.testing.assert_allclose(model.A, [[0, 0, 1, 0], [0, 0, 0, 1], [0, by_angle, 0, 0], [0, turn, 0, 0]], rtol=1e-14)
    np.testing.assert_allclose(model.B, [[0], [0], [1 / 1.5], [-1 / (1.5 * 0.7)]], rtol=1e-14)
    np.testing.assert_allclose(model.C, [[0, 1, 0, 0], [0, by_angle, 0, 0], [0, 0, 0, 0]], rtol=1e-14)
    np.testing.assert_allclose(model.D, [[0], [1 / 1.5], [0]], rtol=1e-14)
    assert (model.states, model.inputs, model.outputs) == (("x", "theta", "v_x", "v_theta"), ("force",), ("theta", "a_x", "height"))
    assert model.units["v_theta"] == "rad/s" and model.units["force"] is None
    assert not model.discrete and model.step is None and not model.drift.any()
    np.testing.assert_allclose(model.measured, [0, 0, 0.7])
    np.testing.assert_allclose(sorted(model.eigenvalues.real), [-np.sqrt(turn), 0, 0, np.sqrt(turn)], atol=1e-14)


def test_shapes_without_inputs_and_outputs() -> None:
    bare = dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) / 2;").linearize(q=0.0)
    assert bare.B.shape == (2, 0) and bare.D.shape == (2, 0) and bare.C.shape == (2, 2)
    none = cart.linearize(q=[0, 0], inputs=[], outputs=[])
    assert none.B.shape == (4, 0) and none.C.shape == (0, 4) and none.D.shape == (0, 0)
    for matrix in (none.A, bare.C):
        with pytest.raises(ValueError, match="read-only"):
            matrix[0, 0] = 1.0


def test_a_regulator_holds_the_pole() -> None:
    linalg = pytest.importorskip("scipy.linalg")
    model = cart.linearize(q=[0.0, 0.0], inputs="force")
    gain = model.B.T @ linalg.solve_continuous_are(model.A, model.B, np.diag([1.0, 10.0, 1.0, 1.0]), np.eye(1))
    assert (np.linalg.eigvals(model.A - model.B @ gain).real < 0).all()
    run = cart.flow(h=0.005, q=[0.0, 0.3], v=[0.0, 0.0])
    run.until(12.0, control=lambda node: {"force": float((-gain @ model.state(node))[0])})
    assert abs(run["theta"][-1]) < 1e-3 and abs(run["x"][-1]) < 1e-2 and abs(run["x"]).max() < 2
    # the same regulator from the model of the step, as a digital controller
    step = cart.linearize(q=[0.0, 0.0], inputs="force", h=0.02)
    digital = linalg.solve_discrete_are(step.A, step.B, np.diag([1.0, 10.0, 1.0, 1.0]), np.eye(1) / 0.02)
    assert np.isfinite(digital).all() and step.discrete and step.step == 0.02


def test_the_step_is_the_exponential() -> None:
    linalg = pytest.importorskip("scipy.linalg")
    errors = []
    for h in (0.02, 0.01):
        step = cart.linearize(q=[0.0, np.pi], inputs="force", h=h)
        both = np.zeros((5, 5))
        continuous = cart.linearize(q=[0.0, np.pi], inputs="force")
        both[:4, :4], both[:4, 4:] = continuous.A, continuous.B
        exact = linalg.expm(both * h)[:4]
        errors.append(abs(np.hstack([step.A, step.B]) - exact).max())
    assert errors[0] < 1e-3 and 7.5 < errors[0] / errors[1] < 8.5


def test_python_control() -> None:
    control = pytest.importorskip("control")
    model = cart.linearize(q=[0.0, 0.0], inputs="force", outputs=["x", "theta"])
    system = model.to_control()
    assert isinstance(system, control.StateSpace) and system.isctime() and system.name == "cart"
    assert system.state_labels == ["x", "theta", "v_x", "v_theta"] and system.input_labels == ["force"] and system.output_labels == ["x", "theta"]
    np.testing.assert_array_equal(system.A, model.A)
    assert np.linalg.matrix_rank(control.ctrb(system.A, system.B)) == 4
    sampled = cart.linearize(q=[0.0, 0.0], inputs="force", h=0.01).to_control()
    assert sampled.isdtime() and sampled.dt == 0.01
    reference = control.c2d(cart.linearize(q=[0.0, 0.0], inputs="force").to_control(), 0.01)
    # to third order in h
    np.testing.assert_allclose(sampled.A, reference.A, atol=100 * 0.01**3)
    np.testing.assert_allclose(sampled.B, reference.B, atol=10 * 0.01**3)


def test_without_python_control(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(ImportError, match="pip install control"):
        cart.linearize(q=[0.0, 0.0]).to_control()


def test_a_rod_is_in_minimal_coordinates(rod: dsocs.System) -> None:
    model = rod.linearize(q=[0.6, -0.8], v=[0.8, 0.6], inputs="gravity")
    assert model.states == ("along_x", "v_along_x") and model.A.shape == (2, 2)
    np.testing.assert_allclose(model.projection @ model.basis.T, np.eye(2), atol=1e-15)
    np.testing.assert_allclose(model.projection[0], [0.8, 0.6, 0, 0], atol=1e-15)
    # a later node of the motion, by its position along the circle and its speed
    run = rod.flow(h=1e-4, q=[0.6, -0.8], v=[0.8, 0.6], tolerance=1e-12).until(1e-3)
    np.testing.assert_allclose(model.state(run[-1]), model.drift * 1e-3, rtol=1e-2)
    np.testing.assert_array_equal(model.state([0.6, -0.8]), [0, 0])
    below = rod.linearize(q=[0.0, -1.0])
    np.testing.assert_allclose(below.eigenvalues, [1j * np.sqrt(9.81), -1j * np.sqrt(9.81)], rtol=1e-14)


def test_where_the_state_comes_from(swing: dsocs.System) -> None:
    # the text's start, a position at rest, and another run of the text
    assert swing.linearize().q.tolist() == [2.0]
    assert swing.linearize(q=[1.0]).v.tolist() == [0.0]
    assert swing.linearize(v=[3.0]).q.tolist() == [2.0]
    assert swing.linearize(run="far").q.tolist() == [3.0]
    assert swing.linearize(q={"theta": 0.0}, length=0.5).A[1, 0] == pytest.approx(-9.81 / 0.5)
    moving = swing.linearize(q=[1.0], v=[0.5], outputs=["energy", "height"])
    np.testing.assert_allclose(moving.measured, [0.125 - 9.81 * np.cos(1.0), 1 - np.cos(1.0)], rtol=1e-14)
    np.testing.assert_allclose(moving.drift, [0.5, -9.81 * np.sin(1.0) - 0.05], rtol=1e-14)


def test_equilibria_of_a_swing(swing: dsocs.System) -> None:
    found = swing.equilibria([[0.3], [3.0], [-0.1], [6.0]], friction=0.0)
    assert len(found) == 3 and found.of_guess == [0, 1, 0, 2] and not found.failures
    np.testing.assert_allclose([each["theta"] for each in found], [0, np.pi, 2 * np.pi], atol=1e-14)
    np.testing.assert_allclose(found[1].eigenvalues, [np.sqrt(9.81), -np.sqrt(9.81)], rtol=1e-13)
    assert [each.stability for each in found] == ["undecided by the linear model", "unstable", "undecided by the linear model"]
    assert swing.equilibrium([0.3]).stability == "stable"
    # the torque that holds it, and the model there with that torque
    held = swing.equilibrium([0.5], hold="theta", free="torque")
    assert held["torque"] == pytest.approx(9.81 * np.sin(0.5)) and held.isolated
    model = held.linearize(inputs="torque")
    assert model.A[1, 0] == pytest.approx(-9.81 * np.cos(0.5)) and abs(model.drift).max() < 1e-14
    assert repr(held).startswith("<Equilibrium of swing: theta=0.5; stable; eigenvalues: -0.05±")


def test_a_continuum_and_dry_friction() -> None:
    found = cart.equilibrium([0.4, 0.1])
    assert not found.isolated and found.directions.tolist() == [[1.0, 0.0]] and found["x"] == 0.4
    assert "one of a continuum of 1 dimension" in repr(found)
    block = dsocs.System(FRICTION).equilibrium(0.5)
    assert abs(block.q[0]) < 1e-14 and block.eigenvalues is None and block.stability is None
    assert block.failure is not None and "jumps there" in block.failure
    falls = dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) / 2 - 9.81 * x;")
    with pytest.raises(dsocs.EquilibriumError, match="let an input be free") as raised:
        falls.equilibrium(0.0)
    assert raised.value.q == [0.0]
    assert pickle.loads(pickle.dumps(raised.value)).q == [0.0]
    all_fail = falls.equilibria([[0.0], [1.0]])
    assert len(all_fail) == 0 and sorted(all_fail.failures) == [0, 1] and all_fail.of_guess == [None, None]


def test_models_can_be_kept() -> None:
    model = cart.linearize(q=[0.0, 0.1], h=0.01, inputs="force")
    for again in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model)):
        assert again.system == cart and again.states == model.states and again.step == 0.01
        np.testing.assert_array_equal(again.A, model.A)
    rest = cart.equilibrium([0.0, 3.0])
    again = pickle.loads(pickle.dumps(rest))
    np.testing.assert_array_equal(again.q, rest.q)
    assert repr(again) == repr(rest)
    assert repr(model).startswith("<LinearModel of cart (step=0.01); states: x, theta, v_x, v_theta; inputs: force; outputs: x, theta, v_x, v_theta; ")
    assert repr(model).endswith(f"A (4, 4), B (4, 1), C (4, 4), D (4, 1); eigenvalues: {', '.join(f'{z.real:.4g}' for z in model.eigenvalues)}>")


def test_elements_of_arrays_are_inputs() -> None:
    beads = dsocs.System(BEADS)
    model = beads.linearize(q=[0.1, 0.0, 0.0], inputs=["masses_0", "stiffness"], outputs=["x_0", "v_x_2"])
    assert model.B[3, 0] == pytest.approx(40 * 0.1 / 0.1**2) and model.B[3, 1] == pytest.approx(-1.0)


@pytest.mark.parametrize(
    ("text", "q", "v"),
    [(CART, [0.1, 0.2], [0.3, -0.4]), (CART.replace("0.7", "0.9"), [0.0, 3.0], [0.0, 0.0])],
)
def test_the_command_line_has_the_same_bits(program: Path, tmp_path: Path, text: str, q: list[float], v: list[float]) -> None:
    (tmp_path / "cart.dsocs").write_text(text, encoding="utf-8")
    system = dsocs.read(tmp_path / "cart.dsocs")
    start = [f"--q0={','.join(map(repr, q))}", f"--v0={','.join(map(repr, v))}"]
    for extra, h in (([], None), (["--step", "0.02"], 0.02)):
        printed = json.loads(run_program(program, "linearize", "cart.dsocs", *start, *extra, "--format", "json", cwd=tmp_path))
        model = system.linearize(q=q, v=v, h=h)
        for name in "ABCD":
            np.testing.assert_array_equal(getattr(model, name), printed[name])
        np.testing.assert_array_equal(model.drift, printed["drift"])
        assert list(model.states) == [state["name"] for state in printed["states"]]
    printed = json.loads(run_program(program, "equilibrium", "cart.dsocs", "--guess", "0,0.2", "--guess", "0,3", "--format", "json", cwd=tmp_path))
    found = system.equilibria([[0, 0.2], [0, 3]])
    assert printed["of_guess"] == found.of_guess
    for one, other in zip(printed["equilibria"], found):
        np.testing.assert_array_equal(one["q"], other.q)
        np.testing.assert_array_equal([complex(*pair) for pair in one["eigenvalues"]], other.eigenvalues)


def test_what_a_controller_asks_for_comes_a_step_later() -> None:
    system = dsocs.System(
        "parameters { u = 0.0, k = 3.0, c = 0.4 } coordinates(x, y);"
        "lagrangian = (dot(x).powi(2) + 2 * dot(y).powi(2)) / 2 - k * (x - y).powi(2) / 2 - x.powi(2) / 2; external_forces = (u - c * dot(x), 0);"
    )
    model = system.linearize(q=[0, 0], inputs="u", h=0.1)
    asked = np.random.default_rng(0).normal(size=31)
    run = system.flow(h=0.1, q=[0.3, -0.1], v=[0.2, 0.1]).until(3.0, control=lambda node: {"u": asked[node.index]})
    z = np.hstack([run.q, run.v])
    # the guide's section 3: z[k+1] = A z[k] + B0 u[k-2] + B1 u[k-1], and nothing of u[k]
    rest = np.array([z[k + 1] - model.A @ z[k] for k in range(2, 30)])
    before = np.array([asked[k - 2 : k + 1] for k in range(2, 30)])
    by, *_ = np.linalg.lstsq(before, rest, rcond=None)
    np.testing.assert_allclose(before @ by, rest, atol=1e-14)
    np.testing.assert_allclose(by[0] + by[1], model.B[:, 0], atol=1e-14)
    np.testing.assert_allclose(by[2], 0.0, atol=1e-14)
    assert 0 < by[0][2] < 0.02 * by[1][2]


def test_a_gain_is_designed_with_the_input_that_is_held() -> None:
    linalg = pytest.importorskip("scipy.linalg")
    cart = dsocs.System(CART, name="cart")
    model = cart.linearize(q=[0.0, 0.0], inputs="force", h=0.1)
    n = len(model.states)
    A = np.block([[model.A, model.B], [np.zeros((1, n + 1))]])
    B = np.vstack([np.zeros((n, 1)), np.eye(1)])
    P = linalg.solve_discrete_are(A, B, np.diag([1.0, 10.0, 1.0, 1.0, 0.01]), np.eye(1))
    K = np.linalg.solve(np.eye(1) + B.T @ P @ B, B.T @ P @ A)
    held = [0.0]

    def control(node: dsocs.Node) -> dict[str, float]:
        held[0] = -(K @ np.append(model.state(node), held[0])).item()
        return {"force": held[0]}

    run = cart.flow(h=0.1, q=[0.0, 0.05], v=[0.0, 0.0]).until(20.0, control=control)
    assert abs(run["theta"][-1]) < 1e-3
