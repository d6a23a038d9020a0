"""Inputs that cannot be used: the exception, and the name in its message."""

from __future__ import annotations

import copy
import math
import pickle
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
from conftest import BEADS, CURVED, FRICTION, ROD, SWING

import dsocs
from dsocs import DeclarationError, InputTypeError, SetupError

swing = dsocs.System(SWING, name="swing")
rod = dsocs.System(ROD, name="rod")
curved = dsocs.System(CURVED, name="curved")
beads = dsocs.System(BEADS, name="beads")
dry = dsocs.System(FRICTION, name="dry")
shaken = dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) / 2 - (x - t.sin()).powi(2);")
bare = dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) / 2;")
WIND = 'parameters { wind = samples("wind.csv") } coordinates(x); lagrangian = dot(x).powi(2) / 2; external_forces = wind.at(t);'
x, y = dsocs.coordinates("x", "y")
mass = dsocs.parameter("mass", 1.0)
kinetic = (dsocs.dot(x) ** 2 + dsocs.dot(y) ** 2) / 2

# the call, the exception, and words of the message
Case = tuple[Callable[[], Any], type[Exception], str]

VECTORS: list[Case] = [
    (lambda: swing.flow(q=[1.0, 2.0]), SetupError, "q has 2 components, but there is 1 coordinate: theta"),
    (lambda: swing.flow(q=[]), SetupError, "q"),
    (lambda: swing.flow(q=[[1.0]]), SetupError, "q has 2 dimensions"),
    (lambda: swing.flow(q=np.zeros((3, 1))), SetupError, "q has 2 dimensions"),
    (lambda: swing.flow(q=[math.nan]), SetupError, "q[0] is nan; it must be finite"),
    (lambda: swing.flow(q=math.inf), SetupError, "q is inf; it must be finite"),
    (lambda: swing.flow(q="1.0"), InputTypeError, "q is '1.0'; expected numbers"),
    (lambda: swing.flow(q=["1.0"]), InputTypeError, "q is ['1.0']"),
    (lambda: swing.flow(q=[None]), InputTypeError, "q is [None]"),
    (lambda: swing.flow(q=[1j]), InputTypeError, "expected real numbers"),
    (lambda: swing.flow(q=[[1.0], [2.0, 3.0]]), InputTypeError, "whose rows are of one length"),
    (lambda: swing.flow(q=True), InputTypeError, "q"),
    (lambda: swing.flow(q=[True]), InputTypeError, "q"),
    (lambda: swing.flow(q=object()), InputTypeError, "q"),
    (lambda: swing.flow(q={"thet": 1.0}), SetupError, "no coordinate `thet` (did you mean `theta`?)"),
    (lambda: swing.flow(q={"theta": "a"}), InputTypeError, "q['theta'] is 'a'; expected a number"),
    (lambda: swing.flow(q={"theta": math.nan}), SetupError, "q['theta'] is nan"),
    (lambda: rod.flow(h=0.01, q={"x": 1.0}, v=[0, 0]), SetupError, "q has no value for the coordinate `y`"),
    (lambda: swing.flow(v=[1.0, 2.0]), SetupError, "v has 2 components"),
    (lambda: swing.flow(v=[-math.inf]), SetupError, "v[0] is -inf"),
    (lambda: swing.flow(v="fast"), InputTypeError, "v is 'fast'"),
    (lambda: bare.flow(v=[0.0]), SetupError, "q is not given"),
    (lambda: bare.flow(q=[0.0]), SetupError, "v is not given, and the text of system has no run with a start"),
    (lambda: swing.flow(q1=[1.0, 2.0]), SetupError, "q1 has 2 components"),
    (lambda: swing.flow(q1=[2.0], v=[0.0]), SetupError, "q1 and v are both given"),
    (lambda: swing.flow(q2=[2.0]), SetupError, "q2 is given without q1"),
    (lambda: swing.flow(a=[1.0], force=[1.0]), SetupError, "a and force are both given"),
    (lambda: swing.flow(a=[1.0], near=[1.0]), SetupError, "near"),
    (lambda: swing.flow(a=[1.0]), SetupError, "no constraint here is of third order"),
    (lambda: swing.flow(force=[1.0]), SetupError, "no constraint here is of third order"),
    (lambda: swing.flow(near=[1.0, 2.0]), SetupError, "near has 2 components"),
    (lambda: rod.flow(h=0.01, q=[2.0, 0.0], v=[0.0, 0.0]), SetupError, "the start violates holonomic constraint 1"),
    (lambda: curved.flow(v=[0.0, 0.0]), SetupError, "the acceleration at the start"),
]

