"""The motion between the nodes of a run, events, both solutions of a step, and regularity."""

from __future__ import annotations

import copy
import math
import pickle
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import FRICTION, run_program, text_of_library
from test_runs import interrupt_after

import dsocs

EITHER = """\
parameters { drift = 0.3 }
coordinates(x);
lagrangian = dot(x).powi(2) / 2;
kinematic = (dot(x) - drift) * (ddot(x) + x);
constraint_forces = [(1,)];
"""


@pytest.mark.parametrize("method", [dict(order=2), dict(order=4), dict(tolerance=1e-12)])
def test_a_sample_at_the_nodes_is_the_run(swing: dsocs.System, method: dict) -> None:
    run = swing.flow(h=0.05, **method).until(2.0)
    points = run.sample(run.t)
    np.testing.assert_allclose(points.q, run.q, atol=1e-13)
    np.testing.assert_allclose(points.v, run.v, atol=1e-12)
    np.testing.assert_allclose(points["height"], run["height"], atol=1e-13)
    assert run.index == 40 and len(run) == 41


def test_a_sample_of_the_continuous_motion_is_exact_between_the_nodes(swing: dsocs.System) -> None:
    times = np.linspace(0.0, 3.0, 301)
    coarse = swing.flow(h=1.0, tolerance=1e-13).until(3.0).sample(times)
    fine = swing.flow(h=0.01, tolerance=1e-13).until(3.0)
    np.testing.assert_allclose(coarse.q, fine.q, atol=1e-11)
    np.testing.assert_allclose(coarse.a, fine.a, atol=1e-9)
    assert coarse["v_theta"].shape == coarse["height"].shape == (301,) and list(coarse.table()) == ["t", "theta", "v_theta", "height"]


def test_a_sample_between_the_nodes_of_a_composition_is_of_fifth_degree(swing: dsocs.System) -> None:
    times = np.linspace(0.0, 1.0, 37)
    exact = swing.flow(tolerance=1e-14, h=1.0).sample(times).q
    errors = [abs(swing.flow(order=6, h=h).sample(times).q - exact).max() for h in (0.1, 0.05)]
    assert errors[1] < errors[0] / 20 and errors[0] < 1e-4


def test_a_sample_goes_beyond_the_run_and_back_in_time(swing: dsocs.System) -> None:
    run = swing.flow(h=-0.01, t=1.0)
    points = run.sample([1.0, 0.5, -0.5])
    np.testing.assert_allclose(points.q[1:], swing.flow(h=-0.01, t=1.0).until(-0.5).q[[50, 150]], atol=1e-12)
    assert run.index == 0 and len(run.sample([])) == 0


@pytest.mark.parametrize("method", [dict(order=2), dict(tolerance=1e-11)])
def test_a_sample_knows_the_inputs_that_changed(swing: dsocs.System, method: dict) -> None:
    run = swing.flow(h=0.01, friction=0.0, **method)
    run.until(1.0, control=lambda node: {"torque": -3 * node["v_theta"]}, control_every=10).set(torque=1.0).until(2.0)
    np.testing.assert_allclose(run.sample(run.t).q, run.q, atol=1e-11)
    np.testing.assert_allclose(copy.copy(run).sample([0.5, 1.5]).q, run.q[[50, 150]], atol=1e-11)


def test_events_are_where_columns_change_their_sign(swing: dsocs.System) -> None:
    run = swing.flow(h=0.01, q=[0.1], friction=0.0, tolerance=1e-13)
    events = run.watch(10.0, "theta", dsocs.Event("v_theta", rising=True), dsocs.Event("height", level=0.002))
    period = 2 * math.pi / math.sqrt(9.81) * (1 + 0.1**2 / 16 + 11 * 0.1**4 / 3072)
    np.testing.assert_allclose(events.of("theta"), period * (np.arange(len(events.of("theta"))) / 2 + 0.25), rtol=1e-8)
    np.testing.assert_allclose(events.of("v_theta"), period * (np.arange(len(events.of("v_theta"))) + 0.5), rtol=1e-8)
    assert all(abs(1 - math.cos(one.q[0]) - 0.002) < 1e-12 for one in events if one.event.of == "height")
    assert np.all(np.diff(events.t) >= 0) and not events.ended and events[0].rising == (events[0].v[0] > 0)
    assert len(run) == 1001 and run.t[-1] == 10.0
    assert repr(events).startswith(f"<{len(events)} events of swing>\nt=0.")


