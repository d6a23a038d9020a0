"""The command `dsocs` of the package, also as `python -m dsocs`."""

from __future__ import annotations

import sys

from . import _dsocs


def main() -> int:
    """Calls the program with the arguments of the command line."""
    return _dsocs.program(["dsocs", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
