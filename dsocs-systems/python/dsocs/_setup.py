"""The setup of a run: step, end, start, method and values of parameters."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Mapping

import numpy as np

from . import _dsocs, _inputs
from ._errors import InputTypeError, SetupError, StepWarning

if TYPE_CHECKING:
    from ._declared import Declared

#: The step of a run, in s, if the text has a run without one; and the distance of nodes if a tolerance is
#: given without a step.
STEP = 0.01
#: The duration of a run, in s, if the text has a run without one.
UNTIL = 10.0

#: The unit round-off of double precision: no tolerance below it can be reached.
_UNIT = 2.0**-53
#: A larger tolerance lets the errors of the steps add up to some per cent.
_LOOSE = 1e-4


@dataclass(frozen=True)
class Setup:
    """The setup of a run."""

    h: float
    until: float | None
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
        system: Declared,
        *,
        h: Any = None,
        q: Any = None,
        v: Any = None,
        q1: Any = None,
        q2: Any = None,
        a: Any = None,
        force: Any = None,
        near: Any = None,
        t: Any = None,
        start: Any = None,
        project: Any = None,
        order: Any = None,
        tolerance: Any = None,
        every: Any = None,
        run: Any = None,
        values: Mapping[str, Any] | None = None,
    ) -> Setup:
        """The setup from the arguments of a call; the text's run supplies those that are missing."""
        text = system._run_text(run)
        own_q, own_v = (text.start if text is not None and text.start is not None else (None, None))
        step = _inputs.number("h", h) if h is not None else (text.step if text and text.step is not None else STEP)
        has_step = h is not None or text is not None or tolerance is not None
        if step == 0:
            raise SetupError("h is 0; expected a step that is not zero (a negative step runs back in time)")
        t0 = 0.0 if t is None else _inputs.number("t", t)
        order = _order(order, tolerance, start, q1)
        first = _vector("q", q, system, own_q)
        if first is None:
            raise _missing(system, "q")

        def velocity() -> tuple[float, ...]:
            vector = _vector("v", v, system, own_v)
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
            second = _vector("q1", q1, system, None)
            third = _vector("q2", q2, system, None)
            rule, vectors = "nodes", tuple(x for x in (first, second, third) if x is not None)
        elif q2 is not None:
            raise SetupError("q2 is given without q1; three nodes begin a run of third order")
        elif start is not None:
            if start not in ("paper", "second-order"):
                raise SetupError(f"start is {start!r}; expected 'second-order' or 'paper'")
            rule, vectors = start, (first, velocity())
        elif force is not None:
            rule, vectors = "force", (first, velocity(), _vector("force", force, system, None) or ())
        else:
            own_a = text.acceleration if text is not None else None
            acceleration = _vector("a", a, system, own_a)
            if acceleration is not None:
                rule, vectors = "acceleration", (first, velocity(), acceleration)
            else:
                rule, vectors = "second-order", (first, velocity())
        own_near = text.near if text is not None else None
        nearby = _vector("near", near, system, own_near)
        projected = text is not None and text.project if project is None else bool(_inputs.truth("project", project))
        own_values = tuple(system._with(values or {}))
        if not has_step:
            raise SetupError(
                f"h is not given, and the text of {system.name} has no run with a step: give h=…, the step in seconds, or in the text, `run {{ step = …; }}`; a step is short enough if "
                "the fastest oscillation has twenty of them or more"
            )
        until = None
        if text is not None:
            length = text.until if text.until is not None else UNTIL
            # negative with a negative step; a text whose own run goes back in time keeps its negative end
            until = t0 + (length if length < 0 else math.copysign(length, step))
        return Setup(
            h=step,
            until=until,
            values=own_values,
            rule=rule,
            vectors=vectors,
            near=nearby,
            t=t0,
            project=projected,
            order=order,
            tolerance=_tolerance(tolerance),
            every=1 if every is None else _inputs.whole("every", every, 1),
        )

    def end(self, system: Declared, name: str, given: Any) -> float:
        """The end of a run: the time that is given, or that of the text's run. `name` is the argument's name, for messages."""
        if given is not None:
            return _inputs.number(name, given)
        if self.until is None:
            raise SetupError(
                f"{name} is not given, and the text of {system.name} has no run with an end: give the time in seconds to which it goes, or in the text, `run {{ until = …; }}`"
            )
        return self.until

    @property
    def beginning(self) -> tuple[Any, ...]:
        """The start in the form of the engine."""
        near = None if self.near is None else list(self.near)
        return (self.rule, [list(vector) for vector in self.vectors], near, self.t, self.project)

    def begin(self, system: Declared) -> Any:
        """A new run of the engine."""
        return _dsocs.RawRun(
            system._raw, list(self.values), self.h, self.order, self.tolerance, self.beginning, self.every
        )


def _vector(name: str, given: Any, system: Declared, own: list[float] | None) -> tuple[float, ...] | None:
    """A vector with a number for each coordinate. A rotation has three components of velocity, in the frame of its body, or a zero before them."""
    if given is None:
        return None if own is None else tuple(own)
    names, moving = system._names, system._moving
    given = _inputs.by_element(name, given, names, system._rotations)
    if name.startswith("q") or isinstance(given, Mapping) or len(moving) == len(names) or np.shape(given) == (len(names),):
        return tuple(_inputs.vector(name, given, names, own))
    # neither length fits: the message asks for the shorter one
    return tuple(_inputs.vector(name, given, moving, None))


def _missing(system: Declared, name: str) -> SetupError:
    said = "{" + ", ".join(f"{coordinate!r}: …" for coordinate in system._names) + "}"
    return SetupError(
        f"{name} is not given, and the text of {system.name} has no run with a start: give {name}={said}, or in the text, "
        "`run { start = ([…], […]); }`, position and velocity"
    )


def _order(order: Any, tolerance: Any, start: Any, q1: Any) -> int:
    """The order of the method, checked with what else belongs to the method."""
    if tolerance is not None and order is not None:
        raise SetupError("order and tolerance are both given; the continuous motion has no order")
    if order is None:
        order = 2
    if isinstance(order, (bool, np.bool_)) or not isinstance(order, (int, np.integer)):
        raise InputTypeError(f"order is {order!r}; expected 2, 4, 6 or 8")
    if order not in (2, 4, 6, 8):
        raise SetupError(f"order is {order}; the step has order 2, its compositions 4, 6 and 8")
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
    return int(order)


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
