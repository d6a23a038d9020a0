"""Further information on a run, besides its nodes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Unresolved(NamedTuple):
    """Steps that did not resolve a jump, such as that of dry friction. Each reduces the order of the run to 1."""

    #: Their number.
    steps: int
    #: The time of the first of them.
    first: float
    #: The largest difference from the force of a smooth continuation, relative to the change of the momentum
    #: over the step.
    largest: float
    #: The time of the step with that difference.
    largest_at: float


class NearlySingular(NamedTuple):
    """Steps in which the equations were nearly singular: they hardly determine the acceleration there."""

    #: Their number.
    steps: int
    #: The time of the first of them.
    first: float
    #: The number of those in which only the equations of the step were nearly singular, not those of the
    #: continuous motion.
    of_step: int


class ErrorEstimate(NamedTuple):
    """The error of a run against the continuous motion."""

    #: The error of each coordinate at each node: an array of the shape (nodes, coordinates).
    errors: Array
    #: The largest error of each coordinate, by name.
    largest: dict[str, float]
    #: The uncertainty of the continuous motion itself.
    uncertainty: float

    def __repr__(self) -> str:
        if not np.isfinite(self.errors).any():
            return f"<ErrorEstimate of {len(self.errors)} nodes>"
        node, place = np.unravel_index(np.nanargmax(self.errors), self.errors.shape)
        name = list(self.largest)[int(place)]
        where = f"of {name} at run[{node}] of {len(self.errors)} nodes"
        return f"<ErrorEstimate: at most {self.errors[node, place]:.3g}, {where}; uncertainty {self.uncertainty:.1g}>"


class Certificate(NamedTuple):
    """The regularity of each step: the paper's theorem on the discrete flow requires that neither singular value is zero."""

    #: The smallest singular value of the derivative by the last node, an array of the shape (nodes,); NaN at the start.
    forward: Array
    #: The smallest singular value of the derivative by the first node, an array of the shape (nodes,); NaN at the start.
    backward: Array
    #: Whether the theorem grants a flow at each node, forward and back: an array of the shape (nodes, 2). At the start, where no step was solved, it is true.
    granted: npt.NDArray[np.bool_]


class Roots(NamedTuple):
    """The positions that solve a step."""

    #: The solution that Newton's iteration finds: an array of the shape (coordinates,).
    found: Array
    #: Another solution; None if none is found.
    other: Array | None


def jumps(found: Unresolved, steps: int, order: int) -> str:
    """The warning about steps within which a function jumps."""
    plural = "s" if steps > 1 else ""
    # no method follows the continuous motion of a third-order system
    third = order > 2
    if math.isinf(found.largest):
        ends = "end the run before" if third else "`tolerance` ends where the motion does"
        place = f"within {steps} step{plural} that the run has passed, first about t = {found.first:.3f}"
        if found.largest_at != found.first:
            place = f"about t = {found.largest_at:.3f}, in one of {steps} steps within which something jumps, the first of them about t = {found.first:.3f}"
        return (
            f"a force is infinite, or the velocity has to jump, {place}: what comes after depends on where the nodes lie ({ends})"
        )
    goes_on = "; or `tolerance`, which goes on from the place of the jump itself; estimate_error() measures what it costs"
    return (
        f"a force or a constraint jumps, or varies too fast for the nodes, within {steps} step{plural}, first about t = {found.first:.3f}: a jump costs an "
        "error of the first order in the step, a root of zero, whose rate has no bound, one of an order between 1 and 2; what has its peak or its "
        f"period between two nodes is lost, and the motion may be another one (a smaller `h`{'' if third else goes_on})"
    )


def singular(found: NearlySingular, steps: int, order: int, may_divide: bool) -> str:
    """The warning about steps in which the equations were nearly singular."""
    plural = "s" if steps > 1 else ""
    third = order > 2
    if found.of_step == found.steps:
        ends = "" if third else "; `tolerance=1e-9` ends where the motion does"
        return (
            f"the equations of the step pass through a singularity in {steps} step{plural}, first about t = {found.first:.3f}, where those of the continuous "
            "motion have none: a force changes too fast with the velocity for this step, or the velocity grows beyond all bounds, and what comes after is not "
            f"the motion (a smaller `h`{ends})"
        )
    factor = "; a factor of a constraint that vanishes may be divided out, `branch = divide(factor)`" if may_divide else ""
    return (
        f"the equations are nearly singular in {steps} step{plural}, first about t = {found.first:.3f}: they hardly determine the "
        f"{'jerk' if third else 'acceleration'} there, and the error of the motion may be much larger than elsewhere, with that of multipliers (a "
        f"smaller `h` shows it{factor})"
    )
