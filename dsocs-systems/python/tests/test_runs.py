"""Runs: nodes, columns, inputs, copies and interruptions."""

from __future__ import annotations

import copy
import math
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from conftest import FRICTION, RUNS_OUT, SWING

import dsocs


def test_a_run_has_arrays_of_its_nodes(swing: dsocs.System) -> None:
    run = swing.flow(h=0.01, q=[1.0], v={"theta": 0.0}, length=1.2).until(2.0)
    assert len(run) == 201
    for array, shape in [(run.t, (201,)), (run.q, (201, 1)), (run.v, (201, 1)), (run.a, (201, 1)), (run.force, (201, 1)), (run.energy, (201,))]:
        assert array.shape == shape and array.dtype == np.float64 and not array.flags.writeable
    assert run.t[-1] == 2.0 and run.q[0, 0] == 1.0 and run.parameters["length"] == 1.2
    assert run.observed.shape == (201, 1) and run.multipliers.shape == (201, 0)


def test_arrays_are_not_copied(swing: dsocs.System) -> None:
    run = swing.flow().until(1.0)
    assert run.q is run.q and run["theta"].base is not None
    assert np.shares_memory(run.q, run["theta"])


def test_an_array_that_was_handed_out_stays(swing: dsocs.System) -> None:
    run = swing.flow()
    seen = []
    for _ in range(50):
        seen.append((run.advance(1).q, run.q.copy()))
    for array, then in seen:
        np.testing.assert_array_equal(array, then)
    assert len(run.q) == 51
    # an array that is asked for after every step rarely moves its rows
    assert len({array.__array_interface__["data"][0] for array, _ in seen}) < 10


def test_looking_changes_nothing(swing: dsocs.System) -> None:
    looked, straight = swing.flow(), swing.flow().advance(300)
    for _ in range(100):
        looked.advance(3)
        assert looked.q.shape[0] == looked["height"].shape[0]
    for name in straight.columns:
        np.testing.assert_array_equal(looked[name], straight[name])


def test_columns_and_units(swing: dsocs.System) -> None:
    run = swing.flow().until(1.0)
    assert run.columns == ["t", "theta", "v_theta", "force_theta", "energy", "height"]
    assert run.units == {"t": "s", "theta": "rad", "v_theta": "rad/s", "force_theta": "N m", "energy": "J", "height": "m"}
    np.testing.assert_allclose(run["height"], 1 - np.cos(run["theta"]), rtol=1e-14)
    assert list(run.table()) == run.columns


def test_multipliers_belong_to_the_rod(rod: dsocs.System) -> None:
    run = rod.flow(h=0.01, q=[0, -1], v=[1, 0]).until(1.0)
    assert run.multipliers.shape == (101, 1)
    # the form of the constraint times its multiplier is the force
    np.testing.assert_allclose(run["lambda_0"][:, None] * 2 * run.q, run.force, atol=1e-2)


def test_nodes(swing: dsocs.System) -> None:
    run = swing.flow().until(1.0)
    last = run[-1]
    assert last.index == 100 and last.t == 1.0 and last["theta"] == run["theta"][-1] == last.q[0]
    assert last["v_theta"] == last.v[0] and last["force_theta"] == last.force[0] and last["energy"] == last.energy
    assert [node.index for node in run] == list(range(101))
    assert run.node.t == 1.0 and run.index == 100
    assert repr(last).startswith("Node(100, t=1, theta=")


def test_every_so_many_nodes(swing: dsocs.System) -> None:
    all_, some = swing.flow().until(1.0), swing.flow(every=7).until(1.0)
    np.testing.assert_array_equal(some.q, all_.q[::7])
    assert some[1].index == 7 and some.index == 100


