"""Calls as users write them, for mypy: each has the intended type."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import dsocs

swing: dsocs.System = dsocs.read("swing.dsocs", constants={"n": 3}, samples={"wind": ([0, 1], np.zeros(2))})
run: dsocs.Run = swing.flow(h=0.01, q=[1.0], v={"theta": 0.0}, length=1.2).until(20.0, progress=True)
column: npt.NDArray[np.float64] = run["theta"]
node: dsocs.Node = run[-1]
angle: float = node["theta"] + float(node.q[0])
steps: list[int] = [node.index for node in run.steps(30.0)]
errors: dict[str, float] = run.estimate_error().largest
ok: bool = run.check().ok and swing.check(until=2.0).ok
ends: dsocs.Ends = swing.ensemble(q=np.zeros((3, 1)), v=[0.0], length=[1, 2, 3]).until(20.0, threads=2)
failed: dict[int, dsocs.Error] = ends.failures
gradient: dsocs.Gradient = swing.path(5.0).gradient(lambda last: last["theta"] ** 2)
by_length: float = gradient.parameters["length"]
count: int = run.unresolved.steps if run.unresolved is not None else 0


def brake(node: dsocs.Node) -> dict[str, float] | None:
    return {"torque": -2 * node["v_theta"]} if node.index > 3 else None


run.until(40.0, control=brake, control_every=10).set(torque=0.0).advance(3)
points: dsocs.Points = run.sample([0.5, 1.0])
between: npt.NDArray[np.float64] = points["theta"] + points.q[:, 0]
events: dsocs.Occurrences = run.watch(50.0, "theta", dsocs.Event("height", level=0.5, rising=True, ends=True))
# what nothing would use is refused by types, too
run.typo = 3  # type: ignore[attr-defined]
swing.length = 2.0  # type: ignore[attr-defined]
first: float = events[0].t + events.of("theta")[0] + float(events[0].q[0])
other: npt.NDArray[np.float64] | None = run.roots().other
regular: bool = bool(run.advance_to({"theta": 1.0}).certify().granted.all())
far: dsocs.Ends = swing.ensemble(q=np.zeros((3, 1)), tolerance=1e-9).until(1.0)
model: dsocs.LinearModel = swing.linearize(q=[0.0], inputs="torque", outputs=["theta"], h=0.01)
poles: npt.NDArray[np.complex128] = model.eigenvalues
state: npt.NDArray[np.float64] = model.state(node) + model.state([1.0], v={"theta": 0.0})
rest: dsocs.Equilibrium = swing.equilibrium([3.0], free=["torque"], hold="theta")
torque: float = rest["torque"] + rest.linearize().A[0, 0]
stabilities: list[str | None] = [each.stability for each in swing.equilibria(np.zeros((3, 1)))]
x, y = dsocs.coordinates("x", "y")
pendulum: dsocs.System = dsocs.System.of(coordinates=(x, y), lagrangian=dsocs.dot(x) ** 2 / 2 - y, holonomic=x**2 + y**2 - 1)
try:
    pendulum.flow(h=0.01, q=[0, 1], v=[0, 0]).until(1.0)
except dsocs.StepError as error:
    partial: dsocs.Run | None = error.run