SETTINGS: list[Case] = [
    (lambda: swing.flow(h=0.0), SetupError, "h is 0"),
    (lambda: swing.flow(h=math.nan), SetupError, "h is nan; it must be finite"),
    (lambda: swing.flow(h="0.01"), InputTypeError, "h is '0.01'; expected a number"),
    (lambda: swing.flow(h=[0.01]), InputTypeError, "h is [0.01]; expected a number"),
    (lambda: swing.flow(h=1e-200), SetupError, "h²"),
    (lambda: swing.flow(h=0.01j), InputTypeError, "h"),
    (lambda: swing.flow(h=np.array([0.01, 0.02])), InputTypeError, "h"),
    (lambda: swing.flow(h=10**400), SetupError, "h is"),
    (lambda: swing.flow(t=math.inf), SetupError, "t is inf"),
    (lambda: swing.flow(t="now"), InputTypeError, "t is 'now'"),
    (lambda: swing.flow(order=3), SetupError, "order is 3; the step has order 2, its compositions 4, 6 and 8"),
    (lambda: swing.flow(order=4.0), InputTypeError, "order is 4.0; expected 2, 4, 6 or 8"),
    (lambda: swing.flow(order="4"), InputTypeError, "order"),
    (lambda: swing.flow(order=True), InputTypeError, "order"),
    (lambda: swing.flow(order=-2), SetupError, "order is -2"),
    (lambda: swing.flow(tolerance=0.0), SetupError, "tolerance is 0.0; it must lie between 0 and 1"),
    (lambda: swing.flow(tolerance=-1e-9), SetupError, "tolerance"),
    (lambda: swing.flow(tolerance=2.0), SetupError, "tolerance"),
    (lambda: swing.flow(tolerance="1e-9"), InputTypeError, "tolerance is '1e-9'"),
    (lambda: swing.flow(tolerance=1e-9, order=4), SetupError, "order and tolerance are both given"),
    (lambda: swing.flow(tolerance=1e-9, order=2), SetupError, "order and tolerance are both given"),
    (lambda: swing.flow(tolerance=1e-9, q1=[2.0]), SetupError, "q1 cannot be used with tolerance"),
    (lambda: swing.flow(order=4, q1=[2.0]), SetupError, "q1 cannot be used with order=4"),
    (lambda: swing.flow(order=4, start="paper"), SetupError, "start cannot be used with order=4"),
    (lambda: rod.flow(h=0.01, q=[0, -1], v=[0, 0], order=4), SetupError, "do not support constraints of positions"),
    (lambda: swing.flow(start="papers"), SetupError, "start is 'papers'; expected 'second-order' or 'paper'"),
    (lambda: swing.flow(project="yes"), InputTypeError, "project is 'yes'; expected True or False"),
    (lambda: swing.flow(every=0), SetupError, "every is 0; it must be at least 1"),
    (lambda: swing.flow(every=1.5), InputTypeError, "every is 1.5; expected a whole number"),
    (lambda: swing.flow(every=True), InputTypeError, "every"),
    (lambda: swing.flow(every=2**70), SetupError, "every"),
    (lambda: swing.flow(run="near"), SetupError, "no run `near`"),
    (lambda: swing.flow(run="farr"), SetupError, "did you mean `far`?"),
    (lambda: bare.flow(run="far"), SetupError, "none is declared"),
    (lambda: swing.flow(lenght=1.0), SetupError, "no parameter `lenght` (did you mean `length`?)"),
    (lambda: swing.flow(length="long"), InputTypeError, "length is 'long'"),
    (lambda: swing.flow(length=math.nan), SetupError, "length is nan; it must be finite"),
    (lambda: swing.flow(length=[1.0, 2.0]), InputTypeError, "length is [1.0, 2.0]; expected a number"),
    (lambda: swing.flow(length=None), InputTypeError, "length is None"),
    (lambda: swing.flow(parameters=[1.0]), InputTypeError, "parameters is list; expected a dict"),
    (lambda: swing.flow(parameters={"length": 1.0}, length=2.0), SetupError, "the parameter `length` is given twice"),
    (lambda: beads.flow(masses=[1.0], q=[0, 0, 0], v=[0, 0, 0]), SetupError, "masses has the shape (1,), but it is an array of 3 numbers"),
    (lambda: beads.flow(masses=[1.0, math.inf, 1.0], q=[0, 0, 0], v=[0, 0, 0]), SetupError, "masses[1] is inf"),
    (lambda: beads.flow(masses_7=1.0, q=[0, 0, 0], v=[0, 0, 0]), SetupError, "no parameter `masses_7`"),
]

