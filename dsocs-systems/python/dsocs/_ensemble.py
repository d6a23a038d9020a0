"""Many runs side by side."""

from __future__ import annotations

import math
from typing import Any, Iterator, Mapping, overload

import numpy as np
import numpy.typing as npt

from . import _arrays, _dsocs, _inputs
from ._errors import Error, InputTypeError, Interrupted, SetupError
from ._progress import shown
from ._run import Progress
from ._setup import Setup
from ._table import frame
from ._system import System

Array = npt.NDArray[np.float64]


class Ends(_inputs.Fixed):
    """The ends of many runs: arrays with a row for each run. A run that failed has NaN, and its error is in `failures`."""

    def __init__(self, system: System, results: Mapping[str, Any], varied: Mapping[str, Array]) -> None:
        self._system = system
        #: The quantities that vary, each an array of the shape (runs,): parameters by name, positions and
        #: velocities at the start as `start_q_theta`, `start_v_theta`.
        self.varied: dict[str, Array] = dict(varied)
        #: The times [s]: an array of the shape (runs,).
        self.t: Array = results["t"]
        #: The positions: an array of the shape (runs, coordinates).
        self.q: Array = results["q"]
        #: The velocities: an array of the shape (runs, coordinates).
        self.v: Array = results["v"]
        #: The accelerations: an array of the shape (runs, coordinates).
        self.a: Array = results["a"]
        #: The generalized constraint forces: an array of the shape (runs, coordinates).
        self.force: Array = results["force"]
        #: The energies: an array of the shape (runs,).
        self.energy: Array = results["energy"]
        #: The observed expressions: an array of the shape (runs, expressions).
        self.observed: Array = results["observed"]
        #: The errors of the runs that failed, by their indices; runs of an interrupted ensemble that had not
        #: reached the end are among them.
        self.failures: dict[int, Error] = dict(results["failures"])
        self._interrupted = False
        self._seal()

    def _interrupt(self, is_unfinished: npt.NDArray[np.bool_]) -> None:
        """Leaves out the runs that had not reached their end when the ensemble was interrupted."""
        self._interrupted = True
        for place in np.flatnonzero(is_unfinished).tolist():
            self.failures.setdefault(place, Error(f"interrupted at t = {self.t[place]:g}"))
        for array in (self.t, self.q, self.v, self.a, self.force, self.energy, self.observed):
            array[is_unfinished] = np.nan

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, name: str) -> Array:
        """A column by its name: a coordinate, an observed expression, `v_theta`, `a_theta`, `force_theta`, `t` or `energy`; an array of coordinates or of observed expressions has one
        for each of its numbers."""
        if name in ("t", "energy"):
            column: Array = getattr(self, name)
            return column
        names = self._system._names
        for prefix, array in (("", self.q), ("v_", self.v), ("a_", self.a), ("force_", self.force)):
            if isinstance(name, str) and name.startswith(prefix) and name[len(prefix) :] in names:
                return array[:, names.index(name[len(prefix) :])]
        for place, of in enumerate(self._system.observables):
            if of.name == name:
                return self.observed[:, place]
        wide = _arrays.column(name, self._system, lambda part: getattr(self, part), ("q", "v", "a", "force"))
        if wide is not None:
            return wide
        others = [f"{prefix}{x}" for prefix in ("a_", "force_") for x in self._system._moving]
        multipliers = "; an ensemble keeps no multipliers, which system.flow(…) has" if self._system.forms else ""
        raise KeyError(f"{_inputs.unknown('column', name, [*self._columns(), *others])}{multipliers}")

    def _columns(self) -> list[str]:
        names = self._system._names
        return ["t", *names, *(f"v_{x}" for x in names), "energy", *(of.name for of in self._system.observables)]

    def table(self) -> dict[str, Any]:
        """The quantities that vary, then times, positions, velocities, energies and observed expressions of the ends by name; and, if a run failed, `error`: its message, or None."""
        ends = {name: self[name] for name in self._columns()}
        table: dict[str, Any] = {**self.varied, **ends}
        if self.failures:
            table["error"] = [str(self.failures[place]) if place in self.failures else None for place in range(len(self))]
        return table

    def frame(self) -> Any:
        """The table as a `pandas.DataFrame`; needs pandas."""
        return frame(self.table())

    def __repr__(self) -> str:
        said = ""
        if self._interrupted:
            said = f", interrupted: {len(self) - len(self.failures)} reached the end"
        elif self.failures:
            said = f", {len(self.failures)} failed"
        shapes = f"t and energy {self.t.shape}, q, v, a and force {self.q.shape}, observed {self.observed.shape}"
        return f"<Ends of {len(self)} runs of {self._system.name}{said}; {shapes}>"