@pytest.mark.parametrize("method", [dict(order=2), dict(order=4), dict(tolerance=1e-12)])
def test_an_event_ends_a_run(swing: dsocs.System, method: dict) -> None:
    run = swing.flow(h=0.01, **method)
    events = run.watch(20.0, dsocs.Event("theta", ends=True))
    assert events.ended and len(events) == 1
    if "tolerance" in method:
        assert 0 <= events[0].t - run.node.t <= 0.01 and abs(events[0].q[0]) < 1e-12
    else:
        assert 0 <= run.node.t - events[0].t <= 0.01
    # the run goes on, and a copy continues in the same way
    other = pickle.loads(pickle.dumps(run)).until(2.0)
    run.until(2.0)
    np.testing.assert_array_equal(other.q, run.q)
    assert run.t[-1] == 2.0


def test_the_nodes_of_a_watched_run_are_those_of_another(swing: dsocs.System) -> None:
    watched, straight = swing.flow(), swing.flow().until(5.0)
    watched.watch(5.0, "theta", "a_theta")
    np.testing.assert_array_equal(watched.q, straight.q)
    np.testing.assert_array_equal(watched["height"], straight["height"])


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
def test_ctrl_c_ends_a_watched_run_and_a_sample(swing: dsocs.System) -> None:
    run = swing.flow(h=1e-5)
    interrupted = interrupt_after(0.2)
    with pytest.raises(dsocs.Interrupted) as info:
        run.watch(1e4, "theta")
    assert time.monotonic() - interrupted[0] < 0.1 and info.value.run is run and run.index > 0
    interrupted = interrupt_after(0.2)
    with pytest.raises(dsocs.Interrupted, match="interrupted: no time is sampled"):
        run.sample([1e4])
    assert time.monotonic() - interrupted[0] < 0.1


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
def test_ctrl_c_ends_a_check(swing: dsocs.System) -> None:
    interrupted = interrupt_after(0.3)
    with pytest.raises(dsocs.Interrupted, match="a shorter one"):
        swing.check(h=1e-3, until=3e3)
    assert time.monotonic() - interrupted[0] < 0.1


@pytest.mark.filterwarnings("ignore::dsocs.StepWarning")
def test_a_step_has_two_solutions() -> None:
    either = dsocs.System(EITHER, name="either")
    run = either.flow(h=0.1, q=[1.0], v=[0.0])
    found, other = run.roots()
    assert other is not None and abs(found - other)[0] > 1e-4 and run.index == 0
    run.advance_to(found)
    assert run.index == 1 and len(run) == 2
    # the second leads on from the same node
    branch = either.flow(h=0.1, q=[1.0], v=[0.0]).advance(1)
    _, other = branch.roots()
    assert other is not None
    branch.advance_to(other)
    assert abs(branch.advance(1).q[-1, 0] - other[0]) < 1e-12
    again = pickle.loads(pickle.dumps(branch))
    assert again.node.q[0] == branch.node.q[0] and again.index == 3
    with pytest.raises(dsocs.SetupError, match="led from one solution"):
        branch.sample([0.05])


def test_regular_steps_are_certified(swing: dsocs.System) -> None:
    run = swing.flow(h=0.1, every=2).until(1.0)
    certificate = run.certify()
    assert certificate.forward.shape == (6,) and certificate.granted.shape == (6, 2)
    assert math.isnan(certificate.forward[0]) and np.all(certificate.forward[1:] > 0.1)
    assert certificate.granted.all()


def test_a_certificate_has_the_bits_of_the_program(program: Path, tmp_path: Path) -> None:
    file = text_of_library(program, tmp_path, "pendulum")
    certificate = dsocs.read(file).flow().until(20.0).certify()
    out = run_program(program, "run", file.name, "--until", "20", "--certify", "--columns", "regularity_forward,regularity_backward", cwd=tmp_path)
    expected = np.array([[float(x or "nan") for x in line.split(",")] for line in out.splitlines()[1:]])
    np.testing.assert_array_equal(np.stack([certificate.forward, certificate.backward], axis=-1), expected)


