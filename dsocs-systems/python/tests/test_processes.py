"""Forked processes, and processes without enough memory."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

FORKED = """
import multiprocessing
import numpy as np
import dsocs

pendulum = dsocs.System("coordinates(a); lagrangian = dot(a).powi(2) / 2 + a.cos();", name="pendulum")

def last(x, threads=None):
    return float(pendulum.ensemble(h=0.01, q=np.full((100, 1), x), v=[0.0]).until(1.0, threads=threads)["a"][0])

if __name__ == "__main__":
    here = [last(x) for x in (1.0, 2.0)]
    last(1.0, 2)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(last, [1.0, 2.0]).get(60) == here
        assert pool.starmap_async(last, [(1.0, 2), (2.0, 2)]).get(60) == here
    print("done")
"""

#: The program of a process that asks for more than its limit of half a gigabyte.
SMALL = """
import resource
import numpy as np
import dsocs

with open("/proc/self/statm") as file:
    most = int(file.read().split()[0]) * resource.getpagesize() + (1 << 29)
resource.setrlimit(resource.RLIMIT_AS, (most, most))
three = dsocs.System("coordinates(x, y, z); lagrangian = (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2)) / 2;")
try:
    {call}
except MemoryError as error:
    print("MemoryError:", error)
"""
CALLS = {
    "until": "three.flow(h=0.001, q=[0, 0, 0], v=[0, 0, 0]).until(1e9)",
    "ensemble": "three.ensemble(h=0.01, q=np.broadcast_to(0.0, (4_000_000, 3)), v=[0.0, 0.0, 0.0]).until(0.1)",
    "sample": "three.flow(h=0.01, q=[0, 0, 0], v=[0, 0, 0]).sample(np.linspace(0.0, 1e3, 10_000_000))",
}


def in_a_process(program: str) -> str:
    # in another folder, so that it imports the installed package
    folder = tempfile.gettempdir()
    python = [sys.executable, "-c", program]
    done = subprocess.run(python, cwd=folder, capture_output=True, text=True, timeout=180, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.skipif(sys.platform != "linux", reason="processes are not forked elsewhere")
def test_a_forked_process_has_threads_of_its_own() -> None:
    assert in_a_process(FORKED) == "done\n"


@pytest.mark.skipif(sys.platform != "linux", reason="limits are those of Linux")
@pytest.mark.parametrize("call", CALLS)
def test_what_is_too_large_is_a_memory_error(call: str) -> None:
    assert in_a_process(SMALL.replace("{call}", CALLS[call])).startswith("MemoryError")


SPAWNED = """
import multiprocessing
import dsocs

pendulum = dsocs.System("coordinates(a); lagrangian = dot(a).powi(2) / 2 + a.cos(); let unused = a;")

def last(x):
    return float(pendulum.flow(h=0.01, q=[x], v=[0.0]).until(0.1)["a"][-1])

if __name__ == "__main__":
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        pool.map(last, [1.0, 2.0])
"""


def test_a_process_that_is_spawned_does_not_warn_again(tmp_path: Path) -> None:
    script = tmp_path / "spawned.py"
    script.write_text(SPAWNED)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=180, check=True)
    assert done.stderr.count("DeclarationWarning") == 1, done.stderr
