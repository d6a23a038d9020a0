"""Events between the nodes of a run, and the motion at any time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterator, NamedTuple, Sequence, overload

import numpy as np
import numpy.typing as npt

from . import _arrays, _inputs
from ._errors import InputTypeError, SetupError

if TYPE_CHECKING:
    from ._system import System

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Event:
    """Where a column passes a value.

    `of` is a coordinate, `v_theta`, `a_theta` or an observed expression. `level` is the value. `rising` says which passages count: True those upwards in the direction of the run, False those
    downwards, None both. `ends` says whether the run ends there: the last node that it keeps is the one before the event.
    """

    of: str
    level: float = 0.0
    rising: bool | None = None
    ends: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.of, str):
            raise InputTypeError(f"of is {self.of!r:.60}; expected the name of a column")
        _inputs.number("level", self.level)
        _inputs.truth("rising", self.rising, or_none=True)
        _inputs.truth("ends", self.ends)

    @staticmethod
    def of_name(given: object) -> Event:
        """An event from the name of a column, or the event itself."""
        if isinstance(given, Event):
            return given
        if isinstance(given, str):
            return Event(given)
        raise InputTypeError(f"an event is {given!r}; expected the name of a column, or a dsocs.Event")

    def _found(self, system: System) -> tuple[str, int, float, int, bool]:
        """The event in the form of the engine."""
        level = float(self.level)
        direction = 0 if self.rising is None else 1 if self.rising else -1
        names = system._names
        for prefix, part in (("", "q"), ("v_", "v"), ("a_", "a")):
            if self.of.startswith(prefix) and self.of[len(prefix) :] in names:
                return part, names.index(self.of[len(prefix) :]), level, direction, bool(self.ends)
        observed = [of.name for of in system.observables]
        if self.of in observed:
            return "observed", observed.index(self.of), level, direction, bool(self.ends)
        known = [*names, *(f"{prefix}{x}" for prefix in ("v_", "a_") for x in names), *observed]
        error = _inputs.unknown("column", self.of, known)
        raise SetupError(
            f"{error}; a function of position and velocity is watched as an observed expression, `let power = …; observe = [power];` in the text or "
            "observe={'power': …} of System.of; forces and multipliers are known at the nodes alone, run['lambda_0']"
        )


class Occurrence(NamedTuple):
    """An event that happened."""

    #: The event.
    event: Event
    #: Whether the column rose there, in the direction of the run.
    rising: bool
    #: The time [s].
    t: float
    #: The position: an array of the shape (coordinates,).
    q: Array
    #: The velocity: an array of the shape (coordinates,).
    v: Array
    #: The acceleration: an array of the shape (coordinates,).
    a: Array


class Occurrences(_inputs.Fixed, Sequence[Occurrence]):
    """The events of a run, in the order in which they happened. `ended` is true if the last of them ended it."""

    def __init__(self, system: System, events: Sequence[Event], found: Sequence[tuple[Any, ...]], ended: bool) -> None:
        self._all = [
            Occurrence(events[event], rising, t, np.asarray(q), np.asarray(v), np.asarray(a)) for event, rising, t, q, v, a in found
        ]
        self._system, self._events = system, tuple(events)
        #: Whether the last one ended the run.
        self.ended = ended
        self._seal()

    @property
    def t(self) -> Array:
        """The times [s]: an array of the shape (events,)."""
        return np.array([one.t for one in self._all])

    def of(self, name: str) -> Array:
        """The times [s] of the events of one column, of which there may be none. Raises `KeyError` for a column that was not watched."""
        if all(event.of != name for event in self._events):
            raise KeyError(str(_inputs.unknown("watched column", name, dict.fromkeys(event.of for event in self._events))))
        return np.array([one.t for one in self._all if one.event.of == name])

    def __len__(self) -> int:
        return len(self._all)

    @overload
    def __getitem__(self, place: int) -> Occurrence: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[Occurrence]: ...

    def __getitem__(self, place: int | slice) -> Occurrence | Sequence[Occurrence]:
        return self._all[place]

    def __iter__(self) -> Iterator[Occurrence]:
        return iter(self._all)

    def __repr__(self) -> str:
        lines = [f"t={one.t:.6g}: {one.event.of} {'rises' if one.rising else 'falls'} through {one.event.level:g}" for one in self._all[:10]]
        more = [f"… and {len(self) - 10} more"] if len(self) > 10 else []
        return "\n".join([f"<{len(self)} event{'' if len(self) == 1 else 's'} of {self._system.name}>", *lines, *more])


class Points(_inputs.Fixed):
    """The motion at some times: arrays with a row for each. `points["theta"]` is a column by its name."""

    def __init__(self, system: System, t: Array, q: Array, v: Array, a: Array, observed: Array) -> None:
        self._system = system
        #: The times [s]: an array of the shape (times,).
        self.t = t
        #: The positions: an array of the shape (times, coordinates).
        self.q = q
        #: The velocities: an array of the shape (times, coordinates).
        self.v = v
        #: The accelerations: an array of the shape (times, coordinates).
        self.a = a
        #: The observed expressions: an array of the shape (times, expressions).
        self.observed = observed
        self._seal()

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, name: str) -> Array:
        """A column by its name: a coordinate, `v_theta`, `a_theta`, an observed expression or `t`."""
        if name == "t":
            return self.t
        names = self._system._names
        for prefix, array in (("", self.q), ("v_", self.v), ("a_", self.a)):
            if isinstance(name, str) and name.startswith(prefix) and name[len(prefix) :] in names:
                return array[:, names.index(name[len(prefix) :])]
        observed = [of.name for of in self._system.observables]
        if name in observed:
            return self.observed[:, observed.index(name)]
        wide = _arrays.column(name, self._system, lambda part: getattr(self, part), ("q", "v", "a"))
        if wide is not None:
            return wide
        known = ["t", *names, *(f"{prefix}{x}" for prefix in ("v_", "a_") for x in self._system._moving), *observed]
        raise KeyError(str(_inputs.unknown("column", name, known)))

    def table(self) -> dict[str, Array]:
        """Times, positions, velocities and observed expressions by name."""
        names = self._system._names
        observed = [of.name for of in self._system.observables]
        return {name: self[name] for name in ["t", *names, *(f"v_{x}" for x in names), *observed]}

    def __repr__(self) -> str:
        return f"<{len(self)} points of {self._system.name}>"
