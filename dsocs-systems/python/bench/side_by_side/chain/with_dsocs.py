import dsocs

chain = dsocs.System("""
    const n = 8;
    parameters { length = 0.125, gravity = 9.81 }
    coordinates(theta: [n]);
    let cosine = |i, j| theta[i].cos() * theta[j].cos() + theta[i].sin() * theta[j].sin();
    let speed = |i| length * dot(theta[i]);
    lagrangian = sum(0..n, |i| (n - i) * (
        speed(i).powi(2) / 2 + sum(0..i, |j| cosine(i, j) * speed(i) * speed(j)) + gravity * length * theta[i].cos()
    ));
""")


def solve():
    return chain.flow(tolerance=1e-10, h=0.1, q=[0.5] * 8, v=[0.0] * 8).until(10.0).q[-1]
