"""MuJoCo on a chain of rigid bodies with ball joints, for the bench `work_precision`: answers questions on standard input.

The arguments are the interval of the grid, how many intervals there are, the half length of a body, its three moments of inertia, and the
attitudes of the bodies as quaternions, four numbers each.

    version                  the version
    values METHOD PARTS      the place of the last body at all times of the grid, with so many steps in an interval
    time METHOD PARTS N      the mean time of N solutions [s]
"""

import sys
import time

try:
    import mujoco
    import numpy as np
except ImportError:
    sys.exit("mujoco is not installed")

interval, intervals, half = float(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
moments = " ".join(sys.argv[4:7])
attitudes = np.array([float(word) for word in sys.argv[7:]]).reshape(-1, 4)

# each body has its ball joint at the joint above it; whatever costs time and has nothing to do here is switched off
open_bodies = "".join(
    f'''<body pos="0 0 {-2 * half if i else 0}"><joint type="ball"/>
    <inertial pos="0 0 {-half}" mass="1" diaginertia="{moments}"/>'''
    for i in range(len(attitudes))
)
model = mujoco.MjModel.from_xml_string(
    f'''<mujoco><option gravity="0 0 -9.81">
    <flag contact="disable" constraint="disable" actuation="disable" sensor="disable" warmstart="disable"/>
    </option><worldbody>{open_bodies}{"</body>" * len(attitudes)}</worldbody></mujoco>'''
)
data = mujoco.MjData(model)
# where a step is too large its motion ends; that is seen in its error, and needs no log
mujoco.set_mju_user_warning(lambda _: None)
start = np.zeros(model.nq)
before = np.array([1.0, 0.0, 0.0, 0.0])
for i, attitude in enumerate(attitudes):
    mujoco.mju_mulQuat(start[4 * i : 4 * i + 4], before * [1, -1, -1, -1], attitude)
    before = attitude
methods = {
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicit": mujoco.mjtIntegrator.mjINT_IMPLICIT,
}


def solve(method, parts):
    model.opt.integrator = methods[method]
    model.opt.timestep = interval / parts
    mujoco.mj_resetData(model, data)
    data.qpos[:] = start
    places = np.empty((intervals + 1, 3))
    mujoco.mj_kinematics(model, data)
    places[0] = data.xipos[-1]
    for k in range(intervals):
        mujoco.mj_step(model, data, parts)
        mujoco.mj_kinematics(model, data)
        places[k + 1] = data.xipos[-1]
    return places


for line in sys.stdin:
    question = line.split()
    if question[0] == "version":
        print(mujoco.__version__.split(".")[0], flush=True)
        continue
    method, parts = question[1], int(question[2])
    if question[0] == "values":
        print(*(f"{x:.17e}" for x in solve(method, parts).flat), flush=True)
    else:
        begun = time.perf_counter()
        for _ in range(int(question[3])):
            solve(method, parts)
        print((time.perf_counter() - begun) / int(question[3]), flush=True)