class Ensemble(_inputs.Fixed):
    """Many runs that have not begun: `until` computes their ends."""

    def __init__(
        self, system: System, *, h: Any, q: Any, v: Any, t: Any, start: Any, project: Any, order: Any, tolerance: Any, run: Any,
        values: Mapping[str, Any],
    ) -> None:  # fmt: skip
        #: The system.
        self.system = system
        names = system._names
        for name, given in (("h", h), ("t", t), ("tolerance", tolerance)):
            if np.ndim(given):
                raise SetupError(
                    f"{name} has the shape {np.shape(given)}; expected one number, which all runs share: only q, v and parameters vary from run to run"
                )
        single, varied = _split(system, values)
        system._with(single)
        text = system._run_text(run)
        own_q, own_v = text.start if text is not None and text.start is not None else (None, None)
        rotations = system._rotations
        rows_q, rows_v = (
            _rows(name, _inputs.by_element(name, given, names, rotations), names, own) for name, given, own in (("q", q, own_q), ("v", v, own_v))
        )
        counts = {
            **({"q": len(rows_q)} if rows_q is not None and rows_q.ndim == 2 else {}),
            **({"v": len(rows_v)} if rows_v is not None and rows_v.ndim == 2 else {}),
            **{name: len(values) for name, values in varied.items()},
        }
        different = sorted(set(counts.values()))
        if len(different) > 1:
            said = ", ".join(f"{name} for {count}" for name, count in counts.items())
            raise SetupError(f"not all arrays are for the same number of runs: {said}")
        if not different:
            raise SetupError("nothing varies from run to run: give q or v as an array of the shape (runs, coordinates), or a parameter as an array")
        self._count = different[0]
        if self._count == 0:
            raise SetupError(f"{' and '.join(counts)} {'is' if len(counts) == 1 else 'are'} for no run at all: the first dimension, that of the runs, is 0")
        first = {"q": None if rows_q is None else np.atleast_2d(rows_q)[:1], "v": None if rows_v is None else np.atleast_2d(rows_v)[:1]}
        sample = {name: None if row is None or not len(row) else row[0] for name, row in first.items()}
        self._setup = Setup.of(
            system, h=h, q=sample["q"], v=sample["v"], t=t, start=start, project=project, order=order, tolerance=tolerance, run=run, values=single
        )
        if self._setup.rule not in ("paper", "second-order"):
            raise SetupError("a constraint here is of third order, which ensembles do not know")
        q0, v0 = self._setup.vectors
        self._q = np.broadcast_to(q0 if rows_q is None else rows_q, (self._count, len(names)))
        self._v = np.broadcast_to(v0 if rows_v is None else rows_v, (self._count, len(names)))
        self._varied = varied
        self._seal()

    def _advice(self, name: str) -> str:
        return "an ensemble is set up by `system.ensemble(…)`"

    def __len__(self) -> int:
        """The number of runs."""
        return self._count

    def until(self, t: float | None = None, *, threads: int | None = None, progress: Progress = False) -> Ends:
        """Runs all of them up to the last node at or before the time `t` [s], by default that of the text's run.

        `threads`: how many threads, by default one for each core. Results do not depend on it. `progress`: as in `Run.until`.

        A run that fails does not end the others: see `Ends.failures`. Where Ctrl-C ends it, the exception's `run` has the ends of the runs that had reached them; the others are NaN, and are
        among the failures.
        """
        end = self._setup.end(self.system, "t", t)
        count = None if threads is None else _inputs.whole("threads", threads, 1)
        setup = self._setup
        if (end - setup.t) * math.copysign(1, setup.h) < 0:
            raise SetupError(f"t = {end} lies the other way than the step h = {setup.h} goes, from t = {setup.t}")
        varied = list(self._varied.items())
        q, v = np.ascontiguousarray(self._q), np.ascontiguousarray(self._v)
        with shown(progress, self.system.name, 0.0, 1.0) as tell:
            results = _dsocs.ensemble(
                self.system._raw, list(setup.values), setup.h, setup.beginning, q, v, varied, end, setup.order, setup.tolerance, count, tell
            )
        ends = Ends(self.system, results, self._columns())
        interrupted = results["interrupted"]
        if isinstance(interrupted, KeyboardInterrupt):
            left = math.copysign(1, setup.h) * (end - ends.t)
            # the last node lies less than a step before the end
            ends._interrupt(~(left < (1 - 1e-9) * abs(setup.h)) if setup.tolerance is None else ends.t != end)
            reached = len(ends) - len(ends.failures)
            raise Interrupted(f"interrupted: {reached} of {len(ends)} runs have reached the end, and are in the exception's `run`", ends)  # type: ignore[arg-type]
        if interrupted is not None:
            raise interrupted
        return ends

    def _columns(self) -> dict[str, Array]:
        """The quantities that vary, by name."""
        columns = dict(self._varied)
        for prefix, rows in (("q_", self._q), ("v_", self._v)):
            for place, name in enumerate(self.system._names):
                column = rows[:, place]
                if len(column) and np.any(column != column[0]):
                    columns[f"start_{prefix}{name}"] = column
        return columns

    def __repr__(self) -> str:
        varied = f", {', '.join(self._varied)} vary" if self._varied else ""
        return f"<Ensemble of {self._count} runs of {self.system.name}, h={self._setup.h:g}{varied}>"