RUNS: list[Case] = [
    (lambda: swing.flow().until(-1.0), SetupError, "t = -1 cannot be reached from t = 0"),
    (lambda: swing.flow().until(math.inf), SetupError, "t is inf"),
    (lambda: swing.flow().until(math.nan), SetupError, "t is nan"),
    (lambda: swing.flow().until("end"), InputTypeError, "t is 'end'; expected a number"),
    (lambda: swing.flow(h=-0.01).until(1.0), SetupError, "lies the other way"),
    (lambda: swing.flow(h=1e-9).until(1e15), MemoryError, "every="),
    (lambda: swing.flow(h=1e-12).until(1.0), MemoryError, "so many steps take days: a longer `h=` makes fewer"),
    (lambda: swing.flow().until(1.0, progress=7), InputTypeError, "progress is 7"),
    (lambda: swing.flow().until(1.0, control=7), InputTypeError, "control is int; expected a function"),
    (lambda: swing.flow().until(1.0, control=lambda node: 7), TypeError, "control returned int; expected a dict"),
    (lambda: swing.flow().until(1.0, control=lambda node: {"torq": 1.0}), SetupError, "no parameter is called `torq`"),
    (lambda: swing.flow().until(1.0, control=lambda node: {"torque": math.nan}), SetupError, "the input `torque` is NaN"),
    (lambda: swing.flow().until(1.0, control=lambda node: {"torque": "a"}), InputTypeError, "torque is 'a'; expected a number"),
    (lambda: swing.flow().until(1.0, control=lambda node: {"torque": np.array([1.0])}), InputTypeError, "expected a number"),
    (lambda: beads.flow(h=0.01, q=[0, 0, 0], v=[0, 0, 0]).until(1.0, control=lambda node: {"masses": 1.0}), SetupError, "masses has the shape (), but it is an array of 3 numbers"),
    (lambda: swing.flow().until(1.0, control=lambda node: node["thet"]), KeyError, "a node has no `thet`"),
    (lambda: swing.flow().until(1.0, control_every=0), SetupError, "control_every is 0"),
    (lambda: swing.flow().until(1.0, control_every=10), SetupError, "control_every is given"),
    (lambda: swing.flow().advance(-1), SetupError, "steps is -1; it must be at least 0"),
    (lambda: swing.flow().advance(1.5), InputTypeError, "steps is 1.5"),
    (lambda: swing.flow().set(torq=1.0), SetupError, "no parameter is called `torq`"),
    (lambda: swing.flow().set(torque=math.inf), SetupError, "torque is inf"),
    (lambda: swing.flow().set(torque="much"), InputTypeError, "torque is 'much'"),
    (lambda: rod.flow(h=0.01, q=[0, -1], v=[0, 0]).set(length=2.0), SetupError, "a holonomic constraint depends on it"),
    (lambda: swing.flow()["thet"], KeyError, "did you mean `theta`?"),
    (lambda: swing.flow()["lambda_0"], KeyError, "no column `lambda_0`"),
    (lambda: swing.flow()[7], IndexError, "1 nodes are kept"),
    (lambda: swing.flow()[-2], IndexError, "run[-2]"),
    (lambda: swing.flow()[1.0], InputTypeError, "run[1.0]"),
    (lambda: swing.flow()[0:5], InputTypeError, "run.q[0:5] or run['theta'][0:5]"),  # type: ignore[call-overload]
    (lambda: swing.flow()[::2], InputTypeError, "run.q[::2]"),  # type: ignore[call-overload]
    (lambda: swing.flow()[None], InputTypeError, "run[None]"),
    (lambda: next(swing.flow().steps("end")), InputTypeError, "until is 'end'"),
    (lambda: next(swing.flow().steps(math.nan)), SetupError, "NaN"),
    (lambda: swing.flow(q1=[2.0]).until(1.0).estimate_error(), SetupError, "begins with nodes"),
    (lambda: swing.flow(order=4).check(), SetupError, "order=2"),
    (lambda: swing.flow().until(1.0).report("/no/such/folder/page.html"), FileNotFoundError, "page.html"),
    (lambda: swing.check(h=0.0), SetupError, "h is 0"),
    (lambda: swing.check(until="a"), InputTypeError, "until is 'a'"),
    (lambda: swing.quantity("lengt"), SetupError, "did you mean `length`?"),
]