def test_steps_go_on_one_by_one(swing: dsocs.System) -> None:
    run = swing.flow()
    times = [node.t for node in run.steps(0.1)]
    assert len(times) == 10 and times[-1] == 0.1
    assert [node.index for node in run.steps(0.2)] == list(range(11, 21))
    for node in run.steps(math.inf):
        if node.index == 50:
            break
    np.testing.assert_array_equal(run.q, swing.flow().advance(50).q)


def test_a_run_goes_where_its_text_says(swing: dsocs.System) -> None:
    assert swing.flow().until().t[-1] == 20.0
    assert swing.flow(run="far").until().t[-1] == 10.0
    assert swing.flow(h=-0.01).until().t[-1] == -20.0
    assert swing.flow(t=5.0).until().t[-1] == 25.0


@pytest.mark.parametrize("method", [dict(order=2), dict(order=4), dict(order=6), dict(order=8), dict(tolerance=1e-10)])
def test_all_methods_go_to_the_same_place(swing: dsocs.System, method: dict) -> None:
    run = swing.flow(h=0.002, **method).until(2.0)
    exact = swing.flow(tolerance=1e-15, h=0.5).until(2.0)
    assert abs(run.q[-1, 0] - exact.q[-1, 0]) < 1e-4
    assert run.order == method.get("order") and run.tolerance == method.get("tolerance")


def test_a_controller_holds_its_inputs(swing: dsocs.System) -> None:
    seen = []

    def damp(node: dsocs.Node) -> dict[str, float]:
        seen.append(node.index)
        return {"torque": -2.0 * node["v_theta"]}

    run = swing.flow(friction=0.0).until(5.0, control=damp, control_every=10)
    assert seen == list(range(0, 500, 10))
    assert run.energy[-1] < run.energy[0] - 10
    # the same controller by hand
    other = swing.flow(friction=0.0)
    for index in range(500):
        if index % 10 == 0:
            other.set(torque=-2.0 * other.node["v_theta"])
        other.advance(1)
    np.testing.assert_array_equal(run.q, other.q)


def test_observed_expressions_follow_the_inputs() -> None:
    system = dsocs.System(
        "parameters { push = 0.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = push; let power = push * dot(x); observe = [power];"
    )
    run = system.flow(h=0.01, q=[0], v=[1]).advance(3)
    run.set(push=2.0).advance(3)
    # a value holds from node 4 on; the motion arrives there with the value before
    np.testing.assert_allclose(run["power"][:5], 0.0)
    np.testing.assert_allclose(run["power"][5:], 2.0 * run["v_x"][5:])


def test_progress_is_told(swing: dsocs.System, capsys: pytest.CaptureFixture[str]) -> None:
    parts: list[float] = []
    swing.flow(h=1e-4).until(20.0, progress=parts.append)
    assert parts == sorted(parts) and parts[-1] == 1.0
    swing.flow().until(1.0, progress=True)
    assert "100" in capsys.readouterr().err


def test_an_error_in_progress_ends_the_run(swing: dsocs.System) -> None:
    def stop(part: float) -> None:
        raise ValueError("enough")

    run = swing.flow()
    with pytest.raises(ValueError, match="enough"):
        run.until(20.0, progress=stop)
    assert len(run) > 1


def test_a_step_without_a_solution_keeps_the_run() -> None:
    system = dsocs.System(RUNS_OUT)
    with pytest.raises(dsocs.StepError) as raised:
        system.flow(h=0.01, q=[0], v=[0]).until(2.0)
    error = raised.value
    assert error.run is not None and 90 < len(error.run) <= 101
    assert error.time == pytest.approx(1.0, abs=0.1) and error.step == error.run.index + 1
    assert len(error.nodes) == 3 and error.h == 0.01 and "has no solution" in str(error)
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error) and again.step == error.step and len(again.run) == len(error.run)


def test_a_series_that_ends_keeps_the_run() -> None:
    system = dsocs.System(RUNS_OUT)
    with pytest.raises(dsocs.StepError) as raised:
        system.flow(q=[0], v=[0], tolerance=1e-9).until(2.0)
    assert raised.value.time == pytest.approx(1.0, abs=1e-2) and raised.value.run is not None


