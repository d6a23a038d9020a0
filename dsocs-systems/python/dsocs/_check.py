"""The paper's theorems, checked on a motion."""

from __future__ import annotations

import textwrap
from typing import Any, NamedTuple

from . import _dsocs
from ._errors import SetupError, interruptible
from ._setup import Setup
from ._system import System


#: The most columns of the table of findings.
_WIDTH = 100


class Finding(NamedTuple):
    """A measured value, and the limit that it has to meet."""

    #: The check.
    check: str
    #: The quantity that is measured.
    what: str
    #: The value; NaN where there is none.
    figure: float
    #: The limit; None where the value is for information only.
    bar: float | None
    #: The relation that the value has to have to its limit: `<=` or `>=`.
    relation: str | None
    #: Whether it meets the limit, or is excused.
    ok: bool
    #: The reason, if there is no value.
    failure: str | None
    #: A remark.
    note: str | None
    #: The reason why the value need not meet its limit on this motion.
    excuse: str | None


class Findings(tuple[Finding, ...]):
    """All findings of a check; `ok` is true if all limits are met or excused."""

    __slots__ = ()

    @property
    def ok(self) -> bool:
        """Whether every value meets its limit, or is excused."""
        return all(finding.ok for finding in self)

    def __repr__(self) -> str:
        rows = []
        for finding in self:
            bar = "" if finding.bar is None else f"{finding.relation} {finding.bar:.3g}"
            word = "" if finding.ok and finding.bar is None else "ok" if finding.ok else "FAILED"
            if finding.ok and finding.excuse is not None:
                word = "open"
            rows.append((f"{finding.check}: {finding.what}", f"{finding.figure:.3g}", bar, word))
        widths = [max((len(row[place]) for row in rows), default=0) for place in range(4)]
        widths[0] = min(widths[0], _WIDTH - sum(widths[1:]) - 6)
        lines = []
        for what, figure, bar, word in rows:
            # the figures stand behind the last line of what is measured
            *before, last = textwrap.wrap(what, widths[0], subsequent_indent="  ")
            lines += [*before, f"{last:<{widths[0]}}  {figure:>{widths[1]}}  {bar:<{widths[2]}}  {word}".rstrip()]
        return "\n".join(lines)


def check(system: System, until: Any, *, values: Any, **asked: Any) -> Findings:
    """Checks a motion with the arguments of `System.flow`."""
    setup = Setup.of(system, values=values, **asked)
    return check_setup(system, setup, setup.end(system, "until", until))


def check_setup(system: System, setup: Setup, until: float) -> Findings:
    """Checks the motion of a run."""
    if setup.order > 2 or setup.tolerance is not None:
        raise SetupError("the checks are about the paper's step: order=2, without a tolerance")
    with interruptible("nothing is known of this motion; a shorter one (until=) takes less time"):
        found = _dsocs.check(system._raw, list(setup.values), setup.h, until, setup.beginning)
    return Findings(Finding(**finding) for finding in found)