def _split(system: System, values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Array]]:
    """Parameters that all runs share, and those with a value for each run."""
    names = [of.name for of in system._parameters]
    single: dict[str, Any] = {}
    varied: dict[str, Array] = {}
    for name, value in values.items():
        if name in names and np.ndim(value) == 1:
            varied[name] = _inputs.array(name, value)
        elif name in names and np.ndim(value) > 1:
            raise SetupError(f"{name} has {np.ndim(value)} dimensions; expected a number, or one for each run")
        else:
            places, shape = _arrays.among(name, names) if name not in names else ([], ())
            if not places or np.ndim(value) != len(shape) + 1:
                single[name] = value
                continue
            # an array or a matrix for each run
            array = _inputs.array(name, value)
            if array.shape[1:] != shape:
                raise SetupError(f"{name} has the shape {array.shape}; expected {shape}, or (runs, {str(shape)[1:-1].removesuffix(',')})")
            columns = array.reshape(len(array), -1)
            varied.update((names[place], np.ascontiguousarray(columns[:, k])) for k, place in enumerate(places))
    return single, varied


def _rows(name: str, given: Any, names: list[str], own: list[float] | None) -> Array | None:
    """A vector that all runs share, or one for each run."""
    if given is None:
        return None
    if isinstance(given, Mapping):
        for key in given:
            if key not in names:
                raise _inputs.unknown("coordinate", key, names)
        columns = []
        for place, coordinate in enumerate(names):
            if coordinate in given:
                column = _inputs.array(f"{name}[{coordinate!r}]", given[coordinate])
                if column.ndim > 1:
                    raise SetupError(f"{name}[{coordinate!r}] has {column.ndim} dimensions; expected a number, or one for each run")
                # one number for all runs
                columns.append(column if np.ndim(given[coordinate]) else column.reshape(()))
            elif own is not None:
                columns.append(np.asarray(own[place]))
            else:
                raise SetupError(f"{name} has no value for the coordinate `{coordinate}`, and the system has none of its own for it")
        lengths = {len(column) for column in columns if column.ndim == 1 and len(column) != 1}
        if len(lengths) > 1:
            raise SetupError(f"{name} has columns of different lengths: {', '.join(str(length) for length in sorted(lengths))}")
        return np.stack(np.broadcast_arrays(*columns), axis=-1)
    array = _inputs.array(name, given)
    if array.ndim not in (1, 2) or array.shape[-1] != len(names):
        raise SetupError(
            f"{name} has the shape {array.shape}; expected ({len(names)},), or (runs, {len(names)}): a number for each coordinate, {', '.join(names)}"
        )
    return array