def test_jumps_are_warned_of() -> None:
    system = dsocs.System(FRICTION.replace("-dry * dot(x).signum()", "-dry * x.signum()"))
    with pytest.warns(dsocs.StepWarning, match="varies too fast for the nodes, within"):
        run = system.flow(q=[1.0], v=[0.0], h=0.1).until(10.0)
    assert run.unresolved is not None and run.unresolved.steps >= 1


def test_what_has_no_effect_is_warned_of() -> None:
    with pytest.warns(dsocs.DeclarationWarning, match="unused") as warned:
        dsocs.System("parameters { unused = 1.0 } coordinates(x); lagrangian = dot(x).powi(2) / 2;")
    assert warned[0].filename == __file__


@pytest.mark.parametrize(("tolerance", "said"), [(1e-20, "cannot be reached"), (0.01, "add up")])
def test_tolerances_are_warned_of(swing: dsocs.System, tolerance: float, said: str) -> None:
    with pytest.warns(dsocs.StepWarning, match=said) as warned:
        swing.flow(tolerance=tolerance)
    assert warned[0].filename == __file__


def interrupt_after(seconds: float) -> list[float]:
    sent: list[float] = []

    def send() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Timer(seconds, send).start()
    return sent


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
@pytest.mark.parametrize("method", [dict(), dict(order=8), dict(tolerance=1e-12)])
def test_ctrl_c_ends_a_run_and_keeps_it(swing: dsocs.System, method: dict) -> None:
    interrupted = interrupt_after(0.2)
    with pytest.raises(dsocs.Interrupted) as raised:
        swing.flow(h=1e-5, every=1000, **method).until(1e6)
    assert time.monotonic() - interrupted[0] < 0.1
    run = raised.value.run
    assert isinstance(raised.value, KeyboardInterrupt) and run is not None and len(run) > 1
    # and the run goes on
    before = run.index
    assert run.advance(5).index == before + 5


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
def test_ctrl_c_ends_an_ensemble_and_keeps_it(swing: dsocs.System) -> None:
    ensemble = swing.ensemble(h=1e-5, q=np.linspace(0, 1, 64)[:, None], v=[0.0])
    interrupted = interrupt_after(0.2)
    with pytest.raises(dsocs.Interrupted) as raised:
        ensemble.until(1e4)
    assert time.monotonic() - interrupted[0] < 0.3
    assert len(raised.value.run) == 64


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
def test_ctrl_c_ends_a_controlled_run(swing: dsocs.System) -> None:
    interrupt_after(0.2)
    with pytest.raises(dsocs.Interrupted) as raised:
        swing.flow(h=1e-5, every=1000).until(1e6, control=lambda node: None)
    assert raised.value.run is not None


def test_python_runs_beside_a_run(swing: dsocs.System) -> None:
    counted, done = [0], threading.Event()

    def count() -> None:
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begun = time.monotonic()
    swing.flow(h=1e-5, every=1000).until(20.0)
    took = time.monotonic() - begun
    done.set()
    thread.join()
    assert counted[0] > 100 * took


def test_a_run_at_work_is_refused_to_other_threads(swing: dsocs.System) -> None:
    run = swing.flow(h=1e-5, every=1000)
    thread = threading.Thread(target=lambda: run.until(20.0))
    thread.start()
    refused = 0
    while thread.is_alive():
        try:
            run.advance(1)
        except RuntimeError as error:
            assert "at work" in str(error)
            refused += 1
    thread.join()
    assert refused > 0


def test_a_controller_that_touches_its_run_is_told(swing: dsocs.System) -> None:
    run = swing.flow()
    with pytest.raises(RuntimeError, match="at work"):
        run.until(1.0, control=lambda node: {"torque": run.energy[-1]})