MANY: list[Case] = [
    (lambda: swing.ensemble(), SetupError, "nothing varies from run to run"),
    (lambda: swing.ensemble(q=[1.0]), SetupError, "nothing varies"),
    (lambda: swing.ensemble(q=np.zeros((0, 1)), v=[0.0]), SetupError, "q is for no run at all"),
    (lambda: bare.ensemble(h=0.01, q=np.zeros((0, 1)), v=[0.0]), SetupError, "q is for no run at all"),
    (lambda: swing.ensemble(length=[]), SetupError, "length is for no run at all"),
    (lambda: swing.ensemble(h=[0.01, 0.02]), SetupError, "h has the shape (2,); expected one number"),  # type: ignore[arg-type]
    (lambda: swing.ensemble(t=np.arange(3.0)), SetupError, "t has the shape (3,); expected one number"),  # type: ignore[arg-type]
    (lambda: rod.ensemble(h=0.01, q=[[0, 1.0], [0, -1.0]], v=[0, 0]).until(0.1)["lambda_0"], KeyError, "an ensemble keeps no multipliers"),
    (lambda: swing.ensemble(q=[[1.0, 2.0]]), SetupError, "q has the shape (1, 2); expected (1,), or (runs, 1)"),
    (lambda: swing.ensemble(q=[[1.0], [math.nan]]), SetupError, "q[1][0] is nan"),
    (lambda: swing.ensemble(q=[[1.0], [2.0]], length=[1, 2, 3]), SetupError, "not all arrays are for the same number of runs: q for 2, length for 3"),
    (lambda: swing.ensemble(length=[[1, 2, 3]]), SetupError, "length has 2 dimensions"),
    (lambda: swing.ensemble(length=["a", "b"]), InputTypeError, "length"),
    (lambda: swing.ensemble(lenght=[1.0, 2.0]), SetupError, "no parameter `lenght`"),
    (lambda: swing.ensemble(q={"theta": [[1.0]]}), SetupError, "q['theta'] has 2 dimensions"),
    (lambda: swing.ensemble(q={"phi": [1.0]}), SetupError, "no coordinate `phi`"),
    (lambda: rod.ensemble(h=0.01, q={"x": [0, 0.1]}, v=[0, 0]), SetupError, "no value for the coordinate `y`"),
    (lambda: rod.ensemble(h=0.01, q={"x": [0, 0.1], "y": [1, 2, 3]}, v=[0, 0]), SetupError, "columns of different lengths: 2, 3"),
    (lambda: swing.ensemble(q=[[1.0], [2.0]]).until(math.nan), SetupError, "t is nan"),
    (lambda: swing.ensemble(q=[[1.0], [2.0]]).until(-1.0), SetupError, "lies the other way"),
    (lambda: swing.ensemble(q=[[1.0], [2.0]]).until(1.0, threads=0), SetupError, "threads is 0"),
    (lambda: swing.ensemble(q=[[1.0], [2.0]]).until(1.0)["phi"], KeyError, "no column `phi`"),
    (lambda: swing.path(0.0), dsocs.DerivativeError, "ends at its start"),
    (lambda: swing.path("end"), InputTypeError, "until is 'end'"),
    (lambda: swing.path(1.0, q=[1.0, 2.0]), SetupError, "q has 2 components"),
    (lambda: swing.path(1.0).gradient(7), InputTypeError, "cost is int"),
    (lambda: swing.path(1.0).gradient(lambda last: "much"), InputTypeError, "the cost is str"),
    (lambda: swing.path(1.0).gradient(lambda last: np.concatenate([last.q, last.v])), InputTypeError, "the cost is ndarray"),
    (lambda: swing.path(1.0).gradient(lambda last: math.sin(last["theta"])), InputTypeError, "np.sin"),
    (lambda: swing.path(1.0).gradient(lambda last: last["phi"]), KeyError, "no quantity `phi`; known: t, theta, v_theta, a_theta"),
    (lambda: swing.path(1.0).gradient(lambda last: last["height"]), KeyError, "an observed expression, the energy or a force is written out in them"),
    (lambda: swing.path(1.0).gradient(lambda last: last.energy), AttributeError, "no quantity `energy`; known: t, theta, v_theta, a_theta"),
    (lambda: swing.path(1.0).gradient(lambda last: last["theta"], of="all"), SetupError, "of is 'all'"),
    (lambda: swing.path(1.0).gradient(lambda last: 1 / 0), ZeroDivisionError, ""),
    (lambda: pickle.dumps(swing.path(1.0)), TypeError, "a path cannot be pickled or copied"),
    (lambda: swing.path(1.0).tangents("lenght"), SetupError, "no variable `lenght`"),
]

