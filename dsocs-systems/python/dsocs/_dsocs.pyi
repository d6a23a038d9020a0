"""The engine, on which the Python files of this package are built. Only `Node` is for users."""

from typing import Any, Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

__version__: str

_Array = npt.NDArray[np.float64]
# the beginning of a run: a rule, its vectors, the acceleration near which one is looked for, the time,
# whether the start is projected
_Beginning = tuple[str, list[list[float]], list[float] | None, float, bool]

class Node:
    """A node of a run: its number, time, position, velocity, acceleration, constraint force and energy.

    `node["theta"]` is a coordinate by its name, `node["v_theta"]`, `node["a_theta"]` and `node["force_theta"]` its velocity, acceleration and force,
    `node["height"]` an observed expression, `node["lambda_0"]` a multiplier,
    `node["torque"]` a parameter, with the value that was set last, there or before. Where the name is that of
    an array or of a rotation, `node["x"]` and `node["v_x"]` are arrays; of a rotation `r`, `node["r"]` has four numbers, `node["v_r"]` three.
    """

    @property
    def index(self) -> int:
        """The number of the node; 0 is the start."""

    @property
    def t(self) -> float:
        """The time."""

    @property
    def q(self) -> _Array:
        """The position, an array with a number for each coordinate."""

    @property
    def v(self) -> _Array:
        """The velocity, an array with a number for each coordinate."""

    @property
    def a(self) -> _Array:
        """The acceleration, an array with a number for each coordinate."""

    @property
    def force(self) -> _Array:
        """The generalized constraint force, an array with a number for each coordinate."""

    @property
    def energy(self) -> float:
        """The energy."""

    def __getitem__(self, name: str) -> Any: ...

class Text:
    @staticmethod
    def parse(
        name: str,
        shown_as: str,
        text: str,
        constants: Sequence[tuple[str, float]],
        samples: Sequence[tuple[str, list[tuple[float, float]]]],
    ) -> Text: ...
    @property
    def name(self) -> str: ...
    @property
    def text(self) -> str: ...
    def warnings(self, shown_as: str) -> list[str]: ...
    def values(self) -> list[float]: ...
    def description(self) -> dict[str, Any]: ...
    def runs(self) -> list[dict[str, Any]]: ...

class RawRun:
    every: int
    def __init__(
        self,
        text: Text,
        values: list[float],
        h: float,
        order: int,
        tolerance: float | None,
        beginning: _Beginning,
        every: int,
    ) -> None: ...
    def until(
        self,
        t: float,
        progress: Callable[[float], None] | None,
        control: tuple[Callable[[Node], Mapping[str, Any] | None], int, Callable[[str, Any], list[tuple[str, float]]]] | None,
    ) -> None: ...
    def advance(self, steps: int, toward: float | None) -> None: ...
    def next(self, toward: float) -> Node | None: ...
    def set_input(self, parameter: str, value: float) -> None: ...
    def input(self, parameter: str) -> float | None: ...
    def changes(self) -> list[tuple[int, float, int, float]]: ...
    def change_count(self) -> int: ...
    def node(self) -> Node: ...
    def kept(self, row: int) -> Node: ...
    def index(self) -> int: ...
    def array(self, name: str) -> _Array: ...
    def unresolved(self) -> tuple[int, float, float, float] | None: ...
    def nearly_singular(self) -> tuple[int, float, int] | None: ...
    def warnings(self) -> list[str | None]: ...
    def __len__(self) -> int: ...

class RawPath:
    def __init__(self, text: Text, values: list[float], h: float, beginning: _Beginning, until: float) -> None: ...
    @property
    def steps(self) -> int: ...
    @property
    def end(self) -> Node: ...
    def gradient(
        self, at_end: bool, cost: Callable[[int, float, _Array, _Array, _Array], tuple[float, list[float]]]
    ) -> dict[str, Any]: ...
    def tangents(self, variables: list[tuple[str, int]]) -> list[list[list[float]]]: ...

def sample(run: RawRun, times: _Array) -> list[_Array]: ...
def watch(
    run: RawRun, t: float, watched: list[tuple[str, int, float, int, bool]]
) -> tuple[list[tuple[int, bool, float, list[float], list[float], list[float]]], bool]: ...
def roots(run: RawRun) -> tuple[list[float], list[float] | None]: ...
def advance_to(run: RawRun, q2: list[float]) -> None: ...
def ensemble(
    text: Text,
    values: list[float],
    h: float,
    beginning: _Beginning,
    q: _Array,
    v: _Array,
    varied: list[tuple[str, _Array]],
    t: float,
    order: int,
    tolerance: float | None,
    threads: int | None,
    progress: Callable[[float], None] | None,
) -> dict[str, Any]: ...
def linearize(
    text: Text,
    values: list[float],
    h: float | None,
    beginning: _Beginning,
    inputs: list[str] | None,
    outputs: list[str] | None,
) -> dict[str, Any]: ...
def state_change(rotations: list[int], before: list[list[float]], after: list[list[float]]) -> _Array: ...
def equilibria(
    text: Text, values: list[float], t: float, guesses: list[list[float]], free: list[str], held: list[str]
) -> tuple[list[dict[str, Any]], list[int | Exception]]: ...
def program(called: list[str]) -> int: ...
def samples(path: str) -> list[tuple[float, float]]: ...
def page(
    text: Text,
    values: list[float],
    h: float,
    until: float,
    order: int,
    tolerance: float | None,
    beginning: _Beginning,
    changed: list[str],
    rows: _Array,
    notes: list[str],
) -> str: ...
def estimate(
    text: Text,
    values: list[float],
    h: float,
    until: float,
    order: int,
    tolerance: float | None,
    beginning: _Beginning,
    held: list[tuple[str, list[tuple[float, float]]]],
    every: int,
) -> tuple[list[float], float]: ...
def certify(
    text: Text, values: list[float], h: float, until: float, beginning: _Beginning, every: int
) -> list[tuple[float, float, bool, bool]]: ...
def check(
    text: Text, values: list[float], h: float, until: float, beginning: _Beginning
) -> list[dict[str, Any]]: ...