def test_ensembles_run_by_every_method(swing: dsocs.System) -> None:
    q, lengths = np.linspace(0.5, 2.5, 7)[:, None], np.linspace(1, 2, 7)
    exact = [swing.flow(q=row, length=length, tolerance=1e-12, h=0.01).until(2.0).q[-1, 0] for row, length in zip(q, lengths)]
    for method in (dict(tolerance=1e-12), dict(order=4), dict(order=8)):
        for threads in (1, 2):
            ends = swing.ensemble(q=q, length=lengths, h=0.01, **method).until(2.0, threads=threads)
            np.testing.assert_allclose(ends["theta"], exact, atol=1e-12 if "tolerance" in method else 1e-6)
    np.testing.assert_array_equal(swing.ensemble(q=q, length=lengths, h=0.01, tolerance=1e-12).until(2.0)["theta"], exact)


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
def test_ctrl_c_ends_an_ensemble_of_another_order(swing: dsocs.System) -> None:
    interrupted = interrupt_after(0.2)
    with pytest.raises(dsocs.Interrupted):
        swing.ensemble(q=[[1.0], [2.0]], h=1e-6, order=8).until(1e4)
    assert time.monotonic() - interrupted[0] < 0.1


def test_the_table_of_ends_says_what_varies(swing: dsocs.System, rod: dsocs.System) -> None:
    ends = swing.ensemble(q=[[0.5], [1.0]], length=[1.0, 2.0]).until(1.0)
    assert list(ends.table()) == ["length", "start_q_theta", "t", "theta", "v_theta", "energy", "height"]
    table = rod.ensemble(h=0.01, q=[[0, -1], [0, -2]], v=[0.0, 0.0]).until(1.0).table()
    assert table["error"][0] is None and "violates" in table["error"][1] and math.isnan(table["x"][1])


def test_tables_are_data_frames(swing: dsocs.System) -> None:
    pandas = pytest.importorskip("pandas")
    run = swing.flow().until(0.1)
    frame = run.frame()
    assert isinstance(frame, pandas.DataFrame) and list(frame.columns) == run.columns and len(frame) == 11
    frame["more"] = frame["theta"] * 2
    assert swing.ensemble(q=[[0.5], [1.0]]).until(1.0).frame().shape == (2, 6)


def test_the_table_of_a_sweep_is_read(tmp_path: Path) -> None:
    parquet, pyarrow = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("pyarrow")
    pytest.importorskip("pandas")
    (tmp_path / "points").mkdir()
    for part in (0, 1):
        parquet.write_table(pyarrow.table({"point": [2 * part, 2 * part + 1], "end_theta": [0.5, 1.5]}), tmp_path / "points" / f"{part}.parquet")
    frame = dsocs.read_sweep(tmp_path)
    assert list(frame["point"]) == [0, 1, 2, 3] and list(frame.columns) == ["point", "end_theta"]
    with pytest.raises(dsocs.SetupError, match="nodes has no table"):
        dsocs.read_sweep(tmp_path, nodes=True)


def warnings_of(run: dsocs.Run, until: float) -> list[str]:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        try:
            run.until(until)
        except dsocs.StepError:
            pass
    return [str(one.message) for one in found]


def test_warnings_advise_what_there_is() -> None:
    dry = dsocs.System(FRICTION, name="dry")
    assert "`tolerance`" in warnings_of(dry.flow(q=[5.0], v=[0.0], h=0.1), 10.0)[0]
    third = dsocs.System(
        "coordinates(x, y); lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;"
        "kinematic = dddot(x) - (t - 0.55).signum(); constraint_forces = [(1, 0)];",
        name="third",
    )
    messages = warnings_of(third.flow(q=[0, 0], v=[0, 0], a=[0, 0], h=0.1), 1.0)
    assert all("tolerance" not in message for message in messages)


def test_the_step_of_a_singularity_is_told() -> None:
    # the velocity is infinite after a finite time
    runaway = dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = dot(x).powi(3);", name="runaway")
    run = runaway.flow(q=[0.0], v=[1.0], h=0.01)
    messages = warnings_of(run, 0.6)
    found = run.nearly_singular
    if found is not None and found.of_step == found.steps:
        assert any("the equations of the step pass through a singularity" in message for message in messages)
    assert found is not None and 0 <= found.of_step <= found.steps


