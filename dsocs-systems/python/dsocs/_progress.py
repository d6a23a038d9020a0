"""The progress of a run."""

from __future__ import annotations

import sys
import time
from contextlib import contextmanager
from typing import Any, Callable, Iterator

from ._errors import InputTypeError

#: The least time between two updates, in s.
_PAUSE = 0.1


@contextmanager
def shown(progress: object, name: str, begin: float, end: float) -> Iterator[Callable[[float], None] | None]:
    """A function that is called with the current time of a run, or None if no progress is to be shown."""
    if progress is False or progress is None:
        yield None
        return
    length = (end - begin) or 1.0
    if progress is not True:
        if not callable(progress):
            raise InputTypeError(f"progress is {progress!r}; expected True, False or a function of the part that is done")
        report: Callable[[float], Any] = progress
        yield lambda t: report(min(max((t - begin) / length, 0.0), 1.0))
        return
    bar = _Bar(name)
    try:
        yield lambda t: bar.show(min(max((t - begin) / length, 0.0), 1.0))
    finally:
        bar.close()


class _Bar:
    """A tqdm bar where tqdm is installed, in terminals and notebooks; otherwise a line on standard error."""

    def __init__(self, name: str) -> None:
        self.name, self.last, self.begun = name, 0.0, time.monotonic()
        self.bar: Any = None
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return
        self.bar = tqdm(total=100, desc=name, unit="%", leave=False)

    def show(self, part: float) -> None:
        now = time.monotonic()
        if now - self.last < _PAUSE and part < 1.0:
            return
        self.last = now
        if self.bar is not None:
            self.bar.n = round(100 * part, 1)
            self.bar.refresh()
        else:
            print(f"\r{self.name}: {100 * part:5.1f} %", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()
        else:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