def test_systems_are_pickled_and_copied(swing: dsocs.System, tmp_path: object) -> None:
    again = pickle.loads(pickle.dumps(swing))
    assert again == swing and again.text == SWING and again.name == "swing"
    assert copy.copy(swing) == copy.deepcopy(swing) == swing and hash(again) == hash(swing)
    samples = dsocs.System(
        'parameters { f = samples("f.csv") } coordinates(x); lagrangian = dot(x).powi(2) / 2 + f.at(t) * x;', samples={"f": ([0, 1, 2], [0, 1, 0])}
    )
    one, two = (system.flow(h=0.01, q=[0], v=[0]).until(1.0).q for system in (samples, pickle.loads(pickle.dumps(samples))))
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("method", [dict(), dict(order=4), dict(tolerance=1e-9), dict(every=3)])
def test_runs_are_pickled_and_go_on_with_the_same_bits(swing: dsocs.System, method: dict) -> None:
    run = swing.flow(**method).until(1.0)
    run.advance(3)
    if not method:
        run.set(torque=0.5)
        run.until(2.0, control=lambda node: {"torque": -node["v_theta"]}, control_every=5)
    others = [pickle.loads(pickle.dumps(run)), copy.copy(run), copy.deepcopy(run)]
    for other in others:
        assert len(other) == len(run) and other.index == run.index and repr(other) == repr(run)
        for name in run.columns:
            np.testing.assert_array_equal(other[name], run[name])
        assert not other.q.flags.writeable
    run.until(3.0)
    for other in others:
        np.testing.assert_array_equal(other.until(3.0).q, run.q)


def _end(length: float) -> dsocs.Run:
    return dsocs.System(SWING).flow(length=length).until(1.0)


def test_runs_come_back_from_other_processes() -> None:
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        runs = list(pool.map(_end, [1.0, 2.0]))
    for length, run in zip([1.0, 2.0], runs):
        np.testing.assert_array_equal(run.q, _end(length).q)


def test_what_is_shown(swing: dsocs.System) -> None:
    assert repr(swing).startswith("<System swing (unconstrained); coordinates: theta; parameters: length=1, ")
    run = swing.flow().until(1.0)
    assert repr(run) == "<Run of swing: 101 nodes, t=0 to 1, h=0.01, order=2>"
    html = run._repr_html_()
    assert html.count("<iframe srcdoc=") == 1 and "sandbox" in html and "&lt;!DOCTYPE html&gt;" in html
    shown = swing._repr_html_()
    assert "The length of the rod" in shown
    assert run._repr_html_().count("<iframe") == 1 and "<p>" in swing.flow()._repr_html_()


def test_an_estimate_and_ends_are_shown_in_a_line(swing: dsocs.System) -> None:
    estimate = swing.flow().until(1.0).estimate_error()
    worst = int(estimate.errors[:, 0].argmax())
    assert repr(estimate).startswith(f"<ErrorEstimate: at most {estimate.largest['theta']:.3g}, of theta at run[{worst}] of 101 nodes; uncertainty ")
    assert repr(swing.ensemble(q=[[1.0], [2.0]]).until(0.1)) == "<Ends of 2 runs of swing; t and energy (2,), q, v, a and force (2, 1), observed (2, 1)>"


def test_advice_is_that_of_python() -> None:
    contact = dsocs.System("coordinates(z); lagrangian = dot(z).powi(2) / 2 - 9.81 * z; external_forces = 1e6 * (-z).max(0);")
    with pytest.warns(dsocs.StepWarning) as told:
        contact.flow(h=0.01, q=[1.0], v=[0.0]).until(2.0)
    said = " ".join(str(one.message) for one in told)
    assert "`tolerance=`" in said and "--" not in said
    jumps = dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) / 2 - x.abs();").check(h=0.1, until=3.0, q=[1.0], v=[0.3])
    excuses = " ".join(str(finding.excuse) for finding in jumps)
    assert "end before (`until=`)" in excuses and "--" not in excuses


