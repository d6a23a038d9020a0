"""A run of a system."""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Callable, Iterator, Mapping, NamedTuple, Union, overload

import numpy as np
import numpy.typing as npt

from . import _dsocs, _inputs
from ._dsocs import Node
from ._errors import InputTypeError, Interrupted, SetupError, StepError, StepWarning
from ._events import Event, Occurrences, Points
from ._progress import shown
from ._table import frame
from ._system import STEP, UNTIL, System, _system_of

if TYPE_CHECKING:
    from ._check import Findings

Array = npt.NDArray[np.float64]
#: What is shown of the progress: nothing, a line or a bar, or a function that is told the part that is done.
Progress = Union[bool, Callable[[float], object]]

#: The unit round-off of double precision: no tolerance below it can be reached.
_UNIT = 2.0**-53
#: Above this tolerance the errors of the steps may add up to some per cent.
_LOOSE = 1e-4


class Unresolved(NamedTuple):
    """Steps that were too long for what jumps in them, such as dry friction. Each reduces the order of the run to 1."""

    #: How many steps.
    steps: int
    #: The time of the first of them.
    first: float
    #: The largest departure from what a smooth force would do, relative to the change of the momentum over the step.
    largest: float


class NearlySingular(NamedTuple):
    """Steps in which the equations were nearly singular: they hardly determine the acceleration there."""

    #: How many steps.
    steps: int
    #: The time of the first of them.
    first: float
    #: In how many of them the equations of the step alone were, and those of the continuous motion were not.
    of_step: int


class ErrorEstimate(NamedTuple):
    """How far a run is from the continuous motion."""

    #: The error of each coordinate at each node: an array of the shape (nodes, coordinates).
    errors: Array
    #: The largest error of each coordinate, by name.
    largest: dict[str, float]
    #: How well the continuous motion itself is known.
    uncertainty: float


class Certificate(NamedTuple):
    """How regular the equations of each step are: the paper's theorem on the discrete flow asks that neither singular value is zero."""

    #: The smallest singular value of the derivative by the last node, an array of the shape (nodes,); NaN at the start.
    forward: Array
    #: The smallest singular value of the derivative by the first node, an array of the shape (nodes,); NaN at the start.
    backward: Array
    #: Whether the theorem grants a flow at each node, forward and back: an array of the shape (nodes, 2). At the start, where no step was solved, it is true.
    granted: npt.NDArray[np.bool_]


class Roots(NamedTuple):
    """The positions that solve a step."""

    #: The one that the iteration finds: an array of the shape (coordinates,).
    found: Array
    #: Another one; None if none is found.
    other: Array | None


