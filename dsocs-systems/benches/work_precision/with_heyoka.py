"""heyoka on one problem, for the bench `work_precision`: answers questions on standard input.

The arguments are the interval of the grid, how many intervals there are, how many components are measured, the start, and the equations
as expressions in y0, y1, ...

    version             the major version
    values TOLERANCE    the measured components at all times of the grid
    time TOLERANCE N    the mean time of N solutions [s]
"""

import sys
import time

try:
    import heyoka as hy
except ImportError:
    sys.exit("heyoka is not installed")

interval, intervals, measured = float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
rest = sys.argv[4:]
start = [float(word) for word in rest[: len(rest) // 2]]
names = [f"y{i}" for i in range(len(start))]
variables = dict(zip(names, hy.make_vars(*names)))
functions = {"sin": hy.sin, "cos": hy.cos, "tanh": hy.tanh, "sqrt": hy.sqrt}
system = [
    (variables[name], eval(text, {**functions, **variables}))
    for name, text in zip(names, rest[len(start) :])
]
grid = [interval * k for k in range(intervals + 1)]
integrators = {}


def solve(tolerance):
    if tolerance not in integrators:
        integrators[tolerance] = hy.taylor_adaptive(system, start, tol=tolerance)
    integrator = integrators[tolerance]
    integrator.time = 0.0
    integrator.state[:] = start
    return integrator.propagate_grid(grid)[-1]


for line in sys.stdin:
    question = line.split()
    if question[0] == "version":
        print(hy.__version__.split(".")[0], flush=True)
        continue
    tolerance = float(question[1])
    if question[0] == "values":
        print(*(f"{y:.17e}" for state in solve(tolerance) for y in state[:measured]), flush=True)
    else:
        begun = time.perf_counter()
        for _ in range(int(question[2])):
            solve(tolerance)
        print((time.perf_counter() - begun) / int(question[2]), flush=True)