def test_a_report_is_written(swing: dsocs.System, tmp_path: os.PathLike[str]) -> None:
    run = swing.flow().until(1.0)
    run.report(os.path.join(tmp_path, "page.html"))
    with open(os.path.join(tmp_path, "page.html"), encoding="utf-8") as file:
        assert file.read() == run.page()


def test_what_a_system_says(swing: dsocs.System, beads: dsocs.System) -> None:
    assert swing.kind == "unconstrained" and swing.doc.startswith("A pendulum")
    assert swing.quantity("length") == ("length", "The length of the rod", "m")
    assert swing.parameters == {"length": 1.0, "gravity": 9.81, "friction": 0.1, "torque": 0.0}
    assert list(beads.parameters)[:3] == ["masses_0", "masses_1", "masses_2"]
    assert set(swing.runs) == {None, "far"} and swing.runs["far"].start == ([3.0], [0.0])


def test_a_check_of_a_run(curved: dsocs.System) -> None:
    findings = curved.flow().until(2.0).check()
    assert findings.ok and len(findings) > 5 and "regularity" in repr(findings)
    # it fits a terminal, and nothing is left out
    lines = repr(findings).split("\n")
    assert max(map(len, lines)) <= 100
    shown = " ".join(" ".join(lines).split())
    for finding in findings:
        assert all(word in shown for word in f"{finding.check}: {finding.what} {finding.figure:.3g}".split())


def test_an_error_estimate_under_held_inputs(swing: dsocs.System) -> None:
    run = swing.flow(h=0.001).until(1.0, control=lambda node: {"torque": -node["v_theta"]}, control_every=100)
    with pytest.warns(dsocs.StepWarning, match="came from `control`"):
        found = run.estimate_error()
    assert found.errors.shape == (1001, 1) and 0 < found.largest["theta"] < 1e-5


def test_an_ensemble_ends_where_runs_end(swing: dsocs.System) -> None:
    q, length = np.linspace(0.1, 2, 20), np.linspace(1, 2, 20)
    ends = swing.ensemble(q=q[:, None], v=[0.0], length=length).until(2.0)
    assert len(ends) == 20 and ends.q.shape == (20, 1) and not ends.failures
    for place in (0, 7, 19):
        run = swing.flow(q=[q[place]], v=[0.0], length=length[place]).until(2.0)
        assert ends["theta"][place] == pytest.approx(run.q[-1, 0], abs=1e-12)
    by_name = swing.ensemble(q={"theta": q}, length=length).until(2.0, threads=1)
    np.testing.assert_array_equal(by_name.q, ends.q)


def test_an_ensemble_tells_who_failed(rod: dsocs.System) -> None:
    ends = rod.ensemble(h=0.01, q=[[0, -1], [0, -2], [1, 0]], v=[0.0, 0.0]).until(1.0)
    assert set(ends.failures) == {1} and isinstance(ends.failures[1], dsocs.SetupError)
    assert "violates" in str(ends.failures[1])
    assert np.isnan(ends.q[1]).all() and np.isfinite(ends.q[[0, 2]]).all() and ends.t[0] == 1.0


def test_a_gradient_is_that_of_differences(swing: dsocs.System) -> None:
    def cost(node: object) -> object:
        return node["theta"] ** 2 + np.sin(node["v_theta"]) * node.q[0] - np.exp(-node["a_theta"] ** 2)  # type: ignore[index, attr-defined]

    gradient = swing.path(1.0, q=[1.0], v=[0.5]).gradient(cost)

    def value(q: float, v: float, length: float) -> float:
        last = swing.flow(q=[q], v=[v], length=length).until(1.0)[-1]
        return last.q[0] ** 2 + np.sin(last.v[0]) * last.q[0] - np.exp(-(last.a[0] ** 2))

    step = 1e-6
    assert gradient.cost == pytest.approx(value(1.0, 0.5, 1.0), rel=1e-12)
    for found, (q, v, length) in [(gradient.q[0], (1, 0, 0)), (gradient.v[0], (0, 1, 0)), (gradient.parameters["length"], (0, 0, 1))]:
        moved = [value(1.0 + s * step * q, 0.5 + s * step * v, 1.0 + s * step * length) for s in (1, -1)]
        assert found == pytest.approx((moved[0] - moved[1]) / (2 * step), rel=1e-5)


