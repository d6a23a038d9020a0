"""The exceptions of the package, in a small tree.

| exception | when |
|---|---|
| `Error` | all of these but the last |
| `DeclarationError` | a text is no system; it has the line and the column of each mistake |
| `SetupError` | a start, a step, a parameter or another input cannot be used |
| `InputTypeError` | the same where an input is of a wrong type; it is a `TypeError`, too |
| `StepError` | a step has no solution; it has the step, the time, the nodes and the run up to there |
| `DerivativeError` | a run, or the equations at a state, have no derivative |
| `EquilibriumError` | no state of rest is found |
| `Interrupted` | Ctrl-C ended a run; it is a `KeyboardInterrupt` and no `Error`, and has the run up to there |

Where Python has an exception of its own, that one is raised: `KeyError` for a column that does not exist, `IndexError` for a node, `AttributeError`
for an attribute that is set, `FileNotFoundError` and its like for files, `MemoryError` for a run that is too long, `ImportError` for a package that is
not installed where it is asked for by name.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Iterator, NamedTuple, Sequence

if TYPE_CHECKING:
    from ._run import Run

__all__ = [
    "DeclarationError",
    "DeclarationWarning",
    "DerivativeError",
    "EquilibriumError",
    "Error",
    "InputTypeError",
    "Interrupted",
    "Mistake",
    "SetupError",
    "StepError",
    "StepWarning",
]


class Error(Exception):
    """The base of all exceptions of this package."""


class Mistake(NamedTuple):
    """A mistake in a text. Lines and columns count from 1, columns in characters."""

    line: int
    column: int
    end_line: int
    end_column: int
    message: str


class DeclarationError(Error, ValueError):
    """A text does not declare a system. The message shows the lines of the text with each mistake underlined."""

    def __init__(self, message: str, mistakes: Sequence[tuple[int, int, int, int, str]] = ()) -> None:
        super().__init__(message)
        #: All mistakes, in the order of the text.
        self.mistakes: list[Mistake] = [Mistake(*mistake) for mistake in mistakes]

    @property
    def line(self) -> int | None:
        """The line of the first mistake, from 1; None if a file could not be read."""
        return self.mistakes[0].line if self.mistakes else None

    @property
    def column(self) -> int | None:
        """The column of the first mistake, from 1; None if a file could not be read."""
        return self.mistakes[0].column if self.mistakes else None

    def __reduce__(self) -> Any:
        return type(self), (self.args[0], [tuple(mistake) for mistake in self.mistakes])


class SetupError(Error, ValueError):
    """A start, a step, a parameter or another input cannot be used. The message has its name."""


class InputTypeError(SetupError, TypeError):
    """An input is of a wrong type. The message has its name."""


class StepError(Error, ArithmeticError):
    """A step has no solution, or more than one. The nodes computed before are in `run`."""

    def __init__(
        self,
        message: str,
        *,
        time: float | None = None,
        step: int | None = None,
        h: float | None = None,
        q0: Sequence[float] = (),
        q1: Sequence[float] = (),
        q2: Sequence[float] = (),
        other: Sequence[float] = (),
        reason: str | None = None,
        run: Run | None = None,
    ) -> None:
        super().__init__(message)
        #: The time of the step's middle node.
        self.time = time
        #: The number of the step's middle node; None where the method chooses its steps.
        self.step = step
        #: The step.
        self.h = h
        #: The step's nodes: the two known ones, and the last candidate for the third.
        self.nodes: tuple[list[float], ...] = (list(q0), list(q1), list(q2)) if len(q0) else ()
        #: The other candidate, where there are two.
        self.other = list(other)
        #: The reason, in a line.
        self.reason = reason
        #: The run up to there.
        self.run = run

    def __reduce__(self) -> Any:
        nodes = self.nodes or ((), (), ())
        state: dict[str, Any] = dict(time=self.time, step=self.step, h=self.h, q0=nodes[0], q1=nodes[1], q2=nodes[2])
        state.update(other=self.other, reason=self.reason, run=self.run)
        return _step_error, (self.args[0], state)


def _step_error(message: str, state: dict[str, Any]) -> StepError:
    return StepError(message, **state)


class DerivativeError(Error, ArithmeticError):
    """A run has no derivative, or the equations have none at a state."""


class EquilibriumError(Error, ArithmeticError):
    """No equilibrium is found near a guess."""

    def __init__(self, message: str, q: Sequence[float] = ()) -> None:
        super().__init__(message)
        #: The position where the search ended.
        self.q = list(q)

    def __reduce__(self) -> Any:
        return type(self), (self.args[0], self.q)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C interrupted a run. The nodes computed before are in `run`, which can go on; it is None where nothing is kept."""

    def __init__(self, message: str, run: Run | None = None) -> None:
        super().__init__(message)
        #: The run up to there.
        self.run = run


@contextmanager
def interruptible(said: str) -> Iterator[None]:
    """Ctrl-C inside is `Interrupted`, with what is lost by it."""
    try:
        yield
    except Interrupted:
        raise
    except KeyboardInterrupt:
        raise Interrupted(f"interrupted: {said}") from None


class DeclarationWarning(UserWarning):
    """A part of a text has no effect."""


class StepWarning(RuntimeWarning):
    """The error of a run may be larger than that of its method, or its energy or motion looks wrong."""
