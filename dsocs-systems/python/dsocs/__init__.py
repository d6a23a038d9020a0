"""Integrators for mechanical systems with constraints on positions, velocities and accelerations.

A system is written down as in the paper: coordinates, a Lagrangian, constraints. `read` takes it from a file, `System` from a text, and
`coordinates` begins one from expressions. `System.flow` begins a run:

```python
import dsocs

swing = dsocs.System('''
    parameters { length = 1.0, gravity = 9.81 }
    coordinates(theta);
    lagrangian = (length * dot(theta)).powi(2) / 2 + gravity * length * theta.cos();
''')
run = swing.flow(h=0.01, q=[1.0], v=[0.0], length=1.2).until(20.0)
run.t, run.q, run.energy        # arrays with a row for each node, not copied
run["theta"]                    # a column by its name
```

The results have the bits of the command line `dsocs`. All numbers are in the units of the declaration; in SI units times are in seconds.
"""

from ._check import Finding, Findings
from ._dsocs import Node, __version__
from ._ensemble import Ends, Ensemble
from ._errors import (
    DeclarationError,
    DeclarationWarning,
    DerivativeError,
    EquilibriumError,
    Error,
    InputTypeError,
    Interrupted,
    Mistake,
    SetupError,
    StepError,
    StepWarning,
)
from ._events import Event, Occurrence, Occurrences, Points
from ._expressions import Expression, coordinates, dddot, ddot, dot, parameter, time, to_sympy, where
from ._linear import Equilibria, Equilibrium, LinearModel
from ._path import Gradient, Path
from ._run import Run
from ._system import Quantity, RunText, System, read
from ._table import read_sweep
from ._results import Certificate, ErrorEstimate, NearlySingular, Roots, Unresolved

__all__ = [
    "Certificate",
    "DeclarationError",
    "DeclarationWarning",
    "DerivativeError",
    "Ends",
    "Ensemble",
    "Equilibria",
    "Equilibrium",
    "EquilibriumError",
    "Error",
    "ErrorEstimate",
    "Event",
    "Expression",
    "Finding",
    "Findings",
    "Gradient",
    "InputTypeError",
    "Interrupted",
    "LinearModel",
    "Mistake",
    "NearlySingular",
    "Node",
    "Occurrence",
    "Occurrences",
    "Path",
    "Points",
    "Quantity",
    "Roots",
    "Run",
    "RunText",
    "SetupError",
    "StepError",
    "StepWarning",
    "System",
    "Unresolved",
    "__version__",
    "coordinates",
    "dddot",
    "ddot",
    "dot",
    "parameter",
    "read",
    "read_sweep",
    "time",
    "to_sympy",
    "where",
]