@dataclass(frozen=True)
class Setup:
    """What a run is set up with."""

    h: float
    until: float
    values: tuple[float, ...]
    rule: str
    vectors: tuple[tuple[float, ...], ...]
    near: tuple[float, ...] | None
    t: float
    project: bool
    order: int
    tolerance: float | None
    every: int

    @staticmethod
    def of(
        system: System,
        *,
        h: Any = None,
        q: Any = None,
        v: Any = None,
        q1: Any = None,
        q2: Any = None,
        a: Any = None,
        force: Any = None,
        near: Any = None,
        t: Any = 0.0,
        start: Any = None,
        project: Any = None,
        order: Any = 2,
        tolerance: Any = None,
        every: Any = 1,
        run: Any = None,
        values: Mapping[str, Any] | None = None,
    ) -> Setup:
        """What is asked for; what is not is that of the text's run."""
        text = system._run_text(run)
        names = system._names
        own_q, own_v = (text.start if text is not None and text.start is not None else (None, None))
        step = _inputs.number("h", h) if h is not None else (text.step if text and text.step is not None else STEP)
        if step == 0:
            raise SetupError("h is 0; expected a step that is not zero (a negative step runs back in time)")
        t0 = _inputs.number("t", t)
        _check_method(order, tolerance, start, q1)
        first = _vector("q", q, names, own_q)
        if first is None:
            raise _missing(system, "q")

        def velocity() -> tuple[float, ...]:
            vector = _vector("v", v, names, own_v, system._moving)
            if vector is None:
                raise _missing(system, "v")
            return vector

        rule: str
        vectors: tuple[tuple[float, ...], ...]
        for name, other in (("v", v), ("start", start), ("a", a), ("force", force)):
            if q1 is not None and other is not None:
                raise SetupError(f"q1 and {name} are both given; two nodes begin a run without a velocity")
        if a is not None and force is not None:
            raise SetupError("a and force are both given; one of them begins the run")
        if near is not None and (a is not None or force is not None):
            raise SetupError("near says which acceleration is meant, and a or force give it; one of them is enough")
        if q1 is not None:
            second = _vector("q1", q1, names, None)
            third = _vector("q2", q2, names, None)
            rule, vectors = "nodes", tuple(x for x in (first, second, third) if x is not None)
        elif q2 is not None:
            raise SetupError("q2 is given without q1; three nodes begin a run of third order")
        elif start is not None:
            if start not in ("paper", "second-order"):
                raise SetupError(f"start is {start!r}; expected 'second-order' or 'paper'")
            rule, vectors = start, (first, velocity())
        elif force is not None:
            rule, vectors = "force", (first, velocity(), _vector("force", force, names, None, system._moving) or ())
        else:
            own_a = text.acceleration if text is not None else None
            acceleration = _vector("a", a, names, own_a, system._moving)
            if acceleration is not None:
                rule, vectors = "acceleration", (first, velocity(), acceleration)
            else:
                rule, vectors = "second-order", (first, velocity())
        own_near = text.near if text is not None else None
        nearby = _vector("near", near, names, own_near, system._moving)
        if project is not None and not isinstance(project, (bool, np.bool_)):
            raise InputTypeError(f"project is {project!r}; expected True or False")
        projected = bool(project) or (project is None and text is not None and text.project)
        length = text.until if text is not None and text.until is not None else UNTIL
        # back in time with a negative step; a text whose run goes back in time goes nowhere else by itself
        length = length if length < 0 else math.copysign(length, step)
        return Setup(
            h=step,
            until=t0 + length,
            values=tuple(system._with(values or {})),
            rule=rule,
            vectors=vectors,
            near=nearby,
            t=t0,
            project=projected,
            order=order,
            tolerance=_tolerance(tolerance),
            every=_inputs.whole("every", every, 1),
        )

    @property
    def begins(self) -> tuple[Any, ...]:
        """The start, as the engine takes it."""
        near = None if self.near is None else list(self.near)
        return (self.rule, [list(vector) for vector in self.vectors], near, self.t, self.project)

    def begin(self, system: System) -> Any:
        """A run of the engine."""
        return _dsocs.RawRun(
            system._raw, list(self.values), self.h, self.order, self.tolerance, self.begins, self.every
        )


def _vector(
    name: str, given: Any, names: list[str], own: list[float] | None, moving: list[str] | None = None
) -> tuple[float, ...] | None:
    """A number for each coordinate. Of a velocity, with those that are `moving`, a rotation has three, in the frame of its body, or a zero before them."""
    if given is None:
        return None if own is None else tuple(own)
    if moving is None or len(moving) == len(names) or np.shape(given) == (len(names),):
        return tuple(_inputs.vector(name, given, names, own))
    among = None if own is None else [number for place, number in zip(names, own) if place in moving]
    numbers = dict(zip(moving, _inputs.vector(name, given, moving, among)))
    return tuple(numbers.get(place, 0.0) for place in names)


def _missing(system: System, name: str) -> SetupError:
    said = "{" + ", ".join(f"{coordinate!r}: …" for coordinate in system._names) + "}"
    return SetupError(
        f"{name} is not given, and the text of {system.name} has no run with a start: give {name}={said}, or in the text, "
        "`run { start = ([…], […]); }`, position and velocity"
    )


def _check_method(order: Any, tolerance: Any, start: Any, q1: Any) -> None:
    if isinstance(order, (bool, np.bool_)) or not isinstance(order, (int, np.integer)):
        raise InputTypeError(f"order is {order!r}; expected 2, 4, 6 or 8")
    if order not in (2, 4, 6, 8):
        raise SetupError(f"order is {order}; the step has order 2, its compositions 4, 6 and 8")
    if tolerance is not None and order != 2:
        raise SetupError("order and tolerance are both given; the continuous motion has no order")
    method = "tolerance" if tolerance is not None else f"order={order}" if order > 2 else None
    if method is not None and q1 is not None:
        raise SetupError(
            f"q1 cannot be used with {method}: it begins with a position and a velocity; two nodes begin the step of order 2 alone"
        )
    if method is not None and start is not None:
        raise SetupError(
            f"start cannot be used with {method}: it begins with the position and the velocity themselves; only the step of order 2 needs "
            "a second node"
        )


