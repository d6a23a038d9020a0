import dsocs

particle = dsocs.System("""
    coordinates(x, y);
    lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2;
    kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / (dot(x).powi(2) + dot(y).powi(2)).sqrt().powi(3) - 1;
    variational = [(dot(x), dot(y))];
""")


def solve():
    return particle.flow(tolerance=1e-10, h=0.1, q=[0.0, 0.0], v=[1.0, 1.0]).until(500.0).q[-1]