BETWEEN: list[Case] = [
    (lambda: swing.flow().watch(1.0), SetupError, "no event is given"),
    (lambda: swing.flow().watch(1.0, "phi"), SetupError, "no column `phi`"),
    (lambda: swing.flow().watch(1.0, 7), InputTypeError, "an event is 7"),
    (lambda: swing.flow().watch("now", "theta"), InputTypeError, "until is 'now'"),
    (lambda: dsocs.Event("theta", level=math.nan), SetupError, "level is nan"),
    (lambda: dsocs.Event("theta", level="a"), InputTypeError, "level is 'a'; expected a number"),  # type: ignore[arg-type]
    (lambda: dsocs.Event("theta", rising="no"), InputTypeError, "rising is 'no'; expected True, False or None"),  # type: ignore[arg-type]
    (lambda: dsocs.Event("theta", rising=-1), InputTypeError, "rising is -1"),  # type: ignore[arg-type]
    (lambda: dsocs.Event("theta", ends="no"), InputTypeError, "ends is 'no'; expected True or False"),  # type: ignore[arg-type]
    (lambda: dsocs.Event("theta", ends=None), InputTypeError, "ends is None"),  # type: ignore[arg-type]
    (lambda: dsocs.Event(7), InputTypeError, "of is 7; expected the name of a column"),  # type: ignore[arg-type]
    (lambda: swing.flow().watch(1.0, dsocs.Event("energy")), SetupError, "no column `energy`"),
    (lambda: swing.flow().watch(1.0, dsocs.Event("energy")), SetupError, "is watched as an observed expression"),
    (lambda: rod.flow(h=0.01, q=[0, -1], v=[1, 0]).watch(1.0, "lambda_0"), SetupError, "multipliers are known at the nodes alone, run['lambda_0']"),
    (lambda: swing.flow().until(1.0).watch(0.5, "theta"), SetupError, "it lies the other way"),
    (lambda: swing.flow().sample("now"), InputTypeError, "times is 'now'"),
    (lambda: swing.flow().sample([[1.0]]), SetupError, "times has 2 dimensions"),
    (lambda: swing.flow().sample([1.0, 0.5]), SetupError, "in the order of the run"),
    (lambda: swing.flow(t=2.0).sample([1.0]), SetupError, "from its start at t = 2 on"),
    (lambda: swing.flow().sample([1.0, math.inf]), SetupError, "times[1] is inf"),
    (lambda: swing.flow().sample([1.0])["phi"], KeyError, "no column `phi`"),
    (lambda: swing.flow(order=4).roots(), SetupError, "of order 2 alone"),
    (lambda: swing.flow(tolerance=1e-9).advance_to([1.0]), SetupError, "of order 2 alone"),
    (lambda: swing.flow().advance_to([1.0, 2.0]), SetupError, "q has 2 components"),
    (lambda: swing.flow(order=4).certify(), SetupError, "the paper's step"),
    (lambda: swing.flow().set(torque=1.0).until(1.0).certify(), SetupError, "inputs changed"),
    (lambda: swing.ensemble(q=[[1.0], [2.0]], order=3), SetupError, "order is 3"),
    (lambda: swing.ensemble(q=[[1.0], [2.0]], order=4, tolerance=1e-9), SetupError, "both given"),
    (lambda: dsocs.read_sweep("no-such-folder"), SetupError, "has no table of a sweep"),
]

