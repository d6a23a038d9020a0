import dsocs

pendulum = dsocs.System("""
    parameters { i = 312.5, j = 2.0772, m = 37.98, d = 1.0, e = 1000.0, chi = 100.0, n = -154.0, rho = 2.0 }
    coordinates(theta, psi);
    lagrangian = i / 2 * dot(theta).powi(2) + j / 2 * (dot(theta) + dot(psi)).powi(2) - m * (1 + theta.cos());
    let g_c = d * (n + 1) * j;
    let h_c = -d * (i + (n + 1) * j);
    let p1 = (i + j) * dot(theta) + j * dot(psi);
    let p2 = j * (dot(theta) + dot(psi));
    let w = g_c * p1 + h_c * p2;
    let lyapunov = (g_c.powi(2) + e) / h_c / 2 * p1.powi(2) + h_c / 2 * p2.powi(2) + g_c * p1 * p2
        + chi * (1 - (psi - n * theta).cos()) + m * e / d * (1 - theta.cos());
    kinematic = dot(lyapunov) + rho * w * w.tanh();
    constraint_forces = [(0, 1)];
    branch = divide(w);
""")


def solve():
    return pendulum.flow(tolerance=1e-10, h=0.1, q=[0.5, 0.0], v=[0.0, 0.5]).until(500.0).q[-1]
