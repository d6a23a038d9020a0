"""A system that is read from a text."""

from __future__ import annotations

import os
import warnings
from typing import TYPE_CHECKING, Any, Callable, Mapping, Sequence

from . import _dsocs, _given, _inputs
from ._declared import Declared, Quantity, RunText
from ._errors import InputTypeError

if TYPE_CHECKING:
    from ._check import Findings
    from ._ensemble import Ensemble
    from ._inputs import VectorLike
    from ._linear import Equilibria, Equilibrium, LinearModel
    from ._path import Path
    from ._run import Run

__all__ = ["Quantity", "RunText", "System", "read"]


class System(Declared):
    """A mechanical system, read from a text: the body of the Rust attribute `#[dsocs { … }]`, and the parameters.

    ```python
    swing = dsocs.System('''
        parameters { length = 1.0, gravity = 9.81 }
        coordinates(theta);
        lagrangian = (length * dot(theta)).powi(2) / 2 + gravity * length * theta.cos();
    ''')
    run = swing.flow(h=0.01, q=[1.0], v=[0.0]).until(20.0)
    ```

    `text` is the text. `name` is the name of the system in messages. `constants` gives numbers in place of those of the text
    (`const n = 3;`). `samples` gives tables in place of the files that a text names, `samples("wind.csv")`: by the name of the parameter or of the
    file, each a pair of arrays, places and values.

    The language, each statement ended by `;`:

    | statement | meaning |
    |---|---|
    | `parameters { length = 1.0, masses: [3] = [0.1; 3] }` | numbers that a run may set |
    | `coordinates(x, theta)` | the coordinates in their order; `x: [3]` is an array, `r: rotation` the attitude of a body |
    | `lagrangian = …` | `L = T − V` |
    | `holonomic = …`, `nonholonomic = …`, `kinematic = …` | rows that are zero, `[one, other]` some: constraints on positions, velocities, accelerations |
    | `variational = [(…)]` | vectors that span the virtual displacements; or `constraint_forces = [(…)]`, one-forms that span the forces |
    | `external_forces = (…)` | a component for each coordinate |
    | `branch = divide(factor)` | a factor that is divided out of a kinematic constraint |
    | `let name = …`, `observe = [name]` | names for expressions, and those that are reported |
    | `run { start = ([1.0], [0.0]); step = 0.01; until = 20.0; }` | the defaults of a run |

    In expressions: `+ - * /`, `dot(x)`, `ddot(x)`, the time `t`, `x.powi(2)`, `x.powf(1.5)`, `x.sin()`, `x.sqrt()` and the like, `if x < 0 { a } else { b }`,
    `sum(0..3, |i| x[i].powi(2))`. `///` before a quantity gives its meaning, with its unit in brackets at the end. The book describes the whole
    language: the chapters `text_files.md` and
    `declaration.md` in the folder `dsocs-systems/src/guide` of the source, and `python.md` for this package.

    A system never changes. It can be pickled and copied, by its text.
    """

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
        t: float | None = None,
        start: str | None = None,
        project: bool | None = None,
        order: int | None = None,
        tolerance: float | None = None,
        every: int | None = None,
        run: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Run:
        """Begins a run, which stands at its start: `.until(t)` goes on.

        Arguments that are not given are those of the text's run (`run { … }`), or of the one that `run` names. Where a text has no run, `h` (unless
        there is a `tolerance`), `q` and `v` have to be given, and the time to `until`. A text's run without a step or an end has the step 0.01 s and
        lasts 10 s.

        `h`: the step [s], negative to run back in time; with a `tolerance`, the distance of the nodes, 0.01 s by default.
        `q`, `v`: position and velocity at the start, a number for each coordinate, or a dict by name.
        `q1`, `q2`: the second (and third) node in place of a velocity.
        `a`, `force`: the acceleration, or the constraint force, where a constraint of third order leaves it free.
        `near`: which acceleration is meant where the equations allow several: the one nearest to this.
        `t`: the time at the start [s], 0 if it is not given.
        `start`: how the second node follows, `"second-order"` (q1 = q0 + h v0 + h²/2 a0, the default) or `"paper"` (q1 = q0 + h v0).
        `project`: whether the start is moved onto the constraints on positions and velocities.
        `order`: 2 is the paper's step (the default); 4, 6 and 8 are compositions of it.
        `tolerance`: the continuous motion by Taylor series, to this tolerance relative to the velocities.
        `every`: the distance of two kept nodes, in nodes; 1 by default.
        `parameters`, and everything else by name: values of parameters, `length=1.2`. A parameter with the name of an argument goes into `parameters`:
        `parameters={"force": 1.0}`.

        Raises `SetupError` if any of it cannot be used.
        """
        from ._run import Run
        from ._setup import Setup

        asked: dict[str, Any] = dict(
            h=h, q=q, v=v, q1=q1, q2=q2, a=a, force=force, near=near, t=t, start=start, project=project,
            order=order, tolerance=tolerance, every=every, run=run,
        )  # fmt: skip
        return Run(self, Setup.of(self, **asked, values=self._values_of("flow", asked, parameters, values)))

    def ensemble(
        self,
        *,
        h: float | None = None,
        q: Any = None,
        v: Any = None,
        t: float | None = None,
        start: str | None = None,
        project: bool | None = None,
        order: int | None = None,
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

        asked: dict[str, Any] = dict(h=h, q=q, v=v, t=t, start=start, project=project, order=order, tolerance=tolerance, run=run)
        return Ensemble(self, **asked, values=self._values_of("ensemble", asked, parameters, values))

    def path(
        self,
        until: float | None = None,
        *,
        h: float | None = None,
        q: VectorLike | None = None,
        v: VectorLike | None = None,
        q1: VectorLike | None = None,
        t: float | None = None,
        start: str | None = None,
        project: bool | None = None,
        run: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Path:
        """A run by the paper's step that can be differentiated: `.gradient(cost)`.

        `until` is the time [s] of its end. Everything else is as in `flow`; there is no `order` (it is 2), no `tolerance`, and all nodes are kept.

        Raises `SetupError` as `flow`, `StepError` if a step has no solution, and `DerivativeError` if one has no derivative.
        """
        from ._path import Path

        asked: dict[str, Any] = dict(h=h, q=q, v=v, q1=q1, t=t, start=start, project=project, run=run)
        return Path(self, until, **asked, values=self._values_of("path", {**asked, "until": until}, parameters, values))

    def in_jax(
        self,
        until: float,
        variables: Sequence[str] = (),
        *,
        h: float | None = None,
        t: float | None = None,
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

        asked: dict[str, Any] = dict(h=h, t=t, start=start, run=run)
        fixed = {name: value for name, value in asked.items() if value is not None}
        given = self._values_of("in_jax", {**asked, "until": until, "variables": None}, parameters, values)
        return function(self, _inputs.number("until", until), variables, fixed, given)

    def check(
        self,
        *,
        h: float | None = None,
        until: float | None = None,
        q: VectorLike | None = None,
        v: VectorLike | None = None,
        a: VectorLike | None = None,
        near: VectorLike | None = None,
        t: float | None = None,
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

        asked: dict[str, Any] = dict(h=h, q=q, v=v, a=a, near=near, t=t, start=start, project=project, run=run)
        return check(self, until, **asked, values=self._values_of("check", {**asked, "until": until}, parameters, values))

    def linearize(
        self,
        *,
        q: VectorLike | None = None,
        v: VectorLike | None = None,
        h: float | None = None,
        inputs: str | Sequence[str] | None = None,
        outputs: str | Sequence[str] | None = None,
        t: float | None = None,
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
        `h`: None is the continuous motion, a number the paper's step of that length [s], under inputs that do not change. What `Run.until` holds from `control` acts a step later (the guide's
        section 3).
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

        asked: dict[str, Any] = dict(h=h, q=q, v=v, t=t, near=near, project=project, inputs=inputs, outputs=outputs, run=run)
        return linearize(self, **asked, values=self._values_of("linearize", asked, parameters, values))

    def equilibrium(
        self,
        q: VectorLike | None = None,
        *,
        free: str | Sequence[str] | None = None,
        hold: str | Sequence[str] | None = None,
        t: float | None = None,
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

        The equilibrium may be one of a continuum (`Equilibrium.directions`), such as the place of a cart; then it is the one nearest to the guess.
        Functions that jump with the velocity, such as dry friction, are zero at rest.

        Raises `EquilibriumError` if none is found, and `SetupError` if an input cannot be used.
        """
        from ._linear import equilibrium

        asked: dict[str, Any] = dict(q=q, t=t, free=free, hold=hold, run=run)
        return equilibrium(self, **asked, values=self._values_of("equilibrium", asked, parameters, values))

    def equilibria(
        self,
        q: Any,
        *,
        free: str | Sequence[str] | None = None,
        hold: str | Sequence[str] | None = None,
        t: float | None = None,
        parameters: Mapping[str, Any] | None = None,
        **values: Any,
    ) -> Equilibria:
        """The states of rest near some positions, each once: `q` is a list of guesses, or an array of the shape (guesses, coordinates).

        Everything else is as in `equilibrium`. A guess that leads to none is among `Equilibria.failures`. Raises `SetupError` if an input cannot be used.
        """
        from ._linear import equilibria

        asked: dict[str, Any] = dict(t=t, free=free, hold=hold)
        return equilibria(self, q, **asked, values=self._values_of("equilibria", {**asked, "q": q}, parameters, values))

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
    asked = _given.samples(samples or {})
    given = dict(asked)
    for parameter, table in _given.named_files(text):
        if table not in given and parameter not in given:
            place = os.path.join(os.path.dirname(name), table)
            if os.path.isfile(place):
                given[table] = _given.table(place)
    numbers = [(str(key), _inputs.number(f"constants[{key!r}]", value)) for key, value in dict(constants or {}).items()]
    system = System.__new__(System)
    own = os.path.splitext(os.path.basename(name))[0]
    system._set(text, own, numbers, given, run, name, os.path.abspath(name))
    system._check_samples(asked)
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
