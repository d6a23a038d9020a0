import dsocs
import numpy as np

swing = dsocs.System("""
    parameters { length = 1.0, gravity = 9.81 }
    coordinates(theta);
    lagrangian = (length * dot(theta)).powi(2) / 2 + gravity * length * theta.cos();
""")
starts = np.linspace(0.1, 3.0, 1000)


def solve():
    return swing.ensemble(h=0.01, q=starts[:, None], v=[0.0]).until(20.0)["theta"]
