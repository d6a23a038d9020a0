"""Checks of inputs: shape, type and finiteness. Messages contain the name of the argument."""

from __future__ import annotations

import difflib
import math
import numbers
from typing import TYPE_CHECKING, Any, Iterable, Mapping, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _arrays
from ._errors import InputTypeError, SetupError

#: A vector: a number for each coordinate in the order of the declaration, or by name; or a number, if there
#: is one coordinate.
VectorLike = Union[float, Sequence[float], npt.NDArray[Any], Mapping[str, float]]


class Fixed:
    """An object whose attributes users cannot set, since nothing would ask for them: its class calls `_seal` when all are there."""

    _sealed = False

    def _seal(self) -> None:
        self._sealed = True

    def _advice(self, name: str) -> str:
        """What to do instead of setting an attribute."""
        return "its attributes are what was computed"

    # type checkers refuse attributes that no class has by themselves
    if not TYPE_CHECKING:

        def __setattr__(self, name: str, value: object) -> None:
            self._refuse(name)
            object.__setattr__(self, name, value)

        def __delattr__(self, name: str) -> None:
            self._refuse(name)
            object.__delattr__(self, name)

        def _refuse(self, name: str) -> None:
            if self._sealed and not name.startswith("_"):
                raise AttributeError(f"`{name}` cannot be set: nothing would use it on a `{type(self).__name__}`; {self._advice(name)}")


def unknown(kind: str, name: object, known: Iterable[str]) -> SetupError:
    """The error for an unknown name."""
    names = list(known)
    near = difflib.get_close_matches(str(name), names, n=1)
    hint = f" (did you mean `{near[0]}`?)" if near else ""
    listed = "known: " + ", ".join(names) if names else "none is declared"
    return SetupError(f"there is no {kind} `{name}`{hint}; {listed}")


def number(name: str, given: object) -> float:
    """A finite number, checked."""
    if isinstance(given, np.ndarray) and given.ndim == 0:
        given = given.item()
    if isinstance(given, (bool, np.bool_)) or not isinstance(given, (numbers.Real, np.number)):
        raise InputTypeError(f"{name} is {_shown(given)}; expected a number")
    if isinstance(given, np.complexfloating):
        raise InputTypeError(f"{name} is {_shown(given)}; expected a real number")
    try:
        value = float(given)
    except OverflowError:
        raise SetupError(f"{name} is {_shown(given)}; it must be finite") from None
    if not math.isfinite(value):
        raise SetupError(f"{name} is {value}; it must be finite")
    return value


def truth(name: str, given: object, *, or_none: bool = False) -> bool | None:
    """True or False, checked; or None, where that has a meaning of its own."""
    if given is None and or_none:
        return None
    if not isinstance(given, (bool, np.bool_)):
        raise InputTypeError(f"{name} is {_shown(given)}; expected True{', False or None' if or_none else ' or False'}")
    return bool(given)


def whole(name: str, given: object, least: int) -> int:
    """A whole number that is at least `least`, checked."""
    if isinstance(given, (bool, np.bool_)) or not isinstance(given, (int, np.integer)):
        raise InputTypeError(f"{name} is {_shown(given)}; expected a whole number")
    if given < least:
        raise SetupError(f"{name} is {given}; it must be at least {least}")
    if given >= 2**63:
        raise SetupError(f"{name} is {given}; it must be below 2**63")
    return int(given)


def array(name: str, given: object) -> npt.NDArray[np.float64]:
    """An array of finite numbers, checked."""
    if isinstance(given, (str, bytes)) or given is None:
        raise InputTypeError(f"{name} is {_shown(given)}; expected numbers")
    try:
        values = np.asarray(given)
    except (TypeError, ValueError):
        raise InputTypeError(f"{name} is {_shown(given)}; expected an array of numbers, whose rows are of one length") from None
    if values.dtype.kind not in "iuf":
        if values.size == 0:
            raise SetupError(f"{name} is empty; expected numbers")
        raise InputTypeError(f"{name} is {_shown(given)}, of the type {values.dtype}; expected real numbers")
    result: npt.NDArray[np.float64] = np.ascontiguousarray(values, dtype=np.float64)
    if not np.isfinite(result).all():
        places = np.argwhere(~np.isfinite(result))[0]
        place = "".join(f"[{i}]" for i in places)
        raise SetupError(f"{name}{place} is {result[tuple(places)]}; it must be finite")
    return result