FREE = "coordinates(x); lagrangian = dot(x).powi(2) / 2; let two = x - 1; observe = [two];"


@pytest.mark.parametrize("method", [{}, {"order": 4}, {"tolerance": 1e-12}])
@pytest.mark.parametrize("split", [1.0, 0.5, 0.97])
def test_an_event_at_a_node_between_two_watches_is_told_once(method: dict[str, Any], split: float) -> None:
    run = dsocs.System(FREE).flow(h=0.1, q=[0.0], v=[1.0], **method)
    first = run.watch(split, "two")
    again = pickle.loads(pickle.dumps(run))
    for one in (run, again):
        times = [*first.t, *one.watch(2.0, "two").t]
        assert len(times) == 1
        assert abs(times[0] - 1.0) < 1e-12


@pytest.mark.parametrize("method", [{}, {"order": 4}, {"tolerance": 1e-12}])
def test_events_behind_one_that_ends_a_run_are_told_by_the_next_watch(method: dict[str, Any]) -> None:
    run = dsocs.System(FREE).flow(h=0.1, q=[0.0], v=[1.0], **method)
    ended = run.watch(2.0, dsocs.Event("x", 0.52), dsocs.Event("x", 0.55, ends=True), dsocs.Event("x", 0.58))
    assert [one.event.level for one in ended] == [0.52, 0.55] and ended.ended
    rest = run.watch(2.0, *(dsocs.Event("x", level) for level in (0.52, 0.57, 0.58, 0.7)))
    assert [one.event.level for one in rest] == [0.57, 0.58, 0.7]


def test_the_times_of_a_column_that_was_not_watched_are_refused() -> None:
    events = dsocs.System(FREE).flow(h=0.1, q=[0.0], v=[1.0]).watch(0.5, "two")
    assert events.of("two").tolist() == []
    with pytest.raises(KeyError, match="no watched column `foo`; known: two"):
        events.of("foo")


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
def test_ctrl_c_ends_a_path(swing: dsocs.System) -> None:
    interrupted = interrupt_after(0.2)
    with pytest.raises(dsocs.Interrupted, match="interrupted: nothing is kept of this path"):
        swing.path(1e4, h=1e-6)
    assert time.monotonic() - interrupted[0] < 0.5


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
@pytest.mark.parametrize("method", [{}, {"order": 4}])
def test_what_has_not_reached_the_end_of_an_ensemble_is_told(swing: dsocs.System, method: dict[str, Any]) -> None:
    interrupt_after(0.3)
    with pytest.raises(dsocs.Interrupted, match="interrupted: [0-9]+ of 1000 runs have reached the end") as raised:
        swing.ensemble(q=np.linspace(0.1, 3.0, 1000)[:, None], h=1e-5, **method).until(200.0)
    ends = raised.value.run
    left = np.array(list(ends.failures))
    assert len(left) > 0 and np.isnan(ends.q[left]).all() and np.isfinite(np.delete(ends.q, left, axis=0)).all()
    assert f"interrupted: {1000 - len(left)} reached the end" in repr(ends)
    assert "interrupted at t = " in str(ends.failures[int(left[0])])


@pytest.mark.parametrize("method", [dict(order=2), dict(order=4), dict(tolerance=1e-12)])
def test_many_times_lie_anywhere_between_the_nodes(method: dict) -> None:
    oscillator = dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) / 2 - x * x / 2;", name="oscillator")
    random = np.random.default_rng(7)
    for _ in range(40):
        h = float(random.uniform(0.002, 0.05)) * random.choice([1, -1])
        run = oscillator.flow(h=h, q=[1.0], v=[0.0], **method)
        for count in (1024, 1025, int(random.integers(2, 6000))):
            # often thousands of times within a step
            ends = np.sort(random.uniform(0, 2 * 10 ** random.uniform(-3, 0), 2))
            times = np.copysign(np.linspace(*ends, count), h)
            points = run.sample(times)
            np.testing.assert_allclose(points["x"], np.cos(times), atol=1e-10 if "tolerance" in method else h * h)
            some = random.choice(count, 3)
            np.testing.assert_allclose(points.q[some], [run.sample([times[place]]).q[0] for place in some], atol=1e-13)
