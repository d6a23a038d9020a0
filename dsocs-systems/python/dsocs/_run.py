"""A run of a system."""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Callable, Iterator, Mapping, Union

import numpy as np
import numpy.typing as npt

from . import _arrays, _dsocs, _given, _inputs, _results
from ._dsocs import Node
from ._errors import InputTypeError, Interrupted, SetupError, StepError, StepWarning, interruptible
from ._events import Event, Occurrences, Points
from ._nodes import Nodes
from ._progress import shown
from ._setup import Setup
from ._system import System, _system_of
from ._results import Certificate, ErrorEstimate, NearlySingular, Roots, Unresolved

if TYPE_CHECKING:
    from ._check import Findings

Array = npt.NDArray[np.float64]
#: The display of progress: none, a line or a bar, or a function that is called with the fraction done.
Progress = Union[bool, Callable[[float], object]]


class Run(Nodes):
    """A run: a motion that is computed node by node, and the nodes that it has so far.

    `System.flow` begins one, which stands at its start. `until` and `advance` go on. All arrays have a row for each node that is kept; they
    are not copied, and cannot be written to. `run["theta"]` is a column by its name: a coordinate, an observed expression, `v_theta`, `a_theta`,
    `force_theta`, `lambda_0` (a multiplier), `t` or `energy`; or a parameter: at each node the value that was set last, there or before. `run[-1]` is a node.
    """

    def __init__(self, system: System, setup: Setup) -> None:
        super().__init__(system, setup)
        self._history: list[tuple[Any, ...]] = []
        self._warned = [0] * 8
        self._failure: str | None = None

    def _advice(self, name: str) -> str:
        if name in self.parameters or _arrays.elements(name, {of: place for place, of in enumerate(self.parameters)})[0]:
            return f"`run.set({name}=…)` changes it from there on, and `system.flow({name}=…)` begins a run with it"
        return "a run is set up by `system.flow(…)`"

    @property
    def _raw(self) -> Any:
        """The engine's run. That of a run that was copied or pickled is made again when it goes on: it takes the same steps, with the same bits."""
        if self._raw_run is None:
            raw = self._setup.begin(self.system)
            for what, *how in self._history:
                _repeat(raw, what, *how)
            self._raw_run, self._kept = raw, None
        return self._raw_run

    # steps

    def until(
        self,
        t: float | None = None,
        *,
        progress: Progress = False,
        control: Callable[[Node], Mapping[str, Any] | None] | None = None,
        control_every: int | None = None,
    ) -> Run:
        """Runs up to the last node at or before the time `t` [s], by default that of the text's run, which has to be there then, and returns itself. No step
        goes beyond `t`: a time that is less than a step away makes none.

        `progress`: True shows how far the run is; a function is called with the fraction that is done, from 0 to 1.
        `control`: a function between steps. It gets the node, and returns the values of inputs by name, `{"torque": -2 * node["v_theta"]}`, of an array or a
        matrix all of them, or None. They hold from the last position that is known on: with order 2 this is the next node's, so that what the node `k` asks for acts on the leg from the
        node `k + 1` on: a delay of one step (the guide's section 3 has the linear model of this delay). `control_every`: the number of nodes from
        one call of `control` to the next, 1 by default.

        Raises `StepError` if a step has no solution, with the run up to there, and `Interrupted` where Ctrl-C ends it.
        """
        end = self._setup.end(self.system, "t", t)
        if control is not None and not callable(control):
            raise InputTypeError(f"control is {type(control).__name__}; expected a function of a node")
        every = 1 if control_every is None else _inputs.whole("control_every", control_every, 1)
        if control is None and control_every is not None:
            raise SetupError("control_every is given, which says at how many nodes control is called, and control is not: control=…, a function of a node")
        raw = self._raw
        begin, before = raw.index(), raw.change_count()
        with shown(progress, self.system.name, self._time(), end) as tell:
            try:
                self._failure = None
                raw.until(end, tell, None if control is None else (control, every, self._elements()))
            except StepError as error:
                self._fails(error)
                raise
            except KeyboardInterrupt:
                raise Interrupted(
                    f"interrupted at t = {self._time():g}, after {raw.index() - begin} steps; the exception's `run` has them, and can go on", self
                ) from None
            finally:
                self._remember(raw, begin, before, end, control is not None)
        self._warn()
        return self

    def _fails(self, error: StepError) -> None:
        error.run, self._failure = self, str(error)

    def _remember(self, raw: Any, begin: int, before: int, end: float, controlled: bool) -> None:
        steps = raw.index() - begin
        if controlled:
            # the inputs themselves are looked up only when they are needed
            self._history.append(("changes", steps, end, before, raw.change_count()))
        elif steps:
            self._history.append(("advance", steps, end))

    def _full_history(self) -> list[tuple[Any, ...]]:
        """The history with the values of the inputs, so that a copy can repeat it."""
        if all(what[0] != "changes" for what in self._history):
            return list(self._history)
        names = [of.name for of in self.system._parameters]
        changes = self._raw.changes()
        history: list[tuple[Any, ...]] = []
        for what, *how in self._history:
            if what == "changes":
                steps, end, first, last = how
                inputs: dict[int, dict[str, float]] = {}
                for index, _, place, value in changes[first:last]:
                    inputs.setdefault(index, {})[names[place]] = value
                history.append(("control", steps, end, inputs))
            else:
                history.append((what, *how))
        return history

    def advance(self, steps: int = 1) -> Run:
        """Makes some steps, and returns itself. Raises as `until`."""
        count = _inputs.whole("steps", steps, 0)
        raw = self._raw
        begin = raw.index()
        try:
            raw.advance(count, None)
        except StepError as error:
            self._fails(error)
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
        end = self._setup.end(self.system, "until", None) if until is None else until
        if isinstance(end, (bool, str)) or not isinstance(end, (int, float, np.number)):
            raise InputTypeError(f"until is {end!r}; expected a time")
        raw = self._raw
        while True:
            try:
                node: Node | None = raw.next(float(end))
            except StepError as error:
                self._fails(error)
                raise
            if node is None:
                self._warn()
                return
            self._count(1, float(end))
            self._warn(of_nodes=False)
            yield node

    def set(self, **inputs: Any) -> Run:
        """Gives parameters other values, from the last position that is known on: `run.set(torque=0.5)`; those of an array or a matrix all, `run.set(torques=[0.5, 0.0])`, or one, `torques_0=0.5`.

        Raises `SetupError` if there is no such parameter, or if it cannot change: one in a holonomic constraint, or inside a `dot(…)`.
        """
        elements = self._elements()
        for name, value in inputs.items():
            for element, number in elements(name, value):
                self._raw.set_input(element, number)
                self._history.append(("set", element, number))
        return self

    def _elements(self) -> Callable[[str, Any], list[tuple[str, float]]]:
        """A function that splits the value of an input, given by its own name or by that of an element, into numbers by name."""
        names = [of.name for of in self.system._parameters]
        places = {name: place for place, name in enumerate(names)}

        def elements(name: str, value: Any) -> list[tuple[str, float]]:
            assigned = _given.assigned(name, value, places)
            if assigned is None:
                if np.ndim(value):
                    raise _inputs.unknown("parameter", name, names)
                # the run refuses names that are no inputs
                return [(name, _inputs.number(name, value))]
            return [(names[place], number) for place, number in assigned]

        return elements

    def watch(self, until: float | None = None, *events: str | Event) -> Occurrences:
        """Runs to the time `until` [s] like `until`, and finds where functions change their signs on the way, to rounding.

        ```python
        run.watch(20.0, "theta", dsocs.Event("height", level=0.5, rising=True, ends=True))
        ```

        An event is the name of a column (a coordinate, `v_theta`, `a_theta`, an observed expression), whose zeros count, or an `Event`. Between the nodes the motion is the
        series of the step with a `tolerance`, and else the polynomial of degree 5 through position, velocity and acceleration at both nodes. A zero without a change of sign is no
        event, nor is one at the start; one at the node where a watch ended is reported by the next watch, if it was not reported before.

        At the first event that ends the run it stops: with a `tolerance` at the node before it, else at the node after it. The last node that is kept
        is the one before it, and the state at the event itself is that of the last occurrence (`t`, `q`, `v`, `a`). Events between this one and the
        node after it are reported when the run is watched again. Raises as `until`.
        """
        end = self._setup.end(self.system, "until", until)
        if not events:
            raise SetupError('no event is given; expected the name of a column, "theta", or dsocs.Event("theta", level=0.5)')
        watched = [Event.of_name(event) for event in events]
        asked = [event._found(self.system) for event in watched]
        raw = self._raw
        begin = raw.index()
        found: list[tuple[Any, ...]] = []
        watched_to_end = ended = False
        try:
            found, ended = _dsocs.watch(raw, end, asked)
            watched_to_end = True
        except StepError as error:
            self._fails(error)
            raise
        except KeyboardInterrupt:
            raise Interrupted(f"interrupted at t = {self._time():g}; the exception's `run` can go on", self) from None
        finally:
            if watched_to_end:
                # a copy has to know the events at the node where it stands
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
        parts: list[list[Array]] = []
        with interruptible("no time is sampled; the run is as it was"):
            raw = self._setup.begin(self.system)
            begin = 0
            for t, changes in self._changes():
                # a change at a node applies to times beyond it
                stop = begin + int(np.searchsorted(forward[begin:], way * t, side="right"))
                parts.append(_dsocs.sample(raw, at[begin:stop]))
                begin = stop
                if begin == len(at):
                    break
                raw.until(t, None, None)
                for name, value in changes:
                    raw.set_input(name, value)
            try:
                parts.append(_dsocs.sample(raw, at[begin:]))
            except StepError as error:
                self._fails(error)
                raise
        return Points(self.system, at, *(arrays[0] if len(arrays) == 1 else np.concatenate(arrays) for arrays in zip(*parts)))

    def _changes(self) -> Iterator[tuple[float, list[tuple[str, float]]]]:
        """The times at which inputs changed, and the inputs."""
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
        names = self.system._names
        toward = _inputs.vector("q", _inputs.by_element("q", q, names, self.system._rotations), names)
        try:
            _dsocs.advance_to(self._raw, toward)
        except StepError as error:
            self._fails(error)
            raise
        self._history.append(("toward", toward))
        self._warn()
        return self

    def _time(self) -> float:
        time: float = self._raw.node().t
        return time

    def _warn(self, of_nodes: bool = True) -> None:
        """Warns of steps whose error may be larger, once in each call; and of the signs in the nodes, once in a run."""
        unresolved, nearly_singular = self.unresolved, self.nearly_singular
        if unresolved is not None and unresolved.steps > self._warned[0]:
            warnings.warn(self._jumps(unresolved, unresolved.steps - self._warned[0]), StepWarning, stacklevel=3)
            self._warned[0] = unresolved.steps
        if nearly_singular is not None and nearly_singular.steps > self._warned[1]:
            warnings.warn(self._singular(nearly_singular, nearly_singular.steps - self._warned[1]), StepWarning, stacklevel=3)
            self._warned[1] = nearly_singular.steps
        for kind, said in enumerate(self._raw.warnings() if of_nodes else (), 2):
            if said is not None and not self._warned[kind]:
                warnings.warn(said, StepWarning, stacklevel=3)
                self._warned[kind] = 1

    def _jumps(self, found: Unresolved, steps: int) -> str:
        return _results.jumps(found, steps, self.system.order)

    def _singular(self, found: NearlySingular, steps: int) -> str:
        return _results.singular(found, steps, self.system.order, self.system._may_divide)

    # estimates, certificates, checks and pages

    def estimate_error(self) -> ErrorEstimate:
        """How far the run is from the continuous motion, coordinate by coordinate, at every node that is kept.

        The continuous motion is computed by Taylor series to nearly all digits, under the same held inputs. The run is made once more for it. Inputs that came from `control` are taken as
        they were, at their times: what the controller would have asked for on the continuous motion is not known, and a warning (`StepWarning`) says so.
        Raises `StepError` if the continuous motion cannot be computed, and `SetupError` if the run began with nodes, since it begins with a velocity.
        """
        if self._setup.rule == "nodes":
            raise SetupError("the error of a run that begins with nodes cannot be estimated: the continuous motion begins with a velocity")
        if any(what[0] in ("changes", "control") for what in self._history):
            warnings.warn(
                "the inputs of this run came from `control`: the estimate holds for the motion under these inputs, each at its time, and not for the controller on the "
                "continuous motion; a run with half the step shows that",
                StepWarning,
                stacklevel=2,
            )
        with interruptible("the error is not known; the run is as it was"):
            errors, uncertainty = _dsocs.estimate(
                self.system._raw, list(self._setup.values), self._setup.h, self._time(), self._setup.order,
                self._setup.tolerance, self._setup.beginning, self._held(), self.every,
            )  # fmt: skip
        array: Array = np.asarray(errors).reshape(-1, len(self.system._names))
        largest = array.max(axis=0).tolist() if len(array) else [0.0] * len(self.system._names)
        return ErrorEstimate(array, dict(zip(self.system._names, largest)), uncertainty)

    def _held(self) -> list[tuple[str, list[tuple[float, float]]]]:
        """The inputs that changed, each with its times and values."""
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
        with interruptible("nothing is certified; the run is as it was"):
            found = _dsocs.certify(self.system._raw, list(self._setup.values), self._setup.h, self._time(), self._setup.beginning, self.every)
        forward, backward, *granted = (np.array(column) for column in zip(*found))
        both = np.stack(granted, axis=-1).astype(bool)
        both[np.isnan(forward) & np.isnan(backward)] = True
        return Certificate(forward, backward, both)

    def check(self) -> Findings:
        """Checks the paper's theorems on the motion of the run, as `System.check` does."""
        from ._check import check_setup

        return check_setup(self.system, self._setup, self._time())

    def report(self, path: str | os.PathLike[str]) -> None:
        """Writes the page of the run to a file, as `dsocs run --report` does: one HTML file with all plots under one slider."""
        if not isinstance(path, (str, bytes, os.PathLike)):
            raise InputTypeError(f"path is {path!r:.60}; expected the name of a file")
        page = self.page()
        with open(path, "w", encoding="utf-8") as file:
            file.write(page)

    def page(self) -> str:
        """The page of `report` as a string, of some megabytes."""
        rows = np.column_stack(list(self.table().values()))
        page: str = _dsocs.page(
            self.system._raw, list(self._setup.values), self._setup.h, self._time(), self._setup.order,
            self._setup.tolerance, self._setup.beginning, self._changed, np.ascontiguousarray(rows), self._notes(),
        )  # fmt: skip
        return page

    def _signs(self) -> list[str | None]:
        """The warnings about the nodes."""
        if self._kept is not None:
            return list(self._kept["warnings"])
        return list(self._raw.warnings())

    def _notes(self) -> list[str]:
        notes = []
        if self._failure is not None:
            notes.append(f"error: the run ends at t = {self.t[-1]:g}: {self._failure}")
        notes += [f"warning: {said}" for said in self._signs() if said is not None]
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
        kept.update(index=self.index, changed=self._changed, failure=self._failure, warnings=self._signs(), unresolved=self._tuple(self.unresolved), nearly_singular=self._tuple(self.nearly_singular))
        system = (_dsocs.__version__, *self.system._state())
        return _run_of, (system, self._setup, self._full_history(), kept, self._warned)

    @staticmethod
    def _tuple(found: Any) -> Any:
        return None if found is None else tuple(found)

    def __copy__(self) -> Run:
        function, (_, setup, history, kept, warned) = self.__reduce__()
        return _made_again(self.system, setup, history, kept, warned)

    def __deepcopy__(self, memo: Any) -> Run:
        return self.__copy__()


def _run_of(system: tuple[Any, ...], setup: Setup, history: Any, kept: Any, warned: Any) -> Run:
    """A run from its pickled parts."""
    return _made_again(_system_of(*system), setup, history, kept, warned)


def _made_again(system: System, setup: Setup, history: Any, kept: Any, warned: Any) -> Run:
    run = Run.__new__(Run)
    run.system, run._setup = system, replace(setup)
    run._raw_run, run._kept = None, dict(kept)
    run._history, run._warned = list(history), list(warned)
    run._failure = kept["failure"]
    run._seal()
    for value in run._kept.values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return run


def _repeat(raw: Any, what: str, *how: Any) -> None:
    """Repeats on one run of the engine what was done with another."""
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
