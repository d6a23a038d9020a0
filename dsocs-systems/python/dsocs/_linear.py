"""Linear models of a system, and its equilibria."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterator, Mapping, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _arrays, _dsocs, _inputs
from ._dsocs import Node
from ._errors import InputTypeError, SetupError
from ._setup import STEP, Setup

if TYPE_CHECKING:
    from ._inputs import VectorLike
    from ._system import System

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
#: A name, or several.
Names = Union[str, Sequence[str]]


def _fixed(numbers: Any, shape: tuple[int, ...]) -> Array:
    """A read-only array."""
    array = np.asarray(numbers, dtype=np.float64).reshape(shape)
    array.setflags(write=False)
    return array


def _complex(pairs: Sequence[Sequence[float]]) -> Complex:
    array = np.array([complex(re, im) for re, im in pairs], dtype=np.complex128)
    array.setflags(write=False)
    return array


def _shown(eigenvalues: Complex) -> str:
    """Eigenvalues in a line, conjugate ones as one."""
    # without the signs of zeros
    numbers = [(float(z.real) + 0.0, float(z.imag)) for z in eigenvalues if z.imag >= 0]
    shown = [f"{re:.4g}" if im == 0 else f"{re:.4g}±{im:.4g}j" for re, im in numbers]
    return "eigenvalues: " + ", ".join([*shown[:8], *(["…"] if len(shown) > 8 else [])])


def _names(what: str, given: Names | None) -> list[str] | None:
    """The names, of which one may be given alone."""
    if given is None:
        return None
    if isinstance(given, str):
        return [given]
    if not isinstance(given, Sequence) or not all(isinstance(name, str) for name in given):
        raise InputTypeError(f"{what} is {given!r}; expected a name or a list of names")
    return list(given)


def _elements(names: list[str] | None, system: System) -> list[str] | None:
    """The names of inputs, those of an array or a matrix element by element."""
    if names is None:
        return None
    known = [of.name for of in system._parameters]
    found = [([], ()) if name in known else _arrays.elements(name, {of: place for place, of in enumerate(known)}) for name in names]
    return [element for name, (places, _) in zip(names, found) for element in ([known[place] for place in places] or [name])]


class LinearModel(_inputs.Fixed):
    """The linear model of a system about a state, of its continuous motion or of the paper's step:

    ```text
    z' = A z + B u,   y = C z + D u      continuous, if step is None
    z  → A z + B u,   y = C z + D u      from a node to the next
    ```

    `z` is the change of the state, `u` that of the inputs from their values, `y` that of the outputs. `System.linearize` makes it. All arrays are
    of float64 and cannot be written to; units are those of the declaration. The derivatives are exact to rounding: by the implicit function theorem
    on the equations (`dsocs_core::linear` has the formula and its source).

    In motion, `z` compares two motions at the same time: the one through the point, and one beside it (`state` with `about`); `drift` is the rate of
    the state along the first. The turn of a rotation is seen from the moving body. The guide's chapter *Linear models and equilibria* has the turn
    from the attitude that stays.

    Without constraints on positions and velocities, `z` is position and velocity. With them, it is a minimal set: coordinates along an orthonormal basis
    of the free directions, `z = projection @ change` and `change = basis.T @ z` with the change of `(q, v)`.
    """

    def __init__(self, system: System, results: Mapping[str, Any]) -> None:
        names = {kind: tuple(name for name, _, _ in results[kind]) for kind in ("states", "inputs", "outputs")}
        n, m, p = (len(names[kind]) for kind in ("states", "inputs", "outputs"))
        both = 2 * len(system.coordinates)
        #: The system.
        self.system = system
        #: The step [s]; None of the continuous motion.
        self.step: float | None = results["step"]
        #: The names of the states, the minimal coordinates `z`: `theta`, `v_theta`; `along_x` where it moves more coordinates than `x`.
        self.states: tuple[str, ...] = names["states"]
        #: The names of the inputs: parameters.
        self.inputs: tuple[str, ...] = names["inputs"]
        #: The names of the outputs.
        self.outputs: tuple[str, ...] = names["outputs"]
        #: The units of states, inputs and outputs, by name; None where the declaration does not say one.
        self.units: dict[str, str | None] = {name: unit for kind in names for name, _, unit in results[kind]}
        #: The matrix A, of the shape (states, states).
        self.A: Array = _fixed(results["A"], (n, n))
        #: The matrix B, of the shape (states, inputs).
        self.B: Array = _fixed(results["B"], (n, m))
        #: The matrix C, of the shape (outputs, states).
        self.C: Array = _fixed(results["C"], (p, n))
        #: The matrix D, of the shape (outputs, inputs).
        self.D: Array = _fixed(results["D"], (p, m))
        #: The time of the state [s].
        self.t: float = results["t"]
        #: The position about which it is linearized.
        self.q: Array = _fixed(results["q"], (-1,))
        #: The velocity.
        self.v: Array = _fixed(results["v"], (-1,))
        #: The acceleration.
        self.a: Array = _fixed(results["a"], (-1,))
        #: The rate of `state` along the motion through the point or, for a step, its change in the step. Zero
        #: at an equilibrium.
        self.drift: Array = _fixed(results["drift"], (n,))
        #: The outputs at the point.
        self.measured: Array = _fixed(results["measured"], (p,))
        #: The matrix that gives the states from changes of position and velocity, of the shape (states, 2
        #: coordinates).
        self.projection: Array = _fixed(results["projection"], (n, both))
        #: The changes of position and velocity of a unit change of each state, of the shape (states, 2
        #: coordinates).
        self.basis: Array = _fixed(results["basis"], (n, both))
        #: `directions` at the next node; for the model of a step.
        self.basis_after: Array = _fixed(results["basis_after"], (n, both))
        self._eigenvalues = results["eigenvalues"]
        self._results = dict(results)
        self._seal()

    @property
    def discrete(self) -> bool:
        """Whether it is the model of the step."""
        return self.step is not None

    @property
    def eigenvalues(self) -> Complex:
        """The eigenvalues of A [1/s; of a step, without unit], from the largest real part to the least."""
        if self._eigenvalues is None:
            return np.asarray(np.linalg.eigvals(self.A), dtype=np.complex128)
        return _complex(self._eigenvalues)

    def state(self, q: VectorLike | Node, v: VectorLike | None = None, *, about: Node | None = None) -> Array:
        """The state `z` of a node, or of a position and a velocity (which is that of the model if it is not given): what a gain is multiplied with.

        `about`: the node from which the change is taken, such as that of the motion that a controller follows; without it, the state about which the
        model is made.

        ```python
        run.until(10.0, control=lambda node: {"force": float(-K @ model.state(node))})
        ```

        Of a rotation, it is the turn from the other attitude, in the frame of its body, as the axis times the angle [rad], of at most half a turn;
        `q` and `-q` are one attitude.
        """
        names, rotations = self.system._names, self.system._rotations
        if isinstance(q, Node):
            if v is not None:
                raise SetupError("v is given beside a node, which has its own velocity")
            place, rate = q.q, q.v
        else:
            place = np.array(_inputs.vector("q", _inputs.by_element("q", q, names, rotations), names, self.q.tolist()))
            rate = self.v if v is None else np.array(_inputs.vector("v", _inputs.by_element("v", v, names, rotations), names, self.v.tolist()))
        origin = (self.q, self.v) if about is None else (about.q, about.v)
        own, there = ([np.asarray(vector).tolist() for vector in each] for each in (origin, (place, rate)))
        state: Array = self.projection @ _dsocs.state_change(rotations, own, there)
        return state

    def to_control(self) -> Any:
        """The model as a `control.StateSpace` of the package python-control, with its names; of a step, with the time `step` between samples.

        Raises `ImportError` if python-control is not installed.
        """
        try:
            import control
        except ImportError:
            raise ImportError("LinearModel.to_control needs the package python-control: pip install control") from None
        return control.ss(
            self.A, self.B, self.C, self.D, 0 if self.step is None else self.step,
            states=list(self.states), inputs=list(self.inputs), outputs=list(self.outputs), name=self.system.name,
        )  # fmt: skip

    def __repr__(self) -> str:
        kind = "continuous" if self.step is None else f"step={self.step:g}"
        parts = [f"states: {', '.join(self.states)}", f"inputs: {', '.join(self.inputs)}", f"outputs: {', '.join(self.outputs)}"]
        parts += [", ".join(f"{name} {matrix.shape}" for name, matrix in zip("ABCD", (self.A, self.B, self.C, self.D))), _shown(self.eigenvalues)]
        return f"<LinearModel of {self.system.name} ({kind}); {'; '.join(parts)}>"

    def __reduce__(self) -> Any:
        return LinearModel, (self.system, self._results)


class Equilibrium(_inputs.Fixed):
    """A state of rest. `equilibrium["theta"]` is a coordinate or a parameter by name. `System.equilibrium` finds it."""

    def __init__(self, system: System, results: Mapping[str, Any], t: float) -> None:
        #: The system.
        self.system = system
        #: The time [s].
        self.t = t
        #: The position. Angles are as they were found, not reduced to a turn.
        self.q: Array = _fixed(results["q"], (-1,))
        #: The values of all parameters, by name, with those that were free as they were found.
        self.parameters: dict[str, float] = dict(zip((of.name for of in system._parameters), np.asarray(results["parameters"]).tolist()))
        #: The generalized constraint force, a number for each coordinate.
        self.force: Array = _fixed(results["force"], (-1,))
        #: The directions in which neighbouring equilibria lie, if this is one of a continuum: a row for each,
        #: with the change of the position, then of the free parameters.
        self.directions: Array = _fixed(results["directions"], (len(results["directions"]), -1 if results["directions"] else len(self.q)))
        #: `stable`, `unstable` or `undecided by the linear model`; None where there is no linear model.
        self.stability: str | None = results["stability"]
        #: Whether dry friction holds a range of positions around this one, which needs no friction.
        self.held_by_friction: bool = results["held_by_friction"]
        #: Whether the declaration depends on the time, so that this is the equilibrium of its equations frozen at `t`.
        self.frozen: bool = results["frozen"]
        #: The reason why there is no linear model, as where dry friction holds the system; None where there
        #: is one.
        self.failure: str | None = results["failure"]
        self._eigenvalues = results["eigenvalues"]
        self._results = dict(results)
        self._seal()

    @property
    def isolated(self) -> bool:
        """Whether there is no other equilibrium nearby."""
        return len(self.directions) == 0

    @property
    def eigenvalues(self) -> Complex | None:
        """The eigenvalues of the linear model [1/s], from the largest real part to the least; None where there is no linear model."""
        return None if self._eigenvalues is None else _complex(self._eigenvalues)

    def linearize(self, *, h: float | None = None, inputs: Names | None = None, outputs: Names | None = None) -> LinearModel:
        """The linear model at the equilibrium, from `System.linearize`."""
        return linearize(
            self.system, h=h, q=self.q, v=None, t=self.t, near=None, project=False, inputs=inputs, outputs=outputs, run=None, values=self.parameters
        )

    def __getitem__(self, name: str) -> float:
        if name in self.system._names:
            return float(self.q[self.system._names.index(name)])
        if name in self.parameters:
            return self.parameters[name]
        raise KeyError(f"an equilibrium has no `{name}`; known: {', '.join([*self.system._names, *self.parameters])}")

    def __repr__(self) -> str:
        place = ", ".join(f"{name}={x:.6g}" for name, x in zip(self.system._names, self.q))
        parts = [place, self.stability or "no linear model"]
        if self.eigenvalues is not None:
            parts.append(_shown(self.eigenvalues))
        if not self.isolated:
            parts.append(f"one of a continuum of {len(self.directions)} dimension{'s' if len(self.directions) > 1 else ''}")
        if self.held_by_friction:
            parts.append("in a range that friction holds")
        if self.frozen:
            parts.append(f"frozen at t = {self.t:.6g}")
        return f"<Equilibrium of {self.system.name}: {'; '.join(parts)}>"

    def __reduce__(self) -> Any:
        return Equilibrium, (self.system, self._results, self.t)


class Equilibria(_inputs.Fixed, Sequence[Equilibrium]):
    """The equilibria that are found from some guesses, each once."""

    def __init__(self, found: Sequence[Equilibrium], of_guess: Sequence[Any]) -> None:
        self._found = tuple(found)
        #: For each guess the index of its equilibrium; None where there is none.
        self.of_guess: list[int | None] = [place if isinstance(place, int) else None for place in of_guess]
        #: The guesses without an equilibrium, by their indices, each with its exception.
        self.failures: dict[int, Exception] = {k: place for k, place in enumerate(of_guess) if isinstance(place, Exception)}
        self._seal()

    def __len__(self) -> int:
        return len(self._found)

    def __getitem__(self, place: Any) -> Any:
        return self._found[place]

    def __iter__(self) -> Iterator[Equilibrium]:
        return iter(self._found)

    def __repr__(self) -> str:
        failed = f"; {len(self.failures)} guesses failed" if self.failures else ""
        return "\n".join([f"<{len(self)} equilibria{failed}>", *(f"  {found!r}" for found in self)])


def linearize(
    system: System, *, h: Any, q: Any, v: Any, t: Any, near: Any, project: Any, inputs: Any, outputs: Any, run: Any, values: Mapping[str, Any]
) -> LinearModel:
    """The linear model at a state with the arguments of `System.linearize`."""
    if q is not None and v is None:
        v = [0.0] * len(system.coordinates)
    step = None if h is None else _inputs.number("h", h)
    if step == 0:
        raise SetupError("h is 0; expected a step that is not zero, or None for the continuous motion")
    setup = Setup.of(system, h=STEP, q=q, v=v, t=t, near=near, project=project, run=run, values=values)
    results = _dsocs.linearize(system._raw, list(setup.values), step, setup.beginning, _elements(_names("inputs", inputs), system), _names("outputs", outputs))
    return LinearModel(system, results)


def _guesses(system: System, q: Any, run: Any) -> list[list[float]]:
    """The guesses: that of the text's run, one position, or several."""
    names = system._names
    if q is None:
        text = system._run_text(run)
        own = text.start[0] if text is not None and text.start is not None else None
        return [list(own) if own is not None else [0.0] * len(names)]
    return [_inputs.vector("q", _inputs.by_element("q", q, names, system._rotations), names, None)]


