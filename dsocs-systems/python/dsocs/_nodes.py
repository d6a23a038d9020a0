"""The nodes of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterator, overload

import numpy as np
import numpy.typing as npt

from . import _arrays, _given, _inputs
from ._dsocs import Node
from ._errors import InputTypeError
from ._setup import Setup
from ._table import frame
from ._results import NearlySingular, Unresolved

if TYPE_CHECKING:
    from ._system import System

Array = npt.NDArray[np.float64]


class Nodes(_inputs.Fixed):
    """The nodes that a run has so far, as arrays: the base of `Run`."""

    def __init__(self, system: System, setup: Setup) -> None:
        #: The system.
        self.system = system
        self._setup = setup
        self._raw_run: Any = setup.begin(system)
        self._kept: dict[str, Any] | None = None
        self._seal()

    @property
    def _raw(self) -> Any:
        """The engine's run."""
        return self._raw_run

    def _array(self, name: str) -> Array:
        if self._kept is not None:
            kept: Array = self._kept[name]
            return kept
        array: Array = self._raw.array(name)
        return array

    # the setup of the run

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
        """The distance of two kept nodes, in nodes."""
        return self._setup.every

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters with the values that the run began with."""
        return _given.Values((of.name, value) for of, value in zip(self.system._parameters, self._setup.values))

    # the nodes of the run

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
        """The observed expressions: an array of the shape (nodes, expressions). They are computed when they are first asked for, at a node where an input changes with the value
        with which the motion arrives there."""
        return self._array("observed")

    @property
    def multipliers(self) -> Array:
        """The multipliers of the constraint forces: an array of the shape (nodes, multipliers). They are computed when they are first asked for."""
        return self._array("multipliers")

    @property
    def node(self) -> Node:
        """The node where the run stands, which need not be kept."""
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
        """The names of all columns, in the order of the command line's table, followed by those of the parameters that changed during the run."""
        names = self.system._names
        observed = [of.name for of in self.system.observables]
        multipliers = [f"lambda_{form}" for form in range(self.system.forms)]
        moving = self.system._moving
        return ["t", *names, *(f"v_{x}" for x in moving), *(f"force_{x}" for x in moving), "energy", *observed, *multipliers, *self._changed]

    @property
    def _changed(self) -> list[str]:
        """The parameters that changed during the run, in the order of the declaration."""
        if self._kept is not None:
            return list(self._kept["changed"])
        places = {place for _, _, place, _ in self._raw.changes()}
        return [self.system._parameters[place].name for place in sorted(places)]

    @property
    def units(self) -> dict[str, str | None]:
        """The unit of each column, if the declaration gives it."""
        # energies are in J where lengths and angles have units
        turning = {first + place for first in self.system._rotations for place in range(4)}
        own = [unit for _, _, unit in self.system.coordinates]
        has_units = any(own) and all(unit is not None for place, unit in enumerate(own) if place not in turning)
        units: dict[str, str | None] = {"t": "s", "energy": "J" if has_units else None}
        for name, _, unit in self.system.coordinates:
            units[name] = unit
            units[f"v_{name}"] = None if unit is None else f"{unit}/s"
            units[f"force_{name}"] = None if unit is None else _FORCES.get(unit, f"J/{unit}")
        units.update((of.name, of.unit) for of in (*self.system.observables, *self.system._parameters))
        return {name: units.get(name) for name in self.columns}

    @property
    def unresolved(self) -> Unresolved | None:
        """The steps so far that did not resolve a jump; None if there is none."""
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
        """The table as a `pandas.DataFrame`; needs pandas."""
        return frame(self.table())

    def __len__(self) -> int:
        """The number of kept nodes."""
        return len(self._kept["t"]) if self._kept is not None else len(self._raw)

    @overload
    def __getitem__(self, key: str) -> Array: ...
    @overload
    def __getitem__(self, key: int) -> Node: ...

    def __getitem__(self, key: str | int) -> Array | Node:
        if isinstance(key, str):
            return self._column(key)
        if isinstance(key, slice):
            rows = ":".join("" if part is None else str(part) for part in (key.start, key.stop, key.step)[: 2 + (key.step is not None)])
            column = f"run[{self.system._names[0]!r}]"
            raise InputTypeError(f"run[{rows}]: a run has columns and nodes; its rows are those of an array, run.q[{rows}] or {column}[{rows}]")
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
        if name in self.parameters:
            return self._input(name)
        wide = _arrays.column(name, self.system, self._part, ("q", "v", "a", "force"))
        if wide is not None:
            return wide
        names = list(self.parameters)
        places, shape = _arrays.among(name, names)
        if places:
            inputs = np.stack([self._input(names[place]) for place in places], axis=-1)
            inputs.setflags(write=False)
            return _arrays.shaped(inputs, list(range(len(places))), shape)
        accelerations = [f"a_{x}" for x in self.system._moving]
        others = [of for of in self.parameters if of not in self._changed]
        raise KeyError(str(_inputs.unknown("column", name, [*self.columns, *accelerations, *others])))

    def _part(self, name: str) -> Array:
        return self.observed if name == "observed" else self._array(name)

    def _input(self, name: str) -> Array:
        """The values of a parameter: at each node the last one that was set there or before."""
        values = np.full(len(self), self.parameters[name])
        numbers = np.arange(len(self)) * self.every
        for index, _, place, value in self._raw.changes():
            if self.system._parameters[place].name == name:
                values[numbers >= index] = value
        values.setflags(write=False)
        return values

    def __iter__(self) -> Iterator[Node]:
        """The kept nodes, one by one."""
        return (self[place] for place in range(len(self)))


#: The unit of the generalized force along a coordinate, by the unit of the coordinate; its work is in J.
_FORCES = {"rad": "N m", "m": "N", "1": "J"}
