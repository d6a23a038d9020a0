"""Systems, fixtures and helpers that the tests share."""

from __future__ import annotations

import os
import signal
import subprocess
import warnings
from pathlib import Path

import pytest

import dsocs

# a process that a shell started in the background ignores Ctrl-C, and so would the tests that send it
signal.signal(signal.SIGINT, signal.default_int_handler)

SWING = """\
//! A pendulum with friction and a motor.
parameters {
    /// The length of the rod [m]
    length = 1.0,
    /// The acceleration of gravity [m/s²]
    gravity = 9.81,
    /// The friction in the pivot, per mass [1/s]
    friction = 0.1,
    /// The torque of the motor, per mass [N m/kg]
    torque = 0.0,
}
coordinates(
    /// The angle from below [rad]
    theta
);
lagrangian = (length * dot(theta)).powi(2) / 2 + gravity * length * theta.cos();
external_forces = (torque - friction * length.powi(2) * dot(theta));

/// The height above the lowest point [m]
let height = length * (1 - theta.cos());
observe = [height];

run { start = ([2.0], [0.0]); step = 0.01; until = 20.0; }
run far { start = ([3.0], [0.0]); until = 10.0; }
"""

ROD = """\
//! A mass on a rod in the plane.
parameters { length = 1.0, gravity = 9.81 }
coordinates(
    /// The place beside the pivot [m]
    x,
    /// The place above the pivot [m]
    y
);
lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - gravity * y;
holonomic = x.powi(2) + y.powi(2) - length.powi(2);
"""

CURVED = """\
//! A particle on a path of a given curvature.
parameters { mass = 1.0, curvature = 0.5 }
coordinates(x, y);
lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
variational = [(dot(x), dot(y))];
run { start = ([0.0, 0.0], [1.0, 0.0]); step = 0.05; until = 5.0; }
"""

BEADS = """\
const n = 3;
parameters { masses: [n] = [0.1; n], stiffness = 40.0 }
coordinates(x: [n]);
lagrangian = sum(0..n, |i| masses[i] / 2 * dot(x[i]).powi(2)) - sum(0..n, |i| stiffness / 2 * x[i].powi(2));
"""

FRICTION = """\
//! A mass that dry friction brings to rest.
parameters { dry = 1.0 }
coordinates(x);
lagrangian = dot(x).powi(2) / 2 - x.powi(2) / 2;
external_forces = -dry * dot(x).signum();
"""

RUNS_OUT = """\
//! A mass that vanishes at t = 1.
coordinates(x);
lagrangian = (1 - t) * dot(x).powi(2) / 2 - x;
"""


@pytest.fixture(scope="session")
def swing() -> dsocs.System:
    return dsocs.System(SWING, name="swing")


@pytest.fixture(scope="session")
def rod() -> dsocs.System:
    return dsocs.System(ROD, name="rod")


@pytest.fixture(scope="session")
def curved() -> dsocs.System:
    return dsocs.System(CURVED, name="curved")


@pytest.fixture(scope="session")
def beads() -> dsocs.System:
    return dsocs.System(BEADS, name="beads")


def find_program() -> Path | None:
    """The program `dsocs` of the workspace: the path in DSOCS_PROGRAM, or the latest build."""
    if asked := os.environ.get("DSOCS_PROGRAM"):
        return Path(asked)
    workspace = Path(__file__).resolve().parents[3]
    target = Path(os.environ.get("CARGO_TARGET_DIR", workspace / "target"))
    built = [target / profile / "dsocs" for profile in ("release", "debug")]
    built = [path for path in built if path.is_file()]
    return max(built, key=lambda path: path.stat().st_mtime, default=None)


PROGRAM = find_program()


def pytest_report_header() -> str:
    if PROGRAM is None:
        return "dsocs: THE PROGRAM `dsocs` IS NOT BUILT (cargo build): no results are compared with its"
    return f"dsocs: results are compared with those of {PROGRAM}"


@pytest.fixture(scope="session")
def program() -> Path:
    if PROGRAM is None:
        pytest.skip("the program `dsocs` is not built (cargo build), so nothing can be compared with it")
    return PROGRAM


def run_program(program: Path, *arguments: str, cwd: Path) -> str:
    """Standard output of the program."""
    done = subprocess.run([str(program), *arguments], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(autouse=True)
def _warnings_are_seen() -> object:
    with warnings.catch_warnings():
        warnings.simplefilter("error", dsocs.DeclarationWarning)
        yield


def text_of_library(program: Path, folder: Path, name: str) -> Path:
    """A system of the program as a text file."""
    file = folder / f"{name}.dsocs"
    if not file.exists():
        done = subprocess.run([str(program), "text", name], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            pytest.skip(f"{name}: {done.stderr.strip()}")
        file.write_text(done.stdout, encoding="utf-8")
    return file