def equilibrium(system: System, *, q: Any, t: Any, free: Any, hold: Any, run: Any, values: Mapping[str, Any]) -> Equilibrium:
    """The equilibrium near a position."""
    found = _search(system, _guesses(system, q, run), t, free, hold, values)
    for failure in found.failures.values():
        raise failure
    result: Equilibrium = found[0]
    return result


def equilibria(system: System, q: Any, *, t: Any, free: Any, hold: Any, values: Mapping[str, Any]) -> Equilibria:
    """The equilibria near some positions."""
    names = system._names
    if isinstance(q, (str, bytes, Mapping)) or not hasattr(q, "__iter__"):
        raise InputTypeError(f"q is {q!r}; expected a list of positions, or an array of the shape (guesses, {len(names)})")
    guesses = [_inputs.vector(f"q[{place}]", guess, names, None) for place, guess in enumerate(q)]
    if not guesses:
        raise SetupError("q is empty; expected a position for each guess")
    return _search(system, guesses, t, free, hold, values)


def _search(system: System, guesses: list[list[float]], t: Any, free: Any, hold: Any, values: Mapping[str, Any]) -> Equilibria:
    time = 0.0 if t is None else _inputs.number("t", t)
    numbers = system._with(values)
    found, of_guess = _dsocs.equilibria(system._raw, numbers, time, guesses, _names("free", free) or [], _names("hold", hold) or [])
    return Equilibria([Equilibrium(system, results, time) for results in found], of_guess)