MODELS: list[Case] = [
    (lambda: swing.linearize(q=[1.0, 2.0]), SetupError, "q has 2 components"),
    (lambda: swing.linearize(q="up"), InputTypeError, "q is 'up'"),
    (lambda: swing.linearize(q=[0.0], v=[math.nan]), SetupError, "v[0] is nan"),
    (lambda: swing.linearize(q=[0.0], h=0.0), SetupError, "h is 0"),
    (lambda: swing.linearize(q=[0.0], h="0.1"), InputTypeError, "h is '0.1'"),
    (lambda: swing.linearize(q=[0.0], h=1e-200), SetupError, "h²"),
    (lambda: swing.linearize(q=[0.0], inputs="motor"), SetupError, "no parameter is called `motor`, so it is no input; expected `length`"),
    (lambda: swing.linearize(q=[0.0], inputs=7), InputTypeError, "inputs is 7; expected a name or a list of names"),
    (lambda: swing.linearize(q=[0.0], inputs=["torque", "torque"]), SetupError, "`torque` is named twice"),
    (lambda: swing.linearize(q=[0.0], outputs=["phi"]), SetupError, "nothing is called `phi` that could be an output; expected `theta`, `height` or `energy`"),
    (lambda: swing.linearize(q=[0.0], outputs=[1.0]), InputTypeError, "outputs is [1.0]"),
    (lambda: swing.linearize(q=[0.0], t=math.inf), SetupError, "t is inf"),
    (lambda: swing.linearize(q=[0.0], torqe=1.0), SetupError, "no parameter `torqe`"),
    (lambda: swing.linearize(q=[0.0], run="near"), SetupError, "no run `near`"),
    (lambda: bare.linearize(), SetupError, "q is not given"),
    (lambda: rod.linearize(q=[2.0, 0.0]), SetupError, "violates holonomic constraint 1"),
    (lambda: curved.linearize(q=[0.0, 0.0], v=[0.0, 0.0]), SetupError, "the acceleration at the start"),
    (lambda: dry.linearize(q=[0.1]), dsocs.DerivativeError, "a function of `dot(x)` jumps there"),
    (lambda: swing.linearize(q=[0.0]).state([1.0, 2.0]), SetupError, "q has 2 components"),
    (lambda: swing.linearize(q=[0.0]).state(swing.flow()[0], [1.0]), SetupError, "v is given beside a node"),
    (lambda: swing.equilibrium([1.0, 2.0]), SetupError, "q has 2 components"),
    (lambda: swing.equilibrium([math.nan]), SetupError, "q[0] is nan"),
    (lambda: swing.equilibrium("down"), InputTypeError, "q is 'down'"),
    (lambda: swing.equilibrium(free="motor"), SetupError, "no parameter is called `motor`; expected `length`"),
    (lambda: swing.equilibrium(free=3), InputTypeError, "free is 3"),
    (lambda: swing.equilibrium(hold=["phi"]), SetupError, "no coordinate is called `phi`; expected `theta`"),
    (lambda: swing.equilibrium(t="now"), InputTypeError, "t is 'now'"),
    (lambda: swing.equilibrium(run="near"), SetupError, "no run `near`"),
    (lambda: swing.equilibrium()["phi"], KeyError, "an equilibrium has no `phi`"),
    (lambda: swing.equilibrium(gravity=math.inf), SetupError, "gravity is inf"),
    (lambda: swing.equilibria([[1.0, 2.0]]), SetupError, "q[0] has 2 components"),
    (lambda: swing.equilibria([]), SetupError, "q is empty"),
    (lambda: swing.equilibria(1.0), InputTypeError, "q is 1.0; expected a list of positions"),
    (lambda: swing.equilibria([["a"]]), InputTypeError, "q[0] is ['a']"),
    (lambda: shaken.equilibrium(0.3), dsocs.EquilibriumError, "for an instant only"),
]