def vector(
    name: str,
    given: object,
    coordinates: Sequence[str],
    own: Sequence[float] | None = None,
) -> list[float]:
    """A number for each coordinate. Coordinates that a mapping does not name have the values of `own`."""
    if isinstance(given, Mapping):
        for key in given:
            if key not in coordinates:
                raise unknown("coordinate", key, coordinates)
        values = []
        for place, coordinate in enumerate(coordinates):
            if coordinate in given:
                values.append(number(f"{name}[{coordinate!r}]", given[coordinate]))
            elif own is not None:
                values.append(own[place])
            else:
                raise SetupError(
                    f"{name} has no value for the coordinate `{coordinate}`, and the system has none of its own for it"
                )
        return values
    if isinstance(given, (numbers.Real, np.number)):
        given = [number(name, given)]
    values_ = array(name, given)
    if values_.ndim != 1:
        raise SetupError(f"{name} has {values_.ndim} dimensions; expected a number for each coordinate: {', '.join(coordinates)}")
    if len(values_) != len(coordinates):
        raise SetupError(miscounted(name, len(values_), coordinates))
    result: list[float] = values_.tolist()
    return result


def miscounted(name: str, count: int, coordinates: Sequence[str]) -> str:
    """The message for a vector with too few or too many components."""
    one = len(coordinates) == 1
    return (
        f"{name} has {count} component{'' if count == 1 else 's'}, but there {'is' if one else 'are'} {len(coordinates)} "
        f"coordinate{'' if one else 's'}: {', '.join(coordinates)}"
    )


def by_element(name: str, given: Any, coordinates: Sequence[str], rotations: Sequence[int]) -> Any:
    """A vector with a number for each coordinate, from one by own names: `x` for `x_0`, `x_1`, …, and `r` for `r_w`, `r_x`, `r_y`, `r_z`. For a velocity (or
    acceleration) a rotation may have three numbers, as in `v`. `rotations` are the indices of their first numbers."""
    has_rates = not name.startswith("q")
    if isinstance(given, Mapping):
        parts: dict[Any, Any] = {}
        for key, value in given.items():
            places, shape = ([], ()) if key in coordinates or not isinstance(key, str) else _arrays.among(key, coordinates, rotations)
            if not places:
                parts[key] = value
                continue
            turns = places[0] in rotations
            numbers = array(f"{name}[{key!r}]", value)
            counts = (3, 4) if turns and has_rates else (len(places),)
            own = [coordinates[place] for place in places]
            if numbers.ndim == 0 or numbers.shape[-1] not in counts or len(shape) > 1:
                expected = " or ".join(str(count) for count in counts)
                raise SetupError(f"{name}[{key!r}] has the shape {np.shape(value)}; expected {expected} numbers: {', '.join(own)}")
            columns = [numbers[..., place] for place in range(numbers.shape[-1])]
            parts.update(zip(own[-len(columns) :], columns))
        for first in rotations if has_rates else ():
            own = list(coordinates[first : first + 4])
            if any(of in parts for of in own):
                parts.setdefault(own[0], 0.0)
        return parts
    if not rotations:
        return given
    try:
        count = np.shape(given)[-1] if np.ndim(given) else 0
    except ValueError:
        return given
    if has_rates and count == len(coordinates) - len(rotations):
        numbers = array(name, given)
        for first in sorted(rotations):
            numbers = np.insert(numbers, first, 0.0, axis=-1)
        return numbers
    return given


def _shown(given: object) -> str:
    """A value as messages show it: its representation, at most 60 characters long."""
    shown = repr(given)
    return shown if len(shown) <= 60 else f"{shown[:57]}..."
