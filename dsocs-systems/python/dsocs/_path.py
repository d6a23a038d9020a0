"""Derivatives of a run."""

from __future__ import annotations

from typing import Any, Callable, Mapping, NamedTuple, Sequence

import numpy as np
import numpy.typing as npt

from . import _dsocs, _inputs
from ._dsocs import Node
from ._dual import Dual, DualNode
from ._errors import InputTypeError, SetupError, interruptible
from ._setup import Setup
from ._system import System

Array = npt.NDArray[np.float64]


class Gradient(NamedTuple):
    """The derivatives of a cost, in units of the cost per unit of the variable.

    Those by a rotation, and by its angular velocity, are a zero and three numbers in the frame of its body: where the attitude at the start turns by a small `xi`, about the axes of
    the body, the cost changes by their inner product.
    """

    #: The cost.
    cost: float
    #: By the position at the start. The velocity there stays fixed, or the second node if the run began with nodes (`q1=`).
    q: Array
    #: By the velocity at the start; zero if the run began with nodes.
    v: Array
    #: By the second node; zero unless the run began with nodes.
    q1: Array
    #: By the parameters, by name. The given start is held: position and velocity, or both nodes. The quantities that follow from it vary: the second
    #: node, and the start that `project=True` moves.
    parameters: dict[str, float]


class Path(_inputs.Fixed):
    """A run by the paper's step whose steps are kept, so that it can be differentiated."""

    def __init__(
        self, system: System, until: Any, *, h: Any, q: Any, v: Any, q1: Any, t: Any, start: Any, project: Any, run: Any, values: Mapping[str, Any]
    ) -> None:
        #: The system.
        self.system = system
        self._setup = Setup.of(system, h=h, q=q, v=v, q1=q1, t=t, start=start, project=project, run=run, values=values)
        #: The time [s] that was asked for.
        self.until: float = self._setup.end(system, "until", until)
        setup = self._setup
        with interruptible("nothing is kept of this path; a shorter one (until=) takes less time"):
            self._raw = _dsocs.RawPath(system._raw, list(setup.values), setup.h, setup.beginning, self.until)
        self._seal()

    def _advice(self, name: str) -> str:
        return "a path is set up by `system.path(…)`"

    @property
    def end(self) -> Node:
        """The last node."""
        node: Node = self._raw.end
        return node

    @property
    def steps(self) -> int:
        """The number of steps."""
        steps: int = self._raw.steps
        return steps

    def gradient(self, cost: Callable[[DualNode], Any], *, of: str = "end", at: Sequence[int] | None = None) -> Gradient:
        """The derivatives of a cost by the start and all parameters, backward through the run: it takes as long as two to four runs.

        `cost` gets a node and returns a number: `lambda last: last["theta"]**2 + np.sin(last["v_theta"])`. The node has `t`, `index`, and the arrays
        `q`, `v` and `a`, whose numbers know their derivatives: operators and numpy's functions work on them. `of` says which nodes have a cost:
        `"end"` the last alone, `"nodes"` all of them, whose costs are summed; with `at`, the nodes with these numbers alone (0 is the start, -1 the
        last), as for measurements.

        A start that is given by position and velocity is differentiated with the run, also where constraints bind it. Two nodes (`q=`, `q1=`) are held as they are: where they were taken from
        another run, their own change with the parameters is not in the gradient.

        Raises `DerivativeError` if a step or the start has no derivative.
        """
        if not callable(cost):
            raise InputTypeError(f"cost is {type(cost).__name__}; expected a function of a node")
        if of not in ("end", "nodes"):
            raise SetupError(f"of is {of!r}; expected 'end' or 'nodes'")
        names = self.system._names
        places: set[int] | None = None
        if at is not None:
            if of != "nodes":
                raise SetupError("at is given, which says at which nodes there is a cost: of='nodes'")
            numbers = [_inputs.whole(f"at[{place}]", index, -self.steps - 1) for place, index in enumerate(at)]
            beyond = next((index for index in numbers if index > self.steps), None)
            if beyond is not None:
                raise SetupError(f"at has the node {beyond}; the last one has the number {self.steps}")
            places = {index + self.steps + 1 if index < 0 else index for index in numbers}
        none = (0.0, [0.0] * (3 * len(names)))

        def asked(index: int, t: float, q: Array, v: Array, a: Array) -> tuple[float, list[float]]:
            if places is not None and index not in places:
                return none
            found = cost(DualNode(index, t, q, v, a, names, self.system._rotations))
            return Dual.parts(found, 3 * len(names))

        with interruptible("no derivative is known; the path is still there"):
            found = self._raw.gradient(of == "end", asked)
        parameters = dict(zip((of.name for of in self.system._parameters), found["parameters"].tolist()))
        return Gradient(found["cost"], found["q"], found["v"], found["q1"], parameters)

    def tangents(self, *variables: str) -> dict[str, tuple[Array, Array]]:
        """The derivatives of the last node by variables, forward through the run: for each position and velocity.

        A variable is a parameter, `"q_theta"` or `"v_theta"`, which is a coordinate or a velocity at the start, by name. Of a rotation `r`, `"q_r_x"` is a turn of the start
        about the first axis of the body, and the derivative of a position has a zero and the turn of the body in the four places of `r`.

        Raises `DerivativeError` as `gradient`, and `SetupError` if there is no such variable.
        """
        names, parameters = self.system._names, {of.name for of in self.system._parameters}
        asked = []
        for variable in variables:
            if variable in parameters:
                asked.append((variable, 0))
            elif variable[:2] in ("q_", "v_") and variable[2:] in names:
                asked.append((f"@{variable[0]}", names.index(variable[2:])))
            else:
                known = [*parameters, *(f"q_{x}" for x in names), *(f"v_{x}" for x in names)]
                raise _inputs.unknown("variable", variable, known)
        found = self._raw.tangents(asked)
        return {name: (np.asarray(q), np.asarray(v)) for name, (q, v) in zip(variables, found)}

    def __reduce__(self) -> Any:
        raise TypeError(
            "a path cannot be pickled or copied: its steps are in the engine. What can be: its system, from which system.path(…) makes it again with the "
            "same bits, its last node (path.end), and its gradients"
        )

    def __repr__(self) -> str:
        return f"<Path of {self.system.name}: {self.steps} steps, h={self._setup.h:g}, to t={self.end.t:g}>"