TEXTS: list[Case] = [
    (lambda: dsocs.System(7), InputTypeError, "text is int"),
    (lambda: dsocs.System(), TypeError, "System.__init__() missing"),  # type: ignore[call-arg]
    (lambda: dsocs.System.of([x], kinetic), TypeError, "System.of() takes 1 positional argument"),  # type: ignore[misc]
    (lambda: dsocs.System(Path("swing.dsocs")), InputTypeError, "dsocs.read"),
    (lambda: dsocs.System("swing.dsocs"), SetupError, "dsocs.read('swing.dsocs') reads it"),
    (lambda: dsocs.System(SWING, name=7), InputTypeError, "name is int"),
    (lambda: dsocs.System(""), DeclarationError, "declares nothing"),
    (lambda: dsocs.System("coordinates(x);"), DeclarationError, "lagrangian"),
    (lambda: dsocs.System("coordinates(x) lagrangian = x;"), DeclarationError, ""),
    (lambda: dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) * mass;"), DeclarationError, "no name `mass` is known here"),
    (lambda: dsocs.System("coordinates(x); lagrangian = dot(x).powi(2) / 2; kinematic = dot(x);"), DeclarationError, "nonholonomic"),
    (lambda: dsocs.System("(" * 5000), DeclarationError, ""),
    (lambda: dsocs.System("\x00"), DeclarationError, ""),
    (lambda: dsocs.System(BEADS, constants={"m": 2}), DeclarationError, "no constant of the text is called `m`"),
    (lambda: dsocs.System(BEADS, constants={"n": "two"}), InputTypeError, "constants['n'] is 'two'"),
    (lambda: dsocs.System(BEADS, constants={"n": 2.5}), DeclarationError, ""),
    (lambda: dsocs.System('parameters { f = samples("f.csv") } coordinates(x); lagrangian = dot(x).powi(2) / 2 + f.at(t) * x;'), DeclarationError, "no samples are given in its place"),
    (lambda: dsocs.System(SWING, samples=[1]), InputTypeError, "samples is list"),
    (lambda: dsocs.System(SWING, samples={"f": 1}), InputTypeError, "samples['f'] is no pair"),
    (lambda: dsocs.System(SWING, samples={"f": ([0, 1], [1])}), SetupError, "samples['f'] has places of the shape (2,) and values of the shape (1,)"),
    (lambda: dsocs.System('parameters { f = samples("f.csv") } coordinates(x); lagrangian = dot(x).powi(2) / 2 + f.at(t) * x;', samples={"f": ([0, 0], [1, 2])}), DeclarationError, "these samples cannot be used"),
    (lambda: dsocs.System(WIND, samples={"wind": ([0, 1], [1, 2]), "gust": ([0, 1], [1, 2])}), SetupError, "there is no table of samples `gust`; known: wind, wind.csv"),
    (lambda: dsocs.System(SWING, samples={"wind": ([0, 1], [1, 2])}), SetupError, "none is declared"),
    (lambda: dsocs.System(WIND, samples={"wind": [0, 1]}), SetupError, "samples['wind'] has places of the shape () and values of the shape ()"),
    (lambda: dsocs.System("coordinates(x, a_x); lagrangian = dot(x).powi(2) + dot(a_x).powi(2);"), DeclarationError, "`a_x` is the column of the acceleration of `x`"),
    (lambda: dsocs.System("coordinates(x); lagrangian = dot(x).powi(2); let a_x = x; observe = [a_x];"), DeclarationError, "expected another name"),
    (lambda: dsocs.read("no-such-file.dsocs"), FileNotFoundError, "no-such-file.dsocs"),
    (lambda: dsocs.read(7), InputTypeError, "path is int"),
    (lambda: dsocs.read("."), OSError, ""),
    (lambda: dsocs.coordinates(), SetupError, "no names"),
    (lambda: dsocs.coordinates("x", "x"), SetupError, "named twice"),
    (lambda: dsocs.coordinates("2x"), SetupError, "`2x` cannot be the name"),
    (lambda: dsocs.coordinates("t"), SetupError, "`t` cannot be the name"),
    (lambda: dsocs.coordinates(7), InputTypeError, "the name of a coordinate is 7"),
    (lambda: dsocs.parameter("m", math.nan), SetupError, "m is nan"),
    (lambda: bool(x < y), InputTypeError, "where(a < b, x, y)"),
    (lambda: math.sin(x), InputTypeError, "np.sin"),
    (lambda: x + "a", TypeError, ""),
    (lambda: np.floor(x), InputTypeError, "numpy's floor has no counterpart"),
    (lambda: dsocs.where(True, x, y), InputTypeError, "the condition is True"),
    (lambda: dsocs.System.of(coordinates=(), lagrangian=kinetic), SetupError, "there are no coordinates"),
    (lambda: dsocs.System.of(coordinates=(x,), lagrangian=kinetic), SetupError, "the coordinate `y` is used, and is none of the system's"),
    (lambda: dsocs.System.of(coordinates=(x, mass), lagrangian=kinetic), InputTypeError, "coordinates[1] is `mass`"),
    (lambda: dsocs.System.of(coordinates=(x, y), lagrangian="x"), InputTypeError, "lagrangian is 'x'; expected an expression"),
    (lambda: dsocs.System.of(coordinates=(x, y), lagrangian=kinetic, holonomic=[None]), InputTypeError, "holonomic[0] is None"),
    (lambda: dsocs.System.of(coordinates=(x, y), lagrangian=kinetic, holonomic=dsocs.dot(x)), DeclarationError, "holonomic = dot(x)"),
    (lambda: dsocs.System.of(coordinates=(x, y), lagrangian=kinetic, external_forces=(1,)), SetupError, "external_forces has 1 component, but there are 2 coordinates: x, y"),
    (lambda: dsocs.System.of(coordinates=(x, y), lagrangian=kinetic, external_forces={"z": 1}), SetupError, "external_forces has a component for `z`"),
    (lambda: dsocs.System.of(coordinates=(x, y), lagrangian=kinetic, variational="lagrange"), SetupError, "variational is 'lagrange'"),
    (lambda: dsocs.System.of(coordinates=(x, y), lagrangian=kinetic * mass + dsocs.parameter("mass", 2.0)), SetupError, "the parameter `mass` has two values, 1 and 2"),
]  # fmt: skip

