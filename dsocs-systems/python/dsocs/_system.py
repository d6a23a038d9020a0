"""A system that is read from a text."""

from __future__ import annotations

import os
import warnings
from typing import TYPE_CHECKING, Any, Callable, Mapping, NamedTuple, Sequence

from . import _dsocs, _given, _inputs
from ._errors import DeclarationError, DeclarationWarning, InputTypeError, SetupError

if TYPE_CHECKING:
    from ._check import Findings
    from ._ensemble import Ensemble
    from ._inputs import VectorLike
    from ._linear import Equilibria, Equilibrium, LinearModel
    from ._path import Path
    from ._run import Run

#: The step of a run, in s, if neither the text nor the call says another one.
STEP = 0.01
#: How long a run is, in s, if neither the text nor the call says it.
UNTIL = 10.0


class Quantity(NamedTuple):
    """A coordinate, a parameter or an observed expression of a declaration."""

    #: The name in the declaration; `masses_2` for an element of an array.
    name: str
    #: What it is.
    meaning: str
    #: Its unit, if the declaration says it.
    unit: str | None


class RunText(NamedTuple):
    """What a text says of a run: `run far { … }`."""

    name: str | None
    start: tuple[list[float], list[float]] | None
    acceleration: list[float] | None
    near: list[float] | None
    project: bool
    step: float | None
    until: float | None