def _tolerance(tolerance: Any) -> float | None:
    if tolerance is None:
        return None
    given = _inputs.number("tolerance", tolerance)
    if not 0 < given < 1:
        raise SetupError(f"tolerance is {given}; it must lie between 0 and 1")
    if given < _UNIT:
        warnings.warn(
            f"the tolerance {given:g} cannot be reached: numbers of double precision are rounded by {_UNIT:.1e} of their size, and that is "
            "the tolerance taken",
            StepWarning,
            stacklevel=4,
        )
        return _UNIT
    if given > _LOOSE:
        warnings.warn(
            f"the tolerance {given:g} is that of each step, and the errors of the steps add up: in the end nothing may be left of the motion. "
            "1e-9 costs little more; estimate_error() measures the error",
            StepWarning,
            stacklevel=4,
        )
    return given


class Run:
    """A run: a motion that is computed node by node, and the nodes that it has so far.

    `System.flow` begins one, which stands at its start. `until` and `advance` go on. All arrays have a row for each node that is kept; they
    are not copied, and cannot be written to. `run["theta"]` is a column by its name: a coordinate, an observed expression, `v_theta`, `a_theta`,
    `force_theta`, `lambda_0` (a multiplier), `t` or `energy`. `run[-1]` is a node.
    """

    def __init__(self, system: System, setup: Setup) -> None:
        #: The system.
        self.system = system
        self._setup = setup
        self._raw_run: Any = setup.begin(system)
        self._kept: dict[str, Any] | None = None
        self._history: list[tuple[Any, ...]] = []
        self._told = [0, 0]

    @property
    def _raw(self) -> Any:
        """The engine's run. That of a run that was copied or pickled is made again when it goes on: it takes the same steps, with the same bits."""
        if self._raw_run is None:
            raw = self._setup.begin(self.system)
            for what, *how in self._history:
                _repeat(raw, what, *how)
            self._raw_run, self._kept = raw, None
        return self._raw_run

    def _array(self, name: str) -> Array:
        if self._kept is not None:
            kept: Array = self._kept[name]
            return kept
        array: Array = self._raw.array(name)
        return array

    # What it was set up with

    @property
    def h(self) -> float:
        """The step [s]; with a tolerance, the distance of the nodes."""
        return self._setup.h

    @property
    def order(self) -> int | None:
        """The order of the method; None for the continuous motion."""
        return None if self._setup.tolerance is not None else self._setup.order

    @property
    def tolerance(self) -> float | None:
        """The tolerance of the continuous motion; None for a method of an order."""
        return self._setup.tolerance

    @property
    def every(self) -> int:
        """Every so many nodes one is kept."""
        return self._setup.every

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters with the values that the run began with."""
        return {of.name: value for of, value in zip(self.system._parameters, self._setup.values)}

    # What it has

    @property
    def t(self) -> Array:
        """The times [s]: an array of the shape (nodes,)."""
        return self._array("t")

    @property
    def q(self) -> Array:
        """The positions: an array of the shape (nodes, coordinates)."""
        return self._array("q")

    @property
    def v(self) -> Array:
        """The velocities: an array of the shape (nodes, coordinates)."""
        return self._array("v")

    @property
    def a(self) -> Array:
        """The accelerations: an array of the shape (nodes, coordinates)."""
        return self._array("a")

    @property
    def force(self) -> Array:
        """The generalized constraint forces: an array of the shape (nodes, coordinates)."""
        return self._array("force")

    @property
    def energy(self) -> Array:
        """The energies: an array of the shape (nodes,)."""
        return self._array("energy")

    @property
    def observed(self) -> Array:
        """The observed expressions: an array of the shape (nodes, expressions). They are computed when they are first asked for."""
        return self._array("observed")

    @property
    def multipliers(self) -> Array:
        """The multipliers of the constraint forces: an array of the shape (nodes, multipliers). They are computed when they are first asked for."""
        return self._array("multipliers")

    @property
    def node(self) -> Node:
        """The node where the run stands, which is kept or not."""
        node: Node = self._raw.node()
        return node

    @property
    def index(self) -> int:
        """The number of the node where the run stands; 0 is the start."""
        if self._kept is not None:
            index: int = self._kept["index"]
            return index
        index = self._raw.index()
        return index

    @property
    def columns(self) -> list[str]:
        """The names of all columns, in the order of the command line's table."""
        names = self.system._names
        observed = [of.name for of in self.system.observables]
        multipliers = [f"lambda_{form}" for form in range(self.system.forms)]
        moving = self.system._moving
        return ["t", *names, *(f"v_{x}" for x in moving), *(f"force_{x}" for x in moving), "energy", *observed, *multipliers]

    @property
    def units(self) -> dict[str, str | None]:
        """The unit of each column, as far as the declaration says it."""
        units: dict[str, str | None] = {"t": "s", "energy": "J"}
        for name, _, unit in self.system.coordinates:
            units[name] = unit
            units[f"v_{name}"] = None if unit is None else f"{unit}/s"
            units[f"force_{name}"] = None if unit is None else _FORCES.get(unit, f"J/{unit}")
        units.update((of.name, of.unit) for of in self.system.observables)
        return {name: units.get(name) for name in self.columns}

    @property
    def unresolved(self) -> Unresolved | None:
        """The steps so far that were too long for what jumps in them; None if there is none."""
        found = self._kept["unresolved"] if self._kept is not None else self._raw.unresolved()
        return None if found is None else Unresolved(*found)

    @property
    def nearly_singular(self) -> NearlySingular | None:
        """The steps so far in which the equations were nearly singular; None if there is none."""
        found = self._kept["nearly_singular"] if self._kept is not None else self._raw.nearly_singular()
        return None if found is None else NearlySingular(*found)

    def table(self) -> dict[str, Array]:
        """All columns by name, as the command line writes them."""
        return {name: self[name] for name in self.columns}

    def frame(self) -> Any:
        """The table as a `pandas.DataFrame`, for which pandas has to be installed."""
        return frame(self.table())

    def __len__(self) -> int:
        """How many nodes are kept."""
        return len(self._kept["t"]) if self._kept is not None else len(self._raw)

    @overload
    def __getitem__(self, key: str) -> Array: ...
    @overload
    def __getitem__(self, key: int) -> Node: ...

    def __getitem__(self, key: str | int) -> Array | Node:
        if isinstance(key, str):
            return self._column(key)
        if isinstance(key, (bool, np.bool_)) or not isinstance(key, (int, np.integer)):
            raise InputTypeError(f"run[{key!r}]: expected the name of a column, or the number of a node that is kept")
        count = len(self)
        place = int(key) + count if key < 0 else int(key)
        if not 0 <= place < count:
            raise IndexError(f"run[{key}]: {count} nodes are kept")
        node: Node = self._raw.kept(place)
        return node

    def _column(self, name: str) -> Array:
        if name == "t":
            return self.t
        if name == "energy":
            return self.energy
        names = self.system._names
        for prefix, column in (("", "q"), ("v_", "v"), ("a_", "a"), ("force_", "force")):
            if name.startswith(prefix) and name[len(prefix) :] in names:
                return self._array(column)[:, names.index(name[len(prefix) :])]
        for place, of in enumerate(self.system.observables):
            if of.name == name:
                return self.observed[:, place]
        if name.startswith("lambda_") and name[7:].isdecimal() and int(name[7:]) < self.system.forms:
            return self.multipliers[:, int(name[7:])]
        raise KeyError(str(_inputs.unknown("column", name, self.columns)))

    def __iter__(self) -> Iterator[Node]:
        """The nodes that are kept."""
        return (self[place] for place in range(len(self)))

    # How it goes on

    def until(
        self,
        t: float | None = None,
        *,
        progress: Progress = False,
        control: Callable[[Node], Mapping[str, float] | None] | None = None,
        control_every: int = 1,
    ) -> Run:
        """Runs up to the last node at or before the time `t` [s], by default that of the text's run, and returns itself.

        `progress`: True shows how far the run is; a function is told the part that is done, from 0 to 1.
        `control`: a function between steps. It gets the node, and returns the values of inputs by name, `{"torque": -2 * node["v_theta"]}`, or
        None. They hold from the last position that is known on: with order 2 this is the next node's. `control_every`: it is asked at every so many nodes.

        Raises `StepError` if a step has no solution, with the run up to there, and `Interrupted` where Ctrl-C ends it.
        """
        end = self._setup.until if t is None else _inputs.number("t", t)
        if control is not None and not callable(control):
            raise InputTypeError(f"control is {type(control).__name__}; expected a function of a node")
        every = _inputs.whole("control_every", control_every, 1)
        raw = self._raw
        begin, before = raw.index(), raw.change_count()
        with shown(progress, self.system.name, self._time(), end) as tell:
            try:
                raw.until(end, tell, control, every)
            except StepError as error:
                error.run = self
                raise
            except KeyboardInterrupt:
                raise Interrupted(
                    f"interrupted at t = {self._time():g}, after {raw.index() - begin} steps; the exception's `run` has them, and can go on", self
                ) from None
            finally:
                self._remember(raw, begin, before, end, control is not None)
        self._warn()
        return self

    def _remember(self, raw: Any, begin: int, before: int, end: float, controlled: bool) -> None:
        steps = raw.index() - begin
        if controlled:
            # which inputs these were is looked up when someone asks
            self._history.append(("changes", steps, end, before, raw.change_count()))
        elif steps:
            self._history.append(("advance", steps, end))

    def _told_history(self) -> list[tuple[Any, ...]]:
        """The history with the inputs themselves, so that it means the same for a copy."""
        if all(what[0] != "changes" for what in self._history):
            return list(self._history)
        names = [of.name for of in self.system._parameters]
        changes = self._raw.changes()
        told: list[tuple[Any, ...]] = []
        for what, *how in self._history:
            if what == "changes":
                steps, end, first, last = how
                inputs: dict[int, dict[str, float]] = {}
                for index, _, place, value in changes[first:last]:
                    inputs.setdefault(index, {})[names[place]] = value
                told.append(("control", steps, end, inputs))
            else:
                told.append((what, *how))
        return told

    def advance(self, steps: int = 1) -> Run:
        """Makes some steps, and returns itself. Raises as `until`."""
        count = _inputs.whole("steps", steps, 0)
        raw = self._raw
        begin = raw.index()
        try:
            raw.advance(count, None)
        except StepError as error:
            error.run = self
            raise
        except KeyboardInterrupt:
            raise Interrupted(f"interrupted at t = {self._time():g}; the exception's `run` can go on", self) from None
        finally:
            self._count(raw.index() - begin)
        self._warn()
        return self

    def _count(self, steps: int, end: float | None = None) -> None:
        last = self._history[-1] if self._history else None
        if steps and last is not None and last[0] == "advance" and last[2] == end:
            steps += self._history.pop()[1]
        if steps:
            self._history.append(("advance", steps, end))

    def steps(self, until: float | None = None) -> Iterator[Node]:
        """Goes on step by step: `for node in run.steps(20.0): …`. Between the steps inputs may be set (`set`), and a `break` ends it.

        The first node is the next one. `until` is a time [s], by default that of the text's run; `math.inf` goes on for ever. Raises as `until`.
        """
        end = self._setup.until if until is None else until
        if isinstance(end, (bool, str)) or not isinstance(end, (int, float, np.number)):
            raise InputTypeError(f"until is {end!r}; expected a time")
        raw = self._raw
        while True:
            try:
                node: Node | None = raw.next(float(end))
            except StepError as error:
                error.run = self
                raise
            if node is None:
                return
            self._count(1, float(end))
            self._warn()
            yield node

    def set(self, **inputs: float) -> Run:
        """Gives parameters other values, from the last position that is known on: `run.set(torque=0.5)`.

        With order 2 this is the position after the current node. Raises `SetupError` if there is no such parameter, or if it cannot change: one in a
        holonomic constraint, or inside a `dot(…)`.
        """
        for name, value in inputs.items():
            self._raw.set_input(name, _inputs.number(name, value))
            self._history.append(("set", name, float(value)))
        return self

    def watch(self, until: float | None = None, *events: str | Event) -> Occurrences:
        """Runs to the time `until` [s] like `until`, and tells where functions change their signs on the way, to rounding.

        ```python
        run.watch(20.0, "theta", dsocs.Event("height", level=0.5, rising=True, ends=True))
        ```

        An event is the name of a column (a coordinate, `v_theta`, `a_theta`, an observed expression), whose zeros count, or an `Event`. Between the nodes the motion is the
        series of the step with a `tolerance`, and else the polynomial of degree 5 through position, velocity and acceleration at both nodes. A zero without a change of sign is no
        event, nor is one at the start.

        At the first event that ends the run it stops: with a `tolerance` at the node before it, else at the node after it. Raises as `until`.
        """
        end = self._setup.until if until is None else _inputs.number("until", until)
        if not events:
            raise SetupError('no event is given; expected the name of a column, "theta", or dsocs.Event("theta", level=0.5)')
        watched = [Event.of_name(event) for event in events]
        asked = [event._found(self.system) for event in watched]
        raw = self._raw
        begin = raw.index()
        found: list[tuple[Any, ...]] = []
        ended = False
        try:
            found, ended = _dsocs.watch(raw, end, asked)
        except StepError as error:
            error.run = self
            raise
        except KeyboardInterrupt:
            raise Interrupted(f"interrupted at t = {self._time():g}; the exception's `run` can go on", self) from None
        finally:
            if ended:
                self._history.append(("watch", end, asked))
            else:
                self._count(raw.index() - begin, end)
        self._warn()
        return Occurrences(self.system, watched, found, ended)

    def sample(self, times: Any) -> Points:
        """The motion at some times [s], between the nodes as well.

        `times`: numbers that come in the order of the run, none of them before its start; they may lie beyond its end. Between the nodes the motion is that of `watch`.
        The steps are made once more for it, under the same inputs, and the run stays where it is.

        Raises `SetupError` if the times do not come in order, and `StepError` as `until`.
        """
        at = _inputs.array("times", times)
        if at.ndim != 1:
            raise SetupError(f"times has {at.ndim} dimensions; expected a row of numbers")
        if any(what[0] == "toward" for what in self._history):
            raise SetupError("this run was led from one solution to another (advance_to), which sample does not know; its nodes are in run.q")
        way = -1.0 if self.h < 0 else 1.0
        forward = way * at
        if len(at) and (np.any(np.diff(forward) < 0) or forward[0] < way * self._setup.t):
            raise SetupError(f"the times have to come in the order of the run, from its start at t = {self._setup.t:g} on")
        raw = self._setup.begin(self.system)
        parts: list[list[Array]] = []
        begin = 0
        for t, changes in self._changes():
            # what changes at a node holds for what is behind it
            stop = begin + int(np.searchsorted(forward[begin:], way * t, side="right"))
            parts.append(_dsocs.sample(raw, at[begin:stop].tolist()))
            begin = stop
            if begin == len(at):
                break
            raw.until(t, None, None, 1)
            for name, value in changes:
                raw.set_input(name, value)
        try:
            parts.append(_dsocs.sample(raw, at[begin:].tolist()))
        except StepError as error:
            error.run = self
            raise
        return Points(self.system, at, *(np.concatenate(arrays) for arrays in zip(*parts)))

    def _changes(self) -> Iterator[tuple[float, list[tuple[str, float]]]]:
        """The times where the run stood while inputs changed, and the inputs."""
        ahead = self._setup.tolerance is None and self._setup.order == 2
        grouped: dict[float, list[tuple[str, float]]] = {}
        for index, t, place, value in self._raw.changes():
            at = self._setup.t + index * self.h if ahead else t
            grouped.setdefault(at, []).append((self.system._parameters[place].name, value))
        yield from grouped.items()

    def roots(self) -> Roots:
        """The positions that solve the next step, one or two: order 2 alone. The run stays where it is. Raises `StepError` if none is found."""
        found, other = _dsocs.roots(self._raw)
        return Roots(np.asarray(found), None if other is None else np.asarray(other))

    def advance_to(self, q: Any) -> Run:
        """Makes one step, and takes the solution nearest to the position `q` where there are several: order 2 alone. Returns itself.

        `q` is a number for each coordinate, or a dict by name: `run.advance_to(run.roots().other)`. It is the position after that of the next node, since the step knows one position
        more than its node.
        """
        toward = _inputs.vector("q", q, self.system._names)
        try:
            _dsocs.advance_to(self._raw, toward)
        except StepError as error:
            error.run = self
            raise
        self._history.append(("toward", toward))
        self._warn()
        return self

    def _time(self) -> float:
        time: float = self._raw.node().t
        return time

    def _warn(self) -> None:
        """Tells of steps whose error may be larger, those of one call once."""
        unresolved, nearly_singular = self.unresolved, self.nearly_singular
        if unresolved is not None and unresolved.steps > self._told[0]:
            warnings.warn(self._jumps(unresolved, unresolved.steps - self._told[0]), StepWarning, stacklevel=3)
            self._told[0] = unresolved.steps
        if nearly_singular is not None and nearly_singular.steps > self._told[1]:
            warnings.warn(self._singular(nearly_singular, nearly_singular.steps - self._told[1]), StepWarning, stacklevel=3)
            self._told[1] = nearly_singular.steps

    def _jumps(self, found: Unresolved, steps: int) -> str:
        """What is said of steps within which something jumps."""
        plural = "s" if steps > 1 else ""
        # no method follows the continuous motion of third order
        third = self.system.order > 2
        if math.isinf(found.largest):
            ends = "end the run before" if third else "`tolerance` ends where the motion does"
            return (
                f"a force is infinite, or the velocity has to jump, within {steps} step{plural} that the run has passed, first about "
                f"t = {found.first:.3f}: what comes after depends on where the nodes lie ({ends})"
            )
        goes_on = "; or `tolerance`, which goes on from the place of the jump itself; estimate_error() measures what it costs"
        return (
            f"a force or a constraint jumps, or nearly so, within {steps} step{plural}, first about t = {found.first:.3f}: there the "
            f"motion has an error of the first order in the step (a smaller `h`{'' if third else goes_on})"
        )

    def _singular(self, found: NearlySingular, steps: int) -> str:
        """What is said of steps in which the equations were nearly singular."""
        plural = "s" if steps > 1 else ""
        third = self.system.order > 2
        if found.of_step == found.steps:
            ends = "" if third else "; `tolerance=1e-9` ends where the motion does"
            return (
                f"the equations of the step pass through a singularity in {steps} step{plural}, first about t = {found.first:.3f}, where those of the continuous "
                "motion have none: a force changes too fast with the velocity for this step, or the velocity grows beyond all bounds, and what comes after is not "
                f"the motion (a smaller `h`{ends})"
            )
        factor = "; a factor of a constraint that vanishes may be divided out, `branch = divide(factor)`" if self.system._may_divide else ""
        return (
            f"the equations are nearly singular in {steps} step{plural}, first about t = {found.first:.3f}: they hardly determine the "
            f"{'jerk' if third else 'acceleration'} there, and the error of the motion may be much larger than elsewhere, with that of multipliers (a "
            f"smaller `h` shows it{factor})"
        )

    # What can be said of it

    def estimate_error(self) -> ErrorEstimate:
        """How far the run is from the continuous motion, coordinate by coordinate, at every node that is kept.

        The continuous motion is computed by Taylor series to nearly all digits, under the same held inputs. The run is made once more for it.
        Raises `StepError` if the continuous motion cannot be computed, and `SetupError` if the run began with nodes, since it begins with a velocity.
        """
        if self._setup.rule == "nodes":
            raise SetupError("the error of a run that begins with nodes cannot be estimated: the continuous motion begins with a velocity")
        errors, uncertainty = _dsocs.estimate(
            self.system._raw, list(self._setup.values), self._setup.h, self._time(), self._setup.order,
            self._setup.tolerance, self._setup.begins, self._held(), self.every,
        )  # fmt: skip
        array: Array = np.asarray(errors).reshape(-1, len(self.system._names))
        largest = array.max(axis=0).tolist() if len(array) else [0.0] * len(self.system._names)
        return ErrorEstimate(array, dict(zip(self.system._names, largest)), uncertainty)

    def _held(self) -> list[tuple[str, list[tuple[float, float]]]]:
        """The inputs that changed: for each its times and values."""
        held: dict[int, list[tuple[float, float]]] = {}
        for _, t, place, value in self._raw.changes():
            plan = held.setdefault(place, [])
            if plan and plan[-1][0] == t:
                plan.pop()
            plan.append((t, value))
        return [(self.system._parameters[place].name, plan) for place, plan in held.items()]

    def certify(self) -> Certificate:
        """How regular the equations of each step are, at every node that is kept: order 2, without changed inputs. The run is made once more for it.

        Where a singular value is zero, the paper's theorem grants no flow: `run.certify().granted.all()`.
        """
        if self._setup.order > 2 or self._setup.tolerance is not None:
            raise SetupError("regularity is about the paper's step: order=2, without a tolerance")
        if self._raw.change_count() or any(what[0] == "toward" for what in self._history):
            raise SetupError("a run whose inputs changed, or that was led from one solution to another, is not certified: only a run from its start by itself is")
        told = _dsocs.certify(
            self.system._raw, list(self._setup.values), self._setup.h, self._time(), self._setup.begins, self.every
        )
        forward, backward, *granted = (np.array(column) for column in zip(*told))
        both = np.stack(granted, axis=-1).astype(bool)
        both[np.isnan(forward) & np.isnan(backward)] = True
        return Certificate(forward, backward, both)

    def check(self) -> Findings:
        """Checks the paper's theorems on the motion of the run, as `System.check` does."""
        from ._check import check_setup

        return check_setup(self.system, self._setup, self._time())

    def report(self, path: str | os.PathLike[str] | None = None) -> str:
        """The page of the run, as `dsocs run --report` writes it: one HTML file with all plots under one slider. It is written to `path`, if one is given."""
        rows = np.column_stack(list(self.table().values()))
        page: str = _dsocs.page(
            self.system._raw, list(self._setup.values), self._setup.h, self._time(), self._setup.order,
            self._setup.tolerance, self._setup.begins, np.ascontiguousarray(rows), self._notes(),
        )  # fmt: skip
        if path is not None:
            with open(path, "w", encoding="utf-8") as file:
                file.write(page)
        return page

    def _notes(self) -> list[str]:
        notes = []
        if (found := self.unresolved) is not None:
            notes.append("warning: " + self._jumps(found, found.steps))
        if (near := self.nearly_singular) is not None:
            notes.append("warning: " + self._singular(near, near.steps))
        return notes

    def __repr__(self) -> str:
        setup = self._setup
        method = f"tolerance={setup.tolerance:g}" if setup.tolerance is not None else f"order={setup.order}"
        kept = "" if setup.every == 1 else f", every {setup.every}th"
        nodes = len(self)
        times = f"t={self.t[0]:g} to {self.t[-1]:g}" if nodes else "no node"
        return f"<Run of {self.system.name}: {nodes} node{'' if nodes == 1 else 's'}{kept}, {times}, h={setup.h:g}, {method}>"

    def _repr_html_(self) -> str:
        from ._html import run

        return run(self)

    def __reduce__(self) -> Any:
        arrays = ("t", "q", "v", "a", "force", "energy", "observed", "multipliers")
        kept: dict[str, Any] = {name: self._array(name) for name in arrays}
        kept.update(index=self.index, unresolved=self._tuple(self.unresolved), nearly_singular=self._tuple(self.nearly_singular))
        system = (_dsocs.__version__, *self.system._state())
        return _run_of, (system, self._setup, self._told_history(), kept, self._told)

    @staticmethod
    def _tuple(found: Any) -> Any:
        return None if found is None else tuple(found)

    def __copy__(self) -> Run:
        function, (_, setup, history, kept, told) = self.__reduce__()
        return _made_again(self.system, setup, history, kept, told)

    def __deepcopy__(self, memo: Any) -> Run:
        return self.__copy__()


