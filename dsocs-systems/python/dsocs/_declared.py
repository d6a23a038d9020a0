"""The declaration of a system, with its names, values and runs."""

from __future__ import annotations

import os
import sys
import warnings
from typing import Any, Mapping, NamedTuple, TypeVar

from . import _arrays, _dsocs, _given, _inputs
from ._errors import DeclarationWarning, InputTypeError, SetupError

#: A class of systems.
Kind = TypeVar("Kind", bound="Declared")


class Quantity(NamedTuple):
    """A coordinate, a parameter or an observed expression of a declaration."""

    #: The name in the declaration; `masses_2` for an element of an array.
    name: str
    #: Its meaning, from the declaration's comment.
    meaning: str
    #: Its unit, if the declaration gives it.
    unit: str | None


class RunText(NamedTuple):
    """A run of a text, `run far { … }`."""

    name: str | None
    start: tuple[list[float], list[float]] | None
    acceleration: list[float] | None
    near: list[float] | None
    project: bool
    step: float | None
    until: float | None

class Declared(_inputs.Fixed):
    """A system with its declaration: the base of `System`."""

    def __init__(
        self,
        text: str,
        *,
        name: str = "system",
        constants: Mapping[str, float] | None = None,
        samples: Mapping[str, Any] | None = None,
    ) -> None:
        if not isinstance(text, str):
            hint = "; a file is read by dsocs.read(path)" if isinstance(text, os.PathLike) else ""
            raise InputTypeError(f"text is {type(text).__name__}; expected the text of a system{hint}")
        if not isinstance(name, str):
            raise InputTypeError(f"name is {type(name).__name__}; expected a text")
        if text.strip().endswith(".dsocs") and "\n" not in text.strip():
            raise SetupError(f"`{text.strip()}` is the name of a file: dsocs.read({text.strip()!r}) reads it")
        given = _given.samples(samples or {})
        numbers = [(str(key), _inputs.number(f"constants[{key!r}]", value)) for key, value in dict(constants or {}).items()]
        self._set(text, name, numbers, given, None, name, None)
        self._check_samples(given)
        self._warn(3)

    @classmethod
    def of(
        cls: type[Kind],
        *,
        coordinates: Any,
        lagrangian: Any,
        holonomic: Any = None,
        nonholonomic: Any = None,
        kinematic: Any = None,
        variational: Any = None,
        constraint_forces: Any = None,
        external_forces: Any = None,
        branch: Any = None,
        observe: Mapping[str, Any] | None = None,
        parameters: Mapping[str, float] | None = None,
        doc: str = "",
        name: str = "system",
    ) -> Kind:
        """A system from expressions, of this package or of sympy.

        ```python
        x, y = dsocs.coordinates("x", "y")
        length = dsocs.parameter("length", 1.0, "The length of the rod [m]")
        pendulum = dsocs.System.of(
            coordinates=(x, y),
            lagrangian=(dsocs.dot(x)**2 + dsocs.dot(y)**2) / 2 - 9.81 * y,
            holonomic=x**2 + y**2 - length**2,
        )
        ```

        `coordinates`: all coordinates, in their order; of sympy, functions of the time (`dynamicsymbols`).
        `holonomic`, `nonholonomic`, `kinematic`: a row or a list of rows, which are zero: constraints on positions, velocities, accelerations.
        `variational`: vectors that span the virtual displacements, each with a component for each coordinate, or `"chetaev"`.
        `constraint_forces`: instead, one-forms that span the constraint forces.
        `external_forces`: a component for each coordinate, or a dict by name or by coordinate.
        `branch`: a factor that is divided out of a kinematic constraint.
        `observe`: expressions that are reported at every node, by name.
        `parameters`: the values of sympy's symbols, and of this package's parameters other ones than they were made with. The parameters of the system are
        those of this dict in its order, then those that it does not name, as they first appear in the expressions.

        Of sympy, a matrix is taken as the list of its elements, or of its rows where vectors are asked for, and an `Eq` as the difference of its sides.

        The text of the system (`System.text`) says the same in the language of the text files. Raises `DeclarationError` with the statement that is
        wrong.
        """
        from ._expressions import written

        text = written(
            coordinates, lagrangian=lagrangian, holonomic=holonomic, nonholonomic=nonholonomic, kinematic=kinematic, variational=variational,
            constraint_forces=constraint_forces, external_forces=external_forces, branch=branch, observe=observe, parameters=parameters, doc=doc,
        )  # fmt: skip
        return cls(text, name=name)

    def _set(
        self,
        text: str,
        name: str,
        constants: list[tuple[str, float]],
        samples: dict[str, list[tuple[float, float]]],
        run: str | None,
        shown_as: str,
        path: str | None,
    ) -> None:
        files = dict(samples)
        # a table may be given by its parameter's name instead of its file's
        for parameter, file in _given.named_files(text):
            if parameter in files and file not in files:
                files[file] = files.pop(parameter)
        self._samples = files
        self._constants = constants
        self._path = path
        self._raw = _read(name, shown_as, text, constants, list(files.items()))
        self._shown_as = shown_as
        description = self._raw.description()
        self._name = name
        #: The documentation in the text.
        self.doc: str = description["doc"]
        #: The kind of its constraints: `unconstrained`, `holonomic`, `nonholonomic`, `second-order`,
        #: `third-order`, `mixed`.
        self.kind: str = description["kind"]
        #: The coordinates, in the order of all arrays.
        self.coordinates = tuple(Quantity(*of) for of in description["coordinates"])
        #: The observed expressions.
        self.observables = tuple(Quantity(*of) for of in description["observables"])
        #: The highest order of a derivative in a constraint, and at least 2.
        self.order: int = description["order"]
        #: The number of multipliers of constraint forces.
        self.forms: int = description["forms"]
        #: The numbers of constraints on positions, on velocities, and on accelerations (or third
        #: derivatives).
        self.constraints: tuple[int, int, int] = tuple(description["constraints"])
        self._declaration: str = description["declaration"]
        self._may_divide: bool = description["may_divide"]
        self._parameters = tuple(Quantity(*of) for of in description["parameters"])
        self._tables = {parameter: file for parameter, file, _ in description["samples"]}
        self._values: list[float] = self._raw.values()
        self._names = [of.name for of in self.coordinates]
        # the index of the first number of each rotation's quaternion
        self._rotations: list[int] = description["rotations"]
        # the coordinates with a velocity and a force: the first of the four numbers of a rotation has none
        self._moving = [name for place, name in enumerate(self._names) if place not in self._rotations]
        runs = [RunText(**run) for run in self._raw.runs()]
        #: The runs of the text, by name; a run without a name has the key None.
        self.runs: dict[str | None, RunText] = {of.name: of for of in runs}
        if run is not None and run not in self.runs:
            raise _inputs.unknown("run", run, [str(known) for known in self.runs if known is not None])
        self._run = run
        self._seal()

    def _advice(self, name: str) -> str:
        places = {of.name: place for place, of in enumerate(self._parameters)}
        if name in places or _arrays.elements(name, places)[0]:
            return f"a system never changes: a run takes other values, `system.flow({name}=…)`"
        return "a system never changes"

    def _check_samples(self, given: Mapping[str, Any]) -> None:
        """Refuses tables that the text does not ask for."""
        known = dict.fromkeys((*self._tables, *self._tables.values()))
        for name in given:
            if name not in known:
                raise _inputs.unknown("table of samples", name, known)

    def _warn(self, stacklevel: int) -> None:
        asks = sys._getframe(stacklevel - 1)
        if (asks.f_globals.get("__name__"), asks.f_code.co_name) == ("__mp_main__", "<module>"):
            # a process that was spawned runs its parent's script once more, which has warned there
            return
        for warning in self._raw.warnings(self._shown_as):
            warnings.warn(warning.removeprefix("warning: "), DeclarationWarning, stacklevel=stacklevel)

    @property
    def text(self) -> str:
        """The text, word for word."""
        text: str = self._raw.text
        return text

    @property
    def name(self) -> str:
        """The name of the system."""
        return self._name

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters with their values, which are read-only (`flow(length=1.2)` takes others); an array has an entry for each element, `masses_0`."""
        return _given.Values((of.name, value) for of, value in zip(self._parameters, self._values))

    def quantity(self, name: str) -> Quantity:
        """Name, meaning and unit of a coordinate, a parameter or an observed expression."""
        for of in (*self.coordinates, *self._parameters, *self.observables):
            if of.name == name:
                return of
        raise _inputs.unknown("coordinate, parameter or observed expression", name, self._all_names())

    def _all_names(self) -> list[str]:
        return [of.name for of in (*self.coordinates, *self._parameters, *self.observables)]

    def _run_text(self, run: str | None) -> RunText | None:
        """The run of this name; without a name, the run without one, or else the first."""
        name = run if run is not None else self._run
        if name is not None:
            if name not in self.runs:
                raise _inputs.unknown("run", name, [str(known) for known in self.runs if known is not None])
            return self.runs[name]
        if None in self.runs:
            return self.runs[None]
        return next(iter(self.runs.values()), None)

    def _with(self, given: Mapping[str, Any]) -> list[float]:
        """The values of the parameters, with the given ones replaced; an array or a matrix by its own name or by that of an element."""
        values = list(self._values)
        places = {of.name: place for place, of in enumerate(self._parameters)}
        for name, value in given.items():
            assigned = _given.assigned(name, value, places)
            if assigned is None:
                if name in self._tables:
                    raise SetupError(
                        f"`{name}` is a table of samples; give another one when the system is read, samples={{{name!r}: …}}"
                    )
                raise _inputs.unknown("parameter", name, places)
            for place, number in assigned:
                values[place] = number
        return values

    def _values_of(
        self, call: str, asked: Mapping[str, Any], parameters: Mapping[str, Any] | None, values: dict[str, Any]
    ) -> dict[str, Any]:
        """The parameters of a call, from a dict and from keywords. A keyword that is neither an argument nor a parameter is refused, and one that may be either."""
        given = _given.joined(parameters, values)
        places = {of.name: place for place, of in enumerate(self._parameters)}
        for name in values:
            if name not in places and name not in self._tables and not _arrays.elements(name, places)[0]:
                raise _given.misspelt(call, name, list(asked), list(places))
        for name, value in asked.items():
            elements, shape = _arrays.elements(name, places)
            dimensions = max(len(shape), 1 if call == "ensemble" else 0)
            if (elements or name in places) and name not in given and _given.may_be_parameter(value, dimensions):
                raise SetupError(
                    f"`{name}` is an argument of {call} and also a parameter of {self.name}: say parameters={{{name!r}: …}} for the parameter; beside it, "
                    f"{name}=… is the argument"
                )
        return given

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Declared):
            return NotImplemented
        return self._state() == other._state()

    def __hash__(self) -> int:
        return hash((self.text, self.name))

    def _state(self) -> tuple[Any, ...]:
        return (self.text, self.name, self._constants, self._samples, self._run, self._shown_as, self._path)


for _method in (Declared.__init__, Declared.of.__func__):  # type: ignore[attr-defined]
    # Python's own messages on arguments name the class that users know
    _method.__qualname__ = _method.__qualname__.replace("Declared", "System")


def _read(name: str, shown_as: str, text: str, constants: Any, samples: Any) -> Any:
    """Parses a text. Messages show it under the name of its file."""
    return _dsocs.Text.parse(name, shown_as, text, constants, samples)
