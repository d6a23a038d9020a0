"""Results of the package and of the command line agree bit for bit."""

from __future__ import annotations

import csv
import io
import json
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import PROGRAM, SWING, run_program, text_of_library

import dsocs

NAMES = [
    "chain", "double-pendulum", "spherical-pendulum", "magnetic", "kapitza", "train", "planar-pendulum", "sphere", "quaternion-top", "arm",
    "nonholonomic-particle", "knife-edge", "rolling-disk", "sleigh", "snakeboard", "vehicle", "contact-oscillator", "particle", "pendulum",
    "gravity-turn", "cart-pole", "exact-decrease", "rod-and-wheel", "motor-friction", "pivot-friction", "clothoid", "crane", "stalled-friction",
    "heavy-top", "bodies", "quadrotor", "suslov", "turntable", "coin", "satellite",
]  # fmt: skip


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for the systems of the program that a text can say, as files."""
    return tmp_path_factory.mktemp("library")


def table(text: str) -> dict[str, np.ndarray]:
    rows = list(csv.reader(io.StringIO(text)))
    numbers = np.array([[float(x) for x in row] for row in rows[1:]])
    return {name: numbers[:, place] for place, name in enumerate(rows[0])}


def same(run: dsocs.Run, text: str) -> None:
    expected = table(text)
    # parameters changed on the command line are not columns of its table
    assert run.columns == [*expected, *(name for name in run.parameters if name in run.columns)]
    for name, column in expected.items():
        np.testing.assert_array_equal(run[name], column, err_msg=name, strict=True)


@pytest.mark.parametrize("name", NAMES)
def test_a_library_system_has_the_bits_of_the_program(program: Path, library: Path, name: str) -> None:
    file = text_of_library(program, library, name)
    system = dsocs.read(file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", dsocs.StepWarning)
        run = system.flow()
        run.until(run.h * 60)
    same(run, run_program(program, "run", file.name, "--until", repr(run.h * 60), cwd=library))


@pytest.mark.parametrize("name", ["chain", "sphere", "gravity-turn", "pendulum", "pivot-friction", "snakeboard", "kapitza", "heavy-top"])
def test_a_motion_to_a_tolerance_has_the_bits_of_the_program(program: Path, library: Path, name: str) -> None:
    file = text_of_library(program, library, name)
    run = dsocs.read(file).flow(tolerance=1e-10, h=0.02).until(1.0)
    same(run, run_program(program, "run", file.name, "--until", "1", "--step", "0.02", "--tolerance", "1e-10", cwd=library))


@pytest.mark.parametrize("order", [4, 6, 8])
@pytest.mark.parametrize("name", ["chain", "gravity-turn", "pendulum"])
def test_a_composition_has_the_bits_of_the_program(program: Path, library: Path, name: str, order: int) -> None:
    file = text_of_library(program, library, name)
    run = dsocs.read(file).flow(order=order, h=0.02).until(0.5)
    same(run, run_program(program, "run", file.name, "--until", "0.5", "--step", "0.02", "--order", str(order), cwd=library))


CALLS = [
    (dict(q=[1.0]), ["--q0", "1"]),
    (dict(q={"theta": 1.0}, v={"theta": -0.5}), ["--q0", "theta=1", "--v0", "theta=-0.5"]),
    (dict(h=-0.01), ["--step", "-0.01"]),
    (dict(start="paper"), ["--start", "paper"]),
    (dict(q=[1.0], q1=[1.01]), ["--q0", "1", "--q1", "1.01"]),
    (dict(t=2.0), ["--t0", "2"]),
    (dict(length=2.0, friction=0.0), ["--set", "length=2", "--set", "friction=0"]),
    (dict(every=7), ["--every", "7"]),
    (dict(run="far"), ["--q0", "3"]),
]


@pytest.mark.parametrize(("call", "arguments"), CALLS, ids=[" ".join(arguments) for _, arguments in CALLS])
def test_arguments_mean_what_options_mean(program: Path, tmp_path: Path, call: dict, arguments: list[str]) -> None:
    (tmp_path / "swing.dsocs").write_text(SWING, encoding="utf-8")
    system = dsocs.read(tmp_path / "swing.dsocs")
    run = system.flow(**call)
    end = run.t[0] + 100 * run.h
    run.until(end)
    same(run, run_program(program, "run", "swing.dsocs", "--until", repr(float(end)), *arguments, cwd=tmp_path))


def test_a_start_is_projected_as_by_the_program(program: Path, tmp_path: Path, rod: dsocs.System) -> None:
    (tmp_path / "rod.dsocs").write_text(rod.text, encoding="utf-8")
    run = rod.flow(h=0.01, q=[0.9, 0.1], v=[0.1, 0.3], project=True).until(1.0)
    arguments = ["--q0", "0.9,0.1", "--v0", "0.1,0.3", "--project", "--until", "1"]
    same(run, run_program(program, "run", "rod.dsocs", *arguments, cwd=tmp_path))


def test_a_run_of_a_file_is_that_of_the_program(program: Path, tmp_path: Path) -> None:
    (tmp_path / "swing.dsocs").write_text(SWING, encoding="utf-8")
    run = dsocs.read(f"{tmp_path}/swing.dsocs:far").flow().until()
    same(run, run_program(program, "run", "swing.dsocs:far", cwd=tmp_path))


def test_held_inputs_have_the_bits_of_the_program(program: Path, tmp_path: Path) -> None:
    (tmp_path / "swing.dsocs").write_text(SWING, encoding="utf-8")
    (tmp_path / "torque.csv").write_text("0.205,0.5\n0.5,-1\n0.9,0.25\n", encoding="utf-8")
    out = run_program(program, "run", "swing.dsocs", "--until", "1.5", "--input", "torque=torque.csv", cwd=tmp_path)
    plan = [(0.205, 0.5), (0.5, -1.0), (0.9, 0.25)]

    def control(node: dsocs.Node) -> dict[str, float] | None:
        # a value holds from the next node on: at order 2 the run knows one position more than its node
        ahead = node.t + 0.01 + 1e-8
        passed = [value for t, value in plan if t <= ahead]
        return {"torque": passed[-1]} if passed else None

    run = dsocs.read(tmp_path / "swing.dsocs").flow().until(1.5, control=control)
    same(run, out)


def test_what_is_observed_of_a_changed_input_has_the_bits_of_the_program(program: Path, tmp_path: Path) -> None:
    text = SWING.replace("observe = [height];", "let power = torque * dot(theta);\nobserve = [height, power];")
    (tmp_path / "swing.dsocs").write_text(text, encoding="utf-8")
    (tmp_path / "torque.csv").write_text("0.2,0.5\n0.5,-1\n", encoding="utf-8")
    out = run_program(program, "run", "swing.dsocs", "--until", "1", "--input", "torque=torque.csv", cwd=tmp_path)
    run = dsocs.read(tmp_path / "swing.dsocs").flow()
    for time, torque in ((0.2, 0.5), (0.5, -1.0)):
        # it holds from the last known position on, one step ahead
        run.until(time - 0.01).set(torque=torque)
    same(run.until(1.0), out)


def test_samples_have_the_bits_of_the_program(program: Path, tmp_path: Path) -> None:
    text = 'parameters { pull = samples("pull.csv", monotone) }\ncoordinates(x);\nlagrangian = dot(x).powi(2) / 2 + pull.at(t) * x;\n'
    (tmp_path / "pull.dsocs").write_text(text, encoding="utf-8")
    (tmp_path / "pull.csv").write_text("t,pull\n0,0\n0.5,1\n1,0.25\n2,0\n", encoding="utf-8")
    out = run_program(program, "run", "pull.dsocs", "--q0", "0", "--v0", "1", "--until", "1", cwd=tmp_path)
    same(dsocs.read(tmp_path / "pull.dsocs").flow(h=0.01, q=[0.0], v=[1.0]).until(1.0), out)
    # the same system with samples from arrays, by the parameter's name or by the file's
    for name in ("pull", "pull.csv"):
        given = dsocs.System(text, samples={name: (np.array([0, 0.5, 1, 2]), [0, 1, 0.25, 0])})
        same(given.flow(h=0.01, q=[0.0], v=[1.0]).until(1.0), out)


def test_constants_have_the_bits_of_the_program(program: Path, tmp_path: Path, beads: dsocs.System) -> None:
    (tmp_path / "beads.dsocs").write_text(beads.text, encoding="utf-8")
    out = run_program(
        program, "run", "beads.dsocs", "--const", "n=2", "--q0", "1,2", "--v0", "0,0", "--until", "1", "--set", "masses_1=0.3", cwd=tmp_path
    )
    system = dsocs.read(tmp_path / "beads.dsocs", constants={"n": 2})
    same(system.flow(h=0.01, q=[1.0, 2.0], v=[0.0, 0.0], masses_1=0.3).until(1.0), out)
    same(system.flow(h=0.01, q=[1.0, 2.0], v=[0.0, 0.0], masses=[0.1, 0.3]).until(1.0), out)


def test_errors_are_those_that_the_program_estimates(program: Path, tmp_path: Path, swing: dsocs.System) -> None:
    (tmp_path / "swing.dsocs").write_text(swing.text, encoding="utf-8")
    expected = table(run_program(program, "run", "swing.dsocs", "--until", "2", "--estimate-error", cwd=tmp_path))
    found = swing.flow().until(2.0).estimate_error()
    np.testing.assert_array_equal(found.errors[:, 0], expected["error_theta"])
    assert found.largest["theta"] == expected["error_theta"].max()
    assert 0 < found.uncertainty < 1e-12


def test_the_page_is_that_of_the_program(program: Path, tmp_path: Path) -> None:
    (tmp_path / "swing.dsocs").write_text(SWING, encoding="utf-8")
    run_program(program, "run", "swing.dsocs", "--until", "2", "--report", "page.html", cwd=tmp_path)
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    own = dsocs.read(tmp_path / "swing.dsocs").flow().until(2.0).page()
    data = [text[text.index('id="data">') : text.rindex("</script>\n<script>")] for text in (page, own)]
    assert data[0] == data[1]


def test_a_check_finds_what_the_program_finds(program: Path, tmp_path: Path, curved: dsocs.System) -> None:
    (tmp_path / "curved.dsocs").write_text(curved.text, encoding="utf-8")
    run_program(program, "check", "curved.dsocs", "--out", "check.json", cwd=tmp_path)
    expected = json.loads((tmp_path / "check.json").read_text(encoding="utf-8"))["systems"][0]["checks"]
    found = curved.check()
    assert found.ok and [finding.what for finding in found] == [finding["what"] for finding in expected]
    for ours, theirs in zip(found, expected):
        assert ours.figure == theirs["figure"] or np.isnan(ours.figure), ours


def test_the_program_is_told_of() -> None:
    assert PROGRAM is None or PROGRAM.is_file()
