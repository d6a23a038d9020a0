"""Values that are given to a system besides its text: the bytes of a file, tables of samples, values of parameters."""

from __future__ import annotations

import difflib
from typing import Any, Iterator, Mapping

import numpy as np

from . import _arrays, _dsocs, _inputs
from ._errors import DeclarationError, InputTypeError, SetupError


class Values(dict[str, float]):
    """The values of parameters by name, read-only."""

    __slots__ = ()

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise InputTypeError(
            "these values cannot be changed: a run takes others, `system.flow(length=1.2)`, and changes them on the way by `run.set(torque=0.5)`; `dict(…)` of them is a copy that can"
        )

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> Any:
        return type(self), (dict(self),)

    def __copy__(self) -> Values:
        return self

    def __deepcopy__(self, memo: Any) -> Values:
        return self


def decoded(name: str, data: bytes) -> str:
    """The text in the bytes of a file."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise DeclarationError(f"{name} is saved as UTF-16; save the file as UTF-8")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise DeclarationError(
            f"{name} is no text in UTF-8: line {line} has a character in another encoding; save the file as UTF-8"
        ) from None


def named_files(text: str) -> Iterator[tuple[str, str]]:
    """The parameters that are tables of samples, with their files, as far as a regular expression finds them in the text."""
    import re

    for found in re.finditer(r"(\w+)\s*=\s*samples\s*\(\s*\"([^\"\\]*)\"", text):
        yield found.group(1), found.group(2)


def table(path: str) -> list[tuple[float, float]]:
    """The samples in a file, read as by the command line."""
    pairs: list[tuple[float, float]] = _dsocs.samples(path)
    return pairs


def samples(given: Mapping[str, Any]) -> dict[str, list[tuple[float, float]]]:
    """Tables of samples, from pairs of arrays."""
    if not isinstance(given, Mapping):
        raise InputTypeError(f"samples is {type(given).__name__}; expected a dict of tables by name")
    tables = {}
    for name, table in given.items():
        what = f"samples[{name!r}]"
        try:
            places, values = table
        except (TypeError, ValueError):
            raise InputTypeError(f"{what} is no pair; expected two arrays, places and values") from None
        arrays = _inputs.array(f"{what}[0]", places), _inputs.array(f"{what}[1]", values)
        # numbers without a dimension are no rows, although the arrays of them have one
        shapes = np.shape(places), np.shape(values)
        if len(shapes[0]) != 1 or shapes[0] != shapes[1]:
            raise SetupError(f"{what} has places of the shape {shapes[0]} and values of the shape {shapes[1]}; expected two rows of one length")
        tables[str(name)] = list(zip(*(column.tolist() for column in arrays)))
    return tables


def assigned(name: str, value: Any, places: Mapping[str, int]) -> list[tuple[int, float]] | None:
    """The values of a parameter: pairs of an index and a number; None where there is no such parameter."""
    if name in places:
        return [(places[name], _inputs.number(name, value))]
    found, shape = _arrays.elements(name, places)
    if not found:
        return None
    numbers = _inputs.array(name, value)
    if np.shape(value) != shape:
        kind = f"an array of {shape[0]} numbers" if len(shape) == 1 else f"a matrix of {shape[0]} × {shape[1]} numbers"
        raise SetupError(f"{name} has the shape {np.shape(value)}, but it is {kind}")
    return list(zip(found, numbers.ravel().tolist()))


#: The names of a run's arguments in other packages.
_ALIASES = {
    "dt": "h", "step": "h", "step_size": "h", "stepsize": "h", "timestep": "h", "q0": "q", "x0": "q", "y0": "q", "v0": "v", "qdot": "v", "dq": "v", "rtol": "tolerance", "atol": "tolerance",
    "tol": "tolerance", "t0": "t", "t_end": "until", "t_final": "until", "tf": "until", "t1": "until", "a0": "a", "method": "order",
}  # fmt: skip


def misspelt(call: str, name: str, arguments: list[str], known: list[str]) -> SetupError:
    """The error for a keyword that is neither an argument of a call nor a parameter."""
    own = [*arguments, "parameters"]
    near = difflib.get_close_matches(name, [*own, *known], n=1)
    meant = _ALIASES.get(name)
    hint = ""
    if meant in own:
        hint = f" (did you mean the argument `{meant}`?)"
    elif near and near[0] in known:
        hint = f" (did you mean `{near[0]}`?)"
    elif near:
        hint = f" (did you mean the argument `{near[0]}`?)"
    elif "until" in (name, meant) and call in ("flow", "ensemble"):
        hint = f" (the end is said to {call}(…).until(t))"
    elif call == "path" and (name in ("order", "tolerance", "every") or meant in ("order", "tolerance")):
        hint = " (a path is made of the paper's step, of order 2, and keeps all of its nodes)"
    listed = ", ".join(known) if known else "none"
    return SetupError(
        f"there is no parameter `{name}`{hint}, and {call} has no such argument; parameters: {listed}; arguments of {call}: {', '.join(own)}"
    )


def joined(parameters: Mapping[str, Any] | None, values: dict[str, Any]) -> dict[str, Any]:
    """Parameters from a dict and by keywords."""
    if parameters is None:
        return values
    if not isinstance(parameters, Mapping):
        raise InputTypeError(f"parameters is {type(parameters).__name__}; expected a dict of values by name")
    for name in parameters:
        if name in values:
            raise SetupError(f"the parameter `{name}` is given twice")
    return {**parameters, **values}


def may_be_parameter(value: Any, dimensions: int) -> bool:
    """Whether a value may be meant for a parameter: a number, or an array of at most this many dimensions."""
    if value is None or isinstance(value, (bool, np.bool_, str, bytes, Mapping)):
        return False
    try:
        return np.ndim(value) <= dimensions
    except ValueError:
        # rows of different lengths are refused where they are used
        return False
