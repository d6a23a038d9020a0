"""This package beside heyoka.py, diffrax and scipy's DOP853: prints a table.

    pip install heyoka diffrax scipy
    python bench/side_by_side.py

Each script in `side_by_side/PROBLEM/with_TOOL.py` is what a user writes, and ends with a function `solve`. It runs in a fresh process: once to its first
result, and then some times more. All are asked for errors of 1e-10 by their own measure, relative and absolute, except the package's ensemble in lanes, whose step
is fixed. On a problem with a grid they give the motion at every 0.1 s.

- *lines* of the script without those that are empty or comments. All but this package's and heyoka's two that take a Lagrangian need equations that were derived by hand beforehand.
- *first* result: the time [s] from the start of the process on, with imports and what is compiled; the median of the processes.
- *run*: the time [s] of `solve` once more in the same process; the least.
- *error*: the largest difference of a coordinate at the end from the exact motion; where none is known, from what this package's series give with a tolerance near the
  rounding. Below the table is the distance of heyoka's end, with such a tolerance, from this one.

A tool that is not installed is left out with a message.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

SCRIPTS = Path(__file__).resolve().parent / "side_by_side"
PROBLEMS = {
    "pendulum": "inertia wheel pendulum under its Lyapunov law, 500 s",
    "particle": "particle of the curvature 1, 500 s",
    "chain": "chain of 8 links, 10 s",
    "starts": "a thousand starts of a pendulum, 20 s, ends alone",
}
TOOLS = {"dsocs": "dsocs", "dsocs_lanes": "dsocs", "heyoka": "heyoka", "diffrax": "diffrax", "scipy": "scipy"}
#: `solve` is called again for this duration [s], and at least this often.
AGAIN, LEAST = 2.0, 1

#: The program of a fresh process: it runs a script, and writes its results with the time of the first.
CHILD = """
import json, sys, time
AGAIN, LEAST = {again}, {least}
names = {{"__name__": "script"}}
exec(compile(open(sys.argv[1]).read(), sys.argv[1], "exec"), names)
end = [float(x) for x in names["solve"]()]
first, times = time.monotonic(), []
while len(times) < LEAST or sum(times) < AGAIN:
    begun = time.monotonic()
    again = [float(x) for x in names["solve"]()]
    times.append(time.monotonic() - begun)
assert max(abs(a - b) for a, b in zip(again, end)) < 1e-9
json.dump(dict(first=first, run=min(times), end=end), sys.stdout)
"""


def lines(script: Path) -> int:
    """The number of lines of a script, without comments."""
    kept = [line.strip() for line in script.read_text(encoding="utf-8").splitlines()]
    return sum(bool(line) and not line.startswith("#") for line in kept)


def measured(script: Path, processes: int) -> dict[str, object]:
    """The times of a script in fresh processes: the median of the first calls, the least of the others, and the result."""
    found = []
    for _ in range(processes):
        begun = time.monotonic()  # the same clock in all processes
        child = CHILD.format(again=AGAIN, least=LEAST)
        # not in the folder of the package's sources, which are not built
        done = subprocess.run([sys.executable, "-c", child, str(script)], cwd=script.parent, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{script}: {done.stderr}")
        one = json.loads(done.stdout)
        found.append({**one, "first": one["first"] - begun})
    return {"first": median(one["first"] for one in found), "run": min(one["run"] for one in found), "end": found[0]["end"]}


def by_package(problem: str) -> list[float]:
    """The final state of a motion, by this package to nearly all digits."""
    script = (SCRIPTS / problem / "with_dsocs.py").read_text(encoding="utf-8").replace("tolerance=1e-10", "tolerance=2e-16")
    names: dict[str, object] = {"__name__": "script"}
    exec(compile(script, problem, "exec"), names)
    return [float(x) for x in names["solve"]()]  # type: ignore[operator]


def by_heyoka(problem: str) -> list[float]:
    """The final state of a motion, by heyoka to nearly all digits."""
    script = (SCRIPTS / problem / "with_heyoka.py").read_text(encoding="utf-8").replace("tol=1e-10", "tol=1e-17")
    names: dict[str, object] = {"__name__": "script"}
    exec(compile(script, problem, "exec"), names)
    return [float(x) for x in names["solve"]()]  # type: ignore[operator]


def exact(problem: str) -> list[float]:
    """The exact final position of the particle, which turns by the angle `speed * t` on a circle of radius 1."""
    from math import cos, pi, sin, sqrt

    turned = pi / 4 + 500 * sqrt(2)
    return [sin(turned) - sin(pi / 4), cos(pi / 4) - cos(turned)]


def distance(one: list[float], other: list[float]) -> float:
    return max(abs(a - b) for a, b in zip(one, other, strict=True))


def main() -> None:
    asked = argparse.ArgumentParser(description="Prints the table.")
    asked.add_argument("problems", nargs="*", choices=[*PROBLEMS, []], help="which problems; by default all of them")
    asked.add_argument("--processes", type=int, default=3, help="so many fresh processes for each script (3)")
    given = asked.parse_args()
    versions = {}
    for tool, package in TOOLS.items():
        try:
            versions[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            print(f"{package} is not installed (pip install {package}): it is left out", file=sys.stderr)
    print("| problem | with | lines | first result (s) | run (s) | error |\n|---|---|---|---|---|---|")
    apart = []
    for problem in given.problems or PROBLEMS:
        reference = exact(problem) if problem == "particle" else by_package(problem)
        if problem != "particle" and "heyoka" in versions:
            apart.append(f"{problem} {distance(reference, by_heyoka(problem)):.1e}")
        for tool, package in TOOLS.items():
            script = SCRIPTS / problem / f"with_{tool}.py"
            if package not in versions or not script.exists():
                continue
            one = measured(script, given.processes)
            error = distance(one["end"], reference)  # type: ignore[arg-type]
            name = "dsocs, lanes, order 2" if tool == "dsocs_lanes" else package
            print(f"| {PROBLEMS[problem]} | {name} | {lines(script)} | {one['first']:.2f} | {one['run']:.2g} | {error:.1e} |", flush=True)
    said = ", ".join(f"{package} {version}" for package, version in versions.items())
    print(f"\n{said}; Python {platform.python_version()}; {os.cpu_count()} cores ({platform.machine()}).")
    if apart:
        print(f"The reference of this package and that of heyoka differ by: {'; '.join(apart)}.")


if __name__ == "__main__":
    main()
