"""Tables: of runs, of ensembles, of sweeps."""

from __future__ import annotations

import os
from typing import Any, Mapping

import numpy as np
import numpy.typing as npt

from ._errors import Error, SetupError


def frame(table: Mapping[str, Any]) -> Any:
    """A `pandas.DataFrame` of columns."""
    try:
        import pandas
    except ImportError:
        raise Error("pandas is not installed; table() gives the same as a dict of arrays") from None
    # pandas takes over read-only arrays without a copy
    return pandas.DataFrame(dict(table), copy=False)


def read_sweep(folder: str | os.PathLike[str], *, nodes: bool = False) -> Any:
    """The table of a sweep (`dsocs sweep plan.toml --out folder`), with a row for each point; with `nodes`, that of the nodes it has kept.

    It is a `pandas.DataFrame` where pandas is installed, else a dict of arrays. pyarrow has to be installed: the tables are in Parquet.

    Raises `SetupError` if there is no such table in the folder.
    """
    place = os.path.join(folder, "nodes" if nodes else "points")
    parts = sorted(name for name in os.listdir(place) if name.endswith(".parquet")) if os.path.isdir(place) else []
    if not parts:
        raise SetupError(f"{place} has no table of a sweep: `dsocs sweep plan.toml --out {os.fspath(folder)}` makes one")
    try:
        import pyarrow.parquet
    except ImportError:
        raise Error("pyarrow is not installed, which reads the tables of a sweep") from None
    table = pyarrow.concat_tables([pyarrow.parquet.read_table(os.path.join(place, name)) for name in parts])
    try:
        import pandas  # noqa: F401
    except ImportError:
        columns: dict[str, npt.NDArray[Any]] = {name: np.asarray(table[name].to_numpy()) for name in table.column_names}
        return columns
    return table.to_pandas()