CASES = [*VECTORS, *SETTINGS, *RUNS, *MANY, *BETWEEN, *MODELS, *TEXTS]


@pytest.mark.parametrize(("call", "expected", "said"), CASES, ids=[f"{place}-{said[:40]}" for place, (_, _, said) in enumerate(CASES)])
def test_what_cannot_be_used_is_refused(call: Callable[[], Any], expected: type[Exception], said: str) -> None:
    with pytest.raises(expected) as raised:
        call()
    assert said in str(raised.value), raised.value
    # `dsocs.Error` catches all exceptions of this package
    if expected not in (OSError, FileNotFoundError, MemoryError, TypeError, KeyError, IndexError, AttributeError, ZeroDivisionError):
        assert isinstance(raised.value, dsocs.Error)
    assert not type(raised.value).__name__.startswith("Panic")


def results() -> list[Any]:
    """One of everything that a user gets and might set attributes of."""
    run, ensemble, path = swing.flow(), swing.ensemble(q=[[1.0], [2.0]]), swing.path(0.1)
    rest = swing.equilibrium()
    found = [run, swing.path(0.1).end, run.node, run.watch(0.1, "theta"), run.sample([0.0, 0.05]), path, ensemble, ensemble.until(0.1)]
    return [swing, swing.parameters, *found, rest, rest.linearize(), swing.equilibria([[0.1]]), run.check(), run.estimate_error()]


@pytest.mark.parametrize("one", results(), ids=lambda one: type(one).__name__)
def test_attributes_that_nothing_would_use_cannot_be_set(one: Any) -> None:
    for name in ("length", "typo", "h", "q", "system", "t"):
        with pytest.raises(AttributeError):
            setattr(one, name, 3.0)
    if type(one).__name__ not in ("Path",):
        other = pickle.loads(pickle.dumps(copy.copy(one)))
        with pytest.raises(AttributeError):
            other.typo = 3.0


def test_setting_an_attribute_says_what_to_do() -> None:
    with pytest.raises(AttributeError, match=r"`system\.flow\(length=…\)`"):
        swing.length = 2.0  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"`run\.set\(length=…\)`"):
        swing.flow().length = 2.0  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"cannot be set: nothing would use it on a `System`"):
        del swing.doc


def test_the_time_is_part_of_a_cost() -> None:
    assert swing.path(0.5).gradient(lambda last: last["t"] * last["theta"]).cost == pytest.approx(0.5 * swing.path(0.5).end["theta"])


def test_the_tree_of_exceptions() -> None:
    assert issubclass(DeclarationError, (dsocs.Error,)) and issubclass(DeclarationError, ValueError)
    assert issubclass(SetupError, dsocs.Error) and issubclass(SetupError, ValueError)
    assert issubclass(InputTypeError, SetupError) and issubclass(InputTypeError, TypeError)
    assert issubclass(dsocs.StepError, dsocs.Error) and issubclass(dsocs.StepError, ArithmeticError)
    assert issubclass(dsocs.Interrupted, KeyboardInterrupt) and not issubclass(dsocs.Interrupted, Exception)


def test_a_mistake_has_its_place() -> None:
    with pytest.raises(DeclarationError) as raised:
        dsocs.System("coordinates(x);\nlagrangian = dot(x).powi(2) / 2 - stiffness * y;", name="spring")
    error = raised.value
    assert (error.line, error.column) == (2, 35)
    assert [mistake.message.split("`")[1] for mistake in error.mistakes] == ["stiffness", "y"]
    assert " --> spring:2:35" in str(error) and "^^^^^^^^^" in str(error)


def test_a_mistake_in_a_file_is_shown_with_its_name(tmp_path: Path) -> None:
    (tmp_path / "spring.dsocs").write_text("coordinates(x);\nlagrangian = y;", encoding="utf-8")
    with pytest.raises(DeclarationError, match=r"--> .*spring\.dsocs:2:14"):
        dsocs.read(tmp_path / "spring.dsocs")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ("coordinates(x);".encode("utf-16"), "is saved as UTF-16"),
        (b"coordinates(x);\n// \xe4", "line 2 has a character in another encoding"),
        (b"\xef\xbb\xbfcoordinates(", "coordinates("),
    ],
)
def test_a_file_that_is_no_text(tmp_path: Path, data: bytes, said: str) -> None:
    (tmp_path / "bad.dsocs").write_bytes(data)
    with pytest.raises(DeclarationError) as raised:
        dsocs.read(tmp_path / "bad.dsocs")
    assert said in str(raised.value)