class System:
    """A mechanical system, read from a text: the body of the Rust attribute `#[dsocs { … }]`, and the parameters.

    ```python
    swing = dsocs.System('''
        parameters { length = 1.0, gravity = 9.81 }
        coordinates(theta);
        lagrangian = (length * dot(theta)).powi(2) / 2 + gravity * length * theta.cos();
    ''')
    run = swing.flow(h=0.01, q=[1.0], v=[0.0]).until(20.0)
    ```

    `text` is the text. `name` is what the system is called in messages. `constants` gives numbers in place of those of the text
    (`const n = 3;`). `samples` gives tables in place of the files that a text names, `samples("wind.csv")`: by the name of the parameter or of the
    file, each a pair of arrays, places and values.

    A system never changes. It can be pickled and copied, by its text.
    """

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
        self._warn(3)

    @classmethod
    def of(
        cls,
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
    ) -> System:
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
        `external_forces`: a component for each coordinate, or a dict by name.
        `branch`: a factor that is divided out of a kinematic constraint.
        `observe`: expressions that are reported at every node, by name.
        `parameters`: the values of sympy's symbols.

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
        # a table is given by its parameter's name as well as by its file's
        for parameter, file in _given.named_files(text):
            if parameter in files and file not in files:
                files[file] = files.pop(parameter)
        self._samples = files
        self._constants = constants
        self._path = path
        self._raw = _read(name, shown_as, text, constants, list(files.items()))
        self._shown_as = shown_as
        told = self._raw.description()
        #: What the system is called.
        self.name = name
        #: What the text says of it.
        self.doc: str = told["doc"]
        #: Of which kind its constraints are: `unconstrained`, `holonomic`, `nonholonomic`, `second-order`, `third-order`, `mixed`.
        self.kind: str = told["kind"]
        #: The coordinates, in the order of all arrays.
        self.coordinates = tuple(Quantity(*of) for of in told["coordinates"])
        #: The observed expressions.
        self.observables = tuple(Quantity(*of) for of in told["observables"])
        #: The highest order of a derivative in a constraint, and at least 2.
        self.order: int = told["order"]
        #: How many multipliers of constraint forces there are.
        self.forms: int = told["forms"]
        #: How many constraints there are on positions, on velocities, and on accelerations (or third derivatives).
        self.constraints: tuple[int, int, int] = tuple(told["constraints"])
        self._declaration: str = told["declaration"]
        self._may_divide: bool = told["may_divide"]
        self._parameters = tuple(Quantity(*of) for of in told["parameters"])
        self._tables = {parameter: file for parameter, file, _ in told["samples"]}
        self._values: list[float] = self._raw.values()
        self._names = [of.name for of in self.coordinates]
        #: Those that have a velocity and a force: the first of the four numbers of a rotation has none.
        rotations = set(told["rotations"])
        self._moving = [name for place, name in enumerate(self._names) if place not in rotations]
        runs = [RunText(**run) for run in self._raw.runs()]
        #: The runs of the text, by name; one may have none (None).
        self.runs: dict[str | None, RunText] = {of.name: of for of in runs}
        if run is not None and run not in self.runs:
            raise _inputs.unknown("run", run, [str(known) for known in self.runs if known is not None])
        self._run = run

    def _warn(self, stacklevel: int) -> None:
        for warning in self._raw.warnings(self._shown_as):
            warnings.warn(warning.removeprefix("warning: "), DeclarationWarning, stacklevel=stacklevel)

    @property
    def text(self) -> str:
        """The text, word for word."""
        text: str = self._raw.text
        return text

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters with their values; of an array each element, `masses_0`."""
        return {of.name: value for of, value in zip(self._parameters, self._values)}

    def quantity(self, name: str) -> Quantity:
        """Name, meaning and unit of a coordinate, a parameter or an observed expression."""
        for of in (*self.coordinates, *self._parameters, *self.observables):
            if of.name == name:
                return of
        raise _inputs.unknown("coordinate, parameter or observed expression", name, self._all_names())

    def _all_names(self) -> list[str]:
        return [of.name for of in (*self.coordinates, *self._parameters, *self.observables)]

    def _run_text(self, run: str | None) -> RunText | None:
        """The run of a name; without one, the run that has no name, or else the first."""
        name = run if run is not None else self._run
        if name is not None:
            if name not in self.runs:
                raise _inputs.unknown("run", name, [str(known) for known in self.runs if known is not None])
            return self.runs[name]
        if None in self.runs:
            return self.runs[None]
        return next(iter(self.runs.values()), None)

    def _with(self, given: Mapping[str, Any]) -> list[float]:
        """The values of the parameters, some of them given; an array by its own name or by that of an element."""
        values = list(self._values)
        places = {of.name: place for place, of in enumerate(self._parameters)}
        for name, value in given.items():
            if name in places:
                values[places[name]] = _inputs.number(name, value)
                continue
            elements = list(_given.elements(name, places))
            if not elements:
                if name in self._tables:
                    raise SetupError(
                        f"`{name}` is a table of samples; give another one when the system is read, samples={{{name!r}: …}}"
                    )
                raise _inputs.unknown("parameter", name, places)
            numbers = _inputs.array(name, value)
            if numbers.shape != (len(elements),):
                raise SetupError(f"{name} has the shape {numbers.shape}, but it is an array of {len(elements)} numbers")
            for place, number in zip(elements, numbers.tolist()):
                values[place] = number
        return values

    def flow(
        self,
        *,
        h: float | None = None,
        q: VectorLike | None = None,
        v: VectorLike | None = None,
        q1: VectorLike | None = None,
        q2: VectorLike | None = None,
        a: VectorLike | None = None,
        force: VectorLike | None = None,
        near: VectorLike | None = None,
        t: float = 0.0,
        start: str | None = None,
        project: bool | None = None,
        order: int = 2,
        tolerance: float | None = None,
        every: int = 1,
        run: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Run:
        """Begins a run, which stands at its start: `.until(t)` goes on.

        What is not given is that of the text's run (`run { … }`), or of the one that `run` names.

        `h`: the step [s], negative to run back in time; with a `tolerance`, the distance of the nodes.
        `q`, `v`: position and velocity at the start, a number for each coordinate, or a dict by name.
        `q1`, `q2`: the second (and third) node in place of a velocity.
        `a`, `force`: the acceleration, or the constraint force, where a constraint of third order leaves it free.
        `near`: which acceleration is meant where the equations allow several: the one nearest to this.
        `t`: the time at the start [s].
        `start`: how the second node follows, `"second-order"` (q1 = q0 + h v0 + h²/2 a0, the default) or `"paper"` (q1 = q0 + h v0).
        `project`: whether the start is moved onto the constraints on positions and velocities.
        `order`: 2 is the paper's step; 4, 6 and 8 are compositions of it.
        `tolerance`: the continuous motion by Taylor series, to this tolerance relative to the velocities.
        `every`: every so many nodes one is kept.
        `parameters`, and everything else by name: values of parameters, `length=1.2`.

        Raises `SetupError` if any of it cannot be used.
        """
        from ._run import Run, Setup

        setup = Setup.of(
            self,
            h=h, q=q, v=v, q1=q1, q2=q2, a=a, force=force, near=near, t=t, start=start, project=project,
            order=order, tolerance=tolerance, every=every, run=run, values=_given.joined(parameters, values),
        )  # fmt: skip
        return Run(self, setup)

    def ensemble(
        self,
        *,
        h: float | None = None,
        q: Any = None,
        v: Any = None,
        t: float = 0.0,
        start: str | None = None,
        project: bool | None = None,
        order: int = 2,
        tolerance: float | None = None,
        run: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Ensemble:
        """Many runs side by side, in SIMD lanes and on all cores: `.until(t)` gives their ends.

        `q`, `v`: a number for each coordinate, shared by all runs, or an array of the shape (runs, coordinates); or a dict by name of numbers and
        arrays with a number for each run. Parameters are numbers, or arrays with a number for each run. Everything else is as in `flow`.
        Lanes are for order 2; the other orders, and a `tolerance`, run one after the other on each core.

        Raises `SetupError` if any of it cannot be used, or if a constraint is of third order.
        """
        from ._ensemble import Ensemble

        return Ensemble(
            self, h=h, q=q, v=v, t=t, start=start, project=project, order=order, tolerance=tolerance, run=run,
            values=_given.joined(parameters, values),
        )  # fmt: skip

    def path(
        self,
        until: float | None = None,
        *,
        h: float | None = None,
        q: VectorLike | None = None,
        v: VectorLike | None = None,
        q1: VectorLike | None = None,
        t: float = 0.0,
        start: str | None = None,
        run: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Path:
        """A run by the paper's step that can be differentiated: `.gradient(cost)`. Its arguments are those of `flow`.

        Raises `SetupError` as `flow`, `StepError` if a step has no solution, and `DerivativeError` if one has no derivative.
        """
        from ._path import Path

        return Path(
            self, until, h=h, q=q, v=v, q1=q1, t=t, start=start, run=run, values=_given.joined(parameters, values)
        )

    def in_jax(
        self,
        until: float,
        variables: Sequence[str] = (),
        *,
        h: float | None = None,
        t: float = 0.0,
        start: str | None = None,
        run: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Callable[..., Any]:
        """The motion as a function for jax: `end(q, v, p)` gives position and velocity at the time `until` [s], two arrays of the shape (coordinates,).

        ```python
        jax.config.update("jax_enable_x64", True)
        end = swing.in_jax(5.0, ["length"], h=0.01)
        jax.grad(lambda p: end([1.0], [0.0], p)[0][0] ** 2)(jax.numpy.array([1.2]))
        ```

        `p` has a number for each of the parameters that `variables` names. Everything else is as in `path`, whose gradients are those that jax gets: reverse derivatives of first
        order (`jax.grad`, `jax.vjp`, `jax.jacrev`). It may be inside of `jax.jit` and `jax.vmap`; the runs are made one after the other on the processor.

        Raises `Error` if jax is not installed, and `SetupError` if it computes in single precision, or if there is no such parameter.
        """
        from ._jax import function

        fixed = {name: value for name, value in (("h", h), ("t", t), ("start", start), ("run", run)) if value is not None}
        return function(self, _inputs.number("until", until), variables, fixed, _given.joined(parameters, values))

    def check(
        self,
        *,
        h: float | None = None,
        until: float | None = None,
        q: VectorLike | None = None,
        v: VectorLike | None = None,
        a: VectorLike | None = None,
        near: VectorLike | None = None,
        t: float = 0.0,
        start: str | None = None,
        project: bool | None = None,
        run: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Findings:
        """Checks the paper's theorems on a motion, as `dsocs check` does: regularity, symplectic and momentum laws, reversibility, order.

        Its arguments are those of `flow`. Raises `SetupError` if the motion cannot be computed.
        """
        from ._check import check

        return check(
            self,
            until,
            h=h, q=q, v=v, a=a, near=near, t=t, start=start, project=project, run=run,
            values=_given.joined(parameters, values),
        )  # fmt: skip

    def linearize(
        self,
        *,
        q: VectorLike | None = None,
        v: VectorLike | None = None,
        h: float | None = None,
        inputs: str | Sequence[str] | None = None,
        outputs: str | Sequence[str] | None = None,
        t: float = 0.0,
        near: VectorLike | None = None,
        project: bool | None = None,
        run: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> LinearModel:
        """The linear model about a state: the matrices A, B, C and D, exact to rounding.

        ```python
        model = cart.linearize(q=[0.0, 0.0], inputs="force", outputs=["x", "theta"])
        P = scipy.linalg.solve_continuous_are(model.A, model.B, np.diag([1.0, 10.0, 1.0, 1.0]), np.eye(1))
        K = model.B.T @ P
        ```

        `q`, `v`: the state, a number for each coordinate, or a dict by name. With `q` alone, it is at rest; without both, the text's start.
        `h`: None is the continuous motion, a number the paper's step of that length [s].
        `inputs`: parameters, by name; without it, all of them.
        `outputs`: coordinates (`"theta"`), `"v_theta"`, `"a_theta"`, `"force_theta"`, `"energy"`, observed expressions; without it, all coordinates and
        velocities.
        `t`, `near`, `project`, `run`, `parameters`, and values of parameters by name: as in `flow`.

        Where constraints bind positions or velocities, the model is in as many states as are free. The state need not be an equilibrium
        (`LinearModel.drift`).

        Raises `SetupError` if any of it cannot be used, or a constraint is of third order, and `DerivativeError` where the equations have no derivative: at
        a jump such as that of `signum`, at a corner, or where they are singular.
        """
        from ._linear import linearize

        return linearize(
            self, h=h, q=q, v=v, t=t, near=near, project=project, inputs=inputs, outputs=outputs, run=run, values=_given.joined(parameters, values)
        )

    def equilibrium(
        self,
        q: VectorLike | None = None,
        *,
        free: str | Sequence[str] = (),
        hold: str | Sequence[str] = (),
        t: float = 0.0,
        run: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Equilibrium:
        """The state of rest near a position, with its eigenvalues.

        ```python
        arm.equilibrium([0.5, -0.7], hold=["shoulder", "elbow"], free=["torque_1", "torque_2"])["torque_1"]
        ```

        `q`: a guess of the position, a number for each coordinate or a dict by name; without it that of the text's start, or zeros.
        `free`: parameters that are unknown as well, by name, from their values on. `hold`: coordinates that are held at their guesses.
        `t`: the time [s], where the system depends on it. Values of parameters by name, as in `flow`.

        What is found may be one of a continuum (`Equilibrium.directions`), such as the place of a cart; then it is the one nearest to the guess. Functions that jump with the
        velocity, such as dry friction, are zero at rest.

        Raises `EquilibriumError` if none is found, and `SetupError` if an input cannot be used.
        """
        from ._linear import equilibrium

        return equilibrium(self, q=q, t=t, free=free, hold=hold, run=run, values=_given.joined(parameters, values))

    def equilibria(
        self,
        q: Any,
        *,
        free: str | Sequence[str] = (),
        hold: str | Sequence[str] = (),
        t: float = 0.0,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Equilibria:
        """The states of rest near some positions, each once: `q` is a list of guesses, or an array of the shape (guesses, coordinates).

        Everything else is as in `equilibrium`. A guess that leads to none is among `Equilibria.failures`. Raises `SetupError` if an input cannot be used.
        """
        from ._linear import equilibria

        return equilibria(self, q, t=t, free=free, hold=hold, values=_given.joined(parameters, values))

    def __repr__(self) -> str:
        parts = [f"coordinates: {', '.join(self._names)}"]
        if self._parameters:
            parts.append("parameters: " + ", ".join(f"{name}={value:g}" for name, value in self.parameters.items()))
        if self.observables:
            parts.append("observed: " + ", ".join(of.name for of in self.observables))
        named = [str(name) for name in self.runs if name is not None]
        if named:
            parts.append("runs: " + ", ".join(named))
        return f"<System {self.name} ({self.kind}); {'; '.join(parts)}>"

    def _repr_html_(self) -> str:
        from ._html import system

        return system(self)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, System):
            return NotImplemented
        return self._state() == other._state()

    def __hash__(self) -> int:
        return hash((self.text, self.name))

    def _state(self) -> tuple[Any, ...]:
        return (self.text, self.name, self._constants, self._samples, self._run, self._shown_as, self._path)

    def __reduce__(self) -> Any:
        return _system_of, (_dsocs.__version__, *self._state())

    def __copy__(self) -> System:
        return self

    def __deepcopy__(self, memo: Any) -> System:
        return self


def read(
    path: str | os.PathLike[str],
    *,
    constants: Mapping[str, float] | None = None,
    samples: Mapping[str, Any] | None = None,
) -> System:
    """Reads a system from a file, `swing.dsocs`; behind a colon one of its runs may be named, `swing.dsocs:far`.

    `constants` gives numbers in place of those of the text. Files of samples are looked for beside the file, unless `samples` gives them.

    Raises `FileNotFoundError` and the like if the file cannot be read, and `DeclarationError` if the text is no system.
    """
    if not isinstance(path, (str, os.PathLike)):
        raise InputTypeError(f"path is {type(path).__name__}; expected the name of a file")
    name = os.fspath(path)
    if not isinstance(name, str):
        raise InputTypeError("path is bytes; expected the name of a file")
    run = None
    stem, mark, after = name.rpartition(".dsocs:")
    if mark and not os.path.exists(name):
        name, run = stem + ".dsocs", after
    with open(name, "rb") as file:
        data = file.read()
    text = _given.decoded(name, data)
    given = _given.samples(samples or {})
    for parameter, table in _given.named_files(text):
        if table not in given and parameter not in given:
            place = os.path.join(os.path.dirname(name), table)
            if os.path.isfile(place):
                given[table] = _given.table(place)
    numbers = [(str(key), _inputs.number(f"constants[{key!r}]", value)) for key, value in dict(constants or {}).items()]
    system = System.__new__(System)
    own = os.path.splitext(os.path.basename(name))[0]
    system._set(text, own, numbers, given, run, name, os.path.abspath(name))
    system._warn(3)
    return system


def _system_of(version: str, text: str, name: str, constants: Any, samples: Any, run: Any, shown_as: str, path: Any) -> System:
    """A system that was pickled."""
    if version != _dsocs.__version__:
        warnings.warn(
            f"this system was pickled by dsocs {version}, and is read by {_dsocs.__version__}: results may differ",
            stacklevel=2,
        )
    system = System.__new__(System)
    system._set(text, name, constants, samples, run, shown_as, path)
    return system


def _read(name: str, shown_as: str, text: str, constants: Any, samples: Any) -> Any:
    """Reads a text. Messages show it under the name of its file."""
    return _dsocs.Text.parse(name, shown_as, text, constants, samples)