def _run_of(system: tuple[Any, ...], setup: Setup, history: Any, kept: Any, told: Any) -> Run:
    """A run that was pickled."""
    return _made_again(_system_of(*system), setup, history, kept, told)


def _made_again(system: System, setup: Setup, history: Any, kept: Any, told: Any) -> Run:
    run = Run.__new__(Run)
    run.system, run._setup = system, replace(setup)
    run._raw_run, run._kept = None, dict(kept)
    run._history, run._told = list(history), list(told)
    for value in run._kept.values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return run


def _repeat(raw: Any, what: str, *how: Any) -> None:
    """Does with an engine's run what was done with another one."""
    if what == "set":
        raw.set_input(*how)
    elif what == "advance":
        raw.advance(*how)
    elif what == "toward":
        _dsocs.advance_to(raw, *how)
    elif what == "watch":
        _dsocs.watch(raw, *how)
    else:
        steps, end, inputs = how
        last = raw.index() + steps
        while raw.index() < last:
            for name, value in inputs.get(raw.index(), {}).items():
                raw.set_input(name, value)
            raw.advance(1, end)
        for name, value in inputs.get(last, {}).items():
            raw.set_input(name, value)


#: The unit of the generalized force along a coordinate, whose work is in J.
_FORCES = {"rad": "N m", "m": "N", "1": "J"}
