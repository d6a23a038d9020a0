"""Arrays, matrices and rotations by their own names: the indices of their elements among the named numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from ._system import System


def elements(name: str, places: Mapping[str, int]) -> tuple[list[int], tuple[int, ...]]:
    """The indices of the elements of an array or a matrix, row by row, and its shape; empty where no array has the name."""
    row = _in_order(name, places)
    if row:
        return row, (len(row),)
    rows: list[list[int]] = []
    while row := _in_order(f"{name}_{len(rows)}", places):
        rows.append(row)
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        return [], ()
    return [place for row in rows for place in row], (len(rows), len(rows[0]))


def _in_order(name: str, places: Mapping[str, int]) -> list[int]:
    found: list[int] = []
    while (element := f"{name}_{len(found)}") in places:
        found.append(places[element])
    return found


def among(
    name: str, names: Sequence[str], rotations: Sequence[int] = (), *, moving: bool = False
) -> tuple[list[int], tuple[int, ...]]:
    """As `elements`, also for a rotation: four numbers, or three where it is `moving`, for a velocity, an acceleration or a force."""
    for first in rotations:
        if names[first] == f"{name}_w":
            return list(range(first + moving, first + 4)), (4 - moving,)
    return elements(name, {known: place for place, known in enumerate(names)})


def column(name: str, system: System, part: Callable[[str], npt.NDArray[Any]], parts: Sequence[str]) -> npt.NDArray[Any] | None:
    """The columns of a table for an array, a matrix or a rotation by its own name. `part` returns `q`, `v`, … or `observed`, with a row for each node. None for other names."""
    found: tuple[list[int], tuple[int, ...]]
    for of in parts:
        prefix = "" if of == "q" else f"{of}_"
        if isinstance(name, str) and name.startswith(prefix):
            found = among(name[len(prefix) :], system._names, system._rotations, moving=of != "q")
            if found[0]:
                return shaped(part(of), *found)
    found = among(name, [of.name for of in system.observables])
    return shaped(part("observed"), *found) if found[0] else None


def shaped(numbers: npt.NDArray[Any], places: list[int], shape: tuple[int, ...]) -> npt.NDArray[Any]:
    """Columns of an array, each row in the given shape. Adjacent columns are not copied."""
    side_by_side = places == list(range(places[0], places[0] + len(places)))
    columns = numbers[..., places[0] : places[-1] + 1] if side_by_side else numbers[..., places]
    wide = columns.reshape(*columns.shape[:-1], *shape) if len(shape) > 1 else columns
    if not numbers.flags.writeable:
        wide.setflags(write=False)
    return wide
