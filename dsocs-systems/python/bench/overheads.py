"""The overhead of this package against the Rust library: prints a table.

    cargo build --release -p dsocs-systems --example beside_python
    python bench/overheads.py

The Rust side is the example `beside_python` of `dsocs-systems`. Both make the same steps of the same text, in turn, for some rounds. Times are processor times, which depend
little on the machine's other load. A processor's speed changes within seconds, by more than what is measured here. So each round compares the two sides
right after each other, now the one first and now the other, and the medians of all rounds are printed, of the times and of their ratios. For an ensemble
both the wall-clock time and the processor time of both threads are printed.

- a run: a million steps, with all nodes kept as arrays, or only the last. In Python the nodes are looked at for warnings on the way, in Rust they are not.
- a controller's callback: the time of a step with `control`, less that of a step under the same control in Rust, less that of the function itself, which is called in a Python
  loop.
- an ensemble: ten thousand runs in lanes on two threads, from arrays to arrays.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Callable

import numpy as np

import dsocs

ROOT = Path(__file__).resolve().parents[3]
TEXTS = {
    "pendulum": """
        parameters { length = 1.0, gravity = 9.81, torque = 0.0 }
        coordinates(theta);
        lagrangian = (length * dot(theta)).powi(2) / 2 + gravity * length * theta.cos();
        external_forces = torque;
        run { start = ([1.0], [0.0]); step = 0.01; }
    """,
    "particle": """
        parameters { mass = 1.0, curvature = 0.5 }
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
        kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
        variational = [(dot(x), dot(y))];
        run { start = ([0.0, 0.0], [1.0, 1.0]); step = 0.01; }
    """,
}


class Rust:
    """The program on the Rust side, which answers questions with times in s."""

    def __init__(self) -> None:
        target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
        program = target / "release" / "examples" / "beside_python"
        if not program.exists():
            sys.exit(f"{program} is not built: cargo build --release -p dsocs-systems --example beside_python")
        self.process = subprocess.Popen([str(program)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, *words: object) -> tuple[float, float]:
        """The wall-clock time and the processor time, in s."""
        assert self.process.stdin is not None and self.process.stdout is not None
        print(*words, file=self.process.stdin, flush=True)
        took, worked = self.process.stdout.readline().split()
        return float(took), float(worked)


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """The wall-clock time and the processor time, in s."""
    begun, worked = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - begun, time.process_time() - worked


def in_turn(rounds: int, *sides: Callable[[], tuple[float, float]]) -> np.ndarray:
    """The times of all rounds and sides: an array of the shape (rounds, sides, 2). Every other round goes through the sides backwards."""
    found = []
    for number in range(rounds):
        order = range(len(sides))
        times = {side: sides[side]() for side in (order if number % 2 == 0 else reversed(order))}
        found.append([times[side] for side in order])
    return np.array(found)


def compare(name: str, rounds: int, rust: Callable[[], tuple[float, float]], python: Callable[[], object], took: bool = False) -> None:
    """Prints a line: both times and their ratio."""
    times = in_turn(rounds, rust, lambda: timed(python))
    for which, what in enumerate((", took", ", worked" if took else "")):
        if took or what == "":
            in_rust, in_python = np.median(times[:, :, which], axis=0)
            more = np.median(times[:, 1, which] / times[:, 0, which]) - 1
            print(f"| {name}{what} | {in_rust:.4g} | {in_python:.4g} | {100 * more:+.1f} % |", flush=True)


def runs(rust: Rust, folder: Path, steps: int, rounds: int) -> None:
    for name, text in TEXTS.items():
        file = folder / f"{name}.dsocs"
        file.write_text(text, encoding="utf-8")
        system = dsocs.read(file)
        end = steps * 0.01

        def kept() -> object:
            run = system.flow().until(end)
            return run.t, run.q, run.v, run.a, run.force, run.energy

        compare(f"{name}, {steps} steps, all nodes kept", rounds, lambda: rust.ask("kept", file, steps), kept)
        compare(f"{name}, {steps} steps, the last kept", rounds, lambda: rust.ask("end", file, steps), lambda: system.flow(every=steps).until(end).q)


def ensembles(rust: Rust, folder: Path, count: int, rounds: int) -> None:
    file = folder / "pendulum.dsocs"
    system = dsocs.read(file)
    starts, lengths = np.linspace(0, 3, count)[:, None], np.linspace(1, 2, count)
    for end in (2.0, 20.0):
        python = lambda: system.ensemble(q=starts, v=[0.0], length=lengths).until(end, threads=2).q  # noqa: B023, E731
        compare(f"ensemble of {count} to {end:g} s, 2 threads", rounds, lambda: rust.ask("ensemble", file, count, end, 2), python, took=True)  # noqa: B023


def silent(node: dsocs.Node) -> None:
    return None


def brake(node: dsocs.Node) -> dict[str, float]:
    return {"torque": -2 * node["v_theta"]}


def callbacks(rust: Rust, folder: Path, steps: int, rounds: int) -> None:
    print("\n| a controller at each step | the step in Rust (µs) | in Python (µs) | the function itself (µs) | the callback (µs) |\n|---|---|---|---|---|")
    file = folder / "pendulum.dsocs"
    system = dsocs.read(file)
    end = steps * 0.01
    node = system.flow().node

    def loop(control: Callable[[dsocs.Node], object]) -> None:
        for _ in range(steps):
            control(node)

    def empty() -> None:
        for _ in range(steps):
            pass

    for name, control, question in (("returns None", silent, "kept"), ('returns `{"torque": -2 * node["v_theta"]}`', brake, "controlled")):
        times = in_turn(
            rounds,
            lambda: rust.ask(question, file, steps),  # noqa: B023
            lambda: timed(lambda: system.flow().until(end, control=control)),  # noqa: B023
            lambda: timed(lambda: loop(control)),  # noqa: B023
            lambda: timed(empty),
        )
        in_rust, in_python, called, counted = 1e6 / steps * times[:, :, 1].T
        own = called - counted
        alone, both, own, callback = (float(np.median(x)) for x in (in_rust, in_python, own, in_python - in_rust - own))
        print(f"| {name} | {alone:.3f} | {both:.3f} | {own:.3f} | {callback:.3f} |", flush=True)


def main() -> None:
    asked = argparse.ArgumentParser(description="Prints the table.")
    asked.add_argument("--rounds", type=int, default=40)
    rounds = asked.parse_args().rounds
    rust = Rust()
    print("| | Rust (s) | Python (s) | more |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        runs(rust, folder, 1_000_000, rounds)
        ensembles(rust, folder, 10_000, rounds)
        callbacks(rust, folder, 200_000, rounds)


if __name__ == "__main__":
    main()