def test_a_cost_of_all_nodes(swing: dsocs.System) -> None:
    path = swing.path(1.0)
    found = path.gradient(lambda node: node["theta"] ** 2 * 0.01, of="nodes")
    assert found.cost == pytest.approx(0.01 * (swing.flow().until(1.0).q ** 2).sum(), rel=1e-12)
    assert path.steps == 100 and path.end.t == 1.0


def test_tangents_agree_with_the_gradient(swing: dsocs.System) -> None:
    path = swing.path(1.0)
    gradient = path.gradient(lambda last: last["theta"])
    tangents = path.tangents("length", "q_theta", "v_theta")
    assert tangents["length"][0][0] == pytest.approx(gradient.parameters["length"], rel=1e-10)
    assert tangents["q_theta"][0][0] == pytest.approx(gradient.q[0], rel=1e-10)
    assert tangents["v_theta"][0][0] == pytest.approx(gradient.v[0], rel=1e-10)


def test_the_module_has_no_undocumented_names() -> None:
    for name in dsocs.__all__:
        thing = getattr(dsocs, name)
        if isinstance(thing, type) and issubclass(thing, Warning | BaseException):
            continue
        assert name.startswith("__") or name == "time" or thing.__doc__, name


def test_importing_is_quick(tmp_path: Path) -> None:
    # processor time, since other processes may run beside it
    code = "import time, numpy; t = time.process_time(); import dsocs; print(time.process_time() - t)"
    # in another folder, since `-c` looks for packages in its own, which has the sources
    run = [sys.executable, "-c", code]
    took = min(float(subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=True).stdout) for _ in range(3))
    assert took < 0.1


def test_nothing_is_warned_of_without_reason(swing: dsocs.System) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        swing.flow().until(2.0)
        swing.flow(tolerance=1e-10).until(2.0)


@pytest.mark.parametrize("options", [{"order": 2}, {"order": 4}, {"tolerance": 1e-10}, {"order": 2, "every": 10}], ids=str)
def test_a_mass_that_changes_keeps_its_momentum_and_is_told(options: dict[str, float]) -> None:
    drone = dsocs.System(
        "parameters { mass = 2.0, thrust = 0.0 } coordinates(z); lagrangian = mass / 2 * dot(z).powi(2) - mass * 9.81 * z; external_forces = thrust;"
    )
    said = "the input `mass` changes from 2 to 1 at t = [0-9.]+, and the momenta depend on it: .*the velocity of `z` jumps there"
    with pytest.warns(dsocs.StepWarning, match=said) as told:
        run = drone.flow(h=0.01, q=[10.0], v=[3.0], **options).until(1.0, control=lambda node: {"mass": 1.0 if node.t > 0.5 else 2.0})
    assert len(told) == 1
    with pytest.warns(dsocs.StepWarning, match=said) as told:
        by_hand = drone.flow(h=0.01, q=[10.0], v=[3.0], **options).until(0.5)
        by_hand.set(mass=1.0)
        by_hand.until(1.0)
    assert len(told) == 1
    # the momentum falls by the weight
    assert abs(run["v_z"][-1] * run["mass"][-1] - by_hand["v_z"][-1]) < 0.2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drone.flow(h=0.01, q=[10.0], v=[3.0], **options).until(1.0, control=lambda node: {"thrust": 5.0 * node.t})
